/* Causes of a motion against closed forms: prescribed laws of every kind, rotors, loads. */
#include "support/support.h"

#include "kmech/dynamics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A body of inertia 2 on a revolute joint, in degrees; the text of the joint is appended. */
static fixture driven(const char *law) {
  static const char text[] =
      "{\"model_parameters\": {\"units\": {\"angle\": \"degrees\"}}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"b\", \"mass\": 1, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 2}}], \"joints\": "
      "[{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"prescribed\": %s}]}]}";
  char buffer[1024];
  snprintf(buffer, sizeof buffer, text, law);
  return fixture_read(buffer);
}

/* q, v, a in degrees, and the torque 2 a in radians, at times 0, 0.25 … 3. */
static void check_motion(const char *law, void (*exact)(double t, double motion[3])) {
  fixture f = driven(law);
  km_forces *forces;
  km_history h;
  km_inverse_def def = {.until = 3.0, .steps = 12};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_inverse_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
  assert_int_equal(km_table_rows(h.table), 13);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    const double *row = km_table_row(h.table, r);
    double motion[3];
    exact(row[0], motion);
    assert_near(row[km_table_find(h.table, "q.A")], motion[0], 1e-11);
    assert_near(row[km_table_find(h.table, "v.A")], motion[1], 1e-11);
    assert_near(row[km_table_find(h.table, "a.A")], motion[2], 1e-10);
    assert_near(row[km_table_find(h.table, "f.A")], 2.0 * motion[2] * M_PI / 180.0, 1e-11);
  }
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

/* offset + amplitude sin(2π frequency t + phase), all angles in degrees. */
static void sine(double t, double motion[3]) {
  double w = 2.0 * M_PI * 0.4, angle = w * t + 30.0 * M_PI / 180.0;
  motion[0] = 10.0 + 20.0 * sin(angle);
  motion[1] = 20.0 * w * cos(angle);
  motion[2] = -20.0 * w * w * sin(angle);
}

/* The natural cubic spline through (0, 0), (1, 1), (2, 0): s'' = −3 in the middle, s = 3/2 t − t³/2 up to there and
 * the same from the other end; past its ends it goes on straight. */
static void spline(double t, double motion[3]) {
  double u = t < 1.0 ? t : 2.0 - t, sense = t < 1.0 ? 1.0 : -1.0;
  motion[0] = t > 2.0 ? -1.5 * (t - 2.0) : 1.5 * u - 0.5 * u * u * u;
  motion[1] = t > 2.0 ? -1.5 : sense * (1.5 - 1.5 * u * u);
  motion[2] = t > 2.0 ? 0.0 : -3.0 * u;
}

/* Two rows are a straight line. */
static void line(double t, double motion[3]) {
  motion[0] = -5.0 + 4.0 * t;
  motion[1] = 4.0;
  motion[2] = 0.0;
}

static void polynomial(double t, double motion[3]) {
  motion[0] = 1.0 + 2.0 * t - t * t + 0.5 * t * t * t;
  motion[1] = 2.0 - 2.0 * t + 1.5 * t * t;
  motion[2] = -2.0 + 3.0 * t;
}

/* 5 + 20 cos(2π t/1.6 + 30°). */
static void cosine(double t, double motion[3]) {
  double w = 2.0 * M_PI / 1.6, angle = w * t + M_PI / 6.0;
  motion[0] = 5.0 + 20.0 * cos(angle);
  motion[1] = -20.0 * w * sin(angle);
  motion[2] = -20.0 * w * w * cos(angle);
}

/* Cycloidal rise of 90 in 0.5 s, dwell of 0.25 s; with a period of 1 s the table indexes by 90 each second. */
static void indexed(double t, double motion[3]) {
  double cycles = floor(t), z = fmin((t - cycles) / 0.5, 1.0), w = 2.0 * M_PI;
  motion[0] = 7.0 + 90.0 * (cycles + z - sin(w * z) / w);
  motion[1] = 90.0 / 0.5 * (1.0 - cos(w * z));
  motion[2] = 90.0 / 0.25 * w * sin(w * z);
}

/* 3-4-5 return of −60 in 2 s, then at rest. */
static void returned(double t, double motion[3]) {
  double z = fmin(t / 2.0, 1.0);
  motion[0] = -60.0 * z * z * z * (10.0 - 15.0 * z + 6.0 * z * z);
  motion[1] = -30.0 * 30.0 * z * z * (1.0 - z) * (1.0 - z);
  motion[2] = -15.0 * 60.0 * z * (1.0 - z) * (1.0 - 2.0 * z);
}

/* Start to 120 a second in 1 s by the cycloidal law, whose integral is z²/2 + (cos 2πz − 1)/(4π²); on at that rate. */
static void started(double t, double motion[3]) {
  double z = fmin(t, 1.0), w = 2.0 * M_PI;
  motion[0] = 120.0 * (0.5 * z * z + (cos(w * z) - 1.0) / (w * w) + (t - z));
  motion[1] = 120.0 * (z - sin(w * z) / w);
  motion[2] = 120.0 * (1.0 - cos(w * z));
}

/* 10 t² cos(3 t). */
static void expressed(double t, double motion[3]) {
  double c = cos(3.0 * t), s = sin(3.0 * t);
  motion[0] = 10.0 * t * t * c;
  motion[1] = 10.0 * (2.0 * t * c - 3.0 * t * t * s);
  motion[2] = 10.0 * (2.0 * c - 12.0 * t * s - 9.0 * t * t * c);
}

static void laws_are_what_they_say(void **state) {
  (void)state;
  check_motion("{\"sine\": {\"offset\": 10, \"amplitude\": 20, \"frequency\": 0.4, \"phase\": 30}}", sine);
  check_motion("{\"table\": [[0, 0], [1, 1], [2, 0]]}", spline);
  check_motion("{\"table\": [[-1, -9], [1, -1]]}", line);
  check_motion("{\"polynomial\": [1, 2, -1, 0.5]}", polynomial);
  check_motion("{\"cosine\": {\"offset\": 5, \"amplitude\": 20, \"phase\": 30}, \"period\": 1.6}", cosine);
  check_motion("{\"start\": 7, \"period\": 1, \"segments\": [{\"rise\": 90, \"duration\": 0.5}, {\"duration\": 0.25}]}",
               indexed);
  check_motion("{\"segments\": [{\"rise\": -60, \"duration\": 2, \"law\": \"3-4-5\"}, {\"duration\": 1}]}", returned);
  check_motion("{\"segments\": [{\"rate\": 120, \"duration\": 1}, {\"duration\": 1}]}", started);
  check_motion("{\"expression\": \"10*t^2*cos(3*t)\"}", expressed);
}

/* The table of a run of one second. */
static km_history run(fixture *f, const km_load *loads, int load_count) {
  km_forces *forces;
  km_history out;
  km_history_def def = km_history_default(f->model);
  def.until = 1.0;
  def.every = 0.1;
  def.simulation.relative = def.simulation.absolute = 1e-11;
  assert_int_equal(km_forces_create(f->mechanism, NULL, loads, load_count, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f->mechanism, forces, f->state, &def, &out, NULL), KM_OK);
  km_forces_free(forces);
  return out;
}

/* The slider-crank with one text of its file in the place of another. */
static km_history changed(const char *from, const char *to) {
  char *text = read_model_text("slider_crank"), *at = strstr(text, from), with[8192];
  assert_non_null(at);
  snprintf(with, sizeof with, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
  fixture f = fixture_read(with);
  km_history h = run(&f, NULL, 0);
  fixture_close(&f);
  km_free(text);
  return h;
}

/* A rotor on the crank's hinge is an inertia of the crank about its axis; one on the slide is a mass of the piston,
 * whose weight is across it. Both lie in a loop, so that dependent coordinates turn rotors, too. */
static void rotors_are_inertias(void **state) {
  (void)state;
  static const char *const pairs[][4] = {{"\"name\": \"A\"", "\"armature\": 0.05, \"name\": \"A\"",
                                          "\"Ixx\": 1.0, \"Iyy\": 0.1", "\"Ixx\": 1.05, \"Iyy\": 0.1"},
                                         {"\"name\": \"B\"", "\"armature\": 2, \"name\": \"B\"",
                                          "\"piston\", \"mass\": 1.0", "\"piston\", \"mass\": 3.0"}};
  km_history plain = changed("\"name\": \"A\"", "\"name\": \"A\"");
  int q = km_table_find(plain.table, "q.A"), v = km_table_find(plain.table, "v.A");
  for (int i = 0; i < 2; ++i) {
    km_history rotor = changed(pairs[i][0], pairs[i][1]), heavy = changed(pairs[i][2], pairs[i][3]);
    size_t last = km_table_rows(rotor.table) - 1;
    assert_true(fabs(km_table_row(plain.table, last)[q] - km_table_row(rotor.table, last)[q]) > 1e-3);
    for (size_t r = 0; r <= last; ++r) {
      assert_near(km_table_row(rotor.table, r)[q], km_table_row(heavy.table, r)[q], 1e-8);
      assert_near(km_table_row(rotor.table, r)[v], km_table_row(heavy.table, r)[v], 1e-8);
    }
    assert_at_most(rotor.energy_error, 1e-8 * rotor.energy_scale);
    km_history_free(&rotor);
    km_history_free(&heavy);
  }
  km_history_free(&plain);
}

/* 2 N on 1 kg along a prismatic joint: q = t², work 2 q. A load of 3 N fixed to a body of inertia 2, half a metre
 * from its axis: θ = 3/8 t², work 3/2 θ. A load along inertial axes would differ. */
static void loads_give_work(void **state) {
  (void)state;
  static const char text[] =
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}, {\"name\": \"c\", \"mass\": 1, "
      "\"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 2}, \"frames\": [{\"name\": \"end\", \"T\": [0.5, 0, "
      "0]}]}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, {\"name\": "
      "\"Z\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"c\"]}]}]}";
  fixture f = fixture_read(text);
  km_load loads[] = {{.force = {2.0, 0.0, 0.0}}, {.force = {0.0, 3.0, 0.0}, .turning = true}};
  static const char *const names[][2] = {{"b", "origin"}, {"c", "end"}};
  for (int i = 0; i < 2; ++i)
    assert_int_equal(km_model_find_frame(f.model, names[i], 2, &loads[i].frame, NULL), KM_OK);
  km_history h = run(&f, loads, 2);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    const double *row = km_table_row(h.table, r);
    double t = row[0], x = t * t, turn = 0.375 * t * t;
    assert_near(row[km_table_find(h.table, "q.X")], x, 1e-9);
    assert_near(row[km_table_find(h.table, "q.Z")], turn, 1e-9);
    assert_near(row[km_table_find(h.table, "motor_work")], 2.0 * x + 1.5 * turn, 1e-8);
  }
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(laws_are_what_they_say), cmocka_unit_test(rotors_are_inertias),
                                     cmocka_unit_test(loads_give_work)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
