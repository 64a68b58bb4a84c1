/* Diagnosis of a configuration: finite mobility, passive freedoms, redundant constraints and their remedies. */
#include "base/arguments.h"
#include "mobility/finite_mobility.h"
#include "mobility/remedies/remedy_set.h"

km_status km_diagnosis_find(const km_mechanism *m, km_state *s, km_progress progress, void *context, km_diagnosis *out,
                            km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_diagnosis){0};
  km_status status = km_passive_freedoms_find(m, s, progress, context, &out->passive, error);
  if (!status)
    status = km_finite_mobility_find_with(m, s, &out->passive, progress, context, &out->finite, error);
  if (!status)
    status = km_redundancies_find(m, s, progress, context, &out->redundancies, error);
  if (!status && out->redundancies.count)
    status = km_remedy_set_find_with(m, s, out->finite.undecided ? -1 : out->finite.mobility, progress, context,
                                     &out->remedies, error);
  return status;
}

void km_diagnosis_free(km_diagnosis *d) {
  if (!d)
    return;
  km_finite_mobility_free(&d->finite);
  km_redundancies_free(&d->redundancies);
  km_passive_freedoms_free(&d->passive);
  km_remedy_set_free(&d->remedies);
}
