/* Redundant serial arms: arms, path-control columns, paths, tracking methods, path studies, self-motions, inverse
 * kinematics. */
#ifndef KMECH_ARM_H
#define KMECH_ARM_H

#include "kmech/base.h"
#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A serial arm in a mechanism: the chain of joints from the inertial frame to an effector frame. */

/* A serial arm, cut out of a mechanism. Immutable except for km_arm_set_rates. */
typedef struct km_arm km_arm;

/* Rows of the effector's motion that follow a path (docs/theory.md 12.1). */
typedef enum km_task {
  KM_TASK_POSE,     /* position and rotation: 6 rows */
  KM_TASK_POSITION, /* the origin: 3 rows */
  KM_TASK_AXIS      /* the origin and the direction of the z axis: 5 rows */
} km_task;

/* Creates the arm from the inertial frame to `effector` (a frame of the model). Joints can be reversed; held joints
 * are rigid at the state's values; other branches of the model have no effect. Lengths are scaled by L, the model's
 * characteristic length if stated, else one metre. KM_USAGE: a joint of the chain lies in a loop or a coupling or is
 * a ball, or there are fewer coordinates than rows of the task that the motions can change. The mechanism must
 * outlive the arm. The caller frees `*out`. */
KM_API km_status km_arm_create(const km_mechanism *mechanism, const km_state *state, int effector, km_task task,
                               km_arm **out, km_error *error);
KM_API void km_arm_free(km_arm *arm);
/* Sets the pairs of bodies, of the arm with itself and with obstacles, whose least clearance is the objective
 * KM_BODY_CLEARANCE. Other coordinates than the arm's stay as in `state`. The clearance must outlive the arm.
 * KM_USAGE, KM_MEMORY. Not while another thread uses the arm. */
KM_API km_status km_arm_set_clearance(km_arm *arm, const km_state *state, const km_clearance *clearance,
                                      km_error *error);

/* Number of coordinates n; 0 without an arm. */
KM_API int km_arm_coordinates(const km_arm *arm);
KM_API int km_arm_coordinate(const km_arm *arm, int column); /* coordinate of the mechanism for a column, base first */
KM_API double km_arm_length(const km_arm *arm);              /* L, in the model's length unit */

KM_API int km_arm_rows(const km_arm *arm); /* rows of the task: 6, 5 or 3 */
/* Number of spare freedoms: coordinates minus rows that the motions can change, which are fewer than the task's for
 * a planar arm, for example; 0 without an arm. */
KM_API int km_arm_freedom(const km_arm *arm);

/* Effector kinematics at q[n] (model's units, base first): km_arm_place computes the pose in the inertial frame,
 * km_arm_jacobian the Jacobian J[rows × n], column-major. Its rows are v of the effector's origin in inertial axes,
 * then ω in inertial axes (pose task) or along the effector's x and y axes (axis task), per unit rate, in radians
 * and the model's length unit. KM_USAGE: not finite; KM_MEMORY. O(n); allocates a workspace. */
KM_API km_status km_arm_place(const km_arm *arm, const double *q, km_frame_pose *out, km_error *error);
KM_API km_status km_arm_jacobian(const km_arm *arm, const double *q, double *J, km_error *error);

/* Inverse kinematics: finds the configuration q[n] within the limits that reaches `pose` and is closest to near[n],
 * all in the model's units, by Newton's method from there, else among all branches (km_ik_solutions_find;
 * deterministic for a seed). KM_NO_RESULT: out of reach, or never within the limits; KM_DIVERGED, KM_CANCELLED,
 * KM_MEMORY, KM_USAGE: q[n] is then unchanged. */
KM_API km_status km_arm_solve(const km_arm *arm, const km_frame_pose *pose, const double *near, unsigned long seed,
                              km_progress progress, void *context, double *q, km_error *error);

/* Sets the joint rates (largest speeds): values[n] in the model's angle or length unit per time unit, base first;
 * NULL: none. KM_USAGE: a value isn't greater than 0. */
KM_API km_status km_arm_set_rates(km_arm *arm, const double *values, int count, km_error *error);

/* ---- Path-control and pose-control columns of a Jacobian that is given as a matrix. */

/* Evidence of the rank. */
typedef struct km_control {
  int rank, freedom;                /* rank of the matrix; columns − rank */
  double last_pivot, first_dropped; /* magnitudes; first_dropped 0: none was dropped */
  double tolerance;                 /* relative size below which a pivot counts as 0 */
  double path_entry;                /* z = norm of the null space's last row */
} km_control;

/* Computes the null space Z′ of matrix[rows × columns] (column-major, last column: the path): first the path-control
 * column Z zᵀ/|z|, with z the last row of an orthonormal basis Z; its last entry is positive. The pose-control
 * columns follow, an orthonormal complement with last entries 0 (docs/theory.md 12.3). Z[columns × freedom],
 * allocated for columns². No scaling. KM_USAGE: an entry isn't finite; KM_NO_RESULT: no null space, or |z| < 1e-9,
 * so the path is impossible here; KM_MEMORY. */
KM_API km_status km_control_of_matrix(const double *matrix, int rows, int columns, double *Z, km_control *out,
                                      km_error *error);

/* ---- Paths of an effector. */

/* A path as samples: immutable. */
typedef struct km_path km_path;

/* The curve of a segment. */
typedef enum km_path_shape {
  KM_PATH_LINE,  /* straight to `to`, with uniform rotation about one axis */
  KM_PATH_ARC,   /* arc of `angle` about an axis through `center`; with `pitch` a helix */
  KM_PATH_WEAVE, /* line with sinusoidal lateral motion */
  KM_PATH_SPLINE /* smooth curve through poses */
} km_path_shape;

/* A segment; it begins at the end of the previous one. Inertial frame, model's length unit. Start from
 * km_path_segment_default(): 100 steps, constant orientation. */
typedef struct km_path_segment {
  km_path_shape shape;         /* shape; it determines the members in use */
  int steps;                   /* intervals between samples, 1 to KM_PATH_STEPS */
  double to[3];                /* LINE, WEAVE: end of the effector's origin */
  bool in_place;               /* LINE: the effector's origin doesn't move; `to` is ignored */
  bool turns;                  /* LINE, ARC, WEAVE: the effector rotates to R; else its orientation is constant */
  double R[9];                 /* rotation matrix by rows */
  double center[3], axis[3];   /* ARC */
  double angle;                /* ARC: radians, right-handed about the axis; at most 1000 turns */
  bool full_turn;              /* ARC: full circle; `angle` is ignored */
  double pitch;                /* ARC: travel along the axis per full turn */
  bool turns_along;            /* ARC: the effector rotates with the arc; `turns` is ignored */
  double amplitude, waves;     /* WEAVE: lateral amplitude, and number of periods, up to 10 000 */
  double sideways[3];          /* WEAVE: direction of the lateral motion */
  const km_frame_pose *points; /* SPLINE: [point_count] poses through which the segment passes, from the end of the
                                * path so far */
  const double *times;         /* SPLINE: [point_count] increasing times of the poses from the start of the segment,
                                * time units; NULL: by the path's speeds */
  int point_count;             /* number of `points` */
  int unturned;   /* SPLINE: number of first points that keep the orientation at the start; their R is ignored */
  bool own_start; /* SPLINE: begins at its first point; else at the end of the path so far */
  bool at_points; /* SPLINE: the samples are the points; `steps` is ignored */
} km_path_segment;
enum { KM_PATH_STEPS = 1000000 }; /* largest number of intervals of a path */
KM_API km_path_segment km_path_segment_default(km_path_shape shape);
/* Definition of a path. Start from km_path_plan_default(). */
typedef struct km_path_plan {
  km_frame_pose start; /* pose of the effector before the first segment */
  double speed;        /* speed of the effector's origin, length per time unit; 0: L per second */
  double turn_speed;   /* rotation speed, radians per time unit; 0: rotations take time only while the origin is at
                        * rest */
  const km_path_segment *segments; /* [segment_count] segments in order */
  int segment_count;
} km_path_plan;
KM_API km_path_plan km_path_plan_default(void);

/* Creates a path for the arm, which must outlive it. KM_USAGE: a segment doesn't move the effector or is out of
 * range; the message states its place, as "segments[2].points[1]". KM_MEMORY. The caller frees `*out`. O(steps). */
KM_API km_status km_path_create(const km_arm *arm, const km_path_plan *plan, km_path **out, km_error *error);
KM_API void km_path_free(km_path *path);
/* Number of samples; 0 without a path. The functions below take samples 0 … number − 1. */
KM_API int km_path_samples(const km_path *path);
/* Values up to a sample: metric s in the model's unit, ds² = |dp|² + L² dθ² (docs/theory.md 12.2); travel of the
 * effector's origin; rotation of the effector in radians, as the task counts it; time in seconds; pose. NaN: no such
 * sample. */
KM_API double km_path_length(const km_path *path, int sample);
KM_API double km_path_travel(const km_path *path, int sample);
KM_API double km_path_turn(const km_path *path, int sample);
KM_API double km_path_time(const km_path *path, int sample);
KM_API void km_path_pose(const km_path *path, int sample, km_frame_pose *pose);

/* ---- Following a path with a redundant arm: methods, objectives, tracks. */

/* Objectives: functions of the configuration q and the path's unit twist ξ (docs/theory.md 12.5); larger is better.
 * The rate margin in a track's rows is that of the track's own rates. */
typedef enum km_objective_kind {
  KM_PATH_CONTROL,   /* least magnitude of the entries of the path-control column, including the path entry */
  KM_MANIPULABILITY, /* product of the singular values of the scaled Jacobian */
  KM_SINGULAR_VALUE, /* smallest singular value of the scaled Jacobian */
  KM_LIMIT_DISTANCE, /* least (distance to the nearer limit)/(half range) over the limited joints */
  KM_JOINT_TRAVEL,   /* path entry z = 1/√(1 + |q′|²): less joint travel along the path is better */
  KM_RATE_MARGIN,    /* least 1 − |q̇|/rate over the rated joints, at the minimum-norm rates that follow the path */
  /* Objectives from inverse dynamics, minus the mean over the time (docs/theory.md 12.10). τ: joint force, of a slide
   * times L; they need masses. */
  KM_EFFORT,          /* Σ τ², in the squared torque unit */
  KM_RELATIVE_EFFORT, /* Σ (τ/max_force)² */
  KM_ENERGY,          /* Σ |τ q̇|: power that the drives give and take */
  KM_POSITIVE_WORK,   /* Σ max(τ q̇, 0): power of drives that get nothing back */
  KM_BODY_CLEARANCE,  /* least clearance of the pairs of km_arm_set_clearance, over L; negative in an overlap */
  KM_OBJECTIVES       /* number of kinds */
} km_objective_kind;

KM_API const char *km_objective_word(km_objective_kind kind); /* name, as "path-control" */
KM_API int km_objective_find(const char *word);               /* kind by name; −1: none */

/* Weighted sum of objectives. */
typedef struct km_objective {
  double weight[KM_OBJECTIVES]; /* weight of each kind; 0: not part of the sum */
} km_objective;
/* Adds an objective by name to a weighted sum. KM_USAGE: unknown name or invalid weight. */
KM_API km_status km_objective_add(km_objective *objective, const char *word, double weight, km_error *error);
/* Finds a task by name: "pose", "position" or "axis". KM_USAGE: unknown name. */
KM_API km_status km_task_of_word(const char *word, km_task *out, km_error *error);
/* Weighted sum of one kind with weight 1. */
KM_API km_objective km_objective_of(km_objective_kind kind);
/* The single kind with weight 1; −1: a weighted sum. */
KM_API int km_objective_single(const km_objective *objective);
/* Name of the single kind, or "weighted". */
KM_API const char *km_objective_name(const km_objective *objective);

/* Tracking methods of a redundant arm (docs/theory.md 12.5 to 12.7). */
typedef enum km_method_kind {
  KM_GREEDY,    /* path-control column: the pseudo-inverse method, computed without a pseudo-inverse (318) */
  KM_LOOKAHEAD, /* look-ahead tree of branches that turn the path-control column, with a receding horizon */
  KM_FIXED,     /* as many joints fixed as there are spare freedoms (Uicker) */
  KM_DLS,       /* damped least squares, damped near singular configurations only */
  KM_GRADIENT,  /* greedy plus the objective's gradient in the null space */
  KM_DP,        /* dynamic programming over the self-motions: the reference method */
  KM_GLOBAL,    /* null-space steps along the whole path, optimised by NLopt */
  KM_METHODS    /* number of kinds */
} km_method_kind;

/* Name of a method, as "greedy"; "": none. */
KM_API const char *km_method_word(km_method_kind kind);
KM_API int km_method_find(const char *word); /* method by name; −1: none; "pinv" is greedy */

enum {
  KM_METHOD_JOINTS = 8, /* largest number of fixed joints */
  KM_METHOD_KNOTS = 64  /* largest number of knots of `global` */
};

/* A method with its settings. Start from km_method_default(). */
typedef struct km_method {
  km_method_kind kind;  /* method; it determines the settings in use */
  const char *word;     /* name by which it was requested; "pinv" for greedy, too */
  int branches, levels; /* lookahead: branches (odd) and levels; 3 and 3 */
  double angle;         /* angle between branches, and largest angle φ of gradient, dp, global: radians, 30° */
  int stride;           /* lookahead: samples per level, 0: 1/12 of the path; dp: samples per stage, 0: 1/24 */
  bool sum;             /* lookahead: a leaf's value is the sum, not the minimum, over its samples */
  double damping;       /* dls: λ₀ at singular configurations: 0.05 */
  double below;         /* dls: singular value σ₀ below which rates are damped: 0.1 */
  double gain;          /* gradient: tan φ per unit of slope: 2 */
  double spacing;       /* dp: spacing of states along self-motions, radians; 0: by the reach of the
                                 * null-space steps */
  int knots;            /* global: knots along the path: 12 */
  int evaluations;      /* global: largest number of tracks: 400 */
  int joints[KM_METHOD_JOINTS]; /* fixed: columns of the fixed joints; joint_count 0: those that pivoting leaves
                                 * independent */
  int joint_count;
} km_method;
/* A method with its default settings (km_method). */
KM_API km_method km_method_default(km_method_kind kind);
/* Method with default settings by name. KM_USAGE: unknown name; `out` is then greedy. */
KM_API km_status km_method_of_word(const char *word, km_method *out, km_error *error);
/* True if a method has a setting of that name. km_method_owners appends the names of the methods that have it, as
 * "dp, global"; nothing: no such setting. */
KM_API bool km_method_has(km_method_kind kind, const char *key);
KM_API void km_method_owners(const char *key, km_text *out);
/* Sets a numerical setting, as in a study: angles in degrees. KM_USAGE: the value is out of range, or there is no
 * such setting; the method is then unchanged. */
KM_API km_status km_method_set(km_method *method, const char *key, double value, km_error *error);
/* Sets the aggregate of a look-ahead leaf: "min" or "sum". KM_USAGE: another name. */
KM_API km_status km_method_set_leaf(km_method *method, const char *word, km_error *error);
/* Checks the settings. KM_USAGE: a setting is out of its range or inconsistent; *key is its name. */
KM_API km_status km_method_check(const km_method *method, const char **key, km_error *error);

/* Reason why a track ends. */
typedef enum km_track_stop {
  KM_TRACK_COMPLETE,           /* end of the path */
  KM_TRACK_LIMIT,              /* a joint is at its limit */
  KM_TRACK_RATE,               /* a joint would exceed its rate */
  KM_TRACK_SINGULAR,           /* singular configuration: this one can't follow the path, another one could */
  KM_TRACK_FIXED_JOINTS,       /* method fixed: the configuration can't follow the path with the fixed joints */
  KM_TRACK_WORKSPACE_BOUNDARY, /* workspace boundary: no configuration reaches the path beyond */
  KM_TRACK_NOT_CONVERGED,      /* dp: largest work exceeded; the track so far */
  KM_TRACK_START               /* no start: the first pose is out of reach or outside the limits */
} km_track_stop;

/* End of a track. */
typedef struct km_track_end {
  km_track_stop stop;  /* reason */
  int column;          /* LIMIT, RATE: column of the arm; else −1 */
  int sample;          /* last sample that was reached; −1: none */
  double s, t;         /* end of the track: path metric in the model's length unit; seconds */
  double travel, turn; /* travel of the effector's origin, model's length unit; rotation, radians */
  double place[3];     /* effector's origin in the inertial frame, model's length unit; of START that of the path */
} km_track_end;

/* A track: a configuration of the arm for each sample of a path. */
typedef struct km_track km_track;

/* Definition of a track. */
typedef struct km_track_plan {
  const km_path *path;    /* path of the same arm */
  const double *start;    /* [n] start configuration, model's units; it reaches the first pose */
  km_method method;       /* tracking method */
  km_objective objective; /* objective to maximise */
  int jobs;               /* number of threads */
  unsigned long seed;     /* seed of random choices */
  km_progress progress;
  void *context;
} km_track_plan;

/* Computes a track. KM_PARTIAL: it ends before the path; the track contains the part that was reached,
 * km_track_ending the reason. KM_CANCELLED; KM_MEMORY. The pose error is below 1e-12 in every row. The result
 * doesn't depend on `jobs`, to the bit. The caller frees `*out`. */
KM_API km_status km_track_run(const km_arm *arm, const km_track_plan *plan, km_track **out, km_error *error);
KM_API void km_track_free(km_track *track);

/* End of the track. */
KM_API km_track_end km_track_ending(const km_track *track);
KM_API int km_track_samples(const km_track *track); /* samples of the path: rows of a complete track */
/* Table with the columns step, s, t, q.*, v.*, z.*, z.path, objective.*, error_position, error_rotation,
 * limit_margin (docs/redundant-arms.md). */
KM_API const km_table *km_track_rows(const km_track *track); /* borrowed */

/* Summary of a track; objectives are those of the plan. */
typedef struct km_track_summary {
  double error_position, error_rotation; /* largest pose errors; model's length and angle unit */
  double objective_min, objective_mean;  /* least and mean objective of the rows */
  double joint_travel;                   /* Σ|Δq|, slides over L */
  double rate;                           /* largest joint speed, slides over L a second */
  int rate_column;                       /* column of that joint; −1: none */
  double limit_margin;                   /* least distance to a limit over half the range; 1 without limits */
  int violations;                        /* rows outside a limit or a rate; 0 unless there is a fault */
  unsigned long evaluations;             /* Jacobians computed */
  double seconds;                        /* computing time; not in records, which are reproducible */
  bool greedy_instead;                   /* look-ahead: greedy's track was better and is the result */
  double converged;                      /* dp: relative change of the value at half the spacing and stage; else NaN */
  bool bounded;  /* dp: the number of states or null-space steps was limited, so they are coarser than the spacing */
  double effort; /* mean over the time of Σ τ², squared torque unit; NaN: no masses, or one row */
  double relative_effort; /* mean over the time of Σ (τ/max_force)²; NaN: a drive states none */
  double energy;          /* ∫ Σ |τ q̇| dt, force · length */
  double positive_work;   /* ∫ Σ max(τ q̇, 0) dt, force · length */
} km_track_summary;
KM_API km_track_summary km_track_summarise(const km_track *track);

/* ---- Path studies: model, effector, path, start and methods, as a definition that is read or filled, then bound to
 * a mechanism. */

/* Place of a part of a study in messages, and its origin. */
typedef struct km_study_place {
  const char *text; /* start of messages about the part: "q0", "--q" */
  bool option;      /* stated by the command, not by the file: km_study_read keeps the part, and its faults are
                     * KM_USAGE */
} km_study_place;

/* List of names with its place. */
typedef struct km_study_names {
  const char *const *items; /* [count] */
  int count;                /* number of items; 0: not stated */
  km_study_place place;     /* place of the part in messages */
} km_study_names;

/* List of numbers with its place. */
typedef struct km_study_numbers {
  const double *items;  /* items; NULL: not stated */
  int count;            /* number of items; 0: not stated */
  km_study_place place; /* place of the part in messages */
} km_study_numbers;

/* Path of a study, in the model's units; angles of arcs and the turn speed are in its angle unit. */
typedef struct km_study_path {
  km_path_plan plan;     /* definition of the path; no segments: none */
  bool start_p, start_R; /* stated parts of the plan's start; others are those of the effector at q0 */
  const double *turns;   /* [3 × points of the one segment] rotation vectors instead of R, NULL: none */
  const char *file;      /* file of the poses; NULL: none */
  const int *lines;      /* [points of the one segment] lines in that file */
  km_study_place place;  /* place of the part in messages */
} km_study_path;

/* A method of a study. */
typedef struct km_study_method {
  km_method method;      /* method; its joints are found when the study is bound */
  km_study_names joints; /* labels of the joints */
} km_study_method;

/* Definition of a path study. Start from km_study_def_default(). All pointers are borrowed except `memory`. */
typedef struct km_study_def {
  const char *model;          /* model file, relative to the study's folder; NULL: none */
  km_study_names effector;    /* effector frame: names of its path, or "body/frame" */
  int frame;                  /* effector frame by its index in the model; −1: by its names */
  km_study_names coordinates; /* order of q0 and rates by labels; none: from the base outward */
  km_study_numbers q0;        /* start configuration, model's units; none: the state's */
  km_study_numbers rates;     /* joint rates (km_arm_set_rates); none: the drives' max_rate, if the path has a speed */
  km_task task;               /* rows that follow the path */
  km_study_place task_place;  /* place of the part in messages */
  km_study_path path;         /* path to follow */
  bool path_optional;         /* a missing path is no fault; the start is then q0 */
  const km_study_method *methods; /* [method_count] methods; each gives a track */
  int method_count;               /* number of methods; 0: greedy */
  km_study_place methods_place;   /* place of the part in messages */
  km_objective objective;         /* objective; path-control by default */
  km_study_place objective_place; /* place of the part in messages */
  struct km_arena *memory;        /* memory of a definition that was read; NULL: none */
} km_study_def;
KM_API km_study_def km_study_def_default(void);

/* Reads a study from `size` bytes of JSON into a definition that contains the default or parts stated by the
 * command, which are kept. `folder` is the folder of the file ("": the working folder), to which CSV files of poses
 * are relative. Findings go to `messages` with their place. KM_MODEL: an error in the text; KM_IO: a file of poses
 * can't be read; KM_MEMORY. Free the definition in any case. */
KM_API km_status km_study_read(const char *bytes, size_t size, const char *folder, km_messages *messages,
                               km_study_def *def, km_error *error);
/* Reads only the path, from the text of a study or path, or (km_study_read_poses) from a CSV file of poses. Files in
 * the text are relative to `folder`. `place` is the path's place in messages and is stored in the definition.
 * Statuses as km_study_read; KM_USAGE for an option. */
KM_API km_status km_study_read_path(const char *bytes, size_t size, const char *folder, km_study_place place,
                                    km_messages *messages, km_study_def *def, km_error *error);
KM_API km_status km_study_read_poses(const char *file, km_study_place place, km_messages *messages, km_study_def *def,
                                     km_error *error);
KM_API void km_study_def_free(km_study_def *def);

/* A study that is bound to a mechanism. */
typedef struct km_study km_study;

/* Creates arm, path, start and methods from a definition and a mechanism of its model. The start is q0, else the
 * state's configuration, moved to the path's first pose by inverse kinematics. KM_MODEL, KM_USAGE: an error in the
 * definition or in an option; KM_NO_RESULT: no start within the limits reaches the first pose; `*out` is then a
 * study without a start, whose tracks end at once. KM_DIVERGED; KM_MEMORY. The mechanism must outlive the study, the
 * definition need not. The caller frees `*out`. */
KM_API km_status km_study_bind(const km_mechanism *mechanism, const km_state *state, const km_study_def *def,
                               unsigned long seed, km_messages *messages, km_study **out, km_error *error);
KM_API void km_study_free(km_study *study);

/* Arm of a study. Borrowed. */
KM_API const km_arm *km_study_arm(const km_study *study);
/* Path of a study; NULL: none. Borrowed. */
KM_API const km_path *km_study_bound_path(const km_study *study);
/* Start of the tracks: q[n] in the model's units, base first, and `moved`, the largest change of a coordinate by
 * inverse kinematics, radians or lengths over L. Either may be NULL. KM_NO_RESULT: no start within the limits
 * reaches the path's first pose; neither is then set. */
KM_API km_status km_study_start(const km_study *study, double *q, double *moved, km_error *error);
/* Track plan of method i: path, start, method, objective; jobs 1, seed 1. */
KM_API km_track_plan km_study_plan(const km_study *study, int method);
/* Number of methods of a study. */
KM_API int km_study_methods(const km_study *study);

/* ---- Self-motions of an arm, and all configurations that reach a pose. */

/* Arc of a self-motion within all limits, for one combination of full turns. */
typedef struct km_arc_span {
  double from, to; /* range of arc length; `from` is below 0 if the start of a closed curve is inside the arc. If a
                    * hinge with wide limits makes full turns along a closed curve, an arc can extend over several
                    * rounds */
  int column[2];   /* coordinates whose limits end the arc; −1: end of the curve, or no end */
} km_arc_span;

/* One component of the self-motion manifold: a curve of configurations. Arc length u is Euclidean in the
 * coordinates: radians, lengths over L. Full turns of hinges are no difference. */
typedef struct km_selfmotion {
  int count, columns;      /* configurations; coordinates n of the arm */
  double *u;               /* [count] increasing arc length; 0 at the start */
  double *q;               /* [count × columns] model's units, base first; continuous */
  bool closed;             /* the curve is closed, full turns of hinges not counted */
  bool continues_by_turns; /* closed except for full turns of hinges with wide limits: only limits end the
                                 * motion */
  double length;           /* length of the closed curve, or from end to end */
  double error;            /* largest error of the effector's pose; lengths over L */
  km_arc_span *arcs;       /* arcs for all full turns within the limits, sorted by their turns */
  int arc_count;
  int *turn;             /* [arc_count × columns] full turn of a hinge with wide limits in the middle of the arc,
                          * else 0; NULL with two spare freedoms */
  bool is_within_limits; /* closed and within the limits everywhere */
  int row_count;         /* rows of the arcs, from located end to located end; for a curve within the limits
                          * everywhere, back to its start */
  int *row_arc;          /* [row_count] arc of the row */
  double *row_u, *row_q; /* [row_count] arc length, [row_count × columns] configurations; continuous, limited hinges
                          * within their limits */
  unsigned long evaluations; /* Jacobians computed */
} km_selfmotion;

enum {
  KM_SELFMOTION_DIRECTIONS = 12 /* directions followed with two spare freedoms */
};

/* Follows the self-motion through q[n] (model's units, base first) in both directions: along its closed curve, or to
 * a singular configuration, or until a slide diverges (docs/theory.md 12.8). Crossings of limits are located as
 * roots along the curve. Two spare freedoms: KM_SELFMOTION_DIRECTIONS directions of a circle, each followed to a
 * limit or up to π; one arc per direction. Hinges with wide limits are reported at every turn within them, whichever
 * turn q is in (two spare freedoms: at that of q); others have one angle within their limits. KM_USAGE: no or more
 * than two spare freedoms; KM_MEMORY; KM_CANCELLED. Free `*out` in any case. */
KM_API km_status km_selfmotion_follow(const km_arm *arm, const double *q, km_progress progress, void *context,
                                      km_selfmotion *out, km_error *error);
KM_API void km_selfmotion_free(km_selfmotion *motion);

/* All components of the configurations that reach a pose. */
typedef struct km_ik_solutions {
  int count;             /* number of components */
  km_selfmotion *items;  /* one spare freedom: curves; else single configurations (count 1, length 0) */
  double *pose;          /* [count × columns] configuration of each branch with the largest limit distance */
  double *margin;        /* [count] limit distance of that configuration; < 0: none within the limits */
  bool *singular;        /* [count] found at a singular configuration: possibly one of a family */
  int within;            /* number of components within the limits; they come first */
  int starts, converged; /* evidence: starts of Newton's method; solutions found */
  bool closed_form;      /* three neighbouring axes are concurrent or parallel: solutions by the closed form */
  bool confirmed;        /* the number of components is confirmed; false: there can be more */
} km_ik_solutions;

/* Finds all solutions of inverse kinematics (docs/theory.md 12.9). Six hinges of which three neighbouring axes are
 * concurrent or parallel (of seven, one is fixed at many angles): closed form. Others: Newton's method from many
 * starts, deterministic for a seed, until the count is confirmed: many known solutions in a row and, for six hinges,
 * equal numbers with positive and negative determinant. Each solution that lies on no known curve is followed along
 * its own. KM_NO_RESULT: out of reach; KM_MEMORY; KM_CANCELLED. Free `*out` in any case. */
KM_API km_status km_ik_solutions_find(const km_arm *arm, const km_frame_pose *pose, unsigned long seed,
                                      km_progress progress, void *context, km_ik_solutions *out, km_error *error);
KM_API void km_ik_solutions_free(km_ik_solutions *solutions);

#ifdef __cplusplus
}
#endif
#endif
