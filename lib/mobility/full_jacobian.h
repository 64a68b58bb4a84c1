/* Jacobian of a substructure with all six rows of every loop. Private to the library. */
#ifndef KM_MOBILITY_FULL_JACOBIAN_H
#define KM_MOBILITY_FULL_JACOBIAN_H

#include "kinematics/state.h"

/* Computes the six entries (v; ω) of a coordinate's twist with the reference point `about`: lengths over the
 * substructure's size, the coordinate in units of `unit`. */
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

/* Computes J: six rows per loop in the order of the substructure's loops (inertial axes, moments about `about`), then
 * the couplings; rows = 6 · loops + couplings. The entry of a row and a column is J[row · row_stride + column ·
 * column_stride]. twist[coordinate] of every coordinate. */
void km_full_jacobian(const km_mechanism *mechanism, const km_state *state, int substructure, const km_twist *twist,
                      km_vec3 about, size_t row_stride, size_t column_stride, double *J);

#endif
