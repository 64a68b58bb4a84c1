/* Factorisation of a constraint matrix J: rank, evidence, null space, row space, solutions (docs/theory.md 3).
 * The module factors matrices and knows no mechanisms.
 *
 *   P_r J P_cᵀ = [J_pd J_pi; J_sd J_si]     p: primary (pivot) rows, d: dependent (pivot) columns, i: independent ones
 *   B = J_pd⁻¹ J_pi,   q̇_d = −B q̇_i,   N = [−B; I]                                    D = diag(weight)
 *
 * Matrices are column-major. Three back ends give the same results up to the choice of pivots: Gauss-Jordan elimination
 * with complete pivoting (GECP) of small matrices in registers and of others in memory, and sparse LU of large matrices
 * with few entries. Source: K. Wehage 2016, sections 3.4, 4.1, 9.1; (163), (271), (275)-(279). */
#ifndef KM_LINALG_FACTOR_H
#define KM_LINALG_FACTOR_H

#include "base/memory.h"

#include <stdbool.h>

typedef struct km_factor km_factor;
typedef struct km_normal_equations km_normal_equations;

/* Factor of near-ties: entries with magnitudes within it are ordered by position (up to 12 × 64: if no eighth of a
 * power of 2 lies between them). So designs that differ slightly mostly share pivots. Dense elimination only. */
#define KM_NEAR_TIE 1.125

/* Use of the null space. The sparse factor saves work by it; the dense one always forms B. */
typedef enum km_factor_basis {
  KM_BASIS_SHORT,   /* |B| as small as complete pivoting makes it */
  KM_BASIS_ANY,     /* any independent columns will do: a sparse factor with many freedoms does not optimise them, and a
                     * refactorisation does not measure B */
  KM_BASIS_ENTRIES, /* as KM_BASIS_ANY; no B is formed, and null vectors are read by km_factor_null_entries only */
  KM_BASIS_NONE     /* none: only the rank and the primary rows, for km_factor_minimum_norm */
} km_factor_basis;

typedef struct km_factor_options {
  double tolerance;        /* pivots end at |pivot| <= tolerance · (largest entry) */
  const bool *forced;      /* [columns] columns that stay independent while the others can give full rank; NULL: none */
  const bool *locked;      /* [columns] borrowed; NULL: none. Locked columns have entries 0, come last and are no
                              * freedom */
  bool forced_never_pivot; /* forced columns are no pivots, at any remaining rank */
  bool ties_by_position;   /* entries within KM_NEAR_TIE are ordered by position */
  km_factor_basis basis;
  double growth_reference; /* max|B| with which the growth monitor compares; 0: that of this search */
} km_factor_options;

/* Evidence of a factorisation. */
typedef struct km_factor_evidence {
  double scale;                                  /* largest entry of the matrix */
  double first_pivot, last_pivot, first_dropped; /* magnitudes of pivots; first_dropped: largest entry after the last
                                                  * pivot, 0: none. Sparse: largest and smallest pivot */
  double smallest_pivot_at_search;
  double max_b, max_b_at_search; /* max|B_ij|, and its value at the last search; with long null vectors of the sparse
                                  * factor an estimate of the length of B's longest row; after a refactorisation for
                                  * any basis with many freedoms, the value of the search */
  unsigned version;              /* number of changes: data derived from the factor are valid for one version */
} km_factor_evidence;

/* Creates a factor for matrices of up to rows × columns, in the arena; NULL (and arena->failed) when out of memory.
 * `weight`[columns]: the metric D, borrowed; NULL: 1. */
km_factor *km_factor_create(int rows, int columns, const double *weight, km_arena *arena);
/* Creates a sparse factor for matrices of one pattern: the rows of entries of column c are row[start[c] …
 * start[c+1]-1], borrowed. `matrix` below is then the values of these entries, in that order. Memory for fill-in and
 * freedom grows in the arena, which must outlive the factor. O(entries) and COLAMD. */
km_factor *km_factor_create_sparse(int rows, int columns, const int *start, const int *row, const double *weight,
                                   km_arena *arena);
/* Creates a factor of the same shape, pattern and metric as another one. */
km_factor *km_factor_create_like(const km_factor *other, km_arena *arena);

/* Sets the memory of the normal equations that minimum-norm solutions of the sparse factor reuse (*normal is NULL at
 * first). It is borrowed and shared with factors that are created like this one; free *normal by
 * km_normal_equations_free. Minimum-norm solutions are slower without it. */
void km_factor_share_normal_equations(km_factor *factor, km_normal_equations **normal);
void km_normal_equations_free(km_normal_equations *normal);

/* Factors `matrix` with complete pivoting, unless the present factor is that of equal data. Equal entries (up to 12 ×
 * 64: equal to 2⁻⁴²) are taken by position, so that rounding does not decide between symmetric joints. Earlier
 * factorisations have no influence. With entries that are not finite the rank is meaningless, but in range. O(rows ·
 * columns · rank). The sparse factor pivots by rows, and completely among the independent columns only: other pivots,
 * but equal rank and null space, and with KM_BASIS_SHORT equal size of B. O(entries of L and U). */
void km_factor_compute(km_factor *factor, const double *matrix, int rows, int columns,
                       const km_factor_options *options);

/* The next km_factor_compute searches pivots: the weights have changed. */
void km_factor_forget(km_factor *factor);

/* Refactors new values with the known pivots, without a search. False if the growth monitor (docs/theory.md 3.3)
 * rejects them, a pivot vanishes or a value is not finite: then factor again. O(rows · rank · columns). */
bool km_factor_refactor(km_factor *factor, const double *matrix, km_factor_basis basis);

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
double km_factor_multiplications(const km_factor *factor);

/* Copies the pivots of another factor of the same size, for a refactorisation. */
void km_factor_copy_pivots(km_factor *to, const km_factor *from);

/* ---- Rank and evidence. */

int km_factor_rank(const km_factor *factor);
/* Columns that are neither dependent nor locked; 0 if the factor failed. */
int km_factor_freedom(const km_factor *factor);
/* Locked columns at the last search. */
int km_factor_locked_count(const km_factor *factor);
/* Order of the rows: [0 … rank-1] are the primary ones, in pivot order. */
const int *km_factor_row_order(const km_factor *factor);
/* Order of the columns: first the dependent ones in pivot order, then the independent ones, forced and locked ones
 * last. */
const int *km_factor_column_order(const km_factor *factor);
km_factor_evidence km_factor_get_evidence(const km_factor *factor);
/* Number of searches for pivots: equal numbers of copies mean equal pivots. */
unsigned km_factor_search_count(const km_factor *factor);
/* True if a forced column had to be a pivot. */
bool km_factor_has_forced_pivot(const km_factor *factor);
/* True if the memory was insufficient: the rank is meaningless, the freedom counts as 0. */
bool km_factor_has_failed(const km_factor *factor);
/* Sign of det of the pivot block, up to a constant: product of the signs of the pivots. */
int km_factor_sign(const km_factor *factor);
/* Smallest magnitude of the present pivots; infinite without pivots. */
double km_factor_smallest_pivot(const km_factor *factor);
/* Product of the pivots. */
double km_factor_pivot_product(const km_factor *factor);
/* True if all null vectors can be read: not with KM_BASIS_NONE and KM_BASIS_ENTRIES of the sparse factor. */
bool km_factor_has_null_vectors(const km_factor *factor);

/* ---- Null and row space. */

/* Column k of B, of the k-th independent column: [rank], valid until the next call on the factor. */
const double *km_factor_b(const km_factor *factor, int k);
/* Null vector that moves the independent column `column` by 1 and the other independent ones by 0. */
void km_factor_null_vector(const km_factor *factor, int column, double *direction);
/* Null vector of the k-th independent column of a sparse factor with KM_BASIS_ENTRIES, by its entries: columns in no
 * order, and values; the independent column has 1. Returns the number of entries, at most rank + 1. O(entries of U). */
int km_factor_null_entries(const km_factor *factor, int k, int *column, double *value);

/* Orthonormal basis Z of D range(N), of its first `count` independent columns only (forced ones come last): Z[count ×
 * columns, leading dimension columns], rows in the matrix's column order, in the factor's memory until the next
 * factorisation or km_factor_row_space. Vectors that are known already are not computed again. The basis is not unique,
 * its range is. NULL when out of memory; then the factor has failed. */
double *km_factor_null_space(km_factor *factor, int count);
/* Number of vectors of that basis that are known. */
int km_factor_known_null_vectors(const km_factor *factor);
/* Sets the basis to one vector z[column · stride] that another method found. */
void km_factor_set_null_vector(km_factor *factor, const double *z, size_t stride);

/* Orthonormal basis R of the row space of J D⁻¹ over the dependent and the first `count` independent columns, with 0 in
 * the others: R[rank × columns, leading dimension columns], in the memory of Z. Its orthogonal complement is D times
 * the null space. NULL when out of memory. O(columns · rank²): cheaper than km_factor_null_space if rank < count. */
double *km_factor_row_space(km_factor *factor, int count);

/* Number of vectors from which sums run in SIMD lanes and sparse QR is cheaper than dense bases. */
enum { KM_MANY_VECTORS = 48 };

/* True if projections by sparse equations are cheaper than a basis: a sparse factor with many freedoms. */
bool km_factor_avoids_basis(const km_factor *factor);
/* True if mobility numbers need no basis Z: with many freedoms, if the factor is sparse or has fewer rows. */
bool km_factor_numbers_avoid_basis(const km_factor *factor);

/* Projects each of `count` vectors Y[columns · count] onto D times the null space, in place, by the matrix factored
 * last. False, and Y unchanged, unless km_factor_avoids_basis, and without SuiteSparse or memory. O(entries of a factor
 * of the primary rows), instead of O(columns · count²) by km_factor_null_space. */
bool km_factor_project_null_space(const km_factor *factor, const double *matrix, double *Y, int count);

/* Mobility numbers m_j = Σ_k Z_jk², (278). */
void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers);

/* Mobility numbers without null vectors, m_j = 1 − Σ_k R_jk² by the rows of the matrix factored last; accurate to
 * 1e-13. O(columns · rank²); sparse O(entries of R that the columns reach). False without SuiteSparse's SPQR or
 * memory. */
bool km_factor_mobility_numbers(const km_factor *factor, const double *matrix, double *numbers);

/* ---- Solutions. */

/* Particular solution of J_p x = rhs with the independent coordinates 0. rhs[rows], x[columns]. */
void km_factor_solve(const km_factor *factor, const double *rhs, double *x);
/* Minimum-norm solution by the matrix factored last: |D x| minimal with J_p x = rhs[rows], in the dependent and first
 * `count` independent columns, 0 in the others. */
void km_factor_minimum_norm(km_factor *factor, const double *matrix, int count, const double *rhs, double *x);
/* Removes from x its projection onto the null space of the first `count` independent columns, in the norm |D x|, by the
 * matrix factored last. Columns behind these keep their entries. */
void km_factor_remove_null_space(km_factor *factor, const double *matrix, int count, double *x);

#endif
