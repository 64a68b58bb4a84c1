/* Checks the designs of a study against the bounds (`low`, `high`) that the model states for its parameters. */
#include "base/arguments.h"
#include "kmech/data.h"
#include "study/design_study.h"

#include <math.h>

/* Bounds of a parameter; ∓infinity if the model states none. */
typedef struct bounds {
  double low, high;
} bounds;

static double number_of(const km_value *parameter, const char *key, double otherwise) {
  const km_value *value = km_value_get(parameter, key);
  return value && value->kind == KM_NUMBER ? value->number : otherwise;
}

static bounds bounds_of(const km_value *parameters, const char *path) {
  const km_value *parameter = km_value_get(parameters, path);
  return (bounds){number_of(parameter, "low", -HUGE_VAL), number_of(parameter, "high", HUGE_VAL)};
}

/* Checks values from `low` to `high` of a part of the study. */
static km_status check_range(const km_design_study_def *def, const bounds *of, const char *part, int parameter,
                             double low, double high, km_error *error) {
  const bounds *b = &of[parameter];
  if (!(low < b->low || high > b->high))
    return KM_OK;
  return km_fail(
      error, KM_USAGE,
      "%s%.80s: found %.9g to %.9g; expected values from %.9g to %.9g, the bounds that the model states for its "
      "parameter (`low`, `high`)",
      part, def->parameters[parameter].name, low, high, b->low, b->high);
}

static km_status check_values(const km_design_study_def *def, const bounds *of, const char *part, const double *values,
                              km_error *error) {
  km_status status = KM_OK;
  for (int p = 0; p < def->parameter_count && !status; ++p)
    if (!isnan(values[p]))
      status = check_range(def, of, part, p, values[p], values[p], error);
  return status;
}

/* Checks a sample; of a normal distribution, which has no bounds, the mean. */
static km_status check_sample(const km_design_study_def *def, const bounds *of, const km_design_sample *sample,
                              km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; i < sample->spread_count && sample->method != KM_SAMPLING_LIST && !status; ++i) {
    const km_design_spread *s = &sample->spreads[i];
    bool bounded = s->distribution != KM_NORMAL;
    status = check_range(def, of, "sample.parameters.", s->parameter, bounded ? s->low : s->mean,
                         bounded ? s->high : s->mean, error);
  }
  for (int i = 0; sample->method == KM_SAMPLING_LIST && i < sample->count && !status; ++i)
    status = check_values(def, of, "sample.list: ", sample->list + (size_t)i * (size_t)def->parameter_count, error);
  return status;
}

/* Checks variants, grid, sample and variables. */
static km_status check_all(const km_design_study_def *def, const bounds *of, km_error *error) {
  km_status status = KM_OK;
  for (int v = 0; v < def->variant_count && !status; ++v)
    status = check_values(def, of, "variants: ", def->variants[v].values, error);
  for (int a = 0; a < def->axis_count && !status; ++a)
    for (int k = 0; k < def->axes[a].count && !status; ++k)
      status =
          check_range(def, of, "grid.", def->axes[a].parameter, def->axes[a].values[k], def->axes[a].values[k], error);
  if (!status && def->sample)
    status = check_sample(def, of, def->sample, error);
  for (int v = 0; def->optimise && v < def->optimise->variable_count && !status; ++v) {
    const km_design_variable *variable = &def->optimise->variables[v];
    status = check_range(def, of, "optimise.variables.", variable->parameter, variable->low, variable->high, error);
  }
  return status;
}

km_status km_design_check_bounds(const km_design_study *s, km_error *error) {
  const km_design_study_def *def = s->def;
  km_arena arena = {0};
  const km_value *root;
  bounds of[KM_MAX_DESIGN_PARAMETERS];
  km_status status = km_json_parse(s->bytes, s->size, &arena, &root, NULL);
  if (!status) { /* a model in another format has no parameters */
    for (int p = 0; p < def->parameter_count; ++p)
      of[p] = bounds_of(km_value_get(root, "parameters"), def->parameters[p].path);
    status = check_all(def, of, error);
  } else {
    status = status == KM_MEMORY ? km_fail(error, KM_MEMORY, "out of memory for a study") : KM_OK;
  }
  km_arena_free(&arena);
  return status;
}
