/* Closure errors, Jacobian, velocity products and Hessian of the loops of a substructure (docs/theory.md 2.3, 2.6,
 * 2.7).
 *
 *   e = log(X_a X_b⁻¹)     J = de/dq     γ = −J̇ q̇     Σ_r λ_r ∂²e_r/∂x_i ∂x_j */
#ifndef KM_KINEMATICS_LOOP_EQUATIONS_H
#define KM_KINEMATICS_LOOP_EQUATIONS_H

#include "kinematics/state.h"

/* Computes the closure errors of all loops (state->misfit, all six components), the errors of the independent rows and
 * couplings (state->error), and J (state->jacobian) with ė = J q̇ near e = 0. Rows lie in each loop's motion space,
 * about a point of the loop; lengths are over the substructure's size. Nothing is recomputed at the cached
 * configuration. No allocation; O(steps + entries of J). */
void km_loops_update(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* As km_loops_update without the cache: for iterates, each of which is a new configuration. */
void km_loops_recompute(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* Stores the present configuration as the cached one. Call it after the last km_loops_recompute of an iteration. */
void km_loops_cache(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* Restores saved coordinates with their errors and J. Pivots become stale. */
void km_loops_restore_cached(const km_mechanism *mechanism, km_state *state, int substructure, const double *saved);

/* Value of a term of a coupling, and its derivative with respect to the scaled coordinate. */
double km_term_value(const km_mechanism *mechanism, const km_state *state, const km_term *term, double *slope);
/* Second derivative of a term; 0 for a linear one. */
double km_term_curvature(const km_mechanism *mechanism, const km_state *state, const km_term *term);

/* Velocity products γ = −J̇ q̇, the right side of J q̈ = γ: gamma[rows], scaled as J, at the configuration of the last
 * km_loops_update of this substructure. `rate`[coordinate]: rates that keep the loops closed, in radians and the
 * model's length. Each column is carried by its frame, ḣ = ad(V) h (docs/theory.md 2.6). O(steps). */
void km_loops_velocity_products(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                                const double *rate, double *gamma);

/* Derivatives ∂γ/∂x by the scaled rates x, in the pattern of the Jacobian: slopes[pattern.size]; entries without a loop
 * or coupling keep their value. γ is quadratic: (∂γ/∂x) x = 2 γ, and ∂γ/∂x at the rates a, times b, is γ(a + b) − γ(a)
 * − γ(b). Conditions and cost as km_loops_velocity_products. */
void km_loops_velocity_slopes(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                              const double *rate, double *slopes);

/* Lists the pairs of columns with an entry in the Hessian of the closure: two joints on one side of a loop, in the
 * order from the base. columns[2 · pairs] may be NULL. Returns the number of pairs. Mechanisms without ball joints
 * only. */
int km_loops_hessian_entries(const km_mechanism *mechanism, const km_substructure *sub, int *columns);

/* Hessian of the closure, Σ multiplier_r ∂²e_r/∂x_i ∂x_j, of closed loops, up to terms that vanish along Jᵀ
 * (docs/theory.md 2.7). Loops: ½ multiplier · ad(h_i) h_j into hessian[pairs]. Couplings are sums of functions of
 * single coordinates: into diagonal[columns]. Scaled as J, at the configuration of the last km_loops_update.
 * O(pairs). */
void km_loops_hessian(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub,
                      const double *multiplier, double *hessian, double *diagonal);

/* Residual √(eᵀe/6) of the substructure's worst loop, errors of couplings alike (235). Scaled. */
double km_loops_residual(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub);
/* Returns the residual and finds that loop; -1: a coupling or none. */
double km_loops_worst(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub, int *worst);

#endif
