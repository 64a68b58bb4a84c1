/* Columns and sums of a track from inverse dynamics (docs/theory.md 12.10). */
#ifndef KM_ARM_TRACKING_TRACK_EFFORT_H
#define KM_ARM_TRACKING_TRACK_EFFORT_H

#include "arm/tracking/joint_effort.h"
#include "arm/tracking/track.h"

/* Configuration and path point of one row of the table. */
typedef struct km_track_row {
  const double *q;
  km_path_point point;
  int sample;
} km_track_row;

/* Adds the columns of an arm with masses: joint forces, effort, power, energy. False: out of memory. */
bool km_track_add_effort_columns(km_table *table, const km_arm *arm);

/* Effort of the step that ends at row r, at the first row (`last` NULL) that of the step that begins there, of a single
 * row that of the minimum-norm rates. */
void km_track_effort(const km_track *track, km_arm_space *space, const km_track_row *r, const km_track_row *last,
                     const km_track_row *next, km_joint_effort *out);

/* Writes the cells of joint forces, effort and power from `out` on; those of energy are left to km_track_add_effort.
 * Nothing for an arm without masses. */
void km_track_write_effort(const km_arm *arm, const km_joint_effort *effort, double *out);

/* Integrals over the rows so far. */
typedef struct km_effort_sum {
  double seconds, effort, relative, energy, positive;
} km_effort_sum;

/* Adds the effort of a step that lasts `seconds` to the sums, and writes them to the summary and to the cells of
 * energy, the last ones before `row_end`. */
void km_track_add_effort(km_track *track, const km_joint_effort *effort, double seconds, km_effort_sum *sum,
                         double *row_end);

#endif
