/* Proof that a closed configuration is a solution, and the only one nearby (docs/theory.md 4.17).
 *
 *   |J⁻¹| <= β,   |J⁻¹ F| <= η,   |F''| <= K at all real q,   h = β η K <= 1/2
 *   => one solution within (1 − √(1 − 2h)) / (β K),  no other within (1 + √(1 − 2h)) / (β K)      (Newton-Kantorovich)
 *   K² = Σ_loops n² (r² + 1),   n: columns of the loop, r: reach of its chain, three times it at a fixed point
 *
 * |·| is the Euclidean norm of angles and lengths over the substructure's size. Two derivatives of a product of
 * rotations and constant links are at most the reach for positions and 1 for rotations, whose errors are vee(R − Rᵀ)/2
 * and sin φ here: those of F differ from them by less than rounding at closed loops. β is the Frobenius norm of an
 * approximate inverse X over 1 − |1 − X J|. Rounding of F and J is bounded by its number of operations. Source: L. V.
 * Kantorovich, G. P. Akilov, Functional Analysis, chapter XVIII. */
#ifndef KM_SPACE_MODE_PROOF_H
#define KM_SPACE_MODE_PROOF_H

#include "space/complex/complex_closure.h"

typedef struct km_mode_proof {
  bool is_proved;     /* h <= 1/2, and no equation was left out */
  double h;           /* β η K; NaN: J is singular */
  double error_bound; /* distance to the solution */
  double radius;      /* distance without another solution */
} km_mode_proof;

/* Proves the configuration x, real and closed to rounding. False when out of memory. O(n³). */
bool km_mode_prove(const km_complex_closure *c, const km_wide *x, km_mode_proof *out);

#endif
