/* Actuators' forces along a sweep as ratios n/d: with Z_A = U S Vᵀ, f = −D U S⁻¹ Vᵀ g and d = ∏ σ. A singular vector
 * has no sense of its own: it is that of the motion, or with several freedoms that of the last sample, by the
 * determinants of how U and Z V have turned. */
#include "statics/statics.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_math.h>

static const double rounding = 0.1; /* of what loads may be rounding at single poses: digits that a root has to spare */

/* The sign of det(turn), rank × rank. */
static double sense_of(km_actuator_workspace *h, int rank) {
  int sign;
  if (rank == 1)
    return gsl_matrix_get(h->turn, 0, 0) < 0.0 ? -1.0 : 1.0;
  gsl_matrix turn = *h->turn;
  turn.size1 = turn.size2 = h->pivots->size = (size_t)rank;
  gsl_linalg_LU_decomp(&turn, h->pivots, &sign);
  return gsl_linalg_LU_det(&turn, sign) < 0.0 ? -1.0 : 1.0;
}

/* Component j of the motion Z v_k. */
static double moved(const km_actuator_workspace *h, int k, int j) {
  double sum = 0.0;
  for (int i = 0; i < h->freedom; ++i)
    sum += h->Z[(size_t)i * (size_t)h->columns + (size_t)j] * gsl_matrix_get(h->V, (size_t)i, (size_t)k);
  return sum;
}

/* Of one actuator and one freedom: does it go with the motion, or against it? 0: there is no motion to go by. */
static double along(const km_mechanism *m, const km_actuator_workspace *h, const double *motion) {
  double dot = 0.0;
  for (int j = 0; j < h->columns && motion && h->freedom == 1 && h->count == 1; ++j) {
    int c = h->coordinate[j];
    dot += moved(h, 0, j) * m->scale[c] * motion[c];
  }
  double u = gsl_matrix_get(h->U, 0, 0);
  return dot == 0.0 ? 0.0 : copysign(1.0, dot * u);
}

/* How U and Z V are turned against those of the last sample, or, where there is one freedom, against the motion: ±1. */
static double orientation(const km_mechanism *m, km_actuator_workspace *h, int rank, const double *motion) {
  int columns = h->columns;
  double way = along(m, h, motion);
  if (way != 0.0)
    return way;
  for (int a = 0; a < rank; ++a)
    for (int b = 0; b < rank; ++b) {
      double sum = 0.0;
      for (int i = 0; i < h->count; ++i)
        sum += gsl_matrix_get(h->fixed, (size_t)i, (size_t)a) * gsl_matrix_get(h->U, (size_t)i, (size_t)b);
      gsl_matrix_set(h->turn, (size_t)a, (size_t)b, sum);
    }
  double sense = sense_of(h, rank);
  for (int b = 0; b < rank; ++b)
    for (int j = 0; j < columns; ++j) {
      double y = moved(h, b, j);
      for (int a = 0; a < rank; ++a) {
        double last = j ? gsl_matrix_get(h->turn, (size_t)a, (size_t)b) : 0.0;
        gsl_matrix_set(h->turn, (size_t)a, (size_t)b, last + y * h->moving[a * columns + j]);
      }
    }
  return sense * sense_of(h, rank);
}

static void keep(km_actuator_workspace *h, double sense) {
  int columns = h->columns;
  for (int b = 0; b < h->most_rank; ++b) {
    for (int i = 0; i < h->count; ++i)
      gsl_matrix_set(h->fixed, (size_t)i, (size_t)b,
                     (b == 0 ? sense : 1.0) * gsl_matrix_get(h->U, (size_t)i, (size_t)b));
    for (int j = 0; j < columns; ++j)
      h->moving[b * columns + j] = moved(h, b, j);
  }
}

/* At right angles to the vectors before it, and of unit length. */
static void straighten(const km_actuator_workspace *h, int rank, gsl_vector *last) {
  for (int k = 0; k + 1 < rank; ++k) {
    gsl_vector_view other = gsl_matrix_subcolumn(h->U, (size_t)k, 0, (size_t)h->count);
    double along;
    gsl_blas_ddot(&other.vector, last, &along);
    gsl_blas_daxpy(-along, &other.vector, last);
  }
  gsl_blas_dscal(1.0 / gsl_blas_dnrm2(last), last);
}

/* The unit vector that has most at right angles to the vectors before the last one. */
static size_t farthest(const km_actuator_workspace *h, int rank) {
  double best = 0.0;
  size_t place = 0;
  for (int i = 0; i < h->count; ++i) {
    double left = 1.0;
    for (int k = 0; k + 1 < rank; ++k)
      left -= gsl_pow_2(gsl_matrix_get(h->U, (size_t)i, (size_t)k));
    if (left > best) {
      best = left;
      place = (size_t)i;
    }
  }
  return place;
}

/* The last vector of U, U x / σ, has no more digits than σ, and may be missing where σ is 0. Of as many actuators as motions
 * it is at right angles to the others, which tells it with all digits; it keeps its sense. Of more actuators a missing one is that
 * of the last sample. */
static void complete(km_actuator_workspace *h, int rank) {
  gsl_vector_view last = gsl_matrix_subcolumn(h->U, (size_t)rank - 1, 0, (size_t)h->count);
  gsl_vector_view before = gsl_matrix_subcolumn(h->fixed, (size_t)rank - 1, 0, (size_t)h->count);
  bool missing = gsl_blas_dnrm2(&last.vector) < 0.5;
  bool more = h->count > rank;
  if (more && !missing)
    return;
  if (more && gsl_blas_dnrm2(&before.vector) > 0.5) {
    gsl_blas_dcopy(&before.vector, &last.vector);
  } else {
    size_t place = farthest(h, rank);
    double sense = missing ? 1.0 : copysign(1.0, gsl_vector_get(&last.vector, place));
    gsl_vector_set_basis(&last.vector, place);
    gsl_blas_dscal(sense, &last.vector);
  }
  straighten(h, rank, &last.vector);
}

static double clear(double x, double grain) {
  return fabs(x) <= grain ? 0.0 : x;
}

/* ∏ σ of all but one (-1: of all). */
static double product(const km_actuator_workspace *h, int rank, int but) {
  double result = 1.0;
  for (int k = 0; k < rank; ++k)
    if (k != but)
      result *= gsl_vector_get(h->S, (size_t)k);
  return result;
}

/* Do loads act on motions that the actuators never reach? */
static bool falls(const km_actuator_workspace *h) {
  double size = 0.0;
  for (int k = h->most_rank; k < h->freedom; ++k)
    size = hypot(size, gsl_vector_get(h->load, (size_t)k));
  return size > h->noise;
}

static bool divide(const km_mechanism *m, int index, const km_statics *st, const double *motion, double *n, double *d) {
  km_actuator_workspace *h = &st->work->holding[index];
  bool grown = h->rank > h->most_rank, lost = false;
  if (grown) {
    h->most_rank = h->rank;
    keep(h, 1.0);
  }
  int rank = h->most_rank;
  lost = falls(h);
  if (rank > 0)
    complete(h, rank);
  double sense = rank > 0 ? orientation(m, h, rank, motion) : 1.0, all = product(h, rank, -1);
  for (int i = 0; i < h->count; ++i) {
    int a = h->actuator[i];
    double sum = 0.0, grain = 0.0;
    for (int k = 0; k < rank; ++k) {
      double others = product(h, rank, k);
      sum -= gsl_matrix_get(h->U, (size_t)i, (size_t)k) * others * gsl_vector_get(h->load, (size_t)k);
      grain += others * rounding * h->noise;
    }
    n[a] = lost ? nan("") : sense * km_actuator_scale(m, st, a) * clear(sum, grain);
    d[a] = sense * all;
  }
  return !grown;
}

bool km_statics_ratios(const km_mechanism *m, km_statics *st, const double *motion, double *n, double *d) {
  bool comparable = true;
  for (int a = 0; a < st->actuator_count; ++a) {
    int c = st->work->alone[a];
    n[a] = c >= 0 ? 0.0 - clear(st->work->tau[c], rounding * st->work->least_load[c]) : 0.0;
    d[a] = c >= 0 && st->work->row[a] ? st->work->row[a][c] : 1.0;
  }
  for (int i = 0; i < st->work->block_count; ++i)
    if (st->work->holding[i].count && st->work->holding[i].freedom)
      comparable = divide(m, i, st, motion, n, d) && comparable;
  return comparable;
}

void km_statics_refer(const km_mechanism *m, km_statics *st) {
  for (int i = 0; i < st->work->block_count; ++i) {
    km_actuator_workspace *h = &st->work->holding[i];
    if (h->count && h->rank == h->most_rank && h->rank > 0)
      keep(h, orientation(m, h, h->most_rank, NULL));
  }
}
