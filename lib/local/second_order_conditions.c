/* Second-order conditions of a motion: wᵀ(J̇ q̇) = 0 for the left null vectors w of J (docs/theory.md 5.2).
 *
 *   Q_i(a, b) = −½ w_iᵀ (γ(a + b) − γ(a) − γ(b))                   γ = −J̇ q̇, quadratic in q̇ = D⁻¹ Z a
 *   Gauss-Newton on |a| = 1:  (Σ g_i g_iᵀ + (1e-9 + 1e-3 worst) I) δ = −Σ v_i g_i
 *                             v_i = aᵀ Q_i a / size,  g_i = 2 Q_i a / size,  worst = max |v_i|
 *   dimension bound: freedom − rank { Q_i a } */
#include "local/second_order_conditions.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* Left null vectors W of J, an orthonormal basis of the null space of Jᵀ. */
static bool find_left_null_space(const km_substructure *sub, const double *J, double tolerance, km_arena *arena,
                                 double **W, int *count) {
  size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
  double *T = KM_ARENA_NEW(arena, double, rows *columns), *weight = KM_ARENA_NEW(arena, double, rows);
  km_partition p;
  if (!km_partition_reserve(&p, sub->columns, sub->rows, arena))
    return false;
  for (size_t r = 0; r < rows; ++r) {
    weight[r] = 1.0;
    for (size_t c = 0; c < columns; ++c)
      T[r * columns + c] = J[c * rows + r];
  }
  km_partition_factor(&p, T, sub->columns, sub->rows, NULL, tolerance);
  *count = km_partition_freedom(&p);
  *W = KM_ARENA_NEW(arena, double, rows *(size_t)*count);
  if (arena->failed)
    return false;
  km_partition_null_space(&p, weight, *count, *W);
  return true;
}

/* Velocity products γ at the rates a + b; b may be NULL. rate[coordinate] is workspace. */
static void compute_products(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *a,
                             const double *b, double *rate, double *gamma) {
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    rate[c] = m->unit[c] * (a[k] + (b ? b[k] : 0.0));
  }
  km_loops_velocity_products(m, s, sub, rate, gamma);
}

/* Q_i(a, b) for every pair of the directions x, by polarisation of γ. gamma[(freedom + 1) × rows]. */
static void compute_conditions(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *W,
                               const double *x, double *rate, double *gamma, km_second_order *out) {
  size_t n = (size_t)sub->columns, rows = (size_t)sub->rows, k = (size_t)out->freedom;
  double *sum_products = gamma + k * rows;
  for (size_t a = 0; a < k; ++a)
    compute_products(m, s, sub, x + a * n, NULL, rate, gamma + a * rows);
  for (size_t a = 0; a < k; ++a)
    for (size_t b = 0; b <= a; ++b) {
      compute_products(m, s, sub, x + a * n, x + b * n, rate, sum_products);
      for (size_t i = 0; i < (size_t)out->conditions; ++i) {
        double sum = 0.0;
        for (size_t r = 0; r < rows; ++r)
          sum -= 0.5 * W[i * rows + r] * (sum_products[r] - gamma[a * rows + r] - gamma[b * rows + r]);
        out->Q[i * k * k + a * k + b] = out->Q[i * k * k + b * k + a] = sum;
      }
    }
}

/* Factors J; the tangents are its null space. */
bool km_second_order_count_tangents(const km_mechanism *m, km_state *s, int index, km_second_order *out) {
  const km_substructure *sub = &m->substructures[index];
  int worst;
  km_loops_update(m, s, sub);
  double residual = km_loops_residual(m, s, sub, &worst),
         tolerance = fmax(km_rank_tolerance(m, sub, residual), s->partition[index].min_relative_pivot);
  km_search_pivots(m, s, index, KM_NO_DRIVER, tolerance);
  const km_partition *p = &s->partition[index];
  *out = (km_second_order){.columns = sub->columns,
                           .freedom = km_partition_freedom(p),
                           .has_redundant_rows = p->rank < sub->rows,
                           .tolerance = tolerance,
                           .noise = fmax(1e-7, 100.0 * residual)};
  return !p->failed;
}

/* Orthonormal null-space basis Z of J. */
bool km_second_order_create_basis(const km_mechanism *m, const km_state *s, int index, km_arena *arena,
                                  km_second_order *out) {
  const km_substructure *sub = &m->substructures[index];
  out->Z = KM_ARENA_NEW(arena, double, (size_t)sub->columns *(size_t)out->freedom);
  if (arena->failed)
    return false;
  km_partition_null_space(&s->partition[index], m->column_weight + sub->column_start, out->freedom, out->Z);
  return true;
}

/* z = Z a. */
void km_second_order_combine(const km_second_order *c, const double *a, double *z) {
  for (int k = 0; k < c->columns; ++k) {
    z[k] = 0.0;
    for (int r = 0; r < c->freedom; ++r)
      z[k] += c->Z[(size_t)r * (size_t)c->columns + (size_t)k] * a[r];
  }
}

/* Cholesky factorisation of A[k × k] in place, lower triangle. False if A is not positive definite; the result is then
 * meaningless. */
static bool cholesky(double *A, int k) {
  bool positive = true;
  for (int i = 0; i < k; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = A[i * k + j];
      for (int o = 0; o < j; ++o)
        sum -= A[i * k + o] * A[j * k + o];
      positive = positive && (j < i || sum > 0.0);
      A[i * k + j] = i == j ? sqrt(fmax(sum, 1e-300)) : sum / A[j * k + j];
    }
  return positive;
}

/* True if |aᵀQ a| exceeds `margin` for every unit vector a: sign Q − margin I is positive definite. sign: 1 or −1. */
static bool is_condition_definite(const double *Q, double sign, double margin, int k, double *A) {
  for (int i = 0; i < k * k; ++i)
    A[i] = sign * Q[i];
  for (int i = 0; i < k; ++i)
    A[i * k + i] -= margin;
  return cholesky(A, k);
}

/* True if some Q_i is positive or negative definite. */
static bool has_definite_condition(const km_second_order *c, double *work) {
  int k = c->freedom;
  double margin = 2.0 * km_condition_tolerance * c->size;
  for (int i = 0; i < c->conditions; ++i) {
    const double *Q = c->Q + (size_t)i * (size_t)(k * k);
    if (is_condition_definite(Q, 1.0, margin, k, work) || is_condition_definite(Q, -1.0, margin, k, work))
      return true;
  }
  return false;
}

/* Returns the largest squared norm of the columns of M[rows × columns]; *longest: that column. */
static double find_longest_column(const double *M, int rows, int columns, int *longest) {
  double max_square = -1.0;
  for (int c = 0; c < columns; ++c) {
    double square = 0.0;
    for (int r = 0; r < rows; ++r)
      square += M[c * rows + r] * M[c * rows + r];
    if (square > max_square) {
      max_square = square;
      *longest = c;
    }
  }
  return max_square;
}

/* Gram-Schmidt with column pivoting, M = V R, until all remaining columns are shorter than `margin`. M is overwritten.
 * Returns the number of rows of R[… × columns]. */
static int compress_columns(double *M, int rows, int columns, double margin, double *R) {
  int count = 0, longest = 0;
  for (; count < rows && count < columns; ++count) {
    double length = sqrt(find_longest_column(M, rows, columns, &longest));
    if (!(length > margin))
      break;
    double *v = M + longest * rows;
    for (int r = 0; r < rows; ++r)
      v[r] /= length;
    for (int c = 0; c < columns; ++c) {
      double *x = M + c * rows, dot = 0.0;
      for (int r = 0; r < rows; ++r)
        dot += v[r] * x[r];
      R[count * columns + c] = c == longest ? length : dot;
      for (int r = 0; r < rows && c != longest; ++r)
        x[r] -= dot * v[r];
    }
    memset(v, 0, (size_t)rows * sizeof *v);
  }
  return count;
}

/* Largest |entry| of all Q_i. */
static double max_entry(const km_second_order *c) {
  double largest = 0.0;
  for (size_t i = 0; i < (size_t)(c->conditions * c->freedom * c->freedom); ++i)
    largest = fmax(largest, fabs(c->Q[i]));
  return largest;
}

/* Replaces more than k (k + 1)/2 conditions, which are dependent, by at most that many with the same sum of squares
 * along every direction, so that Gauss-Newton takes the same steps. */
static bool keep_independent(km_second_order *c) {
  int k = c->freedom, products = k * (k + 1) / 2;
  km_arena arena = {0};
  if (c->conditions <= products)
    return true;
  double *M = KM_ARENA_NEW(&arena, double, (size_t)c->conditions *(size_t)products);
  double *R = KM_ARENA_NEW(&arena, double, (size_t)products *(size_t)products);
  bool is_ok = !arena.failed;
  for (int i = 0; i < c->conditions && is_ok; ++i)
    for (int a = 0, at = i; a < k; ++a)
      for (int b = 0; b <= a; ++b, at += c->conditions)
        M[at] = c->Q[i * k * k + a * k + b];
  if (is_ok)
    c->conditions = compress_columns(M, c->conditions, products, c->noise, R);
  for (int i = 0; i < c->conditions && is_ok; ++i)
    for (int a = 0, at = i * products; a < k; ++a)
      for (int b = 0; b <= a; ++b, ++at)
        c->Q[i * k * k + a * k + b] = c->Q[i * k * k + b * k + a] = R[at];
  c->size = max_entry(c);
  km_arena_free(&arena);
  return is_ok;
}

/* Computes left null vectors W and all forms Q_i. */
bool km_second_order_build_all(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_second_order *out) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  size_t n = (size_t)sub->columns, rows = (size_t)sub->rows, k = (size_t)out->freedom;
  out->is_built = true;
  if (!out->has_redundant_rows)
    return true;
  double *x = KM_ARENA_NEW(arena, double, n *k), *J = KM_ARENA_NEW(arena, double, n *rows);
  double *rate = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count);
  double *gamma = KM_ARENA_NEW(arena, double, (k + 1) * rows), *work = KM_ARENA_NEW(arena, double, k *k);
  if (arena->failed)
    return false;
  km_loops_update(m, s, sub);
  km_state_jacobian_dense(s, sub, J);
  if (!find_left_null_space(sub, J, out->tolerance, arena, &out->W, &out->conditions))
    return false;
  out->Q = KM_ARENA_NEW(arena, double, (size_t)out->conditions *k *k);
  if (arena->failed)
    return false;
  for (size_t i = 0; i < n * k; ++i)
    x[i] = out->Z[i] / weight[i % n];
  compute_conditions(m, s, sub, out->W, x, rate, gamma, out);
  out->size = max_entry(out);
  out->has_definite = has_definite_condition(out, work);
  return true;
}

bool km_second_order_build(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_second_order *out) {
  return km_second_order_build_all(m, s, index, arena, out) && keep_independent(out);
}

/* w_iᵀ J z for all left and right null vectors. */
bool km_second_order_rank_defect(const km_mechanism *m, const km_state *s, int index, const km_second_order *c,
                                 double *changes) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  int n = sub->columns, rows = sub->rows;
  double *J = KM_NEW(double, (size_t)n *(size_t)rows), *moved = KM_NEW(double, (size_t)rows);
  bool is_ok = J && moved;
  if (is_ok)
    km_state_jacobian_dense(s, sub, J);
  for (int v = 0; v < c->freedom && is_ok; ++v) {
    memset(moved, 0, (size_t)rows * sizeof *moved);
    for (int k = 0; k < n; ++k)
      for (int r = 0; r < rows; ++r)
        moved[r] += J[k * rows + r] * c->Z[v * n + k] / weight[k];
    for (int i = 0; i < c->conditions; ++i) {
      double sum = 0.0;
      for (int r = 0; r < rows; ++r)
        sum += c->W[i * rows + r] * moved[r];
      changes[i * c->freedom + v] = sum;
    }
  }
  km_free(J);
  km_free(moved);
  return is_ok;
}

/* Restricted forms V Q_i Vᵀ. */
bool km_second_order_restrict(const km_second_order *c, const double *coefficients, int count, km_arena *arena,
                              km_second_order *out) {
  const int k = c->freedom;
  *out = (km_second_order){.columns = c->columns,
                           .freedom = count,
                           .conditions = c->conditions,
                           .has_redundant_rows = c->has_redundant_rows,
                           .is_built = true,
                           .tolerance = c->tolerance,
                           .noise = c->noise};
  double *product = KM_ARENA_NEW(arena, double, (size_t)(count * k));
  double *work = KM_ARENA_NEW(arena, double, (size_t)(count * count));
  out->Q = KM_ARENA_NEW(arena, double, (size_t)c->conditions *(size_t)(count * count));
  for (int i = 0; i < c->conditions && !arena->failed; ++i) {
    const double *Q = c->Q + (size_t)i * (size_t)(k * k);
    for (int a = 0; a < count; ++a)
      for (int r = 0; r < k; ++r) {
        product[a * k + r] = 0.0;
        for (int o = 0; o < k; ++o)
          product[a * k + r] += coefficients[a * k + o] * Q[o * k + r];
      }
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < count; ++b) {
        double sum = 0.0;
        for (int r = 0; r < k; ++r)
          sum += product[a * k + r] * coefficients[b * k + r];
        out->Q[(i * count + a) * count + b] = sum;
      }
  }
  if (arena->failed)
    return false;
  out->size = max_entry(out);
  out->has_definite = has_definite_condition(out, work);
  return true;
}

/* Value aᵀ Q_i a of condition i and its gradient 2 Q_i a. */
static double evaluate_condition(const km_second_order *c, int i, const double *a, double *slope) {
  int k = c->freedom;
  const double *Q = c->Q + (size_t)i * (size_t)(k * k);
  double value = 0.0;
  for (int r = 0; r < k; ++r) {
    double sum = 0.0;
    for (int o = 0; o < k; ++o)
      sum += Q[r * k + o] * a[o];
    slope[r] = 2.0 * sum;
    value += a[r] * sum;
  }
  return value;
}

/* Solves the damped normal equations (A + μ I) d = −b by Cholesky, in place; k × k, lower triangle of A. */
static void solve_damped_step(double *A, const double *b, int k, double damping, double *d) {
  for (int i = 0; i < k; ++i)
    A[i * k + i] += damping;
  cholesky(A, k);
  for (int i = 0; i < k; ++i) {
    d[i] = -b[i];
    for (int o = 0; o < i; ++o)
      d[i] -= A[i * k + o] * d[o];
    d[i] /= A[i * k + i];
  }
  for (int i = k - 1; i >= 0; --i) {
    for (int o = i + 1; o < k; ++o)
      d[i] -= A[o * k + i] * d[o];
    d[i] /= A[i * k + i];
  }
}

/* Damped Gauss-Newton on the sphere |a| = 1 for aᵀ Q_i a = 0. */
bool km_second_order_solve(const km_second_order *c, double *a, double *work) {
  int k = c->freedom;
  double *A = work, *b = A + k * k, *d = b + k, *slope = d + k;
  if (!km_second_order_is_significant(c))
    return true;
  if (c->has_definite)
    return false;
  for (int pass = 0; pass < 60; ++pass) {
    double worst = 0.0, norm = 0.0;
    memset(A, 0, (size_t)(k * k) * sizeof *A);
    memset(b, 0, (size_t)k * sizeof *b);
    for (int i = 0; i < c->conditions; ++i) {
      double value = evaluate_condition(c, i, a, slope) / c->size;
      worst = fmax(worst, fabs(value));
      for (int r = 0; r < k; ++r) {
        b[r] += value * slope[r] / c->size;
        for (int o = 0; o <= r; ++o)
          A[r * k + o] += slope[r] * slope[o] / (c->size * c->size);
      }
    }
    if (worst < 1e-9)
      return true;
    solve_damped_step(A, b, k, 1e-9 + 1e-3 * worst, d);
    for (int r = 0; r < k; ++r) {
      a[r] += d[r];
      norm += a[r] * a[r];
    }
    for (int r = 0; r < k; ++r)
      a[r] /= sqrt(norm);
  }
  double worst = 0.0;
  for (int i = 0; i < c->conditions; ++i)
    worst = fmax(worst, fabs(evaluate_condition(c, i, a, slope)) / c->size);
  return worst < km_condition_tolerance;
}

/* Dimension bound: freedom minus the rank of the gradients Q_i a. */
int km_second_order_dimension(const km_second_order *c, const double *a) {
  int k = c->freedom, rank = 0;
  km_arena arena = {0};
  km_partition p;
  if (!km_second_order_is_significant(c))
    return k;
  double *slopes = KM_ARENA_NEW(&arena, double, (size_t)(c->conditions * k));
  if (slopes && km_partition_reserve(&p, k, c->conditions, &arena)) {
    double largest = 0.0;
    for (int i = 0; i < c->conditions; ++i)
      evaluate_condition(c, i, a, slopes + i * k);
    for (int i = 0; i < c->conditions * k; ++i)
      largest = fmax(largest, fabs(slopes[i]));
    /* `a` lies within √km_condition_tolerance of a zero of the conditions, and |Q_i a| is at most k times the largest
     * entry. */
    km_partition_factor(&p, slopes, k, c->conditions, NULL, 2.0 * k * sqrt(km_condition_tolerance) * c->size / largest);
    rank = p.rank;
  }
  km_arena_free(&arena);
  return k - rank;
}
