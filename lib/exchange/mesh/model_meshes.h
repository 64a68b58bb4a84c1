/* The meshes that a model's bodies name. */
#ifndef KM_EXCHANGE_MESH_MODEL_MESHES_H
#define KM_EXCHANGE_MESH_MODEL_MESHES_H

#include "base/text.h"
#include "model/geometry/mesh.h"
#include "model/model.h"

/* Appends the path at which a mesh file is found: in the file's folder or one of include_dir. False if nowhere, or,
 * with path->failed, for want of memory. */
bool km_find_mesh(const km_folders *folders, const char *name, km_text *path);
/* Reads the mesh of a name; faults are told of `part` (may be "") of the place `where`. KM_IO: it can't be found or
 * read; KM_MEMORY. The caller frees `*out`. */
km_status km_model_read_mesh(const km_model *model, const char *where, const char *part, const char *name,
                             km_mesh **out, km_error *error);
/* Reads the mesh that a body names. KM_IO: it can't be found or read. The caller frees `*out`. */
km_status km_body_mesh(const km_model *model, const km_model_body *body, km_mesh **out, km_error *error);

/* Mass properties of the bodies with a density, from their meshes; faults go to the messages. */
void km_model_weigh(km_model *model, km_messages *messages);
/* One warning of the meshes that aren't found: no error until something needs them. False when out of memory. */
bool km_model_miss_meshes(const km_model *model, km_messages *messages);

#endif
