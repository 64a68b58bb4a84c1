/* Rows of a task (pose 6, axis 5, position 3), and the subspace of rows that the arm's motions can change. Rows outside
 * it, such as out-of-plane rows of a planar arm, are removed. The subspace is the span of the Jacobian's columns at
 * random configurations (docs/theory.md 12.1). */
#include "arm/arm.h"
#include "base/random.h"

#include <string.h>

/* Component of a unit column below which it is rounding. */
static const double column_rounding = 1e-9;

int km_task_rows(km_task task) {
  return task == KM_TASK_POSE ? 6 : task == KM_TASK_AXIS ? 5 : 3;
}

void km_arm_all_task_rows(const km_arm *a, const km_rotation *effector, km_twist twist, double *rows) {
  km_vec3_write(twist.v, rows);
  if (a->task == KM_TASK_POSITION)
    return;
  if (a->task == KM_TASK_AXIS) {
    rows[3] = km_vec3_dot(effector->axis[0], twist.w);
    rows[4] = km_vec3_dot(effector->axis[1], twist.w);
    return;
  }
  rows[3] = twist.w.x;
  rows[4] = twist.w.y;
  rows[5] = twist.w.z;
}

void km_arm_task_rows(const km_arm *a, const km_rotation *effector, km_twist twist, double *rows) {
  if (a->rows == a->task_rows) {
    km_arm_all_task_rows(a, effector, twist, rows);
    return;
  }
  double all[KM_ARM_ROWS];
  km_arm_all_task_rows(a, effector, twist, all);
  for (int i = 0; i < a->rows; ++i) {
    rows[i] = 0.0;
    for (int r = 0; r < a->task_rows; ++r)
      rows[i] += a->basis[i][r] * all[r];
  }
}

/* Gram-Schmidt, twice: subtracts from x[count] its projections on the orthonormal vectors. Returns the remaining
 * length. */
static double project_out(const double (*basis)[KM_ARM_ROWS], int vectors, int count, double *x) {
  double sum = 0.0;
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < vectors; ++i) {
      double dot = 0.0;
      for (int r = 0; r < count; ++r)
        dot += basis[i][r] * x[r];
      for (int r = 0; r < count; ++r)
        x[r] -= dot * basis[i][r];
    }
  for (int r = 0; r < count; ++r)
    sum += x[r] * x[r];
  return sqrt(sum);
}

/* Extends an orthonormal basis by x if the part of x orthogonal to the basis is longer than `least`. */
static void extend_basis(double (*basis)[KM_ARM_ROWS], int *vectors, int count, double *x, double least) {
  double length = *vectors < count ? project_out((const double(*)[KM_ARM_ROWS])basis, *vectors, count, x) : 0.0;
  if (!(length > least))
    return;
  for (int r = 0; r < count; ++r)
    basis[*vectors][r] = x[r] / length;
  ++*vectors;
}

/* Orthonormal basis of the span of the Jacobian's columns at random configurations; with probability 1 it is the
 * span over all configurations. Returns its dimension. */
static int span_of_columns(const km_arm *a, km_arm_space *s, double (*basis)[KM_ARM_ROWS]) {
  double q[KM_ARM_MAX_JOINTS], x[KM_ARM_ROWS];
  uint64_t seed = 1;
  int found = 0;
  for (int pose = 0; pose < 4 * KM_ARM_ROWS && found < a->task_rows; ++pose) {
    for (int k = 0; k < a->n; ++k)
      q[k] = (a->motions[k].primitive == KM_PRISMATIC ? 1.0 : M_PI) * km_uniform(&seed);
    km_arm_update(a, s, q);
    for (int k = 0; k < a->n; ++k) {
      double largest = 0.0;
      memcpy(x, s->jacobian + k * a->rows, (size_t)a->rows * sizeof *x);
      for (int r = 0; r < a->rows; ++r)
        largest = fmax(largest, fabs(x[r]));
      extend_basis(basis, &found, a->rows, x, column_rounding * largest);
    }
  }
  return found;
}

/* Rewrites a basis of a subspace: coordinate axes that lie in the subspace first, then an orthonormal complement. */
static void align_with_axes(const km_arm *a, const double (*span)[KM_ARM_ROWS], int vectors,
                            double (*basis)[KM_ARM_ROWS]) {
  int found = 0;
  for (int r = 0; r < a->task_rows; ++r) {
    double axis[KM_ARM_ROWS] = {0};
    axis[r] = 1.0;
    if (project_out(span, vectors, a->task_rows, axis) > column_rounding)
      continue;
    memset(basis[found], 0, sizeof *basis);
    basis[found++][r] = 1.0;
  }
  for (int i = 0; i < vectors; ++i) {
    double x[KM_ARM_ROWS];
    memcpy(x, span[i], sizeof x);
    extend_basis(basis, &found, a->task_rows, x, column_rounding);
  }
}

bool km_arm_find_rows(km_arm *a) {
  double span[KM_ARM_ROWS][KM_ARM_ROWS];
  km_arm_space space;
  a->rows = a->task_rows;
  if (!km_arm_space_create(a, &space))
    return false;
  int found = span_of_columns(a, &space, span);
  km_arm_space_free(&space);
  align_with_axes(a, (const double(*)[KM_ARM_ROWS])span, found, a->basis);
  a->rows = found;
  return true;
}
