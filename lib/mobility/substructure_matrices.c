/* Public access to the matrices J, N and Z of substructures, and the basis of all free motions. */
#include "kmech/mobility.h"

#include "base/arguments.h"
#include "kinematics/state.h"

#include <string.h>

static const km_substructure *find_substructure(const km_mechanism *m, int index) {
  return m && index >= 0 && index < m->topology.substructure_count ? &m->substructures[index] : NULL;
}

int km_substructure_rows(const km_mechanism *m, int index) {
  const km_substructure *sub = find_substructure(m, index);
  return sub ? sub->rows : 0;
}

int km_substructure_coordinate(const km_mechanism *m, int index, int column) {
  const km_substructure *sub = find_substructure(m, index);
  return sub && column >= 0 && column < sub->columns ? m->column_coordinate[sub->column_start + column] : -1;
}

/* Factor from a column's scaled rate to the coordinate's rate: 1 for an angle, the substructure's size for a length. */
double km_substructure_unit(const km_mechanism *m, int index, int column) {
  int coordinate = km_substructure_coordinate(m, index, column);
  return coordinate >= 0 ? m->unit[coordinate] : nan("");
}

static km_status check_request(const km_mechanism *m, const km_state *s, int index, const double *out,
                               km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  if (!status)
    status = km_check_index(index, m->topology.substructure_count, "substructure", error);
  if (!status && !km_state_mobility_is_known(m, s))
    status = km_fail(error, KM_USAGE, "the mobility of the state isn't known; expected km_mobility_compute before");
  return status;
}

km_status km_substructure_jacobian(const km_mechanism *m, const km_state *s, int index, double *J, km_error *error) {
  km_status status = check_request(m, s, index, J, error);
  if (!status)
    km_state_jacobian_dense(s, &m->substructures[index], J);
  return status;
}

km_status km_substructure_null(const km_mechanism *m, const km_state *s, int index, double *N, km_error *error) {
  km_status status = check_request(m, s, index, N, error);
  if (status)
    return status;
  const km_factor *p = s->factor[index];
  for (int k = 0; k < km_factor_freedom(p); ++k)
    km_factor_null_vector(p, km_factor_column_order(p)[km_factor_rank(p) + k],
                          N + (size_t)k * (size_t)m->substructures[index].columns);
  return KM_OK;
}

km_status km_substructure_basis(const km_mechanism *m, const km_state *s, int index, double *Z, km_error *error) {
  km_status status = check_request(m, s, index, Z, error);
  const double *basis = status ? NULL : km_state_basis(s, index);
  size_t count = basis ? (size_t)km_factor_freedom(s->factor[index]) : 0;
  if (count > 0)
    memcpy(Z, basis, count * (size_t)m->substructures[index].columns * sizeof *Z);
  return status;
}

/* Appends the motions D⁻¹ Z of a substructure to the `count` present ones; returns the new number. */
static int append_motions(const km_mechanism *m, const km_state *s, int index, double *N, int count) {
  const km_substructure *sub = &m->substructures[index];
  const double *Z = km_state_basis(s, index);
  for (int k = 0; k < km_factor_freedom(s->factor[index]); ++k, ++count) {
    double *rates = N + (size_t)count * (size_t)m->coordinate_count;
    for (int j = 0; j < sub->columns; ++j) {
      int c = m->column_coordinate[sub->column_start + j];
      rates[c] = Z[(size_t)k * (size_t)sub->columns + (size_t)j] / m->scale[c];
    }
  }
  return count;
}

km_status km_motions_basis(const km_mechanism *m, const km_state *s, double *N, int *freedom, km_error *error) {
  if (freedom)
    *freedom = 0;
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(N && freedom, "place for the result", error);
  if (!status && !km_state_mobility_is_known(m, s))
    status = km_fail(error, KM_USAGE, "the mobility of the state isn't known; expected km_mobility_compute before");
  if (status)
    return status;
  size_t n = (size_t)m->coordinate_count;
  int count = 0;
  memset(N, 0, n * n * sizeof *N);
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->substructure_of[c] < 0 && !m->held[c])
      N[(size_t)count++ * n + (size_t)c] = 1.0;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    count = append_motions(m, s, i, N, count);
  *freedom = count;
  return KM_OK;
}
