/* Surfaces of joints that rub: where, how fast they slide, and what presses on them. Private to analysis/. */
#ifndef KM_TRANSFER_FRICTION_SURFACES_H
#define KM_TRANSFER_FRICTION_SURFACES_H

#include "statics/statics.h"

/* A surface on which a coordinate's friction acts. A hinge has two, each at the friction's radius: its journal, on which the
 * force across its axis presses, and its collar, on which the thrust along it does. */
typedef struct km_surface {
  int coordinate;
  bool is_collar;
} km_surface;

/* Those of all coordinates that aren't held and have a coefficient of friction, by coordinate: out[2 × coordinates]. Returns
 * their number. */
int km_surfaces_list(const km_mechanism *mechanism, km_surface *out);

/* The way that a surface slides in a unit of its coordinate: the friction's radius, of a thread its helix at that radius; 1 of
 * a slide; 0: it has no radius. */
double km_slip_arm(const km_mechanism *mechanism, int coordinate);

/* How fast the surfaces slide on which a coordinate's friction acts, at rates[coordinate]: those of a ball, of both slides of a planar
 * joint and of a cylindrical joint do so in one direction, which their coordinates share. */
double km_slip_speed(const km_mechanism *mechanism, const double *rates, int coordinate);

/* The tangent of a thread's lead angle λ, pitch / (2π r); 0 of what isn't a screw. */
double km_thread_slope(const km_mechanism *mechanism, int coordinate);
km_vec3 km_surface_axis(const km_statics *statics, int coordinate);

/* What presses on a surface, from the joint's last reaction F (KM_AXES_FIXED), without the thread's own friction: F across the
 * axis, of collars along it, of balls all of it, of planar joints along their normal, of threads F with its part along the
 * axis over cos λ. Linear in F. */
km_vec3 km_surface_load(const km_mechanism *mechanism, const km_statics *statics, const km_surface *surface);

/* The normal force N ≥ 0 under a load v, with friction ±μ N along the way in which the surface slides. A thread's friction has a
 * part along the axis, so that N = |v + μ tan λ N axis|: between flanks N cos λ ∓ μ N sin λ bears the thrust. Infinite: the
 * thread jams. `friction`: μ with the sign of the rate. */
double km_surface_normal(const km_mechanism *mechanism, const km_statics *statics, const km_surface *surface,
                         double friction);

#endif
