/* Contents of plots, maps and drawings before rendering: columns, colours and names. */
#include "support/arms.h"
#include "support/shown.h"

#include "report/charts/mobility_plot.h"
#include "report/charts/selfmotion_map_plot.h"
#include "report/charts/sweep_strip.h"
#include "report/charts/track_plot.h"
#include "report/drawing/drawing_poses.h"
#include "report/plot/short_names.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static void mobility_plots_draw_their_columns(void **state) {
  (void)state;
  static const char *const names[] = {"brake", "fourbar", "klann", "excavator", "slider_crank", "vehicle", "stewart"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n]);
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_mobility_sweep sweep;
    km_error error = {0};
    km_arena arena = {0};
    km_plot plot;
    plan.steps = 40;
    km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error);
    assert_true(status == KM_OK || status == KM_PARTIAL);
    const km_plotted_sweep plotted = {f.mechanism, &plan, &sweep, names[n], NULL, 0};
    assert_true(km_mobility_plot_make(&plotted, 1, false, &arena, &plot));
    int drawn = 0, expected = 0;
    for (size_t p = 0; p < plot.panel_count; ++p) {
      check_colours(&plot.panels[p]);
      for (size_t i = 0; i < plot.panels[p].series_count; ++i) {
        assert_int_equal(plot.panels[p].series[i].count, km_table_rows(sweep.motion.table));
        drawn += check_lines(&plot.panels[p].series[i], sweep.motion.table, "m.", 1e-9);
      }
    }
    for (int c = 0; c < f.mechanism->coordinate_count; ++c)
      expected += f.mechanism->substructure_of[c] >= 0 && !f.mechanism->held[c];
    assert_int_equal(drawn, expected);
    assert_true(plot.y_low == 0.0 && plot.y_high == 1.0);
    size_t marks = 0;
    for (size_t p = 0; p < plot.panel_count; ++p)
      marks += plot.panels[p].mark_count;
    assert_int_equal(marks, sweep.toggle_count + sweep.motion.branch_count);
    km_arena_free(&arena);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* Two sweeps on one plot: each has its colour and its own numbers, a joint equal dashes in both; only requested
 * joints are drawn, by default the driver. */
static void overlaid_sweeps_have_a_colour_each(void **state) {
  (void)state;
  static const int shown[] = {1, 3};
  fixture f = fixture_open("fourbar");
  km_sweep_plan plans[2] = {km_sweep_plan_default(f.model), km_sweep_plan_default(f.model)};
  km_mobility_sweep sweeps[2];
  km_error error = {0};
  for (int i = 0; i < 2; ++i) {
    plans[i].steps = 20 + i;
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plans[i], &sweeps[i], &error), KM_OK);
  }
  for (int asked = 0; asked <= 1; ++asked) {
    km_arena arena = {0};
    km_plot plot;
    km_plotted_sweep plotted[2];
    for (int i = 0; i < 2; ++i)
      plotted[i] = (km_plotted_sweep){f.mechanism, &plans[i], &sweeps[i], i ? "b" : "a", asked ? shown : NULL, 2};
    plotted[0].shown_count = plotted[1].shown_count = asked ? 2 : 0;
    assert_true(km_mobility_plot_make(plotted, 2, false, &arena, &plot));
    const km_plot_panel *panel = &plot.panels[0];
    assert_int_equal(panel->series_count, asked ? 4 : 2);
    for (size_t i = 0; i < panel->series_count; ++i) {
      char label[200], expected[200];
      const char *tail = strrchr(panel->series[i].name, '(');
      int sweep = tail[1] == 'b', place = asked ? (int)i % 2 : 0;
      assert_int_equal(panel->series[i].colour, sweep);
      assert_int_equal(panel->series[i].dash, place);
      snprintf(label, sizeof label, "%.*s", (int)(tail - 1 - panel->series[i].name), panel->series[i].name);
      snprintf(expected, sizeof expected, "%s", f.model->coordinates[asked ? shown[place] : plans[0].coordinate].label);
      assert_string_equal(label, expected);
      km_plot_series one = panel->series[i];
      one.name = label;
      check_lines(&one, sweeps[sweep].motion.table, "m.", 1e-9);
    }
    km_arena_free(&arena);
  }
  for (int i = 0; i < 2; ++i)
    km_mobility_sweep_free(&sweeps[i]);
  fixture_close(&f);
}

/* Short names keep distinguishing parts, and never split a number. */
static void short_names_keep_numbers_whole(void **state) {
  (void)state;
  static const char *const cases[][4] = {
      {"left_arm.cable.x=-30", "left_arm.cable.x=-20", "…-30", "…-20"},
      {"left_arm.cable.x=1.25", "left_arm.cable.x=1.75", "…1.25", "…1.75"},
      {"excavator_of_today", "excavator_of_1990", "…today", "…1990"},
      {"short", "names", "short", "names"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    km_arena arena = {0};
    const char *out[2];
    km_short_names(cases[i], 2, &arena, out);
    assert_string_equal(out[0], cases[i][2]);
    assert_string_equal(out[1], cases[i][3]);
    km_arena_free(&arena);
  }
}

/* Line by line of a page of tracks, with what each must show. */
static void check_joints(const km_plot *plot, const km_track *t, const char *prefix, bool share) {
  assert_int_equal(plot->panel_count, 1);
  for (size_t i = 0; i < plot->panels[0].series_count; ++i) {
    const km_plot_series *line = &plot->panels[0].series[i];
    assert_int_equal(line->colour, i);
    assert_int_equal(line->count, km_table_rows(t->table));
    int joint = -1;
    for (int k = 0; k < t->arm->n; ++k)
      if (strcmp(km_arm_label(t->arm, k), line->name) == 0)
        joint = k;
    for (size_t r = 0; r < line->count; ++r) {
      double want = shown_cell(t->table, r, prefix, line->name);
      if (share) {
        double low = km_arm_to_units(t->arm, joint, t->arm->low[joint]),
               high = km_arm_to_units(t->arm, joint, t->arm->high[joint]);
        want = (want - 0.5 * (low + high)) / (0.5 * (high - low));
      }
      assert_true(line->x[r] == shown_cell(t->table, r, "", "s"));
      assert_near(line->y[r], want, share ? 1e-12 : 0.0);
    }
  }
}

static void track_plots_draw_their_columns(void **state) {
  (void)state;
  opened_study o = study_open("panda_limit");
  enum { METHODS = 2 };
  km_track *tracks[METHODS];
  for (int i = 0; i < METHODS; ++i)
    tracks[i] = track_of(o.study, i, 1);
  const km_tracks all = {o.study, "panda_limit", "panda", tracks, METHODS};
  const km_track *best = tracks[km_tracks_best(&all)];
  km_arena arena = {0};
  km_plot plots[KM_TRACK_PLOTS];
  size_t count = km_tracks_plots_make(&all, true, &arena, plots);
  assert_true(count >= 7);
  check_joints(&plots[0], best, "q.", false);
  assert_int_equal(plots[0].panels[0].series_count, best->arm->n);
  check_joints(&plots[1], best, "q.", true);
  check_joints(&plots[2], best, "z.", false);
  assert_int_equal(plots[2].panels[0].series_count, best->arm->n + 1);
  for (size_t p = 3; p < count; ++p) {
    const char *title = plots[p].title;
    const char *name = strcmp(title, "Manipulability") == 0   ? "objective.manipulability"
                       : strcmp(title, "Limit margin") == 0   ? "limit_margin"
                       : strcmp(title, "Tracking error") == 0 ? "error_position"
                                                              : NULL;
    assert_int_equal(plots[p].panels[0].series_count, METHODS);
    for (int i = 0; i < METHODS; ++i) {
      const km_plot_series *line = &plots[p].panels[0].series[i];
      char label[64];
      km_tracks_label(&all, i, ' ', label, sizeof label);
      assert_string_equal(line->name, label);
      assert_int_equal(line->count, km_table_rows(tracks[i]->table));
      for (size_t r = 0; r < line->count; ++r) {
        double want = name ? shown_cell(tracks[i]->table, r, "", name) : 0.0;
        if (strcmp(title, "Fastest joint") == 0)
          for (int k = 0; k < best->arm->n; ++k)
            want = fmax(want, fabs(shown_cell(tracks[i]->table, r, "v.", km_arm_label(best->arm, k))));
        else if (!name)
          want = shown_cell(tracks[i]->table, r, "objective.", title + strlen("Objective: "));
        assert_near(line->y[r], want, 0.0);
      }
    }
  }
  km_arena_free(&arena);
  for (int i = 0; i < METHODS; ++i)
    km_track_free(tracks[i]);
  km_study_free(o.study);
  fixture_close(&o.f);
}

static double lightness(km_colour c) {
  return 0.2126 * c.red + 0.7152 * c.green + 0.0722 * c.blue;
}

/* The higher the value, the paler the cell; outside the limits, and nowhere else, in a mist. */
static void maps_are_paler_where_values_are_higher(void **state) {
  (void)state;
  for (int i = 1; i < KM_MAP_SHADES; ++i)
    assert_true(lightness(km_map_shade(i)) > lightness(km_map_shade(i - 1)));
  double u[2] = {-1.0, 3.0}, value[2] = {0.2, 0.7};
  km_arc_span arcs[1] = {{0.0, 2.0, {-1, -1}}};
  km_station station = {.low = -1.0, .high = 3.0, .count = 2, .u = u, .value = value, .arcs = arcs, .arc_count = 1};
  km_map_cell cells[KM_MAP_CELLS];
  const double low = 0.1, high = 0.9, step = 4.0 / KM_MAP_CELLS;
  int count = km_map_cells(&station, low, high, cells);
  assert_true(cells[0].from == -1.0 && fabs(cells[count - 1].to - 3.0) < 1e-12);
  for (int i = 0; i < count; ++i) {
    double middle = 0.5 * (cells[i].from + cells[i].to);
    double part = (value[0] + (value[1] - value[0]) * (middle - u[0]) / (u[1] - u[0]) - low) / (high - low);
    assert_true(cells[i].to > cells[i].from && (i == 0 || cells[i].from == cells[i - 1].to));
    assert_near(cells[i].shade + 0.5, part * KM_MAP_SHADES, 1.01);
    assert_int_equal(cells[i].outside, middle < 0.0 || middle > 2.0);
    assert_true(i == 0 || cells[i].shade >= cells[i - 1].shade);
    assert_true(cells[i].outside || (cells[i].from >= -step && cells[i].to <= 2.0 + step));
  }
  value[0] = -5.0; /* values beyond the ends of the scale */
  value[1] = 50.0;
  count = km_map_cells(&station, low, high, cells);
  assert_int_equal(cells[0].shade, 0);
  assert_int_equal(cells[count - 1].shade, KM_MAP_SHADES - 1);
}

/* A row's drawing is at the row's coordinates, joint by joint. */
static void drawings_are_at_their_rows(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep sweep;
  km_state *other;
  km_error error = {0};
  size_t bodies = (size_t)f.mechanism->topology.body_count, coordinates = (size_t)f.mechanism->coordinate_count;
  km_pose *poses = KM_NEW(km_pose, bodies);
  double *q = KM_NEW(double, coordinates);
  plan.steps = 10;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
  assert_int_equal(km_state_create(f.mechanism, &other, &error), KM_OK);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    km_row_pose(f.mechanism, sweep.motion.table, r, other, q, poses);
    for (int c = 0; c < f.mechanism->coordinate_count; ++c)
      assert_near(km_state_coordinate(other, c),
                  shown_cell(sweep.motion.table, r, "q.", km_model_coordinate_label(f.model, c)), 1e-12);
    assert_memory_equal(poses, other->pose, bodies * sizeof *poses);
  }
  km_state_free(other);
  km_free(poses);
  km_free(q);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* Whichever side is too short. */
static void crowded_plots_are_refused(void **state) {
  (void)state;
  enum { PANELS = 40 };
  const double x[] = {0, 1}, y[] = {0, 1};
  const km_plot_series series = {.name = "y", .x = x, .y = y, .count = 2};
  km_plot_panel panels[PANELS];
  for (int i = 0; i < PANELS; ++i)
    panels[i] = (km_plot_panel){.series = &series, .series_count = 1};
  const km_plot plot = {.title = "t",
                        .x_label = "x",
                        .y_label = "y",
                        .panels = panels,
                        .panel_count = PANELS,
                        .width = 120,
                        .height = 120};
  km_text out = {0};
  km_error error;
  assert_int_equal(km_plot_render(&plot, KM_PICTURE_SVG, &out, &error), KM_USAGE);
  assert_string_equal(error.text, "40 panels on 120 x 120 points; expected a larger page");
  km_text_free(&out);
}

static void small_plots_are_refused(void **state) {
  (void)state;
  static const double sizes[][2] = {{400, 20}, {20, 400}, {20, 20}, {400, 300}};
  const double x[] = {0, 1}, y[] = {0, 1};
  const km_plot_series series = {.name = "y", .x = x, .y = y, .count = 2};
  const km_plot_panel panel = {.series = &series, .series_count = 1};
  for (size_t i = 0; i < 4; ++i) {
    km_plot plot = {.title = "t", .x_label = "x", .y_label = "y", .panels = &panel, .panel_count = 1};
    km_text out = {0};
    km_error error;
    plot.width = sizes[i][0];
    plot.height = sizes[i][1];
    assert_int_equal(km_plot_render(&plot, KM_PICTURE_SVG, &out, &error), i < 3 ? KM_USAGE : KM_OK);
    assert_int_equal(out.size > 0, i == 3);
    if (i < 3)
      assert_non_null(strstr(error.text, "points; expected at least 120 each"));
    km_text_free(&out);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(mobility_plots_draw_their_columns),
                                     cmocka_unit_test(overlaid_sweeps_have_a_colour_each),
                                     cmocka_unit_test(short_names_keep_numbers_whole),
                                     cmocka_unit_test(track_plots_draw_their_columns),
                                     cmocka_unit_test(maps_are_paler_where_values_are_higher),
                                     cmocka_unit_test(drawings_are_at_their_rows),
                                     cmocka_unit_test(small_plots_are_refused),
                                     cmocka_unit_test(crowded_plots_are_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
