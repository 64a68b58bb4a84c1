#include "kmech/losses.h"

#include "analysis/lever.h"
#include "analysis/statics.h"
#include "kinematics/poses.h"

#include <string.h>

enum { MOST_ITERATIONS = 500 };
static const double settled = 1e-13; /* relative change of the input's force */

struct km_losses_work {
  km_lever *lever;
  km_forces *forces;
  km_statics statics;
  double *lost; /* [coordinate] friction along +q, of the last iteration */
};

/* The joint's friction: false if it has none. */
static bool friction_of(const km_model *model, int joint, double *coefficient, double *radius) {
  const km_value *friction = km_value_get(model->joints[joint].source, "friction");
  const km_value *c = km_value_get(friction, "coefficient"), *r = km_value_get(friction, "radius");
  *coefficient = c ? c->number : 0.0;
  *radius = r ? r->number : 0.0;
  return *coefficient != 0.0;
}

bool km_model_has_friction(const km_model *model) {
  double coefficient, radius;
  for (int j = 0; j < model->joint_count; ++j)
    if (friction_of(model, j, &coefficient, &radius))
      return true;
  return false;
}

/* A load of 1 against the output: in its joint, or at its point. */
static km_status create(const km_mechanism *m, const km_handle *input, const km_handle *output, km_losses_work *w,
                        km_error *error) {
  static const double weightless[3] = {0, 0, 0};
  const double *d = output->direction;
  km_load load = {output->frame, {-d[0], -d[1], -d[2]}, {0, 0, 0}, false};
  km_status status = km_lever_create(m, input, output, &w->lever, error);
  if (!status)
    status = km_forces_create(m, weightless, &load, output->coordinate < 0, &w->forces, error);
  if (!status)
    status = km_statics_create(m, &input->coordinate, input->coordinate >= 0, KM_AXES_FIXED, &w->statics, error);
  if (!status && !(w->lost = KM_NEW(double, (size_t)m->coordinate_count)))
    status = km_fail(error, KM_MEMORY, "out of memory for the losses");
  if (!status)
    w->forces->spring_count = 0;
  return status;
}

km_status km_losses_create(const km_mechanism *m, const km_handle *input, const km_handle *output, km_losses_work **out,
                           km_error *error) {
  km_losses_work *w = *out = KM_NEW(km_losses_work, 1);
  if (!w)
    return km_fail(error, KM_MEMORY, "out of memory for the losses");
  km_status status = create(m, input, output, w, error);
  if (status) {
    km_losses_free(w);
    *out = NULL;
  }
  return status;
}

void km_losses_free(km_losses_work *w) {
  if (!w)
    return;
  km_lever_free(w->lever);
  km_forces_free(w->forces);
  km_statics_free(&w->statics);
  km_free(w->lost);
  km_free(w);
}

/* The force of a joint's reaction across a coordinate's axis; of balls and threads all of it. */
static double normal_force(const km_mechanism *m, const km_losses_work *w, int c) {
  const km_twist *h = &w->statics.work->twist[c];
  km_vec3 force = km_vec3_make(w->statics.reactions[m->model->coordinates[c].joint].force);
  bool turns = km_vec3_norm(h->w) > 0.5;
  km_vec3 axis = turns ? h->w : h->v;
  bool all = m->ball_of[c] >= 0 || m->model->joints[m->model->coordinates[c].joint].type == KM_SCREW;
  if (!all)
    force = km_vec3_axpy(-km_vec3_dot(force, axis), axis, force);
  return km_vec3_norm(force);
}

/* Friction against the motion `rates`, from the last reactions. */
static void resist(const km_mechanism *m, km_losses_work *w, const double *rates) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_coordinate_def *def = &m->model->coordinates[c];
    double coefficient, radius;
    w->lost[c] = 0.0;
    if (m->held[c] || !friction_of(m->model, def->joint, &coefficient, &radius))
      continue;
    double arm = km_joint_is_length(m->model->joints[def->joint].type, def->index) ? 1.0 : radius;
    double part = 1.0; /* of a ball's turn about this axis */
    if (m->ball_of[c] >= 0) {
      const double *turn = rates + m->ball_coordinate[m->ball_of[c]];
      double speed = km_vec3_norm(km_vec3_make(turn));
      part = speed > 0.0 ? fabs(rates[c]) / speed : 0.0;
    }
    if (fabs(rates[c]) > 1e-12 * m->unit[c])
      w->lost[c] = -copysign(coefficient * arm * part * normal_force(m, w, c), rates[c]);
  }
}

static void set_extra(const km_mechanism *m, km_losses_work *w) {
  int output = w->lever->output.handle.coordinate;
  memcpy(w->forces->extra, w->lost, (size_t)m->coordinate_count * sizeof *w->lost);
  if (output >= 0)
    w->forces->extra[output] -= 1.0;
}

void km_losses_update(const km_mechanism *m, km_state *s, km_losses_work *w, km_losses *out) {
  km_advantage a;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan("")};
  km_lever_update(m, s, w->lever, &a);
  if (w->lever->input.handle.coordinate < 0 || a.state != KM_ADVANTAGE_FINITE) {
    out->why = a.state != KM_ADVANTAGE_FINITE ? "the mechanical advantage isn't finite" : "the input is no joint";
    return;
  }
  /* The motion in which the output goes against its load. */
  for (int c = 0; c < m->coordinate_count && a.output_rate < 0.0; ++c)
    w->lever->rates[c] = -w->lever->rates[c];
  double ideal = 1.0 / a.value, force = ideal, last = ideal;
  memset(w->lost, 0, (size_t)m->coordinate_count * sizeof *w->lost);
  int i = 0;
  for (; i < MOST_ITERATIONS && (i < 2 || fabs(force - last) > settled * fabs(force)); ++i) {
    last = force;
    set_extra(m, w);
    km_statics_update(m, s, w->forces, &w->statics);
    if (!w->statics.held) {
      out->why = "the input alone can't hold the output";
      return;
    }
    force = w->statics.actuator_forces[0];
    if (!(fabs(force) < 1e9 * fabs(ideal)) || force * ideal < 0.0)
      break;
    resist(m, w, w->lever->rates);
  }
  out->locks = i == MOST_ITERATIONS || !(fabs(force) < 1e9 * fabs(ideal)) || force * ideal < 0.0;
  out->ratio = out->locks ? 0.0 : 1.0 / force;
  out->efficiency = out->ratio / a.value;
}
