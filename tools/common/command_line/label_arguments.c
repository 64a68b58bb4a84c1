/* Labels, values and lists on the command line. */
#include "common/common.h"

#include "kmech/base.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static _Noreturn void abort_with(void) {
  fprintf(stderr, "%s: out of memory\n", program_invocation_short_name);
  exit(KT_INTERNAL);
}

kt_piece kt_split(const char **rest, const char *separators) {
  km_text text = {0};
  const char *c = *rest;
  km_text_add(&text, "");
  for (; *c && !strchr(separators, *c); ++c) {
    if (c[0] == '\\' && c[1] && strchr(",=/[\\", c[1]))
      ++c;
    km_text_bytes(&text, c, 1);
  }
  if (text.failed)
    abort_with();
  kt_piece piece = {text.data, *c};
  *rest = *c ? c + 1 : c;
  return piece;
}

char *kt_plain(const char *text) {
  return kt_split(&text, "").text;
}

/* Numbers on the command line are decimals: no blanks, hexadecimal digits or words. The tools keep the C locale. */
static bool is_number(const char *text, double *out) {
  char *end = NULL;
  *out = strtod(text, &end);
  return end != text && *end == '\0' && text[strspn(text, "+-.0123456789eE")] == '\0';
}

bool kt_number(const char *text, double *out) {
  return is_number(text, out) && fabs(*out) <= 1e60;
}

bool kt_integer(const char *text, int least, int most, int *out) {
  double value;
  bool good = kt_number(text, &value) && value >= least && value <= most && value == floor(value);
  *out = good ? (int)value : 0;
  return good;
}

bool kt_numbers(const char *text, int count, double *out) {
  const char *rest = text;
  char last = ',';
  for (int k = 0; k < count; ++k) {
    kt_piece item = kt_split(&rest, ",");
    bool good = last == ',' && kt_number(item.text, &out[k]);
    last = item.separator;
    km_free(item.text);
    if (!good)
      return false;
  }
  return last == '\0';
}

kt_exit kt_coordinate(const kt_common *common, const km_model *model, const char *option, const char *text,
                      int *coordinate) {
  km_error error;
  const char *rest = text;
  kt_piece label = kt_split(&rest, "");
  km_status status = km_model_find_coordinate(model, label.text, coordinate, &error);
  km_free(label.text);
  if (status)
    kt_print_message(common, KM_ERROR, "%s %s: %s", option, text, error.text);
  return kt_exit_of(status);
}

kt_exit kt_frame(const kt_common *common, const km_model *model, const char *option, const char *text, int *frame) {
  const char *names[64], *rest = text;
  char *owned[64];
  size_t count = 0;
  km_error error;
  for (char last = '/'; last == '/' && count < 64; ++count) {
    kt_piece piece = kt_split(&rest, "/");
    names[count] = owned[count] = piece.text;
    last = piece.separator;
  }
  km_status status = km_model_find_frame(model, names, count, frame, &error);
  for (size_t i = 0; i < count; ++i)
    km_free(owned[i]);
  if (status)
    kt_print_message(common, KM_ERROR, "%s %s: %s", option, text, error.text);
  return kt_exit_of(status);
}

kt_exit kt_each_once(const kt_common *common, const char *option, char *const *texts, int count) {
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < i; ++k)
      if (strcmp(texts[i], texts[k]) == 0) {
        kt_print_message(common, KM_ERROR, "%s %s: it is named twice; expected each once", option, texts[i]);
        return KT_USAGE;
      }
  return KT_DONE;
}

static bool add(kt_settings *out, int coordinate, double value) {
  for (int i = 0; i < out->count; ++i) {
    if (out->items[i].coordinate != coordinate)
      continue;
    out->items[i].value = value; /* the last word counts */
    return true;
  }
  kt_setting *items = km_resize(out->items, (size_t)out->count + 1, sizeof *items);
  if (!items)
    return false;
  out->items = items;
  out->items[out->count++] = (kt_setting){coordinate, value};
  return true;
}

/* Coordinates that a label means: one, or all of a joint with several. */
static kt_exit find(const kt_common *common, const km_model *model, const char *option, const char *text,
                    const char *label, int *first, int *count) {
  km_error error;
  if (km_model_find_coordinate(model, label, first, NULL) == KM_OK) {
    *count = 1;
    return KT_DONE;
  }
  int joint;
  km_status status = km_model_find_joint(model, label, &joint, &error);
  if (!status) {
    *count = km_model_joint_freedom(model, joint, first);
    if (*count > 0)
      return KT_DONE;
    status = km_fail(&error, KM_USAGE, "joint \"%s\" is rigid; expected a joint with a coordinate", label);
  }
  kt_print_message(common, KM_ERROR, "%s %s: %s", option, text, error.text);
  return kt_exit_of(status);
}

static kt_exit add_text(const kt_common *common, const km_model *model, const char *option, const char *text,
                        kt_settings *out) {
  const char *rest = text;
  int first, count;
  kt_piece label = kt_split(&rest, "=");
  if (label.separator != '=') {
    kt_print_message(common, KM_ERROR, "%s %s: expected JOINT=VALUE", option, text);
    km_free(label.text);
    return KT_USAGE;
  }
  kt_exit result = find(common, model, option, text, label.text, &first, &count);
  km_free(label.text);
  int given = 0;
  char last = ',';
  for (; result == KT_DONE && last == ','; ++given) {
    kt_piece item = kt_split(&rest, ",");
    double value;
    last = item.separator;
    if (!kt_number(item.text, &value)) {
      const char *hint = is_number(item.text, &value) ? " of magnitude up to 1e60"
                         : strchr(item.text, '=')     ? "; each joint has its own option"
                                                      : "";
      kt_print_message(common, KM_ERROR, "%s %s: \"%s\" is not a number%s", option, text, item.text, hint);
      result = KT_USAGE;
    } else if (given < count && !add(out, first + given, value)) {
      result = KT_NO_MEMORY;
    }
    km_free(item.text);
  }
  if (result == KT_DONE && given != count) {
    kt_print_message(common, KM_ERROR, "%s %s: found %d values; expected %d", option, text, given, count);
    return KT_USAGE;
  }
  return result;
}

kt_exit kt_settings_add(const kt_common *common, const km_model *model, const char *option, char **texts, int count,
                        kt_settings *out) {
  kt_exit result = KT_DONE;
  for (int i = 0; i < count && result == KT_DONE; ++i)
    result = add_text(common, model, option, texts[i], out);
  return result;
}

void kt_settings_free(kt_settings *settings) {
  km_free(settings->items);
  *settings = (kt_settings){0};
}

bool kt_rate(const km_model *model, int coordinate, const char *text, double *out) {
  size_t length = strlen(text);
  char number[64];
  bool turns = length > 3 && strcmp(text + length - 3, "rpm") == 0;
  if ((turns && km_model_coordinate_is_length(model, coordinate)) || length >= sizeof number)
    return false;
  snprintf(number, sizeof number, "%.*s", (int)(turns ? length - 3 : length), text);
  if (!kt_number(number, out) || !isfinite(*out))
    return false;
  const km_units units = km_model_units(model);
  if (turns)
    *out *= 2.0 * M_PI / units.angle->si / (60.0 / units.time->si);
  return true;
}

static kt_exit add_coordinates(const kt_common *common, const char *option, const char *text, const km_model *model,
                               int first, int freedom, int *out, int *count) {
  for (int c = first; c < first + freedom; ++c) {
    for (int i = 0; i < *count; ++i) {
      if (out[i] != c)
        continue;
      kt_print_message(common, KM_ERROR, "%s %s: joint \"%s\" is named twice; expected each once", option, text,
                       km_model_coordinate_label(model, c));
      return KT_USAGE;
    }
    out[(*count)++] = c;
  }
  return KT_DONE;
}

kt_exit kt_coordinates(const kt_common *common, const km_model *model, const char *option, const char *text, int *out,
                       int *count) {
  kt_exit result = KT_DONE;
  const char *rest = text;
  *count = 0;
  if (!*text) {
    kt_print_message(common, KM_ERROR, "%s: no joint is named; expected at least one, as A,B,…", option);
    return KT_USAGE;
  }
  for (char last = ','; last == ',' && result == KT_DONE;) {
    kt_piece label = kt_split(&rest, ",");
    int first = 0, freedom = 0;
    last = label.separator;
    result = find(common, model, option, text, label.text, &first, &freedom);
    if (result == KT_DONE)
      result = add_coordinates(common, option, text, model, first, freedom, out, count);
    km_free(label.text);
  }
  return result;
}
