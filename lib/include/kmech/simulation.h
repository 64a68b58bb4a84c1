/* Integrating the equations of motion over time. */
#ifndef KMECH_SIMULATION_H
#define KMECH_SIMULATION_H

#include "kmech/dynamics.h"
#include "kmech/progress.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The method of a run. */
typedef enum km_integrator {
  KM_INTEGRATOR_ADAMS, /* variable order and step; BDF takes over while the motion turns out stiff */
  KM_INTEGRATOR_BDF,   /* for stiff forces: stops, tyres, strong dampers */
  KM_INTEGRATOR_FIXED  /* Runge-Kutta of order 4, one step of `max_step` after the other: bounded work per step */
} km_integrator;

/* How a run keeps the loops closed. */
typedef enum km_stabilisation {
  KM_STABILISE_PROJECT, /* every evaluation takes the independent coordinates and closes the loops */
  KM_STABILISE_BAUMGARTE /* the loops' errors are fed back: J q̈ = γ − 2ω ė − ω² e, ω by order and step (thesis 6.7) */
} km_stabilisation;

/* A crossing to locate: where a coordinate passes a value. */
typedef struct km_crossing {
  int coordinate; /* which passes */
  double value;   /* the coordinate's unit */
  bool stops;     /* the run ends there */
} km_crossing;

/* Times in the model's time unit. Start from km_simulation_default(). */
typedef struct km_simulation_def {
  km_integrator integrator;       /* by which method */
  km_stabilisation stabilisation; /* how loops stay closed */
  /* The error to stay near; a step may have a twentieth of it. Of coordinates in radians and characteristic lengths, of
   * rates in those per second; of works the relative one goes by the largest kinetic energy so far, and the absolute one by
   * the energy that everything has at a radian and a characteristic length per second. 1e-7 each; a
   * relative one below 2e-13 counts as that, since rounding allows no less. */
  double relative, absolute;
  double max_step;              /* 0: none; of KM_INTEGRATOR_FIXED: the step */
  double end;                   /* no step goes past it; infinity: none */
  const km_crossing *crossings; /* [crossing_count] what is looked for on the way */
  int crossing_count;
} km_simulation_def;
KM_API km_simulation_def km_simulation_default(void);

/* A run. */
typedef struct km_simulation km_simulation;

/* Prepares a run from the assembled state's pose, rates (made to keep the loops, see km_dynamics_project_rates) and time.
 * `dynamics` and `state` are borrowed and must outlive it; crossings are copied. KM_USAGE: tolerances, steps or
 * crossings that can't be; KM_MODEL: a free motion has no mass; KM_DIVERGED: loops that don't close; KM_MEMORY. The
 * caller frees `*out`. */
KM_API km_status km_simulation_create(km_dynamics *dynamics, km_state *state, const km_simulation_def *def,
                                      km_simulation **out, km_error *error);
KM_API void km_simulation_free(km_simulation *simulation);

/* Goes on to a time, not before the state's; the state, its accelerations and `dynamics` are then those of that time,
 * with the loops closed to 1e-12. KM_PARTIAL: a crossing that stops the run was met on the way: the state is there.
 * KM_DIVERGED: the step grew too small, or loops couldn't be closed; the state is the last good one, and km_simulation_figures
 * says when. KM_CANCELLED. Allocates where a partition finds more freedom than ever before. */
KM_API km_status km_simulation_advance(km_simulation *simulation, double time, km_progress progress, void *context,
                                       km_error *error);

/* What a run has done so far. */
typedef struct km_simulation_figures {
  double time;                   /* up to which it has gone */
  long steps, evaluations;       /* of the integrator */
  long rejected;                 /* steps whose error was too large */
  int repartitions;              /* how often independent coordinates were chosen anew */
  double dissipated, motor_work; /* force × length, since the start: taken by dampers, friction, stops, tyres; given by
                                  * motors, controllers, loads, prescribed motions, springs that act
                                  * elsewhere than where they measure */
  double relative;               /* the relative error that the steps keep to: the definition's, at least 2e-13 */
  double rest_energy;            /* kinetic energy of rates as small as the absolute error allowed */
  bool stiff;                    /* the last steps were BDF's */
} km_simulation_figures;
KM_API km_simulation_figures km_simulation_figures_of(const km_simulation *simulation);

/* The crossings that were met, in order: which of the definition's, the time, and the sense (+1: upwards). */
typedef struct km_crossing_met {
  int crossing; /* which, from 0 */
  double time;  /* when, located */
  int sense;    /* +1: upwards, -1: downwards */
} km_crossing_met;
KM_API int km_simulation_crossing_count(const km_simulation *simulation);
KM_API km_crossing_met km_simulation_crossing(const km_simulation *simulation, int index);

#ifdef __cplusplus
}
#endif
#endif
