/* What friction in the joints takes from a mechanical advantage. */
#ifndef KMECH_LOSSES_H
#define KMECH_LOSSES_H

#include "kmech/advantage.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The force that the output gives for one at the input, while the input moves the output against its load. */
typedef struct km_losses {
  double ratio;      /* −τ_out / f_in with friction; 0: it locks itself; NaN: undefined */
  double efficiency; /* over the mechanical advantage: 0 … 1 */
  bool locks;        /* no input force is enough … */
  double
      locks_from; /* … and where friction grows from nothing, none is from this share of it on; NaN: it doesn't lock */
  const char *why; /* why it is undefined; NULL: it isn't */
} km_losses;

/* The workspace of one thread. */
typedef struct km_losses_work km_losses_work;

/* Does any joint of the model have friction? */
KM_API bool km_model_has_friction(const km_model *model);

/* Prepares for a driving `input` and a driven `output`. KM_MEMORY, KM_USAGE. The caller frees `*out`. */
KM_API km_status km_losses_create(const km_mechanism *mechanism, const km_handle *input, const km_handle *output,
                                  km_losses_work **out, km_error *error);
KM_API void km_losses_free(km_losses_work *work);

/* At the state's pose, whose mobility is up to date. Coulomb friction (`friction`: coefficient μ, radius r): a turning
 * coordinate resists with μ r N, a sliding one with μ N, N the force of its reaction across its axis (of ball joints all of
 * it). A hinge's thrust along its axis resists at the same radius, as on a collar. A screw's thread of mean radius r resists
 * along its helix: F r tan(λ + φ) against the load, F r tan(λ − φ) with it, tan λ = pitch / (2π r), tan φ = μ. Weights, loads
 * and springs don't count. What is statically
 * indeterminate counts as its least-norm part. N depends on friction: Newton's method, continued from no friction to
 * all of it. A lock is told where the load that a given input force moves passes through 0 on the way; where neither a
 * motion nor a lock is found, `why` says so. KM_USAGE: mobility isn't up to date, or the work belongs to another mechanism; KM_MEMORY. */
KM_API km_status km_losses_update(const km_mechanism *mechanism, km_state *state, km_losses_work *work, km_losses *out);

#ifdef __cplusplus
}
#endif
#endif
