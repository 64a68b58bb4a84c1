/* The `known` facts of every shipped model. */
#include "support/support.h"

#include "exchange/json/read/reader.h"
#include "kmech/transfer.h"

#include <math.h>
#include <string.h>

static void expect(const km_value *known, const char *key, double found, double tolerance) {
  const km_value *value = km_value_get(known, key);
  if (value)
    assert_near(found, value->number, tolerance);
}

/* Mechanical advantage of the model's default analysis. */
static void check_advantage(fixture *f, const km_value *known) {
  const km_value *value = km_value_get(known, "mechanical_advantage");
  km_port input, output;
  km_transfer *lever;
  km_advantage advantage;
  if (!value)
    return;
  assert_true(km_port_default(f->model, false, &input) && km_port_default(f->model, true, &output));
  assert_int_equal(km_transfer_create(f->mechanism, &input, &output, &lever, NULL), KM_OK);
  km_transfer_compute(f->mechanism, f->state, lever, &advantage);
  assert_near(advantage.value, value->number, 1e-9 * fabs(value->number));
  km_transfer_free(lever);
}

static void check_model(const char *name) {
  fixture f = fixture_open(name);
  km_mobility mobility;
  km_mobility_compute(f.mechanism, f.state, &mobility);
  const km_value *known = km_value_get(f.model->origin->root, "known");
  assert_non_null(known);
  assert_non_null(km_value_get(f.model->origin->root, "source"));
  expect(known, "kutzbach", mobility.kutzbach, 0.0);
  expect(known, "kutzbach_extended", mobility.kutzbach_extended, 0.0);
  expect(known, "mobility", mobility.mobility, 0.0);
  expect(known, "redundant_constraints", mobility.redundant_constraints, 0.0);
  assert_true(mobility.residual <= 1e-12);
  check_advantage(&f, known);
  int rank = 0;
  for (int s = 0; s < f.mechanism->topology.substructure_count; ++s)
    rank += km_factor_rank(f.state->factor[s]);
  expect(known, "rank", rank, 0.0);
  const km_value *numbers = km_value_get(known, "mobility_numbers");
  for (const km_value *n = numbers ? numbers->first : NULL; n; n = n->next) {
    int coordinate;
    km_error error;
    if (km_model_find_coordinate(f.model, n->key, &coordinate, &error)) {
      int joint;
      assert_int_equal(km_model_find_joint(f.model, n->key, &joint, NULL), KM_OK);
      assert_near(0.0, n->number, 0.0); /* a rigid joint's number */
      continue;
    }
    assert_near(km_mobility_number(f.state, coordinate), n->number, 1e-9);
  }
  fixture_close(&f);
}

static void every_known_fact_holds(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name)
    check_model(*name);
}

/* Excavator, Table 7. */
static void excavator_substructures(void **state) {
  (void)state;
  static const char *const expected[3] = {"C H I L M P Q ", "D J N R ", "E F G K O S T "};
  fixture f = fixture_open("excavator");
  const km_topology *t = &f.mechanism->topology;
  assert_int_equal(t->substructure_count, 3);
  for (int s = 0; s < 3; ++s) {
    km_text text = {0};
    for (int i = t->joint_start[s]; i < t->joint_start[s + 1]; ++i)
      km_text_format(&text, "%s ", f.model->joints[t->joint[i]].label);
    assert_string_equal(text.data, expected[s]);
    km_text_free(&text);
  }
  fixture_close(&f);
}

/* theory.md 6: the robot's columns, v then ω. */
static void robot_columns(void **state) {
  (void)state;
  static const double expected[6][7] = {{0.0000, -0.0134, -0.1356, -0.0256, 0.1756, -0.0123, -0.0936},
                                        {0.0000, 0.0200, 0.0000, 0.1821, 0.0073, -0.3956, -0.0074},
                                        {0.0000, -0.1343, 0.0136, 0.1766, -0.0106, -0.1770, 0.0040},
                                        {0.0000, 0.9950, -0.0978, -0.9791, 0.0604, 0.9981, -0.0584},
                                        {1.0000, 0.0000, 0.1986, -0.1947, -0.0038, -0.0040, 0.2024},
                                        {0.0000, -0.0998, -0.9751, 0.0585, 0.9981, -0.0604, -0.9775}};
  fixture f = fixture_open("robot7r");
  km_poses_compute(f.mechanism, f.state);
  for (int c = 0; c < 7; ++c) {
    km_twist h = column_in_space(&f, c);
    /* The column is how the joint moves the effector: against the user's sense where that runs inwards. */
    double sign = f.mechanism->topology.is_reversed[f.model->coordinates[c].joint] ? -1.0 : 1.0;
    const double column[6] = {h.v.x, h.v.y, h.v.z, h.w.x, h.w.y, h.w.z};
    for (int r = 0; r < 6; ++r)
      assert_near(sign * column[r], expected[r][c], 5e-4);
  }
  fixture_close(&f);
}

static void point_at(fixture *f, const char *body, const char *frame, double place[3]) {
  const char *const names[] = {body, frame};
  int index;
  assert_int_equal(km_model_find_frame(f->model, names, 2, &index, NULL), KM_OK);
  km_poses_compute(f->mechanism, f->state);
  km_frame_position(f->mechanism, f->state, index, place);
}

static km_driver_motion *driven(fixture *f, const char *joint) {
  int coordinate;
  km_driver_motion *drive;
  assert_int_equal(km_model_find_coordinate(f->model, joint, &coordinate, NULL), KM_OK);
  assert_int_equal(km_driver_motion_create(f->mechanism, f->state, coordinate, false, &drive, NULL), KM_OK);
  return drive;
}

/* |OQ| |OP| = arm² − side², Q on a circle through O: P stays on the line x = 100. */
static void peaucellier_runs_straight(void **state) {
  (void)state;
  fixture f = fixture_open("peaucellier");
  km_driver_motion *drive = driven(&f, "C");
  double place[3], last = -1e9;
  for (double angle = -70.0; angle <= 40.0; angle += 5.0) {
    assert_int_equal(km_driver_motion_move_to(drive, angle).stop, KM_STOP_NONE);
    point_at(&f, "AP", "P", place);
    assert_near(place[0], 100.0, 1e-9);
    assert_near(place[2], 0.0, 1e-12);
    assert_true(place[1] > last);
    last = place[1];
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

/* Intersection of two circles: left (+1) or right (−1) of the line from P to Q. */
static void meet(const double P[2], double p, const double Q[2], double q, double side, double out[2]) {
  double dx = Q[0] - P[0], dy = Q[1] - P[1], d = hypot(dx, dy);
  double angle = atan2(dy, dx) + side * acos((p * p + d * d - q * q) / (2.0 * p * d));
  out[0] = P[0] + p * cos(angle);
  out[1] = P[1] + p * sin(angle);
}

/* The foot by five pairs of circles with Jansen's numbers, around the whole turn. */
static void jansen_steps_as_drawn(void **state) {
  (void)state;
  static const double pivot[2] = {-38.0, -7.8};
  fixture f = fixture_open("jansen");
  km_driver_motion *drive = driven(&f, "A");
  for (double angle = 0.0; angle <= 360.0; angle += 10.0) {
    double pin[2] = {15.0 * cos(angle * M_PI / 180.0), 15.0 * sin(angle * M_PI / 180.0)}, top[2], low[2], knee[2],
           shin[2], foot[2], place[3];
    meet(pivot, 41.5, pin, 50.0, 1.0, top);
    meet(pivot, 39.3, pin, 61.9, -1.0, low);
    meet(pivot, 40.1, top, 55.8, 1.0, knee);
    meet(knee, 39.4, low, 36.7, -1.0, shin);
    meet(shin, 65.7, low, 49.0, -1.0, foot);
    assert_int_equal(km_driver_motion_move_to(drive, angle).stop, KM_STOP_NONE);
    point_at(&f, "leg", "foot", place);
    assert_near(place[0], foot[0], 1e-9);
    assert_near(place[1], foot[1], 1e-9);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(every_known_fact_holds, "Every fact that the models state",
                 "whole numbers exactly, mobility numbers to the digits stated"),
      cmocka_unit_test(excavator_substructures),
      claim_test(robot_columns, "The columns of the thesis's 7R robot (thesis section 11.4)",
                 "half of the last digit printed, and rounding of the frames that were found for it"),
      claim_test(peaucellier_runs_straight, "Peaucellier's linkage draws the line x = 100 mm",
                 "the loops are closed to 1e-12 of its size"),
      claim_test(jansen_steps_as_drawn, "The foot of Jansen's leg goes where five pairs of circles meet",
                 "the loops are closed to 1e-12 of its size")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
