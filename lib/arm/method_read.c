/* Methods and objectives of a study. */
#include "arm/study.h"
#include "base/nearest.h"
#include "exchange/json/format.h"

#include <string.h>

static double read_between(km_reader *reader, const km_value *object, const km_place *place, const char *key,
                           double otherwise, double low, double high, bool whole) {
  double value = km_reader_number(object, key, otherwise);
  km_place at = {place, key, 0};
  if (value >= low && value <= high && (!whole || value == floor(value)))
    return value;
  km_reader_error(reader, &at, "found %s; expected a %s from %s to %s", KM_SHOWN(value),
                  whole ? "whole number" : "number", KM_SHOWN(low), KM_SHOWN(high));
  return otherwise;
}

static void unknown_joint(km_reader *reader, const km_arm *arm, const char *label, const km_place *at) {
  km_nearest nearest = {.wanted = label};
  char names[KM_NEAREST_TEXT];
  for (int k = 0; k < arm->n; ++k)
    km_nearest_offer(&nearest, km_arm_label(arm, k));
  km_reader_error(reader, at, "\"%.80s\" is no joint of the arm; the nearest of its %d are %s", label, arm->n,
                  km_nearest_text(&nearest, names));
}

static void read_joints(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                        km_method *out) {
  km_place at = {place, value->key, 0};
  const km_value *label = value->kind == KM_LIST ? value->first : value;
  for (; label; label = value->kind == KM_LIST ? label->next : NULL) {
    int found = -1;
    for (int k = 0; k < arm->n; ++k)
      if (strcmp(km_arm_label(arm, k), label->string) == 0)
        found = k;
    if (found < 0)
      unknown_joint(reader, arm, label->string, &at);
    else if (out->joint_count == arm->freedom || out->joint_count == KM_METHOD_JOINTS)
      km_reader_error(reader, &at, "found more joints than the %d that are to spare", arm->freedom);
    else
      out->joints[out->joint_count++] = found;
  }
}

/* Which methods have a setting. */
static const struct {
  const char *key;
  unsigned methods; /* bits */
} settings[] = {{"branches", 1u << KM_LOOKAHEAD},
                {"levels", 1u << KM_LOOKAHEAD},
                {"value", 1u << KM_LOOKAHEAD},
                {"angle", 1u << KM_LOOKAHEAD | 1u << KM_GRADIENT | 1u << KM_DP | 1u << KM_GLOBAL},
                {"stride", 1u << KM_LOOKAHEAD | 1u << KM_DP},
                {"joints", 1u << KM_FIXED},
                {"joint", 1u << KM_FIXED},
                {"damping", 1u << KM_DLS},
                {"below", 1u << KM_DLS},
                {"gain", 1u << KM_GRADIENT},
                {"spacing", 1u << KM_DP},
                {"knots", 1u << KM_GLOBAL},
                {"evaluations", 1u << KM_GLOBAL}};

static unsigned methods_with(const char *key) {
  for (size_t i = 0; i < sizeof settings / sizeof *settings; ++i)
    if (strcmp(settings[i].key, key) == 0)
      return settings[i].methods;
  return 0;
}

bool km_method_has(km_method_kind kind, const char *key) {
  return methods_with(key) >> kind & 1u;
}

void km_method_owners(const char *key, km_text *out) {
  const unsigned owners = methods_with(key);
  for (int k = 0; k < KM_METHODS; ++k)
    if (owners >> k & 1u)
      km_text_format(out, "%s%s", owners & ((1u << k) - 1u) ? ", " : "", km_method_word((km_method_kind)k));
}

static void warn_of_others(km_reader *reader, const km_value *method, const km_place *place, const km_method *m) {
  for (const km_value *v = method->first; v; v = v->next) {
    km_place at = {place, v->key, 0};
    km_text owners = {0};
    km_method_owners(v->key, &owners);
    if (owners.size && !km_method_has(m->kind, v->key))
      km_reader_warning(reader, &at, "doesn't count: it is no setting of %s, but of %s", m->word, owners.data);
    km_text_free(&owners);
  }
}

static void read_name(km_reader *reader, const char *word, const km_place *place, km_method *out) {
  int kind = km_method_find(word);
  if (kind < 0)
    km_reader_error(
        reader, place,
        "\"%.40s\" is not a method; expected greedy (or pinv), lookahead, fixed, dls, gradient, dp or global", word);
  *out = km_method_default(kind < 0 ? KM_GREEDY : (km_method_kind)kind);
  if (strcmp(word, "pinv") == 0)
    out->word = "pinv";
}

static void read_method(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                        km_method *out) {
  if (value->kind == KM_STRING) {
    read_name(reader, value->string, place, out);
    return;
  }
  size_t errors = km_messages_errors(reader->messages);
  *out = km_method_default(KM_GREEDY);
  km_format_check_as(value, &km_format_method, place, reader->messages);
  if (km_messages_errors(reader->messages) > errors)
    return;
  km_place at = {place, "method", 0}, value_at = {place, "value", 0};
  read_name(reader, km_reader_string(value, "method"), &at, out);
  if (km_messages_errors(reader->messages) == errors)
    warn_of_others(reader, value, place, out);
  out->branches = (int)read_between(reader, value, place, "branches", out->branches, 1, 1001, true);
  out->levels = (int)read_between(reader, value, place, "levels", out->levels, 1, 20, true);
  out->angle = read_between(reader, value, place, "angle", 30.0, 1e-3, 89.0, false) * M_PI / 180.0;
  if (km_value_get(value, "stride"))
    out->stride = (int)read_between(reader, value, place, "stride", 1.0, 1, 1e6, true);
  out->damping = read_between(reader, value, place, "damping", out->damping, 1e-9, 10, false);
  out->below = read_between(reader, value, place, "below", out->below, 1e-9, 10, false);
  out->gain = read_between(reader, value, place, "gain", out->gain, -1e6, 1e6, false);
  if (km_value_get(value, "spacing"))
    out->spacing = read_between(reader, value, place, "spacing", 0.1, 1e-3, 10, false);
  out->knots = (int)read_between(reader, value, place, "knots", out->knots, 2, 64, true);
  out->evaluations = (int)read_between(reader, value, place, "evaluations", out->evaluations, 10, 1e6, true);
  const char *aggregate = km_reader_string(value, "value");
  if (aggregate && strcmp(aggregate, "min") != 0 && strcmp(aggregate, "sum") != 0)
    km_reader_error(reader, &value_at, "\"%.40s\" is not a leaf value; expected \"min\" or \"sum\"", aggregate);
  out->sum = aggregate && strcmp(aggregate, "sum") == 0;
  if (out->branches % 2 == 0) {
    km_place branches_at = {place, "branches", 0};
    km_reader_error(reader, &branches_at, "found %d; expected an odd number", out->branches);
  }
  double widest = (out->branches - 1) / 2 * out->angle * 180.0 / M_PI;
  if (out->kind == KM_LOOKAHEAD && widest > 89.0) {
    km_place angle_at = {place, "angle", 0};
    km_reader_error(reader, &angle_at, "the outermost of %d branches turns by %s degrees; expected less than 90",
                    out->branches, KM_SHOWN(round(widest * 1e6) / 1e6));
  }
  const km_value *joints = km_value_get(value, km_value_get(value, "joint") ? "joint" : "joints");
  if (joints)
    read_joints(reader, arm, joints, place, out);
}

bool km_methods_read(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                     km_arena *arena, km_method **methods, int *count) {
  size_t errors = km_messages_errors(reader->messages), most = value->kind == KM_LIST ? value->count : 1;
  km_place item = {place, NULL, 0};
  *count = 0;
  *methods = KM_ARENA_NEW(arena, km_method, most + 1);
  if (!*methods)
    return false;
  if (value->kind != KM_LIST)
    read_method(reader, arm, value, place, &(*methods)[(*count)++]);
  for (const km_value *v = value->kind == KM_LIST ? value->first : NULL; v; v = v->next, ++item.index)
    read_method(reader, arm, v, &item, &(*methods)[(*count)++]);
  if (*count == 0)
    km_reader_error(reader, place, "found none; expected at least one method");
  return km_messages_errors(reader->messages) == errors;
}

static void read_kind(km_reader *reader, const char *word, double weight, const km_place *place, km_objective *out) {
  int kind = km_objective_find(word);
  if (kind >= 0) {
    out->weight[kind] += weight;
    return;
  }
  km_text known = {0};
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    km_text_format(&known, "%s%s", k ? ", " : "", km_objective_word((km_objective_kind)k));
  km_reader_error(reader, place, "\"%.40s\" is not an objective; expected one of %s", word,
                  known.data ? known.data : "");
  km_text_free(&known);
}

/* A name, or {name: weight}. */
bool km_objective_read(km_reader *reader, const km_value *value, const km_place *place, km_objective *out) {
  size_t errors = km_messages_errors(reader->messages);
  *out = (km_objective){{0}};
  if (value->kind == KM_STRING)
    read_kind(reader, value->string, 1.0, place, out);
  else if (value->kind != KM_OBJECT || !value->first)
    km_reader_error(reader, place, "found %s; expected an objective's name or {name: weight}",
                    km_kind_name(value->kind));
  for (const km_value *v = value->kind == KM_OBJECT ? value->first : NULL; v; v = v->next) {
    km_place at = {place, v->key, 0};
    if (v->kind != KM_NUMBER || !(fabs(v->number) <= 1e6) || v->number == 0.0)
      km_reader_error(reader, &at, "expected a weight other than 0, of magnitude up to 1e6");
    else
      read_kind(reader, v->key, v->number, &at, out);
  }
  return km_messages_errors(reader->messages) == errors;
}
