/* Steps from grid point to grid point of a map (docs/theory.md 4.19).
 *
 *   predictor : dq = −A⁻¹ B du from a neighbour;   corrector: Newton's method with the drivers fixed
 *   accepted  : first correction ≤ 0.3 |dq|, and det A keeps its sign; else the step is halved
 *   kept sign : the cubic of det (J; G) over the step has Bernstein coefficients of one sign */
#include "space/map/map_search.h"

#include <string.h>

static const double most_correction = 0.3;   /* first correction over the predicted step */
static const double shortest_part = 1e-3;    /* shortest step, a part of the way between grid points */
static const double difference = 1e-6;       /* part of a step for a derivative along it */
static const double most_mismatch = 0.05;    /* part of a step by which its tangents may miss its end: a turn of 45° */
static const double least_correction = 1e-9; /* corrections below this are rounding */
static const double same_turn = 1e-6; /* difference of angles and configurations that are one but for full turns */

double km_map_axis_value(const km_map_search *g, int axis, int i) {
  const km_space_axis *a = &g->def->axis[axis];
  int c = a->coordinate;
  double value = a->from + (a->to - a->from) * i / a->steps;
  return value * g->f.m->factor[c] / g->f.m->unit[c];
}

double km_map_scaled_value(const km_map_search *g, int axis) {
  int c = g->def->axis[axis].coordinate;
  return g->f.s->q[c] / g->f.m->unit[c];
}

/* Closes the loops with the drivers fixed, where a step was predicted. */
static bool close_cell(km_map_search *g, double predicted, int *sign) {
  return km_driver_surface_close(&g->f, most_correction * predicted + least_correction, sign);
}

/* Adds a part of the step N du to the configuration. Returns the step's largest component. */
static double move_along(km_map_search *g, const double *N, const double *du, double part) {
  km_driver_surface *f = &g->f;
  double largest = 0.0;
  for (int k = 0; k < f->columns; ++k) {
    f->step[k] = part * (du[0] * N[k] + du[1] * N[f->columns + k]);
    largest = fmax(largest, fabs(f->step[k]));
  }
  km_driver_surface_move(f, f->step);
  return largest;
}

double km_map_output_determinant(km_map_search *g, const double *N, const double *du, double *rate) {
  double D = km_driver_surface_determinant(&g->f, KM_CURVE_OUTPUT, g->K, g->row);
  move_along(g, N, du, difference);
  *rate = (km_driver_surface_determinant(&g->f, KM_CURVE_OUTPUT, g->K, g->row) - D) / difference;
  move_along(g, N, du, -difference);
  return D;
}

bool km_map_has_sign(double sign, double value, double rate) {
  return sign * value > 0.0 && sign * (value + rate / 3.0) > 0.0;
}

bool km_map_is_at(const km_map_search *g, const double *saved) {
  return km_driver_surface_difference(&g->f, saved, g->f.step) < same_turn;
}

bool km_map_is_smooth(km_map_search *g, const double *saved, const double *N, const double *N_here, const double *du) {
  km_driver_surface *f = &g->f;
  double change = km_driver_surface_difference(f, saved, f->step), sum = 0.0;
  for (int k = 0; k < f->columns; ++k) {
    double mean = 0.5 * (du[0] * (N[k] + N_here[k]) + du[1] * (N[f->columns + k] + N_here[f->columns + k]));
    sum += (f->step[k] - mean) * (f->step[k] - mean);
  }
  return sqrt(sum) <= most_mismatch * change;
}

/* Moves the drivers by `part` of the way to a grid point, from a configuration with tangents N. */
static bool advance(km_map_search *g, const double *target, const double *N, int sign, double part) {
  km_driver_surface *f = &g->f;
  double du[2], rate, D;
  int reached;
  for (int d = 0; d < 2; ++d)
    du[d] = (target[d] - km_map_scaled_value(g, d)) * part;
  if (g->kept_sign) {
    D = km_map_output_determinant(g, N, du, &rate);
    if (!km_map_has_sign(g->kept_sign, D, rate))
      return false;
  }
  if (!close_cell(g, move_along(g, N, du, 1.0), &reached) || reached != sign)
    return false;
  if (!g->kept_sign)
    return true;
  km_driver_surface_rates(f, g->kept_N);
  if (!km_map_is_smooth(g, g->before, N, g->kept_N, du))
    return false;
  D = km_map_output_determinant(g, g->kept_N, du, &rate);
  km_driver_surface_update(f);
  return km_map_has_sign(g->kept_sign, D, -rate) && km_driver_surface_factor(f, &reached);
}

/* Moves to a grid point from the configuration g->before with tangents N; a rejected step is halved. */
static bool move_to(km_map_search *g, const double *target, double *N, int sign) {
  km_driver_surface *f = &g->f;
  double left = 1.0, step = 1.0; /* parts of the whole step */
  while (left > 0.0) {
    km_driver_surface_restore(f, g->before);
    step = fmin(step, left);
    if (advance(g, target, N, sign, step / left)) {
      left = step == left ? 0.0 : left - step;
      step *= 2.0;
      if (left > 0.0) {
        km_driver_surface_save(f, g->before);
        km_driver_surface_rates(&g->f, N);
      }
    } else {
      step *= 0.5;
      if (step < shortest_part)
        return false;
    }
  }
  return true;
}

bool km_map_reach(km_map_search *g, int from, int cell, double *N) {
  const double target[2] = {km_map_axis_value(g, 0, cell % g->across), km_map_axis_value(g, 1, cell / g->across)};
  size_t saved = g->f.saved_size, size = 2 * (size_t)g->f.columns;
  memcpy(g->before, g->saved + (size_t)from * saved, saved * sizeof *g->before);
  memcpy(N, g->N + (size_t)from * size, size * sizeof *N);
  return move_to(g, target, N, g->sign[from]);
}

int km_map_neighbour(const km_map_search *g, int cell, int k) {
  static const int side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  int i = cell % g->across + side[k][0], j = cell / g->across + side[k][1];
  return i < 0 || j < 0 || i >= g->across || j >= g->down ? -1 : j * g->across + i;
}

bool km_map_axis_ends(const km_map_search *g, int axis) {
  const km_space_axis *a = &g->def->axis[axis];
  double turn = fabs(a->to - a->from) * g->f.m->factor[a->coordinate];
  return !km_coordinate_turns(g->f.m, a->coordinate) || fabs(turn - 2.0 * M_PI) > same_turn;
}

int km_map_enter_grid(km_map_search *g, int *sign, double *N) {
  int at[2];
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &g->def->axis[d];
    if (km_coordinate_turns(g->f.m, a->coordinate)) { /* the full turn that is nearest to the range */
      double middle = 0.5 * (a->from + a->to) * g->f.m->factor[a->coordinate];
      g->f.s->q[a->coordinate] = middle + remainder(g->f.s->q[a->coordinate] - middle, 2.0 * M_PI);
    }
    double part = (km_state_value(g->f.s, a->coordinate) - a->from) / (a->to - a->from) * a->steps;
    at[d] = (int)round(fmin(fmax(part, 0.0), a->steps));
  }
  const double target[2] = {km_map_axis_value(g, 0, at[0]), km_map_axis_value(g, 1, at[1])};
  if (!close_cell(g, 1.0, sign))
    return -1;
  km_driver_surface_save(&g->f, g->before);
  km_driver_surface_rates(&g->f, N);
  return move_to(g, target, N, *sign) ? at[1] * g->across + at[0] : -1;
}
