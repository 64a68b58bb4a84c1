/* Sparse LU of a partition, for large substructures (docs/theory.md 3.6).
 *
 *   L U = P_r J Q,  columns in COLAMD order;  pivot row: the shortest row with |entry| >= 0.3 of the column's largest
 *
 * Column by column (J. Gilbert and T. Peierls 1988). Column singletons come first. A column of which no more than the
 * rank threshold remains becomes independent. The independent columns are then chosen by complete pivoting of the null
 * vectors, so that |B| is as small as with complete pivoting of the whole matrix. Private to linalg/. */
#ifndef KM_LINALG_SPARSE_SPARSE_LU_H
#define KM_LINALG_SPARSE_SPARSE_LU_H

#include "linalg/factor_private.h"
#include "linalg/sparse/normal_equations.h"
#include "linalg/sparse/row_storage.h"
#include "linalg/sparse/sparse_qr.h"

/* A range of entries in a store. */
typedef struct km_entry_range {
  int start, end;
} km_entry_range;

/* Entries of L, U or B, each with its row or step. Grows with the fill-in. */
typedef struct km_entry_store {
  int *index;
  double *value;
  size_t capacity;
} km_entry_store;

/* Non-zero entries of a column in open rows, while singletons are sought: their number (−1: the column became a pivot),
 * and the exclusive or of their indices in the matrix, which is the index itself once one is left. */
typedef struct km_open_entries {
  int count, index_xor;
} km_open_entries;

struct km_sparse {
  km_arena *arena;                           /* arena of the growing arrays */
  const int *start, *row;                    /* pattern: rows of column c are row[start[c] … start[c+1]-1] */
  const km_row_entry *by_row;                /* the entries by row: those of row r begin at by_row[row_start[r]] */
  const int *row_start;                      /* [rows + 1] */
  const int *order;                          /* [columns] column order of COLAMD */
  int *factor_order;                         /* [columns] column order of this factorisation */
  int singleton_count;                       /* number of column singletons at the beginning of that order */
  int *singleton_zero, singleton_zero_count; /* entries that must be 0 so that the columns are singletons */
  km_open_entries *open_entries;             /* [columns] */
  int *dropped;       /* [columns] columns that became independent, in that order; earlier: candidates for singletons */
  bool *is_postponed; /* [columns] the column comes last, since it shall become independent */
  bool
      postpones_small; /* columns with a small pivot are postponed, so that small pivots that share a vanishing singular
                        * value come last, where they show the rank */
  int max_entries;     /* bound of entries of U and L, beyond which the elimination ends as overfull; 0:
                                   * none */
  bool limits_fill_if_postponing; /* the bound applies only while columns are postponed */
  bool is_overfull;               /* the last elimination exceeded max_entries */
  km_entry_range *upper; /* [columns] entries of U of each column, by step, in an order in which they can be replayed */
  km_entry_range *lower; /* [columns] entries of L of each column, by row; none of independent columns */
  km_entry_store upper_store, lower_store;  /* index: step; row */
  int *step_of;                             /* [rows] step whose pivot lies in the row; -1: none */
  double *x;                                /* [rows] accumulator, 0 between columns */
  int *reach_list, *stack, *stack_position; /* [rows] rows that a column reaches; stack of the depth-first search */
  bool *visited;                            /* [rows] */
  bool *is_excluded_row;                    /* [rows] the row must not be primary, since it depends on others */
  km_entry_range *b;                        /* [columns] non-zero entries of column k of B, by step, ascending */
  km_entry_store b_store;                   /* index: step */
  bool is_basis_any; /* the last search ended with independent columns that suffice for minimum-norm steps only */
  km_normal_equations **normal; /* borrowed, shared by all partitions of the pattern; NULL: none */
  bool has_rows_only;           /* only rows were requested: independent columns have no entries of U and no B */
  bool is_b_unmeasured;         /* max|B| was not measured with these values */
  bool stores_all_b;            /* all columns of B are stored; else they are computed one at a time */
};

/* Ratio of all entries of B to those of the matrix above which max|B| is estimated: such null vectors reach through the
 * whole mechanism. */
enum { KM_SPARSE_MAX_NULL_FILL = 5 };

/* True if the caller makes the column independent: forced or locked. */
static inline bool km_sparse_is_preset(const km_factor *p, const bool *forced, int c) {
  return (forced && forced[c]) || km_factor_is_locked(p, c);
}

/* True if null vectors can be read. */
static inline bool km_sparse_has_null_vectors(const km_factor *p) {
  return !p->sparse->has_rows_only && p->options.basis != KM_BASIS_ENTRIES;
}

/* Subtracts a step of L, times u, from the accumulator. */
static inline void km_sparse_subtract(const km_sparse *s, const km_entry_range *below, double u) {
  for (int i = below->start; i < below->end; ++i)
    s->x[s->lower_store.index[i]] -= s->lower_store.value[i] * u;
}

/* Updates the largest and the smallest pivot. */
static inline void km_sparse_update_pivot_range(km_factor *p, double size) {
  p->first_pivot = size > p->first_pivot ? size : p->first_pivot;
  p->smallest_pivot = size < p->smallest_pivot ? size : p->smallest_pivot;
}

void km_sparse_factor(km_factor *partition, const double *matrix, const bool *forced, double tolerance);
/* True if the present factor has the basis that is needed. */
bool km_sparse_is_basis_sufficient(const km_factor *partition, km_factor_basis basis);
/* Refactors with the known pivots; where a structural zero of the singletons filled in, on the full pattern. False if a
 * value is not finite, or out of memory. */
bool km_sparse_refactor(km_factor *partition, const double *matrix);
/* Eliminates with the known pivots in their order, without assumed zeros. False if a pivot is 0 or out of memory. */
bool km_sparse_refactor_full_pattern(km_factor *partition, const double *matrix);
/* Chooses the independent columns by complete pivoting of the null vectors and postpones them. Returns true if they
 * differ from the present ones. */
bool km_sparse_choose_independent(km_factor *partition, const bool *forced);
void km_sparse_solve(const km_factor *partition, const double *rhs, double *x);
/* y <- U⁻¹ y, by step. */
void km_sparse_solve_upper(const km_factor *partition, double *y);
/* Hidden dependence: pivot column that depends on the others to the threshold without a small pivot; -1: none. */
int km_sparse_hidden_column(const km_factor *partition, const bool *forced, double threshold);
/* Hidden dependence of rows, over all columns that may be pivots; -1: none. */
int km_sparse_hidden_row(const km_factor *partition, const double *matrix, const bool *forced, double threshold);
/* Excludes rows that depend on others to the threshold, by sparse QR over all columns that may be pivots. False if
 * there are none, without SPQR, or out of memory. */
bool km_sparse_find_dependent_rows(km_factor *partition, const double *matrix, const bool *forced, double threshold);
/* Reserves memory for entries of U and L. False when out of memory. */
bool km_sparse_reserve_factor(km_sparse *sparse, int upper, int lower);
bool km_sparse_grow(km_sparse *sparse, km_entry_store *store, int need);
/* Takes column singletons as the first pivots: columns with one entry in open rows, which eliminate nothing. Preset and
 * postponed columns, and entries up to `min_pivot`, are excluded. Returns the number of entries of U. */
int km_sparse_take_singletons(km_factor *partition, const double *matrix, const bool *forced, double min_pivot);
/* One elimination in the order given by is_postponed and `forced`. */
void km_sparse_eliminate(km_factor *partition, const double *matrix, const bool *forced, double threshold);
/* max|B_ij| over the independent columns that are not preset; with many entries an estimate of the length of the
 * longest row instead: O(KM_SPARSE_MAX_NULL_FILL entries of the matrix) at most. */
double km_sparse_estimate_max_b(const km_factor *partition, const bool *forced);
/* Computes the columns of B, or max|B_ij| only. Ends at a column that is not preset with an entry beyond `most`, since
 * other columns are tried then. False if a value is not finite. */
bool km_sparse_find_b(km_factor *partition, const bool *forced, double most);
/* max|B_ij| of the present values, as km_sparse_find_b computes it. */
double km_sparse_current_max_b(const km_factor *partition);
/* Σ over all columns of (entries in primary rows)²: bound of the entries of the rows' Gram matrix and of their QR. */
double km_sparse_gram_cost(const km_factor *partition);
/* Σ over all columns of (entries)², over all rows. */
double km_sparse_full_gram_cost(const km_factor *partition);
/* True if the Gram matrix of the rows would be dense, because columns have many entries. */
bool km_sparse_gram_is_dense(const km_factor *partition);
/* Pseudo-random weight of magnitude 1 to 2, of either sign. */
double km_sparse_random_weight(int index, int probe);
/* Entries of column k of B in b_store, valid until the next column is computed. O(entries of U). */
km_entry_range km_sparse_b(const km_factor *partition, int k);
/* Column k of B as a dense vector, in `work`. */
const double *km_sparse_gather_b(const km_factor *partition, int k);
double km_sparse_multiplications(const km_factor *p);
void km_sparse_copy(km_factor *to, const km_factor *from);

/* Copies row `row` of the matrix, over the column weights (NULL: 1), to column k of `out`, without columns that have
 * left_out[column] set. */
void km_sparse_fill_row(const km_sparse *s, const double *matrix, const double *weight, const bool *left_out, int row,
                        int k, km_columns out);
/* Factors the normal equations of the primary rows in the dependent and the first `count` independent columns. NULL if
 * they are not available, would fill in, or are too ill-conditioned. */
km_normal_equations *km_sparse_normal(const km_factor *p, const double *matrix, int count);

/* Creates a sparse factor with the pattern of `pattern`. NULL when out of memory. */
km_factor *km_sparse_create(const km_sparse *pattern, int rows, int columns, const double *weight, km_arena *arena);

#endif
