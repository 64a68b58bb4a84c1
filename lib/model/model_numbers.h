/* Every number of a model that a file states, in one order: what tells which of them a parameter moves. */
#ifndef KM_MODEL_MODEL_NUMBERS_H
#define KM_MODEL_MODEL_NUMBERS_H

#include "model/model.h"

/* What a reader asks of a number before it takes it over as it is. */
typedef enum km_number_rule {
  KM_NUMBER_FREE,         /* nothing */
  KM_NUMBER_NOT_NEGATIVE, /* at least 0 */
  KM_NUMBER_CHECKED       /* something that involves others, or it isn't taken over as it is */
} km_number_rule;

typedef struct km_model_number {
  double *at;
  km_number_rule rule;
} km_model_number;

typedef struct km_model_numbers {
  km_model_number *items;
  size_t count, capacity;
  bool failed; /* out of memory */
} km_model_numbers;

/* Two models of one structure give the same count and order. Free in any case. */
void km_model_numbers_list(km_model *model, km_model_numbers *out);
void km_model_numbers_free(km_model_numbers *numbers);

#endif
