/* Builder of models. Private to model/. */
#ifndef KM_MODEL_BUILDER_H
#define KM_MODEL_BUILDER_H

#include "model/validation.h"

struct km_builder {
  km_model *model;
  km_names assemblies, bodies, frames, joints; /* names of assemblies, scoped by parent */
  size_t assembly_room, body_room, frame_room, shape_room, joint_room, coordinate_room, coupling_room, module_room,
      load_room, hold_room, pose_room, actuator_room;
};

/* Appends a zeroed element to an array of the model. NULL when out of memory. */
#define KM_BUILDER_GROW(builder, array, room, count)                                                                   \
  km_arena_grow(&(builder)->model->arena, (void **)&(builder)->model->array, &(builder)->room,                         \
                (size_t)((builder)->model->count) + 1, sizeof *(builder)->model->array)

km_status km_builder_memory(km_error *error);
/* Checks that a name isn't empty, reserved or used in its scope, and copies it. */
km_status km_builder_name(km_builder *builder, const char *kind, const char *name, const km_names *names, int scope,
                          const char *reserved, const char **out, km_error *error);
/* Index of an element from its id. False, with the error filled, if the id is invalid. */
bool km_builder_frame(const km_builder *builder, km_frame_id id, const char *who, int *out, km_error *error);
bool km_builder_coordinate(const km_builder *builder, km_coordinate_ref ref, const char *who, int *out,
                           km_error *error);
/* Assembly of a definition; the default is the first assembly, which is created if necessary. */
km_status km_builder_assembly(km_builder *builder, km_assembly_id id, int *out, km_error *error);
/* Copies numbers into the model. NULL if count is 0 or when out of memory (arena.failed is then set). */
double *km_builder_numbers(km_builder *builder, const double *values, size_t count);
/* True if all numbers are finite and at most 1e60 in magnitude, as in files. */
bool km_builder_sane(const double *values, size_t count);

#endif
