/* Checks a study's definition before it is opened. Errors state their place by the names of JSON keys. */
#include "base/arguments.h"
#include "base/similar_names.h"
#include "study/design_study.h"
#include "study/optimisation/optimisation.h"
#include "study/statistics/sampler.h"

#include <math.h>
#include <string.h>

enum { MAX_DESIGNS = 1000000000 };

km_design_study_def km_design_study_default(void) {
  return (km_design_study_def){0};
}

int km_design_find_figure(const km_design_study_def *def, const char *name) {
  int index = 0;
  for (int q = 0; q < def->question_count; ++q)
    for (int f = 0; f < def->questions[q].figure_count; ++f, ++index)
      if (strcmp(def->questions[q].figures[f].name, name) == 0)
        return index;
  return -1;
}

static km_status no_figure(const km_design_study_def *def, const char *place, const char *name, km_error *error) {
  char names[KM_NEAREST_TEXT];
  km_nearest nearest = {.wanted = name};
  for (int q = 0; q < def->question_count; ++q)
    for (int f = 0; f < def->questions[q].figure_count; ++f)
      km_nearest_add(&nearest, def->questions[q].figures[f].name);
  return km_fail(error, KM_USAGE, "%s: there is no figure \"%.80s\"; the nearest ones are %s", place, name,
                 km_nearest_text(&nearest, names));
}

static km_status check_named_figure(const km_design_study_def *def, const char *place, const char *name,
                                    km_error *error) {
  if (!name)
    return km_fail(error, KM_USAGE, "%s: expected the name of a figure", place);
  return km_design_find_figure(def, name) >= 0 ? KM_OK : no_figure(def, place, name, error);
}

/* Checks number, names and paths of the parameters. */
static km_status check_parameters(const km_design_study_def *def, km_error *error) {
  if (def->parameter_count > KM_MAX_DESIGN_PARAMETERS)
    return km_fail(error, KM_USAGE, "parameters: found %d; expected at most %d", def->parameter_count,
                   KM_MAX_DESIGN_PARAMETERS);
  km_status status = km_check_list(def->parameters, def->parameter_count, "parameters", error);
  for (int p = 0; p < def->parameter_count && !status; ++p) {
    status = km_check_given(def->parameters[p].name && def->parameters[p].path, "name or path of a parameter", error);
    for (int k = 0; k < p && !status; ++k)
      if (strcmp(def->parameters[k].path, def->parameters[p].path) == 0)
        status = km_fail(error, KM_USAGE, "parameters: \"%.80s\" and \"%.80s\" are the same number",
                         def->parameters[k].name, def->parameters[p].name);
  }
  return status;
}

static km_status check_index(const km_design_study_def *def, const char *place, int parameter, km_error *error) {
  if (parameter >= 0 && parameter < def->parameter_count)
    return KM_OK;
  return km_fail(error, KM_USAGE, "%s: there is no parameter %d; expected 0 to %d", place, parameter,
                 def->parameter_count - 1);
}

/* Checks names and values of the variants. */
static km_status check_variants(const km_design_study_def *def, km_error *error) {
  km_status status = km_check_list(def->variants, def->variant_count, "variants", error);
  for (int v = 0; v < def->variant_count && !status; ++v) {
    status = km_check_given(def->variants[v].name && def->variants[v].values, "name or values of a variant", error);
    for (int p = 0; p < def->parameter_count && !status; ++p)
      if (isinf(def->variants[v].values[p]))
        status = km_fail(error, KM_USAGE, "variants.%.80s: a value that isn't finite", def->variants[v].name);
  }
  return status;
}

/* Checks the axes of a grid and the number of its designs. */
static km_status check_axes(const km_design_study_def *def, km_error *error) {
  double designs = 1.0;
  km_status status = km_check_list(def->axes, def->axis_count, "axes of a grid", error);
  for (int a = 0; a < def->axis_count && !status; ++a) {
    const km_design_axis *axis = &def->axes[a];
    status = check_index(def, "grid", axis->parameter, error);
    if (status)
      return status;
    const char *name = def->parameters[axis->parameter].name;
    if (axis->count < 1 || !axis->values)
      return km_fail(error, KM_USAGE, "grid.%.80s: found no values; expected at least one", name);
    for (int i = 0; i < axis->count; ++i)
      if (!isfinite(axis->values[i]))
        return km_fail(error, KM_USAGE, "grid.%.80s: a value that isn't finite", name);
    for (int k = 0; k < a; ++k)
      if (def->axes[k].parameter == axis->parameter)
        return km_fail(error, KM_USAGE, "grid.%.80s: it has two axes", name);
    designs *= axis->count;
  }
  if (designs > MAX_DESIGNS)
    return km_fail(error, KM_USAGE, "grid: found %.10g designs; expected at most %d", designs, MAX_DESIGNS);
  return status;
}

/* Checks the distribution of a sampled parameter. */
static km_status check_spread(const km_design_study_def *def, const km_design_spread *s, km_error *error) {
  km_status status = check_index(def, "sample", s->parameter, error);
  if (status)
    return status;
  const char *name = def->parameters[s->parameter].name;
  bool bounded = s->distribution != KM_NORMAL, normal = s->distribution != KM_UNIFORM;
  if ((unsigned)s->distribution > KM_TRUNCATED_NORMAL)
    return km_fail(error, KM_USAGE, "sample.parameters.%.80s: there is no such distribution", name);
  if (bounded && !(isfinite(s->low) && isfinite(s->high) && s->low < s->high))
    return km_fail(error, KM_USAGE, "sample.parameters.%.80s: found bounds [%g, %g]; expected low < high", name, s->low,
                   s->high);
  if (normal && !(isfinite(s->mean) && isfinite(s->deviation) && s->deviation > 0.0))
    return km_fail(error, KM_USAGE,
                   "sample.parameters.%.80s: found mean %g and deviation %g; expected a deviation greater than 0", name,
                   s->mean, s->deviation);
  if (bounded && normal && !(s->high > s->mean - 8.0 * s->deviation && s->low < s->mean + 8.0 * s->deviation))
    return km_fail(error, KM_USAGE,
                   "sample.parameters.%.80s: found bounds [%g, %g] more than 8 deviations from the mean %g", name,
                   s->low, s->high, s->mean);
  return KM_OK;
}

/* Checks a sample: count, method, distributions, accuracy. */
static km_status check_sample(const km_design_study_def *def, const km_design_sample *s, km_error *error) {
  int width = km_sampler_width(s);
  if (s->count < 1 || s->count > MAX_DESIGNS / width)
    return km_fail(error, KM_USAGE, "sample.count: found %d%s; expected 1 to %d%s", s->count,
                   width > 1 ? ", each of several designs for the indices" : "", MAX_DESIGNS / width,
                   width > 1 ? "" : " designs in all");
  if ((unsigned)s->method > KM_SAMPLING_LIST)
    return km_fail(error, KM_USAGE, "sample.method: there is no such method");
  if (s->method == KM_SAMPLING_LIST)
    return km_check_given(s->list != NULL && !s->indices, "list of values, without indices,", error);
  km_status status = km_check_list(s->spreads, s->spread_count, "spreads of a sample", error);
  if (!status && s->spread_count == 0)
    status = km_fail(error, KM_USAGE, "sample.parameters: found none; expected at least one that spreads");
  for (int i = 0; i < s->spread_count && !status; ++i) {
    status = check_spread(def, &s->spreads[i], error);
    for (int k = 0; k < i && !status; ++k)
      if (s->spreads[k].parameter == s->spreads[i].parameter)
        status = km_fail(error, KM_USAGE, "sample.parameters.%.80s: it is there twice",
                         def->parameters[s->spreads[i].parameter].name);
  }
  int dimensions = km_sampler_dimensions(s);
  if (!status && s->method == KM_SAMPLING_SOBOL && dimensions > KM_MAX_SOBOL)
    return km_fail(error, KM_USAGE,
                   "sample.method: a Sobol sequence has at most %d dimensions, and %d are needed; expected latin or "
                   "random",
                   KM_MAX_SOBOL, dimensions);
  if (!status && s->accuracy_figure)
    status = check_named_figure(def, "sample.accuracy", s->accuracy_figure, error);
  if (!status && s->accuracy_figure && !(s->accuracy > 0.0 && !s->indices))
    status =
        km_fail(error, KM_USAGE,
                "sample.accuracy: found a half width of %g; expected one greater than 0, and no indices", s->accuracy);
  return status;
}

/* Checks bounds and start of a variable. */
static km_status check_variable(const km_design_study_def *def, const km_design_variable *v, km_error *error) {
  km_status status = check_index(def, "optimise.variables", v->parameter, error);
  if (status)
    return status;
  const char *name = def->parameters[v->parameter].name;
  if (!(isfinite(v->low) && isfinite(v->high) && v->low < v->high))
    return km_fail(error, KM_USAGE, "optimise.variables.%.80s: found bounds [%g, %g]; expected low < high", name,
                   v->low, v->high);
  if (!isnan(v->start) && !(v->start >= v->low && v->start <= v->high))
    return km_fail(error, KM_USAGE, "optimise.variables.%.80s: the start %g lies outside [%g, %g]", name, v->start,
                   v->low, v->high);
  return KM_OK;
}

/* Checks variables, goals, algorithm and limits of an optimisation. */
static km_status check_optimise(const km_design_study_def *def, const km_design_optimise *o, km_error *error) {
  km_status status = km_check_list(o->variables, o->variable_count, "variables", error);
  if (!status && o->variable_count == 0)
    status = km_fail(error, KM_USAGE, "optimise.variables: found none; expected at least one");
  for (int v = 0; v < o->variable_count && !status; ++v)
    status = check_variable(def, &o->variables[v], error);
  if (!status && (o->goal_count < 1 || o->goal_count > 2))
    status = km_fail(error, KM_USAGE, "optimise: found %d goals; expected one or two of minimise and maximise",
                     o->goal_count);
  for (int g = 0; g < o->goal_count && !status; ++g)
    status = check_named_figure(def, o->goals[g].largest ? "optimise.maximise" : "optimise.minimise",
                                o->goals[g].figure, error);
  if (!status)
    status = km_algorithm_check(o->algorithm, error);
  if (!status && (o->evaluations < 1 || o->starts < 1))
    status = km_fail(error, KM_USAGE, "optimise: found %d evaluations and %d starts; expected at least one of each",
                     o->evaluations, o->starts);
  if (!status && (double)o->evaluations * (o->starts + 2.0) > MAX_DESIGNS)
    status = km_fail(error, KM_USAGE,
                     "optimise: found %d evaluations of each of %d starts; expected at most %d designs in all",
                     o->evaluations, o->starts, MAX_DESIGNS);
  if (!status && !(o->tolerance >= 0.0 && o->tolerance < 1.0))
    status =
        km_fail(error, KM_USAGE, "optimise.tolerance: found %g; expected at least 0 and less than 1", o->tolerance);
  return status;
}

/* Checks a figure. */
static km_status check_figure(const km_design_question *q, const km_design_figure *f, km_error *error) {
  if (!f->name || !*f->name)
    return km_fail(error, KM_USAGE, "ask.%.80s.figures: a figure has no name", q->name);
  if ((unsigned)f->kind >= KM_DESIGN_FIGURE_KINDS)
    return km_fail(error, KM_USAGE, "ask.%.80s.figures.%.80s: there is no such kind of figure", q->name, f->name);
  bool alone = !q->kind || f->kind == KM_DESIGN_REACHED || f->kind == KM_DESIGN_TOGGLES;
  if (!alone && !f->column)
    return km_fail(error, KM_USAGE, "ask.%.80s.figures.%.80s: expected a column", q->name, f->name);
  if (f->kind == KM_DESIGN_SETTLING && !(f->at > 0.0 && f->at < 1.0))
    return km_fail(error, KM_USAGE,
                   "ask.%.80s.figures.%.80s: within %g; expected a part greater than 0 and less than 1", q->name,
                   f->name, f->at);
  if (!(f->low <= f->high))
    return km_fail(error, KM_USAGE, "ask.%.80s.figures.%.80s: found limits [%g, %g]; expected low ≤ high", q->name,
                   f->name, f->low, f->high);
  if (q->kind && f->kind == KM_DESIGN_DISTANCE && (f->point_count < 1 || !f->points))
    return km_fail(error, KM_USAGE, "ask.%.80s.figures.%.80s: found no points; expected at least one", q->name,
                   f->name);
  return KM_OK;
}

/* Checks the requests and their figures. */
static km_status check_questions(const km_design_study_def *def, km_error *error) {
  int figures = 0;
  if (def->question_count < 1 || def->question_count > KM_MAX_DESIGN_QUESTIONS || !def->questions)
    return km_fail(error, KM_USAGE, "ask: found %d questions; expected 1 to %d", def->question_count,
                   KM_MAX_DESIGN_QUESTIONS);
  for (int q = 0; q < def->question_count; ++q) {
    const km_design_question *question = &def->questions[q];
    if (!question->name || !*question->name || (!def->function && !question->kind))
      return km_fail(error, KM_USAGE, "ask[%d]: expected a name and a kind of question", q);
    for (int k = 0; k < q; ++k)
      if (strcmp(def->questions[k].name, question->name) == 0)
        return km_fail(error, KM_USAGE, "ask: two questions are called \"%.80s\"", question->name);
    figures += question->figure_count;
    if (figures > KM_MAX_DESIGN_FIGURES)
      return km_fail(error, KM_USAGE, "ask: more than %d figures", KM_MAX_DESIGN_FIGURES);
    for (int f = 0; f < question->figure_count; ++f) {
      km_status status = check_figure(question, &question->figures[f], error);
      if (status)
        return status;
    }
  }
  if (def->function && (def->question_count != 1 || def->questions[0].kind || def->questions[0].band_count))
    return km_fail(error, KM_USAGE, "a function answers one question without kind and bands");
  return KM_OK;
}

/* Checks that figures have different names. */
static km_status check_names(const km_design_study_def *def, km_error *error) {
  int index = 0;
  for (int q = 0; q < def->question_count; ++q)
    for (int f = 0; f < def->questions[q].figure_count; ++f, ++index)
      if (km_design_find_figure(def, def->questions[q].figures[f].name) != index)
        return km_fail(error, KM_USAGE, "ask: two figures are called \"%.80s\"", def->questions[q].figures[f].name);
  return KM_OK;
}

km_status km_design_check(const km_design_study_def *def, km_error *error) {
  int ways = (def->variant_count > 0) + (def->axis_count > 0) + (def->sample != NULL) + (def->optimise != NULL);
  km_status status = KM_OK;
  if (ways != 1)
    return km_fail(error, KM_USAGE, "found %d of variants, grid, sample and optimise; expected just one", ways);
  if (!def->function && !def->model && !def->bytes)
    return km_fail(error, KM_USAGE, "model: expected a file");
  status = check_parameters(def, error);
  if (!status)
    status = check_questions(def, error);
  if (!status)
    status = check_names(def, error);
  if (!status)
    status = check_variants(def, error);
  if (!status)
    status = check_axes(def, error);
  if (!status && def->sample)
    status = check_sample(def, def->sample, error);
  if (!status && def->optimise)
    status = check_optimise(def, def->optimise, error);
  return status;
}
