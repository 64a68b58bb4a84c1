/* Transmission indices along sweeps against closed forms.
 *
 *   planar four-bar, hinges A B C D, driver A, unit torque at D, rocker CD = l, μ angle of coupler and rocker:
 *     joint force index = 1 / (l sin μ);   minor of J without A = twice the area of BCD = |BC| l sin μ
 *     Lee-Duffy = sin μ / max sin μ;   Zhang = √Σ minors² / max  (Cauchy, Binet)
 *   RSSR: the rod carries a force along itself, so the joint force index is 1 / (2 · virtual coefficient), and
 *     Sutherland-Roth = |u · v_C| / |v_C|, u along the rod
 *   kmob's columns are those of kma. */
#include "support/support.h"

#include "kinematics/body_poses.h"
#include "kmech/question.h"
#include "kmech/sweep.h"
#include "topology/mechanism.h"

#include <string.h>

static km_port joint_port(const fixture *f, const char *label) {
  km_port port = {.kind = KM_PORT_JOINT, .name = label};
  assert_int_equal(km_model_find_coordinate(f->model, label, &port.coordinate, NULL), KM_OK);
  return port;
}

static km_advantage_sweep sweep_of(fixture *f, const char *input, const char *output, double to, int steps) {
  const km_port in = joint_port(f, input), out = joint_port(f, output);
  km_sweep_plan plan = km_sweep_plan_default(f->model);
  km_advantage_sweep sweep;
  plan.coordinate = in.coordinate;
  plan.from = 0.0;
  plan.to = to;
  plan.steps = steps;
  assert_int_equal(km_advantage_sweep_run(f->mechanism, f->state, &plan, &in, &out, true, &sweep, NULL), KM_OK);
  return sweep;
}

/* Moves the state to a row, and returns the position of a joint there. */
static km_vec3 position(fixture *f, const km_table *t, size_t row, int joint) {
  for (int c = 0; c < f->model->coordinate_count; ++c)
    assert_int_equal(km_state_set_coordinate(f->mechanism, f->state, c,
                                             km_table_row(t, row)[km_table_span(t, "q.").first + (size_t)c], NULL),
                     KM_OK);
  km_poses_compute(f->mechanism, f->state);
  return km_joint_pose(f->mechanism, f->state, joint).p;
}

/* Twice the area of the triangle of three points of a plane across z. */
static double twice_area(km_vec3 a, km_vec3 b, km_vec3 c) {
  return fabs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
}

static void four_bars_have_closed_forms(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  enum { STEPS = 72 };
  km_advantage_sweep sweep = sweep_of(&f, "A", "D", 2.0 * M_PI, STEPS);
  const km_table *t = sweep.motion.table;
  double minor[STEPS + 1], volume[STEPS + 1], most_minor = 0.0, most_volume = 0.0;
  assert_int_equal(km_table_rows(t), STEPS + 1);
  for (size_t r = 0; r <= STEPS; ++r) {
    km_vec3 p[4];
    for (int j = 0; j < 4; ++j)
      p[j] = position(&f, t, r, j);
    const double l = km_vec3_norm(km_vec3_sub(p[2], p[3]));
    assert_near(table_cell(t, r, "joint_force_index") * l * sin(table_cell(t, r, "transmission_angle")), 1.0, 1e-9);
    minor[r] = twice_area(p[1], p[2], p[3]);
    volume[r] = hypot(hypot(minor[r], twice_area(p[0], p[2], p[3])),
                      hypot(twice_area(p[0], p[1], p[3]), twice_area(p[0], p[1], p[2])));
    most_minor = fmax(most_minor, minor[r]);
    most_volume = fmax(most_volume, volume[r]);
  }
  for (size_t r = 0; r <= STEPS; ++r) {
    assert_near(table_cell(t, r, "lee_duffy"), minor[r] / most_minor, 1e-9);
    assert_near(table_cell(t, r, "zhang"), volume[r] / most_volume, 1e-9);
  }
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

static void rods_carry_forces_along_themselves(void **state) {
  (void)state;
  fixture f = fixture_open("rssr");
  km_advantage_sweep sweep = sweep_of(&f, "A", "D", 360.0, 36);
  const km_table *t = sweep.motion.table;
  for (size_t r = 0; r < km_table_rows(t); ++r) {
    const km_vec3 b = position(&f, t, r, 1), c = position(&f, t, r, 2), d = position(&f, t, r, 3);
    const km_vec3 axis = {1, 0, 0}, rod = km_vec3_sub(c, b), v = km_vec3_cross(axis, km_vec3_sub(c, d));
    const double index = fabs(km_vec3_dot(rod, v)) / (km_vec3_norm(rod) * km_vec3_norm(v));
    assert_near(table_cell(t, r, "sutherland_roth"), index, 1e-9);
    assert_near(table_cell(t, r, "chen_angeles"), index, 1e-9);
    assert_near(2.0 * table_cell(t, r, "virtual_coefficient") * table_cell(t, r, "joint_force_index"), 1.0, 1e-9);
    assert_true(isnan(table_cell(t, r, "lee_duffy"))); /* the rod spins: J without the input isn't square */
    assert_true(table_cell(t, r, "zhang") > 0.0 && table_cell(t, r, "zhang") <= 1.0);
  }
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

/* Bennett's linkage is overconstrained: statics leaves its joint forces open. */
static void open_forces_give_no_index(void **state) {
  (void)state;
  fixture f = fixture_open("bennett");
  km_advantage_sweep sweep = sweep_of(&f, "A", "D", 1.0, 4);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
    assert_true(isnan(table_cell(sweep.motion.table, r, "joint_force_index")));
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

/* kmob's columns are kma's, of one loop, of several, in the plane and in space. */
static void both_sweeps_have_equal_columns(void **state) {
  (void)state;
  static const char *const cases[][3] = {{"fourbar", "A", "D"},
                                         {"slider_crank", "A", "B"},
                                         {"toggle_press", "A", "G"},
                                         {"klann", "A", "D"},
                                         {"rssr", "A", "D"}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; ++n) {
    fixture f = fixture_open(cases[n][0]);
    km_question *q[2];
    const char *const kinds[2] = {"mobility", "advantage"};
    const km_option_value yes = {.flag = true}, input = {.end = joint_port(&f, cases[n][1])},
                          output = {.end = joint_port(&f, cases[n][2])}, steps = {.whole = 12};
    for (int i = 0; i < 2; ++i) {
      assert_int_equal(km_question_create(f.mechanism, kinds[i], &q[i], NULL), KM_OK);
      assert_int_equal(km_question_set(q[i], "transmission", &yes, NULL), KM_OK);
      assert_int_equal(km_question_set(q[i], "output", &output, NULL), KM_OK);
      assert_int_equal(km_question_set(q[i], "steps", &steps, NULL), KM_OK);
      if (i == 1)
        assert_int_equal(km_question_set(q[i], "input", &input, NULL), KM_OK);
      assert_int_equal(km_question_compute(q[i], f.state, NULL), KM_OK);
    }
    const km_table *a = km_question_table(q[0]), *b = km_question_table(q[1]);
    size_t compared = 0;
    bool counts = false;
    assert_int_equal(km_table_rows(a), km_table_rows(b));
    for (size_t c = 0; c < km_table_columns(a); ++c) {
      const char *name = km_table_name(a, c);
      counts = (counts || strcmp(name, "transmission_angle") == 0) && strcmp(name, "dof") != 0;
      const int other = counts ? km_table_find(b, name) : 0;
      assert_true(other >= 0);
      for (size_t r = 0; counts && r < km_table_rows(a); ++r, ++compared) {
        const double x = km_table_row(a, r)[c], y = km_table_row(b, r)[other];
        assert_true((isnan(x) && isnan(y)) || fabs(x - y) <= 1e-6 * fmax(1.0, fabs(y)));
      }
    }
    assert_true(compared >= 9 * km_table_rows(a));
    for (int i = 0; i < 2; ++i)
      km_question_free(q[i]);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(four_bars_have_closed_forms),
      cmocka_unit_test(rods_carry_forces_along_themselves),
      cmocka_unit_test(open_forces_give_no_index),
      cmocka_unit_test(both_sweeps_have_equal_columns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
