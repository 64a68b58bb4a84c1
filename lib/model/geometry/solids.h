/* Mass properties of primitive solids; rigid displacement and sum. */
#ifndef KM_MODEL_GEOMETRY_SOLIDS_H
#define KM_MODEL_GEOMETRY_SOLIDS_H

#include "spatial/pose.h"

/* Mass, centre of mass, and inertia about it (Ixx Iyy Izz Ixy Iyz Izx). */
typedef struct km_mass {
  double mass;
  km_vec3 center;
  double inertia[6];
} km_mass;
/* The mass properties in a frame in which their own frame has `pose`. */
km_mass km_mass_moved(const km_pose *pose, km_mass mass);
km_mass km_mass_sum(km_mass a, km_mass b);
/* Solids of density 1 about their centres: half sizes of a box, half axes of an ellipsoid, radius and half length
 * (without caps) along z. */
km_mass km_solid_box(const double half[3]);
km_mass km_solid_ellipsoid(const double half[3]);
km_mass km_solid_cylinder(double radius, double half);
km_mass km_solid_capsule(double radius, double half);
/* A cone with tip at +half and base at −half, about the middle between them. */
km_mass km_solid_cone(double radius, double half);
km_mass km_mass_scaled(double factor, km_mass mass);

#endif
