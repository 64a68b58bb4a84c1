/* Loads shared libraries with dlopen. */
#include "base/dynamic_library.h"

#include "base/parallel.h"

#include <dlfcn.h>
#include <string.h>

enum { FILES_MOST = 8 };

typedef void (*any_function)(void);

/* POSIX allows a function's address in a void *, C's conversions don't. */
static bool find(void *const *handles, const char *name, any_function *function) {
  void *address = NULL;
  for (int i = 0; handles[i] && !address; ++i)
    address = dlsym(handles[i], name);
  memcpy(function, &address, sizeof address);
  return address != NULL;
}

static bool load(km_library *library) {
  void *handles[FILES_MOST + 1] = {NULL};
  any_function *functions = library->functions;
  for (int i = 0; library->files[i]; ++i)
    if (!(handles[i] = dlopen(library->files[i], RTLD_NOW | RTLD_LOCAL)))
      return false;
  for (int i = 0; library->names[i]; ++i)
    if (!find(handles, library->names[i], &functions[i]))
      return false;
  return true;
}

typedef struct request {
  km_library *library;
  const char *reason;
} request;

static void load_once(void *context) {
  request *r = context;
  r->library->loaded = r->library->loaded || load(r->library);
  if (r->library->loaded)
    return;
  r->reason = dlerror();
  r->reason = r->reason ? r->reason : "a function of theirs is missing";
}

const char *km_library_load(km_library *library) {
  request r = {library, NULL};
  km_serially(load_once, &r);
  return r.reason;
}
