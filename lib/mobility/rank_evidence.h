/* Evidence of a substructure's rank, independent of how the model is written. Private to the library. */
#ifndef KM_MOBILITY_RANK_EVIDENCE_H
#define KM_MOBILITY_RANK_EVIDENCE_H

#include "kinematics/state.h"

/* Singular values relative to the largest. */
typedef struct km_rank_evidence {
  bool doubtful;  /* a singular value is neither clearly zero nor clearly nonzero */
  double kept;    /* smallest kept singular value */
  double dropped; /* largest dropped singular value; 0: none */
} km_rank_evidence;

/* Finds the evidence after km_mobility_compute and km_poses_compute: singular values of L⁻¹ J, with J the six-row
 * Jacobian about the point nearest to all joint axes, lengths over their root mean square distance from it, and L Lᵀ
 * the Gram matrix of the loops as chains of joints. They are invariant under mirror images, order and senses of
 * joints, body frames and the choice of loops. Larger substructures than KM_MAX_SINGULAR rows or columns are
 * classified by their pivots. O(n³). KM_MEMORY. */
km_status km_rank_evidence_find(const km_mechanism *mechanism, km_state *state, int substructure, km_rank_evidence *out,
                                km_error *error);

#endif
