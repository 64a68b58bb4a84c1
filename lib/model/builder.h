/* A model that is being built by calls. Private to model/. */
#ifndef KM_MODEL_BUILDER_H
#define KM_MODEL_BUILDER_H

#include "model/validation.h"

struct km_builder {
  km_model *model;
  km_names assemblies, bodies, frames, joints; /* scope: the parent */
  size_t assembly_room, body_room, frame_room, shape_room, joint_room, coordinate_room, coupling_room, module_room,
      load_room, hold_room, pose_room, actuator_room;
};

/* Grows one of the model's arrays by an element of zeros; NULL when out of memory. */
#define KM_BUILDER_GROW(builder, array, room, count)                                                                   \
  km_arena_grow(&(builder)->model->arena, (void **)&(builder)->model->array, &(builder)->room,                         \
                (size_t)((builder)->model->count) + 1, sizeof *(builder)->model->array)

km_status km_builder_memory(km_error *error);
/* A copy of a name that is not empty, not reserved and new in its scope. */
km_status km_builder_name(km_builder *builder, const char *kind, const char *name, const km_names *names, int scope,
                          const char *reserved, const char **out, km_error *error);
/* The index of an element from its id; false (with the error filled) if there is no such element. */
bool km_builder_frame(const km_builder *builder, km_frame_id id, const char *who, int *out, km_error *error);
bool km_builder_coordinate(const km_builder *builder, km_coordinate_ref ref, const char *who, int *out,
                           km_error *error);
/* The assembly of a definition: none is the first one, which is made where there is none. */
km_status km_builder_assembly(km_builder *builder, km_assembly_id id, int *out, km_error *error);
/* Copies numbers into the model; NULL where count is 0 or memory is out (then arena.failed is set). */
double *km_builder_numbers(km_builder *builder, const double *values, size_t count);
/* Are all of them finite and of magnitude up to 1e60, as in a file? */
bool km_builder_sane(const double *values, size_t count);

#endif
