/* What the report commands of the tools share: one model, one document. */
#ifndef KT_REPORT_H
#define KT_REPORT_H

#include "common/sweep.h"

/* The options of a report command: those of a sweep, --format, --base and the model. */
void kt_report_options(kt_options *out, kt_sweep_options *options, const char *base_help);
#define KT_REPORT_BASE(WORD)                                                                                           \
  "Write this file if it ends with .pdf or .html, else BASE." WORD ".FORMAT (default: the model's name)"

/* What a report command makes of its one model. */
typedef struct kt_reporting {
  const char *word;                      /* of the result, as in BASE.WORD.pdf */
  kt_exit (*prepare)(kt_sweep_job *job); /* as in kt_sweeping */
  km_status (*run)(kt_sweep_job *job, const km_sweep **motion, km_error *error);
  km_status (*write)(const kt_sweep_job *job, bool html, km_text *out, km_error *error);
  void (*free)(kt_sweep_job *job);
} kt_reporting;

/* Sweeps the model and writes its report. */
kt_exit kt_report(kt_sweep_options *options, const kt_reporting *reporting);

#endif
