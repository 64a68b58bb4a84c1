/* Which of many things on a page lie about a place: a grid of cells, each with those whose frames meet it. Private to
 * drawing/. */
#ifndef KM_REPORT_DRAWING_PAGE_GRID_H
#define KM_REPORT_DRAWING_PAGE_GRID_H

#include "report/drawing/drawing_parts.h"

typedef struct km_grid {
  double left, top, cell; /* size of a cell */
  int columns, rows;
  int *first, *item; /* [cells + 1] into the items */
  unsigned *seen;    /* [count] the last question that met an item */
  unsigned question;
  int left_cell, right_cell, bottom_cell; /* those that the question asks about */
  int row, column, next, end;             /* where it stands: the cell's items to come are item[next … end-1] */
} km_grid;

/* Of `count` things that lie within frames; what lies off `place` counts to the cells at its edge. False when out of
 * memory. */
bool km_grid_make(km_grid *grid, km_rectangle place, double cell, const km_rectangle *frames, size_t count,
                  km_arena *arena);

/* Asks which things may meet a frame. Then each call gives the number of another one; -1: there are no more. */
void km_grid_ask(km_grid *grid, km_rectangle frame);
int km_grid_next(km_grid *grid);

#endif
