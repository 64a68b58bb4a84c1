/* The version of the library at run time. */
#include "kmech/version.h"

const char *km_version(void) {
  return KM_VERSION;
}
