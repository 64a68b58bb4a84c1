/* Singular value decompositions of actuators' rows in many freedoms: few actuators, or rows of an orthonormal basis. */
#include "statics/statics.h"

#include <gsl/gsl_linalg.h>

/* Computes U S Vᵀ of a wide matrix A: Aᵀ = Q R by Householder reflections, where the first columns of Q span the
 * rows, and Rᵀ = U S Wᵀ, which is small; A = U S (Q₁ W)ᵀ. */
static void decompose(gsl_matrix *U, gsl_matrix *V, gsl_vector *S, size_t rows, double *work) {
  size_t columns = U->size2;
  gsl_matrix_view QR = gsl_matrix_view_array(work, columns, rows), W, T, R;
  double *next = work + columns * rows;
  R = gsl_matrix_view_array(next, columns, rows);
  T = gsl_matrix_view_array(next += columns * rows, rows, rows);
  W = gsl_matrix_view_array(next += rows * rows, rows, rows);
  gsl_vector_view tau = gsl_vector_view_array(next += rows * rows, rows), s = gsl_vector_view_array(next + rows, rows);
  for (size_t a = 0; a < rows; ++a)
    for (size_t k = 0; k < columns; ++k)
      gsl_matrix_set(&QR.matrix, k, a, gsl_matrix_get(U, a, k));
  gsl_linalg_QR_decomp(&QR.matrix, &tau.vector);
  gsl_linalg_QR_unpack(&QR.matrix, &tau.vector, V, &R.matrix);
  for (size_t a = 0; a < rows; ++a)
    for (size_t b = 0; b < rows; ++b)
      gsl_matrix_set(&T.matrix, a, b, gsl_matrix_get(&R.matrix, b, a));
  gsl_linalg_SV_decomp_jacobi(&T.matrix, &W.matrix, &s.vector);
  gsl_matrix_set_zero(U);
  gsl_vector_set_zero(S);
  for (size_t i = 0; i < rows; ++i) {
    gsl_vector_set(S, i, gsl_vector_get(&s.vector, i));
    for (size_t a = 0; a < rows; ++a)
      gsl_matrix_set(U, a, i, gsl_matrix_get(&T.matrix, a, i));
  }
  for (size_t k = 0; k < columns; ++k) { /* Q₁ W, row by row, in place of R */
    for (size_t i = 0; i < rows; ++i) {
      double sum = 0.0;
      for (size_t n = 0; n < rows; ++n)
        sum += gsl_matrix_get(V, k, n) * gsl_matrix_get(&W.matrix, n, i);
      gsl_matrix_set(&R.matrix, k, i, sum);
    }
    for (size_t i = 0; i < rows; ++i)
      gsl_matrix_set(V, k, i, gsl_matrix_get(&R.matrix, k, i));
  }
}

bool km_decompose_orthonormal(const gsl_matrix *U, gsl_matrix *V, gsl_vector *S) {
  static const double rounding = 1e-12;
  for (size_t k = 0; k < U->size2; ++k) {
    double square = 0.0;
    for (size_t a = 0; a < U->size1; ++a)
      square += gsl_matrix_get(U, a, k) * gsl_matrix_get(U, a, k);
    if (!(fabs(square - 1.0) < rounding))
      return false;
  }
  gsl_matrix_set_identity(V);
  gsl_vector_set_all(S, 1.0);
  return true;
}

bool km_decompose_wide(gsl_matrix *U, gsl_matrix *V, gsl_vector *S, int rows) {
  size_t a = (size_t)rows;
  if (rows == 0) {
    gsl_matrix_set_zero(U);
    gsl_matrix_set_identity(V);
    gsl_vector_set_zero(S);
    return true;
  }
  double *work = KM_NEW(double, 2 * U->size2 * a + 2 * a * a + 2 * a);
  if (work)
    decompose(U, V, S, a, work);
  km_free(work);
  return work != NULL;
}
