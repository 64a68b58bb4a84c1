/* Rods between two ball joints, held from spinning about their axes (docs/theory.md 4.19).
 *
 *   d, m: the rod's axis and a direction across it, fixed in the rod;   c, a, b: axes of the body at one end, c = a × b
 *   t_a = a − (a·d) / (1 + c·d) (c + d):   a, turned by the least angle that takes c to d; t_b the same
 *   τ   = atan2(m·t_b, m·t_a)
 *   dτ  = g·ω,   g = (c + d) / (1 + c·d),   ω of the rod, all in that body
 *
 * A spin by α changes τ by α and no closure error. So τ = 0 is a further condition that excludes no place of another
 * body; it is singular only where the rod points against c, and every such condition is so somewhere. c: the axis of
 * the body's first hinge in the sense in which the rod begins, so that rods in a plane stay across it; without a hinge,
 * the rod's first direction. */
#ifndef KM_SPACE_ROD_SPIN_H
#define KM_SPACE_ROD_SPIN_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

typedef struct km_rod_spin {
  int body, joint[2];    /* the rod, or one of the bodies that spin together; ball joints at its ends */
  int ball, coordinate;  /* joint[0] has these */
  double sense[2];       /* 1: the rod is that joint's second body */
  km_quaternion inverse; /* Q₀*, Q the ball joint's quaternion */
  km_vec3 a, b, c;       /* in the joint's parent frame where it began */
  km_vec3 d, m;
} km_rod_spin;

/* Describes a passive freedom at the state's configuration, with its poses. False if it isn't the spin of a rod. */
bool km_rod_spin_create(const km_mechanism *mechanism, const km_state *state, const km_passive_freedom *freedom,
                        km_rod_spin *out);
/* τ in [−π, π], and g. */
double km_rod_spin_angle(const km_rod_spin *rod, const km_state *state, km_vec3 *gradient);
/* Spins the rod to τ = 0. */
void km_rod_spin_reset(const km_rod_spin *rod, const km_mechanism *mechanism, km_state *state);

#endif
