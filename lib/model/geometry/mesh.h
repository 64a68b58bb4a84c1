/* A body's surface as triangles. */
#ifndef KM_MODEL_GEOMETRY_MESH_H
#define KM_MODEL_GEOMETRY_MESH_H

#include "kmech/base.h"
#include "spatial/vec3.h"

#include <stdbool.h>

typedef struct km_triangle {
  int corner[3];  /* vertices, counter-clockwise seen from outside */
  unsigned color; /* 0x1RRGGBB; 0: none is stated */
} km_triangle;

typedef struct km_mesh {
  int vertex_count, triangle_count;
  km_vec3 *vertices; /* [vertex_count] in the body's frame and the model's length unit */
  km_triangle *triangles;
} km_mesh;

/* The meshes of a model's bodies, by body; NULL where one has none. */
struct km_meshes {
  int count;
  km_mesh *items[];
};

/* Room for so many vertices and triangles, all zero. The caller frees it; NULL when out of memory. */
km_mesh *km_mesh_create(int vertex_count, int triangle_count);
void km_mesh_free(km_mesh *mesh);

/* Corners of the smallest box along the axes; both 0 for a mesh without vertices. */
void km_mesh_box(const km_mesh *mesh, km_vec3 *low, km_vec3 *high);

/* Stretches it along the axes; where that is a mirror, its faces are turned round and look outwards again. */
void km_mesh_scale(km_mesh *mesh, const double by[3]);

/* Makes one vertex of those that lie within a millionth of the mesh's size of each other, and drops triangles
 * that are left without area between three vertices: files repeat a vertex for each of its normals, and round.
 * False when out of memory. */
bool km_mesh_weld(km_mesh *mesh);

/* Reads an OBJ, STL, PLY, OFF, COLLADA, glTF or 3DS file, or one of MuJoCo's own, all of its parts where the file's scene puts them, welded.
 * Coordinates that assimp reads are rounded to single precision; those of plain OBJ and STL texts aren't. assimp runs in
 * a process of its own (exchange/mesh/mesh_import.h): a damaged file ends that one. The caller frees `*out`. KM_IO with the
 * file's name and the reason: it can't be read, has more than 2000000 triangles or 256 MB, or takes longer than 4 s. */
km_status km_mesh_read(const char *path, km_mesh **out, km_error *error);

#endif
