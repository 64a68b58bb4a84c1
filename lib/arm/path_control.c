/* Path-control and pose-control columns of an arm: null space of [J | −ξ], and minimum-norm solutions
 * (docs/theory.md 12.3).
 *
 *   [J | −xi] Z = 0;  c1 = (q', 1)/sqrt(1 + |q'|²),  q' = J⁺ xi;   c2, ... : null vectors of J, last entry 0
 *   x with J x = rhs of least |moved + x|: minimum-norm solution minus the null-space part of `moved` */
#include "arm/path_control.h"
#include "arm/tracking/seven_joint_arm.h"
#include "base/number/vectors.h"

#include <string.h>

static void subtract(double *a, double s, const double *b, int n) {
  for (int i = 0; i < n; ++i)
    a[i] -= s * b[i];
}

/* Factors by the kernel of seven joints; false if J is nearly rank-deficient, which complete pivoting must decide. */
static bool factor_seven(km_arm_space *s, const double *xi) {
  km_one_factor(s->seven, xi);
  if (!(s->seven->min_pivot > s->seven->max_pivot * KM_SEVEN_MIN_PIVOT_RATIO))
    return false;
  memcpy(s->null, &s->seven->null, sizeof s->seven->null); /* including the final 0 */
  s->null_count = 1;
  return true;
}

void km_control_factor(const km_arm *a, km_arm_space *s, const double *xi, const bool *fixed) {
  s->seven_factored = s->seven_valid && !fixed && factor_seven(s, xi);
  if (!s->seven_factored)
    km_control_pivot(a, s, xi, fixed);
}

/* Gauss-Jordan elimination of [J | −ξ] with complete pivoting, the path column forced independent; orthonormal null
 * space of J. */
void km_control_pivot(const km_arm *a, km_arm_space *s, const double *xi, const bool *fixed) {
  const int rows = a->rows, n = a->n;
  double *path = s->jacobian + n * rows;
  s->seven_factored = false;
  for (int r = 0; r < rows; ++r)
    path[r] = -xi[r];
  for (int k = 0; fixed && k < n; ++k)
    if (fixed[k])
      memset(s->jacobian + k * rows, 0, (size_t)rows * sizeof *s->jacobian);
  const km_factor_options options = {.tolerance = KM_ARM_PIVOT * (n + 1), .forced = s->forced};
  km_factor_compute(s->factor, s->jacobian, rows, n + 1, &options);
  s->null_count = n - km_factor_rank(s->factor) + km_factor_has_forced_pivot(s->factor);
  memcpy(s->null, km_factor_null_space(s->factor, s->null_count),
         (size_t)s->null_count * (size_t)(n + 1) * sizeof *s->null);
}

void km_control_project_out(const km_arm *a, const km_arm_space *s, double *x) {
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; k < s->null_count; ++k) {
      const double *z = s->null + k * (a->n + 1);
      subtract(x, km_dot(z, x, a->n), z, a->n);
    }
}

/* Column k of `self` = normalised projection of `from` on the null space, orthogonal to the first k columns. False:
 * its length is below 1e-3. */
static bool project_column(const km_arm *a, const km_arm_space *s, const double *from, double *self, int k) {
  const int n = a->n;
  double *out = self + k * n;
  memset(out, 0, (size_t)n * sizeof *out);
  for (int j = 0; j < s->null_count; ++j)
    subtract(out, -km_dot(s->null + j * (n + 1), from, n), s->null + j * (n + 1), n);
  for (int pass = 0; pass < 2; ++pass)
    for (int o = 0; o < k; ++o)
      subtract(out, km_dot(self + o * n, out, n), self + o * n, n);
  double size = sqrt(km_dot(out, out, n));
  for (int i = 0; i < n && size > 0.0; ++i)
    out[i] /= size;
  return size > 1e-3;
}

/* Pose-control columns: the guide's columns projected on the null space, completed by null vectors. One freedom: the
 * null vector with the sign of the guide. */
static void set_pose_control_columns(const km_arm *a, const km_arm_space *s, const double *guide, double *self) {
  const int n = a->n;
  if (a->freedom == 1 && s->null_count == 1) {
    double along = !guide ? 0.0 : s->seven_factored ? km_one_along_null(s->seven, guide) : km_dot(guide, s->null, n);
    double sign = along < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < n; ++i)
      self[i] = sign * s->null[i];
    return;
  }
  for (int k = 0; k < a->freedom; ++k) {
    bool found = guide && project_column(a, s, guide + k * n, self, k);
    for (int j = 0; j < s->null_count && !found; ++j)
      found = project_column(a, s, s->null + j * (n + 1), self, k);
  }
}

/* Path-control column: null vector of [J | −ξ] for the path column, without its self-motion part, normalised;
 * pose-control columns along the guide. Returns the path entry. */
double km_control_columns(const km_arm *a, const km_arm_space *s, const double *guide, double *path, double *self) {
  const int n = a->n;
  set_pose_control_columns(a, s, guide, self);
  if (s->seven_factored) {
    km_one_path_column(s->seven, path);
    return path[SEVEN];
  }
  if (km_factor_has_forced_pivot(s->factor)) { /* ξ is not in the range of J */
    memset(path, 0, (size_t)(n + 1) * sizeof *path);
    return 0.0;
  }
  km_factor_null_vector(s->factor, n, path);
  km_control_project_out(a, s, path);
  double scale = 1.0 / sqrt(km_dot(path, path, n + 1));
  for (int i = 0; i <= n; ++i)
    path[i] *= scale;
  return path[n];
}

/* Minimum-norm solution of J x = rhs, minus the null-space part of `moved`. */
void km_control_solve(const km_arm *a, km_arm_space *s, const double *rhs, const double *moved, const bool *fixed,
                      double *x) {
  double all[KM_ARM_MAX_JOINTS + 1], row[KM_ARM_MAX_JOINTS];
  if (s->seven_factored) {
    km_one_row found = km_one_solve(s->seven, rhs, moved ? -km_one_along_null(s->seven, moved) : 0.0);
    memcpy(x, &found, SEVEN * sizeof *x);
    return;
  }
  km_factor_solve(s->factor, rhs, all);
  memcpy(x, all, (size_t)a->n * sizeof *x);
  km_control_project_out(a, s, x);
  if (moved) {
    memcpy(row, moved, (size_t)a->n * sizeof *row);
    km_control_project_out(a, s, row);
    for (int k = 0; k < a->n; ++k)
      x[k] -= moved[k] - row[k];
  }
  for (int k = 0; fixed && k < a->n; ++k)
    x[k] = fixed[k] ? 0.0 : x[k];
}

/* Newton's method with minimum-norm steps to a target pose. */
bool km_arm_reach(const km_arm *a, km_arm_space *s, const km_pose *target, const bool *fixed, int most, double longest,
                  double *q) {
  static const double none[KM_ARM_ROWS] = {0};
  double e[KM_ARM_ROWS], x[KM_ARM_MAX_JOINTS];
  for (int step = 0; step <= most; ++step) {
    km_arm_update(a, s, q);
    double left = km_arm_error(a, s, target, e, NULL, NULL);
    if (left <= 1e-12)
      return true;
    if (!(left < 1e6))
      return false;
    km_control_factor(a, s, none, fixed);
    km_control_solve(a, s, e, NULL, fixed, x);
    double size = sqrt(km_dot(x, x, a->n)), scale = size > longest ? longest / size : 1.0;
    for (int k = 0; k < a->n; ++k)
      q[k] += scale * x[k];
  }
  return false;
}
