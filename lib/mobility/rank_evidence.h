/* Whether a substructure's rank is sure, judged by what doesn't depend on how the model is written. Private to
 * analysis/ and report/. */
#ifndef KM_MOBILITY_RANK_EVIDENCE_H
#define KM_MOBILITY_RANK_EVIDENCE_H

#include "kinematics/state.h"

/* Singular values over the largest. */
typedef struct km_rank_evidence {
  bool doubtful;  /* one lies between those that are surely 0 and those that surely aren't */
  double kept;    /* the smallest one that the rank counts */
  double dropped; /* the largest one that it doesn't; 0: there is none */
} km_rank_evidence;

/* At the state's pose after km_mobility_compute and km_poses_compute. The singular values are those of W J: J the whole
 * Jacobian, lengths over the root mean square distance of the joints' axes from the point that is nearest to them all;
 * W⁻² the Gram matrix of the loops as chains of joints, so that W J doesn't depend on which loops are chosen. Mirror
 * images, the order and senses of the joints, the frames of the bodies change nothing. Substructures of more than
 * KM_MAX_SINGULAR rows or columns are judged by their pivots. O(n³). KM_MEMORY. */
km_status km_rank_evidence_find(const km_mechanism *mechanism, km_state *state, int substructure, km_rank_evidence *out,
                                km_error *error);

#endif
