/* Evidence of a rank (theory 3.2): singular values that do not depend on how the model is written.
 *
 *   J    six-row Jacobian about the point nearest to all axes, lengths over their root mean square distance from it
 *   G    Gram matrix of the loops as signed sets of joints, G = L Lᵀ;   singular values of L⁻¹ J are independent of
 *        the choice of loops
 *   doubtful if a relative singular value lies between 1e-10, rounding and closing errors, and 1e-5 */
#include "mobility/rank_evidence.h"
#include "base/number/tolerances.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kmech/mobility.h"
#include "kmech/sweep.h"
#include "mobility/full_jacobian.h"
#include "mobility/jacobian_singular_values.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <string.h>

static const double nonzero_above = 1e-5; /* relative singular values above this do not come from rounded data */

/* The columns of one substructure as twists, their reference point and length scale. */
typedef struct joint_axes {
  const km_mechanism *m;
  const km_substructure *sub;
  km_twist *twist; /* [coordinate] */
  km_vec3 about;
  double size;
} joint_axes;

/* Finds the point c nearest to all axes, min Σ |v + ω × c|², and their root mean square distance as the length scale.
 * If all axes meet there, lengths do not matter and the substructure's size is used. */
static void find_nearest_point(joint_axes *a) {
  double A[9] = {0}, b[3] = {0}, sum = 0.0;
  int rotating = 0;
  for (int k = 0; k < a->sub->columns; ++k) {
    km_twist t = a->twist[a->m->column_coordinate[a->sub->column_start + k]];
    const double w[3] = {t.w.x, t.w.y, t.w.z};
    km_vec3 rhs = km_vec3_cross(t.w, t.v);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        A[3 * i + j] += (i == j) * km_vec3_dot(t.w, t.w) - w[i] * w[j];
    b[0] += rhs.x;
    b[1] += rhs.y;
    b[2] += rhs.z;
    rotating += km_vec3_dot(t.w, t.w) > 0.0;
  }
  /* parallel axes: the solution of least norm */
  gsl_matrix_view M = gsl_matrix_view_array(A, 3, 3);
  double values[3], vectors[9], work[3], x[3] = {0};
  gsl_matrix_view V = gsl_matrix_view_array(vectors, 3, 3);
  gsl_vector_view S = gsl_vector_view_array(values, 3), W = gsl_vector_view_array(work, 3);
  gsl_vector_view B = gsl_vector_view_array(b, 3), X = gsl_vector_view_array(x, 3);
  gsl_linalg_SV_decomp(&M.matrix, &V.matrix, &S.vector, &W.vector);
  for (int i = 0; i < 3; ++i)
    values[i] = values[i] > 1e-9 * values[0] ? values[i] : 0.0; /* GSL omits values of 0 */
  gsl_linalg_SV_solve(&M.matrix, &V.matrix, &S.vector, &B.vector, &X.vector);
  a->about = (km_vec3){x[0], x[1], x[2]};
  for (int k = 0; k < a->sub->columns; ++k) {
    km_twist t = a->twist[a->m->column_coordinate[a->sub->column_start + k]];
    km_vec3 v = km_vec3_add(t.v, km_vec3_cross(t.w, a->about));
    sum += km_vec3_dot(t.w, t.w) > 0.0 ? km_vec3_dot(v, v) : 0.0;
  }
  a->size = rotating ? sqrt(sum / rotating) : 0.0;
  a->size = a->size > 1e-9 * a->sub->size ? a->size : a->sub->size;
}

/* Computes the Gram matrix of the loops: the signed number of joints that two of them share. */
static void loop_gram(const km_mechanism *m, int index, int loops, double *G) {
  const km_topology *t = &m->topology;
  double *sign = G + (size_t)loops * (size_t)loops; /* [joint] of one loop */
  for (int a = 0; a < loops; ++a) {
    int one = t->loop[t->loop_start[index] + a];
    for (int i = t->member_start[one]; i < t->member_start[one + 1]; ++i)
      sign[t->member[i].joint] = km_member_sign(&t->member[i]);
    for (int b = 0; b < loops; ++b) {
      int other = t->loop[t->loop_start[index] + b];
      double sum = 0.0;
      for (int i = t->member_start[other]; i < t->member_start[other + 1]; ++i)
        sum += sign[t->member[i].joint] * km_member_sign(&t->member[i]);
      G[a * loops + b] = sum;
    }
    for (int i = t->member_start[one]; i < t->member_start[one + 1]; ++i)
      sign[t->member[i].joint] = 0.0;
  }
}

/* Replaces the loop blocks of J by L⁻¹ J, G = L Lᵀ (Cholesky). */
static void apply_inverse_cholesky(const km_mechanism *m, int index, int rows, km_arena *arena, double *J) {
  const km_substructure *sub = &m->substructures[index];
  int loops = sub->loop_count;
  double *G = KM_ARENA_NEW(arena, double, (size_t)(loops * loops + m->model->joint_count));
  if (arena->failed || loops == 0)
    return;
  loop_gram(m, index, loops, G);
  gsl_matrix_view L = gsl_matrix_view_array(G, (size_t)loops, (size_t)loops);
  gsl_linalg_cholesky_decomp1(&L.matrix);
  for (int c = 0; c < sub->columns; ++c)
    for (int r = 0; r < 6; ++r) {
      double *x = J + (size_t)c * (size_t)rows + r;
      for (int a = 0; a < loops; ++a) {
        for (int b = 0; b < a; ++b)
          x[6 * a] -= G[a * loops + b] * x[6 * b];
        x[6 * a] /= G[a * loops + a];
      }
    }
}

/* Scales lengths by the axes' length scale instead of the substructure's size, and couplings' rows to length 1. */
static void rescale_lengths(const joint_axes *a, int rows, double *J) {
  const km_substructure *sub = a->sub;
  double factor = sub->size / a->size;
  for (int c = 0; c < sub->columns; ++c) {
    km_twist t = a->twist[a->m->column_coordinate[sub->column_start + c]];
    bool is_slide = km_vec3_dot(t.w, t.w) == 0.0;
    double *x = J + (size_t)c * (size_t)rows;
    for (int l = 0; l < sub->loop_count && !is_slide; ++l)
      for (int r = 0; r < 3; ++r)
        x[6 * l + r] *= factor;
    for (int r = 6 * sub->loop_count; r < rows && is_slide; ++r)
      x[r] /= factor;
  }
  for (int r = 6 * sub->loop_count; r < rows; ++r) {
    double sum = 0.0;
    for (int c = 0; c < sub->columns; ++c)
      sum += J[c * rows + r] * J[c * rows + r];
    for (int c = 0; c < sub->columns && sum > 0.0; ++c)
      J[c * rows + r] /= sqrt(sum);
  }
}

/* Finds the kept and dropped values, and whether a value is in the doubtful range. */
static void classify_rank(const km_mechanism *m, const double *values, int count, int rank, km_rank_evidence *out) {
  /* A factor of 10 on either side of the rank tolerance. */
  double low = fmax(0.1 * km_relative_zero, m->closure_tolerance_given ? m->closure_tolerance : 0.0);
  double high = m->closure_tolerance_given ? fmax(nonzero_above, km_significant_ratio * low) : nonzero_above;
  double scale = count && values[0] > 0.0 ? 1.0 / values[0] : 1.0;
  out->kept = rank > 0 && rank <= count ? scale * values[rank - 1] : 1.0;
  out->dropped = rank < count ? scale * values[rank] : 0.0;
  for (int i = 0; i < count; ++i)
    out->doubtful = out->doubtful || (scale * values[i] > low && scale * values[i] < high);
}

static bool find_by_singular_values(const km_mechanism *m, km_state *s, int index, km_arena *arena,
                                    km_rank_evidence *out) {
  joint_axes a = {.m = m, .sub = &m->substructures[index]};
  int rows = 6 * a.sub->loop_count + a.sub->coupling_count;
  km_svd_workspace workspace;
  double *values = KM_ARENA_NEW(arena, double, (size_t)a.sub->columns),
         *J = KM_ARENA_NEW(arena, double, (size_t)(rows * a.sub->columns));
  a.twist = KM_ARENA_NEW(arena, km_twist, (size_t)m->coordinate_count);
  if (!km_svd_reserve(&workspace, rows, a.sub->columns, arena))
    return false;
  for (int k = 0; k < a.sub->columns; ++k) {
    int c = m->column_coordinate[a.sub->column_start + k];
    a.twist[c] = km_coordinate_twist(m, s, c);
  }
  find_nearest_point(&a);
  km_full_jacobian(m, s, index, a.twist, a.about, 1, (size_t)rows, J);
  rescale_lengths(&a, rows, J);
  apply_inverse_cholesky(m, index, rows, arena, J);
  if (arena->failed)
    return false;
  int count = km_svd_values(J, rows, a.sub->columns, &workspace, values);
  classify_rank(m, values, count, km_factor_rank(s->factor[index]), out);
  return true;
}

km_status km_rank_evidence_find(const km_mechanism *m, km_state *s, int index, km_rank_evidence *out, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  km_arena arena = {0};
  bool found = true;
  *out = (km_rank_evidence){0};
  gsl_set_error_handler_off();
  if (6 * sub->loop_count + sub->coupling_count <= KM_MAX_SINGULAR && sub->columns <= KM_MAX_SINGULAR) {
    found = find_by_singular_values(m, s, index, &arena, out);
  } else {
    km_substructure_mobility e;
    km_substructure_evidence(m, s, index, &e);
    const double pivots[3] = {1.0, e.last_pivot, e.first_dropped};
    classify_rank(m, pivots, 3, 2, out);
  }
  km_arena_free(&arena);
  return found ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the evidence of a rank");
}
