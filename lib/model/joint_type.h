/* The joint types of the model format and the primitive motions they are made of. */
#ifndef KM_MODEL_JOINT_TYPE_H
#define KM_MODEL_JOINT_TYPE_H

#include "kmech/build.h"
#include "model/units.h"
#include "spatial/pose.h"

typedef enum km_primitive {
  KM_REVOLUTE,  /* turn about an axis; one coordinate, an angle */
  KM_PRISMATIC, /* slide along an axis; one coordinate, a length */
  KM_HELICAL,   /* turn with a proportional slide; one coordinate, an angle */
  KM_BALL       /* any rotation; three coordinates, a rotation vector */
} km_primitive;

typedef struct km_motion {
  km_primitive primitive;
  int axis; /* 0 x, 1 y, 2 z of the frame before this motion; unused for a ball */
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
/* The type of that word, `revolute` being Rz and `prismatic` Tx; -1 if there is none. */
int km_joint_type_find(const char *word);
/* The displacement that a motion makes: `value` in radians or a length; a ball's is a rotation vector. `pitch` is the
 * travel per radian. */
km_pose km_motion_pose(km_motion motion, double pitch, const double *value);
int km_primitive_freedom(km_primitive primitive);

/* Is coordinate k of the joint a length (a Tx, Ty or Tz)? Screws and rotations are angles. */
bool km_joint_is_length(km_joint_type type, int k);
/* The unit of coordinate k in a file: angle or length. */
km_dimension km_joint_dimension(km_joint_type type, int k);

#endif
