/* Actuators that push points of bodies. Symbols: r the rates of the point along its direction d per unit rate of each
 * coordinate, so that a force f along d does the work f r · δq, and Z_A has the row r D⁻¹ Z. */
#include "analysis/statics.h"

/* Calls for every free coordinate between the point's body and the inertial frame in the tree. */
typedef void (*visit)(void *context, int coordinate, bool against);

static void each_coordinate(const km_mechanism *m, int body, visit at, void *context) {
  for (int b = body; b > 0; b = m->topology.parent[b]) {
    int joint = m->topology.arc[b], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c)
      if (!m->held[c])
        at(context, c, m->topology.against[joint]);
  }
}

static int body_of(const km_mechanism *m, const km_handle *point) {
  return m->model->frames[point->frame].body;
}

/* What moves a point. */
typedef struct movers {
  const km_mechanism *m;
  int part, alone, count; /* substructures and lone coordinates, those of one kind once */
} movers;

static void note_mover(void *context, int c, bool against) {
  movers *f = context;
  int part = f->m->substructure_of[c];
  (void)against;
  if (part >= 0 && part == f->part)
    return;
  f->part = part;
  f->alone = part < 0 ? c : -1;
  f->count++;
}

km_status km_pushed_point_place(const km_mechanism *m, km_statics *st, int actuator, km_error *error) {
  const km_handle *point = &st->work->actuators[actuator];
  movers f = {m, -1, -1, 0};
  each_coordinate(m, body_of(m, point), note_mover, &f);
  st->work->part[actuator] = f.part;
  st->work->alone[actuator] = f.alone;
  if (f.count == 1)
    return KM_OK;
  return km_fail(error, KM_USAGE,
                 f.count ? "actuator %s moves with %d parts of the mechanism; expected a point that moves with one "
                           "substructure, or one joint in no loop: hold the others"
                         : "actuator %s can't move: nothing between it and the inertial frame is free",
                 point->name, f.count);
}

/* The unit force of a point, about the forces' origin. */
static km_wrench unit_push(const km_mechanism *m, const km_forces *f, const km_handle *point) {
  const km_model_frame *frame = &m->model->frames[point->frame];
  km_vec3 d = km_vec3_make(point->direction), none = {0, 0, 0};
  return km_wrench_at(d, none, km_pose_point(&f->pose[frame->body], frame->pose.p));
}

typedef struct row {
  const km_twist *twist;
  km_wrench push;
  double *out;
} row;

static void fill_row(void *context, int c, bool against) {
  row *r = context;
  r->out[c] = (against ? -1.0 : 1.0) * km_wrench_power(r->push, r->twist[c]);
}

void km_pushed_points_update(const km_mechanism *m, const km_forces *f, km_statics *st) {
  km_statics_work *w = st->work;
  for (int a = 0; a < st->actuator_count; ++a) {
    const km_handle *point = &st->actuators[a];
    if (point->kind != KM_HANDLE_POINT)
      continue;
    row r = {w->twist, unit_push(m, f, point), w->row[a]};
    each_coordinate(m, body_of(m, point), fill_row, &r);
  }
}

void km_pushed_points_apply(const km_mechanism *m, const km_forces *f, km_statics *st) {
  km_statics_work *w = st->work;
  for (int a = 0; a < st->actuator_count; ++a) {
    const km_handle *point = &st->actuators[a];
    double force = st->actuator_forces[a];
    if (point->kind != KM_HANDLE_POINT)
      continue;
    for (int b = body_of(m, point); b > 0; b = m->topology.parent[b])
      w->subtree[b] = km_wrench_axpy(force, unit_push(m, f, point), w->subtree[b]);
    for (int c = 0; c < m->coordinate_count; ++c)
      w->tau[c] += force * w->row[a][c];
  }
}

bool km_pushes_by_force(const km_model *model, const km_handle *actuator) {
  if (actuator->kind == KM_HANDLE_POINT)
    return true;
  const km_model_coordinate *def = &model->coordinates[actuator->coordinate];
  return km_joint_is_length(model->joints[def->joint].type, def->index);
}

void km_push_unit(const km_model *model, const km_handle *actuator, km_text *out) {
  if (actuator->kind == KM_HANDLE_POINT)
    km_text_add(out, model->units.force->suffix);
  else
    km_force_unit(model, actuator->coordinate, out);
}
