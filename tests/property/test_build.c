/* Models by calls: every shipped model, made again by calls, gives the file's tables byte for byte; wrong definitions
 * are refused and leave the builder as it was. */
#include "support/rebuild.h"
#include "support/support.h"

#include "kmech/report.h"
#include "kmech/sweep.h"
#include "model/model.h"

#include <math.h>
#include <string.h>

/* The tables of all sweeps that the model has defaults for, one after the other. */
static char *tables_of(fixture *f) {
  km_sweep_plan plan = km_sweep_plan_default(f->model);
  km_text out = {0};
  km_error error;
  plan.steps = 12;
  if (plan.coordinate >= 0 || plan.arclength > 0.0) {
    km_mobility_sweep sweep;
    km_mobility_sweep_run(f->mechanism, f->state, &plan, &sweep, &error);
    km_csv_write(sweep.motion.table, &out);
    km_mobility_sweep_free(&sweep);
    km_forces *forces;
    km_statics statics;
    km_statics_sweep held;
    assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, &error), KM_OK);
    assert_int_equal(km_statics_create(f->mechanism, NULL, 0, KM_AXES_JOINT, &statics, &error), KM_OK);
    km_statics_sweep_run(f->mechanism, f->state, &plan, forces, &statics, &held, &error);
    km_csv_write(held.motion.table, &out);
    km_statics_sweep_free(&held);
    km_statics_free(&statics);
    km_forces_free(forces);
  }
  km_mobility mobility;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  for (int c = 0; c < f->model->coordinate_count; ++c)
    km_text_format(&out, "%s %.17g %.17g\n", f->model->coordinates[c].label, f->state->q[c],
                   f->state->mobility_number[c]);
  return out.data;
}

static void the_same_tables(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    fixture read = fixture_open(*name);
    fixture built = fixture_of(rebuild(read.model));
    char *a = tables_of(&read), *b = tables_of(&built);
    if (strcmp(a, b) != 0)
      print_error("%s\n", *name);
    assert_string_equal(a, b);
    km_free(a);
    km_free(b);
    fixture_close(&built);
    fixture_close(&read);
  }
}

/* A hinge from the ground to one body, and what can be wrong with more. */
typedef struct start {
  km_builder *b;
  km_body_id body;
  km_frame_id origin, ground;
  km_joint_id joint;
} start;

static start begin(void) {
  start s = {0};
  km_body_def body = km_body_default();
  km_joint_def joint = km_joint_default();
  assert_int_equal(km_builder_create(&s.b, NULL), KM_OK);
  body.name = "arm";
  assert_int_equal(km_model_add_body(s.b, &body, &s.body, NULL), KM_OK);
  s.origin = km_builder_origin(s.b, s.body);
  s.ground = km_builder_origin(s.b, km_builder_fixed(s.b));
  joint.name = "A";
  joint.parent = s.ground;
  joint.child = s.origin;
  assert_int_equal(km_model_add_joint(s.b, &joint, &s.joint, NULL), KM_OK);
  return s;
}

static void refuse(km_status status, const km_error *error, const char *words) {
  assert_int_equal(status, KM_MODEL);
  if (!strstr(error->text, words))
    fail_msg("\"%s\" doesn't say \"%s\"", error->text, words);
}

static void wrong_bodies_and_frames(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  km_body_def body = km_body_default();
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "empty name");
  body.name = "fixed";
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "reserved");
  body.name = "arm";
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "used twice");
  body.name = "heavy";
  body.mass = -1.0;
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "expected at least 0");
  body.mass = (double)NAN;
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "not finite");
  body.mass = 1.0;
  body.density = 2.0;
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "mesh");
  km_frame_def frame = km_frame_default();
  frame.name = "origin";
  refuse(km_model_add_frame(s.b, s.body, &frame, NULL, &e), &e, "reserved");
  frame.name = "tip";
  refuse(km_model_add_frame(s.b, (km_body_id){0}, &frame, NULL, &e), &e, "no body");
  refuse(km_model_add_frame(s.b, (km_body_id){99999999}, &frame, NULL, &e), &e, "no body");
  frame.R[0] = 0.9;
  refuse(km_model_add_frame(s.b, s.body, &frame, NULL, &e), &e, "not a rotation");
  frame.R[0] = -1.0;
  refuse(km_model_add_frame(s.b, s.body, &frame, NULL, &e), &e, "mirrored");
  km_builder_free(s.b);
}

static void wrong_joints(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  km_joint_def joint = km_joint_default();
  joint.name = "B";
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "no frame");
  joint.parent = s.origin;
  joint.child = (km_frame_id){12345};
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "no frame has");
  joint.child = s.origin;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "both ends");
  joint.child = s.ground;
  joint.low[0] = 2.0;
  joint.high[0] = 1.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "low");
  joint.low[0] = 0.0;
  joint.pitch = 1.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "only on a screw");
  joint.pitch = 0.0;
  joint.law = KM_MOTION_TABLE;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "not complete");
  const double back[4] = {0.0, 0.0, 0.0, 1.0};
  joint.law_count = 2;
  joint.law_values = back;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "doesn't come after");
  joint.type = KM_UNIVERSAL;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "a prescribed motion of 2 coordinates");
  joint.law = KM_MOTION_FREE;
  joint.type = KM_JOINT_TYPES;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "type");
  joint.type = KM_RZ;
  joint.name = "A";
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "used twice");
  km_builder_free(s.b);
}

static void wrong_numbers_of_joints(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  km_joint_def right = km_joint_default();
  right.name = "B";
  right.parent = s.ground;
  right.child = s.origin;
  km_joint_def joint = right;
  joint.position[0] = (double)NAN;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "found a number that is not finite");
  joint = right;
  joint.stop_damping = -1.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "found a friction or stop of -1; expected at least 0");
  joint = right;
  joint.most_turn = 2.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "found 2 as the largest turn");
  joint = right;
  joint.max_rate[0] = 0.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "found a largest rate of 0");
  joint = right;
  joint.armature[0] = -3.0;
  refuse(km_model_add_joint(s.b, &joint, NULL, &e), &e, "found an armature of -3");
  km_builder_free(s.b);
}

static void wrong_laws(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  const double back[2] = {1.0, 0.0}, endless[1] = {HUGE_VAL};
  const int none[3] = {-1, 0, 0}, one[1] = {1};
  const km_force_def right = {.name = "spring", .type = KM_MODULE_STIFFNESS, .coordinate = {s.joint, 0}};
  km_force_def force = right;
  force.coefficients = endless;
  refuse(km_model_add_force(s.b, &force, &e), &e, "the law is not complete");
  force.piece_sizes = none;
  force.knot_count = 2;
  force.knots = back;
  refuse(km_model_add_force(s.b, &force, &e), &e, "found 0 after 1; expected increasing knots");
  force = right;
  force.coefficients = endless;
  force.piece_sizes = none;
  refuse(km_model_add_force(s.b, &force, &e), &e, "a piece has -1 coefficients");
  force.piece_sizes = one;
  refuse(km_model_add_force(s.b, &force, &e), &e, "found a coefficient that is not finite");
  km_builder_free(s.b);
}

static void wrong_shapes(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  km_shape_def shape = km_shape_default();
  refuse(km_model_add_shape(s.b, (km_body_id){0}, &shape, &e), &e, "found no body of this builder to put it on");
  refuse(km_model_add_shape(s.b, s.body, &shape, &e), &e, "a shape of body \"arm\": expected");
  shape.kind = KM_SHAPE_BOX;
  shape.size[0] = shape.size[1] = shape.size[2] = 1.0;
  shape.R[0] = 0.5;
  refuse(km_model_add_shape(s.b, s.body, &shape, &e), &e, "not a rotation");
  km_builder_free(s.b);
}

/* Errors of holds, poses, directions and settings. */
static void wrong_values(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  const km_coordinate_ref one = {s.joint, 0};
  const double endless[1] = {HUGE_VAL}, zero[1] = {0.0};
  refuse(km_model_add_hold(s.b, one, endless[0], &e), &e, "a hold: found no builder, or a value that is not finite");
  refuse(km_model_add_pose(s.b, "home", &one, endless, 1, &e), &e, "pose \"home\": found no builder, or a value");
  assert_int_equal(km_model_add_pose(s.b, "home", &one, zero, 1, &e), KM_OK);
  refuse(km_model_add_pose(s.b, "home", &one, zero, 1, &e), &e, "pose \"home\": this name is used twice");
  km_body_def far = km_body_default();
  km_body_id far_body;
  far.name = "far";
  assert_int_equal(km_model_add_body(s.b, &far, &far_body, &e), KM_OK);
  const km_end_def joint = {.coordinate = one}, still = {.frame = km_builder_origin(s.b, far_body)};
  refuse(km_model_set_advantage(s.b, &joint, &still, &e), &e, "expected a direction with a length");
  const km_coupling_def lawless = {.name = "g", .count = 1, .coordinates = &one};
  refuse(km_model_add_coupling(s.b, &lawless, &e), &e, "expected one or more coordinates, each with a finite ratio");
  km_joint_def ball = km_joint_default();
  km_joint_id ball_id;
  ball.name = "S";
  ball.type = KM_SPHERICAL;
  ball.parent = s.origin;
  ball.child = km_builder_origin(s.b, far_body);
  assert_int_equal(km_model_add_joint(s.b, &ball, &ball_id, &e), KM_OK);
  const km_coordinate_ref component = {ball_id, 1};
  const km_coupling_def turned = {.name = "g", .count = 1, .coordinates = &component, .ratios = (const double[]){1.0}};
  refuse(km_model_add_coupling(s.b, &turned, &e), &e, "found a component of a rotation vector");
  km_settings_def settings = km_settings_default();
  settings.gravity[0] = HUGE_VAL;
  refuse(km_model_set(s.b, &settings, &e), &e, "found a gravity that is not finite");
  refuse(km_model_add_assembly(s.b, "a", (km_assembly_id){7}, NULL, &e), &e,
         "found a parent that is none of this builder");
  km_body_def body = km_body_default();
  body.name = "lost";
  body.assembly = (km_assembly_id){7};
  refuse(km_model_add_body(s.b, &body, NULL, &e), &e, "found an assembly that is none of this builder");
  km_builder_free(s.b);
}

/* Calls without what they work on are the caller's mistake. */
static void nothing_to_build(void **state) {
  (void)state;
  enum { CALLS = 6 };
  km_error e[CALLS];
  const km_coordinate_ref none = {{0}, 0};
  const km_status status[CALLS] = {km_builder_create(NULL, &e[0]),
                                   km_model_set(NULL, NULL, &e[1]),
                                   km_model_add_actuator(NULL, none, &e[2]),
                                   km_model_set_sweep(NULL, NULL, &e[3]),
                                   km_model_set_advantage(NULL, NULL, NULL, &e[4]),
                                   km_builder_finish(NULL, NULL, &e[5])};
  static const char *const words[CALLS] = {"found no place for the builder",
                                           "found no builder or no settings",
                                           "found no builder",
                                           "found no builder or no sweep",
                                           "found no builder, no input or no output",
                                           "found no builder, or one that is finished"};
  for (int i = 0; i < CALLS; ++i) {
    assert_int_equal(status[i], KM_USAGE);
    assert_string_equal(e[i].text, words[i]);
  }
}

static void wrong_rest(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  const km_coordinate_ref one = {s.joint, 0}, none = {{0}, 0}, far = {s.joint, 3},
                          twice[2] = {{s.joint, 0}, {s.joint, 0}};
  const double ratios[2] = {1.0, 0.0}, zero[1] = {0.0};
  km_coupling_def coupling = {.name = "g", .count = 1, .coordinates = &far, .ratios = ratios};
  refuse(km_model_add_coupling(s.b, &coupling, &e), &e, "expected one of its 1");
  coupling.coordinates = twice;
  coupling.count = 2;
  refuse(km_model_add_coupling(s.b, &coupling, &e), &e, "twice");
  coupling = (km_coupling_def){.name = "g", .count = 1, .coordinates = &one, .ratios = zero};
  refuse(km_model_add_coupling(s.b, &coupling, &e), &e, "every ratio is 0");
  refuse(km_model_add_hold(s.b, none, 0.0, &e), &e, "no joint");
  assert_int_equal(km_model_add_hold(s.b, one, 0.0, &e), KM_OK);
  refuse(km_model_add_hold(s.b, one, 0.0, &e), &e, "held twice");
  assert_int_equal(km_model_add_actuator(s.b, one, &e), KM_OK);
  refuse(km_model_add_actuator(s.b, one, &e), &e, "twice");
  km_force_def force = km_force_default();
  force.name = "spring";
  refuse(km_model_add_force(s.b, &force, &e), &e, "no law");
  km_load_def load = {.name = "weight", .force = {HUGE_VAL, 0, 0}};
  refuse(km_model_add_load(s.b, &load, &e), &e, "finite");
  km_sweep_def sweep = km_sweep_default();
  refuse(km_model_set_sweep(s.b, &sweep, &e), &e, "either a driver");
  const km_end_def end = {.coordinate = one};
  refuse(km_model_set_advantage(s.b, &end, &end, &e), &e, "is the input too");
  km_settings_def settings = km_settings_default();
  settings.length = "furlongs";
  refuse(km_model_set(s.b, &settings, &e), &e, "furlongs");
  km_builder_free(s.b);
}

/* Errors of the complete model; a finished builder accepts no further elements. */
static void wrong_wholes(void **state) {
  (void)state;
  start s = begin();
  km_error e;
  km_model *model;
  km_body_def body = km_body_default();
  body.name = "loose";
  assert_int_equal(km_model_add_body(s.b, &body, NULL, &e), KM_OK);
  refuse(km_builder_finish(s.b, &model, &e), &e, "tied to the inertial frame by no chain");
  assert_null(model);
  assert_int_equal(km_model_add_body(s.b, &body, NULL, &e), KM_USAGE);
  km_builder_free(s.b);
  s = begin();
  body = km_body_default();
  body.name = "odd";
  body.inertia[0] = -1.0;
  km_body_id id;
  assert_int_equal(km_model_add_body(s.b, &body, &id, &e), KM_OK);
  km_joint_def joint = km_joint_default();
  joint.name = "B";
  joint.parent = s.origin;
  joint.child = km_builder_origin(s.b, id);
  assert_int_equal(km_model_add_joint(s.b, &joint, NULL, &e), KM_OK);
  refuse(km_builder_finish(s.b, &model, &e), &e, "principal moment");
  km_builder_free(s.b);
  km_builder_free(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_same_tables),
                                     cmocka_unit_test(wrong_bodies_and_frames),
                                     cmocka_unit_test(wrong_joints),
                                     cmocka_unit_test(wrong_rest),
                                     cmocka_unit_test(wrong_numbers_of_joints),
                                     cmocka_unit_test(wrong_laws),
                                     cmocka_unit_test(wrong_shapes),
                                     cmocka_unit_test(wrong_values),
                                     cmocka_unit_test(nothing_to_build),
                                     cmocka_unit_test(wrong_wholes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
