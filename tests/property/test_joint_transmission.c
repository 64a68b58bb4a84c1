/* Transmission angles of hinges: the classical ones of four-bar and slider-crank, and of linkages of two and three
 * loops by the lines of their two-force members and differences of positions. */
#include "support/support.h"

#include "kinematics/body_poses.h"
#include "kmech/sweep.h"

#include <stdio.h>

static int coordinate_of(const fixture *f, const char *label) {
  int c;
  assert_int_equal(km_model_find_coordinate(f->model, label, &c, NULL), KM_OK);
  return c;
}

static km_advantage_sweep sweep_of(fixture *f, const char *input, const char *output, double from, double to,
                                   int steps) {
  km_port in = {.kind = KM_PORT_JOINT, .coordinate = coordinate_of(f, input), .name = input},
          out = {.kind = KM_PORT_JOINT, .coordinate = coordinate_of(f, output), .name = output};
  km_sweep_plan plan = km_sweep_plan_default(f->model);
  km_advantage_sweep sweep;
  plan.coordinate = in.coordinate;
  plan.from = from;
  plan.to = to;
  plan.steps = steps;
  assert_int_equal(km_advantage_sweep_run(f->mechanism, f->state, &plan, &in, &out, true, &sweep, NULL), KM_OK);
  return sweep;
}

static double cell(const km_advantage_sweep *sweep, size_t row, const char *column) {
  int found = km_table_find(sweep->motion.table, column);
  assert_true(found >= 0);
  return km_table_row(sweep->motion.table, row)[found];
}

/* The angle between coupler and rocker, or its supplement. */
static void four_bars_have_the_classical_angle(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_advantage_sweep sweep = sweep_of(&f, "A", "D", 0.0, 2.0 * M_PI, 72);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    double angle = cell(&sweep, r, "transmission_angle");
    assert_near(cell(&sweep, r, "transmission.C"), fmin(angle, M_PI - angle), 1e-9);
    assert_near(cell(&sweep, r, "pressure.C"), 0.5 * M_PI - fmin(angle, M_PI - angle), 1e-9);
  }
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

/* The rod's angle to the slide: sin α = (r/l) sin A. The piston rests at the dead centres: no angle. */
static void slider_cranks_have_the_rods_angle(void **state) {
  (void)state;
  fixture f = fixture_open("engine");
  km_advantage_sweep sweep = sweep_of(&f, "A", "P", 0.0, 360.0, 36);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    double a = cell(&sweep, r, "q.A") * M_PI / 180.0, pressure = cell(&sweep, r, "pressure.C");
    if (r % 18 == 0)
      assert_true(isnan(pressure));
    else
      assert_near(pressure, fabs(asin(40.0 / 140.0 * sin(a))) * 180.0 / M_PI, 1e-8);
  }
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

/* Position of a joint in row `row` of a sweep. */
static km_vec3 position(fixture *f, const km_advantage_sweep *sweep, size_t row, int joint) {
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    char column[128];
    snprintf(column, sizeof column, "q.%s", f->model->coordinates[c].label);
    assert_int_equal(km_state_set_coordinate(f->mechanism, f->state, c, cell(sweep, row, column), NULL), KM_OK);
  }
  km_poses_compute(f->mechanism, f->state);
  return km_joint_pose(f->mechanism, f->state, joint).p;
}

static int body_of(const fixture *f, int joint, int side) {
  return f->model->frames[f->model->joints[joint].frame[side]].body;
}

/* The two joints of a link with two hinges to moving links; false for other bodies. */
static bool is_two_force_member(const fixture *f, int body, int output, int ends[2]) {
  int count = 0;
  for (int j = 0; j < f->model->joint_count; ++j)
    for (int side = 0; side < 2; ++side) {
      if (body_of(f, j, side) != body)
        continue;
      if (count == 2 || j == output || body_of(f, j, !side) == 0)
        return false;
      ends[count++] = j;
    }
  return count == 2;
}

/* Compares the angles at the ends of all two-force members at a driver's value; returns their number. */
static int check_members(const char *model, const char *input, const char *output, double s) {
  const double h = 0.02; /* degrees: differences are off by about h² = 1e-7 times the curvature of the paths */
  fixture f = fixture_open(model);
  int checked = 0, ends[2], out = f.model->coordinates[coordinate_of(&f, output)].joint;
  km_advantage_sweep sweep = sweep_of(&f, input, output, s - h, s + h, 2);
  assert_int_equal(km_table_rows(sweep.motion.table), 3);
  for (int body = 1; body < f.model->body_count; ++body) {
    if (!is_two_force_member(&f, body, out, ends))
      continue;
    km_vec3 along = km_vec3_sub(position(&f, &sweep, 1, ends[1]), position(&f, &sweep, 1, ends[0]));
    for (int k = 0; k < 2; ++k) {
      char column[128];
      snprintf(column, sizeof column, "transmission.%s", f.model->joints[ends[k]].label);
      km_vec3 v = km_vec3_sub(position(&f, &sweep, 2, ends[k]), position(&f, &sweep, 0, ends[k]));
      double expected = asin(fmin(fabs(km_vec3_dot(along, v)) / (km_vec3_norm(along) * km_vec3_norm(v)), 1.0));
      assert_near(cell(&sweep, 1, column) * f.model->units.angle->si, expected, 5e-6);
      ++checked;
    }
  }
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
  return checked;
}

static void linkages_of_several_loops_follow_their_two_force_members(void **state) {
  (void)state;
  int checked = 0;
  for (int i = 0; i < 8; ++i) {
    checked += check_members("toggle_press", "A", "G", 193.0 + 41.0 * i); /* coupler and lower link */
    checked += check_members("jansen", "A", "H", 7.0 + 44.0 * i);         /* both rods and the leg */
  }
  assert_int_equal(checked, 8 * (4 + 6));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(four_bars_have_the_classical_angle),
                                     cmocka_unit_test(slider_cranks_have_the_rods_angle),
                                     cmocka_unit_test(linkages_of_several_loops_follow_their_two_force_members)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
