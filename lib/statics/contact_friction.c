/* Contacts and stops of a static balance, and the part that friction of the contacts may take of each actuator's force
 * (docs/theory.md 9.7).
 *
 *   N_i normal force of contact i, given by its penetration
 *   F_i friction in the tangent plane (e_1, e_2),   |F_i| <= μ_i N_i
 *   f(F) = f(0) + Σ A_i F_i,   A_i = (a_i1 a_i2) the actuators' forces against unit forces along e_1, e_2
 *   f_j within f_j(0) ± Σ μ_i N_i |row j of A_i|
 *
 * f is linear in the loads, because the normal forces don't depend on it. */
#include "statics/statics.h"

/* Applies unit forces along `direction` on both bodies of a contact as the only loads. */
static void apply_unit_friction(const km_mechanism *m, km_forces *f, const km_model_module *contact, km_vec3 direction,
                                km_vec3 point) {
  const km_vec3 none = {0, 0, 0};
  const km_model_frame *frames = m->model->frames;
  memset(f->body, 0, (size_t)m->topology.body_count * sizeof *f->body);
  memset(f->joint, 0, (size_t)m->coordinate_count * sizeof *f->joint);
  f->force_size = f->couple_size = 0.0;
  km_forces_add(f, frames[contact->output.frame[1]].body, direction, none, point);
  km_forces_add(f, frames[contact->output.frame[0]].body, km_vec3_scale(-1.0, direction), none, point);
}

/* Adds Σ μ N |row of A| of one contact to the shares. */
static void add_share(const km_mechanism *m, km_state *s, km_forces *f, const km_model_module *contact, double limit,
                      km_statics *st) {
  const km_touch touch = km_contact_touch(m, f, contact);
  const km_vec3 across = fabs(touch.normal.x) < 0.6 ? (km_vec3){1, 0, 0} : (km_vec3){0, 1, 0};
  const km_vec3 tangent = km_vec3_cross(touch.normal, across), e = km_vec3_scale(1.0 / km_vec3_norm(tangent), tangent);
  const km_vec3 directions[2] = {e, km_vec3_cross(touch.normal, e)};
  double *squares = st->work->squares;
  memset(squares, 0, (size_t)st->actuator_count * sizeof *squares);
  for (int k = 0; k < 2; ++k) {
    apply_unit_friction(m, f, contact, directions[k], touch.point);
    km_statics_forces_balance(m, s, f, st);
    for (int i = 0; i < st->actuator_count; ++i)
      squares[i] += st->actuator_forces[i] * st->actuator_forces[i];
  }
  for (int i = 0; i < st->actuator_count; ++i)
    st->friction[i] += limit * sqrt(squares[i]);
}

static double friction_limit(const km_forces *f, const km_model_module *contact) {
  return contact->contact.friction * km_module_report_of(f->mechanism, f, contact)->force;
}

void km_statics_find_friction(const km_mechanism *m, km_state *s, km_forces *f, km_statics *st) {
  memset(st->friction, 0, (size_t)st->actuator_count * sizeof *st->friction);
  if (!f->contact_count)
    return;
  km_forces_compute(m, s, f);
  for (int i = 0; i < f->contact_count; ++i) {
    const double limit = friction_limit(f, f->contacts[i]);
    if (!(limit > 0.0))
      continue;
    add_share(m, s, f, f->contacts[i], limit, st);
    km_forces_compute(m, s, f);
  }
}

void km_statics_list_contacts(const km_mechanism *m, const km_state *s, const km_forces *f, km_statics *st) {
  st->contact_count = 0;
  for (int i = 0; i < f->contact_count; ++i) {
    const km_module_report *report = km_module_report_of(m, f, f->contacts[i]);
    st->contacts[st->contact_count++] = (km_contact_force){.name = f->contacts[i]->name,
                                                           .coordinate = -1,
                                                           .penetration = report->depth,
                                                           .normal = report->force,
                                                           .friction_limit = friction_limit(f, f->contacts[i])};
  }
  for (int i = 0; i < f->stop_count; ++i) {
    const int c = f->stops[i];
    const double excess = km_stop_excess(m, s, c);
    if (excess != 0.0)
      st->contacts[st->contact_count++] =
          (km_contact_force){.name = m->model->coordinates[c].label,
                             .coordinate = c,
                             .penetration = fabs(excess) / km_model_coordinate_factor(m->model, c),
                             .normal = fabs(km_stop_force(m, s, f, c))};
  }
}
