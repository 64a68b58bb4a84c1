/* Errors of questions, pictures and results of studies, each with its text. */
#include "support/designs.h"
#include "support/refusals.h"

#include "kmech/exchange.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/question.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

static void expect(km_status status, km_status expected, const km_error *error, const char *words) {
  const told_text t = {"a call", words};
  assert_true(is_told(&t, status, expected, NULL, error));
}

static km_question *asking(const fixture *f, const char *kind) {
  km_question *q;
  assert_int_equal(km_question_create(f->mechanism, kind, &q, NULL), KM_OK);
  return q;
}

static void options(void **state) {
  (void)state;
  static const struct {
    const char *kind, *option;
    km_option_value value;
    const char *words;
  } wrong[] = {
      {"mobility",
       "arclength",
       {.numbers = {-1.0}},
       "`arclength` -1: expected a number greater than 1e-08 and at most 1000"},
      {"mobility",
       "arclength",
       {.numbers = {1e9}},
       "`arclength` 1e+09: expected a number greater than 1e-08 and at most 1000"},
      {"mobility", "direction", {.coordinate = 0, .numbers = {0.0}}, "`direction`: expected a joint with +1 or -1"},
      {"track", "study", {.text = ""}, "`study`: expected a file's name"},
      {"forces", "axes", {.whole = 7}, "`axes`: expected joint or fixed"},
  };
  fixture f = fixture_open("fourbar");
  for (size_t i = 0; i < COUNT(wrong); ++i) {
    km_error e = {.text = ""};
    km_question *q = asking(&f, wrong[i].kind);
    expect(km_question_set(q, wrong[i].option, &wrong[i].value, &e), KM_USAGE, &e, wrong[i].words);
    km_question_free(q);
  }
  fixture_close(&f);
}

static void plans(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_error e = {.text = ""};
  km_sweep_plan plan;
  km_question *track = asking(&f, "track"), *mobility = asking(&f, "mobility");
  const km_option_value length = {.numbers = {0.1}}, joint = {.coordinate = 0};
  expect(km_question_make_plan(track, &plan, &e), KM_USAGE, &e, "a \"track\" question has no plan of a sweep");
  assert_int_equal(km_question_set(mobility, "arclength", &length, &e), KM_OK);
  assert_int_equal(km_question_set(mobility, "joint", &joint, &e), KM_OK);
  expect(km_question_make_plan(mobility, &plan, &e), KM_USAGE, &e,
         "`arclength` 0.1: expected it without `joint` and `range`");
  km_question_free(track);
  km_question_free(mobility);
  fixture_close(&f);
}

static km_table *short_table(void) {
  km_table *table = km_table_create();
  assert_true(km_table_add_column(table, "q.A", "rad") >= 0);
  km_table_add_row(table)[0] = 0.0;
  return table;
}

static void pictures(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  fixture g = fixture_read(
      "{\"model_parameters\": {\"version\": \"1.1\"}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"shapes\": [{\"box\": "
      "[1, 1, 1]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}");
  km_error e = {.text = ""};
  km_chart *chart = NULL;
  km_text out = {0};
  km_table *table = short_table();
  km_question *first = asking(&f, "mobility"), *second = asking(&f, "forces"), *none = asking(&f, "advantage");
  assert_int_equal(km_question_compute(first, f.state, &e), KM_OK);
  assert_int_equal(km_question_compute(second, f.state, &e), KM_OK);
  const km_answered answers[2] = {{.question = first, .name = "a"}, {.question = second, .name = "b"}};
  const km_comparison two = {answers, 2, false};
  expect(km_question_chart(&two, &chart, &e), KM_USAGE, &e,
         "answers to \"mobility\" and \"forces\"; expected one kind in a plot");
  const km_answered unasked = {.question = none, .name = "a"};
  const km_comparison alone = {&unasked, 1, false};
  expect(km_question_chart(&alone, &chart, &e), KM_USAGE, &e, "there is no answer to plot");
  expect(km_question_report(&unasked, "", true, &out, &e), KM_USAGE, &e, "there is no answer to report");
  const km_comparison unasked_all = {&unasked, 1, false};
  expect(km_comparison_report(&unasked_all, "all", NULL, NULL, true, &out, &e), KM_USAGE, &e,
         "there is no answer to report");
  const km_plotted_history history = {.mechanism = f.mechanism, .table = table, .name = "a"};
  expect(km_history_chart(&history, &chart, &e), KM_USAGE, &e,
         "a table of 1 rows and 1 coordinates; expected a motion's, of 4");
  km_drawing *drawing;
  km_meshes *meshes;
  assert_int_equal(km_drawing_create(f.mechanism, &drawing, &e), KM_OK);
  expect(km_drawing_add_rows(drawing, table, &e), KM_USAGE, &e, "a table of 1 coordinates (q.); expected one of 4");
  km_poses_compute(f.mechanism, f.state);
  assert_int_equal(km_drawing_add_pose(drawing, f.mechanism, f.state, &e), KM_OK);
  assert_int_equal(km_model_read_meshes(g.model, &meshes, &e), KM_OK);
  const km_drawing_look look = {.meshes = meshes}, plain = {0};
  expect(km_drawing_picture(drawing, &look, KM_PICTURE_SVG, &out, &e), KM_USAGE, &e,
         "expected those of the mechanism's model");
  const double value = 0.0;
  const km_motion_page page = {.quantity = "A", .unit = "", .values = &value, .seconds = 0.0};
  expect(km_drawing_page(drawing, &plain, &page, &out, &e), KM_USAGE, &e, "0 seconds; expected more than 0");
  km_table *endless = km_table_create();
  for (int c = 0; c < 4; ++c)
    assert_true(km_table_add_column(endless, ((const char *const[]){"q.A", "q.B", "q.C", "q.D"})[c], "rad") >= 0);
  double *row = km_table_add_row(endless);
  for (int c = 0; c < 4; ++c)
    row[c] = c == 2 ? (double)NAN : 0.0;
  expect(km_drawing_add_rows(drawing, endless, &e), KM_USAGE, &e, "row 0: q.C isn't a finite number");
  km_table_free(endless);
  km_meshes_free(meshes);
  km_question_free(first);
  km_question_free(second);
  km_question_free(none);
  km_drawing_free(drawing);
  km_table_free(table);
  km_text_free(&out);
  fixture_close(&f);
  fixture_close(&g);
}

static km_status twice(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = 2.0 * x[0];
  return KM_OK;
}

/* A study of a function has no model, and one without indices none. */
static void results(void **state) {
  (void)state;
  designs d;
  km_error e = {.text = ""};
  km_model *model;
  km_text out = {0};
  double first[1], wide[1], total[1], wider[1];
  designs_of_function(&d, twice, 1, 1);
  d.spreads[0] = (km_design_spread){0, KM_UNIFORM, .low = 0.0, .high = 1.0};
  d.sample = (km_design_sample){.count = 16, .seed = 1, .spreads = d.spreads, .spread_count = 1};
  d.def.sample = &d.sample;
  km_design_study *s = designs_run(&d, NULL, 1);
  expect(km_design_study_model(s, 0, &model, &e), KM_USAGE, &e, "the study is about a function; it has no model");
  expect(km_design_study_indices(s, 0, first, wide, total, wider, &e), KM_USAGE, &e,
         "the study has no sample with indices");
  km_design_study_free(s);
  km_text_free(&out);
}

/* A place that isn't finite can't be written, nor a loop that is open. */
static void writing(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_error e = {.text = ""};
  km_bytes bytes;
  km_arena arena = {0};
  const km_value *tree = NULL;
  const double q[4] = {0.0, HUGE_VAL, 0.0, 0.0}, open[4] = {0.5, 0.0, 0.0, 0.0};
  expect(km_model_write(f.model, q, &bytes, &e), KM_USAGE, &e, "found a displacement that is not finite");
  expect(km_model_convert(f.model, &f.model->units, q, false, &arena, &tree, &e), KM_USAGE, &e,
         "found a displacement that is not finite");
  assert_null(tree);
  expect(km_model_write_as(f.model, KM_FORMAT_URDF, q, NULL, NULL, &bytes, &e), KM_USAGE, &e,
         "found a displacement that is not finite");
  expect(km_model_write_as(f.model, KM_FORMAT_MJCF, open, NULL, NULL, &bytes, &e), KM_MODEL, &e,
         "is open at this pose; expected the pose of a closed one");
  fixture_close(&f);
}

/* A strut's own frames stand in no file. */
static void changed_struts(void **state) {
  (void)state;
  fixture f = fixture_open("bonnet");
  km_error e = {.text = ""};
  km_bytes bytes;
  const double T[3] = {1.0, 2.0, 0.0};
  int frame = -1;
  for (int i = 0; i < km_model_frame_count(f.model); ++i)
    if (strcmp(f.model->bodies[f.model->frames[i].body].name, "gas:from") == 0)
      frame = i;
  for (int i = 0; i < km_model_frame_count(f.model); ++i)
    if (strcmp(f.model->bodies[f.model->frames[i].body].name, "gas:to") == 0 &&
        strcmp(f.model->frames[i].name, "origin") != 0)
      frame = i;
  assert_int_equal(km_model_set_frame(f.model, frame, T, NULL, &e), KM_OK);
  expect(km_model_write(f.model, NULL, &bytes, &e), KM_USAGE, &e, "which is a strut's: a file can't say it");
  fixture_close(&f);
}

/* A track moves along its path: it isn't about one pose. */
static void tracks_here(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_error e = {.text = ""};
  km_question *q = asking(&f, "track");
  const km_option_value study = {.text = STUDIES_DIR "/panda_circle/study.json"};
  assert_int_equal(km_question_set(q, "study", &study, &e), KM_OK);
  expect(km_question_compute_here(q, f.state, &e), KM_USAGE, &e, "a \"track\" question isn't about one pose");
  km_question_free(q);
  fixture_close(&f);
}

/* Null spaces need a state whose mobility is known. */
static void motions(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_state *fresh;
  double N[16];
  km_error e = {.text = ""};
  assert_int_equal(km_state_create(f.mechanism, &fresh, &e), KM_OK);
  expect(km_substructure_null(f.mechanism, fresh, 0, N, &e), KM_USAGE, &e,
         "the mobility of the state isn't known; expected km_mobility_compute before");
  km_state_free(fresh);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(options),        cmocka_unit_test(plans),
                                     cmocka_unit_test(pictures),       cmocka_unit_test(results),
                                     cmocka_unit_test(writing),        cmocka_unit_test(motions),
                                     cmocka_unit_test(changed_struts), cmocka_unit_test(tracks_here)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
