/* A grid of cells over a page. */
#include "report/drawing/page_grid.h"

enum { MOST_CELLS = 256 /* number of cells in each direction */ };

/* The cells that a frame meets. */
typedef struct span {
  int left, right, top, bottom;
} span;

static int cell_at(double place, double start, double cell, int count) {
  double at = floor((place - start) / cell);
  return (int)fmin(fmax(at, 0.0), (double)(count - 1)); /* cell of a coordinate; 0 for NaN */
}

static span cells_of(const km_grid *g, const km_rectangle *frame) {
  return (span){cell_at(frame->left, g->left, g->cell, g->columns),
                cell_at(frame->left + frame->width, g->left, g->cell, g->columns),
                cell_at(frame->top, g->top, g->cell, g->rows),
                cell_at(frame->top + frame->height, g->top, g->cell, g->rows)};
}

static void count_cells(km_grid *g, const km_rectangle *frames, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    span s = cells_of(g, &frames[i]);
    for (int row = s.top; row <= s.bottom; ++row)
      for (int column = s.left; column <= s.right; ++column)
        g->first[row * g->columns + column + 2]++;
  }
}

/* First[cell + 1] is where the next item of a cell goes, and ends up where the cell's items end. */
static void fill_cells(km_grid *g, const km_rectangle *frames, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    span s = cells_of(g, &frames[i]);
    for (int row = s.top; row <= s.bottom; ++row)
      for (int column = s.left; column <= s.right; ++column)
        g->item[g->first[row * g->columns + column + 1]++] = (int)i;
  }
}

bool km_grid_make(km_grid *g, km_rectangle place, double cell, const km_rectangle *frames, size_t count,
                  km_arena *arena) {
  *g = (km_grid){.left = place.left, .top = place.top, .cell = cell};
  g->columns = 1 + (int)fmin(fmax(place.width / cell, 0.0), MOST_CELLS);
  g->rows = 1 + (int)fmin(fmax(place.height / cell, 0.0), MOST_CELLS);
  int cells = g->columns * g->rows;
  g->first = KM_ARENA_NEW(arena, int, (size_t)cells + 2);
  g->seen = KM_ARENA_NEW(arena, unsigned, count);
  if (arena->failed)
    return false;
  count_cells(g, frames, count);
  for (int i = 0; i < cells; ++i)
    g->first[i + 2] += g->first[i + 1];
  g->item = KM_ARENA_NEW(arena, int, (size_t)g->first[cells + 1]);
  if (arena->failed)
    return false;
  fill_cells(g, frames, count);
  return true;
}

static void enter_cell(km_grid *g) {
  int cell = g->row * g->columns + g->column;
  g->next = g->first[cell];
  g->end = g->first[cell + 1];
}

void km_grid_query(km_grid *g, km_rectangle frame) {
  span s = cells_of(g, &frame);
  g->left_cell = g->column = s.left;
  g->right_cell = s.right;
  g->bottom_cell = s.bottom;
  g->row = s.top;
  g->question++;
  enter_cell(g);
}

/* False behind the last one. */
static bool next_cell(km_grid *g) {
  bool ends = g->column == g->right_cell;
  g->column = ends ? g->left_cell : g->column + 1;
  g->row += ends;
  if (g->row > g->bottom_cell)
    return false;
  enter_cell(g);
  return true;
}

int km_grid_next(km_grid *g) {
  do {
    while (g->next < g->end) {
      int item = g->item[g->next++];
      if (g->seen[item] != g->question) {
        g->seen[item] = g->question;
        return item;
      }
    }
  } while (next_cell(g));
  return -1;
}
