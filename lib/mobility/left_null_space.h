/* Left null vectors of a substructure's six-row Jacobian, and the names of its redundant constraints (theory 7).
 * Private to the library. */
#ifndef KM_MOBILITY_LEFT_NULL_SPACE_H
#define KM_MOBILITY_LEFT_NULL_SPACE_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* The six-row Jacobian J_6 of a substructure: six rows per loop about its own point, lengths over the substructure's
 * size, then the couplings. A block is a loop's six rows or a coupling's row. */
typedef struct km_left_space {
  const km_mechanism *m;
  km_state *s;
  int index, rows;
  const km_substructure *sub;
  double tolerance;
  km_vec3 *about; /* [loop of the substructure] reference point */
  /* [4 · joint] results of redundancy_remedies.c for the swaps of a joint: 1 raises the rank, -1 does not, 0 unknown */
  signed char *swap_result;
} km_left_space;

/* Part of a left null vector in one block: a wrench (f; τ) of a loop, or a force of a coupling. */
typedef struct km_left_part {
  int vector; /* index among the vectors that span several loops */
  int block;  /* loop of the substructure; loops + index of a coupling */
  double w[6];
} km_left_part;

/* A basis of {w: wᵀ J = 0} of unit vectors. Vectors of single loops are stored as six entries and orthonormal.
 * Vectors that span several loops are orthogonal to them and stored by their nonzero parts. */
typedef struct km_left_null {
  int *first;    /* [loop of the substructure + 1] into `local` */
  double *local; /* [6 × local_count] */
  int local_count, spanning_count;
  int *part_start; /* [spanning_count + 1] into `part`, ordered by vector, then by block */
  km_left_part *part;
  int *block_start, *block_part; /* [block + 1] into block_part: indices of a block's parts, ordered by vector */
  bool is_orthonormal;           /* spanning vectors are orthonormal; else each is a unit vector with few parts */
} km_left_null;

/* Prepares the data of a substructure. False without memory. */
bool km_left_space_create(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                          km_left_space *out);
/* Finds all left null vectors at the state's configuration, whose partition and body poses must be current. False
 * without memory. */
bool km_left_null_find(const km_left_space *space, km_arena *arena, km_left_null *out);
static inline int km_left_null_count(const km_left_null *null) {
  return null->local_count + null->spanning_count;
}

/* Expands vector k to all rows of J, v[rows]; vectors of single loops come first. */
void km_left_null_expand(const km_left_space *space, const km_left_null *null, int k, double *v);

/* Visits the columns of one loop in J: six entries each, with the sign of the loop's direction through the joint. */
typedef void (*km_left_column_visitor)(void *out, int column, const double entry[6]);
void km_left_for_each_column(const km_left_space *space, int block, km_left_column_visitor visit, void *out);
/* Number of columns of one loop in J. */
int km_left_column_count(const km_left_space *space, int block);
/* Adds the vectors that span several loops to those of single loops. False without memory. */
bool km_left_null_find_multiloop(const km_left_space *space, km_arena *arena, km_left_null *null);

/* First row of a block, and its number of rows. */
static inline int km_left_row(const km_left_space *a, int block) {
  return block < a->sub->loop_count ? 6 * block : 5 * a->sub->loop_count + block;
}
static inline int km_left_rows(const km_left_space *a, int block) {
  return block < a->sub->loop_count ? 6 : 1;
}

/* Finds the joint types that would remove a redundancy with the wrench w in `block` (theory 7.4). `null` are all left
 * null vectors; `work[2 · spanning_count]` is 0 before and after. */
void km_remedies_find(const km_left_space *space, const km_left_null *null, int block, const double w[6], double *work,
                      km_redundancy *item);

#endif
