/* MuJoCo's binary meshes. */
#ifndef KM_EXCHANGE_MESH_MSH_H
#define KM_EXCHANGE_MESH_MSH_H

#include "model/geometry/mesh.h"

/* Reads a file of MuJoCo's format, recognised by a header consistent with its size: four int32 (vertices, normals,
 * texture coordinates, faces), then float32 and the faces' int32. If there are no faces, the mesh is the convex hull
 * of its vertices. KM_OK with `*out` NULL: not such a file. The caller frees `*out`. KM_IO: the contents aren't a
 * mesh; KM_MEMORY. */
km_status km_msh_read(const char *path, km_mesh **out, km_error *error);

#endif
