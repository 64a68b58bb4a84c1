/* State that the parts of binding a path study share: definition, study under construction, first fault. */
#ifndef KM_ARM_STUDY_STUDY_BINDING_H
#define KM_ARM_STUDY_STUDY_BINDING_H

#include "arm/study/path_study.h"

typedef struct km_binder {
  km_study *study;
  const km_study_def *def;
  const km_mechanism *mechanism;
  const km_state *state;
  unsigned long seed;
  km_messages *messages;
  int *order;       /* [n] arm's columns in the order of q0 and rates */
  km_status status; /* status of the first fault */
  km_error *error;  /* message of the first fault */
} km_binder;

/* Adds a finding. The first one is the error: KM_USAGE if it concerns an option, else KM_MODEL. Returns false. */
bool km_binder_fault(km_binder *b, const km_study_place *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Adds the finding of another function as km_binder_fault; KM_MEMORY is passed on. Returns true if there is none. */
bool km_binder_pass(km_binder *b, const km_study_place *place, km_status status, const km_error *found);
/* Sets KM_MEMORY. Returns false. */
bool km_binder_memory(km_binder *b);

/* Binds the rates. All functions km_bind_* return false after a fault. */
bool km_bind_rates(km_binder *b);
/* Start values q[n] in the arm's units: q0, or the state's configuration. */
bool km_bind_start(km_binder *b, double *q);
bool km_bind_methods(km_binder *b);
bool km_bind_path(km_binder *b, const double *q);
/* Binds the order of q0 and rates. */
bool km_bind_order(km_binder *b);

#endif
