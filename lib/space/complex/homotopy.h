/* Tracking of solutions along straight paths of parameters (docs/theory.md 4.15).
 *
 *   F(q) = p + s v,  rotations of the errors: P + s V          (v, V): fixed direction; without a section s = 0
 *   (s − s_0)(y(q) − c) = τ                                    the section, with the unknown s
 *   H(x) = 0,  parameters (p, P, s_0, c, τ) on a straight path,   ẋ = −H_x⁻¹ ∂H/∂t
 *
 *   predictor: cubic Hermite extrapolation from the last two points, error O(h⁴);   corrector: Newton's method
 *   step size: h <- h (TARGET / |first correction|)^(1/4) */
#ifndef KM_SPACE_COMPLEX_HOMOTOPY_H
#define KM_SPACE_COMPLEX_HOMOTOPY_H

#include "space/complex/complex_closure.h"

typedef struct km_homotopy {
  const km_complex_closure *closure;
  bool has_section;
  int size;               /* unknowns: n, with a section n + 1 */
  int length;             /* numbers of a point: those of the configuration, with a section also s */
  int parameter_count;    /* p[n], P[4 · loops], with a section also s_0, c, τ */
  int section_start;      /* index of s_0 */
  km_complex *direction;  /* [n + 4 · loops] v and V; V = 0 if there are errors of positions */
  double functional_size; /* size of y, for the section's c and τ; 1 by default */
  double step_factor;     /* scales the corrections that a step may have; 1 by default, less to track again */
  bool is_narrow;         /* chains have doubles: within a path on a first try, not in its last step */
  double reached;         /* parameter t of the last path where it ended; 1: at its end */
  long evaluations;       /* number of factorisations */
  km_complex *turn;       /* [4 · loops] workspace: P + s V */
  km_complex *J, *F, *parameter, *slope, *rates, *step, *rhs; /* workspace */
  km_wide *point[3];                                          /* workspace of the predictor: points, */
  km_complex *rate[2];                                        /* and their rates */
  int *row;
} km_homotopy;

typedef enum km_path_outcome {
  KM_PATH_ARRIVED,  /* the point is a solution at the end of the path */
  KM_PATH_SINGULAR, /* steps became too short or too many, or the end is no solution: the point is the last one */
  KM_PATH_INFINITE  /* an angle's imaginary part or a length grew without bound */
} km_path_outcome;

/* Allocates a homotopy. False when out of memory. */
bool km_homotopy_create(const km_complex_closure *closure, bool has_section, uint64_t *random, km_arena *arena,
                        km_homotopy *out);
/* Draws another direction (v, V). */
void km_homotopy_redirect(km_homotopy *h, uint64_t *random);
/* Draws random parameters. */
void km_homotopy_draw(const km_homotopy *h, uint64_t *random, km_complex *parameters);
/* Chooses a random solution x beside the configuration `centre`, and the errors that it has; no section. */
void km_homotopy_begin(const km_homotopy *h, const km_wide *centre, uint64_t *random, km_wide *x,
                       km_complex *parameters);
/* Parameters of the closed loops: p = 0, P = 1. No section. */
void km_homotopy_close(const km_homotopy *h, km_complex *parameters);
/* Tracks the solution x from the parameters `from` to `to`. */
km_path_outcome km_homotopy_track(km_homotopy *h, const km_complex *from, const km_complex *to, km_wide *x);

#endif
