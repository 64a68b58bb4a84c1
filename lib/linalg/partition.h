/* Coordinate partitioning of one constraint matrix: rank, dependent and independent columns, null space.
 * Knows matrices, never mechanisms. Sources: thesis 3.4, 4.1, 9.1; equations (163), (271), (275)-(279).
 *
 * Matrices are column-major. With P_r J P_cᵀ = [J_pd J_pi; …] the pivot rows p are the primary constraints, the
 * pivot columns d the dependent coordinates; B = J_pd⁻¹J_pi, q̇_d = −B q̇_i, N = [−B; I].
 *
 * Gauss-Jordan: a pivot clears its column in the rows of earlier pivots too. The pivots are those of LU with the
 * same order, and B stands ready when the last one is done. Rows and columns stay where they are; `row` and
 * `column` say in which order they were used. */
#ifndef KM_LINALG_PARTITION_H
#define KM_LINALG_PARTITION_H

#include "base/memory.h"

#include <stdbool.h>

typedef struct km_sparse km_sparse;
typedef struct km_normal_equations km_normal_equations;

/* Entries whose sizes differ by less than this factor are nearly as large as each other (up to 12 × 64: if no step between powers
 * of 2, eight of them, lies between them). Designs that differ a little then mostly have the same pivots. The sparse engine
 * doesn't need it. */
#define KM_NEAR_TIE 1.125

/* The result of a factorisation, with its evidence. */
typedef struct km_partition {
  int rows, columns; /* of the matrix */
  int rank;
  int *row;    /* [rows] row[0 … rank-1] are the primary constraints, in pivot order */
  int *column; /* [columns] first the dependent coordinates in pivot order, then the independent ones */
  int stride;  /* leading dimension of `reduced`: rows, rounded up to even */
  km_sparse
      *sparse;      /* the engine for large matrices with few entries; NULL: dense, and then `reduced`, `place` count */
  double *reduced;  /* [columns × stride] rows and columns in the matrix's order. Dependent column i: the multiples of
                    * row[i] that step i subtracted from the others, 0 for itself. Independent: B before `inverse` */
  double *inverse;  /* [rank] reciprocals of the pivots */
  double *B;        /* [freedom × rank, leading dimension `rank`], of the dense engine */
  int *pivot_guess; /* [rank] where the last search found each pivot: a guess for the next one */
  double *work;     /* [stride] */
  double scale;     /* largest entry of the matrix */
  double first_pivot, last_pivot, first_dropped; /* magnitudes; first_dropped 0: nothing was left */
  double smallest_pivot;                         /* magnitude at the last search */
  double max_b,
      max_b_at_search;   /* max |B_ij|, and its value when pivots were last searched; of long null vectors of the
                                * sparse engine the length of B's longest row, about */
  int sign;              /* of the product of the pivots: flips where det of the pivot block does */
  unsigned search_count; /* how often pivots were searched */
  unsigned version;      /* how often anything of this changed: what was made from it is good for its edition */
  bool forced_dependent; /* a column that should be independent had to be a pivot */
  bool failed;           /* out of memory while the sparse engine grew: the rank means nothing, no freedom is given */
  bool
      ties_by_position; /* set by the caller: entries that are nearly as large as each other go by place too, see KM_NEAR_TIE */
  bool forced_never_pivot; /* set by the caller: forced columns are no pivots, whatever rank that leaves */
  bool
      unrestricted_basis; /* set by the caller: any null vectors will do, and km_partition_null_entries alone is asked for
                         * them; the sparse engine doesn't keep |B| small then, and makes no B */
  bool
      rows_only; /* set by the caller: the rank and which rows are primary are enough, for km_partition_minimum_norm; the
                       * sparse engine makes no null vectors then */
  double
      kept_row_tolerance; /* set by the caller, beside `rows_only`: the primary rows at hand are tried before others, and stay where
                       * they are independent to this tolerance, however loose the search's own is, by which the others depend on
                       * them; 0: they aren't tried */
  bool rows_were_kept; /* the last search of the sparse engine found the rows of `kept_rows` to be good ones */
  double
      min_relative_pivot; /* set by the caller: pivots up to this share of the largest entry count as 0, whatever a search asks for */
  bool
      basis_quality_unneeded; /* set by the caller: the independent columns are asked for nothing but which ones they are; of many the
                       * sparse engine takes any then, and a refactor doesn't measure B */
  bool is_deferred;   /* by km_partition_defer */
  const bool *locked; /* [columns] set by the caller, borrowed; NULL: none. Columns of what doesn't move: their entries
                       * are 0, they come last and count as no freedom */
  int locked_count;   /* at the last search */
} km_partition;

/* Space for matrices of up to rows × columns; false (and arena->failed) when out of memory. */
bool km_partition_reserve(km_partition *partition, int rows, int columns, km_arena *arena);

/* The same for matrices of one pattern, by the sparse engine: the rows of column c that can hold something else than 0
 * are row[start[c] … start[c+1]-1], borrowed. `matrix` is then these entries' values, in that order, everywhere below.
 * What grows with fill and freedom grows in the arena, which must outlive the partition. O(entries) and COLAMD's
 * order. */
bool km_partition_reserve_sparse(km_partition *partition, int rows, int columns, const int *start, const int *row,
                                 km_arena *arena);
/* Space for the matrices of `other`, by the same engine. */
bool km_partition_reserve_like(km_partition *partition, const km_partition *other, int rows, int columns,
                               km_arena *arena);

/* Where what least solutions by the sparse engine keep from one to the next is to be kept, NULL at first: for this partition and
 * those that are reserved like it later; and the weights that they will be taken with. Both are borrowed; *place is for km_normal_equations_free.
 * Without a place they take longer. */
void km_partition_set_normal_equations(km_partition *partition, km_normal_equations **place, const double *weight);
void km_normal_equations_free(km_normal_equations *normal);

/* Complete pivoting. Pivots stop at |pivot| ≤ tolerance · (largest entry). Columns with forced[c] (may be
 * NULL) stay independent while the others can give full rank. Equal entries (up to 12 × 64: equal to 2^-42, so that
 * rounding doesn't decide between symmetric joints) go by place; what was factored before has no influence
 * unless `kept_rows` is set. `matrix` is kept. With entries that are not finite the rank means nothing, but stays in range.
 * O(rows·columns·rank). The sparse engine pivots by rows, and completely only among the independent columns: the pivots
 * are others, rank, null space and the size of B the same; last_pivot is then the smallest. O(entries of L and U). */
void km_partition_factor(km_partition *partition, const double *matrix, int rows, int columns, const bool *forced,
                         double tolerance);

/* The same pivots on new values, no search. False where max |B| passes twice its value at the last search, a pivot
 * vanishes or a value is not finite: then factor again. O(rows·rank·columns). */
bool km_partition_refactor(km_partition *partition, const double *matrix);
/* The same for who needs these pivots and no others. The sparse engine skips what is 0 at the search, and of a mechanism as it was
 * drawn much is; a refactor is false where it isn't any longer, and this goes on without skipping it. As long as a search then. */
bool km_partition_refactor_full_pattern(km_partition *partition, const double *matrix);

/* Do normal equations give least solutions, so that a sparse partition may wait? */
bool km_partition_may_defer(const km_partition *partition);
/* The pivots at hand on a new matrix, of which only their rows and columns are known until a refactor: for km_partition_minimum_norm and
 * km_partition_remove_null_space, which are false where that isn't enough. */
void km_partition_defer(km_partition *partition);

/* Pivots serve while max |B| has grown by the first at most, and the smallest pivot has shrunk by the second. */
static const double km_max_b_growth = 2.0, km_max_pivot_shrinkage = 10.0;
/* Past this |B| the null vectors lean so far on forced columns that digits are lost. */
static const double km_max_good_b = 30.0;

/* Are the independent columns still good ones: max |B| now, and when they were chosen (thesis 5.5, 7.2). */
static inline bool km_is_b_growth_acceptable(double largest_b, double pivoted_b) {
  return largest_b <= km_max_b_growth * (pivoted_b > 1.0 ? pivoted_b : 1.0);
}

/* Do pivots still serve, by max |B| and the largest reciprocal of a pivot now, and what was found when they were searched?
 * A rank that drops shrinks a pivot together with what stands right of it: B alone needn't show it. */
static inline bool km_are_pivots_acceptable(double largest_b, double pivoted_b, double largest_inverse,
                                            double smallest_pivot) {
  return km_is_b_growth_acceptable(largest_b, pivoted_b) && largest_inverse * smallest_pivot <= km_max_pivot_shrinkage;
}

/* About how many multiplications a refactor, B and one solution take. */
double km_partition_multiplications(const km_partition *partition);

/* Takes over which pivots another partition of the same size uses, for a refactor of its own. */
void km_partition_copy_pivots(km_partition *to, const km_partition *from);

static inline int km_partition_freedom(const km_partition *p) {
  return p->failed ? 0 : p->columns - p->rank - p->locked_count;
}

/* Column k of B, that is of the k-th independent coordinate: [rank], good until anything else is asked of the partition. */
const double *km_partition_b(const km_partition *partition, int k);

/* Particular solution of the primary rows of J x = rhs with the independent coordinates 0.
 * rhs[rows], x[columns]. */
void km_partition_solve(const km_partition *partition, const double *rhs, double *x);

/* Orthonormal basis Z of diag(weight)·range(N), of its first `count` independent coordinates only (the forced
 * ones come last): Z[count × columns, leading dimension columns], rows in the matrix's column order. The basis
 * is not unique, its range is. */
void km_partition_null_space(const km_partition *partition, const double *weight, int count, double *Z);

/* Its vectors first … count-1, where Z has those before them. */
void km_partition_extend_null_space(const km_partition *partition, const double *weight, int first, int count,
                                    double *Z);

/* Orthonormal basis of the row space of J·diag(weight)⁻¹ over the dependent columns and the first `count` independent
 * ones, the entries of the others 0: R[rank × columns, leading dimension columns]. What is at right angles to it is
 * diag(weight) times a null vector. O(columns·rank²): cheaper than km_partition_null_space where rank < count. */
void km_partition_row_space(const km_partition *partition, const double *weight, int count, double *R);

/* More vectors than that are many: then sums run in lanes, and sparse Q R is worth its start. */
enum { KM_MANY_VECTORS = 48 };

/* Takes out of x what it has of the null space of the first `count` independent columns, in the norm |diag(weight) x|, by the
 * matrix that the sparse engine factored last. work[columns]. False, and x kept, where SuiteSparse isn't installed or memory
 * is out. O(entries of a factor of the primary rows), where km_partition_null_space takes O(columns·count²). */
bool km_partition_remove_null_space(const km_partition *partition, const double *matrix, const double *weight,
                                    int count, double *x, double *work);

/* Of each of `count` vectors Y[columns · count] what it has of diag(weight) times the null space, in its place; by the matrix that
 * the sparse engine factored last, and as km_partition_remove_null_space. */
bool km_partition_project_null_space(const km_partition *partition, const double *matrix, const double *weight,
                                     double *Y, int count);

/* The x of least |diag(weight) x| with the primary rows of J x = rhs[rows], in the same columns and on the same terms: 0 in the
 * others. No block of pivots is inverted, which may be a bad one where many columns are independent. */
bool km_partition_minimum_norm(const km_partition *partition, const double *matrix, const double *weight, int count,
                               const double *rhs, double *x);

/* The same by the matrix of the last one that normal equations have given, which is near the present one: half of what one takes is
 * to factor them. False where it had other rows or columns, or there was none. */
bool km_partition_minimum_norm_reuse(const km_partition *partition, const double *weight, int count, const double *rhs,
                                     double *x);

/* The null vector that moves independent column `column` by 1 and the other independent ones not at all. */
void km_partition_null_vector(const km_partition *partition, int column, double *direction);

/* The null vector of the k-th independent column, of a sparse partition that was factored with `any_independent`: the columns
 * in which it has entries, in no order, and the entries, that of the independent column being 1. Returns how many, rank + 1 at
 * most. O(entries of the columns of U that it takes). */
int km_partition_null_entries(const km_partition *partition, int k, int *column, double *value);

/* Mobility numbers m_j = Σ_k Z_jk², (278). */
void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers);

/* The same without null vectors, by what the rows of the matrix that was factored last leave of every unit vector: good to
 * 1e-13. O(columns·rank²), of the sparse engine O(entries of R that the columns reach). False where SuiteSparse's SPQR isn't
 * installed or memory is out. */
bool km_partition_mobility_numbers(const km_partition *partition, const double *matrix, const double *weight,
                                   double *numbers);

#endif
