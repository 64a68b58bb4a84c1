/* Drawings and struts: what is drawn is the assembled pose, and a strut is the distance of its points. */
#include "support/support.h"

#include "base/text.h"
#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "kmech/mechanism.h"
#include "kmech/statics.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
  const char *word;
  int freedom;
} types[] = {{"revolute", 1},  {"prismatic", 1}, {"Rx", 1},     {"Ty", 1},    {"cylindrical", 2},
             {"universal", 2}, {"spherical", 3}, {"planar", 3}, {"screw", 1}, {"rigid", 0}};

enum { TYPES = sizeof types / sizeof *types, LONGEST = 9 };

static void add_vector(km_text *out, const char *key, randomness *r) {
  km_text_format(out, ", \"%s\": [%.17g, %.17g, %.17g]", key, uniform(r, -50, 50), uniform(r, -50, 50),
                 uniform(r, -50, 50));
}

static void add_joint(km_text *out, int j, int count, int type, randomness *r) {
  char parent[16] = "fixed", child[16] = "fixed";
  if (j > 0)
    snprintf(parent, sizeof parent, "b%d", j);
  if (j < count - 1)
    snprintf(child, sizeof child, "b%d", j + 1);
  km_text_format(out, "%s{\"name\": \"J%d\", \"type\": \"%s\", \"bodies\": [\"%s\", \"%s\"]", j ? ", " : "", j,
                 types[type].word, parent, child);
  add_vector(out, "at", r);
  add_vector(out, "axis", r);
  if (strcmp(types[type].word, "screw") == 0)
    km_text_add(out, ", \"pitch\": 3");
  if (below(r, 3) && types[type].freedom) {
    km_text_add(out, ", \"initial_displacement\": [");
    for (int k = 0; k < types[type].freedom; ++k)
      km_text_format(out, "%s%.17g", k ? ", " : "", uniform(r, -80, 80));
    km_text_add(out, "]");
  }
  km_text_add(out, "}");
}

/* A loop of random joints, drawn. */
static void draw_loop(km_text *out, randomness *r) {
  int count = 3 + below(r, LONGEST - 2);
  km_text_add(out, "{\"model_parameters\": {\"units\": {\"length\": \"mm\", \"angle\": \"deg\"}}, \"assemblies\": "
                   "[{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int b = 1; b < count; ++b)
    km_text_format(out, "%s{\"name\": \"b%d\"}", b > 1 ? ", " : "", b);
  km_text_add(out, "], \"joints\": [");
  for (int j = 0; j < count; ++j)
    add_joint(out, j, count, below(r, TYPES), r);
  km_text_add(out, "]}]}");
}

static void assert_identity(const fixture *f, int frame, double tolerance) {
  km_frame_pose pose;
  assert_int_equal(km_frame_place(f->mechanism, f->state, frame, &pose, NULL), KM_OK);
  for (int i = 0; i < 9; ++i)
    assert_near(pose.R[i], i % 4 == 0, tolerance);
  for (int i = 0; i < 3; ++i)
    assert_near(pose.p[i], 0.0, 200.0 * tolerance);
}

/* Written as frames the drawing is the same mechanism in the same pose. */
static void assert_same_as_frames(fixture *f) {
  km_arena arena = {0};
  km_text text = {0};
  const km_value *tree;
  km_mobility drawn, framed;
  assert_int_equal(km_model_convert(f->model, &f->model->units, NULL, true, &arena, &tree, NULL), KM_OK);
  km_json_write(tree, &text);
  assert_null(strstr(text.data, "drawn"));
  fixture g = fixture_read(text.data);
  km_mobility_compute(f->mechanism, f->state, &drawn);
  km_mobility_compute(g.mechanism, g.state, &framed);
  assert_int_equal(drawn.mobility, framed.mobility);
  assert_int_equal(drawn.kutzbach, framed.kutzbach);
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    assert_near(km_state_coordinate(f->state, c), km_state_coordinate(g.state, c), 1e-9);
    assert_near(km_mobility_number(f->state, c), km_mobility_number(g.state, c), 1e-9);
  }
  km_text_free(&text);
  km_arena_free(&arena);
  fixture_close(&g);
}

/* Every loop closes at the stated values, every body's frame is the inertial frame there. */
static void a_drawing_is_assembled(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    randomness r = {seed};
    km_text text = {0};
    draw_loop(&text, &r);
    fixture f = fixture_read(text.data);
    for (int c = 0; c < f.model->coordinate_count; ++c)
      assert_near(km_state_coordinate(f.state, c), f.model->coordinates[c].position, 1e-9);
    km_poses_compute(f.mechanism, f.state);
    for (int frame = 0; frame < f.model->frame_count; ++frame)
      if (strcmp(f.model->frames[frame].name, "origin") == 0)
        assert_identity(&f, frame, 1e-12);
    assert_same_as_frames(&f);
    km_text_free(&text);
    fixture_close(&f);
  }
}

/* An axis is turned onto its direction, exactly where it is one already. */
static void axes_are_turned_exactly(void **state) {
  (void)state;
  randomness r = {7};
  for (int k = 0; k < 3; ++k)
    for (int trial = 0; trial < 1000; ++trial) {
      km_vec3 u = {uniform(&r, -1, 1), uniform(&r, -1, 1), uniform(&r, -1, 1)};
      if (trial < 6)
        u = km_vec3_scale(trial < 3 ? 1.0 : -1.0, km_rotation_identity().axis[trial % 3]);
      else if (trial < 800) /* almost opposite */
        u = km_vec3_axpy(pow(10.0, -trial / 4.0), u, km_vec3_scale(-1.0, km_rotation_identity().axis[k]));
      u = km_vec3_scale(1.0 / km_vec3_norm(u), u);
      km_rotation R = km_rotation_onto(k, u);
      assert_near(km_vec3_norm(km_vec3_sub(R.axis[k], u)), 0.0, 0.0);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          assert_near(km_vec3_dot(R.axis[i], R.axis[j]), i == j, 1e-15 * 4);
      assert_near(km_vec3_dot(km_vec3_cross(R.axis[0], R.axis[1]), R.axis[2]), 1.0, 4e-15);
    }
  assert_memory_equal(km_rotation_onto(2, (km_vec3){0, 0, 1}).axis, km_rotation_identity().axis, sizeof(km_rotation));
}

/* A lid on a hinge at the origin, and a strut between two points of the plane. */
static const char lid[] =
    "{\"model_parameters\": {\"units\": {\"length\": \"mm\", \"angle\": \"deg\"}}, \"fixed\": {\"frames\": [{\"name\": "
    "\"p\", \"T\": [250, -120, %g]}]}, \"assemblies\": [{\"name\": \"a\"%s, \"bodies\": [{\"name\": \"lid\", "
    "\"frames\": [{\"name\": \"q\", \"T\": [350, 40]}]}], \"joints\": [{\"name\": \"J\", \"type\": \"revolute\", %s}], "
    "\"struts\": [{\"name\": \"s\", \"from\": \"fixed/p\", \"to\": \"lid/q\", \"planar\": %s, %s}]}]}";

static const char *const ways[2][2] = {
    {", \"drawn\": \"assembled\"", "\"bodies\": [\"fixed\", \"lid\"], \"at\": [0, 0]"},
    {"", "\"body_frame_pairs\": [\"fixed\", \"lid\"]"}};

/* Its length in the plane, and how it grows with the hinge's angle. */
static double length_at(double angle, double offset, double *slope) {
  double x = 350 * cos(angle) - 40 * sin(angle), y = 350 * sin(angle) + 40 * cos(angle);
  double dx = x - 250, dy = y + 120, length = sqrt(dx * dx + dy * dy + offset * offset);
  *slope = (-dx * y + dy * x) / length;
  return length;
}

static double hinge_torque(fixture *f, int hinge) {
  km_forces *forces;
  km_statics statics;
  km_mobility mobility;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  assert_int_equal(mobility.mobility, 1);
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(f->mechanism, &hinge, 1, KM_AXES_JOINT, &statics, NULL), KM_OK);
  km_statics_compute(f->mechanism, f->state, forces, &statics);
  double torque = statics.actuator_forces[0];
  km_statics_free(&statics);
  km_forces_free(forces);
  return torque;
}

/* Length and torque at several angles: by geometry and virtual work, in plane and space, drawn or not. */
static void check_strut(const char *law, double constant, double rate, int way, bool planar, double offset) {
  char text[2000];
  snprintf(text, sizeof text, lid, offset, ways[way][0], ways[way][1], planar ? "true" : "false", law);
  fixture f = fixture_read(text);
  int hinge, strut;
  km_driver_motion *drive;
  assert_int_equal(km_model_find_coordinate(f.model, "J", &hinge, NULL), KM_OK);
  assert_int_equal(km_model_find_coordinate(f.model, "s", &strut, NULL), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, hinge, false, &drive, NULL), KM_OK);
  for (int i = 0; i <= 5; ++i) {
    double slope, angle = 13.0 * i;
    double length = length_at(angle * M_PI / 180.0, planar ? 0.0 : offset, &slope);
    assert_int_equal(km_driver_motion_move_to(drive, angle).stop, KM_STOP_NONE);
    assert_near(km_state_coordinate(f.state, strut), length, 1e-10 * length);
    double force = constant - rate * length, torque = hinge_torque(&f, hinge);
    assert_near(torque, -force * slope, 1e-8 * fabs(force * slope) + 1e-6);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

static void a_strut_is_a_distance(void **state) {
  (void)state;
  for (int way = 0; way < 2; ++way)
    for (int planar = 0; planar < 2; ++planar)
      for (int apart = 0; apart < 2; ++apart) {
        check_strut("\"spring\": {\"stiffness\": 2, \"free_length\": 150}", 300, 2, way, planar, 35.0 * apart);
        check_strut("\"gas_spring\": {\"force\": 400, \"rate\": 0.5, \"length\": 500}", 650, 0.5, way, planar,
                    35.0 * apart);
        check_strut("\"gas_spring\": {\"force\": 400}", 400, 0, way, planar, 35.0 * apart);
      }
}

/* A spatial strut removes no freedom: Kutzbach's number is unchanged. */
static void a_strut_takes_no_freedom(void **state) {
  (void)state;
  static const char free_body[] =
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"q\", \"T\": [1, 2, "
      "3]}]}], \"joints\": [{\"name\": \"F\", \"type\": \"float\", \"body_frame_pairs\": [\"fixed\", \"b\"]}], "
      "\"struts\": [{\"name\": \"s\", \"from\": \"fixed\", \"to\": \"b/q\", \"cylinder\": true}]}]}";
  fixture f = fixture_read(free_body);
  km_mobility mobility;
  km_mobility_compute(f.mechanism, f.state, &mobility);
  assert_int_equal(mobility.kutzbach, 6);
  assert_int_equal(mobility.mobility, 6);
  assert_int_equal(mobility.redundant_constraints, 0);
  assert_int_equal(f.model->actuator_count, 1);
  assert_string_equal(km_model_coordinate_label(f.model, f.model->actuators[0]), "s");
  assert_near(km_state_coordinate(f.state, f.model->actuators[0]), sqrt(14.0), 1e-12);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_drawing_is_assembled),
                                     cmocka_unit_test(axes_are_turned_exactly), cmocka_unit_test(a_strut_is_a_distance),
                                     cmocka_unit_test(a_strut_takes_no_freedom)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
