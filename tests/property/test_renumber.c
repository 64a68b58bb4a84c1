/* New numbers in a compiled mechanism: the same bits as a new compilation gives; a change of structure is refused and
 * changes nothing. */
#include "support/support.h"

#include "kmech/model.h"
#include "model/model.h"

#include <math.h>
#include <string.h>

/* Every length of the model times `factor`: what closed before closes again. */
static void scale(km_model *m, double factor) {
  for (int f = 0; f < m->frame_count; ++f) {
    km_vec3 p = m->frames[f].pose.p;
    const double T[3] = {factor * p.x, factor * p.y, factor * p.z};
    assert_int_equal(km_model_set_frame(m, f, T, NULL, NULL), KM_OK);
  }
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_model_coordinate *q = &m->coordinates[c];
    if (km_joint_is_length(m->joints[q->joint].type, q->index))
      assert_int_equal(km_model_set_position(m, c, factor * q->position, NULL), KM_OK);
  }
}

/* The pose, numbers and residual of an assembled state, to the bit. */
static void same_bits(const fixture *a, const fixture *b) {
  size_t n = (size_t)a->model->coordinate_count;
  km_mobility x, y;
  km_mobility_compute(a->mechanism, a->state, &x);
  km_mobility_compute(b->mechanism, b->state, &y);
  assert_int_equal(x.mobility, y.mobility);
  assert_true(x.residual == y.residual);
  assert_memory_equal(a->state->q, b->state->q, n * sizeof(double));
  assert_memory_equal(a->state->mobility_number, b->state->mobility_number, n * sizeof(double));
}

static void as_a_new_compilation(void **state) {
  (void)state;
  static const double factors[] = {1.1, 0.37, 25.4, 1.0};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    for (size_t i = 0; i < sizeof factors / sizeof *factors; ++i) {
      fixture fresh = {.model = f.model};
      km_error error;
      scale(f.model, factors[i]);
      if (km_mechanism_renumber(f.mechanism, &error))
        fail_msg("%s: %s", *name, error.text);
      km_state_restart(f.state);
      assert_int_equal(km_assemble(f.mechanism, f.state, NULL, &error), KM_OK);
      assert_int_equal(km_mechanism_compile(f.model, NULL, 0, &fresh.mechanism, &error), KM_OK);
      assert_int_equal(km_state_create(fresh.mechanism, &fresh.state, &error), KM_OK);
      assert_int_equal(km_assemble(fresh.mechanism, fresh.state, NULL, &error), KM_OK);
      same_bits(&f, &fresh);
      km_state_free(fresh.state);
      km_mechanism_free(fresh.mechanism);
    }
    fixture_close(&f);
  }
}

/* An inclined axis makes a planar four-bar spatial. */
static void another_structure_is_refused(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_mobility before, after;
  km_error error;
  const int frame = f.model->joints[1].frame[1];
  const km_vec3 p = f.model->frames[frame].pose.p;
  const double T[3] = {p.x, p.y, p.z}, tilted[9] = {1, 0, 0, 0, cos(0.3), -sin(0.3), 0, sin(0.3), cos(0.3)};
  km_mobility_compute(f.mechanism, f.state, &before);
  double number = km_mobility_number(f.state, 0);
  assert_int_equal(km_model_set_frame(f.model, frame, T, tilted, &error), KM_OK);
  assert_int_equal(km_mechanism_renumber(f.mechanism, &error), KM_PARTIAL);
  km_mobility_compute(f.mechanism, f.state, &after);
  assert_int_equal(after.mobility, before.mobility);
  assert_true(km_mobility_number(f.state, 0) == number);
  fixture_close(&f);
}

/* A spring between, a hold, limits: they follow too, and what is held stays. */
static void holds_stay(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  km_error error;
  int b;
  assert_int_equal(km_model_find_coordinate(f.model, "B", &b, &error), KM_OK);
  km_state_free(f.state);
  km_mechanism_free(f.mechanism);
  const km_hold hold = {b, 0.25};
  assert_int_equal(km_mechanism_compile(f.model, &hold, 1, &f.mechanism, &error), KM_OK);
  assert_int_equal(km_state_create(f.mechanism, &f.state, &error), KM_OK);
  assert_int_equal(km_model_set_limits(f.model, 2, -0.5, 0.5, &error), KM_OK);
  for (int i = 0; i < 3; ++i) {
    assert_int_equal(km_mechanism_renumber(f.mechanism, &error), KM_OK);
    km_state_restart(f.state);
    assert_true(f.mechanism->held[b]);
    assert_near(f.state->q[b], 0.25, 0.0);
    assert_near(f.mechanism->high[2], 0.5 * km_model_coordinate_factor(f.model, 2), 0.0);
  }
  fixture_close(&f);
}

static void wrong_numbers(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  const double T[3] = {0, 0, 0}, nan3[3] = {(double)NAN, 0, 0}, flat[9] = {0}, bad[6] = {1, 1, -1, 0, 0, 0};
  assert_int_equal(km_model_set_frame(f.model, -1, T, NULL, NULL), KM_USAGE);
  assert_int_equal(km_model_set_frame(f.model, 99999999, T, NULL, NULL), KM_USAGE);
  assert_int_equal(km_model_set_frame(f.model, 1, nan3, NULL, NULL), KM_MODEL);
  assert_int_equal(km_model_set_frame(f.model, 1, T, flat, NULL), KM_MODEL);
  assert_int_equal(km_model_set_position(f.model, 99, 0.0, NULL), KM_USAGE);
  assert_int_equal(km_model_set_position(f.model, 0, HUGE_VAL, NULL), KM_MODEL);
  assert_int_equal(km_model_set_limits(f.model, 0, 1.0, 0.0, NULL), KM_MODEL);
  assert_int_equal(km_model_set_limits(f.model, -1, 0.0, 1.0, NULL), KM_USAGE);
  assert_int_equal(km_model_set_mass(f.model, 0, 1.0, NULL, NULL, NULL), KM_USAGE);
  assert_int_equal(km_model_set_mass(f.model, 1, -1.0, NULL, NULL, NULL), KM_MODEL);
  assert_int_equal(km_model_set_mass(f.model, 1, 1.0, NULL, bad, NULL), KM_MODEL);
  assert_int_equal(km_model_set_load(f.model, 5, T, NULL, NULL), KM_USAGE);
  assert_int_equal(km_mechanism_renumber(NULL, NULL), KM_USAGE);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(as_a_new_compilation),
                                     cmocka_unit_test(another_structure_is_refused), cmocka_unit_test(holds_stay),
                                     cmocka_unit_test(wrong_numbers)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
