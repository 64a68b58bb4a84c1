/* Finds the numbers of a compiled model that depend on a study's parameters, so that a design needs no reading of
 * the file (docs/theory.md 13.1). The model is read with other values of each parameter and all numbers are
 * compared; the result is tried on designs that change all parameters at once. Parameters whose patch isn't exact
 * to the bit are left to the reader. */
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

/* Reads a model with these values and lists its numbers. KM_MODEL: the values are invalid. */
static km_status probe_open(const km_design_study *s, const double *values, probe *out, km_error *error) {
  *out = (probe){0};
  km_status status = km_design_read_model(s, values, &out->model, error);
  if (status)
    return status;
  km_model_numbers_list(out->model, &out->numbers);
  return out->numbers.failed ? no_memory(error) : KM_OK;
}

/* Varied value near the base value, by ratios that aren't powers of 2, which would hide the rounding of a factor. */
static double varied(double base, int k) {
  static const double steps[PROBES + TRIALS] = {1.0 / 1021.0,  -1.0 / 769.0, 1.0 / 389.0,
                                                -1.0 / 1531.0, 1.0 / 2953.0, 1.0 / 613.0};
  double from = isnan(base) ? 0.0 : base;
  return from + steps[k] * (fabs(from) > 0.0 ? fabs(from) : 1.0);
}

static bool same_bits(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

/* Finds the numbers that equal the parameter's value in every variation. False: another number changes too. */
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

/* Finds the numbers of one parameter; s->patch.works is false if they can't be patched. */
static km_status probe_parameter(km_design_study *s, const probe *base, int parameter, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS], tried[PROBES];
  probe probes[PROBES] = {{0}};
  km_status status = KM_OK;
  bool is_same_count = true;
  for (int k = 0; k < PROBES && !status; ++k) {
    km_design_clear(s, values);
    values[parameter] = tried[k] = varied(s->base[parameter], k);
    status = probe_open(s, values, &probes[k], error);
    is_same_count = is_same_count && !status && probes[k].numbers.count == base->numbers.count;
  }
  s->patch.is_valid = is_same_count && find_places(base, probes, tried, &s->arena, &s->patch.parameters[parameter]);
  for (int k = 0; k < PROBES; ++k)
    probe_close(&probes[k]);
  return status == KM_MEMORY || s->arena.failed ? no_memory(error) : KM_OK;
}

/* Verifies that patching gives the reader's numbers when all parameters change at once. */
static km_status verify_patch(km_design_study *s, probe *base, int k, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  probe read;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    values[p] = varied(s->base[p], PROBES + (k + p) % TRIALS);
    for (int i = 0; i < s->patch.parameters[p].count; ++i)
      *base->numbers.items[s->patch.parameters[p].places[i]].at = values[p];
  }
  km_status status = probe_open(s, values, &read, error);
  bool same = !status && read.numbers.count == base->numbers.count;
  for (size_t i = 0; i < base->numbers.count && same; ++i)
    same = same_bits(*read.numbers.items[i].at, *base->numbers.items[i].at);
  probe_close(&read);
  s->patch.is_valid = same;
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
  s->patch.is_valid = status == KM_OK;
  s->patch.number_count = base.numbers.count;
  for (int p = 0; p < count && s->patch.is_valid && !status; ++p) {
    s->patch.is_valid = plain[p];
    if (plain[p])
      status = probe_parameter(s, &base, p, error);
  }
  for (int k = 0; k < TRIALS && s->patch.is_valid && !status; ++k)
    status = verify_patch(s, &base, k, error);
  probe_close(&base);
  return status;
}
