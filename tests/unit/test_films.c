/* Pictures that move, before they are written: every body in every frame where its pose has it, marks where the table's
 * numbers are, paths that read back to their points. */
#include "support/support.h"

#include "kmech/sweep.h"
#include "report/canvas/apng.h"
#include "report/canvas/svg_path.h"
#include "report/charts/mobility_plot.h"
#include "report/charts/sweep_strip.h"
#include "report/document/film_page.h"
#include "report/drawing/drawing_parts.h"
#include "report/drawing/drawing_poses.h"
#include "report/drawing/film_drawing.h"
#include "report/plot/film_plot.h"
#include "report/plot/plot_layout.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

/* A model's sweep with the poses of its rows. */
typedef struct motion {
  fixture f;
  km_sweep_plan plan;
  km_mobility_sweep sweep;
  km_pose *poses;
  size_t rows, bodies;
  km_drawing_def drawing;
  km_arena arena;
  km_film film;
} motion;

static motion open_motion(const char *name, int steps) {
  motion m = {.f = fixture_open(name)};
  km_error error;
  m.plan = km_sweep_plan_default(m.f.model);
  m.plan.steps = steps;
  km_status status = km_mobility_sweep_run(m.f.mechanism, m.f.state, &m.plan, &m.sweep, &error);
  assert_true(status == KM_OK || status == KM_PARTIAL);
  m.rows = km_table_rows(m.sweep.motion.table);
  m.bodies = (size_t)m.f.model->body_count;
  m.poses = calloc(m.rows * m.bodies, sizeof *m.poses);
  double *q = calloc((size_t)m.f.mechanism->coordinate_count, sizeof *q);
  for (size_t r = 0; r < m.rows; ++r)
    km_row_pose(m.f.mechanism, m.sweep.motion.table, r, m.f.state, q, m.poses + r * m.bodies);
  free(q);
  m.drawing = (km_drawing_def){.mechanism = m.f.mechanism, .poses = m.poses, .pose_count = m.rows};
  return m;
}

static void close_motion(motion *m) {
  km_film_close(&m->film);
  km_arena_free(&m->arena);
  km_mobility_sweep_free(&m->sweep);
  free(m->poses);
  fixture_close(&m->f);
}

static void make_film(motion *m) {
  km_error error;
  assert_int_equal(km_drawing_film(&m->drawing, &m->arena, &m->film, &error), KM_OK);
  assert_int_equal(m->film.frame_count, m->rows);
}

/* Movers of groups; number of groups that are redrawn. */
static size_t count_groups(const km_film *film, int mover) {
  size_t count = 0;
  for (size_t i = 0; i < film->group_count; ++i)
    count += film->groups[i].mover == mover && film->groups[i].shapes->count > 0 && !film->groups[i].names;
  return count;
}

/* Planar films: two points of every body, moved by its mover from the first frame, equal the projection of its pose
 * in every frame, to rounding. */
static void movers_carry_bodies_as_their_poses_do(void **state) {
  (void)state;
  static const char *const names[] = {"klann", "fourbar", "slider_crank", "brake", "toggle_press"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    motion m = open_motion(names[n], 24);
    make_film(&m);
    km_drawing_def whole = m.drawing;
    whole.alone = whole.steady = true;
    km_studio studio = {.drawing = &whole, .place = {0, 0, m.film.width, m.film.height}};
    assert_true(km_studio_open(&studio));
    assert_true(studio.view.planar);
    for (size_t b = 1; b < m.bodies; ++b) {
      const km_film_mover *mover = &m.film.movers[b - 1];
      for (int i = 0; i < studio.shapes[b].count; ++i)
        for (size_t f = 0; f < m.rows; ++f) {
          km_spot first = km_project(&studio.view, km_pose_point(&m.poses[b], studio.shapes[b].points[i]));
          km_spot now = km_project(&studio.view, km_pose_point(&m.poses[f * m.bodies + b], studio.shapes[b].points[i]));
          double x = first.x - mover->x[0], y = first.y - mover->y[0], turn = mover->angle[f] * M_PI / 180.0;
          assert_true(hypot(mover->x[f] + cos(turn) * x - sin(turn) * y - now.x,
                            mover->y[f] + sin(turn) * x + cos(turn) * y - now.y) < 1e-6);
          assert_true(now.x >= 0 && now.x <= m.film.width && now.y >= 0 && now.y <= m.film.height);
        }
      /* Shapes of the body: moved, or redrawn in each frame for a sliding rod. */
      if (studio.shapes[b].count > 1)
        assert_true(count_groups(&m.film, (int)b - 1) + count_groups(&m.film, KM_FILM_DRAWN) > 0);
    }
    km_error error;
    assert_int_equal(km_studio_close(&studio, &error), KM_OK);
    close_motion(&m);
  }
}

/* Nothing of hinges in a plane is drawn twice. */
static void hinges_in_a_plane_are_only_moved(void **state) {
  (void)state;
  motion m = open_motion("klann", 60);
  make_film(&m);
  assert_int_equal(count_groups(&m.film, KM_FILM_DRAWN), 0);
  for (size_t b = 1; b < m.bodies; ++b)
    assert_true(count_groups(&m.film, (int)b - 1) > 0);
  close_motion(&m);
}

/* Ground that turns with the links would flicker: each mount has one direction in all frames. */
static void the_ground_stands_still(void **state) {
  (void)state;
  motion m = open_motion("klann", 24);
  km_drawing_def steady = m.drawing;
  steady.alone = steady.steady = true;
  km_studio studio = {.drawing = &steady, .place = {0, 0, 360, 360}};
  km_spot directions[16];
  size_t mounts = 0;
  assert_true(km_studio_open(&studio));
  for (size_t f = 0; f < m.rows; ++f) {
    km_scene scene = km_studio_scene(&studio, f, 0.0);
    km_scene_build(&scene);
    size_t found = 0;
    for (size_t i = 0; i < scene.count; ++i) {
      if (scene.items[i].kind != KM_ITEM_MOUNT)
        continue;
      if (f == 0)
        directions[mounts++] = scene.items[i].axis[0];
      assert_true(km_spot_distance(directions[found++], scene.items[i].axis[0]) < 1e-12);
    }
    assert_int_equal(found, mounts);
  }
  assert_int_equal(mounts, 3);
  km_error error;
  assert_int_equal(km_studio_close(&studio, &error), KM_OK);
  close_motion(&m);
}

/* In space every frame has a shape of its own for each link, and they differ as long as things move. */
static void links_in_space_are_drawn_in_every_frame(void **state) {
  (void)state;
  motion m = open_motion("stewart", 6);
  make_film(&m);
  assert_int_equal(count_groups(&m.film, KM_FILM_DRAWN), 1);
  for (size_t i = 0; i < m.film.group_count; ++i) {
    const km_film_group *g = &m.film.groups[i];
    for (size_t f = 0; g->mover == KM_FILM_DRAWN && f < m.rows; ++f) {
      assert_true(g->shapes[f].count >= m.bodies - 1);
      for (size_t k = 0; k < g->shapes[f].count; ++k) {
        assert_false(g->shapes[f].items[k].text);
        assert_true(g->shapes[f].items[k].path[0] == 'M');
        assert_in_range(g->shapes[f].items[k].style, 0, m.film.style_count - 1);
      }
    }
  }
  close_motion(&m);
}

/* The rods of an excavator's cylinders slide out of the barrels: drawn anew; barrels and booms are carried. */
static void sliding_rods_are_drawn_anew(void **state) {
  (void)state;
  motion m = open_motion("excavator", 12);
  make_film(&m);
  assert_true(count_groups(&m.film, KM_FILM_DRAWN) > 0);
  size_t carried = 0;
  for (size_t b = 1; b < m.bodies; ++b)
    carried += count_groups(&m.film, (int)b - 1) > 0;
  assert_true(carried > m.bodies / 2);
  close_motion(&m);
}

/* The line of each panel stands at the row's driver value, each dot at the row's number. */
static void marks_are_where_the_table_has_them(void **state) {
  (void)state;
  static const char *const names[] = {"klann", "excavator"};
  for (size_t n = 0; n < 2; ++n) {
    motion m = open_motion(names[n], 50);
    const km_plotted_sweep plotted = {m.f.mechanism, &m.plan, &m.sweep, names[n], NULL, 0};
    km_error error;
    km_plot plot;
    assert_true(km_mobility_plot_make(&plotted, 1, false, &m.arena, &plot));
    assert_int_equal(km_plot_film(&plot, 300, 236, m.rows, &m.arena, &m.film, &error), KM_OK);
    km_plot_layout layout = {.plot = &plot, .canvas = m.film.canvas, .arena = &m.arena};
    km_plot_layout_make(&layout, 300, 236);
    size_t next = 0;
    for (size_t p = 0; p < plot.panel_count; ++p) {
      km_frame frame = km_plot_layout_frame(&layout, p);
      const km_film_mover *line = &m.film.movers[next++];
      for (size_t r = 0; r < m.rows; ++r) {
        double s = km_table_row(m.sweep.motion.table, r)[km_table_find(m.sweep.motion.table, "s")];
        assert_true(fabs(line->x[r] - km_frame_map(&frame, s, 0).x) < 1e-9);
        assert_true(line->y[r] == frame.top);
      }
      for (size_t i = 0; i < plot.panels[p].series_count; ++i) {
        const km_plot_series *series = &plot.panels[p].series[i];
        const km_film_mover *dot = series->colour < 0 ? NULL : &m.film.movers[next++];
        for (size_t r = 0; dot && r < m.rows; ++r) {
          km_canvas_point at = km_frame_map(&frame, series->x[r], series->y[r]);
          assert_true(dot->x[r] == at.x && dot->y[r] == at.y);
        }
      }
    }
    assert_int_equal(next, m.film.mover_count);
    close_motion(&m);
  }
}

/* A dot without a number is off the page in that frame, and only there. */
static void dots_without_a_number_are_hidden(void **state) {
  (void)state;
  static const double x[] = {0, 1, 2, 3}, y[] = {1, (double)NAN, HUGE_VAL, 2};
  const km_plot_series series = {.x = x, .y = y, .count = 4};
  const km_plot_panel panel = {.series = &series, .series_count = 1};
  const km_plot plot = {.x_label = "x", .panels = &panel, .panel_count = 1};
  km_arena arena = {0};
  km_film film;
  km_error error;
  assert_int_equal(km_plot_film(&plot, 300, 236, 4, &arena, &film, &error), KM_OK);
  for (int i = 0; i < 4; ++i)
    assert_int_equal(film.movers[1].x[i] < 0, i == 1 || i == 2);
  km_film_close(&film);
  km_arena_free(&arena);
}

static void add_point(km_svg_path *path, char command, double x, double y) {
  const km_canvas_point point = {x, y};
  km_svg_path_add(path, command, &point);
}

/* Relative numbers on a grid: what they add up to is never farther from a point than half a step. */
static void paths_read_back_to_their_points(void **state) {
  (void)state;
  enum { POINTS = 1000 };
  km_text text = {0};
  km_svg_path path = {.out = &text, .decimals = 1};
  double x[POINTS], y[POINTS];
  for (int i = 0; i < POINTS; ++i) {
    x[i] = 100 * sin(0.37 * i) + 0.033 * i;
    y[i] = 50 * cos(0.11 * i) - 0.0499 * i;
    add_point(&path, i ? 'L' : 'M', x[i], y[i]);
  }
  km_svg_path_end(&path);
  char *at = text.data;
  double sum[2] = {0, 0};
  for (int i = 0; i < POINTS; ++i) {
    at += *at == 'M' || *at == 'l';
    for (int k = 0; k < 2; ++k)
      sum[k] += strtod(at, &at);
    assert_true(fabs(sum[0] - x[i]) <= 0.05 + 1e-9 && fabs(sum[1] - y[i]) <= 0.05 + 1e-9);
  }
  assert_int_equal(*at, '\0');
  km_text_free(&text);
}

/* A circle with slack: fewer corners, and none of those left out is farther from the lines than the slack. */
static void slack_leaves_out_what_nobody_sees(void **state) {
  (void)state;
  enum { POINTS = 200 };
  const double slack = 0.05, grid = 0.0005 * M_SQRT2;
  km_text text = {0};
  km_svg_path path = {.out = &text, .decimals = 3, .slack = slack};
  km_canvas_point written[POINTS], at = {0, 0};
  size_t count = 0;
  for (int i = 0; i < POINTS; ++i)
    add_point(&path, i ? 'L' : 'M', 10 * cos(0.03 * i), 10 * sin(0.03 * i));
  km_svg_path_end(&path);
  for (char *c = text.data; *c; written[count++] = at) {
    c += *c == 'M' || *c == 'l';
    at.x += strtod(c, &c);
    at.y += strtod(c, &c);
  }
  assert_true(count < POINTS / 3 && count > 10);
  assert_true(hypot(at.x - 10 * cos(0.03 * (POINTS - 1)), at.y - 10 * sin(0.03 * (POINTS - 1))) <= grid);
  for (int i = 0; i < POINTS; ++i) {
    double x = 10 * cos(0.03 * i), y = 10 * sin(0.03 * i), nearest = HUGE_VAL;
    for (size_t k = 1; k < count; ++k) {
      km_canvas_point a = written[k - 1], b = written[k];
      double dx = b.x - a.x, dy = b.y - a.y;
      double part = fmin(fmax(((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy), 0), 1);
      nearest = fmin(nearest, hypot(x - a.x - part * dx, y - a.y - part * dy));
    }
    assert_true(nearest <= slack + grid);
  }
  km_text_free(&text);
}

static void numbers_are_short(void **state) {
  (void)state;
  static const struct {
    double value;
    int decimals;
    const char *text;
  } cases[] = {{0, 2, "0"},     {-0.001, 2, "0"},  {0.5, 1, ".5"},   {-0.25, 2, "-.25"}, {12.30, 2, "12.3"},
               {1.005, 1, "1"}, {-100, 0, "-100"}, {0.05, 2, ".05"}, {99.996, 2, "100"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    km_text text = {0};
    km_svg_number(&text, cases[i].value, cases[i].decimals);
    assert_string_equal(text.data, cases[i].text);
    km_text_free(&text);
  }
}

static size_t occurrences(const char *text, const char *of) {
  size_t count = 0;
  for (const char *at = strstr(text, of); at; at = strstr(at + 1, of))
    ++count;
  return count;
}

/* The page for Klann's leg: small, whole in itself, with each body once. */
static void pages_need_nothing_else(void **state) {
  (void)state;
  motion m = open_motion("klann", 240);
  km_text out = {0}, again = {0};
  km_error error;
  make_film(&m);
  double *values = KM_ARENA_NEW(&m.arena, double, m.rows);
  const km_film *films[] = {&m.film};
  const char *const alt[] = {"alt"};
  const km_motion_stop stop = {12.5, "\"a\" <stop>"};
  const km_film_page page = {.title = "</script><b>",
                             .subtitle = "",
                             .footer = "",
                             .films = films,
                             .alt = alt,
                             .film_count = 1,
                             .quantity = "A",
                             .unit = "rad",
                             .values = values,
                             .stops = &stop,
                             .stop_count = 1,
                             .seconds = 5};
  assert_int_equal(km_film_page_write(&page, &out, &error), KM_OK);
  assert_int_equal(km_film_page_write(&page, &again, &error), KM_OK);
  assert_string_equal(out.data, again.data);
  assert_true(out.size < 500000);
  assert_null(strstr(out.data, "src="));
  assert_null(strstr(out.data, "href"));
  assert_null(strstr(out.data, "url("));
  assert_null(strstr(out.data, "<b>"));
  assert_non_null(strstr(out.data, "left:5.21%\" data-frame=\"12.5\" title=\"&quot;a&quot; &lt;stop&gt;\""));
  assert_int_equal(occurrences(out.data, "</script>"), 2);
  for (size_t b = 1; b < m.bodies; ++b) {
    char group[40];
    snprintf(group, sizeof group, "<g class=\"m%zu\"", b - 1);
    assert_true(occurrences(out.data, group) >= 1);
  }
  km_text_free(&out);
  km_text_free(&again);
  close_motion(&m);
}

static uint32_t number_at(const char *data) {
  const unsigned char *b = (const unsigned char *)data;
  return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

static void add_square(km_apng *apng, double size, double place, km_status expected) {
  km_text png = {0};
  km_canvas *canvas;
  km_error error;
  assert_int_equal(km_canvas_create(KM_PICTURE_PNG, size, 20, &png, &canvas, &error), KM_OK);
  km_canvas_rectangle(canvas, (km_colour){1, 0, 0, 1}, place, 5, 5, 5);
  assert_int_equal(km_canvas_finish(canvas, &error), KM_OK);
  km_canvas_free(canvas);
  size_t before = apng->out->size;
  assert_int_equal(km_apng_add(apng, &png, &error), expected);
  assert_true(expected == KM_OK ? apng->out->size > before : apng->out->size == before);
  km_text_free(&png);
}

/* The chunks of an animation: each picture has its control, the sequence has no gap, what isn't of one size is
 * refused. */
static void animated_pictures_are_whole(void **state) {
  (void)state;
  km_text out = {0};
  km_apng apng = {.out = &out, .frames = 3, .milliseconds = 40};
  add_square(&apng, 30, 1, KM_OK);
  add_square(&apng, 40, 1, KM_INTERNAL);
  add_square(&apng, 30, 8, KM_OK);
  add_square(&apng, 30, 16, KM_OK);
  uint32_t sequence = 0;
  int controls = 0, frames = 0, ends = 0;
  bool animated = false;
  for (size_t at = 8; at < out.size; at += 12 + number_at(out.data + at)) {
    const char *type = out.data + at + 4, *data = out.data + at + 8;
    if (memcmp(type, "acTL", 4) == 0) {
      assert_int_equal(number_at(data), 3);
      animated = true;
    }
    bool control = memcmp(type, "fcTL", 4) == 0, frame = memcmp(type, "fdAT", 4) == 0;
    if (control || frame)
      assert_int_equal(number_at(data), sequence++);
    if (memcmp(type, "IDAT", 4) == 0)
      assert_true(animated && controls == 1);
    if (control)
      assert_true(number_at(data + 4) == 60 && number_at(data + 8) == 40);
    controls += control;
    frames += frame;
    ends += memcmp(type, "IEND", 4) == 0;
  }
  assert_int_equal(controls, 3);
  assert_true(frames >= 2);
  assert_int_equal(ends, 1);
  assert_int_equal(number_at(out.data + out.size - 4),
                   0xae426082); /* the check of an empty IEND, as every PNG has it */
  km_text none = {0};
  km_error error;
  assert_int_equal(km_apng_add(&(km_apng){.out = &none, .frames = 1}, &none, &error), KM_INTERNAL);
  km_text_free(&none);
  km_text_free(&out);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(movers_carry_bodies_as_their_poses_do),
      cmocka_unit_test(hinges_in_a_plane_are_only_moved),
      cmocka_unit_test(the_ground_stands_still),
      cmocka_unit_test(links_in_space_are_drawn_in_every_frame),
      cmocka_unit_test(sliding_rods_are_drawn_anew),
      cmocka_unit_test(marks_are_where_the_table_has_them),
      cmocka_unit_test(dots_without_a_number_are_hidden),
      cmocka_unit_test(paths_read_back_to_their_points),
      cmocka_unit_test(slack_leaves_out_what_nobody_sees),
      cmocka_unit_test(numbers_are_short),
      cmocka_unit_test(pages_need_nothing_else),
      cmocka_unit_test(animated_pictures_are_whole),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
