/* Pictures by calls: poses added one by one equal those of a table's rows, pictures equal those of the renderers,
 * and failures are reported. */
#include "support/support.h"

#include "kmech/report.h"
#include "report/canvas/canvas.h"
#include "report/charts/sweep_strip.h"
#include "report/drawing/drawing.h"

#include <math.h>
#include <string.h>

typedef struct swept {
  fixture f;
  km_question *question;
  km_drawing *drawing;
} swept;

/* Computes the mobility over a range, and draws its rows with the path of the last frame. */
static swept sweep(const char *model, const char *driver, double from, double to, int steps) {
  swept s = {.f = fixture_open(model)};
  km_option_value range = {.numbers = {from, to}}, whole = {.whole = steps}, joint = {0};
  km_error error;
  assert_int_equal(km_question_create(s.f.mechanism, "mobility", &s.question, &error), KM_OK);
  assert_int_equal(km_model_find_coordinate(s.f.model, driver, &joint.coordinate, &error), KM_OK);
  assert_int_equal(km_question_set(s.question, "joint", &joint, &error), KM_OK);
  assert_int_equal(km_question_set(s.question, "range", &range, &error), KM_OK);
  assert_int_equal(km_question_set(s.question, "steps", &whole, &error), KM_OK);
  assert_int_equal(km_question_compute(s.question, s.f.state, &error), KM_OK);
  assert_int_equal(km_drawing_create(s.f.mechanism, &s.drawing, &error), KM_OK);
  assert_int_equal(km_drawing_add_path(s.drawing, km_model_frame_count(s.f.model) - 1, "last", &error), KM_OK);
  assert_int_equal(km_drawing_add_rows(s.drawing, km_question_table(s.question), &error), KM_OK);
  assert_int_equal(km_drawing_poses(s.drawing), steps + 1);
  return s;
}

static void close_swept(swept *s) {
  km_drawing_free(s->drawing);
  km_question_free(s->question);
  fixture_close(&s->f);
}

static void assert_same_text(const km_text *a, const km_text *b) {
  assert_int_equal(a->size, b->size);
  assert_memory_equal(a->data, b->data, a->size);
}

/* State by state, with the path led along, gives the bytes of the table's rows; and those are the renderer's. */
static void poses_are_those_of_rows(void **unused) {
  (void)unused;
  swept s = sweep("fourbar", "A", 0.0, 1.5, 6);
  const km_table *table = km_question_table(s.question);
  km_drawing *one_by_one;
  km_error error;
  km_text rows = {0}, states = {0};
  double values[16];
  size_t first = km_table_span(table, "q.").first;
  assert_int_equal(km_drawing_create(s.f.mechanism, &one_by_one, &error), KM_OK);
  assert_int_equal(km_drawing_add_path(one_by_one, km_model_frame_count(s.f.model) - 1, "last", &error), KM_OK);
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    memcpy(values, km_table_row(table, r) + first, (size_t)s.f.mechanism->coordinate_count * sizeof *values);
    assert_int_equal(km_state_set_coordinates(s.f.mechanism, s.f.state, values, &error), KM_OK);
    km_poses_compute(s.f.mechanism, s.f.state);
    assert_int_equal(km_drawing_add_pose(one_by_one, s.f.mechanism, s.f.state, &error), KM_OK);
    assert_int_equal(km_drawing_lead_paths(one_by_one, s.f.mechanism, s.f.state, &error), KM_OK);
  }
  const km_drawing_look look = {.title = "title", .name = "name", .bodies = true};
  assert_int_equal(km_drawing_picture(s.drawing, &look, KM_PICTURE_SVG, &rows, &error), KM_OK);
  assert_int_equal(km_drawing_picture(one_by_one, &look, KM_PICTURE_SVG, &states, &error), KM_OK);
  assert_same_text(&rows, &states);
  assert_non_null(strstr(rows.data, "<svg"));
  km_text_free(&rows);
  km_text_free(&states);
  km_drawing_free(one_by_one);
  close_swept(&s);
}

/* A crank that turns once comes round, one that turns less doesn't; a page says so to its player. */
static void turns_come_round(void **unused) {
  (void)unused;
  static const double turns[] = {2.0 * M_PI, 6.0};
  for (int k = 0; k < 2; ++k) {
    swept s = sweep("fourbar", "A", 0.0, turns[k], 12);
    assert_int_equal(km_drawing_comes_round(s.drawing), k == 0);
    assert_true(km_drawing_is_planar(s.drawing, KM_VIEW_AUTO));
    assert_false(km_drawing_is_planar(s.drawing, KM_VIEW_ISO));
    close_swept(&s);
  }
}

static km_status page_of(const swept *s, const km_chart *chart, const double *values, km_text *out, km_error *error) {
  const km_motion_page page = {.quantity = "A", .values = values, .seconds = 1.0, .chart = chart};
  return km_drawing_page(s->drawing, &(km_drawing_look){0}, &page, out, error);
}

/* Curves of a chart in a motion page have a row for each pose. */
static void pages_need_a_row_for_each_pose(void **unused) {
  (void)unused;
  swept s = sweep("fourbar", "A", 0.0, 1.5, 6);
  const km_answered answer = {s.question, "model", NULL, 0, NULL};
  double values[8] = {0};
  km_chart *chart;
  km_error error;
  km_text out = {0};
  assert_int_equal(km_question_chart(&(km_comparison){&answer, 1, false}, &chart, &error), KM_OK);
  assert_int_equal(page_of(&s, chart, values, &out, &error), KM_OK);
  assert_non_null(strstr(out.data, "<svg"));
  size_t before = out.size;
  km_poses_compute(s.f.mechanism, s.f.state);
  assert_int_equal(km_drawing_add_pose(s.drawing, s.f.mechanism, s.f.state, &error), KM_OK);
  assert_int_equal(page_of(&s, chart, values, &out, &error), KM_USAGE);
  assert_string_equal(error.text, "curves of 7 rows beside 8 poses; expected one for each pose");
  assert_int_equal(out.size, before);
  assert_int_equal(page_of(&s, NULL, values, &out, &error), KM_OK);
  km_chart_free(chart);
  km_text_free(&out);
  close_swept(&s);
}

/* A grid has a frame for each pose in its group's colour, and its captions. Groups change colours alone. */
static void a_grid_shows_each_pose(void **unused) {
  (void)unused;
  swept s = sweep("fourbar", "A", 0.0, 1.5, 4);
  km_error error;
  km_text one_group = {0}, groups = {0}, pdf = {0}, png = {0};
  km_gallery_caption captions[5] = {{0}};
  assert_int_equal(km_drawing_poses(s.drawing), 5);
  for (int i = 0; i < 5; ++i)
    captions[i] = (km_gallery_caption){.title = "Some mode", .group = 1};
  const km_drawing_look look = {.title = "Modes"};
  assert_int_equal(km_drawing_gallery(s.drawing, &look, captions, KM_PICTURE_SVG, &one_group, &error), KM_OK);
  for (int i = 0; i < 5; ++i)
    captions[i].group = i;
  assert_int_equal(km_drawing_gallery(s.drawing, &look, captions, KM_PICTURE_SVG, &groups, &error), KM_OK);
  assert_true(strstr(one_group.data, "<svg") && strstr(groups.data, "<svg"));
  assert_string_not_equal(one_group.data, groups.data);
  assert_int_equal(km_drawing_gallery(s.drawing, &look, captions, KM_PICTURE_PDF, &pdf, &error), KM_OK);
  assert_memory_equal(pdf.data, "%PDF", 4);
  assert_int_equal(km_drawing_gallery(s.drawing, &look, captions, KM_PICTURE_PNG, &png, &error), KM_OK);
  assert_memory_equal(png.data + 1, "PNG", 3);
  assert_int_equal(km_drawing_gallery(s.drawing, &look, NULL, KM_PICTURE_SVG, &groups, &error), KM_USAGE);
  km_text_free(&one_group);
  km_text_free(&groups);
  km_text_free(&pdf);
  km_text_free(&png);
  close_swept(&s);
}

static void assert_refused(km_status status, const km_error *error, const char *text) {
  assert_int_equal(status, KM_USAGE);
  assert_string_equal(error->text, text);
}

static void what_cannot_be_drawn_is_told(void **unused) {
  (void)unused;
  swept s = sweep("fourbar", "A", 0.0, 1.5, 6);
  fixture other = fixture_open("brake");
  km_error e;
  km_text out = {0};
  km_chart *chart;
  km_drawing *empty;
  km_question *unasked;
  const km_drawing_look look = {0}, no_view = {.view = (km_view)9};
  assert_int_equal(km_drawing_create(s.f.mechanism, &empty, &e), KM_OK);
  assert_refused(km_drawing_picture(empty, &look, KM_PICTURE_SVG, &out, &e), &e, "the drawing has no pose");
  assert_refused(km_drawing_picture(s.drawing, &no_view, KM_PICTURE_SVG, &out, &e), &e,
                 "found no view; expected AUTO, XY, XZ, YZ or ISO");
  assert_refused(km_drawing_picture(s.drawing, &look, (km_picture_format)7, &out, &e), &e,
                 "found no format of pictures; expected SVG, PDF or PNG");
  assert_refused(km_drawing_add_pose(s.drawing, other.mechanism, other.state, &e), &e,
                 "the state is of another model than the drawing");
  assert_refused(km_drawing_add_path(s.drawing, 0, "late", &e), &e,
                 "the other paths have points already; expected all paths before them");
  assert_refused(km_drawing_apng(s.drawing, &look, 0.0, &out, &e), &e,
                 "0 seconds; expected more than 0, less than a million");
  assert_refused(km_drawing_outlines(s.drawing, KM_VIEW_AUTO, 0.0, 0.0, KM_PICTURE_SVG, &out, &e), &e,
                 "scale 0; expected more than 0");
  assert_refused(km_drawing_dxf(s.drawing, KM_VIEW_AUTO, -1.0, &out, &e), &e, "links of width -1; expected at least 0");
  assert_int_equal(km_question_create(s.f.mechanism, "forces", &unasked, &e), KM_OK);
  const km_answered answers[] = {{s.question, "a", NULL, 0, NULL}, {unasked, "b", NULL, 0, NULL}};
  assert_refused(km_question_chart(&(km_comparison){answers, 2, false}, &chart, &e), &e, "there is no answer to plot");
  assert_null(chart);
  assert_refused(km_question_report(&answers[0], "", true, &out, &e), &e, "there is no report about this question");
  assert_refused(km_tracks_picture(&(km_tracks){0}, KM_PICTURE_SVG, &out, &e), &e,
                 "found no tracks of a study with a path");
  assert_int_equal(out.size, 0);
  km_question_free(unasked);
  km_drawing_free(empty);
  fixture_close(&other);
  close_swept(&s);
}

/* A pose of a rotation vector turns points about it by Rodrigues' formula. */
static void rotation_vectors_turn(void **unused) {
  (void)unused;
  const double p[3] = {1, 2, 3}, turn[3] = {0.3, -0.4, 1.2}, angle = 1.3, k[3] = {0.3 / 1.3, -0.4 / 1.3, 1.2 / 1.3};
  km_frame_pose pose;
  km_error error;
  assert_int_equal(km_frame_pose_make(p, turn, &pose, &error), KM_OK);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) {
      double cross = r == c ? 0.0 : ((c - r + 3) % 3 == 1 ? -1.0 : 1.0) * k[3 - r - c];
      double expected = (r == c) * cos(angle) + sin(angle) * cross + (1.0 - cos(angle)) * k[r] * k[c];
      assert_near(pose.R[3 * r + c], expected, 1e-14);
    }
  assert_memory_equal(pose.p, p, sizeof p);
  const double endless[3] = {0, HUGE_VAL, 0};
  assert_int_equal(km_frame_pose_make(p, endless, &pose, &error), KM_USAGE);
}

/* Only PDF has pages, and each has a size. */
static void pages_that_cannot_be(void **unused) {
  (void)unused;
  static const km_picture_format formats[] = {KM_PICTURE_SVG, KM_PICTURE_PDF};
  static const double widths[] = {100.0, 0.5};
  for (int i = 0; i < 2; ++i) {
    km_text out = {0};
    km_canvas *canvas;
    km_error error = {.text = ""};
    assert_int_equal(km_canvas_create(formats[i], 100.0, 100.0, &out, &canvas, &error), KM_OK);
    km_canvas_page(canvas, widths[i], 100.0);
    assert_int_equal(km_canvas_finish(canvas, &error), KM_USAGE);
    assert_non_null(strstr(error.text, "a second page that can't be; only PDF has several, of 1 to"));
    assert_int_equal(out.size, 0);
    km_canvas_free(canvas);
    km_text_free(&out);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(poses_are_those_of_rows),        cmocka_unit_test(turns_come_round),
      cmocka_unit_test(pages_need_a_row_for_each_pose), cmocka_unit_test(a_grid_shows_each_pose),
      cmocka_unit_test(what_cannot_be_drawn_is_told),   cmocka_unit_test(rotation_vectors_turn),
      cmocka_unit_test(pages_that_cannot_be),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
