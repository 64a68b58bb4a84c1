/* Real solutions of the closed loops: the ends of the paths from a generic error to none (docs/theory.md 4.17).
 *
 *   p -> 0, P -> 1 along straight paths, which have no singular point before their end (p is generic)
 *   real: the imaginary parts of the bodies' poses are rounding; then Newton's method over the real numbers */
#ifndef KM_SPACE_COMPLEX_REAL_ENDPOINTS_H
#define KM_SPACE_COMPLEX_REAL_ENDPOINTS_H

#include "kinematics/modes/mode_normalisation.h"
#include "space/complex/trace_test.h"

typedef struct km_real_endpoints {
  int count;
  double **items; /* [count] coordinates [3 · columns], by km_state_save */
  size_t capacity;
  int infinite, singular, lost; /* solutions that went to infinity; to singular solutions; that have no end */
} km_real_endpoints;

/* Follows all solutions of the search to the closed loops. `work` holds a state with the locked coordinates, which is
 * changed. KM_CANCELLED, KM_MEMORY. The caller frees `out->items`; the configurations are in the arena. */
km_status km_real_endpoints_find(km_fibre_search *search, const km_complex_closure *closure, km_mode_workspace *work,
                                 km_arena *arena, km_real_endpoints *out, km_error *error);

#endif
