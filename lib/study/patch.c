/* Finds where a study's parameters go in a model that is read already, so that a design costs no reading. What the
 * reader takes over as it is, is found by reading the model with other values and comparing every number; the answer is
 * tried on designs that change everything at once. What doesn't come out bit for bit is left to the reader. */
#include "model/numbers.h"
#include "study/study.h"

#include <math.h>
#include <string.h>

enum { PROBES = 2, TRIALS = 4 };

typedef struct probe {
  km_model *model;
  km_model_numbers numbers;
} probe;

static void probe_close(probe *p) {
  km_model_numbers_free(&p->numbers);
  km_model_free(p->model);
}

/* False: such values are no model. */
static bool probe_open(const km_design_study *s, const double *values, probe *out) {
  *out = (probe){0};
  if (km_design_read_model(s, values, &out->model, NULL))
    return false;
  km_model_numbers_list(out->model, &out->numbers);
  return !out->numbers.failed;
}

/* Another value near the base one. Powers of 2 alone would hide a factor's rounding. */
static double moved(double base, int k) {
  static const double steps[PROBES + TRIALS] = {1.0 / 1021.0,  -1.0 / 769.0, 1.0 / 389.0,
                                                -1.0 / 1531.0, 1.0 / 2953.0, 1.0 / 613.0};
  double from = isnan(base) ? 0.0 : base;
  return from + steps[k] * (fabs(from) > 0.0 ? fabs(from) : 1.0);
}

static bool same_bits(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

/* The places that have the parameter's value, as it is, in every probe. False: something else changes too. */
static bool find_places(const probe *base, const probe *probes, const double *values, km_arena *arena,
                        km_patch_places *out) {
  size_t count = base->numbers.count;
  out->places = KM_ARENA_NEW(arena, int, count + 1);
  for (size_t i = 0; i < count && out->places; ++i) {
    bool changes = false, direct = true;
    for (int k = 0; k < PROBES; ++k) {
      double now = *probes[k].numbers.items[i].at;
      changes = changes || !same_bits(now, *base->numbers.items[i].at);
      direct = direct && same_bits(now, values[k]);
    }
    if (changes && (!direct || base->numbers.items[i].rule == KM_NUMBER_CHECKED))
      return false;
    if (changes)
      out->places[out->count++] = (int)i;
  }
  return out->places && out->count > 0;
}

static bool probe_parameter(km_design_study *s, const probe *base, int parameter) {
  double values[KM_MOST_DESIGN_PARAMETERS], tried[PROBES];
  probe probes[PROBES] = {{0}};
  bool good = true;
  for (int k = 0; k < PROBES && good; ++k) {
    km_design_clear(s, values);
    values[parameter] = tried[k] = moved(s->base[parameter], k);
    good = probe_open(s, values, &probes[k]) && probes[k].numbers.count == base->numbers.count;
  }
  good = good && find_places(base, probes, tried, &s->arena, &s->patch.parameters[parameter]);
  for (int k = 0; k < PROBES; ++k)
    probe_close(&probes[k]);
  return good;
}

/* Does patching give what the reader gives, where all parameters change at once? */
static bool trial(const km_design_study *s, probe *base, int k) {
  double values[KM_MOST_DESIGN_PARAMETERS];
  probe read;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    values[p] = moved(s->base[p], PROBES + (k + p) % TRIALS);
    for (int i = 0; i < s->patch.parameters[p].count; ++i)
      *base->numbers.items[s->patch.parameters[p].places[i]].at = values[p];
  }
  bool same = probe_open(s, values, &read) && read.numbers.count == base->numbers.count;
  for (size_t i = 0; i < base->numbers.count && same; ++i)
    same = same_bits(*read.numbers.items[i].at, *base->numbers.items[i].at);
  probe_close(&read);
  return same;
}

km_status km_patch_find(km_design_study *s, km_error *error) {
  int count = s->def->parameter_count;
  const char *paths[KM_MOST_DESIGN_PARAMETERS];
  bool plain[KM_MOST_DESIGN_PARAMETERS];
  double values[KM_MOST_DESIGN_PARAMETERS];
  probe base;
  for (int p = 0; p < count; ++p)
    paths[p] = s->def->parameters[p].path;
  km_status status = km_model_read_numbers(s->bytes, s->size, paths, count, s->base, plain, error);
  if (status)
    return status;
  s->patch.parameters = KM_ARENA_NEW(&s->arena, km_patch_places, (size_t)count + 1);
  km_design_clear(s, values);
  s->patch.works = s->patch.parameters && probe_open(s, values, &base);
  if (!s->patch.works)
    return s->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a study") : KM_OK;
  s->patch.number_count = base.numbers.count;
  for (int p = 0; p < count && s->patch.works; ++p)
    s->patch.works = plain[p] && probe_parameter(s, &base, p);
  for (int k = 0; k < TRIALS && s->patch.works; ++k)
    s->patch.works = trial(s, &base, k);
  probe_close(&base);
  return KM_OK;
}
