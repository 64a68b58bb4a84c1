/* Checks of arguments by public functions: missing pointers, indices out of range. Internal functions don't repeat
 * them. */
#ifndef KM_BASE_ARGUMENTS_H
#define KM_BASE_ARGUMENTS_H

#include "kmech/base.h"

#include <stdbool.h>

/* Texts of the errors below. */
void km_report_missing(const char *what, km_error *error);
void km_report_index(int index, int count, const char *what, km_error *error);
void km_report_count(int count, const char *what, km_error *error);

/* KM_USAGE with "no <what> was given". */
static inline km_status km_check_given(bool given, const char *what, km_error *error) {
  if (given)
    return KM_OK;
  km_report_missing(what, error);
  return KM_USAGE;
}

/* KM_USAGE unless 0 <= index < count: "there is no <what> 77; expected 0 to 5". */
static inline km_status km_check_index(int index, int count, const char *what, km_error *error) {
  if (index >= 0 && index < count)
    return KM_OK;
  km_report_index(index, count, what, error);
  return KM_USAGE;
}

/* KM_USAGE unless count is 0, or greater with a list of that many. */
static inline km_status km_check_list(const void *list, int count, const char *what, km_error *error) {
  if (count >= 0)
    return km_check_given(list || count == 0, what, error);
  km_report_count(count, what, error);
  return KM_USAGE;
}

#endif
