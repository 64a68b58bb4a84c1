/* Reports: the same input gives the same bytes, HTML needs no other file, every page is there. */
#include "support/support.h"

#include "kmech/sweep.h"
#include "report/charts/sweep_plot.h"
#include "report/document/advantage_report.h"
#include "report/document/statics_report.h"
#include "report/document/sweep_report.h"

#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static void render(km_document_maker *k, const km_model *model, bool html, km_text *out) {
  km_error error = {0};
  if (km_report_finish(k, km_report_subject(k, "model", model), NULL, "kma", "title", html, out, &error))
    fail_msg("%s", error.text);
}

static void leverage(const char *model, bool html, km_text *out) {
  fixture f = fixture_open(model);
  km_port input, output;
  km_transmission_workspace *work;
  km_transmission transmission;
  km_advantage_sweep sweep;
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_error error = {0};
  assert_true(km_port_default(f.model, false, &input) && km_port_default(f.model, true, &output));
  assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &input, &output, true, &sweep, &error), KM_OK);
  assert_int_equal(km_transmission_create(f.mechanism, &input, &output, &work, &error), KM_OK);
  km_transmission_compute(f.mechanism, f.state, work, &transmission);
  km_plotted_advantage plotted = {{f.mechanism, &plan, &sweep.motion, model}, &sweep};
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  km_advantage_report_make(k, &plotted, &transmission, "", false);
  render(k, f.model, html, out);
  km_transmission_free(work);
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

static void holding(const char *model, bool html, km_text *out) {
  fixture f = fixture_open(model);
  km_forces *forces;
  km_statics statics;
  km_statics_sweep sweep;
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_error error = {0};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, &error), KM_OK);
  assert_int_equal(km_statics_create(f.mechanism, NULL, 0, KM_AXES_JOINT, &statics, &error), KM_OK);
  assert_int_equal(km_statics_sweep_run(f.mechanism, f.state, &plan, forces, &statics, &sweep, &error), KM_OK);
  km_plotted_statics plotted = {{f.mechanism, &plan, &sweep.motion, model}, &sweep, NULL, 0};
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  km_statics_report_make(k, &plotted, &statics, "gravity", "", false);
  render(k, f.model, html, out);
  km_statics_sweep_free(&sweep);
  km_statics_free(&statics);
  km_forces_free(forces);
  fixture_close(&f);
}

static void same_input_same_bytes(void **state) {
  (void)state;
  static void (*const reports[])(const char *, bool, km_text *) = {leverage, holding};
  for (int r = 0; r < 2; ++r) {
    for (int html = 0; html < 2; ++html) {
      km_text a = {0}, b = {0};
      reports[r]("brake", html, &a);
      reports[r]("brake", html, &b);
      assert_int_equal(a.size, b.size);
      assert_memory_equal(a.data, b.data, a.size);
      assert_memory_equal(a.data, html ? "<!DOCTYPE html>" : "%PDF-", html ? 15 : 5);
      km_text_free(&a);
      km_text_free(&b);
    }
  }
}

/* The file contains all pictures and has no external references. */
static void html_stands_alone(void **state) {
  (void)state;
  km_text text = {0};
  leverage("fourbar", true, &text);
  for (const char *src = strstr(text.data, "src="); src; src = strstr(src + 1, "src="))
    assert_memory_equal(src, "src=\"data:", 10);
  assert_null(strstr(text.data, "href="));
  assert_null(strstr(text.data, "<script"));
  assert_null(strstr(text.data, "url("));
  assert_non_null(strstr(text.data, "MA ∞ at 0.751348182"));
  assert_non_null(strstr(text.data, "</html>"));
  km_text_free(&text);
}

static km_status nothing(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  (void)canvas;
  *(double *)context = width * height;
  (void)error;
  return KM_OK;
}

/* Names from a model are text, whatever they look like. */
static void markup_is_escaped(void **state) {
  (void)state;
  static const char *const cells[] = {"a<b", "c&d", "<script>", "\"e\""};
  double area = 0.0;
  const km_block blocks[] = {
      {.kind = KM_BLOCK_HEADING, .text = "<h>"},
      {.kind = KM_BLOCK_TABLE, .cells = cells, .rows = 2, .columns = 2},
      {.kind = KM_BLOCK_FACTS, .cells = cells, .rows = 2, .columns = 2},
      {.kind = KM_BLOCK_PICTURE, .text = "\">", .height = 50, .draw = nothing, .context = &area}};
  const km_document document = {
      .title = "<title>", .subtitle = "&", .footer = "<f>", .blocks = blocks, .count = 4};
  km_text html = {0}, pdf = {0};
  assert_int_equal(km_document_html(&document, &html, NULL), KM_OK);
  assert_null(strstr(html.data, "<script>"));
  assert_null(strstr(html.data, "<h>"));
  assert_null(strstr(html.data, "alt=\"\">"));
  assert_non_null(strstr(html.data, "a&lt;b"));
  assert_int_equal(km_document_pdf(&document, &pdf, NULL), KM_OK);
  assert_true(area > 0.0);
  km_text_free(&html);
  km_text_free(&pdf);
}

/* f over s from 0 to 1 in 200 rows. */
static km_sweep drawn(double (*f)(double)) {
  km_sweep motion = {.table = km_table_create(), .between = km_table_create()};
  km_table *const tables[2] = {motion.table, motion.between};
  for (int i = 0; i < 2; ++i) {
    km_table_add_column(tables[i], "step", NULL);
    km_table_add_column(tables[i], "s", NULL);
    km_table_add_column(tables[i], "f", NULL);
  }
  for (int i = 0; i <= 200; ++i) {
    double *row = km_table_add_row(motion.table);
    row[0] = i;
    row[1] = i / 200.0;
    row[2] = f(row[1]);
  }
  return motion;
}

static double sharp_peak(double s) {
  return 1.0 / (1e-6 + (s - 0.5) * (s - 0.5));
}
static double pole(double s) {
  return 1.0 / (s - 0.4975); /* value between two rows */
}

/* A finite peak, however steep, is on the axis; only a way to a pole leaves it. */
static void axes_are_cut_at_poles_alone(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  for (int poles = 0; poles < 2; ++poles) {
    km_sweep motion = drawn(poles ? pole : sharp_peak);
    km_swept swept = {f.mechanism, &plan, &motion, "fourbar"};
    km_swept_line line = {0, 2, "f", 0};
    km_swept_break gap = {0, 2, 0.4975};
    km_sweep_picture picture = {.title = "t",
                                .y_label = "y",
                                .sweeps = &swept,
                                .sweep_count = 1,
                                .lines = &line,
                                .line_count = 1,
                                .breaks = &gap,
                                .break_count = (size_t)poles,
                                .panel_count = 1};
    km_arena arena = {0};
    km_plot plot;
    assert_true(km_sweep_plot_make(&picture, &arena, &plot));
    if (poles) { /* a twentieth of each half remains unseen */
      assert_in_range((long)plot.y_high, 35, 60);
      assert_in_range((long)-plot.y_low, 35, 60);
    } else { /* fitted to all there is */
      assert_true(plot.y_low == 0.0 && plot.y_high == 0.0);
    }
    km_arena_free(&arena);
    km_sweep_free(&motion);
  }
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(same_input_same_bytes), cmocka_unit_test(html_stands_alone),
                                     cmocka_unit_test(markup_is_escaped),
                                     cmocka_unit_test(axes_are_cut_at_poles_alone)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
