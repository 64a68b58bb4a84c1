/* Row access by counting sort. */
#include "linalg/sparse/row_storage.h"

/* While entries are placed, row_start[r + 1] is the next free index of row r. */
void km_create_row_storage(int rows, int columns, const int *start, const int *row, int *row_start,
                           km_row_entry *by_row) {
  for (int i = 0; i < start[columns]; ++i)
    row_start[row[i] + 2]++;
  for (int r = 0; r < rows; ++r)
    row_start[r + 2] += row_start[r + 1];
  for (int c = 0; c < columns; ++c)
    for (int i = start[c]; i < start[c + 1]; ++i)
      by_row[row_start[row[i] + 1]++] = (km_row_entry){i, c};
}
