/* Finds each picture of a study of designs. */
#include "base/arguments.h"
#include "report/charts/chart.h"
#include "report/charts/designs_plot.h"

km_status km_designs_draw(const km_designs_shown *p, km_text *out, km_error *error) {
  switch (p->plot) {
  case KM_DESIGNS_HISTOGRAM:
    return km_designs_histogram(p, p->index, out, error);
  case KM_DESIGNS_SCATTER:
    return km_designs_scatter(p, p->index, out, error);
  case KM_DESIGNS_CONVERGENCE:
    return km_designs_convergence(p, p->index, out, error);
  case KM_DESIGNS_BANDS:
    return km_designs_bands(p, p->index, p->band, out, error);
  case KM_DESIGNS_PROGRESS:
    return km_designs_progress(p, out, error);
  case KM_DESIGNS_FRONT:
    return km_designs_front(p, out, error);
  case KM_DESIGNS_ANSWERS:
    return km_designs_answers(p, p->index, out, error);
  case KM_DESIGNS_PATHS:
    break;
  }
  return km_designs_paths(p, p->index, out, error);
}

static km_status check_place(km_design_study *study, const km_design_study_def *def, km_designs_plot plot, int index,
                             int band, km_error *error) {
  if (plot <= KM_DESIGNS_CONVERGENCE)
    return km_check_index(index, km_design_study_figures(study), "figure", error);
  if (plot == KM_DESIGNS_ANSWERS || plot == KM_DESIGNS_PATHS)
    return km_check_index(index, def->question_count, "question", error);
  if (plot != KM_DESIGNS_BANDS)
    return def->optimise ? KM_OK : km_fail(error, KM_NO_RESULT, "the study has no goals");
  km_status status = km_check_index(index, def->question_count, "question", error);
  return status ? status : km_check_index(band, def->questions[index].band_count, "band", error);
}

km_status km_designs_picture(km_design_study *study, const km_design_study_def *def, const char *name,
                             km_designs_plot plot, int index, int band, km_picture_format format, km_text *out,
                             km_error *error) {
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_check_given(study && def && name, "study or name", error);
  if (!status && ((int)plot < KM_DESIGNS_HISTOGRAM || (int)plot > KM_DESIGNS_PATHS))
    status = km_fail(error, KM_USAGE, "found no picture of a study");
  if (!status)
    status = check_place(study, def, plot, index, band, error);
  const km_designs_shown shown = {
      .study = study, .def = def, .name = name, .plot = plot, .index = index, .band = band, .format = format};
  return status ? status : km_designs_draw(&shown, out, error);
}
