/* Loop errors and Jacobian blocks of a substructure. */
#ifndef KM_KINEMATICS_LOOP_EQUATIONS_H
#define KM_KINEMATICS_LOOP_EQUATIONS_H

#include "kinematics/state.h"

/* At the state's coordinates: error screws e = log(X_a X_b⁻¹) of every loop (misfit), their independent rows
 * and the couplings' (error), and J (jacobian) with ė = J q̇ near e = 0; (163). Rows in each loop's motion space
 * about a point of the loop, lengths over the substructure's size. The state remembers the pose, and finds nothing again that it has
 * (km_cached_configuration). No allocation; O(steps + entries of J). */
void km_loops_update(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* The same without asking or remembering: for steps on the way to a pose, each of which is another one. */
void km_loops_recompute(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* Behind the last of these steps: the state remembers its pose, which they have led to. */
void km_loops_cache(const km_mechanism *mechanism, km_state *state, const km_substructure *sub);
/* Back to the coordinates that km_state_save has saved, with their errors and J; pivots are searched anew. */
void km_loops_restore_cached(const km_mechanism *mechanism, km_state *state, int substructure, const double *saved);

/* What a term of a coupling adds to its row, and the derivative by the scaled coordinate. */
double km_term_value(const km_mechanism *mechanism, const km_state *state, const km_term *term, double *slope);
/* Its second derivative; 0 of a linear one. */
double km_term_curvature(const km_mechanism *mechanism, const km_state *state, const km_term *term);

/* γ = −J̇ q̇, the right side of J q̈ = γ, scaled as J, at the pose of the last km_loops_update of this substructure:
 * of every loop's independent rows, gamma[rows]. `rate`[coordinate]: rates that keep the loops closed, in radians and
 * the model's length; theory 3, ḣ = ad(twist of what carries it) h. O(steps). */
void km_loops_velocity_products(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                                const double *rate, double *gamma);

/* ∂γ/∂x by the scaled rates x, in the pattern of the Jacobian: slopes[pattern.size], of which entries that no loop or coupling
 * has are kept. γ is a square of the rates: ∂γ/∂x x = 2 γ, and ∂γ/∂x of the rates a, times b, is γ(a + b) − γ(a) − γ(b). The
 * same pose, units and cost. */
void km_loops_velocity_slopes(const km_mechanism *mechanism, km_state *state, const km_substructure *sub,
                              const double *rate, double *slopes);

/* Pairs of columns by which a loop's rows bend: two joints on one side of it, the one before the other on the way out.
 * columns[2 · pairs], NULL: none; returns how many. Of mechanisms without ball joints. */
int km_loops_hessian_entries(const km_mechanism *mechanism, const km_substructure *sub, int *columns);

/* Σ multiplier_r ∂²e_r/∂x_i ∂x_j of closed loops, up to what vanishes along Jᵀ: ½ multiplier · ad(h_i) h_j
 * into pair[pairs], and of the couplings, which are sums of functions of single coordinates, into
 * own[columns]. Scaled as J, at the pose of the last km_loops_update. O(pairs). */
void km_loops_hessian(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub,
                      const double *multiplier, double *pair, double *own);

/* √(eᵀe/6) of the substructure's worst loop (235), coupling errors alike, and which loop that is (-1: a coupling
 * or none). Scaled. */
double km_loops_residual(const km_mechanism *mechanism, const km_state *state, const km_substructure *sub, int *worst);

#endif
