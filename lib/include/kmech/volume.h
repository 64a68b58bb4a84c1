/* Size of a point's workspace: its volume, or its area in a plane, by samples, with an interval (docs/theory.md
 * 4.23). */
#ifndef KMECH_VOLUME_H
#define KMECH_VOLUME_H

#include "kmech/base.h"
#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  KM_DEFAULT_VOLUME_SAMPLES = 10000, /* samples, unless stated */
  KM_MIN_VOLUME_SAMPLES = 100,       /* fewest samples */
  KM_MAX_VOLUME_SAMPLES = 1000000    /* most samples */
};

/* Definition of a workspace and its samples. */
typedef struct km_space_volume_def {
  int frame;              /* the point: origin of this frame */
  const char *point_name; /* its name in columns: "body/frame" */
  bool own_circuit;       /* only configurations that a motion from that of the state leads to; else also those of other
                           * ways in which the loops close */
  bool within_limits;     /* configurations outside the joint limits don't count */
  const km_clearance *clearance; /* nor do those in which a pair of bodies is nearer than `least_clearance`; NULL: all
                                  * count */
  double least_clearance;        /* model's unit */
  int samples;                   /* most points of the box that are decided; 0: KM_DEFAULT_VOLUME_SAMPLES */
  unsigned long seed;            /* start of the random numbers */
  int jobs;                      /* threads; the result doesn't depend on them */
} km_space_volume_def;

/* Size of a workspace. Axes are along those of the inertial frame, in a plane x or y projected to it and the one
 * orthogonal to it, with a positive largest component; lengths in the model's unit. */
typedef struct km_space_volume {
  int dimension;                  /* 3: `volume` is one; 2: it is an area in a plane */
  double volume;                  /* estimate, without undecided samples */
  double standard_error;          /* standard error of the estimate */
  double low, high;               /* 95 % interval; undecided samples count for its upper end */
  double axis[3][3];              /* [dimension] unit vectors */
  double box_low[3], box_high[3]; /* [dimension] the box along the axes in which the samples lie */
  int cells[3];                   /* [dimension] cells of the box along each axis, with two samples each */
  int samples;                    /* number of samples */
  int reached;                    /* the point was brought there */
  int not_reached;                /* eight attempts ended where no motion brings the point nearer */
  int undecided;                  /* attempts ended otherwise */
  int split_cells;                /* cells of which one sample is reached */
  int configurations;             /* known configurations from which the point was moved */
  bool is_complete;               /* no attempts were left, and motions from the reached samples found no larger
                                   * box */
  bool is_stopped;                /* the caller ended the work */
  km_table *points;               /* point. x y z, reached (1, 0, −1: undecided), q. of every coordinate where it is
                                   * reached, else NaN: a row for each sample, two for each cell, cells along
                                   * the first axis first */
} km_space_volume;

/* Finds how large the workspace of a point is. The box is found by moving the point along each axis from many
 * configurations on, and is 1 % larger. Two random points are decided in each of its cells: the point is moved to them
 * from the nearest known configurations, which begin with random closures of the loops and motions from there. Every
 * sample reached is closed to 1e-12 and exact to 1e-9 of the characteristic length. That a sample isn't reached is the
 * evidence of eight attempts, no proof. KM_USAGE: an index, a number of samples or a clearance is invalid, the point
 * doesn't move in three directions or over a plane, or moves without end; KM_NO_RESULT: no configuration is within
 * limits and clearance; KM_MEMORY; KM_CANCELLED: `*out` has the samples decided so far, others are undecided; no
 * samples before the first is decided. Free `*out` in any case. O(samples · attempts · steps · rank³). */
KM_API km_status km_space_volume_find(const km_mechanism *mechanism, const km_state *state,
                                      const km_space_volume_def *def, km_progress progress, void *context,
                                      km_space_volume *out, km_error *error);
KM_API void km_space_volume_free(km_space_volume *volume);

#ifdef __cplusplus
}
#endif
#endif
