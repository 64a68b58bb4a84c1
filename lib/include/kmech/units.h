/* The units a model is written in, and what they are in SI. */
#ifndef KMECH_UNITS_H
#define KMECH_UNITS_H

#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One unit of a quantity: the word in a file, the suffix in a column, its size in SI. */
typedef struct km_unit {
  const char *word, *suffix; /* in a file: "degrees"; in a column: "deg" */
  double si;                 /* radians, metres, kilograms, seconds, newtons of one */
} km_unit;

/* A unit for each quantity. */
typedef struct km_units {
  const km_unit *angle, *length, *mass, *time, *force; /* borrowed for ever */
} km_units;

/* Exponents of the five base units; generalised forces and rates of angles count radians, so `angle` is 1 only for angles
 * written in the angle unit. */
typedef struct km_dimension {
  signed char angle, length, mass, time, force; /* exponents */
} km_dimension;

/* What has a unit of its own. */
typedef enum km_quantity {
  KM_ANGLE,     /* radians in SI */
  KM_LENGTH,    /* metres */
  KM_MASS,      /* kilograms */
  KM_TIME,      /* seconds */
  KM_FORCE,     /* newtons */
  KM_QUANTITIES /* how many there are */
} km_quantity;

KM_API km_units km_units_default(void); /* radians, metres, kilograms, seconds, newtons */
/* Those of a model; the default ones without a model. */
KM_API km_units km_model_units(const km_model *model);
/* "angle" …; "" for none. */
KM_API const char *km_quantity_name(km_quantity quantity);
/* The unit of that word or suffix; NULL if there is none. */
KM_API const km_unit *km_unit_find(km_quantity quantity, const char *word);
/* The place of a quantity's unit among the others; NULL if there is none. */
KM_API const km_unit **km_units_slot(km_units *units, km_quantity quantity);
/* Size in SI of one unit of a dimension. NaN without units. */
KM_API double km_units_factor(const km_units *units, km_dimension dimension);

#ifdef __cplusplus
}
#endif
#endif
