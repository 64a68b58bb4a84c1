/* Parts of compiling a mechanism. Private to topology/ and kinematics/. */
#ifndef KM_TOPOLOGY_COMPILE_H
#define KM_TOPOLOGY_COMPILE_H

#include "topology/chain.h"

/* Workspace of a compilation. Bodies that a program has reached are marked by a stamp, which needs no clearing. */
typedef struct km_compile_workspace {
  int *stamp, *entry_joint, *first_step, *step_count; /* [body] stamp of the program that reached it; joint by which;
                                                       * its steps */
  km_chain_frame *body_frame;                         /* [body] end frame of the chain at the body */
  km_pose *reference_pose;                            /* [slot] poses of a program's slots with all coordinates 0 */
  km_twist *twist;                                    /* [3 · steps] unit twists of one loop */
  int *next_column;                                   /* [substructure] next free column */
  int *parent;                                        /* [body] of km_longest_link */
  int current_stamp;                                  /* stamp of the present program */
} km_compile_workspace;

bool km_compile_workspace_create(const km_mechanism *mechanism, size_t steps, km_arena *arena,
                                 km_compile_workspace *out);
/* Compiles every loop of one substructure: steps, motion space and closing frames, into arrays of sufficient size. */
void km_compile_loops(km_mechanism *mechanism, int substructure, km_compile_workspace *workspace);
/* Size of a substructure at q[coordinate]: the larger of its span and its longest slide. At the start values it is the
 * substructure's length unit, which is shared by all configurations and scales with the model's units. */
double km_substructure_size(const km_mechanism *mechanism, int substructure, const double *q);
/* Chooses the storage of the substructure's Jacobian, and sets the value indices of its entries and couplings. False
 * when out of memory. */
bool km_compile_pattern(km_mechanism *mechanism, km_substructure *sub);
/* Distance, in the model's unit, that rounding of computed positions can cause: 1e-14 of the largest coordinate of a
 * frame. It contains no absolute length, so results do not depend on the scale of the mechanism. */
double km_position_rounding(const km_model *model);
/* Squared distance of two positions; 0 if the distance is at most `rounding`, or 1e-10 of the positions' own size, to
 * which files state coordinates. */
double km_squared_distance(km_vec3 a, km_vec3 b, double rounding);
/* Longest link: greatest distance between the frames of two joints on one moving body, in the model's unit. Bodies tied
 * to the inertial frame by rigid joints do not move. 0 for none. parent[body]: workspace. */
double km_longest_link(const km_mechanism *mechanism, int *parent);
/* Allocates the arrays of a mechanism with known topology, zeroed, and the workspace, in its arena. False when out of
 * memory. */
bool km_compile_allocate(km_mechanism *mechanism, km_compile_workspace *workspace);
/* Compiles the model's numbers into these arrays, except the storage of Jacobians. */
void km_compile_values(km_mechanism *mechanism, const km_compiling *options, km_compile_workspace *workspace);
/* Upper bounds of the steps and entries of the mechanism's loops. */
void km_compile_bounds(const km_mechanism *mechanism, size_t *steps, size_t *entries);
/* True if a hinge about `axis`, or a slide along it, moves bodies in planes normal to `normal`; false for other
 * primitives. */
bool km_moves_in_plane(km_primitive primitive, km_vec3 axis, km_vec3 normal);
/* True if all loops of the program move in one plane, to rounding. `plane` is then the base frame rotated so that its z
 * axis is the normal, else the identity. */
bool km_find_plane(const km_mechanism *mechanism, const km_program *program, const km_compile_workspace *workspace,
                   km_rotation *plane);
/* Converts such a program to planar steps. */
void km_compile_planar(km_mechanism *mechanism, km_program *program, const km_compile_workspace *workspace,
                       const km_rotation *plane);

#endif
