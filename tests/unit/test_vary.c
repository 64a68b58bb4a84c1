/* Variants: a number that a path names is read with another value. */
#include "support/support.h"

#include "base/memory.h"
#include "base/text.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

/* Numbers of every kind, by name and by expression. */
static const char linkage[] =
    "{\"model_parameters\": {\"version\": \"1.1\", \"units\": {\"length\": \"mm\", \"angle\": \"deg\"}, \"gravity\": [0, "
    "-9810]},\n"
    "\"parameters\": {\"reach\": 95, \"ground\": {\"value\": 100}},\n"
    "\"fixed\": {\"frames\": [{\"name\": \"D\", \"T\": [100.5, 0, 0]}]},\n"
    "\"assemblies\": [{\"name\": \"fourbar\", \"bodies\": [\n"
    "{\"name\": \"crank\", \"mass\": 1, \"frames\": [{\"name\": \"tip\", \"T\": [40, 0, 0]}]},\n"
    "{\"name\": \"coupler\", \"frames\": [{\"name\": \"tip\", \"T\": [\"reach\", 7]}, {\"name\": \"v1.2\"}]},\n"
    "{\"name\": \"rocker\", \"frames\": [{\"name\": \"tip\", \"T\": [70, 0, 0]}]}],\n"
    "\"joints\": [\n"
    "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"crank\"], \"initial_displacement\": 60, "
    "\"limits\": [-300, 400]},\n"
    "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [\"crank/tip\", \"coupler\"], \"initial_displacement\": "
    "-40},\n"
    "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [\"coupler/tip\", \"rocker/tip\"], "
    "\"initial_displacement\": 60},\n"
    "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed/D\", \"rocker\"], \"initial_displacement\": "
    "80}]}],\n"
    "\"analysis\": {\"sweep\": {\"joint\": \"A\", \"range\": [60, 90], \"steps\": 12}, \"loads\": [{\"name\": \"w\", "
    "\"frame\": \"coupler/tip\", \"force\": [0, -5]}]}}";

static void sweep_csv(km_model *model, km_text *csv) {
  fixture f = fixture_of(model);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep sweep;
  km_error error = {0};
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
  km_csv_write(sweep.motion.table, csv);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

static km_model *read_varied(const char *text, const char *path, double value) {
  km_assignment assignment = {path, value};
  km_model *model = NULL;
  km_error error = {0};
  if (km_model_read_varied(text, strlen(text), NULL, &assignment, 1, NULL, &model, &error))
    fail_msg("%s: %s", path, error.text);
  return model;
}

/* One number, by its paths, and the edit that does the same. */
static const struct {
  const char *path;
  double value;
  const char *from, *to;
} cases[] = {
    {"fourbar.crank.tip.x", 39.25, "[40, 0, 0]", "[39.25, 0, 0]"},
    {"crank.tip.x", 39.25, "[40, 0, 0]", "[39.25, 0, 0]"},
    {"crank.tip.T.0", 39.25, "[40, 0, 0]", "[39.25, 0, 0]"},
    {"assemblies.0.bodies.0.frames.0.T.0", 39.25, "[40, 0, 0]", "[39.25, 0, 0]"},
    {"reach", 96.5, "\"reach\": 95", "\"reach\": 96.5"},
    {"parameters.reach", 96.5, "\"reach\": 95", "\"reach\": 96.5"},
    {"ground", 101, "100}", "101}"},
    {"coupler.tip.x", 96.5, "[\"reach\", 7]", "[96.5, 7]"},
    {"coupler.tip.z", 0.0, "[\"reach\", 7]", "[\"reach\", 7, 0]"},
    {"fixed.D.x", 101, "100.5", "101"},
    {"crank.mass", 2, "\"mass\": 1", "\"mass\": 2"},
    {"rocker.mass", 2, "\"rocker\", ", "\"rocker\", \"mass\": 2, "},
    {"A.limits.1", 350, "400", "350"},
    {"A.initial_displacement", 61, "\"initial_displacement\": 60,", "\"initial_displacement\": 61,"},
    {"fourbar.D.initial_displacement", 81, "80}", "81}"},
    {"loads.w.force.2", 3, "[0, -5]", "[0, -5, 3]"},
    {"coupler.v1\\.2.y", 3, "\"v1.2\"", "\"v1.2\", \"T\": [0, 3, 0]"},
    {"gravity.1", -1, "-9810", "-1"},
    {"characteristic_length", 25, "\"version\": \"1.1\",", "\"version\": \"1.1\", \"characteristic_length\": 25,"},
    {"sweep.range.1", 95, "[60, 90]", "[60, 95]"},
};

static void a_variant_is_the_edited_file(void **state) {
  (void)state;
  const char *text = linkage;
  km_text base = {0};
  sweep_csv(read_varied(text, "reach", 95), &base);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    km_text varied = {0}, by_hand = {0};
    char *other = edited(text, NULL, cases[i].from, cases[i].to);
    km_model *twin, *model = read_varied(text, cases[i].path, cases[i].value);
    assert_int_equal(km_model_read(other, strlen(other), NULL, &twin, NULL), KM_OK);
    for (int f = 0; f < model->frame_count; ++f)
      assert_memory_equal(&model->frames[f].pose, &twin->frames[f].pose, sizeof model->frames[f].pose);
    for (int b = 0; b < model->body_count; ++b)
      assert_true(model->bodies[b].mass == twin->bodies[b].mass);
    assert_memory_equal(&model->loads[0].force, &twin->loads[0].force, sizeof model->loads[0].force);
    assert_memory_equal(&model->gravity, &twin->gravity, sizeof model->gravity);
    for (int c = 0; c < model->coordinate_count; ++c)
      assert_true(model->coordinates[c].high == twin->coordinates[c].high);
    sweep_csv(model, &varied);
    sweep_csv(twin, &by_hand);
    assert_string_equal(varied.data, by_hand.data);
    if (i < 7 && cases[i].value != 101)
      assert_string_not_equal(varied.data, base.data);
    km_text_free(&varied);
    km_text_free(&by_hand);
    km_free(other);
  }
  km_text_free(&base);
}

/* Several values, the later ones over the earlier ones; the fingerprint is the file's. */
static void values_follow_each_other(void **state) {
  (void)state;
  const km_assignment both[] = {{"reach", 80}, {"crank.tip.y", 2}, {"reach", 97}};
  const char *text = linkage;
  km_model *model, *plain;
  assert_int_equal(km_model_read_varied(text, strlen(text), NULL, both, 3, NULL, &model, NULL), KM_OK);
  assert_int_equal(km_model_read(text, strlen(text), NULL, &plain, NULL), KM_OK);
  assert_string_equal(km_model_sha256(model), km_model_sha256(plain));
  const char *const tip[] = {"coupler", "tip"}, *const pin[] = {"crank", "tip"};
  int frame;
  assert_int_equal(km_model_find_frame(model, tip, 2, &frame, NULL), KM_OK);
  assert_true(model->frames[frame].pose.p.x == 97.0);
  assert_int_equal(km_model_find_frame(model, pin, 2, &frame, NULL), KM_OK);
  assert_true(model->frames[frame].pose.p.y == 2.0);
  km_model_free(model);
  km_model_free(plain);
}

static void paths_that_name_no_number_are_refused(void **state) {
  (void)state;
  static const struct {
    const char *path, *words[2];
    double value;
  } bad[] = {{"crnk.tip.x", {"there is no \"crnk\"", "\"crank\""}, 1},
             {"crank.tp.x", {"there is no \"tp\"", "\"tip\""}, 1},
             {"crank.tip.w", {"there is no \"w\"", "\"x\""}, 1},
             {"crank.tip", {"names no single number", "\"T\""}, 1},
             {"tip.x", {"names several numbers", "assemblies[0].bodies[0].frames[0].T[0]"}, 1},
             {"mass", {"names several numbers", "bodies[1].mass"}, 1},
             {"crank.mass.x", {"there is no \"x\"", ""}, 1},
             {"A.limits.2", {"there is no \"2\"", ""}, 1},
             {"version", {"isn't a number", ""}, 1},
             {"crank..x", {"there is no \"\"", ""}, 1},
             {"", {"a path is empty", ""}, 1},
             {"reach", {"isn't finite", ""}, (double)NAN}};
  const char *text = linkage;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
    km_assignment assignment = {bad[i].path, bad[i].value};
    km_model *model;
    km_error error = {0};
    assert_int_equal(km_model_read_varied(text, strlen(text), NULL, &assignment, 1, NULL, &model, &error), KM_USAGE);
    assert_null(model);
    if (!strstr(error.text, bad[i].words[0]) || !strstr(error.text, bad[i].words[1]))
      fail_msg("%s: %s", bad[i].path, error.text);
  }
}

/* Points of drawings, and what belongs to a strut. */
static void drawings_and_struts_have_paths(void **state) {
  (void)state;
  static const struct {
    const char *path, *from, *to;
    double value;
  } edits[] = {{"B.x", "[130, 70]", "[131, 70]", 131},
               {"hinge.B.at.1", "[130, 70]", "[130, 72]", 72},
               {"gas.gas_spring.force", "\"force\": 800", "\"force\": 780", 780},
               {"hinge.gas.gas_spring.length", "\"length\": 400", "\"length\": 410", 410},
               {"gas.limits.0", "\"planar\"", "\"limits\": [100, 900], \"planar\"", 100},
               {"bonnet.mass", "\"mass\": 14", "\"mass\": 15", 15},
               {"spring_foot.y", "[5, -320]", "[5, -310]", -310}};
  char *text = read_model_text("bonnet");
  for (size_t i = 0; i < sizeof edits / sizeof *edits; ++i) {
    char *limited = edited(text, NULL, "\"planar\"", "\"limits\": [0, 900], \"planar\"");
    bool limits = strstr(edits[i].path, "limits");
    char *other = edited(text, NULL, edits[i].from, edits[i].to);
    km_model *twin, *model = read_varied(limits ? limited : text, edits[i].path, edits[i].value);
    km_text varied = {0}, by_hand = {0};
    assert_int_equal(km_model_read(other, strlen(other), NULL, &twin, NULL), KM_OK);
    for (int m = 0; m < model->module_count; ++m)
      assert_memory_equal(model->modules[m].law.coefficients, twin->modules[m].law.coefficients, 2 * sizeof(double));
    for (int c = 0; c < model->coordinate_count; ++c)
      assert_true(model->coordinates[c].low == twin->coordinates[c].low);
    sweep_csv(model, &varied);
    sweep_csv(twin, &by_hand);
    assert_string_equal(varied.data, by_hand.data);
    km_text_free(&varied);
    km_text_free(&by_hand);
    km_free(limited);
    km_free(other);
  }
  km_free(text);
}

/* Errors of a file are errors of a variant, too. */
static void a_variant_is_checked_as_a_file(void **state) {
  (void)state;
  const km_assignment heavy = {"crank.mass", -1};
  km_model *model;
  km_error error = {0};
  const char *text = linkage;
  assert_int_equal(km_model_read_varied(text, strlen(text), NULL, &heavy, 1, NULL, &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "assemblies[0].bodies[0].mass: found -1"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_variant_is_the_edited_file), cmocka_unit_test(values_follow_each_other),
      cmocka_unit_test(paths_that_name_no_number_are_refused), cmocka_unit_test(a_variant_is_checked_as_a_file),
      cmocka_unit_test(drawings_and_struts_have_paths)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
