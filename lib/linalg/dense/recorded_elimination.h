/* The operations that a partition's pivots take on matrices of one pattern, as a list: several matrices side by side
 * replay it without a decision. */
#ifndef KM_LINALG_DENSE_RECORDED_ELIMINATION_H
#define KM_LINALG_DENSE_RECORDED_ELIMINATION_H

#include "linalg/partition.h"

/* Places are (column · rows + row) · stride in the matrix, row · stride in a right side: for numbers that are `stride`
 * doubles apart. */

/* One step of Gauss-Jordan elimination. */
typedef struct km_recorded_elimination_step {
  int pivot;        /* place */
  int scale_count;  /* entries of its column that are divided by it, from `scales` in turn */
  int update_count; /* of the matrix, from `updates` in turn */
} km_recorded_elimination_step;

/* x −= l·u. */
typedef struct km_recorded_elimination_update {
  int x, l, u;
} km_recorded_elimination_update;

typedef struct km_recorded_elimination {
  int rank, row_count, column_count, stride;
  km_recorded_elimination_step *steps;         /* [rank] */
  int *scales;                                 /* places in the matrix, of all steps */
  km_recorded_elimination_update *updates;     /* x, l, u in the matrix */
  km_recorded_elimination_update *rhs_updates; /* [turn_count] x, u in a right side, l in the matrix */
  int rhs_update_count;
  int *fill; /* [fill_count] places that hold something else than 0 only after elimination */
  int fill_count;
  int *row, *column; /* of the pivots, then the independent columns, as in the partition */
  bool *reduced;     /* [rows × columns] pattern of the reduced matrix */
} km_recorded_elimination;

/* Space for lists of matrices of this size: O(rows · columns · rank). False when out of memory. */
bool km_recorded_elimination_reserve(km_recorded_elimination *replay, int rows, int columns, int stride,
                                     km_arena *arena);
/* The list for the pivots of a dense partition. `used`[rows × columns, column-major]: can the entry be other than 0? Leaving
 * out what is 0 changes no value: x − l·0 = x. O(rows·columns·rank). */
void km_recorded_elimination_record(km_recorded_elimination *replay, const km_partition *partition, const bool *used);
/* Is it the list for these pivots? */
bool km_recorded_elimination_matches(const km_recorded_elimination *replay, const km_partition *partition);

#endif
