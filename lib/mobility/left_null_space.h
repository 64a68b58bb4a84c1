/* The left null vectors of a substructure, and the names of its redundant constraints. Private to analysis/. */
#ifndef KM_MOBILITY_LEFT_NULL_SPACE_H
#define KM_MOBILITY_LEFT_NULL_SPACE_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* Where a joint lies in a loop. */
typedef struct km_loop_place {
  int loop;   /* its place in the substructure */
  int member; /* into the topology's members */
} km_loop_place;

/* The whole Jacobian J of a substructure: the six rows of each loop about a point of its own, lengths over the
 * substructure's size, then the couplings. */
typedef struct km_left_space {
  const km_mechanism *m;
  km_state *s;
  int index, rows;
  const km_substructure *sub;
  double tolerance;
  int *first_place; /* [joint + 1] into `place`: the loops of each joint */
  km_loop_place *place;
  km_vec3 *about;     /* [loop] by its place in the substructure */
  signed char *helps; /* [4 · joint] what redundancy_remedies.c has found out about swaps of a joint: 0 nothing yet */
} km_left_space;

/* What a left null vector has in one loop: a wrench (f; τ); or in one coupling: a force. */
typedef struct km_left_part {
  int vector; /* of those of several loops */
  int place;  /* of the loop in the substructure; loops + index of a coupling */
  double w[6];
} km_left_part;

/* A basis of {w: wᵀJ = 0}, of unit vectors. What a loop has by itself is kept as its six entries, orthonormal: long
 * chains of loops have little else. What several loops have only together is at right angles to that, and kept by the
 * loops that have a part in it. */
typedef struct km_left_null {
  int *first;    /* [loop + 1] into `local`, by the loop's place in the substructure */
  double *local; /* [6 a vector] */
  int local_count, whole_count;
  int *part_start; /* [whole_count + 1] into `part`, in the order of the vectors, then of the places */
  km_left_part *part;
  int *at_start, *at; /* [place + 1] into `at`: the parts of a place, in the order of the vectors */
  bool orthonormal;   /* those of several loops too; else each alone has few parts */
} km_left_null;

/* False when out of memory. */
bool km_left_space_make(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                        km_left_space *out);
/* At the state's pose, whose partition and body poses must be up to date. False when out of memory. */
bool km_left_null_find(const km_left_space *space, km_arena *arena, km_left_null *out);
static inline int km_left_null_count(const km_left_null *null) {
  return null->local_count + null->whole_count;
}

/* The columns of one loop in J, six entries each, signed as the loop passes the joint. */
typedef void (*km_left_take)(void *out, int column, const double entry[6]);
void km_left_visit(const km_left_space *space, int place, km_left_take take, void *out);
/* Orthonormal left null vectors W[rows × returned] of a matrix that is given transposed: `rows` constraints of `height`
 * entries. -1: out of memory. */
int km_left_solve(const double *T, int height, int rows, double tolerance, km_arena *arena, double *W);
/* The vectors of several loops, where `null` holds those of single loops already. False when out of memory. */
bool km_left_null_find_multiloop(const km_left_space *space, km_arena *arena, km_left_null *null);

/* Where the part of a place begins among the rows, and how many rows it has. */
static inline int km_left_row(const km_left_space *a, int place) {
  return place < a->sub->loop_count ? 6 * place : 5 * a->sub->loop_count + place;
}
static inline int km_left_rows(const km_left_space *a, int place) {
  return place < a->sub->loop_count ? 6 : 1;
}

/* Swaps of the loop's joints that would end a redundancy with the wrench w of the loop at `place` in the substructure,
 * by test. `null` are all left null vectors; `work[2 · whole_count]` is 0, and left so. */
void km_remedies_find(const km_left_space *space, const km_left_null *null, int place, const double w[6], double *work,
                      km_redundancy *item);

#endif
