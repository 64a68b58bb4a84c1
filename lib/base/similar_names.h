/* Edit distance of names, used by km_nearest_add (kmech/base.h). */
#ifndef KM_BASE_SIMILAR_NAMES_H
#define KM_BASE_SIMILAR_NAMES_H

#include "kmech/base.h"

/* Edit distance in bytes; SIZE_MAX if a text has more than 60 bytes. */
size_t km_text_distance(const char *a, const char *b);

#endif
