/* Errors of studies of designs before any evaluation, each with its text. */
#include "support/designs.h"
#include "support/refusals.h"

#include "kmech/report.h"

#include <math.h>
#include <stdio.h>

static km_status sum(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0] + x[1];
  f[1] = x[0] - x[1];
  return KM_OK;
}

static const double infinite[2] = {HUGE_VAL, 1.0}, one[2] = {1.0, 1.0};
static const km_design_variant variant = {"v", infinite};
static const km_design_axis no_values = {0, 0, one}, endless = {0, 2, infinite};
static const km_design_axis twice[2] = {{0, 2, one}, {0, 2, one}}, of_another = {7, 2, one};
static double many[100000];
static const km_design_axis large[2] = {{0, 100000, many}, {1, 100000, many}};

/* A study of a function of two numbers with a sample of both. */
static void sampled(designs *d) {
  designs_of_function(d, sum, 2, 2);
  for (int p = 0; p < 2; ++p)
    d->spreads[p] = (km_design_spread){p, KM_UNIFORM, .low = 0.0, .high = 1.0};
  d->sample = (km_design_sample){.count = 16, .seed = 1, .spreads = d->spreads, .spread_count = 2};
  d->def.sample = &d->sample;
}

static void with_grid(designs *d, const km_design_axis *axes, int count) {
  d->def.sample = NULL;
  d->def.axes = axes;
  d->def.axis_count = count;
}

static void optimised(designs *d) {
  d->def.sample = NULL;
  d->variables[0] = (km_design_variable){0, 0.0, 1.0, 0.5};
  d->optimise = (km_design_optimise){.variables = d->variables,
                                     .variable_count = 1,
                                     .goals = {{"f0", false}},
                                     .goal_count = 1,
                                     .algorithm = km_design_algorithm(0),
                                     .evaluations = 10,
                                     .tolerance = 1e-6,
                                     .starts = 1};
  d->def.optimise = &d->optimise;
}

static void no_way(designs *d) {
  d->def.sample = NULL;
}
static void no_model(designs *d) {
  d->def.function = NULL;
}
static void too_many_parameters(designs *d) {
  d->def.parameter_count = KM_MAX_DESIGN_PARAMETERS + 1;
}
static void endless_variant(designs *d) {
  d->def.sample = NULL;
  d->def.variants = &variant;
  d->def.variant_count = 1;
}
static void empty_axis(designs *d) {
  with_grid(d, &no_values, 1);
}
static void endless_axis(designs *d) {
  with_grid(d, &endless, 1);
}
static void axis_twice(designs *d) {
  with_grid(d, twice, 2);
}
static void axis_of_another(designs *d) {
  with_grid(d, &of_another, 1);
}
static void large_grid(designs *d) {
  with_grid(d, large, 2);
}
static void other_distribution(designs *d) {
  d->spreads[0].distribution = (km_distribution)7;
}
static void far_bounds(designs *d) {
  d->spreads[0] = (km_design_spread){0, KM_TRUNCATED_NORMAL, 50.0, 60.0, 0.0, 1.0};
}
static void other_method(designs *d) {
  d->sample.method = (km_sampling)9;
}
static void nothing_spreads(designs *d) {
  d->sample.spread_count = 0;
}
static void spreads_twice(designs *d) {
  d->spreads[1].parameter = 0;
}
static void no_width(designs *d) {
  d->sample.accuracy_figure = "f0";
}
static void nothing_varies(designs *d) {
  optimised(d);
  d->optimise.variable_count = 0;
}
static void start_outside(designs *d) {
  optimised(d);
  d->variables[0].start = 3.0;
}
static void no_goal(designs *d) {
  optimised(d);
  d->optimise.goal_count = 0;
}
static void unnamed_goal(designs *d) {
  optimised(d);
  d->optimise.goals[0].figure = NULL;
}
static void coarse(designs *d) {
  optimised(d);
  d->optimise.tolerance = 1.5;
}
static void unnamed_figure(designs *d) {
  d->figures[0].name = NULL;
}
static void other_figure(designs *d) {
  d->figures[0].kind = KM_DESIGN_FIGURE_KINDS;
}
static void no_limits(designs *d) {
  d->figures[0].low = 2.0;
  d->figures[0].high = 1.0;
}
static void no_column(designs *d) {
  d->questions[0].kind = "mobility";
}
static void no_points(designs *d) {
  d->questions[0].kind = "mobility";
  d->figures[0].kind = d->figures[1].kind = KM_DESIGN_DISTANCE;
  d->figures[0].column = "a/b";
}
static void no_question(designs *d) {
  d->def.question_count = 0;
}
static void unnamed_question(designs *d) {
  d->questions[0].name = NULL;
}
static void question_twice(designs *d) {
  d->questions[1] = d->questions[0];
  d->def.question_count = 2;
}
static void two_questions(designs *d) {
  d->questions[1] = (km_design_question){.name = "other"};
  d->def.question_count = 2;
}
static void too_many_figures(designs *d) {
  d->questions[0].figure_count = KM_MAX_DESIGN_FIGURES + 1;
}
static void figure_twice(designs *d) {
  d->figures[1].name = d->figures[0].name;
}

static const struct {
  void (*spoil)(designs *d);
  const char *words;
} spoilt[] = {
    {no_way, "found 0 of variants, grid, sample and optimise; expected just one"},
    {no_model, "model: expected a file"},
    {too_many_parameters, "parameters: found 33; expected at most 32"},
    {endless_variant, "variants.v: a value that isn't finite"},
    {empty_axis, "grid.x0: found no values; expected at least one"},
    {endless_axis, "grid.x0: a value that isn't finite"},
    {axis_twice, "grid.x0: it has two axes"},
    {axis_of_another, "grid: there is no parameter 7; expected 0 to 1"},
    {large_grid, "grid: found 1e+10 designs; expected at most"},
    {other_distribution, "sample.parameters.x0: there is no such distribution"},
    {far_bounds, "sample.parameters.x0: found bounds [50, 60] more than 8 deviations from the mean 0"},
    {other_method, "sample.method: there is no such method"},
    {nothing_spreads, "sample.parameters: found none; expected at least one that spreads"},
    {spreads_twice, "sample.parameters.x0: it is there twice"},
    {no_width, "sample.accuracy: found a half width of 0"},
    {nothing_varies, "optimise.variables: found none; expected at least one"},
    {start_outside, "optimise.variables.x0: the start 3 lies outside [0, 1]"},
    {no_goal, "optimise: found 0 goals; expected one or two"},
    {unnamed_goal, "optimise.minimise: expected the name of a figure"},
    {coarse, "optimise.tolerance: found 1.5; expected at least 0 and less than 1"},
    {unnamed_figure, "a figure has no name"},
    {other_figure, "figures.f0: there is no such kind of figure"},
    {no_limits, "figures.f0: found limits [2, 1]; expected low ≤ high"},
    {no_column, "figures.f0: expected a column"},
    {no_points, "figures.f0: found no points; expected at least one"},
    {no_question, "ask: found 0 questions; expected 1 to 16"},
    {unnamed_question, "ask[0]: expected a name and a kind of question"},
    {question_twice, "ask: two questions are called"},
    {two_questions, "a function answers one question without kind and bands"},
    {too_many_figures, "ask: more than 64 figures"},
    {figure_twice, "ask: two figures are called \"f0\""},
};

static void studies_are_refused(void **state) {
  (void)state;
  int silent = 0;
  for (size_t i = 0; i < COUNT(spoilt); ++i) {
    designs d;
    km_design_study *study = NULL;
    km_error error = {.text = ""};
    sampled(&d);
    spoilt[i].spoil(&d);
    km_status status = km_design_study_open(&d.def, NULL, false, &study, &error);
    const told_text t = {"a study", spoilt[i].words};
    silent += !is_told(&t, status, KM_USAGE, NULL, &error);
    km_design_study_free(study);
  }
  assert_int_equal(silent, 0);
}

static bool stop(void *context, double done) {
  (void)context, (void)done;
  return false;
}

/* Runs that are stopped, and more dimensions than Sobol's sequence has: two for each of 24 parameters. */
static void runs_are_refused(void **state) {
  (void)state;
  enum { MANY = 24 };
  designs d;
  km_design_study *study = NULL;
  km_error error = {.text = ""};
  const told_text stopped = {"a run", "stopped after"},
                  dimensions = {"a sample", "a Sobol sequence has at most 40 dimensions, and 48"};
  static char names[MANY][16];
  static km_design_parameter parameters[MANY];
  static km_design_spread spreads[MANY];
  sampled(&d);
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &study, &error), KM_OK);
  km_status status = km_design_study_run(study, 1, stop, NULL, &error);
  assert_words(&stopped, status, KM_CANCELLED, NULL, &error);
  km_design_study_free(study);
  for (int p = 0; p < MANY; ++p) {
    snprintf(names[p], sizeof names[p], "x%d", p);
    parameters[p] = (km_design_parameter){names[p], names[p]};
    spreads[p] = (km_design_spread){p, KM_UNIFORM, .low = 0.0, .high = 1.0};
  }
  d.def.parameters = parameters;
  d.def.parameter_count = MANY;
  d.sample = (km_design_sample){.count = 4, .seed = 1, .spreads = spreads, .spread_count = MANY, .indices = true};
  status = km_design_study_open(&d.def, NULL, false, &study, &error);
  assert_words(&dimensions, status, KM_USAGE, NULL, &error);
}

/* A joint that is held twice, and a picture that isn't one. */
static void holds_and_pictures(void **state) {
  (void)state;
  static const km_design_setting held_twice[2] = {{"A", 0.1}, {"A", 0.2}};
  designs d;
  km_design_study *study = NULL;
  km_error e = {.text = ""};
  km_text out = {0};
  const told_text held = {"holds", "\"A\" is named twice"}, none = {"a picture", "found no picture of a study"};
  const told_text few = {"a convergence of 16 designs", "there is nothing to draw"};
  designs_of_model(&d, "fourbar", "mobility");
  d.questions[0].holds = held_twice;
  d.questions[0].hold_count = 2;
  designs_add_figure(&d, "grip", KM_DESIGN_MIN, "m.A");
  designs_add_parameter(&d, "rocker.mass");
  d.spreads[0] = (km_design_spread){0, KM_UNIFORM, .low = 1.0, .high = 2.0};
  d.sample = (km_design_sample){.count = 2, .seed = 1, .spreads = d.spreads, .spread_count = 1};
  d.def.sample = &d.sample;
  km_status status = km_design_study_open(&d.def, NULL, false, &study, &e);
  assert_words(&held, status, status, NULL, &e);
  sampled(&d);
  study = designs_run(&d, NULL, 1);
  status = km_designs_picture(study, &d.def, "x", (km_designs_plot)99, 0, 0, KM_PICTURE_SVG, &out, &e);
  assert_words(&none, status, KM_USAGE, NULL, &e);
  status = km_designs_picture(study, &d.def, "x", KM_DESIGNS_CONVERGENCE, 0, 0, KM_PICTURE_SVG, &out, &e);
  assert_words(&few, status, KM_NO_RESULT, NULL, &e);
  km_text_free(&out);
  km_design_study_free(study);
}

static bool refuse(void *context, double done) {
  (void)context, (void)done;
  return false;
}

static void optimisations_can_be_stopped(void **state) {
  (void)state;
  designs d;
  km_design_study *study = NULL;
  km_error e = {.text = ""};
  const told_text stopped = {"a callback that refuses", "designs; what was answered is stored"};
  designs_of_function(&d, sum, 2, 2);
  optimised(&d);
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &study, &e), KM_OK);
  assert_words(&stopped, km_design_study_run(study, 1, refuse, NULL, &e), KM_CANCELLED, NULL, &e);
  km_design_study_free(study);
}

/* A function gives figures only: it has no answer to draw. */
static void no_answers(void **state) {
  (void)state;
  static const double values[2] = {1.0, 2.0};
  static const km_design_variant both = {"both", values};
  designs d;
  km_error e = {.text = ""};
  km_text out = {0};
  const told_text none = {"a picture", "no design has an answer"};
  designs_of_function(&d, sum, 2, 2);
  d.def.variants = &both;
  d.def.variant_count = 1;
  km_design_study *study = designs_run(&d, NULL, 1);
  km_status status = km_designs_picture(study, &d.def, "x", KM_DESIGNS_ANSWERS, 0, 0, KM_PICTURE_SVG, &out, &e);
  assert_words(&none, status, KM_NO_RESULT, NULL, &e);
  assert_int_equal(out.size, 0);
  km_text_free(&out);
  km_design_study_free(study);
}

/* One worker process that sends one message. */
typedef struct talk {
  bool sends;
  int from; /* size of the message; −1: none */
  const void *bytes;
  size_t size;
} talk;

static bool say(void *context, int member, const void *bytes, size_t size) {
  (void)member, (void)bytes, (void)size;
  return ((const talk *)context)->sends;
}

static int hear(void *context, bool wait, const void **bytes, size_t *size) {
  const talk *t = context;
  *bytes = t->bytes;
  *size = t->size;
  return wait ? t->from : -1;
}

/* Worker processes whose messages fail or are invalid. */
static void crews_are_refused(void **state) {
  (void)state;
  static const int answers = 2; /* the word that begins a member's answers */
  static const struct {
    int what;
    char text[8];
  } failed = {3, "no more"}; /* the word that begins a member's complaint */
  struct {
    talk talk;
    const char *words;
  } led[] = {{{false, 1, "", 0}, "rank 1 can't be reached"},
             {{true, -1, NULL, 0}, "the other ranks can't be reached"},
             {{true, 1, &failed, sizeof failed}, "rank 1: no more"},
             {{true, 1, &answers, sizeof answers}, "rank 1 sent an answer that can't be read"}};
  designs d;
  km_design_study *study = NULL;
  km_error e = {.text = ""};
  sampled(&d);
  for (size_t i = 0; i < COUNT(led); ++i) {
    const km_design_workers crew = {.context = &led[i].talk, .size = 1, .send = say, .receive = hear};
    const told_text t = {"a crew", led[i].words};
    assert_int_equal(km_design_study_open(&d.def, NULL, false, &study, &e), KM_OK);
    km_status status = km_design_study_run_leader(study, 1, &crew, NULL, NULL, &e);
    assert_words(&t, status, KM_IO, NULL, &e);
    km_design_study_free(study);
  }
  talk nobody = {true, -1, NULL, 0};
  const km_design_workers few = {&nobody, -1, say, hear}, alone = {&nobody, 1, say, hear};
  const told_text size = {"a crew", "found -1 worker processes; expected at least 0"},
                  leader = {"a crew", "the leader can't be reached"};
  const told_text threads = {"a crew", "found 0 threads; expected 1 to 1024"};
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &study, &e), KM_OK);
  km_status status = km_design_study_run_worker(study, 1, &few, &e);
  assert_words(&size, status, KM_USAGE, NULL, &e);
  status = km_design_study_run_worker(study, 0, &alone, &e);
  assert_words(&threads, status, KM_USAGE, NULL, &e);
  status = km_design_study_run_worker(study, 1, &alone, &e);
  assert_words(&leader, status, KM_IO, NULL, &e);
  km_design_study_free(study);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(studies_are_refused), cmocka_unit_test(runs_are_refused),
      cmocka_unit_test(crews_are_refused),   cmocka_unit_test(holds_and_pictures),
      cmocka_unit_test(no_answers),          cmocka_unit_test(optimisations_can_be_stopped)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
