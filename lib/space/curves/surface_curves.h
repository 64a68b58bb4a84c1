/* Curves on a surface of configurations with two controls (docs/theory.md 4.19, 4.20).
 *
 *   input, output: det K = 0, K of the surface (driver_surface.h)
 *   limit        : a coordinate at a bound of its range
 *   clearance    : the distance of a pair of bodies at its least */
#ifndef KM_SPACE_SURFACE_CURVES_H
#define KM_SPACE_SURFACE_CURVES_H

#include "base/store/piece_store.h"
#include "space/driver_surface.h"

typedef struct km_surface_curves km_surface_curves;

/* Definition of a curve. */
typedef struct km_surface_curve {
  km_curve_kind kind;
  int column;     /* limit: the coordinate's column; clearance: the pair */
  double bound;   /* limit: its value, of the state's coordinate */
  bool is_signed; /* limit: a strut's is of its coordinate, as in the range of a driver, else of its length */
} km_surface_curve;

/* A point of a curve. */
typedef struct km_curve_point {
  double *saved;   /* configuration */
  double *tangent; /* [columns] unit vector in the order of the points */
  km_surface_curve of;
  int curve;        /* number, from 1 */
  bool is_crossing; /* another singularity curve crosses, of the kind */
  km_curve_kind crossing;
} km_curve_point;

/* The table has the columns curve; kind, or with a number of the design number and critical; q. of all coordinates;
 * with an output the x y z of its point. NULL when out of memory. */
km_surface_curves *km_surface_curves_create(km_driver_surface *surface, km_table *table);
void km_surface_curves_free(km_surface_curves *curves);
/* Adds the curve nearest to the saved configuration, unless it is in the table. Nothing is done where a known point of
 * such a curve is nearer to the configuration than `distance` + 0.02. False when out of memory. */
bool km_surface_curves_add(km_surface_curves *curves, const km_surface_curve *of, const double *saved, double distance);
/* Moves the surface from point i of a curve of the drivers to its side, by `distance` along z; the loops are then open.
 * False for another kind of curve. *is_point: there is a point i. */
bool km_surface_curves_leave(km_surface_curves *curves, size_t i, double distance, bool *is_point);
int km_surface_curves_count(const km_surface_curves *curves);
/* Coefficients c[columns × 4] of the Hermite interpolant between two points of a curve, as the step from the first one;
 * step[columns] and `length` are those to the second one. Its error is of fourth order in the length. */
void km_curve_interpolate(int columns, const km_curve_point *p, const km_curve_point *next, const double *step,
                          double length, double *c);
/* The points of all curves, row by row of the table. Borrowed. */
const km_curve_point *km_surface_curves_points(const km_surface_curves *curves, size_t *count);

/* Passes the curves' points from number `first` on, with their rows, to a piece or from it; not their critical points.
 * False when out of memory. */
bool km_surface_curves_pass(km_surface_curves *curves, size_t first, km_piece *piece);

/* Critical points of the curves: extrema of the number. Borrowed. */
const km_turning_point *km_surface_curves_critical(const km_surface_curves *curves, int *count);

#endif
