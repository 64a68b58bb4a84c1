/* Errors about missing or invalid arguments. */
#include "base/arguments.h"

void km_report_missing(const char *what, km_error *error) {
  km_fail(error, KM_USAGE, "no %s was given", what);
}

void km_report_index(int index, int count, const char *what, km_error *error) {
  if (count <= 0)
    km_fail(error, KM_USAGE, "there is no %s %d: there are none", what, index);
  else
    km_fail(error, KM_USAGE, "there is no %s %d; expected 0 to %d", what, index, count - 1);
}

void km_report_count(int count, const char *what, km_error *error) {
  km_fail(error, KM_USAGE, "%d is no number of %s; expected 0 or more", count, what);
}
