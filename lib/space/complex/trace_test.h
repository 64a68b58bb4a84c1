/* All solutions over a generic value of the errors, with the trace test for completeness (docs/theory.md 4.16).
 *
 *   curve  : F(q) = p + s v;   sections of it: (s − s_0)(y(q) − c) = τ, N + M points
 *   trace  : Σ y and Σ s over all points of a section are linear in τ:  Σ(τ) − 2 Σ(τ + d) + Σ(τ + 2 d) = 0
 *   τ -> 0 : N of the points go to s = s_0, the solutions over p + s_0 v; M to y = c
 *
 * With f(s, y) = Σ f_ij s^i y^j of bidegree (M, N) and s = s_0 + τ / (y − c), the two highest coefficients of
 * (y − c)^M f are constant and linear in τ. The curve is irreducible, so that the sum over a part of the points isn't
 * linear. Source: A. Leykin, J. I. Rodriguez, F. Sottile, Trace test, Arnold Mathematical Journal 4, 2018. */
#ifndef KM_SPACE_COMPLEX_TRACE_TEST_H
#define KM_SPACE_COMPLEX_TRACE_TEST_H

#include "space/complex/monodromy.h"

/* Result of the search. Its arrays belong to `graph`. */
typedef struct km_fibre_search {
  km_homotopy homotopy, section; /* the system without and with a section */
  km_monodromy graph;            /* node 0 holds the solutions */
  int section_points;            /* N + M of the last trace test */
  double trace_difference;       /* relative second difference of the last trace test; NaN: none was made */
  bool is_exhausted;             /* the search ended at a limit of solutions or work */
  bool is_complete;              /* the trace test passed */
  int samples, found_once;       /* incomplete search: independent finds, and solutions found by one of them */
} km_fibre_search;

/* Finds the solutions over a generic value. `centre` is a closed configuration; the closure's
 * functional for the trace test is set. `limit`: largest number of points
 * that are tracked together. KM_CANCELLED; KM_MEMORY. Free `*out` in any case. */
km_status km_fibre_search_run(km_complex_closure *closure, const km_wide *centre, int limit, uint64_t *random,
                              km_arena *arena, km_progress progress, void *context, km_fibre_search *out,
                              km_error *error);
void km_fibre_search_free(km_fibre_search *search);

#endif
