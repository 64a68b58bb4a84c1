/* Newton's method on the loops of a substructure, with least steps. */
#include "kinematics/loop_closing.h"

#include "base/extrema.h"
#include "kinematics/loop_equations.h"

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

/* Are the pivots at hand what this search would find? The sparse engine knows that itself (km_sparse_has_factor). */
static bool are_searched(const km_state *s, int index, int driver, double tolerance) {
  const km_partition *p = &s->partition[index];
  const km_cached_configuration *shown = &s->cached[index];
  return !p->sparse && !p->failed && shown->is_valid && shown->evaluation_at_search == shown->evaluations &&
         shown->partition_version == p->version && shown->driver == driver &&
         shown->forced_never_pivot == p->forced_never_pivot && shown->tolerance == tolerance;
}

static void remember_search(km_state *s, int index, int driver, double tolerance) {
  const km_partition *p = &s->partition[index];
  km_cached_configuration *shown = &s->cached[index];
  shown->evaluation_at_search = shown->evaluations;
  shown->partition_version = p->version;
  shown->driver = driver;
  shown->forced_never_pivot = p->forced_never_pivot;
  shown->tolerance = tolerance;
}

void km_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  const km_substructure *sub = &m->substructures[index];
  tolerance = km_larger(tolerance, s->partition[index].min_relative_pivot);
  if (are_searched(s, index, driver, tolerance)) {
    s->pivot_driver[index] = driver;
    return;
  }
  s->partition[index].ties_by_position = driver >= 0;
  if (driver >= 0)
    s->forced[driver] = true;
  km_partition_factor(&s->partition[index], km_state_jacobian(s, sub), sub->rows, sub->columns,
                      driver >= 0 ? s->forced : NULL, tolerance);
  if (driver >= 0)
    s->forced[driver] = false;
  s->partition[index].ties_by_position = false;
  s->pivot_driver[index] = driver;
  remember_search(s, index, driver, tolerance);
}

void km_update_and_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double misfit) {
  const km_substructure *sub = &m->substructures[index];
  km_loops_update(m, s, sub);
  km_search_pivots(m, s, index, driver, km_rank_tolerance(m, sub, misfit));
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

static bool reject_null(const km_mechanism *m, km_state *s, int index, int count, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  return takes_many(p, count) &&
         km_partition_remove_null_space(p, km_state_jacobian(s, sub), m->column_weight + sub->column_start, count, x,
                                        s->projection);
}

/* D x loses what it has of the null space Z, or keeps what it has of the row space R: whichever has fewer vectors. */
void km_minimum_norm_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const double *weight = m->column_weight + sub->column_start;
  int count = motions_beside(p, driver);
  if (count <= 0)
    return;
  bool by_rows = p->rank < count, done = reject_null(m, s, index, count, x);
  if (!done && p->is_deferred) {
    km_partition_refactor_full_pattern(&s->partition[index], km_state_jacobian(s, sub));
    done = reject_null(m, s, index, count, x);
  }
  if (done) {
    s->basis[index].count = 0;
    return;
  }
  const double *Y = by_rows ? km_state_row_space(m, s, index, count) : km_state_null_space(m, s, index, count);
  if (!Y)
    return;
  project(sub, weight, Y, by_rows ? p->rank : count, x, s->projection);
  bool keeps = driver >= 0 && !p->forced_dependent; /* none of these motions has a part in it, and R leaves it out */
  double own = keeps ? x[driver] : 0.0;
  for (int j = 0; j < sub->columns; ++j)
    x[j] = by_rows ? s->projection[j] / weight[j] : x[j] - s->projection[j] / weight[j];
  if (keeps)
    x[driver] = own;
}

/* The motions' part of the driver's unit vector, over its own entry. Of many freedoms the null vectors may be long and nearly
 * cancel in the least one; this takes none of them alone. */
static bool project_driver(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_substructure *sub = &m->substructures[index];
  memset(t, 0, (size_t)sub->columns * sizeof *t);
  t[driver] = 1.0;
  km_minimum_norm_step(m, s, index, KM_NO_DRIVER, t);
  double share = 1.0 - t[driver];
  for (int k = 0; k < sub->columns; ++k)
    t[k] = k == driver ? 1.0 : -t[k] / share;
  return share > 0.0;
}

void km_minimum_norm_rates(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_partition *p = &s->partition[index];
  if (p->sparse && km_partition_freedom(p) > KM_MANY_VECTORS && project_driver(m, s, index, driver, t))
    return;
  km_partition_null_vector(p, driver, t);
  km_minimum_norm_step(m, s, index, driver, t);
}

void km_search_pivots_for_steps(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  km_partition *p = &s->partition[index];
  p->basis_quality_unneeded = true;
  km_search_pivots(m, s, index, driver, tolerance);
  p->basis_quality_unneeded = false;
}

static double primary_rms(const km_partition *p, const double *error) {
  double sum = 0.0;
  for (int i = 0; i < p->rank; ++i)
    sum += error[p->row[i]] * error[p->row[i]];
  return p->rank ? sqrt(sum / p->rank) : 0.0;
}

static bool takes_rows(const km_partition *p, int driver) {
  return p->rows_only || takes_many(p, motions_beside(p, driver));
}

bool km_defer_pivots(km_state *s, int index, int driver) {
  km_partition *p = &s->partition[index];
  if (!takes_rows(p, driver) || !km_partition_may_defer(p))
    return false;
  km_partition_defer(p);
  return true;
}

/* Do the pivots of the last pose serve? Of many motions nobody asks for B. */
static bool refactor(const km_mechanism *m, km_state *s, int index, int driver) {
  km_partition *p = &s->partition[index];
  p->basis_quality_unneeded = takes_rows(p, driver);
  bool serve = km_partition_refactor(p, km_state_jacobian(s, &m->substructures[index]));
  p->basis_quality_unneeded = false;
  return serve;
}

/* Those that were searched with the loose tolerance of an open pose may leave out rows that count: they aren't kept. */
static void search(const km_mechanism *m, km_state *s, int index, int driver, double residual) {
  const km_substructure *sub = &m->substructures[index];
  double tolerance = km_rank_tolerance(m, sub, residual);
  km_search_pivots_for_steps(m, s, index, driver, tolerance);
  if (!km_has_full_row_rank(&s->partition[index]) && tolerance > km_rank_tolerance(m, sub, 0.0))
    km_state_invalidate_pivots(s, index);
}

/* The pivots of the last pose serve while the monitor agrees and Newton is near the solution. Where rows are enough for a step
 * the monitor waits for the pose that is found. */
static void factor(const km_mechanism *m, km_state *s, int index, int driver, double residual) {
  if (residual < km_pivot_reuse_residual && s->pivot_driver[index] == driver &&
      (km_defer_pivots(s, index, driver) || refactor(m, s, index, driver)))
    return;
  search(m, s, index, driver, residual);
}

/* By the Jacobian of the last step where `again` is set and that is known. */
static bool take_rows(const km_mechanism *m, km_state *s, int index, int driver, bool again, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const double *weight = m->column_weight + sub->column_start, *error = km_state_error(s, sub);
  int count = motions_beside(p, driver);
  return takes_rows(p, driver) && ((again && km_partition_minimum_norm_reuse(p, weight, count, error, x)) ||
                                   km_partition_minimum_norm(p, km_state_jacobian(s, sub), weight, count, error, x));
}

/* The least x with J x = the loops' errors in the primary rows. Among many motions any other solution may be a long one, of which
 * taking the motions out leaves rounding alone. */
static void solve_least(const km_mechanism *m, km_state *s, int index, int driver, double residual, bool again,
                        double *x) {
  const km_partition *p = &s->partition[index];
  bool done = take_rows(m, s, index, driver, again && p->is_deferred, x);
  if (!done && p->is_deferred) {
    if (!refactor(m, s, index, driver))
      search(m, s, index, driver, residual);
    done = take_rows(m, s, index, driver, false, x);
  }
  if (done)
    return;
  km_partition_solve(p, km_state_error(s, &m->substructures[index]), x);
  if (!p->rows_only)
    km_minimum_norm_step(m, s, index, driver, x);
}

/* The next step into x; returns its largest entry. */
static double newton_step(const km_mechanism *m, km_state *s, int index, int driver, double residual, bool again,
                          double *x) {
  const km_substructure *sub = &m->substructures[index];
  double largest = 0.0;
  solve_least(m, s, index, driver, residual, again, x);
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
  return km_smaller(1.0 + km_tolerance_scale_growth * largest, km_max_tolerance_scale);
}

static km_closure_outcome verdict(const km_mechanism *m, double residual, double coarse) {
  return residual <= km_larger(m->closure_tolerance, coarse * km_residual_tolerance) ? KM_CLOSED : KM_INCONSISTENT;
}

/* Newton's place. */
typedef struct newton {
  double step, last; /* the largest entries of this step and of the one before it, where that led from closed loops */
  double closed, settled; /* what shows the pose to be found: its error, and the step from there */
  bool small;
  bool converges; /* so soon that the next step may be taken by the same Jacobian */
} newton;

/* A step of this size, scaled, changes the Jacobian by so little that the next one by the same Jacobian is shorter by more than the
 * share below, as long as no rows are nearly dependent: then it isn't. */
static const double short_newton = 0.01, fast_share = 0.1;

static void take_step(const km_mechanism *m, km_state *s, int index, int driver, const km_closure *evidence, double *x,
                      newton *n) {
  double before = n->step;
  n->step = newton_step(m, s, index, driver, evidence->residual, n->converges, x);
  n->converges = n->step <= short_newton && n->step <= fast_share * before;
  n->small = primary_rms(&s->partition[index], km_state_error(s, &m->substructures[index])) <= n->closed;
}

static bool is_found(const km_partition *p, const newton *n) {
  return n->small && (n->step <= n->settled || (p->forced_never_pivot && n->step >= n->last));
}

/* Are the pivots that waited for the pose that is found good ones there? Rows that are kept beside others must be looked at again. */
static bool still_serve(const km_mechanism *m, km_state *s, int index, int driver) {
  const km_partition *p = &s->partition[index];
  return !p->is_deferred ||
         ((p->kept_row_tolerance == 0.0 || km_has_full_row_rank(p)) && refactor(m, s, index, driver));
}

static km_closure_outcome close_loops(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  double *x = s->work, first = 0.0, coarse = grain(m, s, sub);
  newton n = {.step = HUGE_VAL, .last = HUGE_VAL, .closed = coarse * km_residual_tolerance};
  *evidence = (km_closure){.worst = -1, .last_step = x};
  for (int i = 0; i < MOST_ITERATIONS; ++i) {
    if (i == 0 && driver < 0)
      km_loops_update(m, s, sub);
    else
      km_loops_recompute(m, s, sub);
    evidence->iterations = i;
    evidence->residual = km_loops_residual(m, s, sub, &evidence->worst);
    if (!isfinite(evidence->residual))
      return KM_OPEN;
    if (i == 0)
      first = evidence->residual;
    n.settled = coarse * (i == 0 && driver >= 0 ? km_predicted_step_tolerance : km_step_tolerance);
    factor(m, s, index, driver, evidence->residual);
    take_step(m, s, index, driver, evidence, x, &n);
    if (is_found(p, &n) && !still_serve(m, s, index, driver)) {
      search(m, s, index, driver, evidence->residual);
      if (!p->rows_were_kept) /* else the step is the same */
        take_step(m, s, index, driver, evidence, x, &n);
    }
    if (is_found(p, &n))
      return verdict(m, evidence->residual, coarse);
    n.last = n.small ? n.step : HUGE_VAL;
    if (!isfinite(n.step) || evidence->residual > residual_growth * (first + residual_floor))
      return KM_OPEN;
    if (n.step > km_max_newton_step)
      for (int k = 0; k < sub->columns; ++k)
        x[k] *= km_max_newton_step / n.step;
    if (i + 1 == MOST_ITERATIONS)
      break;
    evidence->correction += km_step_length(m, sub, x);
    km_state_move(m, s, sub, x);
  }
  /* At a singular pose Newton only halves its distance: the error is as small as it can be shown to be. */
  return driver < 0 && primary_rms(p, km_state_error(s, sub)) <= n.closed ? verdict(m, evidence->residual, coarse)
                                                                          : KM_OPEN;
}

km_closure_outcome km_loops_close(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  km_closure_outcome outcome = close_loops(m, s, index, driver, evidence);
  if (driver < 0) /* poses of a driver are left at once */
    km_loops_cache(m, s, &m->substructures[index]);
  if (s->partition[index].is_deferred)
    refactor(m, s, index, driver);
  return outcome;
}

km_closure_outcome km_close_with_driver(const km_mechanism *m, km_state *s, int index, int driver,
                                        km_closure *evidence) {
  s->partition[index].forced_never_pivot = true;
  km_closure_outcome outcome = km_loops_close(m, s, index, driver, evidence);
  s->partition[index].forced_never_pivot = false;
  return outcome;
}

km_closure_outcome km_close_fully(km_closing_function close, const km_mechanism *m, km_state *s, int index, int driver,
                                  km_closure *evidence) {
  enum { MOST_RANKS = 4 };
  km_state_invalidate_pivots(s, index);
  km_closure_outcome outcome = close(m, s, index, driver, evidence);
  for (int i = 0; i < MOST_RANKS && outcome == KM_CLOSED; ++i) {
    int rank = s->partition[index].rank;
    km_update_and_search_pivots(m, s, index, driver, evidence->residual);
    if (s->partition[index].rank <= rank)
      break;
    int iterations = evidence->iterations;
    outcome = close(m, s, index, driver, evidence);
    evidence->iterations += iterations;
  }
  return outcome;
}
