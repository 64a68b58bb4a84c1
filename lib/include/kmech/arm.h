/* Redundant serial arms: arms, path-control columns, paths, tracking methods, path studies, self-motions, inverse
 * kinematics. */
#ifndef KMECH_ARM_H
#define KMECH_ARM_H

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A serial arm in a mechanism: the chain of joints from the inertial frame to an effector frame. */

/* The chain, cut out of a mechanism. Immutable but for km_arm_set_rates. */
typedef struct km_arm km_arm;

/* What of the effector must follow: its whole pose (6 rows), its origin (3), or its origin and z axis (5). */
typedef enum km_task {
  KM_TASK_POSE,     /* position and rotation: 6 rows */
  KM_TASK_POSITION, /* the origin: 3 rows */
  KM_TASK_AXIS      /* the origin and the direction of the z axis: 5 rows */
} km_task;

/* The chain to `effector` (a frame of the model), joints passed in either sense, held and rigid joints rigid at the
 * state's values; other branches of the model don't matter. Lengths are scaled by L, the model's characteristic length
 * if its file gives one, else one metre. KM_USAGE: a joint on the way lies in a loop or a coupling, is a ball,
 * or there are fewer coordinates than rows of the task that motions can change. The mechanism must outlive it. The caller frees `*out`. */
KM_API km_status km_arm_create(const km_mechanism *mechanism, const km_state *state, int effector, km_task task,
                               km_arm **out, km_error *error);
KM_API void km_arm_free(km_arm *arm);

/* The number of its coordinates n; 0 without an arm. */
KM_API int km_arm_coordinates(const km_arm *arm);
KM_API int km_arm_coordinate(const km_arm *arm, int column); /* the mechanism's coordinate of a column, base first */
KM_API double km_arm_length(const km_arm *arm);              /* L, in the model's length unit */

KM_API int km_arm_rows(const km_arm *arm); /* of the task: 6, 5 or 3 */
/* To spare for it: coordinates − rows that its motions can change, which are fewer than the task's of an arm that moves in a
 * plane, for instance; 0 without an arm. */
KM_API int km_arm_freedom(const km_arm *arm);

/* Effector kinematics at q[n] (model's units, base first). The pose in the inertial frame; J[rows × n], column-major:
 * v of the effector's origin along the inertial axes, then of a pose ω along them, of an axis ω along the effector's x
 * and y, per unit rate in radians and the model's length unit. KM_USAGE: not finite; KM_MEMORY. O(n), and a workspace
 * is made. */
KM_API km_status km_arm_place(const km_arm *arm, const double *q, km_frame_pose *out, km_error *error);
KM_API km_status km_arm_jacobian(const km_arm *arm, const double *q, double *J, km_error *error);

/* Inverse kinematics: of all poses within the limits that reach `pose` the one nearest to near[n], both in the model's
 * units: by Newton's method from there, else of all branches that are found (km_ik_solutions_find; the same for the same
 * seed). KM_NO_RESULT: out of reach, or never within the limits; KM_DIVERGED, KM_CANCELLED, KM_MEMORY, KM_USAGE: then
 * q[n] stays as it is. */
KM_API km_status km_arm_solve(const km_arm *arm, const km_frame_pose *pose, const double *near, unsigned long seed,
                              km_progress progress, void *context, double *q, km_error *error);

/* Largest speeds: values[n] in the model's angle or length unit per time unit, base first; NULL: none. KM_USAGE if
 * one isn't greater than 0. */
KM_API km_status km_arm_set_rates(km_arm *arm, const double *values, int count, km_error *error);

/* ---- Path-control and pose-control columns of a Jacobian that is given as it is. */

/* Evidence of the rank. */
typedef struct km_control {
  int rank, freedom;                /* of the matrix; columns − rank */
  double last_pivot, first_dropped; /* magnitudes; 0 dropped: nothing was left */
  double tolerance;                 /* below which a pivot counts as 0 */
  double path_entry;                /* z = |the null space's last row| */
} km_control;

/* Z′ of the null space of matrix[rows × columns] (column-major, its last column the path's): first the path-control
 * column Zzᵀ/|z|, z the last row of an orthonormal basis Z, its own last entry positive; then the pose-control columns,
 * an orthonormal complement whose last entries are 0 (theory 6). Z[columns × freedom], room for columns². No scaling.
 * KM_USAGE: an entry isn't finite; KM_NO_RESULT: no null space, or |z| < 1e-9: the path is impossible here; KM_MEMORY.
 */
KM_API km_status km_control_of_matrix(const double *matrix, int rows, int columns, double *Z, km_control *out,
                                      km_error *error);

/* ---- The path that an effector is to follow. */

/* A path as samples: immutable. */
typedef struct km_path km_path;

/* The curve of a segment. */
typedef enum km_path_shape {
  KM_PATH_LINE,  /* straight to `to`, turning evenly about one axis */
  KM_PATH_ARC,   /* by `angle` about an axis through `center`, with `pitch` a helix; a full turn is a circle */
  KM_PATH_WEAVE, /* a line with sine swings sideways */
  KM_PATH_SPLINE /* smoothly through poses */
} km_path_shape;

/* One segment. It begins where the one before ends. All in the inertial frame and the model's length unit. Start from
 * km_path_segment_default(), which is 100 steps long, and keeps the effector's orientation. */
typedef struct km_path_segment {
  km_path_shape shape;         /* which members count */
  int steps;                   /* intervals between samples, 1 to KM_PATH_STEPS */
  double to[3];                /* LINE, WEAVE: where the effector's origin ends */
  bool in_place;               /* LINE: the effector's origin stays where it is; `to` doesn't count then */
  bool turns;                  /* LINE, ARC, WEAVE: the effector turns to R, else it keeps its orientation */
  double R[9];                 /* by rows */
  double center[3], axis[3];   /* ARC */
  double angle;                /* ARC: radians, right-handed about the axis; at most 1000 turns */
  bool full_turn;              /* ARC: a circle; `angle` doesn't count then */
  double pitch;                /* ARC: travel along the axis in a full turn */
  bool turns_along;            /* ARC: the effector turns with the arc; `turns` doesn't count then */
  double amplitude, waves;     /* WEAVE: how far to either side, and how many swings there and back, up to 10 000 */
  double sideways[3];          /* WEAVE: direction of the swings */
  const km_frame_pose *points; /* SPLINE: [point_count] poses through which it goes, from where the path stands */
  const double *times;         /* SPLINE: [point_count] when it is at them, counted in time units from where it begins,
                                  increasing; NULL: by the path's speeds */
  int point_count;             /* of `points` */
  int unturned;   /* SPLINE: so many of the first points keep the orientation with which the path comes; their R
                      doesn't count */
  bool own_start; /* SPLINE: begins at its first point, wherever the path stands; else only where that is the same */
  bool at_points; /* SPLINE: the samples are the points; `steps` doesn't count then */
} km_path_segment;
enum { KM_PATH_STEPS = 1000000 }; /* the most intervals of a path */
KM_API km_path_segment km_path_segment_default(km_path_shape shape);
/* Start from km_path_plan_default(). */
typedef struct km_path_plan {
  km_frame_pose start; /* where the effector is before the first segment */
  double speed;        /* of the effector's origin, length per time unit; 0: L a second */
  double turn_speed;   /* radians per time unit; 0: turns take no time of their own but where the origin stands still */
  const km_path_segment *segments; /* [segment_count] in their order */
  int segment_count;
} km_path_plan;
KM_API km_path_plan km_path_plan_default(void);

/* Makes a path for the arm, which must outlive it. KM_USAGE: a segment doesn't move the effector or is out of range,
 * and says which, as "segments[2].points[1]"; KM_MEMORY. The caller frees `*out`. O(steps). */
KM_API km_status km_path_create(const km_arm *arm, const km_path_plan *plan, km_path **out, km_error *error);
KM_API void km_path_free(km_path *path);
/* The number of samples: 0 … one less are those of the functions below. 0 without a path. */
KM_API int km_path_samples(const km_path *path);
/* The metric s up to a sample, model's unit: ds² = |dp|² + L²dθ² (theory 6); the length that the effector's origin has
 * travelled, and the angle in radians by which the effector has turned, as far as the task counts it; time in seconds;
 * the pose. */
KM_API double km_path_length(const km_path *path, int sample);
KM_API double km_path_travel(const km_path *path, int sample);
KM_API double km_path_turn(const km_path *path, int sample);
KM_API double km_path_time(const km_path *path, int sample);
KM_API void km_path_pose(const km_path *path, int sample, km_frame_pose *pose);

/* ---- Following a path with a redundant arm: methods, objectives, tracks. */

/* Functions of a pose q and the path's unit twist ξ alone (theory 6); larger is better. The rate margin of a track's
 * rows is that of the track's own rates. */
typedef enum km_objective_kind {
  KM_PATH_CONTROL,   /* min over all |entries| of the path-control column, the path's included */
  KM_MANIPULABILITY, /* product of the scaled Jacobian's singular values */
  KM_SINGULAR_VALUE, /* the smallest of them */
  KM_LIMIT_DISTANCE, /* min over limited joints of (distance to the nearer limit)/(half range) */
  KM_JOINT_TRAVEL,   /* the path entry z = 1/√(1 + |q′|²): less joint travel for the same way is better */
  KM_RATE_MARGIN,    /* min over rated joints of 1 − |q̇|/rate, at the least rates that follow the path */
  KM_OBJECTIVES      /* how many there are */
} km_objective_kind;

KM_API const char *km_objective_word(km_objective_kind kind); /* "path-control" … */
KM_API int km_objective_find(const char *word);               /* -1: none */

/* A weighted sum of them. */
typedef struct km_objective {
  double weight[KM_OBJECTIVES]; /* of each kind; 0: it doesn't count */
} km_objective;
/* Adds an objective of that name to a weighted sum. KM_USAGE: there is none, or it is no weight. */
KM_API km_status km_objective_add(km_objective *objective, const char *word, double weight, km_error *error);
/* What must follow the path: "pose", "position" or "axis". KM_USAGE: no task has that name. */
KM_API km_status km_task_of_word(const char *word, km_task *out, km_error *error);
/* The sum in which one kind alone has weight 1. */
KM_API km_objective km_objective_of(km_objective_kind kind);
/* The only kind, if it has weight 1; -1: a weighted sum. */
KM_API int km_objective_single(const km_objective *objective);
/* "singular-value", or "weighted" of several. */
KM_API const char *km_objective_name(const km_objective *objective);

/* How a redundant arm follows a path. */
typedef enum km_method_kind {
  KM_GREEDY,    /* the path-control column: the pseudo-inverse method, found without one (318) */
  KM_LOOKAHEAD, /* a tree of branches that turn the path-control column, receding with the path */
  KM_FIXED,     /* as many joints held as there are spare freedoms (Uicker) */
  KM_DLS,       /* damped least squares, damped near singular poses only */
  KM_GRADIENT,  /* greedy, and up the objective's slope in the null space */
  KM_DP,        /* dynamic programming over the self-motions: the reference */
  KM_GLOBAL,    /* NLopt over the whole path's turns */
  KM_METHODS    /* how many there are */
} km_method_kind;

/* "greedy", "lookahead" …; "" for none. */
KM_API const char *km_method_word(km_method_kind kind);
KM_API int km_method_find(const char *word); /* -1: none; "pinv" is greedy */

enum {
  KM_METHOD_JOINTS = 8, /* the most that are held */
  KM_METHOD_KNOTS = 64  /* the most of global */
};

/* A method with its settings. Start from km_method_default(). */
typedef struct km_method {
  km_method_kind kind;          /* which settings count */
  const char *word;             /* what it was asked for by: "pinv" for greedy, too */
  int branches, levels;         /* lookahead: odd; 3 and 3 */
  double angle;                 /* radians between branches, and the most of gradient, dp, global: 30° */
  int stride;                   /* lookahead: samples a level, 0: 1/12 of the path; dp: a stage, 0: 1/24 */
  bool sum;                     /* lookahead: a leaf's value is the sum, not the min, over its samples */
  double damping;               /* dls: λ at singular poses: 0.05 */
  double below;                 /* dls: damped where the smallest singular value is below: 0.1 */
  double gain;                  /* gradient: tilt per unit of slope: 2 */
  double spacing;               /* dp: of states along self-motions, radians; 0: by what the tilts can reach */
  int knots;                    /* global: turns along the path: 12 */
  int evaluations;              /* global: most tracks tried: 400 */
  int joints[KM_METHOD_JOINTS]; /* fixed: held columns of the arm; joint_count 0: those that pivoting leaves free */
  int joint_count;
} km_method;
/* The method with the settings that km_method names. */
KM_API km_method km_method_default(km_method_kind kind);
/* The default method of a word. KM_USAGE: there is none of that name; `out` is then greedy. */
KM_API km_status km_method_of_word(const char *word, km_method *out, km_error *error);
/* Has a method a setting of that name; and which methods have (appended: "dp, global"; nothing: it is no setting)? */
KM_API bool km_method_has(km_method_kind kind, const char *key);
KM_API void km_method_owners(const char *key, km_text *out);
/* A setting that is a number, as a study writes it: angles in degrees. KM_USAGE: the value is out of the setting's range,
 * or there is no such setting; the method stays as it is. */
KM_API km_status km_method_set(km_method *method, const char *key, double value, km_error *error);
/* What a leaf of look-ahead counts: "min" or "sum". KM_USAGE: another word. */
KM_API km_status km_method_set_leaf(km_method *method, const char *word, km_error *error);
/* KM_USAGE: a setting is out of its range, or doesn't fit the others; *key is then the setting. */
KM_API km_status km_method_check(const km_method *method, const char **key, km_error *error);

/* Why a track ends. */
typedef enum km_track_stop {
  KM_TRACK_COMPLETE,      /* the path does */
  KM_TRACK_LIMIT,         /* a joint is at its limit */
  KM_TRACK_RATE,          /* a joint would be faster than it may */
  KM_TRACK_SINGULAR,      /* the pose can't move along the path, though another one could */
  KM_TRACK_HELD,          /* fixed: the pose can't move along the path with the joints that are held */
  KM_TRACK_EDGE,          /* the workspace ends here: no pose of the arm reaches what follows */
  KM_TRACK_NOT_CONVERGED, /* dp: more work than it does; what was reached so far */
  KM_TRACK_START          /* nowhere to begin: the first pose is out of reach or outside the limits */
} km_track_stop;

/* How a track ended. */
typedef struct km_track_end {
  km_track_stop stop;  /* why */
  int column;          /* LIMIT, RATE: of the arm; else -1 */
  int sample;          /* the last sample that was reached, -1 none */
  double s, t;         /* where it ended: the path's metric in the model's length unit, and seconds; */
  double travel, turn; /* how far its origin travelled to there, model's length unit, and how far it turned, radians */
} km_track_end;

/* A track: a pose of the arm for each sample of the path. */
typedef struct km_track km_track;

/* What to follow, from where, and how. */
typedef struct km_track_plan {
  const km_path *path;    /* of the same arm */
  const double *start;    /* [n] model's units: reaches the first pose */
  km_method method;       /* how */
  km_objective objective; /* what is made large */
  int jobs;               /* threads */
  unsigned long seed;     /* of what is random */
  km_progress progress;
  void *context;
} km_track_plan;

/* Follows the path. KM_PARTIAL: not to its end (the track holds what was reached, km_track_end why it stops);
 * KM_CANCELLED; KM_MEMORY. The pose error is below 1e-12 at every row; the result doesn't depend on `jobs`, to the bit.
 * The caller frees `*out`. */
KM_API km_status km_track_run(const km_arm *arm, const km_track_plan *plan, km_track **out, km_error *error);
KM_API void km_track_free(km_track *track);

/* How it ended. */
KM_API km_track_end km_track_ending(const km_track *track);
KM_API int km_track_samples(const km_track *track); /* of the path: rows that a whole track has */
/* Columns as cli.md: step, s, t_s, q., v., z., z.path, objective., error_position, error_rotation, limit_margin. */
KM_API const km_table *km_track_rows(const km_track *track); /* borrowed */

/* What a summary tells. Objectives are the plan's. */
typedef struct km_track_summary {
  double error_position, error_rotation; /* largest; model's length and angle unit */
  double objective_min, objective_mean;  /* over the rows */
  double joint_travel;                   /* Σ|Δq|, slides over L */
  double rate;                           /* largest joint speed, slides over L a second */
  int rate_column;                       /* whose speed that is, a column of the arm; -1: none */
  double limit_margin;                   /* least distance to a limit over half the range; 1 without limits */
  int violations;                        /* rows outside a limit or a rate: 0, or a fault */
  unsigned long evaluations;             /* Jacobians */
  double seconds;                        /* of work; not in records, which are the same for the same input */
  bool greedy_instead;                   /* look-ahead: greedy's track was better and is given */
  double converged;                      /* dp: relative change of the value at half the spacing and stage; else NaN */
  bool bounded; /* dp: there were more states or tilts than it keeps, so they lie wider than the spacing */
} km_track_summary;
KM_API km_track_summary km_track_summarise(const km_track *track);

/* ---- Path studies: a model, an effector, a path, a start and methods, as a definition that a file or a program fills, and
 * bound to a mechanism. */

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

/* ---- Motions of an arm that leave its effector where it is, and all the ways in which an arm reaches a pose. */

/* A stretch of a self-motion on which every joint is within its limits, at one combination of full turns. */
typedef struct km_arc_span {
  double from, to; /* arc length; `from` is below 0 where the start of a closed curve is inside. A hinge with room for a
                    * full turn that makes one round a closed curve runs on: then for more rounds, either way */
  int column[2];   /* whose limits end it; -1: the motion itself ends, or nothing does */
} km_arc_span;

/* One component: a curve of poses. Arc length u is Euclidean over the coordinates: radians, slides over L. Full turns
 * of hinges don't count as a difference. */
typedef struct km_selfmotion {
  int count, columns; /* poses; coordinates n of the arm */
  double *u;          /* [count] increasing; 0 at the pose that it was followed from */
  double *q;          /* [count × columns] model's units, base first; continuous */
  bool closed;        /* it comes back to its start, full turns of hinges aside */
  bool turns_on;      /* closed but for full turns of hinges with limits that leave room for them: only limits end it */
  double length;      /* of the closed curve, or from end to end */
  double error;       /* of the effector's pose, the largest along it: lengths over L */
  km_arc_span *arcs;  /* at all full turns that the limits leave room for, by their turns */
  int arc_count;
  int *turn;             /* [arc_count × columns] the full turn in which a hinge with room for several is in the arc's
                          * middle, else 0; NULL with two spare freedoms */
  bool whole;            /* closed, and within the limits all the way */
  int row_count;         /* the arcs' poses, from located end to located end; of a whole curve back to its start */
  int *row_arc;          /* [row_count] which arc */
  double *row_u, *row_q; /* [row_count], [row_count × columns]; limited hinges within their limits, continuous */
  unsigned long evaluations; /* Jacobians that it took */
} km_selfmotion;

enum {
  KM_SELFMOTION_DIRECTIONS = 12 /* looked in with two spare freedoms */
};

/* Follows the self-motion through q[n] (model's units, base first) in both senses: round its closed curve, or until it
 * ends in a singular pose, or its slides leave for infinity. Where limits are crossed is found as roots along the
 * curve. With two spare freedoms: in KM_SELFMOTION_DIRECTIONS directions of a circle, each carried on without turning
 * to a limit or up to π; an arc a direction. Hinges whose limits are a full turn apart or more are delivered at
 * every turn within them, whichever turn q is in (with two spare freedoms at that of q); the others have one angle
 * within their limits. KM_USAGE: none or more than two spare freedoms; KM_MEMORY; KM_CANCELLED. Free `*out` in any
 * case. */
KM_API km_status km_selfmotion_follow(const km_arm *arm, const double *q, km_progress progress, void *context,
                                      km_selfmotion *out, km_error *error);
KM_API void km_selfmotion_free(km_selfmotion *motion);

/* All components of the poses that hold the effector at a pose. */
typedef struct km_ik_solutions {
  int count;             /* components */
  km_selfmotion *items;  /* with one freedom: curves; else single poses (count 1, length 0) */
  double *pose;          /* [count × columns] of each branch: within the limits, as far from them as it gets */
  double *margin;        /* [count] limit distance there; below 0: no pose within the limits */
  bool *singular;        /* [count] found at a singular pose: perhaps one of a family of poses */
  int within;            /* how many have poses within the limits; they come first */
  int starts, converged; /* evidence: starts of Newton's method, and solutions */
  bool closed_form;      /* three neighbouring axes meet or are parallel: the solutions are those of the closed form */
  bool confirmed;        /* the count of components; false: there may be more */
} km_ik_solutions;

/* In closed form where six hinges (of seven one is held, at many angles) have three neighbouring axes that meet or are
 * parallel; else by Newton's method from many starts (the same for the same seed), until the count is confirmed: no new
 * ones in a long row, and, of six hinges, as many of either sense. Each solution that lies on no known curve is
 * followed along its own. KM_NO_RESULT: out of reach; KM_MEMORY; KM_CANCELLED. Free `*out` in any case. */
KM_API km_status km_ik_solutions_find(const km_arm *arm, const km_frame_pose *pose, unsigned long seed,
                                      km_progress progress, void *context, km_ik_solutions *out, km_error *error);
KM_API void km_ik_solutions_free(km_ik_solutions *solutions);

#ifdef __cplusplus
}
#endif
#endif
