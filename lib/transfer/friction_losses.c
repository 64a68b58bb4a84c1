/* Efficiency and self-locking by Coulomb friction in the joints (theory 8.6).
 *
 *   all reactions are linear in the output's load (1) and the normal forces N_k:
 *   a_c  load of surface c under the load without friction;  B_ck, w_k  from a unit normal force at surface k
 *   efficiency = remaining load with all friction;  force ratio = mechanical advantage · efficiency */
#include "base/number/tolerances.h"
#include "kmech/transfer.h"

#include "base/arguments.h"
#include "transfer/coulomb_friction.h"
#include "transfer/friction_surfaces.h"
#include "transfer/transfer.h"

#include <string.h>

struct km_losses_workspace {
  km_arena arena;
  km_transfer *transfer;
  km_forces *forces;
  km_statics statics;
  km_surface *surface; /* [surface_count] surfaces with friction */
  int surface_count;
  km_surface *sliding;   /* [friction.count] surfaces that slide in this motion */
  double *unit_friction; /* [friction.count] friction force along +q for a normal force of 1 */
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

static km_status create_parts(const km_mechanism *m, const km_port *input, const km_port *output,
                              km_losses_workspace *w, km_error *error) {
  km_status status = km_transfer_create(m, input, output, &w->transfer, error);
  if (!status)
    status = km_unit_load_create(m, input, output, &w->forces, &w->statics, error);
  size_t most = 2 * (size_t)m->coordinate_count;
  w->surface = KM_ARENA_NEW(&w->arena, km_surface, most);
  w->sliding = KM_ARENA_NEW(&w->arena, km_surface, most);
  w->unit_friction = KM_ARENA_NEW(&w->arena, double, most);
  if (!w->arena.failed)
    w->surface_count = km_surfaces_list(m, w->surface);
  if (!status && (w->arena.failed || !km_friction_reserve(&w->friction, w->surface_count, &w->arena)))
    status = km_fail(error, KM_MEMORY, "out of memory for the losses");
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
  km_status status = create_parts(m, input, output, w, error);
  if (status) {
    km_losses_free(w);
    *out = NULL;
  }
  return status;
}

void km_losses_free(km_losses_workspace *w) {
  if (!w)
    return;
  km_transfer_free(w->transfer);
  km_forces_free(w->forces);
  km_statics_free(&w->statics);
  km_arena_free(&w->arena);
  km_free(w);
}

/* Finds the surfaces that slide in the motion `rates`, and their friction for a unit normal force. */
static void find_sliding(const km_mechanism *m, km_losses_workspace *w, const double *rates) {
  w->friction.count = 0;
  for (int i = 0; i < w->surface_count; ++i) {
    int c = w->surface[i].coordinate;
    if (fabs(rates[c]) <= 1e-12 * m->unit[c])
      continue;
    double arm = km_slip_arm(m, c), coefficient = m->model->joints[m->model->coordinates[c].joint].friction.coefficient;
    w->unit_friction[w->friction.count] = -coefficient * arm * (arm * rates[c] / km_slip_speed(m, rates, c));
    w->sliding[w->friction.count++] = w->surface[i];
  }
}

/* Adds the axial part of a thread's own friction to its load, for a normal force of 1: μ tan λ along the axis, with
 * the sign of the rate. */
static void add_own_friction(const km_mechanism *m, km_losses_workspace *w, int surface) {
  int c = w->sliding[surface].coordinate;
  double *entry = w->friction.B + 3 * (surface * w->friction.count + surface);
  double along = -w->unit_friction[surface] / km_slip_arm(m, c) * km_thread_slope(m, c);
  km_vec3 sum = km_vec3_axpy(along, km_surface_axis(&w->statics, c), km_vec3_from_array(entry));
  km_vec3_write(sum, entry);
}

/* Balances the load of 1 against the output, and the friction of a unit normal force at one surface (-1: none).
 * Returns the input's force. */
static double balance_unit_load(const km_mechanism *m, km_state *s, km_losses_workspace *w, int surface) {
  int output = w->transfer->output.port.coordinate;
  memset(w->forces->extra, 0, (size_t)m->coordinate_count * sizeof *w->forces->extra);
  if (output >= 0)
    w->forces->extra[output] = -1.0;
  if (surface >= 0)
    w->forces->extra[w->sliding[surface].coordinate] += w->unit_friction[surface];
  km_statics_compute(m, s, w->forces, &w->statics);
  return w->statics.held ? w->statics.actuator_forces[0] : nan("");
}

/* Returns the largest reaction of a joint; torques count over the characteristic length. */
static double largest_reaction(const km_mechanism *m, const km_statics *st) {
  double size = 0.0;
  for (int j = 0; j < m->topology.joint_count; ++j) {
    km_vec3 force = km_vec3_from_array(st->reactions[j].force), torque = km_vec3_from_array(st->reactions[j].torque);
    size = fmax(size, fmax(km_vec3_norm(force), km_vec3_norm(torque) / m->length));
  }
  return size;
}

/* Writes a force; up to `least` it is 0. */
static void write_force(km_vec3 a, double least, double *to) {
  if (km_vec3_norm(a) <= least)
    a = (km_vec3){0.0, 0.0, 0.0};
  km_vec3_write(a, to);
}

/* Computes a, B and w from static balances: under the input force that holds a load of 1 without friction there
 * remains a load of 1 − Σ w N, and each surface carries a + Σ B N. False if the input alone cannot hold the output. */
static bool compute_coefficients(const km_mechanism *m, km_state *s, km_losses_workspace *w) {
  km_friction *f = &w->friction;
  double frictionless_force = balance_unit_load(m, s, w, -1), frictionless_reaction = largest_reaction(m, &w->statics);
  for (int c = 0; c < f->count; ++c)
    write_force(km_surface_load(m, &w->statics, &w->sliding[c]), km_solved_rounding * frictionless_reaction,
                f->a + 3 * c);
  for (int k = 0; k < f->count && isfinite(frictionless_force); ++k) {
    double force = balance_unit_load(m, s, w, k);
    if (isnan(force))
      return false;
    f->w[k] = (force - frictionless_force) / frictionless_force;
    double least =
        km_solved_rounding * (largest_reaction(m, &w->statics) + fabs(1.0 + f->w[k]) * frictionless_reaction);
    for (int c = 0; c < f->count; ++c) {
      km_vec3 load = km_surface_load(m, &w->statics, &w->sliding[c]), a = km_vec3_from_array(f->a + 3 * c);
      write_force(km_vec3_axpy(-1.0 - f->w[k], a, load), least, f->B + 3 * (c * f->count + k));
    }
    add_own_friction(m, w, k);
  }
  return isfinite(frictionless_force);
}

km_status km_losses_compute(const km_mechanism *m, km_state *s, km_losses_workspace *w, km_losses *out) {
  if (!out)
    return KM_USAGE;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan(""), .locks_from = nan(""), .why = "the mobility isn't known"};
  if (!w || w->transfer->mechanism != m || !km_state_mobility_is_known(m, s))
    return KM_USAGE;
  km_advantage a;
  *out = (km_losses){.ratio = nan(""), .efficiency = nan(""), .locks_from = nan("")};
  km_status status = km_transfer_compute(m, s, w->transfer, &a);
  if (status)
    return status;
  if (w->transfer->input.port.kind != KM_PORT_JOINT || a.state != KM_ADVANTAGE_FINITE) {
    out->why = a.state != KM_ADVANTAGE_FINITE ? "the mechanical advantage isn't finite" : "the input is no joint";
    return KM_OK;
  }
  /* the motion in which the output moves against its load */
  for (int c = 0; c < m->coordinate_count && a.output_rate < 0.0; ++c)
    w->transfer->rates[c] = -w->transfer->rates[c];
  find_sliding(m, w, w->transfer->rates);
  if (!compute_coefficients(m, s, w)) {
    bool failed = w->statics.work->arena.failed;
    out->why = failed ? "there is no memory" : "the input alone can't hold the output";
    return failed ? KM_MEMORY : KM_OK;
  }
  km_friction_outcome outcome = km_friction_solve(&w->friction);
  if (outcome == KM_FRICTION_OPEN) {
    out->why = "neither motion nor self-locking could be proved";
    return KM_OK;
  }
  out->locks = outcome == KM_FRICTION_LOCKS;
  out->locks_from = out->locks ? w->friction.locks_from : nan("");
  out->efficiency = out->locks ? 0.0 : w->friction.load;
  out->ratio = out->efficiency * a.value;
  return KM_OK;
}
