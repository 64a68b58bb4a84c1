/* Which method of integration goes further for the same work. Private to dynamics/.
 *
 * Adams' method with functional iteration is the cheaper one a step, but where ρ is the largest rate of the motion, h ρ
 * can't pass a limit of stability. BDF has no such limit and solves equations in every step. Where Adams' steps have been
 * near their limit, BDF is tried; of two methods the one is kept whose steps went further for their work. The other
 * one is tried again after a while: contacts come and go. */
#ifndef KM_DYNAMICS_INTEGRATOR_METHOD_CHOICE_H
#define KM_DYNAMICS_INTEGRATOR_METHOD_CHOICE_H

#include "base/memory.h"

typedef enum km_method { KM_ADAMS, KM_BDF } km_method;

/* A number of steps that is looked at as a whole. */
typedef struct km_window {
  double *y, *f;     /* [size] where it began */
  double time, work; /* when it began */
  int strained, low; /* steps that only stability kept short, steps of a low order */
} km_window;

typedef struct km_choice {
  km_method method;
  bool bound;          /* the caller has chosen it */
  int size;            /* of the vector */
  double *y, *f, time; /* of the last evaluation */
  double largest;      /* ρ, as pairs of evaluations at one time tell it */
  long steps;          /* since the method began */
  int windows;         /* since then */
  km_window window;
  double rival;    /* how far the method that was left went for its work, while this one is tried; 0: it isn't */
  int patience[2]; /* [method] windows until the other one is tried */
} km_choice;

typedef struct km_taken_step {
  double time, length; /* at its end */
  int order;
  double work; /* since the run began */
} km_taken_step;

/* False (and arena->failed) when out of memory. */
bool km_choice_create(km_choice *choice, km_method method, bool bound, int size, km_arena *arena);
/* An evaluation of y' = f(t, y); `tolerance`[size] is what components are compared by. */
void km_choice_see(km_choice *choice, double t, const double *y, const double *f, const double *tolerance);
/* After a step. True: the other method's turn has come. */
bool km_choice_step(km_choice *choice, const km_taken_step *step, const double *tolerance);
/* A step failed. True: this method was only tried, so that the other one's turn has come. */
bool km_choice_fail(km_choice *choice);
/* The other method from here on. */
void km_choice_change(km_choice *choice);

/* The part of a step times the largest rate up to which Adams' method of an order is stable (thesis table 19). */
double km_stability_limit(int order);

#endif
