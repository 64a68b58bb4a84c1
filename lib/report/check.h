/* Everything suspicious about a model, and what to do about it. */
#ifndef KM_REPORT_CHECK_H
#define KM_REPORT_CHECK_H

#include "base/text.h"
#include "base/value.h"
#include "report/diagnosis_record.h"

/* One finding: a word for scripts, what was found, what to do. */
typedef struct km_finding {
  const char *kind; /* "redundant", "shaky", "undecided", "branch", "doubtful-rank", "units", "angles", "massless-loop",
                     * "unused-frame", "limits", "start", "reader" */
  const char *statement, *advice;
} km_finding;

typedef struct km_findings {
  km_arena arena;
  km_finding *items;
  size_t count, capacity;
  bool failed;
} km_findings;

/* Examines an assembled pose. `messages` are the reader's (warnings and notes count). KM_MEMORY. */
km_status km_check(const km_mechanism *mechanism, km_state *state, const km_messages *messages, km_findings *out,
                   km_error *error);
void km_findings_free(km_findings *findings);
void km_findings_print(const km_findings *findings, const char *name, km_text *out);
void km_findings_record(const km_findings *findings, km_value *record, km_arena *arena);

#endif
