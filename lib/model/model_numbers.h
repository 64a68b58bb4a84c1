/* All numbers of a model in a fixed order, so that the numbers that depend on a parameter can be found by
 * comparison. */
#ifndef KM_MODEL_MODEL_NUMBERS_H
#define KM_MODEL_MODEL_NUMBERS_H

#include "model/model.h"

/* Conditions under which a reader copies a number unchanged. */
typedef enum km_number_rule {
  KM_NUMBER_FREE,         /* always */
  KM_NUMBER_NOT_NEGATIVE, /* if it is at least 0 */
  KM_NUMBER_CHECKED       /* not copied unchanged, or depends on others */
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

/* Lists the numbers of a model. Models with equal structure have equal count and order. Free in any case. */
void km_model_numbers_list(km_model *model, km_model_numbers *out);
void km_model_numbers_free(km_model_numbers *numbers);

#endif
