/* The meshes that a model's bodies name. */
#ifndef KM_EXCHANGE_MESH_MODEL_MESHES_H
#define KM_EXCHANGE_MESH_MODEL_MESHES_H

#include "base/text.h"
#include "model/geometry/mesh.h"
#include "model/model.h"

/* Appends the path of a mesh file, searched in the file's folder and in include_dir. False if it isn't found, or
 * when out of memory (path->failed). */
bool km_find_mesh(const km_folders *folders, const char *name, km_text *path);
/* Reads the mesh with a name; errors name `part` (may be "") of the location `where`. KM_IO: it can't be found or
 * read; KM_MEMORY. The caller frees `*out`. */
km_status km_model_read_mesh(const km_model *model, const char *where, const char *part, const char *name,
                             km_mesh **out, km_error *error);
/* Reads the mesh that a body names. KM_IO: it can't be found or read. The caller frees `*out`. */
km_status km_body_mesh(const km_model *model, const km_model_body *body, km_mesh **out, km_error *error);

/* Appends hashes of all meshes of bodies and shapes to the text of an identity (base/store/store_file.h), on which
 * masses and clearances depend. A mesh that can't be read has an empty name there: what needs it reports the error.
 * KM_MEMORY. */
km_status km_model_identify_meshes(const km_model *model, km_text *out, km_error *error);

/* Mass properties of the bodies with a density, from their meshes; faults go to the messages. */
void km_model_weigh(km_model *model, km_messages *messages);
/* One warning of the meshes that aren't found: no error until something needs them. False when out of memory. */
bool km_model_miss_meshes(const km_model *model, km_messages *messages);

#endif
