/* Reading a model by the library, and writing it back. */
#include "support/support.h"

#include "exchange/json/format/format.h"
#include "exchange/json/json.h"
#include "exchange/json/study/study_reader.h"
#include "exchange/json/write/convert.h"
#include "kmech/exchange.h"

#include <stdlib.h>
#include <string.h>

/* One of everything. */
static const char everything[] =
    "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"degrees\", \"length\": \"inches\", "
    "\"mass\": \"pounds\","
    " \"time\": \"milliseconds\", \"force\": \"pounds-force\"}, \"gravity\": [0, 0, -0.000386], \"include_dir\": "
    "[\"meshes\"],"
    " \"closure_tolerance\": 1e-8, \"simulation\": {\"time_span\": 2000, \"time_step\": 3}, \"characteristic_length\": "
    "2},"
    " \"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [1, 2, 3]}], \"lights\": [{\"name\": \"sun\", \"Ka\": [1, 1, "
    "1]}]},"
    " \"assemblies\": [{\"name\": \"left\", \"bodies\": [{\"name\": \"arm\", \"mass\": 2, \"center_of_mass\": [1, 0, "
    "0],"
    "   \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 2, \"Izz\": 2}, \"frames\": [{\"name\": \"tip\", \"T\": [3, 0, "
    "0]}]},"
    "  {\"name\": \"slider\"}, {\"name\": \"ball\"}, {\"name\": \"nut\"}],"
    "  \"joints\": [{\"name\": \"turn\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], [\"arm\"]], "
    "\"initial_displacement\": 30,"
    "    \"initial_velocity\": 0.5, \"damping\": 0.1, \"limits\": [-90, 90], \"max_rate\": 6, \"max_force\": 7, \"armature\": "
    "8, \"friction\": {\"torque\": 9, \"coefficient\": 0.2, "
    "\"radius\": 0.5, \"stiction_velocity\": 0.001},"
    "    \"stop\": {\"stiffness\": 10, \"damping\": 1}, \"prescribed\": {\"sine\": {\"offset\": 5, \"amplitude\": 10, "
    "\"frequency\": 0.001, \"phase\": 90}}},"
    "   {\"name\": \"slide\", \"type\": \"Tx\", \"body_frame_pairs\": [[\"arm\", \"tip\"], \"slider\"], "
    "\"initial_displacement\": 0.25, \"damping\": 3, \"max_rate\": 6, \"max_force\": 7, \"armature\": 8,"
    "    \"prescribed\": {\"polynomial\": [0.25, 0.1, 0.01]}},"
    "   {\"name\": \"round\", \"type\": \"spherical\", \"body_frame_pairs\": [\"slider\", \"ball\"], "
    "\"initial_displacement\": [10, 20, 30]},"
    "   {\"name\": \"thread\", \"type\": \"screw\", \"pitch\": 0.1, \"body_frame_pairs\": [\"arm\", \"nut\"], "
    "\"initial_displacement\": 720,"
    "    \"prescribed\": {\"table\": [[0, 720], [10, 710]]}}],"
    "  \"couplings\": [{\"name\": \"gear\", \"joints\": [\"turn\", \"slide\"], \"ratios\": [1, -2]}, {\"name\": \"cam\", "
    "\"joints\": [\"turn\", \"slide\"], \"polynomial\": [1, 2, 3]}],"
    "  \"force_modules\": [{\"name\": \"spring\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": "
    "\"slide\"}, \"knot_points\": [0.1], \"coefficients\": [[0, -5], [1, -6]]},"
    "   {\"name\": \"drag\", \"type\": \"damping\", \"input\": {\"type\": \"joint\", \"joint\": \"turn\"}, "
    "\"coefficients\": [[0, -5, 0.1]]},"
    "   {\"name\": \"push\", \"type\": \"motor\", \"output\": {\"type\": \"joint\", \"joint\": \"slide\"}, "
    "\"polynomial\": [1, 2]},"
    "   {\"name\": \"control\", \"type\": \"pid\", \"input\": {\"type\": \"joint\", \"joint\": \"turn\"}, "
    "\"reference\": 0.5, \"kp\": 1, \"ki\": 2, \"kd\": 3}]},"
    " {\"name\": \"right\", \"bodies\": [{\"name\": \"arm\"}], \"joints\": [{\"name\": \"turn\", \"type\": \"Ry\", "
    "\"body_frame_pairs\": [[\"left\", \"arm\", \"tip\"], [\"arm\"]]}]}],"
    " \"analysis\": {\"sweep\": {\"joint\": \"left/turn\", \"range\": [0, 45], \"steps\": 9}, \"actuators\": "
    "[\"slide\", [\"right\", \"turn\"]],"
    "  \"loads\": [{\"name\": \"w\", \"frame\": [\"left\", \"arm\", \"tip\"], \"force\": [0, 0, -5], \"torque\": [1, "
    "0, 0]}], \"hold\": {\"round\": [10, 20, 30]}},"
    " \"poses\": {\"home\": {\"left/turn\": 45, \"slide\": 2}}, \"source\": \"made up\", \"known\": {\"mobility\": 6}}";

static km_model *read(const char *text) {
  km_model *model;
  km_error error;
  if (km_model_read(text, strlen(text), NULL, &model, &error))
    fail_msg("%s", error.text);
  return model;
}

static void labels_paths_and_units(void **state) {
  (void)state;
  km_model *m = read(everything);
  assert_int_equal(km_model_body_count(m), 5);
  assert_int_equal(km_model_joint_count(m), 5);
  assert_int_equal(km_model_coordinate_count(m), 7);
  assert_string_equal(km_model_joint_label(m, 0), "left/turn"); /* two joints are called turn */
  assert_string_equal(km_model_joint_label(m, 4), "right/turn");
  assert_string_equal(km_model_coordinate_label(m, 3), "round[1]");
  assert_string_equal(km_model_coordinate_unit(m, 0), "deg");
  assert_string_equal(km_model_coordinate_unit(m, 1), "in");
  assert_string_equal(km_model_coordinate_unit(m, 5), "deg"); /* a screw's coordinate is an angle */
  int index;
  km_error error;
  assert_int_equal(km_model_find_coordinate(m, "turn", &index, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "left/turn"));
  assert_int_equal(km_model_find_coordinate(m, "round", &index, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "round[0]"));
  const char *path[3] = {"left", "arm", "tip"}, *ambiguous[2] = {"arm", "origin"}, *wrong[2] = {"arm", "top"};
  assert_int_equal(km_model_find_frame(m, path, 3, &index, NULL), KM_OK);
  assert_string_equal(m->frames[index].name, "tip");
  assert_int_equal(km_model_find_frame(m, path + 1, 2, &index, NULL), KM_OK); /* only one arm has a tip */
  assert_int_equal(km_model_find_frame(m, ambiguous, 2, &index, &error), KM_USAGE);
  assert_int_equal(km_model_find_frame(m, wrong, 2, &index, &error), KM_USAGE);
  assert_int_equal(m->sweep.coordinate, 0);
  assert_int_equal(m->actuator_count, 2);
  assert_int_equal(m->hold_count, 3);
  km_model_free(m);
}

static double number_at(const km_value *root, const char *const *path) {
  for (; *path; ++path) {
    char *end;
    long index = strtol(*path, &end, 10);
    if (*end == '\0') {
      root = root->first;
      while (index-- > 0)
        root = root->next;
    } else {
      root = km_value_get(root, *path);
    }
    assert_non_null(root);
  }
  return root->number;
}

#define AT(...) ((const char *const[]){__VA_ARGS__, NULL})

/* To metres, radians, kilograms, seconds and newtons, by hand. */
static void conversion_knows_every_unit(void **state) {
  (void)state;
  km_model *m = read(everything);
  km_units units = km_units_default();
  km_arena arena = {0};
  const km_value *t;
  const double in = 0.0254, ms = 1e-3, lbf = 4.4482216152605, lb = 0.45359237, deg = M_PI / 180.0;
  assert_int_equal(km_model_convert(m, &units, NULL, false, &arena, &t, NULL), KM_OK);
#define EXPECT(value, ...) assert_near(number_at(t, AT(__VA_ARGS__)) / (value), 1.0, 1e-14)
  EXPECT(-0.000386 * in / (ms * ms), "model_parameters", "gravity", "2");
  EXPECT(2 * in, "model_parameters", "characteristic_length");
  EXPECT(1e-8, "model_parameters", "closure_tolerance");
  EXPECT(2000 * ms, "model_parameters", "simulation", "time_span");
  EXPECT(3 * in, "fixed", "frames", "0", "T", "2");
#define LEFT "assemblies", "0"
  EXPECT(2 * lb, LEFT, "bodies", "0", "mass");
  EXPECT(2 * lb * in * in, LEFT, "bodies", "0", "moment_of_inertia", "Izz");
  EXPECT(30 * deg, LEFT, "joints", "0", "initial_displacement");
  EXPECT(0.5 * deg / ms, LEFT, "joints", "0", "initial_velocity");
  EXPECT(0.1 * lbf * in * ms, LEFT, "joints", "0", "damping"); /* torque per radian/time */
  EXPECT(90 * deg, LEFT, "joints", "0", "limits", "1");
  EXPECT(0.5 * in, LEFT, "joints", "0", "friction", "radius");
  EXPECT(0.001 * in / ms, LEFT, "joints", "0", "friction", "stiction_velocity");
  EXPECT(6 * deg / ms, LEFT, "joints", "0", "max_rate");
  EXPECT(7 * lbf * in, LEFT, "joints", "0", "max_force");
  EXPECT(8 * lb * in * in, LEFT, "joints", "0", "armature");
  EXPECT(9 * lbf * in, LEFT, "joints", "0", "friction", "torque");
  EXPECT(6 * in / ms, LEFT, "joints", "1", "max_rate");
  EXPECT(7 * lbf, LEFT, "joints", "1", "max_force");
  EXPECT(8 * lb, LEFT, "joints", "1", "armature");
  EXPECT(10 * lbf * in, LEFT, "joints", "0", "stop", "stiffness");
  EXPECT(1 * lbf * in * ms, LEFT, "joints", "0", "stop", "damping");
  EXPECT(10 * deg, LEFT, "joints", "0", "prescribed", "sine", "amplitude");
  EXPECT(0.001 / ms, LEFT, "joints", "0", "prescribed", "sine", "frequency");
  EXPECT(90 * deg, LEFT, "joints", "0", "prescribed", "sine", "phase");
  EXPECT(3 * lbf / in * ms, LEFT, "joints", "1", "damping");
  EXPECT(0.01 * in / (ms * ms), LEFT, "joints", "1", "prescribed", "polynomial", "2");
  EXPECT(20 * deg, LEFT, "joints", "2", "initial_displacement", "1");
  EXPECT(0.1 * in, LEFT, "joints", "3", "pitch");
  EXPECT(10 * ms, LEFT, "joints", "3", "prescribed", "table", "1", "0");
  EXPECT(710 * deg, LEFT, "joints", "3", "prescribed", "table", "1", "1");
  EXPECT(1, LEFT, "couplings", "0", "ratios", "0");
  EXPECT(-2 / in, LEFT, "couplings", "0", "ratios", "1");
  EXPECT(1, LEFT, "couplings", "1", "polynomial", "0");
  EXPECT(3 / (in * in), LEFT, "couplings", "1", "polynomial", "2");
  EXPECT(45 * deg, "poses", "home", "left/turn");
  EXPECT(2 * in, "poses", "home", "slide");
  EXPECT(0.1 * in, LEFT, "force_modules", "0", "knot_points", "0");
  EXPECT(-6 * lbf / in, LEFT, "force_modules", "0", "coefficients", "1", "1");
  EXPECT(0.1 * lbf * in * ms * ms, LEFT, "force_modules", "1", "coefficients", "0", "2"); /* torque over (rad/s)² */
  EXPECT(2 * lbf / ms, LEFT, "force_modules", "2", "polynomial", "1");
  EXPECT(0.5, LEFT, "force_modules", "3", "reference");
  EXPECT(1 * lbf * in, LEFT, "force_modules", "3", "kp");
  EXPECT(2 * lbf * in / ms, LEFT, "force_modules", "3", "ki");
  EXPECT(3 * lbf * in * ms, LEFT, "force_modules", "3", "kd");
  EXPECT(45 * deg, "analysis", "sweep", "range", "1");
  EXPECT(-5 * lbf, "analysis", "loads", "0", "force", "2");
  EXPECT(1 * lbf * in, "analysis", "loads", "0", "torque", "0");
  EXPECT(30 * deg, "analysis", "hold", "round", "2");
  km_arena_free(&arena);
  km_model_free(m);
}

/* In its own units nothing changes, and what is written reads to the same text again. */
static void writing_is_stable(void **state) {
  (void)state;
  km_text first = {0}, second = {0};
  const char *source = everything;
  for (int pass = 0; pass < 2; ++pass) {
    km_model *m = read(source);
    km_arena arena = {0};
    const km_value *t;
    assert_int_equal(km_model_convert(m, &m->units, NULL, false, &arena, &t, NULL), KM_OK);
    km_json_write(t, pass ? &second : &first);
    km_arena_free(&arena);
    km_model_free(m);
    source = first.data;
  }
  assert_string_equal(first.data, second.data);
  km_text_free(&first);
  km_text_free(&second);
}

/* Every key of an object and of those inside it has a text, and the schema describes it in these words. */
static void check_described(const km_value *schema, const km_object_format *format, const km_object_format **seen) {
  int known = 0;
  for (; seen[known]; ++known)
    if (seen[known] == format)
      return;
  seen[known] = format;
  const km_value *object =
      known == 0 ? schema : km_value_get(km_value_get(schema, "$defs"), format->name); /* the first one is the root */
  for (const km_field *field = format->fields; field->key; ++field) {
    const km_value *told = km_value_get(km_value_get(km_value_get(object, "properties"), field->key), "description");
    if (!field->help || !told)
      fail_msg("%s.%s has no description", format->name, field->key);
    size_t length = strlen(field->help);
    assert_true(length > 0 && field->help[length - 1] == '.');
    assert_memory_equal(told->string, field->help, length);
    if (field->object)
      check_described(schema, field->object, seen);
  }
}

static void every_key_is_described_in_the_schema(void **state) {
  (void)state;
  enum { MOST = 64 };
  static const struct {
    const km_object_format *format;
    int least; /* keys of its objects */
  } formats[KM_SCHEMAS] = {[KM_SCHEMA_MODEL] = {&km_format_model, 20},
                           [KM_SCHEMA_DESIGNS] = {&km_format_designs, 8},
                           [KM_SCHEMA_PATHS] = {&km_format_study, 6}};
  for (int of = 0; of < KM_SCHEMAS; ++of) {
    const km_object_format *seen[MOST] = {NULL};
    km_arena arena = {0};
    const km_value *schema = km_schema_record((km_schema)of, &arena);
    assert_non_null(schema);
    check_described(schema, formats[of].format, seen);
    assert_non_null(seen[formats[of].least - 1]);
    km_arena_free(&arena);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(labels_paths_and_units),
                                     cmocka_unit_test(conversion_knows_every_unit), cmocka_unit_test(writing_is_stable),
                                     cmocka_unit_test(every_key_is_described_in_the_schema)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
