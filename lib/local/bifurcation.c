/* The motions that meet at a branch point, and leaving one. */
#include "local/bifurcation.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/nearest_configuration.h"
#include "local/constant_rank_motion.h"
#include "local/sampled_tangents.h"

#include <string.h>

/* Counts the direction behind the `found` ones if it isn't one of them, in one sense or the other. */
static int count_new(const km_tangents *f, const double *directions, int found) {
  size_t n = (size_t)f->sub->columns;
  for (int i = 0; i < found; ++i)
    if (km_is_same_tangent(km_step_dot(f->m, f->sub, directions + (size_t)found * n, directions + (size_t)i * n)))
      return found;
  return found + 1;
}

static int find_in_few(km_tangents *f, double *directions) {
  int found = 0;
  size_t k = (size_t)f->conditions.freedom;
  double length;
  if (!km_tangents_create_basis(f) || km_tangents_are_regular(f) || km_tangents_all_finite(f))
    return 0;
  double *known = KM_ARENA_NEW(f->arena, double, KM_MAX_BRANCHES *k);
  while (known && found < KM_MAX_BRANCHES && km_tangents_find_next(f, known, found, &length)) {
    memcpy(known + (size_t)found * k, f->a, k * sizeof *known);
    km_tangents_direction(f, f->a, directions + (size_t)found++ * (size_t)f->sub->columns);
  }
  return found;
}

static int find_in_many(km_tangents *f, double *directions) {
  km_sampled_tangents many;
  int found = 0;
  double length;
  if (km_sampled_tangents_create(&many, f) && !km_sampled_tangents_all_finite(&many, &length))
    while (found < KM_MAX_BRANCHES && km_sampled_tangents_find_next(&many, &length)) {
      memcpy(directions + (size_t)found * (size_t)f->sub->columns, many.x, (size_t)f->sub->columns * sizeof *many.x);
      found = count_new(f, directions, found);
    }
  km_sampled_tangents_free(&many);
  return found;
}

/* Are all rows independent, so that no motions meet at the pose? Its pivots are searched then. */
static bool is_regular(const km_mechanism *m, km_state *s, int index) {
  km_second_order conditions;
  return km_second_order_count_tangents(m, s, index, &conditions) && !conditions.has_redundant_rows;
}

/* Does the mechanism shake at the pose as it does all along its motion? That isn't a branch point. */
static bool shakes_along(const km_mechanism *m, km_state *s, int index) {
  km_arena arena = {0};
  km_constant_rank steady = {0};
  km_constant_rank_begin(&steady, m, s, index, KM_NO_DRIVER, &arena);
  km_arena_free(&arena);
  return steady.is_active;
}

int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  if (is_regular(m, s, index))
    return 0;
  km_arena arena = {0};
  km_tangents f;
  int found = 0;
  bool made = km_tangents_create(&f, m, s, index, &arena);
  f.min_verdict = KM_TANGENT_UNDECIDED; /* rounded data have branches too */
  if (made)
    found = (km_tangents_are_many(&f) ? find_in_many : find_in_few)(&f, directions);
  if (arena.failed) {
    found = -1;
  } else {
    km_state_restore(s, f.sub, f.origin);
    km_loops_update(m, s, f.sub);
    km_search_pivots(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, f.sub, 0.0));
  }
  km_arena_free(&arena);
  return found;
}

static int fastest(const double *directions, int count, int columns, int column) {
  int best = -1;
  double largest = 0.0;
  for (int i = 0; i < count; ++i) {
    double rate = fabs(directions[(size_t)i * (size_t)columns + (size_t)column]);
    if (rate > 1.000001 * largest) {
      largest = rate;
      best = i;
    }
  }
  return best;
}

/* A step from a branch point. */
typedef struct departure {
  const km_mechanism *m;
  km_state *s;
  int index, column;
  const km_substructure *sub;
  km_arena arena;
  double *from, *there, *best; /* saved poses: the branch point, the last one on the way, the best one so far */
  double *step;                /* [columns] */
} departure;

/* The fastest coordinate goes so far. */
static const double short_step = 5e-3;
/* The driver goes so far at least where the shortest way is sought: the square is what loops on it open by. */
static const double least_way = 1e-5;
/* Of the rate of the first direction that is tried: others that move the driver less are no shorter way. */
static const double least_rate = 0.1;

static void go(const departure *d, const double *direction, double length) {
  for (int k = 0; k < d->sub->columns; ++k)
    d->step[k] = length * direction[k];
  km_state_restore(d->s, d->sub, d->from);
  km_state_move(d->m, d->s, d->sub, d->step);
  km_state_invalidate_pivots(d->s, d->index);
}

/* Closes the loops with `driver` held: by all rows that the closed pose has, or by those at hand, where they are of a pose near by.
 * Few rows are far from depending on each other here: their null vectors, of which nothing is asked, would be long. */
static bool close(const departure *d, int driver, bool by_all) {
  km_partition *p = &d->s->partition[d->index];
  km_closure evidence;
  p->rows_only = p->sparse != NULL;
  km_closure_outcome outcome = by_all ? km_close_fully(km_close_with_driver, d->m, d->s, d->index, driver, &evidence)
                                      : km_close_with_driver(d->m, d->s, d->index, driver, &evidence);
  p->rows_only = false;
  return outcome == KM_CLOSED;
}

/* On to the pose closest to the branch point: by poses closest to where a part of the way back leads, all of it at last, which is
 * closed by all rows. Where none is found nearby the state stays. */
static void draw_near(departure *d) {
  enum { MOST_PARTS = 40 };
  static const double least_part = 1e-3;
  km_nearest_configuration closest;
  if (d->m->ball_count > 0 || !km_nearest_configuration_reserve(&closest, d->m, d->sub, &d->arena))
    return;
  double part = 0.5, *away = closest.displacement;
  bool near = false;
  for (int i = 0; i < MOST_PARTS && !near && part > least_part; ++i) {
    km_state_save(d->s, d->sub, d->there);
    km_state_difference(d->s, d->sub, d->from, away);
    double length = km_step_length(d->m, d->sub, away);
    for (int k = 0; k < d->sub->columns; ++k)
      away[k] *= part;
    bool found =
        km_nearest_configuration_find(&closest, d->m, d->s, d->index, d->column, &d->s->partition[d->index], away);
    km_state_difference(d->s, d->sub, d->from, away);
    double shorter = km_step_length(d->m, d->sub, away);
    const bool last = part == 1.0;
    found = found && shorter <= length && close(d, d->column, last);
    near = found && last;
    part = !found ? 0.5 * part : shorter > 0.9 * length ? fmin(1.0, 2.0 * part) : part;
    if (!found)
      km_state_restore(d->s, d->sub, d->there);
  }
}

/* Along a direction. False where one freedom is left there. */
static bool set_out(departure *d, const double *direction, double way) {
  double most = 0.0, rate = direction[d->column], side = way * rate < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k < d->sub->columns; ++k)
    most = fmax(most, fabs(direction[k]));
  double length = short_step / most;
  go(d, direction, length);
  close(d, KM_NO_DRIVER, true);
  if (km_partition_freedom(&d->s->partition[d->index]) <= 1)
    return false;
  km_state_save(d->s, d->sub, d->there);
  length = way != 0.0 ? fmin(length, fabs(way / rate)) : length;
  go(d, direction, side * length);
  if (!close(d, d->column, true))
    km_state_restore(d->s, d->sub, d->there);
  else if (length * fabs(rate) > least_way)
    draw_near(d);
  return true;
}

/* The way from the branch point to the state's pose over the coordinate's. */
static double relative_length(const departure *d) {
  km_state_difference(d->s, d->sub, d->from, d->step);
  return km_step_length(d->m, d->sub, d->step) / fabs(d->step[d->column]);
}

/* Where several freedoms are left, the pose that any of the directions leads to with the shortest way. */
static void take_shortest(departure *d, const double *directions, int count, int first, double way) {
  double shortest = relative_length(d);
  km_state_save(d->s, d->sub, d->best);
  for (int i = 0; i < count; ++i) {
    const double *direction = directions + (size_t)i * (size_t)d->sub->columns;
    double rate = direction[d->column] / directions[(size_t)first * (size_t)d->sub->columns + (size_t)d->column];
    if (i == first || fabs(rate) < least_rate || !set_out(d, direction, way) || !(relative_length(d) < shortest))
      continue;
    shortest = relative_length(d);
    km_state_save(d->s, d->sub, d->best);
  }
  km_state_restore(d->s, d->sub, d->best);
}

km_branch_exit km_branch_depart(const km_mechanism *m, km_state *s, int coordinate, double way) {
  int index = m->substructure_of[coordinate];
  km_branch_exit out = {0};
  if (index < 0 || km_state_is_fixed(s, coordinate) || is_regular(m, s, index) || shakes_along(m, s, index))
    return out; /* a held one leads nowhere */
  const km_substructure *sub = &m->substructures[index];
  size_t n = (size_t)sub->columns;
  departure d = {.m = m, .s = s, .index = index, .column = m->column_of[coordinate], .sub = sub};
  double *directions = KM_ARENA_NEW(&d.arena, double, KM_MAX_BRANCHES *n);
  d.from = KM_ARENA_NEW(&d.arena, double, KM_SAVED_PER_COLUMN *n);
  d.there = KM_ARENA_NEW(&d.arena, double, KM_SAVED_PER_COLUMN *n);
  d.best = KM_ARENA_NEW(&d.arena, double, KM_SAVED_PER_COLUMN *n);
  d.step = KM_ARENA_NEW(&d.arena, double, n);
  out.branch_count = d.arena.failed ? -1 : km_branch_directions(m, s, index, directions);
  int best = fastest(directions, out.branch_count, sub->columns, d.column);
  if (best >= 0) {
    km_state_save(s, sub, d.from);
    way *= m->factor[coordinate] / m->unit[coordinate];
    out.has_further_freedoms = set_out(&d, directions + (size_t)best * n, way);
    if (out.has_further_freedoms)
      take_shortest(&d, directions, out.branch_count, best, way);
    km_state_invalidate_pivots(s, index);
  }
  out.branch_count = d.arena.failed ? -1 : out.branch_count;
  km_arena_free(&d.arena);
  return out;
}
