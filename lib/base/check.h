/* What public functions ask of what comes in: a pointer that is missing and an index out of range are told, never
 * followed. Internal functions don't ask again. */
#ifndef KM_BASE_CHECK_H
#define KM_BASE_CHECK_H

#include "kmech/status.h"

#include <stdbool.h>

/* KM_USAGE with "no <what> was given". */
km_status km_check_given(bool given, const char *what, km_error *error);
/* KM_USAGE unless 0 <= index < count: "there is no <what> 77; expected 0 to 5". */
km_status km_check_index(int index, int count, const char *what, km_error *error);
/* KM_USAGE unless count is 0, or greater with a list of that many. */
km_status km_check_list(const void *list, int count, const char *what, km_error *error);

#endif
