/* The mechanism of a given rank that is nearest to the numbers of a file (docs/theory.md 14.7).
 *
 *   min |x|²   subject to   e(q_i, p + h x) = 0   for all i
 *   N_iᵀ E_i h dx = −N_iᵀ e_i     Gauss-Newton step; N_i: left null vectors of J(q_i) of the given rank
 *
 * p: numbers, h: half a unit of the last digit of each, q_i: configurations along the motion, e: gaps, E = ∂e/∂p. */
#ifndef KM_ROUNDING_NEAREST_MECHANISM_H
#define KM_ROUNDING_NEAREST_MECHANISM_H

#include "rounding/loop_gaps.h"
#include "rounding/regular_shapes.h"

/* A substructure of a model whose numbers change. */
typedef struct km_nearest_mechanism {
  km_model *model;
  const km_compiling *options;
  km_arena *arena;
  const km_mechanism *m; /* compiled from the present numbers, with its state */
  km_state *s;
  km_mechanism *own; /* the compilation after a change of numbers; NULL: `m` and `s` are the caller's */
  km_loop_gaps gaps;
  int index, rows, columns;
  int count;                      /* numbers that may change */
  km_written_number *number;      /* [count] */
  double *half, *x;               /* [count] x: changes in units of `half` */
  const km_relations *relations;  /* further conditions; NULL: none */
  const km_pose *written;         /* [frame] poses as written */
  double *e, *J, *E, *S, *U, *Vt; /* gaps, J and its singular values and vectors, at the last configuration */
  int rank;                       /* that the nearest mechanism is to have */
  double strictness;              /* factor of the bounds of the present check */
  int configuration_count;
  double *configuration, *heading; /* [most configurations × (3 · columns, columns)] saved coordinates, and the steps
                                    * that led there */
  double *start;                   /* [3 · columns] configuration from which the search starts */
} km_nearest_mechanism;

/* Reserves the workspace for a substructure of `mechanism`, with a state whose poses are current. `written`[frame]:
 * poses of the file. The caller fills number and half, and frees by km_nearest_release. KM_MEMORY. */
km_status km_nearest_create(km_model *model, const km_compiling *options, const km_mechanism *mechanism,
                            km_state *state, const km_pose *written, int substructure, int most_numbers,
                            km_arena *arena, km_nearest_mechanism *out, km_error *error);
void km_nearest_release(km_nearest_mechanism *nearest);
/* Sets the frames to their written poses, changed by x, and compiles the model again. */
km_status km_nearest_apply(km_nearest_mechanism *nearest, km_error *error);
/* Computes e, J and the singular values of J at the state's configuration. */
km_status km_nearest_decompose(km_nearest_mechanism *nearest, km_error *error);
/* Moves the state to the nearest configuration without gaps in the first `rank` left singular directions. *converged is
 * false if the steps don't end. */
km_status km_nearest_correct(km_nearest_mechanism *nearest, bool *converged, km_error *error);
/* Finds x for the relations alone. *found is false if they need changes beyond rounding. */
km_status km_nearest_regular(km_nearest_mechanism *nearest, bool *found, km_error *error);
/* Finds x for nearest->rank, from nearest->start. *found is false if
 * no mechanism within about one unit of the written numbers moves with that rank. */
km_status km_nearest_find(km_nearest_mechanism *nearest, bool *found, km_error *error);

#endif
