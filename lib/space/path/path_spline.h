/* Natural cubic splines of the drivers over the length of a path.
 *
 *   u(x_i) = u_i;  u, u', u'' continuous, u'' = 0 at both ends:  ∫ u''² dx is least of all curves through the knots */
#ifndef KM_SPACE_PATH_SPLINE_H
#define KM_SPACE_PATH_SPLINE_H

#include "kmech/space.h"

#include <gsl/gsl_interp.h>

typedef struct km_path_spline {
  int drivers, count;
  const double *x;                     /* [count] increasing */
  const double *u;                     /* [drivers × count], by drivers */
  gsl_interp *of[KM_MAX_PATH_DRIVERS]; /* [drivers] */
} km_path_spline;

/* Splines through count >= 2 knots, which stay borrowed; straight lines between them unless `is_smooth`. Free in any
 * case. False when out of memory. */
bool km_path_spline_create(const double *x, const double *u, int count, int drivers, bool is_smooth,
                           km_path_spline *out);
void km_path_spline_free(km_path_spline *spline);
double km_path_spline_value(const km_path_spline *spline, int driver, double x);

#endif
