/* Distances of names; kmech/base.h finds the nearest by them. */
#ifndef KM_BASE_SIMILAR_NAMES_H
#define KM_BASE_SIMILAR_NAMES_H

#include "kmech/base.h"

/* Edit distance in bytes; SIZE_MAX where a text has more than 60. */
size_t km_text_distance(const char *a, const char *b);

#endif
