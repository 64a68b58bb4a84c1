/* Shapes of bodies as meshes and as solids. */
#ifndef KM_EXCHANGE_MESH_SHAPE_MESHES_H
#define KM_EXCHANGE_MESH_SHAPE_MESHES_H

#include "exchange/mesh/model_meshes.h"
#include "model/geometry/solids.h"

/* A shape's surface in its body's frame; round ones as polyhedra, for pictures. The caller frees `*out`. KM_IO: its
 * file can't be found or read; KM_MEMORY. */
km_status km_shape_mesh(const km_model *model, const km_model_shape *shape, km_mesh **out, km_error *error);
/* A plain shape of density 1, exactly; false: it is a mesh. */
bool km_shape_solid(const km_model_shape *shape, km_mass *out);
/* Adds a mesh to another one (NULL: none yet), and takes it over. KM_MEMORY. */
km_status km_mesh_join(km_mesh **sum, km_mesh *part, km_error *error);

#endif
