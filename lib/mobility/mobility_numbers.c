/* Mobility counts, instantaneous mobility and mobility numbers (theory 6.1 to 6.3).
 *
 *   mobility = Σ (columns - rank) + free coordinates outside loops;   m_j = Σ_k Z_jk² */
#include "mobility/mobility_numbers.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

static void write_mobility_numbers(const km_mechanism *m, km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  km_state_mobility_numbers(m, s, index, s->work);
  for (int k = 0; k < sub->columns; ++k)
    s->mobility_number[coordinate[k]] = s->work[k];
}

void km_motions_update(const km_mechanism *m, km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  /* computed from the row space, independent of B */
  bool uses_row_space = km_factor_avoids_basis(p);
  if (s->pivot_driver[index] == KM_NEVER || (!uses_row_space && !(km_factor_get_evidence(p).max_b <= km_max_good_b))) {
    km_search_pivots(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, sub, km_loops_residual(m, s, sub)));
  }
  km_state_mark_mobility_known(s, index);
}

void km_numbers_update(const km_mechanism *m, km_state *s, int index) {
  km_motions_update(m, s, index);
  write_mobility_numbers(m, s, index);
}

static void count_kutzbach(const km_mechanism *m, km_mobility *out) {
  const km_model *model = m->model;
  int freedom = 0, lambda = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    freedom += !m->held[c];
  for (int l = 0; l < m->topology.loop_count; ++l)
    lambda += m->loops[l].lambda;
  out->kutzbach = 6 * (model->body_count - 1 - model->joint_count) + freedom - model->coupling_count;
  out->kutzbach_planar = 3 * (model->body_count - 1 - model->joint_count) + freedom - model->coupling_count;
  out->kutzbach_extended = freedom - lambda - model->coupling_count;
}

/* True if the coordinate is free and outside loops and couplings. */
static bool is_free_tree_coordinate(const km_mechanism *m, const km_state *s, int coordinate) {
  return m->substructure_of[coordinate] < 0 && !km_state_is_fixed(s, coordinate);
}

void km_ranks_update(const km_mechanism *m, km_state *s, km_factor_basis basis, km_mobility *out) {
  const km_pivoting pivoting = {.driver = KM_NO_DRIVER, .basis = basis};
  *out = (km_mobility){0};
  count_kutzbach(m, out);
  out->redundant_constraints = 6 * m->topology.loop_count + m->model->coupling_count;
  for (int c = 0; c < m->coordinate_count; ++c)
    out->mobility += is_free_tree_coordinate(m, s, c);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    km_loops_update(m, s, sub);
    double residual = km_loops_residual(m, s, sub);
    km_search_pivots_by(m, s, i, &pivoting, km_rank_tolerance(m, sub, residual));
    out->residual = fmax(out->residual, residual);
    out->mobility += km_factor_freedom(s->factor[i]);
    out->redundant_constraints -= km_factor_rank(s->factor[i]);
  }
}

km_status km_mobility_check_memory(const km_mechanism *m, km_state *s) {
  km_status status = KM_OK;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (km_factor_has_failed(s->factor[i])) {
      km_state_invalidate_pivots(s, i);
      status = KM_MEMORY;
    }
  if (status)
    s->arena.failed = false; /* arrays that grow are allocated again; all others exist since the state's creation */
  return status;
}

km_status km_mobility_compute(const km_mechanism *m, km_state *s, km_mobility *out) {
  static const km_mobility unknown = {.residual = (double)NAN};
  if (!out)
    return KM_USAGE;
  *out = unknown;
  if (!km_state_belongs_to(m, s))
    return KM_USAGE;
  km_ranks_update(m, s, KM_BASIS_SHORT, out);
  for (int c = 0; c < m->coordinate_count; ++c)
    s->mobility_number[c] = is_free_tree_coordinate(m, s, c) ? 1.0 : 0.0;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    write_mobility_numbers(m, s, i);
  km_status status = km_mobility_check_memory(m, s);
  if (status)
    *out = unknown;
  return status;
}

int km_substructure_count(const km_mechanism *m) {
  if (!m)
    return 0;
  return m->topology.substructure_count;
}

void km_substructure_evidence(const km_mechanism *m, const km_state *s, int index, km_substructure_mobility *out) {
  if (!out)
    return;
  *out = (km_substructure_mobility){0};
  if (!km_state_belongs_to(m, s) || index < 0 || index >= m->topology.substructure_count)
    return;
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  const km_topology *t = &m->topology;
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  double scale = evidence.scale > 0.0 ? evidence.scale : 1.0;
  *out = (km_substructure_mobility){.joints = t->joint_start[index + 1] - t->joint_start[index],
                                    .loops = sub->loop_count,
                                    .coordinates = sub->columns,
                                    .rank = km_factor_rank(p),
                                    .mobility = km_factor_freedom(p),
                                    .last_pivot = evidence.last_pivot / scale,
                                    .first_dropped = evidence.first_dropped / scale,
                                    .tolerance = km_rank_tolerance(m, sub, 0.0)};
}

/* Squared cosine between the coordinate and the null space, 0 … 1. */
double km_mobility_number(const km_state *s, int coordinate) {
  if (!s || coordinate < 0 || coordinate >= s->mechanism->coordinate_count)
    return nan("");
  return s->mobility_number[coordinate];
}
