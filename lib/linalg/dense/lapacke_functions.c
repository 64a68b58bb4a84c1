/* Loads LAPACKE. */
#include "linalg/dense/lapacke_functions.h"

#include "base/dynamic_library.h"

km_status km_lapacke_load(const char *what, km_lapacke_functions *out, km_error *error) {
  static const char *const files[] = {KM_LAPACKE, NULL};
  static const char *const names[] = {"LAPACKE_dgeev_work", "LAPACKE_dgesdd_work", NULL};
  static km_lapacke_functions functions;
  static km_library library = {files, names, &functions, false};
  const char *reason = km_library_load(&library);
  *out = functions;
  return reason ? km_fail(error, KM_IO, "%s can't be computed: %.300s; expected LAPACKE to be installed", what, reason)
                : KM_OK;
}
