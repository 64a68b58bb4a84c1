/* Friction of surfaces that slide in several directions, and laws that bring something to rest, against closed
 * forms. */
#include "support/support.h"

#include "kmech/dynamics.h"
#include "kmech/transfer.h"

#include <math.h>
#include <stdio.h>

static km_history run(const char *text, double until, double tolerance) {
  fixture f = fixture_read(text);
  km_forces *forces;
  km_history out;
  km_history_def def = km_history_default(f.model);
  def.until = until;
  def.simulation.relative = def.simulation.absolute = tolerance;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f.mechanism, forces, f.state, &def, &out, NULL), KM_OK);
  km_forces_free(forces);
  fixture_close(&f);
  return out;
}

static double at_end(const km_history *h, const char *column) {
  int found = km_table_find(h->table, column);
  assert_true(found >= 0);
  return km_table_row(h->table, km_table_rows(h->table) - 1)[found];
}

/* A block on a plane slows down by μ g against its way, whatever way that is, and keeps its direction. */
static void test_plane(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i) {
    char text[700];
    const double angle = 0.3 + i * M_PI / 4.0;
    snprintf(
        text, sizeof text,
        "{\"model_parameters\": {\"gravity\": [0, 0, -10]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", "
        "\"mass\": 2, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 1}}], \"joints\": [{\"name\": \"P\", \"type\": "
        "\"planar\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": [%.17g, %.17g, 0], \"friction\": "
        "{\"coefficient\": 0.1, \"stiction_velocity\": 1e-6}}]}]}",
        2.0 * cos(angle), 2.0 * sin(angle));
    km_history h = run(text, 1.0, 1e-10);
    assert_near(at_end(&h, "v.P[0]"), cos(angle), 1e-7);
    assert_near(at_end(&h, "v.P[1]"), sin(angle), 1e-7);
    km_history_free(&h);
  }
}

/* A sleeve that turns fast and slides slowly: both rates die at once, along one helix, at μ g of the speed of its
 * surface; a body whose radius of gyration is that of the surface slows down as one mass. */
static void test_sleeve(void **state) {
  (void)state;
  km_history h = run(
      "{\"model_parameters\": {\"gravity\": [0, -10, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"b\", \"mass\": 2, \"moment_of_inertia\": {\"Ixx\": 0.18, \"Iyy\": 0.18, \"Izz\": 0.18}}], \"joints\": "
      "[{\"name\": \"C\", \"type\": \"cylindrical\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": "
      "[0.4, 10], \"friction\": {\"coefficient\": 0.1, \"radius\": 0.3, \"stiction_velocity\": 1e-6}}]}]}",
      1.0, 1e-10);
  const double speed = hypot(0.4, 3.0), share = (speed - 1.0) / speed;
  assert_near(at_end(&h, "v.C[0]"), 0.4 * share, 1e-7);
  assert_near(at_end(&h, "v.C[1]"), 10.0 * share, 1e-6);
  km_history_free(&h);
}

/* The ratio of a wedge of 30° on a rough plane is tan 30° − μ however the plane's axes lie. */
static void test_wedge(void **state) {
  (void)state;
  const double slope = M_PI / 6.0;
  for (int i = 0; i < 6; ++i) {
    char text[2000], turned[200], incline[200];
    const double angle = 0.4 * i;
    snprintf(turned, sizeof turned, "[[%.17g, %.17g, 0], [%.17g, %.17g, 0], [0, 0, 1]]", cos(angle), -sin(angle),
             sin(angle), cos(angle));
    snprintf(incline, sizeof incline, "[[0, %.17g, %.17g], [1, 0, 0], [0, %.17g, %.17g]]", -sin(slope), cos(slope),
             cos(slope), sin(slope));
    snprintf(
        text, sizeof text,
        "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"R\": %s}]}, \"assemblies\": [{\"name\": \"k\", \"bodies\": [{\"name\": "
        "\"wedge\", \"frames\": [{\"name\": \"p\", \"R\": %s}, {\"name\": \"i\", \"R\": %s}, {\"name\": \"o\"}]}, {\"name\": "
        "\"ram\", \"frames\": [{\"name\": \"i\", \"R\": %s}]}], \"joints\": [{\"name\": \"P\", \"type\": \"planar\", "
        "\"body_frame_pairs\": [[\"fixed\", \"p\"], [\"wedge\", \"p\"]], \"friction\": {\"coefficient\": 0.45}}, {\"name\": "
        "\"I\", \"type\": \"Tz\", \"body_frame_pairs\": [[\"wedge\", \"i\"], [\"ram\", \"i\"]]}, {\"name\": \"V\", \"type\": "
        "\"Tz\", \"body_frame_pairs\": [\"fixed\", \"ram\"]}]}]}",
        turned, turned, incline, incline);
    fixture f = fixture_read(text);
    int frame, c = f.model->coordinate_count - 1;
    assert_int_equal(km_model_find_frame(f.model, (const char *const[]){"wedge", "o"}, 2, &frame, NULL), KM_OK);
    const km_port in = {.kind = KM_PORT_JOINT, .coordinate = c, .name = "in"},
                  out = {
                      .kind = KM_PORT_POINT, .frame = frame, .direction = {1, 0, 0}, .coordinate = -1, .name = "out"};
    km_losses_workspace *work;
    km_losses losses;
    km_mobility mobility;
    assert_int_equal(km_losses_create(f.mechanism, &in, &out, &work, NULL), KM_OK);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(km_losses_compute(f.mechanism, f.state, work, &losses), KM_OK);
    assert_near(fabs(losses.ratio), tan(slope) - 0.45, 1e-12);
    km_losses_free(work);
    fixture_close(&f);
  }
}

/* A brake whose law jumps at rest: 0.3 stop a flywheel of 0.02 at 5 1/s after 1/3 s, and it stays there. */
static void test_brake(void **state) {
  (void)state;
  km_history h = run(
      "{\"model_parameters\": {\"gravity\": [0, 0, 0]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"d\", "
      "\"moment_of_inertia\": {\"Izz\": 0.02}}], \"joints\": [{\"name\": \"C\", \"type\": \"Rz\", "
      "\"body_frame_pairs\": [\"fixed\", \"d\"], \"initial_velocity\": 5}], \"force_modules\": [{\"name\": \"b\", "
      "\"type\": \"friction\", \"input\": {\"type\": \"joint\", \"joint\": \"C\"}, \"knot_points\": [0], "
      "\"coefficients\": [[0.3], [-0.3]]}]}]}",
      20.0, 1e-6);
  assert_near(at_end(&h, "v.C"), 0.0, 1e-6);
  assert_near(at_end(&h, "q.C"), 0.5 * 5.0 * 5.0 * 0.02 / 0.3,
              1e-4); /* the sticking rate times the time that it takes */
  assert_near(at_end(&h, "energy_dissipated"), 0.25, 1e-5);
  assert_at_most((double)h.figures.evaluations, 5000.0);
  km_history_free(&h);
}

/* Friction whose law is steep at rest, without a jump: a block at rest stays there, and one at 1 m/s is braked by 5
 * N and stops after 0.1 m; its last 1e-4 m/s, where the force goes down with the rate, add 1e-9 m. */
static void test_steep_law(void **state) {
  (void)state;
  static const char model[] =
      "{\"model_parameters\": {\"gravity\": [0, 0, 0]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"b\", "
      "\"mass\": 1}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], "
      "\"initial_velocity\": %g}], \"force_modules\": [{\"name\": \"f\", \"type\": \"friction\", \"input\": {\"type\": "
      "\"joint\", \"joint\": \"X\"}, \"knot_points\": [-1e-4, 1e-4], \"coefficients\": [[5], [0, -5e4], [-5]]}]}]}";
  for (int i = 0; i < 2; ++i) {
    char text[700];
    snprintf(text, sizeof text, model, (double)i);
    km_history h = run(text, 1.0, 1e-8);
    assert_near(at_end(&h, "v.X"), 0.0, 1e-8);
    assert_near(at_end(&h, "q.X"), i * 0.1, 1e-7);
    assert_at_most((double)h.figures.evaluations, 5000.0);
    km_history_free(&h);
  }
}

/* A block that sticks on a slope creeps as slowly in milliseconds as in seconds. */
static void test_stiction_in_units(void **state) {
  (void)state;
  double slid[2];
  for (int i = 0; i < 2; ++i) {
    char text[700];
    snprintf(
        text, sizeof text,
        "{\"model_parameters\": {\"gravity\": [%.17g, 0, %.17g], \"units\": {\"time\": \"%s\"}}, \"assemblies\": [{\"name\": "
        "\"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", "
        "\"body_frame_pairs\": [\"fixed\", \"b\"], \"friction\": {\"coefficient\": 0.5}}]}]}",
        i ? 3.4e-6 : 3.4, i ? -9.2e-6 : -9.2, i ? "ms" : "s");
    km_history h = run(text, i ? 1e4 : 10.0, 1e-10);
    slid[i] = at_end(&h, "q.X");
    km_history_free(&h);
  }
  assert_true(slid[0] > 0.0 && slid[0] < 1e-2);
  assert_near(slid[1], slid[0], 1e-6 * slid[0]);
}

/* A torque about an axis doesn't turn a ball by that component of its rotation vector alone. */
static void test_stop_of_a_component(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": "
      "1, \"Izz\": 1}}], \"joints\": [{\"name\": \"B\", \"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"limits\": "
      "[[-1, 1], [-1, 1], [-1, 1]], \"stop\": {\"stiffness\": 10}}]}]}");
  km_forces *forces;
  km_error error = {.text = ""};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, &error), KM_MODEL);
  assert_string_equal(error.text, "joint B[0]: a stop of one component of a ball; expected one range of its angle");
  assert_null(forces);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_plane),
                                     cmocka_unit_test(test_sleeve),
                                     cmocka_unit_test(test_wedge),
                                     cmocka_unit_test(test_brake),
                                     cmocka_unit_test(test_steep_law),
                                     cmocka_unit_test(test_stiction_in_units),
                                     cmocka_unit_test(test_stop_of_a_component)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
