/* Motions of a block with many freedoms that its balance needs (theory 9.3).
 *
 *   Z' = orth P [Aᵀ, D⁻¹ τ, g₁, g₂ …],   P = Z Zᵀ by sparse equations, A the actuators' scaled rows, g random
 *
 * A Z' has the singular values of A Z, and Z' Z'ᵀ D⁻¹ τ = P D⁻¹ τ. All other motions are out of reach and without load;
 * KM_MAX_DIRECTIONS of them are in Z', for the report. Random vectors overlap little in twice as many freedoms. Along
 * null vectors of a chain, each of which overlaps the next, rounding would grow exponentially. */
#include "base/number/vectors.h"
#include "base/random.h"
#include "local/local.h"
#include "statics/statics.h"

#include <string.h>

/* Appends the part of x that is orthogonal to the vectors of Z', if it is longer than `shortest`. x is overwritten. */
static void append(km_actuator_workspace *h, double shortest, double *x) {
  if (h->size < h->capacity && km_orthonormalise(h->own_Z, h->size, h->columns, x) > shortest) {
    km_orthonormalise(h->own_Z, h->size, h->columns, x);
    memcpy(h->own_Z + (size_t)h->size++ * (size_t)h->columns, x, (size_t)h->columns * sizeof *x);
  }
}

/* Fills x with the actuators' scaled rows, then D⁻¹ τ as a unit vector. */
static void fill_rows(const km_mechanism *m, const km_statics *st, const km_actuator_workspace *h, double *x) {
  for (int a = 0; a < h->count; ++a, x += h->columns)
    km_actuator_row(m, st, h, h->actuator[a], x);
  for (int j = 0; j < h->columns; ++j)
    x[j] = st->work->tau[h->coordinate[j]] / m->scale[h->coordinate[j]];
  double length = km_norm(x, h->columns);
  for (int j = 0; j < h->columns && length > 0.0; ++j)
    x[j] /= length;
}

int km_actuator_subspace_size(const km_actuator_workspace *h, const km_state *s, int freedom) {
  int needed = h->count + 1 + KM_MAX_DIRECTIONS;
  bool is_reduced = !h->is_composed && km_factor_avoids_basis(s->factor[h->part[0]]) && 2 * needed <= freedom;
  return is_reduced ? needed : freedom;
}

bool km_actuator_subspace_compute(const km_mechanism *m, const km_state *s, const km_statics *st,
                                  km_actuator_workspace *h) {
  const km_substructure *sub = &m->substructures[h->part[0]];
  const km_factor *p = s->factor[h->part[0]];
  size_t n = (size_t)h->columns;
  int rows = h->count + 1, vectors = rows + KM_MAX_DIRECTIONS;
  double *x = KM_NEW(double, n *(size_t)vectors);
  uint64_t random = 1;
  h->size = 0;
  if (x)
    fill_rows(m, st, h, x);
  for (size_t i = n * (size_t)rows; i < n * (size_t)vectors && x; ++i)
    x[i] = km_uniform(&random);
  bool is_ok = x && km_factor_project_null_space(p, s->jacobian + sub->matrix_start, x, vectors);
  for (int i = 0; i < vectors && is_ok; ++i)
    append(h, i < h->count ? km_relative_zero : i < rows ? km_load_rounding : KM_INDEPENDENT, x + (size_t)i * n);
  km_free(x);
  return is_ok;
}
