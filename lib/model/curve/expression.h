/* Expressions of the time, as compiled programs with exact derivatives (docs/theory.md 11.8). */
#ifndef KM_MODEL_CURVE_EXPRESSION_H
#define KM_MODEL_CURVE_EXPRESSION_H

#include "base/memory.h"

#include <stdbool.h>

enum { KM_LONGEST_EXPRESSION = 1000 /* characters */ };

typedef struct km_expression km_expression;

/* Value of a name; false: it has none. */
typedef bool km_name_value(const void *context, const char *name, size_t length, double *value);

/* Compiles numbers, + - * / ^ ( ), t, pi, deg, sqrt sin cos tan atan2 abs min max and the names of `values`: the syntax
 * of exchange/json/formula.h. NULL: the text isn't such an expression, or no memory. */
const km_expression *km_expression_compile(const char *text, km_name_value *values, const void *context,
                                           km_arena *arena);
/* Value and two derivatives at t. O(length of the text); never allocates. */
void km_expression_at(const km_expression *expression, double t, double out[3]);
/* Numbers of the program, so that changes of parameters can be found. */
const double *km_expression_numbers(const km_expression *expression, int *count);

/* True if the text uses a name. */
bool km_expression_uses(const char *text, const char *name);
/* Length of the name at the start of the text; 0: none begins there. */
size_t km_expression_name(const char *text);
/* Length of the number at the start of the text; 0: none begins there. */
size_t km_expression_number(const char *text);

#endif
