/* A run in two parts equals one run: internal states of force modules, energies and works continue (docs/theory.md
 * 11.7). */
#include "support/moving.h"

#include "kmech/inspect.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

/* A run with the works of all force modules, from a time or from the end of an earlier table. */
static km_history run_part(fixture *f, const km_table *from, double until, double tolerance) {
  km_forces *forces;
  km_history out;
  km_run_memory *memory = NULL;
  km_error error = {0};
  int modules[64], count = km_model_module_count(f->model);
  km_history_def def = km_history_default(f->model);
  assert_true(count <= 64);
  for (int i = 0; i < count; ++i)
    modules[i] = i;
  def.modules = modules;
  def.module_count = count;
  def.until = until;
  def.simulation.relative = def.simulation.absolute = tolerance;
  if (from && km_history_resume(f->mechanism, from, "table", f->state, &def.start, &memory, &error))
    fail_msg("%s", error.text);
  def.every = (until - def.start) / 4.0;
  def.simulation.memory = memory;
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  if (km_history_run(f->mechanism, forces, f->state, &def, &out, &error))
    fail_msg("%s", error.text);
  km_forces_free(forces);
  km_run_memory_free(memory);
  return out;
}

/* Largest magnitude of a column's values. */
static double size_of(const km_history *h, size_t column) {
  double size = 0.0;
  for (size_t r = 0; r < km_table_rows(h->table); ++r)
    size = fmax(size, fabs(km_table_row(h->table, r)[column]));
  return size;
}

static bool counts_work(const char *name) {
  return strcmp(name, "evaluations") == 0 || strcmp(name, "repartitions") == 0 ||
         strncmp(name, "integrator_", strlen("integrator_")) == 0 || strcmp(name, "loop_error") == 0;
}

/* Both runs make the same errors but for the first steps of the second part: the difference is the tolerance times the
 * growth of errors over the run (at most 1000 here), accelerations have the largest. */
static void compare_ends(const char *model, const char *text, double half, double tolerance) {
  fixture whole = fixture_read(text), parts = fixture_read(text);
  km_history a = run_part(&whole, NULL, 2.0 * half, tolerance), b = run_part(&parts, NULL, half, tolerance);
  fixture again = fixture_read(text);
  km_history c = run_part(&again, b.table, 2.0 * half, tolerance);
  assert_int_equal(km_table_columns(a.table), km_table_columns(c.table));
  for (size_t k = 0; k < km_table_columns(a.table); ++k) {
    const char *name = km_table_name(a.table, k);
    if (counts_work(name))
      continue;
    double x = km_table_row(a.table, km_table_rows(a.table) - 1)[k];
    double y = km_table_row(c.table, km_table_rows(c.table) - 1)[k];
    if (!(fabs(x - y) <= 1e3 * tolerance * (1.0 + size_of(&a, k))))
      fail_msg("%s: %s is %.12g in one run, %.12g in two", model, name, x, y);
  }
  assert_at_most(c.energy_error / c.energy_scale, 1e3 * tolerance);
  km_history_free(&a);
  km_history_free(&b);
  km_history_free(&c);
  fixture_close(&whole);
  fixture_close(&parts);
  fixture_close(&again);
}

static void compare_model(const char *model, double half, double tolerance) {
  char *text = read_model_text(model);
  compare_ends(model, text, half, tolerance);
  km_free(text);
}

/* Tyres and controllers: slips and integrals aren't coordinates. The rack is at 5 mm, so that no tyre slides, which
 * would let errors grow. */
static void test_vehicle(void **data) {
  (void)data;
  char *text = read_model_text("vehicle_circle"), *gentle = edited(text, NULL, "\"rack\": 0.1", "\"rack\": 0.005");
  compare_ends("vehicle_circle", gentle, 1.5, 1e-9);
  km_free(text);
  km_free(gentle);
}

/* Loops with balls, whose coordinates are rotation vectors. */
static void test_balls(void **data) {
  (void)data;
  compare_model("stewart", 0.1, 1e-10);
}

/* Springs, dampers and stops: energies continue from those of the first part. */
static void test_energies(void **data) {
  (void)data;
  compare_model("excavator", 0.5, 1e-9);
}

/* Internal states that are missing or in other units are refused. */
static void test_errors(void **data) {
  (void)data;
  fixture f = fixture_open("vehicle_circle");
  km_history h = run_part(&f, NULL, 0.25, 1e-6);
  km_run_memory *memory;
  km_error error;
  double time;
  km_table *table = km_table_create();
  for (size_t k = 0; k < km_table_columns(h.table); ++k)
    if (strncmp(km_table_name(h.table, k), "state.", strlen("state.")) != 0)
      km_table_add_column(table, km_table_name(h.table, k), km_table_unit(h.table, k));
  assert_int_equal(km_history_resume(f.mechanism, table, "a.csv", f.state, &time, &memory, &error), KM_USAGE);
  assert_string_equal(error.text, "a.csv: it has no row with a time; expected the table of a run");
  double *row = km_table_add_row(table);
  for (size_t k = 0; k < km_table_columns(table); ++k)
    row[k] = 0.0;
  assert_int_equal(km_history_resume(f.mechanism, table, "a.csv", f.state, &time, &memory, &error), KM_USAGE);
  assert_string_equal(error.text, "a.csv: its last row has no state.tyre of left_front_wheel.slip; expected the table "
                                  "of a run of this model");
  assert_null(memory);
  assert_int_equal(km_history_resume(f.mechanism, NULL, "a.csv", f.state, &time, &memory, &error), KM_USAGE);
  assert_int_equal(km_history_resume(f.mechanism, table, "a.csv", f.state, &time, NULL, &error), KM_USAGE);
  km_table_free(table);
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_vehicle), cmocka_unit_test(test_balls),
                                     cmocka_unit_test(test_energies), cmocka_unit_test(test_errors)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
