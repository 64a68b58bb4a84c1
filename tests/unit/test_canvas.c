/* Text on pages: what HarfBuzz sets alone is where Pango sets it, and nothing gets lost in any script or format. */
#include "support/support.h"

#include "report/canvas/canvas.h"
#include "report/canvas/letters.h"
#include "report/canvas/pango_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static const km_colour ink = {0.1, 0.2, 0.3, 1};

/* Words with kerning, ligatures, signs and places at which Unicode's rules part them, or don't. */
static void add_words(randomness *r, km_text *text) {
  static const char *const words[] = {
      "AVATAR", "To",      "office", "fluffy", "mobility", "ΔxΩ",   "угол",     "20.5",    "least-norm",
      "N·m",    "rad/s",   "(K)",    "×10⁻⁶",  "−0.25",    "100 %", "[0, 1]",   "Ty—We",   "end…",
      "a/b/c",  "x-y-z",   "5-bar",  "W.,T,",  "\"LTV\"",  "café",  "Łódź",     "naïve",   "→ λ = 3",
      "▲",      "what?no", "q'=v'",  "A1:B2",  "45°",      "f̄",     "a_b_c_d",  "c++",     "e.g.",
      "10-20",  "-x",      "x -",    "1/2",    "m/s²",     "a & b", "~/models", "≤ 1e-12", "‘one’"};
  for (int n = 1 + below(r, 14); n > 0; --n) {
    km_text_add(text, words[below(r, (int)(sizeof words / sizeof *words))]);
    if (n > 1)
      km_text_add(text, below(r, 12) ? " " : "  ");
  }
}

typedef struct line_list {
  km_pango_line lines[64];
  size_t count;
} line_list;

static void take(void *context, const km_pango_line *line) {
  line_list *list = context;
  assert_true(list->count < 64);
  list->lines[list->count++] = *line;
}

/* Pango counts in 1/1024 of a point, glyph by glyph. */
static void check_same(const km_letters *letters, km_pango *pango, const km_font *font, const char *text) {
  km_text_box box = km_pango_set(pango, font, text);
  double slack = (double)(letters->count + 2) / 1024 + letters->unit;
  line_list list = {.count = 0};
  km_pango_lines(pango, take, &list);
  assert_int_equal(letters->line_count, list.count);
  for (size_t i = 0; i < list.count; ++i) {
    const km_letters_line *own = &letters->lines[i];
    assert_int_equal(own->begin, list.lines[i].begin);
    assert_near(own->width, list.lines[i].width, slack);
    assert_near((KM_FONT_ASCENT + KM_FONT_HEIGHT * (double)i) * font->size, list.lines[i].baseline - box.top,
                0.001 * font->size * (double)(i + 1) + slack);
  }
  assert_near(letters->width, box.width, slack);
}

static void letters_are_where_pango_sets_them(void **state) {
  (void)state;
  enum { TEXTS = 3000 };
  randomness r = {11};
  km_letters letters = {0};
  km_pango *pango;
  int set = 0, parted = 0;
  assert_int_equal(km_pango_create(&pango, NULL), KM_OK);
  for (int i = 0; i < TEXTS; ++i) {
    km_text text = {0};
    add_words(&r, &text);
    const km_font font = {.size = 0.5 * (10 + below(&r, 30)),
                          .bold = below(&r, 3) == 0,
                          .width = below(&r, 2) ? uniform(&r, 30, 500) : 0,
                          .lines = below(&r, 6)};
    if (km_letters_set(&letters, &font, text.data)) {
      check_same(&letters, pango, &font, text.data);
      ++set;
      parted += letters.line_count > 1;
    }
    km_text_free(&text);
  }
  print_message("%d of %d texts, %d in several lines\n", set, TEXTS, parted);
  assert_true(set > TEXTS / 2 && parted > TEXTS / 20);
  km_pango_free(pango);
  km_letters_free(&letters);
}

/* Marks on letters, other directions, other fonts, controls, bad bytes. */
static const char *const others[] = {"f\xcc\x84",
                                     "שלום",
                                     "مفصل",
                                     "关节",
                                     "ジョイント",
                                     "काज",
                                     "a\tb",
                                     "a\nb",
                                     "a\xc2\xad"
                                     "b",
                                     "\xe2\x80\x8f"
                                     "x",
                                     "\xff",
                                     "\xc3",
                                     "\xf0\x9f\x94\xa9",
                                     "\xed\xa0\x80"};

static void other_text_is_left_to_pango(void **state) {
  (void)state;
  km_letters letters = {0};
  const km_font font = {.size = 10};
  for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
    assert_false(km_letters_set(&letters, &font, others[i]));
  km_letters_free(&letters);
}

/* Extent from the leftmost to the rightmost point drawn by Pango. */
static void outline_reach(km_pango *pango, double *left, double *right) {
  km_canvas_path path = {0};
  km_pango_outline(pango, &path);
  assert_false(path.failed);
  *left = HUGE_VAL;
  *right = -HUGE_VAL;
  for (size_t i = 0; i < path.point_count; ++i) {
    *left = fmin(*left, path.points[i].x);
    *right = fmax(*right, path.points[i].x);
  }
  km_canvas_path_free(&path);
}

/* The outlines of a text fill its box from end to end, however long it is, and where lines from the right begin far
 * from the left. */
static void outlines_fill_their_box(void **state) {
  (void)state;
  static const char *const words[] = {"关节", "מפרק", "مفصل", "ジョイント", "plain"};
  km_pango *pango;
  assert_int_equal(km_pango_create(&pango, NULL), KM_OK);
  for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
    for (int repeated = 1; repeated <= 60; repeated += 59)
      for (int wide = 0; wide < 2; ++wide) {
        const km_font font = {.size = 10, .width = wide ? 3000 : 0};
        km_text text = {0};
        double left, right;
        for (int k = 0; k < repeated; ++k)
          km_text_add(&text, words[i]);
        km_text_box box = km_pango_set(pango, &font, text.data);
        outline_reach(pango, &left, &right);
        assert_near(left, box.left, 0.5 * font.size);
        assert_near(right, box.left + box.width, 0.5 * font.size);
        km_text_free(&text);
      }
  km_pango_free(pango);
}

static void draw(int format, const char *text, const km_font *font, double angle, km_text *out) {
  km_canvas *canvas;
  km_error error = {0};
  assert_int_equal(km_canvas_create((km_picture_format)format, 200, 100, out, &canvas, &error), KM_OK);
  km_canvas_clip(canvas, 0, 0, 190, 90);
  km_canvas_shift(canvas, 5, 7);
  km_canvas_text(canvas, font, ink, text, (km_canvas_point){50, 40}, (km_anchor){0.5, 0.5, angle});
  km_canvas_release(canvas);
  assert_int_equal(km_canvas_finish(canvas, &error), KM_OK);
  km_canvas_free(canvas);
}

/* Each text leaves marks on the page in every format, whatever sets it, and equal bytes when repeated. */
static void every_text_is_drawn(void **state) {
  (void)state;
  const km_font font = {.size = 12};
  for (int format = KM_PICTURE_SVG; format <= KM_PICTURE_PNG; ++format) {
    km_text empty = {0};
    draw(format, "", &font, 0, &empty);
    for (size_t i = 0; i < sizeof others / sizeof *others + 1; ++i) {
      const char *text = i ? others[i - 1] : "plain";
      km_text out = {0}, again = {0};
      draw(format, text, &font, 0.4, &out);
      draw(format, text, &font, 0.4, &again);
      assert_int_equal(out.size, again.size);
      assert_memory_equal(out.data, again.data, out.size);
      assert_true(out.size > empty.size + 20);
      km_text_free(&out);
      km_text_free(&again);
    }
    km_text_free(&empty);
  }
}

static size_t occurrences(const char *text, const char *of) {
  size_t count = 0;
  for (const char *at = strstr(text, of); at; at = strstr(at + 1, of))
    ++count;
  return count;
}

/* Each glyph that is used is defined, once; blanks aren't. */
static void glyphs_are_defined_once(void **state) {
  (void)state;
  const km_font plain = {.size = 9}, bold = {.size = 12, .bold = true};
  km_text out = {0};
  km_canvas *canvas;
  assert_int_equal(km_canvas_create(KM_PICTURE_SVG, 200, 100, &out, &canvas, NULL), KM_OK);
  km_canvas_text(canvas, &plain, ink, "add a dad", (km_canvas_point){10, 10}, (km_anchor){0, 0, 0});
  km_canvas_text(canvas, &bold, ink, "dad", (km_canvas_point){10, 30}, (km_anchor){0, 0, 0});
  assert_int_equal(km_canvas_finish(canvas, NULL), KM_OK);
  km_canvas_free(canvas);
  assert_int_equal(occurrences(out.data, "<use "), 10);
  assert_int_equal(occurrences(out.data, " id=\""), 4);
  for (const char *use = strstr(out.data, "href=\"#"); use; use = strstr(use + 1, "href=\"#")) {
    char id[40];
    const char *name = use + strlen("href=\"#");
    snprintf(id, sizeof id, " id=\"%.*s\"", (int)strcspn(name, "\""), name);
    assert_int_equal(occurrences(out.data, id), 1);
  }
  km_text_free(&out);
}

/* The area of a text equals its measured box, rotated or not, at its position: the ends of its first and last
 * letter's advance are those of the box. */
static void text_is_held_where_asked(void **state) {
  (void)state;
  const km_font font = {.size = 10};
  km_canvas *canvas;
  km_text out = {0};
  assert_int_equal(km_canvas_create(KM_PICTURE_SVG, 200, 200, &out, &canvas, NULL), KM_OK);
  const km_canvas_point size = km_canvas_measure(canvas, &font, "HAH"), at = {100, 120};
  km_canvas_text(canvas, &font, ink, "HAH", at, (km_anchor){1, 1, 0});
  km_canvas_text(canvas, &font, ink, "HAH", at, (km_anchor){0.5, 0, -M_PI / 2});
  assert_int_equal(km_canvas_finish(canvas, NULL), KM_OK);
  km_canvas_free(canvas);
  double x, y, turned_x, turned_y, angle;
  const char *found = strstr(out.data, "translate(");
  assert_non_null(found);
  assert_int_equal(sscanf(found, "translate(%lf %lf)scale", &x, &y), 2);
  found = strstr(found + 1, "translate(");
  assert_non_null(found);
  assert_int_equal(sscanf(found, "translate(%lf %lf)rotate(%lf)", &turned_x, &turned_y, &angle), 3);
  const double digits = 0.0006; /* three decimals are written */
  double ascent = KM_FONT_ASCENT * font.size;
  assert_near(x, at.x - size.x, digits);
  assert_near(y, at.y - size.y + ascent, digits);
  assert_near(angle, -90.0, digits);
  assert_near(turned_x, at.x + ascent, digits);
  assert_near(turned_y, at.y + 0.5 * size.x, digits);
  km_text_free(&out);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(letters_are_where_pango_sets_them), cmocka_unit_test(other_text_is_left_to_pango),
      cmocka_unit_test(outlines_fill_their_box),           cmocka_unit_test(every_text_is_drawn),
      cmocka_unit_test(glyphs_are_defined_once),           cmocka_unit_test(text_is_held_where_asked),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
