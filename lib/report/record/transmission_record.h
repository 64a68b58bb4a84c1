/* Transmission metrics as records (JSON), as text and by name. */
#ifndef KM_REPORT_RECORD_TRANSMISSION_RECORD_H
#define KM_REPORT_RECORD_TRANSMISSION_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/transfer.h"

/* Adds `transmission` to a record: every metric with its value, or null and why. */
void km_transmission_record(const km_mechanism *mechanism, const km_transmission *transmission, const km_port *output,
                            km_value *record, km_arena *arena);
void km_transmission_print(const km_mechanism *mechanism, const km_transmission *transmission, const km_port *output,
                           km_text *out);

/* The metrics in order, for tables: name in words, unit and metric. */
enum { KM_TRANSMISSION_METRICS = 6 };
typedef struct km_named_metric {
  const char *name, *words, *unit; /* unit "": none */
  const km_metric *metric;
} km_named_metric;
void km_transmission_list(const km_mechanism *mechanism, const km_transmission *transmission, const km_port *output,
                          km_named_metric out[KM_TRANSMISSION_METRICS]);

#endif
