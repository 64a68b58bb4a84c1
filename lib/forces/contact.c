/* Unilateral contact with friction (K. Hunt and F. Crossley 1975; docs/theory.md 11.15).
 *
 *   n    : normal from parent to child;  c centre of the child, o of the parent, ρ = c − o
 *          point-plane  n = e_z of the parent, g = n · ρ − r          circle-line  n = e_y, g = n · ρ − r
 *          circle-circle  n = ρ'/|ρ'|, g = |ρ'| − R − r,  ρ' = ρ − (e_z · ρ) e_z
 *          circle-in-circle  n = −ρ'/|ρ'|, g = R − r − |ρ'|
 *   δ = −g,  δ̇ = −n · v(c),  v(x) velocity of the child relative to the parent at x
 *   N = k δ (δ/δ_0)^(n−1) max(1 + c δ̇, 0)  for δ > 0,  else 0                          no adhesion
 *   F = N n − μ N s(|v_t|) v_t/|v_t|  at p = c − (r − δ/2) n,  v_t = v(p) − (n · v(p)) n;   s of km_slip_share
 *
 * The elastic part is stored: E = k δ² (δ/δ_0)^(n−1)/(n + 1). The rest of the power is dissipated. */
#include "forces/motion_forces.h"

/* Elastic force k δ (δ/δ_0)^(n−1). */
static double elastic_force(const km_contact *contact, double depth) {
  double force = contact->stiffness * depth;
  return contact->exponent == 1.0 ? force : force * pow(depth / contact->reference_depth, contact->exponent - 1.0);
}

static bool has_two_circles(const km_contact *contact) {
  return contact->shape == KM_CONTACT_CIRCLE_CIRCLE || contact->shape == KM_CONTACT_CIRCLE_IN_CIRCLE;
}

/* Distance of the child's centre along the normal at which the surfaces touch. */
static double touching_distance(const km_contact *contact) {
  return contact->shape == KM_CONTACT_CIRCLE_CIRCLE      ? contact->radius + contact->parent_radius
         : contact->shape == KM_CONTACT_CIRCLE_IN_CIRCLE ? contact->radius - contact->parent_radius
                                                         : contact->radius;
}

km_touch km_contact_touch(const km_mechanism *m, const km_forces *f, const km_model_module *module) {
  const km_contact *contact = &module->contact;
  const km_model_frame *a = &m->model->frames[module->output.frame[0]], *b = &m->model->frames[module->output.frame[1]];
  const km_pose A = km_pose_product(&f->pose[a->body], &a->pose), B = km_pose_product(&f->pose[b->body], &b->pose);
  const km_twist v = km_twist_axpy(-1.0, f->twist[a->body], f->twist[b->body]);
  km_vec3 way = km_vec3_sub(B.p, A.p);
  km_touch t = {.normal = A.R.axis[contact->shape == KM_CONTACT_CIRCLE_LINE ? 1 : 2]};
  double distance = km_vec3_dot(t.normal, way);
  if (has_two_circles(contact)) {
    const double sense = contact->shape == KM_CONTACT_CIRCLE_CIRCLE ? 1.0 : -1.0;
    way = km_vec3_axpy(-distance, t.normal, way);
    distance = sense * km_vec3_norm(way);
    t.normal = distance != 0.0 ? km_vec3_scale(1.0 / distance, way) : A.R.axis[0];
  }
  t.depth = touching_distance(contact) - distance;
  t.depth_rate = -km_vec3_dot(t.normal, km_point_velocity(v, B.p));
  t.point = km_vec3_axpy(0.5 * t.depth - contact->radius, t.normal, B.p);
  const km_vec3 velocity = km_point_velocity(v, t.point);
  t.slip = km_vec3_axpy(-km_vec3_dot(t.normal, velocity), t.normal, velocity);
  return t;
}

void km_contacts_collect(const km_model *model, km_forces *f) {
  for (int i = 0; i < model->module_count; ++i)
    if (model->modules[i].type == KM_MODULE_CONTACT)
      f->contacts[f->contact_count++] = &model->modules[i];
}

/* Adds the forces of one contact and its report; returns the dissipated power. */
static double add_contact(const km_mechanism *m, km_forces *f, const km_model_module *module, bool has_friction) {
  const km_contact *contact = &module->contact;
  const km_vec3 none = {0, 0, 0};
  const km_touch t = km_contact_touch(m, f, module);
  km_module_report *report = km_module_report_of(m, f, module);
  *report = (km_module_report){.depth = t.depth, .slip = km_vec3_norm(t.slip)};
  if (!(t.depth > 0.0))
    return 0.0;
  const double elastic = elastic_force(contact, t.depth);
  const double normal = elastic * fmax(1.0 + contact->dissipation * t.depth_rate, 0.0);
  const double slip_speed = contact->slip_speed > 0.0 ? contact->slip_speed : km_stiction_speed(m, NULL);
  const double friction = has_friction ? contact->friction * normal * km_slip_share(report->slip, slip_speed) : 0.0;
  const km_vec3 along = report->slip > 0.0 ? km_vec3_scale(-friction / report->slip, t.slip) : none;
  const km_vec3 force = km_vec3_axpy(normal, t.normal, along);
  km_forces_add(f, m->model->frames[module->output.frame[1]].body, force, none, t.point);
  km_forces_add(f, m->model->frames[module->output.frame[0]].body, km_vec3_scale(-1.0, force), none, t.point);
  report->force = normal;
  report->friction = friction;
  report->power = -normal * t.depth_rate - friction * report->slip;
  return (normal - elastic) * t.depth_rate + friction * report->slip;
}

double km_contacts_add(const km_mechanism *m, km_forces *f, bool has_friction) {
  double dissipation = 0.0;
  for (int i = 0; i < f->contact_count; ++i)
    dissipation += add_contact(m, f, f->contacts[i], has_friction);
  return dissipation;
}

double km_contacts_energy(const km_mechanism *m, const km_forces *f) {
  double energy = 0.0;
  for (int i = 0; i < f->contact_count; ++i) {
    const km_model_module *module = f->contacts[i];
    const double depth = km_contact_touch(m, f, module).depth;
    if (depth > 0.0)
      energy += elastic_force(&module->contact, depth) * depth / (module->contact.exponent + 1.0);
  }
  return energy;
}

km_status km_contacts_check(const km_model *model, km_error *error) {
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *module = &model->modules[i];
    const km_contact *c = &module->contact;
    if (module->type != KM_MODULE_CONTACT)
      continue;
    if (module->output.coordinate >= 0)
      return km_fail(error, KM_MODEL, "%s: a contact acts in a joint; expected the frames of the two bodies that touch",
                     module->where);
    const bool has_circle = c->shape != KM_CONTACT_POINT_PLANE, has_two = has_two_circles(c);
    const struct {
      const char *key;
      double value;
      bool is_needed;
    } needed[] = {{"stiffness", c->stiffness, true},
                  {"radius", c->radius, has_circle},
                  {"parent_radius", c->parent_radius, has_two},
                  {"reference_depth", c->reference_depth, c->exponent != 1.0}};
    for (size_t k = 0; k < sizeof needed / sizeof *needed; ++k)
      if (needed[k].is_needed && !(needed[k].value > 0.0))
        return km_fail(error, KM_MODEL, "%s.contact.%s: found %g; expected a positive number", module->where,
                       needed[k].key, needed[k].value);
    if (c->shape == KM_CONTACT_CIRCLE_IN_CIRCLE && !(c->parent_radius > c->radius))
      return km_fail(error, KM_MODEL, "%s.contact.parent_radius: found %g; expected more than the radius %g inside it",
                     module->where, c->parent_radius, c->radius);
    if (!(c->exponent >= 1.0))
      return km_fail(error, KM_MODEL, "%s.contact.exponent: found %g; expected a number of at least 1", module->where,
                     c->exponent);
  }
  return KM_OK;
}
