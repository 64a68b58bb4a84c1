/* Writing and reading a robot description gives the same mechanism: mobility, body poses, masses, gravity. */
#include "support/random_mechanism.h"

#include "base/memory.h"
#include "kmech/exchange.h"
#include "kmech/mechanism.h"
#include "kmech/statics.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

/* A model read back, with the original. */
typedef struct pair {
  const fixture *one;
  fixture two;
  const char *name;
  km_model_format format;
} pair;

static int body_named(const km_model *model, const char *name) {
  for (int b = 1; b < model->body_count; ++b)
    if (strcmp(model->bodies[b].name, name) == 0)
      return b;
  return -1;
}

static bool is_tree(const km_model *model) {
  return model->joint_count == model->body_count - 1;
}

static void send_and_read(const fixture *f, const char *name, km_model_format format, fixture *out) {
  km_bytes bytes;
  km_error error;
  km_model *model;
  double *q = KM_NEW(double, (size_t)f->model->coordinate_count);
  for (int c = 0; c < f->model->coordinate_count; ++c)
    q[c] = km_state_coordinate(f->state, c);
  if (km_model_write_as(f->model, format, q, NULL, NULL, &bytes, &error))
    fail_msg("%s, format %d: %s", name, format, error.text);
  km_free(q);
  if (km_model_read_as(bytes.data, bytes.size, &(km_read_def){.floating = format == KM_FORMAT_SDF}, NULL, &model,
                       &error))
    fail_msg("%s\n%.3000s", error.text, bytes.data);
  km_bytes_free(&bytes);
  *out = fixture_of(model);
}

/* Balls and free bodies count from poses of their own. */
static bool is_free(const km_model *model, int coordinate) {
  km_joint_type type = model->joints[model->coordinates[coordinate].joint].type;
  return type == KM_SPHERICAL || type == KM_FLOAT;
}

/* Coordinates that count as before take the first one's values; those of MJCF stand there already. */
static void follow(pair *p) {
  const km_model *m = p->one->model;
  for (int c = 0; c < m->coordinate_count; ++c) {
    int other;
    if (is_free(m, c) || km_model_find_coordinate(p->two.model, m->coordinates[c].label, &other, NULL))
      continue;
    bool length = km_joint_is_length(m->joints[m->coordinates[c].joint].type, m->coordinates[c].index);
    double value = p->one->state->q[c] * (length ? m->units.length->si : 1.0);
    if (p->format == KM_FORMAT_URDF || (p->format == KM_FORMAT_SDF && p->one->mechanism->substructure_of[c] < 0))
      assert_int_equal(km_state_set_coordinate(p->two.mechanism, p->two.state, other, value, NULL), KM_OK);
    else if (p->format == KM_FORMAT_MJCF)
      assert_near(p->two.state->q[other], value, 1e-9); /* it stands there already */
  }
}

static void same_bodies(pair *p) {
  const km_model *m = p->one->model, *w = p->two.model;
  double unit = m->units.length->si, size = 1e-30;
  km_poses_compute(p->one->mechanism, p->one->state);
  km_poses_compute(p->two.mechanism, p->two.state);
  for (int b = 0; b < m->body_count; ++b)
    size = fmax(size, unit * (km_vec3_norm(p->one->state->pose[b].p) + km_vec3_norm(m->bodies[b].center_of_mass)));
  for (int k = 0; k < m->frame_count; ++k)
    size = fmax(size, unit * km_vec3_norm(m->frames[k].pose.p));
  for (int b = 1; b < m->body_count; ++b) {
    int twin = body_named(w, m->bodies[b].name);
    if (twin < 0)
      continue; /* its name was taken by another one's */
    const km_pose *A = &p->one->state->pose[b], *B = &p->two.state->pose[twin];
    double off = km_vec3_norm(km_vec3_sub(km_vec3_scale(unit, A->p), B->p)) / size;
    if (!(off <= 1e-12))
      fail_msg("%s, format %d: body %s is off by %g", p->name, p->format, m->bodies[b].name, off);
    for (int k = 0; k < 3; ++k)
      assert_near(km_vec3_norm(km_vec3_sub(A->R.axis[k], B->R.axis[k])), 0.0, 1e-12);
    double mass = m->bodies[b].mass * m->units.mass->si;
    assert_near(w->bodies[twin].mass, mass, 1e-12 * (1.0 + mass));
    for (int k = 0; k < 6; ++k) {
      double inertia = m->bodies[b].inertia[k] * m->units.mass->si * unit * unit;
      assert_near(w->bodies[twin].inertia[k], inertia, 1e-12 * (fabs(inertia) + mass * size * size + 1e-30));
    }
  }
}

static int mobility_of(const fixture *f) {
  km_mobility mobility;
  km_error error;
  if (km_assemble(f->mechanism, f->state, NULL, &error))
    fail_msg("%s", error.text);
  km_mobility_compute(f->mechanism, f->state, &mobility);
  return mobility.mobility;
}

/* The forces that hold a tree against gravity, joint by joint. */
static void same_torques(pair *p) {
  const km_model *m = p->one->model;
  const fixture *both[2] = {p->one, &p->two};
  km_forces *forces[2];
  km_statics statics[2];
  double unit = m->units.length->si / (m->units.time->si * m->units.time->si);
  const double gravity[3] = {unit * m->gravity.x, unit * m->gravity.y, unit * m->gravity.z}; /* URDF has none */
  for (int i = 0; i < 2; ++i) {
    assert_int_equal(km_forces_create(both[i]->mechanism, i ? gravity : NULL, NULL, 0, &forces[i], NULL), KM_OK);
    assert_int_equal(km_statics_create(both[i]->mechanism, NULL, 0, KM_AXES_JOINT, &statics[i], NULL), KM_OK);
    mobility_of(both[i]);
    km_statics_compute(both[i]->mechanism, both[i]->state, forces[i], &statics[i]);
  }
  double size = 1e-30;
  for (int c = 0; c < p->two.model->coordinate_count; ++c)
    size = fmax(size, fabs(statics[1].least_norm[c]));
  for (int c = 0; c < m->coordinate_count; ++c) {
    int other;
    if (is_free(m, c) || km_model_find_coordinate(p->two.model, m->coordinates[c].label, &other, NULL))
      continue;
    bool length = km_joint_is_length(m->joints[m->coordinates[c].joint].type, m->coordinates[c].index);
    double force = m->units.force->si * (length ? 1.0 : m->units.length->si);
    assert_near(statics[0].least_norm[c] * force / size, statics[1].least_norm[other] / size, 1e-11);
  }
  for (int i = 0; i < 2; ++i) {
    km_statics_free(&statics[i]);
    km_forces_free(forces[i]);
  }
}

static bool has_screw_or_ball(const km_model *m) {
  for (int j = 0; j < m->joint_count; ++j)
    if (m->joints[j].type == KM_SPHERICAL || m->joints[j].type == KM_FLOAT || m->joints[j].type == KM_SCREW)
      return true;
  return false;
}

static bool couplings_fit(const km_model *m, km_model_format format) {
  for (int i = 0; i < m->coupling_count; ++i)
    if (m->couplings[i].count > 2 || (format != KM_FORMAT_MJCF && m->couplings[i].count != 2))
      return false;
  return true;
}

static void goes_and_comes(const fixture *f, const char *name, km_model_format format) {
  pair p = {.one = f, .name = name, .format = format};
  if (format == KM_FORMAT_URDF && !is_tree(f->model))
    return; /* its loops can't be written */
  if (!couplings_fit(f->model, format))
    return;
  send_and_read(f, name, format, &p.two);
  int before = mobility_of(f), after = mobility_of(&p.two);
  if (before != after)
    fail_msg("%s, format %d: mobility %d, was %d", name, format, after, before);
  follow(&p);
  if (format == KM_FORMAT_MJCF || !has_screw_or_ball(f->model)) /* a ball of URDF or SDF stands at 0 */
    same_bodies(&p);
  if (is_tree(f->model) && f->model->coupling_count == 0 && !has_screw_or_ball(f->model))
    same_torques(&p);
  fixture_close(&p.two);
}

static void all_formats(const fixture *f, const char *name) {
  for (int format = KM_FORMAT_URDF; format <= KM_FORMAT_SDF; ++format)
    goes_and_comes(f, name, (km_model_format)format);
}

static void models_of_the_project(void **unused) {
  (void)unused;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    all_formats(&f, *name);
    fixture_close(&f);
  }
}

static void random_ones(void **unused) {
  (void)unused;
  for (uint64_t seed = 1; seed <= 120; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, seed % 3 == 0);
    all_formats(&f, "random");
    fixture_close(&f);
  }
}

/* Data of joints are preserved, too: limits, drives, rotors, springs, couplings with constants and polynomials. */
static void joints_keep_what_they_state(void **unused) {
  (void)unused;
  static const char text[] =
      "{\"model_parameters\": {\"units\": {\"angle\": \"deg\", \"length\": \"mm\", \"mass\": \"g\"}}, \"assemblies\": "
      "[{\"name\": \"m\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}], \"joints\": [{\"name\": \"A\", \"type\": "
      "\"Ry\", \"body_frame_pairs\": [\"fixed\", \"a\"], \"initial_displacement\": 30, \"limits\": [-90, 45], \"damping\": 2, "
      "\"max_force\": 3, \"max_rate\": 90, \"armature\": 5, \"friction\": {\"torque\": 4}}, {\"name\": \"B\", \"type\": \"Tz\", "
      "\"body_frame_pairs\": [\"a\", \"b\"], \"initial_displacement\": 1500, \"limits\": [-1e30, 2000]}], \"couplings\": "
      "[{\"name\": \"c\", \"joints\": [\"B\", \"A\"], \"polynomial\": [1000, 300, 1246.9]}], \"force_modules\": [{\"name\": "
      "\"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"A\"}, \"knot_points\": [], "
      "\"coefficients\": [[1, -2]]}]}]}";
  fixture f = fixture_read(text), g;
  send_and_read(&f, "joints", KM_FORMAT_MJCF, &g);
  int a, b;
  assert_int_equal(km_model_find_coordinate(g.model, "A", &a, NULL), KM_OK);
  assert_int_equal(km_model_find_coordinate(g.model, "B", &b, NULL), KM_OK);
  const km_model_coordinate *c = &g.model->coordinates[a];
  assert_near(c->low, -M_PI / 2, 1e-15);
  assert_near(c->high, M_PI / 4, 1e-15);
  assert_near(c->damping, 2e-3, 1e-18);
  assert_near(c->max_force, 3e-3, 1e-18);
  assert_near(c->armature, 5e-9, 1e-23);
  assert_near(c->friction, 4e-3, 1e-18);
  assert_true(g.model->coordinates[b].low == -HUGE_VAL);
  assert_near(g.model->coordinates[b].high, 2.0, 1e-15);
  const km_law *law = &g.model->modules[0].law;
  assert_near(law->coefficients[0], 1e-3, 1e-17);
  assert_near(law->coefficients[1], -2e-3, 1e-17);
  const double *p = g.model->couplings[0].polynomial;
  assert_int_equal(g.model->couplings[0].polynomial_count, 3);
  assert_near(p[0], 1.0, 1e-14);
  assert_near(p[1], 0.3, 1e-14);
  assert_near(p[2], 1.2469, 1e-14);
  fixture_close(&g);
  fixture_close(&f);
}

static void endings_tell_formats(void **unused) {
  (void)unused;
  assert_int_equal(km_model_format_of("a/b.urdf"), KM_FORMAT_URDF);
  assert_int_equal(km_model_format_of("b.xml"), KM_FORMAT_MJCF);
  assert_int_equal(km_model_format_of("b.sdf"), KM_FORMAT_SDF);
  assert_int_equal(km_model_format_of("b"), KM_FORMAT_JSON);
  assert_int_equal(km_model_format_of(NULL), KM_FORMAT_JSON);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(models_of_the_project), cmocka_unit_test(random_ones),
                                     cmocka_unit_test(joints_keep_what_they_state),
                                     cmocka_unit_test(endings_tell_formats)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
