/* Constant-rank tangents, and motions of permanently shaky mechanisms along them (docs/theory.md 5.6).
 *
 *   U = { a : Q_i a = 0 for all i },  orthonormal rows of V, completed by the other tangents
 *   deflation: F(q) = wᵀ J z = 0 for all left and right null vectors w, z, by Newton's method
 *   step     : Σ_o y_o Q_i(v, o) = −w_iᵀ J z_v  for all i, v, by least squares; o: tangents outside U
 *   test     : no other tangent satisfies second order; four steps along U, ahead or back, keep rank and dimension */
#include "local/constant_rank.h"
#include "base/number/tolerances.h"

#include "kinematics/loop_equations.h"
#include "linalg/factor.h"
#include "local/local_private.h"

#include <string.h>

/* Tangent in U: the projection of a direction, or the motion of the driver. */
bool km_constant_rank_tangent(const km_constant_rank *st, const km_mechanism *m, int index, int driver,
                              const double *direction, double *t) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  int n = sub->columns;
  memset(t, 0, (size_t)n * sizeof *t);
  for (int i = 0; i < st->count; ++i) {
    const double *z = st->Z + (size_t)i * (size_t)n;
    double dot = driver >= 0 ? z[driver] : 0.0;
    for (int c = 0; c < n && driver < 0; ++c)
      dot += z[c] * weight[c] * direction[c];
    for (int c = 0; c < n; ++c)
      t[c] += dot * z[c];
  }
  for (int c = 0; c < n; ++c)
    t[c] /= weight[c];
  double size = km_step_length(m, sub, t), unit = driver >= 0 ? t[driver] : size;
  for (int c = 0; c < n; ++c)
    t[c] /= unit;
  return size > km_root_rounding;
}

/* Tangents of a configuration, divided into those of constant rank and the others. */
typedef struct tangent_split {
  km_local *l;
  double *V; /* [freedom × freedom] orthonormal coefficients: constant-rank tangents first, then the others */
  int count; /* number of constant-rank tangents */
} tangent_split;

/* Computes U as the common null space of all Q_i, to 1e-6 of their largest entry, and completes V. `known`: number of
 * constant-rank tangents on the motion, so the tolerance is widened until there are as many; 0: unknown. */
static bool find_constant_rank_tangents(tangent_split *p, int known) {
  static const double null_tolerance = 1e-6, max_tolerance = 1e-2;
  const km_local *l = p->l;
  const int k = l->freedom, rows = l->conditions * k;
  double *M = KM_ARENA_NEW(l->arena, double, (size_t)rows *(size_t)k), *U = NULL;
  p->V = KM_ARENA_NEW(l->arena, double, (size_t)(k * k) + 1);
  if (l->arena->failed || !km_local_is_significant(l))
    return false;
  for (int a = 0; a < k; ++a)
    for (int i = 0; i < rows; ++i)
      M[a * rows + i] = l->Q[i * k + a];
  for (double tolerance = null_tolerance; p->count < (known ? known : 1) && tolerance <= max_tolerance;
       tolerance = known ? 10.0 * tolerance : HUGE_VAL)
    p->count = km_dense_null_space(M, rows, k, fmax(tolerance, l->noise / l->scale), l->arena, &U);
  if (p->count <= 0 || p->count == k || (known && p->count != known))
    return false;
  memcpy(p->V, U, (size_t)(p->count * k) * sizeof *U);
  return km_complete_basis(p->V, p->count, k);
}

/* Divides the tangents at the state's configuration. False if none are of constant rank, all are, or another number
 * than known. */
static bool split_tangents(tangent_split *p, const km_mechanism *m, km_state *s, int index, int known,
                           double min_tolerance, km_arena *arena) {
  *p = (tangent_split){.l = km_local_create(m, s, index, NULL, min_tolerance, arena)};
  return p->l && p->l->freedom > 0 && km_local_reserve_tangents(p->l, true) && km_local_update_conditions(p->l) &&
         find_constant_rank_tangents(p, known);
}

/* True if some combination of the other tangents satisfies the conditions, as far as random starts show, so that it can
 * belong to a finite motion. */
static bool may_others_be_finite(const tangent_split *p) {
  km_local others = *p->l;
  uint64_t random = 1;
  int k = others.freedom, count = k - p->count;
  if (!km_local_restrict(&others, p->V + p->count * k, count))
    return true;
  bool is_satisfied = false;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * count && count > 1 && !is_satisfied; ++start)
    is_satisfied = km_local_draw(&others, &random, others.a) && km_local_solve_second_order(&others, others.a);
  return is_satisfied;
}

/* Stores the constant-rank tangents as rows of Z in the motion. */
static bool store_tangents(km_constant_rank *st, const tangent_split *p) {
  int n = p->l->sub->columns;
  if (p->count > st->capacity)
    return false;
  st->count = p->count;
  for (int i = 0; i < st->count; ++i) {
    double *z = st->Z + (size_t)i * (size_t)n;
    km_local_direction(p->l, p->V + i * p->l->freedom, z);
    for (int c = 0; c < n; ++c)
      z[c] *= p->l->weight[c];
  }
  return true;
}

/* Newton step of the deflation: coefficients y of the other tangents with Σ_o y_o Q_i(v, o) = −w_iᵀ J z_v for all i, v,
 * by normal equations. */
static bool solve_deflation(const tangent_split *p, const double *defect, double *y) {
  const km_local *l = p->l;
  int k = l->freedom, others = k - p->count, rows = l->conditions * k;
  double *A = KM_ARENA_NEW(l->arena, double, (size_t)(rows * others));
  double *square = KM_ARENA_NEW(l->arena, double, (size_t)(others * others)),
         *b = KM_ARENA_NEW(l->arena, double, (size_t)others);
  km_factor *normal = km_factor_create(others, others, NULL, l->arena);
  if (l->arena->failed)
    return false;
  for (int o = 0; o < others; ++o)
    for (int i = 0; i < rows; ++i)
      for (int r = 0; r < k; ++r)
        A[o * rows + i] += l->Q[i * k + r] * p->V[(p->count + o) * k + r];
  for (int o = 0; o < others; ++o)
    for (int i = 0; i < rows; ++i) {
      b[o] -= A[o * rows + i] * defect[i];
      for (int q = 0; q < others; ++q)
        square[q * others + o] += A[o * rows + i] * A[q * rows + i];
    }
  km_factor_compute(normal, square, others, others, &(km_factor_options){.tolerance = 1e-12});
  km_factor_solve(normal, b, y);
  return km_factor_rank(normal) == others;
}

/* The deflation step in the scaled coordinates, corrected along U so that the driver is fixed. Returns |x|_∞; infinite:
 * there is no step. */
static double compute_deflation_step(const km_constant_rank *st, const tangent_split *p, int driver, double *x) {
  km_local *l = p->l;
  int k = l->freedom, n = l->sub->columns;
  double *defect = KM_ARENA_NEW(l->arena, double, (size_t)(l->conditions * k)), largest = 0.0;
  double *y = KM_ARENA_NEW(l->arena, double, (size_t)k), *t = l->tangent;
  if (l->arena->failed || !km_local_rank_defect(l, defect) || !solve_deflation(p, defect, y) ||
      (driver >= 0 && !km_constant_rank_tangent(st, l->m, l->index, driver, NULL, t)))
    return HUGE_VAL;
  memset(l->a, 0, (size_t)k * sizeof *l->a);
  for (int o = 0; o < k - p->count; ++o)
    for (int r = 0; r < k; ++r)
      l->a[r] += y[o] * p->V[(p->count + o) * k + r];
  km_local_direction(l, l->a, x);
  double driver_part = driver >= 0 ? x[driver] : 0.0;
  for (int c = 0; c < n; ++c) {
    x[c] -= driver_part * t[c];
    largest = fmax(largest, fabs(x[c]));
  }
  return largest;
}

/* Applies one deflation step if it is shorter than the last one. Returns its size: 0 converged, infinite if no motion
 * is close. */
static double apply_deflation_step(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                                   double last) {
  const km_substructure *sub = &m->substructures[index];
  km_arena arena = {0};
  tangent_split p = {0};
  double *x = KM_ARENA_NEW(&arena, double, (size_t)sub->columns), size = HUGE_VAL;
  if (x && split_tangents(&p, m, s, index, st->count, st->rank_tolerance, &arena) &&
      km_factor_rank(s->factor[index]) == st->rank && store_tangents(st, &p))
    size = compute_deflation_step(st, &p, driver, x);
  if (size > km_solved_rounding && size < km_longest_arc_step && size < last)
    km_state_move(m, s, sub, x);
  km_arena_free(&arena);
  return size <= km_solved_rounding ? 0.0 : size < km_longest_arc_step ? size : HUGE_VAL;
}

/* Closes the primary rows to full accuracy: the last Newton step, below the tolerance, is applied too. */
static bool close_exactly(const km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                          km_closure *evidence) {
  const km_pivoting pivoting = {.driver = driver, .min_relative_pivot = st->rank_tolerance};
  if (km_loops_close_by(m, s, index, &pivoting, evidence) == KM_OPEN)
    return false;
  km_state_move(m, s, &m->substructures[index], evidence->last_step);
  return true;
}

/* Alternates deflation steps and closing until convergence. */
static bool deflate(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                    km_closure *evidence) {
  enum { MAX_STEPS = 8 };
  double size = HUGE_VAL;
  for (int i = 0; i < MAX_STEPS && size != 0.0; ++i) {
    double last = size;
    size = apply_deflation_step(st, m, s, index, driver, last);
    if (size >= last) /* step no longer decreases: converged to rounding, or diverging */
      return last < km_relative_zero;
    if (size != 0.0 && !close_exactly(st, m, s, index, driver, evidence))
      return false;
  }
  return size < km_relative_zero;
}

static void update_rank_tolerance(km_constant_rank *st, const km_factor *p) {
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  st->rank_tolerance = evidence.last_pivot / (km_max_pivot_shrinkage * evidence.scale);
}

/* Largest residual of secondary rows on the motion: the stated closure tolerance, else that of exact data. */
static double max_residual(const km_mechanism *m) {
  return m->closure_tolerance_given ? m->closure_tolerance : km_exact_misfit;
}

/* Closes the loops onto the permanently shaky motion: Newton's method, then deflation. */
bool km_constant_rank_close(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                            km_closure *evidence) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  bool converged = close_exactly(st, m, s, index, driver, evidence);
  double correction = evidence->correction;
  converged = converged && deflate(st, m, s, index, driver, evidence);
  km_loops_update(m, s, sub);
  evidence->residual = km_loops_residual(m, s, sub);
  evidence->correction = correction;
  km_search_pivots(m, s, index, driver, st->rank_tolerance);
  converged = converged && km_factor_rank(p) == st->rank && evidence->residual <= max_residual(m);
  if (converged)
    update_rank_tolerance(st, p);
  return converged;
}

/* Recomputes the constant-rank tangents; false if rank or dimension changed. */
bool km_constant_rank_update(km_constant_rank *st, const km_mechanism *m, km_state *s, int index) {
  km_arena arena = {0};
  tangent_split at_start = {0};
  bool converged = split_tangents(&at_start, m, s, index, st->count, 0.0, &arena) &&
                   km_factor_rank(s->factor[index]) == st->rank && store_tangents(st, &at_start);
  km_arena_free(&arena);
  return converged;
}

/* LOOPS_OPEN: the loops do not close after the step. RANK_CHANGED: they close or nearly close, with another rank or
 * dimension. */
typedef enum step_outcome { STEP_ACCEPTED, LOOPS_OPEN, RANK_CHANGED } step_outcome;

/* Steps along the constant-rank tangents, by the driver or along `direction`, which becomes the step's tangent. */
static step_outcome step_along_motion(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                                      double step, double *direction) {
  const km_substructure *sub = &m->substructures[index];
  km_closure evidence;
  double fastest = 0.0, *x = s->projection;
  if (!km_constant_rank_tangent(st, m, index, driver, direction, x))
    return LOOPS_OPEN;
  for (int c = 0; c < sub->columns; ++c) {
    direction[c] = x[c];
    fastest = fmax(fastest, fabs(x[c]));
  }
  for (int c = 0; c < sub->columns; ++c)
    x[c] *= step / fastest;
  km_state_move(m, s, sub, x);
  km_state_invalidate_pivots(s, index);
  if (!km_constant_rank_close(st, m, s, index, driver, &evidence))
    return evidence.residual > fabs(step * step * step) ? LOOPS_OPEN : RANK_CHANGED; /* a contact above third order */
  km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, evidence.residual);
  bool exact = m->closure_tolerance_given || evidence.residual <= km_solved_rounding;
  return exact && km_factor_rank(s->factor[index]) == st->rank ? STEP_ACCEPTED : RANK_CHANGED;
}

/* True if rank and dimension stay for four steps ahead or back. The end of a motion can be near on either side; shorter
 * steps decide then. */
static bool keeps_rank_along_motion(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                                    double *saved, double *direction) {
  static const double steps[] = {0.025, -0.025, 0.00625, -0.00625};
  enum { TRIES = sizeof steps / sizeof *steps, STEPS = 4 };
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  const double rank_tolerance = st->rank_tolerance;
  step_outcome end = LOOPS_OPEN;
  km_state_save(s, sub, saved);
  for (int try = 0; try < TRIES && end == LOOPS_OPEN; ++try) {
    end = km_constant_rank_update(st, m, s, index) ? STEP_ACCEPTED : RANK_CHANGED;
    for (int c = 0; c < sub->columns; ++c)
      direction[c] = st->Z[c] / weight[c]; /* the first tangent is used without a driver */
    for (int i = 0; i < STEPS && end == STEP_ACCEPTED; ++i)
      end = step_along_motion(st, m, s, index, driver, steps[try], direction);
    km_loops_restore_cached(m, s, index, saved);
    st->rank_tolerance = rank_tolerance;
  }
  return end == STEP_ACCEPTED;
}

/* Tests for permanent shakiness: U is proper, other tangents violate second order, rank stays along U. */
static bool begin_motion(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                         km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  size_t n = (size_t)sub->columns;
  tangent_split at_start = {0};
  if (!split_tangents(&at_start, m, s, index, 0, 0.0, arena) || may_others_be_finite(&at_start))
    return false;
  st->rank = km_factor_rank(p);
  km_update_and_search_pivots(m, s, index, driver, 0.0); /* pivots with the driver forced: near its dead point the last
                                                          * pivot is small */
  update_rank_tolerance(st, p);
  double *saved = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n), *x = KM_ARENA_NEW(arena, double, n);
  return !arena->failed && store_tangents(st, &at_start) &&
         keeps_rank_along_motion(st, m, s, index, driver, saved, x) && store_tangents(st, &at_start);
}

/* Tests a configuration for permanent shakiness if its size allows. */
bool km_constant_rank_begin(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                            km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  km_arena scratch = {0};
  int freedom = km_factor_freedom(p);
  st->is_active = false;
  if (freedom < 2 || freedom > KM_MANY_VECTORS || km_factor_rank(p) == sub->rows || !km_local_is_small(sub))
    return true;
  if (st->capacity < freedom) {
    st->Z = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)sub->columns);
    st->capacity = st->Z ? freedom : 0;
  }
  st->is_active = st->capacity >= freedom && begin_motion(st, m, s, index, driver, &scratch);
  bool is_ok = st->capacity >= freedom && !scratch.failed;
  km_arena_free(&scratch);
  km_update_and_search_pivots(m, s, index, driver, 0.0);
  return is_ok;
}

/* Restricts the tangents to U if the mechanism is permanently shaky and all tangents of U are finite. */
int km_local_restrict_to_constant_rank(km_local *l, double *directions) {
  km_constant_rank motion = {0};
  km_local all = *l;
  km_arena scratch = {0};
  int k = l->freedom, n = l->sub->columns, count = 0;
  km_state_restore(l->s, l->sub, l->origin);
  km_update_and_search_pivots(l->m, l->s, l->index, KM_NO_DRIVER, l->residual);
  double *V = KM_ARENA_NEW(&scratch, double, (size_t)(k * k) + 1);
  bool is_ok = V && km_constant_rank_begin(&motion, l->m, l->s, l->index, KM_NO_DRIVER, &scratch);
  for (int i = 0; i < motion.count && motion.is_active && is_ok; ++i) {
    for (int c = 0; c < n; ++c)
      l->direction[c] = motion.Z[(size_t)i * (size_t)n + (size_t)c] / l->weight[c];
    count += km_local_coefficients(l, l->direction, l->a) > KM_INDEPENDENT && count < k &&
             km_append_orthonormal(V, count, k, l->a);
  }
  if (count > 0 && count < k && km_complete_basis(V, count, k)) {
    for (int i = count; i < k && directions; ++i)
      km_local_direction(l, V + i * k, directions + (size_t)(i - count) * (size_t)n);
    is_ok = km_local_restrict(l, V, count);
    l->conditions = 0;
    if (!is_ok || !km_local_is_regular(l)) {
      *l = all;
      count = 0;
    }
  } else
    count = 0;
  l->arena->failed = l->arena->failed || !is_ok;
  km_arena_free(&scratch);
  return count > 0 ? k - count : 0;
}
