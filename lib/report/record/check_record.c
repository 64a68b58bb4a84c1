/* Findings of a check as a record and as text. */
#include "kmech/report.h"

/* Faults first; of one severity in the order in which they were found. */
void km_findings_print(const km_findings *f, const char *name, km_text *out) {
  if (!f || !name || !out)
    return;
  if (f->count == 0) {
    km_text_format(out, "%s: nothing suspicious\n", name);
    return;
  }
  km_text_format(out, "%s:", name);
  for (int severity = 0, listed = 0; severity < KM_FINDING_SEVERITIES; ++severity)
    if (f->counts[severity])
      km_text_format(out, "%s %zu %s%s", listed++ ? "," : "", f->counts[severity],
                     km_finding_severity_name((km_finding_severity)severity), f->counts[severity] == 1 ? "" : "s");
  km_text_add(out, "\n");
  for (int severity = 0; severity < KM_FINDING_SEVERITIES; ++severity)
    for (size_t i = 0; i < f->count; ++i)
      if (f->items[i].severity == (km_finding_severity)severity)
        km_text_format(out, "  %s: %s: %s\n    → %s\n", km_finding_severity_name(f->items[i].severity),
                       f->items[i].kind, f->items[i].statement, f->items[i].advice);
}

void km_findings_record(const km_findings *f, km_value *record, km_arena *arena) {
  if (!f || !record || !arena)
    return;
  km_value *list = km_value_add(arena, record, "findings", KM_LIST);
  for (size_t i = 0; i < f->count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "kind", f->items[i].kind);
    km_value_string(arena, item, "severity", km_finding_severity_name(f->items[i].severity));
    km_value_string(arena, item, "statement", f->items[i].statement);
    km_value_string(arena, item, "advice", f->items[i].advice);
  }
}
