/* Following a path with a redundant arm: methods, objectives, tracks. */
#ifndef KMECH_TRACK_H
#define KMECH_TRACK_H

#include "kmech/path.h"
#include "kmech/progress.h"
#include "kmech/table.h"
#include "kmech/text.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

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
  KM_TRACK_COMPLETE, /* the path does */
  KM_TRACK_LIMIT,    /* a joint is at its limit */
  KM_TRACK_RATE,     /* a joint would be faster than it may */
  KM_TRACK_SINGULAR, /* the pose can't move along the path, though another one could */
  KM_TRACK_HELD,     /* fixed: the pose can't move along the path with the joints that are held */
  KM_TRACK_EDGE,     /* the workspace ends here: no pose of the arm reaches what follows */
  KM_TRACK_GAVE_OUT, /* dp: more work than it does; what was reached so far */
  KM_TRACK_START     /* nowhere to begin: the first pose is out of reach or outside the limits */
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

#ifdef __cplusplus
}
#endif
#endif
