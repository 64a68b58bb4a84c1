/* Small motions about a pose: rest poses, linearised equations of motion, natural modes. */
#ifndef KMECH_LINEAR_H
#define KMECH_LINEAR_H

#include "kmech/dynamics.h"
#include "kmech/progress.h"
#include "kmech/table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ẋ = A x + B f at the state's pose, with its rates, which are made to keep the loops as a run's are: x the deviations of `freedom` independent coordinates, then those
 * of their rates; f the forces in all coordinates, along +q. In radians and the model's length, force and time units.
 * Arrays are column-major. */
typedef struct km_linear {
  int freedom, coordinate_count; /* independent coordinates; all coordinates */
  int *independent;              /* [freedom] coordinates */
  double *A;                     /* [2 freedom × 2 freedom] */
  double *B;                     /* [2 freedom × coordinates] */
  double *N;                     /* [coordinates × freedom] how all coordinates follow the independent ones */
  /* [2 freedom] eigenvalues of A, per time unit, by size; of a pair the one with the positive imaginary part first, of
   * equally large ones what grows. */
  double *real, *imaginary;
  double *modes;   /* [coordinates × 2 freedom × 2] the coordinates' parts of the eigenvectors: real, imaginary; the
                        * largest scaled entry has length 1 */
  double residual; /* largest acceleration of an independent coordinate at the pose, scaled, over s²: 0 at rest */
  double *doubt;   /* [2 freedom] per time unit: up to this size an eigenvalue may be 0, by the differences' errors */
  double noise;    /* per time unit: what the errors of differences of such accelerations make of an eigenvalue 0 */
} km_linear;

/* Differences of ±1e-5 (radians, characteristic lengths, and these per second) of the accelerations, which err by about
 * 1e-9 of their size and by what differences of ±2e-5 tell; eigenvalues by LAPACK's dgeev. The state's pose stays, and so do its rates but for
 * km_dynamics_project_rates. Prescribed coordinates follow
 * their laws at the state's time. Where nothing moves friction is left out: it holds whatever it can, and has no slope. KM_MODEL, KM_DIVERGED: as km_dynamics_accelerate; KM_IO: LAPACKE isn't installed;
 * KM_MEMORY. Free `*out` in any case. O(freedom · evaluation + freedom³). */
KM_API km_status km_linearise(km_dynamics *dynamics, km_state *state, km_linear *out, km_error *error);
KM_API void km_linear_free(km_linear *linear);

/* What happens to a deviation in a mode. */
typedef enum km_linear_kind {
  KM_LINEAR_STILL,  /* the eigenvalue is 0 but for the differences: it stays */
  KM_LINEAR_SWINGS, /* the eigenvalue is complex, one of a pair */
  KM_LINEAR_DIES,   /* real and negative */
  KM_LINEAR_GROWS   /* real and positive */
} km_linear_kind;
/* KM_LINEAR_STILL without such an eigenvalue. O(freedom). */
KM_API km_linear_kind km_linear_kind_of(const km_linear *linear, int eigenvalue);

/* The motion q = q0 + a (Re v cos φ − Im v sin φ) of an eigenvector v, as a table to draw (km_drawing_add_rows): `rows`
 * rows, first the column `phase` (0 to 360 deg) or, where the eigenvalue is real, `t` (over four time constants, a
 * factor e^λt for the cosine), then q. of every coordinate. The loops are closed on the independent coordinates; the
 * amplitude a is 0.25 radians or characteristic lengths, halved until loops close and bend the motion by less than half
 * of it. It tells the shape alone: neither the decay of a swing nor its size. The state is at the pose that was
 * linearised and comes back to it. The caller frees `*out`. KM_USAGE: no such eigenvalue, fewer than 2 rows; KM_DIVERGED:
 * the loops close along the mode with no amplitude; KM_MODEL, KM_MEMORY. O(rows · closing the loops). */
KM_API km_status km_linear_motion(km_dynamics *dynamics, km_state *state, const km_linear *linear, int eigenvalue,
                                  int rows, km_table **out, km_error *error);

/* How a rest pose answers a small push. */
typedef enum km_stability {
  KM_STABLE,      /* it swings about the pose, or comes back */
  KM_UNSTABLE,    /* it leaves the pose */
  KM_INDIFFERENT, /* a motion changes nothing to first order */
  KM_NOT_AT_REST /* the pose is none of rest or steady motion: what a push does to what happens there anyway isn't asked */
} km_stability;
KM_API const char *km_stability_name(km_stability stability); /* "stable" … */
/* By the real parts of the eigenvalues and their doubts, where nothing accelerates by more than 1e-6 (km_linear.residual). */
KM_API km_stability km_linear_stability(const km_linear *linear);

/* Moves the state to a pose where nothing accelerates: Newton's method on the accelerations of the independent
 * coordinates, at rest, with steps of at most 0.2 radians or characteristic lengths, longer ones where forces are
 * linear; `settle`: first lets it fall slowly, by a step of Euler's implicit method after the other, until hardly anything
 * accelerates, and again from a rest pose that isn't stable. KM_NO_RESULT: no rest pose was found from here; KM_MODEL; KM_IO:
 * LAPACKE isn't installed. Rates are 0 afterwards. O(steps · (freedom · evaluation + freedom³)). */
KM_API km_status km_equilibrium_find(km_dynamics *dynamics, km_state *state, bool settle, km_progress progress,
                                     void *context, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
