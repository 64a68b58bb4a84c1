/* The folder of a model's file, and the names of its meshes in a file that is written to another one. */
#ifndef KM_EXCHANGE_MESH_MESH_FOLDERS_H
#define KM_EXCHANGE_MESH_MESH_FOLDERS_H

#include "base/memory.h"
#include "model/model.h"

/* The folder in which the files that a model names are looked for is that of `file`; NULL: the current one. Its name
 * lives in `arena`. False when out of memory. */
bool km_folders_create(km_folders *folders, const char *file, km_arena *arena);
/* The folder of the file that the model will be written to, without links, in `arena`; NULL: it is the model's own
 * one, or there is no such folder. `file` NULL, or "-": the model's own. KM_MEMORY. */
km_status km_find_destination(const km_folders *folders, const char *file, km_arena *arena, const char **destination,
                              km_error *error);
/* Path of a mesh as seen from the destination: relative, or absolute if only the root is common. The name is
 * unchanged without a destination, for an absolute name, or if the mesh isn't found. Allocated in `arena`; NULL when
 * out of memory. */
const char *km_written_mesh(const km_folders *folders, const char *destination, const char *name, km_arena *arena);

#endif
