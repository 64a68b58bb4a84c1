/* Dynamics: equations of motion, simulation over time, time histories, inverse dynamics, linearisation
 * (docs/theory.md 11). */
#ifndef KMECH_DYNAMICS_H
#define KMECH_DYNAMICS_H

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/statics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Equations of motion: accelerations, energies and driving forces. */

/* Equations of motion of a mechanism, for one thread, with all forces of its model: masses, gravity, loads, springs,
 * dampers, stops, motors, controllers, tyres, prescribed motions. Friction coefficients of joints act in
 * km_history_run and km_inverse_run only. */
typedef struct km_dynamics km_dynamics;

/* Creates the equations of motion. `forces` (km_forces_create) and the mechanism are borrowed and must outlive them.
 * KM_MEMORY; KM_MODEL: a force or a prescribed motion can't be used. The caller frees `*out`. O(joints + forces). */
KM_API km_status km_dynamics_create(const km_mechanism *mechanism, km_forces *forces, km_dynamics **out,
                                    km_error *error);
KM_API void km_dynamics_free(km_dynamics *dynamics);

/* Sets a stop at the limits of every joint whose model states limits and no stop: k = `stiffness` > 0, force per length
 * or torque per radian; b = `damping` >= 0, of that per time. Beyond a limit by x it acts with k x + b v, never pulling
 * (docs/theory.md 11.8). Call it before km_dynamics_create and km_history_run. KM_USAGE. */
KM_API km_status km_forces_set_limit_stops(km_forces *forces, double stiffness, double damping, km_error *error);

/* Prescribes value + rate · time for a coordinate (the model's units), in place of the model's law for it. KM_USAGE:
 * the coordinate is held or a component of a ball, or a number isn't finite. */
KM_API km_status km_dynamics_prescribe(km_dynamics *dynamics, int coordinate, double value, double rate,
                                       km_error *error);

/* Projects the rates v on the closed loops: min |D (v − v0)| subject to J v = 0 (metric D: docs/theory.md 1.4;
 * 11.4), with prescribed coordinates at their rates and v_k = v0_k for every stated rate (km_state_set_rate, model).
 * Contradictory statements are satisfied in least squares, the caller's before the model's. `change` (may be NULL):
 * relative change of the stated rates. The state's loops are closed. KM_MODEL: a prescribed rate violates a loop;
 * KM_MEMORY. O(n³) per substructure. */
KM_API km_status km_dynamics_project_rates(km_dynamics *dynamics, km_state *state, double *change, km_error *error);

/* Computes the accelerations at the state's configuration, rates and time, and stores them in the state: M q̈ + Jᵀλ
 * = Q, J q̈ = γ (133), by elimination of clusters (187; docs/theory.md 11.2). Dependent coordinates and rates are
 * computed from the independent ones. KM_MODEL: a free motion moves no mass; KM_DIVERGED: a loop can't be closed.
 * Allocates only if a partition has more freedoms than before. O(Σ bodies · freedom² + freedom³) over the clusters,
 * plus partitions. */
KM_API km_status km_dynamics_accelerate(km_dynamics *dynamics, km_state *state, km_error *error);

/* Energies, in force × length, at the last km_dynamics_accelerate: kinetic; potential of gravity (0 with all centres
 * of mass at the inertial origin), springs, stops and contacts; power dissipated by dampers, friction, stops, tyres and
 * contacts; power supplied by motors, controllers, loads and prescribed motions. */
typedef struct km_energy {
  double kinetic, potential, dissipation, motor_power; /* energies; powers */
} km_energy;
KM_API km_status km_dynamics_energy(km_dynamics *dynamics, km_state *state, km_energy *out, km_error *error);

/* Driving force of a prescribed coordinate along +q, in the model's force unit; for an angle force × length per
 * radian. NaN: not prescribed. Requires km_dynamics_accelerate. */
KM_API double km_dynamics_driving_force(const km_dynamics *dynamics, const km_state *state, int coordinate);

/* Largest scaled loop error before the last km_dynamics_accelerate closed the loops; km_dynamics_repartitions:
 * number of repartitions since km_dynamics_create. */
KM_API double km_dynamics_loop_error(const km_dynamics *dynamics);
KM_API int km_dynamics_repartitions(const km_dynamics *dynamics);

/* Approximate multiplications of a solution of the equations of motion, without poses, joint twists and forces: by
 * clusters, and with the dense bordered matrix (133). Requires km_dynamics_accelerate. NaN: not available. */
typedef struct km_effort {
  double multiplications, dense; /* count by clusters; count with the dense matrix */
} km_effort;
KM_API km_effort km_dynamics_effort(const km_dynamics *dynamics, const km_state *state);

/* ---- A program takes part: forces and events of its own, and inputs that it changes between steps. */

/* Motion of a frame, along the inertial axes; rotations in radians. */
typedef struct km_frame_motion {
  double origin[3], axes[9];  /* position of the origin; rotation matrix, by rows */
  double velocity[3];         /* velocity of the origin */
  double angular_velocity[3]; /* angular velocity of its body */
} km_frame_motion;

/* A motion at one time, as the functions of a program see it. */
typedef struct km_motion_sample {
  double time;                   /* the model's time unit */
  const double *q, *rate;        /* [coordinate] in the coordinate's unit, and over the time unit */
  const km_frame_motion *frames; /* [frame_count] frames of km_user_forces */
} km_motion_sample;

/* Forces that a program computes in every evaluation of the equations of motion. */
typedef struct km_user_forces {
  /* Adds to joint_forces[coordinate], forces along +q (for an angle force × length per radian), and to
   * wrenches[frame], force and moment on the frame's body at its origin along the inertial axes; all are 0 before the
   * call. The forces are a continuous function of the sample and of inputs that change between steps only. False stops
   * the run. */
  bool (*compute)(void *context, const km_motion_sample *sample, double *joint_forces, double (*wrenches)[6]);
  void *context;     /* first argument of `compute` */
  const int *frames; /* [frame_count] frames whose motion is read and on which wrenches act */
  int frame_count;
} km_user_forces;

/* Sets the forces of a program, before km_dynamics_create; frames are copied, the rest is borrowed. Their power counts
 * as motor work. KM_USAGE: a missing function or invalid frame, or equations of motion exist; KM_MEMORY. */
KM_API km_status km_forces_set_user(km_forces *forces, const km_user_forces *user, km_error *error);

/* Inputs that are constant until they are set again: a force along +q, added to the others (for an angle force × length
 * per radian; 0 at first); load `index` of km_forces_create; the reference `value` of the controller `module` (NaN: its
 * law in the model). During a run km_simulation_restart follows. KM_USAGE: invalid index or value, not a controller. */
KM_API km_status km_forces_set_joint_force(km_forces *forces, int coordinate, double force, km_error *error);
KM_API km_status km_forces_set_load(km_forces *forces, int index, const km_load *load, km_error *error);
KM_API km_status km_forces_set_reference(km_forces *forces, int module, double value, km_error *error);

/* ---- Integrating the equations of motion over time. */

/* Integration method of a run (docs/theory.md 11.5). */
typedef enum km_integrator {
  KM_INTEGRATOR_ADAMS, /* variable order and step; changes to BDF while the motion is stiff */
  KM_INTEGRATOR_BDF,   /* stiff forces: stops, tyres, strong dampers */
  KM_INTEGRATOR_FIXED  /* Runge-Kutta of order 4 with steps of `max_step`: bounded work per step */
} km_integrator;

/* Method that keeps the loops closed. */
typedef enum km_stabilisation {
  KM_STABILISE_PROJECT, /* every evaluation closes the loops from the independent coordinates */
  KM_STABILISE_BAUMGARTE /* loop errors are fed back: J q̈ = γ − 2ω ė − ω² e, ω by order and step (thesis 6.7) */
} km_stabilisation;

/* A crossing to locate: a coordinate or a function of a program passes a value. */
typedef struct km_crossing {
  int coordinate; /* coordinate that passes */
  double value;   /* in the coordinate's unit */
  bool stops;     /* the run ends at the crossing */
  /* Function that passes the value instead of a coordinate; NULL: none. Two passages within one step aren't noticed. */
  double (*function)(void *context, const km_motion_sample *sample);
  void *context; /* first argument of `function` */
} km_crossing;

/* State of a run besides time, coordinates and rates; created by km_history_resume. Energies and works in force ×
 * length. The caller frees it (km_run_memory_free). */
typedef struct km_run_memory {
  double *internal;                         /* [km_model_internal_count] internal states of the force modules */
  double potential, dissipated, motor_work; /* potential energy and works at the end of the earlier run */
  double *module_works;                     /* [km_model_module_count] works of the force modules */
} km_run_memory;
KM_API void km_run_memory_free(km_run_memory *memory);

/* Definition of a run; times in the model's time unit. Start from km_simulation_default(). */
typedef struct km_simulation_def {
  km_integrator integrator;       /* integration method */
  km_stabilisation stabilisation; /* method that keeps the loops closed */
  /* Relative and absolute error of the run; a step may have a twentieth of it. Coordinates count in radians and
   * characteristic lengths, rates in these per second. For works, the relative error refers to the largest kinetic
   * energy so far, the absolute one to the energy at one radian and one characteristic length per second. Default
   * 1e-7 each; the relative one is at least 2e-13 because of rounding. */
  double relative, absolute;
  double max_step;              /* longest step, 0: none; KM_INTEGRATOR_FIXED: the step */
  double end;                   /* end time, which no step passes; infinity: none */
  const km_crossing *crossings; /* [crossing_count] crossings to locate */
  int crossing_count;
  bool module_works;           /* integrates the power of every force module, see km_simulation_module_work */
  const km_run_memory *memory; /* end of an earlier run that this one continues, borrowed; NULL: all are 0 */
} km_simulation_def;
KM_API km_simulation_def km_simulation_default(void);

/* A run. */
typedef struct km_simulation km_simulation;

/* Creates a run from the assembled state's configuration, rates (projected by km_dynamics_project_rates) and time.
 * `dynamics` and `state` are borrowed and must outlive it; crossings are copied. KM_USAGE: invalid tolerances, steps
 * or crossings; KM_MODEL: a free motion has no mass; KM_DIVERGED: loops can't be closed; KM_MEMORY. The caller frees
 * `*out`. */
KM_API km_status km_simulation_create(km_dynamics *dynamics, km_state *state, const km_simulation_def *def,
                                      km_simulation **out, km_error *error);
KM_API void km_simulation_free(km_simulation *simulation);

/* Advances to a time, not before the state's. State, accelerations and `dynamics` are then those of that time, with
 * the loops closed to 1e-12. KM_PARTIAL: a crossing stopped the run; the state is at the crossing. KM_DIVERGED: the
 * step became too small, or loops couldn't be closed; the state is the last accepted one, its time is in
 * km_simulation_figures. KM_CANCELLED. Allocates only if a partition has more freedoms than before. */
KM_API km_status km_simulation_advance(km_simulation *simulation, double time, km_progress progress, void *context,
                                       km_error *error);

/* Makes one step of the integrator; state and statuses as km_simulation_advance. With KM_INTEGRATOR_FIXED steps end at
 * multiples of their length after the start, by six evaluations each. */
KM_API km_status km_simulation_step(km_simulation *simulation, km_error *error);

/* Continues from the state's time after a program has changed inputs of the forces, or coordinates or rates of the
 * state; rates are projected on the loops. Internal states and works stay. Crossings located later than the state's
 * time are discarded. KM_DIVERGED: loops can't be closed. */
KM_API km_status km_simulation_restart(km_simulation *simulation, km_error *error);

/* Figures of a run so far. */
typedef struct km_simulation_figures {
  double time;                   /* time reached */
  long steps, evaluations;       /* steps and evaluations of the integrator */
  long rejected;                 /* rejected steps */
  int repartitions;              /* number of repartitions */
  double dissipated, motor_work; /* work since the start, force × length: dissipated by dampers, friction, stops,
                                  * tyres; supplied by motors, controllers, loads, prescribed motions and springs
                                  * that act where they don't measure */
  double relative;               /* relative error in use: the definition's, at least 2e-13 */
  double rest_energy;            /* kinetic energy of rates of the size of the absolute error allowed */
  bool stiff;                    /* the last steps were made by BDF */
  int order;                     /* order of the last step's method; 0 before the first step */
  double last_step;              /* length of the last step */
} km_simulation_figures;
KM_API km_simulation_figures km_simulation_figures_of(const km_simulation *simulation);

/* Work of a force module since the start, force × length; NaN without `module_works`. */
KM_API double km_simulation_module_work(const km_simulation *simulation, int module);

/* A crossing that occurred. */
typedef struct km_crossing_met {
  int crossing; /* index in the definition, from 0 */
  double time;  /* located time */
  int sense;    /* +1: upwards, -1: downwards */
} km_crossing_met;
KM_API int km_simulation_crossing_count(const km_simulation *simulation);
KM_API km_crossing_met km_simulation_crossing(const km_simulation *simulation, int index);

/* ---- A session: a program sets inputs, makes steps and reads the motion, as hardware or a co-simulation does. */

/* Definition of a session. Start from km_session_default(). */
typedef struct km_session_def {
  km_simulation_def simulation; /* run; with KM_INTEGRATOR_FIXED one step of the session is one of the integrator */
  double step;                  /* length of a step, the model's time unit */
  const int *frames;            /* [frame_count] frames on which wrenches act and whose motion is read */
  int frame_count;
  const km_user_forces *user; /* forces of a program in every evaluation (km_forces_set_user), borrowed; NULL: none */
  double limit_stop[2]; /* stiffness and damping of stops at limits without one (km_forces_set_limit_stops); 0: none */
} km_session_def;
/* Default definition: fixed steps of 1 ms. */
KM_API km_session_def km_session_default(const km_model *model);

/* A session. Not thread-safe. */
typedef struct km_session km_session;

/* Creates a session at the assembled state's configuration, rates and time, with all forces of the model, `gravity`
 * NULL for the model's own. The mechanism is borrowed; the state is copied. KM_USAGE: step or frames; statuses of
 * km_dynamics_create and km_simulation_create. The caller frees `*out`. */
KM_API km_status km_session_create(const km_mechanism *mechanism, const km_state *state, const km_session_def *def,
                                   km_session **out, km_error *error);
KM_API void km_session_free(km_session *session);

/* Set inputs, which act from the next step on until they are set again: force of a joint along +q (for an angle force ×
 * length per radian); `wrench`, force and moment on frame `index` of the definition (its origin, inertial axes);
 * reference `value` of the controller `module` (NaN: its law); rate of a coordinate now (the rates of others follow the
 * loops). KM_USAGE. */
KM_API km_status km_session_set_force(km_session *session, int coordinate, double force, km_error *error);
KM_API km_status km_session_set_wrench(km_session *session, int index, const double wrench[6], km_error *error);
KM_API km_status km_session_set_reference(km_session *session, int module, double value, km_error *error);
KM_API km_status km_session_set_rate(km_session *session, int coordinate, double rate, km_error *error);

/* Makes steps; step n since the start ends at start + n · step. KM_PARTIAL: a crossing stopped the run within a step,
 * the next call continues; KM_DIVERGED, KM_CANCELLED as km_simulation_advance. Bounded work per step with
 * KM_INTEGRATOR_FIXED: six evaluations and at most one new partition. */
KM_API km_status km_session_step(km_session *session, int count, km_error *error);

/* State of the motion, borrowed; its run; and the motion of frame `index` (NaN: invalid). */
KM_API const km_state *km_session_state(const km_session *session);
KM_API double km_session_time(const km_session *session);
KM_API const km_simulation *km_session_run(const km_session *session);
KM_API km_frame_motion km_session_frame(const km_session *session, int index);

/* ---- A simulation as a table: coordinates, rates, accelerations, energies, points and reactions over time. */

/* Frame whose motion is tabulated; its name is borrowed. */
typedef struct km_traced_frame {
  int frame;        /* frame of the model */
  const char *name; /* "body/frame" */
} km_traced_frame;

/* Definition of a tabulated simulation. Times in the model's time unit. Start from km_history_default(). */
typedef struct km_history_def {
  km_simulation_def simulation;  /* run; crossings and frames are borrowed; `end` is set to `until` */
  double start;                  /* start time; 0 */
  double until, every;           /* end time; time between rows, at most KM_MAX_SWEEP_STEPS rows */
  const km_traced_frame *frames; /* frames whose origins are tabulated */
  int frame_count;
  bool frame_rotations; /* adds angular velocity and acceleration of the frames, and all along their own axes */
  const int *modules;   /* [module_count] force modules whose variable, force, power and work are tabulated */
  int module_count;
  bool reactions; /* adds the reactions of every joint */
  km_axes axes;   /* axes of the reactions */
  bool mobility;  /* adds mobility numbers */
  /* rows hold the time, coordinates and rates; all else in them, errors of energy and loops and exceeded drives are
   * left out (NaN), so that rows need no accelerations */
  bool kinematics_only;
  km_progress progress;
  void *context;
} km_history_def;
enum {
  KM_HISTORY_ROWS = 200 /* default number of intervals between rows */
};
/* Default definition, with the model's simulation settings; without them one period of the loads over a coordinate that
 * starts with a rate, else 10 s or a longer period of the loads over time; KM_HISTORY_ROWS intervals, tolerances of
 * 1e-7, KM_INTEGRATOR_ADAMS. */
KM_API km_history_def km_history_default(const km_model *model);
/* Sets `*out` to the method that the model's integration_type names. False: it names none that is known. */
KM_API bool km_model_integrator(const km_model *model, km_integrator *out);

/* A drive that exceeds its max_force or max_rate: largest value of all rows. */
typedef struct km_exceeded {
  int coordinate;     /* coordinate of the drive */
  bool of_force;      /* bound of the force; else of the rate */
  double most;        /* largest by magnitude: force or torque, or rate in the coordinate's unit over the time unit */
  double time, bound; /* time of the largest value; the bound */
} km_exceeded;

/* A joint that passes a limit without a stop (`stop` of the model): first passage and largest excess. */
typedef struct km_passed_limit {
  int coordinate; /* coordinate; for a ball's angle its first one */
  bool upper;     /* the upper limit */
  double limit;   /* in the coordinate's unit */
  double time;    /* time of the first passage; located between rows in a run */
  double beyond;  /* largest excess of all rows, the coordinate's unit */
} km_passed_limit;

/* Limits without a stop that a session's steps have passed, at most one a joint: their number, and the one of an index
 * (coordinate −1: invalid), whose `time` is the end of the first step beyond it. */
KM_API int km_session_limit_count(const km_session *session);
KM_API km_passed_limit km_session_limit(const km_session *session, int index);

/* A stated initial rate that loops or earlier statements don't permit. */
typedef struct km_changed_rate {
  int coordinate;       /* coordinate */
  double stated, start; /* stated rate, initial rate: the coordinate's unit over the time unit */
  bool by_model;        /* stated by the model; else by km_state_set_rate, which has priority */
} km_changed_rate;

/* Largest force of a prescribed motion, also located between rows, and its root mean square. */
typedef struct km_force_peak {
  int coordinate; /* coordinate of the driving force; −1: magnitude of the shaking force */
  size_t column;  /* first column in the table */
  int parts;      /* number of columns */
  double value;   /* largest value by magnitude, as in the table */
  double time;    /* time of the largest value */
  double rms;     /* sqrt(1/T ∫ f² dt) by the trapezoidal rule over the rows */
} km_force_peak;

/* Result of a simulation or of inverse dynamics. */
typedef struct km_history {
  km_table *table;               /* table with one row per time */
  km_simulation_figures figures; /* figures of the run */
  km_crossing_met *crossings;    /* crossings in order of time */
  int crossing_count;
  km_exceeded *exceeded; /* exceeded drives by coordinate: motors, controllers, prescribed motions */
  int exceeded_count;
  km_passed_limit *limits; /* passed limits by coordinate */
  int limit_count;
  km_changed_rate *changed_rates; /* changed initial rates by coordinate; empty if the stated ones are consistent */
  int changed_rate_count;
  km_force_peak *peaks; /* km_inverse_run: peaks of every driving force, then of the shaking force */
  int peak_count;
  double rate_change;  /* relative change of the stated initial rates by the projection on the loops */
  double worst_loop;   /* largest rms loop error of a row, scaled (235) */
  double energy_error; /* largest change of kinetic + potential + dissipated − motor work, force × length */
  double energy_scale; /* largest kinetic energy, the scale of energy_error */
  double energy_start; /* kinetic energy at the start */
  km_effort effort;    /* operation count of one solution */
  km_error why;        /* reason of an early end */
} km_history;

/* Simulates from the assembled state's configuration and rates, and tabulates. Columns: t; q., v., a. of every
 * coordinate; f. driving forces of prescribed joints; energy_kinetic, energy_potential (0 at the start),
 * energy_dissipated, motor_work; loop_error, evaluations, repartitions; integrator_step and integrator_order, the last
 * step's; state.NAME.integral of controllers, slip and slip_angle of tyres; frame.NAME.x … position, velocity and
 * acceleration of the origins of `frames` in the inertial frame; module.NAME.variable, value (the force), power and
 * work of `modules`, of a tyre its forces and moments along the wheel's heading, across it and along the road's normal,
 * and its slips; r.LABEL.fx … tz reactions of parent on child;
 * m.LABEL mobility numbers. KM_PARTIAL: a crossing ended the run. KM_DIVERGED, KM_CANCELLED: the table contains the
 * rows so far, `why` the reason. Others as km_simulation_create. Free `*out` in any case. */
KM_API km_status km_history_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_history_def *def, km_history *out, km_error *error);
KM_API void km_history_free(km_history *history);

/* Sets coordinates and rates from the last row of a table of km_history_run for the same model, and `*time`; `*out`
 * contains internal states, energies and works for km_simulation_def.memory. A run from 0 to t and one from t to T
 * then equal one from 0 to T within their tolerances. Columns of energies and works may be missing and count as 0.
 * `name`: name of the table in messages. KM_USAGE: a column is missing or in another unit; KM_MEMORY; statuses of
 * km_state_set_coordinates. The caller frees `*out` (km_run_memory_free). */
KM_API km_status km_history_resume(const km_mechanism *mechanism, const km_table *table, const char *name,
                                   km_state *state, double *time, km_run_memory **out, km_error *error);

/* ---- Inverse dynamics: forces of a prescribed motion on drives, joints and the ground. */

/* A coordinate that moves from its value at a constant rate. */
typedef struct km_constant_rate {
  int coordinate; /* coordinate that moves */
  double rate;    /* rate, the coordinate's unit per time unit */
} km_constant_rate;

/* Definition of inverse dynamics. Lists are borrowed. The model's prescribed motions apply in addition to these
 * rates. */
typedef struct km_inverse_def {
  const km_constant_rate *rates; /* moving coordinates and their rates */
  int rate_count;
  double until;                  /* end time, the model's time unit */
  int steps;                     /* intervals between rows */
  const km_traced_frame *frames; /* frames whose origins are tabulated */
  int frame_count;
  bool reactions; /* adds the reactions of every joint */
  km_axes axes;   /* axes of the reactions */
  km_progress progress;
  void *context;
} km_inverse_def;
/* Default definition for `rates` (borrowed): 360 intervals over one turn of the first coordinate if that is the angle
 * of a hinge, or over a longer period of the loads at these rates; over the model's simulation without rates; else
 * `until` is 0 and must be set. */
KM_API km_inverse_def km_inverse_default(const km_mechanism *mechanism, const km_constant_rate *rates, int rate_count);

/* Computes the forces of a motion whose freedoms are all prescribed (docs/theory.md 11.11). The table is that of
 * km_history_run without the columns of integration, with f. of every prescribed coordinate and `shaking.fx` … `tz`:
 * minus the sum of the rates of all momenta about the inertial origin, which acts on the ground in addition to
 * weights and loads. KM_PARTIAL: the motion can't continue (dead point of the drive, end of a link's reach); the
 * table ends there, `why` states the time. KM_USAGE: a freedom isn't prescribed, or none is. Free `*out` with
 * km_history_free in any case. */
KM_API km_status km_inverse_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_inverse_def *def, km_history *out, km_error *error);

/* ---- Small motions about a configuration: equilibria, linearised equations of motion, natural modes. */

/* Linearised equations of motion ẋ = A x + B f at the state's configuration and projected rates (docs/theory.md
 * 11.12): x deviations of `freedom` independent coordinates, then of their rates; f forces in all coordinates along
 * +q. Radians and the model's length, force and time units. Arrays are column-major. */
typedef struct km_linear {
  int freedom, coordinate_count; /* independent coordinates; all coordinates */
  int *independent;              /* [freedom] independent coordinates */
  double *A;                     /* [2 freedom × 2 freedom] */
  double *B;                     /* [2 freedom × coordinates] */
  double *N;                     /* [coordinates × freedom] derivative of all coordinates by the independent ones */
  /* [2 freedom] eigenvalues of A per time unit, by magnitude; of a pair the one with positive imaginary part first,
   * equal magnitudes by decreasing real part. */
  double *real, *imaginary;
  double *modes;       /* [2 freedom × 2 × coordinates] mode shapes: of each eigenvalue the real parts of all
                    * coordinates, then the imaginary parts; the largest scaled entry is 1 */
  double residual;     /* largest scaled acceleration of an independent coordinate per s²; 0 at rest */
  double *error_bound; /* [2 freedom] per time unit: an eigenvalue of at most this magnitude counts as 0, by the errors
                     * of the differences */
  double noise;        /* per time unit: magnitude that errors of the accelerations give an eigenvalue 0 */
} km_linear;

/* Linearises by central differences of ±1e-5 of the accelerations (radians, characteristic lengths, and these per
 * second). Errors are estimated by differences of ±2e-5 plus 1e-9 of their size; eigenvalues by LAPACK's dgeev. The
 * state is unchanged except for km_dynamics_project_rates. Prescribed coordinates follow their laws at the state's
 * time. At rest, friction is omitted, because it has no slope. KM_MODEL, KM_DIVERGED: as km_dynamics_accelerate;
 * KM_IO: LAPACKE isn't installed; KM_MEMORY. Free `*out` in any case. O(freedom · evaluation + freedom³). */
KM_API km_status km_linearise(km_dynamics *dynamics, km_state *state, km_linear *out, km_error *error);
KM_API void km_linear_free(km_linear *linear);

/* Kind of a mode. */
typedef enum km_linear_kind {
  KM_LINEAR_ZERO,       /* the eigenvalue is 0 within its error: a deviation remains */
  KM_LINEAR_OSCILLATES, /* complex eigenvalue, one of a pair: oscillation */
  KM_LINEAR_DECAYS,     /* real and negative */
  KM_LINEAR_GROWS       /* real and positive */
} km_linear_kind;
/* Kind of an eigenvalue; KM_LINEAR_ZERO if there is none with that index. O(freedom). */
KM_API km_linear_kind km_linear_kind_of(const km_linear *linear, int eigenvalue);

/* Mode shape q = q0 + a (Re v cos φ − Im v sin φ) of an eigenvector v, as a table to draw (km_drawing_add_rows):
 * `rows` rows with the column `phase` (0 to 360 deg) or, for a real eigenvalue, `t` (four time constants, factor
 * e^λt), then q. of every coordinate. The loops are closed on the independent coordinates. The amplitude a is 0.25
 * radians or characteristic lengths, halved until the loops close within half of it from the linear motion. The
 * table shows the shape only, neither decay nor amplitude. The state is at the linearised configuration and is
 * restored. The caller frees `*out`. KM_USAGE: no such eigenvalue, fewer than 2 rows; KM_DIVERGED: no amplitude
 * closes the loops; KM_MODEL, KM_MEMORY. O(rows · closing the loops). */
KM_API km_status km_linear_motion(km_dynamics *dynamics, km_state *state, const km_linear *linear, int eigenvalue,
                                  int rows, km_table **out, km_error *error);

/* Stability of a configuration. */
typedef enum km_stability {
  KM_STABLE,      /* deviations oscillate or decay */
  KM_UNSTABLE,    /* a deviation grows */
  KM_INDIFFERENT, /* an eigenvalue is 0: undecided to first order */
  KM_NOT_AT_REST  /* neither at rest nor in constant motion */
} km_stability;
KM_API const char *km_stability_name(km_stability stability); /* name, as "stable" */
/* Stability by the real parts of the eigenvalues and their error bounds; KM_NOT_AT_REST if an acceleration exceeds
 * 1e-6 (km_linear.residual). */
KM_API km_stability km_linear_stability(const km_linear *linear);

/* Moves the state to an equilibrium (docs/theory.md 11.13): Newton's method on the accelerations at rest, with steps
 * of at most 0.2 radians or characteristic lengths, longer ones if forces are linear. `settle`: first
 * pseudo-transient continuation by implicit Euler steps until the accelerations are small, repeated from unstable
 * equilibria. Rates are 0 afterwards. KM_NO_RESULT: no equilibrium was found; KM_MODEL; KM_IO: LAPACKE isn't
 * installed. O(steps · (freedom · evaluation + freedom³)). */
KM_API km_status km_equilibrium_find(km_dynamics *dynamics, km_state *state, bool settle, km_progress progress,
                                     void *context, km_error *error);
/* Moves the joints that no actuator holds to an equilibrium near the state's configuration, by Newton's method as in
 * km_equilibrium_find: the actuators' coordinates keep their values, `forces` are gravity, loads, springs, contacts and
 * stops, as in a static balance (docs/theory.md 9.7). Poses and mobility must be updated afterwards. KM_USAGE: invalid
 * index; otherwise as km_mechanism_compile, km_dynamics_create and km_equilibrium_find. */
KM_API km_status km_equilibrium_hold(const km_mechanism *mechanism, km_state *state, const km_forces *forces,
                                     const int *actuators, int actuator_count, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
