/* Dynamics: equations of motion, simulation over time, time histories, inverse dynamics, linearisation. */
#ifndef KMECH_DYNAMICS_H
#define KMECH_DYNAMICS_H

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/statics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Equations of motion: accelerations, energies and driving forces of a mechanism that moves. */

/* One thread's equations of motion of a mechanism, with all that its model says acts: masses, gravity, loads, springs,
 * dampers, stops, motors, controllers, tyres, prescribed motions. Joints' coefficients of friction act in km_history_run and
 * km_inverse_run alone. */
typedef struct km_dynamics km_dynamics;

/* `forces` (km_forces_create) and the mechanism are borrowed and must outlive it. KM_MEMORY, KM_MODEL: a force or a
 * prescribed motion can't be used. The caller frees `*out`. O(joints + forces). */
KM_API km_status km_dynamics_create(const km_mechanism *mechanism, km_forces *forces, km_dynamics **out,
                                    km_error *error);
KM_API void km_dynamics_free(km_dynamics *dynamics);

/* Drives a coordinate at a constant rate from a value on (the model's units per time unit), as a prescribed motion
 * would, from time 0. Instead of the law that the model may have for it. KM_USAGE: it is held, a component of a ball, or
 * the numbers aren't finite. */
KM_API km_status km_dynamics_prescribe(km_dynamics *dynamics, int coordinate, double value, double rate,
                                       km_error *error);

/* Makes the rates v keep the closed loops: min |D (v - v0)| subject to J v = 0 (D q: theory 4), with prescribed coordinates at
 * their rates and v_k = v0_k for every stated rate, of km_state_set_rate and of the model; the other joints follow. Stated
 * rates that contradict each other are met in least squares, the caller's before the model's. `change` (may be NULL): the
 * length of the stated rates' change, over theirs. The state's loops are closed. KM_MODEL: a prescribed rate breaks a loop;
 * KM_MEMORY. O(n³) a substructure. */
KM_API km_status km_dynamics_project_rates(km_dynamics *dynamics, km_state *state, double *change, km_error *error);

/* The accelerations at the state's pose, rates and time, into the state: M q̈ + Jᵀλ = Q, J q̈ = γ (133), by elimination
 * to independent coordinates within each substructure and from substructure to substructure (187). Dependent
 * coordinates and rates are made to follow the independent ones. KM_MODEL: a free motion moves no mass; KM_DIVERGED:
 * a loop can't be closed from here. Never allocates but where a partition finds more freedom than ever before.
 * O(Σ bodies · freedom² + freedom³) over the substructures, and their partitions. */
KM_API km_status km_dynamics_accelerate(km_dynamics *dynamics, km_state *state, km_error *error);

/* Energies, in force × length, at the state of the last km_dynamics_accelerate: kinetic; of gravity (0 with all centres
 * of mass at the inertial origin) and springs; power that dampers, friction, stops and tyres take; power that motors,
 * controllers, loads and prescribed motions give. */
typedef struct km_energy {
  double kinetic, potential, dissipation, motor_power; /* energies; powers */
} km_energy;
KM_API km_status km_dynamics_energy(km_dynamics *dynamics, km_state *state, km_energy *out, km_error *error);

/* After km_dynamics_accelerate: the force in a prescribed coordinate that its motion takes, along +q, in the model's
 * force unit, of an angle force × length per radian; NaN where the coordinate isn't prescribed. */
KM_API double km_dynamics_driving_force(const km_dynamics *dynamics, const km_state *state, int coordinate);

/* The largest scaled error of a loop that the last km_dynamics_accelerate was given, and how often partitions have been
 * renewed since km_dynamics_create. */
KM_API double km_dynamics_loop_error(const km_dynamics *dynamics);
KM_API int km_dynamics_repartitions(const km_dynamics *dynamics);

/* About how many multiplications a solution of the equations of motion takes once poses, columns and forces are known:
 * by clusters, and if the bordered matrix (133) were dense. After km_dynamics_accelerate. NaN: nothing to tell of. */
typedef struct km_effort {
  double multiplications, dense; /* by clusters; with the dense matrix */
} km_effort;
KM_API km_effort km_dynamics_effort(const km_dynamics *dynamics, const km_state *state);

/* ---- Integrating the equations of motion over time. */

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

/* ---- A simulation as a table: coordinates, rates, accelerations, energies, points and reactions over time. */

/* A frame that the table follows; its name is borrowed. */
typedef struct km_traced_frame {
  int frame;        /* of the model */
  const char *name; /* "body/frame" */
} km_traced_frame;

/* What to write down. Times in the model's time unit; start from km_history_default(). */
typedef struct km_history_def {
  km_simulation_def simulation;  /* crossings and frames are borrowed; `end` is set to `until` */
  double start;                  /* the time at which the motion begins; 0 */
  double until, every;           /* the end, and the time between rows, of which there are at most KM_MAX_SWEEP_STEPS */
  const km_traced_frame *frames; /* whose origins are written down */
  int frame_count;
  bool reactions; /* of every joint, too */
  km_axes axes;   /* of the reactions */
  bool mobility;  /* mobility numbers, too */
  km_progress progress;
  void *context;
} km_history_def;
/* The model's own simulation settings where it has some. */
KM_API km_history_def km_history_default(const km_model *model);

/* A joint's drive that goes beyond its max_force or max_rate: the most of all rows. */
typedef struct km_exceeded {
  int coordinate;     /* of the drive */
  bool of_force;      /* else of the rate */
  double most;        /* by size: a force, or of angles a torque; or the coordinate's unit over the time unit */
  double time, bound; /* when; what the drive can give */
} km_exceeded;

/* A joint that passes a limit where no stop acts (`stop` of the model): where it does so first, and how far it goes. */
typedef struct km_passed_limit {
  int coordinate; /* which passes; of a ball's angle its first one */
  bool upper;     /* the upper limit */
  double limit;   /* the coordinate's unit */
  double time;    /* when; of a run located between rows */
  double beyond;  /* the furthest of all rows past its limits, the coordinate's unit */
} km_passed_limit;

/* A stated initial rate that the loops, or rates that come before it, don't allow. */
typedef struct km_changed_rate {
  int coordinate;       /* whose */
  double stated, start; /* as stated; as the motion starts: the coordinate's unit over the time unit */
  bool by_model;        /* stated by the model; else by km_state_set_rate, which comes before the model */
} km_changed_rate;

/* The largest force of a prescribed motion, located between rows too, and its root mean square over the motion's time. */
typedef struct km_force_peak {
  int coordinate; /* whose driving force; -1: the size of the shaking force */
  size_t column;  /* its first one in the table, */
  int parts;      /* of so many */
  double value;   /* as in the table; largest by size */
  double time;    /* when */
  double rms;     /* sqrt(1/T ∫ f² dt) by the trapezoidal rule over the rows */
} km_force_peak;

/* What a simulation gave. */
typedef struct km_history {
  km_table *table;               /* a row for each time */
  km_simulation_figures figures; /* how the run went */
  km_crossing_met *crossings;    /* in order of time */
  int crossing_count;
  km_exceeded *exceeded; /* by coordinate; motors, controllers and prescribed motions are drives */
  int exceeded_count;
  km_passed_limit *limits; /* by coordinate */
  int limit_count;
  km_changed_rate *changed_rates; /* by coordinate; empty where the stated initial rates agree */
  int changed_rate_count;
  km_force_peak *peaks; /* of km_inverse_run: of every driving force, then of the shaking force */
  int peak_count;
  double rate_change;  /* share of the stated initial rates that had to change so that the loops stay closed */
  double worst_loop;   /* largest rms loop error of a row, scaled (235) */
  double energy_error; /* largest change of kinetic + potential + dissipated − motor work, force × length */
  double energy_scale; /* largest kinetic energy: what it is compared with */
  double energy_start; /* kinetic energy at the start */
  km_effort effort;    /* of an evaluation's solution */
  km_error why;        /* of a run that ended early */
} km_history;

/* Columns: t; q., v., a. of every coordinate; f. of prescribed joints, the force that drives them; energy_kinetic,
 * energy_potential (0 at the start), energy_dissipated, motor_work; loop_error, evaluations, repartitions; frame.NAME.x
 * … of followed frames: place, velocity and acceleration of its origin in the inertial frame; r.LABEL.fx … tz reactions
 * of parent on child; m.LABEL mobility numbers. From the assembled state's pose and rates. KM_PARTIAL: a
 * crossing ended the run. KM_DIVERGED, KM_CANCELLED: the table holds what was reached, `why` tells the reason. Else as
 * km_simulation_create. Free `*out` in any case. */
KM_API km_status km_history_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_history_def *def, km_history *out, km_error *error);
KM_API void km_history_free(km_history *history);

/* ---- Forces of a prescribed motion: what its drives, joints and the ground must bear. */

/* A coordinate that goes on from its value at a constant rate. */
typedef struct km_constant_rate {
  int coordinate; /* which goes on */
  double rate;    /* the coordinate's unit per time unit */
} km_constant_rate;

/* Lists are borrowed. Beside these rates the model's own prescribed motions count. */
typedef struct km_inverse_def {
  const km_constant_rate *rates; /* what moves, and how fast */
  int rate_count;
  double until;                  /* the model's time unit */
  int steps;                     /* intervals between rows */
  const km_traced_frame *frames; /* whose origins are written down */
  int frame_count;
  bool reactions; /* of every joint, too */
  km_axes axes;   /* of the reactions */
  km_progress progress;
  void *context;
} km_inverse_def;

/* Rows over time as km_history_run's, without what integration gives, and with f. of every prescribed coordinate, the
 * force that drives it, and shaking.fx … tz: −Σ of the rates of all momenta about the inertial origin, which the ground
 * bears beside weights and loads. The prescribed motions must leave no freedom. KM_PARTIAL: the motion can't go on (a
 * dead point of the drive, a limit of a link's reach): the table ends there, and `why` says when. KM_USAGE: a freedom is
 * left, or none is prescribed. Free `*out` with km_history_free in any case. */
KM_API km_status km_inverse_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_inverse_def *def, km_history *out, km_error *error);

/* ---- Small motions about a pose: rest poses, linearised equations of motion, natural modes. */

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
  double
      *error_bound; /* [2 freedom] per time unit: up to this size an eigenvalue may be 0, by the differences' errors */
  double noise;     /* per time unit: what the errors of differences of such accelerations make of an eigenvalue 0 */
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
  KM_LINEAR_ZERO,       /* the eigenvalue is 0 but for the differences: it stays */
  KM_LINEAR_OSCILLATES, /* the eigenvalue is complex, one of a pair */
  KM_LINEAR_DECAYS,     /* real and negative */
  KM_LINEAR_GROWS       /* real and positive */
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
