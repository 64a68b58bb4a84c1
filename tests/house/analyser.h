/* Included before every file that clang-tidy reads: what its analyser has to know of functions in other files. */
#ifndef KM_ANALYSER_H
#define KM_ANALYSER_H

#include "../../lib/include/kmech/base.h"

/* km_fail returns the status that it is given. The analyser doesn't look into functions with `...`. */
static inline km_status km_analysed(km_status status) {
  return status;
}
#define km_fail(error, status, ...) ((void)km_fail((error), (status), __VA_ARGS__), km_analysed(status))

#endif
