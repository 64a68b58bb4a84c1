/* A simulation run: the integrator's vector, its derivative, and the state of step control. Private to dynamics/. */
#ifndef KM_DYNAMICS_SIMULATION_H
#define KM_DYNAMICS_SIMULATION_H

#include "dynamics/dynamics.h"
#include "dynamics/force_breakpoints.h"
#include "dynamics/integrator/method_choice.h"
#include "kmech/dynamics.h"

typedef struct km_cvode km_cvode;

/* The vector's size is a multiple of this; padding components are 0 and have no weight. */
enum { KM_VECTOR_LANES = 4 };

enum { KM_STAGES = 6 }; /* stages of collocation */

enum { KM_WORKS = 2 }; /* dissipated work; work of motors; the works of the force modules follow if requested */

typedef enum km_step_method { KM_STEP_CVODE, KM_STEP_RUNGE_KUTTA, KM_STEP_COLLOCATION } km_step_method;

struct km_simulation {
  km_arena arena;
  km_dynamics *dynamics;
  km_state *state;
  km_simulation_def def;
  km_crossing *crossings; /* crossings with values in radians and the model's length unit */
  /* Vector: values of coordinates (quaternions of balls), rates, internal states of forces, dissipated work, motor
   * work. */
  int size, rate_start, memory_start, work_start;
  int work_count;   /* KM_WORKS, and the works of the model's force modules */
  int *value_index; /* [coordinate] index of its value; for a ball's first coordinate, index of the quaternion */
  double *y, *ydot; /* [size] vector and derivative at `time` */
  double *shift;    /* [size] state minus vector since pivots changed (integrator_vector.c) */
  double *shifted, *closed; /* [size] vector plus shift at the last evaluation; state after closing the loops */
  double *tolerance;        /* [size] absolute tolerances; infinity for works, see work_error.c */
  double *stage;            /* [(KM_STAGES + 2) × size] stages of steps that aren't CVODE's */
  double *kept_stages;      /* [KM_STAGES × size] collocation stages of the last step */
  double *before, *slope;   /* [size] vector and derivative before the last fixed step */
  double *accepted;         /* [size] vector before the last step */
  double *accepted_shift;   /* [size] shift before the last step */
  double origin;            /* time of the start: fixed steps end at multiples of their length after it */
  double last_time;         /* time before the last step */
  double typical_step;      /* typical step length, and its value before the last step */
  double typical_step_before;
  double unit_energy, largest_energy; /* energies for the tolerance of works (work_error.c) */
  km_step_method step_method;         /* method of the last step */
  int order;                          /* its order; 0 before the first step */
  double time;
  km_dynamics_outcome outcome; /* outcome of the last failed evaluation */
  long steps, evaluations, rejected;
  km_method_choice choice; /* choice between CVODE's methods */
  double operations;       /* operations of linear algebra, besides evaluations */
  int unchecked;           /* remaining steps without a check of noise */
  bool is_noisy;           /* CVODE stopped before a configuration where accelerations are dominated by rounding */
  km_corners corners;
  double due_time;    /* time at which a step must end, because a longer one passed over a corner; infinity: none */
  long rejected_over; /* steps repeated because they passed over a corner */
  km_crossing_met *crossings_met;
  size_t crossings_met_count, crossings_met_capacity;
  size_t reported; /* crossings reported so far, up to the first that ends the run; later ones wait until the run
                    * continues */
  double *at;      /* [size] vector between steps */
  double *side;    /* [crossing] coordinate minus value at the last step */
  double stop;     /* time of the last reported crossing if it ends the run; else infinity */
  bool halted;     /* the run has stopped there */
  bool skips_accelerations; /* the state between steps has coordinates and rates only */
  km_cvode *cvode;          /* integrator; NULL: fixed steps */
};

/* Copies the vector to the state; km_simulation_pack copies back. */
void km_simulation_unpack(km_simulation *run, const double *y, double time);
void km_simulation_pack(km_simulation *run, double *y);
/* Sets the state from a vector, and the poses and twists of the bodies on which forces act; loops aren't closed. */
void km_simulation_locate_bodies(km_simulation *run, const double *y, double time);
/* Sets the shift so that the vector of the last evaluation represents its closed state (integrator_vector.c). */
void km_simulation_shift(km_simulation *run);
/* Computes the vector's derivative. False: an evaluation failed, the step is too long. */
bool km_simulation_derivative(km_simulation *run, double time, const double *y, double *ydot);
/* Sets the state's coordinates and rates from a vector, and the accelerations only where constraints are weak, which
 * km_simulation_noise examines. False: loops can't be closed. */
bool km_simulation_close(km_simulation *run, double time, const double *y);
/* Closes the loops of an accepted configuration tightly and renews partitions where requested. If `keep`, the closed
 * state is written back to the vector. */
bool km_simulation_accept(km_simulation *run, double *y, double time, bool keep);

/* Initialises the tolerance of works at an evaluated state before the first step. */
void km_simulation_begin_works(km_simulation *run);
void km_simulation_update_works(km_simulation *run);
/* Kinetic energy of rates of the size of the absolute error allowed. */
double km_simulation_rest_energy(const km_simulation *run);
/* Error allowed for a work of this size in a step. */
double km_simulation_work_tolerance(const km_simulation *run, double work);

/* Creates the integrator. Steps of km_cvode_step and km_fixed_step don't pass the definition's end. KM_DIVERGED,
 * KM_MEMORY. */
km_status km_cvode_create(km_simulation *run, km_error *error);
void km_cvode_free(km_cvode *cvode);
km_status km_cvode_step(km_simulation *run, km_error *error);
/* Replaces the operations of an N_Vector of NVECTOR_SERIAL and of its clones by SIMD ones. Its size is a multiple of
 * KM_VECTOR_LANES. */
void km_vector_use_lanes(void *vector);
km_status km_fixed_step(km_simulation *run, km_error *error);
/* Largest rate at the last evaluation, in radians or characteristic lengths per time. */
double km_simulation_speed(const km_simulation *run);
/* Rounding error of a step of length h at weak constraints, over the error allowed: with a smallest pivot δ,
 * configurations are known to ε/δ and accelerations to ε v²/δ³. */
double km_simulation_noise(const km_simulation *run, double h);
/* Computes the stages of a collocation step of length h, the largest noise of a stage and that of the last one, for
 * a typical step length. False: no convergence. */
bool km_collocation_try(km_simulation *run, double h, double *noise, double *after);
/* Stores the stages of the last trial; km_collocation_step makes the step with them. False, with the vector
 * unchanged: it failed. */
void km_collocation_keep(km_simulation *run);
bool km_collocation_step(km_simulation *run, double h);
/* Restarts CVODE at the present vector and time. */
bool km_cvode_restart(km_simulation *run);

/* Finds the crossings of the last step, sorted by time. False: out of memory. */
bool km_crossings_find(km_simulation *run);
/* Reports the waiting crossings up to the first that ends the run. */
void km_crossings_report(km_simulation *run);
/* Initialises the crossings at a start or restart. Leaving a value at which the motion is then is no crossing. */
void km_crossings_begin(km_simulation *run);
/* Time within the last step at which a coordinate is beyond a corner although it isn't at both ends of the step, so
 * that no evaluation noticed it; or at which it passes the first of several corners. Infinity: none. O(corners), plus
 * the search near a corner. */
double km_simulation_passed_over(km_simulation *run);

/* Time within the last step at which the bodies of a contact overlap although they are apart at both ends of the step;
 * infinity: none. O(1) without contacts, else up to some ten forward kinematics a contact. */
double km_contacts_passed_over(km_simulation *run);

/* Interpolates the vector at a time within the last step (dense output). */
bool km_simulation_interpolate(const km_simulation *run, double time, double *y);
bool km_cvode_interpolate(const km_simulation *run, double time, double *y);
void km_fixed_interpolate(const km_simulation *run, double time, double *y);
void km_collocation_interpolate(const km_simulation *run, double time, double *y);

#endif
