/* Lattices of bars, and sheets of panels. */
#include "support/sheets.h"

#include "base/random.h"
#include "support/hinges.h"

#include <stdlib.h>

/* The crossing of row i and column k is the sum of a place of row bars and of one of column bars. */
static void lay_trellis(km_text *out, int rows, int columns, double away, double bend) {
  hinges h = {0};
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k <= columns; ++k) {
      double x = k + 0.3 * i + bend * sin(2.0 * i), y = 1.1 * i + bend * cos(3.0 * k);
      hinges_pin(&h, i, 1 + rows + k, x, y);
    }
  hinges_write(&h, out, away);
}

void write_trellis(km_text *out, int rows, int columns, double away) {
  lay_trellis(out, rows, columns, away, 0.0);
}

void write_bent_trellis(km_text *out, int rows, int columns) {
  lay_trellis(out, rows, columns, 0.0, 0.2);
}

/* Where bars meet, and the bar that came there last; -1: none has. */
typedef struct corner {
  double x, y;
  int last;
} corner;

/* Bars that are hinged to each other at their ends. */
typedef struct truss {
  hinges h;
  int columns, bars;
  corner *corners;
} truss;

/* Corners of parallelograms, moved by up to `bend` in each direction. */
static truss truss_of(int rows, int columns, double bend) {
  uint64_t seed = 1;
  truss t = {.columns = columns, .corners = malloc((size_t)((rows + 1) * (columns + 1)) * sizeof *t.corners)};
  if (!t.corners)
    abort();
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k <= columns; ++k) {
      corner *c = &t.corners[i * (columns + 1) + k];
      c->x = k + 0.3 * i + bend * km_uniform(&seed);
      c->y = 1.1 * i + bend * km_uniform(&seed);
      c->last = -1;
    }
  return t;
}

/* A bar comes to the corner of row i and column k, and is hinged to the one before it. */
static void meet(truss *t, int i, int k) {
  corner *c = &t->corners[i * (t->columns + 1) + k];
  if (c->last >= 0)
    hinges_pin(&t->h, c->last, t->bars, c->x, c->y);
  c->last = t->bars;
}

static void add_bar(truss *t, int i1, int k1, int i2, int k2) {
  meet(t, i1, k1);
  meet(t, i2, k2);
  ++t->bars;
}

static void lay_grid(km_text *out, int rows, int columns, double bend, bool stiff) {
  truss t = truss_of(rows, columns, bend);
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k <= columns; ++k) {
      if (k < columns)
        add_bar(&t, i, k, i, k + 1);
      if (i < rows)
        add_bar(&t, i, k, i + 1, k);
      if (stiff && i < rows && k < columns && (i + k) % 2 == 0) {
        add_bar(&t, i, k, i + 1, k + 1);
        add_bar(&t, i, k + 1, i + 1, k);
      }
    }
  free(t.corners);
  hinges_write(&t.h, out, 0.0);
}

void write_grid(km_text *out, int rows, int columns) {
  lay_grid(out, rows, columns, 0.0, false);
}

void write_bent_grid(km_text *out, int rows, int columns) {
  lay_grid(out, rows, columns, 0.15, false);
}

void write_stiff_grid(km_text *out, int rows, int columns) {
  lay_grid(out, rows, columns, 0.0, true);
}

/* The corner of row i and column k: sides 1, angle 60 degrees. */
static km_vec3 fold_at(int i, int k, double fold) {
  const double angle = M_PI / 3.0;
  double t = cos(fold) * tan(angle), root = sqrt(1.0 + t * t), s = sin(fold) * sin(angle);
  return (km_vec3){k * t / root, i * sqrt(1.0 - s * s) + (k % 2) / root, (i % 2) * s};
}

static void crease(hinges *h, int panel1, int panel2, km_vec3 from, km_vec3 to) {
  hinges_add(h, "Rz", panel1, panel2, from, km_vec3_sub(to, from));
}

static void lay_miura(km_text *out, int rows, int columns, double away, double fold) {
  hinges h = {0};
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      int panel = i * columns + k;
      if (i > 0)
        crease(&h, panel - columns, panel, fold_at(i, k, fold), fold_at(i, k + 1, fold));
      if (k > 0)
        crease(&h, panel - 1, panel, fold_at(i, k, fold), fold_at(i + 1, k, fold));
    }
  hinges_write(&h, out, away);
}

void write_miura(km_text *out, int rows, int columns, double away) {
  lay_miura(out, rows, columns, away, 0.9);
}

void write_flat_miura(km_text *out, int rows, int columns) {
  lay_miura(out, rows, columns, 0.0, 0.0);
}

static km_vec3 wave(int i, int k) {
  return (km_vec3){k, i, 0.3 * sin(2.0 * i + 5.0 * k)};
}

/* The triangle of a square at its corner i,k+1 is even, the one at i+1,k odd. */
void write_triangles(km_text *out, int rows, int columns) {
  hinges h = {0};
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      int panel = 2 * (i * columns + k);
      crease(&h, panel, panel + 1, wave(i, k), wave(i + 1, k + 1));
      if (i > 0)
        crease(&h, panel - 2 * columns + 1, panel, wave(i, k), wave(i, k + 1));
      if (k > 0)
        crease(&h, panel - 2, panel + 1, wave(i, k), wave(i + 1, k));
    }
  hinges_write(&h, out, 0.0);
}
