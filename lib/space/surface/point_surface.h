/* The plane or sphere on which a point of a mechanism with two freedoms moves (docs/theory.md 4.22).
 *
 *   fit      : a |p|² + b·p + c = 0: the null vector over places p;  a = 0: a plane, normal b;  else a sphere, centre
 *              o = −b / (2 a)
 *   tangents : t_i = a_i − (a_i·n) / (1 + a_3·n) (n + a_3): the axes a_i turned by the least angle that takes a_3 to
 *              the normal n; on a plane a_i
 *   chart    : x_i = a_i·p of a plane;  x_i = R k a_i·n,  k = √(2 / (1 + a_3·n)) of a sphere, n = (p − o) / R:
 *              equal areas; the place −a_3 is the circle of radius 2 R
 *   Source: J. H. Lambert 1772 */
#ifndef KM_SPACE_POINT_SURFACE_H
#define KM_SPACE_POINT_SURFACE_H

#include "base/memory.h"
#include "kmech/space.h"
#include "spatial/vec3.h"

/* Sets a plane of this unit normal; its axes are a coordinate axis projected, and the one orthogonal to it. */
void km_point_surface_set_plane(km_point_surface *surface, km_vec3 normal, km_vec3 place);
/* Fits a plane or a sphere to places[count], count > 4, that are not on a curve. KM_USAGE: they are on neither. */
km_status km_point_surface_fit(const km_vec3 *places, int count, km_point_surface *out, km_error *error);
/* Turns the axes of a sphere so that the last one has this direction. */
void km_point_surface_turn(km_point_surface *surface, km_vec3 pole);
/* Distance of a place from the surface. */
double km_point_surface_distance(const km_point_surface *surface, km_vec3 place);
/* Unit tangents at a place, t_1 × t_2 = n. */
void km_point_surface_tangents(const km_point_surface *surface, km_vec3 place, km_vec3 tangent[2]);
/* Chart of a place, and the chart's rate for a velocity along the surface. */
void km_point_surface_chart(const km_point_surface *surface, km_vec3 place, double chart[2]);
void km_point_surface_chart_rate(const km_point_surface *surface, km_vec3 place, km_vec3 velocity, double rate[2]);
/* Place on the surface at a point of the chart. */
km_vec3 km_point_surface_place(const km_point_surface *surface, const double chart[2]);
/* Area of the whole chart; 0: infinite. */
double km_point_surface_area(const km_point_surface *surface);

#endif
