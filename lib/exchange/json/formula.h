/* Parameters of a model file, and expressions over them in place of numbers. */
#ifndef KM_EXCHANGE_JSON_FORMULA_H
#define KM_EXCHANGE_JSON_FORMULA_H

#include "base/value.h"
#include "exchange/json/json_location.h"
#include "kmech/base.h"

/* Names of a parser of expressions: constants, and values of the parameters so far. */
typedef struct km_formulas km_formulas;

/* Creates a parser. `parameters`: those of the file, to distinguish a later parameter from an unknown name; NULL:
 * none. NULL when out of memory. muParser is loaded with the first expression. */
km_formulas *km_formulas_create(const km_value *parameters);
void km_formulas_free(km_formulas *formulas);

/* Checks that a name is valid for a parameter. KM_MODEL with the reason. */
km_status km_formulas_check_name(const char *name, km_error *error);
/* Gives a parameter its value. False when out of memory. */
bool km_formulas_define(km_formulas *formulas, const char *name, double value);

/* The value of an expression: numbers, + - * / ^ ( ), pi, deg, sqrt sin cos tan atan2 abs min max, and parameters that
 * are defined. KM_MODEL says what is wrong, without the place; KM_IO: the library isn't there; KM_MEMORY. */
km_status km_formulas_evaluate(km_formulas *formulas, const char *text, double *value, km_error *error);
/* As km_formulas_evaluate; the value may be infinite or NaN. */
km_status km_formulas_result(km_formulas *formulas, const char *text, double *value, km_error *error);

#endif
