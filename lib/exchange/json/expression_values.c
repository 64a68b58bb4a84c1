/* Puts values into the numbers of a model file that are written as expressions. */
#include "exchange/json/expression_values.h"

#include "exchange/json/format/format.h"
#include "exchange/json/formula.h"
#include "model/curve/expression.h"

#include <string.h>

typedef struct evaluation {
  km_formulas *formulas;
  km_messages *messages;
  bool has_t;       /* a parameter is called t */
  bool is_faulty;   /* the value of a parameter is */
  km_status status; /* KM_IO or KM_MEMORY: no use to go on */
  km_error error;
} evaluation;

/* Returns false where the string is no expression; that is reported, with the note of the parameter (NULL: none). */
static bool evaluate_noted(evaluation *e, km_value *value, const char *note, const km_place *place) {
  char where[KM_PLACE_TEXT];
  km_status status = km_formulas_evaluate(e->formulas, value->string, &value->number, &e->error);
  if (status == KM_MODEL)
    km_messages_add(e->messages, KM_ERROR, "%s: found the string \"%.60s\"; expected a number or an expression: %s%s%s",
                    km_place_text(place, where), value->string, e->error.text, note ? "; " : "", note ? note : "");
  else if (status)
    e->status = status;
  value->kind = KM_NUMBER;
  return !status;
}

static bool evaluate_number(evaluation *e, km_value *value, const km_place *place) {
  return evaluate_noted(e, value, NULL, place);
}

/* Every string in a field of numbers, however deep. */
static void evaluate_numbers(evaluation *e, km_value *value, const km_place *place) {
  if (value->kind == KM_STRING)
    evaluate_number(e, value, place);
  km_place item = {place, NULL, 0};
  for (km_value *v = value->first; v && !e->status; v = v->next, ++item.index) {
    item.key = v->key;
    evaluate_numbers(e, v, &item);
  }
}

static void evaluate_object(evaluation *e, km_value *object, const km_object_format *format, const km_place *place);

static void evaluate_map(evaluation *e, km_value *map, const km_field *field, const km_place *place) {
  for (km_value *v = map->first; v && !e->status; v = v->next) {
    km_place item = {place, v->key, 0};
    if (v->kind == KM_OBJECT)
      evaluate_object(e, v, field->object, &item);
    else if (field->shape == KM_SHAPE_LIST_MAP)
      evaluate_numbers(e, v, &item);
  }
}

/* True for a string that is an expression of the time, not of numbers. */
static bool is_of_time(const evaluation *e, const km_value *value, km_shape shape) {
  return value->kind == KM_STRING && shape == KM_SHAPE_TIME_LAW && !e->has_t && km_expression_uses(value->string, "t");
}

/* A string in place of a whole list is none of its numbers: it is left to the check of the field. */
static bool stands_for_a_list(const km_value *value, km_shape shape) {
  return value->kind == KM_STRING && shape != KM_SHAPE_NUMBER && shape != KM_SHAPE_COORDINATES &&
         shape != KM_SHAPE_TIME_LAW;
}

static void evaluate_object(evaluation *e, km_value *object, const km_object_format *format, const km_place *place) {
  for (km_value *v = object->kind == KM_OBJECT ? object->first : NULL; v && !e->status; v = v->next) {
    const km_field *field = km_format_field(format, v->key);
    km_place at = {place, v->key, 0};
    km_place item = {&at, NULL, 0};
    if (!field || stands_for_a_list(v, field->shape) || is_of_time(e, v, field->shape))
      continue;
    if (km_shape_is_numeric(field->shape))
      evaluate_numbers(e, v, &at);
    else if (field->shape == KM_SHAPE_OBJECT || field->shape == KM_SHAPE_END)
      evaluate_object(e, v, field->object, &at);
    else if (field->shape == KM_SHAPE_OBJECTS && v->kind == KM_LIST)
      for (km_value *o = v->first; o; o = o->next, ++item.index)
        evaluate_object(e, o, field->object, &item);
    else if (field->shape == KM_SHAPE_MAP || field->shape == KM_SHAPE_LIST_MAP || field->shape == KM_SHAPE_WORD_MAP)
      evaluate_map(e, v, field, &at);
  }
}

static km_value *member(km_value *object, const char *key) {
  for (km_value *v = object->kind == KM_OBJECT ? object->first : NULL; v; v = v->next)
    if (strcmp(v->key, key) == 0)
      return v;
  return NULL;
}

km_value *km_parameter_number(km_value *parameter) {
  return parameter->kind == KM_OBJECT ? member(parameter, "value") : parameter;
}

static void evaluate_parameter(evaluation *e, km_value *parameter, const km_place *place) {
  char where[KM_PLACE_TEXT];
  km_value *number = km_parameter_number(parameter), *note = member(parameter, "note");
  km_place inner = {place, "value", 0};
  bool sound = true;
  if (km_formulas_check_name(parameter->key, &e->error)) {
    km_messages_add(e->messages, KM_ERROR, "%s: %s", km_place_text(place, where), e->error.text);
    return;
  }
  if (number && number->kind == KM_STRING)
    sound = evaluate_noted(e, number, note && note->kind == KM_STRING ? note->string : NULL,
                           number == parameter ? place : &inner);
  e->is_faulty = e->is_faulty || !sound;
  /* A faulty expression has the value 1, so that its fault isn't reported again at each use. */
  double value = sound && number && number->kind == KM_NUMBER ? number->number : 1.0;
  if (!km_formulas_define(e->formulas, parameter->key, value))
    e->status = km_fail(&e->error, KM_MEMORY, "out of memory while reading parameters");
}

/* Reports a value beyond a bound, which may be why another parameter has no value. */
static void report_beyond(evaluation *e, const km_value *number, const km_value *bound, bool is_high,
                          const km_place *place) {
  char where[KM_PLACE_TEXT];
  const double beyond = is_high ? number->number - bound->number : bound->number - number->number;
  if (beyond > 0.0)
    km_messages_add(e->messages, KM_ERROR, "%s: %.10g is %.4g %s its %s value, %s%s%.10g", km_place_text(place, where),
                    number->number, beyond, is_high ? "more than" : "below", is_high ? "greatest" : "least",
                    bound->string ? bound->string : "", bound->string ? " = " : "", bound->number);
}

/* Evaluates the bounds of a parameter, which may use all parameters. */
static void evaluate_bounds(evaluation *e, km_value *parameter, const km_place *place) {
  static const char *const keys[2] = {"low", "high"};
  const km_value *number = km_parameter_number(parameter);
  for (int high = 0; high < 2; ++high) {
    km_value *bound = member(parameter, keys[high]);
    km_place at = {place, keys[high], 0};
    const bool is_sound = bound && (bound->kind != KM_STRING || evaluate_number(e, bound, &at));
    if (is_sound && e->is_faulty && bound->kind == KM_NUMBER && number && number->kind == KM_NUMBER)
      report_beyond(e, number, bound, high == 1, place);
  }
}

/* Calls a step for each parameter. */
static void evaluate_parameters(evaluation *e, km_value *parameters,
                                void (*step)(evaluation *e, km_value *parameter, const km_place *place)) {
  const km_place place = {NULL, "parameters", 0};
  for (km_value *p = parameters && parameters->kind == KM_OBJECT ? parameters->first : NULL; p && !e->status;
       p = p->next) {
    km_place at = {&place, p->key, 0};
    step(e, p, &at);
  }
}

km_status km_model_evaluate(km_value *root, km_messages *messages, km_error *error) {
  km_value *parameters = member(root, "parameters");
  evaluation e = {
      .messages = messages, .formulas = km_formulas_create(parameters), .has_t = km_value_get(parameters, "t") != NULL};
  if (!e.formulas)
    return km_fail(error, KM_MEMORY, "out of memory while reading parameters");
  evaluate_parameters(&e, parameters, evaluate_parameter);
  evaluate_parameters(&e, parameters, evaluate_bounds);
  evaluate_object(&e, root, &km_format_model, NULL);
  km_formulas_free(e.formulas);
  return e.status ? km_fail(error, e.status, "%s", e.error.text) : KM_OK;
}

km_status km_format_evaluate(km_value *root, const km_object_format *format, km_messages *messages, km_error *error) {
  evaluation e = {.messages = messages, .formulas = km_formulas_create(NULL)};
  if (!e.formulas)
    return km_fail(error, KM_MEMORY, "out of memory while reading expressions");
  evaluate_object(&e, root, format, NULL);
  km_formulas_free(e.formulas);
  return e.status ? km_fail(error, e.status, "%s", e.error.text) : KM_OK;
}
