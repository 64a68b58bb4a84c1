/* Every allocation of the main jobs fails once: the job ends with KM_MEMORY, nothing crashes, nothing is leaked (which
 * the build under AddressSanitizer shows). The linker sends the library's calloc and realloc through this file. */
#include "support/support.h"

#include "base/memory.h"
#include "base/text.h"
#include "exchange/json/json.h"
#include "kmech/kmech.h"
#include "report/document/question_report.h"
#include "report/plot/question_plot.h"
#include "report/record/question_record.h"

#include <string.h>

static long calls, failing; /* counted since `arm`; the one that fails, 0: none */

void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);

void *__wrap_calloc(size_t count, size_t size) {
  return ++calls == failing ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size) {
  return ++calls == failing ? NULL : __real_realloc(block, size);
}

static void arm(long n) {
  calls = 0;
  failing = n;
}

/* A job from the model's text to the bytes of its result. */
typedef km_status (*job)(const char *json);

static km_status open_pose(const char *json, fixture *f) {
  km_error error;
  *f = (fixture){0};
  km_status status = km_model_read(json, strlen(json), NULL, &f->model, &error);
  return status ? status : km_reach_pose(f->model, NULL, 0, NULL, 0, &f->mechanism, &f->state, &error);
}

static km_status diagnose(const char *json) {
  fixture f;
  km_findings findings = {0};
  km_text text = {0};
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_check(f.mechanism, f.state, NULL, NULL, NULL, &findings, NULL);
  km_findings_free(&findings);
  km_text_free(&text);
  fixture_close(&f);
  return status;
}

/* Asks, and writes the answer as a record, a plot, a report. */
static km_status write_answer(const fixture *f, const km_question *q) {
  km_answered answer = {f->mechanism, q, "model", NULL, 0};
  km_arena arena = {0};
  km_text record = {0}, summary = {0}, plot = {0}, report = {0};
  const km_value *value = km_question_record(q, f->mechanism, "", "model", &arena);
  if (value)
    km_json_write(value, &record);
  km_question_print(q, f->mechanism, "model", &summary);
  km_status status = km_question_plot(&(const km_comparison){&answer, 1, false}, KM_CANVAS_SVG, &plot, NULL);
  if (!status && !km_question_mobility(q))
    status = km_question_report(&answer, "", true, &report, NULL);
  if (!status && (!value || arena.failed || record.failed || summary.failed || plot.failed || report.failed))
    status = KM_MEMORY;
  km_text_free(&report);
  km_text_free(&plot);
  km_text_free(&summary);
  km_text_free(&record);
  km_arena_free(&arena);
  return status;
}

static km_status ask(const char *json, const char *kind) {
  fixture f;
  km_question *q = NULL;
  km_option_value steps = {.whole = 3}, yes = {.flag = true};
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_question_create(f.mechanism, kind, &q, NULL);
  if (!status)
    status = km_question_set(q, "steps", &steps, NULL);
  if (!status && strcmp(kind, "forces") != 0)
    status = km_question_set(q, strcmp(kind, "mobility") == 0 ? "redundancies" : "transmission", &yes, NULL);
  if (!status)
    status = km_question_ask(q, f.state, NULL);
  if (!status)
    status = write_answer(&f, q);
  km_question_free(q);
  fixture_close(&f);
  return status;
}

static km_status ask_mobility(const char *json) {
  return ask(json, "mobility");
}

static km_status ask_advantage(const char *json) {
  return ask(json, "advantage");
}

static km_status ask_forces(const char *json) {
  return ask(json, "forces");
}

/* Fails the first calls one by one, and later ones in growing strides: a job has thousands. */
static void fail_each(job run, const char *model) {
  char *json = read_model_text(model);
  arm(0);
  assert_int_equal(run(json), KM_OK);
  long all = calls;
  assert_true(all > 20);
  for (long n = 1; n <= all; n += 1 + n / 400) {
    arm(n);
    km_status status = run(json);
    arm(0);
    if (status != KM_MEMORY)
      fail_msg("status %d where call %ld of %ld failed", (int)status, n, all);
  }
  km_free(json);
}

static void test_mobility(void **unused) {
  (void)unused;
  fail_each(ask_mobility, "fourbar");
}

static void test_advantage(void **unused) {
  (void)unused;
  fail_each(ask_advantage, "brake");
}

static void test_forces(void **unused) {
  (void)unused;
  fail_each(ask_forces, "excavator");
}

static void test_check(void **unused) {
  (void)unused;
  fail_each(diagnose, "brake");
  fail_each(diagnose, "bricard");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mobility),
      cmocka_unit_test(test_advantage),
      cmocka_unit_test(test_forces),
      cmocka_unit_test(test_check),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
