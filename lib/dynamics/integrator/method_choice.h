/* Choice of the integration method that advances further for the same work. Private to dynamics/.
 *
 * Adams' method with functional iteration needs less work per step, but is stable only up to a limit of h ρ, with ρ
 * the largest rate of the motion. BDF has no such limit and solves linear equations in every step. BDF is tried if
 * Adams' steps were near their limit. The method whose steps advanced further for their work is kept; the other one
 * is tried again later, because contacts begin and end. */
#ifndef KM_DYNAMICS_INTEGRATOR_METHOD_CHOICE_H
#define KM_DYNAMICS_INTEGRATOR_METHOD_CHOICE_H

#include "base/memory.h"

typedef enum km_integration_method { KM_ADAMS, KM_BDF } km_integration_method;

/* Window of steps that are judged together. */
typedef struct km_window {
  double *y, *f;              /* [size] vector and derivative at its start */
  double time, work;          /* time and work at its start */
  int stability_limited, low; /* steps limited by stability; steps of low order */
} km_window;

typedef struct km_method_choice {
  km_integration_method method;
  bool is_fixed;       /* the method is fixed by the caller */
  int size;            /* size of the vector */
  double *y, *f, time; /* vector, derivative and time of the last evaluation */
  double largest;      /* ρ, estimated from pairs of evaluations at one time */
  long steps;          /* steps since the method began */
  int windows;         /* windows since the method began */
  km_window window;
  double rival_progress; /* progress per work of the previous method during a trial; 0: no trial */
  int patience[2];       /* [method] windows until the other method is tried */
} km_method_choice;

typedef struct km_step_record {
  double time, length; /* time at its end, and its length */
  int order;
  double work; /* work since the start of the run */
} km_step_record;

/* Initialises the choice. False, with arena->failed: out of memory. */
bool km_method_choice_create(km_method_choice *choice, km_integration_method method, bool is_fixed, int size,
                             km_arena *arena);
/* Records an evaluation of y' = f(t, y), to estimate ρ; tolerance[size] are the weights of components. */
void km_method_choice_evaluation(km_method_choice *choice, double t, const double *y, const double *f,
                                 const double *tolerance);
/* Records a step. True: change to the other method. */
bool km_method_choice_step(km_method_choice *choice, const km_step_record *step, const double *tolerance);
/* Records a failed step. True: this method was on trial, change back. */
bool km_method_choice_failure(km_method_choice *choice);
/* Changes the method. */
void km_method_choice_change(km_method_choice *choice);

/* Stability limit of h ρ for Adams' method of an order (thesis table 19). */
double km_stability_limit(int order);

#endif
