/* Forces of actuators against loads (theory 9.3): Y_Aᵀ f_A = -Yᵀ τ, block by block.
 *
 *   Z_A = U S Vᵀ,  f_A = D_A F,  F = -U S⁻¹ Vᵀ g,  g = Zᵀ D⁻¹ τ;   σ < 1e-9: motion out of reach */
#include "linalg/factor.h"
#include "local/local.h"
#include "statics/statics.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

bool km_actuator_workspace_reserve(km_statics *st) {
  km_statics_workspace *w = st->work;
  for (int i = 0; i < w->block_count && !w->arena.failed; ++i) {
    km_actuator_workspace *h = &w->blocks[i];
    h->actuator = KM_ARENA_NEW(&w->arena, int, (size_t)st->actuator_count);
    for (int a = 0; a < st->actuator_count && !w->arena.failed; ++a)
      if (w->part[a] == i)
        h->actuator[h->count++] = a;
  }
  return !w->arena.failed;
}

/* Leading part of a matrix or vector for the present number of freedoms. */
static gsl_matrix leading_block(const gsl_matrix *a, int rows, int columns) {
  return (gsl_matrix){.size1 = (size_t)rows, .size2 = (size_t)columns, .tda = a->tda, .data = a->data};
}
static gsl_vector leading_part(const gsl_vector *a, int size) {
  return (gsl_vector){.size = (size_t)size, .stride = 1, .data = a->data};
}

/* Returns an element's address, without the function call of GSL. */
static double *entry(const gsl_matrix *a, size_t row, size_t column) {
  return a->data + row * a->tda + column;
}

/* Adds the motion Z x as a direction. */
static void add_direction(const km_mechanism *m, const km_actuator_workspace *h, const double *x, bool is_loaded,
                          km_statics *st) {
  double *rates = km_direction_begin(m, is_loaded, st);
  for (int j = 0; j < h->columns && rates; ++j)
    for (int k = 0; k < h->size; ++k)
      rates[h->coordinate[j]] += h->Z[(size_t)k * (size_t)h->columns + (size_t)j] * x[k] / m->scale[h->coordinate[j]];
  if (rates)
    km_direction_end(m, h, rates);
}

/* Adds the motion of a tree joint as a direction. */
static void add_tree_joint_direction(const km_mechanism *m, int coordinate, double sign, bool is_loaded,
                                     km_statics *st) {
  double *rates = km_direction_begin(m, is_loaded, st);
  if (rates)
    rates[coordinate] = sign * m->unit[coordinate];
}

/* Computes the loads g = Yᵀτ of the free motions; returns their rounding. */
static double compute_loads(const km_mechanism *m, const km_actuator_workspace *h, const km_statics_workspace *w,
                            gsl_vector *g) {
  const double *z = h->Z;
  double noise = 0.0;
  for (size_t k = 0; k < g->size; ++k, z += h->columns) {
    double sum = 0.0, least = 0.0;
    for (int j = 0; j < h->columns; ++j) {
      int c = h->coordinate[j];
      sum += z[j] * w->tau[c] / m->scale[c];
      least += fabs(z[j]) * w->least_load[c] / m->scale[c];
    }
    g->data[k] = sum;
    noise = fmax(noise, least);
  }
  return noise;
}

/* Returns an actuator's scaled rate in the motion z of D · range(N). */
static double scaled_rate(const km_mechanism *m, const km_statics *st, const km_actuator_workspace *h, int actuator,
                          const double *z) {
  double sum = 0.0;
  if (st->actuators[actuator].kind == KM_PORT_JOINT)
    return z[st->work->column[actuator]];
  for (int j = 0; j < h->columns; ++j) {
    int c = h->coordinate[j];
    sum += st->work->row[actuator][c] * z[j] / m->scale[c];
  }
  return sum * km_actuator_scale(m, st, actuator);
}

void km_actuator_row(const km_mechanism *m, const km_statics *st, const km_actuator_workspace *h, int actuator,
                     double *row) {
  const double *rate = st->work->row[actuator], scale = km_actuator_scale(m, st, actuator);
  for (int j = 0; j < h->columns; ++j) {
    int c = h->coordinate[j];
    row[j] = rate ? scale * rate[c] / m->scale[c] : j == st->work->column[actuator];
  }
}

/* Fills Z_A, one scaled row per actuator: f_A = D F gives Z_Aᵀ F = −g. Rates at rounding level are 0, since near a
 * pole of the others they would count as motions. */
static void fill_actuator_rows(const km_mechanism *m, const km_statics *st, const km_actuator_workspace *h,
                               gsl_matrix *U) {
  for (size_t a = 0; a < U->size1; ++a)
    for (size_t k = 0; k < U->size2; ++k) {
      double rate = a < (size_t)h->count ? scaled_rate(m, st, h, h->actuator[a], h->Z + k * (size_t)h->columns) : 0.0;
      *entry(U, a, k) = fabs(rate) > km_sum_rounding ? rate : 0.0;
    }
}

/* Adds the motions out of reach: first the one in which the loads move the mechanism, then others orthogonal to it.
 * Returns true if no load acts on them. */
static bool add_unreached_motions(const km_mechanism *m, const km_actuator_workspace *h, km_statics *st) {
  int size = h->size, rank = h->rank, unreached = h->freedom - rank, count = 0;
  double load = 0.0, *basis = h->basis;
  for (int i = rank; i < size; ++i)
    load = hypot(load, h->load->data[i]);
  bool is_loaded = load > h->noise;
  for (int i = is_loaded ? rank - 1 : rank; i < size && count < unreached && st->direction_count < KM_MAX_DIRECTIONS;
       ++i) {
    double *x = basis + (size_t)count * (size_t)size;
    memset(x, 0, (size_t)size * sizeof *x);
    for (int k = 0; k < size; ++k) {
      if (i >= rank)
        x[k] = *entry(h->V, (size_t)k, (size_t)i);
      for (int n = rank; n < size && i < rank; ++n)
        x[k] += *entry(h->V, (size_t)k, (size_t)n) * h->load->data[n] / load;
    }
    if (km_orthonormalise(basis, count, size, x) > KM_INDEPENDENT) {
      add_direction(m, h, x, i < rank, st);
      ++count;
    }
  }
  st->direction_count += unreached - count; /* the others are counted only */
  return !is_loaded;
}

static int count_freedom(const km_state *s, const km_actuator_workspace *h) {
  int freedom = h->tree_joint_count;
  for (int i = 0; i < h->part_count; ++i)
    freedom += km_factor_freedom(s->factor[h->part[i]]);
  return freedom;
}

/* Block-diagonal basis of all parts of the block, 1 for a tree joint. */
static void compose_basis(const km_mechanism *m, const km_state *s, km_actuator_workspace *h) {
  int column = 0, size = 0;
  if (h->size > 0)
    memset(h->own_Z, 0, (size_t)h->columns * (size_t)h->size * sizeof *h->own_Z);
  for (int i = 0; i < h->part_count; ++i) {
    int columns = m->substructures[h->part[i]].columns, freedom = km_factor_freedom(s->factor[h->part[i]]);
    const double *Z = km_state_basis(s, h->part[i]);
    for (int k = 0; k < freedom; ++k)
      memcpy(h->own_Z + (size_t)(size + k) * (size_t)h->columns + column, Z + (size_t)k * (size_t)columns,
             (size_t)columns * sizeof *Z);
    size += freedom;
    column += columns;
  }
  for (int i = 0; i < h->tree_joint_count; ++i)
    h->own_Z[(size_t)size++ * (size_t)h->columns + (size_t)column++] = 1.0;
}

/* Sets Z: the basis of the only substructure, or of all parts, or the vectors that the balance needs. False without
 * memory. */
static bool set_basis(const km_mechanism *m, const km_state *s, km_statics *st, km_actuator_workspace *h) {
  h->freedom = count_freedom(s, h);
  h->size = km_actuator_subspace_size(h, s, h->freedom);
  if (!km_actuator_workspace_fit(h, h->size, &st->work->arena))
    return false;
  h->Z = h->own_Z;
  if (h->size < h->freedom)
    return km_actuator_subspace_compute(m, s, st, h);
  if (h->is_composed)
    compose_basis(m, s, h);
  else
    h->Z = km_state_basis(s, h->part[0]);
  return true;
}

/* True if every free coordinate has an actuator: they hold everything, with the minimum-norm forces f̄. */
static bool are_all_actuated(const km_state *s, const km_statics *st, const km_actuator_workspace *h) {
  int joints = 0, free = h->columns;
  for (int a = 0; a < h->count; ++a)
    joints += st->actuators[h->actuator[a]].kind == KM_PORT_JOINT;
  for (int i = 0; i < h->part_count; ++i)
    free -= km_factor_locked_count(s->factor[h->part[i]]);
  return joints == free && h->count == free;
}

/* Copies the minimum-norm forces. */
static void copy_minimum_norm(const km_state *s, km_actuator_workspace *h, km_statics *st) {
  for (int a = 0; a < h->count; ++a)
    st->actuator_forces[h->actuator[a]] = st->least_norm[st->actuators[h->actuator[a]].coordinate];
  h->freedom = h->rank = count_freedom(s, h);
  st->redundant = st->redundant || h->count > h->rank;
}

/* Computes U S Vᵀ of the actuators' rows in place. The rows of all coordinates are those of Z: S = V = 1. */
static void decompose(bool are_all_actuated, gsl_matrix *U, gsl_matrix *V, gsl_vector *S) {
  if (are_all_actuated) {
    gsl_matrix_set_identity(V);
    gsl_vector_set_all(S, 1.0);
    return;
  }
  if (U->size2 > 1) {
    gsl_linalg_SV_decomp_jacobi(U, V, S);
    return;
  }
  double square = 0.0;
  for (size_t a = 0; a < U->size1; ++a)
    square += *entry(U, a, 0) * *entry(U, a, 0);
  S->data[0] = sqrt(square);
  *entry(V, 0, 0) = 1.0;
  for (size_t a = 0; a < U->size1; ++a)
    *entry(U, a, 0) /= square > 0.0 ? S->data[0] : 1.0;
}

static void solve_block(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_actuator_workspace *h = &st->work->blocks[index];
  bool many = count_freedom(s, h) > KM_MANY_VECTORS, all_actuated = many && are_all_actuated(s, st, h);
  if (all_actuated && !st->work->keeps_factors) {
    copy_minimum_norm(s, h, st);
    return;
  }
  if (!set_basis(m, s, st, h)) {
    for (int a = 0; a < h->count; ++a)
      st->actuator_forces[h->actuator[a]] = nan("");
    h->freedom = h->rank = 0;
    st->held = false;
    return;
  }
  int size = h->size, rank = 0;
  h->rank = 0;
  if (size == 0)
    return; /* nothing moves: all forces are 0 */
  gsl_matrix U = leading_block(h->U, h->count > size ? h->count : size, size), V = leading_block(h->V, size, size);
  gsl_vector S = leading_part(h->S, size), g = leading_part(h->answer, size), load = leading_part(h->load, size);
  double noise = compute_loads(m, h, st->work, &g);
  fill_actuator_rows(m, st, h, &U);
  decompose(all_actuated, &U, &V, &S);
  for (size_t i = 0; i < load.size; ++i) { /* Vᵀ g */
    load.data[i] = 0.0;
    for (size_t k = 0; k < g.size; ++k)
      load.data[i] += *entry(&V, k, i) * g.data[k];
  }
  while (rank < size && S.data[rank] > km_relative_zero)
    ++rank;
  h->rank = rank;
  h->noise = noise;
  st->redundant = st->redundant || h->count > rank;
  for (int a = 0; a < h->count; ++a) {
    int actuator = h->actuator[a];
    double F = 0.0;
    for (size_t i = 0; i < (size_t)rank; ++i)
      F -= *entry(&U, (size_t)a, i) * load.data[i] / S.data[i];
    st->actuator_forces[actuator] = F * km_actuator_scale(m, st, actuator);
  }
  bool holds = add_unreached_motions(m, h, st);
  for (int a = 0; a < h->count && !holds; ++a)
    st->actuator_forces[h->actuator[a]] = nan("");
  st->held = st->held && holds;
}

/* Returns the force that holds a single tree joint. A point at rest in its direction holds nothing. */
static double solve_tree_joint(const km_mechanism *m, km_statics *st, int actuator) {
  const km_statics_workspace *w = st->work;
  int c = w->tree_joint[actuator];
  w->tree_load[actuator] = w->tau[c];
  if (!w->row[actuator])
    return 0.0 - w->tau[c];
  double rate = w->row[actuator][c];
  bool loaded = fabs(w->tau[c]) > w->least_load[c];
  if (fabs(rate) * km_actuator_scale(m, st, actuator) > km_relative_zero * m->scale[c])
    return 0.0 - w->tau[c] / rate;
  add_tree_joint_direction(m, c, loaded && w->tau[c] < 0.0 ? -1.0 : 1.0, loaded, st);
  st->held = st->held && !loaded;
  return loaded ? nan("") : 0.0;
}

void km_actuator_forces_solve(const km_mechanism *m, const km_state *s, km_statics *st) {
  const km_statics_workspace *w = st->work;
  st->held = true;
  st->redundant = false;
  st->direction_count = 0;
  for (int a = 0; a < st->actuator_count; ++a)
    st->actuator_forces[a] = w->tree_joint[a] >= 0 ? solve_tree_joint(m, st, a) : 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->substructure_of[c] >= 0 || m->held[c] || w->actuated[c])
      continue;
    bool is_loaded = fabs(w->tau[c]) > w->least_load[c];
    add_tree_joint_direction(m, c, is_loaded && w->tau[c] < 0.0 ? -1.0 : 1.0, is_loaded, st);
    st->held = st->held && !is_loaded;
  }
  for (int i = 0; i < w->block_count; ++i)
    solve_block(m, s, i, st);
}
