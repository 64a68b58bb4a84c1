/* Numbers by name: the parameters of a model file, and the expressions over them that stand for numbers. */
#ifndef KM_EXCHANGE_JSON_FORMULA_H
#define KM_EXCHANGE_JSON_FORMULA_H

#include "base/value.h"
#include "exchange/json/json_location.h"
#include "kmech/base.h"

/* What a parser of expressions knows: constants, and the values of the parameters so far. */
typedef struct km_formulas km_formulas;

/* `parameters`: of the file, for telling a later one from an unknown one; NULL: none. NULL when out of memory. The
 * library that evaluates is loaded with the first expression. */
km_formulas *km_formulas_create(const km_value *parameters);
void km_formulas_free(km_formulas *formulas);

/* Is the name one that a parameter can have? KM_MODEL with the reason. */
km_status km_formulas_check_name(const char *name, km_error *error);
/* Gives a parameter its value. False when out of memory. */
bool km_formulas_define(km_formulas *formulas, const char *name, double value);

/* The value of an expression: numbers, + - * / ^ ( ), pi, deg, sqrt sin cos tan atan2 abs min max, and parameters that
 * are defined. KM_MODEL says what is wrong, without the place; KM_IO: the library isn't there; KM_MEMORY. */
km_status km_formulas_evaluate(km_formulas *formulas, const char *text, double *value, km_error *error);

#endif
