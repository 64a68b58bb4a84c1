/* Reaching a pose with the mechanism that is there gives the pose of a mechanism compiled for it. */
#include "support/support.h"

#include "base/memory.h"
#include "continuation/target_configuration.h"
#include "kmech/model.h"

#include <math.h>
#include <string.h>

/* Both ways end in poses that are closed to 1e-12 of the loops' size: their coordinates differ by the condition of the
 * loops times that. */
static void compare(const char *name, const km_hold *sets, int count) {
  fixture f = fixture_open(name);
  km_mechanism *mechanism;
  km_state *state;
  km_error error;
  const km_mechanism *own = f.mechanism;
  if (km_mechanism_compile_at(f.model, NULL, 0, sets, count, &mechanism, &state, &error) ||
      km_state_move_to(f.mechanism, f.state, sets, count, &error))
    fail_msg("%s: %s", name, error.text);
  assert_ptr_equal(f.state->mechanism, own);
  for (int c = 0; c < f.model->coordinate_count; ++c)
    assert_near(f.state->q[c], state->q[c], 1e-9);
  km_state_free(state);
  km_mechanism_free(mechanism);
  fixture_close(&f);
}

static void test_same_pose(void **unused) {
  (void)unused;
  fixture f = fixture_open("excavator");
  km_hold sets[3] = {
      {fixture_coordinate(&f, "M"), 0.0}, {fixture_coordinate(&f, "N"), 0.0}, {fixture_coordinate(&f, "O"), 0.0}};
  for (int i = 0; i < 3; ++i)
    sets[i].value = km_state_coordinate(f.state, sets[i].coordinate) + 0.02;
  fixture_close(&f);
  compare("excavator", sets, 1);
  compare("excavator", sets, 3);
  const km_hold crank = {0, 2.0};
  compare("fourbar", &crank, 1);
}

/* The three components of a ball are turned together, alone and in a loop, and end at their values to the last
 * digit. */
static void test_balls_turn_together(void **unused) {
  (void)unused;
  static const char *const texts[2] = {
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"S\", "
      "\"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}",
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"S\", "
      "\"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, {\"name\": \"F\", \"type\": "
      "\"float\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}"};
  for (int i = 0; i < 2; ++i) {
    fixture f = fixture_read(texts[i]);
    int first = fixture_coordinate(&f, "S[0]");
    const km_hold sets[3] = {{first, 0.7}, {first + 1, -0.4}, {first + 2, 1.1}};
    km_error error;
    if (km_state_move_to(f.mechanism, f.state, sets, 3, &error))
      fail_msg("%s", error.text);
    for (int k = 0; k < 3; ++k)
      assert_near(km_state_coordinate(f.state, first + k), sets[k].value, 1e-12);
    if (i) /* the other joint of the same two bodies turns as far */
      for (int k = 0; k < 3; ++k)
        assert_near(km_state_coordinate(f.state, fixture_coordinate(&f, "F[3]") + k), sets[k].value, 1e-12);
    assert_int_equal(km_state_move_to(f.mechanism, f.state, sets, 2, &error), KM_USAGE);
    fixture_close(&f);
  }
}

static void test_refusals_leave_the_state(void **unused) {
  (void)unused;
  fixture f = fixture_open("brake");
  km_error error;
  int k = fixture_coordinate(&f, "K");
  double *before = KM_NEW(double, (size_t)f.model->coordinate_count);
  memcpy(before, f.state->q, (size_t)f.model->coordinate_count * sizeof *before);
  const km_hold far = {k, 1e4}, none = {999, 0.0};
  assert_int_equal(km_state_move_to(f.mechanism, f.state, &far, 1, &error), KM_NO_RESULT);
  assert_int_equal(km_state_move_to(f.mechanism, f.state, &none, 1, &error), KM_USAGE);
  assert_memory_equal(before, f.state->q, (size_t)f.model->coordinate_count * sizeof *before);
  km_free(before);
  fixture_close(&f);
}

static km_status reach_again(const fixture *f, double value, km_mechanism **held, km_state **at) {
  km_mechanism *free;
  km_state *there;
  const km_hold hold = {fixture_coordinate(f, "D"), value};
  assert_int_equal(km_mechanism_compile(f->model, NULL, 0, &free, NULL), KM_OK);
  assert_int_equal(km_state_create(free, &there, NULL), KM_OK);
  km_status status = km_mechanism_recompile_at(free, there, &hold, 1, NULL, 0, held, at, NULL);
  km_state_free(there);
  km_mechanism_free(free);
  return status;
}

/* A held joint accepts new numbers, but not an inclined axis that makes the loop spatial. */
static void test_what_holds_is_kept(void **unused) {
  (void)unused;
  fixture f =
      fixture_read("{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"a\"}, "
                   "{\"name\": \"b\"}, {\"name\": \"c\"}], \"joints\": ["
                   "{\"name\": \"A\", \"type\": \"Rz\", \"bodies\": [\"fixed\", \"a\"], \"at\": [0, 0, 0]}, "
                   "{\"name\": \"B\", \"type\": \"Rz\", \"bodies\": [\"a\", \"b\"], \"at\": [0, 1, 0]}, "
                   "{\"name\": \"C\", \"type\": \"Rz\", \"bodies\": [\"b\", \"c\"], \"at\": [2, 2, 0]}, "
                   "{\"name\": \"D\", \"type\": \"Rz\", \"bodies\": [\"c\", \"fixed\"], \"at\": [3, 0, 0]}]}]}");
  km_mechanism *held = NULL;
  km_state *at = NULL;
  assert_int_equal(reach_again(&f, 0.0, &held, &at), KM_OK);
  const km_mechanism *first = held;
  assert_int_equal(reach_again(&f, 0.1, &held, &at), KM_OK);
  assert_ptr_equal(held, first);
  assert_near(km_state_coordinate(at, fixture_coordinate(&f, "D")), 0.1, 0.0);
  const double tilt[9] = {1, 0, 0, 0, cos(0.3), -sin(0.3), 0, sin(0.3), cos(0.3)};
  for (int e = 0; e < 2; ++e) {
    int frame = f.model->joints[1].frame[e];
    const km_vec3 p = f.model->frames[frame].pose.p;
    assert_int_equal(km_model_set_frame(f.model, frame, (const double[3]){p.x, p.y, p.z}, tilt, NULL), KM_OK);
  }
  assert_int_equal(reach_again(&f, 0.0, &held, &at), KM_PARTIAL);
  km_state_free(at);
  km_mechanism_free(held);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_same_pose),
      cmocka_unit_test(test_balls_turn_together),
      cmocka_unit_test(test_refusals_leave_the_state),
      cmocka_unit_test(test_what_holds_is_kept),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
