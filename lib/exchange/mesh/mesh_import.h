/* Meshes that assimp reads, in a process of its own (import/kmech_mesh.c). */
#ifndef KM_EXCHANGE_MESH_MESH_IMPORT_H
#define KM_EXCHANGE_MESH_MESH_IMPORT_H

#include "model/geometry/mesh.h"

/* Reads a PLY, OFF, OBJ, STL, glTF, COLLADA or 3DS file, identified by its extension, within 4 s and 800 MB of the
 * child process. Vertices and triangles are those of the file, not welded; every vertex is finite, every corner a
 * valid index. The caller frees `*out`. Thread-safe. KM_IO: a damaged, too large or unsupported file, or a process
 * that fails; KM_MEMORY. */
km_status km_mesh_import(const char *path, km_mesh **out, km_error *error);

#endif
