/* Reads the options of a question by their types. */
#include "common/command_line/question_options.h"

#include "kmech/inspect.h"

#include <stdio.h>
#include <string.h>

static kt_exit read_range(const kt_common *common, const char *name, const char *text, double out[2]) {
  const char *colon = strchr(text, ':');
  char from[64];
  if (!colon || (size_t)(colon - text) >= sizeof from)
    return kt_usage(common, name, text, "FROM:TO");
  snprintf(from, sizeof from, "%.*s", (int)(colon - text), text);
  bool good = kt_number(from, &out[0]) && kt_number(colon + 1, &out[1]);
  return good ? KT_DONE : kt_usage(common, name, text, "two numbers FROM:TO");
}

static kt_exit read_whole(const kt_common *common, const km_option *o, const char *name, const char *text, int *out) {
  char expected[80];
  snprintf(expected, sizeof expected, "a whole number from %.0f to %.0f", o->low, o->high);
  return kt_integer(text, (int)o->low, (int)o->high, out) ? KT_DONE : kt_usage(common, name, text, expected);
}

static kt_exit read_number(const kt_common *common, const km_option *o, const char *name, const char *text,
                           double *out) {
  char expected[80];
  snprintf(expected, sizeof expected, "a number greater than %g and at most %g", o->low, o->high);
  return kt_number(text, out) && *out > o->low && *out <= o->high ? KT_DONE : kt_usage(common, name, text, expected);
}

static kt_exit read_sense(const kt_common *common, const km_model *model, const char *name, const char *text,
                          km_option_value *out) {
  const char *rest = text;
  kt_piece label = kt_split(&rest, "=");
  kt_exit result;
  if (label.separator != '=' || !kt_number(rest, &out->numbers[0]) || out->numbers[0] == 0.0)
    result = kt_usage(common, name, text, "JOINT=+1 or JOINT=-1");
  else
    result = kt_coordinate(common, model, name, label.text, &out->coordinate);
  km_free(label.text);
  return result;
}

/* The third of two numbers is 0, as in the file. */
static kt_exit read_vector(const kt_common *common, const char *name, const char *text, double *out) {
  bool given = kt_numbers(text, 3, out);
  if (!given && kt_numbers(text, 2, out)) {
    out[2] = 0.0;
    given = true;
  }
  return given ? KT_DONE : kt_usage(common, name, text, "two or three numbers X,Y or X,Y,Z");
}

static kt_exit read_coordinates(const kt_common *common, const km_model *model, const char *name, const char *text,
                                km_arena *arena, km_option_value *out) {
  int *list = KM_ARENA_NEW(arena, int, (size_t)km_model_coordinate_count(model) + 1);
  out->coordinates = list;
  return list ? kt_coordinates(common, model, name, text, list, &out->count) : KT_NO_MEMORY;
}

static kt_exit read_points(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                           km_arena *arena, km_option_value *out) {
  km_sweep_point *points = KM_ARENA_NEW(arena, km_sweep_point, (size_t)texts->count);
  kt_exit result = points ? kt_each_once(common, name, texts->items, texts->count) : KT_NO_MEMORY;
  out->points = points;
  out->count = texts->count;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i) {
    char *plain = kt_plain(texts->items[i]);
    points[i].name = km_arena_string(arena, plain);
    km_free(plain);
    result = points[i].name ? kt_frame(common, model, name, texts->items[i], &points[i].frame) : KT_NO_MEMORY;
  }
  return result;
}

static kt_exit read_ends(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                         km_arena *arena, km_option_value *out) {
  km_port *ends = KM_ARENA_NEW(arena, km_port, (size_t)texts->count);
  kt_exit result = ends ? kt_each_once(common, name, texts->items, texts->count) : KT_NO_MEMORY;
  out->ends = ends;
  out->count = texts->count;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i)
    result = kt_direction(texts->items[i]) ? kt_end(common, model, name, texts->items[i], arena, &ends[i])
                                           : kt_usage(common, name, texts->items[i], "BODY/FRAME:DX,DY,DZ");
  return result;
}

/* JOINT=RATE: "60rpm", or a number in the model's unit per time unit. */
static kt_exit read_rate(const kt_common *common, const km_model *model, const char *name, const char *text,
                         int *coordinate, double *rate) {
  const char *rest = text;
  kt_piece label = kt_split(&rest, "=");
  kt_exit result;
  if (label.separator != '=')
    result = kt_usage(common, name, text, "JOINT=RATE, as A=60rpm or A=2.5");
  else
    result = kt_coordinate(common, model, name, label.text, coordinate);
  km_free(label.text);
  if (result == KT_DONE && !kt_rate(model, *coordinate, rest, rate))
    result = kt_usage(common, name, text, "a rate in the model's unit per time unit, or of an angle in rpm");
  return result;
}

static kt_exit read_rates(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                          km_arena *arena, km_option_value *out) {
  int *coordinates = KM_ARENA_NEW(arena, int, (size_t)texts->count + 1);
  double *rates = KM_ARENA_NEW(arena, double, (size_t)texts->count + 1);
  kt_exit result = arena->failed ? KT_NO_MEMORY : KT_DONE;
  out->coordinates = coordinates;
  out->settings = rates;
  out->count = texts->count;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i)
    result = read_rate(common, model, name, texts->items[i], &coordinates[i], &rates[i]);
  return result;
}

/* JOINT=VALUE, several values of one joint too. */
static kt_exit read_values(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                           km_arena *arena, km_option_value *out) {
  size_t most = (size_t)texts->count * (size_t)km_model_coordinate_count(model);
  int *coordinates = KM_ARENA_NEW(arena, int, most + 1);
  double *values = KM_ARENA_NEW(arena, double, most + 1);
  kt_exit result = arena->failed ? KT_NO_MEMORY : KT_DONE;
  out->coordinates = coordinates;
  out->settings = values;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i) {
    kt_settings one = {0};
    char *text = (char *)(size_t)texts->items[i];
    result = kt_settings_add(common, model, name, &text, 1, &one);
    for (int k = 0; k < one.count && result == KT_DONE; ++k) {
      coordinates[out->count] = one.items[k].coordinate;
      values[out->count++] = one.items[k].value;
    }
    kt_settings_free(&one);
  }
  return result;
}

/* Names of force modules, each once, or "all". */
static kt_exit read_modules(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                            km_arena *arena, km_option_value *out) {
  bool all = texts->count == 1 && strcmp(texts->items[0], "all") == 0 && km_model_find_module(model, "all") < 0;
  out->count = all ? km_model_module_count(model) : texts->count;
  int *modules = KM_ARENA_NEW(arena, int, (size_t)out->count + 1);
  kt_exit result = modules ? kt_each_once(common, name, texts->items, texts->count) : KT_NO_MEMORY;
  out->modules = modules;
  for (int i = 0; i < out->count && result == KT_DONE; ++i) {
    modules[i] = all ? i : km_model_find_module(model, texts->items[i]);
    if (modules[i] < 0)
      result = kt_usage(common, name, texts->items[i], "all, or the name of one force module");
  }
  return result;
}

/* BODY,BODY */
static kt_exit read_bodies(const kt_common *common, const km_model *model, const char *name, const char *text,
                           km_body_pair *out) {
  const char *rest = text;
  kt_piece body[2];
  for (int k = 0; k < 2; ++k)
    body[k] = kt_split(&rest, ",");
  kt_exit result = body[0].separator && !body[1].separator ? KT_DONE : kt_usage(common, name, text, "BODY,BODY");
  for (int k = 0; k < 2; ++k) {
    int frame = -1;
    if (result == KT_DONE)
      result = kt_frame(common, model, name, body[k].text, &frame);
    out->body[k] = km_model_frame_body(model, frame);
    km_free(body[k].text);
  }
  return result;
}

static kt_exit read_body_pairs(const kt_common *common, const km_model *model, const char *name, const kt_texts *texts,
                               km_arena *arena, km_option_value *out) {
  km_body_pair *pairs = KM_ARENA_NEW(arena, km_body_pair, (size_t)texts->count);
  kt_exit result = pairs ? kt_each_once(common, name, texts->items, texts->count) : KT_NO_MEMORY;
  out->pairs = pairs;
  out->count = texts->count;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i)
    result = read_bodies(common, model, name, texts->items[i], &pairs[i]);
  return result;
}

static kt_exit read_pair(const kt_common *common, const km_option *o, const char *name, const char *text, double *out) {
  out[1] = 0.0;
  return kt_numbers(text, strchr(text, ',') ? 2 : 1, out) ? KT_DONE : kt_usage(common, name, text, o->argument);
}

kt_exit kt_question_value(const kt_common *common, const km_model *model, const km_option *o, const char *name,
                          const kt_texts *texts, km_arena *arena, km_option_value *out) {
  const char *text = texts->items[texts->count - 1];
  switch (o->type) {
  case KM_OPTION_FLAG:
    out->flag = true;
    return KT_DONE;
  case KM_OPTION_WHOLE:
    return read_whole(common, o, name, text, &out->whole);
  case KM_OPTION_NUMBER:
    return read_number(common, o, name, text, &out->numbers[0]);
  case KM_OPTION_RANGE:
    return read_range(common, name, text, out->numbers);
  case KM_OPTION_VECTOR:
    return read_vector(common, name, text, out->numbers);
  case KM_OPTION_WORD:
    out->whole = kt_word_place(o->words, text);
    return out->whole >= 0 ? KT_DONE : kt_usage(common, name, text, o->words);
  case KM_OPTION_COORDINATE:
    return kt_coordinate(common, model, name, text, &out->coordinate);
  case KM_OPTION_SENSE:
    return read_sense(common, model, name, text, out);
  case KM_OPTION_COORDINATES:
    return read_coordinates(common, model, name, text, arena, out);
  case KM_OPTION_SETTINGS:
    return (strcmp(o->name, "rate") == 0 ? read_rates : read_values)(common, model, name, texts, arena, out);
  case KM_OPTION_MODULES:
    return read_modules(common, model, name, texts, arena, out);
  case KM_OPTION_BODY_PAIRS:
    return read_body_pairs(common, model, name, texts, arena, out);
  case KM_OPTION_PAIR:
    return read_pair(common, o, name, text, out->numbers);
  case KM_OPTION_POINTS:
    return read_points(common, model, name, texts, arena, out);
  case KM_OPTION_END:
    return kt_end(common, model, name, text, arena, &out->end);
  case KM_OPTION_ENDS:
    return read_ends(common, model, name, texts, arena, out);
  case KM_OPTION_FILE:
    kt_input(text);
    out->text = text;
    return KT_DONE;
  case KM_OPTION_LOADS:
    return kt_loads(common, model, texts, arena, out);
  }
  return KT_INTERNAL;
}
