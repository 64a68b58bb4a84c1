/* A drawing that is being written. Private to exchange/json. */
#ifndef KM_EXCHANGE_JSON_WRITE_DRAWING_TREE_H
#define KM_EXCHANGE_JSON_WRITE_DRAWING_TREE_H

#include "exchange/json/format/format.h"
#include "exchange/json/read/reader.h"

typedef struct km_sketch {
  const km_model *model; /* model with frames, in the drawn configuration */
  km_pose *stand;        /* [body] in the inertial frame, in that pose */
  bool *drawn;           /* [assembly] */
  bool *pointed;         /* [joint] defined by a point */
  bool *needed;          /* [frame] named by something else than a joint that is pointed */
  const char **own;      /* [body] new frame at the former position of the body's own frame; NULL: none is needed */
  double grain;          /* rounding unit of points' coordinates */
  km_arena *arena;
} km_sketch;

/* True if the body is in a drawing, or is the inertial frame. */
bool km_sketch_has_body(const km_sketch *sketch, int body);
/* True if the body's frame coincides with the inertial frame, so that its elements don't change. */
bool km_sketch_stays(const km_sketch *sketch, int body);
/* The parent frame of a joint in the inertial frame. */
km_pose km_sketch_joint_pose(const km_sketch *sketch, int joint);
/* True if a point and an axis define the joint. */
bool km_sketch_can_point(const km_sketch *sketch, int joint);

/* The frame that a path names, seen from an assembly; -1: none that is in the model. */
int km_sketch_frame(const km_sketch *sketch, int assembly, const km_value *path);
/* Calls `found` for every path to a frame inside an object of the model, with the frame. */
typedef void (*km_sketch_path)(km_sketch *sketch, int frame);
void km_sketch_each_path(km_sketch *sketch, const km_value *root, km_sketch_path found);
/* Adds the path, to the new frame where it named a drawn body's own one. */
void km_sketch_write_path(const km_sketch *sketch, int assembly, const km_value *path, km_value *parent,
                          const char *key);
/* Adds the names of the assemblies from the root down to one. */
void km_sketch_write_assemblies(const km_sketch *sketch, int assembly, km_value *path);
/* True if the field holds one or two paths to frames. */
bool km_names_frame(const km_field *field);
bool km_names_frames(const km_field *field);

/* The assembly of that object in the one around it. */
int km_sketch_assembly(const km_sketch *sketch, int around, const km_value *object);

/* A copy of a value under a key. */
void km_sketch_copy(const km_sketch *sketch, const km_value *value, km_value *parent, const char *key);
/* A drawn body, and the inertial frame as body 0; a joint by its point. */
void km_sketch_body(const km_sketch *sketch, int body, const km_value *object, km_value *parent, const char *key);
void km_sketch_joint(const km_sketch *sketch, int joint, const km_value *object, km_value *parent);

#endif
