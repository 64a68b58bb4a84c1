/* The parts of compiling a mechanism. Private to topology/. */
#ifndef KM_TOPOLOGY_COMPILE_H
#define KM_TOPOLOGY_COMPILE_H

#include "topology/chain.h"

/* Where walks have been, by body: kept from program to program by a stamp instead of clearing. */
typedef struct km_compile_workspace {
  int *stamp, *entry_joint, *first_step, *step_count; /* [body] `via`: the joint by which it was reached */
  km_chain_frame *body_frame;                         /* [body] */
  km_pose *reference_pose;                            /* [slot] poses of a program's slots when all coordinates are 0 */
  km_twist *twist;                                    /* [entry + 2] twists of one loop */
  int *next_column;                                   /* [substructure] where its next column goes */
  int *parent, *first, *frame;                        /* [body], [body + 2], [2 · joint] of km_longest_link */
  int current_stamp;                                  /* the current stamp */
} km_compile_workspace;

bool km_compile_workspace_create(const km_mechanism *mechanism, size_t steps, km_arena *arena,
                                 km_compile_workspace *out);
/* Reads every loop's steps, motion space and closing frames of one substructure into the mechanism, whose
 * arrays are large enough. */
void km_compile_loops(km_mechanism *mechanism, int substructure, km_compile_workspace *walks);
/* The larger of the substructure's span and the longest slide at q[coordinate]. At the start it is the substructure's size: a length
 * that every pose shares, and that scales with the units. */
double km_substructure_size(const km_mechanism *mechanism, int substructure, const double *q);
/* Chooses how the substructure's Jacobian is stored, and tells its entries and couplings where. False when out of
 * memory. */
bool km_compile_pattern(km_mechanism *mechanism, km_substructure *sub);
/* A distance, in the model's unit, that rounding makes of places that are computed from others: 1e-14 of the largest coordinate of a
 * frame. No length of its own enters: a mechanism of any scale is what it is in metres. */
double km_position_rounding(const km_model *model);
/* The square of the distance between two places; 0 where that is no more than the grain, or 1e-10 of the places' own size, to
 * which coordinates in a file are written. */
double km_squared_distance(km_vec3 a, km_vec3 b, double grain);
/* The greatest distance between the frames of two joints on one moving body, in the model's unit; bodies that rigid
 * joints tie to the inertial frame don't move. 0 where there is none. */
double km_longest_link(const km_model *model, const km_compile_workspace *walks, double grain);
/* The arrays of a mechanism whose topology is known, zeroed, and the workspace of its walks, in its arena. False when out
 * of memory. */
bool km_compile_allocate(km_mechanism *mechanism, km_compile_workspace *walks);
/* Fills these arrays from the model's numbers, but for where Jacobians are stored. */
void km_compile_values(km_mechanism *mechanism, const km_compiling *how, km_compile_workspace *walks);
/* Upper bound of the steps (and entries) that the loops of the mechanism need. */
void km_compile_bounds(const km_mechanism *mechanism, size_t *steps, size_t *entries);
/* True if a hinge about `axis` or a slide along it moves what it carries in planes across `normal`; false for other primitives. */
bool km_moves_in_plane(km_primitive primitive, km_vec3 axis, km_vec3 normal);
/* Do all loops of the program move in one plane, to the last digits? `plane` is then the base frame turned
 * so that its z is the normal, else the identity. */
bool km_find_plane(const km_mechanism *mechanism, const km_program *program, const km_compile_workspace *walks,
                   km_rotation *plane);
/* Rewrites such a program into planar steps. */
void km_compile_planar(km_mechanism *mechanism, km_program *program, const km_compile_workspace *walks,
                       const km_rotation *plane);

#endif
