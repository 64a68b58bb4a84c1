/* Studies of designs: JSON text into a definition. */
#include "exchange/json/design/designs_reader.h"

#include "base/arguments.h"
#include "exchange/json/expression_values.h"
#include "exchange/json/json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

int km_designs_parameter(km_designs_reader *d, const char *name) {
  for (int p = 0; p < d->def->parameter_count; ++p)
    if (strcmp(d->parameters[p].name, name) == 0)
      return p;
  if (d->def->parameter_count == KM_MAX_DESIGN_PARAMETERS) {
    d->too_many = true;
    return 0;
  }
  d->parameters[d->def->parameter_count] = (km_design_parameter){name, name};
  return d->def->parameter_count++;
}

void km_designs_error(km_designs_reader *d, const km_place *place, const char *what) {
  char where[KM_PLACE_TEXT];
  km_messages_add(d->messages, KM_ERROR, "%s: %s", km_place_text(place, where), what);
}

int km_designs_whole(km_designs_reader *d, const km_value *object, const km_place *place, const char *key,
                     int otherwise) {
  const km_value *value = km_value_get(object, key);
  km_place at = {place, key, 0};
  if (!value)
    return otherwise;
  if (value->number == floor(value->number) && fabs(value->number) <= 2e9)
    return (int)value->number;
  char found[80];
  snprintf(found, sizeof found, "found %g; expected a whole number of magnitude up to 2e9", value->number);
  km_designs_error(d, &at, found);
  return otherwise;
}

double km_designs_number(const km_value *object, const char *key, double otherwise) {
  const km_value *value = km_value_get(object, key);
  return value ? value->number : otherwise;
}

const char *km_designs_text(const km_value *object, const char *key) {
  const km_value *value = km_value_get(object, key);
  return value && value->kind == KM_STRING ? value->string : NULL;
}

const char *const *km_designs_texts(km_designs_reader *d, const km_value *value, int *count) {
  const char **out = KM_ARENA_NEW(d->arena, const char *, value ? value->count + 1 : 1);
  *count = 0;
  if (!value || !out)
    return out;
  if (value->kind == KM_STRING)
    out[(*count)++] = value->string;
  for (const km_value *v = value->kind == KM_LIST ? value->first : NULL; v; v = v->next)
    out[(*count)++] = v->string;
  return out;
}

static void read_parameters(km_designs_reader *d, const km_value *map) {
  for (const km_value *v = map ? map->first : NULL; v && !d->too_many; v = v->next)
    d->parameters[km_designs_parameter(d, v->key)].path = v->string;
}

/* All parameters must be known before rows of them are made. */
static void name_parameters(km_designs_reader *d, const km_value *map) {
  for (const km_value *v = map ? map->first : NULL; v; v = v->next)
    km_designs_parameter(d, v->key);
}

static void read_variants(km_designs_reader *d, const km_value *map) {
  size_t count = map ? map->count : 0, width = (size_t)d->def->parameter_count;
  km_design_variant *variants = KM_ARENA_NEW(d->arena, km_design_variant, count + 1);
  double *values = KM_ARENA_NEW(d->arena, double, count *width + 1);
  km_place place = {NULL, "variants", 0};
  d->def->variants = variants;
  if (map && count == 0)
    km_designs_error(d, &place, "found none; expected at least one variant");
  for (const km_value *v = map ? map->first : NULL; v && values; v = v->next) {
    double *row = values + width * (size_t)d->def->variant_count;
    for (size_t p = 0; p < width; ++p)
      row[p] = nan("");
    for (const km_value *number = v->first; number; number = number->next)
      row[km_designs_parameter(d, number->key)] = number->number;
    variants[d->def->variant_count++] = (km_design_variant){v->key, row};
  }
}

static void read_range(km_designs_reader *d, const km_value *object, const km_place *place, km_design_axis *out) {
  int count = km_designs_whole(d, object, place, "count", 0);
  if (!km_value_get(object, "from") || !km_value_get(object, "to") || count < 1 || count > 1000000) {
    km_designs_error(d, place, "expected \"values\", or \"from\", \"to\" and a \"count\" of 1 to 1000000");
    return;
  }
  double from = km_designs_number(object, "from", 0.0), to = km_designs_number(object, "to", 0.0);
  double *values = KM_ARENA_NEW(d->arena, double, (size_t)count);
  for (int i = 0; i < count && values; ++i)
    values[i] = i + 1 == count && count > 1 ? to : from + (to - from) * i / (count > 1 ? count - 1 : 1);
  out->values = values;
  out->count = count;
}

static void read_grid(km_designs_reader *d, const km_value *map) {
  km_design_axis *axes = KM_ARENA_NEW(d->arena, km_design_axis, map ? map->count + 1 : 1);
  km_place place = {NULL, "grid", 0};
  d->def->axes = axes;
  if (map && !map->first)
    km_designs_error(d, &place, "found none; expected at least one parameter with its values");
  for (const km_value *v = map ? map->first : NULL; v && axes; v = v->next) {
    km_place at = {&place, v->key, 0};
    km_design_axis *axis = &axes[d->def->axis_count++];
    const km_value *list = v->kind == KM_LIST ? v : km_value_get(v, "values");
    axis->parameter = km_designs_parameter(d, v->key);
    if (!list) {
      read_range(d, v, &at, axis);
      continue;
    }
    double *values = KM_ARENA_NEW(d->arena, double, list->count + 1);
    for (const km_value *n = list->first; n && values; n = n->next)
      values[axis->count++] = n->number;
    axis->values = values;
  }
}

static void read_all(km_designs_reader *d, const km_value *root) {
  const km_value *sample = km_value_get(root, "sample"), *optimise = km_value_get(root, "optimise");
  const km_value *variants = km_value_get(root, "variants");
  d->parameters = KM_ARENA_NEW(d->arena, km_design_parameter, KM_MAX_DESIGN_PARAMETERS);
  if (!d->parameters)
    return;
  d->def->parameters = d->parameters;
  d->def->model = km_designs_text(root, "model");
  read_parameters(d, km_value_get(root, "parameters"));
  for (const km_value *v = variants ? variants->first : NULL; v; v = v->next)
    name_parameters(d, v);
  name_parameters(d, km_value_get(root, "grid"));
  name_parameters(d, sample ? km_value_get(sample, "parameters") : NULL);
  name_parameters(d, optimise ? km_value_get(optimise, "variables") : NULL);
  km_place place = {NULL, "parameters", 0};
  if (d->too_many)
    km_designs_error(d, &place, "found more than 32");
  read_variants(d, variants);
  read_grid(d, km_value_get(root, "grid"));
  if (sample)
    km_designs_read_sample(d, sample);
  if (optimise)
    km_designs_read_optimise(d, optimise);
  km_designs_read_questions(d, km_value_get(root, "ask"));
}

static km_status first_error(const km_messages *messages, size_t from, km_error *error) {
  for (size_t i = from; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  return km_fail(error, KM_MODEL, "the study is faulty");
}

static km_status read(km_designs_reader *d, const char *bytes, size_t size, km_error *error) {
  km_value *root;
  size_t had = km_messages_count(d->messages), errors = km_messages_errors(d->messages);
  km_status status = km_json_parse_open(bytes, size, d->arena, &root, error);
  if (status)
    return status;
  if (km_value_get(root, "assemblies"))
    return km_fail(error, KM_MODEL, "this is a model, not a study; expected a study, whose \"model\" names one");
  const char *other = km_other_kind(root, &km_format_designs);
  if (other)
    return km_fail(error, KM_MODEL, "the file is %s; expected a study of designs", other);
  status = km_format_evaluate(root, &km_format_designs, d->messages, error);
  if (!status)
    km_format_check_as(root, &km_format_designs, NULL, d->messages);
  if (!status && km_messages_errors(d->messages) == errors)
    read_all(d, root);
  if (!status && d->arena->failed)
    status = km_fail(error, KM_MEMORY, "out of memory for a study");
  if (!status && km_messages_errors(d->messages) > errors)
    status = first_error(d->messages, had, error);
  return status;
}

km_status km_design_study_read(const char *bytes, size_t size, km_messages *messages, km_design_study_def *def,
                               km_error *error) {
  km_status status = km_check_given(bytes && def, "text or definition of a study", error);
  if (status)
    return status;
  if (!def->memory)
    def->memory = KM_NEW(km_arena, 1);
  km_messages *own = messages ? NULL : km_messages_create();
  km_designs_reader d = {.def = def, .arena = def->memory, .messages = messages ? messages : own};
  status =
      d.arena && d.messages ? read(&d, bytes, size, error) : km_fail(error, KM_MEMORY, "out of memory for a study");
  km_messages_free(own);
  return status;
}

void km_design_study_def_free(km_design_study_def *def) {
  if (!def)
    return;
  if (def->memory)
    km_arena_free(def->memory);
  km_free(def->memory);
  *def = (km_design_study_def){0};
}
