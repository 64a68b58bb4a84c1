/* The effector's path: segments, samples, and the unit twist at each sample (docs/theory.md 12.2).
 *
 * Lengths are over L in the arm's frame (arm.h). The metric is σ = s/L with dσ² = |dp/L|² + dθ²; dθ contains only
 * the rotation that the task counts. */
#ifndef KM_ARM_PATH_PATH_H
#define KM_ARM_PATH_PATH_H

#include "arm/arm.h"
#include "model/path_study/path_plan.h"

#include <gsl/gsl_spline.h>

typedef struct km_path_point {
  km_pose pose;
  km_twist twist; /* dX/dσ at the effector's origin; at a junction, of the segment that begins there */
  double s, t;    /* σ, and seconds */
  double travel; /* travel of the effector's origin over L; `turn` is the counted rotation: dσ² = dtravel² + dturn² */
  double turn;
  double speed; /* dσ/dt; at a junction, of the segment that begins there */
} km_path_point;

/* Quantity that sets the time of an interval between samples. */
typedef enum km_pace { KM_PACE_TRAVEL, KM_PACE_TURN, KM_PACE_TIMES } km_pace;

typedef enum km_segment_kind { KM_SEGMENT_LINE, KM_SEGMENT_HELIX, KM_SEGMENT_WEAVE, KM_SEGMENT_SPLINE } km_segment_kind;

/* Orientations between two knots: q₀ exp(w₁β₁) exp(w₂β₂) exp(w₃β₃) with the cumulative cubic Bernstein polynomials β
 * (M. Kim, M. Kim and S. Shin 1995). The curve is as smooth as SQUAD, also for unevenly spaced knots. */
typedef struct km_orientation_piece {
  km_quaternion start;
  km_vec3 w[3]; /* body rotation vectors */
} km_orientation_piece;

/* A segment of the path, over u = 0 … 1. */
typedef struct km_segment {
  km_segment_kind kind;
  km_pose start;
  int steps, first;     /* number of intervals; index of the first sample */
  double seconds;       /* 0: by the path's speeds */
  double length;        /* σ of the segment; by km_path_finish */
  km_vec3 travel;       /* LINE, WEAVE: from start to end */
  km_vec3 turn;         /* rotation vector of the segment about a fixed axis; HELIX with `turns_along`: that of the
                         * helix */
  km_vec3 centre, axis; /* HELIX */
  double angle, rise;   /* HELIX: radians; travel along the axis */
  km_vec3 sideways;     /* WEAVE: amplitude and direction */
  double waves;
  bool at_knots; /* SPLINE: samples are the knots; else evenly in u */
  int knots;
  double *knot; /* [knots] 0 … 1 */
  gsl_spline *spline[3];
  km_orientation_piece *piece; /* [knots − 1] */
} km_segment;

struct km_path {
  km_arena arena;
  const km_arm *arm;
  int segment_count, samples; /* samples: intervals + 1 */
  km_segment *segments;
  km_path_point *points; /* [samples] */
  int *segment_of;       /* [samples] segment of the interval after the sample */
  km_pace *pace;         /* [samples] pace of the interval after the sample */
  double speed;          /* speed of the effector's origin, L per second, for segments without times */
  double turn_speed;     /* rad/s; 0: rotations take time only while the origin is at rest */
};

/* Path point at a fraction of the interval from sample i to i + 1 (i < samples − 1). */
km_path_point km_path_at(const km_path *path, int i, double fraction);

/* Creates the path of a checked plan, from `start` in the arm's units in place of the plan's start. KM_USAGE:
 * `fault` is the place in the plan; KM_MEMORY. The caller frees `*out`. */
km_status km_path_build(const km_arm *arm, const km_path_plan *plan, const km_pose *start, km_path **out,
                        km_path_fault *fault, km_error *error);

/* Computes samples and lengths of the segments. KM_USAGE: a segment doesn't move; `which` is then its index. */
km_status km_path_finish(km_path *path, int *which, km_error *error);

/* Distance between two poses: √(|Δp|² + angle²), lengths over L. Poses closer than KM_SAME_POSE are equal. */
#define KM_SAME_POSE 1e-9
double km_pose_distance(const km_pose *a, const km_pose *b);

/* Pose of a segment at u, and dX/du at the effector's origin (inertial axes). */
km_pose km_segment_pose(const km_segment *segment, double u, km_twist *rate);
/* Fits a spline segment through poses at increasing `knot`s (0 … 1). KM_MEMORY. */
km_status km_segment_fit(km_segment *segment, const km_pose *poses, km_arena *arena, km_error *error);

#endif
