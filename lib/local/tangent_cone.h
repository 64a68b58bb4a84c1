/* The tangents of a substructure at one pose, and which of them are real: those that a motion follows. Private to
 * kinematics/ and analysis/. */
#ifndef KM_LOCAL_TANGENT_CONE_H
#define KM_LOCAL_TANGENT_CONE_H

#include "local/second_order_conditions.h"

#include <stdint.h>

enum { KM_STARTS_PER_FREEDOM = 40 };
/* More freedoms are tried by single directions, and followed without a basis. */
enum { KM_MAX_BASIS_FREEDOM = 12 };

/* Does a motion follow the tangent? */
typedef enum km_tangent_verdict {
  KM_TANGENT_REFUTED, /* the loops can't be closed along it, or open as a power of the way: a contact of finite order */
  KM_TANGENT_LOST,    /* they can't be closed even a short way, but don't fit at the pose itself either: rounded data */
  KM_TANGENT_UNDECIDED, /* they close for a part of the way, and what stops them shows no power */
  KM_TANGENT_CONFIRMED
} km_tangent_verdict;

typedef struct km_tangents {
  const km_mechanism *m;
  km_state *s;
  int index;
  const km_substructure *sub;
  km_arena *arena;
  km_second_order conditions; /* Q is built when a random tangent is first asked for */
  double residual;            /* of the pose's worst loop */
  double *origin, *last;      /* saved coordinates */
  double *end_ahead;          /* those at the end of the way ahead of the tangent tried last */
  double *chord;           /* [columns] of the way that was followed last: the scaled step to a place near its begin */
  double *secant;          /* [columns] of the tangent that was tried last: unit direction between such places */
  bool has_undecided;      /* some tangent was neither confirmed nor refuted */
  int undecided_dimension; /* by km_tangents_find_next: the most that a motion along such a one can have */
  km_tangent_verdict min_verdict; /* to count as real; KM_TANGENT_CONFIRMED */
  double *x, *move, *work;
  double *direction; /* of the tangent that is tried */
  double *a;         /* [freedom] a tangent by its share of each column of Z */
  double *previous;  /* [freedom] by km_tangents_find_next, before what was followed took its place */
  double *length;    /* [freedom] how far each column of Z was followed, ahead and back; -1: not yet */
  int starts;        /* by km_tangents_find_next */
  uint64_t random;
} km_tangents;

/* At the state's pose, which `pose` keeps. Directions can be followed and tried. False when out of memory. */
bool km_tangents_create(km_tangents *tangents, const km_mechanism *mechanism, km_state *state, int substructure,
                        km_arena *arena);
/* A basis of the null space, right after that, for all that is said by shares of it. False when out of memory. */
bool km_tangents_create_basis(km_tangents *tangents);
void km_tangents_normalise(double *a, int freedom);
/* Scaled unit direction D⁻¹Z a. */
void km_tangents_direction(const km_tangents *tangents, const double *a, double *x);

/* A unit vector at right angles to the `count` rows of basis[count × size], from v: false if nothing is left of it. */
bool km_orthonormalise(const double *basis, int count, int size, double *v);
/* Adds what of the shares a[freedom] lies outside the first `count` rows of V[freedom × freedom], which are orthonormal, as one more of
 * them; false where that is next to nothing. */
bool km_tangents_append_orthonormal(double *V, int count, int freedom, const double *a);
/* Fills the rows behind the first `count` with others at right angles to them. False when out of memory. */
bool km_tangents_complete_basis(double *V, int count, int freedom);
/* Takes the first `count` rows of V[freedom × freedom] out, orthonormal shares of the basis: what is left stands at right angles to them.
 * Fills the other rows of V with its shares of the basis that was. Before conditions of second order are asked for, or where none is
 * left. False when out of memory. */
bool km_tangents_remove(km_tangents *tangents, double *V, int count);

typedef struct km_followed_tangent {
  double length; /* arc length to which the loops were closed */
  km_tangent_verdict verdict;
} km_followed_tangent;

/* Follows a direction (scaled) from the pose, `sign` ahead or back, with the fastest
 * coordinate as the driver: what is left of the loops' errors is then theirs, and not moved away. The state is left at
 * the end. See trial.c. */
km_followed_tangent km_tangents_follow(km_tangents *tangents, const double *direction, double sign);
/* Do the loops fit at the pose to rounding, so that a misfit further on means something however small it is? */
bool km_tangents_are_exact(const km_tangents *tangents);
/* Has the state's place, to which a way has led, fewer tangents than the pose? Then the pose's aren't all real: those of a
 * smooth family have its dimension everywhere. A direction near a motion's is led onto that motion by closing the loops, and
 * only this shows it. The state stays there. O(one factorisation). */
bool km_tangents_have_dropped(km_tangents *tangents);
/* The shorter of the ways ahead and back; 0 where the first of the two shows that the direction isn't real. `doubtful`
 * remembers answers that are undecided. */
km_followed_tangent km_tangents_follow_both_senses(km_tangents *tangents, const double *direction);
/* Has the direction that was tried last been followed, and not a motion beside it, onto which closing the loops has led? On such a
 * motion there can be as many tangents as at the pose, of which no more are real. A single tangent has none beside it. */
bool km_tangents_secant_agrees(const km_tangents *tangents, const double *direction);
/* Can it be followed ahead and back? */
bool km_tangents_is_finite(km_tangents *tangents, const double *a);
/* Are the basis vectors real, and a random combination of them, or, of data that aren't exact, as many combinations? */
bool km_tangents_all_finite(km_tangents *tangents);
/* Are all tangents real, by a single one? True is certain, of exact data: the primary equations leave a manifold, on which the
 * errors of the others are analytic. They are 0 along a random way on it only where they are 0 everywhere. */
bool km_tangents_are_regular(km_tangents *tangents);
/* The conditions of second order, found when they are first asked for; the state is then at the pose. False when out of memory. */
bool km_tangents_update_conditions(km_tangents *tangents);
/* True if some tangent meets the conditions of second order, as far as random starts show. */
bool km_tangents_satisfy_second_order(km_tangents *tangents);
/* A random tangent that meets the second order and is real, into `a`; false if the start leads to none. To be asked for
 * after km_tangents_all_finite: the tangent of a single freedom isn't tried again. */
bool km_tangents_find_random(km_tangents *tangents);
/* The next one that is none of the `count` known[count × freedom], into `a`, and how far it was followed, ahead and back; false:
 * the starts that are left lead to none. There are as many for each that is known as for each freedom: who meets many branches
 * has missed some. */
bool km_tangents_find_next(km_tangents *tangents, const double *known, int count, double *length);

#endif
