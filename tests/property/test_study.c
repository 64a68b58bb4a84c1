/* Definitions of path studies: by text and by calls, with parts of a command, on a mechanism. */
#include "support/arms.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define START "[0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0]"
#define LINE  "{\"segments\": [{\"type\": \"line\", \"to\": [0.4, 0.45, 0.5], \"steps\": 8}]}"

static const double start[7] = {0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0};
static const char *const effector[2] = {"flange", "tool"};

static void read_text(const char *json, km_study_def *def) {
  km_error error;
  if (km_study_read(json, strlen(json), "", NULL, def, &error))
    fail_msg("%s", error.text);
}

static km_study *bind(const fixture *f, const km_study_def *def) {
  km_study *study;
  km_error error;
  if (km_study_bind(f->mechanism, f->state, def, 1, NULL, &study, &error))
    fail_msg("%s", error.text);
  return study;
}

/* Both studies' methods give the same rows, to the bit. */
static void assert_same_tracks(const km_study *a, const km_study *b) {
  assert_int_equal(km_study_methods(a), km_study_methods(b));
  for (int m = 0; m < km_study_methods(a); ++m) {
    km_track *x = track_of(a, m, 1), *y = track_of(b, m, 1);
    assert_true(km_table_rows(x->table) > 1);
    assert_same_rows(x, y);
    km_track_free(x);
    km_track_free(y);
  }
}

/* A definition filled by a program equals that read from a file. */
static void calls_are_text(void **state) {
  (void)state;
  static const double rates[7] = {9, 9, 9, 9, 9, 9, 8};
  static const char *const held[1] = {"A3"};
  fixture f = fixture_open("iiwa14");
  km_study_def text = km_study_def_default(), calls = km_study_def_default();
  read_text(
      "{\"effector\": \"flange/tool\", \"q0\": " START ", \"path\": " LINE ", \"rates\": [9, 9, 9, 9, 9, 9, 8],"
      "\"methods\": [\"greedy\", {\"method\": \"lookahead\", \"levels\": 2, \"angle\": 20}, {\"method\": \"fixed\", "
      "\"joint\": \"A3\"}], \"objective\": {\"singular-value\": 2}}",
      &text);
  km_path_segment line = km_path_segment_default(KM_PATH_LINE);
  memcpy(line.to, (const double[]){0.4, 0.45, 0.5}, sizeof line.to);
  line.steps = 8;
  km_study_method methods[3] = {{.method = km_method_default(KM_GREEDY)},
                                {.method = km_method_default(KM_LOOKAHEAD)},
                                {.method = km_method_default(KM_FIXED), .joints = {held, 1, {"joints", false}}}};
  methods[1].method.levels = 2;
  methods[1].method.angle = 20.0 * M_PI / 180.0;
  calls.effector.items = effector;
  calls.effector.count = 2;
  calls.q0.items = start;
  calls.rates.items = rates;
  calls.q0.count = calls.rates.count = 7;
  calls.path.plan.segments = &line;
  calls.path.plan.segment_count = 1;
  calls.methods = methods;
  calls.method_count = 3;
  calls.objective = (km_objective){{[KM_SINGULAR_VALUE] = 2.0}};
  km_study *a = bind(&f, &text), *b = bind(&f, &calls);
  km_study_def_free(&text); /* a study needs its definition no more */
  assert_same_tracks(a, b);
  km_study_free(a);
  km_study_free(b);
  fixture_close(&f);
}

/* One definition can be used with several mechanisms. */
static void definitions_are_bound_again(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14"), g = fixture_open("iiwa14");
  km_study_def def = km_study_def_default();
  read_text("{\"effector\": \"flange/tool\", \"q0\": " START ", \"path\": " LINE "}", &def);
  km_study *a = bind(&f, &def), *b = bind(&g, &def);
  assert_same_tracks(a, b);
  km_study_free(a);
  km_study_free(b);
  km_study_def_free(&def);
  fixture_close(&f);
  fixture_close(&g);
}

/* A part of the command isn't read from the text, however faulty it is there; its own faults are of the call. */
static void parts_of_a_command_stay(void **state) {
  (void)state;
  static const double two[2] = {1, 2};
  fixture f = fixture_open("iiwa14");
  for (int option = 0; option < 2; ++option) {
    km_study_def def = km_study_def_default();
    km_study *study;
    km_error error;
    def.q0 = (km_study_numbers){two, 2, {option ? "--q" : "q0", option}};
    def.task_place = (km_study_place){"--task", true};
    def.methods_place = (km_study_place){"--method", true};
    def.objective_place = (km_study_place){"--objective", true};
    read_text("{\"effector\": \"flange/tool\", \"q0\": [1, 2, 3], \"task\": \"none\", \"methods\": [\"none\"], "
              "\"objective\": 7, \"path\": " LINE "}",
              &def);
    km_status status = km_study_bind(f.mechanism, f.state, &def, 1, NULL, &study, &error);
    assert_int_equal(status, option ? KM_USAGE : KM_MODEL);
    assert_string_equal(error.text, option ? "--q: found 2 values; expected 7, one for each joint from A1 to A7"
                                           : "q0: found 3 values; expected 7, one for each joint from A1 to A7");
    assert_null(study);
    km_study_def_free(&def);
  }
  fixture_close(&f);
}

/* The path of a study's text, a path's text, and a study that is read whole. */
static void paths_are_read_alone(void **state) {
  (void)state;
  static const char study_text[] = "{\"effector\": \"flange/tool\", \"q0\": " START ", \"path\": " LINE "}";
  static const char no_path[] = "{\"effector\": \"flange/tool\", \"q0\": " START "}";
  static const char faulty[] = "{\"segments\": [{\"type\": \"lime\"}]}";
  const char *texts[2] = {study_text, LINE};
  const km_study_place place = {"--path", true};
  fixture f = fixture_open("iiwa14");
  km_study *whole = study_of(&f, study_text);
  km_error error;
  for (int i = 0; i < 2; ++i) {
    km_study_def def = km_study_def_default();
    assert_int_equal(km_study_read_path(texts[i], strlen(texts[i]), "", place, NULL, &def, &error), KM_OK);
    read_text(no_path, &def);
    km_study *study = bind(&f, &def);
    assert_same_tracks(whole, study);
    km_study_free(study);
    assert_int_equal(km_study_read_path(faulty, sizeof faulty - 1, "", place, NULL, &def, &error), KM_USAGE);
    assert_non_null(strstr(error.text, "--path.segments[0].type: \"lime\""));
    km_study_def_free(&def);
  }
  km_study_free(whole);
  fixture_close(&f);
}

static void write_poses(const char *file, const char *text) {
  FILE *out = fopen(file, "w");
  assert_non_null(out);
  fputs(text, out);
  assert_int_equal(fclose(out), 0);
}

/* The model in degrees. */
static fixture in_degrees(const fixture *f) {
  km_arena arena = {0};
  km_text json = {0};
  const km_value *tree;
  km_units units = f->model->units;
  units.angle = km_unit_find(KM_ANGLE, "degrees");
  assert_int_equal(km_model_convert(f->model, &units, NULL, false, &arena, &tree, NULL), KM_OK);
  km_json_write(tree, &json);
  fixture g = fixture_read(json.data);
  km_text_free(&json);
  km_arena_free(&arena);
  return g;
}

/* Rotation vectors are in the model's angle unit: the same quarter turn in radians, in degrees, as a quaternion. */
static void poses_turn_in_the_angle_unit(void **state) {
  (void)state;
  static const char *const poses[3] = {
      "x,y,z,rx,ry,rz,t\n\n0.5,0.1,0.5,0,0,0,1\n0.5,0.2,0.5,0,0,1.5707963267948966,3\n",
      "x,y,z,rx,ry,rz,t\n\n0.5,0.1,0.5,0,0,0,1\n0.5,0.2,0.5,0,0,90,3\n",
      "t,x,y,z,w,x,y,z\n1,0.5,0.1,0.5,1,0,0,0\n3,0.5,0.2,0.5,0.7071067811865476,0,0,0.7071067811865476\n"};
  static const double last[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  char file[] = "/tmp/kmech_poses_XXXXXX";
  int handle = mkstemp(file);
  fixture f = fixture_open("iiwa14"), g = in_degrees(&f);
  assert_true(handle >= 0);
  close(handle);
  for (int i = 0; i < 3; ++i) {
    km_study_def def = km_study_def_default();
    km_frame_pose pose;
    write_poses(file, poses[i]);
    assert_int_equal(km_study_read_poses(file, (km_study_place){"path", false}, NULL, &def, NULL), KM_OK);
    def.effector = (km_study_names){effector, 2, {"effector", false}};
    km_study *study = bind(i == 1 ? &g : &f, &def);
    assert_int_equal(km_path_samples(study->path), 2);
    assert_near(km_path_turn(study->path, 1), 0.5 * M_PI, 1e-12);
    assert_near(km_path_time(study->path, 1), 2.0, 1e-12);
    km_path_pose(study->path, 1, &pose);
    for (int k = 0; k < 9; ++k)
      assert_near(pose.R[k], last[k], 1e-12);
    km_study_free(study);
    km_study_def_free(&def);
  }
  unlink(file);
  fixture_close(&f);
  fixture_close(&g);
}

/* A pose that a file repeats is reported with its line, empty lines included. */
static void poses_that_stand_are_told_with_their_line(void **state) {
  (void)state;
  char file[] = "/tmp/kmech_poses_XXXXXX", expected[200];
  int handle = mkstemp(file);
  fixture f = fixture_open("iiwa14");
  km_study_def def = km_study_def_default();
  km_study *study;
  km_error error;
  assert_true(handle >= 0);
  close(handle);
  write_poses(file, "x,y,z,rx,ry,rz\n0.5,0.1,0.5,0,0,0\n\n0.5,0.2,0.5,0,0,1\n0.5,0.2,0.5,0,0,1\n");
  assert_int_equal(km_study_read_poses(file, (km_study_place){"path", false}, NULL, &def, NULL), KM_OK);
  def.effector = (km_study_names){effector, 2, {"effector", false}};
  assert_int_equal(km_study_bind(f.mechanism, f.state, &def, 1, NULL, &study, &error), KM_MODEL);
  snprintf(expected, sizeof expected, "path.csv: %s, line 5: the same pose as the one before; expected a way to go",
           file);
  assert_string_equal(error.text, expected);
  unlink(file);
  km_study_def_free(&def);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(calls_are_text),
      cmocka_unit_test(definitions_are_bound_again),
      cmocka_unit_test(parts_of_a_command_stay),
      cmocka_unit_test(paths_are_read_alone),
      cmocka_unit_test(poses_turn_in_the_angle_unit),
      cmocka_unit_test(poses_that_stand_are_told_with_their_line),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
