/* Triangle meshes of bodies' surfaces. */
#ifndef KM_MODEL_GEOMETRY_MESH_H
#define KM_MODEL_GEOMETRY_MESH_H

#include "kmech/base.h"
#include "spatial/vec3.h"

#include <stdbool.h>

typedef struct km_triangle {
  int corner[3];  /* vertices, counter-clockwise seen from outside */
  unsigned color; /* colour 0x1RRGGBB; 0: not stated */
} km_triangle;

typedef struct km_mesh {
  int vertex_count, triangle_count;
  km_vec3 *vertices; /* [vertex_count] in the body's frame and the model's length unit */
  km_triangle *triangles;
} km_mesh;

/* Meshes of a model's bodies, by body; NULL if a body has none. */
struct km_meshes {
  int count;
  km_mesh *items[];
};

/* Allocates a mesh of zeros. The caller frees it. NULL when out of memory. */
km_mesh *km_mesh_create(int vertex_count, int triangle_count);
void km_mesh_free(km_mesh *mesh);

/* Corners of the bounding box along the axes; 0 for a mesh without vertices. */
void km_mesh_box(const km_mesh *mesh, km_vec3 *low, km_vec3 *high);

/* Scales the mesh along the axes. Faces are reversed if the scaling is a reflection. */
void km_mesh_scale(km_mesh *mesh, const double by[3]);

/* Welds the mesh: merges vertices within 1e-6 of the mesh's size, and removes triangles that thereby have fewer than
 * three vertices. Files repeat a vertex for each normal and round coordinates. False when out of memory. */
bool km_mesh_weld(km_mesh *mesh);

/* Reads and welds a mesh from an OBJ, STL, PLY, OFF, COLLADA, glTF, 3DS or MuJoCo msh file, with all parts at their
 * places in the file's scene. Coordinates are in single precision, except from plain OBJ and STL texts. assimp runs
 * in a process of its own (exchange/mesh/mesh_import.h), so that a damaged file ends that process only. The caller
 * frees `*out`. KM_IO with the file's name and the reason: it can't be read, has more than 2000000 triangles or 256
 * MB, or takes longer than 4 s. */
km_status km_mesh_read(const char *path, km_mesh **out, km_error *error);

#endif
