/* Chains of a spatial program over the complex numbers (complex_chain.h).
 *
 *   X_to = X_from · before · exp(h q),   h = (p × a; a), (a; 0), or the three of a ball (docs/theory.md 2.1)
 *   a ball at X_b = X_from · before, with the displacement T of the hinges and slides from it to its hub:
 *     R_hub = R_b R(Q),   p_hub = p_b + R_hub T_Rᵀ T_p,   X_to = (R_hub T_Rᵀ, p_b)
 *   E = X_a X_b⁻¹;  errors: E(o) − o and 2 g,  g = tan(θ/2) axis = vee(R − Rᵀ) / (1 + tr R),  R = E_R Gᵀ
 *
 * The hub is the body behind the ball where most chains meet. T has parts of 1e5 beside a pole: with the rotation of
 * the ball's own body as the unknown, the rounding of T would pass to the hub and all chains there. Products of vectors
 * have no conjugate, so the transpose inverts a rotation. */
#include "space/complex/complex_chain.h"

#include "model/joint_type.h"
#include "spatial/rotation.h"

#include <tgmath.h>

#define NUMBER    km_complex
#define REAL      double
#define POSE      km_complex_pose
#define OF(name)  double_##name
#define NUMBER_OF km_complex_of
#include "space/complex/chain_body.h"
#undef NUMBER
#undef REAL
#undef POSE
#undef OF
#undef NUMBER_OF

#define NUMBER    km_wide
#define REAL      long double
#define POSE      km_wide_pose
#define OF(name)  wide_##name
#define NUMBER_OF km_wide_of
#include "space/complex/chain_body.h"

void km_complex_compute_chains(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               const km_complex_values *out) {
  if (out->is_narrow) {
    double_compute_chains(c, program, x, out, c->slot);
    return;
  }
  wide_compute_chains(c, program, x, out, c->wide_slot);
  for (int i = 0; i < program->slot_count; ++i) {
    wide_narrow(c->wide_slot[i].p, c->slot[i].p);
    for (int k = 0; k < 3; ++k)
      wide_narrow(c->wide_slot[i].R[k], c->slot[i].R[k]);
  }
}

void km_complex_rotate(km_complex (*R)[3], const km_complex *a, km_complex *out) {
  double_rotate(R, a, out);
}

void km_complex_pose_product(km_complex_pose *X, const km_pose *Y, bool has_rotation, km_complex_pose *out) {
  double_pose_product(X, Y, has_rotation, out);
}

void km_complex_hub_velocity(const km_complex_closure *c, int column, const km_wide *x, const km_complex *rates,
                             km_complex *w) {
  const km_complex_hub *hub = &c->hub[column];
  for (int k = 0; k < 3; ++k)
    w[k] = c->unknown_of[column + k] >= 0 ? rates[c->unknown_of[column + k]] : 0.0;
  if (hub->count == 0)
    return;
  km_complex relative[3] = {0.0, 0.0, 0.0}, own[3], Q[3][3];
  km_complex_pose T = double_hub_displacement(c, hub, x, rates, relative);
  double_ball_rotation(c, column, x, Q);
  double_rotate_back(T.R, relative, own);
  double_rotate(Q, own, relative);
  for (int k = 0; k < 3; ++k)
    w[k] += relative[k];
}

/* Real quaternion of R(Q) T_R, or of R(Q) T_Rᵀ if `back`. */
static km_quaternion turn_along_chain(const km_complex_closure *c, int column, const km_wide *x, bool back) {
  km_complex_pose T = double_hub_displacement(c, &c->hub[column], x, NULL, NULL);
  km_complex Q[3][3], row[3], axis[3];
  km_rotation R;
  double_ball_rotation(c, column, x, Q);
  for (int k = 0; k < 3; ++k) {
    double_row(T.R, k, row);
    double_rotate(Q, back ? row : T.R[k], axis);
    R.axis[k] = (km_vec3){creal(axis[0]), creal(axis[1]), creal(axis[2])};
  }
  return km_rotation_quaternion(&R);
}

km_quaternion km_complex_hub_quaternion(const km_complex_closure *c, int column, const km_wide *x) {
  return turn_along_chain(c, column, x, false);
}

km_quaternion km_complex_ball_quaternion(const km_complex_closure *c, int column, const km_wide *x) {
  return turn_along_chain(c, column, x, true);
}
