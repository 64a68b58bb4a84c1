/* Where a model's text says that its meshes are, and their names in a text that is written elsewhere. */
#include "exchange/json/json_meshes.h"

#include "exchange/mesh/mesh_folders.h"

#include <string.h>

void km_read_folders(const km_value *dirs, km_arena *arena, km_folders *folders) {
  folders->include_dirs = KM_ARENA_NEW(arena, const char *, dirs ? dirs->count + 1 : 0);
  if (arena->failed || !dirs)
    return;
  if (dirs->kind == KM_STRING)
    folders->include_dirs[folders->include_dir_count++] = dirs->string;
  for (const km_value *d = dirs->kind == KM_LIST ? dirs->first : NULL; d; d = d->next)
    folders->include_dirs[folders->include_dir_count++] = d->string;
}

typedef struct renamer {
  const km_folders *folders;
  const char *destination;
  km_arena *arena;
} renamer;

static void rename_mesh(const renamer *r, km_value *value) {
  if (value->kind == KM_STRING)
    value->string = km_written_mesh(r->folders, r->destination, value->string, r->arena);
}

/* A body's definition is a name or a list of one. */
static bool names_mesh(const km_value *value) {
  return value->key && (strcmp(value->key, "mesh") == 0 || strcmp(value->key, "definition") == 0);
}

static void rename_all(const renamer *r, km_value *value) {
  bool named = names_mesh(value);
  if (named)
    rename_mesh(r, value);
  for (km_value *v = value->first; v && !r->arena->failed; v = v->next)
    if (named)
      rename_mesh(r, v);
    else
      rename_all(r, v);
}

km_status km_rename_meshes(km_value *tree, const km_folders *folders, const char *file, km_arena *arena,
                           km_error *error) {
  renamer r = {.folders = folders, .arena = arena};
  km_status status = km_find_destination(folders, file, arena, &r.destination, error);
  if (!status && r.destination)
    rename_all(&r, tree);
  return status || !arena->failed ? status : km_fail(error, KM_MEMORY, "out of memory for the names of meshes");
}
