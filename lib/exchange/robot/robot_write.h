/* Functions shared by writers of robot descriptions: a model in SI units in a configuration, and a tree of its
 * joints. */
#ifndef KM_EXCHANGE_ROBOT_ROBOT_WRITE_H
#define KM_EXCHANGE_ROBOT_ROBOT_WRITE_H

#include "exchange/robot/omissions.h"
#include "exchange/xml/xml_write.h"
#include "kmech/exchange.h"
#include "model/model.h"

/* A primitive motion on the way along a joint, from the one body to the other. */
typedef struct km_written_motion {
  km_primitive primitive;
  int coordinate;     /* first of the model */
  const char *name;   /* the joint's, or of several coordinates label[k] */
  km_vec3 axis;       /* unit, in `before`; against the joint's sense it is turned over */
  double pitch;       /* metres per radian */
  double sign;        /* -1: the joint is passed against its sense */
  km_pose before;     /* pose from the frame after the last motion to that of this motion */
  const char *beyond; /* name of the massless body after it; NULL: the last one */
} km_written_motion;

/* The way from one body to another through a joint: X = motions · after. */
typedef struct km_written_joint {
  int joint, from, to; /* bodies */
  int count;           /* motions, 0: rigid */
  km_written_motion motion[KM_MAX_MOTIONS];
  km_pose after;
} km_written_joint;

typedef struct km_written {
  const km_model *model;
  const char *destination; /* the folder that it is written to, as km_find_destination has it */
  km_arena arena;
  km_messages *messages;
  km_xml_writer xml;
  double *q;                     /* [coordinate] radians and metres, as the pose has it */
  double *reference;             /* [coordinate] values in the file's configuration */
  km_pose *world;                /* [body] at `reference` */
  const char **bodies, **joints; /* names, unique in the file */
  const char **frames; /* [frame] names of those that no joint is held by, such as a tool's; NULL: of others */
  int *arc;            /* [body] joint to its parent in the tree, -1: the inertial frame */
  bool *in_tree;       /* [joint] */
  int *order;          /* bodies, parents first; without the inertial frame */
  int ordered;
  km_omissions omissions;
  double length, mass, force, time; /* SI per unit of the model */
} km_written;

/* Prepares a model in the configuration q [coordinate] (model's units), for a `file` (NULL: in the model's folder).
 * KM_MODEL: the loops aren't closed; KM_MEMORY. Free in any case. */
km_status km_written_make(const km_model *model, const double *q, const char *file, km_messages *messages, km_text *out,
                          km_written *w, km_error *error);
void km_written_free(km_written *w);
/* Makes `reference` and `world` those of the pose `q`, or of zero for the joints that no loop and no coupling binds. */
bool km_written_refer(km_written *w, bool zero_where_free);
/* A joint passed from the body `from`. */
km_written_joint km_written_pass(km_written *w, int joint, int from);
/* Counts what the format can't say; km_written_tell makes a note of each kind. */
void km_written_omit(km_written *w, const char *kind, const char *name);
void km_written_tell(const km_written *w);
/* SI per unit of a coordinate inside a coupling: the length unit in metres, or 1 (radians). */
double km_written_unit(const km_written *w, int coordinate);
/* True if km_written_mimic writes the coupling at its first coordinate. */
bool km_written_is_mimic(const km_written *w, int coupling);
/* q_c = ratio · q_leader + constant, radians and metres, of the coupling that lets coordinate c follow another one; the
 * constant is that of the pose where the coupling states none. False if no line does it. */
bool km_written_mimic(const km_written *w, int coordinate, int *leader, double *ratio, double *constant);
const char *km_written_text(km_written *w, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The displacement of a motion at a value of its coordinates. */
km_pose km_written_motion_at(const km_written_motion *motion, const double *q);
/* The pose of the way's last body in its first one. */
km_pose km_written_through(const km_written_joint *way, const double *q);
/* True if the displacement is along the axis, or about an axis through the body's origin, so that `after` can be
 * rotated. */
bool km_written_fold(km_written_joint *joint);

/* Numbers in SI of a coordinate: a force or torque per force unit, and so on. */
double km_written_force(const km_written *w, int coordinate);
double km_written_rate(const km_written *w, int coordinate); /* per time */
double km_written_damping(const km_written *w, int coordinate);
double km_written_inertia(const km_written *w, int coordinate);
/* The least and greatest value, ∓1e30 where there is none; of a held coordinate (analysis.hold) both are its value. */
void km_written_range(const km_written *w, int coordinate, double range[2]);
/* The value at which the model holds a coordinate, in its unit; NULL: it is free. */
const double *km_written_held_at(const km_model *model, int coordinate);
bool km_written_is_limited(const km_model *model, int coordinate); /* held ones are */
/* The linear springs in a coordinate as one: true with its stiffness and where it is at rest, in SI. Others count as
 * left out. */
bool km_written_spring(const km_written *w, int coordinate, double *stiffness, double *rest);
/* Stiffness of a ball joint's three coordinates, if they have one stiffness and no force in the file's
 * configuration; otherwise their springs count as omitted. */
bool km_written_ball_spring(km_written *w, int first, double *stiffness);
/* The model's closure tolerance; 0: it states none. */
double km_written_tolerance(const km_written *w);
/* Counts forces and motions that no format holds. */
void km_written_omit_forces(km_written *w);
/* Data of a coordinate that a joint's element can hold. */
enum {
  KM_HELD_LIMITS = 1,
  KM_HELD_FORCE = 2, /* the largest one */
  KM_HELD_RATE = 4,
  KM_HELD_DAMPING = 8,
  KM_HELD_FRICTION = 16,
  KM_HELD_ARMATURE = 32,
  KM_HELD_TURN = 64, /* the largest angle of a ball */
  /* Axis of URDF or SDF. */
  KM_HELD_BY_AXIS = KM_HELD_LIMITS | KM_HELD_FORCE | KM_HELD_RATE | KM_HELD_DAMPING | KM_HELD_FRICTION
};
/* Counts as left out what coordinates from `first` on, or all of a joint's, state beyond what is held. */
void km_written_hold(km_written *w, int first, int count, unsigned held);
void km_written_hold_none(km_written *w, int joint);
/* Position of one of `frames` in its body, in metres. */
km_pose km_written_frame(const km_written *w, int frame);
/* Mass, centre and inertia in SI. */
double km_written_mass(const km_written *w, int body, double center[3], double inertia[6]);
/* Shapes of a body, in metres: the mesh of its definition first. NULL: none, or out of memory. */
const km_model_shape *km_written_shapes(km_written *w, int body, int *count);
void km_written_quaternion(const km_rotation *R, double wxyz[4]);

typedef km_status (*km_robot_write)(km_written *w, km_error *error);
km_status km_mjcf_write(km_written *w, km_error *error);
km_status km_urdf_write(km_written *w, km_error *error);
km_status km_sdf_write(km_written *w, km_error *error);

#endif
