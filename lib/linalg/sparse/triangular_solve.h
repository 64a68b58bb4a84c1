/* Sparse upper triangular matrix R of a QR factorisation: forward substitution with several right sides. Private to
 * linalg/. */
#ifndef KM_LINALG_SPARSE_TRIANGULAR_SOLVE_H
#define KM_LINALG_SPARSE_TRIANGULAR_SOLVE_H

#include <stdbool.h>
#include <stdint.h>

/* R by rows: entries of row k from start[k] on, by column, the diagonal entry first. */
typedef struct km_triangle {
  const long *start, *column;
  const double *value;
  const bool *is_nested;    /* [columns] by km_triangle_is_nested: such rows are processed together */
  const bool *covers_later; /* [columns] by km_triangle_covers_later: of such a row only the first column after the
                             * diagonal is marked */
  long columns;
} km_triangle;

/* Right sides per call, in SIMD lanes. */
enum { KM_TRIANGLE_LANES = 8 };

/* True if row k + 1 has the columns of row k without its diagonal (nested rows). */
bool km_triangle_is_nested(const km_triangle *triangle, long k);

/* True if the row of row k's first column after the diagonal contains its other columns. False if some of its entries
 * came out 0. */
bool km_triangle_covers_later(const km_triangle *triangle, long k);

/* Bits per word of a set of columns. */
enum { KM_TRIANGLE_WORD = 64 };
static inline void km_triangle_mark(uint64_t *marked, long k) {
  marked[k / KM_TRIANGLE_WORD] |= (uint64_t)1 << k % KM_TRIANGLE_WORD;
}

/* sum[lane] += |R⁻ᵀ b|² for the right sides in y[columns × KM_TRIANGLE_LANES]. Columns with entries are marked; `first`
 * is the first one. y and the marks are 0 on return. O(entries of the rows that are reached). */
void km_triangle_squares(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                         double sum[KM_TRIANGLE_LANES]);

/* km_triangle_squares for one instruction set. */
void km_triangle_squares_plain(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                               double sum[KM_TRIANGLE_LANES]);
void km_triangle_squares_avx2(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                              double sum[KM_TRIANGLE_LANES]);

#endif
