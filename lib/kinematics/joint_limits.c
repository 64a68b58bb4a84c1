/* Limits of coordinates: exceeded at a configuration, or at an extremum of the cubic Hermite interpolant of a step. */
#include "kinematics/state.h"

#include <math.h>

double km_state_ball_excess(const km_mechanism *m, int c, const double *q) {
  return m->max_ball_angle[c] < HUGE_VAL ? km_vec3_norm(km_vec3_from_array(q)) - m->max_ball_angle[c] : -HUGE_VAL;
}

/* Excess of coordinate c, with its value at q, above (> 0) or below (< 0) its limits; 0 within them and their rounding.
 * The limit of a ball joint's angle counts for its first coordinate; limits of a strut apply to its length |q|. */
static double excess(const km_mechanism *m, int c, const double *q) {
  double slack = 1e-12 * (m->unit[c] + fabs(*q)), ball_excess = km_state_ball_excess(m, c, q);
  double sense = m->model->coordinates[c].is_strut && *q < 0.0 ? -1.0 : 1.0, value = sense * *q;
  return ball_excess > slack          ? ball_excess
         : value > m->high[c] + slack ? sense * (value - m->high[c])
         : value < m->low[c] - slack  ? sense * (value - m->low[c])
                                      : 0.0;
}

double km_state_excess(const km_state *s, int coordinate) {
  return excess(s->mechanism, coordinate, &s->q[coordinate]);
}

bool km_state_is_outside(const km_state *s, int coordinate) {
  return km_state_excess(s, coordinate) != 0.0;
}

int km_state_find_outside_limit(const km_state *s, const km_substructure *sub) {
  const int *limited = s->mechanism->limited_column + sub->column_start;
  for (int i = 0; i < sub->limited_count; ++i) {
    int c = s->mechanism->column_coordinate[sub->column_start + limited[i]];
    if (excess(s->mechanism, c, &s->q[c]) != 0.0)
      return c;
  }
  return -1;
}

/* First coordinate that moved further beyond its limit since the saved configuration. */
int km_state_limit_passed(const km_state *s, const km_substructure *sub, const double *saved) {
  const int *limited = s->mechanism->limited_column + sub->column_start;
  for (int i = 0; i < sub->limited_count; ++i) {
    int k = limited[i], c = s->mechanism->column_coordinate[sub->column_start + k];
    double excess_now = excess(s->mechanism, c, &s->q[c]), change = s->q[c] - saved[k];
    if (excess_now != 0.0 && s->mechanism->max_ball_angle[c] < HUGE_VAL) /* the three coordinates of a ball joint are
                                                                          * consecutive */
      change = km_state_ball_excess(s->mechanism, c, &s->q[c]) - km_state_ball_excess(s->mechanism, c, &saved[k]);
    if (excess_now * change > 0.0)
      return c;
  }
  return -1;
}

/* Extrema of the cubic Hermite interpolant from 0 to m with end slopes t0, t1 over h, as parts of the interval. Returns
 * their number (0 or 2). */
static int find_extrema(double m, double t0, double t1, double h, double at[2]) {
  double a = 3.0 * h * (t0 + t1) - 6.0 * m, b = 6.0 * m - 2.0 * h * (2.0 * t0 + t1), c = h * t0;
  double root = b * b - 4.0 * a * c;
  if (!(root > 0.0))
    return 0;
  double half = -0.5 * (b + copysign(sqrt(root), b)); /* both roots of the quadratic without cancellation */
  at[0] = a != 0.0 ? half / a : -1.0;
  at[1] = c / half;
  return 2;
}

/* First coordinate that exceeds a limit at an extremum of the step's cubic interpolant. */
int km_state_limit_touched(const km_state *s, const km_substructure *sub, const double *saved, const double *t0,
                           const double *t1, double h) {
  const km_mechanism *m = s->mechanism;
  const int *limited = m->limited_column + sub->column_start;
  for (int l = 0; l < sub->limited_count; ++l) {
    int k = limited[l], c = m->column_coordinate[sub->column_start + k];
    double move = (s->q[c] - saved[k]) / m->unit[c], at[2];
    if (m->ball_of[c] >= 0)
      continue;
    for (int i = find_extrema(move, t0[k], t1[k], h, at) - 1; i >= 0; --i) {
      double u = at[i], tangent_part = h * u * (1.0 - u) * (t0[k] * (1.0 - u) - t1[k] * u);
      double displacement = m->unit[c] * (move * u * u * (3.0 - 2.0 * u) + tangent_part);
      double q = saved[k] + displacement;
      if (u > 0.0 && u < 1.0 && excess(m, c, &q) * displacement > 0.0)
        return c;
    }
  }
  return -1;
}
