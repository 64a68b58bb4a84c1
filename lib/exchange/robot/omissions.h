/* Kinds of things that a reader or a writer leaves out, counted. */
#ifndef KM_EXCHANGE_ROBOT_OMISSIONS_H
#define KM_EXCHANGE_ROBOT_OMISSIONS_H

#include "kmech/base.h"

/* Names of the closure tolerance in MJCF (a numeric of `custom`) and SDF (an element of a model). */
#define KM_MJCF_TOLERANCE "kmech_closure_tolerance"
#define KM_SDF_TOLERANCE  "kmech:closure_tolerance"

enum { KM_MAX_OMISSIONS = 48 };

typedef struct km_omission {
  const char *kind, *first; /* the name of the first one, "" if it has none; both borrowed */
  int count;
} km_omission;

typedef struct km_omissions {
  km_omission items[KM_MAX_OMISSIONS];
  int count;
} km_omissions;

/* Counts an omission; `name` may be NULL. Kinds after the last slot are dropped. */
void km_omissions_add(km_omissions *omissions, const char *kind, const char *name);
/* A note for each kind: how many, and the first one. */
void km_omissions_report(const km_omissions *omissions, km_messages *messages);

#endif
