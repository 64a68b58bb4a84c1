/* The models that kmob new writes. */
#ifndef KMOB_STARTERS_H
#define KMOB_STARTERS_H

#include "kmech/base.h"
#include "kmech/model.h"

/* The kinds, as options list them; a kind is its place there. */
#define KMOB_KINDS "fourbar or slider-crank or cylinder or six-bar or parallel or arm"

/* A kind's model in the given units. Sizes are round numbers in every unit: an inch stands for 25 mm, a pound for half
 * a kilogram, a pound-force for 5 N; gravity is exact. */
void kmob_starter_write(int kind, const km_units *units, km_text *out);

#endif
