/* List of a study's designs by number: variants, grid points, samples, designs of an optimisation (docs/theory.md
 * 13.1). */
#include "base/arguments.h"
#include "study/optimisation/optimisation.h"
#include "study/statistics/sampler.h"

#include <math.h>
#include <string.h>

int km_designs_planned(const km_design_study *s) {
  const km_design_study_def *def = s->def;
  int count = 1;
  if (def->variant_count)
    return def->variant_count;
  if (def->sample)
    return km_sampler_designs(def->sample);
  for (int a = 0; a < def->axis_count; ++a)
    count *= def->axes[a].count;
  return def->axis_count ? count : 0;
}

int km_design_study_designs(const km_design_study *s) {
  if (!s)
    return 0;
  if (s->def->optimise)
    return s->trail.count;
  return s->stopped_at ? s->stopped_at : km_designs_planned(s);
}

int km_design_representative(const km_design_study *s, int k, int count) {
  const int total = km_design_study_designs(s);
  bool ordered = !s->def->sample || s->def->sample->method == KM_SAMPLING_LIST;
  if (count >= total || !ordered)
    return k;
  int64_t begin = (int64_t)k * total / count, end = (int64_t)(k + 1) * total / count;
  return (int)(begin + (int64_t)(km_random_at(0, (uint64_t)k, 0) * (double)(end - begin)));
}

int km_design_study_representative(const km_design_study *s, int k, int count) {
  return k >= 0 && k < count && k < km_design_study_designs(s) ? km_design_representative(s, k, count) : -1;
}

double km_design_study_length(const km_design_study *s) {
  return s ? s->length : 0.0;
}

double km_design_study_base(const km_design_study *s, int parameter) {
  return s && parameter >= 0 && parameter < s->def->parameter_count ? s->base[parameter] : nan("");
}

void km_design_values(const km_design_study *s, int design, double *values) {
  const km_design_study_def *def = s->def;
  size_t size = (size_t)def->parameter_count;
  if (def->variant_count) {
    memcpy(values, def->variants[design].values, size * sizeof *values);
    return;
  }
  km_design_clear(s, values);
  for (int a = def->axis_count - 1; a >= 0; --a) {
    values[def->axes[a].parameter] = def->axes[a].values[design % def->axes[a].count];
    design /= def->axes[a].count;
  }
  if (def->sample)
    km_sampler_values(s->sampler, design, def->parameter_count, values);
  if (def->optimise)
    memcpy(values, s->trail.values + (size_t)design * size, size * sizeof *values);
}

km_status km_design_study_values(const km_design_study *s, int design, double *values, km_error *error) {
  km_status status = km_check_given(s && values, "study or place for the values", error);
  if (!status)
    status = km_check_index(design, km_design_study_designs(s), "design", error);
  if (!status)
    km_design_values(s, design, values);
  return status;
}

const char *km_design_outcome_name(km_design_outcome outcome) {
  static const char *const names[KM_DESIGN_OUTCOMES] = {"done",     "stops short",   "no pose in reach", "not closing",
                                                        "no model", "not converged", "not computed"};
  return (unsigned)outcome < KM_DESIGN_OUTCOMES ? names[outcome] : "";
}
