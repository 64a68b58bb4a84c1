/* Questions give what the analyses give by themselves: rows, one row at a pose, events, figures of merit. */
#include "support/support.h"

#include "base/memory.h"
#include "kmech/question.h"

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

static void ask(km_question *q, fixture *f, km_status expected) {
  km_error error = {0};
  km_status status = km_question_compute(q, f->state, &error);
  if (status != expected)
    fail_msg("status %d instead of %d: %s", (int)status, (int)expected, error.text);
}

/* Bit for bit, with the same columns. */
static void assert_same_table(const km_table *a, const km_table *b) {
  assert_int_equal(km_table_columns(a), km_table_columns(b));
  assert_int_equal(km_table_rows(a), km_table_rows(b));
  assert_true(km_table_rows(a) > 0);
  for (size_t c = 0; c < km_table_columns(a); ++c)
    assert_string_equal(km_table_name(a, c), km_table_name(b, c));
  for (size_t r = 0; r < km_table_rows(a); ++r)
    assert_memory_equal(km_table_row(a, r), km_table_row(b, r), km_table_columns(a) * sizeof(double));
}

static void test_mobility_is_the_sweep(void **unused) {
  (void)unused;
  fixture asked = fixture_open("brake"), direct = fixture_open("brake");
  km_question *q = question(&asked, "mobility");
  km_sweep_plan plan = km_sweep_plan_default(direct.model);
  km_mobility_sweep sweep;
  km_error error;
  plan.from = 21.0;
  plan.to = 29.0;
  plan.steps = 17;
  set(q, "range", (km_option_value){.numbers = {21.0, 29.0}});
  set(q, "steps", (km_option_value){.whole = 17});
  ask(q, &asked, KM_OK);
  assert_int_equal(km_mobility_sweep_run(direct.mechanism, direct.state, &plan, &sweep, &error), KM_OK);
  assert_same_table(km_question_table(q), sweep.motion.table);
  assert_null(km_question_advantage(q));
  km_mobility_sweep_free(&sweep);
  km_question_free(q);
  fixture_close(&asked);
  fixture_close(&direct);
}

/* A question that is computed again reuses the memory of its last answer. */
static void test_the_next_answer_is_as_the_first(void **unused) {
  (void)unused;
  fixture asked = fixture_open("excavator"), other = fixture_open("excavator");
  km_question *again = question(&asked, "mobility");
  set(again, "steps", (km_option_value){.whole = 40});
  ask(again, &asked, KM_OK);
  for (int round = 0; round < 3; ++round) {
    km_question *first = question(&other, "mobility");
    if (round > 0)
      set(again, "steps", (km_option_value){.whole = 10 + round});
    set(first, "steps", (km_option_value){.whole = round > 0 ? 10 + round : 40});
    for (int i = 0; i < 2 && round == 2; ++i)
      set(i ? first : again, "singularities", (km_option_value){.flag = true}); /* another column */
    km_state_restart(asked.state);
    km_state_restart(other.state);
    assert_int_equal(km_assemble(asked.mechanism, asked.state, NULL, NULL), KM_OK);
    assert_int_equal(km_assemble(other.mechanism, other.state, NULL, NULL), KM_OK);
    ask(again, &asked, KM_OK);
    ask(first, &other, KM_OK);
    assert_same_table(km_question_table(again), km_question_table(first));
    km_question_free(first);
  }
  km_question_free(again);
  fixture_close(&asked);
  fixture_close(&other);
}

static void test_row_at_a_pose_is_the_sweeps_row(void **unused) {
  (void)unused;
  static const char *const kinds[] = {"mobility", "advantage", "forces"};
  for (int i = 0; i < 3; ++i) {
    fixture f = fixture_open("excavator");
    km_question *q = question(&f, kinds[i]);
    km_error error;
    ask(q, &f, KM_OK); /* leaves the state at the last row's pose */
    size_t last = km_table_rows(km_question_table(q)) - 1, columns = km_table_columns(km_question_table(q));
    double *row = KM_NEW(double, columns);
    memcpy(row, km_table_row(km_question_table(q), last), columns * sizeof *row);
    assert_int_equal(km_question_compute_here(q, f.state, &error), KM_OK);
    const km_table *here = km_question_table(q);
    assert_int_equal(km_table_rows(here), 1);
    assert_int_equal(km_table_columns(here), columns);
    for (size_t c = 2; c < columns; ++c) { /* after step and s */
      double value = km_table_row(here, 0)[c];
      /* the configuration by other pivots: condition number of the loops times rounding */
      if (isfinite(row[c]))
        assert_near(value, row[c], 1e-7 * (1.0 + fabs(row[c])));
      else
        assert_int_equal(isnan(value), isnan(row[c]));
    }
    km_free(row);
    km_question_free(q);
    fixture_close(&f);
  }
}

/* Every toggle that the typed answer has is an event, and every event lies in the range. */
static void test_events_are_the_toggles(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  km_question *q = question(&f, "mobility");
  ask(q, &f, KM_OK);
  const km_mobility_sweep *sweep = km_question_mobility(q);
  int toggles = 0, count = km_question_event_count(q);
  assert_true(sweep->toggle_count > 0);
  for (int i = 0; i < count; ++i) {
    km_question_event e = km_question_event_at(q, i);
    const km_sweep_plan *plan = km_question_plan(q);
    assert_true(e.s >= fmin(plan->from, plan->to) && e.s <= fmax(plan->from, plan->to));
    if (strcmp(e.name, "toggle") != 0)
      continue;
    assert_near(e.s, sweep->toggles[toggles].s, 0.0);
    assert_string_equal(e.subject, km_model_coordinate_label(f.model, sweep->toggles[toggles].coordinate));
    ++toggles;
  }
  assert_int_equal(toggles, sweep->toggle_count);
  km_question_event none = km_question_event_at(q, count);
  assert_string_equal(none.name, "");
  km_question_free(q);
  fixture_close(&f);
}

/* Toggles first, then the places where the loops come nearest to another freedom, each as the sweep has it. */
static void test_minima_are_events(void **unused) {
  (void)unused;
  int minima = 0;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    if (f.model->sweep.coordinate >= 0) {
      km_question *q = question(&f, "mobility");
      km_error error;
      set(q, "singularities", (km_option_value){.flag = true});
      km_status status = km_question_compute(q, f.state, &error);
      const km_mobility_sweep *sweep = km_question_mobility(q);
      assert_true(status == KM_OK || status == KM_PARTIAL);
      assert_int_equal(km_question_event_count(q),
                       sweep->toggle_count + sweep->minimum_count + sweep->motion.branch_count);
      for (size_t i = 0; i < sweep->minimum_count; ++i, ++minima) {
        km_question_event e = km_question_event_at(q, (int)(sweep->toggle_count + i));
        assert_string_equal(e.name, "minimum");
        assert_near(e.s, sweep->minima[i].s, 0.0);
        assert_near(e.value, sweep->minima[i].number, 0.0);
        assert_true(sweep->smallest.number <= e.value);
      }
      km_question_free(q);
    }
    fixture_close(&f);
  }
  assert_true(minima > 3);
}

/* Twice the gravity alone: twice every force. */
static void test_options_reach_the_forces(void **unused) {
  (void)unused;
  fixture f = fixture_open("excavator");
  km_question *q = question(&f, "forces");
  set(q, "load", (km_option_value){.count = 0});
  set(q, "gravity", (km_option_value){.numbers = {0.0, 0.0, -3.0}});
  ask(q, &f, KM_OK);
  const km_statics_sweep *sweep = km_question_statics(q);
  assert_true(sweep->actuator_count > 0);
  km_span forces = km_table_span(km_question_table(q), "f.");
  double once = km_table_row(km_question_table(q), 3)[forces.first];
  fixture g = fixture_open("excavator");
  km_question *twice = question(&g, "forces");
  set(twice, "load", (km_option_value){.count = 0});
  set(twice, "gravity", (km_option_value){.numbers = {0.0, 0.0, -6.0}});
  ask(twice, &g, KM_OK);
  assert_true(fabs(once) > 0.0);
  assert_near(km_table_row(km_question_table(twice), 3)[forces.first], 2.0 * once, 1e-12 * fabs(once));
  km_question_free(twice);
  km_question_free(q);
  fixture_close(&g);
  fixture_close(&f);
}

static void test_refusals(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  km_question *q, *none;
  km_error error;
  q = question(&f, "mobility");
  assert_int_equal(km_question_create(f.mechanism, "strength", &none, &error), KM_USAGE);
  assert_null(none);
  km_option_value value = {.whole = 0};
  assert_int_equal(km_question_set(q, "stepz", &value, &error), KM_USAGE);
  assert_int_equal(km_question_set(q, "steps", &value, &error), KM_USAGE);
  assert_string_equal(error.text, "`steps` 0: expected a whole number from 1 to 10000000");
  value = (km_option_value){.numbers = {(double)NAN, 1.0}};
  assert_int_equal(km_question_set(q, "range", &value, &error), KM_USAGE);
  value = (km_option_value){.coordinate = 99};
  assert_int_equal(km_question_set(q, "joint", &value, &error), KM_USAGE);
  value = (km_option_value){.count = 2};
  assert_int_equal(km_question_set(q, "point", &value, &error), KM_USAGE);
  assert_null(km_question_table(q));
  set(q, "derivatives", (km_option_value){.flag = true});
  assert_int_equal(km_question_compute(q, f.state, &error), KM_USAGE);
  set(q, "derivatives", (km_option_value){.flag = false});
  set(q, "branch", (km_option_value){.whole = 2});
  assert_int_equal(km_question_compute(q, f.state, &error), KM_USAGE);
  km_question_free(q);
  fixture_close(&f);
}

/* The caller's lists and names may go as soon as they are set. */
static void test_values_are_copied(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  km_question *q = question(&f, "mobility");
  char name[] = "coupler/point";
  km_sweep_point points[1] = {{1, name}};
  set(q, "point", (km_option_value){.count = 1, .points = points});
  memset(name, 'x', sizeof name - 1);
  points[0] = (km_sweep_point){-1, NULL};
  ask(q, &f, KM_OK);
  assert_true(km_table_find(km_question_table(q), "point.coupler/point.x") >= 0);
  km_question_free(q);
  fixture_close(&f);
}

/* A table of s and x: 0 0, 1 4, 2 nan, 4 2. */
static void test_figures(void **unused) {
  (void)unused;
  static const double rows[4][2] = {{0, 0}, {1, 4}, {2, (double)NAN}, {4, 2}};
  km_table *table = km_table_create();
  km_table_add_plain_column(table, "s", "");
  km_table_add_column(table, "x", "mm");
  for (int r = 0; r < 4; ++r)
    memcpy(km_table_add_row(table), rows[r], sizeof rows[r]);
  static const struct {
    km_figure figure;
    double at, value, where;
  } cases[] = {
      {KM_FIGURE_MIN, 0, 0, 0},
      {KM_FIGURE_MAX, 0, 4, 1},
      {KM_FIGURE_SPAN, 0, 4, (double)NAN},
      {KM_FIGURE_MEAN, 0, 2.75, (double)NAN},
      {KM_FIGURE_AT, 0.5, 2.0, 0.5},
      {KM_FIGURE_AT, 4.0, 2.0, 4.0},
      {KM_FIGURE_AT, 5.0, (double)NAN, 5.0},
      {KM_FIGURE_AT, -1.0, (double)NAN, -1.0},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    double value, where;
    km_error error;
    assert_int_equal(km_table_figure(table, "x", cases[i].figure, cases[i].at, &value, &where, &error), KM_OK);
    assert_true(value == cases[i].value || (isnan(value) && isnan(cases[i].value)));
    assert_true(where == cases[i].where || (isnan(where) && isnan(cases[i].where)));
  }
  double value;
  assert_int_equal(km_table_figure(table, "y", KM_FIGURE_MIN, 0, &value, NULL, NULL), KM_USAGE);
  km_table_free(table);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_the_next_answer_is_as_the_first),
      cmocka_unit_test(test_mobility_is_the_sweep),
      cmocka_unit_test(test_row_at_a_pose_is_the_sweeps_row),
      cmocka_unit_test(test_events_are_the_toggles),
      cmocka_unit_test(test_minima_are_events),
      cmocka_unit_test(test_options_reach_the_forces),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_values_are_copied),
      cmocka_unit_test(test_figures),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
