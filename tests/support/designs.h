/* Studies as fixtures: of functions, and of models with one question. */
#ifndef KM_TESTS_DESIGNS_H
#define KM_TESTS_DESIGNS_H

#include "support/support.h"

#include "kmech/study.h"

enum { DESIGN_MOST = 8 };

/* A definition with storage for the tests. Start from designs_of_function or designs_of_model. */
typedef struct designs {
  km_design_study_def def;
  km_design_parameter parameters[DESIGN_MOST];
  km_design_spread spreads[DESIGN_MOST];
  km_design_variable variables[DESIGN_MOST];
  km_design_sample sample;
  km_design_optimise optimise;
  km_design_question questions[2];
  km_design_figure figures[DESIGN_MOST];
  km_design_option options[DESIGN_MOST];
  char path[512];
} designs;

/* A study of `parameters` numbers x0, x1, … with `figures` figures f0, f1, … */
void designs_of_function(designs *d, km_design_function function, int parameters, int figures);
/* A study of a model of models/ with one question of this kind, without figures. */
void designs_of_model(designs *d, const char *model, const char *kind);
void designs_add_parameter(designs *d, const char *path);
void designs_add_figure(designs *d, const char *name, km_design_figure_kind kind, const char *column);
/* A sample of slider-cranks, of which some are longer than their rods and stop short. */
void designs_of_cranks(designs *d, int count);
/* An option that is one number. */
void designs_set_number(designs *d, const char *option, const double *value);

/* Opens and runs what must be right; the caller frees. */
km_design_study *designs_run(const designs *d, const char *store, int jobs);
km_design_result designs_result(const km_design_study *study, int design);

#endif
