/* Meshes that assimp reads, in a process of its own (import/kmech_mesh.c). */
#ifndef KM_EXCHANGE_MESH_MESH_IMPORT_H
#define KM_EXCHANGE_MESH_MESH_IMPORT_H

#include "model/geometry/mesh.h"

/* Reads a PLY, OFF, OBJ, STL, glTF, COLLADA or 3DS file, told by its ending, within 4 s and 800 MB of the other
 * process. Vertices and triangles are as the file has them, not welded; every vertex is finite, every corner a
 * vertex. The caller frees `*out`. Any number of threads may call it. KM_IO for a file that is damaged, too large or
 * of another format, and for a process that ends otherwise; KM_MEMORY. */
km_status km_mesh_import(const char *path, km_mesh **out, km_error *error);

#endif
