/* The head of a report: title, author, date, note and logo, by options or by the model. */
#ifndef KT_REPORT_HEAD_H
#define KT_REPORT_HEAD_H

#include "common/common.h"
#include "kmech/report.h"

typedef struct kt_report_head {
  km_report_header stated; /* words of the options */
  const char *logo;        /* --logo, or NULL */
  km_text logo_bytes;
  km_report_header header; /* set by kt_report_head_complete */
} kt_report_head;

/* --title, --author, --date, --note and --logo. */
void kt_report_word_options(kt_options *out, kt_report_head *head);
/* These, --format and --base. */
void kt_report_head_options(kt_options *out, kt_report_head *head, const char **format, const char **base,
                            const char *base_help);
/* Reads the file of --logo before anything is computed; reports errors. */
kt_exit kt_report_head_read(const kt_common *common, kt_report_head *head);
/* Takes from the model (may be NULL), read from `path`, what no option states; reports a logo that can't be read. */
kt_exit kt_report_head_complete(const kt_common *common, kt_report_head *head, const km_model *model, const char *path);
void kt_report_head_free(kt_report_head *head);

#endif
