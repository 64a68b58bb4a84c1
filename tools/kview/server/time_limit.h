/* Time limit of a page's request, because pages share a thread: longer work is cancelled. */
#ifndef KT_KVIEW_SERVER_TIME_LIMIT_H
#define KT_KVIEW_SERVER_TIME_LIMIT_H

#include "kmech/base.h"

#include <stdbool.h>
#include <time.h>

typedef struct kv_limit {
  struct timespec start;
} kv_limit;

extern const double kv_most_seconds;
kv_limit kv_limit_begin(void);
/* A km_progress: false when the time is over. */
bool kv_limit_goes_on(void *limit, double done);
/* Says of work that was cancelled so what took too long; other statuses stay. */
km_status kv_limit_report(km_status status, const char *what, km_error *error);

#endif
