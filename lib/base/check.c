/* The words for what is missing or out of range in a call. */
#include "base/check.h"

km_status km_check_given(bool given, const char *what, km_error *error) {
  return given ? KM_OK : km_fail(error, KM_USAGE, "no %s was given", what);
}

km_status km_check_index(int index, int count, const char *what, km_error *error) {
  if (index >= 0 && index < count)
    return KM_OK;
  if (count <= 0)
    return km_fail(error, KM_USAGE, "there is no %s %d: there are none", what, index);
  return km_fail(error, KM_USAGE, "there is no %s %d; expected 0 to %d", what, index, count - 1);
}

km_status km_check_list(const void *list, int count, const char *what, km_error *error) {
  if (count < 0)
    return km_fail(error, KM_USAGE, "%d is no number of %s; expected 0 or more", count, what);
  return km_check_given(list || count == 0, what, error);
}
