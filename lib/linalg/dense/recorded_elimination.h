/* Recorded elimination: the operations of Gauss-Jordan elimination with known pivots on one pattern, as a list that
 * several matrices in SIMD lanes replay without decisions (docs/theory.md 3.8). */
#ifndef KM_LINALG_DENSE_RECORDED_ELIMINATION_H
#define KM_LINALG_DENSE_RECORDED_ELIMINATION_H

#include "linalg/factor_private.h"

/* Positions are (column · rows + row) · stride in the matrix and row · stride in a right side, for numbers that are
 * `stride` doubles apart. */

/* One step of Gauss-Jordan elimination. */
typedef struct km_recorded_elimination_step {
  int pivot;        /* position of the pivot */
  int scale_count;  /* entries of its column that are divided by it, next in `scales` */
  int update_count; /* updates of the matrix, next in `updates` */
} km_recorded_elimination_step;

/* x <- x − l u, by positions. */
typedef struct km_recorded_elimination_update {
  int x, l, u;
} km_recorded_elimination_update;

typedef struct km_recorded_elimination {
  int rank, row_count, column_count, stride;
  km_recorded_elimination_step *steps;         /* [rank] */
  int *scales;                                 /* positions in the matrix, of all steps */
  km_recorded_elimination_update *updates;     /* x, l, u in the matrix */
  km_recorded_elimination_update *rhs_updates; /* [rhs_update_count] x, u in a right side, l in the matrix */
  int rhs_update_count;
  int *fill; /* [fill_count] positions of fill-in */
  int fill_count;
  int *row, *column; /* rows and columns in the partition's order */
  bool *reduced;     /* [rows × columns] pattern of the reduced matrix */
} km_recorded_elimination;

/* Reserves lists for matrices of this size: O(rows · columns · rank). False when out of memory. */
bool km_recorded_elimination_reserve(km_recorded_elimination *recorded, int rows, int columns, int stride,
                                     km_arena *arena);
/* Records the elimination by the pivots of a dense partition. `used`[rows × columns, column-major]: the entry can be
 * non-zero. Skipping structural zeros changes no value: x − l 0 = x. O(rows · columns · rank). */
void km_recorded_elimination_record(km_recorded_elimination *recorded, const km_factor *partition, const bool *used);
/* True if the list belongs to the partition's pivots. */
bool km_recorded_elimination_matches(const km_recorded_elimination *recorded, const km_factor *partition);

#endif
