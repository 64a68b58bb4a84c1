/* Writes the lane of a drive back into the drive and its state. */
#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_equations.h"

/* What is left of a pose: the state's balls are those of the lane. */
void km_batch_write_ball_joints(const km_batch *l, int i) {
  for (int b = 0; b < l->m->ball_count; ++b)
    l->drives[i]->c.state->ball[b] = km_lane_ball(&l->ball[b], i);
}

/* What a state has beside its coordinates where a drive rides: Jacobian, partition and null space, as if it went alone. */
void km_batch_refresh_state(const km_batch *l, km_driver_motion *d) {
  km_state *s = d->c.state;
  const km_substructure *sub = km_driver_motion_substructure(d);
  /* The loops were closed before the driver got its value to the last bit. */
  double value = s->q[l->coordinate];
  s->q[l->coordinate] = l->here.closed_at.of[d->lane];
  km_loops_update(d->c.mechanism, s, sub);
  km_partition_refactor(&s->partition[d->c.substructure], km_state_jacobian(s, sub));
  s->q[l->coordinate] = value;
  km_state_null_space(d->c.mechanism, s, d->c.substructure, km_partition_freedom(&s->partition[d->c.substructure]));
}

void km_driver_motion_write_back(km_driver_motion *d) {
  km_batch *l = d->lanes;
  unsigned own = l ? 1u << d->lane : 0;
  if (!l || !(l->aboard & own))
    return;
  l->aboard &= ~own;
  l->known[0] &= ~own;
  l->looked &= ~own;
  if (!(l->ahead & own))
    return;
  l->ahead &= ~own;
  int i = d->lane;
  km_step_history *course = &d->c.course;
  km_state *s = d->c.state;
  const km_substructure *sub = km_driver_motion_substructure(d);
  const km_lane_past earlier = km_lane_past_of(l, course);
  for (int k = 0; k < sub->columns; ++k) {
    course->t[k] = l->t[k].of[i];
    course->last_t[k] = l->last_t[k].of[i];
    course->last_move[k] = l->last_move[k].of[i];
    course->rest[k] = l->rest[k].of[i];
    for (int j = 0; j < earlier.count; ++j)
      earlier.of[j][k] = l->past[j][k].of[i];
    int c = l->m->column_coordinate[sub->column_start + k];
    s->q[c] = l->q[c].of[i];
  }
  for (int j = 0; j < KM_OLDER_STEPS; ++j)
    course->older_h[j] = l->here.older_h[j].of[i];
  course->older_count = (int)l->here.older_count.of[i];
  km_batch_write_ball_joints(l, i);
  course->last_h = l->here.last_h.of[i];
  course->equal_count = (int)l->here.equal_count.of[i];
  course->reference.sign = (int)l->sign.of[i];
  d->here.s = l->here.s.of[i];
  d->here.largest = l->here.largest.of[i];
  d->here.stopped = l->here.stopped.of[i];
  km_batch_refresh_state(l, d);
}

bool km_driver_motion_is_batched(const km_driver_motion *d) {
  return d->lanes && (d->lanes->ahead >> d->lane & 1);
}
