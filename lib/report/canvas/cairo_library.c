/* Loads cairo, FreeType and Pango. */
#include "report/canvas/cairo_library.h"

#include "base/dynamic_library.h"

static const void *load(km_library *library, km_error *error) {
  const char *reason = km_library_load(library);
  if (!reason)
    return library->functions;
  km_fail(error, KM_IO, "pictures can't be drawn: %.300s; expected cairo and Pango to be installed", reason);
  return NULL;
}

#define X(name) #name,

const km_cairo *km_cairo_load(km_error *error) {
  static const char *const files[] = {"libcairo.so.2", "libfreetype.so.6", NULL};
  static const char *const names[] = {KM_CAIRO_FUNCTIONS(X) NULL};
  static km_cairo functions;
  static km_library library = {files, names, &functions, false};
  return load(&library, error);
}

const km_pango_functions *km_pango_load(km_error *error) {
  static const char *const files[] = {"libpangocairo-1.0.so.0", "libcairo.so.2",    "libpango-1.0.so.0",
                                      "libgobject-2.0.so.0",    "libglib-2.0.so.0", NULL};
  static const char *const names[] = {KM_PANGO_FUNCTIONS(X) NULL};
  static km_pango_functions functions;
  static km_library library = {files, names, &functions, false};
  return load(&library, error);
}
