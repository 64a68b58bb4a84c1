/* Loops that are closed beside the tree of joints, by elements that other programs read: Gazebo's joints in a URDF
 * file and its plugin DetachableJoint, Drake's ball constraints, the loop_joint of Isaac Sim, pairs of frames
 * closing_NAME_1 and closing_NAME_2 of onshape-to-robot. */
#ifndef KM_EXCHANGE_SDF_SDF_CLOSURES_H
#define KM_EXCHANGE_SDF_SDF_CLOSURES_H

#include "exchange/robot/robot.h"

/* A link, or a frame of one, by its name. */
typedef struct km_closure_end {
  int link; /* name for `tie` */
  km_body_id body;
  km_pose world;   /* pose of the link at joint values 0 */
  km_pose in_link; /* pose of the frame with the name */
} km_closure_end;

/* Access to the links of a format. */
typedef struct km_closures {
  km_robot *robot;
  km_assembly_id assembly;
  void *context;
  bool (*find)(void *context, const char *name, km_closure_end *out); /* false: there is no such link or frame */
  void (*tie)(void *context, int parent, int child);                  /* a joint was added between these links */
} km_closures;

/* Reads an element that isn't the format's own: adds the joint that it describes, and true; or true with a warning,
 * where it ties links in a way that can't be read. False: it ties nothing. */
bool km_closures_read(const km_closures *c, const km_xml *element);
/* A ball joint between the frames closing_NAME_1 and closing_NAME_2, of the name of either; nothing for other names. */
void km_closures_pair(const km_closures *c, const km_xml *at, const char *name);

#endif
