/* Contacts and stops at rest against closed forms: a block on an incline, a cam under a flat follower, a ball in a
 * corner, a hinge at its stop; forces that hold leave no acceleration. */
#include "support/moving.h"

#include "kmech/mobility.h"
#include "kmech/statics.h"

#include <math.h>

/* Forces of two evaluations of one pose differ by rounding. */
static const double rounding = 1e-10;

/* Balance of a model's pose by actuators, NULL: all joints. */
typedef struct balance {
  km_forces *forces;
  km_statics statics;
} balance;

static balance balance_of(fixture *f, const int *actuators, int count) {
  balance b = {0};
  km_mobility mobility;
  assert_int_equal(km_mobility_compute(f->mechanism, f->state, &mobility), KM_OK);
  assert_int_equal(km_forces_create_own(f->mechanism, &b.forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(f->mechanism, actuators, count, KM_AXES_JOINT, &b.statics, NULL), KM_OK);
  assert_int_equal(km_statics_compute(f->mechanism, f->state, b.forces, &b.statics), KM_OK);
  return b;
}

static void balance_free(balance *b) {
  km_statics_free(&b->statics);
  km_forces_free(b->forces);
}

/* The joints' forces leave the pose at rest: no coordinate accelerates under them. */
static void assert_at_rest(fixture *f, const balance *b) {
  km_forces *forces = NULL;
  km_dynamics *dynamics = NULL;
  assert_int_equal(km_forces_create_own(f->mechanism, &forces, NULL), KM_OK);
  for (int i = 0; i < b->statics.actuator_count; ++i)
    assert_int_equal(
        km_forces_set_joint_force(forces, b->statics.actuators[i].coordinate, b->statics.actuator_forces[i], NULL),
        KM_OK);
  assert_int_equal(km_dynamics_create(f->mechanism, forces, &dynamics, NULL), KM_OK);
  assert_int_equal(km_dynamics_accelerate(dynamics, f->state, NULL), KM_OK);
  for (int c = 0; c < f->model->coordinate_count; ++c)
    assert_near(f->state->acceleration[c], 0.0, 1e-8);
  km_dynamics_free(dynamics);
  km_forces_free(forces);
}

/* A block of 2 kg on a plane that rises by `angle`, 10 m/s², μ = 0.4, penetration `depth`. Joints: X along the plane,
 * Y off it. */
static fixture block_on_incline(double angle, double depth) {
  const double c = cos(angle), s = sin(angle);
  km_text text = {0};
  km_text_format(
      &text,
      "{\"model_parameters\": {\"gravity\": [0, -10, 0]}, \"fixed\": {\"frames\": [{\"name\": \"f\", \"R\": [[%.17g, "
      "%.17g, 0], [%.17g, %.17g, 0], [0, 0, 1]]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"c\"}, "
      "{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": "
      "[\"fixed/f\", \"c\"]}, {\"name\": \"Y\", \"type\": \"Ty\", \"body_frame_pairs\": [\"c\", \"b\"], "
      "\"initial_displacement\": %.17g}], \"force_modules\": [{\"name\": \"floor\", \"type\": \"contact\", \"input\": "
      "{\"body_frame_pair\": [\"fixed/f\", \"b\"]}, \"contact\": {\"shape\": \"circle-line\", \"radius\": 0.1, "
      "\"stiffness\": 1e4, \"friction\": 0.4}}]}]}",
      c, -s, s, c, 0.1 - depth);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* m g sin θ holds the block without friction, m g (sin θ ± μ cos θ) are the ends of the range with it, and it holds
 * itself where tan θ < μ. */
static void friction_cone(void **state) {
  (void)state;
  const double weight = 20.0, coefficient = 0.4;
  for (int i = 0; i <= 8; ++i) {
    const double angle = 0.1 * i, normal = weight * cos(angle);
    fixture f = block_on_incline(angle, normal / 1e4);
    balance b = balance_of(&f, NULL, 0);
    const km_statics *st = &b.statics;
    assert_near(st->actuator_forces[0], weight * sin(angle), rounding * weight);
    assert_near(st->actuator_forces[1], 0.0, rounding * weight);
    assert_near(st->friction[0], coefficient * normal, rounding * weight);
    assert_near(st->friction[1], 0.0, rounding * weight);
    assert_int_equal(st->contact_count, 1);
    assert_string_equal(st->contacts[0].name, "floor");
    assert_near(st->contacts[0].normal, normal, rounding * weight);
    assert_near(st->contacts[0].friction_limit, coefficient * normal, rounding * weight);
    assert_near(st->contacts[0].penetration, normal / 1e4, 1e-15);
    assert_true((st->actuator_forces[0] - st->friction[0] <= 0.0) == (tan(angle) <= coefficient));
    assert_at_rest(&f, &b);
    balance_free(&b);
    fixture_close(&f);
  }
}

/* A gap carries nothing: the plane's joint Y bears m g cos θ. */
static void gap_carries_nothing(void **state) {
  (void)state;
  fixture f = block_on_incline(0.3, -0.01);
  balance b = balance_of(&f, NULL, 0);
  assert_near(b.statics.actuator_forces[1], 20.0 * cos(0.3), rounding);
  assert_near(b.statics.contacts[0].penetration, -0.01, 1e-15);
  assert_near(b.statics.contacts[0].normal, 0.0, 0.0);
  assert_near(b.statics.friction[0], 0.0, 0.0);
  balance_free(&b);
  fixture_close(&f);
}

/* Moves the joints other than the actuated one to rest. */
static void rest(fixture *f, int actuator) {
  km_forces *forces = NULL;
  assert_int_equal(km_forces_create_own(f->mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_equilibrium_hold(f->mechanism, f->state, forces, &actuator, 1, NULL), KM_OK);
  km_forces_free(forces);
}

/* A disc of radius R = 0.05 that turns about a point e = 0.02 from its centre lifts a follower of 3 kg with a flat
 * face. Its rest is at the height e sin a + R − δ with N = m g. Holding torque: N e cos a on the cam, ± μ N (e sin
 * a + R − δ/2) with friction; the follower needs nothing. */
static void cam_under_follower(void **state) {
  (void)state;
  static const char text[] =
      "{\"model_parameters\": {\"gravity\": [0, -10, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"cam\", \"frames\": [{\"name\": \"disc\", \"T\": [0.02, 0, 0]}]}, {\"name\": \"follower\", \"mass\": 3, \"frames\": "
      "[{\"name\": \"face\", \"R\": [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]}]}], \"joints\": [{\"name\": \"A\", \"type\": "
      "\"Rz\", \"body_frame_pairs\": [\"fixed\", \"cam\"], \"initial_displacement\": %.17g}, {\"name\": \"Y\", \"type\": "
      "\"Ty\", \"body_frame_pairs\": [\"fixed\", \"follower\"], \"initial_displacement\": %.17g}], \"force_modules\": "
      "[{\"name\": \"lift\", \"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"follower/face\", \"cam/disc\"]}, "
      "\"contact\": {\"shape\": \"circle-line\", \"radius\": 0.05, \"stiffness\": 1e5, \"exponent\": 1.5, "
      "\"reference_depth\": 0.001, \"friction\": 0.1}}]}]}";
  const double weight = 30.0, depth = 0.001 * pow(weight / (1e5 * 0.001), 2.0 / 3.0);
  for (int i = 0; i < 7; ++i) {
    const double a = 0.9 * i, height = 0.02 * sin(a) + 0.05;
    km_text model = {0};
    km_text_format(&model, text, a, height - 0.5 * depth);
    fixture f = fixture_read(model.data);
    rest(&f, 0);
    assert_near(km_state_coordinate(f.state, 0), a, 1e-15);
    assert_near(km_state_coordinate(f.state, 1), height - depth, 1e-10);
    balance b = balance_of(&f, NULL, 0);
    const km_statics *st = &b.statics;
    assert_near(st->contacts[0].normal, weight, 1e-6 * weight);
    assert_near(st->actuator_forces[0], weight * 0.02 * cos(a), 1e-6 * weight);
    assert_near(st->actuator_forces[1], 0.0, 1e-6 * weight);
    assert_near(st->friction[0], 0.1 * weight * (height - 0.5 * depth), 1e-6 * weight);
    balance_free(&b);
    fixture_close(&f);
    km_text_free(&model);
  }
}

/* A ball on three slides touches a floor z = 0 (μ = 0.5) and a wall x = 0 (μ = 0.2), which push with 100 N and 40 N.
 * Friction of the floor counts in x and y, that of the wall in y and z, whatever the tangents are. */
static void ball_in_a_corner(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"fixed\": {\"frames\": [{\"name\": \"wall\", \"R\": [[0, 0, 1], [1, 0, 0], [0, 1, 0]]}]}, \"assemblies\": "
      "[{\"name\": \"a\", \"bodies\": [{\"name\": \"p\"}, {\"name\": \"q\"}, {\"name\": \"b\", \"mass\": 1}], \"joints\": "
      "[{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"p\"], \"initial_displacement\": 0.096}, "
      "{\"name\": \"Y\", \"type\": \"Ty\", \"body_frame_pairs\": [\"p\", \"q\"]}, {\"name\": \"Z\", \"type\": \"Tz\", "
      "\"body_frame_pairs\": [\"q\", \"b\"], \"initial_displacement\": 0.09}], \"force_modules\": [{\"name\": \"floor\", "
      "\"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"fixed\", \"b\"]}, \"contact\": {\"shape\": "
      "\"point-plane\", \"radius\": 0.1, \"stiffness\": 1e4, \"friction\": 0.5}}, {\"name\": \"side\", \"type\": "
      "\"contact\", \"input\": {\"body_frame_pair\": [\"fixed/wall\", \"b\"]}, \"contact\": {\"shape\": \"point-plane\", "
      "\"radius\": 0.1, \"stiffness\": 1e4, \"friction\": 0.2}}]}]}");
  balance b = balance_of(&f, NULL, 0);
  static const double forces[] = {-40.0, 0.0, -100.0}, friction[] = {50.0, 58.0, 8.0};
  for (int i = 0; i < 3; ++i) {
    assert_near(b.statics.actuator_forces[i], forces[i], 1e-9);
    assert_near(b.statics.friction[i], friction[i], 1e-9);
  }
  balance_free(&b);
  /* An actuator of Z alone bears neither the wall's push nor its friction along y. */
  const int z = 2;
  b = balance_of(&f, &z, 1);
  assert_false(b.statics.held);
  assert_true(isnan(b.statics.friction[0]) || b.statics.friction[0] >= 8.0 - 1e-9);
  balance_free(&b);
  fixture_close(&f);
}

/* A pendulum 0.05 rad beyond its limit is pushed back by k x; the rate that the state has doesn't count. */
static void stop_of_a_hinge(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, -10, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"b\", \"mass\": 2, \"center_of_mass\": [0.5, 0, 0]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", "
      "\"body_frame_pairs\": [\"fixed\", \"b\"], \"limits\": [-0.3, 1], \"stop\": {\"stiffness\": 80, \"damping\": 7}, "
      "\"initial_displacement\": -0.35, \"initial_velocity\": 1}]}]}");
  f.state->rate[0] = 1.0;
  balance b = balance_of(&f, NULL, 0);
  assert_near(b.statics.actuator_forces[0], 10.0 * cos(0.35) - 80.0 * 0.05, rounding);
  assert_int_equal(b.statics.contact_count, 1);
  assert_int_equal(b.statics.contacts[0].coordinate, 0);
  assert_near(b.statics.contacts[0].normal, 4.0, rounding);
  assert_near(b.statics.contacts[0].penetration, 0.05, rounding);
  f.state->rate[0] = 0.0;
  assert_at_rest(&f, &b);
  balance_free(&b);
  fixture_close(&f);
}

/* An excavator hangs from its stick's drive: with two cylinders held, all loops come to rest, and the two hold then. No
 * pose near a block that nothing carries is a rest. */
static void loops_come_to_rest(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  int held[2];
  km_forces *forces = NULL;
  km_error error;
  assert_int_equal(km_model_find_coordinate(f.model, "M", &held[0], NULL), KM_OK);
  assert_int_equal(km_model_find_coordinate(f.model, "O", &held[1], NULL), KM_OK);
  const double before[2] = {km_state_coordinate(f.state, held[0]), km_state_coordinate(f.state, held[1])};
  assert_int_equal(km_forces_create_own(f.mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_equilibrium_hold(f.mechanism, f.state, forces, held, 2, NULL), KM_OK);
  for (int i = 0; i < 2; ++i)
    assert_near(km_state_coordinate(f.state, held[i]), before[i], 1e-12);
  balance b = balance_of(&f, held, 2);
  assert_true(b.statics.held);
  balance_free(&b);
  km_forces_free(forces);
  fixture_close(&f);
  f = block_on_incline(0.3, -0.01);
  held[0] = 1;
  assert_int_equal(km_forces_create_own(f.mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_equilibrium_hold(f.mechanism, f.state, forces, held, 1, &error), KM_NO_RESULT);
  km_forces_free(forces);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(friction_cone),    cmocka_unit_test(gap_carries_nothing), cmocka_unit_test(cam_under_follower),
      cmocka_unit_test(ball_in_a_corner), cmocka_unit_test(stop_of_a_hinge),     cmocka_unit_test(loops_come_to_rest),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
