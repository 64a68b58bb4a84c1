/* Outlines of links: closed, at true scale, with the requested width; equal in the DXF text. */
#include "support/support.h"

#include "report/drawing/drawing_parts.h"
#include "report/drawing/link_outlines.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static km_drawing_def drawing_of(fixture *f) {
  km_poses_compute(f->mechanism, f->state);
  return (km_drawing_def){.mechanism = f->mechanism, .poses = f->state->pose, .pose_count = 1};
}

static km_canvas_point on_arc(const km_outline_part *arc, double angle) {
  return (km_canvas_point){arc->from.x + arc->radius * cos(angle), arc->from.y + arc->radius * sin(angle)};
}

/* Each line ends where the next arc begins, and each arc where the next line does, around the body and back; all of it
 * turns left by one whole turn. */
static void check_ring(const km_outline_part *parts, size_t count, double size) {
  double turned = 0.0;
  assert_true(count >= 4 && count % 2 == 0);
  for (size_t i = 0; i < count; i += 2) {
    const km_outline_part *line = &parts[i], *arc = &parts[i + 1], *next = &parts[(i + 2) % count];
    assert_true(line->kind == KM_OUTLINE_LINE && arc->kind == KM_OUTLINE_ARC);
    km_canvas_point begin = on_arc(arc, arc->begin), end = on_arc(arc, arc->end);
    assert_true(hypot(begin.x - line->to.x, begin.y - line->to.y) < 1e-12 * size);
    assert_true(hypot(end.x - next->from.x, end.y - next->from.y) < 1e-12 * size);
    double turn = fmod(arc->end - arc->begin + 4.0 * M_PI, 2.0 * M_PI);
    assert_true(turn > 0.0 && turn < M_PI + 1e-9);
    turned += turn;
  }
  assert_near(turned, 2.0 * M_PI, 1e-9);
}

static void outlines_are_closed_around_each_link(void **state) {
  (void)state;
  static const char *const names[] = {"klann", "fourbar", "brake", "slider_crank"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n]);
    km_drawing_def drawing = drawing_of(&f);
    km_arena arena = {0};
    km_outlines o;
    km_error error;
    assert_int_equal(km_outlines_make(&drawing, 0.0, &arena, &o, &error), KM_OK);
    double size = hypot(o.high[0] - o.low[0], o.high[1] - o.low[1]);
    for (size_t i = 0, end; i < o.count; i = end) {
      for (end = i + 1; end < o.count && o.parts[end].body == o.parts[i].body;)
        ++end;
      size_t ring = 0;
      while (i + ring < end && o.parts[i + ring].kind != KM_OUTLINE_CIRCLE)
        ++ring;
      if (ring)
        check_ring(o.parts + i, ring, size);
      for (size_t k = i + ring; k < end; ++k)
        assert_true(o.parts[k].kind == KM_OUTLINE_CIRCLE);
    }
    km_arena_free(&arena);
    fixture_close(&f);
  }
}

/* Holes of one body are as far apart as its joints are in the model, whatever the pose. */
static void holes_are_at_true_distances(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_drawing_def drawing = drawing_of(&f);
  km_arena arena = {0};
  km_outlines o;
  km_error error;
  assert_int_equal(km_outlines_make(&drawing, 0.25, &arena, &o, &error), KM_OK);
  assert_true(o.width == 0.25);
  for (int b = 1; b < f.model->body_count; ++b) {
    const km_outline_part *holes[8];
    size_t count = 0;
    for (size_t i = 0; i < o.count; ++i)
      if (o.parts[i].body == b && o.parts[i].kind == KM_OUTLINE_CIRCLE)
        holes[count++] = &o.parts[i];
    assert_int_equal(count, 2);
    assert_near(holes[0]->radius, 0.0625, 1e-15);
    km_vec3 at[2];
    size_t found = 0;
    for (int j = 0; j < f.model->joint_count; ++j)
      for (int end = 0; end < 2; ++end)
        if (km_joint_body(f.model, j, end) == b)
          at[found++] = f.model->frames[f.model->joints[j].frame[end]].pose.p;
    assert_int_equal(found, 2);
    assert_near(hypot(holes[0]->from.x - holes[1]->from.x, holes[0]->from.y - holes[1]->from.y),
                km_vec3_norm(km_vec3_sub(at[0], at[1])), 1e-12);
  }
  km_arena_free(&arena);
  fixture_close(&f);
}

/* Pairs of lines; every entity on a layer that the table has; as many entities as parts. */
static void dxf_holds_every_part(void **state) {
  (void)state;
  fixture f = fixture_open("klann");
  km_drawing_def drawing = drawing_of(&f);
  km_arena arena = {0};
  km_outlines o;
  km_text out = {0};
  km_error error;
  assert_int_equal(km_outlines_make(&drawing, 0.0, &arena, &o, &error), KM_OK);
  assert_int_equal(km_outlines_dxf(&o, &out, &error), KM_OK);
  size_t entities = 0, layers = 0;
  char value[80];
  for (const char *at = out.data; *at;) {
    int group = 0, read = 0;
    assert_int_equal(sscanf(at, "%d\r\n%79[^\r]\r\n%n", &group, value, &read), 2);
    assert_true(read > 0);
    at += read;
    if (group == 0) {
      entities += strcmp(value, "LINE") == 0 || strcmp(value, "ARC") == 0 || strcmp(value, "CIRCLE") == 0;
      layers += strcmp(value, "LAYER") == 0;
    }
    if (group == 10 && entities > 0) {
      double expected = o.parts[entities - 1].from.x;
      assert_true(strtod(value, NULL) == expected);
    }
  }
  assert_string_equal(value, "EOF");
  assert_int_equal(entities, o.count);
  assert_int_equal(layers, f.model->body_count);
  assert_non_null(strstr(out.data, "$INSUNITS\r\n 70\r\n6\r\n")); /* metres */
  assert_non_null(strstr(out.data, "1_CRANK"));
  km_text_free(&out);
  km_arena_free(&arena);
  fixture_close(&f);
}

/* Metres at 1:100: a page as many points wide as the outlines are centimetres, and a margin. */
static void pages_are_at_scale(void **state) {
  (void)state;
  fixture f = fixture_open("klann");
  km_drawing_def drawing = drawing_of(&f);
  km_arena arena = {0};
  km_outlines o;
  km_text out = {0};
  km_error error;
  double width = 0.0;
  assert_int_equal(km_outlines_make(&drawing, 0.0, &arena, &o, &error), KM_OK);
  assert_int_equal(km_outlines_render(&o, 0.01, KM_PICTURE_SVG, &out, &error), KM_OK);
  const char *found = strstr(out.data, "width=\"");
  assert_non_null(found);
  width = strtod(found + 7, NULL);
  assert_near(width - 36.0, (o.high[0] - o.low[0]) * 0.01 / 0.0254 * 72.0, 1e-5);
  assert_int_equal(km_outlines_render(&o, 1e6, KM_PICTURE_SVG, &out, &error), KM_USAGE);
  km_text_free(&out);
  km_arena_free(&arena);
  fixture_close(&f);
}

static void space_has_no_outlines(void **state) {
  (void)state;
  fixture f = fixture_open("stewart");
  km_drawing_def drawing = drawing_of(&f);
  km_arena arena = {0};
  km_outlines o;
  km_error error;
  assert_int_equal(km_outlines_make(&drawing, 0.0, &arena, &o, &error), KM_USAGE);
  km_arena_free(&arena);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(outlines_are_closed_around_each_link),
      cmocka_unit_test(holes_are_at_true_distances),
      cmocka_unit_test(dxf_holds_every_part),
      cmocka_unit_test(pages_are_at_scale),
      cmocka_unit_test(space_has_no_outlines),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
