/* Studies as fixtures. */
#include "support/designs.h"

#include <stdio.h>

void designs_of_function(designs *d, km_design_function function, int parameters, int figures) {
  static const char *const names[DESIGN_MOST] = {"x0", "x1", "x2", "x3", "x4", "x5", "x6", "x7"};
  static const char *const figure_names[DESIGN_MOST] = {"f0", "f1", "f2", "f3", "f4", "f5", "f6", "f7"};
  *d = (designs){.def = km_design_study_default()};
  d->def.function = function;
  d->def.parameters = d->parameters;
  d->def.questions = d->questions;
  d->def.question_count = 1;
  d->questions[0] = (km_design_question){.name = "function", .figures = d->figures, .figure_count = figures};
  for (int p = 0; p < parameters; ++p)
    designs_add_parameter(d, names[p]);
  for (int f = 0; f < figures; ++f) {
    d->figures[f] = km_design_figure_default();
    d->figures[f].name = figure_names[f];
  }
}

void designs_of_model(designs *d, const char *model, const char *kind) {
  *d = (designs){.def = km_design_study_default()};
  snprintf(d->path, sizeof d->path, "%s/%s.json", MODELS_DIR, model);
  d->def.model = d->path;
  d->def.parameters = d->parameters;
  d->def.questions = d->questions;
  d->def.question_count = 1;
  d->questions[0] = (km_design_question){.name = kind, .kind = kind, .figures = d->figures, .options = d->options};
}

void designs_add_parameter(designs *d, const char *path) {
  assert_true(d->def.parameter_count < DESIGN_MOST);
  d->parameters[d->def.parameter_count++] = (km_design_parameter){path, path};
}

void designs_add_figure(designs *d, const char *name, km_design_figure_kind kind, const char *column) {
  km_design_figure *f = &d->figures[d->questions[0].figure_count++];
  *f = km_design_figure_default();
  f->name = name;
  f->kind = kind;
  f->column = column;
}

void designs_set_number(designs *d, const char *option, const double *value) {
  d->options[d->questions[0].option_count++] = (km_design_option){.name = option, .numbers = value, .number_count = 1};
}

void designs_of_cranks(designs *d, int count) {
  static const double steps = 30.0;
  designs_of_model(d, "slider_crank", "mobility");
  designs_add_parameter(d, "slider_crank.crank.end.y");
  designs_add_parameter(d, "slider_crank.rod.end.z");
  designs_add_figure(d, "stroke", KM_DESIGN_SPAN, "q.B");
  designs_add_figure(d, "least", KM_DESIGN_MIN, "m.A");
  designs_set_number(d, "steps", &steps);
  d->spreads[0] = (km_design_spread){0, KM_NORMAL, .mean = 0.6, .deviation = 0.004};
  d->spreads[1] = (km_design_spread){1, KM_UNIFORM, .low = -1.6, .high = -0.55};
  d->sample = (km_design_sample){.count = count, .seed = 3, .spreads = d->spreads, .spread_count = 2};
  d->def.sample = &d->sample;
}

km_design_study *designs_run(const designs *d, const char *store, int jobs) {
  km_design_study *study;
  km_error error;
  if (km_design_study_open(&d->def, store, false, &study, &error) ||
      km_design_study_run(study, jobs, NULL, NULL, &error))
    fail_msg("%s", error.text);
  return study;
}

km_design_result designs_result(const km_design_study *study, int design) {
  km_design_result r;
  km_error error;
  if (km_design_study_result(study, design, &r, &error))
    fail_msg("%s", error.text);
  return r;
}
