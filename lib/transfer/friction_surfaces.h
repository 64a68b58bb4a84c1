/* Friction surfaces of joints: slip arms, slip speeds and normal forces (theory 8.5). Private to the library. */
#ifndef KM_TRANSFER_FRICTION_SURFACES_H
#define KM_TRANSFER_FRICTION_SURFACES_H

#include "statics/statics.h"

/* A surface on which a coordinate's friction acts. A hinge has two at the friction radius: its journal, loaded by the
 * force across the axis, and its collar, loaded by the thrust along it. */
typedef struct km_surface {
  int coordinate;
  bool is_collar;
} km_surface;

/* Lists the surfaces of all free coordinates with a coefficient of friction: out[2 × coordinates]. Returns their
 * number. */
int km_surfaces_list(const km_mechanism *mechanism, km_surface *out);

/* Returns the slip per unit of a coordinate: the friction radius; for a thread its helix at that radius; 1 for a
 * slide; 0 without a radius. */
double km_slip_arm(const km_mechanism *mechanism, int coordinate);

/* Returns the slip speed of a coordinate's surfaces at rates[coordinate]. The coordinates of a ball joint, of a
 * planar joint's slides and of a cylindrical joint share one slip direction. */
double km_slip_speed(const km_mechanism *mechanism, const double *rates, int coordinate);

/* Returns the tangent of a thread's lead angle λ, pitch / (2π r); 0 for other joints. */
double km_thread_slope(const km_mechanism *mechanism, int coordinate);
km_vec3 km_surface_axis(const km_statics *statics, int coordinate);

/* Returns the load of a surface from the joint's last reaction F (KM_AXES_FIXED), without a thread's own friction.
 * Journals and slides: F across the axis; collars: F along it; ball joints: F; planar joints: F along the normal;
 * threads: F with its axial part over cos λ. Linear in F. */
km_vec3 km_surface_load(const km_mechanism *mechanism, const km_statics *statics, const km_surface *surface);

/* Returns the normal force N ≥ 0 under a load v with friction ±μ N against the slip. A thread's friction has an axial
 * part, so that N = |v + μ tan λ N axis|. Infinite: the thread jams. `friction`: μ with the sign of the rate. */
double km_surface_normal(const km_mechanism *mechanism, const km_statics *statics, const km_surface *surface,
                         double friction);

#endif
