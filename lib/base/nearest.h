/* Distances of names; kmech/nearest.h finds the nearest by them. */
#ifndef KM_BASE_NEAREST_H
#define KM_BASE_NEAREST_H

#include "kmech/nearest.h"

/* Edit distance in bytes; SIZE_MAX where a text has more than 60. */
size_t km_text_distance(const char *a, const char *b);

#endif
