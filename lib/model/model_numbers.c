/* Lists the numbers of a model. */
#include "model/model_numbers.h"

static void add(km_model_numbers *n, const double *at, size_t count, km_number_rule rule) {
  void *items = n->items;
  n->failed = n->failed || !km_reserve(&items, &n->capacity, n->count + count, sizeof *n->items);
  if (n->failed)
    return;
  n->items = items;
  for (size_t i = 0; i < count; ++i)
    n->items[n->count++] = (km_model_number){(double *)(size_t)(at + i), rule};
}

static void add_vector(km_model_numbers *n, km_vec3 *v, km_number_rule rule) {
  add(n, &v->x, 1, rule);
  add(n, &v->y, 1, rule);
  add(n, &v->z, 1, rule);
}

static void add_curve(km_model_numbers *n, const km_law_curve *curve) {
  int count = curve->form == KM_CURVE_SINE ? 4 : curve->count;
  const double *numbers = curve->numbers;
  if (curve->form == KM_CURVE_EXPRESSION)
    numbers = km_expression_numbers(curve->expression, &count);
  if (curve->form != KM_CURVE_PIECES)
    add(n, numbers, (size_t)count, KM_NUMBER_CHECKED);
  for (int i = 0; curve->form == KM_CURVE_PIECES && i < curve->count; ++i) {
    const km_curve_piece *p = &curve->pieces[i];
    add(n, &p->start, 2, KM_NUMBER_CHECKED);
    add(n, p->c, 4, KM_NUMBER_CHECKED);
    add(n, &p->step, 2, KM_NUMBER_CHECKED);
  }
  add(n, &curve->period, 2, KM_NUMBER_CHECKED);
}

static size_t law_size(const km_joint_prescribed *p) {
  size_t count = (size_t)p->count;
  return p->law == KM_MOTION_TABLE ? 2 * count : p->law == KM_MOTION_SINE ? 4 : count;
}

static void add_bodies(km_model_numbers *n, km_model *m) {
  for (int b = 0; b < m->body_count; ++b) {
    add(n, &m->bodies[b].mass, 1, KM_NUMBER_NOT_NEGATIVE);
    add_vector(n, &m->bodies[b].center_of_mass, KM_NUMBER_FREE);
    add(n, m->bodies[b].inertia, 6, KM_NUMBER_CHECKED);
    add(n, &m->bodies[b].density, 1, KM_NUMBER_CHECKED);
  }
  for (int f = 0; f < m->frame_count; ++f) {
    add_vector(n, &m->frames[f].pose.p, KM_NUMBER_FREE);
    for (int k = 0; k < 3; ++k)
      add_vector(n, &m->frames[f].pose.R.axis[k], KM_NUMBER_CHECKED);
  }
}

static void add_shapes(km_model_numbers *n, km_model *m) {
  for (int i = 0; i < m->shape_count; ++i) {
    km_model_shape *at = &m->shapes[i];
    add(n, at->scale, 3, KM_NUMBER_CHECKED);
    add(n, at->size, 3, KM_NUMBER_CHECKED);
    add_vector(n, &at->pose.p, KM_NUMBER_CHECKED);
    for (int k = 0; k < 3; ++k)
      add_vector(n, &at->pose.R.axis[k], KM_NUMBER_CHECKED);
    add(n, &at->density, 1, KM_NUMBER_CHECKED);
    add(n, at->color, 4, KM_NUMBER_CHECKED);
  }
}

static void add_joints(km_model_numbers *n, km_model *m) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    km_model_coordinate *at = &m->coordinates[c];
    add(n, &at->position, 1, KM_NUMBER_FREE);
    const double *checked[] = {&at->rate, &at->low, &at->high, &at->damping};
    for (int k = 0; k < 4; ++k)
      add(n, checked[k], 1, KM_NUMBER_CHECKED);
  }
  for (int j = 0; j < m->joint_count; ++j) {
    km_model_joint *at = &m->joints[j];
    const double *checked[] = {&at->pitch,
                               &at->most_turn,
                               &at->friction.coefficient,
                               &at->friction.radius,
                               &at->friction.stiction_velocity,
                               &at->stop.stiffness,
                               &at->stop.damping,
                               &at->fit.position,
                               &at->fit.direction,
                               &at->fit.radial,
                               &at->fit.axial,
                               &at->fit.angular,
                               &at->fit.force_stiffness,
                               &at->fit.moment_stiffness};
    for (size_t k = 0; k < sizeof checked / sizeof *checked; ++k)
      add(n, checked[k], 1, KM_NUMBER_CHECKED);
    if (at->prescribed.values)
      add(n, at->prescribed.values, law_size(&at->prescribed), KM_NUMBER_CHECKED);
    add_curve(n, &at->prescribed.curve);
  }
  for (int c = 0; c < m->coupling_count; ++c) {
    km_model_coupling *at = &m->couplings[c];
    if (at->ratios)
      add(n, at->ratios, (size_t)at->count, KM_NUMBER_CHECKED);
    add(n, &at->constant, 1, KM_NUMBER_CHECKED);
    add(n, at->polynomial, (size_t)at->polynomial_count, KM_NUMBER_CHECKED);
  }
  for (int p = 0; p < m->pose_count; ++p)
    add(n, m->poses[p].values, (size_t)m->poses[p].count, KM_NUMBER_CHECKED);
}

static void add_forces(km_model_numbers *n, km_model *m) {
  for (int i = 0; i < m->module_count; ++i) {
    km_model_module *at = &m->modules[i];
    add(n, at->law.knots, (size_t)at->law.knot_count, KM_NUMBER_CHECKED);
    if (at->law.start)
      add(n, at->law.coefficients, (size_t)at->law.start[at->law.knot_count + 1], KM_NUMBER_FREE);
    const double *checked[] = {&at->kp, &at->ki, &at->kd, &at->least, &at->most};
    add_curve(n, &at->reference);
    for (int k = 0; k < at->input_count; ++k)
      add(n, &at->inputs[k].weight, 1, KM_NUMBER_CHECKED);
    for (int k = 0; k < 5; ++k)
      add(n, checked[k], 1, KM_NUMBER_CHECKED);
    add_curve(n, &at->curve);
    const km_tire *t = &at->tire;
    const double *tire[] = {
        &t->radius,       &t->stiffness, &t->damping,       &t->rolling_resistance, &t->width,
        &t->longitudinal, &t->lateral,   &t->friction_peak, &t->friction_sliding,   &t->relaxation[0],
        &t->relaxation[1]};
    for (size_t k = 0; k < sizeof tire / sizeof *tire; ++k)
      add(n, tire[k], 1, KM_NUMBER_CHECKED);
    const km_contact *c = &at->contact;
    const double *contact[] = {&c->radius,          &c->parent_radius, &c->stiffness, &c->exponent,
                               &c->reference_depth, &c->dissipation,   &c->friction,  &c->slip_speed};
    for (size_t k = 0; k < sizeof contact / sizeof *contact; ++k)
      add(n, contact[k], 1, KM_NUMBER_CHECKED);
  }
  for (int l = 0; l < m->load_count; ++l) {
    add_vector(n, &m->loads[l].force, KM_NUMBER_FREE);
    add_vector(n, &m->loads[l].torque, KM_NUMBER_FREE);
    if (m->loads[l].scale)
      add_curve(n, &m->loads[l].scale->curve);
  }
  add_vector(n, &m->gravity, KM_NUMBER_FREE);
}

static void add_analysis(km_model_numbers *n, km_model *m) {
  for (int h = 0; h < m->hold_count; ++h)
    add(n, &m->holds[h].value, 1, KM_NUMBER_CHECKED);
  add(n, m->sweep.range, 2, KM_NUMBER_CHECKED);
  add(n, &m->sweep.arclength, 1, KM_NUMBER_CHECKED);
  add(n, &m->sweep.sign, 1, KM_NUMBER_CHECKED);
  add_vector(n, &m->advantage_input.direction, KM_NUMBER_CHECKED);
  add_vector(n, &m->advantage_output.direction, KM_NUMBER_CHECKED);
  const km_simulation_settings *s = &m->simulation;
  const double *settings[] = {&s->span, &s->step, &s->relative, &s->absolute};
  for (int k = 0; k < 4; ++k)
    add(n, settings[k], 1, KM_NUMBER_CHECKED);
  add(n, &m->characteristic_length, 1, KM_NUMBER_CHECKED);
  add(n, &m->closure_tolerance, 1, KM_NUMBER_CHECKED);
  add(n, &m->rotation_misfit, 1, KM_NUMBER_CHECKED);
}

void km_model_numbers_list(km_model *m, km_model_numbers *out) {
  *out = (km_model_numbers){0};
  add_bodies(out, m);
  add_shapes(out, m);
  add_joints(out, m);
  add_forces(out, m);
  add_analysis(out, m);
}

void km_model_numbers_free(km_model_numbers *n) {
  km_free(n->items);
  *n = (km_model_numbers){0};
}
