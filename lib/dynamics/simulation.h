/* A run: the integrator's vector, its derivative, and what steps are made by. Private to dynamics/. */
#ifndef KM_DYNAMICS_SIMULATION_H
#define KM_DYNAMICS_SIMULATION_H

#include "dynamics/dynamics.h"
#include "dynamics/force_breakpoints.h"
#include "dynamics/integrator/method_choice.h"
#include "kmech/dynamics.h"

typedef struct km_cvode km_cvode;

/* The vector's size is a multiple of this; components past the last are 0 and count for nothing. */
enum { KM_VECTOR_LANES = 4 };

enum { KM_STAGES = 6 }; /* of collocation */

enum { KM_WORKS = 2 }; /* dissipated; given by motors */

typedef enum km_step_way { KM_STEP_CVODE, KM_STEP_RUNGE_KUTTA, KM_STEP_COLLOCATION } km_step_way;

struct km_simulation {
  km_arena arena;
  km_dynamics *dynamics;
  km_state *state;
  km_simulation_def def;
  km_crossing *crossings; /* values in radians and the model's length unit */
  /* The vector: a value of every coordinate (four of a ball), its rates, the internal states of forces, and the work
   * that was dissipated and that motors gave. */
  int size, rate_start, memory_start, work_start;
  int *place;             /* [coordinate] of its value; of a ball's first one the quaternion's */
  double *y, *ydot;       /* [size] at `time` */
  double *shift;          /* [size] what the state has more than the vector, since pivots changed (integrator_vector.c) */
  double *seen, *closed;  /* [size] the vector with it, at the last evaluation; and the state that it became */
  double *tolerance;      /* [size] absolute; of works infinity: work_error.c has theirs */
  double *stage;          /* [(KM_STAGES + 2) × size] of steps that aren't CVODE's */
  double *kept;           /* [KM_STAGES × size] those of collocation that the last step was made with */
  double *before, *slope; /* [size] the vector before the last fixed step, and its derivative */
  double *good;           /* [size] the vector before the last step, … */
  double *good_shift;     /* … and its shift */
  double last_time;       /* before the last step */
  double usual;           /* length of a step that counts as usual; and before the last step */
  double usual_before;
  double usual_energy, largest_energy; /* what the works may err by goes by (work_error.c) */
  km_step_way way;                     /* how the last step was made */
  double time;
  km_dynamics_outcome outcome; /* of the last evaluation that failed */
  long steps, evaluations, rejected;
  km_choice choice;  /* between CVODE's methods */
  double operations; /* beside evaluations, so far */
  int unchecked;     /* steps to come that don't look for it */
  bool noisy;        /* CVODE has stopped before a pose where accelerations are rounding */
  km_corners corners;
  double due_time;    /* steps end there, since a longer one would pass over something; infinity: nowhere */
  long rejected_over; /* steps that had passed over something */
  km_crossing_met *met;
  size_t met_count, met_room;
  size_t told;     /* of these, up to the first that ends the run; those behind it wait until the run goes on */
  double *at;      /* [size] the vector between steps */
  double *side;    /* [crossing] coordinate less value at the last step */
  double stop;     /* when the last crossing that is told was met, if it ends the run; else infinite */
  bool halted;     /* the run has come there */
  km_cvode *cvode; /* NULL: fixed steps */
};

/* The state from the vector, and back. */
void km_simulation_unpack(km_simulation *run, const double *y, double time);
void km_simulation_pack(km_simulation *run, double *y);
/* From here on the state at the last evaluation is what the vector there means (integrator_vector.c). */
void km_simulation_shift(km_simulation *run);
/* The vector's derivative. False where an evaluation fails: the step is too long. */
bool km_simulation_derivative(km_simulation *run, double time, const double *y, double *ydot);
/* Closes the loops of an accepted pose tightly and renews partitions that ask for it; what the state then is goes back into
 * the vector where `keep`. */
bool km_simulation_settle(km_simulation *run, double *y, double time, bool keep);

/* Before the first step, at an evaluated state; and after every step. */
void km_simulation_begin_works(km_simulation *run);
void km_simulation_watch_works(km_simulation *run);
/* The kinetic energy of rates as small as the absolute error allowed. */
double km_simulation_rest_energy(const km_simulation *run);
/* What a work of this size may err by in a step. */
double km_simulation_work_tolerance(const km_simulation *run, double work);

/* One step, not past the definition's end. KM_DIVERGED, KM_MEMORY. */
km_status km_cvode_create(km_simulation *run, km_error *error);
void km_cvode_free(km_cvode *cvode);
km_status km_cvode_step(km_simulation *run, km_error *error);
/* Gives an N_Vector of NVECTOR_SERIAL, and all that CVODE clones from it, faster operations: its size is a multiple of
 * KM_VECTOR_LANES. */
void km_vector_use_lanes(void *vector);
km_status km_fixed_step(km_simulation *run, km_error *error);
/* The largest rate at the last evaluation, in radians or characteristic lengths per time. */
double km_simulation_speed(const km_simulation *run);
/* Where constraints hardly determine the motion for a moment, with a smallest pivot δ, poses are known to ε/δ and accelerations to
 * ε v²/δ³. What that leaves in a step of length h at the last evaluation, over the error allowed. */
double km_simulation_noise(const km_simulation *run, double h);
/* The stages of a step of length h, the largest noise at one of them and that at the last one, both for a usual step;
 * false where there are none. */
bool km_collocation_try(km_simulation *run, double h, double *noise, double *after);
/* The step with the stages that were kept; false, with the vector as it was, where it fails. */
void km_collocation_keep(km_simulation *run);
bool km_collocation_step(km_simulation *run, double h);
/* CVODE begins anew, at the vector and the time. */
bool km_cvode_restart(km_simulation *run);

/* The crossings of the last step, in order of time. False when out of memory. */
bool km_crossings_find(km_simulation *run);
/* Tells the crossings that wait to be told, up to the first that ends the run. */
void km_crossings_tell(km_simulation *run);
/* Before the first step. A value at which a coordinate begins isn't passed by leaving it. */
void km_crossings_begin(km_simulation *run);
/* A time within the last step at which a coordinate is beyond one of run->corners, though at both ends of the step it isn't:
 * no evaluation has seen it. Infinity: there is none. O(corners) but for coordinates that came near to one. */
double km_simulation_passed_over(km_simulation *run);

/* The vector at a time within the last step. */
bool km_simulation_between(const km_simulation *run, double time, double *y);
bool km_cvode_between(const km_simulation *run, double time, double *y);
void km_fixed_between(const km_simulation *run, double time, double *y);
void km_collocation_between(const km_simulation *run, double time, double *y);

#endif
