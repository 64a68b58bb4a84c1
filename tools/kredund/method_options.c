/* The options about methods, put into the study's definition. */
#include "kredund/kredund.h"

#include "kmech/base.h"

#include <stdio.h>
#include <string.h>

static const char all_methods[] = "greedy,lookahead,fixed,dls,gradient,dp,global";

/* The settings that have an option, and what it says. */
enum { SETTINGS = 5 };
typedef struct setting {
  const char *key, *option, *text;
} setting;

static void gather(const kredund_request *r, setting out[SETTINGS]) {
  const setting all[SETTINGS] = {{"branches", "--branches", r->branches},
                                 {"levels", "--levels", r->levels},
                                 {"angle", "--angle", r->angle},
                                 {"stride", "--stride", r->stride},
                                 {"value", "--value", r->value}};
  memcpy(out, all, sizeof all);
}

static kt_exit fault(const km_study_def *def, km_messages *messages, int index, const char *key,
                     const km_error *error) {
  const km_study_place *methods = &def->methods_place;
  char place[64];
  snprintf(place, sizeof place, "%s[%d]%s%s", methods->text, index, key ? "." : "", key ? key : "");
  return kredund_fault(messages, methods->option, place, error);
}

/* Methods by their names, with commas between. */
static kt_exit name_methods(kredund_open *open, const char *names, km_messages *messages, km_study_method *out) {
  kt_exit result = KT_DONE;
  const char *rest = names;
  for (char last = ','; last == ',';) {
    kt_piece piece = kt_split(&rest, ",");
    km_error error;
    int index = open->def.method_count++;
    last = piece.separator;
    if (km_method_of_word(piece.text, &out[index].method, &error))
      result = fault(&open->def, messages, index, NULL, &error);
    km_free(piece.text);
  }
  return result;
}

/* The settings of options, put into a method that has them. */
static kt_exit set_method(const kredund_request *r, const setting *settings, kredund_open *open, int index,
                          km_messages *messages, km_method *method) {
  kt_exit result = KT_DONE;
  km_error error;
  const char *key;
  for (int i = 0; i < SETTINGS; ++i) {
    const setting *s = &settings[i];
    bool word = strcmp(s->key, "value") == 0;
    double value = 0.0;
    if (!s->text || !km_method_has(method->kind, s->key))
      continue;
    if (!word && !kt_number(s->text, &value))
      return kt_usage(&r->common, s->option, s->text, "a number");
    if (word ? km_method_set_leaf(method, s->text, &error) : km_method_set(method, s->key, value, &error))
      result = kredund_fault(messages, true, s->option, &error);
  }
  if (result != KT_DONE || !km_method_check(method, &key, &error))
    return result;
  for (int i = 0; i < SETTINGS; ++i)
    if (settings[i].text && strcmp(settings[i].key, key) == 0)
      return kredund_fault(messages, true, settings[i].option, &error);
  return fault(&open->def, messages, index, key, &error);
}

/* An option that none of the methods has. */
static void warn_of_settings(const kredund_request *r, const setting *settings, const km_study_def *def) {
  for (int i = 0; i < SETTINGS; ++i) {
    bool used = !settings[i].text;
    for (int k = 0; k < def->method_count && !used; ++k)
      used = km_method_has(def->methods[k].method.kind, settings[i].key);
    km_text owners = {0};
    km_method_owners(settings[i].key, &owners);
    if (!used && owners.data)
      kt_print_message(&r->common, KM_WARNING, "--%s doesn't count: none of the methods has it; it is a setting of %s",
                       settings[i].key, owners.data);
    km_text_free(&owners);
  }
}

static km_study_method *copy_of_methods(kredund_open *open, const char *names) {
  const km_study_def *def = &open->def;
  size_t most = names ? strlen(names) + 1 : (size_t)def->method_count;
  km_study_method *methods = KM_ARENA_NEW(&open->arena, km_study_method, most);
  for (int i = 0; i < def->method_count && methods && !names; ++i)
    methods[i] = def->methods[i];
  return methods;
}

kt_exit kredund_set_methods(const kredund_request *r, kredund_open *open, km_messages *messages) {
  km_study_def *def = &open->def;
  setting settings[SETTINGS];
  kt_exit result = KT_DONE;
  bool set = false;
  const char *names = r->methods ? r->methods : r->everything && def->method_count == 0 ? all_methods : NULL;
  gather(r, settings);
  for (int i = 0; i < SETTINGS; ++i)
    set = set || settings[i].text;
  if (!names && (!set || def->method_count == 0))
    return KT_DONE;
  km_study_method *methods = copy_of_methods(open, names);
  if (!methods)
    return KT_NO_MEMORY;
  def->methods = methods;
  if (names)
    result = name_methods(open, names, messages, methods);
  for (int i = 0; i < def->method_count && set && result == KT_DONE; ++i)
    result = set_method(r, settings, open, i, messages, &methods[i].method);
  if (set && result == KT_DONE)
    warn_of_settings(r, settings, def);
  return result;
}
