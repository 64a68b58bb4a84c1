/* Copies a driven motion and its state into a batch's lane and back. */
#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_equations.h"

static void transfer(double *own, km_batch_number *number, int lane, bool is_loaded) {
  double *to = is_loaded ? &number->of[lane] : own;
  *to = is_loaded ? *own : number->of[lane];
}

static void transfer_count(int *own, km_batch_number *number, int lane, bool is_loaded) {
  double count = *own;
  transfer(&count, number, lane, is_loaded);
  *own = (int)count;
}

void km_batch_transfer(km_batch *l, int i, bool is_loaded) {
  km_driver_motion *d = l->drives[i];
  km_step_history *history = &d->c.history;
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  const km_lane_past older = km_lane_past_of(l, history);
  km_lane_position *p = &l->current;
  for (int k = 0; k < l->sub->columns; ++k) {
    transfer(&history->t[k], &l->t[k], i, is_loaded);
    transfer(&history->last_t[k], &l->last_t[k], i, is_loaded);
    transfer(&history->last_move[k], &l->last_move[k], i, is_loaded);
    transfer(&history->remaining_step[k], &l->remaining_step[k], i, is_loaded);
    transfer(&d->c.state->q[coordinate[k]], &l->q[coordinate[k]], i, is_loaded);
    for (int j = 0; j < older.count; ++j)
      transfer(&older.of[j][k], &l->past[j][k], i, is_loaded);
  }
  for (int j = 0; j < KM_OLDER_STEPS; ++j)
    transfer(&history->older_h[j], &p->older_h[j], i, is_loaded);
  transfer(&history->last_h, &p->last_h, i, is_loaded);
  transfer(&d->current.s, &p->s, i, is_loaded);
  transfer(&d->current.largest, &p->largest, i, is_loaded);
  transfer(&d->current.stopped, &p->stopped, i, is_loaded);
  transfer_count(&history->older_count, &p->older_count, i, is_loaded);
  transfer_count(&history->equal_count, &p->equal_count, i, is_loaded);
  transfer_count(&history->sign, &l->sign, i, is_loaded);
}

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
  km_batch_transfer(l, d->lane, false);
  km_batch_write_ball_joints(l, d->lane);
  km_batch_refresh_state(l, d);
}

bool km_driver_motion_is_batched(const km_driver_motion *d) {
  return d->lanes && (d->lanes->unwritten >> d->lane & 1);
}
