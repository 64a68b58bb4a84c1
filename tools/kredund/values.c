/* What options say, as the values that a study has for it. */
#include "kredund/kredund.h"

#include "base/memory.h"

#include <string.h>

const km_value *kredund_as_list(kredund_open *open, const char *text, bool numbers, const kt_common *common,
                                const char *option, kt_exit *exit) {
  km_value *list = km_value_add(&open->arena, NULL, NULL, KM_LIST);
  const char *rest = text;
  for (char last = ','; last == ',' && *exit == KT_DONE;) {
    kt_piece piece = kt_split(&rest, ",");
    double value = 0.0;
    last = piece.separator;
    if (numbers && !(piece.text && kt_number(piece.text, &value)))
      *exit = kt_usage(common, option, text, "numbers a,b,…");
    else if (numbers)
      km_value_number(&open->arena, list, NULL, value);
    else
      km_value_string(&open->arena, list, NULL, piece.text ? piece.text : "");
    km_free(piece.text);
  }
  return list;
}

const km_value *kredund_as_objective(kredund_open *open, const char *text, const kt_common *common, kt_exit *exit) {
  if (!strchr(text, '='))
    return km_value_string(&open->arena, NULL, NULL, text);
  km_value *object = km_value_add(&open->arena, NULL, NULL, KM_OBJECT);
  const char *rest = text;
  for (char last = ','; last == ',' && *exit == KT_DONE;) {
    kt_piece name = kt_split(&rest, "="), weight = kt_split(&rest, ",");
    double value = 0.0;
    last = weight.separator;
    if (name.separator != '=' || !weight.text || !kt_number(weight.text, &value))
      *exit = kt_usage(common, "--objective", text, "NAME, or NAME=WEIGHT,NAME=WEIGHT");
    else
      km_value_number(&open->arena, object, name.text, value);
    km_free(name.text);
    km_free(weight.text);
  }
  return object;
}

/* The settings of options, put into a method that has them. */
static void add_settings(kredund_open *open, const kredund_request *r, km_value *method, kt_exit *exit) {
  const km_value *name = km_value_get(method, "method");
  int kind = name && name->kind == KM_STRING ? km_method_find(name->string) : -1;
  const struct {
    const char *key, *option, *text;
  } numbers[] = {{"branches", "--branches", r->branches},
                 {"levels", "--levels", r->levels},
                 {"angle", "--angle", r->angle},
                 {"stride", "--stride", r->stride}};
  double value;
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
    if (!numbers[i].text || kind < 0 || !km_method_has((km_method_kind)kind, numbers[i].key))
      continue;
    if (!kt_number(numbers[i].text, &value))
      *exit = kt_usage(&r->common, numbers[i].option, numbers[i].text, "a number");
    else
      km_value_number(&open->arena, method, numbers[i].key, value);
  }
  if (r->value && kind == KM_LOOKAHEAD)
    km_value_string(&open->arena, method, "value", r->value);
}

static bool is_set_by(const kredund_request *r, const char *key) {
  return (strcmp(key, "branches") == 0 && r->branches) || (strcmp(key, "levels") == 0 && r->levels) ||
         (strcmp(key, "angle") == 0 && r->angle) || (strcmp(key, "stride") == 0 && r->stride) ||
         (strcmp(key, "value") == 0 && r->value);
}

/* A method as the study or --method has it, with the options in the place of its own settings. */
static void add_method(kredund_open *open, const kredund_request *r, const km_value *from, km_value *list,
                       kt_exit *exit) {
  km_value *method = km_value_add(&open->arena, list, NULL, KM_OBJECT);
  if (from->kind == KM_STRING)
    km_value_string(&open->arena, method, "method", from->string);
  for (const km_value *v = from->kind == KM_OBJECT ? from->first : NULL; v; v = v->next) {
    if (is_set_by(r, v->key))
      continue;
    km_value *copy = km_value_add(&open->arena, method, v->key, v->kind);
    if (copy) {
      copy->number = v->number;
      copy->string = v->string;
      copy->first = v->first;
      copy->last = v->last;
      copy->count = v->count;
    }
  }
  add_settings(open, r, method, exit);
}

/* An option that none of the methods has. */
static void warn_of_settings(const kredund_request *r, const km_value *methods) {
  static const char *const keys[] = {"branches", "levels", "angle", "stride", "value"};
  for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
    bool used = !is_set_by(r, keys[i]);
    for (const km_value *v = methods->first; v && !used; v = v->next) {
      const km_value *name = km_value_get(v, "method");
      int kind = name && name->kind == KM_STRING ? km_method_find(name->string) : -1;
      used = kind >= 0 && km_method_has((km_method_kind)kind, keys[i]);
    }
    km_text owners = {0};
    km_method_owners(keys[i], &owners);
    if (!used && owners.data)
      kt_say(&r->common, KM_WARNING, "--%s doesn't count: none of the methods has it; it is a setting of %s", keys[i],
             owners.data);
    km_text_free(&owners);
  }
}

const km_value *kredund_as_methods(kredund_open *open, const kredund_request *r, kt_exit *exit) {
  static const char all[] = "greedy,lookahead,fixed,dls,gradient,dp,global";
  const km_value *own = km_value_get(open->study->root, "methods");
  const char *named = r->methods ? r->methods : r->everything && !own ? all : NULL;
  const km_value *given = named ? kredund_as_list(open, named, false, &r->common, "--method", exit) : own;
  bool set = r->branches || r->levels || r->angle || r->stride || r->value;
  if (!set || !given)
    return named ? given : NULL;
  km_value *list = km_value_add(&open->arena, NULL, NULL, KM_LIST);
  if (given->kind != KM_LIST)
    add_method(open, r, given, list, exit);
  for (const km_value *v = given->kind == KM_LIST ? given->first : NULL; v; v = v->next)
    add_method(open, r, v, list, exit);
  warn_of_settings(r, list);
  return list;
}
