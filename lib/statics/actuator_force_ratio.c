/* Actuators' forces along a sweep as ratios n/d of smooth functions (theory 9.6).
 *
 *   Z_A = U S Vᵀ:   d = ∏ σ_k,   n = -D Σ_k u_k (∏_{i≠k} σ_i) (v_kᵀ g),   g = Yᵀ τ
 *
 * The sign of a singular vector is arbitrary. It follows the motion, or with several freedoms the determinants of the
 * rotations of U and Z V since the last sample. */
#include "statics/statics.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_math.h>

/* Returns the sign of det(rotation), rank × rank. */
static double determinant_sign(km_actuator_workspace *h, int rank) {
  int sign;
  if (rank == 1)
    return gsl_matrix_get(h->rotation, 0, 0) < 0.0 ? -1.0 : 1.0;
  gsl_matrix rotation = *h->rotation;
  rotation.size1 = rotation.size2 = h->pivots->size = (size_t)rank;
  gsl_linalg_LU_decomp(&rotation, h->pivots, &sign);
  return gsl_linalg_LU_det(&rotation, sign) < 0.0 ? -1.0 : 1.0;
}

/* Returns component j of the motion Z v_k. */
static double motion_component(const km_actuator_workspace *h, int k, int j) {
  double sum = 0.0;
  for (int i = 0; i < h->size; ++i)
    sum += h->Z[(size_t)i * (size_t)h->columns + (size_t)j] * gsl_matrix_get(h->V, (size_t)i, (size_t)k);
  return sum;
}

/* Returns the sign of one actuator's singular motion relative to the given motion, for one freedom; 0: no motion
 * given. */
static double sign_along_motion(const km_mechanism *m, const km_actuator_workspace *h, const double *motion) {
  double dot = 0.0;
  for (int j = 0; j < h->columns && motion && h->freedom == 1 && h->count == 1; ++j) {
    int c = h->coordinate[j];
    dot += motion_component(h, 0, j) * m->scale[c] * motion[c];
  }
  double u = gsl_matrix_get(h->U, 0, 0);
  return dot == 0.0 ? 0.0 : copysign(1.0, dot * u);
}

/* Returns the orientation, ±1, of U and Z V relative to those of the last sample or, with one freedom, relative to
 * the motion. */
static double orientation(const km_mechanism *m, km_actuator_workspace *h, int rank, const double *motion) {
  int columns = h->columns;
  double motion_sign = sign_along_motion(m, h, motion);
  if (motion_sign != 0.0)
    return motion_sign;
  for (int a = 0; a < rank; ++a)
    for (int b = 0; b < rank; ++b) {
      double sum = 0.0;
      for (int i = 0; i < h->count; ++i)
        sum += gsl_matrix_get(h->reference_U, (size_t)i, (size_t)a) * gsl_matrix_get(h->U, (size_t)i, (size_t)b);
      gsl_matrix_set(h->rotation, (size_t)a, (size_t)b, sum);
    }
  double sign = determinant_sign(h, rank);
  for (int b = 0; b < rank; ++b)
    for (int j = 0; j < columns; ++j) {
      double y = motion_component(h, b, j);
      for (int a = 0; a < rank; ++a) {
        double last = j ? gsl_matrix_get(h->rotation, (size_t)a, (size_t)b) : 0.0;
        gsl_matrix_set(h->rotation, (size_t)a, (size_t)b, last + y * h->reference_ZV[a * columns + j]);
      }
    }
  return sign * determinant_sign(h, rank);
}

static void store_reference(km_actuator_workspace *h, double sign) {
  int columns = h->columns;
  for (int b = 0; b < h->regular_rank; ++b) {
    for (int i = 0; i < h->count; ++i)
      gsl_matrix_set(h->reference_U, (size_t)i, (size_t)b,
                     (b == 0 ? sign : 1.0) * gsl_matrix_get(h->U, (size_t)i, (size_t)b));
    for (int j = 0; j < columns; ++j)
      h->reference_ZV[b * columns + j] = motion_component(h, b, j);
  }
}

/* Orthonormalises the last vector of U against those before it. */
static void orthonormalise_last(const km_actuator_workspace *h, int rank, gsl_vector *last) {
  for (int k = 0; k + 1 < rank; ++k) {
    gsl_vector_view other = gsl_matrix_subcolumn(h->U, (size_t)k, 0, (size_t)h->count);
    double sign_along_motion;
    gsl_blas_ddot(&other.vector, last, &sign_along_motion);
    gsl_blas_daxpy(-sign_along_motion, &other.vector, last);
  }
  gsl_blas_dscal(1.0 / gsl_blas_dnrm2(last), last);
}

/* Returns the axis with the largest part orthogonal to the vectors before the last one. */
static size_t find_orthogonal_axis(const km_actuator_workspace *h, int rank) {
  double best = 0.0;
  size_t axis = 0;
  for (int i = 0; i < h->count; ++i) {
    double left = 1.0;
    for (int k = 0; k + 1 < rank; ++k)
      left -= gsl_pow_2(gsl_matrix_get(h->U, (size_t)i, (size_t)k));
    if (left > best) {
      best = left;
      axis = (size_t)i;
    }
  }
  return axis;
}

/* Recomputes the last vector of U: it is known to the digits of σ only, and missing if σ is 0. With as many actuators
 * as motions it is the orthogonal complement of the others, with its sign kept. A missing one is that of the last
 * sample if there are more actuators. */
static void recompute_last_vector(km_actuator_workspace *h, int rank) {
  gsl_vector_view last = gsl_matrix_subcolumn(h->U, (size_t)rank - 1, 0, (size_t)h->count);
  gsl_vector_view before = gsl_matrix_subcolumn(h->reference_U, (size_t)rank - 1, 0, (size_t)h->count);
  bool missing = gsl_blas_dnrm2(&last.vector) < 0.5;
  bool more = h->count > rank;
  if (more && !missing)
    return;
  if (more && gsl_blas_dnrm2(&before.vector) > 0.5) {
    gsl_blas_dcopy(&before.vector, &last.vector);
  } else {
    size_t axis = find_orthogonal_axis(h, rank);
    double sign = missing ? 1.0 : copysign(1.0, gsl_vector_get(&last.vector, axis));
    gsl_vector_set_basis(&last.vector, axis);
    gsl_blas_dscal(sign, &last.vector);
  }
  orthonormalise_last(h, rank, &last.vector);
}

static double clear_rounding(double x, double rounding_level) {
  return fabs(x) <= rounding_level ? 0.0 : x;
}

/* Returns ∏ σ of all but one (-1: of all). */
static double product(const km_actuator_workspace *h, int rank, int excluded) {
  double result = 1.0;
  for (int k = 0; k < rank; ++k)
    if (k != excluded)
      result *= gsl_vector_get(h->S, (size_t)k);
  return result;
}

/* True if loads act on motions that the actuators never reach. */
static bool is_loaded_out_of_reach(const km_actuator_workspace *h) {
  double size = 0.0;
  for (int k = h->regular_rank; k < h->size; ++k)
    size = hypot(size, gsl_vector_get(h->load, (size_t)k));
  return size > h->noise;
}

/* Computes n and d of the actuators of one block; false if its rank has grown. */
static bool compute_block_ratio(const km_mechanism *m, int index, const km_statics *st, const double *motion,
                                bool clears, double *n, double *d) {
  km_actuator_workspace *h = &st->work->blocks[index];
  bool has_grown = h->rank > h->regular_rank, never_holds = false;
  if (has_grown) {
    h->regular_rank = h->rank;
    store_reference(h, 1.0);
  }
  int rank = h->regular_rank;
  never_holds = is_loaded_out_of_reach(h);
  if (rank > 0)
    recompute_last_vector(h, rank);
  double sign = rank > 0 ? orientation(m, h, rank, motion) : 1.0, all = product(h, rank, -1);
  for (int i = 0; i < h->count; ++i) {
    int a = h->actuator[i];
    double sum = 0.0, rounding_level = 0.0;
    for (int k = 0; k < rank; ++k) {
      double others = product(h, rank, k);
      sum -= gsl_matrix_get(h->U, (size_t)i, (size_t)k) * others * gsl_vector_get(h->load, (size_t)k);
      rounding_level += others * h->noise;
    }
    n[a] =
        never_holds ? nan("") : sign * km_actuator_scale(m, st, a) * clear_rounding(sum, clears ? rounding_level : 0.0);
    d[a] = sign * all;
  }
  return !has_grown;
}

bool km_statics_ratios(const km_mechanism *m, km_statics *st, const double *motion, bool clears, double *n, double *d) {
  bool comparable = true;
  for (int a = 0; a < st->actuator_count; ++a) {
    int c = st->work->tree_joint[a];
    n[a] = c >= 0 ? 0.0 - clear_rounding(st->work->tree_load[a], clears ? st->work->least_load[c] : 0.0) : 0.0;
    d[a] = c >= 0 && st->work->row[a] ? st->work->row[a][c] : 1.0;
  }
  for (int i = 0; i < st->work->block_count; ++i)
    if (st->work->blocks[i].count && st->work->blocks[i].freedom)
      comparable = compute_block_ratio(m, i, st, motion, clears, n, d) && comparable;
  return comparable;
}

void km_statics_set_reference(const km_mechanism *m, km_statics *st) {
  for (int i = 0; i < st->work->block_count; ++i) {
    km_actuator_workspace *h = &st->work->blocks[i];
    if (h->count && h->rank == h->regular_rank && h->rank > 0)
      store_reference(h, orientation(m, h, h->regular_rank, NULL));
  }
}
