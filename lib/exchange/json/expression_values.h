/* The numbers of a model file that are written as expressions. */
#ifndef KM_EXCHANGE_JSON_EXPRESSION_VALUES_H
#define KM_EXCHANGE_JSON_EXPRESSION_VALUES_H

#include "base/value.h"
#include "exchange/json/format/format.h"
#include "kmech/base.h"

/* Evaluates `parameters`, and replaces each string in the place of a number by its value: a KM_NUMBER that keeps its
 * text in `string`. Faults are reported with their locations. KM_IO: expressions can't be evaluated at all;
 * KM_MEMORY. */
km_status km_model_evaluate(km_value *root, km_messages *messages, km_error *error);

/* Evaluates a file of another format, which has no parameters. */
km_status km_format_evaluate(km_value *root, const km_object_format *format, km_messages *messages, km_error *error);

/* Value of a parameter by its name, of the `parameters` of a file (NULL: none): a km_name_value. */
bool km_parameter_value(const void *parameters, const char *name, size_t length, double *value);

/* A member of `parameters` that holds its number: itself, or its `value`; NULL if it has none. */
km_value *km_parameter_number(km_value *parameter);

#endif
