/* The operations that a partition's pivots take on matrices of one pattern, as a list: several matrices side by side
 * replay it without a decision. */
#ifndef KM_LINALG_DENSE_RECORDED_ELIMINATION_H
#define KM_LINALG_DENSE_RECORDED_ELIMINATION_H

#include "linalg/partition.h"

/* Places are (column · rows + row) · stride in the matrix, row · stride in a right side: for numbers that are `stride`
 * doubles apart. */

/* One step of Gauss-Jordan elimination. */
typedef struct km_replay_step {
  int pivot;        /* place */
  int scale_count;  /* entries of its column that are divided by it, from `scales` in turn */
  int update_count; /* of the matrix, from `updates` in turn */
} km_replay_step;

/* x −= l·u. */
typedef struct km_replay_update {
  int x, l, u;
} km_replay_update;

typedef struct km_replay {
  int rank, row_count, column_count, stride;
  km_replay_step *steps;     /* [rank] */
  int *scales;               /* places in the matrix, of all steps */
  km_replay_update *updates; /* x, l, u in the matrix */
  km_replay_update *turns;   /* [turn_count] x, u in a right side, l in the matrix */
  int turn_count;
  int *fill; /* [fill_count] places that hold something else than 0 only after elimination */
  int fill_count;
  int *row, *column; /* of the pivots, then the independent columns, as in the partition */
  bool *reduced;     /* [rows × columns] pattern of the reduced matrix */
} km_replay;

/* Space for lists of matrices of this size: O(rows · columns · rank). False when out of memory. */
bool km_replay_reserve(km_replay *replay, int rows, int columns, int stride, km_arena *arena);
/* The list for the pivots of a dense partition. `used`[rows × columns, column-major]: can the entry be other than 0? Leaving
 * out what is 0 changes no value: x − l·0 = x. O(rows·columns·rank). */
void km_replay_make(km_replay *replay, const km_partition *partition, const bool *used);
/* Is it the list for these pivots? */
bool km_replay_fits(const km_replay *replay, const km_partition *partition);

#endif
