/* Forces in joints without play. */
#include "allowance/strain_forces.h"
#include "base/number/tolerances.h"

#include <math.h>

enum { FORCE = 0, MOMENT = 3 }; /* rows of km_self_stress.wrench */

bool km_model_states_stiffness(const km_model *model) {
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].fit.force_stiffness > 0.0 || model->joints[j].fit.moment_stiffness > 0.0)
      return true;
  return false;
}

static const double *rows_of(const km_self_stress *stress, int joint, int first) {
  return stress->wrench + ((size_t)joint * KM_STRESS_ROWS + (size_t)first) * (size_t)stress->count;
}

/* Adds MᵀM factor of three rows to the lower half of C. */
static void add_squares(const double *M, int n, double factor, double *C) {
  for (int r = 0; r < 3; ++r)
    for (int i = 0; i < n; ++i)
      for (int k = 0; k <= i; ++k)
        C[i * n + k] += factor * M[r * n + i] * M[r * n + k];
}

/* Cholesky factor L of C in its lower half. False if C is singular. */
static bool factor(double *C, int n) {
  for (int i = 0; i < n; ++i) {
    const double diagonal = C[i * n + i];
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k < j; ++k)
        C[i * n + j] -= C[i * n + k] * C[j * n + k];
      if (j < i)
        C[i * n + j] /= C[j * n + j];
    }
    if (!(C[i * n + i] > km_solved_rounding * diagonal))
      return false;
    C[i * n + i] = sqrt(C[i * n + i]);
  }
  return true;
}

/* x ← L⁻¹ x, so that F C⁻¹ Eᵀ = (L⁻¹Fᵀ)ᵀ (L⁻¹Eᵀ). */
static void forward(const double *L, int n, double *x) {
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k)
      x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
}

/* Largest eigenvalue of a symmetric 3 × 3 matrix (trigonometric solution of its characteristic cubic). */
static double largest_eigenvalue(double S[3][3]) {
  double mean = (S[0][0] + S[1][1] + S[2][2]) / 3.0, square = 0.0;
  double B[3][3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      B[i][k] = S[i][k] - (i == k ? mean : 0.0);
      square += B[i][k] * B[i][k];
    }
  const double p = sqrt(square / 6.0);
  if (p == 0.0)
    return mean;
  double determinant = B[0][0] * (B[1][1] * B[2][2] - B[1][2] * B[2][1]) -
                       B[0][1] * (B[1][0] * B[2][2] - B[1][2] * B[2][0]) +
                       B[0][2] * (B[1][0] * B[2][1] - B[1][1] * B[2][0]);
  double cosine = fmax(-1.0, fmin(1.0, determinant / (2.0 * p * p * p)));
  return mean + 2.0 * p * cos(acos(cosine) / 3.0);
}

/* The three rows of M, each multiplied by L⁻¹, into out[3 × n]. */
static void transform(const double *L, const double *M, int rows, int n, double *out) {
  for (int r = 0; r < rows; ++r) {
    for (int i = 0; i < n; ++i)
      out[r * n + i] = M[r * n + i];
    forward(L, n, out + r * n);
  }
}

/* Worst case and three standard deviations of |F a|; F, E: transformed rows. */
static void bound_length(const double *F, const km_support_terms *terms, const double *E, int n, double *worst,
                         double *statistical) {
  double covariance[3][3] = {{0}};
  *worst = 0.0;
  for (int t = 0; t < terms->error_count; ++t) {
    double product[3][3] = {{0}}, gram[3][3] = {{0}};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < n; ++i)
          product[r][c] += terms->error[t].size * F[r * n + i] * E[(t * 3 + c) * n + i];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
          gram[r][c] += product[r][k] * product[c][k];
    *worst += sqrt(fmax(0.0, largest_eigenvalue(gram)));
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        covariance[r][c] += gram[r][c];
  }
  *statistical = sqrt(fmax(0.0, largest_eigenvalue(covariance)));
}

bool km_strain_forces_compute(const km_mechanism *m, const km_self_stress *stress, const km_support_terms *terms,
                              km_strain_forces *out) {
  const int n = stress->count;
  km_arena scratch = {0};
  double *C = KM_ARENA_NEW(&scratch, double, (size_t)n *(size_t)n);
  double *E = KM_ARENA_NEW(&scratch, double, 3 * (size_t)n * (size_t)terms->error_count + 1);
  double *F = KM_ARENA_NEW(&scratch, double, 3 * (size_t)n);
  bool computed = !scratch.failed, is_regular = false;
  for (int j = 0; computed && j < stress->joint_count; ++j) {
    const km_joint_fit *fit = &m->model->joints[stress->joint[j]].fit;
    if (fit->force_stiffness > 0.0)
      add_squares(rows_of(stress, j, FORCE), n, 1.0 / fit->force_stiffness, C);
    if (fit->moment_stiffness > 0.0)
      add_squares(rows_of(stress, j, MOMENT), n, 1.0 / fit->moment_stiffness, C);
  }
  if (computed)
    is_regular = factor(C, n);
  for (int t = 0; is_regular && t < terms->error_count; ++t)
    transform(C, terms->W + terms->error[t].first * n, terms->error[t].rows, n, E + (size_t)t * 3 * (size_t)n);
  for (int j = 0; computed && j < stress->joint_count; ++j) {
    out[j] = (km_strain_forces){nan(""), nan(""), nan(""), nan("")};
    if (!is_regular)
      continue;
    transform(C, rows_of(stress, j, FORCE), 3, n, F);
    bound_length(F, terms, E, n, &out[j].force_worst, &out[j].force_statistical);
    transform(C, rows_of(stress, j, MOMENT), 3, n, F);
    bound_length(F, terms, E, n, &out[j].moment_worst, &out[j].moment_statistical);
  }
  km_arena_free(&scratch);
  return computed;
}
