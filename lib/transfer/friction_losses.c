/* Friction in joints: the force ratio with it, and whether the mechanism locks itself. */
#include "kmech/transfer.h"

#include "base/arguments.h"
#include "transfer/coulomb_friction.h"
#include "transfer/friction_surfaces.h"
#include "transfer/transfer.h"

#include <string.h>

/* A force smaller than this share of the largest one is what rounding leaves where nothing presses. */
static const double rounded = 1e-12;

struct km_losses_workspace {
  km_arena arena;
  km_transfer *lever;
  km_forces *forces;
  km_statics statics;
  km_surface *surface; /* [surface_count] all that can rub */
  int surface_count;
  km_surface *rubbing; /* [friction.count] those that slide in this motion */
  double *resists;     /* [friction.count] the friction along +q for a normal force of 1 */
  km_friction friction;
};

bool km_model_has_friction(const km_model *model) {
  if (!model)
    return false;
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].friction.coefficient != 0.0)
      return true;
  return false;
}

/* A load of 1 against the output: in its joint, or at its point. */
static km_status create(const km_mechanism *m, const km_port *input, const km_port *output, km_losses_workspace *w,
                        km_error *error) {
  static const double weightless[3] = {0, 0, 0};
  const double *d = output->direction;
  km_load load = {output->frame, {-d[0], -d[1], -d[2]}, {0, 0, 0}, false};
  km_status status = km_transfer_create(m, input, output, &w->lever, error);
  if (!status)
    status = km_forces_create(m, weightless, &load, output->kind == KM_PORT_POINT, &w->forces, error);
  if (!status)
    status = km_statics_create(m, &input->coordinate, input->kind == KM_PORT_JOINT, KM_AXES_FIXED, &w->statics, error);
  size_t most = 2 * (size_t)m->coordinate_count;
  w->surface = KM_ARENA_NEW(&w->arena, km_surface, most);
  w->rubbing = KM_ARENA_NEW(&w->arena, km_surface, most);
  w->resists = KM_ARENA_NEW(&w->arena, double, most);
  if (!w->arena.failed)
    w->surface_count = km_surfaces_list(m, w->surface);
  if (!status && (w->arena.failed || !km_friction_reserve(&w->friction, w->surface_count, &w->arena)))
    status = km_fail(error, KM_MEMORY, "out of memory for the losses");
  if (!status)
    w->forces->spring_count = 0;
  return status;
}

km_status km_losses_create(const km_mechanism *m, const km_port *input, const km_port *output,
                           km_losses_workspace **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_ports(m, input, output, error);
  if (fits)
    return fits;
  km_losses_workspace *w = *out = KM_NEW(km_losses_workspace, 1);
  if (!w)
    return km_fail(error, KM_MEMORY, "out of memory for the losses");
  km_status status = create(m, input, output, w, error);
  if (status) {
    km_losses_free(w);
    *out = NULL;
  }
  return status;
}

void km_losses_free(km_losses_workspace *w) {
  if (!w)
    return;
  km_transfer_free(w->lever);
  km_forces_free(w->forces);
  km_statics_free(&w->statics);
  km_arena_free(&w->arena);
  km_free(w);
}

/* What rubs in the motion `rates`. */
static void find_rubbing(const km_mechanism *m, km_losses_workspace *w, const double *rates) {
  w->friction.count = 0;
  for (int i = 0; i < w->surface_count; ++i) {
    int c = w->surface[i].coordinate;
    if (fabs(rates[c]) <= 1e-12 * m->unit[c])
      continue;
    double arm = km_slip_arm(m, c), coefficient = m->model->joints[m->model->coordinates[c].joint].friction.coefficient;
    w->resists[w->friction.count] = -coefficient * arm * (arm * rates[c] / km_slip_speed(m, rates, c));
    w->rubbing[w->friction.count++] = w->surface[i];
  }
}

/* What a thread's own friction adds to its load, for a normal force of 1: μ tan λ along the axis, with the sense of the rate. */
static void add_own_friction(const km_mechanism *m, km_losses_workspace *w, int place) {
  int c = w->rubbing[place].coordinate;
  double *own = w->friction.B + 3 * (place * w->friction.count + place);
  double along = -w->resists[place] / km_slip_arm(m, c) * km_thread_slope(m, c);
  km_vec3 sum = km_vec3_axpy(along, km_surface_axis(&w->statics, c), km_vec3_from_array(own));
  memcpy(own, (double[3]){sum.x, sum.y, sum.z}, 3 * sizeof *own);
}

/* Balances the load of 1 against the output, and friction from a normal force of 1 at one place (-1: none). Returns the
 * input's force. */
static double balance(const km_mechanism *m, km_state *s, km_losses_workspace *w, int place) {
  int output = w->lever->output.handle.coordinate;
  memset(w->forces->extra, 0, (size_t)m->coordinate_count * sizeof *w->forces->extra);
  if (output >= 0)
    w->forces->extra[output] = -1.0;
  if (place >= 0)
    w->forces->extra[w->rubbing[place].coordinate] += w->resists[place];
  km_statics_compute(m, s, w->forces, &w->statics);
  return w->statics.held ? w->statics.actuator_forces[0] : nan("");
}

/* The largest force that any joint carries, of torques the force at the arm of the characteristic length. */
static double largest_reaction(const km_mechanism *m, const km_statics *st) {
  double size = 0.0;
  for (int j = 0; j < m->topology.joint_count; ++j) {
    km_vec3 force = km_vec3_from_array(st->reactions[j].force), torque = km_vec3_from_array(st->reactions[j].torque);
    size = fmax(size, fmax(km_vec3_norm(force), km_vec3_norm(torque) / m->length));
  }
  return size;
}

/* Forces up to `least` are 0. */
static void put(km_vec3 a, double least, double *to) {
  if (km_vec3_norm(a) <= least)
    a = (km_vec3){0.0, 0.0, 0.0};
  memcpy(to, (double[3]){a.x, a.y, a.z}, 3 * sizeof *to);
}

/* Everything is linear in the load and the normal forces N: under the input force that holds a load of 1 without
 * friction there remains a load of 1 − Σ w N, and what presses on each place is a + Σ B N. False if the input alone
 * can't hold the output. */
static bool make_equations(const km_mechanism *m, km_state *s, km_losses_workspace *w) {
  km_friction *f = &w->friction;
  double ideal = balance(m, s, w, -1), alone = largest_reaction(m, &w->statics);
  for (int c = 0; c < f->count; ++c)
    put(km_surface_load(m, &w->statics, &w->rubbing[c]), rounded * alone, f->a + 3 * c);
  for (int k = 0; k < f->count && isfinite(ideal); ++k) {
    double force = balance(m, s, w, k);
    if (isnan(force))
      return false;
    f->w[k] = (force - ideal) / ideal;
    double least = rounded * (largest_reaction(m, &w->statics) + fabs(1.0 + f->w[k]) * alone);
    for (int c = 0; c < f->count; ++c) {
      km_vec3 both = km_surface_load(m, &w->statics, &w->rubbing[c]), a = km_vec3_from_array(f->a + 3 * c);
      put(km_vec3_axpy(-1.0 - f->w[k], a, both), least, f->B + 3 * (c * f->count + k));
    }
    add_own_friction(m, w, k);
  }
  return isfinite(ideal);
}

km_status km_losses_compute(const km_mechanism *m, km_state *s, km_losses_workspace *w, km_losses *out) {
  if (!out)
    return KM_USAGE;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan(""), .locks_from = nan(""), .why = "the mobility isn't known"};
  if (!w || w->lever->mechanism != m || !km_state_mobility_is_known(m, s))
    return KM_USAGE;
  km_advantage a;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan(""), .locks_from = nan("")};
  km_status status = km_transfer_compute(m, s, w->lever, &a);
  if (status)
    return status;
  if (w->lever->input.handle.kind != KM_PORT_JOINT || a.state != KM_ADVANTAGE_FINITE) {
    out->why = a.state != KM_ADVANTAGE_FINITE ? "the mechanical advantage isn't finite" : "the input is no joint";
    return KM_OK;
  }
  /* The motion in which the output goes against its load. */
  for (int c = 0; c < m->coordinate_count && a.output_rate < 0.0; ++c)
    w->lever->rates[c] = -w->lever->rates[c];
  find_rubbing(m, w, w->lever->rates);
  if (!make_equations(m, s, w)) {
    bool failed = w->statics.work->arena.failed;
    out->why = failed ? "there is no memory" : "the input alone can't hold the output";
    return failed ? KM_MEMORY : KM_OK;
  }
  km_friction_answer answer = km_friction_solve(&w->friction);
  if (answer == KM_FRICTION_OPEN) {
    out->why = "neither motion nor self-locking could be proved";
    return KM_OK;
  }
  out->locks = answer == KM_FRICTION_LOCKS;
  out->locks_from = out->locks ? w->friction.locks_from : nan("");
  out->efficiency = out->locks ? 0.0 : w->friction.load;
  out->ratio = out->efficiency * a.value;
  return KM_OK;
}
