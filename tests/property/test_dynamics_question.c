/* Questions of kinds "run" and "inverse" give the rows of km_history_run and km_inverse_run, in studies too, and their
 * figures over time agree with closed forms. */
#include "support/designs.h"
#include "support/support.h"

#include "kmech/question.h"
#include "study/design_study.h"

#include <math.h>
#include <string.h>

static km_question *question(const fixture *f, const char *kind) {
  km_question *q;
  km_error error;
  if (km_question_create(f->mechanism, kind, &q, &error))
    fail_msg("%s", error.text);
  return q;
}

static void set(km_question *q, const char *option, km_option_value value) {
  km_error error;
  if (km_question_set(q, option, &value, &error))
    fail_msg("%s", error.text);
}

static void set_number(km_question *q, const char *option, double number) {
  set(q, option, (km_option_value){.numbers = {number}});
}

static void ask(km_question *q, const fixture *f, km_status expected) {
  km_error error = {0};
  km_status status = km_question_compute(q, f->state, &error);
  if (status != expected)
    fail_msg("status %d instead of %d: %s", (int)status, (int)expected, error.text);
}

/* Bit for bit. */
static void assert_same_table(const km_table *a, const km_table *b) {
  size_t columns = km_table_columns(a);
  assert_int_equal(columns, km_table_columns(b));
  assert_int_equal(km_table_rows(a), km_table_rows(b));
  assert_true(km_table_rows(a) > 1);
  for (size_t c = 0; c < columns; ++c)
    assert_string_equal(km_table_name(a, c), km_table_name(b, c));
  for (size_t r = 0; r < km_table_rows(a); ++r)
    assert_memory_equal(km_table_row(a, r), km_table_row(b, r), columns * sizeof(double));
}

/* Table of a run of a model, with rows of coordinates and rates only. The caller frees it. */
static km_history history_of_model(const char *name, double until, bool kinematics_only) {
  fixture f = fixture_open(name);
  km_forces *forces;
  km_history h;
  km_history_def def = km_history_default(f.model);
  def.until = until;
  def.every = until / 40.0;
  def.kinematics_only = kinematics_only;
  assert_int_equal(km_forces_create_own(f.mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
  km_forces_free(forces);
  fixture_close(&f);
  return h;
}

/* Rows without accelerations have the bits of complete ones; also with friction by reactions (brake), whose rows need
 * accelerations, and with weak constraints (a02). */
static void rows_of_rates_alone(void **unused) {
  (void)unused;
  static const struct {
    const char *model;
    double until;
  } runs[] = {{"slider_crank", 5.0}, {"bricard", 3.0},  {"vehicle_circle", 0.5}, {"excavator", 1.0},
              {"striker", 3.0},      {"stewart", 0.05}, {"brake", 0.02},         {"a02", 1.0}};
  for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
    km_history a = history_of_model(runs[i].model, runs[i].until, false);
    km_history b = history_of_model(runs[i].model, runs[i].until, true);
    assert_int_equal(km_table_rows(a.table), km_table_rows(b.table));
    assert_int_equal(a.figures.evaluations, b.figures.evaluations);
    for (size_t c = 0; c < km_table_columns(a.table); ++c) {
      const char *name = km_table_name(a.table, c);
      const bool is_kept = strcmp(name, "t") == 0 || strncmp(name, "q.", 2) == 0 || strncmp(name, "v.", 2) == 0;
      for (size_t r = 0; r < km_table_rows(a.table); ++r) {
        const double value = km_table_row(b.table, r)[c];
        if (!(is_kept ? value == km_table_row(a.table, r)[c] : isnan(value)))
          fail_msg("%s: %s of row %zu is %.17g instead of %.17g", runs[i].model, name, r, value,
                   km_table_row(a.table, r)[c]);
      }
    }
    km_history_free(&a);
    km_history_free(&b);
  }
}

static void a_run_is_the_history(void **unused) {
  (void)unused;
  static const int joint = 0;
  static const double rate = 3.0;
  fixture asked = fixture_open("slider_crank"), direct = fixture_open("slider_crank");
  km_question *q = question(&asked, "run");
  set_number(q, "until", 1.0);
  set_number(q, "every", 0.05);
  set(q, "reactions", (km_option_value){.flag = true});
  set(q, "rate", (km_option_value){.coordinates = &joint, .settings = &rate, .count = 1});
  for (int i = 0; i < 2; ++i) { /* the state stays at the start */
    ask(q, &asked, KM_OK);
    assert_true(km_state_coordinate(asked.state, joint) == km_state_coordinate(direct.state, joint));
  }
  km_forces *forces;
  km_history history;
  km_history_def def = km_history_default(direct.model);
  def.until = 1.0;
  def.every = 0.05;
  def.reactions = true;
  assert_int_equal(km_forces_create_own(direct.mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_state_set_rate(direct.mechanism, direct.state, joint, rate, NULL), KM_OK);
  assert_int_equal(km_history_run(direct.mechanism, forces, direct.state, &def, &history, NULL), KM_OK);
  assert_same_table(km_question_table(q), history.table);
  assert_ptr_equal(km_question_table(q), km_question_history(q)->table);
  assert_null(km_question_motion(q));
  assert_null(km_question_track(q));
  km_history_free(&history);
  km_forces_free(forces);
  km_question_free(q);
  fixture_close(&asked);
  fixture_close(&direct);
}

static void an_inverse_motion_is_the_history(void **unused) {
  (void)unused;
  const km_constant_rate rate = {0, 5.0};
  fixture asked = fixture_open("slider_crank"), direct = fixture_open("slider_crank");
  km_question *q = question(&asked, "inverse");
  set(q, "steps", (km_option_value){.whole = 24});
  set(q, "rate", (km_option_value){.coordinates = &rate.coordinate, .settings = &rate.rate, .count = 1});
  ask(q, &asked, KM_OK);
  km_forces *forces;
  km_history history;
  km_inverse_def def = km_inverse_default(direct.mechanism, &rate, 1);
  assert_true(fabs(def.until - 2.0 * M_PI / 5.0) < 1e-15);
  def.steps = 24;
  assert_int_equal(km_forces_create_own(direct.mechanism, &forces, NULL), KM_OK);
  assert_int_equal(km_inverse_run(direct.mechanism, forces, direct.state, &def, &history, NULL), KM_OK);
  assert_same_table(km_question_table(q), history.table);
  assert_int_equal(km_question_event_count(q), history.peak_count);
  assert_true(km_question_event_at(q, 0).value == history.peaks[0].value);
  assert_string_equal(km_question_event_at(q, 0).subject, "A");
  km_history_free(&history);
  km_forces_free(forces);
  km_question_free(q);
  fixture_close(&asked);
  fixture_close(&direct);
}

/* A pendulum of length 1 under g = 9.81: a stop is located, a limit that is passed makes the answer partial. */
static const char pendulum[] =
    "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"radians\"}, \"gravity\": [0, -9.81, 0]},"
    "\"assemblies\": [{\"name\": \"pendulum\", \"bodies\": [{\"name\": \"bob\", \"mass\": 2, \"center_of_mass\": [1, 0, 0],"
    "\"moment_of_inertia\": {\"Ixx\": 0, \"Iyy\": 0, \"Izz\": 0}}],"
    "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"origin\"], [\"bob\", "
    "\"origin\"]], \"limits\": [-2, 2]}]}]}";

static void stops_and_limits(void **unused) {
  (void)unused;
  static const int joint = 0;
  static const double bottom = -M_PI / 2.0;
  fixture f = fixture_read(pendulum);
  km_question *q = question(&f, "run");
  set_number(q, "until", 2.0);
  set_number(q, "rtol", 1e-10);
  set_number(q, "atol", 1e-10);
  ask(q, &f, KM_PARTIAL); /* it swings to −π, past −2 */
  assert_int_equal(km_question_event_count(q), 1);
  assert_string_equal(km_question_event_at(q, 0).name, "limit");
  set(q, "ignore-limits", (km_option_value){.flag = true});
  ask(q, &f, KM_OK);
  set(q, "stop", (km_option_value){.coordinates = &joint, .settings = &bottom, .count = 1});
  ask(q, &f, KM_OK);
  /* A quarter of the period of swings by 90° is K(sin 45°) sqrt(length/g). */
  const double quarter = 1.8540746773013719 / sqrt(9.81);
  double time, rate;
  assert_int_equal(km_table_figure(km_question_table(q), "t", KM_FIGURE_LAST, 0, &time, NULL, NULL), KM_OK);
  assert_int_equal(km_table_figure(km_question_table(q), "v.A", KM_FIGURE_PEAK, 0, &rate, NULL, NULL), KM_OK);
  assert_true(fabs(time - quarter) < 1e-8);
  assert_true(fabs(rate - sqrt(2.0 * 9.81)) < 1e-8);
  assert_string_equal(km_question_event_at(q, 0).name, "crossing");
  assert_true(fabs(km_question_event_at(q, 0).s - quarter) < 1e-8);
  km_question_free(q);
  fixture_close(&f);
}

static void refusals(void **unused) {
  (void)unused;
  static const int joint = 0;
  static const double wrong = NAN;
  fixture f = fixture_read(pendulum);
  km_question *q = question(&f, "run");
  km_error e = {0};
  km_option_value value = {.coordinates = &joint, .settings = &wrong, .count = 1};
  assert_int_equal(km_question_set(q, "rate", &value, &e), KM_USAGE);
  assert_non_null(strstr(e.text, "`rate`: a value that isn't finite"));
  value = (km_option_value){.coordinates = &joint, .count = 1};
  assert_int_equal(km_question_set(q, "rate", &value, &e), KM_USAGE);
  set(q, "integrator", (km_option_value){.whole = KM_INTEGRATOR_FIXED});
  assert_int_equal(km_question_compute(q, f.state, &e), KM_USAGE);
  assert_non_null(strstr(e.text, "`integrator` fixed: expected `max-step`"));
  assert_int_equal(km_question_compute_here(q, f.state, &e), KM_USAGE);
  km_question_free(q);
  q = question(&f, "inverse");
  set_number(q, "until", 1.0);
  assert_int_equal(km_question_compute(q, f.state, &e), KM_USAGE);
  assert_non_null(strstr(e.text, "no motion is prescribed"));
  assert_null(km_question_table(q));
  km_question_free(q);
  fixture_close(&f);
}

/* Figures of y = e^(−t) cos(20 t) and of y = t on 0 … 4, by rows so close that the trapezoidal rule errs by less than
 * the tolerances. */
static void figures_over_time(void **unused) {
  (void)unused;
  enum { ROWS = 40001 };
  km_table *table = km_table_create();
  km_table_add_plain_column(table, "t", "s");
  km_table_add_plain_column(table, "y", "");
  km_table_add_plain_column(table, "ramp", "");
  for (int r = 0; r < ROWS; ++r) {
    double t = 4.0 * r / (ROWS - 1);
    memcpy(km_table_add_row(table), (double[]){t, exp(-t) * cos(20.0 * t) - 2.0, t}, 3 * sizeof t);
  }
  double value, where;
  km_table_figure(table, "ramp", KM_FIGURE_RMS, 0, &value, &where, NULL);
  assert_true(fabs(value - 4.0 / sqrt(3.0)) < 1e-12);
  km_table_figure(table, "ramp", KM_FIGURE_SETTLING, 0.02, &value, &where, NULL);
  assert_true(fabs(value - 4.0 * 0.98) < 1e-9);
  km_table_figure(table, "ramp", KM_FIGURE_MEAN, 0, &value, &where, NULL);
  assert_true(fabs(value - 2.0) < 1e-12);
  km_table_figure(table, "y", KM_FIGURE_PEAK, 0, &value, &where, NULL); /* y' = 0: tan 20 t = −1/20, second half wave */
  double least = (M_PI - atan(0.05)) / 20.0;
  assert_true(fabs(where - least) < 1e-4);
  assert_true(fabs(value - fabs(exp(-least) * cos(20.0 * least) - 2.0)) < 1e-6);
  km_table_figure(table, "y", KM_FIGURE_LAST, 0, &value, &where, NULL);
  assert_true(where == 4.0 && fabs(value - (exp(-4.0) * cos(80.0) - 2.0)) < 1e-15);
  km_table_free(table);
}

/* Runs of a study have the bits of runs by hand, for one and two threads; masses are patched. */
static void runs_of_a_study(void **unused) {
  (void)unused;
  static const double masses[3] = {1.0, 1.5, 0.7}, until = 1.5;
  static const char *const names[3] = {"a", "b", "c"};
  for (int jobs = 1; jobs <= 2; ++jobs) {
    designs d;
    km_design_variant variants[3];
    designs_of_model(&d, "slider_crank", "run");
    designs_add_parameter(&d, "bodies.crank.mass");
    designs_add_figure(&d, "peak", KM_DESIGN_PEAK, "v.A");
    designs_set_number(&d, "until", &until);
    for (int i = 0; i < 3; ++i)
      variants[i] = (km_design_variant){names[i], &masses[i]};
    d.def.variants = variants;
    d.def.variant_count = 3;
    km_design_study *s = designs_run(&d, NULL, jobs);
    for (int i = 0; i < 3; ++i) {
      km_evaluated_design a;
      double wanted;
      assert_int_equal(km_design_study_evaluate(s, i, 0, &a, NULL), KM_OK);
      km_table_figure(km_question_table(a.question), "v.A", KM_FIGURE_PEAK, 0, &wanted, NULL, NULL);
      assert_true(wanted > 1.0);
      assert_memory_equal(&designs_result(s, i).figures[0], &wanted, sizeof wanted);
      km_evaluated_design_free(&a);
    }
    km_design_study_free(s);
  }
}

/* A formula of two figures has the bits of their quotient; NaN stays NaN. */
static void figures_by_formula(void **unused) {
  (void)unused;
  static const double masses[2] = {1.0, 1.5}, until = 1.0;
  designs d;
  const km_design_variant variants[2] = {{"a", &masses[0]}, {"b", &masses[1]}};
  designs_of_model(&d, "slider_crank", "run");
  designs_add_parameter(&d, "bodies.crank.mass");
  designs_add_figure(&d, "peak", KM_DESIGN_PEAK, "v.A");
  designs_add_figure(&d, "end", KM_DESIGN_LAST, "v.A");
  designs_add_figure(&d, "ratio", KM_DESIGN_FORMULA, "end/peak");
  designs_add_figure(&d, "none", KM_DESIGN_FORMULA, "sqrt(0 - peak) + ratio");
  designs_set_number(&d, "until", &until);
  d.def.variants = variants;
  d.def.variant_count = 2;
  km_design_study *s = designs_run(&d, NULL, 2);
  for (int i = 0; i < 2; ++i) {
    const km_design_result r = designs_result(s, i);
    const double quotient = r.figures[1] / r.figures[0];
    assert_memory_equal(&r.figures[2], &quotient, sizeof quotient);
    assert_true(isnan(r.figures[3]));
  }
  km_design_study_free(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_is_the_history),
      cmocka_unit_test(an_inverse_motion_is_the_history),
      cmocka_unit_test(rows_of_rates_alone),
      cmocka_unit_test(stops_and_limits),
      cmocka_unit_test(refusals),
      cmocka_unit_test(figures_over_time),
      cmocka_unit_test(runs_of_a_study),
      cmocka_unit_test(figures_by_formula),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
