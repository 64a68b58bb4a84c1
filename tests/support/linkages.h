/* Linkages by their axes in an assembled pose, as text: each body may be seen from a frame of its own, and numbers may
 * be cut to a few digits, as CAD exports them. */
#ifndef KM_TESTS_LINKAGES_H
#define KM_TESTS_LINKAGES_H

#include "support/support.h"

enum { MOST_AXES = 24 };

typedef struct axis_joint {
  int parent, child; /* bodies; 0: the inertial frame */
  bool slides;
  km_vec3 at, along; /* a point of the axis, its unit direction */
} axis_joint;

typedef struct linkage {
  int bodies, joints; /* bodies without the inertial frame */
  axis_joint joint[MOST_AXES];
} linkage;

typedef struct writing {
  bool own_frames;  /* random ones for the bodies, and random places of the joints' frames along and about their axes */
  int digits;       /* digits of every number; 0: all. Rotations have at least 7: the reader refuses fewer */
  double tolerance; /* closure_tolerance, 0: not stated */
  double size;      /* the unit of length: points are multiplied by it */
} writing;

/* The caller frees it (km_free). */
char *linkage_text(const linkage *l, writing how, randomness *r);
/* Reads the linkage, optionally with bodies' own frames. */
fixture linkage_open(const linkage *l, randomness *r);

km_vec3 random_direction(randomness *r);
km_vec3 random_point(randomness *r);

/* One closed loop of hinges, whose first link is the inertial frame. */
linkage hinged_loop(const km_vec3 *at, const km_vec3 *along, int count);

/* Overconstrained loops that move with one freedom. */
enum { MOVING_KINDS = 8 };
extern const char *const moving_names[MOVING_KINDS];
linkage moving_loop(int kind, randomness *r);
/* The one of `count` random loops of the kind whose screws are nearest to losing another rank. */
linkage nearly_singular_loop(int kind, int count, randomness *r);

#endif
