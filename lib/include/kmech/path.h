/* The path that an effector is to follow. */
#ifndef KMECH_PATH_H
#define KMECH_PATH_H

#include "kmech/arm.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A path as samples: immutable. */
typedef struct km_path km_path;

/* The curve of a segment. */
typedef enum km_path_shape {
  KM_PATH_LINE,  /* straight to `to`, turning evenly about one axis */
  KM_PATH_ARC,   /* by `angle` about an axis through `center`, with `pitch` a helix; a full turn is a circle */
  KM_PATH_WEAVE, /* a line with sine swings sideways */
  KM_PATH_SPLINE /* smoothly through poses */
} km_path_shape;

/* One segment. It begins where the one before ends. All in the inertial frame and the model's length unit. Start from
 * km_path_segment_default(), which is 100 steps long, and keeps the effector's orientation. */
typedef struct km_path_segment {
  km_path_shape shape;         /* which members count */
  int steps;                   /* intervals between samples, 1 to KM_PATH_STEPS */
  double to[3];                /* LINE, WEAVE: where the effector's origin ends */
  bool in_place;               /* LINE: the effector's origin stays where it is; `to` doesn't count then */
  bool turns;                  /* LINE, ARC, WEAVE: the effector turns to R, else it keeps its orientation */
  double R[9];                 /* by rows */
  double center[3], axis[3];   /* ARC */
  double angle;                /* ARC: radians, right-handed about the axis; at most 1000 turns */
  bool full_turn;              /* ARC: a circle; `angle` doesn't count then */
  double pitch;                /* ARC: travel along the axis in a full turn */
  bool turns_along;            /* ARC: the effector turns with the arc; `turns` doesn't count then */
  double amplitude, waves;     /* WEAVE: how far to either side, and how many swings there and back, up to 10 000 */
  double sideways[3];          /* WEAVE: direction of the swings */
  const km_frame_pose *points; /* SPLINE: [point_count] poses through which it goes, from where the path stands */
  const double *times;         /* SPLINE: [point_count] when it is at them, counted in time units from where it begins,
                                  increasing; NULL: by the path's speeds */
  int point_count;             /* of `points` */
  int unturned;   /* SPLINE: so many of the first points keep the orientation with which the path comes; their R
                      doesn't count */
  bool own_start; /* SPLINE: begins at its first point, wherever the path stands; else only where that is the same */
  bool at_points; /* SPLINE: the samples are the points; `steps` doesn't count then */
} km_path_segment;
enum { KM_PATH_STEPS = 1000000 }; /* the most intervals of a path */
KM_API km_path_segment km_path_segment_default(km_path_shape shape);
/* Start from km_path_plan_default(). */
typedef struct km_path_plan {
  km_frame_pose start; /* where the effector is before the first segment */
  double speed;        /* of the effector's origin, length per time unit; 0: L a second */
  double turn_speed;   /* radians per time unit; 0: turns take no time of their own but where the origin stands still */
  const km_path_segment *segments; /* [segment_count] in their order */
  int segment_count;
} km_path_plan;
KM_API km_path_plan km_path_plan_default(void);

/* Makes a path for the arm, which must outlive it. KM_USAGE: a segment doesn't move the effector or is out of range,
 * and says which, as "segments[2].points[1]"; KM_MEMORY. The caller frees `*out`. O(steps). */
KM_API km_status km_path_create(const km_arm *arm, const km_path_plan *plan, km_path **out, km_error *error);
KM_API void km_path_free(km_path *path);
/* The number of samples: 0 … one less are those of the functions below. 0 without a path. */
KM_API int km_path_samples(const km_path *path);
/* The metric s up to a sample, model's unit: ds² = |dp|² + L²dθ² (theory 6); the length that the effector's origin has
 * travelled, and the angle in radians by which the effector has turned, as far as the task counts it; time in seconds;
 * the pose. */
KM_API double km_path_length(const km_path *path, int sample);
KM_API double km_path_travel(const km_path *path, int sample);
KM_API double km_path_turn(const km_path *path, int sample);
KM_API double km_path_time(const km_path *path, int sample);
KM_API void km_path_pose(const km_path *path, int sample, km_frame_pose *pose);

#ifdef __cplusplus
}
#endif
#endif
