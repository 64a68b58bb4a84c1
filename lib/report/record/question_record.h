/* Answers to questions as records (JSON) and as text for people, whatever their kind. */
#ifndef KM_REPORT_RECORD_QUESTION_RECORD_H
#define KM_REPORT_RECORD_QUESTION_RECORD_H

#include "base/text.h"
#include "kmech/question.h"
#include "report/record/record.h"

/* What a sweep's `--format json` gives (cli.md). `name`: the model's; `stopped_by`: km_sweep_stop_text. NULL when out of
 * memory (arena->failed) or without an answer. */
km_value *km_question_record(const km_question *question, const km_mechanism *mechanism, const char *stopped_by,
                             const char *name, km_arena *arena);
/* A summary to act on. */
void km_question_print(const km_question *question, const km_mechanism *mechanism, const char *name, km_text *out);

#endif
