/* What a study of designs came to: text, tables, a record, pictures, a report. */
#ifndef KMECH_DESIGN_RESULTS_H
#define KMECH_DESIGN_RESULTS_H

#include "kmech/design_study.h"
#include "kmech/picture_format.h"
#include "kmech/value.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The study is one that was opened with this definition, and run or recalled. Names are those of the study, for people. What
 * is written is appended to `out`. KM_USAGE: something is missing; KM_IO: the store can't be read; KM_MEMORY. */
/* Tables of figures of merit, with the best marked; statistics of a sample; what an optimisation found. */
KM_API km_status km_designs_print(km_design_study *study, const km_design_study_def *def, const char *name,
                                  km_text *out, km_error *error);
/* Every design as one row: number, name, parameters, outcome, figures. */
KM_API km_status km_designs_csv(const km_design_study *study, const km_design_study_def *def, km_text *out,
                                km_error *error);
/* The same as JSON, with the statistics. The record is the arena's. */
KM_API km_status km_designs_record(km_design_study *study, const km_design_study_def *def, const char *name,
                                   km_arena *arena, km_value **out, km_error *error);
/* "as built", "pivot=33, crank=0.6", "17": what a design is called. Nothing if there is no such design. */
KM_API void km_design_label(const km_design_study *study, const km_design_study_def *def, int design, km_text *out);

/* Pictures of a study. */
typedef enum km_designs_plot {
  KM_DESIGNS_HISTOGRAM,   /* how often a figure has which values, with its quantiles and limits */
  KM_DESIGNS_SCATTER,     /* a figure over each parameter's place in its spread: a panel each, the strongest first */
  KM_DESIGNS_CONVERGENCE, /* a figure's mean and its interval over the number of designs */
  KM_DESIGNS_BANDS,       /* quantiles of a question's column over the driver */
  KM_DESIGNS_PROGRESS, /* an optimisation's goal over the designs that were asked: of each start, and the best so far */
  KM_DESIGNS_FRONT,    /* both goals of all designs, and the front */
  KM_DESIGNS_ANSWERS, /* a question's answers for all designs over each other; for the start and the best of an optimisation */
  KM_DESIGNS_PATHS /* the same of the path of the first point that the question traces */
} km_designs_plot;

enum {
  KM_MOST_OVERLAID_DESIGNS = 64 /* of so many the answers and paths are drawn, the first ones */
};

/* `index`: of the figure, or of the question; `band`: which of its bands. KM_NO_RESULT: there is nothing to draw;
 * KM_INTERNAL: the graphics library's own failure. O(designs); answers and paths of a question are asked for again, of
 * KM_MOST_OVERLAID_DESIGNS at most. */
KM_API km_status km_designs_picture(km_design_study *study, const km_design_study_def *def, const char *name,
                                    km_designs_plot plot, int index, int band, km_picture_format format, km_text *out,
                                    km_error *error);
/* A short report: what was asked, the main table, what became of the designs. `html`: one file that needs no other, else PDF
 * pages. KM_INTERNAL as above. */
KM_API km_status km_designs_report(km_design_study *study, const km_design_study_def *def, const char *name, bool html,
                                   km_text *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
