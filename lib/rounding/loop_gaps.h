/* Gaps of a substructure's loops, and their derivatives by the coordinates and by the numbers that place frames
 * (docs/theory.md 14.6).
 *
 *   e = log(X Y⁻¹)      X, Y: poses of the closing body along both sides of a loop, in the inertial frame
 *   de = J dq + E dp    six rows (v; ω) for each loop, lengths over the substructure's size; then couplings
 *   E_k = ± Ad(X_f) (move; turn) of number k for each joint of the loop whose parent (+) or child (−) frame f it places
 */
#ifndef KM_ROUNDING_LOOP_GAPS_H
#define KM_ROUNDING_LOOP_GAPS_H

#include "kinematics/state.h"
#include "model/written_numbers.h"

/* Sizes of a substructure's system, and workspace. */
typedef struct km_loop_gaps {
  const km_mechanism *m;
  km_state *s;
  int index, rows, columns;
  km_vec3 about;     /* reference point of the rows: the first joint at the start */
  km_twist *twist;   /* [coordinate] */
  km_vec3 *normal;   /* [loop of the substructure] of a planar loop the normal, in the axes of its base body; else 0 */
  bool *is_hinged;   /* [loop of the substructure] planar loop of hinges, which may be offset along the normal */
  bool keeps_planes; /* offsets along the normals don't count */
} km_loop_gaps;

/* Prepares the system. The poses of all bodies must be current (km_poses_compute). Planes are those of the mechanism's
 * loops. False without memory. */
bool km_loop_gaps_create(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                         km_loop_gaps *out);
/* Continues with another compilation and state of the mechanism. The planes stay. */
void km_loop_gaps_replace(km_loop_gaps *gaps, const km_mechanism *mechanism, km_state *state);
/* Computes e[rows] and J[rows × columns], column-major, at the state's coordinates. The component of e
 * along the normal of a planar loop of hinges is 0 if `keeps_planes` is set. */
void km_loop_gaps_compute(km_loop_gaps *gaps, double *e, double *J);
/* Computes E[rows × count] of numbers[count], after km_loop_gaps_compute. `half`[count] scales the columns. */
void km_loop_gaps_number_columns(const km_loop_gaps *gaps, const km_written_number *numbers, const double *half,
                                 int count, double *E);
/* The part of a number's effect that leaves the planes of planar loops as they are. */
km_written_number km_loop_gaps_keep_plane(const km_loop_gaps *gaps, const km_written_number *number);
/* Change of J that one unit of every number causes, about: the root of the sum of the squared twists of all ends of
 * joints that the numbers place. */
double km_loop_gaps_noise(const km_loop_gaps *gaps, const km_written_number *numbers, const double *half, int count);

#endif
