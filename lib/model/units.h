/* The units a model is written in, and what they are in SI. */
#ifndef KM_MODEL_UNITS_H
#define KM_MODEL_UNITS_H

#include <stdbool.h>

/* One unit of a quantity: the word in the file, the suffix in a column, its size in SI. */
typedef struct km_unit {
  const char *word, *suffix;
  double si;
} km_unit;

typedef struct km_units {
  const km_unit *angle, *length, *mass, *time, *force; /* into the tables of units.c */
} km_units;

/* What a number in a model file measures. Exponents of the five base units; generalised forces and rates
 * of angles count radians, so `angle` is 1 only for angles written in the angle unit. */
typedef struct km_dimension {
  signed char angle, length, mass, time, force;
} km_dimension;

typedef enum km_quantity { KM_ANGLE, KM_LENGTH, KM_MASS, KM_TIME, KM_FORCE, KM_QUANTITIES } km_quantity;

km_units km_units_default(void); /* radians, metres, kilograms, seconds, newtons */
const char *km_quantity_name(km_quantity quantity);
/* The table of one quantity, ended by an entry without word. */
const km_unit *km_quantity_units(km_quantity quantity);
/* The unit of that word or suffix; NULL if there is none. */
const km_unit *km_unit_find(km_quantity quantity, const char *word);
const km_unit **km_units_slot(km_units *units, km_quantity quantity);

km_dimension km_dimension_product(km_dimension a, km_dimension b);
km_dimension km_dimension_power(km_dimension a, int n); /* n of any sign */
/* Size in SI of one unit of the given dimension. */
double km_units_factor(const km_units *units, km_dimension dimension);

#endif
