/* Report commands: one model, several or variants in one document. */
#ifndef KT_REPORT_H
#define KT_REPORT_H

#include "common/sweep.h"

/* The options of a report command: those of a sweep, --format, --base and the model. */
void kt_report_options(kt_options *out, kt_sweep_options *options, const char *kind, const char *base_help);
/* True if a report is written to `base` itself, by its ending. */
bool kt_report_is_file(const char *base);
/* True, with `*html`, if --format fits the ending of `base` (may be NULL). False: it is invalid, or contradicts. */
bool kt_report_format(const char *format, const char *base, bool *html);
/* Writes `base` if it ends with .pdf or .html, else BASE.WORD.FORMAT; `name`: BASE without -o. */
kt_exit kt_report_write(const kt_common *common, const char *base, const char *name, const char *word, bool html,
                        const km_text *bytes);

#define KT_REPORT_BASE(WORD)                                                                                           \
  "Write this file if it ends with .pdf or .html, else BASE." WORD ".FORMAT (default: the model's name)"

/* Computes a question with the options of its report, and writes BASE.<kind>-report.FORMAT. */
kt_exit kt_report(kt_sweep_options *options);

#endif
