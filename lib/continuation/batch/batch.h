/* Batches (theory 4.12): driven motions of mechanisms with equal structure and different numbers advance together in
 * SIMD lanes. A step without decisions is taken for all lanes at once; any other by the single motion. All results
 * have the bits of a single motion. */
#ifndef KM_CONTINUATION_BATCH_BATCH_H
#define KM_CONTINUATION_BATCH_BATCH_H

#include "continuation/driver_motion.h"

/* Lanes of a batch, for every register width. */
enum { KM_BATCH_LANES = 16 };

typedef struct km_batch km_batch;

/* Creates a batch of `count` motions of the same coordinate, each with its own mechanism and state; they are borrowed
 * and must outlive the batch. *out is NULL if the mechanisms differ in structure or have properties that batches do
 * not cover (limits of ball joints, polynomial couplings, large substructures): advance them singly. Memory of an
 * earlier batch is taken from `memory` and given back there; NULL: none. KM_MEMORY. */
km_status km_batch_create(km_arena *memory, km_driver_motion *const *drives, int count, km_batch **out,
                          km_error *error);
void km_batch_free(km_arena *memory, km_batch *lanes);

/* A row contains no zero of an entry z_k of the unit direction of motion if z_k times its value in the previous row
 * is above km_relative_zero, and the parabola through |z_k| in this and the two previous rows stays above
 * this part of the least of them: two sign changes between two rows are then unlikely. */
static const double km_batch_minimum_ratio = 0.5;

/* Does km_driver_motion_move_to(drives[i], targets[i]) for every motion whose bit i is set in `wanted`, with the same
 * bits. If km_driver_motion_is_batched, the state has its coordinates and mobility numbers; Jacobian, partition, null
 * space and closure errors are valid only after km_driver_motion_prepare_read. */
void km_batch_move_to(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);

/* Moves in two parts, over several rows. First, motions advance through up to KM_BATCH_ROWS rows of targets,
 * targets[row × KM_BATCH_LANES + i], while all of them are batched and the rows contain no zero or, without observers
 * (is_observed false), the pivots stay valid. Returns the number of rows passed. Then km_batch_arrive ends the next
 * row: its `targets` and `reaches` are of that row alone. */
enum { KM_BATCH_ROWS = 32 };
int km_batch_advance_rows(km_batch *lanes, unsigned wanted, const double *targets, int rows, bool is_observed);
void km_batch_arrive(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);
/* Results of a motion at the passed rows, before km_batch_arrive. km_batch_write_row makes a row, 0 is the first,
 * current: coordinates and mobility numbers in the states, km_driver_motion_batched_residual and
 * km_driver_motion_batched_direction. */
typedef struct km_batched_rows {
  const double *q, *numbers; /* [column × KM_BATCH_LANES] coordinates and mobility numbers in the first row */
  const double *residual;
  size_t stride; /* stride between rows, in doubles */
} km_batched_rows;
km_batched_rows km_driver_motion_batched_rows(const km_driver_motion *drive);
void km_batch_write_row(km_batch *lanes, int row);

/* Does km_driver_motion_move_to(drives[i], targets[i]) for the motions of `wanted` that can reach their targets in
 * their lanes, with the same bits; returns their bits. The others keep their configuration and leave the batch. */
unsigned km_batch_try(km_batch *lanes, unsigned wanted, const double *targets, km_motion_end *reaches);

/* Computes km_driver_motion_tangent at targets[i] into rates[i], for every bit of `wanted`. The motions keep their
 * configuration. Returns those that were computed in their lanes; the others need a single motion. */
unsigned km_batch_sample(km_batch *lanes, unsigned wanted, const double *targets, double *const *rates);

/* True if the last step of the motion was taken in its lane. */
bool km_driver_motion_is_batched(const km_driver_motion *drive);
/* Return, for a batched motion, km_loops_residual of its substructure; and the unit null vector D q̇, with a positive
 * entry of the driver, into z[coordinate] (other entries stay). */
double km_driver_motion_batched_residual(const km_driver_motion *drive);
void km_driver_motion_batched_direction(const km_driver_motion *drive, double *z);
/* Makes that vector the basis of the state's null space; with one freedom. */
void km_driver_motion_read_basis(km_driver_motion *drive);
/* Updates the state of a batched motion completely. The motion stays in its lane unless other pivots are searched in
 * the state before its next step. */
void km_driver_motion_prepare_read(km_driver_motion *drive);
/* Writes the results of a lane back into its motion, which then continues singly. Part of every function that moves a
 * motion. */
void km_driver_motion_write_back(km_driver_motion *drive);
/* Removes a motion that ends from its lane, if the state is read no further than coordinates and mobility numbers. */
void km_driver_motion_leave_batch(km_driver_motion *drive);

#endif
