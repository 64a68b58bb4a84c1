/* Convex parts of the bodies of a model, from their shapes and meshes. */
#ifndef KM_CLEARANCE_BODY_PARTS_H
#define KM_CLEARANCE_BODY_PARTS_H

#include "base/memory.h"
#include "clearance/convex.h"
#include "model/model.h"

typedef struct km_body_parts {
  km_convex *parts; /* [part] grouped by body */
  int *start;       /* [body_count + 1] first part of each body */
  double *error;    /* [body_count] largest distance of a hull from its mesh, model's length unit; 0 of other shapes */
} km_body_parts;

/* True if the body has a mesh or shapes. */
bool km_body_has_geometry(const km_model *model, int body);
/* Makes the parts of the bodies that `wanted` names: a box, sphere, cylinder or capsule is one; a mesh is the hulls of
 * its connected components. KM_IO: a mesh can't be found or read; KM_MEMORY. */
km_status km_body_parts_create(const km_model *model, const bool *wanted, km_arena *arena, km_body_parts *out,
                               km_error *error);

#endif
