/* Transfer of motion and force from an input to an output: mechanical advantage, friction losses, transmission
 * metrics. */
#ifndef KMECH_TRANSFER_H
#define KMECH_TRANSFER_H

#include "kmech/base.h"
#include "kmech/mobility.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Mechanical advantage: how fast an input moves for its output. */

/* An end of a mechanism that is pushed, or pushes: a joint, or a point of a body along a direction. */
typedef enum km_port_kind {
  KM_PORT_NONE,  /* no end */
  KM_PORT_JOINT, /* a joint's coordinate */
  KM_PORT_POINT  /* a point of a body along a direction */
} km_port_kind;

/* One such end. Start from {0}. */
typedef struct km_port {
  km_port_kind kind;   /* which members count */
  int coordinate;      /* of a joint */
  int frame;           /* the point: a frame's origin */
  double direction[3]; /* unit vector along the inertial axes */
  const char *name;    /* as columns call it: a joint's label, or body/frame:dx,dy,dz; borrowed */
} km_port;

/* What kind of number an advantage is. */
typedef enum km_advantage_state {
  KM_ADVANTAGE_FINITE,   /* both move */
  KM_ADVANTAGE_ZERO,     /* the input stands while the output moves */
  KM_ADVANTAGE_INFINITE, /* the output stands while the input moves */
  KM_ADVANTAGE_UNDEFINED /* both stand, or nothing moves */
} km_advantage_state;

/* Which motion an advantage is about. */
typedef enum km_advantage_method {
  KM_ADVANTAGE_SINGLE_FREEDOM, /* the one motion there is: Z_i / Z_k (287) */
  KM_ADVANTAGE_LEAST_MOTION    /* of several freedoms, the motion of least length that moves the input: Z Zᵀ */
} km_advantage_method;

/* The advantage at one pose. */
typedef struct km_advantage {
  km_advantage_state state;   /* says what `value` can be */
  km_advantage_method method; /* of which motion it is */
  double value;               /* q̇_in / q̇_out, angles in radians, the model's length; infinity or NaN by state */
  double velocity_ratio;      /* q̇_out / q̇_in */
  double input_rate, output_rate; /* in that motion, whose largest scaled rate is 1; 0 where they count as 0 */
} km_advantage;

/* An end of the model's own analysis.mechanical_advantage, its `output` or its input: false where it has none. */
KM_API bool km_port_default(const km_model *model, bool output, km_port *out);

/* An input and an output, with the workspace of one thread. */
typedef struct km_transfer km_transfer;

/* Prepares for a driving `input` and a driven `output`. KM_USAGE: an end that is held or can't move, both the same, or
 * of parts that don't move each other. The caller frees `*out`. */
KM_API km_status km_transfer_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                    km_transfer **out, km_error *error);
KM_API void km_transfer_free(km_transfer *lever);

/* At the state's pose, whose mobility is up to date. One freedom: MA = q̇_i / q̇_k = (D_k/D_i) Z_i / Z_k; more: MA =
 * (D_k/D_i) m_i / (Z_k Z_iᵀ), the substructures that the input lies in moving, the others standing (theory 5; of
 * points: rows of the point's Jacobian). Rates below 3e-8 of the largest, each over its substructure's size, count as
 * 0. KM_USAGE: a pointer is missing, or the mobility isn't known; KM_MEMORY: the mobility is to be found again. `*out`
 * is undefined then. O(coordinates · freedoms). */
KM_API km_status km_transfer_compute(const km_mechanism *mechanism, km_state *state, km_transfer *lever,
                                     km_advantage *out);
/* Where several motions meet at the state's configuration (a branch point), the advantages in each of them. Returns
 * their number, at most `most`; 0 at a regular configuration, -1 when out of memory. The state keeps its
 * configuration. */
KM_API int km_transfer_branches(const km_mechanism *mechanism, km_state *state, km_transfer *lever, km_advantage *out,
                                int most);
/* The motion that the last update was about: rates[coordinate], radians and model's length, largest scaled one 1.
 * Borrowed. */
KM_API const double *km_transfer_rates(const km_transfer *lever);

/* "rad/mm" of input over output; "" where both are of one kind. Borrowed. */
KM_API const char *km_advantage_unit(const km_model *model, const km_port *input, const km_port *output);
/* "finite", "zero", "infinite", "undefined"; "single freedom", "least motion". */
KM_API const char *km_advantage_state_name(km_advantage_state state);
KM_API const char *km_advantage_method_name(km_advantage_method method);

/* ---- What friction in the joints takes from a mechanical advantage. */

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
typedef struct km_losses_workspace km_losses_workspace;

/* Does any joint of the model have friction? */
KM_API bool km_model_has_friction(const km_model *model);

/* Prepares for a driving `input` and a driven `output`. KM_MEMORY, KM_USAGE. The caller frees `*out`. */
KM_API km_status km_losses_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                  km_losses_workspace **out, km_error *error);
KM_API void km_losses_free(km_losses_workspace *work);

/* At the state's pose, whose mobility is up to date. Coulomb friction (`friction`: coefficient μ, radius r): a turning
 * coordinate resists with μ r N, a sliding one with μ N, N the force of its reaction across its axis (of ball joints all of
 * it). A hinge's thrust along its axis resists at the same radius, as on a collar. A screw's thread of mean radius r resists
 * along its helix: F r tan(λ + φ) against the load, F r tan(λ − φ) with it, tan λ = pitch / (2π r), tan φ = μ. Weights, loads
 * and springs don't count. What is statically
 * indeterminate counts as its least-norm part. N depends on friction: Newton's method, continued from no friction to
 * all of it. A lock is told where the load that a given input force moves passes through 0 on the way; where neither a
 * motion nor a lock is found, `why` says so. KM_USAGE: mobility isn't up to date, or the work belongs to another mechanism; KM_MEMORY. */
KM_API km_status km_losses_compute(const km_mechanism *mechanism, km_state *state, km_losses_workspace *work,
                                   km_losses *out);

/* ---- How well a mechanism transmits: transmission wrench, indices, transmission angle, condition of the Jacobian. */

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
typedef struct km_transmission_workspace km_transmission_workspace;
/* Prepares for a driving `input` and a driven `output`. The caller frees `*out`. KM_MEMORY. */
KM_API km_status km_transmission_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                        km_transmission_workspace **out, km_error *error);
KM_API void km_transmission_free(km_transmission_workspace *work);

/* At the state's pose, whose mobility is up to date. Never allocates. O(columns · rows²). */
KM_API void km_transmission_compute(const km_mechanism *mechanism, km_state *state, km_transmission_workspace *work,
                                    km_transmission *out);

#ifdef __cplusplus
}
#endif
#endif
