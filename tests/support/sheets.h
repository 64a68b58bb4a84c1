/* Lattices of bars in a plane and sheets of panels, of any number of loops in one substructure, as text: drawn as
 * those of support/lattices.h. */
#ifndef KM_TESTS_SHEETS_H
#define KM_TESTS_SHEETS_H

#include "base/text.h"

/* A garden trellis: rows + 1 bars and columns + 1 bars, hinged where they cross. rows · columns loops, mobility 1: all
 * hinges but the first two rows' and columns' are redundant. */
void write_trellis(km_text *out, int rows, int columns, double away);
/* A sheet with bent bars, equal in rows and equal in columns. */
void write_bent_trellis(km_text *out, int rows, int columns);

/* A lattice of rows · columns parallelograms, each side a bar of its own, hinged at the corners: a loop for each.
 * Mobility rows + columns − 1. */
void write_grid(km_text *out, int rows, int columns);
/* A sheet with corners near those of squares. */
void write_bent_grid(km_text *out, int rows, int columns);
/* A grid of parallelograms in which each second one, as on a chessboard, has bars along both diagonals: two loops
 * for each parallelogram, mobility 1, and one constraint of each braced one is redundant besides others. */
void write_stiff_grid(km_text *out, int rows, int columns);

/* A Miura-ori of rows · columns rigid parallelograms hinged at their creases (M. Schenk, S. Guest, 2013): a loop about
 * each inner corner, with axes that meet there. Mobility 1. */
void write_miura(km_text *out, int rows, int columns, double away);
/* A flat sheet, where creases may fold either way. */
void write_flat_miura(km_text *out, int rows, int columns);
/* A wavy sheet of rows · columns · 2 triangles, hinged at their sides: a loop about each inner corner, with six axes
 * that meet there. Mobility 2 (rows + columns) − 3. */
void write_triangles(km_text *out, int rows, int columns);

#endif
