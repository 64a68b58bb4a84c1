/* The settings of path studies' methods as data; kmech/track.h has what programs ask. */
#ifndef KM_MODEL_METHODS_H
#define KM_MODEL_METHODS_H

#include "base/text.h"
#include "kmech/track.h"

/* The settings that are numbers, as a study writes them: angles in degrees. */
int km_method_setting_count(void);
const char *km_method_setting(int index);

#endif
