/* Closed loops in the equations of motion: partitions, dependent coordinates and rates, velocity products
 * (docs/theory.md 11.3).
 *
 *   q_d ← q_d − (L U)⁻¹ e_p  until |e_p| ≤ tolerance/weakness;   q̇_d = −B q̇_i,  γ_d = U⁻¹ L⁻¹ γ_p
 *   option: γ − 2 ω ė − ω² e  instead of closing            (J. Baumgarte 1972) */
#include "dynamics/dynamics.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MAX_STEPS = 12 };
static const double max_growth = 8.0;
/* Scaled error of the dependent coordinates at an accepted configuration; error that rounding of multi-turn angles
 * can leave; largest Newton step. */
static const double accepted_tolerance = 1e-13, rounding = 1e-9, max_newton_step = 0.5;
static const double loop_rounding = 1e-15; /* rounding error of a closure error */
/* Approximate reduction of the error by a Newton step with the pivots of the previous evaluation. */
static const double old_pivot_gain = 20.0;

static double largest_primary(const km_factor *p, const double *error) {
  const int rank = km_factor_rank(p), *row = km_factor_row_order(p);
  double largest = 0.0;
  for (int i = 0; i < rank; ++i)
    largest = km_larger_or_nan(fabs(error[row[i]]), largest);
  return largest;
}

/* Factors the present Jacobian, with the columns in s->forced kept independent if possible. False: they can't be. */
static bool factor_jacobian(const km_mechanism *m, km_state *s, int index, double growth_reference) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  const km_factor_options options = {.tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub)),
                                     .forced = s->forced,
                                     .locked = km_state_locked_columns(s, index),
                                     .growth_reference = growth_reference};
  km_factor_compute(p, km_state_jacobian(s, sub), sub->rows, sub->columns, &options);
  memset(s->forced, 0, (size_t)sub->columns * sizeof *s->forced);
  return !km_factor_has_failed(p) && !km_factor_has_forced_pivot(p);
}

/* Finds a new partition at the present Jacobian; prescribed columns stay independent. */
static bool find_partition(km_dynamics *d, km_state *s, int index) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  const int *coordinate = d->mechanism->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k)
    s->forced[k] = d->driven[coordinate[k]];
  s->pivot_driver[index] = KM_PRESCRIBED;
  d->repartitions[index]++;
  bool found = factor_jacobian(d->mechanism, s, index, 0.0);
  const km_factor *p = s->factor[index];
  for (int i = 0; i < km_factor_rank(p) && !found && km_factor_has_forced_pivot(p); ++i)
    if (d->driven[coordinate[km_factor_column_order(p)[i]]])
      d->overprescribed = coordinate[km_factor_column_order(p)[i]];
  return found;
}

/* Refactors with another pivot order for the same partition, if its B is acceptable and only pivots became small. */
static bool repivot_partition(const km_mechanism *m, km_state *s, int index) {
  const km_factor *p = s->factor[index];
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  if (!km_is_b_growth_acceptable(evidence.max_b, evidence.max_b_at_search))
    return false;
  for (int i = km_factor_rank(p); i < m->substructures[index].columns; ++i)
    s->forced[km_factor_column_order(p)[i]] = true;
  return factor_jacobian(m, s, index, evidence.max_b_at_search); /* the partition itself is not newer */
}

/* True if the pivots are acceptable until the end of the step: max|B| has grown at most eightfold. */
static bool is_usable_within_step(const km_factor *p) {
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  return evidence.max_b <= max_growth * fmax(evidence.max_b_at_search, 1.0);
}

/* Repartitions during a motion. First the dependent rates are computed with the old pivots, so that the motion does
 * not jump to the vector's drifted values of its new independent coordinates. */
static bool change_pivots(km_dynamics *d, km_state *s, int index) {
  const km_mechanism *m = d->mechanism;
  const int *coordinate = m->column_coordinate + m->substructures[index].column_start;
  const km_factor *p = s->factor[index];
  bool follows = !d->uses_baumgarte && isfinite(km_factor_get_evidence(p).max_b);
  memset(d->step, 0, (size_t)km_factor_rank(p) * sizeof *d->step);
  for (int k = 0; k < km_factor_freedom(p) && follows; ++k) {
    const double *B = km_factor_b(p, k);
    int c = coordinate[km_factor_column_order(p)[km_factor_rank(p) + k]];
    for (int i = 0; i < km_factor_rank(p); ++i)
      d->step[i] -= B[i] * s->rate[c] / m->unit[c];
  }
  for (int i = 0; i < km_factor_rank(p) && follows; ++i)
    s->rate[coordinate[km_factor_column_order(p)[i]]] = d->step[i] * m->unit[coordinate[km_factor_column_order(p)[i]]];
  d->changed_pivots = true;
  return find_partition(d, s, index);
}

/* One Newton step of the dependent coordinates with the present pivots. False: too long or not finite. */
static bool step_dependent(km_dynamics *d, km_state *s, int index) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  double size = 0.0;
  km_factor_solve(s->factor[index], km_state_error(s, sub), d->step);
  for (int k = 0; k < sub->columns; ++k) {
    d->step[k] = -d->step[k];
    size = fabs(d->step[k]) <= size ? size : fabs(d->step[k]);
  }
  if (!(size < max_newton_step))
    return false;
  km_state_move(d->mechanism, s, sub, d->step);
  km_loops_recompute(d->mechanism, s, sub);
  return true;
}

/* Largest reciprocal of a pivot: growth of a loop error in the coordinates. */
static double weakness_of(const km_factor *p) {
  return fmax(1.0, 1.0 / km_factor_smallest_pivot(p));
}

/* Error at which loops count as closed, reduced by the weakness of the constraints. */
static double closing_target(const km_dynamics *d, const km_factor *p, bool search) {
  return fmax((search ? accepted_tolerance : d->closing_tolerance) / weakness_of(p), loop_rounding);
}

/* Refactors the present Jacobian with the present pivots; finds others if they became unacceptable at an accepted
 * configuration. */
static bool refactor(km_dynamics *d, km_state *s, int index, bool search) {
  km_factor *p = s->factor[index];
  if (km_factor_refactor(p, km_state_jacobian(s, &d->mechanism->substructures[index]), KM_BASIS_SHORT))
    return true;
  d->stale = true;
  if (!search)
    return is_usable_within_step(p);
  return repivot_partition(d->mechanism, s, index) || change_pivots(d, s, index);
}

/* True if the prescribed columns are independent; the state's pivots can come from other equations of motion. */
static bool are_prescribed_independent(const km_dynamics *d, const km_factor *p, int index) {
  const int *coordinate = d->mechanism->column_coordinate + d->mechanism->substructures[index].column_start;
  for (int i = 0; i < km_factor_rank(p); ++i)
    if (d->driven[coordinate[km_factor_column_order(p)[i]]])
      return false;
  return true;
}

/* Closes the loops by Newton's method on the dependent coordinates, with the previous pivots as long as they reduce
 * the error. Pivots and Jacobian are finally those of the closed configuration. */
static bool close_loops(km_dynamics *d, km_state *s, int index, bool search) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  km_factor *p = s->factor[index];
  km_loops_recompute(d->mechanism, s, sub);
  bool is_valid = s->pivot_driver[index] == KM_PRESCRIBED && are_prescribed_independent(d, p, index);
  if (!is_valid && !find_partition(d, s, index))
    return false;
  double error = largest_primary(p, km_state_error(s, sub)), last = HUGE_VAL;
  bool fresh = false, open = !d->uses_baumgarte || search;
  d->residual = error <= d->residual ? d->residual : error;
  for (int steps = 0; open || !fresh;) {
    double closed = closing_target(d, p, search);
    if (!fresh && (!open || error <= closed || error > old_pivot_gain * closed || !(error < 0.1 * last))) {
      if (!refactor(d, s, index, search))
        return false;
      fresh = true;
      continue;
    }
    if (error <= closed || (steps > 3 && error < rounding && !(error < 0.1 * last))) /* stagnation at rounding */
      break;
    if (steps++ == MAX_STEPS || !step_dependent(d, s, index))
      return false;
    fresh = false;
    last = error;
    error = largest_primary(p, km_state_error(s, sub));
  }
  d->weakness = fmax(d->weakness, weakness_of(p));
  return true;
}

/* Allocates the cluster's arrays for `count` independent coordinates, at least one. They grow only if a partition
 * has more than before. */
static bool reserve_cluster(km_dynamics *d, km_cluster_motion *c, const km_cluster *cluster, size_t count) {
  if (count <= c->capacity && c->capacity > 0)
    return true;
  count = count > 0 ? count : 1;
  size_t n = (size_t)cluster->coordinate_count;
  c->independent = KM_ARENA_NEW(&d->arena, int, count);
  c->N = KM_ARENA_NEW(&d->arena, double, count *n);
  c->P = KM_ARENA_NEW(&d->arena, km_twist, count * (size_t)cluster->node_count);
  c->U = KM_ARENA_NEW(&d->arena, km_wrench, count);
  c->D = KM_ARENA_NEW(&d->arena, double, count *count);
  c->b = KM_ARENA_NEW(&d->arena, double, count);
  c->udot = KM_ARENA_NEW(&d->arena, double, count);
  c->capacity = d->arena.failed ? 0 : count;
  return !d->arena.failed;
}

/* Lists the cluster's independent coordinates: of each partition, then those in no substructure; free ones first,
 * then prescribed ones. */
static bool list_independent(km_dynamics *d, const km_state *s, int index) {
  const km_mechanism *m = d->mechanism;
  const km_cluster *cluster = &d->tree.clusters[index];
  km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  size_t count = 0;
  int in_substructures = 0;
  for (int i = 0; i < cluster->substructure_count; ++i) {
    int sub = d->tree.substructure_order[cluster->substructure_start + i];
    in_substructures += m->substructures[sub].columns;
    count += (size_t)km_factor_freedom(s->factor[sub]);
  }
  count += (size_t)(cluster->coordinate_count - in_substructures);
  if (!reserve_cluster(d, c, cluster, count))
    return false;
  int k = 0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0, first = 0; i < cluster->substructure_count; ++i) {
      int sub = d->tree.substructure_order[cluster->substructure_start + i];
      const km_factor *p = s->factor[sub];
      for (int o = km_factor_rank(p); o < m->substructures[sub].columns; ++o)
        if (d->driven[coordinates[first + km_factor_column_order(p)[o]]] == (pass == 1))
          c->independent[k++] = first + km_factor_column_order(p)[o];
      first += m->substructures[sub].columns;
    }
    for (int o = in_substructures; o < cluster->coordinate_count; ++o)
      if (d->driven[coordinates[o]] == (pass == 1))
        c->independent[k++] = o;
    if (pass == 0)
      c->freedom = k;
  }
  c->driven = k - c->freedom;
  return true;
}

/* Computes N of the cluster, in radians and the model's length unit. */
static void compute_N(km_dynamics *d, const km_state *s, int index) {
  const km_mechanism *m = d->mechanism;
  const km_cluster *cluster = &d->tree.clusters[index];
  km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  int n = cluster->coordinate_count, count = c->freedom + c->driven;
  if (count == 0)
    return;
  memset(c->N, 0, (size_t)count * (size_t)n * sizeof *c->N);
  for (int k = 0; k < count; ++k) {
    double *N = c->N + (size_t)k * (size_t)n;
    int own = c->independent[k], sub = m->substructure_of[coordinates[own]];
    N[own] = 1.0;
    if (sub < 0)
      continue;
    const km_factor *p = s->factor[sub];
    int column = m->column_of[coordinates[own]], first = own - column, position = km_factor_rank(p);
    while (km_factor_column_order(p)[position] != column)
      ++position;
    const double *B = km_factor_b(p, position - km_factor_rank(p));
    double inverse = 1.0 / m->unit[coordinates[own]];
    for (int i = 0; i < km_factor_rank(p); ++i) {
      int dependent = first + km_factor_column_order(p)[i];
      N[dependent] = -B[i] * m->unit[coordinates[dependent]] * inverse;
    }
  }
}

/* Computes all rates from the independent ones, q̇ = N u. */
static void project_rates(km_dynamics *d, km_state *s, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  const km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  int n = cluster->coordinate_count, count = c->freedom + c->driven;
  for (int i = 0; i < n; ++i)
    c->gamma[i] = 0.0; /* holds the rates until all are known */
  for (int k = 0; k < count; ++k) {
    const double *N = c->N + (size_t)k * (size_t)n;
    double rate = s->rate[coordinates[c->independent[k]]];
    for (int i = 0; i < n; ++i)
      c->gamma[i] += N[i] * rate;
  }
  for (int i = 0; i < n; ++i)
    s->rate[coordinates[i]] = c->gamma[i];
}

/* Baumgarte's stabilisation: γ ← γ − 2 ω ė − ω² e with ė = J q̇. */
static void add_baumgarte(km_dynamics *d, const km_state *s, const km_substructure *sub) {
  const km_mechanism *m = d->mechanism;
  const km_pattern *pattern = &sub->pattern;
  const double *J = s->jacobian + sub->matrix_start, *e = s->error + sub->error_start, w = d->omega;
  for (int r = 0; r < sub->rows; ++r)
    d->row[r] -= w * w * e[r];
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    double rate = 2.0 * w * s->rate[c] / m->unit[c];
    if (pattern->start)
      for (int i = pattern->start[k]; i < pattern->start[k + 1]; ++i)
        d->row[pattern->row[i]] -= J[i] * rate;
    else
      for (int r = 0; r < sub->rows; ++r)
        d->row[r] -= J[(size_t)k * (size_t)sub->rows + (size_t)r] * rate;
  }
}

/* Computes γ: velocity products of the loops for dependent coordinates, plus the prescribed accelerations. */
static void compute_gamma(km_dynamics *d, km_state *s, int index) {
  const km_mechanism *m = d->mechanism;
  const km_cluster *cluster = &d->tree.clusters[index];
  km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  int n = cluster->coordinate_count;
  memset(c->gamma, 0, (size_t)n * sizeof *c->gamma);
  for (int i = 0, first = 0; i < cluster->substructure_count; ++i) {
    int index_of = d->tree.substructure_order[cluster->substructure_start + i];
    const km_substructure *sub = &m->substructures[index_of];
    km_loops_velocity_products(m, s, sub, s->rate, d->row);
    if (d->uses_baumgarte)
      add_baumgarte(d, s, sub);
    km_factor_solve(s->factor[index_of], d->row, d->step);
    for (int k = 0; k < sub->columns; ++k)
      c->gamma[first + k] = m->unit[coordinates[first + k]] * d->step[k];
    first += sub->columns;
  }
  for (int k = c->freedom; k < c->freedom + c->driven; ++k) {
    const double *N = c->N + (size_t)k * (size_t)n;
    double udot = d->driven_acceleration[coordinates[c->independent[k]]];
    c->udot[k] = udot;
    for (int i = 0; i < n; ++i)
      c->gamma[i] += N[i] * udot;
  }
}

/* Closes all loops, then computes N and dependent rates of all clusters. */
static bool update_loops(km_dynamics *d, km_state *s, bool search) {
  const km_topology *t = &d->mechanism->topology;
  d->residual = 0.0;
  d->weakness = 1.0;
  d->stale = d->changed_pivots = false;
  d->overprescribed = -1;
  for (int i = 0; i < t->substructure_count; ++i)
    if (!close_loops(d, s, i, search))
      return false;
  for (int i = 0; i < d->tree.cluster_count; ++i) {
    if (!list_independent(d, s, i))
      return false;
    compute_N(d, s, i);
    if (!d->uses_baumgarte || search)
      project_rates(d, s, i);
  }
  return true;
}

bool km_constraints_close(km_dynamics *d, km_state *s, bool search) {
  bool closed = update_loops(d, s, search);
  if (!closed)
    d->open = d->residual;
  return closed;
}

void km_constraints_velocity_products(km_dynamics *d, km_state *s) {
  for (int i = 0; i < d->tree.cluster_count; ++i)
    compute_gamma(d, s, i);
}
