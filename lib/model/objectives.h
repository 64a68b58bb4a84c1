/* The words of path studies for what is good, and for what must follow the path. */
#ifndef KM_MODEL_OBJECTIVES_H
#define KM_MODEL_OBJECTIVES_H

#include "kmech/track.h"

/* Adds an objective of that name to a weighted sum. KM_USAGE: there is none, or it is no weight. */
km_status km_objective_add(km_objective *objective, const char *word, double weight, km_error *error);
/* KM_USAGE: no task has that name. */
km_status km_task_of_word(const char *word, km_task *out, km_error *error);

#endif
