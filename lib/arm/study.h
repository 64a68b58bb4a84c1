/* A path study: what the user wrote of a path, a start and the methods to compare (model-format.md). */
#ifndef KM_ARM_STUDY_H
#define KM_ARM_STUDY_H

#include "arm/path.h"
#include "base/text.h"
#include "base/value.h"
#include "exchange/json/format.h"
#include "exchange/json/reader.h"
#include "kmech/path_study.h"

/* What replaces a study's members, as values; `place` is how messages call them ("--q"). NULL: nothing. */
typedef struct km_study_change {
  const km_value *value;
  const char *place;
} km_study_change;

typedef struct km_study_changes {
  int effector; /* frame of the model, −1: the study's */
  km_study_change q0, path, task, methods, objective, rates;
  bool path_optional;      /* without one the start is the pose itself, and there is no path */
  const char *path_folder; /* where files that the new path names are looked for */
} km_study_changes;

struct km_study {
  km_arena arena;
  const km_value *root;
  const char *folder; /* of the file */
  km_arm *arm;
  km_path *path;
  int effector;
  km_task task;
  double *start;      /* [n] model's units, base first: reaches the first pose; NaN where none does */
  double start_moved; /* how far the start is from what was given (inverse kinematics), largest coordinate */
  km_status start_status;
  km_error start_error;
  km_method *methods;
  int method_count;
  km_objective objective;
};

km_status km_study_bind_as(km_study *study, const km_mechanism *mechanism, const km_state *state,
                           const km_study_changes *changes, unsigned long seed, km_messages *messages, km_error *error);

/* The parts of the reader. What is wrong goes to the reader's messages. */
extern const km_object_format km_format_study, km_format_path, km_format_method;
/* The frame of an `effector`: a list of names, or a text "body/frame". */
bool km_effector_find(const km_model *model, const km_value *value, km_arena *arena, int *frame, km_error *error);
/* The path of a `path` object; `here` is the effector's pose at q0 (arm's units). NULL if something is wrong. */
km_path *km_path_read(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                      const km_pose *here, const char *folder);
/* Poses of a CSV file: *poses[count], and *times[count] or NULL; in `arena`. The count, 0 if something is wrong. */
int km_poses_read(km_reader *reader, const km_arm *arm, const char *file, const km_place *place, km_arena *arena,
                  km_pose **poses, double **times);
/* Methods as a name, an object, or a list of them. False if something is wrong. */
bool km_methods_read(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                     km_arena *arena, km_method **methods, int *count);
/* Has a method a setting of that name; and which methods have ("dp, global"; nothing: it is no setting)? */
bool km_method_has(km_method_kind kind, const char *key);
void km_method_owners(const char *key, km_text *out);
bool km_objective_read(km_reader *reader, const km_value *value, const km_place *place, km_objective *out);

#endif
