/* Finds where a study's parameters go in a model that is read already, so that a design costs no reading. What the
 * reader takes over as it is, is found by reading the model with other values and comparing every number; the answer is
 * tried on designs that change everything at once. What doesn't come out bit for bit is left to the reader. */
#include "model/model_numbers.h"
#include "study/design_study.h"

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

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

/* KM_MODEL …: such values are no model. */
static km_status probe_open(const km_design_study *s, const double *values, probe *out, km_error *error) {
  *out = (probe){0};
  km_status status = km_design_read_model(s, values, &out->model, error);
  if (status)
    return status;
  km_model_numbers_list(out->model, &out->numbers);
  return out->numbers.failed ? no_memory(error) : KM_OK;
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

/* s->patch.works tells what came out. */
static km_status probe_parameter(km_design_study *s, const probe *base, int parameter, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS], tried[PROBES];
  probe probes[PROBES] = {{0}};
  km_status status = KM_OK;
  bool alike = true;
  for (int k = 0; k < PROBES && !status; ++k) {
    km_design_clear(s, values);
    values[parameter] = tried[k] = moved(s->base[parameter], k);
    status = probe_open(s, values, &probes[k], error);
    alike = alike && !status && probes[k].numbers.count == base->numbers.count;
  }
  s->patch.works = alike && find_places(base, probes, tried, &s->arena, &s->patch.parameters[parameter]);
  for (int k = 0; k < PROBES; ++k)
    probe_close(&probes[k]);
  return status == KM_MEMORY || s->arena.failed ? no_memory(error) : KM_OK;
}

/* Does patching give what the reader gives, where all parameters change at once? */
static km_status trial(km_design_study *s, probe *base, int k, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  probe read;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    values[p] = moved(s->base[p], PROBES + (k + p) % TRIALS);
    for (int i = 0; i < s->patch.parameters[p].count; ++i)
      *base->numbers.items[s->patch.parameters[p].places[i]].at = values[p];
  }
  km_status status = probe_open(s, values, &read, error);
  bool same = !status && read.numbers.count == base->numbers.count;
  for (size_t i = 0; i < base->numbers.count && same; ++i)
    same = same_bits(*read.numbers.items[i].at, *base->numbers.items[i].at);
  probe_close(&read);
  s->patch.works = same;
  return status == KM_MEMORY ? status : KM_OK;
}

km_status km_patch_find(km_design_study *s, km_error *error) {
  int count = s->def->parameter_count;
  const char *paths[KM_MAX_DESIGN_PARAMETERS];
  bool plain[KM_MAX_DESIGN_PARAMETERS];
  double values[KM_MAX_DESIGN_PARAMETERS];
  probe base = {0};
  for (int p = 0; p < count; ++p)
    paths[p] = s->def->parameters[p].path;
  km_status status = km_model_read_numbers(s->bytes, s->size, paths, count, s->base, plain, error);
  if (status)
    return status;
  s->patch.parameters = KM_ARENA_NEW(&s->arena, km_patch_places, (size_t)count + 1);
  km_design_clear(s, values);
  status = s->patch.parameters ? probe_open(s, values, &base, error) : no_memory(error);
  s->patch.works = status == KM_OK;
  s->patch.number_count = base.numbers.count;
  for (int p = 0; p < count && s->patch.works && !status; ++p) {
    s->patch.works = plain[p];
    if (plain[p])
      status = probe_parameter(s, &base, p, error);
  }
  for (int k = 0; k < TRIALS && s->patch.works && !status; ++k)
    status = trial(s, &base, k, error);
  probe_close(&base);
  return status;
}
