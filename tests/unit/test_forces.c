/* Springs of every kind against differences of their displacement, and force laws piece by piece. */
#include "support/support.h"

#include "forces/forces.h"
#include "kmech/statics.h"

#include <math.h>
#include <stdio.h>

static void pieces_of_a_law(void **state) {
  (void)state;
  const double knots[2] = {-1.0, 2.0}, coefficients[6] = {3.0, 1.0, -2.0, 0.5, 7.0, 4.0};
  const int start[4] = {0, 1, 4, 6};
  const km_law law = {2, knots, start, coefficients};
  assert_near(km_law_force(&law, -5.0), 3.0, 0.0);
  assert_near(km_law_force(&law, 1.0), 1.0 - 2.0 + 0.5, 1e-15);
  assert_near(km_law_force(&law, 3.0), 7.0 + 12.0, 1e-15);
  const km_law plain = {0, NULL, (const int[]){0, 2}, (const double[]){0.0, -4.0}};
  assert_near(km_law_force(&plain, 0.5), -2.0, 1e-15);
}

/* Only jumps are spread: a law that is whole at its knots stays as it is, however near to each other they lie. A
 * jump of −2 at 0.3 is spread over 0.1 to either side, or over half the way to the next knot. */
static void jumps_of_a_law_are_spread(void **state) {
  (void)state;
  const double near[2] = {-1e-4, 1e-4}, friction[4] = {5.0, 0.0, -5e4, -5.0};
  const km_law whole = {2, near, (const int[]){0, 1, 3, 4}, friction};
  for (double rate = -3e-4; rate < 3e-4; rate += 1e-5)
    assert_near(km_law_resistance(&whole, rate, 1e-3), km_law_force(&whole, rate), 1e-14);
  const double knot = 0.3, steps[2] = {1.0, -1.0};
  const km_law one = {1, &knot, (const int[]){0, 1, 2}, steps};
  assert_near(km_law_resistance(&one, 0.3, 0.1), 0.0, 1e-15);
  assert_near(km_law_resistance(&one, 0.35, 0.1), -0.75, 1e-15);
  assert_near(km_law_resistance(&one, 0.25, 0.1), 0.75, 1e-15);
  assert_near(km_law_resistance(&one, 0.2, 0.1), 1.0, 0.0);
  const double pair[2] = {0.3, 0.4}, stairs[3] = {1.0, -1.0, -2.0};
  const km_law two = {2, pair, (const int[]){0, 1, 2, 3}, stairs};
  assert_near(km_law_resistance(&two, 0.325, 0.1), -0.75, 1e-14);
  assert_near(km_law_resistance(&two, 0.35, 0.1), -1.0, 1e-14);
  assert_near(km_law_resistance(&two, 0.4, 0.1), -1.5, 1e-14);
}

/* An arm of three joints in space with one spring: %s are its input, the rest of its module. */
static const char arm[] =
    "{\"fixed\": {\"frames\": [{\"name\": \"wall\", \"T\": [0.3, -0.4, 0.2], \"R\": [[0, -1, 0], [1, 0, 0], [0, 0, "
    "1]]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": ["
    "{\"name\": \"one\", \"frames\": [{\"name\": \"end\", \"T\": [1, 0, 0.1]}, {\"name\": \"eye\", \"T\": [0.4, 0.2, "
    "0]}]},"
    "{\"name\": \"two\", \"frames\": [{\"name\": \"end\", \"T\": [0.7, 0, 0]}]},"
    "{\"name\": \"three\", \"frames\": [{\"name\": \"hook\", \"T\": [0.3, 0.1, 0.5]}]}],"
    "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"one\"], "
    "\"initial_displacement\": 0.3},"
    "{\"name\": \"B\", \"type\": \"Ry\", \"body_frame_pairs\": [\"two\", [\"one\", \"end\"]], "
    "\"initial_displacement\": "
    "0.7},"
    "{\"name\": \"C\", \"type\": \"Tx\", \"body_frame_pairs\": [[\"two\", \"end\"], \"three\"], "
    "\"initial_displacement\": 0.4}],"
    "\"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"knot_points\": [0.5], \"coefficients\": [[1, "
    "-2], "
    "[3, 0.5, -1]], %s}]}]}";

static double force_at(double x) {
  return x < 0.5 ? 1.0 - 2.0 * x : 3.0 + 0.5 * x - x * x;
}

/* The displacement of a port between frames, from the frames' positions alone. */
static double displacement(const fixture *f, const km_module_port *port, const char *distance) {
  if (port->coordinate >= 0)
    return f->state->q[port->coordinate];
  km_poses_compute(f->mechanism, f->state);
  double a[3], b[3];
  km_frame_position(f->mechanism, f->state, port->frame[0], a);
  km_frame_position(f->mechanism, f->state, port->frame[1], b);
  km_vec3 way = km_vec3_sub(km_vec3_from_array(b), km_vec3_from_array(a));
  if (distance[0] == 'e')
    return km_vec3_norm(way);
  const km_model_frame *frame = &f->model->frames[port->frame[0]];
  km_pose X = km_pose_product(&f->state->pose[frame->body], &frame->pose);
  return km_vec3_dot(X.R.axis[distance[1] - 'x'], way);
}

/* τ_c = force(input) · ∂(output)/∂q_c by central differences, which err by h² = 1e-10. */
static void springs_push_along_their_displacement(void **state) {
  (void)state;
  static const struct {
    const char *ports, *distance;
  } cases[] = {
      {"\"input\": {\"type\": \"joint\", \"joint\": \"B\"}", "euclid"},
      {"\"input\": {\"type\": \"joint\", \"joint\": \"C\"}", "euclid"},
      {"\"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"fixed\", \"wall\"], [\"three\", \"hook\"]]}",
       "euclid"},
      {"\"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"one\", \"eye\"], [\"three\", \"hook\"]]}", "Tx"},
      {"\"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"three\", \"hook\"], [\"one\", \"eye\"]]}", "Ty"},
      {"\"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"fixed\", \"wall\"], [\"three\", \"hook\"]]}", "Tz"},
      {"\"input\": {\"type\": \"joint\", \"joint\": \"A\"}, \"output\": {\"type\": \"frame\", \"body_frame_pair\": "
       "[[\"one\", \"eye\"], [\"three\", \"hook\"]]}",
       "euclid"},
      {"\"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"one\", \"eye\"], [\"three\", \"hook\"]]}, "
       "\"output\": "
       "{\"type\": \"joint\", \"joint\": \"A\"}",
       "euclid"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    char ports[600], text[4096];
    snprintf(ports, sizeof ports, "\"distance_type\": \"%s\", %s", cases[i].distance, cases[i].ports);
    snprintf(text, sizeof text, arm, ports);
    fixture f = fixture_read(text);
    km_forces *forces;
    km_statics statics;
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
    assert_int_equal(km_statics_create(f.mechanism, NULL, 0, KM_AXES_JOINT, &statics, NULL), KM_OK);
    km_statics_compute(f.mechanism, f.state, forces, &statics);
    const km_model_module *module = &f.model->modules[0];
    double force = force_at(displacement(&f, &module->input, cases[i].distance));
    for (int c = 0; c < 3; ++c) {
      double q = f.state->q[c], h = 1e-5, there[2];
      for (int k = 0; k < 2; ++k) {
        f.state->q[c] = q + (k ? h : -h);
        there[k] = displacement(&f, &module->output, cases[i].distance);
      }
      f.state->q[c] = q;
      assert_near(-statics.least_norm[c], force * (there[1] - there[0]) / (2.0 * h), 1e-8);
    }
    km_statics_free(&statics);
    km_forces_free(forces);
    fixture_close(&f);
  }
}

/* Computed by hand: a load along the frame's axes rotates with it; both act at the frame's origin. */
static void loads_act_at_their_frames(void **state) {
  (void)state;
  char text[4096];
  snprintf(text, sizeof text, arm, "\"input\": {\"type\": \"joint\", \"joint\": \"B\"}");
  fixture f = fixture_read(text);
  static const char *const path[2] = {"one", "eye"};
  km_load load = {0, {2.0, 0.0, 0.0}, {0.0, 0.0, 0.5}, false, NULL};
  assert_int_equal(km_model_find_frame(f.model, path, 2, &load.frame, NULL), KM_OK);
  double c = cos(0.3), s = sin(0.3), x = 0.4 * c - 0.2 * s, y = 0.4 * s + 0.2 * c;
  for (int turning = 0; turning < 2; ++turning) {
    km_forces *forces;
    double w[6];
    load.turning = turning;
    assert_int_equal(km_forces_create(f.mechanism, NULL, &load, 1, &forces, NULL), KM_OK);
    km_forces_compute(f.mechanism, f.state, forces);
    km_forces_on_body(forces, f.model->frames[load.frame].body, w);
    double fx = turning ? 2.0 * c : 2.0, fy = turning ? 2.0 * s : 0.0;
    const double expected[6] = {fx, fy, 0.0, 0.0, 0.0, 0.5 + x * fy - y * fx};
    for (int k = 0; k < 6; ++k)
      assert_near(w[k], expected[k], 1e-14);
    km_forces_free(forces);
  }
  fixture_close(&f);
}

/* Points that a mechanism brings together have no line between them, whatever rounding leaves of their distance. */
static void points_in_one_place_have_no_direction(void **state) {
  (void)state;
  for (int i = 0; i < 20; ++i) {
    char text[1200];
    snprintf(
        text, sizeof text,
        "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [0.3, 0.7, 0]}]}, \"assemblies\": [{\"name\": \"a\", "
        "\"bodies\": [{\"name\": \"one\", \"frames\": [{\"name\": \"c\", \"T\": [0.1, 0.2, 0]}, {\"name\": \"t\", \"T\": "
        "[1.1, 0.2, 0]}]}, {\"name\": \"two\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}], \"joints\": "
        "[{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], [\"one\", \"c\"]], "
        "\"initial_displacement\": %.2f}, {\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"one\", \"t\"], "
        "\"two\"], \"initial_displacement\": 3.141592653589793}], \"force_modules\": [{\"name\": \"s\", \"type\": "
        "\"stiffness\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"fixed\", \"p\"], [\"two\", \"t\"]]}, "
        "\"coefficients\": [[100]]}]}]}",
        0.1 * i);
    fixture f = fixture_read(text);
    km_forces *forces;
    double wrench[6];
    assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
    km_poses_compute(f.mechanism, f.state);
    km_forces_compute(f.mechanism, f.state, forces);
    km_forces_on_body(forces, 2, wrench);
    for (int k = 0; k < 6; ++k)
      assert_near(wrench[k], 0.0, 0.0);
    km_forces_free(forces);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(pieces_of_a_law), cmocka_unit_test(jumps_of_a_law_are_spread),
                                     cmocka_unit_test(springs_push_along_their_displacement),
                                     cmocka_unit_test(points_in_one_place_have_no_direction),
                                     cmocka_unit_test(loads_act_at_their_frames)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
