/* Natural cubic splines of the drivers (space/path/path_spline.h), by GSL. */
#include "space/path/path_spline.h"

#include <gsl/gsl_errno.h>
#include <math.h>

bool km_path_spline_create(const double *x, const double *u, int count, int drivers, bool is_smooth,
                           km_path_spline *out) {
  *out = (km_path_spline){.drivers = drivers, .count = count, .x = x, .u = u};
  bool done = true;
  gsl_set_error_handler_off();
  for (int d = 0; done && d < drivers; ++d) {
    out->of[d] = gsl_interp_alloc(is_smooth && count > 2 ? gsl_interp_cspline : gsl_interp_linear, (size_t)count);
    done = out->of[d] && gsl_interp_init(out->of[d], x, u + d * count, (size_t)count) == 0;
  }
  return done;
}

void km_path_spline_free(km_path_spline *s) {
  for (int d = 0; d < s->drivers; ++d)
    gsl_interp_free(s->of[d]);
}

double km_path_spline_value(const km_path_spline *s, int driver, double x) {
  double inside = fmax(s->x[0], fmin(x, s->x[s->count - 1]));
  return gsl_interp_eval(s->of[driver], s->x, s->u + driver * s->count, inside, NULL);
}
