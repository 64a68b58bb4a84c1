/* The operations that a partition's pivots take on matrices of one pattern, as a list: several matrices side by side
 * replay it without a decision. */
#ifndef KM_PARTITION_REPLAY_H
#define KM_PARTITION_REPLAY_H

#include "partition/partition.h"

/* One step of Gauss-Jordan elimination. Places are column · rows + row. */
typedef struct km_replay_step {
  int pivot, row;                 /* place and row of the pivot */
  int target_start, target_count; /* rows that lose a multiple of the pivot's, into `rows` */
  int column_start, column_count; /* columns behind the pivot's that have an entry in its row: their first places, into
                                    * `columns` */
} km_replay_step;

typedef struct km_replay {
  int rank, row_count, column_count;
  km_replay_step *steps; /* [rank] */
  int *rows, *columns;
  int *fill; /* [fill_count] places that hold something else than 0 only after elimination */
  int fill_count;
  int *row, *column; /* of the pivots, then the independent columns, as in the partition */
  bool *reduced;     /* [rows × columns] pattern of the reduced matrix */
} km_replay;

/* Space for lists of matrices of this size. False when out of memory. */
bool km_replay_reserve(km_replay *replay, int rows, int columns, km_arena *arena);
/* The list for the pivots of a dense partition. `used`[rows × columns, column-major]: can the entry be other than 0? Leaving
 * out what is 0 changes no value: x − l·0 = x. O(rows·columns·rank). */
void km_replay_make(km_replay *replay, const km_partition *partition, const bool *used);
/* Is it the list for these pivots? */
bool km_replay_fits(const km_replay *replay, const km_partition *partition);

#endif
