/* Studies of designs: the same bits as models run by hand, for any number of threads; samples. */
#include "support/designs.h"

#include "kmech/continuation.h"
#include "kmech/data.h"
#include "kmech/report.h"
#include "study/design_evaluation.h"
#include "study/design_study.h"
#include "study/statistics/sampler.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Models with numbers that can be patched, and with numbers that need the reader (a rotation, a limit). Held and set
 * values are in radians or the model's length unit. */
static const struct {
  const char *model, *kind, *column, *paths[2];
  double values[2][2];
  bool patched;
  km_design_setting holds[2], set;
} cases[] = {
    {"slider_crank",
     "mobility",
     "m.A",
     {"slider_crank.crank.end.y", "slider_crank.rod.end.z"},
     {{0.55, -1.5}, {0.6, -1.4}},
     true,
     .holds = {{NULL}}},
    {"brake",
     "advantage",
     "ma.I/K",
     {"brake.bridge.left_arm_pivot.y", "brake.left_arm.cable.x"},
     {{33.0, -51.0}, {35.0, -55.0}},
     true,
     .holds = {{NULL}}},
    {"brake",
     "forces",
     "f.I",
     {"loads.rim on left pad.force.0", "brake.left_arm.cable.x"},
     {{-80.0, -51.0}, {-100.0, -54.0}},
     true,
     .holds = {{NULL}}},
    {"brake",
     "forces",
     "r.B.fx",
     {"loads.rim on left pad.force.0", "brake.left_arm.cable.x"},
     {{-80.0, -51.0}, {-100.0, -54.0}},
     true,
     .holds = {{NULL}}},
    {"excavator",
     "forces",
     "f.M",
     {"payload.force.2", "bucket.mass"},
     {{-4000.0, 700.0}, {-5000.0, 500.0}},
     true,
     .holds = {{NULL}}},
    {"jansen", "mobility", "m.A", {"a", "m"}, {{37.5, 15.0}, {38.2, 14.8}}, false, .holds = {{NULL}}},
    {"slider_crank",
     "mobility",
     "m.A",
     {"slider_crank.crank.end.y", "slider_crank.rod.end.z"},
     {{0.55, -1.5}, {0.6, -1.4}},
     true,
     .set = {"A", 0.3}},
    {"excavator",
     "mobility",
     "m.M",
     {"excavator.stick.stick_cylinder.x", "excavator.boom.stick_cylinder.y"},
     {{-0.9, 0.95}, {-0.88, 0.93}},
     true,
     .holds = {{"N", 2.5}, {"B", 0.4}},
     .set = {"O", 2.0}},
    {"delta",
     "mobility",
     "m.A1",
     {"delta.arm_1.end.x", "delta.arm_2.end.x"},
     {{0.25, 0.25}, {0.251, 0.249}},
     true,
     .holds = {{"A2", 0.1}, {"A3", 0.2}}},
};
enum { CASES = sizeof cases / sizeof *cases, VARIANTS = 7 };

static int hold_count(int c) {
  return !cases[c].holds[0].coordinate ? 0 : !cases[c].holds[1].coordinate ? 1 : 2;
}

static km_hold as_hold(const km_model *model, const km_design_setting *setting) {
  km_hold hold = {.value = setting->value};
  assert_int_equal(km_model_find_coordinate(model, setting->coordinate, &hold.coordinate, NULL), KM_OK);
  return hold;
}

/* Figure of a model that is read with the values, without a study. */
static double by_hand(int c, const double *values, double length) {
  km_assignment assignments[2] = {{cases[c].paths[0], values[0]}, {cases[c].paths[1], values[1]}};
  char path[512];
  km_model *model;
  km_mechanism *m;
  km_state *state;
  km_question *q = NULL;
  km_error error;
  double value = nan("");
  km_option_value steps = {.whole = 20};
  snprintf(path, sizeof path, "%s/%s.json", MODELS_DIR, cases[c].model);
  if (km_model_read_file_varied(path, assignments, 2, NULL, &model, &error))
    fail_msg("%s", error.text);
  if (length > 0.0)
    km_model_share_length(model, length);
  km_hold holds[8], set;
  int held = model->hold_count, sets = cases[c].set.coordinate != NULL;
  for (int h = 0; h < model->hold_count; ++h)
    holds[h] = (km_hold){model->holds[h].coordinate, model->holds[h].value};
  for (int h = 0; h < hold_count(c); ++h)
    holds[held++] = as_hold(model, &cases[c].holds[h]);
  if (sets)
    set = as_hold(model, &cases[c].set);
  if (km_mechanism_compile_at(model, holds, held, &set, sets, &m, &state, &error) ||
      km_question_create(m, cases[c].kind, &q, &error))
    fail_msg("%s", error.text);
  assert_int_equal(km_question_set(q, "steps", &steps, &error), KM_OK);
  km_status status = km_question_compute(q, state, &error);
  assert_true(status == KM_OK || status == KM_PARTIAL);
  assert_int_equal(km_table_figure(km_question_table(q), cases[c].column, KM_FIGURE_MEAN, 0, &value, NULL, &error),
                   KM_OK);
  km_question_free(q);
  km_state_free(state);
  km_mechanism_free(m);
  km_model_free(model);
  return value;
}

/* The first design is read, the others are patched, some of them where an earlier one was. */
static void as_by_hand(void **state) {
  (void)state;
  static const double steps = 20.0;
  for (int c = 0; c < CASES; ++c) {
    designs d;
    designs_of_model(&d, cases[c].model, cases[c].kind);
    designs_add_parameter(&d, cases[c].paths[0]);
    designs_add_parameter(&d, cases[c].paths[1]);
    designs_add_figure(&d, "mean", KM_DESIGN_MEAN, cases[c].column);
    designs_set_number(&d, "steps", &steps);
    d.questions[0].holds = cases[c].holds;
    d.questions[0].hold_count = hold_count(c);
    d.questions[0].sets = &cases[c].set;
    d.questions[0].set_count = cases[c].set.coordinate != NULL;
    static const char *const names[VARIANTS] = {"a", "b", "c", "d", "e", "f", "g"};
    km_design_variant variants[VARIANTS];
    double values[VARIANTS][2];
    for (int i = 0; i < VARIANTS; ++i) {
      for (int p = 0; p < 2; ++p)
        values[i][p] = cases[c].values[0][p] + (cases[c].values[1][p] - cases[c].values[0][p]) * i / (VARIANTS - 1);
      variants[i] = (km_design_variant){names[i], values[i]};
    }
    d.def.variants = variants;
    d.def.variant_count = VARIANTS;
    km_design_study *s = designs_run(&d, NULL, 1);
    assert_int_equal(s->patch.is_valid, cases[c].patched);
    for (int i = 0; i < VARIANTS; ++i) {
      double wanted = by_hand(c, values[i], i ? s->length : 0.0);
      km_design_result r = designs_result(s, i);
      assert_true(isfinite(wanted));
      assert_memory_equal(&r.figures[0], &wanted, sizeof wanted);
    }
    km_design_study_free(s);
  }
}

/* The least distance from the limits on an arm's track, as kredund finds it. */
static double track_by_hand(const double *base, double length) {
  km_assignment assignments[2] = {{"fixed.A1.x", base[0]}, {"fixed.A1.y", base[1]}};
  km_model *model;
  km_mechanism *m;
  km_state *state;
  km_study *study;
  km_track *track;
  km_text text = {0};
  km_error error;
  double value = nan("");
  km_study_def def = km_study_def_default();
  assert_int_equal(km_model_read_file_varied(MODELS_DIR "/iiwa14.json", assignments, 2, NULL, &model, &error), KM_OK);
  if (length > 0.0)
    km_model_share_length(model, length);
  assert_int_equal(km_mechanism_compile_at(model, NULL, 0, NULL, 0, &m, &state, &error), KM_OK);
  assert_int_equal(km_file_read(STUDIES_DIR "/iiwa_weld/study.json", &text, &error), KM_OK);
  assert_int_equal(km_study_read(text.data, text.size, "", NULL, &def, &error), KM_OK);
  assert_int_equal(km_study_bind(m, state, &def, 1, NULL, &study, &error), KM_OK);
  km_track_plan plan = km_study_plan(study, 0);
  km_status status = km_track_run(km_study_arm(study), &plan, &track, &error);
  assert_true(status == KM_OK || status == KM_PARTIAL);
  km_table_figure(km_track_rows(track), "limit_margin", KM_FIGURE_MIN, 0, &value, NULL, &error);
  km_track_free(track);
  km_study_free(study);
  km_study_def_free(&def);
  km_text_free(&text);
  km_state_free(state);
  km_mechanism_free(m);
  km_model_free(model);
  return value;
}

static void tracks_as_by_hand(void **state) {
  (void)state;
  static const double bases[3][2] = {{0.0, 0.0}, {-0.03, 0.1}, {0.02, 0.05}};
  const char *file = "iiwa_weld/study.json";
  const km_design_option study = {.name = "study", .texts = &file, .text_count = 1};
  designs d;
  designs_of_model(&d, "iiwa14", "track");
  designs_add_parameter(&d, "fixed.A1.x");
  designs_add_parameter(&d, "fixed.A1.y");
  designs_add_figure(&d, "margin", KM_DESIGN_MIN, "limit_margin");
  d.options[0] = study;
  d.questions[0].option_count = 1;
  d.def.folder = STUDIES_DIR;
  const km_design_variant variants[3] = {{"one", bases[0]}, {"two", bases[1]}, {"three", bases[2]}};
  d.def.variants = variants;
  d.def.variant_count = 3;
  km_design_study *s = designs_run(&d, NULL, 2);
  assert_true(s->patch.is_valid);
  for (int i = 0; i < 3; ++i) {
    double wanted = track_by_hand(bases[i], i ? s->length : 0.0);
    km_design_result r = designs_result(s, i);
    assert_true(isfinite(wanted));
    assert_memory_equal(&r.figures[0], &wanted, sizeof wanted);
  }
  km_design_study_free(s);
}

/* Some of these cranks are longer than their rods: they stop short, and nothing else is different. */
static void threads_change_nothing(void **state) {
  (void)state;
  designs d;
  designs_of_cranks(&d, 300);
  km_design_study *one = designs_run(&d, NULL, 1);
  int short_ones = 0;
  for (int jobs = 2; jobs <= 4; jobs += 2) {
    km_design_study *many = designs_run(&d, NULL, jobs);
    assert_int_equal(km_design_study_computed(many), 300);
    for (int i = 0; i < 300; ++i) {
      km_design_result a = designs_result(one, i), b = designs_result(many, i);
      assert_int_equal(a.outcome, b.outcome);
      assert_string_equal(a.reason, b.reason);
      assert_memory_equal(a.figures, b.figures, 2 * sizeof(double));
      short_ones += a.outcome == KM_DESIGN_SHORT;
      assert_int_equal(a.outcome == KM_DESIGN_SHORT, a.reason[0] != '\0');
    }
    km_design_study_free(many);
  }
  assert_true(short_ones > 0 && short_ones < 200);
  km_design_study_free(one);
}

/* The next batch takes the target's time, or up to two seconds where lanes would stay empty; it has no more than
 * four times as many designs. */
static void batches_fill_the_lanes(void **state) {
  (void)state;
  static const struct {
    int size, jobs, next;
    double seconds;
  } batches[] = {{1, 1, 4, 1e-5},  {4, 1, 16, 1e-4},  {768, 1, 768, 1e-3}, {16, 1, 16, 0.8},
                 {16, 1, 5, 6.4},  {16, 1, 40, 0.04}, {2, 2, 8, 1e-3},     {64, 2, 64, 1.0},
                 {64, 2, 32, 4.0}, {4, 4, 4, 100.0},  {768, 0, 768, 0.0},  {1, 0, 1, 1000.0}};
  for (size_t i = 0; i < sizeof batches / sizeof *batches; ++i)
    assert_int_equal(km_batch_next_size(batches[i].size, batches[i].seconds, 0.1, batches[i].jobs, 768),
                     batches[i].next);
}

/* The stroke of a slider-crank whose slide passes through the crank's pivot is twice the crank. */
static void stroke_of_normal_cranks(void **state) {
  (void)state;
  static const double steps = 8.0; /* both dead centres are rows */
  enum { COUNT = 1000 };
  for (int method = KM_SAMPLING_SOBOL; method <= KM_SAMPLING_RANDOM; ++method) {
    designs d;
    km_design_statistics st;
    designs_of_cranks(&d, COUNT);
    d.options[0].numbers = &steps;
    d.spreads[1] = (km_design_spread){1, KM_NORMAL, .mean = -1.5, .deviation = 0.01};
    static const double range[2] = {0.5 * M_PI, 2.5 * M_PI};
    d.options[d.questions[0].option_count++] = (km_design_option){.name = "range", .numbers = range, .number_count = 2};
    d.sample.method = (km_sampling)method;
    km_design_study *s = designs_run(&d, NULL, 2);
    assert_int_equal(km_design_study_statistics(s, 0, &st, NULL), KM_OK);
    assert_int_equal(st.count, COUNT);
    /* four standard errors of the mean and of the deviation */
    assert_near(st.mean, 1.2, 4.0 * 0.008 / sqrt(COUNT));
    assert_near(st.deviation, 0.008, 4.0 * 0.008 / sqrt(2.0 * COUNT));
    assert_near(st.quantiles[3], 1.2, 4.0 * 0.008 * 1.2533 / sqrt(COUNT));
    km_design_study_free(s);
  }
}

static void samples_by_number(void **state) {
  (void)state;
  designs d;
  enum { COUNT = 200 };
  double up[COUNT][2], value[2];
  for (int method = KM_SAMPLING_SOBOL; method <= KM_SAMPLING_RANDOM; ++method) {
    bool slices[2][COUNT] = {{false}};
    designs_of_cranks(&d, COUNT);
    d.sample.method = (km_sampling)method;
    d.spreads[0] = (km_design_spread){0, KM_UNIFORM, .low = 0.0, .high = 1.0};
    d.spreads[1] = (km_design_spread){1, KM_UNIFORM, .low = 0.0, .high = 1.0};
    km_sampler *s = km_sampler_create(&d.sample);
    for (int i = 0; i < COUNT; ++i) {
      km_sampler_values(s, i, 2, up[i]);
      for (int k = 0; k < 2; ++k) {
        assert_true(up[i][k] > 0.0 && up[i][k] < 1.0);
        slices[k][(int)(up[i][k] * COUNT)] = true;
      }
    }
    for (int i = COUNT - 1; i >= 0; i -= 7) {
      km_sampler_values(s, i, 2, value);
      assert_memory_equal(value, up[i], sizeof value);
    }
    for (int i = 0; method == KM_SAMPLING_LATIN && i < COUNT; ++i)
      assert_true(slices[0][i] && slices[1][i]);
    km_sampler_free(s);
  }
}

static void truncated_tails(void **state) {
  (void)state;
  designs d;
  designs_of_cranks(&d, 2000);
  d.sample.method = KM_SAMPLING_RANDOM;
  d.spreads[0] = (km_design_spread){0, KM_TRUNCATED_NORMAL, .mean = 0.0, .deviation = 1.0, .low = 6.0, .high = 7.0};
  d.sample.spread_count = 1;
  km_sampler *s = km_sampler_create(&d.sample);
  double sum = 0.0, value[2];
  for (int i = 0; i < 2000; ++i) {
    km_sampler_values(s, i, 2, value);
    assert_true(value[0] >= 6.0 && value[0] <= 7.0);
    sum += value[0] / 2000.0;
  }
  /* mean of the tail beyond a = 6: φ(a)/Q(a) = 6.158260; the part beyond 7 is 0.0011 of it */
  assert_near(sum, 6.1573, 4.0 * 0.15 / sqrt(2000.0));
  km_sampler_free(s);
}

/* A design that can't be patched goes through the reader, which reports its errors. */
static void faulty_designs_are_results(void **state) {
  (void)state;
  designs d;
  designs_of_model(&d, "slider_crank", "forces");
  designs_add_parameter(&d, "crank.mass");
  designs_add_parameter(&d, "fixed.slide.z");
  designs_add_figure(&d, "force", KM_DESIGN_MAX, "f.A");
  static const double steps = 4.0, values[3][2] = {{1.0, 0.1}, {-1.0, 0.1}, {1.0, 5.0}};
  const km_design_variant variants[3] = {{"good", values[0]}, {"negative", values[1]}, {"open", values[2]}};
  designs_set_number(&d, "steps", &steps);
  d.def.variants = variants;
  d.def.variant_count = 3;
  km_design_study *s = designs_run(&d, NULL, 2);
  assert_true(s->patch.is_valid);
  assert_int_equal(designs_result(s, 0).outcome, KM_DESIGN_DONE);
  assert_int_equal(designs_result(s, 1).outcome, KM_DESIGN_FAULTY);
  assert_non_null(strstr(designs_result(s, 1).reason, "mass"));
  assert_int_equal(designs_result(s, 2).outcome, KM_DESIGN_UNASSEMBLED);
  assert_true(isnan(designs_result(s, 2).figures[0]));
  km_design_yield y;
  assert_int_equal(km_design_study_yield(s, &y, NULL), KM_OK);
  assert_int_equal(y.count, 3);
  assert_int_equal(y.good, 1);
  km_design_study_free(s);
}

static bool stop_soon(void *context, double done) {
  (void)done;
  return --*(int *)context > 0;
}

static void cancelled_runs_go_on(void **state) {
  (void)state;
  designs d;
  km_design_study *s, *whole;
  km_error error;
  int rounds = 2;
  designs_of_cranks(&d, 500);
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &s, &error), KM_OK);
  assert_int_equal(km_design_study_run(s, 1, stop_soon, &rounds, &error), KM_CANCELLED);
  int had = km_design_study_computed(s);
  assert_true(had > 0 && had < 500);
  assert_int_equal(km_design_study_run(s, 2, NULL, NULL, &error), KM_OK);
  assert_int_equal(km_design_study_found(s), had);
  whole = designs_run(&d, NULL, 1);
  for (int i = 0; i < 500; ++i) {
    km_design_result a = designs_result(s, i), b = designs_result(whole, i);
    assert_memory_equal(a.figures, b.figures, 2 * sizeof(double));
  }
  km_design_study_free(whole);
  km_design_study_free(s);
}

/* A record begins with the model's hash, its units and the characteristic length shared by all designs. */
static void records_name_the_model(void **state) {
  (void)state;
  designs d;
  km_arena arena = {0};
  km_value *record;
  designs_of_cranks(&d, 8);
  km_design_study *s = designs_run(&d, NULL, 1);
  fixture f = fixture_open("slider_crank");
  assert_int_equal(km_designs_record(s, &d.def, "study", &arena, &record, NULL), KM_OK);
  assert_string_equal(km_value_get(record, "model_sha256")->string, f.model->sha256);
  assert_string_equal(km_value_get(km_value_get(record, "units"), "length")->string, "meters");
  assert_near(km_value_get(record, "characteristic_length")->number, f.mechanism->length, 1e-14 * f.mechanism->length);
  fixture_close(&f);
  km_arena_free(&arena);
  km_design_study_free(s);
}

static km_status reciprocal(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)x, (void)error;
  f[0] = HUGE_VAL;
  f[1] = -HUGE_VAL;
  f[2] = 1.0;
  return KM_OK;
}

/* Numbers that JSON can't represent have a word. */
static void infinite_figures_say_so(void **state) {
  (void)state;
  designs d;
  km_arena arena = {0};
  km_value *record;
  designs_of_function(&d, reciprocal, 1, 3);
  d.spreads[0] = (km_design_spread){0, KM_UNIFORM, .low = 0.0, .high = 1.0};
  d.sample = (km_design_sample){.count = 2, .seed = 1, .spreads = d.spreads, .spread_count = 1};
  d.def.sample = &d.sample;
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_designs_record(s, &d.def, "study", &arena, &record, NULL), KM_OK);
  const km_value *design = km_value_get(record, "designs")->first, *states = km_value_get(design, "states");
  assert_int_equal(km_value_get(km_value_get(design, "figures"), "f0")->kind, KM_NULL);
  assert_string_equal(km_value_get(states, "f0")->string, "infinite");
  assert_string_equal(km_value_get(states, "f1")->string, "minus infinite");
  assert_null(km_value_get(states, "f2"));
  km_arena_free(&arena);
  km_design_study_free(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(as_by_hand),
                                     cmocka_unit_test(tracks_as_by_hand),
                                     cmocka_unit_test(threads_change_nothing),
                                     cmocka_unit_test(batches_fill_the_lanes),
                                     cmocka_unit_test(stroke_of_normal_cranks),
                                     cmocka_unit_test(samples_by_number),
                                     cmocka_unit_test(truncated_tails),
                                     cmocka_unit_test(faulty_designs_are_results),
                                     cmocka_unit_test(cancelled_runs_go_on),
                                     cmocka_unit_test(records_name_the_model),
                                     cmocka_unit_test(infinite_figures_say_so)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
