/* Time limit of a page's request. */
#include "kview/server/time_limit.h"

const double kv_most_seconds = 4.0;

kv_limit kv_limit_begin(void) {
  kv_limit limit;
  clock_gettime(CLOCK_MONOTONIC, &limit.start);
  return limit;
}

bool kv_limit_goes_on(void *limit, double done) {
  const kv_limit *l = limit;
  struct timespec now;
  (void)done;
  clock_gettime(CLOCK_MONOTONIC, &now);
  double passed = (double)(now.tv_sec - l->start.tv_sec) + 1e-9 * (double)(now.tv_nsec - l->start.tv_nsec);
  return passed < kv_most_seconds;
}

km_status kv_limit_report(km_status status, const char *what, km_error *error) {
  return status == KM_CANCELLED ? km_fail(error, KM_CANCELLED, "%s took more than %g s", what, kv_most_seconds)
                                : status;
}
