/* What the report commands of the tools share: one model, one document. */
#ifndef KT_REPORT_H
#define KT_REPORT_H

#include "common/sweep.h"

/* The entry of --format in the parser of a report command. */
#define KT_REPORT_FORMAT_OPTION                                                                                        \
  { "format", KT_OPTION_FORMAT, "FORMAT", 0, "pdf (default) or html", 2 }
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
