/* Table of the settings of tracking methods. The public functions are in kmech/arm.h. */
#ifndef KM_MODEL_PATH_STUDY_METHOD_SETTINGS_H
#define KM_MODEL_PATH_STUDY_METHOD_SETTINGS_H

#include "base/text.h"
#include "kmech/arm.h"

/* Numeric settings as in a study file: angles in degrees. */
int km_method_setting_count(void);
const char *km_method_setting(int index);

#endif
