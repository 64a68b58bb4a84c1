/* A drive and what it remembers. Private to kinematics/. */
#ifndef KM_CONTINUATION_DRIVER_MOTION_H
#define KM_CONTINUATION_DRIVER_MOTION_H

#include "continuation/minimum_norm_path.h"
#include "continuation/predictor_corrector.h"
#include "kmech/continuation.h"

/* In radians or substructure sizes: the longest step of a driver, the step that a drive to the next target is begun with
 * at least, and how far any coordinate may go in a step. */
static const double km_drive_longest = 0.3, km_drive_least_first = 1e-3, km_drive_furthest = 0.6;
/* In substructure sizes, and in sizes per radian or size of the driver: a slide that is farther away, and faster, has left. */
static const double km_drive_away = 1e3;
/* A step reaches a target that is further away by so little, which may be rounding alone: the short step that would be left tells next to
 * nothing, and spoils what the next ones take from the tangents behind them. */
static const double km_drive_reach = 1.0 + 1e-6;
/* How closely a step has to keep to the prediction, and the same where a singular pose is crossed. */
static const double km_drive_tightness = 0.25, km_drive_crossing_tightness = 0.05;
/* Strain below which a step may become longer: one twice as long has 16 times the error over its length, one that is drawn to
 * the path of least motion 4 times. */
static const double km_drive_easy = 0.05;
/* A longer step leaves an end behind that was located before. */
static const double km_drive_leaves = 1e-6;

/* Where a drive is, beside its course and the state's pose. */
typedef struct km_drive_place {
  double s;       /* the driver, scaled */
  double largest; /* the step that step control allows now */
  double stopped; /* the direction that ended here, ±1, while the pose is close to that end; else 0 */
  int crossings;  /* singular poses passed so far */
  bool known;     /* the course's tangent belongs to the present pose */
  bool stiff;     /* the last step was drawn to the path: see km_least_path_draw */
  int bridge;     /* the bridge that the place is on; 0: none */
  int pivoted;    /* of a mark: the state's pivots were searched for this driver column; KM_NEVER */
} km_drive_place;

/* A place to come back to, with all that the next step from there depends on. */
typedef struct km_drive_kept {
  km_drive_place place;
  km_course course;
  double *pose; /* of the state, saved; NULL: no room yet */
  bool is_one;
} km_drive_kept;

/* Where a step was refused last that was long enough for the configuration to be away from a singular one. */
typedef struct km_drive_regular {
  double s;     /* the driver; infinite: there is no such place */
  double *pose; /* saved coordinates */
} km_drive_regular;

/* A stretch of the driver around a singular configuration that the motion passes smoothly: see drive_singular.c. */
enum { KM_BRIDGE_NODES = 4 };
typedef struct km_drive_bridge {
  int number, count;     /* of this one, 0: there is none; of all so far */
  double c, h;           /* its centre and the unit of its nodes' distances, signed, in the driver */
  double smallest_pivot; /* at the nodes, relative */
  double *nodes;         /* [KM_BRIDGE_NODES] saved coordinates */
  double *tangents;      /* [KM_BRIDGE_NODES × columns] */
} km_drive_bridge;

struct km_drive {
  km_arena arena;
  km_continuation c;
  km_drive_place here;
  km_drive_kept mark, passed[2]; /* the latest first */
  km_drive_kept before_bridge;   /* where a bridge is begun */
  bool passing;                  /* this step goes over a singular pose on purpose */
  double *near, *from_bridge;    /* [3 · columns] saved coordinates, workspace of drive_singular.c */
  km_drive_regular regular;
  km_drive_bridge bridge;
  km_least_path path;  /* where other freedoms are left */
  km_closest *closest; /* the same where the path is stiff; NULL: not yet */
  int bent;            /* steps refused one after the other */
  bool drawn;          /* the last prediction was */
  double strain;       /* of the last prediction by it: at 1 its error is all that is allowed */
  km_step_watch watch;
  struct km_drive_lanes *lanes; /* where this drive goes beside others, and which of them it is; NULL: alone */
  int lane;
};

/* How much correction a step allows, and the least cosine between its tangents. */
static inline double km_drive_most_correction(double tightness, double length) {
  return tightness * length + 1e-9;
}
static inline double km_drive_least_cosine(double tightness) {
  return 1.0 - tightness * 0.4;
}
/* Of the driver: a value in the model's unit times this is the scaled one. */
static inline double km_drive_factor(const km_drive *d) {
  const km_mechanism *m = d->c.mechanism;
  return m->factor[d->c.coordinate] / m->unit[d->c.coordinate];
}
/* The slack of a driver's own limit. */
static inline double km_drive_slack(double goal) {
  return 1e-12 * (1.0 + fabs(goal));
}

static inline const km_substructure *km_drive_driven(const km_drive *d) {
  return km_continuation_sub(&d->c);
}

/* km_drive_create and km_drive_free; the memory of an earlier drive is taken from `memory` and given back there. */
km_status km_drive_create_in(km_arena *memory, const km_mechanism *mechanism, km_state *state, int coordinate,
                             bool ignore_limits, km_drive **out, km_error *error);
void km_drive_free_into(km_arena *memory, km_drive *drive);

/* The rates of all coordinates per unit of the driver, by the tangent t[column · stride]. */
void km_drive_rates(const km_drive *drive, const double *t, int stride, double *rates);
/* Keeps the present place with all that the next step depends on, and comes back to it with the same bits. */
void km_drive_keep(km_drive *drive, km_drive_kept *kept);
void km_drive_come_back(km_drive *drive, const km_drive_kept *kept);
/* Who is told of the drive's steps. */
static inline void km_drive_watch(km_drive *d, km_step_watch watch) {
  d->watch = watch;
}
/* Tells of a step to s, scaled, with the tangent t[column · stride]. */
void km_drive_tell(const km_drive *drive, double s, const double *t, int stride);
/* The state has just left a singular pose, near which paths are stiff: see km_least_path_draw. */
void km_drive_expect_stiff(km_drive *drive);
/* Where other freedoms are left, a way back needn't be the one that led here. The present place is one from which
 * km_drive_return_before sets out again; the last two are. False when out of memory. */
bool km_drive_pass(km_drive *drive);
/* Back to the last place that was passed before s, on the way to the mark; false, and nothing happens, if there is none. */
bool km_drive_return_before(km_drive *drive, double s);
/* Searches pivots and tangent of the present pose, if there is a way to go to the target, and they aren't known. */
void km_drive_get_ready(km_drive *drive, double target);
/* The first of several steps towards the target, if it takes several and the first is accepted: km_drive_to goes on from
 * there with the same bits. */
void km_drive_begin(km_drive *drive, double target);

#endif
