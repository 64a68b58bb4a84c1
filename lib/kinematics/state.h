/* One thread's copy of everything that moves. Allocated once; kernels take (mechanism, state). */
#ifndef KM_KINEMATICS_STATE_H
#define KM_KINEMATICS_STATE_H

#include "partition/partition.h"
#include "topology/mechanism.h"

/* Pose of a slot in a planar program: turn and place since all coordinates were 0. */
typedef struct km_planar_pose {
  double angle, cosine, sine, x, y;
} km_planar_pose;

struct km_state {
  km_arena arena;
  const km_mechanism *mechanism;
  double *q;               /* [coordinate] radians, or the model's length unit. A ball's: rotation vector, derived */
  km_quaternion *ball;     /* [ball] what a ball's coordinates really are. By km_state_move, km_state_set */
  double *jacobian;        /* [matrix_size] by substructure, rows × columns. By km_loops_update */
  double *error;           /* [error_size] by substructure, the rows' errors. By km_loops_update */
  km_twist *misfit;        /* [loop] whole error screws, scaled. By km_loops_update */
  km_partition *partition; /* [substructure] of the Jacobian. By km_closure */
  int *pivoted;            /* [substructure] driver column that its pivots were searched for; KM_NEVER */
  double *basis;           /* [basis_size] by substructure, Z: columns × freedom. By km_mobility_update */
  double *numbers;         /* [coordinate] mobility numbers. By km_mobility_update */
  km_pose *pose;           /* [body] in the inertial frame, model's length unit. By km_poses_update */
  km_pose *slot;           /* [largest_slots] workspace of spatial programs */
  km_planar_pose *planar_slot;
  km_twist *twist; /* [3 · longest program] columns of the steps */
  double *work;    /* [largest_columns] */
  bool *forced;    /* [largest_columns] */
};

enum { KM_NO_DRIVER = -1, KM_NEVER = -2 };

static inline double *km_state_jacobian(km_state *s, const km_substructure *sub) {
  return s->jacobian + sub->matrix_start;
}
static inline double *km_state_error(km_state *s, const km_substructure *sub) {
  return s->error + sub->error_start;
}
static inline double *km_state_basis(km_state *s, const km_substructure *sub) {
  return s->basis + sub->basis_start;
}

/* Space for the partition of one substructure's Jacobian, dense or sparse, whichever is faster. False when out of
 * memory. */
bool km_state_reserve_partition(const km_mechanism *mechanism, km_state *state, int substructure);

/* Adds a step to the coordinates of a substructure: step[column] scaled; a ball turns about the axes of the
 * joint's parent frame. */
void km_state_move(const km_mechanism *mechanism, km_state *state, const km_substructure *sub, const double *step);
/* Sets every coordinate (radians, model's length unit). */
void km_state_set(const km_mechanism *mechanism, km_state *state, const double *q);
/* Sets one scalar coordinate, which must not belong to a ball. */
void km_state_set_one(km_state *state, int coordinate, double value);
/* The coordinates of one substructure, to come back to. */
enum { KM_SAVED_PER_COLUMN = 3 };
void km_state_save(const km_state *state, const km_substructure *sub, double *saved /* [3 · columns] */);
void km_state_restore(km_state *state, const km_substructure *sub, const double *saved);
/* The scaled step that leads from the saved coordinates to the present ones. */
void km_state_difference(const km_state *state, const km_substructure *sub, const double *saved, double *step);
/* Is the coordinate outside its limits, by more than rounding? */
bool km_state_is_outside(const km_state *state, int coordinate);
/* The coordinate of the substructure that is outside its limits; -1 none. */
int km_state_outside(const km_state *state, const km_substructure *sub);
/* The coordinate of the substructure that is outside its limit, and further out than at the saved pose; -1 none. */
int km_state_limit_passed(const km_state *state, const km_substructure *sub, const double *saved);
/* The same for the way from the saved pose, by the cubic through both poses with the tangents t0 and t1 (scaled, per
 * unit of the way's parameter, over h of it): a coordinate may turn outside its limit and come back. */
int km_state_limit_touched(const km_state *state, const km_substructure *sub, const double *saved, const double *t0,
                           const double *t1, double h);
/* Does a full turn of the coordinate bring the mechanism back? True for hinges, not for slides, screws, balls. */
bool km_coordinate_turns(const km_mechanism *mechanism, int coordinate);
/* Copies the coordinates of one state to another of the same model. */
void km_state_copy(const km_mechanism *mechanism, km_state *to, const km_state *from);

#endif
