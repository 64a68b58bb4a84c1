/* Numbers that calls have changed are in the file that is written, and nothing else is. */
#include "support/support.h"

#include "kmech/exchange.h"
#include "kmech/model.h"

#include <math.h>
#include <string.h>

/* Bodies that struts make have a colon in their name. */
static bool is_of_strut(const km_model *m, int body) {
  return strchr(m->bodies[body].name, ':') != NULL;
}

static bool is_weighed(const km_model *m, int body) {
  bool weighed = m->bodies[body].density > 0.0;
  for (int s = 0; s < m->shape_count; ++s)
    weighed = weighed || (m->shapes[s].body == body && m->shapes[s].density > 0.0);
  return weighed;
}

/* Struts put frames of their own where those are that they join: one that moves alone is another model. */
static bool has_struts(const km_model *m) {
  bool some = false;
  for (int b = 1; b < m->body_count; ++b)
    some = some || is_of_strut(m, b);
  return some;
}

/* Some frames get other places, one of them another rotation; bodies, limits and loads other numbers. */
static void change(km_model *m, randomness *r) {
  for (int f = 0; f < m->frame_count; ++f) {
    const km_model_frame *frame = &m->frames[f];
    km_vec3 p = frame->pose.p;
    const double T[3] = {p.x + uniform(r, -1, 1), p.y + uniform(r, -1, 1), p.z};
    if (strcmp(frame->name, "origin") != 0 && !has_struts(m) && below(r, 3) == 0)
      assert_int_equal(km_model_set_frame(m, f, T, NULL, NULL), KM_OK);
  }
  for (int b = 1; b < m->body_count; ++b) {
    const double center[3] = {uniform(r, -1, 1), 2, 3}, inertia[6] = {3, 4, 5, 0.1, 0.2, 0.3};
    if (!is_of_strut(m, b) && !is_weighed(m, b) && below(r, 2))
      assert_int_equal(km_model_set_mass(m, b, uniform(r, 0, 9), center, below(r, 2) ? inertia : NULL, NULL), KM_OK);
  }
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!strchr(m->joints[m->coordinates[c].joint].name, ':') &&
        m->joints[m->coordinates[c].joint].type != KM_SPHERICAL && below(r, 3) == 0)
      assert_int_equal(km_model_set_limits(m, c, uniform(r, -9, -5), below(r, 2) ? HUGE_VAL : 7.5, NULL), KM_OK);
  for (int l = 0; l < m->load_count; ++l) {
    const double force[3] = {uniform(r, -1, 1), 2, 3};
    assert_int_equal(km_model_set_load(m, l, force, NULL, NULL), KM_OK);
  }
}

static int frame_like(const km_model *m, const km_model *other, int frame) {
  for (int f = 0; f < m->frame_count; ++f)
    if (m->frames[f].body == other->frames[frame].body && strcmp(m->frames[f].name, other->frames[frame].name) == 0)
      return f;
  fail_msg("no frame %s", other->frames[frame].name);
  return -1;
}

static void assert_vector(km_vec3 a, km_vec3 b, double tolerance) {
  assert_near(a.x, b.x, tolerance);
  assert_near(a.y, b.y, tolerance);
  assert_near(a.z, b.z, tolerance);
}

/* No limit beside one is written as a large number: JSON has no infinity. */
static bool same_limit(double a, double b) {
  return a == b || (isinf(a) && b == copysign(1e30, a));
}

/* Drawn joints' frames are read as points and put back by the same sums: a few roundings. */
static void assert_alike(const km_model *a, const km_model *b) {
  assert_int_equal(a->body_count, b->body_count);
  assert_int_equal(a->frame_count, b->frame_count);
  for (int f = 0; f < a->frame_count; ++f) {
    const km_pose *one = &a->frames[f].pose, *other = &b->frames[frame_like(b, a, f)].pose;
    assert_vector(one->p, other->p, 1e-13 * (1.0 + km_vec3_norm(one->p)));
    for (int k = 0; k < 3; ++k)
      assert_vector(one->R.axis[k], other->R.axis[k], 1e-14);
  }
  for (int i = 1; i < a->body_count; ++i) {
    assert_near(a->bodies[i].mass, b->bodies[i].mass, 1e-12 * (1.0 + a->bodies[i].mass));
    assert_vector(a->bodies[i].center_of_mass, b->bodies[i].center_of_mass, 1e-12);
    for (int k = 0; k < 6; ++k)
      assert_near(a->bodies[i].inertia[k], b->bodies[i].inertia[k], 1e-12 * (1.0 + fabs(a->bodies[i].inertia[k])));
  }
  for (int c = 0; c < a->coordinate_count; ++c) {
    assert_true(same_limit(a->coordinates[c].low, b->coordinates[c].low));
    assert_true(same_limit(a->coordinates[c].high, b->coordinates[c].high));
  }
  for (int l = 0; l < a->load_count; ++l) {
    assert_vector(a->loads[l].force, b->loads[l].force, 0.0);
    assert_vector(a->loads[l].torque, b->loads[l].torque, 0.0);
  }
}

static km_model *read_again(const km_model *model) {
  km_bytes text = {0};
  km_model *out = NULL;
  km_error error;
  if (km_model_write(model, NULL, &text, &error))
    fail_msg("%s", error.text);
  if (km_model_read_as(text.data, text.size, &(km_read_def){.file = MODELS_DIR "/x.json"}, NULL, &out, &error))
    fail_msg("%s", error.text);
  km_bytes_free(&text);
  return out;
}

static void changes_are_written(void **unused) {
  (void)unused;
  for (const char *const *name = all_models; *name; ++name)
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      fixture f = fixture_open(*name);
      randomness r = {seed};
      change(f.model, &r);
      km_model *again = read_again(f.model);
      assert_alike(f.model, again);
      km_model_free(again);
      fixture_close(&f);
    }
}

/* A pivot that moves on both bodies leaves the drawing a drawing; a frame of one body alone doesn't. */
static void drawings_stay_where_they_can(void **unused) {
  (void)unused;
  static const char text[] =
      "{\"model_parameters\": {\"version\": \"1.1\"}, \"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", "
      "\"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"J\", \"type\": \"revolute\", \"bodies\": [\"fixed\", "
      "\"b\"], \"at\": [1, 2]}]}]}";
  for (int ends = 1; ends <= 2; ++ends) {
    fixture f = fixture_read(text);
    const double T[3] = {4, 5, 0};
    km_bytes out = {0};
    for (int end = 0; end < ends; ++end)
      assert_int_equal(km_model_set_frame(f.model, f.model->joints[0].frame[end], T, NULL, NULL), KM_OK);
    assert_int_equal(km_model_write(f.model, NULL, &out, NULL), KM_OK);
    assert_true((strstr(out.data, "\"drawn\"") != NULL) == (ends == 2));
    assert_true((strstr(out.data, "\"at\": [4, 5, 0]") != NULL) == (ends == 2));
    km_model *again = read_again(f.model);
    assert_alike(f.model, again);
    km_bytes_free(&out);
    km_model_free(again);
    fixture_close(&f);
  }
}

static void what_no_file_says_is_refused(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  const double T[3] = {1, 0, 0};
  km_bytes out = {0};
  km_error error;
  for (int i = 0; i < f.model->frame_count; ++i)
    if (f.model->frames[i].body == 1 && strcmp(f.model->frames[i].name, "origin") == 0)
      assert_int_equal(km_model_set_frame(f.model, i, T, NULL, NULL), KM_OK);
  assert_int_equal(km_model_write(f.model, NULL, &out, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "own frame"));
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(changes_are_written),
                                     cmocka_unit_test(drawings_stay_where_they_can),
                                     cmocka_unit_test(what_no_file_says_is_refused)};
  return cmocka_run_group_tests_name("edited", tests, NULL, NULL);
}
