/* Reads --vary and makes the variants. */
#include "common/command_line/vary.h"

#include "kmech/base.h"

#include <stdio.h>
#include <string.h>

enum { MOST_VALUES = 1024 };

static kt_exit store(kt_varied *v, double value) {
  double *values = v->count < MOST_VALUES ? km_resize(v->values, (size_t)v->count + 1, sizeof *values) : NULL;
  if (!values)
    return v->count < MOST_VALUES ? KT_NO_MEMORY : KT_USAGE;
  v->values = values;
  v->values[v->count++] = value;
  return KT_DONE;
}

/* FROM:TO:N, both ends among the N values. */
static kt_exit read_range(const char *text, kt_varied *out) {
  const char *rest = text;
  double part[3];
  char last = ':';
  for (int k = 0; k < 3; ++k) {
    kt_piece piece = kt_split(&rest, ":");
    bool good = last == ':' && kt_number(piece.text, &part[k]);
    last = piece.separator;
    km_free(piece.text);
    if (!good)
      return KT_USAGE;
  }
  int count = part[2] >= 1.0 && part[2] <= MOST_VALUES ? (int)part[2] : 0;
  if (last != '\0' || count < 1 || (double)count != part[2] || (count == 1 && part[0] != part[1]))
    return KT_USAGE;
  kt_exit result = KT_DONE;
  for (int i = 0; i < count && result == KT_DONE; ++i)
    result = store(out, i + 1 == count ? part[1] : part[0] + (part[1] - part[0]) * i / (count - 1));
  return result;
}

static kt_exit read_list(const char *text, kt_varied *out) {
  const char *rest = text;
  kt_exit result = KT_DONE;
  for (char last = ','; last == ',' && result == KT_DONE;) {
    kt_piece piece = kt_split(&rest, ",");
    double value;
    result = kt_number(piece.text, &value) ? store(out, value) : KT_USAGE;
    last = piece.separator;
    km_free(piece.text);
  }
  return result;
}

static bool read_alike(const kt_varied *v, int digits) {
  char text[2][32];
  for (int i = 0; i < v->count; ++i)
    for (int k = 0; k < i; ++k) {
      snprintf(text[0], sizeof text[0], "%.*g", digits, v->values[i]);
      snprintf(text[1], sizeof text[1], "%.*g", digits, v->values[k]);
      if (strcmp(text[0], text[1]) == 0)
        return true;
    }
  return false;
}

static void choose_digits(kt_varied *v) {
  for (v->digits = 6; v->digits < 17 && read_alike(v, v->digits);)
    v->digits++;
}

/* The path keeps its backslashes, which the library reads. */
static kt_exit read_one(const kt_common *common, const char *text, kt_varied *out) {
  const char *equals = text;
  while (*equals && *equals != '=')
    equals += equals[0] == '\\' && equals[1] ? 2 : 1;
  size_t size = (size_t)(equals - text);
  out->path = KM_NEW(char, size + 1);
  if (!out->path)
    return KT_NO_MEMORY;
  memcpy(out->path, text, size);
  kt_exit result = !*equals || size == 0 ? KT_USAGE
                   : strchr(equals, ':') ? read_range(equals + 1, out)
                                         : read_list(equals + 1, out);
  return result == KT_USAGE ? kt_usage(common, "--vary", text, "PATH=FROM:TO:N, or PATH=A,B,C") : result;
}

kt_exit kt_variants_read(const kt_common *common, const kt_texts *texts, int most, kt_variants *out) {
  char expected[80];
  double count = 1.0;
  *out = (kt_variants){.count = 1};
  if (texts->count > KT_MOST_VARIED)
    return kt_usage(common, "--vary", texts->items[KT_MOST_VARIED], "at most 8 numbers to vary");
  for (int i = 0; i < texts->count; ++i) {
    kt_exit result = read_one(common, texts->items[i], &out->numbers[out->number_count++]);
    if (result != KT_DONE)
      return result;
    count *= out->numbers[i].count;
  }
  snprintf(expected, sizeof expected, "at most %d variants in all", most);
  if (count > most)
    return kt_usage(common, "--vary", texts->items[texts->count - 1], expected);
  out->count = (int)count;
  for (int i = 0; i < out->number_count; ++i)
    choose_digits(&out->numbers[i]);
  return KT_DONE;
}

void kt_variants_free(kt_variants *v) {
  for (int i = 0; i < v->number_count; ++i) {
    km_free(v->numbers[i].path);
    km_free(v->numbers[i].values);
  }
  *v = (kt_variants){0};
}

void kt_variant(const kt_variants *v, int index, km_assignment *out, char name[KT_VARIANT_NAME]) {
  size_t used = 0;
  name[0] = '\0';
  for (int i = v->number_count - 1; i >= 0; --i) {
    const kt_varied *number = &v->numbers[i];
    out[i] = (km_assignment){number->path, number->values[index % number->count]};
    index /= number->count;
  }
  for (int i = 0; i < v->number_count && used < KT_VARIANT_NAME - 1; ++i) {
    int length = snprintf(name + used, KT_VARIANT_NAME - used, "%s%s=%.*g", i ? ", " : "", out[i].path,
                          v->numbers[i].digits, out[i].value);
    used += length > 0 ? (size_t)length : 0;
  }
}
