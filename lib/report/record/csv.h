/* Tables as RFC 4180 text, written and read. */
#ifndef KM_REPORT_RECORD_CSV_H
#define KM_REPORT_RECORD_CSV_H

#include "base/text.h"
#include "kmech/status.h"
#include "kmech/table.h"

/* One header row (name, then _unit), then the numbers in their shortest exact form. */
void km_csv_write(const km_table *table, km_text *out);

/* Reads a table: a header row, then rows of numbers (inf, -inf, nan and empty fields, which are nan, too). What stands
 * behind the last underscore of a column's name is its unit if it is one of the model format's or made of them (rad/mm);
 * mobility numbers, m.LABEL, have none. `file` is named in messages, with the line. KM_IO: the text is no table of
 * numbers; KM_MEMORY. The caller frees `*out`. */
km_status km_csv_read(const km_text *text, const char *file, km_table **out, km_error *error);

/* The column that is called so, with or without its unit; -1 if there is none. */
int km_csv_find(const km_table *table, const char *name);

#endif
