/* Tables as RFC 4180 text. */
#ifndef KM_REPORT_RECORD_CSV_H
#define KM_REPORT_RECORD_CSV_H

#include "base/text.h"
#include "kmech/table.h"

/* One header row (name, then _unit), then the numbers in their shortest exact form. */
void km_csv_write(const km_table *table, km_text *out);

#endif
