/* Names, units and values of the transmission metrics, as in columns and keys. */
#ifndef KM_TRANSFER_TRANSMISSION_METRICS_H
#define KM_TRANSFER_TRANSMISSION_METRICS_H

#include "kmech/transfer.h"

enum { KM_METRIC_COLUMNS = 6 };

const char *km_transmission_name(int metric);
const char *km_transmission_unit(const km_model *model, const km_port *output, int metric);
/* Writes the values in that order; NaN where undefined. */
void km_transmission_values(const km_transmission *transmission, double out[KM_METRIC_COLUMNS]);

#endif
