/* Batches of driven motions (theory 4.12): motions enter and leave lanes, rows of targets are stepped through, and
 * the step function is chosen by the processor's registers. */
#include "continuation/batch/batch_arrays.h"

#include "kinematics/loop_equations.h"
#include "kmech/continuation.h"

#include <string.h>

/* True if a batch covers the number of freedoms. The first step with several freedoms is taken singly. */
static bool has_batchable_freedoms(const km_driver_motion *d, int freedom) {
  bool few = freedom <= KM_BATCH_FREEDOMS && freedom - 1 <= km_factor_rank(d->c.history.reference);
  return freedom == 1 || (freedom > 1 && few && !d->current.is_stiff && d->c.history.last_h != 0.0);
}

/* True if the motion can be batched: known pivots that belong to the present configuration, which is regular. */
static bool can_be_batched(const km_driver_motion *d) {
  const km_state *s = d->c.state;
  const km_factor *p = s->factor[d->c.substructure], *reference = d->c.history.reference;
  return d->current.known && !d->c.constant_rank.is_active && s->pivot_driver[d->c.substructure] == d->c.column &&
         !km_factor_has_forced_pivot(p) && !s->has_locked[d->c.substructure] &&
         has_batchable_freedoms(d, km_factor_freedom(p)) && km_factor_rank(reference) == km_factor_rank(p) &&
         km_factor_search_count(reference) == km_factor_search_count(p) && !km_continuation_is_singular(p);
}

/* Records the elimination with the pivots of the first active lane; all lanes use them. */
static void record_elimination(km_batch *l, const km_factor *p) {
  km_recorded_elimination_record(&l->elimination, p, l->sub->pattern.used);
  l->extra_freedoms = km_factor_freedom(p) - 1;
  memset(l->J, 0, l->sub->pattern.size * sizeof *l->J);
}

static void copy_ball(km_lane_quaternion *to, const km_quaternion *q, int i) {
  to->w.of[i] = q->w;
  to->x.of[i] = q->x;
  to->y.of[i] = q->y;
  to->z.of[i] = q->z;
}

/* Copies configuration and history of motion i into its lane if it can be batched with the recorded pivots. */
static void load_lane(km_batch *l, int i) {
  const km_driver_motion *d = l->drives[i];
  const km_factor *p = d->c.state->factor[d->c.substructure];
  if (!can_be_batched(d))
    return;
  if (!l->active && !km_recorded_elimination_matches(&l->elimination, p))
    record_elimination(l, p);
  else if (!km_recorded_elimination_matches(&l->elimination, p))
    return;
  for (int c = 0; c < l->m->coordinate_count; ++c)
    l->q[c].of[i] = d->c.state->q[c];
  for (int b = 0; b < l->m->ball_count; ++b)
    copy_ball(&l->ball[b], &d->c.state->ball[b], i);
  km_batch_transfer(l, i, true);
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  l->max_b_at_search.of[i] = evidence.max_b_at_search;
  l->smallest_pivot.of[i] = km_factor_rank(p) > 0 ? evidence.smallest_pivot_at_search : 0.0;
  l->active |= 1u << i;
}

/* Copies coordinates and mobility numbers of the row into the state. */
static void copy_row_to_state(const km_batch *l, int i) {
  const km_lane_row *row = l->read_row;
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  double *q = l->drives[i]->c.state->q, *numbers = l->drives[i]->c.state->mobility_number;
  for (int k = 0, count = l->sub->columns; k < count; ++k) {
    q[coordinate[k]] = row->q[k].of[i];
    numbers[coordinate[k]] = row->mobility_number[k].of[i];
  }
}

void km_driver_motion_prepare_read(km_driver_motion *d) {
  if (!km_driver_motion_is_batched(d))
    return;
  km_batch_refresh_state(d->lanes, d);
  d->lanes->refreshed |= 1u << d->lane;
}

void km_driver_motion_leave_batch(km_driver_motion *d) {
  km_batch *l = d->lanes;
  if (!l)
    return;
  unsigned others = ~(1u << d->lane);
  l->active &= others;
  l->unwritten &= others;
  l->drives[d->lane] = NULL;
  d->lanes = NULL;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
}

double km_driver_motion_batched_residual(const km_driver_motion *d) {
  return d->lanes->read_row->residual->of[d->lane];
}

void km_driver_motion_batched_direction(const km_driver_motion *d, double *z) {
  const km_batch *l = d->lanes;
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k)
    z[coordinate[k]] = l->read_row->z[k].of[d->lane];
}

void km_driver_motion_read_basis(km_driver_motion *d) {
  km_factor_set_null_vector(d->c.state->factor[d->c.substructure], &d->lanes->read_row->z->of[d->lane], KM_BATCH_LANES);
}

/* Takes one step with the widest registers of the processor. */
static unsigned step_lanes(km_batch *l, unsigned wanted) {
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

/* Writes back lanes whose state has new pivots, searched by an observer: these motions continue singly at first. */
static void release_repivoted_lanes(km_batch *l) {
  for (unsigned remaining = l->refreshed; remaining; remaining &= remaining - 1) {
    km_driver_motion *d = l->drives[__builtin_ctz(remaining)];
    const km_state *s = d->c.state;
    const km_factor *p = s->factor[d->c.substructure];
    if (s->pivot_driver[d->c.substructure] != d->c.column ||
        km_factor_search_count(p) != km_factor_search_count(d->c.history.reference))
      km_driver_motion_write_back(d);
  }
  l->refreshed = 0;
}

/* Loads a lane; if that fails, finds pivots and tangent, or takes the first step singly, and tries again. */
static void load_or_start_lane(km_batch *l, int i, double target) {
  km_driver_motion *d = l->drives[i];
  load_lane(l, i);
  bool is_distant = !(fabs(target * l->factor.of[i] - d->current.s) < KM_MOST_STEPS_TO_UNREACHABLE * km_longest_step);
  if (is_distant)
    km_driver_motion_write_back(d);
  if (is_distant || l->active >> i & 1)
    return;
  km_driver_motion_prepare(d, target);
  load_lane(l, i);
  if (l->active >> i & 1)
    return;
  km_driver_motion_begin(d, target);
  load_lane(l, i);
}

static bool is_far(const km_batch *l, int i) {
  return !(fabs(l->target.of[i] - l->current.s.of[i]) < KM_MOST_STEPS_TO_UNREACHABLE * km_longest_step);
}

/* Sets the targets of the active lanes and writes back those with distant targets. */
static void set_targets(km_batch *l, unsigned wanted, const double *targets) {
  bool any_distant = false;
  for (int i = 0; i < l->count; ++i) {
    l->target.of[i] = targets[i] * l->factor.of[i];
    any_distant |= is_far(l, i);
  }
  for (unsigned remaining = any_distant ? wanted : 0; remaining; remaining &= remaining - 1)
    if (is_far(l, __builtin_ctz(remaining)))
      km_driver_motion_write_back(l->drives[__builtin_ctz(remaining)]);
}

/* Ends a move: in the lane, or singly from where the lane stopped. */
static km_motion_end finish_move(km_batch *l, int i, bool at_target, double target) {
  if (!at_target)
    return km_driver_motion_move_to(l->drives[i], target);
  if (l->unwritten >> i & 1) {
    copy_row_to_state(l, i);
    km_batch_write_ball_joints(l, i);
  }
  if (!(l->current.largest_b.of[i] <= km_max_good_b)) /* observers search other pivots at such a configuration */
    km_driver_motion_write_back(l->drives[i]);
  return (km_motion_end){KM_STOP_NONE, target, -1, -1};
}

/* Notifies the observers of an intermediate step in these lanes. */
static void notify_steps(km_batch *l, unsigned lanes) {
  l->is_multi_step |= lanes;
  for (unsigned remaining = lanes; remaining; remaining &= remaining - 1) {
    int i = __builtin_ctz(remaining);
    km_driver_motion_notify(l->drives[i], l->current.s.of[i], &l->t->of[i], KM_BATCH_LANES);
  }
}

/* Steps the lanes `wanted` until they reach their targets or need a decision. Returns those at their targets. */
static unsigned step_to_targets(km_batch *l, unsigned wanted) {
  unsigned at_target = 0;
  for (unsigned stepping = wanted; stepping; stepping &= ~l->at_target) {
    stepping = step_lanes(l, stepping);
    if (l->extra_freedoms == 0)
      km_batch_rotate_history(l, stepping);
    l->unwritten |= stepping;
    at_target |= l->at_target;
    notify_steps(l, stepping & ~l->at_target);
  }
  return at_target;
}

unsigned km_batch_sample(km_batch *l, unsigned wanted, const double *targets, double *const *rates) {
  release_repivoted_lanes(l);
  set_targets(l, wanted & l->active, targets);
  unsigned unwritten = l->unwritten & l->active, at_target = 0;
  if (!(wanted & l->active))
    return 0;
  km_batch_save(l);
  l->row = &l->rows[KM_BATCH_ROWS];
  at_target = step_to_targets(l, wanted & l->active);
  for (unsigned remaining = at_target; remaining; remaining &= remaining - 1) {
    int i = __builtin_ctz(remaining);
    km_driver_motion_rates(l->drives[i], &l->t->of[i], KM_BATCH_LANES, rates[i]);
  }
  km_batch_restore(l);
  l->unwritten = unwritten;
  return at_target;
}

/* Steps the lanes `wanted` to their targets and writes the row. */
static void step_into_row(km_batch *l, unsigned wanted, int index) {
  const km_lane_row *row = l->row = &l->rows[index];
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  l->is_multi_step = 0;
  l->arrived = step_to_targets(l, wanted);
  for (int k = 0; k < l->sub->columns; ++k)
    row->q[k] = l->q[coordinate[k]];
  *row->residual = l->current.residual;
}

/* Makes the present row the previous one. */
static void shift_rows(km_batch *l) {
  l->previous_z[1] = l->previous_z[0];
  l->previous_z[0] = l->row->z;
  l->has_previous[1] = l->has_previous[0] & ~l->is_multi_step;
  l->has_previous[0] = l->arrived;
}

/* Ends a pass over rows: z of the last two rows is copied, since the next pass overwrites them. */
static void end_rows(km_batch *l, int passed_rows) {
  l->passed_rows = passed_rows;
  shift_rows(l);
  for (int i = 1; i >= 0; --i) { /* the previous row can belong to the last pass */
    memmove(l->last_z[i], l->previous_z[i], (size_t)l->sub->columns * sizeof *l->last_z[i]);
    l->previous_z[i] = l->last_z[i];
  }
}

int km_batch_advance_rows(km_batch *l, unsigned wanted, const double *targets, int rows, bool is_observed) {
  int passed_rows = 0;
  release_repivoted_lanes(l);
  l->is_observed = is_observed;
  for (unsigned remaining = wanted & ~l->active; remaining; remaining &= remaining - 1) {
    int i = __builtin_ctz(remaining);
    load_or_start_lane(l, i, targets[i]);
  }
  for (;; ++passed_rows) {
    set_targets(l, wanted & l->active, targets + (size_t)passed_rows * KM_BATCH_LANES);
    step_into_row(l, wanted & l->active, passed_rows);
    unsigned continues = is_observed ? l->has_no_zero & l->has_previous[0] & l->has_previous[1] & ~l->is_multi_step
                                     : l->has_valid_pivots;
    if (passed_rows + 1 == rows || l->arrived != wanted || wanted & ~continues)
      break;
    shift_rows(l);
  }
  end_rows(l, passed_rows);
  return passed_rows;
}

unsigned km_batch_try(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  release_repivoted_lanes(l);
  for (unsigned remaining = wanted & ~l->active; remaining; remaining &= remaining - 1)
    load_lane(l, __builtin_ctz(remaining));
  set_targets(l, wanted & l->active, targets);
  unsigned stepped = wanted & l->active, unwritten = l->unwritten;
  if (!stepped)
    return 0;
  km_batch_save(l);
  step_into_row(l, stepped, 0);
  for (unsigned remaining = stepped & ~l->arrived; remaining; remaining &= remaining - 1) {
    int i = __builtin_ctz(remaining);
    km_batch_restore_lane(l, i);
    l->unwritten = (l->unwritten & ~(1u << i)) | (unwritten & 1u << i);
    km_driver_motion_write_back(l->drives[i]);
  }
  end_rows(l, 0);
  km_batch_arrive(l, l->arrived, targets, reaches);
  return l->arrived;
}

km_batched_rows km_driver_motion_batched_rows(const km_driver_motion *d) {
  const km_batch *l = d->lanes;
  const km_lane_row *first = &l->rows[0];
  return (km_batched_rows){&first->q->of[d->lane], &first->mobility_number->of[d->lane], &first->residual->of[d->lane],
                           l->row_size * KM_BATCH_LANES};
}

void km_batch_write_row(km_batch *l, int row) {
  l->read_row = &l->rows[row];
  for (unsigned remaining = l->unwritten; remaining; remaining &= remaining - 1)
    copy_row_to_state(l, __builtin_ctz(remaining));
}

void km_batch_arrive(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  l->read_row = &l->rows[l->passed_rows];
  for (unsigned remaining = wanted; remaining; remaining &= remaining - 1) {
    int i = __builtin_ctz(remaining);
    reaches[i] = finish_move(l, i, l->arrived >> i & 1, targets[i]);
  }
}

void km_batch_move_to(km_batch *l, unsigned wanted, const double *targets, km_motion_end *reaches) {
  km_batch_advance_rows(l, wanted, targets, 1, true);
  km_batch_arrive(l, wanted, targets, reaches);
}
