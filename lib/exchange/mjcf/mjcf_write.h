/* The parts of a model that is written as MJCF. */
#ifndef KM_EXCHANGE_MJCF_MJCF_WRITE_H
#define KM_EXCHANGE_MJCF_MJCF_WRITE_H

#include "exchange/robot/robot_write.h"

/* The kinds of joints that MJCF has, by what they take of a keyframe. */
typedef enum km_mjcf_kind { KM_MJCF_SINGLE, KM_MJCF_SLIDE_OF_SCREW, KM_MJCF_BALL, KM_MJCF_FREE } km_mjcf_kind;

/* Joints in the order in which they were written, which is that of keyframes. */
typedef struct km_mjcf_order {
  km_mjcf_kind *kinds;
  int *joints; /* name of the model */
  km_written_motion *motions;
  size_t kind_room, joint_room, motion_room;
  int count;
} km_mjcf_order;

void km_mjcf_remember(km_written *w, km_mjcf_order *order, km_mjcf_kind kind, int joint,
                      const km_written_motion *motion);

/* The slide that follows a screw's hinge. */
const char *km_mjcf_slide_of(km_written *w, const char *screw);
/* A pose as attributes of the element that was begun last. */
void km_mjcf_set_pose(km_written *w, const km_pose *X);
/* The assets that shapes need, and the shapes of a body. */
void km_mjcf_write_assets(km_written *w);
void km_mjcf_write_geoms(km_written *w, int body);
/* Couplings, as constraints inside of `equality`; and the tendons that some of them need. */
void km_mjcf_write_couplings(km_written *w);
void km_mjcf_write_tendons(km_written *w);
/* Named poses, as keyframes. */
void km_mjcf_write_keyframes(km_written *w, const km_mjcf_order *order);

#endif
