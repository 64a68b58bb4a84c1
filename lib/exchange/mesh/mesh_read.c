/* Reads a mesh by the reader for its contents or extension. */
#include "exchange/mesh/import/stream.h"
#include "exchange/mesh/mesh_import.h"
#include "exchange/mesh/msh.h"
#include "exchange/mesh/plain_meshes.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

static const long long size_limit = 256LL << 20; /* bytes: the file is read whole into memory */

/* A pipe would block its reader, and a device never ends. */
static km_status check_file(const char *path, km_error *error) {
  struct stat found;
  if (stat(path, &found))
    return km_fail(error, KM_IO, "%s: %s", path, strerror(errno));
  if (!S_ISREG(found.st_mode))
    return km_fail(error, KM_IO, "%s: isn't a file", path);
  if (found.st_size > size_limit)
    return km_fail(error, KM_IO, "%s: has %lld bytes; expected at most %lld", path, (long long)found.st_size,
                   size_limit);
  return KM_OK;
}

km_status km_mesh_read(const char *path, km_mesh **out, km_error *error) {
  *out = NULL;
  km_status status = check_file(path, error);
  if (!status)
    status = km_msh_read(path, out, error);
  if (!status && !*out)
    status = km_plain_mesh_read(path, out, error);
  if (!status && !*out)
    status = km_mesh_import(path, out, error);
  if (!status && !km_mesh_weld(*out)) {
    km_mesh_free(*out);
    *out = NULL;
    status = km_fail(error, KM_MEMORY, "%s: out of memory", path);
  }
  return status;
}
