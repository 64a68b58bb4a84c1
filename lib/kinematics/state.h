/* State of one thread: configuration, closure errors, Jacobian, factorisations and null spaces of a mechanism.
 *
 *   q      configuration, by coordinate       J, e   Jacobian and closure errors, by substructure (docs/theory.md 2.3)
 *   p      factor of J (3.1)                  Z      orthonormal basis of the null space of J, in the metric D (3.4)
 *
 * Kernels take (mechanism, state) and allocate nothing: km_state_create reserves all arrays but those of large
 * factors. */
#ifndef KM_KINEMATICS_STATE_H
#define KM_KINEMATICS_STATE_H

#include "linalg/factor.h"
#include "topology/mechanism.h"

/* Multiplications of a search over starts or exchanges: about a second. */
static const double km_search_work = 1e9;

/* Displacement of a slot of a planar program from its configuration with all coordinates 0. */
typedef struct km_planar_pose {
  double angle, cosine, sine, x, y;
} km_planar_pose;

/* Twist of a slot relative to the base, and its acceleration at zero joint accelerations (docs/theory.md 2.6). */
typedef struct km_slot_motion {
  km_twist twist, product;
} km_slot_motion;

/* Configuration at which errors and Jacobian of a substructure were evaluated. */
typedef struct km_cached_configuration {
  double *coordinates;        /* [3 · columns] as km_state_save writes it */
  bool is_valid;              /* errors and Jacobian belong to `coordinates` */
  unsigned mechanism_version; /* `version` of the mechanism at that evaluation */
} km_cached_configuration;

/* Source of a coordinate's rate. Where rates contradict each other, the caller's have precedence over the model's. */
typedef enum km_rate_source {
  KM_RATE_FOLLOWS, /* not stated: it follows from the others */
  KM_RATE_MODEL,   /* the model's initial rate */
  KM_RATE_CALLER   /* km_state_set_rate */
} km_rate_source;

struct km_state {
  km_arena arena;
  const km_mechanism *mechanism;
  double *q;                       /* [coordinate] radians, or the model's length unit; of a ball joint its rotation
                                    * vector, derived from `ball` */
  double *rate;                    /* [coordinate] per the model's time unit; of a ball joint the components of its
                                    * angular velocity */
  km_rate_source *rate_source;     /* [coordinate] source of the rate */
  double *acceleration;            /* [coordinate] second derivatives of q; set by km_dynamics_accelerate */
  double time;                     /* the model's time unit */
  km_quaternion *ball;             /* [ball] unit quaternions of the ball motions; set by km_state_move, km_state_set */
  double *jacobian;                /* [matrix_size] by substructure, in its pattern; set by km_loops_update */
  double *error;                   /* [error_size] closure errors of the rows, by substructure; set by
                                    * km_loops_update */
  km_twist *misfit;                /* [loop] all six components of the closure error, scaled; set by km_loops_update */
  km_factor **factor;              /* [substructure] of the Jacobian; set by km_search_pivots, km_loops_close */
  km_normal_equations **normal;    /* [substructure] normal equations of minimum-norm steps; freed by km_state_free */
  int normal_count;                /* substructure count, for km_state_free after the mechanism was freed */
  km_cached_configuration *cached; /* [substructure] last evaluation; set by km_loops_update */
  int *pivot_driver;               /* [substructure] driver column for which pivots were searched; KM_NEVER: pivots are
                                    * stale */
  bool *mobility_is_known;         /* [substructure] the null space is known for this configuration or an earlier one */
  double *mobility_number;         /* [coordinate] mobility numbers; set by km_mobility_compute */
  km_pose *pose;                   /* [body] in the inertial frame, model's length unit; set by km_poses_compute */
  km_pose *slot;                   /* [largest_slots] workspace of spatial programs */
  km_planar_pose *planar_slot;
  km_twist *twist;    /* [twist_count] unit twists h of the programs' steps; of a planar step (x, y, angle) in v; set by
                       * km_loops_update */
  km_vec3 *row_point; /* [loop] spatial loops: point at which the rows are taken, from the origin of the first branch;
                       * set by km_loops_update */
  km_slot_motion *slot_motion; /* [largest_slots] workspace of km_loops_velocity_products */
  double *work;                /* [largest_columns] */
  double *projection;          /* [largest_columns] workspace */
  bool *forced;                /* [largest_columns] */
  bool *locked;                /* [coordinate] locked by the state, in addition to the held joints of the mechanism; set
                                * by km_state_lock */
  bool *locked_column;         /* [columns of all substructures] `locked` by column, borrowed by the factors */
  bool *has_locked;            /* [substructure] some column is locked */
};

enum { KM_NO_DRIVER = -1, KM_NEVER = -2, KM_PRESCRIBED = -3 /* the prescribed columns of a motion are forced */ };

/* Marks the pivots as stale: they are searched again before the next use. */
static inline void km_state_invalidate_pivots(km_state *s, int substructure) {
  s->pivot_driver[substructure] = KM_NEVER;
}
static inline double *km_state_jacobian(km_state *s, const km_substructure *sub) {
  return s->jacobian + sub->matrix_start;
}
static inline double *km_state_error(km_state *s, const km_substructure *sub) {
  return s->error + sub->error_start;
}
/* Locked columns of a substructure; NULL: none. */
const bool *km_state_locked_columns(const km_state *state, int substructure);
/* Returns the basis Z of the present factor, which is formed if it is stale. NULL when out of memory (then
 * km_factor_freedom is 0 too). */
const double *km_state_basis(const km_state *state, int substructure);

/* True if the state belongs to the mechanism. km_check_state returns KM_USAGE otherwise. */
bool km_state_belongs_to(const km_mechanism *mechanism, const km_state *state);
km_status km_check_state(const km_mechanism *mechanism, const km_state *state, km_error *error);
/* True if pivots and null spaces of every substructure are known. Otherwise they must not be read. */
bool km_state_mobility_is_known(const km_mechanism *mechanism, const km_state *state);

/* Projects row[coordinate] / scale (a rate or forces) onto D · range(N) of a substructure with many freedoms:
 * y[columns]. It uses the Jacobian and no basis. False with few freedoms, where the basis is cheaper, or as
 * km_factor_project_null_space. */
bool km_state_project_onto_motions(const km_mechanism *mechanism, km_state *state, int substructure, const double *row,
                                   double *y);

/* Copies the Jacobian to a dense matrix J[rows × columns], column-major. */
void km_state_jacobian_dense(const km_state *state, const km_substructure *sub, double *J);
/* Sets the basis to one vector z[column · stride] that another method found. It is valid until the next
 * factorisation. */
void km_state_set_single_basis(km_state *state, int substructure, const double *z, size_t apart);
/* Marks the null space as known. Forms its basis unless km_factor_numbers_avoid_basis. */
void km_state_mark_mobility_known(km_state *state, int substructure);
/* Mobility numbers m_j (docs/theory.md 3.4) by column. No basis is formed if the freedoms are many. */
void km_state_mobility_numbers(const km_mechanism *mechanism, km_state *state, int substructure, double *numbers);
/* Adds a step to the coordinates of a substructure: step[column] scaled. A ball joint rotates by its three components,
 * about the axes of its parent frame. */
void km_state_move(const km_mechanism *mechanism, km_state *state, const km_substructure *sub, const double *step);
/* As km_state_move for a configuration that km_state_restore leaves again: only the quaternion of a ball joint is
 * updated, not its rotation vector, whose logarithm is costly. */
void km_state_move_temporarily(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                               const double *step);
/* Rotates a ball joint by a rotation vector along the parent frame's axes. */
void km_state_rotate_ball(const km_mechanism *mechanism, km_state *state, int ball, km_vec3 turn);
/* Sets a ball joint to a quaternion of any length. Its coordinates become the rotation vector nearest to the present
 * one. */
void km_state_set_ball(const km_mechanism *mechanism, km_state *state, int ball, km_quaternion place);
/* Sets every coordinate (radians, model's length unit). */
void km_state_set(const km_mechanism *mechanism, km_state *state, const double *q);
/* Locks a coordinate at its value until km_state_unlock (docs/theory.md 4.4): its Jacobian column is 0 and it is no
 * freedom in closing, continuation, tangents and mobility numbers. All three coordinates of a ball joint must be
 * locked. A loop keeps the rows that it has without the lock. */
void km_state_lock(km_state *state, int coordinate);
void km_state_unlock(km_state *state); /* unlocks all coordinates */
/* True if the coordinate is held by the mechanism or locked by the state. */
static inline bool km_state_is_fixed(const km_state *s, int coordinate) {
  return s->mechanism->held[coordinate] || s->locked[coordinate];
}
/* Converts q to the model's unit, q / factor. Rounded to ten decimals if that gives q back. */
double km_convert_unit(double q, double factor);
static inline double km_in_unit(double q, double factor) {
  return factor == 1.0 ? q : km_convert_unit(q, factor);
}
/* km_state_coordinate for a valid index. */
static inline double km_state_value(const km_state *s, int coordinate) {
  return km_in_unit(s->q[coordinate], s->mechanism->factor[coordinate]);
}
/* Clears the Jacobian columns of locked coordinates. Part of km_loops_update. */
void km_state_clear_locked(km_state *state, const km_substructure *sub);
/* Saves and restores the coordinates of one substructure, and the quaternions of its ball joints. */
enum { KM_SAVED_PER_COLUMN = 3 };
void km_state_save(const km_state *state, const km_substructure *sub, double *saved /* [3 · columns] */);
void km_state_restore(km_state *state, const km_substructure *sub, const double *saved);
/* True if the coordinates equal the saved ones bit by bit. */
bool km_state_is_at(const km_state *state, const km_substructure *sub, const double *saved);
/* Scaled step from the saved coordinates to the present ones. */
void km_state_difference(const km_state *state, const km_substructure *sub, const double *saved, double *step);
/* Angle of a ball joint beyond its limit: |q| − limit, for its first coordinate c and rotation vector q[3]. Negative
 * within the limit; -infinity without a limit. */
double km_state_ball_excess(const km_mechanism *mechanism, int c, const double *q);
/* Excess of a coordinate above (> 0) or below (< 0) its limits; 0 within them and their rounding. The limit of a ball
 * joint's angle counts for its first coordinate. */
double km_state_excess(const km_state *state, int coordinate);
/* True if the coordinate exceeds its limits by more than rounding. */
bool km_state_is_outside(const km_state *state, int coordinate);
/* First coordinate of the substructure that exceeds its limits; -1: none. */
int km_state_find_outside_limit(const km_state *state, const km_substructure *sub);
/* First coordinate of the substructure that exceeds its limit by more than at the saved configuration; -1: none. */
int km_state_limit_passed(const km_state *state, const km_substructure *sub, const double *saved);
/* First coordinate that exceeds a limit at an extremum of the step's cubic Hermite interpolant; -1: none. The
 * interpolant has the saved and the present configuration and the tangents t0, t1 (scaled, per unit of the parameter)
 * over the step h. Ball joints are omitted. */
int km_state_limit_touched(const km_state *state, const km_substructure *sub, const double *saved, const double *t0,
                           const double *t1, double h);
/* Copies the coordinates of one state to another of the same model. */
void km_state_copy(const km_mechanism *mechanism, km_state *to, const km_state *from);

#endif
