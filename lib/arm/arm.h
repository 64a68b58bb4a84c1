/* A serial chain from the inertial frame to an effector: forward kinematics and the scaled Jacobian (docs/theory.md
 * 12.1).
 *
 * All quantities refer to the arm's length scale L and to a point of its first joint: a coordinate is an angle in
 * radians, or a travel over L. So neither the model's units nor a distant inertial origin change any digit. */
#ifndef KM_ARM_ARM_H
#define KM_ARM_ARM_H

#include "kinematics/body_poses.h"
#include "kmech/arm.h"
#include "spatial/inertia.h"

enum { KM_ARM_ROWS = 6, KM_ARM_MAX_JOINTS = 32 };

/* One primitive motion of the chain. */
typedef struct km_arm_motion {
  km_primitive primitive;
  int axis;
  int column;        /* column of the Jacobian */
  double sign;       /* −1: reversed joint */
  double pitch;      /* travel per radian of a helical motion, over L */
  bool has_rotation; /* `before` contains a rotation */
  km_pose before;    /* displacement from the previous motion to this one's frame */
} km_arm_motion;

/* Inertial data of an arm. A force belongs to a coordinate of the arm: force · length of the model, also of a slide,
 * whose coordinate is a travel over L. Times are seconds. */
typedef struct km_arm_mass {
  bool has_mass;       /* a link or a drive has inertia */
  km_vec3 gravity;     /* L/s² */
  km_inertia *inertia; /* [n] all bodies that move with coordinate k and no later one, in the frame of motion k */
  double *armature;    /* [n] force per acceleration */
  double *damping;     /* [n] force per rate */
  double *force_limit; /* [n] largest force of the drive; infinity: none */
} km_arm_mass;

struct km_arm {
  km_arena arena;
  const km_mechanism *mechanism;
  int frame; /* effector: frame of the model */
  km_task task;
  int n;
  int rows;    /* rows of the Jacobian: rows of the task that the motions can change; fewer than task_rows for planar
             * arms, for example */
  int freedom; /* n − rows: dimension of the self-motion at regular configurations */
  int task_rows;
  double basis[KM_ARM_ROWS][KM_ARM_ROWS]; /* [rows × task_rows] orthonormal basis of the Jacobian's rows in the
                                           * task's rows */
  double length;                          /* L, in the model's length unit */
  double max_travel;                      /* slides beyond this travel count as diverged; several times the arm's
                                           * size, over L */
  /* Squared weight of position errors: 1, less for arms longer than 100 L, whose rounding grows with their size. */
  double position_weight;
  km_vec3 origin;                /* origin of the arm's frame, in the inertial frame and the model's unit */
  km_arm_motion *motions;        /* [n] */
  km_pose tool;                  /* displacement from the last motion to the effector */
  int *coordinate;               /* [n] coordinates of the mechanism */
  double *unit;                  /* [n] 1, or L for a slide: value in the mechanism = unit · value here */
  double *low, *high;            /* [n] limits; ∓infinity: none */
  double *rate;                  /* [n] largest speed in these units per second; infinity: none */
  km_arm_mass mass;              /* inertial data; km_arm_set_masses sets it */
  const km_clearance *clearance; /* pairs of bodies; NULL: none. km_arm_set_clearance sets it */
  double *rest;                  /* [coordinate count] coordinates of the mechanism for them, radians or length */
};

/* Workspace of one thread, allocated once. */
typedef struct km_arm_space {
  km_arena arena;
  km_pose pose;          /* pose of the effector; by km_arm_update */
  double *jacobian;      /* [rows × (n + 1)] column-major, the last column for −ξ; by km_arm_update */
  km_vec3 *axis, *point; /* [n] axes of the motions and points on them */
  km_factor *factor;     /* factorisation of [J | −ξ]; by km_control_factor */
  bool *forced;          /* [n + 1] */
  double *null;          /* [n × (n + 1)] orthonormal null space of the Jacobian; by km_control_factor */
  int null_count;
  double *rotated;            /* [rows × n] work array of the singular values */
  double sigma[KM_ARM_ROWS];  /* singular values, unordered */
  bool sigma_valid;           /* sigma belongs to the present Jacobian */
  unsigned long evaluations;  /* number of Jacobians computed */
  struct km_one_seven *seven; /* kernel of seven joints; NULL: not applicable */
  bool seven_valid;           /* the kernel's Jacobian is the present one; by km_arm_update */
  bool seven_factored;        /* the kernel's reflections are those of the last km_control_factor */
  km_state *state;            /* configuration of all bodies for clearances; NULL: the arm has none */
  km_pair_clearance *near;    /* [pair] their clearances */
} km_arm_space;

bool km_arm_space_create(const km_arm *arm, km_arm_space *space);
/* Part of it: what clearances need. False: out of memory. */
bool km_arm_clearance_create(const km_arm *arm, km_arm_space *space);
void km_arm_space_free(km_arm_space *space);

/* Computes the pose of the effector and the Jacobian at q[n]. Rows: v of the effector's origin over L, then ω in
 * inertial axes; position task: v only; axis task: v, then the components of ω along the effector's x and y axes.
 * O(n). */
void km_arm_update(const km_arm *arm, km_arm_space *space, const double *q);

/* Computes the columns with all rows of the task: columns[task_rows × n]. The Jacobian of the space is unchanged. */
void km_arm_all_columns(const km_arm *arm, km_arm_space *space, const double *q, double *columns);

/* Pose error from the present pose to a target: error[rows], with its length `position` and angle `rotation` (each
 * may be NULL). Returns √(position_weight · length² + angle²). */
double km_arm_error(const km_arm *arm, const km_arm_space *space, const km_pose *target, double *error,
                    double *position, double *rotation);

/* Number of rows of a task: pose 6, axis 5, position 3. */
int km_task_rows(km_task task);
/* Finds the subspace of the task's rows that the motions can change, by random configurations: arm->basis,
 * arm->rows. False: out of memory. */
bool km_arm_find_rows(km_arm *arm);
/* Rows of a twist at the effector's origin: all rows of the task, or those in the basis of rows that the motions can
 * change. */
void km_arm_all_task_rows(const km_arm *arm, const km_rotation *effector, km_twist twist, double *rows);
void km_arm_task_rows(const km_arm *arm, const km_rotation *effector, km_twist twist, double *rows);

/* Least clearance of the arm's pairs of bodies at q[n], over L; infinite without pairs. No allocation. */
double km_arm_clearance(const km_arm *arm, km_arm_space *space, const double *q);

/* Computes the singular values of the scaled Jacobian, sorted in decreasing order: sigma[rows]. */
void km_arm_singular_values(const km_arm *arm, km_arm_space *space, double *sigma);

/* Newton's method with minimum-norm steps from q to the target pose, until the error is below 1e-12. At most `most`
 * steps, each shortened to `longest`. Joints marked in `fixed` (may be NULL) don't move. True: converged; q is the
 * solution and the space is updated for it. */
bool km_arm_reach(const km_arm *arm, km_arm_space *space, const km_pose *target, const bool *fixed, int most,
                  double longest, double *q);

/* Converts a pose from the inertial frame and the model's unit to the arm's frame and unit. */
km_pose km_arm_from_model(const km_arm *arm, const km_pose *pose);
/* Converts a public record of a pose to the arm's frame and unit. */
km_pose km_arm_pose_of(const km_arm *arm, const km_frame_pose *pose);
km_pose km_arm_to_model(const km_arm *arm, const km_pose *pose);

/* First coordinate outside its limits; −1: none. */
int km_arm_limit_passed(const km_arm *arm, const double *q);
/* Least (distance to the nearer limit)/(half range) over the limited joints; 1 without limits, negative outside. */
double km_arm_limit_distance(const km_arm *arm, const double *q);

/* True if the coordinate is an angle of a hinge, for which a full turn is the same configuration. */
static inline bool km_arm_is_hinge(const km_arm *arm, int column) {
  return km_coordinate_turns(arm->mechanism, arm->coordinate[column]);
}
/* Converts a coordinate to the model's unit; km_arm_from_units converts it from that unit. */
double km_arm_to_units(const km_arm *arm, int column, double q);
double km_arm_from_units(const km_arm *arm, int column, double value);
const char *km_arm_label(const km_arm *arm, int column);

#endif
