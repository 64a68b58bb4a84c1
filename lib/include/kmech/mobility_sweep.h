/* Mobility numbers over the range of a driver. */
#ifndef KMECH_MOBILITY_SWEEP_H
#define KMECH_MOBILITY_SWEEP_H

#include "kmech/follow.h"
#include "kmech/mobility.h"
#include "kmech/sweep.h"
#include "kmech/table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Asked now and then during long work with how much is done (0 … 1); returns false to cancel. */
typedef bool (*km_progress)(void *context, double done);

typedef struct km_sweep_point {
  int frame;        /* of the model */
  const char *name; /* "body/frame", as the columns call it */
} km_sweep_point;

/* What to sweep. Start from km_sweep_plan_default(). */
typedef struct km_sweep_plan {
  int coordinate;   /* the driver; -1: the model's analysis.sweep */
  double from, to;  /* model's unit */
  int steps;        /* intervals; rows = steps + 1 */
  double arclength; /* > 0: by arc length instead, `steps` times this much; coordinate, from, to don't count */
  int direction;    /* the coordinate that starts the motion, -1: the one with the largest mobility number */
  double sign;      /* +1 or -1 */
  int branch;       /* by arc length, at the first branch point: 1 (or 0) goes on smoothly; 2, 3 take the next motion
                     * ahead and back, 4, 5 the one after, … */
  bool cycle;       /* by arc length: KM_PARTIAL unless the motion comes back to its start */
  bool ignore_limits;
  const km_sweep_point *points;
  int point_count;
  bool derivatives; /* of the points along s */
  km_progress progress;
  void *context;
} km_sweep_plan;

/* A pose at which a coordinate's mobility number passes through 0. */
typedef struct km_toggle {
  int coordinate;
  double s; /* of the driver, model's unit */
} km_toggle;

typedef struct km_extreme {
  double number, s; /* smallest mobility number over the rows, and where */
} km_extreme;

typedef struct km_mobility_sweep {
  km_table *table;     /* columns as cli.md: step, s, q., m., dof, dof.k, residual, point. */
  km_mobility first;   /* at the pose from which the sweep started */
  int substructure;    /* the one that moves, -1: a joint in no loop */
  int freedom;         /* of the driven substructure there: above 1 the others move least */
  int start_branches;    /* motions that meet at the starting pose, where it is a branch point; else 0 */
  km_reach start, end; /* how FROM and TO were reached */
  km_toggle *toggles;  /* in the order of the sweep */
  size_t toggle_count, toggle_capacity;
  km_branch_point *branches; /* where several motions meet; s is the driver's value, or the arc length */
  size_t branch_count, branch_capacity;
  double cycle;         /* by arc length: length of the closed cycle, 0 if it wasn't closed */
  km_extreme *extremes; /* [coordinate] */
} km_mobility_sweep;

/* The model's own plan: analysis.sweep with a driver. coordinate -1 where it has none. */
km_sweep_plan km_sweep_plan_default(const km_model *model);

/* Moves the assembled state from its pose to `from` without output, then gives steps + 1 rows. Where a part of
 * the range is out of reach the rows end (or begin) at the located bound and the status is KM_PARTIAL; start
 * and end say why. With one freedom the rows don't depend on `steps` (to 1e-8). Free `*out` in any case. */
km_status km_mobility_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                km_mobility_sweep *out, km_error *error);
void km_mobility_sweep_free(km_mobility_sweep *sweep);

#ifdef __cplusplus
}
#endif
#endif
