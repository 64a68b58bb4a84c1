/* Curves while they are followed (space/curves/surface_curves.h). */
#ifndef KM_SPACE_CURVE_SEARCH_H
#define KM_SPACE_CURVE_SEARCH_H

#include "space/curves/curve_system.h"

/* Functions whose roots are located along a curve. */
enum { KM_CURVE_FUNCTIONS = 5 };

/* A point of a curve: configuration, null vector, tangent and functions. */
typedef struct km_followed_point {
  double *saved, *z, *t; /* [saved_size], [order], [unknowns] */
  double value[KM_CURVE_FUNCTIONS];
} km_followed_point;

struct km_surface_curves {
  km_curve_system system;
  km_table *table;
  km_arena arena;
  int count;
  int located; /* function whose root is located */
  km_followed_point from, start;
  km_curve_point *points; /* [point_count] of all curves; those of the present one as they were found */
  size_t point_count, capacity;
  km_curve_point *found; /* [row_count] points of the present curve */
  size_t found_capacity;
  double *rows; /* [row_count × columns of the table] of the present curve */
  size_t row_count, row_capacity;
  double *chord;              /* [4 · columns] workspace: an interpolant */
  km_turning_point *critical; /* extrema of the number */
  size_t critical_capacity;
  int critical_count;
};

/* Longest step of (q, z). */
static const double km_longest_curve_step = 0.02;
/* Margin of a start at an end, such as a corner of the ranges. */
static const double km_at_curve_end = 1e-9;

/* Least margin to ranges, limits and the least clearance at the state's configuration, but for those of the curve. */
double km_curve_margin(km_surface_curves *curves);
/* Saves the present point, and returns to it. */
void km_followed_point_save(km_surface_curves *curves, km_followed_point *to);
void km_followed_point_restore(km_surface_curves *curves, const km_followed_point *from);
/* Adds the present point and its row; `critical`: of the number there. False when out of memory. */
bool km_curve_add_point(km_surface_curves *curves, km_turning_kind critical);
/* Follows the curve from its start in the sense of t. False when out of memory; *is_closed: the curve has returned;
 * *length: of the configurations, infinite with an end. */
bool km_curve_follow(km_surface_curves *curves, bool *is_closed, double *length);

#endif
