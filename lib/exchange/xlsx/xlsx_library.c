/* Loads libxlsxwriter. */
#include "exchange/xlsx/xlsx_library.h"

#include "base/dynamic_library.h"

const km_xlsx_functions *km_xlsx_load(km_error *error) {
#define X(name) #name,
  static const char *const names[] = {KM_XLSX_FUNCTIONS(X) NULL};
#undef X
  static const char *const files[] = {KM_XLSXWRITER, NULL};
  static km_xlsx_functions functions;
  static km_library library = {files, names, &functions, false};
  const char *reason = km_library_load(&library);
  if (!reason)
    return &functions;
  km_fail(error, KM_IO, "workbooks can't be written: %.300s; expected libxlsxwriter to be installed", reason);
  return NULL;
}
