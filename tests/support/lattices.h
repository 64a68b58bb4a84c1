/* Mechanisms of any number of loops in one substructure, as text: with frames as a CAD program gives them
 * (support/hinges.h). Where there is `away`, it is how far from the inertial origin the mechanism is, in each
 * direction. */
#ifndef KM_TESTS_LATTICES_H
#define KM_TESTS_LATTICES_H

#include "base/text.h"

/* n parallelograms between n + 1 rockers: mobility 1. */
void write_drawn_chain(km_text *out, int n, double away);
/* A chain with all joints on one line: each parallelogram continues as such or crossed. */
void write_folded_chain(km_text *out, int n);
/* n five-bars between n + 1 cranks: mobility n + 1. */
void write_five_bars(km_text *out, int n, double away);
/* A chain with all joints on one line, each five-bar stretched between its cranks: the cranks rotate, the first one
 * least. */
void write_flat_five_bars(km_text *out, int n);
/* A chain with each five-bar stretched on a line of its own. */
void write_stretched_five_bars(km_text *out, int n);
/* n four-bars in space between n + 1 cranks, whose hinges point anywhere; each coupler has a spherical joint at both
 * ends and spins. Mobility n + 1. */
void write_ball_couplers(km_text *out, int n);
/* A chain with spherical joints at the cranks. Mobility 3 n + 3. */
void write_balls(km_text *out, int n);
/* A platform on n bars between spherical joints: beyond six bars n − 6 are redundant, and every bar spins. */
void write_bars(km_text *out, int n, double away);

#endif
