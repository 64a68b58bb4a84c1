/* Robots as URDF describes them: a tree of links, each joint's child frame being its link's. */
#ifndef KM_EXCHANGE_URDF_URDF_H
#define KM_EXCHANGE_URDF_URDF_H

#include "exchange/robot/robot.h"

/* Reads the element `robot`: a km_robot_read. Default gravity is 9.81 m/s² along −z. */
void km_urdf_read(km_robot *robot, km_xml *root);

/* A joint's element, and what the reader knows of it. */
typedef struct km_urdf_joint {
  const km_xml *at;
  const char *name;
  km_joint_type type;
  double position; /* value of its coordinate in the file's configuration */
  int mimics;      /* the joint that it follows, -1: none */
  double ratio, offset;
  km_joint_id id;
} km_urdf_joint;

typedef struct km_urdf {
  km_robot *robot;
  km_assembly_id assembly;
  km_names links, joints;  /* scope 0: index into the arrays */
  km_body_id *bodies;      /* [link] */
  const km_xml **parents;  /* [link] the joint that it is child of, NULL: none */
  const km_xml **elements; /* [link] */
  int *leaders;            /* [link] a link that it hangs together with, of a smaller index; itself: none */
  km_urdf_joint *list;
  int link_count, joint_count;
  bool world_undeclared; /* a joint has a parent "world" that isn't defined */
} km_urdf;

/* The joints' types and the values that they have in the file's pose, then their bodies tied. */
void km_urdf_read_joints(km_urdf *urdf, const km_xml *root);
/* Two links hang together; -1: the inertial frame. */
void km_urdf_tie(km_urdf *urdf, int parent, int child);
km_pose km_urdf_origin(km_robot *robot, const km_xml *element);

#endif
