/* Parameters of the file by their names: their values, and the model with other ones. */
#include "kview/messages.h"

#include "kmech/data.h"
#include "kmech/rounding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const km_value *number_of(const km_value *member) {
  const km_value *value = member->kind == KM_OBJECT ? km_value_get(member, "value") : member;
  return value && value->kind == KM_NUMBER ? value : NULL;
}

static double bound(const km_value *member, const char *key, double otherwise) {
  const km_value *value = member->kind == KM_OBJECT ? km_value_get(member, key) : NULL;
  return value && value->kind == KM_NUMBER ? value->number : otherwise;
}

static const char *note_of(const km_value *member) {
  const km_value *note = member->kind == KM_OBJECT ? km_value_get(member, "note") : NULL;
  return note && note->kind == KM_STRING ? note->string : "";
}

void kv_parameters_free(kv_parameters *p) {
  km_arena_free(&p->memory);
  *p = (kv_parameters){0};
}

/* Those that are expressions over others follow them, and aren't listed. */
static void list(const km_value *members, kv_parameters *out) {
  size_t room = members && members->kind == KM_OBJECT ? members->count : 0;
  out->items = KM_ARENA_NEW(&out->memory, kv_parameter, room);
  for (const km_value *v = room && out->items ? members->first : NULL; v; v = v->next)
    if (number_of(v)) {
      double value = number_of(v)->number;
      out->items[out->count++] =
          (kv_parameter){v->key, note_of(v), value, value, bound(v, "low", -HUGE_VAL), bound(v, "high", HUGE_VAL)};
    }
}

km_status kv_parameters_read(const km_text *file, kv_parameters *out, km_error *error) {
  const km_value *root = NULL;
  km_error ignored;
  *out = (kv_parameters){0};
  /* Another format than JSON has none. */
  if (!km_json_parse(file->data ? file->data : "", file->size, &out->memory, &root, &ignored) && root)
    list(km_value_get(root, "parameters"), out);
  if (!out->memory.failed)
    return KM_OK;
  kv_parameters_free(out);
  return km_fail(error, KM_MEMORY, "out of memory");
}

bool kv_parameters_differ(const kv_parameters *p) {
  bool differ = false;
  for (int i = 0; i < p->count; ++i)
    differ = differ || p->items[i].value != p->items[i].file;
  return differ;
}

static km_status load(const kv_session *s, const double *values, km_model **out, km_error *error) {
  const kv_parameters *p = &s->parameters;
  km_assignment *items = calloc((size_t)p->count + 1, sizeof *items);
  km_read_def def = {
      .floating = s->opening.floating, .closure_tolerance = s->opening.closure_tolerance, .assignments = items};
  if (!items)
    return km_fail(error, KM_MEMORY, "out of memory");
  for (int i = 0; i < p->count; ++i)
    if (values[i] != p->items[i].file) {
      /* A parameter's name is a path of one part. */
      items[def.assignment_count++] = (km_assignment){p->items[i].name, values[i]};
    }
  km_status status = km_model_read_file_as(s->opening.path, &def, NULL, out, error);
  if (!status && !s->opening.exact)
    status = km_model_idealise(*out, false, NULL, NULL, error);
  free(items);
  return status;
}

/* Frames that were dragged away from where the parameters put them stay as far from there: a parameter moves them
 * too. */
static km_status store_dragged(const kv_session *s, km_model *model, km_error *error) {
  double *present = kv_frame_places(s->model), *next = kv_frame_places(model);
  km_status status = present && next ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  for (int f = 0; f < km_model_frame_count(model) && !status; ++f) {
    if (memcmp(present + 3 * f, s->own_places + 3 * f, 3 * sizeof *present) == 0)
      continue;
    for (int k = 3 * f; k < 3 * f + 3; ++k)
      next[k] += present[k] - s->own_places[k];
    status = km_model_set_frame(model, f, next + 3 * f, NULL, error);
  }
  free(present);
  free(next);
  return status;
}

km_status kv_session_set_parameters(kv_session *s, const double *values, km_error *error) {
  kv_parameters *p = &s->parameters;
  km_model *model = NULL;
  bool same = true;
  for (int i = 0; i < p->count; ++i)
    same = same && values[i] == p->items[i].value;
  if (same)
    return KM_OK;
  if (kv_session_is_stale(s))
    return km_fail(error, KM_USAGE, "the file has changed in the meantime");
  km_status status = load(s, values, &model, error);
  if (status)
    return status;
  double *places = kv_frame_places(model), *q = kv_session_coordinates(s);
  if (!places || !q)
    status = km_fail(error, KM_MEMORY, "out of memory");
  else if (km_model_frame_count(model) != km_model_frame_count(s->model))
    status = km_fail(error, KM_USAGE, "with these parameters the model has other parts");
  if (!status)
    status = store_dragged(s, model, error);
  if (!status)
    status = kv_session_set_model(s, model, q, error);
  free(q);
  if (status) {
    free(places);
    km_model_free(model);
    return status;
  }
  free(s->own_places);
  s->own_places = places;
  for (int i = 0; i < p->count; ++i)
    p->items[i].value = values[i];
  kv_session_note_edits(s);
  return KM_OK;
}

/* parameters V…: a value for each. */
km_status kv_set_parameters(const kv_call *c, km_error *error) {
  if (c->count != c->session->parameters.count)
    return km_fail(error, KM_USAGE, "found %d values; expected one for each of the %d parameters", c->count,
                   c->session->parameters.count);
  km_status status = kv_session_set_parameters(c->session, c->arguments, error);
  if (!status)
    kv_describe(c->session, c->request, &c->answer->bytes);
  return status;
}
