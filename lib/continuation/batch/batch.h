/* Drives of mechanisms that differ in their numbers only, side by side: a step that needs no decision is taken for all
 * of them in vectors, any other by the drive alone. */
#ifndef KM_CONTINUATION_BATCH_BATCH_H
#define KM_CONTINUATION_BATCH_BATCH_H

#include "continuation/driver_motion.h"

/* As many drives go side by side, whatever registers the processor has. */
enum { KM_DRIVE_LANES = 16 };

typedef struct km_drive_lanes km_drive_lanes;

/* For `count` drives of the same coordinate, each with a mechanism and a state of its own; they are borrowed and have to
 * outlive the lanes. *out is NULL where their mechanisms differ in more than numbers, or have what lanes aren't for (limits
 * of balls, couplings by polynomials, large substructures): then drive them one by one. The memory of earlier lanes is taken from
 * `memory` and given back there; NULL: there is none. KM_MEMORY. */
km_status km_drive_lanes_create(km_arena *memory, km_drive *const *drives, int count, km_drive_lanes **out,
                                km_error *error);
void km_drive_lanes_free(km_arena *memory, km_drive_lanes *lanes);

/* A row is quiet as long as no entry of a unit direction of motion, times what it was at the row before, is below this, */
static const double km_drive_quiet = 1e-9;
/* and the parabola through its sizes at the row and at the two before it stays above this part of the least of them. Then it has
 * hardly passed 0 twice between two of these rows. */
static const double km_drive_dip = 0.5;

/* km_drive_to(drives[i], targets[i]) for every drive whose bit i is set in `wanted`, with the same bits. Where
 * km_drive_rides says so, the state has its coordinates and mobility numbers; whatever else is read of it (Jacobian,
 * partition, null space, loop errors) is up to date only after km_drive_look. */
void km_drive_lanes_to(km_drive_lanes *lanes, unsigned wanted, const double *targets, km_reach *reaches);

/* The same in two parts, over several rows. Drives go through up to KM_DRIVE_ROWS rows of targets, targets[row ×
 * KM_DRIVE_LANES + i], as long as all of them ride and the rows are quiet or, where nobody `looks` at rows, the pivots serve
 * there. Returns how many rows they have passed. km_drive_lanes_arrive then ends the row behind them: `targets` and `reaches`
 * are of that row alone. */
enum { KM_DRIVE_ROWS = 32 };
int km_drive_lanes_pass(km_drive_lanes *lanes, unsigned wanted, const double *targets, int rows, bool looks);
void km_drive_lanes_arrive(km_drive_lanes *lanes, unsigned wanted, const double *targets, km_reach *reaches);
/* Before that, what a drive found at the rows that were passed, from the first one on; and a row, 0 is the first, is shown as
 * if the drives were there: coordinates and mobility numbers in the states, km_drive_ridden_residual and
 * km_drive_ridden_direction. */
typedef struct km_ridden_rows {
  const double *q, *numbers; /* [column × KM_DRIVE_LANES] coordinates and mobility numbers at the first row */
  const double *residual;
  size_t apart; /* those of the next row are so many doubles behind these */
} km_ridden_rows;
km_ridden_rows km_drive_ridden_rows(const km_drive *drive);
void km_drive_lanes_show(km_drive_lanes *lanes, int row);

/* km_drive_to(drives[i], targets[i]) for those drives of `wanted` that can go there in their lanes, with the same bits; their bits
 * are returned. The others are where they were, and alone. */
unsigned km_drive_lanes_try(km_drive_lanes *lanes, unsigned wanted, const double *targets, km_reach *reaches);

/* Rates at targets near by: km_drive_tangent at targets[i] into rates[i], for every bit of `wanted`. The drives stay where they
 * are. Returns those that could go in their lanes; the others have to go alone. */
unsigned km_drive_lanes_visit(km_drive_lanes *lanes, unsigned wanted, const double *targets, double *const *rates);

/* Did the drive's last step go in its lane? */
bool km_drive_rides(const km_drive *drive);
/* Of a drive that rides: km_loops_residual of its substructure; and its null vector D q̇ at unit length, in which the driver
 * is positive, into z[coordinate] (the others stay). */
double km_drive_ridden_residual(const km_drive *drive);
void km_drive_ridden_direction(const km_drive *drive, double *z);
/* The same vector as the state's basis, where one freedom is left. */
void km_drive_show_basis(km_drive *drive);
/* Brings the state of a drive that rides up to date with all that it has. The drive stays in its lane, unless other pivots are
 * searched in the state before it goes on. */
void km_drive_look(km_drive *drive);
/* Gives a drive back what its lane has found, so that it can go on alone. Part of whatever moves a drive. */
void km_drive_settle(km_drive *drive);
/* Takes a drive that goes no farther out of its lane, where nobody reads what its state has beside coordinates and mobility
 * numbers. */
void km_drive_leave(km_drive *drive);

#endif
