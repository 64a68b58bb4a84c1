/* A force at a point as actuator: the same force as a load leaves nothing for the joints to hold, reactions
 * included, and its power is that of a joint that would hold instead. */
#include "support/support.h"

#include "forces/forces.h"
#include "kmech/statics.h"

#include <math.h>
#include <string.h>

/* The balance of some actuators under gravity and loads, at the fixture's pose. */
static km_statics balance(fixture *f, const km_port *actuators, int count, const km_load *loads, int load_count) {
  static const double gravity[3] = {0.3, -9.81, 0.0};
  km_statics statics;
  km_forces *forces;
  km_mobility mobility;
  km_error error;
  if (km_forces_create(f->mechanism, gravity, loads, load_count, &forces, &error) ||
      km_statics_create_for(f->mechanism, actuators, count, KM_AXES_JOINT, &statics, &error))
    fail_msg("%s", error.text);
  km_mobility_compute(f->mechanism, f->state, &mobility);
  km_statics_compute(f->mechanism, f->state, forces, &statics);
  km_forces_free(forces);
  return statics;
}

/* A frame of a body that moves, and a direction in the plane of planar models. */
static km_port some_point(const fixture *f, randomness *r) {
  km_port point = {.kind = KM_PORT_POINT, .coordinate = -1, .name = "hand"};
  double turn = uniform(r, -M_PI, M_PI);
  point.direction[0] = cos(turn);
  point.direction[1] = sin(turn);
  for (bool moves = false; !moves;) {
    km_statics statics;
    point.frame = below(r, f->model->frame_count);
    moves = km_statics_create_for(f->mechanism, &point, 1, KM_AXES_JOINT, &statics, NULL) == KM_OK;
    km_statics_free(&statics);
  }
  return point;
}

static void check_push(fixture *f, int driver, randomness *r) {
  const km_port point = some_point(f, r), joint = {.kind = KM_PORT_JOINT, .coordinate = driver, .name = "driver"};
  km_load own[8];
  int loads = km_model_load_count(f->model);
  for (int i = 0; i < loads; ++i)
    own[i] = km_model_load_at(f->model, i);
  km_statics pushed = balance(f, &point, 1, own, loads), driven = balance(f, &joint, 1, own, loads);
  double largest = 0.0, force = pushed.actuator_forces[0];
  for (int c = 0; c < f->model->coordinate_count; ++c)
    largest = fmax(largest, fabs(driven.least_norm[c]));
  /* A point that hardly moves in its direction needs a force whose digits are its own. */
  if (pushed.held && driven.held && fabs(force) < 1e3 * (1.0 + largest)) {
    km_load hand = {.frame = point.frame};
    for (int k = 0; k < 3; ++k)
      hand.force[k] = force * point.direction[k];
    own[loads] = hand;
    km_statics rest = balance(f, &joint, 1, own, loads + 1);
    double size = 1.0 + largest + fabs(force);
    assert_near(rest.actuator_forces[0], 0.0, 1e-8 * size);
    for (int j = 0; j < f->model->joint_count; ++j)
      for (int k = 0; k < 3; ++k) {
        assert_near(pushed.reactions[j].force[k], rest.reactions[j].force[k], 1e-7 * size);
        assert_near(pushed.reactions[j].torque[k], rest.reactions[j].torque[k], 1e-7 * size);
      }
    km_statics_free(&rest);
  }
  km_statics_free(&pushed);
  km_statics_free(&driven);
}

/* Every body of these moves with one substructure. */
static void test_loops(void **unused) {
  (void)unused;
  static const char *const names[] = {"fourbar", "slider_crank", "brake", "klann", "jansen", "toggle_press", "bonnet"};
  randomness r = {41};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
    for (int n = 0; n < 12; ++n) {
      fixture f = fixture_open(names[i]);
      for (int b = 1; b < f.model->body_count; ++b)
        f.model->bodies[b].mass = 1.0 + 0.1 * b; /* some models have none */
      go_somewhere(&f, &r);
      check_push(&f, f.model->sweep.coordinate, &r);
      fixture_close(&f);
    }
}

/* A lever of length 2 with a weight of 3 · 9.81 at 1.5: the hand at its end holds 0.75 of it, downwards a negative
 * force. */
static void test_lever(void **unused) {
  (void)unused;
  fixture f = fixture_read("{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"lever\", \"mass\": 3, "
                           "\"center_of_mass\": [1.5, 0, 0], \"frames\": [{\"name\": \"end\", \"T\": [2, 0, 0]}]}], "
                           "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", "
                           "\"lever\"]}]}]}");
  int frame;
  km_error error;
  const char *const path[] = {"lever", "end"};
  assert_int_equal(km_model_find_frame(f.model, path, 2, &frame, &error), KM_OK);
  for (int sign = -1; sign <= 1; sign += 2) {
    const km_port up = {.kind = KM_PORT_POINT, .frame = frame, .direction = {0, sign, 0}, .name = "end"};
    km_statics held = balance(&f, &up, 1, NULL, 0);
    assert_true(held.held);
    assert_near(held.actuator_forces[0], sign * 0.75 * 3 * 9.81, 1e-12 * 30);
    assert_near(held.reactions[0].force[1], 0.25 * 3 * 9.81, 1e-12 * 30);
    km_statics_free(&held);
  }
  const km_port along = {.kind = KM_PORT_POINT, .frame = frame, .direction = {1, 0, 0}, .name = "end"};
  km_statics falls = balance(&f, &along, 1, NULL, 0); /* the end stands still in this direction */
  assert_false(falls.held);
  assert_true(isnan(falls.actuator_forces[0]));
  km_statics_free(&falls);
  fixture_close(&f);
}

static void test_refusals(void **unused) {
  (void)unused;
  fixture f = fixture_open("excavator");
  km_statics statics;
  km_error error;
  int frame;
  const char *const path[] = {"bucket", "tip"};
  assert_int_equal(km_model_find_frame(f.model, path, 2, &frame, &error), KM_OK);
  km_port tip = {.kind = KM_PORT_POINT, .direction = {0, 0, 1}, .name = "bucket/tip"};
  tip.frame = 0; /* point of the inertial frame */
  assert_int_equal(km_statics_create_for(f.mechanism, &tip, 1, KM_AXES_JOINT, &statics, &error), KM_USAGE);
  km_statics_free(&statics);
  tip = (km_port){.kind = KM_PORT_POINT, .frame = frame, .direction = {0, 0, 2}, .name = "bucket/tip"};
  assert_int_equal(km_statics_create_for(f.mechanism, &tip, 1, KM_AXES_JOINT, &statics, &error), KM_USAGE);
  km_statics_free(&statics);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_loops),
      cmocka_unit_test(test_lever),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
