/* Closure errors of one substructure over the complex numbers (docs/theory.md 4.15).
 *
 *   F(q) = p,  E_R = G,   q complex: angles and lengths x, quaternions Q of ball joints with Q·Q = 1            [n × n]
 *   planar loops : isotropic coordinates Z = x + iy, W = x − iy, U = exp(iφ), V = 1/U
 *                  F = ((F_Z + F_W)/2, (F_Z − F_W)/(2i), (A/G − 1)/i),   A = U_a V_b exp(i φ_0)
 *   spatial loops: F = (E(o) − o; 2 tan(θ/2) axis),   E = X_a X_b⁻¹, E_R Gᵀ a rotation by θ; o the loop's point
 *
 * Q turns the hub of a ball joint (complex_chain.c), the body behind it where most chains meet; the rates of a ball's
 * unknowns are the angular velocity of its own body.
 *
 * A closed loop has F = 0 with G = 1. Positions have errors p; rotations have an error G, the quaternion P, since sums
 * of quaternions near the real ones have no pole.
 *
 * A ball joint that closes a loop, and a hinge that closes a planar one, take any rotation error, so they and the
 * loop's rotations are left out. Rows are independent at the reference configuration, columns at a generic one. F is
 * rational in exp(iq), lengths and quaternions, so almost all values p have the same number of solutions. Source of
 * isotropic coordinates: C. W. Wampler, Solving the kinematics of planar mechanisms, ASME J. Mechanical Design 121,
 * 1999. */
#ifndef KM_SPACE_COMPLEX_COMPLEX_CLOSURE_H
#define KM_SPACE_COMPLEX_COMPLEX_CLOSURE_H

#include "base/random.h"
#include "kinematics/state.h"

#include <complex.h>
#include <stdint.h>
#include <string.h>

typedef double complex km_complex;

/* re + i im. CMPLX of C11 is missing in some headers, and `I` is a float. */
static inline km_complex km_complex_of(double re, double im) {
  const double parts[2] = {re, im};
  km_complex z;
  memcpy(&z, parts, sizeof z);
  return z;
}
#define KM_I km_complex_of(0.0, 1.0) /* the imaginary unit as a double: C's own is a float */

/* Numbers of configurations, and of the chains of spatial loops at the end of a path: rotations have parts of 1e4
 * beside a pole, whose products cancel. */
typedef long double complex km_wide;

/* re + i im, as km_complex_of. */
static inline km_wide km_wide_of(long double re, long double im) {
  const long double parts[2] = {re, im};
  km_wide z;
  memcpy(&z, parts, sizeof z);
  return z;
}

/* Random functions y_k of the bodies' poses: the first two are the fingerprint of a solution, the third one is that of
 * the trace test. */
enum { KM_FINGERPRINT = 2, KM_TRACE = 2, KM_FUNCTIONALS = 3 };

/* Complex pose of a slot of a spatial program: columns of the rotation, origin. */
typedef struct km_complex_pose {
  km_complex R[3][3], p[3];
} km_complex_pose;

typedef struct km_wide_pose {
  km_wide R[3][3], p[3];
} km_wide_pose;

/* Displacement E of a spatial loop: its rotation (columns), image of o, Gibbs vector g, o on side b, and the errors. A
 * loop that a joint closes uses only the ends of its two sides, `image` and `o`, and the errors of positions. */
typedef struct km_loop_displacement {
  km_complex R[3][3], image[3], g[3], o[3], errors[6];
} km_loop_displacement;

/* Slot of a planar program in isotropic coordinates. */
typedef struct km_isotropic_pose {
  km_complex U, V, Z, W;
} km_isotropic_pose;

/* Random number in the square |Re|, |Im| <= 1. */
static inline km_complex km_complex_random(uint64_t *random) {
  double re = km_uniform(random);
  return km_complex_of(re, km_uniform(random));
}

/* Coefficients of one slot in a functional. Spatial: y = Σ p·p_slot + Σ_k R_k·R_slot,k. Planar: y = p · (U, Z, W). */
typedef struct km_slot_weight {
  km_complex p[3], R[3][3];
} km_slot_weight;

/* A ball joint and its hub: the ball's quaternion is the rotation from the frame before the ball to the hub. */
typedef struct km_complex_hub {
  const km_step *ball;   /* NULL: no ball */
  int count;             /* steps from the ball to the hub; 0: the hub is the ball's own body */
  const km_step **steps; /* [count] */
} km_complex_hub;

/* The square system of one substructure. One thread at a time: functions write its workspace. The coefficients of the
 * trace's functional are chosen later (km_complex_choose_trace). */
typedef struct km_complex_closure {
  const km_mechanism *m;
  const km_substructure *sub;
  int size;          /* n: unknowns and equations */
  int passive;       /* coordinates that are fixed although they are not locked, since they move passive bodies only */
  int length;        /* numbers of a configuration */
  int *start_of;     /* [columns] index of a column's number, or of its quaternion, in a configuration */
  int *unknown_of;   /* [columns] unknown; −1: fixed */
  int *equation_of;  /* [rows] equation; −1: left out */
  int *column_of;    /* [n] column of an unknown */
  int *turn_of;      /* [n] index of a rotation's component in `turn`; −1: a position */
  bool *has_turn;    /* [4 · loops] components of P that loops have */
  int *closing_step; /* [loops] step of a ball joint or planar hinge that closes the loop; −1: none */
  km_complex_hub *hub;                    /* [columns], at the first column of a ball */
  bool *is_hub;                           /* [the mechanism's steps] steps that end at a hub, which its ball places */
  km_slot_weight *weight[KM_FUNCTIONALS]; /* [steps of all programs + 2 · loops]: slots, then the ends of the loops'
                                           * sides, whose positions count; zero: they don't */
  int end_start;                          /* first weight of an end: side k of loop l has end_start + 2 l + k */
  km_complex_pose *slot;                  /* workspace of spatial programs */
  km_wide_pose *wide_slot;                /* workspace of spatial programs */
  km_loop_displacement *displacement;     /* workspace of spatial programs, by loop */
  km_isotropic_pose *isotropic;           /* workspace of planar programs */
  km_complex (*twist)[6];                 /* workspace: unit twists (v; ω) of a program's steps, three per step */
  km_complex (*wrench)[6];                /* workspace of gradients, by slot */
  km_complex *rate, *step;                /* [length], [columns] workspace */
} km_complex_closure;

/* One evaluation: F[n], J[n × n] by rows of `stride` numbers, and a functional with its gradient[n]. Pointers may be
 * NULL. */
typedef struct km_complex_values {
  const km_complex
      *turn; /* [4 · loops] quaternions P of the rotations G that the loops' errors shall have; NULL: none */
  km_complex *F, *J;
  int stride;
  int functional; /* index of the functional */
  bool is_narrow; /* chains of spatial loops have doubles: steps within a path need no more; false: long doubles */
  km_complex value, *gradient;
} km_complex_values;

/* Compiles the system of a substructure at a closed configuration of the state. Coordinates that are locked in the
 * state, and passive ones, are fixed. KM_USAGE: it has screws or couplings, or bodies can move; then `*freedom` is the
 * number of their freedoms. KM_MEMORY. */
km_status km_complex_closure_create(const km_mechanism *mechanism, km_state *state, int substructure, uint64_t *random,
                                    km_arena *arena, km_complex_closure *out, int *freedom, km_error *error);

/* True if all rows of all loops are equations, or are solved by a joint that closes the loop. */
bool km_complex_has_all_rows(const km_complex_closure *c);

/* Copies the state's coordinates to a configuration x[length]. */
void km_complex_from_state(const km_complex_closure *c, const km_state *state, km_wide *x);
/* Copies the real part of a configuration to a state. Joints that close loops take the rotation that closes them, in x
 * too. */
void km_complex_to_state(const km_complex_closure *c, km_wide *x, km_state *state);
/* Writes a random complex configuration beside `centre`, which may be x: x <- exp(δ) centre with |δ_i| <= distance. */
void km_complex_randomise(const km_complex_closure *c, const km_wide *centre, double distance, uint64_t *random,
                          km_wide *x);

/* Evaluates F, J and a functional at a configuration. O(steps + entries of J). */
void km_complex_evaluate(const km_complex_closure *c, const km_wide *x, km_complex_values *out);
/* Computes the fingerprint y[KM_FINGERPRINT]: two configurations with the same values have the same bodies' poses. */
void km_complex_fingerprint(const km_complex_closure *c, const km_wide *x, km_complex *y);
/* Size of the parts of the bodies' poses that count: largest part, and largest imaginary part. */
typedef struct km_complex_extent {
  double largest, imaginary;
} km_complex_extent;
km_complex_extent km_complex_pose_extent(const km_complex_closure *c, const km_wide *x);
/* True if two configurations have the same fingerprint, the poses of the bodies, to a relative tolerance. */
bool km_complex_is_same_mode(const km_complex_closure *c, const km_wide *x, const km_wide *other, double tolerance);
/* Value of the trace's functional. */
km_complex km_complex_trace(const km_complex_closure *c, const km_wide *x);
/* Draws random coefficients of the trace's functional for all slots and ends. */
void km_complex_redraw_trace(km_complex_closure *c, uint64_t *random);
/* Chooses the trace's functional: a random function of the first slot whose position differs in all `count`
 * configurations, else of the first one whose pose does, else of all slots. The fewer it takes, the fewer points has a
 * section of a curve. */
void km_complex_choose_trace(km_complex_closure *c, const km_wide *points, int count, uint64_t *random);

/* Adds a step[n] to a configuration: x <- exp(step) x. Returns its size: the largest |change| of a hinge or slide, and
 * of a ball joint 2 |Q̇|/|Q|, the angle of its hub where Q is real. Angular velocities grow with |Q|² beside a pole,
 * where Q hardly changes. */
double km_complex_move(const km_complex_closure *c, const km_complex *step, km_wide *x);
/* Computes the rate of the configuration's numbers, out[length], at the rates[n] of the unknowns. */
void km_complex_rate(const km_complex_closure *c, const km_wide *x, const km_complex *rates, km_complex *out);
/* Normalises the quaternions, Q <- Q / sqrt(Q·Q). */
void km_complex_normalise(const km_complex_closure *c, km_wide *x);

#endif
