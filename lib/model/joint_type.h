/* Joint types and the primitive motions of which they consist. */
#ifndef KM_MODEL_JOINT_TYPE_H
#define KM_MODEL_JOINT_TYPE_H

#include "kmech/build.h"
#include "model/units.h"
#include "spatial/pose.h"

typedef enum km_primitive {
  KM_REVOLUTE,  /* rotation about an axis; one angle */
  KM_PRISMATIC, /* translation along an axis; one length */
  KM_HELICAL,   /* screw motion; one angle */
  KM_BALL       /* arbitrary rotation; three coordinates, a rotation vector */
} km_primitive;

typedef struct km_motion {
  km_primitive primitive;
  int axis; /* 0 x, 1 y, 2 z of the frame before this motion; unused for a ball joint */
} km_motion;

enum { KM_MAX_MOTIONS = 4 };

/* A joint type: X_child = X_parent · motion_0(q) · motion_1(q) … */
typedef struct km_joint_kind {
  const char *word;
  int freedom; /* number of coordinates */
  int motion_count;
  km_motion motions[KM_MAX_MOTIONS];
} km_joint_kind;

const km_joint_kind *km_joint_kind_of(km_joint_type type);
/* Type with a word (`revolute` is Rz, `prismatic` Tx); -1 if there is none. */
int km_joint_type_find(const char *word);
/* Displacement of a primitive motion. `value`: radians or a length; a rotation vector for a ball joint. `pitch`:
 * translation per radian. */
km_pose km_motion_pose(km_motion motion, double pitch, const double *value);
int km_primitive_freedom(km_primitive primitive);

/* True if coordinate k of the joint is a length (Tx, Ty, Tz); rotations and screws are angles. */
bool km_joint_is_length(km_joint_type type, int k);
/* Axis of the joint's first hinge or screw, else of its first slide: 0 x, 1 y, 2 z; -1: it has none. */
int km_joint_axis(km_joint_type type);
/* Unit of coordinate k in a file. */
km_dimension km_joint_dimension(km_joint_type type, int k);

#endif
