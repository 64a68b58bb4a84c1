/* What the parts of binding a study share: the definition, what it becomes, and the first fault. */
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
  km_status status; /* of the first fault, */
  km_error *error;  /* which it tells */
} km_binder;

/* Adds a finding; the first one is the error, KM_USAGE where it is about an option. Returns false. */
bool km_binder_fault(km_binder *b, const km_study_place *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The same of what another function found, whose KM_MEMORY stays that. */
bool km_binder_pass(km_binder *b, const km_study_place *place, km_status status, const km_error *found);
/* Ends it with KM_MEMORY. Returns false. */
bool km_binder_memory(km_binder *b);

/* The parts. False if something is wrong. */
bool km_bind_rates(km_binder *b);
/* q0 in the arm's units; the state's pose if none is given. */
bool km_bind_start(km_binder *b, double *q);
bool km_bind_methods(km_binder *b);
bool km_bind_path(km_binder *b, const double *q);
/* Order of q0 and rates. */
bool km_bind_order(km_binder *b);

#endif
