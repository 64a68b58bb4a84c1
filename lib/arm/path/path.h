/* The effector's path: segments, samples on them, and the unit twist at each.
 *
 * Lengths are over L and seen from the arm (arm.h), so that σ = s/L with dσ² = |dp/L|² + dθ²; of a task that doesn't
 * count turns (or only those of an axis) dθ is what it counts. */
#ifndef KM_ARM_PATH_PATH_H
#define KM_ARM_PATH_PATH_H

#include "arm/arm.h"
#include "model/path_study/path_plan.h"

#include <gsl/gsl_spline.h>

typedef struct km_path_point {
  km_pose pose;
  km_twist twist; /* dX/dσ at the effector's origin; of the segment that begins where two meet */
  double s, t;    /* σ, and seconds */
  double
      travel; /* of the effector's origin, over L; and its turn, as far as the task counts it: dσ² = travel² + turn² */
  double turn;
  double speed; /* dσ/dt; of that segment too */
} km_path_point;

/* What sets the time of an interval between samples. */
typedef enum km_pace { KM_PACE_TRAVEL, KM_PACE_TURN, KM_PACE_TIMES } km_pace;

typedef enum km_segment_kind { KM_SEGMENT_LINE, KM_SEGMENT_HELIX, KM_SEGMENT_WEAVE, KM_SEGMENT_SPLINE } km_segment_kind;

/* Orientations through knots: between two, q₀ exp(w₁β₁) exp(w₂β₂) exp(w₃β₃) with the cumulative cubic Bernstein
 * polynomials β (Kim, Kim and Shin 1995): SQUAD's smoothness, also for knots that are not evenly spaced. */
typedef struct km_turn_piece {
  km_quaternion start;
  km_vec3 w[3]; /* body rotation vectors */
} km_turn_piece;

/* A piece of the path over u from 0 to 1. */
typedef struct km_segment {
  km_segment_kind kind;
  km_pose start;
  int steps, first;     /* intervals, and the sample it begins with */
  double seconds;       /* 0: by the path's speeds */
  double length;        /* σ of the whole. By km_path_finish */
  km_vec3 travel;       /* LINE, WEAVE: from start to end */
  km_vec3 turn;         /* rotation vector about a fixed axis over the whole; HELIX with `turns`: that of the helix */
  km_vec3 centre, axis; /* HELIX */
  double angle, rise;   /* HELIX: radians; travel along the axis */
  km_vec3 sideways;     /* WEAVE: amplitude and direction */
  double waves;
  bool at_knots; /* SPLINE: samples are the knots; else evenly in u */
  int knots;
  double *knot; /* [knots] 0 … 1 */
  gsl_spline *spline[3];
  km_turn_piece *piece; /* [knots − 1] */
} km_segment;

struct km_path {
  km_arena arena;
  const km_arm *arm;
  int segment_count, samples; /* samples: intervals + 1 */
  km_segment *segments;
  km_path_point *points; /* [samples] */
  int *segment_of;       /* [samples] that begins at or holds the interval after it */
  km_pace *pace;         /* [samples] of the interval after it */
  double speed;          /* of the effector's origin where a segment has no times, L a second */
  double turn_speed;     /* radians a second; 0: turns take no time of their own but where the origin stands still */
};

/* The point a fraction of the way from sample i to i + 1 (i < samples − 1). */
km_path_point km_path_at(const km_path *path, int i, double fraction);

/* The path of a plan whose numbers are checked, from a start in the arm's units instead of the plan's. KM_USAGE: `fault`
 * says where in the plan; KM_MEMORY. The caller frees `*out`. */
km_status km_path_make(const km_arm *arm, const km_path_plan *plan, const km_pose *start, km_path **out,
                       km_path_fault *fault, km_error *error);

/* Samples and arc lengths, once the segments stand. KM_USAGE: a segment doesn't move; `which` is then its index. */
km_status km_path_finish(km_path *path, int *which, km_error *error);

/* Distance and turn between two poses (lengths over L), together; below KM_SAME_POSE there is no way to go. */
#define KM_SAME_POSE 1e-9
double km_poses_apart(const km_pose *a, const km_pose *b);

/* Pose of a segment at u, and dX/du at the effector's origin (inertial axes). */
km_pose km_segment_pose(const km_segment *segment, double u, km_twist *rate);
/* Fits a spline segment through poses at increasing `knot`s (0 … 1). KM_MEMORY. */
km_status km_segment_fit(km_segment *segment, const km_pose *poses, km_arena *arena, km_error *error);

#endif
