/* An upper triangle with few entries, as Q R of large matrices leaves it. Private to partition/. */
#ifndef KM_LINALG_SPARSE_TRIANGULAR_SOLVE_H
#define KM_LINALG_SPARSE_TRIANGULAR_SOLVE_H

#include <stdbool.h>
#include <stdint.h>

/* R by rows: of row k the entries from start[k] on, by column, that of the diagonal first. */
typedef struct km_triangle {
  const long *start, *column;
  const double *value;
  const bool *is_nested;    /* [columns] by km_triangle_is_nested: such rows go together */
  const bool *covers_later; /* [columns] by km_triangle_covers_later: of such rows the first column alone is marked */
  long columns;
} km_triangle;

/* So many vectors go side by side. */
enum { KM_TRIANGLE_LANES = 8 };

/* Has the row behind row k the same columns, without row k's diagonal? */
bool km_triangle_is_nested(const km_triangle *triangle, long k);

/* Has the row of row k's first column behind the diagonal the others too? Not where some of its entries came out 0. */
bool km_triangle_covers_later(const km_triangle *triangle, long k);

/* A set of columns, a bit each. */
enum { KM_TRIANGLE_WORD = 64 };
static inline void km_triangle_mark(uint64_t *marked, long k) {
  marked[k / KM_TRIANGLE_WORD] |= (uint64_t)1 << k % KM_TRIANGLE_WORD;
}

/* Adds |R⁻ᵀ b|² of vectors b side by side, which y[columns × KM_TRIANGLE_LANES] holds. Their entries are marked; `first` is the first
 * column of them. 0 is left in y, and no mark. O(entries of the rows that they reach). */
void km_triangle_squares(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                         double sum[KM_TRIANGLE_LANES]);

/* The same for one instruction set. */
void km_triangle_squares_plain(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                               double sum[KM_TRIANGLE_LANES]);
void km_triangle_squares_avx2(const km_triangle *triangle, long first, double *y, uint64_t *marked,
                              double sum[KM_TRIANGLE_LANES]);

#endif
