/* Methods and objectives of a study. */
#include "exchange/json/study/study_reader.h"

#include "kmech/arm.h"
#include "model/path_study/method_settings.h"

static void warn_of_others(km_study_reader *s, const km_value *method, const km_place *place, const km_method *m) {
  for (const km_value *v = method->first; v; v = v->next) {
    km_place at = {place, v->key, 0};
    km_text owners = {0};
    km_method_owners(v->key, &owners);
    if (owners.size && !km_method_has(m->kind, v->key))
      km_reader_warning(&s->reader, &at, "doesn't count: it is no setting of %s, but of %s", m->word, owners.data);
    s->arena->failed = s->arena->failed || owners.failed;
    km_text_free(&owners);
  }
}

static void read_name(km_study_reader *s, const char *word, const km_place *place, km_method *out) {
  km_error error;
  if (km_method_of_word(word, out, &error))
    km_reader_error(&s->reader, place, "%s", error.text);
}

static void read_settings(km_study_reader *s, const km_value *value, const km_place *place, km_method *out) {
  km_error error;
  for (int i = 0; i < km_method_setting_count(); ++i) {
    const char *key = km_method_setting(i);
    const km_value *number = key ? km_value_get(value, key) : NULL;
    km_place at = {place, key, 0};
    if (number && km_method_set(out, key, number->number, &error))
      km_reader_error(&s->reader, &at, "%s", error.text);
  }
  const char *leaf = km_reader_string(value, "value"), *faulty;
  km_place leaf_at = {place, "value", 0};
  if (leaf && km_method_set_leaf(out, leaf, &error))
    km_reader_error(&s->reader, &leaf_at, "%s", error.text);
  if (km_method_check(out, &faulty, &error)) {
    km_place at = {place, faulty, 0};
    km_reader_error(&s->reader, &at, "%s", error.text);
  }
}

/* The labels of the joints that are held; their place keeps the key that was written. */
static void read_joints(km_study_reader *s, const km_value *value, const km_place *place, km_study_names *out) {
  const char *key = km_value_get(value, "joint") ? "joint" : "joints";
  const km_value *labels = km_value_get(value, key);
  char text[KM_PLACE_TEXT];
  km_place at = {place, key, 0};
  if (!labels)
    return;
  km_study_names_of(s, labels, out);
  out->place.text = km_arena_string(s->arena, km_place_text(&at, text));
}

static void read_method(km_study_reader *s, const km_value *value, const km_place *place, km_study_method *out) {
  size_t errors = km_messages_errors(s->reader.messages);
  km_place at = {place, "method", 0};
  if (value->kind == KM_STRING) {
    read_name(s, value->string, place, &out->method);
    return;
  }
  km_format_check_as(value, &km_format_method, place, s->reader.messages);
  if (km_messages_errors(s->reader.messages) > errors)
    return;
  read_name(s, km_reader_string(value, "method"), &at, &out->method);
  if (km_messages_errors(s->reader.messages) == errors)
    warn_of_others(s, value, place, &out->method);
  read_settings(s, value, place, &out->method);
  read_joints(s, value, place, &out->joints);
}

void km_study_methods_of(km_study_reader *s, const km_value *value, km_study_def *def) {
  bool list = value->kind == KM_LIST;
  km_place place = {NULL, def->methods_place.text, 0}, item = {&place, NULL, 0};
  km_study_method *methods = KM_ARENA_NEW(s->arena, km_study_method, list ? value->count + 1 : 1);
  if (!methods)
    return;
  if (list && value->count == 0)
    km_reader_error(&s->reader, &place, "found none; expected at least one method");
  for (const km_value *v = list ? value->first : value; v; v = list ? v->next : NULL, ++item.index)
    read_method(s, v, list ? &item : &place, &methods[item.index]);
  def->methods = methods;
  def->method_count = (int)item.index;
}

void km_study_objective_of(km_study_reader *s, const km_value *value, km_objective *out) {
  km_place place = {NULL, "objective", 0};
  km_error error;
  bool weighted = value->kind == KM_OBJECT && value->first;
  *out = (km_objective){{0}};
  if (value->kind == KM_STRING && km_objective_add(out, value->string, 1.0, &error))
    km_reader_error(&s->reader, &place, "%s", error.text);
  else if (value->kind != KM_STRING && !weighted)
    km_reader_error(&s->reader, &place, "found %s; expected an objective's name or {name: weight}",
                    km_kind_name(value->kind));
  for (const km_value *v = weighted ? value->first : NULL; v; v = v->next) {
    km_place at = {&place, v->key, 0};
    if (km_objective_add(out, v->key, v->kind == KM_NUMBER ? v->number : 0.0, &error))
      km_reader_error(&s->reader, &at, "%s", error.text);
  }
}
