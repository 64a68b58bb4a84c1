#include "base/file.h"

#include "base/memory.h"

#include <errno.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const size_t largest_file = (size_t)512 << 20; /* a device that never ends is no model */

static km_status read_all(FILE *file, const char *path, km_text *out, km_error *error) {
  char chunk[1 << 16];
  size_t size;
  errno = 0;
  while ((size = fread(chunk, 1, sizeof chunk, file)) > 0) {
    if (out->size + size > largest_file)
      return km_fail(error, KM_IO, "%s: is larger than %zu MiB; expected a model file", path, largest_file >> 20);
    km_text_bytes(out, chunk, size);
  }
  if (ferror(file))
    return km_fail(error, KM_IO, "%s: can't be read: %s", path, strerror(errno));
  km_text_bytes(out, "", 0);
  return out->failed ? km_fail(error, KM_MEMORY, "%s: out of memory", path) : KM_OK;
}

km_status km_file_read(const char *path, km_text *out, km_error *error) {
  if (strcmp(path, "-") == 0)
    return read_all(stdin, "standard input", out, error);
  FILE *file = fopen(path, "rb");
  if (!file)
    return km_fail(error, KM_IO, "%s: can't be opened: %s", path, strerror(errno));
  km_status status = read_all(file, path, out, error);
  fclose(file);
  return status;
}

static int write_all(FILE *file, const km_text *bytes) {
  int failed = bytes->size && fwrite(bytes->data, 1, bytes->size, file) != bytes->size;
  return fflush(file) != 0 || failed;
}

static km_status write_renamed(const char *path, char *temporary, const km_text *bytes, km_error *error) {
  int descriptor = mkstemp(temporary);
  if (descriptor < 0)
    return km_fail(error, KM_IO, "%s: can't be written: %s", path, strerror(errno));
  mode_t mask = umask(0);
  umask(mask);
  FILE *file = fdopen(descriptor, "wb");
  int failed = !file || fchmod(descriptor, 0666 & ~mask) != 0 || write_all(file, bytes);
  int reason = errno;
  if (file)
    fclose(file);
  else
    close(descriptor);
  if (!failed && rename(temporary, path) == 0)
    return KM_OK;
  if (!failed)
    reason = errno;
  unlink(temporary);
  return km_fail(error, KM_IO, "%s: can't be written: %s", path, strerror(reason));
}

km_status km_file_write(const char *path, const km_text *bytes, km_error *error) {
  if (bytes->failed)
    return km_fail(error, KM_MEMORY, "%s: out of memory", path);
  if (strcmp(path, "-") == 0)
    return write_all(stdout, bytes) ? km_fail(error, KM_IO, "standard output: can't be written: %s", strerror(errno))
                                    : KM_OK;
  struct stat info;
  if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
    FILE *file = fopen(path, "wb"); /* a device or a pipe can't be replaced by a rename */
    int failed = !file || write_all(file, bytes);
    int reason = errno;
    if (file)
      fclose(file);
    return failed ? km_fail(error, KM_IO, "%s: can't be written: %s", path, strerror(reason)) : KM_OK;
  }
  km_text temporary = {0};
  km_text_format(&temporary, "%s.XXXXXX", path);
  km_status status = temporary.failed ? km_fail(error, KM_MEMORY, "%s: out of memory", path)
                                      : write_renamed(path, temporary.data, bytes, error);
  km_text_free(&temporary);
  return status;
}

void km_sha256(const void *bytes, size_t size, char out[KM_SHA256_TEXT]) {
  SHA256Data(bytes, size, out);
}
