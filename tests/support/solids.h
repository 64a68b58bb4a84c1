/* Closed meshes whose mass properties are known. The caller frees them. */
#ifndef KM_TESTS_SOLIDS_H
#define KM_TESTS_SOLIDS_H

#include "model/geometry/mass_properties.h"
#include "spatial/rotation.h"

static const double solid_pi = 3.14159265358979323846;

/* A prism over a regular polygon of n corners on a circle of radius r about the z axis, from −h/2 to h/2. */
km_mesh *solid_prism(int n, double r, double h, double turn);
/* A square prism, stretched: sides a, b, c about the origin. */
km_mesh *solid_box(double a, double b, double c);

/* Turned about its own x, then y, then z. */
km_rotation solid_turn(double x, double y, double z);
void solid_move(km_mesh *m, const km_rotation *R, km_vec3 by);

/* Mass properties of a mesh that must have no faults. */
km_mass_properties solid_weigh(const km_mesh *mesh);

#endif
