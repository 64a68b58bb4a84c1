/* Writes the results of a batch's lane back into its driven motion and state. */
#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_equations.h"

void km_batch_write_ball_joints(const km_batch *l, int i) {
  for (int b = 0; b < l->m->ball_count; ++b)
    l->drives[i]->c.state->ball[b] = km_lane_ball(&l->ball[b], i);
}

void km_batch_refresh_state(const km_batch *l, km_driver_motion *d) {
  km_state *s = d->c.state;
  const km_substructure *sub = km_driver_motion_substructure(d);
  /* the loops were closed before the driver was rounded to its exact target */
  double value = s->q[l->coordinate];
  s->q[l->coordinate] = l->current.closed_at.of[d->lane];
  km_loops_update(d->c.mechanism, s, sub);
  km_factor *p = s->factor[d->c.substructure];
  km_factor_refactor(p, km_state_jacobian(s, sub), KM_BASIS_SHORT);
  s->q[l->coordinate] = value;
  km_factor_null_space(p, km_factor_freedom(p));
}

void km_driver_motion_write_back(km_driver_motion *d) {
  km_batch *l = d->lanes;
  unsigned bit = l ? 1u << d->lane : 0;
  if (!l || !(l->active & bit))
    return;
  l->active &= ~bit;
  l->has_previous[0] &= ~bit;
  l->refreshed &= ~bit;
  if (!(l->unwritten & bit))
    return;
  l->unwritten &= ~bit;
  int i = d->lane;
  km_step_history *history = &d->c.history;
  km_state *s = d->c.state;
  const km_substructure *sub = km_driver_motion_substructure(d);
  const km_lane_past older = km_lane_past_of(l, history);
  for (int k = 0; k < sub->columns; ++k) {
    history->t[k] = l->t[k].of[i];
    history->last_t[k] = l->last_t[k].of[i];
    history->last_move[k] = l->last_move[k].of[i];
    history->remaining_step[k] = l->remaining_step[k].of[i];
    for (int j = 0; j < older.count; ++j)
      older.of[j][k] = l->past[j][k].of[i];
    int c = l->m->column_coordinate[sub->column_start + k];
    s->q[c] = l->q[c].of[i];
  }
  for (int j = 0; j < KM_OLDER_STEPS; ++j)
    history->older_h[j] = l->current.older_h[j].of[i];
  history->older_count = (int)l->current.older_count.of[i];
  km_batch_write_ball_joints(l, i);
  history->last_h = l->current.last_h.of[i];
  history->equal_count = (int)l->current.equal_count.of[i];
  history->sign = (int)l->sign.of[i];
  d->current.s = l->current.s.of[i];
  d->current.largest = l->current.largest.of[i];
  d->current.stopped = l->current.stopped.of[i];
  km_batch_refresh_state(l, d);
}

bool km_driver_motion_is_batched(const km_driver_motion *d) {
  return d->lanes && (d->lanes->unwritten >> d->lane & 1);
}
