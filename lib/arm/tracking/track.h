/* The stored result of one method on one path. */
#ifndef KM_ARM_TRACKING_TRACK_H
#define KM_ARM_TRACKING_TRACK_H

#include "arm/methods/method.h"

struct km_track {
  const km_arm *arm;
  km_track_plan plan;
  km_table *table;
  km_track_end end;
  km_track_summary summary;
  bool fixed[KM_ARM_MAX_JOINTS]; /* method fixed: joints that don't move */
};

#endif
