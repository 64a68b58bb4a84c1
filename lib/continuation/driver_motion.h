/* A drive and what it remembers. Private to kinematics/. */
#ifndef KM_CONTINUATION_DRIVER_MOTION_H
#define KM_CONTINUATION_DRIVER_MOTION_H

#include "continuation/minimum_norm_path.h"
#include "continuation/predictor_corrector.h"
#include "kmech/continuation.h"

/* In radians or substructure sizes: the longest step of a driver, the step that a drive to the next target is begun with
 * at least, and how far any coordinate may go in a step. */
static const double km_driver_longest_step = 0.3, km_driver_motion_least_first = 1e-3, km_driver_motion_furthest = 0.6;
/* In substructure sizes, and in sizes per radian or size of the driver: a slide that is farther away, and faster, has left. */
static const double km_driver_motion_away = 1e3;
/* A step reaches a target that is further away by so little, which may be rounding alone: the short step that would be left tells next to
 * nothing, and spoils what the next ones take from the tangents behind them. */
static const double km_driver_motion_reach = 1.0 + 1e-6;
/* How closely a step has to keep to the prediction, and the same where a singular pose is crossed. */
static const double km_driver_motion_tightness = 0.25, km_driver_motion_crossing_tightness = 0.05;
/* Strain below which a step may become longer: one twice as long has 16 times the error over its length, one that is drawn to
 * the path of least motion 4 times. */
static const double km_driver_motion_easy = 0.05;
/* A longer step leaves an end behind that was located before. */
static const double km_driver_motion_leaves = 1e-6;

/* Where a drive is, beside its course and the state's pose. */
typedef struct km_driver_motion_place {
  double s;       /* the driver, scaled */
  double largest; /* the step that step control allows now */
  double stopped; /* the direction that ended here, ±1, while the pose is close to that end; else 0 */
  int crossings;  /* singular poses passed so far */
  bool known;     /* the course's tangent belongs to the present pose */
  bool stiff;     /* the last step was drawn to the path: see km_minimum_norm_path_record */
  int bridge;     /* the bridge that the place is on; 0: none */
  int pivoted;    /* of a mark: the state's pivots were searched for this driver column; KM_NEVER */
} km_driver_motion_place;

/* A place to come back to, with all that the next step from there depends on. */
typedef struct km_driver_motion_snapshot {
  km_driver_motion_place place;
  km_step_history course;
  double *pose; /* of the state, saved; NULL: no room yet */
  bool is_one;
} km_driver_motion_snapshot;

/* Where a step was refused last that was long enough for the configuration to be away from a singular one. */
typedef struct km_driver_regular_sample {
  double s;     /* the driver; infinite: there is no such place */
  double *pose; /* saved coordinates */
} km_driver_regular_sample;

/* A stretch of the driver around a singular configuration that the motion passes smoothly: see drive_singular.c. */
enum { KM_BRIDGE_NODES = 4 };
typedef struct km_singular_bridge {
  int number, count;     /* of this one, 0: there is none; of all so far */
  double c, h;           /* its centre and the unit of its nodes' distances, signed, in the driver */
  double smallest_pivot; /* at the nodes, relative */
  double *nodes;         /* [KM_BRIDGE_NODES] saved coordinates */
  double *tangents;      /* [KM_BRIDGE_NODES × columns] */
} km_singular_bridge;

struct km_driver_motion {
  km_arena arena;
  km_continuation c;
  km_driver_motion_place here;
  km_driver_motion_snapshot mark, passed[2]; /* the latest first */
  km_driver_motion_snapshot before_bridge;   /* where a bridge is begun */
  bool passing;                              /* this step goes over a singular pose on purpose */
  double *near, *from_bridge;                /* [3 · columns] saved coordinates, workspace of drive_singular.c */
  km_driver_regular_sample regular;
  km_singular_bridge bridge;
  km_minimum_norm_path path;         /* where other freedoms are left */
  km_nearest_configuration *closest; /* the same where the path is stiff; NULL: not yet */
  int bent;                          /* steps refused one after the other */
  bool drawn;                        /* the last prediction was */
  double strain;                     /* of the last prediction by it: at 1 its error is all that is allowed */
  km_step_watch watch;
  struct km_batch *lanes; /* where this drive goes beside others, and which of them it is; NULL: alone */
  int lane;
};

/* How much correction a step allows, and the least cosine between its tangents. */
static inline double km_driver_motion_most_correction(double tightness, double length) {
  return tightness * length + 1e-9;
}
static inline double km_driver_motion_least_cosine(double tightness) {
  return 1.0 - tightness * 0.4;
}
/* Of the driver: a value in the model's unit times this is the scaled one. */
static inline double km_driver_motion_factor(const km_driver_motion *d) {
  const km_mechanism *m = d->c.mechanism;
  return m->factor[d->c.coordinate] / m->unit[d->c.coordinate];
}
/* The slack of a driver's own limit. */
static inline double km_driver_motion_slack(double goal) {
  return 1e-12 * (1.0 + fabs(goal));
}

static inline const km_substructure *km_driver_motion_substructure(const km_driver_motion *d) {
  return km_continuation_sub(&d->c);
}

/* km_driver_motion_create and km_driver_motion_free; the memory of an earlier drive is taken from `memory` and given back there. */
km_status km_driver_motion_create_in(km_arena *memory, const km_mechanism *mechanism, km_state *state, int coordinate,
                                     bool ignore_limits, km_driver_motion **out, km_error *error);
void km_driver_motion_free_into(km_arena *memory, km_driver_motion *drive);

/* The rates of all coordinates per unit of the driver, by the tangent t[column · stride]. */
void km_driver_motion_rates(const km_driver_motion *drive, const double *t, int stride, double *rates);
/* Keeps the present place with all that the next step depends on, and comes back to it with the same bits. */
void km_driver_motion_store(km_driver_motion *drive, km_driver_motion_snapshot *kept);
void km_driver_motion_recall(km_driver_motion *drive, const km_driver_motion_snapshot *kept);
/* Who is told of the drive's steps. */
static inline void km_driver_motion_watch(km_driver_motion *d, km_step_watch watch) {
  d->watch = watch;
}
/* Tells of a step to s, scaled, with the tangent t[column · stride]. */
void km_driver_motion_notify(const km_driver_motion *drive, double s, const double *t, int stride);
/* The state has just left a singular pose, near which paths are stiff: see km_minimum_norm_path_record. */
void km_driver_motion_expect_stiff(km_driver_motion *drive);
/* Where other freedoms are left, a way back needn't be the one that led here. The present place is one from which
 * km_driver_motion_restore_previous sets out again; the last two are. False when out of memory. */
bool km_driver_motion_pass(km_driver_motion *drive);
/* Back to the last place that was passed before s, on the way to the mark; false, and nothing happens, if there is none. */
bool km_driver_motion_restore_previous(km_driver_motion *drive, double s);
/* Searches pivots and tangent of the present pose, if there is a way to go to the target, and they aren't known. */
void km_driver_motion_prepare(km_driver_motion *drive, double target);
/* The first of several steps towards the target, if it takes several and the first is accepted: km_driver_motion_move_to goes on from
 * there with the same bits. */
void km_driver_motion_begin(km_driver_motion *drive, double target);

#endif
