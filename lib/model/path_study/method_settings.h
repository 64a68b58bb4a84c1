/* The settings of path studies' methods as data; kmech/arm.h has what programs ask. */
#ifndef KM_MODEL_PATH_STUDY_METHOD_SETTINGS_H
#define KM_MODEL_PATH_STUDY_METHOD_SETTINGS_H

#include "base/text.h"
#include "kmech/arm.h"

/* The settings that are numbers, as a study writes them: angles in degrees. */
int km_method_setting_count(void);
const char *km_method_setting(int index);

#endif
