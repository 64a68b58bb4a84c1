/* An upper triangle with few entries, as Q R of large matrices leaves it. Private to partition/. */
#ifndef KM_PARTITION_TRIANGLE_H
#define KM_PARTITION_TRIANGLE_H

#include <stdbool.h>

/* R by rows: of row k the entries from start[k] on, by column, that of the diagonal first. */
typedef struct km_triangle {
  const long *start, *column;
  const double *value;
  const bool *continues; /* [columns] by km_triangle_continues: such rows go together */
  long columns;
} km_triangle;

/* So many vectors go side by side. */
enum { KM_TRIANGLE_LANES = 4 };

/* Has the row behind row k the same columns, without row k's diagonal? */
bool km_triangle_continues(const km_triangle *triangle, long k);

/* Adds |R⁻ᵀ b|² of vectors b side by side, which y[columns × KM_TRIANGLE_LANES] holds from column `first` on; 0 is left there. */
void km_triangle_squares(const km_triangle *triangle, long first, double *y, double sum[KM_TRIANGLE_LANES]);

#endif
