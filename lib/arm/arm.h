/* A serial chain from the inertial frame to an effector: forward kinematics and the scaled Jacobian (theory 6).
 *
 * Everything is counted in the arm's own length scale L about the arm's first joint: a coordinate is an angle, or
 * a slide over L. Neither units nor a far inertial origin touch its digits. */
#ifndef KM_ARM_ARM_H
#define KM_ARM_ARM_H

#include "kinematics/body_poses.h"
#include "kmech/arm.h"

enum { KM_ARM_ROWS = 6, KM_ARM_MOST = 32 };

/* One motion on the way out. */
typedef struct km_arm_motion {
  km_primitive primitive;
  int axis;
  int column;     /* of the Jacobian */
  double sign;    /* -1: the joint is passed against its sense */
  double pitch;   /* travel per radian of a helical motion, over L */
  bool turned;    /* `before` turns, not only shifts */
  km_pose before; /* from the last motion to this one's frame */
} km_arm_motion;

struct km_arm {
  km_arena arena;
  const km_mechanism *mechanism;
  int frame; /* the effector's, of the model */
  km_task task;
  int n;
  int rows; /* of the Jacobian: those of the task that motions can change; all of them but for planar arms and the like */
  int freedom; /* n − rows: dimension of the self-motion at regular poses */
  int task_rows;
  double basis[KM_ARM_ROWS][KM_ARM_ROWS]; /* [rows × task_rows] orthonormal: what they are of the task's rows */
  double length;                          /* L, in the model's unit */
  double slide_most;                      /* slides further than this are of no use: several times the arm's size */
  double shrink;  /* of position errors, squared: 1 but for arms of more than 100 L, whose rounding is as large */
  km_vec3 origin; /* of everything here, in the inertial frame and the model's unit */
  km_arm_motion *motions; /* [n] */
  km_pose tool;           /* from the last motion to the effector */
  int *coordinate;        /* [n] of the mechanism */
  double *unit;           /* [n] 1, or L for a slide: engine's value = unit · ours */
  double *low, *high;     /* [n] limits, ∓infinity where there is none */
  double *rate;           /* [n] largest speed in our units a second, infinity: none */
};

/* One thread's workspace. Everything is allocated once. */
typedef struct km_arm_space {
  km_arena arena;
  km_pose pose;           /* of the effector. By km_arm_update */
  double *jacobian;       /* [rows × (n + 1)], the last column for the path. By km_arm_update */
  km_vec3 *axis, *point;  /* [n] where the motions are */
  km_partition partition; /* of the Jacobian with its path column. By km_control_update */
  bool *forced;           /* [n + 1] */
  double *ones;           /* [n + 1] */
  double *null;           /* [n × (n + 1)] orthonormal null space of the Jacobian. By km_control_update */
  int null_count;
  double *rotated;            /* [rows × n] workspace of singular values */
  double sigma[KM_ARM_ROWS];  /* singular values in no order, */
  bool sigma_stands;          /* if they are known already */
  unsigned long evaluations;  /* Jacobians so far */
  struct km_one_seven *seven; /* the kernel of seven joints; NULL: not for this arm */
  bool seven_stands;          /* its Jacobian is the space's. By km_arm_update */
  bool seven_factored;        /* and its reflections are those of the last km_control_factor */
} km_arm_space;

bool km_arm_space_create(const km_arm *arm, km_arm_space *space);
void km_arm_space_free(km_arm_space *space);

/* Pose of the effector and the Jacobian's columns at q[n]: rows v at the effector's origin over L, then ω; of a
 * position v alone; of an axis v, then ω across the effector's z axis, along its x and y. */
void km_arm_update(const km_arm *arm, km_arm_space *space, const double *q);

/* The columns by all rows of the task: columns[task_rows × n]. The space keeps its Jacobian. */
void km_arm_all_columns(const km_arm *arm, km_arm_space *space, const double *q, double *columns);

/* What is left from the pose to a target: error[rows], and its length and angle. Returns √(shrink·length² + angle²). */
double km_arm_error(const km_arm *arm, const km_arm_space *space, const km_pose *target, double *error,
                    double *position, double *rotation);

/* Of a pose 6, of an axis 5, of a position 3. */
int km_task_rows(km_task task);
/* Which of the task's rows the motions can change, by random poses. False when out of memory. */
bool km_arm_find_rows(km_arm *arm);
/* The part of a twist at the effector's origin that the task counts: all of it, and what motions can change of it. */
void km_arm_all_task_rows(const km_arm *arm, const km_rotation *effector, km_twist twist, double *rows);
void km_arm_task_rows(const km_arm *arm, const km_rotation *effector, km_twist twist, double *rows);

/* Singular values of the scaled Jacobian, largest first: sigma[rows]. */
void km_arm_singular_values(const km_arm *arm, km_arm_space *space, double *sigma);

/* Newton steps of least norm from q to the target, to 1e-12; q and the space stand there. At most `most` steps, none
 * longer than `longest` (shortened). False if it doesn't converge. `held` columns (may be NULL) don't move. */
bool km_arm_reach(const km_arm *arm, km_arm_space *space, const km_pose *target, const bool *held, int most,
                  double longest, double *q);

/* A pose in the inertial frame and the model's unit, seen from the arm; and back. */
km_pose km_arm_from_model(const km_arm *arm, const km_pose *pose);
/* The same of a public record. */
km_pose km_arm_pose_of(const km_arm *arm, const km_frame_pose *pose);
km_pose km_arm_to_model(const km_arm *arm, const km_pose *pose);

/* The coordinate outside its limits, the first; -1 none. */
int km_arm_limit_passed(const km_arm *arm, const double *q);
/* min over limited joints of (distance to the nearer limit)/(half range), 1 if there is none; negative outside. */
double km_arm_limit_distance(const km_arm *arm, const double *q);

/* Is the coordinate a hinge, which a full turn brings back? */
static inline bool km_arm_turns(const km_arm *arm, int column) {
  return km_coordinate_turns(arm->mechanism, arm->coordinate[column]);
}
/* Coordinates in the model's unit (degrees where it has them), and back. */
double km_arm_shown(const km_arm *arm, int column, double q);
double km_arm_read(const km_arm *arm, int column, double value);
const char *km_arm_label(const km_arm *arm, int column);

#endif
