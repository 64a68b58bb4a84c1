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

/* ---- Mechanical advantage (theory 8.1): rate of the input over rate of the output. */

/* Kind of a port: an end of a mechanism by which it is driven or loaded. */
typedef enum km_port_kind {
  KM_PORT_NONE,  /* none */
  KM_PORT_JOINT, /* a joint's coordinate */
  KM_PORT_POINT  /* a point of a body along a direction */
} km_port_kind;

/* A port. Start from {0}. */
typedef struct km_port {
  km_port_kind kind;   /* selects the members below */
  int coordinate;      /* joint: its coordinate */
  int frame;           /* point: frame whose origin it is */
  double direction[3]; /* point: unit vector along the inertial axes */
  const char *name;    /* name in columns: a joint's label, or body/frame:dx,dy,dz; borrowed */
} km_port;

/* Kinds of advantage values (theory 8.2). */
typedef enum km_advantage_state {
  KM_ADVANTAGE_FINITE,   /* input and output move */
  KM_ADVANTAGE_ZERO,     /* the input is at rest */
  KM_ADVANTAGE_INFINITE, /* the output is at rest */
  KM_ADVANTAGE_UNDEFINED /* both are at rest, or nothing moves */
} km_advantage_state;

/* Motion of an advantage. */
typedef enum km_advantage_method {
  KM_ADVANTAGE_SINGLE_FREEDOM, /* the single motion: Z_i / Z_k */
  KM_ADVANTAGE_LEAST_MOTION    /* several freedoms: the shortest motion that moves the input, Z Z_iᵀ */
} km_advantage_method;

/* The advantage at one configuration. */
typedef struct km_advantage {
  km_advantage_state state;       /* kind of `value` */
  km_advantage_method method;     /* motion of the ratio */
  double value;                   /* q̇_in / q̇_out, radians and the model's length; infinity or NaN by state */
  double velocity_ratio;          /* q̇_out / q̇_in */
  double input_rate, output_rate; /* rates in that motion, whose largest scaled rate is 1; 0 if they count as 0 */
} km_advantage;

/* Returns a port of the model's analysis.mechanical_advantage, its `output` or its input; false without one. */
KM_API bool km_port_default(const km_model *model, bool output, km_port *out);

/* An input and an output, with the workspace of one thread. */
typedef struct km_transfer km_transfer;

/* Creates a transfer from a driving `input` to an `output`. KM_USAGE: a port that is held or cannot move, equal
 * ports, or ports that do not move each other; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_transfer_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                    km_transfer **out, km_error *error);
KM_API void km_transfer_free(km_transfer *lever);

/* Computes the advantage at the state's configuration, whose mobility is current (theory 8.1). One freedom: MA = q̇_i
 * / q̇_k = (D_k/D_i) Z_i / Z_k; more: MA = (D_k/D_i) m_i / (Z_k Z_iᵀ), with only the input's substructures moving;
 * points: rows of the point's Jacobian. Scaled rates below 3e-8 of the largest are 0. KM_USAGE: a pointer is missing,
 * or the mobility is unknown; KM_MEMORY: the mobility must be computed again. `*out` is undefined then. O(coordinates
 * · freedoms). */
KM_API km_status km_transfer_compute(const km_mechanism *mechanism, km_state *state, km_transfer *lever,
                                     km_advantage *out);
/* Computes the advantage in each branch at a branch point. Returns their number, at most `most`; 0 at a regular
 * configuration, -1 without memory. The state keeps its configuration. */
KM_API int km_transfer_branches(const km_mechanism *mechanism, km_state *state, km_transfer *lever, km_advantage *out,
                                int most);
/* Returns the motion of the last computation: rates[coordinate], radians and model's length, largest scaled one 1.
 * Borrowed. */
KM_API const double *km_transfer_rates(const km_transfer *lever);

/* Returns the unit of input over output, such as "rad/mm"; "" if both are of one kind. Borrowed. */
KM_API const char *km_advantage_unit(const km_model *model, const km_port *input, const km_port *output);
/* Return "finite", "zero", "infinite", "undefined"; and "single freedom", "least motion". */
KM_API const char *km_advantage_state_name(km_advantage_state state);
KM_API const char *km_advantage_method_name(km_advantage_method method);

/* ---- Friction losses of a mechanical advantage (theory 8.6). */

/* The output's force for a unit input force, while the input moves the output against its load. */
typedef struct km_losses {
  double ratio;      /* −τ_out / f_in with friction; 0: self-locking; NaN: undefined */
  double efficiency; /* ratio over the mechanical advantage: 0 … 1 */
  bool locks;        /* self-locking: no input force moves the output */
  double locks_from; /* load share of the friction from which it locks; NaN: it does not lock */
  const char *why;   /* reason for undefined values; NULL: defined */
} km_losses;

/* The workspace of one thread. */
typedef struct km_losses_workspace km_losses_workspace;

/* True if a joint of the model has friction. */
KM_API bool km_model_has_friction(const km_model *model);

/* Creates the workspace for a driving `input` and an `output`. KM_MEMORY, KM_USAGE. The caller frees `*out`. */
KM_API km_status km_losses_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                  km_losses_workspace **out, km_error *error);
KM_API void km_losses_free(km_losses_workspace *work);

/* Computes the losses at the state's configuration, whose mobility is current. Coulomb friction with coefficient μ
 * and radius r: a rotational coordinate resists with μ r N, a slide with μ N, N the reaction across the axis (ball
 * joints: the whole reaction). A hinge's thrust resists at the same radius, on a collar. A screw's thread resists
 * along its helix: F r tan(λ + φ) against the load, F r tan(λ − φ) with it, tan λ = pitch / (2π r), tan φ = μ.
 * Weights, loads and springs do not count; statically indeterminate reactions enter with their minimum-norm part. N
 * depends on friction: Newton's method is continued from no friction to all of it (theory 8.6). Self-locking is
 * reported if the load passes through 0; if neither motion nor locking is proved, `why` says so. KM_USAGE: the
 * mobility is stale, or the workspace belongs to another mechanism; KM_MEMORY. */
KM_API km_status km_losses_compute(const km_mechanism *mechanism, km_state *state, km_losses_workspace *work,
                                   km_losses *out);

/* ---- Transmission metrics (theory 8.3, 8.4): transmission wrench, indices, transmission angle, condition of the
 * Jacobian. */

/* A metric, or the reason why it is undefined. */
typedef struct km_metric {
  double value;    /* NaN where undefined */
  const char *why; /* NULL: defined */
} km_metric;

/* The metrics of one configuration. */
typedef struct km_transmission {
  /* Transmission wrench: reciprocal to all joints of the loop but input and output. Unit force and its moment (or
   * unit moment) about the inertial origin, along the inertial axes. */
  double wrench[6];
  const char *no_wrench;         /* reason for an undefined wrench; NULL: defined */
  km_metric virtual_coefficient; /* ½ |w · s_o|; a length if a force drives a rotational output */
  km_metric sutherland_roth; /* w · s_o| over its largest value for a wrench through the output link's other joint, */
                             /* if that joint is a point of the link; 0 … 1 */
  km_metric chen_angeles;    /* Chen-Angeles index: with the point of the wrench axis nearest to that joint's axis */
  km_metric angle;           /* transmission angle of planar four-bars, model's angle unit */
  km_metric manipulability;  /* manipulability ∏σ of J D⁻¹ of the substructure, rows over its size (Yoshikawa) */
  km_metric condition;       /* condition number σ_max / σ_min of J D⁻¹ */
} km_transmission;

/* The workspace of one thread. */
typedef struct km_transmission_workspace km_transmission_workspace;
/* Creates the workspace for a driving `input` and an `output`. KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_transmission_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                        km_transmission_workspace **out, km_error *error);
KM_API void km_transmission_free(km_transmission_workspace *work);

/* Computes the metrics at the state's configuration, whose mobility is current. Never allocates. O(columns · rows²). */
KM_API void km_transmission_compute(const km_mechanism *mechanism, km_state *state, km_transmission_workspace *work,
                                    km_transmission *out);

#ifdef __cplusplus
}
#endif
#endif
