/* Everything suspicious about a model, and what to do about it. */
#ifndef KM_REPORT_RECORD_CHECK_H
#define KM_REPORT_RECORD_CHECK_H

#include "base/text.h"
#include "base/value.h"
#include "report/record/diagnosis_record.h"

/* How much a finding matters: a fault keeps the mechanism from working as it is described, a warning is likely to be a
 * mistake, a remark tells what a mechanism of its kind has by nature. */
typedef enum km_finding_severity {
  KM_FINDING_FAULT,
  KM_FINDING_WARNING,
  KM_FINDING_REMARK,
  KM_FINDING_SEVERITIES
} km_finding_severity;
const char *km_finding_severity_name(km_finding_severity severity); /* "fault", "warning", "remark" */

/* One finding: a word for scripts, what was found, what to do. */
typedef struct km_finding {
  km_finding_severity severity;
  const char *kind; /* "redundant", "shaky", "undecided", "branch", "doubtful-rank", "units", "angles", "massless-loop",
                     * "unused-frame", "idle", "limits", "start", "reader" */
  const char *statement, *advice;
} km_finding;

typedef struct km_findings {
  km_arena arena;
  km_finding *items;
  size_t count, capacity;
  size_t counts[KM_FINDING_SEVERITIES];
  bool failed;
} km_findings;

/* Examines an assembled pose. `messages` are the reader's (warnings and notes count). KM_MEMORY. */
km_status km_check(const km_mechanism *mechanism, km_state *state, const km_messages *messages, km_findings *out,
                   km_error *error);
void km_findings_free(km_findings *findings);
void km_findings_print(const km_findings *findings, const char *name, km_text *out);
void km_findings_record(const km_findings *findings, km_value *record, km_arena *arena);

#endif
