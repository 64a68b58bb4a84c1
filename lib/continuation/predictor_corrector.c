/* Predictor, corrector and history of a step along a motion (theory 4.5, 4.6, 4.9).
 *
 *   cubic     : Hermite polynomial through the last two configurations and tangents, extrapolated by h
 *   degree 10 : through nine equidistant configurations and two tangents (hermite_curve.h)
 *   Adams     : h (t + h / (2 h_last) (t - t_last)),  several freedoms
 *   corrector : minimum-norm Newton steps (loop_closing.h), or the augmented system of constant-rank motions */
#include "continuation/predictor_corrector.h"

#include "base/extrema.h"
#include "base/number/gauss_legendre.h"
#include "kinematics/loop_closing.h"
#include "local/local.h"

#include <string.h>

bool km_step_history_reserve(km_step_history *history, const km_continuation *c, km_arena *arena) {
  size_t n = (size_t)km_continuation_sub(c)->columns;
  history->t = KM_ARENA_NEW(arena, double, n);
  history->last_t = KM_ARENA_NEW(arena, double, n);
  history->last_move = KM_ARENA_NEW(arena, double, n);
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    history->older_t[i] = KM_ARENA_NEW(arena, double, n);
  history->remaining_step = KM_ARENA_NEW(arena, double, n);
  for (int i = 0; i < KM_CURVE_MOVES; ++i)
    history->moves[i] = KM_ARENA_NEW(arena, double, n);
  history->reference = km_factor_create_like(c->state->factor[c->substructure], arena);
  return history->reference != NULL;
}

void km_step_history_copy(km_step_history *to, const km_step_history *from, int columns) {
  size_t bytes = (size_t)columns * sizeof *to->t;
  memcpy(to->t, from->t, bytes);
  memcpy(to->last_t, from->last_t, bytes);
  memcpy(to->last_move, from->last_move, bytes);
  to->last_h = from->last_h;
  to->older_count = from->older_count;
  for (int i = 0; i < from->older_count; ++i) {
    memcpy(to->older_t[i], from->older_t[i], bytes);
    to->older_h[i] = from->older_h[i];
  }
  memcpy(to->remaining_step, from->remaining_step, bytes);
  to->equal_count = from->equal_count;
  for (int i = 0; i < from->equal_count; ++i)
    memcpy(to->moves[i], from->moves[i], bytes);
  to->sign = from->sign;
  km_factor_copy_pivots(to->reference, from->reference);
}

void km_step_history_set_reference(km_step_history *history, const km_factor *factor) {
  km_factor_copy_pivots(history->reference, factor);
  history->sign = km_factor_sign(factor);
}

void km_step_history_begin(km_step_history *history, int columns) {
  history->last_h = 0.0;
  history->equal_count = 0;
  memset(history->remaining_step, 0, (size_t)columns * sizeof *history->remaining_step);
}

bool km_continuation_reserve(km_continuation *c, km_arena *arena) {
  size_t n = (size_t)km_continuation_sub(c)->columns;
  c->next_t = KM_ARENA_NEW(arena, double, n);
  c->next_remaining_step = KM_ARENA_NEW(arena, double, n);
  c->move = KM_ARENA_NEW(arena, double, n);
  c->work = KM_ARENA_NEW(arena, double, n);
  c->from = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  return km_step_history_reserve(&c->history, c, arena);
}

double km_continuation_dot(const km_continuation *c, const double *a, const double *b) {
  return km_step_dot(c->mechanism, km_continuation_sub(c), a, b);
}

bool km_continuation_tangent(km_continuation *c, const double *along, double *t) {
  const km_factor *p = c->state->factor[c->substructure];
  if (c->constant_rank.is_active)
    return km_constant_rank_tangent(&c->constant_rank, c->mechanism, c->substructure, c->column, along, t);
  if (c->column < 0) {
    memmove(t, along, (size_t)km_continuation_sub(c)->columns * sizeof *t);
    return km_tangent_project(c->mechanism, c->state, c->substructure, t, c->work) > 1e-6;
  }
  if (km_factor_has_forced_pivot(p))
    return false;
  km_minimum_norm_rates(c->mechanism, c->state, c->substructure, c->column, t);
  return true;
}

static bool is_equal_step(double h, double other) {
  return fabs(h - other) <= km_relative_zero * fabs(h);
}

/* Replaces the cubic prediction by the polynomial of degree 10 where both agree. Two partial sums, for
 * instruction-level parallelism. */
static void predict_degree_ten(km_continuation *c, double h) {
  const km_step_history *history = &c->history;
  const int columns = km_continuation_sub(c)->columns;
  double difference = 0.0;
  for (int k = 0; k < columns; ++k) {
    double even = h * (km_curve_tangents[0] * history->t[k] + km_curve_tangents[1] * history->last_t[k]);
    double odd = history->remaining_step[k];
    for (int i = 0; i < KM_CURVE_MOVES; i += 2) {
      even += km_curve_moves[i] * history->moves[i][k];
      odd += km_curve_moves[i + 1] * history->moves[i + 1][k];
    }
    c->work[k] = even + odd;
    difference = km_larger(fabs(c->work[k] - c->move[k]), difference);
  }
  if (!(difference <= km_continuation_predictor_agreement * fabs(h)))
    return;
  double *cubic = c->move;
  c->move = c->work;
  c->work = cubic;
}

void km_continuation_predict(km_continuation *c, double h, bool single_freedom) {
  const km_step_history *history = &c->history;
  int columns = km_continuation_sub(c)->columns;
  bool has_history = history->last_h != 0.0 && fabs(h) <= km_continuation_extrapolation_limit * fabs(history->last_h);
  if (has_history && single_freedom) {
    const km_cubic cubic = km_cubic_weights(h, history->last_h);
    for (int k = 0; k < columns; ++k)
      c->move[k] = km_cubic_value(&cubic, history->last_move[k], history->last_t[k], history->t[k]);
    bool equal = history->equal_count == KM_CURVE_MOVES && is_equal_step(h, history->last_h);
    if (equal && c->column >= 0 && c->mechanism->ball_count == 0)
      predict_degree_ten(c, h);
    return;
  }
  double slope = has_history ? 0.5 * h / history->last_h : 0.0;
  for (int k = 0; k < columns; ++k)
    c->move[k] = has_history ? h * (history->t[k] + slope * (history->t[k] - history->last_t[k])) : h * history->t[k];
}

void km_continuation_set_driver(km_continuation *c, double parameter) {
  c->state->q[c->coordinate] = parameter * c->mechanism->unit[c->coordinate];
}

/* Closes the loops at the predicted configuration. The first step by arc length can start at a singular
 * configuration, beside which independent rows look dependent while the loops are open; full closing finds the rank
 * again. */
static bool close_loops(km_continuation *c, km_closure *evidence) {
  if (c->constant_rank.is_active)
    return km_constant_rank_close(&c->constant_rank, c->mechanism, c->state, c->substructure, c->column, evidence);
  if (c->column < 0 && c->history.last_h == 0.0)
    return km_loops_close_fully(c->mechanism, c->state, c->substructure, &(km_pivoting){.driver = c->column},
                                evidence) == KM_CLOSED;
  return km_loops_close(c->mechanism, c->state, c->substructure, c->column, evidence) == KM_CLOSED;
}

km_step_outcome km_continuation_correct(km_continuation *c, const km_step_terms *terms) {
  const double *t = c->history.t, *next = c->next_t;
  km_closure evidence;
  km_state_move(c->mechanism, c->state, km_continuation_sub(c), c->move);
  if (c->column >= 0)
    km_continuation_set_driver(c, terms->parameter);
  if (!close_loops(c, &evidence) || !km_continuation_tangent(c, t, c->next_t))
    return KM_STEP_OPEN;
  memcpy(c->next_remaining_step, evidence.last_step,
         (size_t)km_continuation_sub(c)->columns * sizeof *c->next_remaining_step);
  const km_factor *p = c->state->factor[c->substructure];
  if (km_factor_rank(p) < terms->least_rank || (km_continuation_is_singular(p) && !terms->leaves_end))
    return KM_STEP_OPEN; /* no unique tangent in a singular configuration */
  double along = km_continuation_dot(c, t, next);
  double cosine = along / sqrt(km_continuation_dot(c, t, t) * km_continuation_dot(c, next, next));
  return evidence.correction <= terms->most_correction && cosine >= terms->least_cosine ? KM_STEP_ACCEPTED
                                                                                        : KM_STEP_TOO_LONG;
}

int km_continuation_limit(const km_continuation *c, double h) {
  const km_substructure *sub = km_continuation_sub(c);
  if (c->ignore_limits || sub->limited_count == 0)
    return -1;
  int passed = km_state_limit_passed(c->state, sub, c->from);
  return passed >= 0 ? passed : km_state_limit_touched(c->state, sub, c->from, c->history.t, c->next_t, h);
}

double km_continuation_step_to_limit(const km_continuation *c, int coordinate) {
  const km_mechanism *m = c->mechanism;
  double q = c->state->q[coordinate], low = m->low[coordinate], high = m->high[coordinate];
  double gap = ((fabs(high - q) < fabs(q - low) ? high : low) - q) / m->unit[coordinate] /
               c->history.t[m->column_of[coordinate]];
  return m->ball_of[coordinate] < 0 && fabs(gap) < km_singular_pivot ? gap : 0.0;
}

/* Shifts the tangents of earlier steps for Adams-Bashforth; returns the vector that drops out. A reversal clears
 * them, because the nodes must lie on one side. */
static double *push_older_tangents(km_step_history *history, double h, bool single_freedom) {
  if (single_freedom || history->last_h == 0.0 || h * history->last_h < 0.0) {
    history->older_count = 0;
    return history->last_t;
  }
  double *spare = history->older_t[KM_OLDER_STEPS - 1];
  for (int i = KM_OLDER_STEPS - 1; i > 0; --i) {
    history->older_t[i] = history->older_t[i - 1];
    history->older_h[i] = history->older_h[i - 1];
  }
  history->older_t[0] = history->last_t;
  history->older_h[0] = history->last_h;
  history->older_count += history->older_count < KM_OLDER_STEPS;
  return spare;
}

/* Shifts the moves of the degree-10 predictor and adds the last one, corrected by the Newton steps not applied at its
 * ends. */
static void push_move(km_continuation *c, double h) {
  km_step_history *history = &c->history;
  double *move = history->moves[KM_CURVE_MOVES - 1], *remaining_step = c->next_remaining_step;
  for (int i = KM_CURVE_MOVES - 1; i > 0; --i)
    history->moves[i] = history->moves[i - 1];
  for (int k = 0; k < km_continuation_sub(c)->columns; ++k)
    move[k] = history->last_move[k] + (remaining_step[k] - history->remaining_step[k]);
  history->moves[0] = move;
  c->next_remaining_step = history->remaining_step;
  history->remaining_step = remaining_step;
  history->equal_count =
      !is_equal_step(h, history->last_h) ? 1 : history->equal_count + (history->equal_count < KM_CURVE_MOVES);
}

void km_continuation_accept(km_continuation *c, double h) {
  km_step_history *history = &c->history;
  bool single_freedom = km_factor_freedom(c->state->factor[c->substructure]) <= 1;
  double *spare = push_older_tangents(history, h, single_freedom);
  km_state_difference(c->state, km_continuation_sub(c), c->from, history->last_move);
  if (single_freedom)
    push_move(c, h);
  else
    history->equal_count = 0;
  history->last_t = history->t;
  history->t = c->next_t;
  c->next_t = spare;
  history->last_h = h;
  km_step_history_set_reference(history, c->state->factor[c->substructure]);
}

void km_continuation_reject(km_continuation *c) {
  km_state_restore(c->state, km_continuation_sub(c), c->from);
  km_state_invalidate_pivots(c->state, c->substructure);
}

void km_continuation_rates(const km_continuation *c, const double *t, int stride, double scale, double *rates) {
  const km_substructure *sub = km_continuation_sub(c);
  memset(rates, 0, (size_t)c->mechanism->coordinate_count * sizeof *rates);
  for (int k = 0; k < sub->columns; ++k) {
    int a = c->mechanism->column_coordinate[sub->column_start + k];
    rates[a] = t[k * stride] * c->mechanism->unit[a] * scale;
  }
}

double km_continuation_arc_length(const km_continuation *c, const double *move, const double *t0, const double *t1) {
  const km_substructure *sub = km_continuation_sub(c);
  const double *weight = c->mechanism->column_weight + sub->column_start;
  double sign = km_continuation_dot(c, move, t0) < 0.0 ? -1.0 : 1.0;
  double length = sign * sqrt(km_continuation_dot(c, move, move));
  for (int pass = 0; pass < 4; ++pass) {
    double sum = 0.0;
    for (int i = 0; i < KM_GAUSS_POINTS; ++i) {
      double u = km_gauss_node[i], d01 = 6 * u * (1 - u), d10 = (1 - u) * (1 - 3 * u), d11 = u * (3 * u - 2),
             square = 0.0;
      for (int k = 0; k < sub->columns; ++k) {
        double d = weight[k] * (d01 * move[k] + length * (d10 * t0[k] + d11 * t1[k]));
        square += d * d;
      }
      sum += km_gauss_weight[i] * sqrt(square);
    }
    length = sign * sum;
  }
  return length;
}
