/* Loads cairo and Pango. */
#include "report/plot/cairo_library.h"

#include "base/library.h"

#include <dlfcn.h>
#include <stdatomic.h>

/* Each library that holds some of the functions; the loader finds those that they need. */
static const char *const files[] = {"libpangocairo-1.0.so.0", "libcairo.so.2", "libpango-1.0.so.0",
                                    "libgobject-2.0.so.0", "libglib-2.0.so.0"};
enum { FILES = sizeof files / sizeof *files };

static bool find(void *const *handles, const char *name, void *function) {
  for (int i = 0; i < FILES; ++i)
    if (km_library_function(handles[i], name, function))
      return true;
  return false;
}

static bool load(km_cairo *out) {
  void *handles[FILES];
  for (int i = 0; i < FILES; ++i) {
    handles[i] = dlopen(files[i], RTLD_NOW | RTLD_LOCAL);
    if (!handles[i])
      return false;
  }
  bool found = true;
#define X(name) found = find(handles, #name, &out->name) && found;
  KM_CAIRO_FUNCTIONS(X)
#undef X
  return found;
}

/* Two threads that load at once write the same addresses: the first to finish publishes its own. */
const km_cairo *km_cairo_load(km_error *error) {
  static km_cairo kept;
  static atomic_int state; /* 0: not loaded, 1: one thread is loading, 2: loaded */
  int none = 0;
  if (atomic_load(&state) == 2)
    return &kept;
  km_cairo own;
  if (!load(&own)) {
    const char *reason = dlerror();
    km_fail(error, KM_IO, "pictures can't be drawn: %.300s; expected cairo and Pango to be installed",
            reason ? reason : "a function of theirs is missing");
    return NULL;
  }
  if (atomic_compare_exchange_strong(&state, &none, 1)) {
    kept = own;
    atomic_store(&state, 2);
  }
  while (atomic_load(&state) != 2)
    ;
  return &kept;
}
