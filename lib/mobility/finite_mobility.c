/* Finite mobility of a mechanism: the sum over its substructures (theory 6.4, 6.5). */
#include "mobility/finite_mobility.h"

#include "base/arguments.h"
#include "local/local.h"
#include "mobility/substructure_loop.h"

/* Data of the search over all substructures. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  const km_passive_freedoms *passive;
  km_finite_mobility *out;
} search;

static km_status search_substructure(void *self, int index, km_arena *arena, km_error *error) {
  const search *f = self;
  km_local *l = km_local_create(f->m, f->s, index, f->passive, 0.0, arena);
  (void)error;
  f->out->mobility += l ? km_local_find_motions(l, f->out) : 0;
  km_local_restore(l);
  km_local_free(l);
  return KM_OK;
}

km_status km_finite_mobility_find_with(const km_mechanism *m, km_state *s, const km_passive_freedoms *passive,
                                       km_progress progress, void *context, km_finite_mobility *out, km_error *error) {
  out->store = KM_NEW(double, (size_t)KM_MAX_FINITE_MOTIONS *(size_t)(m->coordinate_count + 1));
  if (!out->store)
    return km_fail(error, KM_MEMORY, "out of memory for the finite mobility");
  for (int c = 0; c < m->coordinate_count; ++c)
    out->mobility += m->substructure_of[c] < 0 && !m->held[c];
  search f = {m, s, passive, out};
  return km_each_substructure(m, search_substructure, &f, progress, context, "the finite mobility", error);
}

km_status km_finite_mobility_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                                  km_finite_mobility *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_finite_mobility){0};
  km_passive_freedoms passive;
  km_status status = km_passive_freedoms_find(m, s, NULL, NULL, &passive, error);
  if (!status)
    status = km_finite_mobility_find_with(m, s, &passive, progress, context, out, error);
  km_passive_freedoms_free(&passive);
  return status;
}

int km_finite_mobility_branches(const km_finite_mobility *finite) {
  double product = 1.0;
  for (int i = 0; finite && i < finite->motion_count; ++i) {
    int substructure = finite->motions[i].substructure, branches = 0;
    bool is_first = true;
    for (int k = 0; k < finite->motion_count; ++k) {
      bool counts = finite->motions[k].substructure == substructure && finite->motions[k].kind == KM_MOTION_BRANCH;
      is_first = is_first && !(counts && k < i);
      branches += counts;
    }
    product *= is_first && branches ? branches : 1;
  }
  return product < 1e6 ? (int)product : 1000000;
}

void km_finite_mobility_free(km_finite_mobility *mobility) {
  if (!mobility)
    return;
  km_free(mobility->store);
  *mobility = (km_finite_mobility){0};
}

const char *km_motion_kind_name(km_motion_kind kind) {
  static const char *const names[] = {"regular", "branch", "shaky", "undecided"};
  return (size_t)kind < sizeof names / sizeof *names ? names[kind] : "";
}
