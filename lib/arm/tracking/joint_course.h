/* Courses of the joints of a track against their limits.
 *
 *   margin of a joint = min over the rows of min(q − low, high − q) / ((high − low) / 2); 1 in the middle, 0 at a limit
 *   rate of a joint   = max over the rows of |v|,  its part of the drive's limit */
#ifndef KM_ARM_TRACKING_JOINT_COURSE_H
#define KM_ARM_TRACKING_JOINT_COURSE_H

#include "arm/tracking/track.h"

/* Course of one joint over the rows of a track. */
typedef struct km_joint_course {
  double least, greatest;         /* values, file's unit */
  double margin, margin_s;        /* least margin and its place; NaN: no limits */
  double rate, rate_s, rate_part; /* largest speed in file's units a second, its place; part of its limit or NaN */
} km_joint_course;

km_joint_course km_joint_course_find(const km_track *track, int joint);
/* The joint with the least margin; −1: no joint has limits. */
int km_limiting_joint(const km_track *track);
/* The joint whose rate is the largest part of its limit; −1: no joint has a limit. */
int km_fastest_joint(const km_track *track);
/* Part of the path that is followed, per cent. */
double km_track_part(const km_track *track);

#endif
