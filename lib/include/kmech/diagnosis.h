/* What a pose has beyond its numbers, and everything about a model that is suspicious. */
#ifndef KMECH_DIAGNOSIS_H
#define KMECH_DIAGNOSIS_H

#include "kmech/finite_mobility.h"
#include "kmech/idle.h"
#include "kmech/redundancy.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The three answers about one pose. */
typedef struct km_diagnosis {
  km_finite_mobility finite;    /* which motions are real */
  km_redundancies redundancies; /* what is constrained twice */
  km_idle_freedoms idle;        /* what moves by itself */
} km_diagnosis;

/* All three at an assembled pose. Free `*out` in any case. KM_CANCELLED, KM_MEMORY. Cost: the sum of them. */
KM_API km_status km_diagnosis_find(const km_mechanism *mechanism, km_state *state, km_progress progress, void *context,
                                   km_diagnosis *out, km_error *error);
KM_API void km_diagnosis_free(km_diagnosis *diagnosis);

/* Adds notes to `messages` about the geometry of an assembled configuration: the ends of a planar loop that are offset
 * along its hinge axes, and overconstrained substructures that are rigid as written, but within a thousandth of their
 * size of one that moves. The state keeps its configuration. O(loops), and for each such substructure 20 compilations
 * of the model. */
KM_API void km_geometry_notes(const km_mechanism *mechanism, km_state *state, km_messages *messages);
/* Adds a warning for each substructure whose rank is doubtful: a singular value within a factor of ten of the rank
 * tolerance or, of exact data, between what rounding leaves and what geometry makes. KM_MEMORY. O(rows · columns²)
 * each. */
KM_API km_status km_rank_doubts(const km_mechanism *mechanism, km_state *state, km_messages *messages, km_error *error);

/* How much a finding matters: a fault keeps the mechanism from working as it is described, a warning is likely to be a
 * mistake, a remark tells what a mechanism of its kind has by nature. */
typedef enum km_finding_severity {
  KM_FINDING_FAULT,     /* it can't work as it is described */
  KM_FINDING_WARNING,   /* likely to be a mistake */
  KM_FINDING_REMARK,    /* so by nature */
  KM_FINDING_SEVERITIES /* how many there are */
} km_finding_severity;
KM_API const char *km_finding_severity_name(km_finding_severity severity); /* "fault", "warning", "remark" */

/* One finding: a word for programs, what was found, what to do. */
typedef struct km_finding {
  km_finding_severity severity; /* how much it matters */
  const char *kind; /* "redundant", "shaky", "undecided", "branch", "doubtful-rank", "units", "angles", "massless-loop",
                     * "unused-frame", "idle", "limits", "start", "damping", "stop", "friction", "geometry", "reader" */
  const char *statement, *advice; /* what was found; what to do */
} km_finding;

/* All findings about a model. */
typedef struct km_findings {
  km_finding *items; /* in the order in which they were found */
  size_t count;
  size_t counts[KM_FINDING_SEVERITIES]; /* of each severity */
  struct km_findings_store *store;      /* of the texts */
} km_findings;

/* Examines an assembled pose. `messages` are the reader's, whose warnings and notes count; NULL: none. Free `*out` in
 * any case. KM_CANCELLED, KM_MEMORY. */
KM_API km_status km_check(const km_mechanism *mechanism, km_state *state, const km_messages *messages,
                          km_progress progress, void *context, km_findings *out, km_error *error);
/* Leaves out those of a kind: who has moved the mechanism himself, for instance, isn't told that it starts elsewhere
 * ("start"). */
KM_API void km_findings_leave_out(km_findings *findings, const char *kind);
KM_API void km_findings_free(km_findings *findings);

#ifdef __cplusplus
}
#endif
#endif
