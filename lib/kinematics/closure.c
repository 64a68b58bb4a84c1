/* Newton's method on the loops of a substructure, with least steps. */
#include "kinematics/closure.h"

#include "base/larger.h"
#include "kinematics/loops.h"

#include <string.h>

enum { MOST_ITERATIONS = 60 };
/* A residual above the first one plus the floor, times the growth, leads nowhere. */
static const double residual_growth = 1e3, residual_floor = 0.1;

double km_rank_tolerance(const km_mechanism *m, const km_substructure *sub, double misfit) {
  int size = sub->rows > sub->columns ? sub->rows : sub->columns;
  double tolerance = 1e-9 * fmax(size, 1.0);
  /* A misfit e of the data can make a pivot of a few e. */
  if (m->closure_tolerance_given)
    tolerance = fmax(tolerance, 10.0 * m->closure_tolerance);
  return fmin(fmax(tolerance, 10.0 * misfit), 0.05);
}

void km_pivot(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  const km_substructure *sub = &m->substructures[index];
  s->partition[index].nearly = driver >= 0;
  if (driver >= 0)
    s->forced[driver] = true;
  km_partition_factor(&s->partition[index], km_state_jacobian(s, sub), sub->rows, sub->columns,
                      driver >= 0 ? s->forced : NULL, tolerance);
  if (driver >= 0)
    s->forced[driver] = false;
  s->partition[index].nearly = false;
  s->pivoted[index] = driver;
}

double km_step_dot(const km_mechanism *m, const km_substructure *sub, const double *a, const double *b) {
  const double *weight = m->column_weight + sub->column_start;
  double sum = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    sum += weight[k] * a[k] * weight[k] * b[k];
  return sum;
}

double km_step_length(const km_mechanism *m, const km_substructure *sub, const double *x) {
  return sqrt(km_step_dot(m, sub, x, x));
}

/* The part of D x along the `count` orthonormal vectors of Y, into `sum` [columns]. */
static void project(const km_substructure *sub, const double *weight, const double *Y, int count, const double *x,
                    double *sum) {
  memset(sum, 0, (size_t)sub->columns * sizeof *sum);
  for (int k = 0; k < count; ++k) {
    const double *y = Y + (size_t)k * (size_t)sub->columns;
    double dot = 0.0;
    for (int j = 0; j < sub->columns; ++j)
      dot += y[j] * weight[j] * x[j];
    for (int j = 0; j < sub->columns; ++j)
      sum[j] += dot * y[j];
  }
}

/* How many motions leave the driver alone. */
static int motions_beside(const km_partition *p, int driver) {
  return km_partition_freedom(p) - (driver >= 0 && !p->forced_dependent);
}

/* Are the vectors that least steps take so many that the rows' own equations find them sooner? */
static bool takes_many(const km_partition *p, int count) {
  return p->sparse && (p->rank < count ? p->rank : count) > KM_MANY_VECTORS;
}

/* D x loses what it has of the null space Z, or keeps what it has of the row space R: whichever has fewer vectors. */
void km_least_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const double *weight = m->column_weight + sub->column_start;
  int count = motions_beside(p, driver);
  if (count <= 0)
    return;
  bool by_rows = p->rank < count;
  if (takes_many(p, count) && km_partition_reject_null(p, km_state_jacobian(s, sub), weight, count, x, s->part)) {
    s->basis[index].count = 0;
    return;
  }
  const double *Y = by_rows ? km_state_rows(m, s, index, count) : km_state_null(m, s, index, count);
  if (!Y)
    return;
  project(sub, weight, Y, by_rows ? p->rank : count, x, s->part);
  bool keeps = driver >= 0 && !p->forced_dependent; /* none of these motions has a part in it, and R leaves it out */
  double own = keeps ? x[driver] : 0.0;
  for (int j = 0; j < sub->columns; ++j)
    x[j] = by_rows ? s->part[j] / weight[j] : x[j] - s->part[j] / weight[j];
  if (keeps)
    x[driver] = own;
}

/* The motions' part of the driver's unit vector, over its own entry. Of many freedoms the null vectors may be long and nearly
 * cancel in the least one; this takes none of them alone. */
static bool project_driver(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_substructure *sub = &m->substructures[index];
  memset(t, 0, (size_t)sub->columns * sizeof *t);
  t[driver] = 1.0;
  km_least_step(m, s, index, KM_NO_DRIVER, t);
  double share = 1.0 - t[driver];
  for (int k = 0; k < sub->columns; ++k)
    t[k] = k == driver ? 1.0 : -t[k] / share;
  return share > 0.0;
}

void km_least_rates(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_partition *p = &s->partition[index];
  if (p->sparse && km_partition_freedom(p) > KM_MANY_VECTORS && project_driver(m, s, index, driver, t))
    return;
  km_partition_direction(p, driver, t);
  km_least_step(m, s, index, driver, t);
}

static double primary_rms(const km_partition *p, const double *error) {
  double sum = 0.0;
  for (int i = 0; i < p->rank; ++i)
    sum += error[p->row[i]] * error[p->row[i]];
  return p->rank ? sqrt(sum / p->rank) : 0.0;
}

/* The pivots of the last pose serve while the monitor agrees and Newton is near the solution. Those that were
 * searched with the loose tolerance of an open pose may leave out rows that count: they aren't kept. */
static void factor(const km_mechanism *m, km_state *s, int index, int driver, double residual) {
  const km_substructure *sub = &m->substructures[index];
  if (residual < km_near_closed && s->pivoted[index] == driver &&
      km_partition_refactor(&s->partition[index], km_state_jacobian(s, sub)))
    return;
  double tolerance = km_rank_tolerance(m, sub, residual);
  km_pivot(m, s, index, driver, tolerance);
  if (tolerance > km_rank_tolerance(m, sub, 0.0))
    km_state_forget_pivots(s, index);
}

/* The least x with J x = the loops' errors in the primary rows. Among many motions any other solution may be a long one, of which
 * taking the motions out leaves rounding alone. */
static void solve_least(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  int count = motions_beside(p, driver);
  if ((p->rows_only || takes_many(p, count)) &&
      km_partition_least(p, km_state_jacobian(s, sub), m->column_weight + sub->column_start, count,
                         km_state_error(s, sub), x))
    return;
  km_partition_solve(p, km_state_error(s, sub), x);
  if (!p->rows_only)
    km_least_step(m, s, index, driver, x);
}

/* The next step into x; returns its largest entry. */
static double newton_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  double largest = 0.0;
  solve_least(m, s, index, driver, x);
  for (int k = 0; k < sub->columns; ++k)
    x[k] = -x[k];
  if (driver >= 0) /* where it came out dependent, the step wants to move it */
    x[driver] = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    largest = km_larger(fabs(x[k]), largest);
  return largest;
}

/* The factor of all thresholds, up to the 1e6 radians where rounding drowns the geometry. A ball is a unit quaternion, however
 * far it has turned. */
static double grain(const km_mechanism *m, const km_state *s, const km_substructure *sub) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  double largest = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    if (m->ball_of[coordinate[k]] < 0)
      largest = km_larger(fabs(s->q[coordinate[k]] / m->unit[coordinate[k]]), largest);
  return km_smaller(1.0 + km_grain_growth * largest, km_grain_most);
}

static km_closure_outcome verdict(const km_mechanism *m, double residual, double coarse) {
  return residual <= km_larger(m->closure_tolerance, coarse * km_closed) ? KM_CLOSED : KM_INCONSISTENT;
}

km_closure_outcome km_loops_close(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  const km_substructure *sub = &m->substructures[index];
  double *x = s->work, first = 0.0, last = HUGE_VAL, coarse = grain(m, s, sub);
  *evidence = (km_closure){.worst = -1, .left = x};
  for (int i = 0; i < MOST_ITERATIONS; ++i) {
    km_loops_update(m, s, sub);
    evidence->iterations = i;
    evidence->residual = km_loops_residual(m, s, sub, &evidence->worst);
    if (!isfinite(evidence->residual))
      return KM_OPEN;
    if (i == 0)
      first = evidence->residual;
    factor(m, s, index, driver, evidence->residual);
    double step = newton_step(m, s, index, driver, x);
    bool small = primary_rms(&s->partition[index], km_state_error(s, sub)) <= coarse * km_closed;
    if (small && step <= coarse * (i == 0 && driver >= 0 ? km_settled_at_once : km_settled))
      return verdict(m, evidence->residual, coarse);
    if (s->partition[index].held && small && step >= last)
      return verdict(m, evidence->residual, coarse);
    last = small ? step : HUGE_VAL;
    if (!isfinite(step) || evidence->residual > residual_growth * (first + residual_floor))
      return KM_OPEN;
    if (step > km_longest_newton)
      for (int k = 0; k < sub->columns; ++k)
        x[k] *= km_longest_newton / step;
    if (i + 1 == MOST_ITERATIONS)
      break;
    evidence->correction += km_step_length(m, sub, x);
    km_state_move(m, s, sub, x);
  }
  /* At a singular pose Newton only halves its distance: the error is as small as it can be shown to be. */
  return driver < 0 && primary_rms(&s->partition[index], km_state_error(s, sub)) <= coarse * km_closed
             ? verdict(m, evidence->residual, coarse)
             : KM_OPEN;
}

km_closure_outcome km_close_held(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  s->partition[index].held = true;
  km_closure_outcome outcome = km_loops_close(m, s, index, driver, evidence);
  s->partition[index].held = false;
  return outcome;
}
