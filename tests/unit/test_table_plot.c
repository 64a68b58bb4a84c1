/* Tables read back from their text, and plots of their columns before they are rendered. */
#include "support/shown.h"

#include "base/similar_names.h"
#include "kmech/report.h"
#include "report/charts/table_plot.h"
#include "report/plot/plot_layout.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static km_table *read_text(const char *text) {
  km_text bytes = {0};
  km_table *table = NULL;
  km_error error;
  km_text_add(&bytes, text);
  assert_int_equal(km_csv_read(&bytes, "test", &table, &error), KM_OK);
  km_text_free(&bytes);
  return table;
}

static bool same_number(double a, double b) {
  return a == b || (isnan(a) && isnan(b));
}

/* Written tables are read back: names with all characters of labels, and every kind of double. */
static void tables_survive_their_text(void **state) {
  (void)state;
  static const char *const names[] = {"step", "q.A", "q.comma, \"quoted\"\nin two lines", "m.crank_m", "ma.A/B", "a.A"};
  static const char *const units[] = {"", "rad", "deg", "", "rad/mm", "m/s^2"};
  static const double numbers[] = {0.0,       -0.1,        1e300,        DBL_MIN, HUGE_VAL,
                                   -HUGE_VAL, (double)NAN, DBL_TRUE_MIN, 1.0 / 3, 12345678901234567.0};
  enum { COLUMNS = 6, ROWS = 10 };
  km_table *table = km_table_create();
  for (int c = 0; c < COLUMNS; ++c)
    assert_int_equal(km_table_add_column(table, names[c], units[c]), c);
  for (int r = 0; r < ROWS; ++r) {
    double *row = km_table_add_row(table);
    for (int c = 0; c < COLUMNS; ++c)
      row[c] = numbers[(r + 3 * c) % ROWS];
  }
  km_text text = {0};
  km_csv_write(table, &text);
  km_table *back = read_text(text.data);
  assert_int_equal(km_table_columns(back), COLUMNS);
  assert_int_equal(km_table_rows(back), ROWS);
  for (size_t c = 0; c < COLUMNS; ++c) {
    assert_string_equal(km_table_name(back, c), names[c]);
    assert_string_equal(km_table_unit(back, c), units[c]);
    for (size_t r = 0; r < ROWS; ++r)
      assert_true(same_number(km_table_row(back, r)[c], km_table_row(table, r)[c]));
  }
  assert_int_equal(km_csv_find(back, "q.A"), 1);
  assert_int_equal(km_csv_find(back, "q.A_rad"), 1);
  assert_int_equal(km_csv_find(back, "ma.A/B_rad/mm"), 4);
  assert_int_equal(km_csv_find(back, "q.A_deg"), -1);
  km_text_free(&text);
  km_table_free(table);
  km_table_free(back);
}

/* Tables of other programs: line ends of any kind, a byte order mark, empty fields and lines, blanks. */
static void foreign_tables_are_read(void **state) {
  (void)state;
  km_table *table = read_text("\xEF\xBB\xBFx_mm,y_margin\r\n 1, 2 \n\n3,\r\n\"5\",6");
  assert_int_equal(km_table_rows(table), 3);
  assert_string_equal(km_table_name(table, 0), "x");
  assert_string_equal(km_table_unit(table, 0), "mm");
  assert_string_equal(km_table_name(table, 1), "y_margin");
  assert_true(km_table_row(table, 0)[1] == 2.0 && km_table_row(table, 2)[0] == 5.0);
  assert_true(isnan(km_table_row(table, 1)[1]));
  km_table_free(table);
}

static void expect_nearest(const char *wanted, const char *expected) {
  static const char *const names[] = {"q.boom", "q.bucket", "point.bucket/tip.x", "m.boom", "s"};
  km_nearest nearest = {.wanted = wanted};
  char text[KM_NEAREST_TEXT];
  for (int i = 0; i < 5; ++i)
    km_nearest_add(&nearest, names[i]);
  assert_int_equal(strncmp(km_nearest_text(&nearest, text), expected, strlen(expected)), 0);
}

static void near_names_come_first(void **state) {
  (void)state;
  expect_nearest("q.bom", "\"q.boom\", \"m.boom\"");
  expect_nearest("tip.x", "\"point.bucket/tip.x\"");
  assert_int_equal(km_text_distance("kitten", "sitting"), 3);
  assert_int_equal(km_text_distance("", "abc"), 3);
}

/* Panels by unit, in the order of the columns, with the columns' own numbers. */
static void columns_of_one_unit_share_a_panel(void **state) {
  (void)state;
  km_table *table = read_text("s,q.A_deg,point.b/t.x_mm,q.B_deg\n0,1,2,3\n1,inf,5,6\n");
  const size_t y[] = {1, 2, 3};
  const km_plotted_table shown = {table, "name", 0, y};
  km_arena arena = {0};
  km_plot plot;
  assert_true(km_table_plot_make(&shown, 1, 3, NULL, &arena, &plot));
  assert_int_equal(plot.panel_count, 2);
  assert_int_equal(plot.panels[0].series_count, 2);
  assert_int_equal(plot.panels[1].series_count, 1);
  assert_string_equal(plot.panels[0].y_label, "q.A, q.B (deg)");
  assert_string_equal(plot.panels[1].y_label, "point.b/t.x (mm)");
  assert_string_equal(plot.panels[0].series[1].name, "q.B");
  assert_true(plot.panels[0].series[1].y[1] == 6.0 && plot.panels[0].series[0].y[1] == HUGE_VAL);
  assert_true(plot.own_y && !plot.equal);
  km_arena_free(&arena);
  km_table_free(table);
}

/* Words of the user's replace those of the table; a column that has none keeps its own, and scales stay equal. */
static void words_are_the_users(void **state) {
  (void)state;
  km_table *table = read_text("point.a/b.x_mm,point.a/b.y_mm,point.c/d.y_mm\n0,1,2\n1,5,6\n");
  const size_t y[] = {1, 2};
  const char *const names[] = {"tip", NULL};
  const km_plotted_table shown = {table, "name", 0, y};
  km_chart_words words = {.x_name = "across", .names = names};
  km_arena arena = {0};
  km_plot plot;
  assert_true(km_table_plot_make(&shown, 1, 2, &words, &arena, &plot));
  assert_string_equal(plot.title, "tip, point.c/d.y over across");
  assert_string_equal(plot.x_label, "across (mm)");
  assert_string_equal(plot.panels[0].y_label, "tip, point.c/d.y (mm)");
  assert_string_equal(plot.panels[0].series[0].name, "tip");
  assert_true(plot.equal);
  words = (km_chart_words){.title = "A door", .x_label = "width", .y_label = "height"};
  assert_true(km_table_plot_make(&shown, 1, 2, &words, &arena, &plot));
  assert_string_equal(plot.title, "A door");
  assert_string_equal(plot.x_label, "width");
  assert_string_equal(plot.panels[0].y_label, "height");
  km_arena_free(&arena);
  km_table_free(table);
}

static bool equal_scales(const char *text, size_t x, size_t y) {
  km_table *table = read_text(text);
  const km_plotted_table shown = {table, "name", x, &y};
  km_arena arena = {0};
  km_plot plot;
  assert_true(km_table_plot_make(&shown, 1, 1, NULL, &arena, &plot));
  bool equal = plot.equal;
  km_arena_free(&arena);
  km_table_free(table);
  return equal;
}

static void curves_in_a_plane_have_equal_scales(void **state) {
  (void)state;
  static const char points[] =
      "point.a/b.x_mm,point.a/b.y_mm,q.A_mm,q.B_deg,point.c/d.x_m\n0,0,0,0,0\n1,1,1,1,1\n2,1,1,0,2\n";
  static const char back[] = "q.A_mm,q.B_mm\n0,0\n1,1\nnan,1\n0.5,2\n";
  assert_true(equal_scales(points, 0, 1));
  assert_false(equal_scales(points, 2, 1)); /* a driver that goes on */
  assert_false(equal_scales(points, 3, 1)); /* an angle */
  assert_false(equal_scales(points, 0, 4)); /* another unit */
  assert_true(equal_scales(back, 0, 1));    /* x goes forth and back */
}

/* On the page a unit is as long along x as along y, and all the data lie within. */
static void equal_plots_keep_shapes(void **state) {
  (void)state;
  static const double x[] = {-3, 5, 1}, y[3][3] = {{0, 1, 0.5}, {100, 1e-3, 40}, {7, 7, 7}};
  for (int k = 0; k < 3; ++k) {
    const km_plot_series series = {.x = x, .y = y[k], .count = 3};
    const km_plot_panel panel = {.y_label = "y", .series = &series, .series_count = 1};
    const km_plot plot = {
        .title = "t", .x_label = "x", .panels = &panel, .panel_count = 1, .own_y = true, .equal = true};
    km_text out = {0};
    km_canvas *canvas;
    km_arena arena = {0};
    km_error error;
    double width, height;
    km_plot_layout_size(&plot, &width, &height);
    assert_int_equal(km_canvas_create(KM_PICTURE_SVG, width, height, &out, &canvas, &error), KM_OK);
    km_plot_layout layout = {.plot = &plot, .canvas = canvas, .arena = &arena};
    km_plot_layout_make(&layout, width, height);
    assert_true(layout.fits);
    km_frame f = km_plot_layout_frame(&layout, 0);
    double across = f.width / (f.x_high - f.x_low), up = f.height / (f.y_high - f.y_low);
    assert_true(fabs(across / up - 1.0) < 1e-12);
    for (int i = 0; i < 3; ++i) {
      km_canvas_point at = km_frame_map(&f, x[i], y[k][i]);
      assert_true(at.x >= f.left && at.x <= f.left + f.width && at.y >= f.top && at.y <= f.top + f.height);
    }
    km_canvas_free(canvas);
    km_text_free(&out);
    km_arena_free(&arena);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tables_survive_their_text),
      cmocka_unit_test(foreign_tables_are_read),
      cmocka_unit_test(near_names_come_first),
      cmocka_unit_test(columns_of_one_unit_share_a_panel),
      cmocka_unit_test(words_are_the_users),
      cmocka_unit_test(curves_in_a_plane_have_equal_scales),
      cmocka_unit_test(equal_plots_keep_shapes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
