/* Reactions by sparse matrices against those by dense ones: two formulations, one of the loops and one of the
 * bodies. */
#include "support/random_mechanism.h"
#include "support/sheets.h"
#include "support/support.h"

#include "statics/statics.h"

#include <math.h>
#include <string.h>

enum { LOADS = 4 };

static km_forces *load_randomly(fixture *f, randomness *r) {
  km_load loads[LOADS];
  km_forces *forces = NULL;
  for (int i = 0; i < LOADS; ++i) {
    loads[i] = (km_load){.frame = below(r, f->model->frame_count)};
    for (int k = 0; k < 3; ++k) {
      loads[i].force[k] = uniform(r, -10.0, 10.0);
      loads[i].torque[k] = uniform(r, -10.0, 10.0);
    }
  }
  assert_int_equal(km_forces_create(f->mechanism, NULL, loads, LOADS, &forces, NULL), KM_OK);
  return forces;
}

static void make_large(fixture *f, km_statics *statics) {
  km_statics_workspace *w = statics->work;
  for (int i = 0; i < f->mechanism->topology.substructure_count; ++i) {
    if (w->reactions_of[i].body_equilibrium)
      continue;
    assert_int_equal(km_reaction_workspace_make_large(f->mechanism, w, i, NULL), KM_OK);
    assert_false(w->arena.failed);
  }
}

static double largest_of(const km_statics *statics, int joints) {
  double largest = 0.0;
  for (int j = 0; j < joints; ++j)
    for (int k = 0; k < 3; ++k)
      largest = fmax(largest, fmax(fabs(statics->reactions[j].force[k]), fabs(statics->reactions[j].torque[k])));
  return largest;
}

static void compare(fixture *f, randomness *r) {
  km_statics small, large;
  km_mobility mobility;
  km_forces *forces = load_randomly(f, r);
  int joints = f->model->joint_count;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  assert_int_equal(km_statics_create(f->mechanism, NULL, 0, KM_AXES_JOINT, &small, NULL), KM_OK);
  assert_int_equal(km_statics_create(f->mechanism, NULL, 0, KM_AXES_JOINT, &large, NULL), KM_OK);
  make_large(f, &large);
  km_statics_compute(f->mechanism, f->state, forces, &small);
  km_statics_compute(f->mechanism, f->state, forces, &large);
  assert_int_equal(small.degree, large.degree);
  /* Both lose as many digits as the smallest pivot has less than 1: a thousandth is left to them. */
  double tolerance = 1e-9 * fmax(1.0, largest_of(&small, joints));
  for (int j = 0; j < joints; ++j)
    for (int k = 0; k < 3; ++k) {
      const km_reaction *a = &small.reactions[j], *b = &large.reactions[j];
      assert_near(a->force[k], b->force[k], tolerance);
      assert_near(a->torque[k], b->torque[k], tolerance);
      assert_int_equal(a->indeterminate[k], b->indeterminate[k]);
      assert_int_equal(a->indeterminate[3 + k], b->indeterminate[3 + k]);
    }
  km_statics_free(&small);
  km_statics_free(&large);
  km_forces_free(forces);
}

static void shipped_models(void **state) {
  (void)state;
  randomness r = {3};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    compare(&f, &r);
    fixture_close(&f);
  }
}

/* Also where forces, or moments, count for almost nothing. */
static void odd_lengths(void **state) {
  (void)state;
  randomness r = {7};
  const double lengths[] = {1e-3, 1e3};
  for (const char *const *name = all_models; *name; ++name)
    for (int i = 0; i < 2; ++i) {
      fixture f = fixture_open(*name);
      km_model_share_length(f.model, lengths[i] * f.mechanism->length);
      km_mechanism_free(f.mechanism);
      km_state_free(f.state);
      f = fixture_of(f.model);
      compare(&f, &r);
      fixture_close(&f);
    }
}

/* With gears, at any pose. */
static void random_mechanisms(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, true);
    compare(&f, &r);
    fixture_close(&f);
  }
}

/* The gear of the text, if there is one, three times: what they do against each other stresses no joint. */
static bool repeat_gear(const char *text, km_text *out) {
  const char *gear = strstr(text, "{\"name\": \"gear\""), *end = gear ? strchr(gear, '}') : NULL;
  if (!end)
    return false;
  int length = (int)(end + 1 - gear), name = (int)strlen("{\"name\": \"gear");
  km_text_format(out, "%.*s", (int)(gear - text) + length, text);
  for (int i = 2; i <= 3; ++i)
    km_text_format(out, ", {\"name\": \"gear%d%.*s", i, length - name, gear + name);
  km_text_add(out, end + 1);
  return true;
}

static void gears_against_each_other(void **state) {
  (void)state;
  int tried = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    randomness r = {seed};
    km_text text = {0};
    char *once = random_mechanism(&r, true);
    if (repeat_gear(once, &text)) {
      fixture f = fixture_read(text.data);
      go_somewhere(&f, &r);
      compare(&f, &r);
      fixture_close(&f);
      ++tried;
    }
    km_text_free(&text);
    km_free(once);
  }
  assert_true(tried > 10);
}

static void lattices(void **state) {
  (void)state;
  randomness r = {5};
  for (int kind = 0; kind < 2; ++kind) {
    km_text text = {0};
    (kind ? write_miura : write_trellis)(&text, 4, 4, 0.0);
    fixture f = fixture_read(text.data);
    compare(&f, &r);
    km_text_free(&text);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(shipped_models, "Reactions by sparse matrices are those by dense ones, every model",
                 "1e-9 of the largest reaction: both lose as many digits as the smallest pivot is below 1"),
      cmocka_unit_test(odd_lengths), cmocka_unit_test(random_mechanisms), cmocka_unit_test(gears_against_each_other),
      cmocka_unit_test(lattices)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
