/* Comparison of mechanism structures, and the numbers of mechanisms in lanes. */
#include "continuation/batch/batch_arrays.h"

#include "model/joint_type.h"

#include <string.h>

static bool same_planar_steps(const km_mechanism *a, const km_mechanism *b, const km_program *p) {
  for (int i = p->step_start; i < p->step_start + p->step_count; ++i) {
    const km_planar_step *x = &a->planar_steps[i], *y = &b->planar_steps[i];
    if (x->is_slide != y->is_slide || x->coordinate != y->coordinate || x->sign != y->sign || x->from != y->from ||
        x->to != y->to)
      return false;
  }
  return true;
}

static bool same_spatial_steps(const km_mechanism *a, const km_mechanism *b, const km_program *p) {
  for (int i = p->step_start; i < p->step_start + p->step_count; ++i) {
    const km_step *x = &a->steps[i], *y = &b->steps[i];
    if (x->primitive != y->primitive || x->ball != y->ball || x->axis != y->axis || x->coordinate != y->coordinate ||
        x->sign != y->sign || x->from != y->from || x->to != y->to || x->has_rotation != y->has_rotation)
      return false;
  }
  return true;
}

static bool same_program(const km_mechanism *a, const km_mechanism *b, int index) {
  const km_program *p = &a->programs[index], *q = &b->programs[index];
  if (p->planar != q->planar || p->step_count != q->step_count || p->loop_count != q->loop_count ||
      p->step_start != q->step_start || p->loop_start != q->loop_start || p->twist_start != q->twist_start)
    return false;
  return p->planar ? same_planar_steps(a, b, p) : same_spatial_steps(a, b, p);
}

static bool same_loop(const km_mechanism *a, const km_mechanism *b, int l) {
  const km_loop *x = &a->loops[l], *y = &b->loops[l];
  if (x->lambda != y->lambda || memcmp(x->rows, y->rows, (size_t)x->lambda * sizeof *x->rows) != 0 ||
      x->has_moving_point != y->has_moving_point || x->row_start != y->row_start || x->slot[0] != y->slot[0] ||
      x->slot[1] != y->slot[1] || x->entry_start != y->entry_start || x->entry_count != y->entry_count)
    return false;
  for (int i = x->entry_start; i < x->entry_start + x->entry_count; ++i) {
    const km_entry *e = &a->entries[i], *f = &b->entries[i];
    if (e->step != f->step || e->column != f->column || e->side != f->side || e->value_index != f->value_index)
      return false;
  }
  return true;
}

static bool same_couplings(const km_mechanism *a, const km_mechanism *b, const km_substructure *sub) {
  for (int i = sub->coupling_start; i < sub->coupling_start + sub->coupling_count; ++i) {
    const km_coupling *x = &a->couplings[i], *y = &b->couplings[i];
    if (x->row != y->row || x->term_start != y->term_start || x->term_count != y->term_count)
      return false;
    for (int k = x->term_start; k < x->term_start + x->term_count; ++k) {
      const km_term *s = &a->terms[k], *t = &b->terms[k];
      if (s->coordinate != t->coordinate || s->column != t->column || s->curve_count > 0 || t->curve_count > 0 ||
          s->value_index != t->value_index)
        return false;
    }
  }
  return true;
}

/* True if a ball joint has a limit, which batches do not cover. */
static bool has_limited_ball(const km_driver_motion *d) {
  const km_mechanism *m = d->c.mechanism;
  for (int b = 0; b < m->ball_count && !d->c.ignore_limits; ++b) {
    const int c = m->ball_coordinate[b];
    for (int k = c; k < c + 3; ++k)
      if (km_is_limited(m, k))
        return true;
  }
  return false;
}

bool km_batch_has_same_structure(const km_driver_motion *d, const km_driver_motion *e) {
  const km_mechanism *a = d->c.mechanism, *b = e->c.mechanism;
  if (a->coordinate_count != b->coordinate_count || a->ball_count != b->ball_count || has_limited_ball(e) ||
      d->c.substructure != e->c.substructure || d->c.coordinate != e->c.coordinate || d->c.column != e->c.column)
    return false;
  const km_substructure *s = km_driver_motion_substructure(d), *t = km_driver_motion_substructure(e);
  if (s->rows != t->rows || s->columns != t->columns || s->column_start != t->column_start ||
      s->program_count != t->program_count || s->program_start != t->program_start || s->loop_start != t->loop_start ||
      s->loop_count != t->loop_count || s->coupling_start != t->coupling_start ||
      s->coupling_count != t->coupling_count || t->pattern.start)
    return false;
  for (int p = s->program_start; p < s->program_start + s->program_count; ++p)
    if (!same_program(a, b, p))
      return false;
  for (int i = s->loop_start; i < s->loop_start + s->loop_count; ++i)
    if (a->loop_order[i] != b->loop_order[i] || !same_loop(a, b, a->loop_order[i]))
      return false;
  const size_t columns = (size_t)s->columns * sizeof *a->column_coordinate;
  return memcmp(a->column_coordinate + s->column_start, b->column_coordinate + s->column_start, columns) == 0 &&
         same_couplings(a, b, s);
}

bool km_batch_fits(const km_driver_motion *d) {
  return d->c.substructure >= 0 && km_batch_has_same_structure(d, d);
}

static void copy_vec3(km_lane_vec3 *to, km_vec3 a, int i) {
  to->x.of[i] = a.x;
  to->y.of[i] = a.y;
  to->z.of[i] = a.z;
}

static void copy_pose(km_lane_pose *to, const km_pose *X, int i) {
  for (int k = 0; k < 3; ++k)
    copy_vec3(&to->axis[k], X->R.axis[k], i);
  copy_vec3(&to->p, X->p, i);
}

static void copy_planar_step(km_lane_step *to, const km_planar_step *step, int i) {
  to->x.of[i] = step->x;
  to->y.of[i] = step->y;
  to->ux.of[i] = step->ux;
  to->uy.of[i] = step->uy;
}

static void copy_spatial_step(km_lane_spatial_step *to, const km_step *step, int i) {
  copy_pose(&to->before, &step->before, i);
  to->pitch.of[i] = step->pitch;
}

static void copy_planar_loop(km_batch *l, int index, const km_loop *loop, int i) {
  km_lane_planar_loop *to = &l->planar_loops[index];
  for (int a = 0; a < 2; ++a) {
    to->closing_point[0][a].of[i] = loop->planar_closing_point[0][a];
    to->closing_point[1][a].of[i] = loop->planar_closing_point[1][a];
    to->origin_offset[a].of[i] = loop->planar_origin_offset[a];
    to->point[a].of[i] = loop->planar_point[a];
  }
  to->turn.of[i] = loop->planar_closing_angle;
  for (int k = 0; k < 3; ++k)
    l->loops[index].fixed[k].of[i] = loop->fixed_misfit[2 + k];
}

static void copy_spatial_loop(km_lane_spatial_loop *to, const km_loop *loop, int i) {
  for (int a = 0; a < 2; ++a)
    copy_pose(&to->closing_frame[a], &loop->closing_frame[a], i);
  copy_vec3(&to->origin_offset, loop->origin_offset, i);
  copy_vec3(&to->point, loop->point[0], i);
}

static void copy_program(km_batch *l, const km_mechanism *m, const km_program *program, int i) {
  for (int k = program->step_start; k < program->step_start + program->step_count; ++k)
    if (program->planar)
      copy_planar_step(&l->steps[k], &m->planar_steps[k], i);
    else
      copy_spatial_step(&l->spatial_steps[k], &m->steps[k], i);
  for (int k = program->loop_start; k < program->loop_start + program->loop_count; ++k) {
    int index = m->loop_order[k];
    if (program->planar)
      copy_planar_loop(l, index, &m->loops[index], i);
    else
      copy_spatial_loop(&l->spatial_loops[index], &m->loops[index], i);
  }
}

/* Computes the positions of the loop's rows behind `start`; `none` for components without a row. */
static void set_row_positions(const km_loop *loop, int start, int none, int *position) {
  for (int a = 0; a < 6; ++a)
    position[a] = none * KM_BATCH_LANES;
  for (int r = 0; r < loop->lambda; ++r)
    position[loop->rows[r]] = (start + r) * KM_BATCH_LANES;
}

/* Marks the steps whose pose only the driver changes: constant while the loops close. */
static void mark_constant_steps(km_batch *l, const km_program *program) {
  const km_planar_step *steps = l->m->planar_steps + program->step_start;
  km_lane_step *marks = l->steps + program->step_start;
  for (int i = 0; i < program->step_count; ++i) {
    bool depends_on_driver_only = steps[i].from == 0;
    for (int k = 0; k < i && !depends_on_driver_only; ++k)
      depends_on_driver_only = steps[k].to == steps[i].from && marks[k].is_constant;
    marks[i].is_constant = depends_on_driver_only && steps[i].coordinate == l->coordinate;
  }
}

/* Marks the steps whose pose is stored in a slot: ends of loops, and predecessors of a step other than the next. */
static void mark_stored_steps(km_batch *l, const km_program *program) {
  const km_planar_step *steps = l->m->planar_steps + program->step_start;
  for (int i = 0; i < program->step_count; ++i) {
    km_lane_step *mark = &l->steps[program->step_start + i];
    mark->is_stored = mark->is_constant;
    for (int k = i + 2; k < program->step_count; ++k)
      mark->is_stored = mark->is_stored || steps[k].from == steps[i].to;
    for (int k = program->loop_start; k < program->loop_start + program->loop_count; ++k) {
      const km_loop *loop = &l->m->loops[l->m->loop_order[k]];
      mark->is_stored = mark->is_stored || loop->slot[0] == steps[i].to || loop->slot[1] == steps[i].to;
    }
  }
}

/* Initialises slot 0 of every program, its base, to the identity. */
static void initialise_base(km_batch *l) {
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    if (l->slots)
      l->slots[0].cosine.of[i] = 1.0;
    if (l->poses)
      l->poses[0].axis[0].x.of[i] = l->poses[0].axis[1].y.of[i] = l->poses[0].axis[2].z.of[i] = 1.0;
  }
}

/* Sets the positions of one loop's rows and entries. */
static void set_loop_positions(km_batch *l, const km_program *program, int index) {
  const km_mechanism *m = l->m;
  const km_loop *loop = &m->loops[index];
  set_row_positions(loop, loop->row_start, l->sub->rows, l->loops[index].row);
  for (int i = loop->entry_start; i < loop->entry_start + loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[i];
    km_lane_entry *to = &l->entries[i];
    to->step = entry->step;
    to->side = entry->side;
    const int step = program->step_start + entry->step;
    to->columns = program->planar ? 1 : km_primitive_freedom(m->steps[step].primitive);
    to->turn = program->planar && !m->planar_steps[step].is_slide ? m->planar_steps[step].sign : 0.0;
    to->column_stride = (int)entry->column_stride * KM_BATCH_LANES;
    set_row_positions(loop, (int)entry->value_index, l->sub->rows * l->sub->columns, to->position);
  }
}

void km_batch_copy_structure(km_batch *l) {
  const km_mechanism *m = l->m;
  initialise_base(l);
  const km_program *program = &m->programs[l->sub->program_start], *end = program + l->sub->program_count;
  if (l->sub->program_count == 1 && program->planar) /* several programs would share the slots */
    mark_constant_steps(l, program);
  for (; program < end; ++program) {
    if (program->planar)
      mark_stored_steps(l, program);
    for (int k = program->loop_start; k < program->loop_start + program->loop_count; ++k)
      set_loop_positions(l, program, m->loop_order[k]);
  }
}

static void copy_couplings(km_batch *l, const km_mechanism *m, int i) {
  for (int k = l->sub->coupling_start; k < l->sub->coupling_start + l->sub->coupling_count; ++k) {
    const km_coupling *coupling = &m->couplings[k];
    l->couplings[k].constant.of[i] = coupling->constant;
    for (int t = coupling->term_start; t < coupling->term_start + coupling->term_count; ++t) {
      l->coefficients[t].of[i] = m->terms[t].coefficient;
      l->term_unit[t].of[i] = m->unit[m->terms[t].coordinate];
    }
  }
}

void km_batch_copy_numbers(km_batch *l, int i) {
  const km_driver_motion *d = l->drives[i];
  const km_mechanism *m = d->c.mechanism;
  const km_substructure *sub = km_driver_motion_substructure(d);
  for (int p = sub->program_start; p < sub->program_start + sub->program_count; ++p)
    copy_program(l, m, &m->programs[p], i);
  copy_couplings(l, m, i);
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    l->unit[k].of[i] = m->unit[c];
    l->weight[k].of[i] = m->column_weight[sub->column_start + k];
    l->low[k].of[i] = m->low[c];
    l->high[k].of[i] = m->high[c];
    l->is_length[k] = km_model_coordinate_is_length(m->model, c);
    l->is_ball[k] = m->ball_of[c] >= 0;
    l->is_limited[k] = l->is_limited[k] || (!d->c.ignore_limits && (isfinite(m->low[c]) || isfinite(m->high[c])));
  }
  l->size.of[i] = sub->size;
  l->inverse_size.of[i] = 1.0 / sub->size;
  l->factor.of[i] = km_driver_motion_factor(d);
  l->closure_tolerance.of[i] = m->closure_tolerance;
  l->driver_low.of[i] = d->c.ignore_limits ? -HUGE_VAL : m->low[l->coordinate] / m->unit[l->coordinate];
  l->driver_high.of[i] = d->c.ignore_limits ? HUGE_VAL : m->high[l->coordinate] / m->unit[l->coordinate];
}
