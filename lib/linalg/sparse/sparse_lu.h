/* The sparse engine of a partition, for large substructures: LU of one column after the other (J. Gilbert, T. Peierls,
 * Sparse partial pivoting in time proportional to arithmetic operations, 1988) in an order that keeps L sparse
 * (COLAMD). Columns with a single entry come first. A column that those before it make nearly dependent becomes an independent coordinate. Which columns these
 * are is then chosen again by complete pivoting of the null space, so that |B| is as small as with complete pivoting of
 * the whole matrix. Private to partition/. */
#ifndef KM_LINALG_SPARSE_SPARSE_LU_H
#define KM_LINALG_SPARSE_SPARSE_LU_H

#include "linalg/partition.h"
#include "linalg/sparse/normal_equations.h"
#include "linalg/sparse/row_storage.h"
#include "linalg/sparse/sparse_qr.h"

/* A run of entries in the store. */
typedef struct km_entry_range {
  int start, end;
} km_entry_range;

/* Entries of L or U, each with its row or step. Grows with the fill. */
typedef struct km_entry_store {
  int *index;
  double *value;
  size_t capacity;
} km_entry_store;

/* The entries of a column other than 0 in rows without a pivot, while singles are sought: how many, -1: the column is one; and
 * the exclusive or of their places in the matrix, which is the place itself where one is left. */
typedef struct km_open_entries {
  int count, index_xor;
} km_open_entries;

struct km_sparse {
  km_arena *arena;                           /* what grows, grows there */
  const int *start, *row;                    /* pattern: rows of column c are row[start[c] … start[c+1]-1] */
  const km_row_entry *by_row;                /* the same entries: of row r from by_row[row_start[r]] on */
  const int *row_start;                      /* [rows + 1] */
  const int *order;                          /* [columns] that keeps L sparse */
  int *factor_order;                         /* [columns] the order of this factorisation */
  int singleton_count;                       /* so many of its first columns are single ones */
  int *singleton_zero, singleton_zero_count; /* entries of their pattern that must be 0 for that */
  km_open_entries *open_entries;             /* [columns] */
  int *dropped;       /* [columns] those that became independent, in that order; before, those that may become single */
  bool *is_postponed; /* [columns] is to come last, since it should stay independent */
  bool
      postpones_small; /* columns that leave only a small pivot become late ones: small pivots that share a vanishing singular
                  * value then come last, where they tell */
  int max_entries;                /* of U and L, beyond which the elimination ends as overfull; 0: any number */
  bool limits_fill_if_postponing; /* that only where columns wait */
  bool is_overfull;
  km_entry_range *upper; /* [columns] of each: its entries of U, by step in an order that replays it */
  km_entry_range *lower; /* [columns] and of L, by row; independent columns have none */
  km_entry_store upper_store, lower_store; /* index: the step, the row */
  bool *is_nested;                         /* [rows] by step, while columns are eliminated: see sparse_nests.c */
  km_entry_range *
      supernode_range; /* [rows] by step: its entries of L once more, in the order of the step behind it where it nests */
  km_entry_store supernode_store; /* index: the row */
  int supernode_end;
  int *step_of;                             /* [rows] that used the row, -1: none yet */
  double *x;                                /* [rows] accumulators, 0 between columns */
  int *reach_list, *stack, *stack_position; /* [rows] rows that a column reaches; walking them */
  bool *visited;                            /* [rows] */
  bool *is_excluded_row;                    /* [rows] is to be no primary one, since others make it dependent */
  km_entry_range *b;      /* [columns] of independent column k: its entries of B that aren't 0, by step, ascending */
  km_entry_store b_store; /* index: the step */
  bool was_last_b_long;   /* the column of B that was asked for last has many entries */
  double *cached_matrix;  /* [entries] the matrix that was factored last, while the factor is that of it */
  bool *cached_forced, *cached_locked; /* [columns] then */
  double cached_tolerance;
  unsigned cached_flags;
  bool is_cached;
  int resume_pass; /* of a search for good independent columns that ended since any serve: where it goes on; 0: it doesn't */
  km_normal_equations **normal; /* borrowed, of all partitions of the pattern; NULL: none */
  const double *weight;         /* the same: of the columns, for the normal equations */
  bool has_rows_only;   /* only the rows were asked for: the independent columns have no entries of U, and no B */
  bool has_normal_only; /* they were, and are independent by their normal equations: there is no L and no U */
  bool is_b_unmeasured; /* the size of B wasn't measured with these values */
  bool stores_all_b;    /* else there is room for one column of B only: many are found when they are asked for */
};

/* Null vectors with so many times the entries of the matrix, all together, are long: they reach through the whole mechanism. */
enum { KM_SPARSE_MAX_NULL_FILL = 5 };

static inline bool km_sparse_is_locked(const km_partition *p, int c) {
  return p->locked && p->locked[c];
}

/* Is it for the caller to say that the column is an independent one? */
static inline bool km_sparse_is_preset(const km_partition *p, const bool *forced, int c) {
  return (forced && forced[c]) || km_sparse_is_locked(p, c);
}

/* Subtracts a step from the accumulators. */
static inline void km_sparse_subtract(const km_sparse *s, const km_entry_range *below, double u) {
  for (int i = below->start; i < below->end; ++i)
    s->x[s->lower_store.index[i]] -= s->lower_store.value[i] * u;
}

/* A step with a pivot of that size was found. */
static inline void km_sparse_update_pivot_range(km_partition *p, double size) {
  p->first_pivot = size > p->first_pivot ? size : p->first_pivot;
  p->smallest_pivot = size < p->smallest_pivot ? size : p->smallest_pivot;
}

void km_sparse_factor(km_partition *partition, const double *matrix, const bool *forced, double tolerance);
/* Is the factor at hand what these arguments give? */
bool km_sparse_has_factor(const km_partition *partition, const double *matrix, const bool *forced, double tolerance);
/* Where that is so, but any independent columns served who asked for it, and don't serve now: goes on to better ones. Returns whether
 * the pivots have changed. */
bool km_sparse_improve_independent(km_partition *partition, const double *matrix, const bool *forced, double tolerance);
/* False where a value is not finite, or one that the pivots take to be 0 isn't and `whole` isn't set, or when out of memory. */
bool km_sparse_refactor(km_partition *partition, const double *matrix, bool whole);
/* The pivots at hand in their order, whatever is 0. False where one of them is, or when out of memory. */
bool km_sparse_refactor_full_pattern(km_partition *partition, const double *matrix);
/* The columns of the independent coordinates that serve best become late, by complete pivoting of the null vectors. Returns
 * whether they aren't those that are independent now. */
bool km_sparse_choose_independent(km_partition *partition, const bool *forced);
void km_sparse_solve(const km_partition *partition, const double *rhs, double *x);
/* U⁻¹ y by step. */
void km_sparse_solve_upper(const km_partition *partition, double *y);
/* The steps that a column of U reaches by entries other than 0, each behind those that change it, into list[top … rows-1].
 * Returns top; their `seen` is set. */
int km_sparse_reach_upper(const km_partition *partition, const km_entry_range *own);
/* A column among the pivots' that the others make dependent to the threshold, though no pivot tells; -1: none. */
int km_sparse_hidden_column(const km_partition *partition, const bool *forced, double threshold);
/* The same of the rows over all columns that may be pivots, whether or not they are. */
int km_sparse_hidden_row(const km_partition *partition, const double *matrix, const bool *forced, double threshold);
/* Spares the rows that others make dependent to the threshold, by Q R over all columns that may be pivots. False where it finds
 * none, or SuiteSparse's SPQR isn't installed, or memory is out. */
bool km_sparse_find_dependent_rows(km_partition *partition, const double *matrix, const bool *forced, double threshold);
/* Are all rows independent to the tolerance over all columns that may be pivots, by their normal equations? Then that is the
 * partition's result. Where `kept_rows` is set: are the primary rows at hand, to that, and do the others depend on them? False also where
 * these equations aren't kept. */
bool km_sparse_rows_are_independent(km_partition *partition, const double *matrix, const bool *forced,
                                    double tolerance);
/* So many steps are subtracted together. */
enum { KM_SUPERNODE_WIDTH = 8 };
/* Before the first step. */
void km_sparse_reset_supernodes(km_partition *partition);
/* The last step, whose entries of L are there, takes the order of the one before it where its rows are that one's. */
void km_sparse_extend_supernode(km_partition *partition, int step);
/* Do the `count` rows of a column's list begin with those of KM_SUPERNODE_WIDTH steps that nest? */
bool km_sparse_supernode_follows(const km_partition *partition, const int *list, int count);
/* Subtracts these from the accumulators, from `step` on; what they have of the column goes to u. */
void km_sparse_supernode_subtract(const km_partition *partition, int step, double u[KM_SUPERNODE_WIDTH]);
/* Room for so many entries of U and of L in all. False when out of memory. */
bool km_sparse_reserve_factor(km_sparse *sparse, int upper, int lower);
bool km_sparse_grow(km_sparse *sparse, km_entry_store *store, int need);
/* The columns with one entry in the rows that no other of them has taken, as the first pivots: nothing is eliminated by
 * them. `given` columns and late ones, and entries of up to `least`, are left. Returns how many entries U has. */
int km_sparse_take_singletons(km_partition *partition, const double *matrix, const bool *forced, double least);
/* One elimination in the order of `late` and `forced`. */
void km_sparse_eliminate(km_partition *partition, const double *matrix, const bool *forced, double threshold);
/* max |B_ij| over the independent columns that aren't given. Where these are long, about the length of the longest row instead:
 * O(KM_SPARSE_MAX_NULL_FILL entries of the matrix) at most. */
double km_sparse_estimate_max_b(const km_partition *partition, const bool *forced);
/* The columns of B, or max |B_ij| alone. Ends at a column that isn't given with an entry beyond `most`: other ones are
 * tried then. False where a value is not finite. */
bool km_sparse_find_b(km_partition *partition, const bool *forced, double most);
/* max |B_ij| of the values at hand, as km_sparse_find_b leaves it. */
double km_sparse_current_max_b(const km_partition *partition);
/* Σ over all columns of the squared number of entries in primary rows: about how many entries Q R of the rows comes to, at most.
 */
double km_sparse_gram_cost(const km_partition *partition);
/* The same sum over all rows, primary or not. */
double km_sparse_full_gram_cost(const km_partition *partition);
/* Do some columns have so many entries that Q R of the rows would be full? */
bool km_sparse_gram_is_dense(const km_partition *partition);
/* Between 1 and 2, of either sign, as if by chance. */
double km_sparse_random_weight(int index, int probe);
/* The entries of column k of B in the store, until another one is asked for. O(entries of U that it reaches). */
km_entry_range km_sparse_b(const km_partition *partition, int k);
/* Column k of B with its zeros, in the workspace. */
const double *km_sparse_gather_b(const km_partition *partition, int k);
double km_sparse_multiplications(const km_partition *p);
void km_sparse_copy(km_partition *to, const km_partition *from);

/* Row `row` of the matrix, divided by the column weights (NULL: by 1), becomes column k of `out`. Columns with
 * left_out[column] set have no entries. */
void km_sparse_fill_row(const km_sparse *s, const double *matrix, const double *weight, const bool *left_out, int row,
                        int k, km_columns out);
/* The partition's normal equations, created at the first call. NULL where they aren't kept, or would fill in. */
km_normal_equations *km_sparse_create_normal(const km_partition *p);
/* The normal equations of the primary rows in the dependent and the first `count` independent columns: of `matrix`, or of
 * the matrix that was factored last where it is NULL. NULL where they aren't kept, would fill in, or are too badly
 * conditioned. */
km_normal_equations *km_sparse_normal(const km_partition *p, const double *matrix, const double *weight, int count);

/* Arrays of a sparse partition with the pattern of `pattern`. False when out of memory. */
bool km_sparse_reserve(km_partition *p, const km_sparse *pattern, int rows, int columns, km_arena *arena);

#endif
