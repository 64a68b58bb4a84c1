/* Closed loops in the equations of motion: partitions, dependent coordinates, rates and velocity products. */
#include "dynamics/dynamics.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MOST_STEPS = 12 };
static const double most_growth = 8.0;
/* Error of the dependent coordinates at an accepted pose; what rounding may leave of many turns; longest step. Scaled. */
static const double tightly = 1e-13, rounding = 1e-9, longest = 0.5;
static const double least = 1e-15; /* rounding of a loop's error */
/* A step by the last evaluation's pivots shrinks an error about as much. */
static const double stale_gain = 20.0;

static double largest_primary(const km_partition *p, const double *error) {
  double largest = 0.0;
  for (int i = 0; i < p->rank; ++i)
    largest = km_larger_or_nan(fabs(error[p->row[i]]), largest);
  return largest;
}

/* Pivots at the present Jacobian, with the columns in s->forced independent if that is possible. */
static bool factor(const km_mechanism *m, km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  int worst;
  double tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst));
  km_partition_factor(p, km_state_jacobian(s, sub), sub->rows, sub->columns, s->forced, tolerance);
  memset(s->forced, 0, (size_t)sub->columns * sizeof *s->forced);
  return !p->failed && !p->forced_dependent;
}

/* A new partition at the present Jacobian; prescribed columns stay independent. */
static bool search_pivots(km_dynamics *d, km_state *s, int index) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  const int *coordinate = d->mechanism->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k)
    s->forced[k] = d->driven[coordinate[k]];
  s->pivot_driver[index] = KM_PRESCRIBED;
  d->renewed[index]++;
  bool found = factor(d->mechanism, s, index);
  const km_partition *p = &s->partition[index];
  for (int i = 0; i < p->rank && !found && p->forced_dependent; ++i)
    if (d->driven[coordinate[p->column[i]]])
      d->overdriven = coordinate[p->column[i]];
  return found;
}

/* Pivots in another order for the partition at hand, where that one is good and only pivots have become small. */
static bool keep_partition(const km_mechanism *m, km_state *s, int index) {
  km_partition *p = &s->partition[index];
  double pivoted_b = p->max_b_at_search;
  if (!km_is_b_growth_acceptable(p->max_b, pivoted_b))
    return false;
  for (int i = p->rank; i < p->columns; ++i)
    s->forced[p->column[i]] = true;
  bool kept = factor(m, s, index);
  p->max_b_at_search = pivoted_b; /* the partition is as old as it was */
  return kept;
}

/* Can the motion go on with these pivots until a pose is accepted? */
static bool carries_on(const km_partition *p) {
  return p->max_b <= most_growth * fmax(p->max_b_at_search, 1.0);
}

/* Other pivots within a motion: first the dependent rates are made to follow by those that served up to here, so that the
 * motion doesn't jump to what the vector holds of its new independent coordinates. */
static bool change_pivots(km_dynamics *d, km_state *s, int index) {
  const km_mechanism *m = d->mechanism;
  const int *coordinate = m->column_coordinate + m->substructures[index].column_start;
  const km_partition *p = &s->partition[index];
  bool follows = !d->feeds_back && isfinite(p->max_b);
  memset(d->step, 0, (size_t)p->rank * sizeof *d->step);
  for (int k = 0; k < km_partition_freedom(p) && follows; ++k) {
    const double *B = km_partition_b(p, k);
    int c = coordinate[p->column[p->rank + k]];
    for (int i = 0; i < p->rank; ++i)
      d->step[i] -= B[i] * s->rate[c] / m->unit[c];
  }
  for (int i = 0; i < p->rank && follows; ++i)
    s->rate[coordinate[p->column[i]]] = d->step[i] * m->unit[coordinate[p->column[i]]];
  d->repivoted = true;
  return search_pivots(d, s, index);
}

/* One step of the dependent coordinates by the pivots at hand; the others stay. False where it is none. */
static bool step_dependent(km_dynamics *d, km_state *s, int index) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  double size = 0.0;
  km_partition_solve(&s->partition[index], km_state_error(s, sub), d->step);
  for (int k = 0; k < sub->columns; ++k) {
    d->step[k] = -d->step[k];
    size = fabs(d->step[k]) <= size ? size : fabs(d->step[k]);
  }
  if (!(size < longest))
    return false;
  km_state_move(d->mechanism, s, sub, d->step);
  km_loops_recompute(d->mechanism, s, sub);
  return true;
}

/* The largest reciprocal of a pivot: by how much an error of the loops grows in the coordinates. */
static double weakness_of(const km_partition *p) {
  double largest = 1.0;
  for (int i = 0; i < p->rank; ++i)
    largest = fmax(largest, fabs(p->inverse[i]));
  return largest;
}

/* The error at which loops count as closed: where constraints are weak it grows in the coordinates. */
static double close_enough(const km_dynamics *d, const km_partition *p, bool search) {
  return fmax((search ? tightly : d->closing) / weakness_of(p), least);
}

/* The pivots at hand on the present Jacobian; others where a pose is accepted and they don't serve any more. */
static bool refresh(km_dynamics *d, km_state *s, int index, bool search) {
  km_partition *p = &s->partition[index];
  if (km_partition_refactor(p, km_state_jacobian(s, &d->mechanism->substructures[index])))
    return true;
  d->stale = true;
  if (!search)
    return carries_on(p);
  return keep_partition(d->mechanism, s, index) || change_pivots(d, s, index);
}

/* Are the prescribed columns independent? The pivots at hand may be those of other equations that had this state. */
static bool serves_drives(const km_dynamics *d, const km_partition *p, int index) {
  const int *coordinate = d->mechanism->column_coordinate + d->mechanism->substructures[index].column_start;
  for (int i = 0; i < p->rank; ++i)
    if (d->driven[coordinate[p->column[i]]])
      return false;
  return true;
}

/* Newton on the dependent coordinates, with pivots of the last evaluation where they are good enough for a step. Pivots and
 * Jacobian are then those of the closed pose. */
static bool close_loops(km_dynamics *d, km_state *s, int index, bool search) {
  const km_substructure *sub = &d->mechanism->substructures[index];
  km_partition *p = &s->partition[index];
  km_loops_recompute(d->mechanism, s, sub);
  bool served = s->pivot_driver[index] == KM_PRESCRIBED && serves_drives(d, p, index);
  if (!served && !search_pivots(d, s, index))
    return false;
  double error = largest_primary(p, km_state_error(s, sub)), last = HUGE_VAL;
  bool fresh = false, open = !d->feeds_back || search;
  d->residual = error <= d->residual ? d->residual : error;
  for (int steps = 0; open || !fresh;) {
    double closed = close_enough(d, p, search);
    if (!fresh && (!open || error <= closed || error > stale_gain * closed || !(error < 0.1 * last))) {
      if (!refresh(d, s, index, search))
        return false;
      fresh = true;
      continue;
    }
    if (error <= closed || (steps > 3 && error < rounding && !(error < 0.1 * last))) /* it doesn't become smaller */
      break;
    if (steps++ == MOST_STEPS || !step_dependent(d, s, index))
      return false;
    fresh = false;
    last = error;
    error = largest_primary(p, km_state_error(s, sub));
  }
  d->weakness = fmax(d->weakness, weakness_of(p));
  return true;
}

/* Room for the cluster's independent coordinates, at least for one, so that there are addresses to count from. Grows only where
 * a partition has more of them than ever before. */
static bool reserve(km_dynamics *d, km_cluster_motion *c, const km_cluster *cluster, size_t count) {
  if (count <= c->room && c->room > 0)
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
  c->room = d->arena.failed ? 0 : count;
  return !d->arena.failed;
}

/* Which coordinates of the cluster are independent: those of each partition, then those in no substructure; of both
 * kinds first the free ones, then the prescribed. */
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
    count += (size_t)km_partition_freedom(&s->partition[sub]);
  }
  count += (size_t)(cluster->coordinate_count - in_substructures);
  if (!reserve(d, c, cluster, count))
    return false;
  int k = 0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0, first = 0; i < cluster->substructure_count; ++i) {
      int sub = d->tree.substructure_order[cluster->substructure_start + i];
      const km_partition *p = &s->partition[sub];
      for (int o = p->rank; o < p->columns; ++o)
        if (d->driven[coordinates[first + p->column[o]]] == (pass == 1))
          c->independent[k++] = first + p->column[o];
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

/* N of the cluster, in radians and the model's length unit. */
static void fill_N(km_dynamics *d, const km_state *s, int index) {
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
    const km_partition *p = &s->partition[sub];
    int column = m->column_of[coordinates[own]], first = own - column, place = p->rank;
    while (p->column[place] != column)
      ++place;
    const double *B = km_partition_b(p, place - p->rank);
    double inverse = 1.0 / m->unit[coordinates[own]];
    for (int i = 0; i < p->rank; ++i) {
      int dependent = first + p->column[i];
      N[dependent] = -B[i] * m->unit[coordinates[dependent]] * inverse;
    }
  }
}

/* The dependent rates, by the independent ones; where errors are fed back, rates stay as they are. */
static void follow_rates(km_dynamics *d, km_state *s, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  const km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  int n = cluster->coordinate_count, count = c->freedom + c->driven;
  for (int i = 0; i < n; ++i)
    c->gamma[i] = 0.0; /* the rates, until they are all known */
  for (int k = 0; k < count; ++k) {
    const double *N = c->N + (size_t)k * (size_t)n;
    double rate = s->rate[coordinates[c->independent[k]]];
    for (int i = 0; i < n; ++i)
      c->gamma[i] += N[i] * rate;
  }
  for (int i = 0; i < n; ++i)
    s->rate[coordinates[i]] = c->gamma[i];
}

/* γ − 2ω ė − ω² e with ė = J q̇. */
static void feed_back(km_dynamics *d, const km_state *s, const km_substructure *sub) {
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

/* γ: of dependent coordinates the velocity products of their loops, and what prescribed accelerations make. */
static void find_gamma(km_dynamics *d, km_state *s, int index) {
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
    if (d->feeds_back)
      feed_back(d, s, sub);
    km_partition_solve(&s->partition[index_of], d->row, d->step);
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

static bool update(km_dynamics *d, km_state *s, bool search) {
  const km_topology *t = &d->mechanism->topology;
  d->residual = 0.0;
  d->weakness = 1.0;
  d->stale = d->repivoted = false;
  d->overdriven = -1;
  for (int i = 0; i < t->substructure_count; ++i)
    if (!close_loops(d, s, i, search))
      return false;
  for (int i = 0; i < d->tree.cluster_count; ++i) {
    if (!list_independent(d, s, i))
      return false;
    fill_N(d, s, i);
    if (!d->feeds_back || search)
      follow_rates(d, s, i);
    find_gamma(d, s, i);
  }
  return true;
}

bool km_constraints_update(km_dynamics *d, km_state *s, bool search) {
  bool closed = update(d, s, search);
  if (!closed)
    d->open = d->residual;
  return closed;
}
