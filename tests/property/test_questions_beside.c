/* Batched questions about variants of a mechanism have the answers of single questions, bit by bit. */
#include "support/support.h"

#include "continuation/batch/batch.h"
#include "question/question.h"

#include <math.h>
#include <string.h>

typedef struct asked {
  const char *kind;
  int steps;
  bool flag;  /* transmission, singularities */
  bool point; /* the output of leverage is a point of the last body, else a joint */
  bool ignore_limits;
  bool short_of_range; /* the first three go over another range than the others */
  bool table_only;     /* batched questions without events; the others with events */
} asked;

static void set(km_question *q, const char *option, km_option_value value) {
  assert_int_equal(km_question_set(q, option, &value, NULL), KM_OK);
}

/* The first coordinate of the driver's substructure from the n-th on that isn't the driver itself. */
static int other_coordinate(const fixture *f, int driver) {
  const int *of = f->mechanism->substructure_of;
  for (int c = f->mechanism->coordinate_count - 1; c >= 0; --c)
    if (c != driver && !f->mechanism->held[c] && of[c] == of[driver])
      return c;
  return driver;
}

/* A frame of a body that moves. */
static int moving_frame(const fixture *f) {
  for (int k = f->model->frame_count - 1; k > 0; --k)
    if (f->model->frames[k].body > 0)
      return k;
  return -1;
}

static void set_ends(km_question *q, const fixture *f, int driver, bool point) {
  km_port in = {.kind = KM_PORT_JOINT, .coordinate = driver, .name = "in"};
  km_port out = {.kind = KM_PORT_JOINT, .coordinate = other_coordinate(f, driver), .name = "out"};
  if (point)
    out = (km_port){.kind = KM_PORT_POINT, .frame = moving_frame(f), .direction = {0.6, 0.0, 0.8}, .name = "out"};
  set(q, "input", (km_option_value){.end = in});
  set(q, "output", (km_option_value){.end = out});
}

static km_question *make(const fixture *f, const asked *a, int index) {
  km_question *q;
  km_sweep_plan plan = km_sweep_plan_default(f->model);
  assert_int_equal(km_question_create(f->mechanism, a->kind, &q, NULL), KM_OK);
  set(q, "steps", (km_option_value){.whole = a->steps});
  if (strcmp(a->kind, "advantage") == 0)
    set_ends(q, f, plan.coordinate, a->point);
  if (a->flag)
    set(q, strcmp(a->kind, "advantage") == 0 ? "transmission" : "singularities", (km_option_value){.flag = true});
  if (a->ignore_limits)
    set(q, "ignore-limits", (km_option_value){.flag = true});
  if (a->short_of_range && index < 3)
    set(q, "range", (km_option_value){.numbers = {plan.from, 0.5 * (plan.from + plan.to)}});
  return q;
}

static bool same(double x, double y) {
  return x == y || (isnan(x) && isnan(y));
}

static void same_table(const char *what, int index, const km_table *x, const km_table *y) {
  assert_int_equal(km_table_columns(x), km_table_columns(y));
  if (km_table_rows(x) != km_table_rows(y))
    fail_msg("%s, variant %d: %zu rows beside others, %zu alone", what, index, km_table_rows(x), km_table_rows(y));
  for (size_t row = 0; row < km_table_rows(x); ++row)
    for (size_t c = 0; c < km_table_columns(x); ++c)
      if (!same(km_table_row(x, row)[c], km_table_row(y, row)[c]))
        fail_msg("%s, variant %d, row %zu, %s: %.17g beside others, %.17g alone", what, index, row, km_table_name(x, c),
                 km_table_row(x, row)[c], km_table_row(y, row)[c]);
}

static void same_answer(const char *what, int index, const km_question *x, const km_question *y) {
  same_table(what, index, km_question_table(x), km_question_table(y));
  const km_motion_end *end = &km_question_motion(x)->end, *alone = &km_question_motion(y)->end;
  assert_int_equal(end->stop, alone->stop);
  assert_true(same(end->position, alone->position));
  if (x->table_only)
    return;
  same_table(what, index, km_question_motion(x)->between, km_question_motion(y)->between);
  assert_int_equal(km_question_event_count(x), km_question_event_count(y));
  for (int i = 0; i < km_question_event_count(x); ++i) {
    km_question_event a = km_question_event_at(x, i), b = km_question_event_at(y, i);
    assert_string_equal(a.name, b.name);
    if (!same(a.s, b.s) || !same(a.value, b.value))
      fail_msg("%s, variant %d, %s: %.17g at %.17g beside others, %.17g at %.17g alone", what, index, a.name, a.value,
               a.s, b.value, b.s);
  }
}

/* Returns how many of the variants gave an answer. */
static int compare(const char *name, const asked *a, uint64_t seed) {
  fixture beside[KM_BATCH_LANES];
  km_question *questions[KM_BATCH_LANES];
  km_state *states[KM_BATCH_LANES];
  km_status statuses[KM_BATCH_LANES];
  km_error errors[KM_BATCH_LANES];
  int answered = 0;
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    beside[i] = fixture_open_variant(name, seed + (uint64_t)i);
    questions[i] = make(&beside[i], a, i);
    questions[i]->table_only = a->table_only;
    states[i] = beside[i].state;
  }
  km_questions_compute(questions, states, KM_BATCH_LANES, statuses, errors);
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    fixture f = fixture_open_variant(name, seed + (uint64_t)i);
    km_question *alone = make(&f, a, i);
    km_status status = km_question_compute(alone, f.state, NULL);
    assert_int_equal(statuses[i], status);
    if (status == KM_OK || status == KM_PARTIAL) {
      same_answer(name, i, questions[i], alone);
      ++answered;
    }
    km_question_free(alone);
    fixture_close(&f);
  }
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    km_question_free(questions[i]);
    fixture_close(&beside[i]);
  }
  return answered;
}

/* Planar mechanisms are batched; bricard isn't. */
static void over_models(const asked *a, uint64_t seed) {
  static const char *const names[] = {"slider_crank", "fourbar", "excavator", "klann", "brake", "bricard"};
  int answered = 0;
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
    answered += compare(names[k], a, seed);
  assert_true(answered >= 5 * KM_BATCH_LANES);
}

static void leverage(void **state) {
  (void)state;
  over_models(&(asked){.kind = "advantage", .steps = 50}, 1000);
  over_models(&(asked){.kind = "advantage", .steps = 400, .ignore_limits = true}, 2000);
}

static void leverage_at_points(void **state) {
  (void)state;
  over_models(&(asked){.kind = "advantage", .steps = 90, .point = true}, 3000);
}

static void leverage_with_metrics(void **state) {
  (void)state;
  over_models(&(asked){.kind = "advantage", .steps = 30, .flag = true}, 4000);
}

static void forces(void **state) {
  (void)state;
  over_models(&(asked){.kind = "forces", .steps = 60}, 5000);
}

static void mobility(void **state) {
  (void)state;
  over_models(&(asked){.kind = "mobility", .steps = 60}, 6000);
  over_models(&(asked){.kind = "mobility", .steps = 40, .flag = true}, 7000);
}

/* Questions with other ranges are computed singly, the others in a batch. */
static void different_ranges(void **state) {
  (void)state;
  over_models(&(asked){.kind = "advantage", .steps = 40, .short_of_range = true}, 8000);
}

/* Rows and end of the motion don't depend on whether events are read. */
static void without_events(void **state) {
  (void)state;
  static const char *const several[] = {"delta", "stewart", "rssr", "bonnet"};
  static const asked all[] = {{.kind = "mobility", .steps = 150, .table_only = true},
                              {.kind = "mobility", .steps = 40, .flag = true, .table_only = true},
                              {.kind = "advantage", .steps = 12, .table_only = true},
                              {.kind = "advantage", .steps = 150, .point = true, .table_only = true},
                              {.kind = "advantage", .steps = 30, .flag = true, .table_only = true},
                              {.kind = "forces", .steps = 60, .table_only = true}};
  for (size_t k = 0; k < sizeof all / sizeof *all; ++k) {
    over_models(&all[k], 9000 + 100 * (uint64_t)k);
    for (size_t i = 0; i < sizeof several / sizeof *several && k < 4; ++i)
      compare(several[i], &all[k], 9000 + 100 * (uint64_t)k);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(leverage),      cmocka_unit_test(leverage_at_points), cmocka_unit_test(leverage_with_metrics),
      cmocka_unit_test(forces),        cmocka_unit_test(mobility),           cmocka_unit_test(different_ranges),
      cmocka_unit_test(without_events)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
