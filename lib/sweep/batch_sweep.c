/* Driven sweeps side by side: the way from row to row. */
#include "sweep/driver_sweep.h"

#include <math.h>
#include <string.h>

/* How many rows may be passed at once from the next one on, because the observer doesn't look at all of them. */
static int rows_ahead(const km_driver_sweep *w) {
  const km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->step == 0 || !r->observer->number_cells || r->out->start.stop || plan->derivatives || plan->point_count > 0)
    return 1;
  int left = plan->steps - w->step + 1;
  return left < KM_BATCH_ROWS ? left : KM_BATCH_ROWS;
}

/* An observer that looks at rows sees so many of those that were passed, the last ones. */
enum { KM_ROWS_SEEN = 2 };

/* Behind `count` rows that are written, of which the last one is at s. */
static void leave_rows(km_driver_sweep *w, int count, double s) {
  w->last = s;
  w->row += count;
  w->step += count;
}

/* The rows that were passed and that the observer doesn't see, at s[row × KM_BATCH_LANES], of `count` in all. */
static void write_unseen_rows(km_driver_sweep *w, int count, const double *s) {
  const int seen = !w->r->observer->seen ? 0 : count < KM_ROWS_SEEN ? count : KM_ROWS_SEEN, unseen = count - seen;
  w->job->status = km_sweeper_passed_rows(w->r, w->at.drive, unseen, w->row, s, w->job->error);
  if (unseen > 0)
    leave_rows(w, unseen, s[(unseen - 1) * KM_BATCH_LANES]);
}

/* A row that was passed, which the state shows. */
static void write_seen_row(km_driver_sweep *w, double s) {
  km_sweeper *r = w->r;
  r->rides = r->passed = true;
  r->residual = km_driver_motion_batched_residual(w->at.drive);
  if (!w->job->status)
    w->job->status = km_sweeper_row(r, w->row, s, w->job->error);
  r->passed = false;
  leave_rows(w, 1, s);
}

/* The rows that the walks `going` have passed. */
static void write_passed_rows(km_driver_sweep *walks, unsigned going, km_batch *lanes, int count, const double *rows) {
  for (unsigned rest = going; rest; rest &= rest - 1)
    write_unseen_rows(&walks[__builtin_ctz(rest)], count, rows + __builtin_ctz(rest));
  for (int k = count > KM_ROWS_SEEN ? count - KM_ROWS_SEEN : 0; k < count; ++k) {
    km_batch_write_row(lanes, k);
    for (unsigned rest = going; rest; rest &= rest - 1) {
      int i = __builtin_ctz(rest);
      if (walks[i].r->observer->seen)
        write_seen_row(&walks[i], rows[k * KM_BATCH_LANES + i]);
    }
  }
}

/* Does the observer look at more than the lane tells? */
static bool needs_state(const km_sweeper *r) {
  const km_observer *observer = r->observer;
  return observer->reads_jacobian ||
         (observer->reads_basis && km_partition_freedom(&r->s->partition[r->substructure]) > 1);
}

void km_driver_sweep_prepare(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  r->rides = km_driver_motion_is_batched(w->at.drive);
  if (r->rides && needs_state(r)) {
    km_driver_motion_prepare_read(w->at.drive);
    r->rides = false;
  }
  if (r->rides)
    r->residual = km_driver_motion_batched_residual(w->at.drive);
  if (r->rides && r->observer->reads_basis && !r->observer->asks_direction)
    km_driver_motion_read_basis(w->at.drive);
}

static bool is_shown_the_way(const km_driver_sweep *w) {
  return w->r->observer->passed && w->step > 0;
}

static km_sweep_way way_to(const km_driver_sweep *w, double s) {
  return (km_sweep_way){w->last, s, w->row == 1, w->step == w->r->plan->steps};
}

/* The way to the row at s, from the part `first` on, by the drive alone. */
static km_motion_end go_alone(km_driver_sweep *w, double s, int first) {
  km_sweep_way way = way_to(w, s);
  if (is_shown_the_way(w))
    w->job->status = km_sweeper_pass(w->r, w->at.drive, &way, first, w->job->error);
  return km_driver_motion_move_to(w->at.drive, s);
}

/* Do both drive the same range, and are at the same row? */
static bool same_row(const km_driver_sweep *a, const km_driver_sweep *b) {
  const km_sweep_plan *p = a->r->plan, *q = b->r->plan;
  return a->step == b->step && p->from == q->from && p->to == q->to && p->steps == q->steps;
}

/* Those of the walks `going` that do so with the first of them. */
static unsigned at_first_row(const km_driver_sweep *walks, unsigned going) {
  unsigned same = 0;
  for (unsigned rest = going; rest; rest &= rest - 1)
    same |= same_row(&walks[__builtin_ctz(going)], &walks[__builtin_ctz(rest)]) ? rest & -rest : 0;
  return same;
}

/* The targets of the walks `going`, k rows on, of which `same` have the same one. */
static void set_targets(const km_driver_sweep *walks, unsigned going, unsigned same, int k, double *targets) {
  const km_driver_sweep *first = &walks[__builtin_ctz(going)];
  double target = km_walk_value(first->r->plan, first->step + k);
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    targets[i] = target;
  for (unsigned rest = going & ~same; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    targets[i] = km_walk_value(walks[i].r->plan, walks[i].step + k);
  }
}

static bool any_looks(const km_driver_sweep *walks, unsigned going) {
  bool found = false;
  for (unsigned rest = going; rest; rest &= rest - 1)
    found = found || walks[__builtin_ctz(rest)].r->observer->seen;
  return found;
}

/* Moves the walks `going` in lanes: through rows that need no look, which are written, to the row behind them. targets[lane]: of
 * the next row, and then of the one where they arrive. */
static void move_beside(km_driver_sweep *walks, unsigned going, km_batch *lanes, double *targets,
                        km_motion_end *reaches) {
  double rows[KM_BATCH_ROWS * KM_BATCH_LANES];
  int count = KM_BATCH_ROWS;
  for (unsigned rest = going; rest; rest &= rest - 1) {
    int ahead = rows_ahead(&walks[__builtin_ctz(rest)]);
    count = ahead < count ? ahead : count;
  }
  unsigned same = at_first_row(walks, going);
  memcpy(rows, targets, KM_BATCH_LANES * sizeof *rows);
  for (int k = 1; k < count; ++k)
    set_targets(walks, going, same, k, rows + k * KM_BATCH_LANES);
  int passed = km_batch_advance_rows(lanes, going, rows, count, any_looks(walks, going));
  write_passed_rows(walks, going, lanes, passed, rows);
  memcpy(targets, rows + passed * KM_BATCH_LANES, KM_BATCH_LANES * sizeof *targets);
  km_batch_arrive(lanes, going, targets, reaches);
}

/* Those of the walks `going` whose observers are shown the way to the next row. */
static unsigned shown_their_way(const km_driver_sweep *walks, unsigned going) {
  unsigned found = 0;
  for (unsigned rest = going; rest; rest &= rest - 1)
    found |= is_shown_the_way(&walks[__builtin_ctz(rest)]) ? rest & -rest : 0;
  return found;
}

/* Moves the walks `riding`, which are at one row, over part k of their ways; those that can't in their lanes go to their rows
 * alone. Returns the others. */
static unsigned pass_part(km_driver_sweep *walks, unsigned riding, int k, km_batch *lanes, const double *targets,
                          km_motion_end *reaches) {
  double places[KM_BATCH_LANES] = {0}; /* registers also read those of lanes that don't ride */
  unsigned able = 0;
  int parts = km_sweeper_parts(walks[__builtin_ctz(riding)].r);
  for (unsigned rest = riding; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    km_sweep_way way = way_to(&walks[i], targets[i]);
    places[i] = km_sweeper_part(way.from, way.to, k, parts);
    able |= k == parts && way.ends ? 0 : rest & -rest;
  }
  unsigned there = km_batch_try(lanes, able, places, reaches);
  for (unsigned rest = riding & ~there; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    reaches[i] = go_alone(&walks[i], targets[i], k);
  }
  for (unsigned rest = k < parts ? there : 0; rest; rest &= rest - 1) {
    km_driver_sweep *w = &walks[__builtin_ctz(rest)];
    km_driver_sweep_prepare(w);
    w->job->status = w->r->observer->passed(w->r->observer->self, w->r, places[__builtin_ctz(rest)], w->job->error);
    w->r->rides = false;
    there &= w->job->status ? ~(rest & -rest) : ~0U;
  }
  return there;
}

/* Moves the walks `going` to their rows, in lanes as far as they go, and shows their observers the ways. */
static void pass_beside(km_driver_sweep *walks, unsigned going, km_batch *lanes, const double *targets,
                        km_motion_end *reaches) {
  unsigned riding = lanes ? shown_their_way(walks, going) : 0;
  riding = riding ? at_first_row(walks, riding) : 0;
  for (unsigned rest = going; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    if (riding >> i & 1 && !way_to(&walks[i], targets[i]).begins)
      continue;
    riding &= ~(1u << i);
    reaches[i] = go_alone(&walks[i], targets[i], 1);
  }
  int parts = riding ? km_sweeper_parts(walks[__builtin_ctz(riding)].r) : 0;
  for (int k = 1; k <= parts && riding; ++k)
    riding = pass_part(walks, riding, k, lanes, targets, reaches);
}

void km_driver_sweeps_advance(km_driver_sweep *walks, unsigned going, km_batch *lanes, double *targets,
                              km_motion_end *reaches) {
  if (lanes && going && !shown_their_way(walks, going))
    move_beside(walks, going, lanes, targets, reaches);
  else
    pass_beside(walks, going, lanes, targets, reaches);
}
