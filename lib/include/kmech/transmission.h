/* How well a mechanism transmits: transmission wrench, indices, transmission angle, condition of the Jacobian. */
#ifndef KMECH_TRANSMISSION_H
#define KMECH_TRANSMISSION_H

#include "kmech/advantage.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A number, or why there is none at this pose. */
typedef struct km_metric {
  double value;    /* NaN where undefined */
  const char *why; /* NULL: defined */
} km_metric;

/* The metrics of one pose. */
typedef struct km_transmission {
  /* The wrench that reaches the output: reciprocal to all joints of the loop but input and output (thesis 8.1). Unit
   * force and its moment (a unit couple where there is no force) about the inertial origin, along its axes. */
  double wrench[6];
  const char *no_wrench;         /* NULL: it is defined */
  km_metric virtual_coefficient; /* ½ |w · s_o|; a length where a force drives a turning output */
  km_metric sutherland_roth; /* |w · s_o| over its largest value for a wrench through the output link's other joint, */
                             /* where that joint is a point of the link; 0 … 1 */
  km_metric chen_angeles;    /* the same with the wrench's own point nearest to that joint's axis */
  km_metric angle;           /* of planar four-bars: between coupler and output link, model's angle unit */
  km_metric manipulability;  /* ∏σ of J D⁻¹ of the substructure, rows over its size (Yoshikawa) */
  km_metric condition;       /* σ_max / σ_min of the same */
} km_transmission;

/* The workspace of one thread. */
typedef struct km_transmission_work km_transmission_work;
/* Prepares for a driving `input` and a driven `output`. The caller frees `*out`. KM_MEMORY. */
KM_API km_status km_transmission_create(const km_mechanism *mechanism, const km_handle *input, const km_handle *output,
                                        km_transmission_work **out, km_error *error);
KM_API void km_transmission_free(km_transmission_work *work);

/* At the state's pose, whose mobility is up to date. Never allocates. O(columns · rows²). */
KM_API void km_transmission_update(const km_mechanism *mechanism, km_state *state, km_transmission_work *work,
                                   km_transmission *out);

#ifdef __cplusplus
}
#endif
#endif
