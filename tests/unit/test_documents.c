/* Contents of reports before rendering, with the plots on their pages; and written tables. */
#include "support/shown.h"

#include "kmech/report.h"
#include "kmech/sweep.h"
#include "report/document/advantage_report.h"
#include "report/document/statics_report.h"
#include "report/record/mobility_record.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

/* "−1.5" as the reports write it. */
static double number_of(const char *text) {
  const char minus[] = "−";
  bool negative = strncmp(text, minus, sizeof minus - 1) == 0;
  const char *rest = negative ? text + sizeof minus - 1 : text;
  double value = strcmp(text, "–") == 0 ? (double)NAN : strncmp(rest, "∞", 3) == 0 ? HUGE_VAL : strtod(rest, NULL);
  return negative ? -value : value;
}

static void check_number(const char *text, double want) {
  double found = number_of(text);
  if (!shown_same(found, want) && !(fabs(found - want) <= 1e-5 * fabs(want)))
    fail_msg("found %s; expected %.9g", text, want);
}

/* The table whose first row begins with a head, its rows below it the sweep's, first and last among them. */
static const km_block *table_below(const km_document_maker *k, const char *heading) {
  for (size_t i = 0; i + 1 < k->count; ++i)
    if (k->blocks[i].kind == KM_BLOCK_HEADING && strcmp(k->blocks[i].text, heading) == 0)
      for (size_t b = i + 1; b < k->count; ++b)
        if (k->blocks[b].kind == KM_BLOCK_TABLE)
          return &k->blocks[b];
  fail_msg("no table below \"%s\"", heading);
  return NULL;
}

/* Each of the table's rows is the sweep's row with that s; returns the sweep's row. */
static size_t row_at(const km_table *table, const char *s) {
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    double value = shown_cell(table, r, "", "s");
    if (fabs(value - number_of(s)) <= 1e-5 * fabs(value))
      return r;
  }
  fail_msg("no row at %s", s);
  return 0;
}

static void check_chosen_rows(const km_block *block, const km_table *table, const char *const *columns,
                              double special) {
  size_t rows = km_table_rows(table), shown = block->rows - 1;
  double nearest = HUGE_VAL, best = HUGE_VAL;
  assert_in_range(shown, rows < 6 ? rows : 6, 12); /* places may fall together */
  for (size_t r = 0; r < rows; ++r)
    best = fmin(best, fabs(shown_cell(table, r, "", "s") - special));
  assert_int_equal(row_at(table, block->cells[block->columns]), 0);
  assert_int_equal(row_at(table, block->cells[shown * block->columns]), rows - 1);
  for (size_t i = 1; i < block->rows; ++i) {
    const char *const *cells = block->cells + i * block->columns;
    size_t row = row_at(table, cells[0]);
    nearest = fmin(nearest, fabs(shown_cell(table, row, "", "s") - special));
    for (size_t c = 1; c < block->columns && columns[c - 1]; ++c)
      check_number(cells[c], shown_cell(table, row, "", columns[c - 1]));
  }
  if (isfinite(special))
    assert_near(nearest, best, 0.0);
}

/* The reactions are those of the row at which an actuator holds most, joint by joint. */
static void check_reactions(const km_document_maker *k, const fixture *f, const km_statics_sweep *sweep) {
  static const char *const parts[6] = {".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};
  const km_block *block = table_below(k, "Reactions where an actuator holds most");
  const km_table *table = sweep->motion.table;
  size_t worst = 0;
  double most = -1.0, forces = 0.0;
  for (size_t r = 0; r < km_table_rows(table); ++r)
    for (int i = 0; i < sweep->actuator_count; ++i) {
      double force = fabs(shown_cell(table, r, "f.", sweep->actuators[i].name));
      if (isfinite(force) && force > most) {
        most = force;
        worst = r;
      }
    }
  assert_int_equal(block->rows, f->model->joint_count + 1);
  for (int pass = 0; pass < 2; ++pass)
    for (int j = 0; j < f->model->joint_count; ++j)
      for (int c = 0; c < 6; ++c) {
        char name[400];
        snprintf(name, sizeof name, "%s%s", f->model->joints[j].label, parts[c]);
        double value = shown_cell(table, worst, "r.", name);
        if (pass == 0)
          forces = fmax(forces, c < 3 ? fabs(value) : 0.0);
        else
          check_number(block->cells[(size_t)(j + 1) * 7 + 1 + (size_t)c], fabs(value) < 1e-9 * forces ? 0.0 : value);
      }
}

static void forces_are_drawn_and_reported(void **state) {
  (void)state;
  static const char *const names[] = {"brake", "excavator", "scissor_lift", "toggle_press"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n]);
    km_forces *forces;
    km_statics statics;
    km_statics_sweep sweep;
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_error error = {0};
    km_arena arena = {0};
    km_plot plot;
    int actuators[64];
    for (int i = 0; i < f.model->actuator_count; ++i)
      actuators[i] = f.model->actuators[i];
    assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, &error), KM_OK);
    assert_int_equal(km_statics_create(f.mechanism, f.model->actuator_count ? actuators : NULL, f.model->actuator_count,
                                       KM_AXES_JOINT, &statics, &error),
                     KM_OK);
    km_status status = km_statics_sweep_run(f.mechanism, f.state, &plan, forces, &statics, &sweep, &error);
    assert_true(status == KM_OK || status == KM_PARTIAL);
    km_plotted_statics plotted = {{f.mechanism, &plan, &sweep.motion, names[n]}, &sweep, NULL, 0};
    assert_true(km_statics_plot_make(&plotted, 1, false, false, &arena, &plot));
    int drawn = 0;
    for (size_t p = 0; p < plot.panel_count; ++p) {
      check_colours(&plot.panels[p]);
      for (size_t i = 0; i < plot.panels[p].series_count; ++i) {
        const km_plot_series *line = &plot.panels[p].series[i];
        double largest = 0.0;
        for (size_t r = 0; r < line->count; ++r)
          largest = fmax(largest, isfinite(line->y[r]) ? fabs(line->y[r]) : 0.0);
        drawn += check_lines(line, sweep.motion.table, "f.", 2e-9 * largest);
      }
    }
    assert_int_equal(drawn, sweep.actuator_count);
    km_document_maker *k = KM_NEW(km_document_maker, 1);
    km_statics_report_make(k, &plotted, &statics, "gravity", "", false);
    char labels[8][300];
    const char *columns[9] = {NULL};
    for (int i = 0; i < sweep.actuator_count && i < 8; ++i) {
      snprintf(labels[i], sizeof labels[i], "f.%s", sweep.actuators[i].name);
      columns[i] = labels[i];
    }
    check_chosen_rows(table_below(k, "At chosen poses"), sweep.motion.table, columns, sweep.largest[0].s);
    check_reactions(k, &f, &sweep);
    km_arena_free(&k->arena);
    km_free(k);
    km_arena_free(&arena);
    km_statics_sweep_free(&sweep);
    km_statics_free(&statics);
    km_forces_free(forces);
    fixture_close(&f);
  }
}

static void leverage_is_drawn_and_reported(void **state) {
  (void)state;
  static const char *const names[] = {"brake", "fourbar", "toggle_press"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n]);
    km_port input, output;
    km_transmission transmission = {.no_wrench = NULL};
    km_advantage_sweep sweep;
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_error error = {0};
    km_arena arena = {0};
    km_plot plot;
    assert_true(km_port_default(f.model, false, &input) && km_port_default(f.model, true, &output));
    km_status status = km_advantage_sweep_run(f.mechanism, f.state, &plan, &input, &output, true, &sweep, &error);
    assert_true(status == KM_OK || status == KM_PARTIAL);
    km_plotted_advantage plotted = {{f.mechanism, &plan, &sweep.motion, names[n]}, &sweep};
    assert_true(km_advantage_plot_make(&plotted, 1, false, false, &arena, &plot));
    assert_int_equal(plot.panel_count, 1);
    assert_int_equal(plot.panels[0].series_count, sweep.friction ? 2 : 1);
    char ends[300], with[330];
    snprintf(ends, sizeof ends, "%s/%s", input.name, output.name);
    snprintf(with, sizeof with, "%s with friction", ends);
    assert_string_equal(plot.panels[0].series[0].name, ends);
    check_line(&plot.panels[0].series[0], sweep.motion.table, "ma.", ends, 0.0);
    if (sweep.friction) {
      assert_string_equal(plot.panels[0].series[1].name, with);
      check_line(&plot.panels[0].series[1], sweep.motion.table, "force_ratio.", ends, 0.0);
    }
    size_t marks = sweep.toggle_count + (size_t)(isfinite(sweep.lowest.value) && isfinite(sweep.lowest.s)) +
                   (size_t)(isfinite(sweep.highest.value) && isfinite(sweep.highest.s));
    assert_int_equal(plot.panels[0].mark_count, marks);
    for (size_t i = 0; i < sweep.toggle_count; ++i)
      assert_true(plot.panels[0].marks[i].x == sweep.toggles[i].s);
    km_document_maker *k = KM_NEW(km_document_maker, 1);
    km_advantage_report_make(k, &plotted, &transmission, "", false);
    char ma[320], ratio[340];
    snprintf(ma, sizeof ma, "ma.%s", ends);
    snprintf(ratio, sizeof ratio, "force_ratio.%s", ends);
    const char *columns[3] = {ma, sweep.friction ? ratio : NULL, NULL};
    check_chosen_rows(table_below(k, "At chosen poses"), sweep.motion.table, columns, sweep.highest.s);
    km_arena_free(&k->arena);
    km_free(k);
    km_arena_free(&arena);
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static size_t lines_of(const km_text *text) {
  size_t lines = 0;
  for (size_t i = 0; i < text->size; ++i)
    lines += text->data[i] == '\n';
  return lines;
}

/* Every row and every column of a table is in its CSV and in its record. */
static void tables_are_written_whole(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
  km_error error = {0};
  km_arena arena = {0};
  km_text csv = {0};
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
  assert_int_equal(km_sweep_redundancies_find(f.mechanism, &sweep.motion, true, &redundancies, &error), KM_OK);
  const km_table *table = sweep.motion.table;
  km_csv_write(table, &csv);
  assert_int_equal(lines_of(&csv), km_table_rows(table) + 1);
  const km_value *record = km_mobility_sweep_record(f.mechanism, &sweep, &redundancies, "", "fourbar", &arena);
  const km_value *rows = km_value_get(record, "rows");
  size_t r = 0;
  for (const km_value *row = rows->first; row; row = row->next, ++r) {
    size_t c = 0;
    for (const km_value *number = row->first; number; number = number->next, ++c)
      assert_true(number->number == km_table_row(table, r)[c]);
    assert_int_equal(c, km_table_columns(table));
  }
  assert_int_equal(r, km_table_rows(table));
  km_text_free(&csv);
  km_arena_free(&arena);
  km_sweep_redundancies_free(&redundancies);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(forces_are_drawn_and_reported),
                                     cmocka_unit_test(leverage_is_drawn_and_reported),
                                     cmocka_unit_test(tables_are_written_whole)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
