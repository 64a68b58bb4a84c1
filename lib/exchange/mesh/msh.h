/* MuJoCo's binary meshes. */
#ifndef KM_EXCHANGE_MESH_MSH_H
#define KM_EXCHANGE_MESH_MSH_H

#include "model/geometry/mesh.h"

/* Reads a file of MuJoCo's own format, told by a header that fits its size: four int32 (vertices, normals, texture
 * coordinates, faces), then float32 and the faces' int32. Without faces it is the convex hull of its vertices. KM_OK
 * with `*out` NULL: it isn't such a file. The caller frees `*out`. KM_IO: its contents can't be a mesh; KM_MEMORY. */
km_status km_msh_read(const char *path, km_mesh **out, km_error *error);

#endif
