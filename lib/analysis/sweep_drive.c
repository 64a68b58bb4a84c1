/* Sweeps by one driven coordinate. */
#include "analysis/sweeper.h"

#include <math.h>
#include <string.h>

/* A drive, and whether it has left the row for a look at poses beside it. */
typedef struct seat {
  km_drive *drive;
  bool away;
} seat;

/* FROM is out of reach and the motion towards it ended at a bound: does s lie in what is left of the range? */
static bool reachable(const km_sweeper *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position, away = plan->to >= plan->from ? 1.0 : -1.0;
  return away * (bound - plan->from) > 0.0 && away * (s - bound) > 1e-9 * (1.0 + fabs(bound));
}

/* The rows of one sweep as they come: what is left to do, beside the sweeper. */
typedef struct walk {
  km_sweeper *r;
  km_sweep_job *job;
  seat at;
  int step, row; /* the next ones; step 0 leads to the first row */
  double last;
  int crossings; /* of the drive, at the last row */
  bool over;
} walk;

/* The driver's value at a step from 1 on. */
static double value_at(const km_sweep_plan *plan, int step) {
  return step == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * step / plan->steps;
}

/* The driver's next value; false where the sweep is over. */
static bool next(walk *w, double *target) {
  km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->job->status || w->over)
    return false;
  *target = plan->from;
  if (w->step == 0)
    return true;
  for (; w->step <= plan->steps; ++w->step) {
    double s = value_at(plan, w->step);
    if (r->out->start.stop && !reachable(r, s))
      continue;
    if (!km_sweeper_goes_on(r, w->step)) {
      w->job->status = km_fail(w->job->error, KM_CANCELLED, "stopped at %g", s);
      return false;
    }
    w->crossings = km_drive_crossings(w->at.drive);
    *target = s;
    return true;
  }
  return false;
}

/* How many rows may be passed at once from the next one on, because the observer doesn't look at all of them. */
static int rows_ahead(const walk *w) {
  const km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->step == 0 || !r->observer->number_cells || r->out->start.stop || plan->derivatives || plan->point_count > 0)
    return 1;
  int left = plan->steps - w->step + 1;
  return left < KM_DRIVE_ROWS ? left : KM_DRIVE_ROWS;
}

/* The quiet rows that were passed, at s[row × KM_DRIVE_LANES]. The observer sees the last one, which the state shows. */
static void write_passed_rows(walk *w, int count, const double *s) {
  km_sweeper *r = w->r;
  int last = count - 1;
  km_status status = km_sweeper_passed_rows(r, w->at.drive, last, w->row, s, w->job->error);
  r->rides = true;
  r->residual = km_drive_ridden_residual(w->at.drive);
  w->last = s[last * KM_DRIVE_LANES];
  w->row += count;
  w->step += count;
  w->job->status = status ? status : km_sweeper_row(r, w->row - 1, w->last, w->job->error);
}

/* Where the drive has arrived, and the observer is going to look. */
static void take_ride(walk *w) {
  km_sweeper *r = w->r;
  if (r->observer->reads_jacobian)
    km_drive_settle(w->at.drive);
  r->rides = km_drive_rides(w->at.drive);
  if (r->rides)
    r->residual = km_drive_ridden_residual(w->at.drive);
}

static bool is_shown_the_way(const walk *w) {
  return w->r->observer->passed && w->step > 0;
}

static km_sweep_way way_to(const walk *w, double s) {
  return (km_sweep_way){w->last, s, w->row == 1, w->step == w->r->plan->steps};
}

/* The way to the row at s, from the part `first` on, by the drive alone. */
static km_reach go_alone(walk *w, double s, int first) {
  km_sweep_way way = way_to(w, s);
  if (is_shown_the_way(w))
    w->job->status = km_sweeper_pass(w->r, w->at.drive, &way, first, w->job->error);
  return km_drive_to(w->at.drive, s);
}

/* The row where the drive has arrived; then what the observer wants to see near it has to follow. */
static void write_row(walk *w, km_reach reach) {
  km_sweeper *r = w->r;
  km_status status = KM_OK;
  if (w->job->status) /* on the way */
    return;
  take_ride(w);
  r->out->end = reach;
  if (w->step == 0)
    r->out->start = reach;
  bool again = w->step > 0 && reach.stop && fabs(reach.position - w->last) <= 1e-9 * (1.0 + fabs(w->last));
  if (reach.stop == KM_STOP_GAVE_OUT)
    status = km_fail(
        w->job->error, KM_DIVERGED,
        "the sweep gave out at %.9g: too many steps to the next row; expected a range that so many rows resolve",
        reach.position);
  else if (!again) /* the end may be where the last row stands already */
    status = km_sweeper_row(r, w->row++, reach.position, w->job->error);
  w->job->status = status;
}

/* Shows the walks `going` what their observers want to see near the row, side by side as long as they ride. */
static void show_beside(walk *walks, unsigned going, km_drive_lanes *lanes) {
  double places[KM_DRIVE_LANES], *rates[KM_DRIVE_LANES];
  while (going) {
    unsigned wanting = going;
    for (unsigned rest = wanting; rest; rest &= rest - 1) {
      int i = __builtin_ctz(rest);
      const km_observer *observer = walks[i].r->observer;
      rates[i] = walks[i].r->rates;
      if (walks[i].job->status || !observer->wants || !observer->wants(observer->self, &places[i]))
        wanting &= ~(1u << i);
    }
    going = wanting ? km_drive_lanes_visit(lanes, wanting, places, rates) : 0;
    for (unsigned rest = going; rest; rest &= rest - 1) {
      const walk *w = &walks[__builtin_ctz(rest)];
      w->job->status = w->r->observer->shown(w->r->observer->self, w->r, w->r->rates, w->job->error);
    }
  }
}

/* What is left to be seen near the row is looked at by each drive alone. */
static void show_near_rows(walk *walks, unsigned going, km_drive_lanes *lanes) {
  if (lanes)
    show_beside(walks, going, lanes);
  for (unsigned rest = going; rest; rest &= rest - 1) {
    const walk *w = &walks[__builtin_ctz(rest)];
    if (!w->job->status)
      w->job->status = km_sweeper_near_row(w->r, w->job->error);
  }
}

/* Behind the row. */
static void leave_row(walk *w) {
  km_sweeper *r = w->r;
  const km_reach *reach = &r->out->end;
  km_status status = w->job->status;
  r->rides = false;
  if (!status && w->step > 0 && km_drive_crossings(w->at.drive) > w->crossings && r->substructure >= 0)
    status = km_sweeper_find_branch(r, w->job->error);
  w->last = reach->position;
  w->over = w->step > 0 && reach->stop;
  w->step++;
  w->job->status = status;
}

/* Behind the last row: where the driver itself gives out. */
static km_status finish(const walk *w) {
  km_sweeper *r = w->r;
  const km_reach *start = &r->out->start, *end = &r->out->end;
  km_status status = KM_OK;
  for (int i = 0; i < 2 && !status; ++i) {
    const km_reach *reach = i ? end : start;
    bool again = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !again && r->observer->ended)
      status = r->observer->ended(r->observer->self, r, reach->position, w->job->error);
  }
  if (status)
    return status;
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static bool rates(void *self, double *out) {
  return km_drive_tangent(((const seat *)self)->drive, out);
}

static bool probe(void *self, double s, double *out) {
  seat *at = self;
  if (at->away)
    km_drive_return(at->drive);
  else
    km_drive_mark(at->drive);
  at->away = true;
  return !km_drive_to(at->drive, s).stop && km_drive_tangent(at->drive, out);
}

static void settle(void *self) {
  seat *at = self;
  if (at->away)
    km_drive_return(at->drive);
  at->away = false;
}

static void direction(void *self, double *z) {
  km_drive_ridden_direction(((const seat *)self)->drive, z);
}

static km_status begin_walk(walk *w) {
  km_sweeper *r = w->r;
  km_error *error = w->job->error;
  r->substructure = r->out->substructure = r->m->substructure_of[r->plan->coordinate];
  km_status status = km_sweeper_leave_branch(r, r->plan->coordinate, error);
  if (!status)
    status = km_sweep_enter_limits(r->m, r->s, r->plan, error);
  if (!status)
    status = km_drive_create_in(&w->job->room->drive, r->m, r->s, r->plan->coordinate, r->plan->ignore_limits,
                                &w->at.drive, error);
  if (status)
    return status;
  r->mover = (km_mover){&w->at, rates, probe, settle, direction};
  return km_sweeper_prepare(r, error);
}

/* Do both drive the same range, and are at the same row? */
static bool same_row(const walk *a, const walk *b) {
  const km_sweep_plan *p = a->r->plan, *q = b->r->plan;
  return a->step == b->step && p->from == q->from && p->to == q->to && p->steps == q->steps;
}

/* Those of the walks `going` that do so with the first of them. */
static unsigned at_first_row(const walk *walks, unsigned going) {
  unsigned same = 0;
  for (unsigned rest = going; rest; rest &= rest - 1)
    same |= same_row(&walks[__builtin_ctz(going)], &walks[__builtin_ctz(rest)]) ? rest & -rest : 0;
  return same;
}

/* The targets of the walks `going`, k rows on, of which `same` have the same one. */
static void set_targets(const walk *walks, unsigned going, unsigned same, int k, double *targets) {
  const walk *first = &walks[__builtin_ctz(going)];
  double target = value_at(first->r->plan, first->step + k);
  for (int i = 0; i < KM_DRIVE_LANES; ++i)
    targets[i] = target;
  for (unsigned rest = going & ~same; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    targets[i] = value_at(walks[i].r->plan, walks[i].step + k);
  }
}

/* Moves the walks `going` in lanes: through quiet rows, which are written, to the row behind them. targets[lane]: of the next
 * row, and then of the one where they arrive. */
static void move_beside(walk *walks, unsigned going, km_drive_lanes *lanes, double *targets, km_reach *reaches) {
  double rows[KM_DRIVE_ROWS * KM_DRIVE_LANES];
  int count = KM_DRIVE_ROWS;
  for (unsigned rest = going; rest; rest &= rest - 1) {
    int ahead = rows_ahead(&walks[__builtin_ctz(rest)]);
    count = ahead < count ? ahead : count;
  }
  unsigned same = at_first_row(walks, going);
  memcpy(rows, targets, KM_DRIVE_LANES * sizeof *rows);
  for (int k = 1; k < count; ++k)
    set_targets(walks, going, same, k, rows + k * KM_DRIVE_LANES);
  int passed = km_drive_lanes_pass(lanes, going, rows, count);
  if (passed > 0) {
    km_drive_lanes_show(lanes, passed - 1);
    for (unsigned rest = going; rest; rest &= rest - 1)
      write_passed_rows(&walks[__builtin_ctz(rest)], passed, rows + __builtin_ctz(rest));
  }
  memcpy(targets, rows + passed * KM_DRIVE_LANES, KM_DRIVE_LANES * sizeof *targets);
  km_drive_lanes_arrive(lanes, going, targets, reaches);
}

/* Those of the walks `going` whose observers are shown the way to the next row. */
static unsigned shown_their_way(const walk *walks, unsigned going) {
  unsigned found = 0;
  for (unsigned rest = going; rest; rest &= rest - 1)
    found |= is_shown_the_way(&walks[__builtin_ctz(rest)]) ? rest & -rest : 0;
  return found;
}

/* Moves the walks `riding`, which are at one row, over part k of their ways; those that can't in their lanes go to their rows
 * alone. Returns the others. */
static unsigned pass_part(walk *walks, unsigned riding, int k, km_drive_lanes *lanes, const double *targets,
                          km_reach *reaches) {
  double places[KM_DRIVE_LANES];
  unsigned able = 0;
  int parts = km_sweeper_parts(walks[__builtin_ctz(riding)].r);
  for (unsigned rest = riding; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    km_sweep_way way = way_to(&walks[i], targets[i]);
    places[i] = km_sweeper_part(way.from, way.to, k, parts);
    able |= k == parts && way.ends ? 0 : rest & -rest;
  }
  unsigned there = km_drive_lanes_try(lanes, able, places, reaches);
  for (unsigned rest = riding & ~there; rest; rest &= rest - 1) {
    int i = __builtin_ctz(rest);
    reaches[i] = go_alone(&walks[i], targets[i], k);
  }
  for (unsigned rest = k < parts ? there : 0; rest; rest &= rest - 1) {
    walk *w = &walks[__builtin_ctz(rest)];
    take_ride(w);
    w->job->status = w->r->observer->passed(w->r->observer->self, w->r, places[__builtin_ctz(rest)], w->job->error);
    w->r->rides = false;
    there &= w->job->status ? ~(rest & -rest) : ~0U;
  }
  return there;
}

/* Moves the walks `going` to their rows, in lanes as far as they go, and shows their observers the ways. */
static void pass_beside(walk *walks, unsigned going, km_drive_lanes *lanes, const double *targets, km_reach *reaches) {
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

/* Moves each of the walks that goes on to its next row, or over several. False where none does. */
static bool advance(walk *walks, int count, km_drive_lanes *lanes) {
  double targets[KM_DRIVE_LANES] = {0.0};
  km_reach reaches[KM_DRIVE_LANES];
  unsigned going = 0;
  for (int i = 0; i < count; ++i)
    going |= next(&walks[i], &targets[i]) ? 1u << i : 0;
  if (lanes && going && !shown_their_way(walks, going))
    move_beside(walks, going, lanes, targets, reaches);
  else
    pass_beside(walks, going, lanes, targets, reaches);
  for (int i = 0; i < count; ++i)
    if (going >> i & 1)
      write_row(&walks[i], reaches[i]);
  show_near_rows(walks, going, lanes);
  for (int i = 0; i < count; ++i)
    if (going >> i & 1)
      leave_row(&walks[i]);
  return going != 0;
}

/* Side by side, if there are several and lanes are for them. */
static km_status advance_all(walk *walks, int count) {
  km_drive *drives[KM_DRIVE_LANES];
  km_arena *memory = &walks[0].job->room->lanes;
  km_drive_lanes *lanes = NULL;
  for (int i = 0; i < count; ++i)
    drives[i] = walks[i].at.drive;
  km_status status = count > 1 ? km_drive_lanes_create(memory, drives, count, &lanes, NULL) : KM_OK;
  while (!status && advance(walks, count, lanes))
    continue;
  km_drive_lanes_free(memory, lanes);
  return status;
}

void km_sweeps_by_driver(km_sweeper *sweepers, km_sweep_job *jobs, int count) {
  walk walks[KM_DRIVE_LANES];
  int going = 0;
  for (int i = 0; i < count; ++i) {
    if (jobs[i].status || !km_plan_is_driven(jobs[i].plan))
      continue;
    walks[going] = (walk){.r = &sweepers[i], .job = &jobs[i]};
    jobs[i].status = begin_walk(&walks[going]);
    if (jobs[i].status)
      km_drive_free_into(&jobs[i].room->drive, walks[going].at.drive);
    else
      ++going;
  }
  bool failed = going > 0 && advance_all(walks, going) == KM_MEMORY;
  for (int i = 0; i < going; ++i) {
    km_sweep_job *job = walks[i].job;
    if (failed)
      job->status = km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
    else if (!job->status)
      job->status = finish(&walks[i]);
    km_drive_free_into(&job->room->drive, walks[i].at.drive);
  }
}
