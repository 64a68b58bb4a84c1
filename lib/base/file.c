/* Reads files, and writes them atomically. */
#include "base/file.h"

#include "base/arguments.h"

#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <sha256.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const size_t largest_file = (size_t)512 << 20; /* an endless device isn't a model */

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
  if (!path || !out)
    return km_check_given(false, path ? "place for the bytes" : "path of a file", error);
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

static km_status cannot_write(const char *path, int reason, km_error *error) {
  return km_fail(error, KM_IO, "%s: can't be written: %s", path, strerror(reason));
}

/* Writes in place: a device, a pipe or a dangling link can't be replaced by a rename. */
static km_status write_in_place(const char *path, const km_text *bytes, km_error *error) {
  FILE *file = fopen(path, "wb");
  int failed = !file || write_all(file, bytes), reason = errno;
  if (file)
    fclose(file);
  return failed ? cannot_write(path, reason, error) : KM_OK;
}

/* A new file before its rename. Where the system supports it the file has no name until it is complete, so that an
 * interruption leaves nothing. Otherwise it has the name `temporary`. */
typedef struct draft {
  char *temporary; /* a template of mkstemp */
  int descriptor;
  bool named;
} draft;

/* Writes the folder of a path. */
static void folder_of(const char *path, km_text *out) {
  const char *slash = strrchr(path, '/');
  if (slash)
    km_text_bytes(out, path, (size_t)(slash - path) + 1);
  else
    km_text_add(out, ".");
}

static bool open_draft(draft *d, const char *path, mode_t mode) {
  km_text folder = {0};
  folder_of(path, &folder);
  d->descriptor = folder.failed ? -1 : open(folder.data, O_TMPFILE | O_WRONLY | O_CLOEXEC, mode);
  km_text_free(&folder);
  if (d->descriptor >= 0)
    return true;
  d->named = true;
  d->descriptor = mkstemp(d->temporary);
  return d->descriptor >= 0 && fchmod(d->descriptor, mode) == 0;
}

/* Links an unnamed draft to the temporary name. */
static bool name_draft(draft *d) {
  char own[64];
  int free_name = mkstemp(d->temporary);
  if (free_name < 0)
    return false;
  close(free_name);
  snprintf(own, sizeof own, "/proc/self/fd/%d", d->descriptor);
  unlink(d->temporary);
  d->named = linkat(AT_FDCWD, own, AT_FDCWD, d->temporary, AT_SYMLINK_FOLLOW) == 0;
  return d->named;
}

/* Mode of the new file: that of the old file, or the default under the process's mask. */
static mode_t mode_of(const struct stat *old, bool exists) {
  mode_t mask = umask(0);
  umask(mask);
  return exists ? old->st_mode & 07777 : 0666 & ~mask;
}

static bool write_draft(draft *d, const char *path, const km_text *bytes, mode_t mode) {
  if (!open_draft(d, path, mode))
    return false;
  FILE *file = fdopen(dup(d->descriptor), "wb");
  bool written = file && write_all(file, bytes) == 0;
  int reason = errno;
  if (file)
    fclose(file);
  errno = reason;
  return written && fchmod(d->descriptor, mode) == 0 && (d->named || name_draft(d)) && rename(d->temporary, path) == 0;
}

/* Signals are blocked while a temporary file has a name, so that an interruption doesn't leave it. */
static km_status replace(const char *path, const km_text *bytes, mode_t mode, km_error *error) {
  km_text name = {0};
  sigset_t all, before;
  km_text_format(&name, "%s.XXXXXX", path);
  if (name.failed)
    return km_fail(error, KM_MEMORY, "%s: out of memory", path);
  draft d = {.temporary = name.data, .descriptor = -1};
  sigfillset(&all);
  sigprocmask(SIG_BLOCK, &all, &before);
  bool done = write_draft(&d, path, bytes, mode);
  int reason = errno;
  if (d.descriptor >= 0)
    close(d.descriptor);
  if (!done && d.named)
    unlink(d.temporary);
  sigprocmask(SIG_SETMASK, &before, NULL);
  km_text_free(&name);
  return done ? KM_OK : cannot_write(path, reason, error);
}

km_status km_file_write(const char *path, const km_text *bytes, km_error *error) {
  if (!path || !bytes)
    return km_check_given(false, path ? "text" : "path of a file", error);
  if (bytes->failed)
    return km_fail(error, KM_MEMORY, "%s: out of memory", path);
  if (strcmp(path, "-") == 0)
    return write_all(stdout, bytes) ? km_fail(error, KM_IO, "standard output: can't be written: %s", strerror(errno))
                                    : KM_OK;
  struct stat info, link;
  bool exists = stat(path, &info) == 0, linked = lstat(path, &link) == 0 && S_ISLNK(link.st_mode);
  if ((exists && !S_ISREG(info.st_mode)) || (linked && !exists))
    return write_in_place(path, bytes, error);
  if (exists && access(path, W_OK) != 0)
    return cannot_write(path, errno, error);
  char *target = linked ? realpath(path, NULL) : NULL; /* the link is kept, its target is replaced */
  km_status status = replace(target ? target : path, bytes, mode_of(&info, exists), error);
  free(target);
  return status;
}

void km_sha256(const void *bytes, size_t size, char out[KM_SHA256_TEXT]) {
  SHA256Data(bytes, size, out);
}
