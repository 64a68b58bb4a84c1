/* The entries of a sparse matrix by row, where it is stored by column. Private to partition/. */
#ifndef KM_LINALG_SPARSE_ROW_STORAGE_H
#define KM_LINALG_SPARSE_ROW_STORAGE_H

/* An entry of a row: which one of the matrix, and in which column. */
typedef struct km_row_entry {
  int entry, column;
} km_row_entry;

/* Of a matrix whose column c has the rows row[start[c] … start[c+1]-1]: the entries of row r, by column, from
 * by_row[row_start[r]] on. row_start[rows + 2] is 0 before; its last number is room to work in. O(rows + entries). */
void km_create_row_storage(int rows, int columns, const int *start, const int *row, int *row_start,
                           km_row_entry *by_row);

#endif
