/* Sweeps: what to move, over which range, and what every sweep gives, whatever it looks at. */
#ifndef KMECH_SWEEP_PLAN_H
#define KMECH_SWEEP_PLAN_H

#include "kmech/follow.h"
#include "kmech/mobility.h"
#include "kmech/progress.h"
#include "kmech/sweep.h"
#include "kmech/table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A point whose way a sweep writes down. */
typedef struct km_sweep_point {
  int frame;        /* of the model */
  const char *name; /* "body/frame", as the columns call it */
} km_sweep_point;

enum {
  KM_MOST_SWEEP_STEPS = 10000000 /* the most intervals */
};

/* What to sweep. Start from km_sweep_plan_default(). */
typedef struct km_sweep_plan {
  int coordinate;  /* the driver; -1: the model's analysis.sweep */
  double from, to; /* model's unit */
  int steps;       /* intervals; rows = steps + 1. 0: one row at the state's pose, where nothing moves */
  /* > 0: by arc length instead, `steps` times this much (more than 1e-8, at most 1000); coordinate, from, to don't count */
  double arclength;
  int direction;      /* the coordinate that starts the motion, -1: the one with the largest mobility number */
  double sign;        /* +1 or -1 */
  int branch;         /* by arc length, at the first branch point: 1 (or 0) goes on smoothly; 2, 3 take the next motion
                     * ahead and back, 4, 5 the one after, … */
  bool cycle;         /* by arc length: KM_PARTIAL unless the motion comes back to its start */
  bool ignore_limits; /* joints go beyond their limits */
  const km_sweep_point *points; /* [point_count] whose way is written down */
  int point_count;
  bool derivatives;   /* of the points along s */
  bool singularities; /* of mobility sweeps: the smallest kept singular value too */
  km_progress progress;
  void *context;
} km_sweep_plan;

/* The rows of a sweep, and how the mechanism moved. */
typedef struct km_sweep {
  km_table *table;        /* step, s, q.; the columns of what is looked at; dof, dof.k, residual, point. (cli.md) */
  km_table *between;      /* the same columns at poses between rows, where a curve grows without bound; step 0 */
  km_mobility first;      /* at the pose from which the sweep started */
  int substructure;       /* the one that moves, -1: a joint in no loop */
  int freedom;            /* of the driven substructure there: above 1 the others move least */
  int idle;               /* how many of them are idle (kmech/idle.h): nothing else feels them */
  int shaking;            /* how many of them no motion follows, though first order allows them all along */
  bool *idle_coordinates; /* [coordinate] of joints that idle bodies turn in; NULL: idle is 0 */
  int start_branches;     /* motions that meet at the starting pose, where it is a branch point; else 0 */
  km_reach start, end;    /* how FROM and TO were reached */
  char *causes[2];        /* of start and end at a dead point: the links that are in line, or the joints whose axes are
                              * dependent; NULL: none, or it can't be told */
  double rank_value
      [2]; /* of start and end where the rank changes within the closure tolerance, which is no dead point: the
                              * singular value that decides it, over the largest; else 0 */
  km_branch_point *branches; /* where several motions meet; s is the driver's value, or the arc length */
  size_t branch_count, branch_capacity;
  double cycle; /* by arc length: length of the closed cycle, 0 if it wasn't closed */
} km_sweep;

/* The model's own plan: analysis.sweep with a driver. coordinate -1 where it has none. */
KM_API km_sweep_plan km_sweep_plan_default(const km_model *model);
/* Where the assembled state's pose is outside the limits of what the plan's driver moves: moves the driver towards
 * FROM, then towards TO, to the first pose where they all hold, located to 1e-12; from there on they count.
 * KM_NO_RESULT if there is none: then no pose of the range is in reach, and a sweep has no row. */
KM_API km_status km_sweep_enter_limits(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_error *error);
KM_API void km_sweep_free(km_sweep *sweep);

#ifdef __cplusplus
}
#endif
#endif
