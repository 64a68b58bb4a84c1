/* The folder of a model's file, and the names of its meshes as seen from the folder that it is written to. */
#include "exchange/mesh/mesh_folders.h"

#include "exchange/mesh/model_meshes.h"

#include <stdlib.h>
#include <string.h>

bool km_folders_create(km_folders *folders, const char *file, km_arena *arena) {
  const char *slash = file ? strrchr(file, '/') : NULL;
  folders->folder = ".";
  if (!slash)
    return true;
  char *folder = km_arena_string(arena, file);
  if (folder)
    folder[slash == file ? 1 : slash - file] = '\0';
  folders->folder = folder;
  return folder != NULL;
}

static bool is_folder_itself(const km_folders *folders, const char *destination) {
  char *own = realpath(folders->folder, NULL);
  bool same = own && strcmp(own, destination) == 0;
  free(own);
  return same;
}

km_status km_find_destination(const km_folders *folders, const char *file, km_arena *arena, const char **destination,
                              km_error *error) {
  km_folders other;
  *destination = NULL;
  if (!file || strcmp(file, "-") == 0)
    return KM_OK;
  char *there = km_folders_create(&other, file, arena) ? realpath(other.folder, NULL) : NULL;
  if (there && !is_folder_itself(folders, there))
    *destination = km_arena_string(arena, there);
  free(there);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory for the folder of a model") : KM_OK;
}

/* Length of the common folders of two absolute paths, with the last slash. */
static size_t common_folders(const char *a, const char *b) {
  size_t end = 0;
  for (size_t i = 0; a[i] && a[i] == b[i]; ++i)
    if (a[i] == '/')
      end = i + 1;
  return end;
}

static const char *between(const char *destination, const char *path, km_arena *arena) {
  km_text from = {0}, name = {0};
  km_text_format(&from, "%s/", destination); /* the root is never a destination with something in common */
  size_t shared = from.failed ? 0 : common_folders(from.data, path);
  for (const char *c = from.failed ? "" : from.data + shared; *c && shared > 1; ++c)
    if (*c == '/')
      km_text_add(&name, "../");
  km_text_add(&name, shared > 1 ? path + shared : path);
  arena->failed = arena->failed || from.failed || name.failed;
  const char *out = arena->failed ? NULL : km_arena_string(arena, name.data);
  km_text_free(&from);
  km_text_free(&name);
  return out;
}

const char *km_written_mesh(const km_folders *folders, const char *destination, const char *name, km_arena *arena) {
  km_text found = {0};
  if (!destination || name[0] == '/' || name[0] == '\0')
    return name;
  char *path = km_find_mesh(folders, name, &found) ? realpath(found.data, NULL) : NULL;
  const char *out = path ? between(destination, path, arena) : name;
  arena->failed = arena->failed || found.failed;
  free(path);
  km_text_free(&found);
  return out;
}
