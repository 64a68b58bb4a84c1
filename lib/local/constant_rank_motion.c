/* Following the motions of mechanisms that shake all along them. */
#include "local/constant_rank_motion.h"
#include "local/constant_rank_basis.h"

#include "kinematics/loop_equations.h"
#include "linalg/partition.h"

#include <string.h>

bool km_constant_rank_tangent(const km_constant_rank *st, const km_mechanism *m, int index, int driver,
                              const double *along, double *t) {
  static const double hardly = 1e-6;
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  int n = sub->columns;
  memset(t, 0, (size_t)n * sizeof *t);
  for (int i = 0; i < st->count; ++i) {
    const double *z = st->Z + (size_t)i * (size_t)n;
    double dot = driver >= 0 ? z[driver] : 0.0;
    for (int c = 0; c < n && driver < 0; ++c)
      dot += z[c] * weight[c] * along[c];
    for (int c = 0; c < n; ++c)
      t[c] += dot * z[c];
  }
  for (int c = 0; c < n; ++c)
    t[c] /= weight[c];
  double size = km_step_length(m, sub, t), unit = driver >= 0 ? t[driver] : size;
  for (int c = 0; c < n; ++c)
    t[c] /= unit;
  return size > hardly;
}

/* What the null space of a pose consists of. */
typedef struct split {
  km_second_order c;
  double *V; /* [freedom × freedom] shares: the steady ones, and the others behind them */
  int steady;
} split;

/* `count`: how many tangents are steady on the motion; 0: that is not known. */
static bool find_split(split *p, const km_mechanism *m, km_state *s, int index, int count, km_arena *arena) {
  if (!km_second_order_count_tangents(m, s, index, &p->c) || p->c.freedom < 1 ||
      !km_second_order_create_basis(m, s, index, arena, &p->c) || !km_second_order_build_all(m, s, index, arena, &p->c))
    return false;
  p->steady = km_constant_rank_basis(&p->c, count, arena, &p->V);
  return p->steady > 0 && (count == 0 || p->steady == count);
}

static bool keep_tangents(km_constant_rank *st, const split *p) {
  if (p->steady > st->capacity)
    return false;
  st->count = p->steady;
  for (int i = 0; i < st->count; ++i)
    km_second_order_combine(&p->c, p->V + i * p->c.freedom, st->Z + (size_t)i * (size_t)p->c.columns);
  return true;
}

/* Newton's step: shares y of the others with Σ Q_i(v, others y) = −w_iᵀ J z_v for all i and v, by least squares. */
static bool solve_shares(const split *p, const double *changes, km_arena *arena, double *y) {
  int k = p->c.freedom, others = k - p->steady, rows = p->c.conditions * k;
  double *A = KM_ARENA_NEW(arena, double, (size_t)(rows * others));
  double *square = KM_ARENA_NEW(arena, double, (size_t)(others * others)),
         *b = KM_ARENA_NEW(arena, double, (size_t)others);
  km_partition normal;
  if (arena->failed || !km_partition_reserve(&normal, others, others, arena))
    return false;
  for (int o = 0; o < others; ++o)
    for (int i = 0; i < rows; ++i)
      for (int r = 0; r < k; ++r)
        A[o * rows + i] += p->c.Q[i * k + r] * p->V[(p->steady + o) * k + r];
  for (int o = 0; o < others; ++o)
    for (int i = 0; i < rows; ++i) {
      b[o] -= A[o * rows + i] * changes[i];
      for (int q = 0; q < others; ++q)
        square[q * others + o] += A[o * rows + i] * A[q * rows + i];
    }
  km_partition_factor(&normal, square, others, others, NULL, 1e-12);
  km_partition_solve(&normal, b, y);
  return normal.rank == others;
}

/* That step as one of the coordinates, with the driver where it is; returns its largest entry, infinite: there is none. */
static double find_step(km_constant_rank *st, const split *p, const km_mechanism *m, km_state *s, int index, int driver,
                        km_arena *arena, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  int k = p->c.freedom, n = sub->columns;
  double *changes = KM_ARENA_NEW(arena, double, (size_t)(p->c.conditions * k)), largest = 0.0;
  double *y = KM_ARENA_NEW(arena, double, (size_t)k), *t = KM_ARENA_NEW(arena, double, (size_t)n);
  double *shares = KM_ARENA_NEW(arena, double, (size_t)k);
  if (arena->failed || !km_second_order_rank_defect(m, s, index, &p->c, changes) ||
      !solve_shares(p, changes, arena, y) || (driver >= 0 && !km_constant_rank_tangent(st, m, index, driver, NULL, t)))
    return HUGE_VAL;
  for (int o = 0; o < k - p->steady; ++o)
    for (int r = 0; r < k; ++r)
      shares[r] += y[o] * p->V[(p->steady + o) * k + r];
  km_second_order_combine(&p->c, shares, x);
  for (int c = 0; c < n; ++c)
    x[c] /= weight[c];
  double back = driver >= 0 ? x[driver] : 0.0;
  for (int c = 0; c < n; ++c) {
    x[c] -= back * t[c];
    largest = fmax(largest, fabs(x[c]));
  }
  return largest;
}

/* One step towards the motion, if it is shorter than the last one; returns its size, infinite: there is no motion near by. */
static double settle_once(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                          double last) {
  static const double most = 0.05, found = 1e-13;
  const km_substructure *sub = &m->substructures[index];
  km_arena arena = {0};
  split p = {0};
  double *x = KM_ARENA_NEW(&arena, double, (size_t)sub->columns), size = HUGE_VAL;
  if (x && find_split(&p, m, s, index, st->count, &arena) && s->partition[index].rank == st->rank &&
      keep_tangents(st, &p))
    size = find_step(st, &p, m, s, index, driver, &arena, x);
  if (size > found && size < most && size < last)
    km_state_move(m, s, sub, x);
  km_arena_free(&arena);
  return size <= found ? 0.0 : size < most ? size : HUGE_VAL;
}

/* Closes the primary equations by all digits: the step that is too small for closing is taken too. */
static bool close_exactly(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  if (km_loops_close(m, s, index, driver, evidence) == KM_OPEN)
    return false;
  km_state_move(m, s, &m->substructures[index], evidence->last_step);
  return true;
}

static bool settle(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                   km_closure *evidence) {
  enum { MOST_STEPS = 8 };
  static const double settled = 1e-9;
  double size = HUGE_VAL;
  for (int i = 0; i < MOST_STEPS && size != 0.0; ++i) {
    double last = size;
    size = settle_once(st, m, s, index, driver, last);
    if (size >= last) /* rounding is left, or it leads nowhere */
      return last < settled;
    if (size != 0.0 && !close_exactly(m, s, index, driver, evidence))
      return false;
  }
  return size < settled;
}

static void take_blunt(km_constant_rank *st, const km_partition *p) {
  static const double part = 0.1;
  st->rank_tolerance = part * p->last_pivot / p->scale;
}

/* What closed loops of data that aren't rounded keep at most, where they are on the motion. */
static double most_residual(const km_mechanism *m) {
  static const double exact = 1e-11;
  return m->closure_tolerance_given ? m->closure_tolerance : exact;
}

bool km_constant_rank_close(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                            km_closure *evidence) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  int worst;
  p->min_relative_pivot = st->rank_tolerance;
  bool found = close_exactly(m, s, index, driver, evidence);
  double correction = evidence->correction;
  found = found && settle(st, m, s, index, driver, evidence);
  km_loops_update(m, s, sub);
  evidence->residual = km_loops_residual(m, s, sub, &worst);
  evidence->correction = correction;
  km_search_pivots(m, s, index, driver, st->rank_tolerance);
  p->min_relative_pivot = 0.0;
  found = found && p->rank == st->rank && evidence->residual <= most_residual(m);
  if (found)
    take_blunt(st, p);
  return found;
}

bool km_constant_rank_update(km_constant_rank *st, const km_mechanism *m, km_state *s, int index) {
  km_arena arena = {0};
  split here = {0};
  bool found = find_split(&here, m, s, index, st->count, &arena) && s->partition[index].rank == st->rank &&
               keep_tangents(st, &here);
  km_arena_free(&arena);
  return found;
}

/* BLOCKED: the loops don't close there. REFUTED: they nearly do, or all the way, but what shakes at the pose doesn't shake there. */
typedef enum progress { GONE_ON, BLOCKED, REFUTED } progress;

/* A step on along the steady tangents, with the driver or as `along` goes, which becomes the step's tangent. */
static progress go_on(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver, double step,
                      double *along) {
  const km_substructure *sub = &m->substructures[index];
  static const double open = 1e-5; /* a misfit that no tangency of high order makes in a step */
  km_closure evidence;
  double fastest = 0.0, *x = s->projection;
  if (!km_constant_rank_tangent(st, m, index, driver, along, x))
    return BLOCKED;
  for (int c = 0; c < sub->columns; ++c) {
    along[c] = x[c];
    fastest = fmax(fastest, fabs(x[c]));
  }
  for (int c = 0; c < sub->columns; ++c)
    x[c] *= step / fastest;
  km_state_move(m, s, sub, x);
  km_state_invalidate_pivots(s, index);
  if (!km_constant_rank_close(st, m, s, index, driver, &evidence))
    return evidence.residual > open ? BLOCKED : REFUTED;
  km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, evidence.residual);
  bool exact = m->closure_tolerance_given || evidence.residual <= km_residual_tolerance;
  return exact && s->partition[index].rank == st->rank ? GONE_ON : REFUTED;
}

/* Is what shakes at the pose the same for a while, ahead or back? What ends a motion may be near on one side, or on both: then short steps
 * tell it too, though less surely. */
static bool lasts(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver, double *saved,
                  double *along) {
  static const double steps[] = {0.025, -0.025, 0.00625, -0.00625};
  enum { TRIES = sizeof steps / sizeof *steps, STEPS = 4 };
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  const double blunt = st->rank_tolerance;
  progress end = BLOCKED;
  km_state_save(s, sub, saved);
  for (int try = 0; try < TRIES && end == BLOCKED; ++try) {
    end = km_constant_rank_update(st, m, s, index) ? GONE_ON : REFUTED;
    for (int c = 0; c < sub->columns; ++c)
      along[c] = st->Z[c] / weight[c]; /* without a driver the first tangent is as good as any */
    for (int i = 0; i < STEPS && end == GONE_ON; ++i)
      end = go_on(st, m, s, index, driver, steps[try], along);
    km_loops_restore_cached(m, s, index, saved);
    st->rank_tolerance = blunt;
  }
  return end == GONE_ON;
}

static bool begin(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver, km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  size_t n = (size_t)sub->columns;
  split here = {0};
  if (!find_split(&here, m, s, index, 0, arena) ||
      km_constant_rank_others_may_be_finite(&here.c, here.V, here.steady, arena))
    return false;
  st->rank = p->rank;
  km_update_and_search_pivots(m, s, index, driver, 0.0); /* near a dead point of the driver its last pivot is small */
  take_blunt(st, p);
  double *saved = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n), *x = KM_ARENA_NEW(arena, double, n);
  return !arena->failed && keep_tangents(st, &here) && lasts(st, m, s, index, driver, saved, x) &&
         keep_tangents(st, &here);
}

bool km_constant_rank_begin(km_constant_rank *st, const km_mechanism *m, km_state *s, int index, int driver,
                            km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  km_arena scratch = {0};
  int freedom = km_partition_freedom(p);
  st->is_active = false;
  if (freedom < 2 || freedom > KM_MANY_VECTORS || p->rank == sub->rows || !km_constant_rank_is_small(sub))
    return true;
  if (st->capacity < freedom) {
    st->Z = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)sub->columns);
    st->capacity = st->Z ? freedom : 0;
  }
  st->is_active = st->capacity >= freedom && begin(st, m, s, index, driver, &scratch);
  bool whole = st->capacity >= freedom && !scratch.failed;
  km_arena_free(&scratch);
  km_update_and_search_pivots(m, s, index, driver, 0.0);
  return whole;
}
