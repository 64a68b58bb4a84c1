/* Data and operations of the local analysis. Private to local/. */
#ifndef KM_LOCAL_LOCAL_PRIVATE_H
#define KM_LOCAL_LOCAL_PRIVATE_H

#include "base/number/tolerances.h"
#include "local/local.h"

#include <stdint.h>

enum {
  KM_STARTS_PER_FREEDOM = 40,
  KM_MAX_BASIS_FREEDOM = 12 /* freedoms up to which branches are enumerated: n folded loops have 2^n branches */
};

/* Tolerance of a condition over the size of Q. A condition that is a square converges slowly to its zero; below this
 * the direction is tried. */
static const double km_condition_tolerance = 1e-5;

/* Bounds of 1 − |cos| between tangents that can be one. A direction that misses a square by the tolerance lies
 * √tolerance from its zero, so two of one tangent are at most twice that apart, and 1 − cos is half the square of that.
 * A tangent and the secant of its curve differ more, since that is curved and closed to a tolerance. */
static const double km_tangent_tolerance = 2.0 * 1e-5, km_secant_tolerance = 1e-3;

/* Verdict on a followed tangent (docs/theory.md 5.3). */
typedef enum km_tangent_verdict {
  KM_TANGENT_REFUTED,   /* the loops do not close along it, or the misfit grows as a contact of finite order */
  KM_TANGENT_LOST,      /* rounded data, and the loops do not close even for a short length */
  KM_TANGENT_UNDECIDED, /* the loops close for a part of the length, and the misfit shows no order */
  KM_TANGENT_CONFIRMED
} km_tangent_verdict;

typedef struct km_followed_tangent {
  double length; /* arc length to which the loops stay closed */
  km_tangent_verdict verdict;
} km_followed_tangent;

typedef struct km_second_order_columns km_second_order_columns;

struct km_local {
  const km_mechanism *m;
  km_state *s;
  int index;
  const km_substructure *sub;
  const double *weight; /* [columns] D */
  km_arena *arena;
  const km_passive_freedoms *passive;
  int known_passive; /* known passive freedoms of the substructure */
  double *origin;    /* saved coordinates of the configuration */

  /* First order. */
  int freedom;             /* dimension of the space of tangents; without removed ones */
  int passive_count;       /* passive tangents that were removed from it */
  bool has_redundant_rows; /* some row of J depends on the others, so that tangents need not belong to motions */
  bool has_basis;          /* back end: basis Z, or columns */
  double tolerance;        /* rank tolerance */
  double residual;         /* residual of the worst loop */
  int size;                /* entries of a tangent's coefficients a: freedom, or columns */
  double *Z;               /* [freedom × columns] if has_basis */

  /* Second order. */
  bool has_conditions;              /* the conditions were computed, */
  bool lacks_conditions;            /* or could not be, without SPQR */
  int conditions;                   /* number of conditions */
  double noise;                     /* bound of entries of Q that the misfit of the configuration can cause */
  double scale;                     /* largest entry of Q */
  bool has_definite;                /* some Q_i is definite: no direction satisfies its condition */
  double *W;                        /* [conditions × rows] left null vectors, if has_basis */
  double *Q;                        /* [conditions × freedom × freedom] symmetric, if has_basis */
  double *value, *gradient;         /* c_i/scale; [conditions × freedom] its derivatives, of the last evaluation */
  km_second_order_columns *columns; /* conditions of the other back end */

  /* Following a tangent. */
  km_tangent_verdict min_verdict; /* verdict from which a tangent counts as finite; default KM_TANGENT_CONFIRMED */
  bool has_undecided;             /* some tangent was neither confirmed nor refuted */
  int undecided_dimension;        /* dimension bound of motions along undecided tangents, by km_local_find_next */
  double *last, *end_ahead;       /* saved coordinates: before a step, at the end of the last curve ahead */
  double *chord;                  /* [columns] step from the configuration to an early point of the last curve */
  double *secant; /* [columns] unit direction between the early points ahead and back, of the last tangent */
  double *move, *tangent;
  double *direction; /* [columns] tangent that is followed */

  /* Random search. */
  double *a, *previous, *work; /* [size] coefficients; [4 · freedom² + 8 · freedom], or [columns] */
  int starts;                  /* number of starts of km_local_find_next */
  uint64_t random;
};

/* ---- Tangents by coefficients (local.c). */

/* Prepares coefficients of tangents, with a basis or by columns. False when out of memory. */
bool km_local_reserve_tangents(km_local *local, bool with_basis);
/* Moves the state to the configuration, with J factored. */
void km_local_return(km_local *local);
/* Scaled direction x = D⁻¹ Z a. */
void km_local_direction(const km_local *local, const double *a, double *x);
/* Unit coefficients a = Zᵀ D x of a scaled step. Returns their length before, 0 if nothing remains. */
double km_local_coefficients(km_local *local, const double *x, double *a);
/* Random unit coefficients. */
bool km_local_draw(km_local *local, uint64_t *random, double *a);
/* Normalises coefficients; by columns it projects them onto the null space first. Returns their length before, 0 if
 * nothing remains. */
double km_local_normalise(km_local *local, double *a);
/* True if two unit vectors of coefficients are one tangent, in either sense: 1 − |cos| <= tolerance. */
bool km_local_is_same(const km_local *local, const double *a, const double *b, double tolerance);

/* Appends the part of a[size] that is orthogonal to the first `count` orthonormal rows of V[size × size] as a further
 * row; false if it is nearly 0. */
bool km_append_orthonormal(double *V, int count, int size, const double *a);
/* Completes the first `count` orthonormal rows of V[size × size] to an orthonormal basis. False when out of memory. */
bool km_complete_basis(double *V, int count, int size);
/* Restricts the tangents, and the conditions if they were computed, to the span of the orthonormal coefficients
 * V[count × freedom]. It needs a basis. False when out of memory. */
bool km_local_restrict(km_local *local, const double *V, int count);

/* ---- Second-order conditions (second_order.c). */

/* Computes the conditions at the first call. False when out of memory, or if SPQR is not installed. */
bool km_local_update_conditions(km_local *local);
/* True if the conditions exceed what the misfit of the configuration can cause. */
static inline bool km_local_is_significant(const km_local *l) {
  return l->conditions > 0 && !(l->scale < l->noise);
}
/* True if a dense analysis of second order is affordable: rows² · columns < 1e7. */
static inline bool km_local_is_small(const km_substructure *sub) {
  static const double most_work = 1e7;
  return (double)sub->rows * sub->rows * sub->columns < most_work;
}
/* True if the conditions refute the tangent, far beyond rounding. */
bool km_local_violates_second_order(km_local *local, const double *a);
/* Largest |c_i| of the conditions along a unit vector a, over their scale. The conditions must be significant. */
double km_local_violation(km_local *local, const double *a);
/* Finds a unit vector near `a` that satisfies all conditions, by damped Gauss-Newton; false if there is none. */
bool km_local_solve_second_order(km_local *local, double *a);
/* True if some tangent satisfies the conditions, as far as random starts show. */
bool km_local_satisfies_second_order(km_local *local);
/* Dimension bound of a motion along a tangent a that satisfies the conditions: freedom − rank { Q_i a }. Only entries
 * that are clearly above the tolerance count for the rank. */
int km_local_dimension_bound(km_local *local, const double *a);
/* Defect of the rank at the state, for deflation (docs/theory.md 5.6): defect[conditions × freedom] = w_iᵀ J z. It
 * needs a basis. */
bool km_local_rank_defect(km_local *local, double *defect);

/* ---- Following (follow.c). */

/* True for exact data: no closure tolerance is stated and the misfit of the configuration is rounding, so that any
 * later misfit is significant. */
bool km_local_is_exact(const km_local *local);
/* Follows a scaled direction from the configuration, ahead (sign 1) or back (−1), with the fastest coordinate fixed in
 * each closing, so that closing does not reduce the misfit by moving back. The state is left at the end. */
km_followed_tangent km_local_follow(km_local *local, const double *direction, double sign);
/* True if the state, at the end of a followed curve, has fewer tangents than the configuration. Then the
 * configuration's tangents are not all finite, since a smooth family has constant dimension. Closing can lead a
 * direction onto a neighbouring motion, and only this test shows it. The state stays there. O(one factorisation). */
bool km_local_has_dropped(km_local *local);
/* Follows a direction ahead and back. Returns the shorter length and the lower verdict; length 0 if the first sense
 * refutes it. `has_undecided` records undecided verdicts. */
km_followed_tangent km_local_follow_both_senses(km_local *local, const double *direction);
/* True if the last followed curve has the given direction by its secant, so that closing has not led to a neighbouring
 * motion with another tangent. A single tangent has no neighbour. */
bool km_local_secant_agrees(const km_local *local, const double *direction);
/* True if the chord of the last curve agrees with the direction; it has the curve's curvature. */
bool km_local_chord_agrees(const km_local *local, const double *direction);
/* True if the tangent `a` is followed ahead and back with the required verdict and its own secant. */
bool km_local_is_finite(km_local *local, const double *a);

/* ---- Tangent cone (tangent_cone.c). */

/* True if all tangents are finite motions (docs/theory.md 5.4). */
bool km_local_is_regular(km_local *local);
/* Finds the next finite tangent that differs from the `count` known[count × size], into `a`, and its followed length;
 * false if the remaining starts lead to none. */
bool km_local_find_next(km_local *local, const double *known, int count, double *length);

/* Removes passive freedoms that are finite from the tangents (docs/theory.md 6.6). They move independently of all
 * others, so a motion is finite with them if it is finite without them. It needs a basis. directions[freedom × columns]
 * (may be NULL) receives the removed tangents, scaled, of unit length. Returns their number. */
int km_local_remove_passive(km_local *local, const km_passive_freedoms *passive, double *directions);
/* Restricts the tangents to those of constant rank, if these are exactly the finite ones (docs/theory.md 5.6). It needs
 * a basis. Returns the number of removed tangents, with their directions[freedom × columns] (may be NULL); 0: the
 * configuration is not one of a permanently shaky mechanism, or memory is out; nothing changes then. */
int km_local_restrict_to_constant_rank(km_local *local, double *directions);

/* Halves of the motions through the configuration, each given by a closed configuration at a small distance
 * (docs/theory.md 5.7). */
enum { KM_MAX_HALF_BRANCHES = 32 };
typedef struct km_half_branches {
  int count;
  bool truncated;       /* there are more than KM_MAX_HALF_BRANCHES */
  bool is_isolated;     /* the starts cover the sphere, and the loops close on it nowhere */
  double length;        /* |D (q - q0)| of the configurations */
  double *saved;        /* [KM_MAX_HALF_BRANCHES × 3 · columns] saved */
  double *coefficients; /* [KM_MAX_HALF_BRANCHES × freedom] unit directions from q0 */
} km_half_branches;
/* Finds the half-branches from random starts around the tangent space: of branches that cross, that touch with one
 * tangent up to an order of contact of about 5, or that end in a cusp. It needs a basis and exact data. A motion that
 * no start leads to is missed. Restores the state. False when out of memory. O(starts · iterations · rows ·
 * columns²). */
bool km_half_branches_find(km_local *local, km_half_branches *out);

#endif
