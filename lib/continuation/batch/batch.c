/* Drives side by side: which of them may ride, what passes between a drive and its lane, and the choice of registers. */
#include "continuation/batch/batch_arrays.h"

#include "kinematics/loop_equations.h"
#include "kmech/continuation.h"

#include <string.h>

/* Are as many freedoms left as lanes are for? With several the first step is taken alone. */
static bool has_freedoms_for_lanes(const km_driver_motion *d, int freedom) {
  bool few = freedom <= KM_BATCH_FREEDOMS && freedom - 1 <= d->c.course.reference.rank;
  return freedom == 1 || (freedom > 1 && few && !d->here.stiff && d->c.course.last_h != 0.0);
}

/* May the drive take steps in its lane: known pivots that belong to the last pose, and a regular pose? */
static bool may_ride(const km_driver_motion *d) {
  const km_state *s = d->c.state;
  const km_partition *p = &s->partition[d->c.substructure], *reference = &d->c.course.reference;
  return d->here.known && !d->c.steady.is_active && s->pivot_driver[d->c.substructure] == d->c.column &&
         !p->forced_dependent && !p->locked && has_freedoms_for_lanes(d, km_partition_freedom(p)) &&
         reference->rank == p->rank && reference->search_count == p->search_count && !km_continuation_is_singular(p);
}

/* The first one aboard decides by which pivots all go. */
static void take_pivots(km_batch *l, const km_partition *p) {
  km_recorded_elimination_make(&l->replay, p, l->sub->pattern.used);
  l->beside = km_partition_freedom(p) - 1;
  memset(l->J, 0, l->sub->pattern.size * sizeof *l->J);
}

static void take_ball(km_lane_quaternion *to, const km_quaternion *q, int i) {
  to->w.of[i] = q->w;
  to->x.of[i] = q->x;
  to->y.of[i] = q->y;
  to->z.of[i] = q->z;
}

/* The course of drive i into its lane, if it may ride. */
static void board(km_batch *l, int i) {
  const km_driver_motion *d = l->drives[i];
  const km_step_history *course = &d->c.course;
  const km_partition *p = &d->c.state->partition[d->c.substructure];
  if (!may_ride(d))
    return;
  if (!l->aboard && !km_recorded_elimination_fits(&l->replay, p))
    take_pivots(l, p);
  else if (!km_recorded_elimination_fits(&l->replay, p))
    return;
  const km_lane_past earlier = km_lane_past_of(l, course);
  for (int c = 0; c < l->m->coordinate_count; ++c)
    l->q[c].of[i] = d->c.state->q[c];
  for (int b = 0; b < l->m->ball_count; ++b)
    take_ball(&l->ball[b], &d->c.state->ball[b], i);
  for (int k = 0; k < l->sub->columns; ++k) {
    l->t[k].of[i] = course->t[k];
    l->last_t[k].of[i] = course->last_t[k];
    l->last_move[k].of[i] = course->last_move[k];
    l->rest[k].of[i] = course->rest[k];
    for (int j = 0; j < earlier.count; ++j)
      l->past[j][k].of[i] = earlier.of[j][k];
  }
  for (int j = 0; j < KM_OLDER_STEPS; ++j)
    l->here.older_h[j].of[i] = course->older_h[j];
  l->here.older_count.of[i] = course->older_count;
  l->here.last_h.of[i] = course->last_h;
  l->here.equal_count.of[i] = course->equal_count;
  l->sign.of[i] = course->reference.sign;
  l->here.s.of[i] = d->here.s;
  l->here.largest.of[i] = d->here.largest;
  l->here.stopped.of[i] = d->here.stopped;
  l->pivoted_b.of[i] = p->max_b_at_search;
  l->smallest_pivot.of[i] = p->rank > 0 ? p->smallest_pivot : 0.0;
  l->aboard |= 1u << i;
}

/* What a look at the pose reads of a state: coordinates and mobility numbers. */
static void show(const km_batch *l, int i) {
  const km_lane_row *row = l->shown;
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  double *q = l->drives[i]->c.state->q, *numbers = l->drives[i]->c.state->mobility_number;
  for (int k = 0, count = l->sub->columns; k < count; ++k) {
    q[coordinate[k]] = row->q[k].of[i];
    numbers[coordinate[k]] = row->numbers[k].of[i];
  }
}

void km_driver_motion_prepare_read(km_driver_motion *d) {
  if (!km_driver_motion_is_batched(d))
    return;
  km_batch_refresh_state(d->lanes, d);
  d->lanes->looked |= 1u << d->lane;
}

void km_driver_motion_leave_batch(km_driver_motion *d) {
  km_batch *l = d->lanes;
  if (!l)
    return;
  unsigned others = ~(1u << d->lane);
  l->aboard &= others;
  l->ahead &= others;
  l->drives[d->lane] = NULL;
  d->lanes = NULL;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
}

double km_driver_motion_batched_residual(const km_driver_motion *d) {
  return d->lanes->shown->residual->of[d->lane];
}

void km_driver_motion_batched_direction(const km_driver_motion *d, double *z) {
  const km_batch *l = d->lanes;
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k)
    z[coordinate[k]] = l->shown->z[k].of[d->lane];
}

void km_driver_motion_read_basis(km_driver_motion *d) {
  km_state_set_single_basis(d->c.state, d->c.substructure, &d->lanes->shown->z->of[d->lane], KM_BATCH_LANES);
}

static unsigned take_step(km_batch *l, unsigned wanted) {
#ifdef KM_LANES_AVX512
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return km_batch_step_avx512(l, wanted);
#endif
#ifdef KM_LANES_AVX2
  if (__builtin_cpu_supports("avx2"))
    return km_batch_step_avx2(l, wanted);
#endif
  return km_batch_step_sse2(l, wanted);
}

/* Whoever looked at a drive's pose may have searched other pivots there: then it goes on by those, alone at first. */
static void keep_pivots(km_batch *l) {
  for (unsigned left = l->looked; left; left &= left - 1) {
    km_driver_motion *d = l->drives[__builtin_ctz(left)];
    const km_state *s = d->c.state;
    const km_partition *p = &s->partition[d->c.substructure];
    if (s->pivot_driver[d->c.substructure] != d->c.column || p->search_count != d->c.course.reference.search_count)
      km_driver_motion_write_back(d);
  }
  l->looked = 0;
}

/* A target so many of the longest steps away is left to the drive alone, which gives up at a number of steps. */
static const double most_steps = 1e4;

/* Aboard, if it may: where there is a way to go it gets ready for it, or takes the first step alone, after which it mostly may. */
static void call_aboard(km_batch *l, int i, double target) {
  km_driver_motion *d = l->drives[i];
  board(l, i);
  bool far = !(fabs(target * l->factor.of[i] - d->here.s) < most_steps * km_driver_longest_step);
  if (far)
    km_driver_motion_write_back(d);
  if (far || l->aboard >> i & 1)
    return;
  km_driver_motion_prepare(d, target);
  board(l, i);
  if (l->aboard >> i & 1)
    return;
  km_driver_motion_begin(d, target);
  board(l, i);
}

static bool is_far(const km_batch *l, int i) {
  return !(fabs(l->target.of[i] - l->here.s.of[i]) < most_steps * km_driver_longest_step);
}

/* Sets the targets of those that are aboard, and lets those leave that have too far to go. */
static void set_targets(km_batch *l, unsigned wanted, const double *targets) {
  bool some = false;
  for (int i = 0; i < l->count; ++i) {
    l->target.of[i] = targets[i] * l->factor.of[i];
    some |= is_far(l, i);
  }
  for (unsigned left = some ? wanted : 0; left; left &= left - 1)
    if (is_far(l, __builtin_ctz(left)))
      km_driver_motion_write_back(l->drives[__builtin_ctz(left)]);
}

/* What a drive has reached: in its lane, or alone from where its lane has stopped. */
static km_motion_end arrive(km_batch *l, int i, bool there, double target) {
  if (!there)
    return km_driver_motion_move_to(l->drives[i], target);
  if (l->ahead >> i & 1) {
    show(l, i);
    km_batch_write_ball_joints(l, i);
  }
  if (!(l->here.largest_b.of[i] <= km_max_good_b)) /* whoever looks at the pose searches other pivots */
    km_driver_motion_write_back(l->drives[i]);
  return (km_motion_end){KM_STOP_NONE, target, -1, -1};
}

/* These lanes have made a step that leads on. */
static void tell_steps(km_batch *l, unsigned lanes) {
  l->several |= lanes;
  for (unsigned left = lanes; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    km_driver_motion_notify(l->drives[i], l->here.s.of[i], &l->t->of[i], KM_BATCH_LANES);
  }
}

/* Steps of the lanes `wanted` towards their targets. Returns those that got there. */
static unsigned go(km_batch *l, unsigned wanted) {
  unsigned there = 0;
  for (unsigned going = wanted; going; going &= ~l->there) {
    going = take_step(l, going);
    if (l->beside == 0)
      km_batch_extend_history(l, going);
    l->ahead |= going;
    there |= l->there;
    tell_steps(l, going & ~l->there);
  }
  return there;
}

unsigned km_batch_sample(km_batch *l, unsigned wanted, const double *targets, double *const *rates) {
  keep_pivots(l);
  set_targets(l, wanted & l->aboard, targets);
  unsigned ahead = l->ahead & l->aboard, there = 0;
  if (!(wanted & l->aboard))
    return 0;
  km_batch_save(l);
  l->row = &l->rows[KM_BATCH_ROWS];
  there = go(l, wanted & l->aboard);
  for (unsigned left = there; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    km_driver_motion_rates(l->drives[i], &l->t->of[i], KM_BATCH_LANES, rates[i]);
  }
  km_batch_restore(l);
  l->ahead = ahead;
  return there;
}

/* Steps of the lanes `wanted` towards their targets, into a row. */
static void go_to_row(km_batch *l, unsigned wanted, int index) {
  const km_lane_row *row = l->row = &l->rows[index];
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  l->several = 0;
  l->arrived = go(l, wanted);
  for (int k = 0; k < l->sub->columns; ++k)
    row->q[k] = l->q[coordinate[k]];
  *row->residual = l->here.residual;
}

/* What lanes know of the row where they are becomes what they know of the row before. */
static void leave_row(km_batch *l) {
  l->before[1] = l->before[0];
  l->before[0] = l->row->z;
  l->known[1] = l->known[0] & ~l->several;
  l->known[0] = l->arrived;
}

/* Behind the rows there are others of the next pass: what is read of the last two is kept. */
static void end_pass(km_batch *l, int passed) {
  l->passed = passed;
  leave_row(l);
  for (int i = 1; i >= 0; --i) { /* the row before may be the last one of the pass before */
    memmove(l->last_z[i], l->before[i], (size_t)l->sub->columns * sizeof *l->last_z[i]);
    l->before[i] = l->last_z[i];
  }
}

int km_batch_advance_rows(km_batch *l, unsigned wanted, const double *targets, int rows, bool looks) {
  int passed = 0;
  keep_pivots(l);
  l->looks = looks;
  for (unsigned left = wanted & ~l->aboard; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    call_aboard(l, i, targets[i]);
  }
  for (;; ++passed) {
    set_targets(l, wanted & l->aboard, targets + (size_t)passed * KM_BATCH_LANES);
    go_to_row(l, wanted & l->aboard, passed);
    unsigned plain = looks ? l->quiet & l->known[0] & l->known[1] & ~l->several : l->sound;
    if (passed + 1 == rows || l->arrived != wanted || wanted & ~plain)
      break;
    leave_row(l);
  }
  end_pass(l, passed);
  return passed;
}

unsigned km_batch_try(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  keep_pivots(l);
  for (unsigned left = wanted & ~l->aboard; left; left &= left - 1)
    board(l, __builtin_ctz(left));
  set_targets(l, wanted & l->aboard, targets);
  unsigned riding = wanted & l->aboard, ahead = l->ahead;
  if (!riding)
    return 0;
  km_batch_save(l);
  go_to_row(l, riding, 0);
  for (unsigned left = riding & ~l->arrived; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    km_batch_restore_lane(l, i);
    l->ahead = (l->ahead & ~(1u << i)) | (ahead & 1u << i);
    km_driver_motion_write_back(l->drives[i]);
  }
  end_pass(l, 0);
  km_batch_arrive(l, l->arrived, targets, reaches);
  return l->arrived;
}

km_batched_rows km_driver_motion_batched_rows(const km_driver_motion *d) {
  const km_batch *l = d->lanes;
  const km_lane_row *first = &l->rows[0];
  return (km_batched_rows){&first->q->of[d->lane], &first->numbers->of[d->lane], &first->residual->of[d->lane],
                           l->row_size * KM_BATCH_LANES};
}

void km_batch_write_row(km_batch *l, int row) {
  l->shown = &l->rows[row];
  for (unsigned left = l->ahead; left; left &= left - 1)
    show(l, __builtin_ctz(left));
}

void km_batch_arrive(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  l->shown = &l->rows[l->passed];
  for (unsigned left = wanted; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    reaches[i] = arrive(l, i, l->arrived >> i & 1, targets[i]);
  }
}

void km_batch_move_to(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  km_batch_advance_rows(l, wanted, targets, 1, true);
  km_batch_arrive(l, wanted, targets, reaches);
}
