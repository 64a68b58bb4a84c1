/* Chains of a spatial program over the complex numbers: poses of its slots, and displacements of its loops. Private to
 * space/. */
#ifndef KM_SPACE_COMPLEX_COMPLEX_CHAIN_H
#define KM_SPACE_COMPLEX_COMPLEX_CHAIN_H

#include "space/complex/complex_loops.h"

/* a · b */
static inline km_complex km_complex_dot(const km_complex *a, const km_complex *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* out = a × b; out may be a or b. */
static inline void km_complex_cross(const km_complex *a, const km_complex *b, km_complex *out) {
  km_complex x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  out[0] = x;
  out[1] = y;
  out[2] = z;
}

/* Computes the poses of a program's slots, c->slot, the unit twists of its steps, c->twist, and the displacements and
 * errors of its loops, c->displacement. The twists of a ball are rotations about the axes of the frame before it. */
void km_complex_compute_chains(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               const km_complex_values *out);
/* out = R a, R by columns; out may be a. */
void km_complex_rotate(km_complex (*R)[3], const km_complex *a, km_complex *out);
/* out = X · Y for a real pose Y; out may be X. */
void km_complex_pose_product(km_complex_pose *X, const km_pose *Y, bool has_rotation, km_complex_pose *out);

/* Chooses the hubs of the ball joints that are not locked. */
void km_complex_choose_hubs(km_complex_closure *c, const km_state *state, km_arena *arena);
/* Angular velocity of the hub of the ball at `column`, along the axes of the frame before the ball. */
void km_complex_hub_velocity(const km_complex_closure *c, int column, const km_wide *x, const km_complex *rates,
                             km_complex *w);
/* Real quaternions, relative to the frame before the ball at `column`: of its hub, if x has that of the ball's own
 * body, and of the ball's own body, if x has that of the hub. */
km_quaternion km_complex_hub_quaternion(const km_complex_closure *c, int column, const km_wide *x);
km_quaternion km_complex_ball_quaternion(const km_complex_closure *c, int column, const km_wide *x);

#endif
