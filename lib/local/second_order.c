/* Second-order conditions of a motion: wᵀ(J̇ q̇) = 0 for the left null vectors w of J (docs/theory.md 5.2).
 *
 *   Q_i(a, b) = −½ w_iᵀ (γ(a + b) − γ(a) − γ(b))                   γ = −J̇ q̇, quadratic in q̇ = D⁻¹ Z a
 *   Gauss-Newton on |a| = 1:  min Σ (g_i δ + v_i)² + (1e-9 + 1e-3 worst) |δ|²
 *                             v_i = aᵀ Q_i a / scale,  g_i = 2 Q_i a / scale,  worst = max |v_i|
 *   dimension bound: freedom − rank { Q_i a }
 *
 * The basis stores all Q_i; the other back end evaluates v_i and g_i (second_order_columns.c). */
#include "base/number/tolerances.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/second_order_columns.h"

#include <string.h>

/* Velocity products γ at the rates a + b; b may be NULL. rate[coordinate] is workspace. */
static void compute_products(const km_local *l, const double *a, const double *b, double *rate, double *gamma) {
  for (int k = 0; k < l->sub->columns; ++k) {
    int c = l->m->column_coordinate[l->sub->column_start + k];
    rate[c] = l->m->unit[c] * (a[k] + (b ? b[k] : 0.0)) / l->weight[k];
  }
  km_loops_velocity_products(l->m, l->s, l->sub, rate, gamma);
}

/* Q_i(a, b) for every pair of basis vectors, by polarisation of γ. gamma[(freedom + 1) × rows]. */
static void compute_forms(km_local *l, double *rate, double *gamma) {
  size_t n = (size_t)l->sub->columns, rows = (size_t)l->sub->rows, k = (size_t)l->freedom;
  double *sum_products = gamma + k * rows;
  for (size_t a = 0; a < k; ++a)
    compute_products(l, l->Z + a * n, NULL, rate, gamma + a * rows);
  for (size_t a = 0; a < k; ++a)
    for (size_t b = 0; b <= a; ++b) {
      compute_products(l, l->Z + a * n, l->Z + b * n, rate, sum_products);
      for (size_t i = 0; i < (size_t)l->conditions; ++i) {
        double sum = 0.0;
        for (size_t r = 0; r < rows; ++r)
          sum -= 0.5 * l->W[i * rows + r] * (sum_products[r] - gamma[a * rows + r] - gamma[b * rows + r]);
        l->Q[i * k * k + a * k + b] = l->Q[i * k * k + b * k + a] = sum;
      }
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

/* True if some Q_i is definite: |aᵀQ_i a| exceeds the tolerance, twice, for every unit vector a. */
static bool has_definite_form(const km_local *l, double *A) {
  int k = l->freedom;
  bool is_definite = false;
  for (int i = 0; i < l->conditions; ++i)
    for (double sign = 1.0; sign >= -1.0; sign -= 2.0) {
      for (int r = 0; r < k * k; ++r)
        A[r] = sign * l->Q[(size_t)i * (size_t)(k * k) + (size_t)r];
      for (int r = 0; r < k; ++r)
        A[r * k + r] -= 2.0 * km_condition_tolerance * l->scale;
      is_definite = is_definite || cholesky(A, k);
    }
  return is_definite;
}

/* Scale and definiteness of the forms. */
static void measure_forms(km_local *l) {
  l->scale = 0.0;
  for (size_t i = 0; i < (size_t)(l->conditions * l->freedom * l->freedom); ++i)
    l->scale = fmax(l->scale, fabs(l->Q[i]));
  l->has_definite = has_definite_form(l, l->work);
}

/* Orthonormal left null vectors W, and all forms Q_i. */
static bool build_forms(km_local *l) {
  size_t n = (size_t)l->sub->columns, rows = (size_t)l->sub->rows, k = (size_t)l->freedom;
  km_arena scratch = {0};
  double *J = KM_ARENA_NEW(&scratch, double, n *rows), *transposed = KM_ARENA_NEW(&scratch, double, n *rows);
  double *rate = KM_ARENA_NEW(&scratch, double, (size_t)l->m->coordinate_count);
  double *gamma = KM_ARENA_NEW(&scratch, double, (k + 1) * rows);
  bool is_ok = !scratch.failed;
  if (is_ok) {
    km_state_jacobian_dense(l->s, l->sub, J);
    for (size_t i = 0; i < n * rows; ++i)
      transposed[i % rows * n + i / rows] = J[i];
    l->conditions = km_dense_null_space(transposed, (int)n, (int)rows, l->tolerance, l->arena, &l->W);
    is_ok = l->conditions >= 0;
    l->conditions = is_ok ? l->conditions : 0;
    l->Q = KM_ARENA_NEW(l->arena, double, (size_t)l->conditions *k *k);
    l->value = KM_ARENA_NEW(l->arena, double, (size_t)l->conditions);
    l->gradient = KM_ARENA_NEW(l->arena, double, (size_t)l->conditions *k);
    is_ok = is_ok && !l->arena->failed;
  }
  if (is_ok) {
    compute_forms(l, rate, gamma);
    measure_forms(l);
  }
  km_arena_free(&scratch);
  l->arena->failed = l->arena->failed || !is_ok;
  return is_ok;
}

/* Computes the conditions once, at the configuration. */
bool km_local_update_conditions(km_local *l) {
  km_error error;
  if (l->has_conditions)
    return !l->arena->failed && !l->lacks_conditions;
  l->has_conditions = true;
  if (!l->has_redundant_rows)
    return true;
  km_state_restore(l->s, l->sub, l->origin);
  km_loops_update(l->m, l->s, l->sub);
  if (l->has_basis)
    return build_forms(l);
  km_status status = km_second_order_columns_create(l, &error);
  l->arena->failed = l->arena->failed || status == KM_MEMORY;
  l->lacks_conditions = status != KM_OK;
  return !status;
}

bool km_local_restrict(km_local *l, const double *V, int count) {
  const int k = l->freedom, n = l->sub->columns;
  double *Z = KM_ARENA_NEW(l->arena, double, (size_t)(count * n) + 1), *Q = NULL;
  for (int i = 0; i < count && Z; ++i)
    for (int c = 0; c < n; ++c)
      for (int r = 0; r < k; ++r)
        Z[i * n + c] += V[i * k + r] * l->Z[r * n + c];
  if (l->Q) { /* V Q_i Vᵀ */
    Q = KM_ARENA_NEW(l->arena, double, (size_t)(l->conditions * count * count) + 1);
    double *product = KM_ARENA_NEW(l->arena, double, (size_t)(count * k) + 1);
    for (int i = 0; i < l->conditions && !l->arena->failed; ++i) {
      memset(product, 0, (size_t)(count * k) * sizeof *product);
      for (int a = 0; a < count; ++a)
        for (int r = 0; r < k; ++r)
          for (int o = 0; o < k; ++o)
            product[a * k + r] += V[a * k + o] * l->Q[(i * k + o) * k + r];
      for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b)
          for (int r = 0; r < k; ++r)
            Q[(i * count + a) * count + b] += product[a * k + r] * V[b * k + r];
    }
  }
  if (l->arena->failed)
    return false;
  l->Z = Z;
  l->freedom = l->size = count;
  if (Q) {
    l->Q = Q;
    measure_forms(l);
  }
  return true;
}

/* Values and derivatives of all conditions along a, over the scale. */
double km_local_violation(km_local *l, const double *a) {
  int k = l->freedom;
  double worst = 0.0, steepest;
  if (!l->has_basis)
    return km_second_order_columns_evaluate(l, a, &steepest) / l->scale;
  for (int i = 0; i < l->conditions; ++i) {
    const double *Q = l->Q + (size_t)i * (size_t)(k * k);
    double *g = l->gradient + (size_t)i * (size_t)k;
    l->value[i] = 0.0;
    for (int r = 0; r < k; ++r) {
      double sum = 0.0;
      for (int o = 0; o < k; ++o)
        sum += Q[r * k + o] * a[o];
      g[r] = 2.0 * sum / l->scale;
      l->value[i] += a[r] * sum / l->scale;
    }
    worst = fmax(worst, fabs(l->value[i]));
  }
  return worst;
}

/* Damped step by the normal equations (Σ g_i g_iᵀ + damping I) δ = −Σ v_i g_i. work[freedom² + 2 · freedom] */
static void add_step(const km_local *l, double damping, double *a) {
  int k = l->freedom;
  double *A = l->work, *d = A + k * k;
  memset(A, 0, (size_t)(k * k + k) * sizeof *A);
  for (int i = 0; i < l->conditions; ++i) {
    const double *g = l->gradient + (size_t)i * (size_t)k;
    for (int r = 0; r < k; ++r) {
      d[r] -= l->value[i] * g[r];
      for (int o = 0; o <= r; ++o)
        A[r * k + o] += g[r] * g[o];
    }
  }
  for (int r = 0; r < k; ++r)
    A[r * k + r] += damping;
  cholesky(A, k);
  for (int i = 0; i < k; ++i) {
    for (int o = 0; o < i; ++o)
      d[i] -= A[i * k + o] * d[o];
    d[i] /= A[i * k + i];
  }
  for (int i = k - 1; i >= 0; --i) {
    for (int o = i + 1; o < k; ++o)
      d[i] -= A[o * k + i] * d[o];
    d[i] /= A[i * k + i];
    a[i] += d[i];
  }
}

/* Makes a[size] a unit vector, of a tangent that needs no projection. */
static bool scale_to_unit(const km_local *l, double *a) {
  double square = 0.0;
  for (int i = 0; i < l->size; ++i)
    square += a[i] * a[i];
  for (int i = 0; i < l->size; ++i)
    a[i] /= sqrt(square);
  return isfinite(square) && square > 0.0;
}

/* Evaluates the conditions at a start. False if they are not significant, or unknown. */
static bool evaluate_start(km_local *l, const double *a, double *worst) {
  double steepest;
  if (!km_local_update_conditions(l) || l->conditions == 0)
    return false;
  if (!l->has_basis) { /* a quadratic form is half its derivative along a */
    km_local_return(l);
    km_second_order_columns_evaluate(l, a, &steepest);
    l->scale = fmax(l->scale, 0.5 * steepest);
  }
  if (!km_local_is_significant(l))
    return false;
  *worst = km_local_violation(l, a);
  return true;
}

bool km_local_violates_second_order(km_local *l, const double *a) {
  double worst;
  return evaluate_start(l, a, &worst) && worst > km_significant_ratio * km_condition_tolerance;
}

/* Damped Gauss-Newton iteration onto the tangent cone. */
bool km_local_solve_second_order(km_local *l, double *a) {
  enum { MAX_PASSES = 60 };
  double worst;
  if (!evaluate_start(l, a, &worst))
    return !l->arena->failed && !l->lacks_conditions;
  for (int pass = 0; pass < MAX_PASSES && !l->has_definite; ++pass) {
    double damping = 1e-9 + 1e-3 * worst;
    if (worst < km_relative_zero)
      return true;
    if (l->has_basis)
      add_step(l, damping, a);
    else if (!km_second_order_columns_step(l, damping, a))
      return false;
    if (!scale_to_unit(l, a))
      return false;
    worst = km_local_violation(l, a);
  }
  return !l->has_definite && worst < km_condition_tolerance;
}

/* Random starts on the tangent cone. */
bool km_local_satisfies_second_order(km_local *l) {
  for (int start = 0; start < KM_STARTS_PER_FREEDOM; ++start)
    if (l->freedom > 1 && km_local_draw(l, &l->random, l->a) && km_local_solve_second_order(l, l->a))
      return true;
  return false;
}

/* Dimension bound: freedom minus the rank of the derivatives 2 Q_i a. `a` lies within √km_condition_tolerance of a zero
 * of the conditions, and |Q_i a| is at most k times the largest entry. */
int km_local_dimension_bound(km_local *l, const double *a) {
  int k = l->freedom;
  km_arena arena = {0};
  double *null, largest = 0.0;
  if (!l->has_basis || !km_local_is_significant(l))
    return k;
  km_local_violation(l, a);
  for (int i = 0; i < l->conditions * k; ++i)
    largest = fmax(largest, fabs(l->gradient[i]));
  int dependent = km_dense_null_space(l->gradient, k, l->conditions, 2.0 * k * sqrt(km_condition_tolerance) / largest,
                                      &arena, &null);
  km_arena_free(&arena);
  return dependent < 0 ? k : k - l->conditions + dependent;
}

/* w_iᵀ J z for all left and right null vectors. */
bool km_local_rank_defect(km_local *l, double *defect) {
  int n = l->sub->columns, rows = l->sub->rows;
  km_arena arena = {0};
  double *J = KM_ARENA_NEW(&arena, double, (size_t)n *(size_t)rows), *b = KM_ARENA_NEW(&arena, double, (size_t)rows);
  bool is_ok = !arena.failed;
  if (is_ok)
    km_state_jacobian_dense(l->s, l->sub, J);
  for (int v = 0; v < l->freedom && is_ok; ++v) {
    memset(b, 0, (size_t)rows * sizeof *b);
    for (int k = 0; k < n; ++k)
      for (int r = 0; r < rows; ++r)
        b[r] += J[k * rows + r] * l->Z[v * n + k] / l->weight[k];
    for (int i = 0; i < l->conditions; ++i) {
      defect[i * l->freedom + v] = 0.0;
      for (int r = 0; r < rows; ++r)
        defect[i * l->freedom + v] += l->W[i * rows + r] * b[r];
    }
  }
  km_arena_free(&arena);
  return is_ok;
}
