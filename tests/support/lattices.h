/* Mechanisms of any number of loops in one substructure, as text: with frames as a CAD program gives them (every joint
 * in the coordinates of the whole drawing), and anywhere in space. */
#ifndef KM_TESTS_LATTICES_H
#define KM_TESTS_LATTICES_H

#include "base/text.h"

/* `away` is how far from the inertial origin the mechanism is, in each direction. */

/* n parallelograms between n + 1 rockers: mobility 1. */
void write_drawn_chain(km_text *out, int n, double away);
/* n five-bars between n + 1 cranks: mobility n + 1. */
void write_five_bars(km_text *out, int n, double away);
/* The same with all joints on one line, each five-bar stretched between its cranks: the cranks turn, and the first one least. */
void write_flat_five_bars(km_text *out, int n);
/* A platform on n bars between spherical joints: beyond six bars n − 6 are redundant, and every bar spins. */
void write_bars(km_text *out, int n, double away);
/* A garden trellis: rows + 1 bars and columns + 1 bars, hinged where they cross. rows · columns loops, mobility 1: all
 * hinges but the first two rows' and columns' are redundant. */
void write_trellis(km_text *out, int rows, int columns, double away);
/* A Miura-ori of rows · columns rigid parallelograms hinged at their creases (M. Schenk, S. Guest, 2013): a loop about
 * each inner corner, with axes that meet there. Mobility 1. */
void write_miura(km_text *out, int rows, int columns, double away);

#endif
