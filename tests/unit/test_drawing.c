/* Drawings: views, order, names, robustness, and the same bytes for the same input. */
#include "support/support.h"

#include "base/memory.h"
#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static km_drawing_def drawing_of(fixture *f) {
  km_poses_compute(f->mechanism, f->state);
  return (km_drawing_def){
      .mechanism = f->mechanism, .poses = f->state->pose, .pose_count = 1, .title = "title", .name = "name"};
}

static void render(const km_drawing_def *drawing, km_picture_format format, km_text *out) {
  km_error error;
  if (km_drawing_render(drawing, format, out, &error))
    fail_msg("%s", error.text);
}

static void the_same_bytes_for_every_model(void **state) {
  (void)state;
  for (int m = 0; all_models[m]; ++m)
    for (int format = KM_PICTURE_SVG; format <= KM_PICTURE_PNG; ++format) {
      fixture f = fixture_open(all_models[m]);
      km_drawing_def drawing = drawing_of(&f);
      km_text a = {0}, b = {0};
      drawing.bodies = true;
      render(&drawing, (km_picture_format)format, &a);
      render(&drawing, (km_picture_format)format, &b);
      assert_int_equal(a.size, b.size);
      assert_memory_equal(a.data, b.data, a.size);
      km_text_free(&a);
      km_text_free(&b);
      fixture_close(&f);
    }
}

static void the_plane_of_motion_is_found(void **state) {
  (void)state;
  static const struct {
    const char *model, *view;
    bool planar;
  } cases[] = {{"fourbar", "view of the xy plane", true},
               {"klann", "view of the xy plane", true},
               {"brake", "view of the xy plane", true},
               {"slider_crank", "view of the yz plane", true},
               {"excavator", "view of the xz plane", true},
               {"stewart", "iso view", false},
               {"bennett", "iso view", false},
               {"iiwa14", "iso view", false}};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    fixture f = fixture_open(cases[i].model);
    km_drawing_def drawing = drawing_of(&f);
    km_projection view = km_view_make(&drawing);
    assert_string_equal(view.name, cases[i].view);
    assert_int_equal(view.planar, cases[i].planar);
    fixture_close(&f);
  }
}

static void views_are_right_handed(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  for (int v = KM_VIEW_AUTO; v <= KM_VIEW_ISO; ++v) {
    km_drawing_def drawing = drawing_of(&f);
    drawing.view = (km_view)v;
    km_projection view = km_view_make(&drawing);
    km_vec3 toward = km_vec3_cross(view.right, view.up);
    assert_near(km_vec3_norm(km_vec3_sub(toward, view.toward)), 0.0, 1e-12);
    assert_near(km_vec3_norm(view.up), 1.0, 1e-12);
  }
  fixture_close(&f);
}

/* Two bars that cross on the page, and a third far behind; depths are mean ones that deceive. */
static const char *const crossing =
    "{\"model_parameters\": {\"version\": \"1.0\"}, \"fixed\": {\"frames\": ["
    "{\"name\": \"a\", \"T\": [0, 0, 1]}, {\"name\": \"b\", \"T\": [0, 0, 2]}]},"
    "\"assemblies\": [{\"name\": \"x\", \"bodies\": ["
    "{\"name\": \"near\", \"frames\": [{\"name\": \"t\", \"T\": [4, 4, -20]}]},"
    "{\"name\": \"far\", \"frames\": [{\"name\": \"s\", \"T\": [0.4, 0, 0]}, {\"name\": \"t\", "
    "\"T\": [0.4, 4, 0]}]}],"
    "\"joints\": [{\"name\": \"A\", \"type\": \"spherical\", \"body_frame_pairs\": [[\"fixed\", "
    "\"b\"], \"near\"]},"
    "{\"name\": \"B\", \"type\": \"spherical\", \"body_frame_pairs\": [[\"fixed\", \"a\"], "
    "[\"far\", \"s\"]]}]}]}";

static void what_lies_in_front_comes_last(void **state) {
  (void)state;
  fixture f = fixture_read(crossing);
  km_arena arena = {0};
  km_drawing_def drawing = drawing_of(&f);
  drawing.view = KM_VIEW_XY;
  km_studio studio = {.drawing = &drawing, .place = {0, 0, 400, 300}};
  assert_true(km_studio_open(&studio));
  km_spot crossed[2][2] = {{{0, 0, 0}, {10, 10, 10}}, {{0, 10, 100}, {10, 0, -92}}};
  km_item items[2] = {
      {.kind = KM_ITEM_BAR, .joint = -1, .body = 1, .spots = crossed[0], .count = 2, .depth = 5, .reach = 1},
      {.kind = KM_ITEM_BAR, .joint = -1, .body = 2, .spots = crossed[1], .count = 2, .depth = 4, .reach = 1}};
  /* They cross where both are at about 5 and 4: body 2 lies behind, and mean depths agree. */
  km_scene scene = {.mechanism = f.mechanism, .view = &studio.view, .arena = &arena, .items = items, .count = 2};
  km_scene_order(&scene);
  assert_int_equal(scene.items[1].body, 1);
  crossed[1][0].depth = 108; /* now it crosses at 8, in front, although its mean may say less */
  items[0] =
      (km_item){.kind = KM_ITEM_BAR, .joint = -1, .body = 1, .spots = crossed[0], .count = 2, .depth = 50, .reach = 1};
  items[1] =
      (km_item){.kind = KM_ITEM_BAR, .joint = -1, .body = 2, .spots = crossed[1], .count = 2, .depth = 4, .reach = 1};
  scene.items = items;
  km_scene_order(&scene);
  assert_int_equal(scene.items[1].body, 2);
  km_arena_free(&arena);
  assert_int_equal(km_studio_close(&studio, NULL), KM_OK);
  fixture_close(&f);
}

/* The excavator's payload pulls down on the bucket: its arrow points down the page, and is named. */
static void loads_are_arrows_with_names(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  km_drawing_def drawing = drawing_of(&f);
  km_studio studio = {.drawing = &drawing, .place = {0, 0, 400, 300}};
  assert_true(km_studio_open(&studio));
  km_scene scene = km_studio_scene(&studio, 0, 1.0);
  km_label *labels = calloc(km_studio_most_labels(&studio), sizeof *labels);
  size_t without = km_studio_labels(&studio, &scene, labels), with;
  drawing.loads = true;
  with = km_studio_labels(&studio, &scene, labels);
  assert_int_equal(with, without + (size_t)f.model->load_count);
  assert_string_equal(labels[0].text, "payload");
  km_spot ends[2];
  assert_true(km_load_arrow(&studio, &scene, 0, ends));
  assert_near(ends[1].x, ends[0].x, 1e-9);
  assert_true(ends[1].y > ends[0].y); /* y of a page points down */
  const km_model_frame *frame = &f.model->frames[f.model->loads[0].frame];
  km_spot point = km_project(&studio.view, km_pose_point(&f.state->pose[frame->body], frame->pose.p));
  bool tip = hypot(ends[1].x - point.x, ends[1].y - point.y) < 1e-9,
       tail = hypot(ends[0].x - point.x, ends[0].y - point.y) < 1e-9;
  assert_true(tip != tail);
  free(labels);
  assert_int_equal(km_studio_close(&studio, NULL), KM_OK);
  fixture_close(&f);
}

static void names_do_not_overlap(void **state) {
  (void)state;
  enum { NAMES = 60 };
  fixture f = fixture_open("brake");
  km_drawing_def drawing = drawing_of(&f);
  km_text out = {0};
  km_canvas *canvas;
  km_arena arena = {0};
  km_rectangle place = {0, 0, 400, 300};
  const km_font font = {.size = 8, .width = 120};
  km_label labels[NAMES] = {{0}};
  char texts[NAMES][64];
  assert_int_equal(km_canvas_create(KM_PICTURE_SVG, 400, 300, &out, &canvas, NULL), KM_OK);
  for (int i = 0; i < NAMES; ++i) {
    snprintf(texts[i], sizeof texts[i], "joint %d%s", i, i % 7 ? "" : " with a much longer name than the others have");
    labels[i] = (km_label){
        .text = texts[i], .at = {150 + 9.0 * (i % 10), 120 + 9.0 * (i / 10), 0}, .radius = 3, .colour = KM_BLACK};
  }
  km_projection view = km_view_make(&drawing);
  km_scene scene = {.mechanism = f.mechanism, .view = &view, .arena = &arena};
  km_labels_place(canvas, &scene, NULL, 0, labels, NAMES, &font, place);
  int placed = 0;
  for (int i = 0; i < NAMES; ++i) {
    const km_label *a = &labels[i];
    placed += a->placed;
    for (int k = 0; k < i && a->placed; ++k) {
      const km_label *b = &labels[k];
      assert_false(b->placed && a->box.x < b->box.x + b->size.x && b->box.x < a->box.x + a->size.x &&
                   a->box.y < b->box.y + b->size.y && b->box.y < a->box.y + a->size.y);
    }
  }
  assert_true(placed > NAMES / 2);
  assert_int_equal(km_canvas_finish(canvas, NULL), KM_OK);
  km_canvas_free(canvas);
  km_arena_free(&arena);
  km_text_free(&out);
  fixture_close(&f);
}

static const char *const pendulum = "{\"model_parameters\": {\"version\": \"1.0\"}, \"fixed\": "
                                    "{\"frames\": [{\"name\": \"a\", \"T\": [%s, 0, 0]}]},"
                                    "\"assemblies\": [{\"name\": \"x\", \"bodies\": [{\"name\": "
                                    "\"bob\", \"frames\": [{\"name\": \"t\", \"T\": [%s, 0, 0]}]}],"
                                    "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", "
                                    "\"body_frame_pairs\": [[\"fixed\", \"a\"], \"bob\"]}]}]}";

static void any_size_can_be_drawn(void **state) {
  (void)state;
  static const char *const sizes[][2] = {
      {"0", "1e-12"}, {"0", "1e50"}, {"1e6", "0.001"}, {"0", "0"}, {"1e50", "1e-50"}};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
    char json[1024];
    snprintf(json, sizeof json, pendulum, sizes[i][0], sizes[i][1]);
    fixture f = fixture_read(json);
    km_drawing_def drawing = drawing_of(&f);
    km_text out = {0};
    render(&drawing, KM_PICTURE_SVG, &out);
    assert_null(strstr(out.data, "nan"));
    assert_null(strstr(out.data, "inf"));
    km_text_free(&out);
    fixture_close(&f);
  }
}

static void a_page_too_small_is_refused(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_drawing_def drawing = drawing_of(&f);
  km_text out = {0};
  km_error error;
  drawing.width = drawing.height = 100;
  assert_int_equal(km_drawing_render(&drawing, KM_PICTURE_SVG, &out, &error), KM_USAGE);
  assert_int_equal(out.size, 0);
  km_text_free(&out);
  fixture_close(&f);
}

/* The points of every line in a colour, one line after the other. */
static void lines_in(const char *svg, km_colour colour, km_text *out) {
  char stroke[64];
  snprintf(stroke, sizeof stroke, "stroke=\"#%02lx%02lx%02lx\"", lround(255 * colour.red), lround(255 * colour.green),
           lround(255 * colour.blue));
  for (const char *path = strstr(svg, "<path"); path; path = strstr(path + 1, "<path")) {
    const char *end = strstr(path, "/>"), *d = strstr(path, " d=\""), *own = strstr(path, stroke);
    if (own && d && own < end && d < end)
      km_text_format(out, "%.*s\n", (int)strcspn(d + 4, "\""), d + 4);
  }
}

static void overlay(const fixture *a, const fixture *b, km_text lines[2]) {
  const int colours[2] = {0, 1};
  const km_rectangle place = {10, 10, 180, 180};
  km_text out = {0};
  km_canvas *canvas;
  km_poses_compute(a->mechanism, a->state);
  km_poses_compute(b->mechanism, b->state);
  const km_drawing_def drawings[2] = {
      {.mechanism = a->mechanism, .poses = a->state->pose, .pose_count = 1, .bare = true},
      {.mechanism = b->mechanism, .poses = b->state->pose, .pose_count = 1, .bare = true}};
  assert_int_equal(km_canvas_create(KM_PICTURE_SVG, 200, 200, &out, &canvas, NULL), KM_OK);
  assert_int_equal(km_drawing_overlay(drawings, colours, 2, canvas, place, NULL), KM_OK);
  assert_int_equal(km_canvas_finish(canvas, NULL), KM_OK);
  km_canvas_free(canvas);
  for (int k = 0; k < 2; ++k)
    lines_in(out.data, km_palette_text(colours[k]), &lines[k]);
  km_text_free(&out);
}

/* Equal points coincide, and a longer link's don't. */
static void overlays_share_view_and_scale(void **state) {
  (void)state;
  for (int m = 0; all_models[m]; ++m) {
    fixture a = fixture_open(all_models[m]), b = fixture_open(all_models[m]);
    km_text lines[2] = {{0}, {0}};
    overlay(&a, &b, lines);
    assert_true(lines[0].size > 0);
    assert_string_equal(lines[0].data, lines[1].data);
    fixture_close(&a);
    fixture_close(&b);
    for (int k = 0; k < 2; ++k)
      km_text_free(&lines[k]);
  }
  fixture a = fixture_open("fourbar"), b = fixture_open("klann");
  km_text lines[2] = {{0}, {0}};
  overlay(&a, &b, lines);
  assert_string_not_equal(lines[0].data, lines[1].data);
  fixture_close(&a);
  fixture_close(&b);
  for (int k = 0; k < 2; ++k)
    km_text_free(&lines[k]);
}

static void thumbnails_of_any_size(void **state) {
  (void)state;
  km_text out = {0};
  km_canvas *canvas;
  assert_int_equal(km_canvas_create(KM_PICTURE_PNG, 640, 520, &out, &canvas, NULL), KM_OK);
  for (int m = 0; all_models[m]; ++m) {
    fixture f = fixture_open(all_models[m]);
    km_poses_compute(f.mechanism, f.state);
    km_rectangle place = {10 + 120 * (m % 5), 10 + 100 * (m / 5), 110, 90}, tiny = {600, 10, 2, 1};
    km_drawing_def drawing = {.mechanism = f.mechanism, .poses = f.state->pose, .pose_count = 1, .bare = true};
    assert_int_equal(km_drawing_place(&drawing, canvas, place, NULL), KM_OK);
    drawing.view = KM_VIEW_ISO;
    assert_int_equal(km_drawing_place(&drawing, canvas, tiny, NULL), KM_OK);
    fixture_close(&f);
  }
  assert_int_equal(km_canvas_finish(canvas, NULL), KM_OK);
  km_canvas_free(canvas);
  const char *keep = getenv("KMECH_KEEP_THUMBNAILS");
  FILE *file = keep ? fopen(keep, "wb") : NULL;
  if (file) {
    fwrite(out.data, 1, out.size, file);
    fclose(file);
  }
  km_text_free(&out);
}

/* A row of thumbnails shows a motion: same scale, one pose each. */
static void a_row_of_poses_shares_its_scale(void **state) {
  (void)state;
  fixture f = fixture_open("klann");
  size_t bodies = (size_t)f.model->body_count;
  km_pose *poses = KM_NEW(km_pose, 2 * bodies);
  km_drawing_def drawing = drawing_of(&f);
  memcpy(poses, f.state->pose, bodies * sizeof *poses);
  km_driver_motion *drive;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, true, &drive, NULL), KM_OK);
  km_driver_motion_move_to(drive, 5.0);
  km_driver_motion_free(drive);
  km_poses_compute(f.mechanism, f.state);
  memcpy(poses + bodies, f.state->pose, bodies * sizeof *poses);
  drawing.poses = poses;
  drawing.pose_count = 2;
  drawing.alone = drawing.bare = true;
  double scale[2];
  for (size_t k = 0; k < 2; ++k) {
    drawing.full = k;
    km_studio studio = {.drawing = &drawing, .place = {0, 0, 100, 80}};
    assert_true(km_studio_open(&studio));
    scale[k] = studio.view.scale;
    assert_int_equal(km_studio_close(&studio, NULL), KM_OK);
    km_text out = {0};
    render(&drawing, KM_PICTURE_SVG, &out);
    km_text_free(&out);
  }
  assert_near(scale[0], scale[1], 0.0);
  km_free(poses);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_same_bytes_for_every_model),  cmocka_unit_test(the_plane_of_motion_is_found),
      cmocka_unit_test(views_are_right_handed),          cmocka_unit_test(what_lies_in_front_comes_last),
      cmocka_unit_test(loads_are_arrows_with_names),     cmocka_unit_test(names_do_not_overlap),
      cmocka_unit_test(any_size_can_be_drawn),           cmocka_unit_test(a_page_too_small_is_refused),
      cmocka_unit_test(overlays_share_view_and_scale),   cmocka_unit_test(thumbnails_of_any_size),
      cmocka_unit_test(a_row_of_poses_shares_its_scale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
