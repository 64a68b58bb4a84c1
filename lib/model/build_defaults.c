/* Default definitions of elements. */
#include "kmech/build.h"

#include <math.h>

km_settings_def km_settings_default(void) {
  return (km_settings_def){
      .angle = "radians", .length = "meters", .mass = "kilograms", .time = "seconds", .force = "newtons"};
}

km_frame_def km_frame_default(void) {
  return (km_frame_def){.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

km_body_def km_body_default(void) {
  return (km_body_def){.density = -1.0}; /* < 0: mass and inertia are given instead of a density */
}

km_shape_def km_shape_default(void) {
  return (km_shape_def){.kind = KM_SHAPE_SPHERE,
                        .scale = {1, 1, 1},
                        .R = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                        .density = -1.0, /* < 0: drawn only, without mass */
                        .color = {0, 0, 0, -1.0}};
}

km_joint_def km_joint_default(void) {
  km_joint_def def = {.type = KM_RZ}; /* revolute joint of a planar mechanism in the x, y plane */
  for (int k = 0; k < KM_MAX_FREEDOM; ++k) {
    def.low[k] = -HUGE_VAL;
    def.high[k] = HUGE_VAL;
    def.max_rate[k] = HUGE_VAL;
    def.max_force[k] = HUGE_VAL;
  }
  return def;
}

km_force_def km_force_default(void) {
  return (km_force_def){.type = KM_MODULE_STIFFNESS, .distance = KM_DISTANCE_EUCLID};
}

km_sweep_def km_sweep_default(void) {
  return (km_sweep_def){.sign = 1.0, .steps = 100};
}
