/* Grid of cells for neighbour search on a page: each cell lists the frames that intersect it. Private to
 * report/drawing/. */
#ifndef KM_REPORT_DRAWING_PAGE_GRID_H
#define KM_REPORT_DRAWING_PAGE_GRID_H

#include "report/drawing/drawing_parts.h"

typedef struct km_grid {
  double left, top, cell; /* size of a cell */
  int columns, rows;
  int *first, *item; /* [cells + 1] into the items */
  unsigned *seen;    /* [count] the last question that met an item */
  unsigned question;
  int left_cell, right_cell, bottom_cell; /* frames that intersect the query */
  int row, column, next, end;             /* state of the iteration: remaining items of the cell are item[next …
                                           * end-1] */
} km_grid;

/* Builds the grid of `count` frames; frames outside the page are assigned to the cells at its edge. False when out
 * of memory. */
bool km_grid_make(km_grid *grid, km_rectangle place, double cell, const km_rectangle *frames, size_t count,
                  km_arena *arena);

/* Starts a query of the frames that may intersect a given frame. Each further call returns another index; −1 at the
 * end. */
void km_grid_query(km_grid *grid, km_rectangle frame);
int km_grid_next(km_grid *grid);

#endif
