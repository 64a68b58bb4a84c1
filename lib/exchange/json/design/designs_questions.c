/* The questions of a study. */
#include "exchange/json/design/designs_reader.h"

#include <math.h>
#include <string.h>

static const char *const kinds[KM_DESIGN_FIGURE_KINDS] = {[KM_DESIGN_MIN] = "min",
                                                          [KM_DESIGN_MAX] = "max",
                                                          [KM_DESIGN_SPAN] = "span",
                                                          [KM_DESIGN_MEAN] = "mean",
                                                          [KM_DESIGN_AT] = "at",
                                                          [KM_DESIGN_WHERE_MIN] = "where min",
                                                          [KM_DESIGN_WHERE_MAX] = "where max",
                                                          [KM_DESIGN_RMS] = "rms",
                                                          [KM_DESIGN_PEAK] = "peak",
                                                          [KM_DESIGN_WHERE_PEAK] = "where peak",
                                                          [KM_DESIGN_LAST] = "last",
                                                          [KM_DESIGN_SETTLING] = "settling",
                                                          [KM_DESIGN_REACHED] = "reached",
                                                          [KM_DESIGN_TOGGLES] = "toggles",
                                                          [KM_DESIGN_DISTANCE] = "distance",
                                                          [KM_DESIGN_FORMULA] = "formula"};

static const double default_settling = 0.02; /* part of the largest distance from the last value */

static bool find_kind(const char *word, size_t length, km_design_figure_kind *out) {
  for (int k = 0; k < KM_DESIGN_FIGURE_KINDS; ++k)
    if (strlen(kinds[k]) == length && memcmp(kinds[k], word, length) == 0) {
      *out = (km_design_figure_kind)k;
      return true;
    }
  return false;
}

/* True for a text with an operator whose first word is no kind of figure: "start/end". */
static bool is_formula(const char *text, bool known) {
  return !known && strpbrk(text, "+-*/^(");
}

/* "min ma.A/B", "where max q.K", "reached", "start/end". */
static void read_short(km_designs_reader *d, const char *text, const km_place *place, km_design_figure *out) {
  const char *blank = strncmp(text, "where ", 6) == 0 ? strchr(text + 6, ' ') : strchr(text, ' ');
  bool known = find_kind(text, blank ? (size_t)(blank - text) : strlen(text), &out->kind);
  if (is_formula(text, known)) {
    out->kind = KM_DESIGN_FORMULA;
    out->column = text;
    return;
  }
  bool alone = out->kind == KM_DESIGN_REACHED || out->kind == KM_DESIGN_TOGGLES;
  if (!known || alone == (blank != NULL) || out->kind == KM_DESIGN_AT || out->kind == KM_DESIGN_DISTANCE ||
      out->kind == KM_DESIGN_FORMULA)
    km_designs_error(
        d, place,
        "expected min, max, span, mean, rms, peak, last, settling, where min, where max or where peak and a "
        "column, reached or toggles, or an expression of figures before it");
  out->column = blank ? blank + 1 : NULL;
  out->at = out->kind == KM_DESIGN_SETTLING ? default_settling : 0.0;
}

static void read_points(km_designs_reader *d, const km_value *rows, const km_place *place, km_design_figure *out) {
  double *points = KM_ARENA_NEW(d->arena, double, 3 * (rows ? rows->count : 0) + 1);
  km_place list = {place, "through", 0}, at = {&list, NULL, 0};
  for (const km_value *row = rows ? rows->first : NULL; row && points; row = row->next, ++at.index) {
    int k = 0;
    if (row->count != 2 && row->count != 3)
      km_designs_error(d, &at, "expected [x, y] or [x, y, z]");
    for (const km_value *v = row->first; v && k < 3; v = v->next)
      points[3 * out->point_count + k++] = v->number;
    ++out->point_count;
  }
  out->points = points;
}

static int better_of(km_designs_reader *d, const km_value *object, const km_place *place) {
  const char *word = km_designs_text(object, "better");
  km_place at = {place, "better", 0};
  if (!word || strcmp(word, "larger") == 0)
    return word != NULL;
  if (strcmp(word, "smaller") != 0)
    km_designs_error(d, &at, "expected larger or smaller");
  return -1;
}

static void read_figure(km_designs_reader *d, const km_value *v, const km_place *place, km_design_figure *out) {
  *out = (km_design_figure){.name = v->key, .low = -HUGE_VAL, .high = HUGE_VAL};
  if (v->kind == KM_STRING) {
    read_short(d, v->string, place, out);
    return;
  }
  const char *word = km_designs_text(v, "figure");
  km_place at = {place, "figure", 0};
  if (!find_kind(word, strlen(word), &out->kind))
    km_designs_error(
        d, &at,
        "expected min, max, span, mean, at, rms, peak, last, settling, where min, where max, where peak, reached, "
        "toggles, distance or formula");
  out->column = km_designs_text(v, out->kind == KM_DESIGN_DISTANCE  ? "point"
                                   : out->kind == KM_DESIGN_FORMULA ? "formula"
                                                                    : "column");
  out->at = km_designs_number(v, "at", nan(""));
  if (out->kind == KM_DESIGN_AT && isnan(out->at))
    km_designs_error(d, place, "\"at\" is missing; expected the driver's value");
  if (out->kind != KM_DESIGN_AT)
    out->at = out->kind == KM_DESIGN_SETTLING ? km_designs_number(v, "within", default_settling) : 0.0;
  out->low = km_designs_number(v, "low", -HUGE_VAL);
  out->high = km_designs_number(v, "high", HUGE_VAL);
  out->better = better_of(d, v, place);
  read_points(d, km_value_get(v, "through"), place, out);
}

/* Adds a number or a text to an option. */
static void add_to_option(km_designs_reader *d, const km_value *item, const km_place *place, double *numbers,
                          const char **texts, km_design_option *out) {
  if (item->kind == KM_NUMBER)
    numbers[out->number_count++] = item->number;
  else if (item->kind == KM_STRING)
    texts[out->text_count++] = item->string;
  else
    km_designs_error(d, place, "expected true or false, a number, a text, or a list of these");
}

/* true, a number, a text, a list of either; a list of a text and a number is a joint with a sense, and so is
 * {"joint", "sign"}, as a model has it. Another object is a number for each joint. */
static void read_option(km_designs_reader *d, const km_value *v, const km_place *place, km_design_option *out) {
  bool map = v->kind == KM_OBJECT;
  bool sense = map && v->count == 2 && km_value_get(v, "joint") && km_value_get(v, "sign");
  double *numbers = KM_ARENA_NEW(d->arena, double, v->count + 1);
  const char **texts = KM_ARENA_NEW(d->arena, const char *, v->count + 1);
  *out = (km_design_option){.name = v->key, .numbers = numbers, .texts = texts};
  out->flag = v->kind == KM_BOOLEAN && v->number != 0.0;
  if (!texts || v->kind == KM_BOOLEAN)
    return;
  if (!map && v->kind != KM_LIST)
    add_to_option(d, v, place, numbers, texts, out);
  for (const km_value *item = map || v->kind == KM_LIST ? v->first : NULL; item; item = item->next) {
    if (map && !sense)
      texts[out->text_count++] = item->key;
    add_to_option(d, item, place, numbers, texts, out);
  }
}

static void read_options(km_designs_reader *d, const km_value *map, const km_place *place, km_design_question *out) {
  km_place list = {place, "options", 0};
  if (map && map->kind != KM_OBJECT) {
    km_designs_error(d, &list, "expected an object {option: value}");
    return;
  }
  km_design_option *options = KM_ARENA_NEW(d->arena, km_design_option, map ? map->count + 1 : 1);
  for (const km_value *v = map ? map->first : NULL; v && options; v = v->next) {
    km_place at = {&list, v->key, 0};
    read_option(d, v, &at, &options[out->option_count++]);
  }
  out->options = options;
}

/* A joint with several coordinates has a list: one setting each, by "joint[k]". */
static const km_design_setting *read_settings(km_designs_reader *d, const km_value *map, int *count) {
  size_t room = 1;
  for (const km_value *v = map ? map->first : NULL; v; v = v->next)
    room += v->kind == KM_LIST ? v->count : 1;
  km_design_setting *out = KM_ARENA_NEW(d->arena, km_design_setting, room);
  for (const km_value *v = map ? map->first : NULL; v && out; v = v->next) {
    if (v->kind != KM_LIST)
      out[(*count)++] = (km_design_setting){v->key, v->number};
    int k = 0;
    for (const km_value *item = v->kind == KM_LIST ? v->first : NULL; item; item = item->next) {
      km_text name = {0};
      km_text_format(&name, "%s[%d]", v->key, k++);
      out[(*count)++] = (km_design_setting){km_text_move_to_arena(&name, d->arena), item->number};
    }
  }
  return out;
}

static void read_question(km_designs_reader *d, const km_value *v, const km_place *place, km_design_question *out) {
  const km_value *figures = km_value_get(v, "figures");
  km_design_figure *list = KM_ARENA_NEW(d->arena, km_design_figure, figures ? figures->count + 1 : 1);
  km_place inside = {place, "figures", 0};
  *out = (km_design_question){.name = km_designs_text(v, "name"), .kind = km_designs_text(v, "question")};
  if (!out->name)
    out->name = out->kind;
  read_options(d, km_value_get(v, "options"), place, out);
  out->holds = read_settings(d, km_value_get(v, "hold"), &out->hold_count);
  out->sets = read_settings(d, km_value_get(v, "set"), &out->set_count);
  for (const km_value *f = figures ? figures->first : NULL; f && list; f = f->next) {
    km_place at = {&inside, f->key, 0};
    read_figure(d, f, &at, &list[out->figure_count++]);
  }
  out->figures = list;
  out->bands = km_designs_texts(d, km_value_get(v, "bands"), &out->band_count);
}

void km_designs_read_questions(km_designs_reader *d, const km_value *list) {
  km_design_question *questions = KM_ARENA_NEW(d->arena, km_design_question, list->count + 1);
  km_place place = {NULL, "ask", 0}, at = {&place, NULL, 0};
  for (const km_value *v = list->first; v && questions; v = v->next, ++at.index)
    read_question(d, v, &at, &questions[d->def->question_count++]);
  d->def->questions = questions;
}
