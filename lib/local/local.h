/* Local analysis of one closed configuration of one substructure: everything that first and second order and short
 * motions show about it (docs/theory.md 5).
 *
 *   first order  : J, its rank with the tolerance, Z: orthonormal basis of D null(J), k = freedom
 *   tangent      : x = D⁻¹ Z a, |a| = 1, x scaled; D = diag(column weights)
 *   second order : Q_i(a, b) = w_iᵀ D²e(Z a, Z b), w_i left null vectors of J;   tangent cone: aᵀ Q_i a = 0 for all i
 *
 * Two back ends implement Z a, Zᵀ x, w_i, Q_i(a, a) and 2 Q_i a: an explicit basis Z, where a has k entries; or, with
 * many freedoms or rows, the projector onto D null(J) as Z, where a has one entry per column, and sparse factors. All
 * queries use these five operations and are the same for both. Each is computed at the first query that needs it. */
#ifndef KM_LOCAL_LOCAL_H
#define KM_LOCAL_LOCAL_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

typedef struct km_local km_local;

/* Length that remains of a unit vector which the others don't span: spanned ones leave rounding, others far more. */
#define KM_INDEPENDENT 1e-3

/* Misfit that closing leaves on exact data, and shortest step of a driver that closing resolves: scaled. */
static const double km_exact_misfit = 1e-11;
/* First step beside a singular configuration, distance of the configurations by which it is located, and shortest first
 * step towards a new target: radians or substructure sizes, of the fastest coordinate. */
static const double km_singular_step = 1e-3;
/* Longest step along a curve of configurations, scaled. The arc of the cubic between two configurations has an error of
 * about h⁵/1000. */
static const double km_longest_arc_step = 0.05;
/* Least cosine between directions of one curve at two lengths: 37 degrees. */
static const double km_min_direction_cosine = 0.8;

/* Creates the analysis at the state's closed configuration, in the arena. `passive`: known passive freedoms of the
 * mechanism, which are separated from the others; NULL: none are known. The rank tolerance is at least `min_tolerance`.
 * The queries move the state. NULL when out of memory. */
km_local *km_local_create(const km_mechanism *mechanism, km_state *state, int substructure,
                          const km_passive_freedoms *passive, double min_tolerance, km_arena *arena);
/* Restores the configuration with its errors and J; pivots become stale. */
void km_local_restore(km_local *local);
void km_local_free(km_local *local);

/* True if J has full row rank. Then every tangent is that of a motion. */
bool km_local_has_full_row_rank(const km_local *local);

/* Finite mobility of the substructure (docs/theory.md 6.4). The motions are appended to `out`, and its flags
 * `undecided` and `truncated` are set if they hold here. */
int km_local_find_motions(km_local *local, km_finite_mobility *out);
/* Number of passive freedoms of a group that are finite motions; the group's freedoms if the freedoms are many. */
int km_local_count_passive(km_local *local, const km_passive_freedom *group);
/* Directions of the branches that meet at the configuration: confirmed or undecided tangents that differ in more than
 * their sense, as scaled unit directions[KM_MAX_BRANCHES × columns]. 0 at a regular configuration. */
int km_local_find_branches(km_local *local, double *directions);

/* Makes v a unit vector orthogonal to the `count` orthonormal rows of basis[count × size]. Returns the length that
 * remained before. */
double km_orthonormalise(const double *basis, int count, int size, double *v);
/* Orthonormal basis of the null space of A[rows × columns], to the relative pivot `tolerance`: (*N)[dimension ×
 * columns]. Returns the dimension; -1 when out of memory. */
int km_dense_null_space(const double *A, int rows, int columns, double tolerance, km_arena *arena, double **N);
/* Projects the scaled step x onto the null space of J and normalises it, |D x| = 1. Returns the length before. The
 * partition belongs to the state's Jacobian. projection[columns] is workspace. */
double km_tangent_project(const km_mechanism *mechanism, km_state *state, int substructure, double *x,
                          double *projection);

#endif
