/* Tracking methods: words, defaults, settings and their ranges. */
#include "model/path_study/method_settings.h"

#include "base/arguments.h"

#include <math.h>
#include <string.h>

static const char *const words[KM_METHODS] = {"greedy", "lookahead", "fixed", "dls", "gradient", "dp", "global"};

/* A setting: the methods that have it, its range, and for numbers its offset in km_method. */
typedef struct setting {
  const char *key;
  unsigned methods; /* bit mask of methods */
  enum { WORD, WHOLE, NUMBER, DEGREES } kind;
  double low, high;
  bool automatic; /* the default 0 lets the method choose */
  size_t offset;
} setting;

#define AT(member) offsetof(km_method, member)
static const setting settings[] = {
    {"branches", 1u << KM_LOOKAHEAD, WHOLE, 1, 1001, false, AT(branches)},
    {"levels", 1u << KM_LOOKAHEAD, WHOLE, 1, 20, false, AT(levels)},
    {"value", 1u << KM_LOOKAHEAD, WORD, 0, 0, false, 0},
    {"angle", 1u << KM_LOOKAHEAD | 1u << KM_GRADIENT | 1u << KM_DP | 1u << KM_GLOBAL, DEGREES, 1e-3, 89, false,
     AT(angle)},
    {"stride", 1u << KM_LOOKAHEAD | 1u << KM_DP, WHOLE, 1, 1e6, true, AT(stride)},
    {"joints", 1u << KM_FIXED, WORD, 0, 0, false, 0},
    {"joint", 1u << KM_FIXED, WORD, 0, 0, false, 0},
    {"damping", 1u << KM_DLS, NUMBER, 1e-9, 10, false, AT(damping)},
    {"below", 1u << KM_DLS, NUMBER, 1e-9, 10, false, AT(below)},
    {"gain", 1u << KM_GRADIENT, NUMBER, -1e6, 1e6, false, AT(gain)},
    {"spacing", 1u << KM_DP, NUMBER, 1e-3, 10, true, AT(spacing)},
    {"knots", 1u << KM_GLOBAL, WHOLE, 2, KM_METHOD_KNOTS, false, AT(knots)},
    {"evaluations", 1u << KM_GLOBAL, WHOLE, 10, 1e6, false, AT(evaluations)},
};
enum { SETTINGS = sizeof settings / sizeof *settings };

const char *km_method_word(km_method_kind kind) {
  if ((unsigned)kind >= KM_METHODS)
    return "";
  return words[kind];
}

int km_method_find(const char *word) {
  if (!word)
    return -1;
  if (strcmp(word, "pinv") == 0)
    return KM_GREEDY;
  for (int k = 0; k < KM_METHODS; ++k)
    if (strcmp(word, words[k]) == 0)
      return k;
  return -1;
}

km_method km_method_default(km_method_kind kind) {
  return (km_method){.kind = kind,
                     .word = km_method_word(kind),
                     .branches = 3,
                     .levels = 3,
                     .angle = M_PI / 6.0,
                     .damping = 0.05,
                     .below = 0.1,
                     .gain = 2.0,
                     .knots = 12,
                     .evaluations = 400};
}

km_status km_method_of_word(const char *word, km_method *out, km_error *error) {
  if (!word || !out)
    return km_check_given(false, word ? "place for the result" : "word", error);
  int kind = km_method_find(word);
  *out = km_method_default(kind < 0 ? KM_GREEDY : (km_method_kind)kind);
  if (strcmp(word, "pinv") == 0)
    out->word = "pinv";
  if (kind >= 0)
    return KM_OK;
  return km_fail(error, KM_USAGE,
                 "\"%.40s\" is not a method; expected greedy (or pinv), lookahead, fixed, dls, gradient, dp or global",
                 word);
}

static const setting *find(const char *key) {
  for (int i = 0; i < SETTINGS; ++i)
    if (strcmp(settings[i].key, key) == 0)
      return &settings[i];
  return NULL;
}

bool km_method_has(km_method_kind kind, const char *key) {
  if (!key || (int)kind < 0 || kind >= KM_METHODS)
    return false;
  const setting *s = find(key);
  return s && s->methods >> kind & 1u;
}

void km_method_owners(const char *key, km_text *out) {
  if (!key || !out)
    return;
  const setting *s = find(key);
  for (int k = 0; k < KM_METHODS && s; ++k)
    if (s->methods >> k & 1u)
      km_text_format(out, "%s%s", s->methods & ((1u << k) - 1u) ? ", " : "", words[k]);
}

int km_method_setting_count(void) {
  return SETTINGS;
}

const char *km_method_setting(int index) {
  return settings[index].kind == WORD ? NULL : settings[index].key;
}

/* The value of a setting in a method: angles in radians. */
static double value_of(const setting *s, const km_method *m) {
  const char *at = (const char *)m + s->offset;
  return s->kind == WHOLE ? *(const int *)at : *(const double *)at;
}

static double in_method(const setting *s, double value) {
  return s->kind == DEGREES ? value * M_PI / 180.0 : value;
}

static km_status out_of_range(const setting *s, double value, km_error *error) {
  return km_fail(error, KM_USAGE, "found %s; expected a %s from %s to %s", KM_SHOWN(value),
                 s->kind == WHOLE ? "whole number" : "number", KM_SHOWN(s->low), KM_SHOWN(s->high));
}

km_status km_method_set(km_method *m, const char *key, double value, km_error *error) {
  if (!m || !key)
    return km_check_given(false, key ? "method" : "setting", error);
  const setting *s = find(key);
  if (!s || s->kind == WORD)
    return km_fail(error, KM_USAGE, "\"%.40s\" is no setting that is a number", key);
  if (!(value >= s->low && value <= s->high) || (s->kind == WHOLE && value != floor(value)))
    return out_of_range(s, value, error);
  char *at = (char *)m + s->offset;
  if (s->kind == WHOLE)
    *(int *)at = (int)value;
  else
    *(double *)at = in_method(s, value);
  return KM_OK;
}

km_status km_method_set_leaf(km_method *m, const char *word, km_error *error) {
  if (!m || !word)
    return km_check_given(false, word ? "method" : "word", error);
  m->sum = strcmp(word, "sum") == 0;
  return m->sum || strcmp(word, "min") == 0
             ? KM_OK
             : km_fail(error, KM_USAGE, "\"%.40s\" is not a leaf value; expected \"min\" or \"sum\"", word);
}

static km_status check_branches(const km_method *m, const char **key, km_error *error) {
  *key = "branches";
  if (m->branches % 2 == 0)
    return km_fail(error, KM_USAGE, "found %d; expected an odd number", m->branches);
  *key = "angle";
  int outermost = (m->branches - 1) / 2;
  double widest = outermost * m->angle * 180.0 / M_PI;
  if (m->kind == KM_LOOKAHEAD && widest > 89.0)
    return km_fail(error, KM_USAGE, "the outermost of %d branches turns by %s degrees; expected less than 90",
                   m->branches, KM_SHOWN(round(widest * 1e6) / 1e6));
  return KM_OK;
}

km_status km_method_check(const km_method *m, const char **key, km_error *error) {
  if (!m || !key)
    return km_check_given(false, key ? "method" : "place for the setting", error);
  for (int i = 0; i < SETTINGS; ++i) {
    const setting *s = &settings[i];
    if (s->kind == WORD)
      continue;
    double value = value_of(s, m);
    *key = s->key;
    if (!(value >= in_method(s, s->low) && value <= in_method(s, s->high)) && !(s->automatic && value == 0.0))
      return out_of_range(s, s->kind == DEGREES ? value * 180.0 / M_PI : value, error);
  }
  return check_branches(m, key, error);
}
