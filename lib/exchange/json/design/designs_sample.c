/* Samples and optimisations of a study. */
#include "exchange/json/design/designs_reader.h"

#include <math.h>
#include <string.h>

/* [a, b] of a member. */
static void pair(const km_value *object, const char *key, double *a, double *b) {
  const km_value *list = km_value_get(object, key);
  *a = list ? list->first->number : 0.0;
  *b = list ? list->last->number : 0.0;
}

static void read_spread(km_designs_reader *d, const km_value *v, const km_place *place, km_design_spread *out) {
  bool uniform = km_value_get(v, "uniform") != NULL, normal = km_value_get(v, "normal") != NULL;
  bool within = km_value_get(v, "within") != NULL;
  out->parameter = km_designs_parameter(d, v->key);
  if (uniform == normal || (within && !normal)) {
    km_designs_error(d, place, "expected either \"uniform\", or \"normal\", perhaps with \"within\"");
    return;
  }
  out->distribution = uniform ? KM_UNIFORM : within ? KM_TRUNCATED_NORMAL : KM_NORMAL;
  pair(v, uniform ? "uniform" : "within", &out->low, &out->high);
  pair(v, "normal", &out->mean, &out->deviation);
}

static unsigned long seed_of(km_designs_reader *d, const km_value *object, const km_place *place) {
  int seed = km_designs_whole(d, object, place, "seed", 1);
  km_place at = {place, "seed", 0};
  if (seed < 0)
    km_designs_error(d, &at, "expected a whole number of at least 0");
  return seed < 0 ? 0 : (unsigned long)seed;
}

static km_sampling method_of(km_designs_reader *d, const km_value *object, const km_place *place) {
  static const char *const words[] = {"sobol", "latin", "random"};
  const char *word = km_designs_text(object, "method");
  km_place at = {place, "method", 0};
  for (int m = 0; m < 3; ++m)
    if (!word || strcmp(word, words[m]) == 0)
      return (km_sampling)m;
  km_designs_error(d, &at, "expected sobol, latin or random");
  return KM_SAMPLING_SOBOL;
}

void km_designs_read_sample(km_designs_reader *d, const km_value *object) {
  km_place place = {NULL, "sample", 0}, inside = {&place, "parameters", 0};
  const km_value *map = km_value_get(object, "parameters"), *accuracy = km_value_get(object, "accuracy");
  const km_value *indices = km_value_get(object, "indices");
  km_design_sample *s = KM_ARENA_NEW(d->arena, km_design_sample, 1);
  km_design_spread *spreads = KM_ARENA_NEW(d->arena, km_design_spread, map ? map->count + 1 : 1);
  if (!spreads)
    return;
  d->def->sample = s;
  d->def->sample_file = km_designs_text(object, "csv");
  if (d->def->sample_file && (map || indices))
    km_designs_error(d, &place, "expected either \"csv\" or \"parameters\" with their spreads");
  *s = (km_design_sample){.method = d->def->sample_file ? KM_SAMPLING_LIST : method_of(d, object, &place),
                          .count = km_designs_whole(d, object, &place, "count", 0),
                          .seed = seed_of(d, object, &place),
                          .spreads = spreads,
                          .indices = indices && indices->number != 0.0};
  for (const km_value *v = map ? map->first : NULL; v; v = v->next) {
    km_place at = {&inside, v->key, 0};
    read_spread(d, v, &at, &spreads[s->spread_count++]);
  }
  if (accuracy) {
    s->accuracy_figure = km_designs_text(accuracy, "figure");
    s->accuracy = km_designs_number(accuracy, "half_width", 0.0);
  }
}

static void read_goals(km_designs_reader *d, const km_value *value, bool largest, km_design_optimise *out) {
  int count;
  const char *const *names = km_designs_texts(d, value, &count);
  for (int i = 0; i < count; ++i, ++out->goal_count)
    if (out->goal_count < 2)
      out->goals[out->goal_count] = (km_design_goal){names[i], largest};
}

void km_designs_read_optimise(km_designs_reader *d, const km_value *object) {
  km_place place = {NULL, "optimise", 0};
  const km_value *map = km_value_get(object, "variables");
  const char *algorithm = km_designs_text(object, "algorithm");
  km_design_optimise *o = KM_ARENA_NEW(d->arena, km_design_optimise, 1);
  km_design_variable *variables = KM_ARENA_NEW(d->arena, km_design_variable, map->count + 1);
  if (!variables)
    return;
  d->def->optimise = o;
  *o = (km_design_optimise){.variables = variables,
                            .algorithm = algorithm ? algorithm : "cobyla",
                            .evaluations = km_designs_whole(d, object, &place, "evaluations", 200),
                            .tolerance = km_designs_number(object, "tolerance", 1e-6),
                            .starts = km_designs_whole(d, object, &place, "starts", 1),
                            .seed = seed_of(d, object, &place)};
  for (const km_value *v = map->first; v; v = v->next)
    variables[o->variable_count++] =
        (km_design_variable){km_designs_parameter(d, v->key), km_designs_number(v, "low", 0.0),
                             km_designs_number(v, "high", 0.0), km_designs_number(v, "start", nan(""))};
  read_goals(d, km_value_get(object, "minimise"), false, o);
  read_goals(d, km_value_get(object, "maximise"), true, o);
}
