/* Rods between two ball joints, held from spinning about their axes (docs/theory.md 4.19).
 *
 *   P = Q Q₀*,  Q: quaternion of the ball joint at one end, Q₀ where it began;   (w; v) = P
 *   τ = 2 atan2(v·d, w)                                  turn of P about d, the rod's axis where it began
 *   g = (w² d + w v × d + (v·d) v) / (w² + (v·d)²)       dτ = g·ω,   ω the angular velocity in the parent frame
 *
 * A spin by α changes τ by ±α and no closure error. So τ = 0 is a further condition that excludes no place of another
 * body; it is singular only where the rod points against its first direction. */
#ifndef KM_SPACE_ROD_SPIN_H
#define KM_SPACE_ROD_SPIN_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

typedef struct km_rod_spin {
  int body, joint[2];    /* the rod, or one of the bodies that spin together; ball joints at its ends */
  int ball, coordinate;  /* joint[0] has these */
  double sense[2];       /* 1: the rod is that joint's second body */
  km_quaternion inverse; /* Q₀* */
  km_vec3 axis;          /* d, in the joint's parent frame */
} km_rod_spin;

/* Describes a passive freedom at the state's configuration, with its poses. False if it isn't the spin of a rod. */
bool km_rod_spin_create(const km_mechanism *mechanism, const km_state *state, const km_passive_freedom *freedom,
                        km_rod_spin *out);
/* τ in [−π, π], and g. */
double km_rod_spin_angle(const km_rod_spin *rod, const km_state *state, km_vec3 *gradient);
/* Spins the rod to τ = 0. */
void km_rod_spin_reset(const km_rod_spin *rod, const km_mechanism *mechanism, km_state *state);

#endif
