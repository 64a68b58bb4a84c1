/* Loads and laws over a joint's value or the time: forces against closed forms, works against integrals, corners that
 * an integrator can't pass over. */
#include "support/support.h"

#include "kmech/dynamics.h"
#include "kmech/statics.h"

#include <stdio.h>
#include <string.h>

/* Body of inertia 2 on the hinge A, in degrees, and body of mass 1 on the slide X, with modules and analysis. */
static fixture rotor(const char *modules, const char *analysis) {
  static const char text[] =
      "{\"model_parameters\": {\"units\": {\"angle\": \"degrees\"}}, \"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "{\"name\": \"r\", \"mass\": 1, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 2}}, {\"name\": \"s\", "
      "\"mass\": 1}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"r\"], "
      "\"initial_velocity\": 360}, {\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"s\"]}], "
      "\"force_modules\": [%s]}], \"analysis\": {%s}}";
  char buffer[4096];
  snprintf(buffer, sizeof buffer, text, modules, analysis);
  return fixture_read(buffer);
}

static km_history run(fixture *f, double until) {
  km_forces *forces;
  km_history out;
  km_history_def def = km_history_default(f->model);
  def.until = until;
  def.every = 0.01;
  def.simulation.relative = def.simulation.absolute = 1e-10;
  assert_int_equal(km_forces_create_own(f->mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f->mechanism, forces, f->state, &def, &out, NULL), KM_OK);
  km_forces_free(forces);
  return out;
}

static double at(const km_history *h, size_t row, const char *column) {
  int found = km_table_find(h->table, column);
  assert_true(found >= 0);
  return km_table_row(h->table, row)[found];
}

/* The rotor's kinetic energy w² follows the integral of the torque over the angle. */
static void check_work(const char *module, double (*work)(double turns)) {
  fixture f = rotor(module, "");
  km_history h = run(&f, 3.0);
  double most = 0.0;
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double w = at(&h, r, "v.A") * M_PI / 180.0, kinetic = w * w - 4.0 * M_PI * M_PI;
    double expected = work(at(&h, r, "q.A") / 360.0) - work(0.0);
    double tolerance = 1e-8 * (4.0 * M_PI * M_PI + fabs(expected)); /* the energy's error at 1e-10 of the rates */
    assert_near(kinetic, expected, tolerance);
    assert_near(at(&h, r, "motor_work"), expected, tolerance);
    most = fmax(most, fabs(expected));
  }
  assert_true(most > 0.1);
  km_history_free(&h);
  fixture_close(&f);
}

/* ∫ of 3 + 2 cos(2π turns + 30°) over the angle. */
static double cosine_work(double turns) {
  return 2.0 * M_PI * (3.0 * turns + 2.0 * sin(2.0 * M_PI * turns + M_PI / 6.0) / (2.0 * M_PI));
}

/* ∫ of the table 0 at 0°, 9 at 90°, 0 at 180° (lines), which repeats after 360° and is 0 in the second half. */
static double triangle_work(double turns) {
  double u = turns - floor(turns), full = 2.0 * M_PI * 9.0 / 4.0;
  double part = u <= 0.25 ? 18.0 * u * u : u <= 0.5 ? 9.0 / 4.0 - 18.0 * (0.5 - u) * (0.5 - u) : 9.0 / 4.0;
  return full * floor(turns) + 2.0 * M_PI * part;
}

/* A push between 179.5° and 180.5° of each turn, beyond it: a triangle of area 1000 · 1°/2. */
static double narrow_work(double turns) {
  return 500.0 * M_PI / 180.0 * floor(turns + 0.5);
}

/* ∫ of a 3-4-5 step from 0 to 5 between 90° and 180°: ∫s dz = 5/2 z⁴ − 3 z⁵ + z⁶. */
static double step_work(double turns) {
  double q = 360.0 * turns, z = fmin(fmax((q - 90.0) / 90.0, 0.0), 1.0);
  double area = 90.0 * z * z * z * z * (2.5 - 3.0 * z + z * z) + fmax(q - 180.0, 0.0);
  return 5.0 * area * M_PI / 180.0;
}

#define OVER_A "{\"name\": \"m\", \"type\": \"motor\", \"over\": \"A\", \"output\": {\"joint\": \"A\"}, "
static void torques_over_an_angle_do_their_work(void **state) {
  (void)state;
  check_work(OVER_A "\"period\": 360, \"cosine\": {\"offset\": 3, \"amplitude\": 2, \"phase\": 30}}", cosine_work);
  check_work(OVER_A "\"period\": 360, \"table\": [[0, 0], [90, 9], [180, 0]]}", triangle_work);
  check_work(OVER_A "\"step\": {\"at\": 90, \"width\": 90, \"from\": 0, \"to\": 5}}", step_work);
  check_work("{\"name\": \"m\", \"type\": \"stiffness\", \"over\": \"A\", \"output\": {\"joint\": \"A\"}, "
             "\"period\": 360, \"table\": [[0, 0], [90, 9], [180, 0]]}",
             triangle_work);
}

/* A push shorter than a step of the integrator counts in each turn. Rows within the push are left out. */
static void no_step_passes_over_a_push(void **state) {
  (void)state;
  fixture f = rotor(OVER_A "\"period\": 360, \"table\": [[179.5, 0], [180, 1000], [180.5, 0]]}", "");
  km_history h = run(&f, 3.0);
  int turns = 0;
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double w = at(&h, r, "v.A") * M_PI / 180.0, q = at(&h, r, "q.A") / 360.0;
    if (fabs(q - floor(q) - 0.5) < 0.5 / 360.0)
      continue;
    turns = (int)floor(q + 0.5);
    assert_near(w * w - 4.0 * M_PI * M_PI, narrow_work(q), 1e-6);
  }
  assert_true(turns >= 3);
  km_history_free(&h);
  fixture_close(&f);
}

/* A load on the slide: 2 N times a factor over A. It is the force on the body at A = q; and the slide's speed is the
 * factor's integral over the time while A turns at 360°/s. */
static void loads_follow_an_angle(void **state) {
  (void)state;
  fixture f =
      rotor("", "\"loads\": [{\"name\": \"push\", \"frame\": [\"a\", \"s\", \"origin\"], \"force\": [2, 0, 0], "
                "\"scale\": {\"over\": \"A\", \"period\": 360, \"cosine\": {\"offset\": 1, \"amplitude\": 4}}}]");
  km_forces *forces;
  int a, x;
  assert_int_equal(km_model_find_coordinate(f.model, "A", &a, NULL), KM_OK);
  assert_int_equal(km_model_find_coordinate(f.model, "X", &x, NULL), KM_OK);
  assert_int_equal(km_forces_create_own(f.mechanism, &forces, NULL), KM_OK);
  for (int i = -4; i < 20; ++i) {
    double q = 37.0 * i, wrench[6];
    assert_int_equal(km_state_set_coordinate(f.mechanism, f.state, a, q, NULL), KM_OK);
    km_forces_compute(f.mechanism, f.state, forces);
    km_forces_on_body(forces, f.model->frames[f.model->loads[0].frame].body, wrench);
    assert_near(wrench[0], 2.0 * (1.0 + 4.0 * cos(q * M_PI / 180.0)), 1e-12);
  }
  km_forces_free(forces);
  assert_int_equal(km_state_set_coordinate(f.mechanism, f.state, a, 0.0, NULL), KM_OK);
  km_history h = run(&f, 2.0);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double t = at(&h, r, "t"), w = 2.0 * M_PI, v = 2.0 * (t + 4.0 * sin(w * t) / w);
    assert_near(at(&h, r, "v.X"), v, 1e-8);
    assert_near(at(&h, r, "motor_work"), 0.5 * v * v, 1e-7);
  }
  km_history_free(&h);
  fixture_close(&f);
}

/* Loads over time: a jump at 0.5 and a periodic spline; momentum against the integral. */
static void loads_follow_the_time(void **state) {
  (void)state;
  fixture f = rotor("", "\"loads\": [{\"name\": \"push\", \"frame\": [\"a\", \"s\", \"origin\"], \"force\": [3, 0, 0], "
                        "\"scale\": {\"step\": {\"at\": 0.5, \"from\": 1, \"to\": -1}}}]");
  km_history h = run(&f, 2.0);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double t = at(&h, r, "t");
    assert_near(at(&h, r, "v.X"), t < 0.5 ? 3.0 * t : 1.5 - 3.0 * (t - 0.5), 1e-9);
  }
  km_history_free(&h);
  fixture_close(&f);
}

/* A controller of the slide with k_p 400 and k_d 40 (critical) follows r(t) = sin 3t + t²/10 from rest at r(0) = 0; the
 * error obeys ë + 40 ė + 400 e = r̈, so that with e(0) = 0, ė(0) = 3 it is the solution below. The motor takes the
 * force by an expression, and the load is its negative: both cancel. */
static void references_are_expressions(void **state) {
  (void)state;
  fixture f =
      rotor("{\"name\": \"c\", \"type\": \"pid\", \"input\": {\"joint\": \"X\"}, \"reference\": \"sin(3*t) + t^2/10\", "
            "\"kp\": 400, \"kd\": 40}, {\"name\": \"m\", \"type\": \"motor\", \"output\": {\"joint\": \"X\"}, "
            "\"expression\": \"5*cos(7*t)\"}",
            "\"loads\": [{\"name\": \"push\", \"frame\": [\"a\", \"s\", \"origin\"], \"force\": [5, 0, 0], "
            "\"scale\": {\"expression\": \"-cos(7*t)\"}}]");
  km_history h = run(&f, 2.0);
  /* Particular solution of −9 sin 3t: a sin 3t + b cos 3t with (391 + 120 i)(…) = −9; of 1/5: 1/2000. */
  double square = 391.0 * 391.0 + 120.0 * 120.0, a = -9.0 * 391.0 / square, b = 9.0 * 120.0 / square, c = 0.2 / 400.0;
  double c0 = -b - c, c1 = 3.0 - 3.0 * a + 20.0 * c0;
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double t = at(&h, r, "t"), reference = sin(3.0 * t) + 0.1 * t * t;
    double e = a * sin(3.0 * t) + b * cos(3.0 * t) + c + (c0 + c1 * t) * exp(-20.0 * t);
    assert_near(at(&h, r, "q.X"), reference - e, 1e-8);
  }
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(torques_over_an_angle_do_their_work),
                                     cmocka_unit_test(no_step_passes_over_a_push),
                                     cmocka_unit_test(loads_follow_an_angle), cmocka_unit_test(loads_follow_the_time),
                                     cmocka_unit_test(references_are_expressions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
