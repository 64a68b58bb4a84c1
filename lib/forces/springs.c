/* Force modules of type stiffness: a force from a displacement, between frames or in a joint. */
#include "forces/forces.h"

double km_law_force(const km_law *law, double x) {
  int piece = 0;
  while (piece < law->knot_count && x >= law->knots[piece])
    ++piece;
  double force = 0.0;
  for (int k = law->start[piece + 1] - 1; k >= law->start[piece]; --k)
    force = force * x + law->coefficients[k];
  return force;
}

km_status km_springs_gather(const km_model *model, km_forces *f, km_error *error) {
  f->springs = KM_ARENA_NEW(&f->arena, const km_model_module *, (size_t)model->module_count);
  for (int i = 0; i < model->module_count && f->springs; ++i)
    if (model->modules[i].type == KM_MODULE_STIFFNESS)
      f->springs[f->spring_count++] = &model->modules[i];
  return f->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the springs") : KM_OK;
}

/* A port between frames as it stands: from the parent's origin to the child's, and the line of its displacement. */
typedef struct line {
  km_vec3 from, to, along; /* unit vector */
  double displacement;
} line;

/* Two points in one place have no line between them: a force there has no direction, and counts as 0. */
static line line_of(const km_mechanism *m, const km_forces *f, const km_port *port, km_distance distance) {
  const km_model_frame *a = &m->model->frames[port->frame[0]], *b = &m->model->frames[port->frame[1]];
  km_pose A = km_pose_product(&f->pose[a->body], &a->pose);
  line l = {.from = A.p, .to = km_pose_point(&f->pose[b->body], b->pose.p)};
  km_vec3 way = km_vec3_sub(l.to, l.from);
  if (distance == KM_DISTANCE_EUCLID) {
    l.displacement = km_vec3_norm(way);
    l.along = l.displacement > 0.0 ? km_vec3_scale(1.0 / l.displacement, way) : (km_vec3){0, 0, 0};
  } else {
    l.along = A.R.axis[distance - KM_DISTANCE_X];
    l.displacement = km_vec3_dot(l.along, way);
  }
  return l;
}

static double displacement(const km_mechanism *m, const km_state *s, const km_forces *f,
                           const km_model_module *spring) {
  if (spring->input.coordinate >= 0)
    return s->q[spring->input.coordinate];
  return line_of(m, f, &spring->input, spring->distance).displacement;
}

/* Pushes the two frames apart. Both forces act at the child's point: along a parent's axis their line must pass
 * through it, so that the power is that of the displacement. */
static void push(const km_mechanism *m, km_forces *f, const km_model_module *spring, double force) {
  const km_vec3 none = {0, 0, 0};
  line l = line_of(m, f, &spring->output, spring->distance);
  const int *frame = spring->output.frame;
  km_forces_add(f, m->model->frames[frame[1]].body, km_vec3_scale(force, l.along), none, l.to);
  km_forces_add(f, m->model->frames[frame[0]].body, km_vec3_scale(-force, l.along), none, l.to);
}

void km_springs_add(const km_mechanism *m, const km_state *s, km_forces *f) {
  for (int i = 0; i < f->spring_count; ++i) {
    const km_model_module *spring = f->springs[i];
    double force = km_law_force(&spring->law, displacement(m, s, f, spring));
    int c = spring->output.coordinate;
    if (c < 0)
      push(m, f, spring, force);
    else
      km_forces_add_joint(m->model, f, c, force);
  }
}
