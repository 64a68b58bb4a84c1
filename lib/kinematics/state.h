/* One thread's copy of everything that moves. Allocated once; kernels take (mechanism, state). */
#ifndef KM_KINEMATICS_STATE_H
#define KM_KINEMATICS_STATE_H

#include "linalg/partition.h"
#include "topology/mechanism.h"

/* Pose of a slot in a planar program: turn and place since all coordinates were 0. */
typedef struct km_planar_pose {
  double angle, cosine, sine, x, y;
} km_planar_pose;

/* Of a slot against its base: its twist, and its acceleration where no rate changes. */
typedef struct km_slot_motion {
  km_twist twist, product;
} km_slot_motion;

/* A null space basis that grows with the freedom. */
typedef struct km_basis {
  km_arena *arena; /* the state's, in which it grows */
  double *Z;
  size_t capacity;
  bool is_known;              /* what moves was found at this pose or one before it */
  bool is_deferred;           /* the mobility numbers needed no basis: it is made when it is first asked for */
  int count;                  /* vectors of it: 0 while it holds rows */
  unsigned partition_version; /* of the partition that they were made from */
} km_basis;

/* A second partition: of the present pose, or of one to come back to. By km_partition_stash */
typedef struct km_stashed_partition {
  km_partition stored;
  bool is_reserved, is_swapped; /* is_out: the other one is the pose's to come back to */
} km_stashed_partition;

/* The pose of a substructure's errors and Jacobian, and the last search for pivots. */
typedef struct km_cached_configuration {
  double *coordinates;           /* as km_state_save leaves it */
  bool is_valid;                 /* errors and Jacobian are of `pose` */
  unsigned mechanism_version;    /* the mechanism's edition then */
  unsigned evaluations;          /* how many poses were shown */
  unsigned evaluation_at_search; /* `count` at the last search */
  unsigned partition_version;    /* the partition's edition after it */
  int driver;                    /* what was asked for: of km_search_pivots, */
  bool forced_never_pivot;       /* and of the partition */
  double tolerance;
} km_cached_configuration;

/* Who states a coordinate's rate. Of rates that contradict each other, those of the caller come before the model's. */
typedef enum km_rate_source {
  KM_RATE_FOLLOWS, /* nobody: it follows the others */
  KM_RATE_MODEL,   /* the model's initial rate */
  KM_RATE_CALLER   /* km_state_set_rate */
} km_rate_source;

struct km_state {
  km_arena arena;
  const km_mechanism *mechanism;
  double *q;    /* [coordinate] radians, or the model's length unit. A ball's: rotation vector, derived */
  double *rate; /* [coordinate] per the model's time unit; a ball's: its angular velocity's components */
  km_rate_source *rate_source;   /* [coordinate] who states the rate */
  double *acceleration;          /* [coordinate] the rates' rates. By km_dynamics_accelerate */
  double time;                   /* the model's time unit */
  km_quaternion *ball;           /* [ball] what a ball's coordinates really are. By km_state_move, km_state_set */
  double *jacobian;              /* [matrix_size] by substructure, in its pattern. By km_loops_update */
  double *error;                 /* [error_size] by substructure, the rows' errors. By km_loops_update */
  km_twist *misfit;              /* [loop] whole error screws, scaled. By km_loops_update */
  km_partition *partition;       /* [substructure] of the Jacobian. By km_closure */
  km_normal_equations **normal;  /* [substructure] what their least steps keep. By km_state_free */
  int normal_count;              /* the mechanism may be gone by then */
  km_stashed_partition *stashed; /* [substructure] large ones' second partitions */
  km_cached_configuration
      *cached;             /* [substructure] the pose and the search at hand. By km_loops_update, km_search_pivots */
  int *pivot_driver;       /* [substructure] driver column that its pivots were searched for; KM_NEVER */
  km_basis *basis;         /* [substructure] Z: columns × freedom. By km_state_null_space */
  double *mobility_number; /* [coordinate] mobility numbers. By km_mobility_compute */
  km_pose *pose;           /* [body] in the inertial frame, model's length unit. By km_poses_compute */
  km_pose *slot;           /* [largest_slots] workspace of spatial programs */
  km_planar_pose *planar_slot;
  km_twist *twist;    /* [twist_count] columns of the programs' steps, a planar one's as (x, y, turn) in v. By
                    * km_loops_update */
  km_vec3 *row_point; /* [loop] in space: where its rows are taken, from its first branch's origin. By the same */
  km_slot_motion *slot_motion; /* [largest_slots] workspace of km_loops_velocity_products */
  double *work;                /* [largest_columns] */
  double *projection;          /* [largest_columns] of km_minimum_norm_step */
  bool *forced;                /* [largest_columns] */
  bool *locked;                /* [coordinate] held by the state, beside what the mechanism holds. By km_state_lock */
  bool *locked_column;         /* [columns of all substructures] the same, for their partitions */
};

enum { KM_NO_DRIVER = -1, KM_NEVER = -2, KM_PRESCRIBED = -3 /* the prescribed columns of a motion are forced */ };

/* The pivots at hand don't belong to the present pose: they are searched anew before they are used. */
static inline void km_state_invalidate_pivots(km_state *s, int substructure) {
  s->pivot_driver[substructure] = KM_NEVER;
}
static inline double *km_state_jacobian(km_state *s, const km_substructure *sub) {
  return s->jacobian + sub->matrix_start;
}
static inline double *km_state_error(km_state *s, const km_substructure *sub) {
  return s->error + sub->error_start;
}
/* The basis of all motions by the partition at hand, made where it isn't there yet. NULL when out of memory (then
 * km_partition_freedom is 0 too). */
const double *km_state_basis(const km_state *state, int substructure);

/* For public functions: is this a state of the mechanism? KM_USAGE where it isn't. */
bool km_state_belongs_to(const km_mechanism *mechanism, const km_state *state);
km_status km_check_state(const km_mechanism *mechanism, const km_state *state, km_error *error);
/* Have pivots been searched and null spaces made for every substructure? Else nobody may read them. */
bool km_state_mobility_is_known(const km_mechanism *mechanism, const km_state *state);

/* Of the row of a rate, or of forces, row[coordinate] over the scales, what it has of a substructure's motions D · range(N): y[columns],
 * without a basis of them, by the Jacobian at hand. False where there are few freedoms, whose basis serves, or as
 * km_partition_project_null_space. */
bool km_state_project_onto_motions(const km_mechanism *mechanism, km_state *state, int substructure, const double *row,
                                   double *y);

/* J as a whole matrix: J[rows × columns], column-major. */
void km_state_jacobian_dense(const km_state *state, const km_substructure *sub, double *J);
/* km_partition_null_space of a substructure's partition with the weights D, into the state: Z[count × columns], those that are
 * there already not again. NULL when out of memory (then km_partition_freedom is 0 too). */
double *km_state_null_space(const km_mechanism *mechanism, const km_state *state, int substructure, int count);
/* Makes the only motion that is left the basis, found elsewhere than by the partition at hand: z[column], `apart` from each
 * other. Until the partition is factored anew. */
void km_state_set_single_basis(km_state *state, int substructure, const double *z, size_t apart);
/* What moves is known from the partition at hand: the basis is made, unless many motions let it wait. */
void km_state_mark_mobility_known(km_state *state, int substructure);
/* Mobility numbers by column. Those of many freedoms need no basis, which is made when someone asks for it. */
void km_state_mobility_numbers(const km_mechanism *mechanism, km_state *state, int substructure, double *numbers);
/* km_partition_row_space in the same place: R[rank × columns]. NULL when out of memory. */
double *km_state_row_space(const km_mechanism *mechanism, km_state *state, int substructure, int count);

/* Adds a step to the coordinates of a substructure: step[column] scaled; a ball turns about the axes of the
 * joint's parent frame. */
void km_state_move(const km_mechanism *mechanism, km_state *state, const km_substructure *sub, const double *step);
/* The same for a pose that is left again by km_state_restore: of a ball the quaternion moves alone, not its coordinates, which take
 * longer to find. */
void km_state_move_temporarily(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                               const double *step);
/* Turns a ball by a rotation vector along the parent frame's axes. */
void km_state_rotate_ball(const km_mechanism *mechanism, km_state *state, int ball, km_vec3 turn);
/* Puts a ball at a quaternion of any length; its coordinates become the rotation vector nearest to theirs. */
void km_state_set_ball(const km_mechanism *mechanism, km_state *state, int ball, km_quaternion place);
/* Sets every coordinate (radians, model's length unit). */
void km_state_set(const km_mechanism *mechanism, km_state *state, const double *q);
/* Keeps a coordinate at its value until km_state_unlock: closing, driving, following, tangents and mobility numbers of
 * this state take it for rigid, since its columns are 0 and count as no freedom. Of a ball all three are locked. A loop
 * keeps the rows that it has without the lock: lib/README.md, Holds. */
void km_state_lock(km_state *state, int coordinate);
void km_state_unlock(km_state *state); /* all of them */
/* Does the coordinate keep its value, by the mechanism or by the state? */
static inline bool km_state_is_fixed(const km_state *s, int coordinate) {
  return s->mechanism->held[coordinate] || s->locked[coordinate];
}
/* Value of a coordinate in the model's unit, of which q is `factor` times as much. */
double km_convert_unit(double q, double factor);
static inline double km_in_unit(double q, double factor) {
  return factor == 1.0 ? q : km_convert_unit(q, factor);
}
/* km_state_coordinate of a coordinate that there is. */
static inline double km_state_value(const km_state *s, int coordinate) {
  return km_in_unit(s->q[coordinate], s->mechanism->factor[coordinate]);
}
/* Clears the columns of what is locked in a substructure's Jacobian. Part of km_loops_update. */
void km_state_clear_locked(km_state *state, const km_substructure *sub);
/* The coordinates of one substructure, to come back to. */
enum { KM_SAVED_PER_COLUMN = 3 };
void km_state_save(const km_state *state, const km_substructure *sub, double *saved /* [3 · columns] */);
void km_state_restore(km_state *state, const km_substructure *sub, const double *saved);
/* Are the coordinates the saved ones, to the last bit? */
bool km_state_is_at(const km_state *state, const km_substructure *sub, const double *saved);
/* The scaled step that leads from the saved coordinates to the present ones. */
void km_state_difference(const km_state *state, const km_substructure *sub, const double *saved, double *step);
/* How far a ball whose first coordinate is c, with the rotation vector q[3], is past the limit of its angle; negative:
 * within it, -infinity where there is none. */
double km_state_ball_excess(const km_mechanism *mechanism, int c, const double *q);
/* How far the coordinate is above (> 0) or below (< 0) its limits; 0 within them, rounding included. Of a ball's first one
 * the turn beyond the limit of its angle. */
double km_state_excess(const km_state *state, int coordinate);
/* Is the coordinate outside its limits, by more than rounding? */
bool km_state_is_outside(const km_state *state, int coordinate);
/* The coordinate of the substructure that is outside its limits; -1 none. */
int km_state_find_outside_limit(const km_state *state, const km_substructure *sub);
/* The coordinate of the substructure that is outside its limit, and further out than at the saved pose; -1 none. */
int km_state_limit_passed(const km_state *state, const km_substructure *sub, const double *saved);
/* The same for the way from the saved pose, by the cubic through both poses with the tangents t0 and t1 (scaled, per
 * unit of the way's parameter, over h of it): a coordinate may turn outside its limit and come back. */
int km_state_limit_touched(const km_state *state, const km_substructure *sub, const double *saved, const double *t0,
                           const double *t1, double h);
/* Copies the coordinates of one state to another of the same model. */
void km_state_copy(const km_mechanism *mechanism, km_state *to, const km_state *from);

#endif
