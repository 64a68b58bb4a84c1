/* Actuators against loads: Y_Aᵀ f_A = −Yᵀ τ, block by block. */
#include "linalg/partition.h"
#include "local/tangent_cone.h"
#include "statics/statics.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

bool km_actuator_workspace_reserve(km_statics *st) {
  km_statics_workspace *w = st->work;
  for (int i = 0; i < w->block_count && !w->arena.failed; ++i) {
    km_actuator_workspace *h = &w->holding[i];
    h->actuator = KM_ARENA_NEW(&w->arena, int, (size_t)st->actuator_count);
    for (int a = 0; a < st->actuator_count && !w->arena.failed; ++a)
      if (w->part[a] == i)
        h->actuator[h->count++] = a;
  }
  return !w->arena.failed;
}

/* The part of a matrix or vector that a block of so many freedoms needs now. */
static gsl_matrix top(const gsl_matrix *a, int rows, int columns) {
  return (gsl_matrix){.size1 = (size_t)rows, .size2 = (size_t)columns, .tda = a->tda, .data = a->data};
}
static gsl_vector first(const gsl_vector *a, int size) {
  return (gsl_vector){.size = (size_t)size, .stride = 1, .data = a->data};
}

/* Elements, without the call that GSL makes of each. */
static double *entry(const gsl_matrix *a, size_t row, size_t column) {
  return a->data + row * a->tda + column;
}

/* Adds the motion Z x as a direction. */
static void add_direction(const km_mechanism *m, const km_actuator_workspace *h, const double *x, bool falls,
                          km_statics *st) {
  double *rates = km_direction_begin(m, falls, st);
  for (int j = 0; j < h->columns && rates; ++j)
    for (int k = 0; k < h->freedom; ++k)
      rates[h->coordinate[j]] += h->Z[(size_t)k * (size_t)h->columns + (size_t)j] * x[k] / m->scale[h->coordinate[j]];
  if (rates)
    km_direction_end(m, h, rates);
}

/* The same for a joint in no loop. */
static void add_joint(const km_mechanism *m, int coordinate, double sense, bool falls, km_statics *st) {
  double *rates = km_direction_begin(m, falls, st);
  if (rates)
    rates[coordinate] = sense * m->unit[coordinate];
}

/* The loads g = Yᵀτ of the free motions into h->load; returns what rounding can make of them. */
static double loads_on(const km_mechanism *m, const km_actuator_workspace *h, const km_statics_workspace *w,
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

/* How far an actuator moves, scaled, in the motion z of D · range(N). */
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

/* Z_A, a row an actuator, scaled: f_A = D F makes Z_Aᵀ F = −g. Of an actuator that stands rounding is left, which near a pole of
 * the others would pass for a motion. */
static void fill(const km_mechanism *m, const km_statics *st, const km_actuator_workspace *h, gsl_matrix *U) {
  static const double stands = 1e-14;
  for (size_t a = 0; a < U->size1; ++a)
    for (size_t k = 0; k < U->size2; ++k) {
      double rate = a < (size_t)h->count ? scaled_rate(m, st, h, h->actuator[a], h->Z + k * (size_t)h->columns) : 0.0;
      *entry(U, a, k) = fabs(rate) > stands ? rate : 0.0;
    }
}

/* Motions out of reach: if loads act on them, the one in which they fall, then others at right angles to it. Returns
 * whether nothing falls. */
static bool unreached(const km_mechanism *m, const km_actuator_workspace *h, km_statics *st) {
  int freedom = h->freedom, rank = h->rank;
  double size = 0.0, *basis = h->basis;
  int kept = 0;
  for (int i = rank; i < freedom; ++i)
    size = hypot(size, h->load->data[i]);
  bool falls = size > h->noise;
  for (int i = falls ? rank - 1 : rank; i < freedom && kept < freedom - rank; ++i) {
    if (st->direction_count >= KM_MAX_DIRECTIONS) { /* the others are counted */
      st->direction_count += freedom - rank - kept;
      break;
    }
    double *x = basis + (size_t)kept * (size_t)freedom;
    memset(x, 0, (size_t)freedom * sizeof *x);
    for (int k = 0; k < freedom; ++k) {
      if (i >= rank)
        x[k] = *entry(h->V, (size_t)k, (size_t)i);
      for (int n = rank; n < freedom && i < rank; ++n)
        x[k] += *entry(h->V, (size_t)k, (size_t)n) * h->load->data[n] / size;
    }
    if (km_orthonormalise(basis, kept, freedom, x)) {
      add_direction(m, h, x, i < rank, st);
      ++kept;
    }
  }
  return !falls;
}

static int count_freedom(const km_state *s, const km_actuator_workspace *h) {
  int freedom = h->alone_count;
  for (int i = 0; i < h->part_count; ++i)
    freedom += km_partition_freedom(&s->partition[h->part[i]]);
  return freedom;
}

/* Z of the block: that of its only substructure, or those of all, side by side, and 1 for a joint in no loop. */
static void gather(const km_mechanism *m, const km_state *s, km_actuator_workspace *h) {
  if (!h->gathers) {
    h->Z = km_state_basis(s, h->part[0]);
    h->freedom = km_partition_freedom(&s->partition[h->part[0]]);
    return;
  }
  h->Z = h->gathered;
  h->freedom = 0;
  if (!h->gathered) /* nothing is free */
    return;
  memset(h->gathered, 0, (size_t)h->columns * (size_t)h->capacity * sizeof *h->gathered);
  int column = 0;
  for (int i = 0; i < h->part_count; ++i) {
    int columns = m->substructures[h->part[i]].columns, freedom = km_partition_freedom(&s->partition[h->part[i]]);
    const double *Z = km_state_basis(s, h->part[i]);
    for (int k = 0; k < freedom; ++k)
      memcpy(h->gathered + (size_t)(h->freedom + k) * (size_t)h->columns + column, Z + (size_t)k * (size_t)columns,
             (size_t)columns * sizeof *Z);
    h->freedom += freedom;
    column += columns;
  }
  for (int i = 0; i < h->alone_count; ++i)
    h->gathered[(size_t)h->freedom++ * (size_t)h->columns + (size_t)column++] = 1.0;
}

static bool push_joints(const km_statics *st, const km_actuator_workspace *h) {
  bool all = true;
  for (int a = 0; a < h->count; ++a)
    all = all && st->actuators[h->actuator[a]].kind == KM_PORT_JOINT;
  return all;
}

/* U S Vᵀ of the actuators' rows, in their place. */
static void decompose(const km_statics *st, const km_actuator_workspace *h, gsl_matrix *U, gsl_matrix *V,
                      gsl_vector *S) {
  bool many = U->size2 > KM_MANY_VECTORS, wide = (size_t)h->count < U->size2;
  if (many && (wide ? km_decompose_wide(U, V, S, h->count) : push_joints(st, h) && km_decompose_straight(U, V, S)))
    return;
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

static void hold_block(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_actuator_workspace *h = &st->work->holding[index];
  if (km_actuator_forces_solve_columns(m, s, index, st))
    return;
  if (!km_actuator_workspace_fit(h, count_freedom(s, h), &st->work->arena)) {
    for (int a = 0; a < h->count; ++a)
      st->actuator_forces[h->actuator[a]] = nan("");
    h->freedom = h->rank = 0;
    st->held = false;
    return;
  }
  gather(m, s, h);
  int freedom = h->freedom, rank = 0;
  h->rank = 0;
  if (freedom == 0)
    return; /* nothing moves: the actuators have nothing to do */
  gsl_matrix U = top(h->U, h->count > freedom ? h->count : freedom, freedom), V = top(h->V, freedom, freedom);
  gsl_vector S = first(h->S, freedom), g = first(h->answer, freedom), load = first(h->load, freedom);
  double noise = loads_on(m, h, st->work, &g);
  fill(m, st, h, &U);
  decompose(st, h, &U, &V, &S);
  for (size_t i = 0; i < load.size; ++i) { /* Vᵀ g */
    load.data[i] = 0.0;
    for (size_t k = 0; k < g.size; ++k)
      load.data[i] += *entry(&V, k, i) * g.data[k];
  }
  while (rank < freedom && S.data[rank] > km_out_of_reach)
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
  bool holds = unreached(m, h, st);
  for (int a = 0; a < h->count && !holds; ++a)
    st->actuator_forces[h->actuator[a]] = nan("");
  st->held = st->held && holds;
}

/* The force against the load of a joint in no loop. A point that stands still in its direction holds nothing. */
static double hold_alone(const km_mechanism *m, km_statics *st, int actuator) {
  const km_statics_workspace *w = st->work;
  int c = w->alone[actuator];
  if (!w->row[actuator])
    return 0.0 - w->tau[c];
  double rate = w->row[actuator][c];
  bool loaded = fabs(w->tau[c]) > w->least_load[c];
  if (fabs(rate) * km_actuator_scale(m, st, actuator) > km_out_of_reach * m->scale[c])
    return 0.0 - w->tau[c] / rate;
  add_joint(m, c, loaded && w->tau[c] < 0.0 ? -1.0 : 1.0, loaded, st);
  st->held = st->held && !loaded;
  return loaded ? nan("") : 0.0;
}

void km_actuator_forces_solve(const km_mechanism *m, const km_state *s, km_statics *st) {
  const km_statics_workspace *w = st->work;
  st->held = true;
  st->redundant = false;
  st->direction_count = 0;
  for (int a = 0; a < st->actuator_count; ++a)
    st->actuator_forces[a] = w->alone[a] >= 0 ? hold_alone(m, st, a) : 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->substructure_of[c] >= 0 || m->held[c] || w->actuated[c])
      continue;
    bool falls = fabs(w->tau[c]) > w->least_load[c];
    add_joint(m, c, falls && w->tau[c] < 0.0 ? -1.0 : 1.0, falls, st);
    st->held = st->held && !falls;
  }
  for (int i = 0; i < w->block_count; ++i)
    hold_block(m, s, i, st);
}
