/* The Jacobian of a substructure with all six rows of every loop. Private to analysis/. */
#ifndef KM_MOBILITY_FULL_JACOBIAN_H
#define KM_MOBILITY_FULL_JACOBIAN_H

#include "kinematics/state.h"

/* Six entries (v; ω) of a twist about `about`, lengths over the substructure's size, of a coordinate in units of
 * `unit`. */
static inline void km_twist_entries(const km_substructure *sub, km_twist twist, km_vec3 about, double unit,
                                    double out[6]) {
  double scale = unit / sub->size;
  km_vec3 v = km_vec3_add(twist.v, km_vec3_cross(twist.w, about));
  out[0] = v.x * scale;
  out[1] = v.y * scale;
  out[2] = v.z * scale;
  out[3] = twist.w.x;
  out[4] = twist.w.y;
  out[5] = twist.w.z;
}

/* J: six rows a loop in the order of the substructure's loops (along the inertial axes, moments about `about`), then
 * the couplings; rows = 6 · loops + couplings, by the substructure's columns. twist[coordinate] of every coordinate. */
void km_full_jacobian(const km_mechanism *mechanism, const km_state *state, int substructure, const km_twist *twist,
                      km_vec3 about, double *J);
/* The couplings' entries alone: that of coupling i and a column at first[i · down + column · across]. */
void km_coupling_entries(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub,
                         double *first, size_t down, size_t across);

#endif
