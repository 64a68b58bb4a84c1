/* Continuation with the scaled driver s as parameter (theory 4.6): data of a driven motion.
 * Lengths and steps are scaled: radians, or lengths over the substructure's size. Private to the library. */
#ifndef KM_CONTINUATION_DRIVER_MOTION_H
#define KM_CONTINUATION_DRIVER_MOTION_H

#include "base/number/tolerances.h"
#include "continuation/minimum_norm_path.h"
#include "continuation/node_curve.h"
#include "continuation/predictor_corrector.h"
#include "kmech/continuation.h"

/* A slide beyond this distance (sizes) with a rate above this value (per unit of the driver) diverges; a rate above it
 * where a motion ends shows a turning point. */
static const double km_driver_motion_diverging = 1e3;
/* A step is doubled if the predictor's error over the allowed one would stay below this. In relation to its length the
 * error of a doubled step is 16 times, that of an implicit one 4 times larger. */
static const double km_driver_motion_growth_limit = 0.8;
/* True if a step of at most `step` reaches a target that is `remaining` away. A target nearer to the end of a step than
 * km_root_rounding, relative to the step, is reached by it: so short a step would corrupt the history of the
 * predictor. */
static inline bool km_driver_motion_reaches(double remaining, double step) {
  return fabs(remaining) <= step * (1.0 + km_root_rounding);
}

/* Position of the continuation besides its history and the state's configuration. */
typedef struct km_driver_motion_position {
  double s;         /* driver, scaled */
  double largest;   /* step size of the step control */
  double stopped;   /* direction, ±1, of a located turning point while the configuration is close to it; else 0 */
  int crossings;    /* branch points that were crossed */
  bool known;       /* the tangent in the history belongs to the present configuration */
  bool is_stiff;    /* the last step used the implicit predictor: km_minimum_norm_path_predict_implicit */
  int bridge;       /* number of the bridge (singular_bridge.c) under this configuration; 0: none */
  int pivot_driver; /* snapshots only: driver column for which the pivots were searched; KM_NEVER */
} km_driver_motion_position;

/* Snapshot of a continuation: restoring it reproduces all later steps to the last bit. */
typedef struct km_driver_motion_snapshot {
  km_driver_motion_position position;
  km_step_history history;
  double *pose; /* configuration as km_state_save; NULL: not allocated yet */
  bool is_set;
} km_driver_motion_snapshot;

/* Last configuration from which a step of at least 5e-3 was rejected: it is still away from the singular one. */
typedef struct km_driver_regular_sample {
  double s;     /* driver; infinite: none */
  double *pose; /* configuration as km_state_save */
} km_driver_regular_sample;

/* Curve over a stretch of s around a singular configuration (theory 4.11, singular_bridge.c); h is signed. */
typedef struct km_singular_bridge {
  int number, count;     /* number of this bridge, 0: none; count of all bridges built */
  double smallest_pivot; /* smallest relative pivot at the nodes */
  km_node_curve curve;
} km_singular_bridge;

/* Steps of a motion to a target; a target further away than as many longest steps is unreachable, and fewer are enough
 * to find an end or a limit before it. */
enum { KM_MOST_DRIVER_STEPS = 200000, KM_MOST_STEPS_TO_UNREACHABLE = 10000 };

struct km_driver_motion {
  km_arena arena;
  km_continuation c;
  km_driver_motion_position current;
  km_driver_motion_snapshot mark, passed[2]; /* user's snapshot; two passed configurations, the latest first */
  km_driver_motion_snapshot before_bridge;   /* snapshot at which a bridge is built */
  bool crosses_singular;                     /* the step crosses a singular configuration deliberately: no sign test */
  double *from_bridge;                       /* [3 · columns] configuration, workspace of singular_bridge.c */
  km_driver_regular_sample regular;
  km_singular_bridge bridge;
  km_minimum_norm_path path;         /* explicit predictor with several freedoms */
  km_nearest_configuration *closest; /* implicit predictor of stiff paths; NULL: not allocated yet */
  int rejections;                    /* rejected steps in a row */
  bool implicit;                     /* the last prediction was the implicit one */
  double error_ratio;                /* error of the last prediction over the allowed error */
  km_step_observer observer;
  struct km_batch *lanes; /* batch that advances this motion, and its lane; NULL: none */
  int lane;
};

/* Factor from the model's unit to the scaled driver. */
static inline double km_driver_motion_factor(const km_driver_motion *d) {
  const km_mechanism *m = d->c.mechanism;
  return m->factor[d->c.coordinate] / m->unit[d->c.coordinate];
}
/* Rounding error allowed at the driver's own limit. */
static inline double km_driver_motion_slack(double goal) {
  return 1e-12 * (1.0 + fabs(goal));
}

static inline const km_substructure *km_driver_motion_substructure(const km_driver_motion *d) {
  return km_continuation_sub(&d->c);
}

/* km_driver_motion_create and km_driver_motion_free that take the memory from `memory` and give it back there. */
km_status km_driver_motion_create_in(km_arena *memory, const km_mechanism *mechanism, km_state *state, int coordinate,
                                     bool ignore_limits, km_driver_motion **out, km_error *error);
void km_driver_motion_free_into(km_arena *memory, km_driver_motion *drive);

/* Converts the tangent t[column · stride] to rates of all coordinates per unit rate of the driver: radians, model's
 * length. */
void km_driver_motion_rates(const km_driver_motion *drive, const double *t, int stride, double *rates);
/* Stores and restores the configuration with everything that the next steps depend on. */
void km_driver_motion_store(km_driver_motion *drive, km_driver_motion_snapshot *snapshot);
void km_driver_motion_restore_snapshot(km_driver_motion *drive, const km_driver_motion_snapshot *snapshot);
/* Sets the observer of intermediate steps. */
static inline void km_driver_motion_set_observer(km_driver_motion *d, km_step_observer observer) {
  d->observer = observer;
}
/* Notifies the observer of a step to s (scaled) with the tangent t[column · stride]. */
void km_driver_motion_notify(const km_driver_motion *drive, double s, const double *t, int stride);
/* Selects the implicit predictor for the next step: near a singular configuration the path of least motion is stiff. */
void km_driver_motion_expect_stiff(km_driver_motion *drive);
/* Stores the configuration for km_driver_motion_restore_previous, which knows the last two: with several freedoms the
 * return path to s can differ from the path that led here. False without memory. */
bool km_driver_motion_save_passed(km_driver_motion *drive);
/* Restores the last stored configuration between s and the mark; false, without effect, if there is none. */
bool km_driver_motion_restore_previous(km_driver_motion *drive, double s);
/* Computes pivots and tangent of the present configuration if they are unknown and the target differs from s. */
void km_driver_motion_prepare(km_driver_motion *drive, double target);
/* Takes the first step towards the target if several are needed; km_driver_motion_move_to continues with the same
 * bits. */
void km_driver_motion_begin(km_driver_motion *drive, double target);

#endif
