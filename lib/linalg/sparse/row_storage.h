/* Row access to a sparse matrix that is stored by column. Private to linalg/. */
#ifndef KM_LINALG_SPARSE_ROW_STORAGE_H
#define KM_LINALG_SPARSE_ROW_STORAGE_H

/* An entry of a row: its index in the matrix, and its column. */
typedef struct km_row_entry {
  int entry, column;
} km_row_entry;

/* Sorts the entries of a matrix by row; its column c has the rows row[start[c] … start[c+1]-1]. The entries of row r,
 * by column, begin at by_row[row_start[r]]. row_start[rows + 2] is 0 on entry; its last element is workspace. O(rows +
 * entries). */
void km_create_row_storage(int rows, int columns, const int *start, const int *row, int *row_start,
                           km_row_entry *by_row);

#endif
