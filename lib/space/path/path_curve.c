/* A smooth path beside one of straight steps (space/path/path_curve.h). */
#include "space/path/path_curve.h"

#include "space/path/path_spline.h"

#include <string.h>

static const double least_step = 1e-3;   /* part of the longest step: less ends the curve */
static const double shorter_step = 0.95; /* part of the longest step that the next attempt aims at */

typedef struct path_curve {
  km_path_trees *trees;
  km_path_steps *steps;
  const km_path_points *points;
  int drivers, knots;
  int *knot;     /* [knots] its point */
  double *x, *u; /* [knots], [drivers × knots] as km_path_spline */
  km_path_spline spline;
  double *du, *rate;              /* [drivers] last step, and over its length */
  double last_step, length, peak; /* followed so far; peak: greatest |d²u/ds²| */
  int peak_interval;
  double least_peak; /* L² peak of the best curve so far */
} path_curve;

static double driver_at(const path_curve *c, int point, int driver) {
  const km_driver_surface *f = &c->steps->f;
  return c->points->q[(size_t)point * (size_t)f->columns + (size_t)f->control[driver]];
}

static bool set_spline(path_curve *c) {
  for (int i = 0; i < c->knots; ++i) {
    c->x[i] = c->points->x[c->knot[i]];
    for (int d = 0; d < c->drivers; ++d)
      c->u[d * c->knots + i] = driver_at(c, c->knot[i], d);
  }
  km_path_spline_free(&c->spline);
  return km_path_spline_create(c->x, c->u, c->knots, c->drivers, true, &c->spline);
}

/* Tangent step from the state to the drivers at x. Returns its length. */
static double tangent_to(path_curve *c, double x) {
  const km_driver_surface *f = &c->steps->f;
  for (int d = 0; d < c->drivers; ++d) {
    int k = km_driver_surface_coordinate(f, f->control[d]);
    c->du[d] = km_path_spline_value(&c->spline, d, x) - f->s->q[k] / f->m->unit[k];
  }
  return km_path_steps_tangent(c->steps, c->du);
}

/* Adds the step du of a length to the length and the peak. */
static void measure_step(path_curve *c, int interval, double length) {
  double sum = 0.0;
  for (int d = 0; d < c->drivers; ++d) {
    double rate = c->du[d] / length;
    sum += (rate - c->rate[d]) * (rate - c->rate[d]);
    c->rate[d] = rate;
  }
  double curvature = 2.0 * sqrt(sum) / (length + c->last_step);
  if (c->length > 0.0 && curvature > c->peak) {
    c->peak = curvature;
    c->peak_interval = interval;
  }
  c->last_step = length;
  c->length += length;
}

/* Follows the curve from one knot to the next; adds the configurations to `out`, unless it is NULL. */
static bool follow_interval(path_curve *c, int interval, km_path_tree *out) {
  double from = c->x[interval], to = c->x[interval + 1];
  for (double at = from; at < to;) {
    double next = at + (to - at) / ceil((to - at) / KM_LONGEST_PATH_STEP), length;
    bool is_whole;
    km_driver_surface_rates(&c->steps->f, c->steps->N);
    while (!((length = tangent_to(c, next)) <= KM_LONGEST_PATH_STEP)) {
      next = at + (next - at) * shorter_step * KM_LONGEST_PATH_STEP / length;
      if (!(next - at >= least_step * KM_LONGEST_PATH_STEP))
        return false;
    }
    if (!km_path_steps_move(c->steps, length, &is_whole) || (out && km_path_trees_add(c->trees, out, -1) < 0))
      return false;
    measure_step(c, interval, length);
    at = next;
  }
  return true;
}

/* Follows the curve. Returns the first interval that isn't allowed, or doesn't end in its knot's configuration; that
 * behind the last one: all are. */
static int follow(path_curve *c, km_path_tree *out) {
  c->length = c->peak = 0.0;
  km_path_steps_move_to(c->steps, c->points->saved[0]);
  if (out && km_path_trees_add(c->trees, out, -1) < 0)
    return 0;
  for (int i = 0; i + 1 < c->knots; ++i)
    if (!follow_interval(c, i, out) ||
        km_path_steps_difference(c->steps, c->points->saved[c->knot[i + 1]]) > KM_EQUAL_PATH_CONFIGURATIONS)
      return i;
  return c->knots - 1;
}

static void insert_knot(path_curve *c, int at, int point) {
  memmove(c->knot + at + 1, c->knot + at, (size_t)(c->knots - at) * sizeof *c->knot);
  c->knot[at] = point;
  ++c->knots;
}

static void remove_knot(path_curve *c, int at) {
  --c->knots;
  memmove(c->knot + at, c->knot + at + 1, (size_t)(c->knots - at) * sizeof *c->knot);
}

/* Makes the point of an interval that is farthest from the curve a knot. False: there is none between. */
static bool divide_interval(path_curve *c, int interval) {
  double most = -1.0;
  int farthest = -1;
  for (int p = c->knot[interval] + 1; p < c->knot[interval + 1]; ++p) {
    double sum = 0.0;
    for (int d = 0; d < c->drivers; ++d)
      sum += pow(driver_at(c, p, d) - km_path_spline_value(&c->spline, d, c->points->x[p]), 2.0);
    if (sum > most) {
      most = sum;
      farthest = p;
    }
  }
  if (farthest >= 0)
    insert_knot(c, interval + 1, farthest);
  return farthest >= 0;
}

/* Adds knots until the curve is allowed. False when out of memory. */
static bool add_needed_knots(path_curve *c, bool *is_allowed) {
  for (;;) {
    if (!set_spline(c))
      return false;
    int interval = follow(c, NULL);
    *is_allowed = interval == c->knots - 1;
    if (*is_allowed || !divide_interval(c, interval))
      return true;
  }
}

/* Follows the curve through the present knots. *is_better: it is allowed, and its peak is lower than the least one so
 * far. False when out of memory. */
static bool try_knots(path_curve *c, bool *is_better) {
  if (!set_spline(c))
    return false;
  bool is_allowed = follow(c, NULL) == c->knots - 1;
  double peak = c->peak * c->length * c->length;
  *is_better = is_allowed && peak < c->least_peak;
  c->least_peak = *is_better ? peak : c->least_peak;
  return true;
}

/* Adds knots at the peak, as long as they lessen it. False when out of memory. */
static bool add_knots_at_peak(path_curve *c) {
  for (bool is_better = true; is_better;) {
    int interval = c->peak_interval;
    if (!divide_interval(c, interval))
      return true;
    if (!try_knots(c, &is_better))
      return false;
    if (!is_better)
      remove_knot(c, interval + 1);
  }
  return true;
}

/* Leaves out each knot without which the peak is lower. False when out of memory. */
static bool remove_knots(path_curve *c) {
  for (int i = 1; i + 1 < c->knots;) {
    int point = c->knot[i];
    bool is_better;
    remove_knot(c, i);
    if (!try_knots(c, &is_better))
      return false;
    if (!is_better)
      insert_knot(c, i++, point);
  }
  return true;
}

bool km_path_curve_smooth(km_path_trees *trees, km_path_points *points, bool *is_smooth) {
  km_arena *a = trees->arena;
  size_t drivers = (size_t)trees->steps->f.control_count, most = (size_t)points->count;
  path_curve c = {.trees = trees, .steps = trees->steps, .points = points, .drivers = (int)drivers, .knots = 2};
  km_path_tree smooth = {0};
  *is_smooth = false;
  c.knot = KM_ARENA_NEW(a, int, most);
  c.x = KM_ARENA_NEW(a, double, most);
  c.u = KM_ARENA_NEW(a, double, drivers *most);
  c.du = KM_ARENA_NEW(a, double, drivers);
  c.rate = KM_ARENA_NEW(a, double, drivers);
  if (a->failed)
    return false;
  c.knot[1] = points->count - 1;
  bool done = add_needed_knots(&c, is_smooth);
  c.least_peak = c.peak * c.length * c.length;
  if (done && *is_smooth)
    done = add_knots_at_peak(&c) && remove_knots(&c) && set_spline(&c) && follow(&c, &smooth) == c.knots - 1 &&
           km_path_points_create(c.steps, smooth.saved, smooth.count, a, points);
  km_path_spline_free(&c.spline);
  km_free(smooth.saved);
  km_free(smooth.parent);
  return done;
}
