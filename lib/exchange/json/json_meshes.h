/* The meshes that the text of a model names. */
#ifndef KM_EXCHANGE_JSON_JSON_MESHES_H
#define KM_EXCHANGE_JSON_JSON_MESHES_H

#include "base/value.h"
#include "model/model.h"

/* The folders of `include_dir` (NULL: none), which live as long as it. */
void km_read_folders(const km_value *include_dir, km_arena *arena, km_folders *folders);
/* Every mesh in the tree takes its name as seen from the folder of `file` (NULL: they keep theirs). KM_MEMORY. */
km_status km_rename_meshes(km_value *tree, const km_folders *folders, const char *file, km_arena *arena,
                           km_error *error);

#endif
