/* Coordinate partitioning of one constraint matrix J: rank, dependent and independent columns, null space
 * (docs/theory.md 3). The module factors matrices and knows no mechanisms.
 *
 *   P_r J P_cᵀ = [J_pd J_pi; J_sd J_si]     p: primary (pivot) rows, d: dependent (pivot) columns, i: independent ones
 *   B = J_pd⁻¹ J_pi,   q̇_d = −B q̇_i,   N = [−B; I]                                    D = diag(weight)
 *
 * Matrices are column-major. Gauss-Jordan elimination with complete pivoting (GECP): a pivot clears its column in the
 * rows of earlier pivots too. The pivots are those of LU in the same order, and B is complete after the last step. Rows
 * and columns are not moved; `row` and `column` state their order. Source: K. Wehage 2016, sections 3.4, 4.1, 9.1;
 * (163), (271), (275)-(279). */
#ifndef KM_LINALG_PARTITION_H
#define KM_LINALG_PARTITION_H

#include "base/memory.h"

#include <stdbool.h>

typedef struct km_sparse km_sparse;
typedef struct km_normal_equations km_normal_equations;

/* Factor of near-ties: entries with magnitudes within it are ordered by position (up to 12 × 64: if no eighth of a
 * power of 2 lies between them). So designs that differ slightly mostly share pivots. Dense elimination only. */
#define KM_NEAR_TIE 1.125

/* A factorisation with its evidence. Fields "set by the caller" are options of the next factorisation. */
typedef struct km_partition {
  int rows, columns; /* shape of the matrix */
  int rank;
  int *row;          /* [rows] row[0 … rank-1] are the primary constraints, in pivot order */
  int *column;       /* [columns] first the dependent coordinates in pivot order, then the independent ones */
  int stride;        /* leading dimension of `reduced`: rows, rounded up to even */
  km_sparse *sparse; /* sparse factor of large matrices with few entries; NULL: dense, by `reduced` and `pivot_guess` */
  double *reduced;   /* [columns × stride] rows and columns in the matrix's order. Dependent column i: the multiples of
                    * row[i] that step i subtracted from the others, 0 for itself. Independent: B before `inverse` */
  double *inverse;   /* [rank] reciprocals of the pivots */
  double *B;         /* [freedom × rank, leading dimension `rank`], of the dense engine */
  int *pivot_guess;  /* [rank] position of each pivot at the last search: guess for the next search */
  double *work;      /* [stride] */
  double scale;      /* largest entry of the matrix */
  double first_pivot, last_pivot, first_dropped; /* magnitudes of pivots; first_dropped: largest entry after the last
                                                  * pivot, 0: none */
  double smallest_pivot;                         /* magnitude at the last search */
  double max_b,
      max_b_at_search;   /* max|B_ij|, and its value at the last search; with long null vectors of the sparse factor an
                          * estimate of the length of B's longest row */
  int sign;              /* sign of det of the pivot block, up to a constant: product of the signs of the pivots */
  unsigned search_count; /* number of searches for pivots */
  unsigned version;      /* number of changes: data derived from the partition are valid for one version */
  bool forced_dependent; /* a forced column had to be a pivot */
  bool failed;           /* out of memory in the sparse factor: the rank is meaningless, the freedom counts as 0 */
  bool ties_by_position; /* set by the caller: near-ties are ordered by position, see KM_NEAR_TIE */
  bool forced_never_pivot; /* set by the caller: forced columns are no pivots, at any remaining rank */
  bool unrestricted_basis; /* set by the caller: any basis of the null space will do, read by km_partition_null_entries
                           * only; the sparse factor then does not bound |B| and forms no B */
  bool
      rows_only; /* set by the caller: only the rank and the primary rows are needed, for km_partition_minimum_norm; the
                  * sparse factor forms no null vectors */
  double min_relative_pivot; /* set by the caller: relative pivot threshold below which no search goes, over the largest
                           * entry */
  bool accepts_any_basis;    /* set by the caller: any independent columns will do; the sparse factor with many
                               * freedoms does not optimise them, and a refactorisation does not measure B */
  const bool *locked; /* [columns] set by the caller, borrowed; NULL: none. Locked columns have entries 0, come last and
                       * are no freedom */
  int locked_count;   /* locked columns at the last search */
} km_partition;

/* Reserves memory for matrices of up to rows × columns; false (and arena->failed) when out of memory. */
bool km_partition_reserve(km_partition *partition, int rows, int columns, km_arena *arena);

/* Reserves a sparse factor for matrices of one pattern: the rows of entries of column c are row[start[c] …
 * start[c+1]-1], borrowed. `matrix` below is then the values of these entries, in that order. Memory for fill-in and
 * freedom grows in the arena, which must outlive the partition. O(entries) and COLAMD. */
bool km_partition_reserve_sparse(km_partition *partition, int rows, int columns, const int *start, const int *row,
                                 km_arena *arena);
/* Reserves a partition for matrices of another size or for those of `other`, dense or sparse as that one. */
bool km_partition_reserve_like(km_partition *partition, const km_partition *other, int rows, int columns,
                               km_arena *arena);

/* Sets the memory of the normal equations that minimum-norm solutions of the sparse factor reuse (*normal is NULL at
 * first), and the weights of these solutions. Both are borrowed and shared with partitions that are reserved like this
 * one; free *normal by km_normal_equations_free. Minimum-norm solutions are slower without them. */
void km_partition_set_normal_equations(km_partition *partition, km_normal_equations **normal, const double *weight);
void km_normal_equations_free(km_normal_equations *normal);

/* Factors `matrix` with complete pivoting. Pivots stop at |pivot| <= tolerance · (largest entry). Columns with
 * forced[c] (NULL: none) stay independent while the others can give full rank. Equal entries (up to 12 × 64: equal to
 * 2⁻⁴²) are taken by position, so that rounding does not decide between symmetric joints. Earlier factorisations have
 * no influence. With entries that are not finite the rank is meaningless, but in
 * range. O(rows · columns · rank). The sparse factor pivots by rows, and completely among the independent columns only:
 * other pivots, but equal rank, null space and size of B; last_pivot is then the smallest. O(entries of L and U). */
void km_partition_factor(km_partition *partition, const double *matrix, int rows, int columns, const bool *forced,
                         double tolerance);

/* Refactors new values with the known pivots, without a search. False if the growth monitor (docs/theory.md 3.3)
 * rejects them, a pivot vanishes or a value is not finite: then factor again. O(rows · rank · columns). */
bool km_partition_refactor(km_partition *partition, const double *matrix);
/* Refactors on the full pattern, keeping the given pivots even if entries that were 0 at the search filled in. The
 * sparse factor skips such zeros in km_partition_refactor, which is false then. Cost of a search in that case. */
bool km_partition_refactor_full_pattern(km_partition *partition, const double *matrix);

/* Growth monitor: pivots are acceptable while max|B| has at most doubled and the smallest pivot has shrunk to no less
 * than a tenth. */
static const double km_max_b_growth = 2.0, km_max_pivot_shrinkage = 10.0;
/* Largest max|B| of good null vectors: above it they are so dominated by forced columns that digits are lost. */
static const double km_max_good_b = 30.0;

/* True if max|B| is acceptable against its value at the search (K. Wehage 2016, sections 5.5, 7.2). */
static inline bool km_is_b_growth_acceptable(double largest_b, double pivoted_b) {
  return largest_b <= km_max_b_growth * (pivoted_b > 1.0 ? pivoted_b : 1.0);
}

/* Growth monitor by max|B| and the largest reciprocal of a pivot. A rank that drops shrinks a pivot together with its
 * row of B, so B alone need not show it. */
static inline bool km_are_pivots_acceptable(double largest_b, double pivoted_b, double largest_inverse,
                                            double smallest_pivot) {
  return km_is_b_growth_acceptable(largest_b, pivoted_b) && largest_inverse * smallest_pivot <= km_max_pivot_shrinkage;
}

/* Approximate multiplications of a refactorisation with B and one solution. */
double km_partition_multiplications(const km_partition *partition);

/* Copies the pivots of another partition of the same size, for a refactorisation. */
void km_partition_copy_pivots(km_partition *to, const km_partition *from);

static inline int km_partition_freedom(const km_partition *p) {
  return p->failed ? 0 : p->columns - p->rank - p->locked_count;
}

/* Column k of B, of the k-th independent column: [rank], valid until the next call on the partition. */
const double *km_partition_b(const km_partition *partition, int k);

/* Particular solution of J_p x = rhs with the independent coordinates 0. rhs[rows], x[columns]. */
void km_partition_solve(const km_partition *partition, const double *rhs, double *x);

/* Orthonormal basis Z of D range(N), of its first `count` independent columns only (forced ones come last): Z[count ×
 * columns, leading dimension columns], rows in the matrix's column order. The basis is not unique, its range is. */
void km_partition_null_space(const km_partition *partition, const double *weight, int count, double *Z);

/* Computes the vectors first … count-1 of that basis; Z contains those before them. */
void km_partition_extend_null_space(const km_partition *partition, const double *weight, int first, int count,
                                    double *Z);

/* Orthonormal basis R of the row space of J D⁻¹ over the dependent and the first `count` independent columns, with 0 in
 * the others: R[rank × columns, leading dimension columns]. Its orthogonal complement is D times the null space.
 * O(columns · rank²): cheaper than km_partition_null_space if rank < count. */
void km_partition_row_space(const km_partition *partition, const double *weight, int count, double *R);

/* Number of vectors from which sums run in SIMD lanes and sparse QR is cheaper than dense bases. */
enum { KM_MANY_VECTORS = 48 };

/* True if projections by sparse equations are cheaper than a basis: a sparse factor with many freedoms. */
static inline bool km_partition_avoids_basis(const km_partition *p) {
  return p->sparse && km_partition_freedom(p) > KM_MANY_VECTORS;
}

/* Removes from x its projection onto the null space of the first `count` independent columns, in the norm |D x|, by the
 * matrix factored last with the sparse factor. work[columns]. False, and x unchanged, without SuiteSparse or memory.
 * O(entries of a factor of the primary rows), instead of O(columns · count²) by km_partition_null_space. */
bool km_partition_remove_null_space(const km_partition *partition, const double *matrix, const double *weight,
                                    int count, double *x, double *work);

/* Projects each of `count` vectors Y[columns · count] onto D times the null space, in place. Conditions as
 * km_partition_remove_null_space. */
bool km_partition_project_null_space(const km_partition *partition, const double *matrix, const double *weight,
                                     double *Y, int count);

/* Minimum-norm solution: |D x| minimal with J_p x = rhs[rows], in the dependent and first `count` independent columns,
 * 0 in the others. Conditions as km_partition_remove_null_space. No pivot block is inverted, which can be
 * ill-conditioned with many independent columns. */
bool km_partition_minimum_norm(const km_partition *partition, const double *matrix, const double *weight, int count,
                               const double *rhs, double *x);

/* Null vector that moves the independent column `column` by 1 and the other independent ones by 0. */
void km_partition_null_vector(const km_partition *partition, int column, double *direction);

/* Null vector of the k-th independent column of a sparse partition with `unrestricted_basis`, by its entries: columns
 * in no order, and values; the independent column has 1. Returns the number of entries, at most rank + 1. O(entries of
 * U). */
int km_partition_null_entries(const km_partition *partition, int k, int *column, double *value);

/* Mobility numbers m_j = Σ_k Z_jk², (278). */
void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers);

/* Mobility numbers without null vectors, m_j = 1 − Σ_k R_jk² by the rows of the matrix factored last; accurate to
 * 1e-13. O(columns · rank²); sparse O(entries of R that the columns reach). False without SuiteSparse's SPQR or
 * memory. */
bool km_partition_mobility_numbers(const km_partition *partition, const double *matrix, const double *weight,
                                   double *numbers);

#endif
