/* The main table of a study of designs, as cells of text: variants with the best marked, statistics of a sample, the
 * start and the best design, or a front. */
#ifndef KM_REPORT_RECORD_DESIGNS_TABLE_H
#define KM_REPORT_RECORD_DESIGNS_TABLE_H

#include "kmech/study.h"

enum { KM_DESIGNS_ROWS = 64, KM_DESIGNS_COLUMNS = 24, KM_DESIGNS_CELL = 64 };

typedef struct km_designs_table {
  char cells[KM_DESIGNS_ROWS + 3][KM_DESIGNS_COLUMNS][KM_DESIGNS_CELL];
  int rows, columns;
  int left_out; /* number of designs that were omitted */
  bool failed;  /* while it was made: out of memory */
  bool marked;  /* "*" precedes the best value of a figure */
} km_designs_table;

/* KM_IO, KM_MEMORY. */
km_status km_designs_table_make(km_design_study *study, const km_design_study_def *def, km_designs_table *out,
                                km_error *error);

/* True if the designs are a random sample, so that shares have a confidence interval. */
bool km_designs_are_drawn(const km_design_study_def *def);
/* True if a figure has a limit, so that designs can be accepted or not. */
bool km_designs_have_limits(const km_design_study *study);

#endif
