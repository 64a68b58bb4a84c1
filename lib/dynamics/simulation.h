/* A run: the integrator's vector, its derivative, and what steps are made by. Private to dynamics/. */
#ifndef KM_DYNAMICS_SIMULATION_H
#define KM_DYNAMICS_SIMULATION_H

#include "dynamics/dynamics.h"
#include "kmech/simulation.h"

typedef struct km_cvode km_cvode;

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
  double *tolerance;      /* [size] absolute */
  double *stage;          /* [5 × size] of Runge-Kutta */
  double *before, *slope; /* [size] the vector before the last fixed step, and its derivative */
  double *good;           /* [size] the vector before the last step */
  double last_time;       /* before the last step */
  double usual;           /* length of a step that counts as usual */
  bool jumped;            /* the last step was one of Runge-Kutta */
  double time;
  double pull;                 /* how fast values that the loops don't agree with are drawn to them, per time */
  km_dynamics_outcome outcome; /* of the last evaluation that failed */
  long steps, evaluations, rejected;
  bool stiff;
  km_crossing_met *met;
  size_t met_count, met_room;
  double *at;      /* [size] the vector between steps */
  double *side;    /* [crossing] coordinate less value at the last step */
  km_cvode *cvode; /* NULL: fixed steps */
};

/* The state from the vector, and back. */
void km_simulation_unpack(km_simulation *run, const double *y, double time);
void km_simulation_pack(km_simulation *run, double *y);
/* The vector's derivative. False where an evaluation fails: the step is too long. */
bool km_simulation_derivative(km_simulation *run, double time, const double *y, double *ydot);
/* Closes the loops of an accepted pose tightly and renews partitions that ask for it; what the state then is goes back into
 * the vector where `keep`. */
bool km_simulation_settle(km_simulation *run, double *y, double time, bool keep);

/* One step, not past the definition's end. KM_DIVERGED, KM_MEMORY. */
km_status km_cvode_create(km_simulation *run, km_error *error);
void km_cvode_free(km_cvode *cvode);
km_status km_cvode_step(km_simulation *run, km_error *error);
km_status km_fixed_step(km_simulation *run, km_error *error);
/* A step of length h by Runge-Kutta, the loops closed after it. False, with the vector as it was, where it fails. */
bool km_fixed_jump(km_simulation *run, double h, double to);
/* The vector at a time within the last step. */
bool km_cvode_between(const km_simulation *run, double time, double *y);
void km_fixed_between(const km_simulation *run, double time, double *y);

#endif
