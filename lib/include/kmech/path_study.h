/* Path studies: a model, an effector, a path, a start and methods, as a definition that a file or a program fills, and
 * bound to a mechanism. */
#ifndef KMECH_PATH_STUDY_H
#define KMECH_PATH_STUDY_H

#include "kmech/track.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How messages name a part of a study, and whose it is. */
typedef struct km_study_place {
  const char *text; /* what a message about the part begins with: "q0", "--q" */
  bool option;      /* of the command, not of the file: km_study_read keeps the part, and its faults are KM_USAGE */
} km_study_place;

/* Names, and whose they are. */
typedef struct km_study_names {
  const char *const *items; /* [count] */
  int count;                /* 0: not given */
  km_study_place place;     /* for messages */
} km_study_names;

/* Numbers, and whose they are. */
typedef struct km_study_numbers {
  const double *items;  /* NULL: not given */
  int count;            /* 0: not given */
  km_study_place place; /* for messages */
} km_study_numbers;

/* The path, in the model's units throughout: angles of arcs and the turn speed, too, are in its angle unit. */
typedef struct km_study_path {
  km_path_plan plan;     /* no segments: there is no path */
  bool start_p, start_R; /* parts of the plan's start that count; else those of the effector at q0 */
  const double *turns;   /* [3 × points of the one segment] rotation vectors instead of R, NULL: none */
  const char *file;      /* from which the poses are, NULL: none; */
  const int *lines;      /* [points of the one segment] where in it */
  km_study_place place;  /* for messages */
} km_study_path;

/* A method that a study asks for. */
typedef struct km_study_method {
  km_method method;      /* its joints are found when the study is bound, */
  km_study_names joints; /* by these labels */
} km_study_method;

/* What a study asks for. Start from km_study_def_default(). All that it points to is borrowed, but for `memory`. */
typedef struct km_study_def {
  const char *model;          /* the model's file, seen from the study's folder; NULL: none is named */
  km_study_names effector;    /* the frame that follows the path: its path's names, or "body/frame" alone */
  int frame;                  /* the same by its index in the model; -1: by its names */
  km_study_names coordinates; /* order of q0 and rates by labels; none: from the base out */
  km_study_numbers q0;        /* where to start, in the model's units; none: at the state's pose */
  km_study_numbers
      rates;    /* largest joint speeds (km_arm_set_rates); none: the drives' max_rate, if the path has a speed */
  km_task task; /* what must follow the path */
  km_study_place task_place;      /* for messages */
  km_study_path path;             /* what it follows */
  bool path_optional;             /* without a path the start is q0 itself; else it is missing */
  const km_study_method *methods; /* [method_count] each gives a track */
  int method_count;               /* 0: greedy */
  km_study_place methods_place;   /* for messages */
  km_objective objective;         /* path-control */
  km_study_place objective_place; /* for messages */
  struct km_arena *memory;        /* of what was read, NULL: none */
} km_study_def;
KM_API km_study_def km_study_def_default(void);

/* Reads a study from `size` bytes of JSON into a definition that is the default but for parts of the command, which
 * stay; `folder` is that of the file ("" the current one), where poses in a CSV file are looked for. Findings go to
 * `messages` with their place. KM_MODEL: something in the text is wrong; KM_IO: a file of poses can't be read;
 * KM_MEMORY. The definition is to be freed in any case. */
KM_API km_status km_study_read(const char *bytes, size_t size, const char *folder, km_messages *messages,
                               km_study_def *def, km_error *error);
/* The path alone, of the text of a study or of a path, seen from its `folder`; and that of a CSV file of poses. `place` is how messages are to
 * name it, and stays in the definition; statuses as above, KM_USAGE for those of an option. */
KM_API km_status km_study_read_path(const char *bytes, size_t size, const char *folder, km_study_place place,
                                    km_messages *messages, km_study_def *def, km_error *error);
KM_API km_status km_study_read_poses(const char *file, km_study_place place, km_messages *messages, km_study_def *def,
                                     km_error *error);
KM_API void km_study_def_free(km_study_def *def);

/* A study that is bound to a mechanism. */
typedef struct km_study km_study;

/* Makes arm, path, start and methods from a definition and a mechanism of its model at its pose. The start is q0, or else
 * the state's pose, brought to the path's first pose by inverse kinematics where it isn't there. KM_MODEL, KM_USAGE:
 * something in the definition, or in an option, is wrong; KM_NO_RESULT: no start within the limits reaches the first
 * pose, `*out` is then the study without one, whose tracks end where they begin; KM_DIVERGED; KM_MEMORY. The mechanism
 * must outlive the study, the definition need not. The caller frees `*out`. */
KM_API km_status km_study_bind(const km_mechanism *mechanism, const km_state *state, const km_study_def *def,
                               unsigned long seed, km_messages *messages, km_study **out, km_error *error);
KM_API void km_study_free(km_study *study);

/* Its arm. Borrowed. */
KM_API const km_arm *km_study_arm(const km_study *study);
/* Its path; NULL: it has none. Borrowed. */
KM_API const km_path *km_study_bound_path(const km_study *study);
/* Where its tracks start: q[n] in the model's units, base first; and `moved`, by how much inverse kinematics moved the
 * largest coordinate from what was given, in radians, slides over L. Either may be NULL. KM_NO_RESULT: no start within the
 * limits reaches the path's first pose, and neither is set. */
KM_API km_status km_study_start(const km_study *study, double *q, double *moved, km_error *error);
/* The plan of method i: path, start, method, objective; jobs 1, seed 1. */
KM_API km_track_plan km_study_plan(const km_study *study, int method);
/* The number of its methods. */
KM_API int km_study_methods(const km_study *study);

#ifdef __cplusplus
}
#endif
#endif
