/* Drives of mechanisms that differ in their numbers only, side by side: a step that needs no decision is taken for all
 * of them in vectors, any other by the drive alone. */
#ifndef KM_CONTINUATION_BATCH_BATCH_H
#define KM_CONTINUATION_BATCH_BATCH_H

#include "continuation/driver_motion.h"

/* As many drives go side by side, whatever registers the processor has. */
enum { KM_BATCH_LANES = 16 };

typedef struct km_batch km_batch;

/* For `count` drives of the same coordinate, each with a mechanism and a state of its own; they are borrowed and have to
 * outlive the lanes. *out is NULL where their mechanisms differ in more than numbers, or have what lanes aren't for (limits
 * of balls, couplings by polynomials, large substructures): then drive them one by one. The memory of earlier lanes is taken from
 * `memory` and given back there; NULL: there is none. KM_MEMORY. */
km_status km_batch_create(km_arena *memory, km_driver_motion *const *drives, int count, km_batch **out,
                          km_error *error);
void km_batch_free(km_arena *memory, km_batch *lanes);

/* A row is quiet as long as no entry of a unit direction of motion, times what it was at the row before, is below this, */
static const double km_driver_motion_quiet = 1e-9;
/* and the parabola through its sizes at the row and at the two before it stays above this part of the least of them. Then it has
 * hardly passed 0 twice between two of these rows. */
static const double km_driver_motion_dip = 0.5;

/* km_driver_motion_move_to(drives[i], targets[i]) for every drive whose bit i is set in `wanted`, with the same bits. Where
 * km_driver_motion_is_batched says so, the state has its coordinates and mobility numbers; whatever else is read of it (Jacobian,
 * partition, null space, loop errors) is up to date only after km_driver_motion_prepare_read. */
void km_batch_move_to(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);

/* The same in two parts, over several rows. Drives go through up to KM_BATCH_ROWS rows of targets, targets[row ×
 * KM_BATCH_LANES + i], as long as all of them ride and the rows are quiet or, where nobody `looks` at rows, the pivots serve
 * there. Returns how many rows they have passed. km_batch_arrive then ends the row behind them: `targets` and `reaches`
 * are of that row alone. */
enum { KM_BATCH_ROWS = 32 };
int km_batch_advance_rows(km_batch *lanes, unsigned wanted, const double *targets, int rows, bool looks);
void km_batch_arrive(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);
/* Before that, what a drive found at the rows that were passed, from the first one on; and a row, 0 is the first, is shown as
 * if the drives were there: coordinates and mobility numbers in the states, km_driver_motion_batched_residual and
 * km_driver_motion_batched_direction. */
typedef struct km_batched_rows {
  const double *q, *numbers; /* [column × KM_BATCH_LANES] coordinates and mobility numbers at the first row */
  const double *residual;
  size_t apart; /* those of the next row are so many doubles behind these */
} km_batched_rows;
km_batched_rows km_driver_motion_batched_rows(const km_driver_motion *drive);
void km_batch_write_row(km_batch *lanes, int row);

/* km_driver_motion_move_to(drives[i], targets[i]) for those drives of `wanted` that can go there in their lanes, with the same bits; their bits
 * are returned. The others are where they were, and alone. */
unsigned km_batch_try(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);

/* Rates at targets near by: km_driver_motion_tangent at targets[i] into rates[i], for every bit of `wanted`. The drives stay where they
 * are. Returns those that could go in their lanes; the others have to go alone. */
unsigned km_batch_sample(km_batch *lanes, unsigned wanted, const double *targets, double *const *rates);

/* Did the drive's last step go in its lane? */
bool km_driver_motion_is_batched(const km_driver_motion *drive);
/* Of a drive that rides: km_loops_residual of its substructure; and its null vector D q̇ at unit length, in which the driver
 * is positive, into z[coordinate] (the others stay). */
double km_driver_motion_batched_residual(const km_driver_motion *drive);
void km_driver_motion_batched_direction(const km_driver_motion *drive, double *z);
/* The same vector as the state's basis, where one freedom is left. */
void km_driver_motion_read_basis(km_driver_motion *drive);
/* Brings the state of a drive that rides up to date with all that it has. The drive stays in its lane, unless other pivots are
 * searched in the state before it goes on. */
void km_driver_motion_prepare_read(km_driver_motion *drive);
/* Gives a drive back what its lane has found, so that it can go on alone. Part of whatever moves a drive. */
void km_driver_motion_write_back(km_driver_motion *drive);
/* Takes a drive that goes no farther out of its lane, where nobody reads what its state has beside coordinates and mobility
 * numbers. */
void km_driver_motion_leave_batch(km_driver_motion *drive);

#endif
