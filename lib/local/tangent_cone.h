/* Tangents of a substructure at one closed configuration, and which of them belong to finite motions (docs/theory.md
 * 5).
 *
 *   x = D⁻¹ Z a: scaled tangent of the coefficients a[freedom]; Z: orthonormal basis of the null space of J */
#ifndef KM_LOCAL_TANGENT_CONE_H
#define KM_LOCAL_TANGENT_CONE_H

#include "local/second_order_conditions.h"

#include <stdint.h>

enum { KM_STARTS_PER_FREEDOM = 40 };
/* Largest freedom with a basis; single directions are followed without a basis beyond it (docs/theory.md 5.5). */
enum { KM_MAX_BASIS_FREEDOM = 12 };

/* Verdict on a followed tangent (docs/theory.md 5.3). */
typedef enum km_tangent_verdict {
  KM_TANGENT_REFUTED,   /* the loops do not close along it, or the misfit grows as a contact of finite order */
  KM_TANGENT_LOST,      /* rounded data, and the loops do not close even for a short length */
  KM_TANGENT_UNDECIDED, /* the loops close for a part of the length, and the misfit shows no order */
  KM_TANGENT_CONFIRMED
} km_tangent_verdict;

typedef struct km_tangents {
  const km_mechanism *m;
  km_state *s;
  int index;
  const km_substructure *sub;
  km_arena *arena;
  km_second_order conditions; /* Q is computed with the first random tangent */
  double residual;            /* residual of the worst loop at the configuration */
  double *origin, *last;      /* saved coordinates */
  double *end_ahead;          /* saved coordinates at the end of the last curve in the positive sense */
  double *chord;              /* [columns] scaled step from the origin to an early point of the last followed curve */
  double *secant;          /* [columns] unit direction between the early points ahead and back, of the last tangent */
  bool has_undecided;      /* some tangent was neither confirmed nor refuted */
  int undecided_dimension; /* dimension bound of motions along undecided tangents, by km_tangents_find_next */
  km_tangent_verdict min_verdict; /* verdict from which a tangent counts as finite; default KM_TANGENT_CONFIRMED */
  double *x, *move, *work;
  double *direction; /* [columns] tangent that is followed */
  double *a;         /* [freedom] coefficients of a tangent */
  double *previous;  /* [freedom] coefficients before the secant replaced them */
  double *length;    /* [freedom] length to which each column of Z was followed, ahead and back; -1: not yet */
  int starts;        /* number of starts of km_tangents_find_next */
  uint64_t random;
} km_tangents;

/* Creates the tangents at the state's configuration, which `origin` stores. Directions can then be followed. False when
 * out of memory. */
bool km_tangents_create(km_tangents *tangents, const km_mechanism *mechanism, km_state *state, int substructure,
                        km_arena *arena);
/* Creates the basis Z, directly after km_tangents_create, for all functions of coefficients. False when out of
 * memory. */
bool km_tangents_create_basis(km_tangents *tangents);
void km_tangents_normalise(double *a, int freedom);
/* Scaled unit direction D⁻¹Z a. */
void km_tangents_direction(const km_tangents *tangents, const double *a, double *x);

/* Makes v a unit vector orthogonal to the `count` orthonormal rows of basis[count × size]; false if nearly nothing
 * remains. */
bool km_orthonormalise(const double *basis, int count, int size, double *v);
/* Appends the part of a[freedom] that is orthogonal to the first `count` orthonormal rows of V[freedom × freedom] as a
 * further row; false if it is nearly 0. */
bool km_tangents_append_orthonormal(double *V, int count, int freedom, const double *a);
/* Completes the first `count` orthonormal rows of V to an orthonormal basis. False when out of memory. */
bool km_tangents_complete_basis(double *V, int count, int freedom);
/* Removes the span of the first `count` orthonormal rows of V[freedom × freedom] from the basis Z, whose remaining
 * vectors are orthogonal to it; the other rows of V receive their coefficients in the former basis. Before second-order
 * conditions are computed, or where none remain. False when out of memory. */
bool km_tangents_remove(km_tangents *tangents, double *V, int count);

typedef struct km_followed_tangent {
  double length; /* arc length to which the loops stay closed */
  km_tangent_verdict verdict;
} km_followed_tangent;

/* Follows a scaled direction from the configuration, ahead (sign 1) or back (−1), with the fastest coordinate fixed in
 * each closing, so that closing does not reduce the misfit by moving back. The state is left at the end. */
km_followed_tangent km_tangents_follow(km_tangents *tangents, const double *direction, double sign);
/* True for exact data: no closure tolerance is stated and the misfit of the configuration is rounding, so that any
 * later misfit is significant. */
bool km_tangents_are_exact(const km_tangents *tangents);
/* True if the state, at the end of a followed curve, has fewer tangents than the configuration. Then the
 * configuration's tangents are not all finite, since a smooth family has constant dimension. Closing can lead a
 * direction onto a neighbouring motion, and only this test shows it. The state stays there. O(one factorisation). */
bool km_tangents_have_dropped(km_tangents *tangents);
/* Follows a direction ahead and back. Returns the shorter length and the lower verdict; length 0 if the first sense
 * refutes it. `has_undecided` records undecided verdicts. */
km_followed_tangent km_tangents_follow_both_senses(km_tangents *tangents, const double *direction);
/* True if the last followed curve has the given direction by its secant, so that closing has not led to a neighbouring
 * motion with another tangent. A single tangent has no neighbour. */
bool km_tangents_secant_agrees(const km_tangents *tangents, const double *direction);
/* True if the tangent `a` is followed ahead and back with the required verdict and its own secant. */
bool km_tangents_is_finite(km_tangents *tangents, const double *a);
/* True if all basis vectors and random combinations of them are finite: one combination for exact data, else as many as
 * freedoms. */
bool km_tangents_all_finite(km_tangents *tangents);
/* True if all tangents are finite, by one random tangent of exact data (docs/theory.md 5.4): the primary equations
 * leave a manifold, on which the secondary errors are analytic. They vanish along a random curve only if they vanish
 * everywhere. */
bool km_tangents_are_regular(km_tangents *tangents);
/* Computes the second-order conditions at the first call; the state is then at the configuration. False when out of
 * memory. */
bool km_tangents_update_conditions(km_tangents *tangents);
/* True if some tangent satisfies the second-order conditions, as far as random starts show. */
bool km_tangents_satisfy_second_order(km_tangents *tangents);
/* Finds a random tangent that satisfies the second order and is finite, into `a`; false if the start leads to none.
 * After km_tangents_all_finite: the tangent of a single freedom is not followed again. */
bool km_tangents_find_random(km_tangents *tangents);
/* Finds the next finite tangent that differs from the `count` known[count × freedom], into `a`, and its followed
 * length; false if the remaining starts lead to none. The number of starts is 40 times the larger of the freedom and
 * the number of known tangents, since many known branches indicate further ones. */
bool km_tangents_find_next(km_tangents *tangents, const double *known, int count, double *length);

#endif
