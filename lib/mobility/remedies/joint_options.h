/* Joint types with more freedoms than a hinge or a slide (theory 7.5). Private to the library. */
#ifndef KM_MOBILITY_REMEDIES_JOINT_OPTIONS_H
#define KM_MOBILITY_REMEDIES_JOINT_OPTIONS_H

#include "kmech/mobility.h"
#include "model/model.h"

enum { KM_MAX_JOINT_OPTIONS = 12, KM_JOINT_MOTIONS = 6 };

/* One type that a joint can have instead of its own. Motions are bits of km_joint_change. */
typedef struct km_joint_option {
  const char *to;
  bool is_type;   /* `to` is a joint type of the format; else it is a series of joints */
  int own, added; /* motions of the joint; motions that the option adds */
} km_joint_option;

/* Lists the options of a hinge, a slide or a cylindrical joint; 0 for other joints. */
int km_joint_options(const km_model_joint *joint, km_joint_option out[KM_MAX_JOINT_OPTIONS]);
/* The option of a change. False if the change isn't one of the joint's options. */
bool km_joint_option_find(const km_model_joint *joint, const km_joint_change *change, km_joint_option *out);
/* Number of motions in a set. */
int km_motion_count(int motions);

#endif
