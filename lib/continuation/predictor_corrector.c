/* Predictor, corrector and memory of a step along a motion. */
#include "continuation/predictor_corrector.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "local/sampled_tangents.h"

#include <string.h>

bool km_step_history_reserve(km_step_history *course, const km_continuation *c, km_arena *arena) {
  const km_substructure *sub = km_continuation_sub(c);
  size_t n = (size_t)sub->columns;
  course->t = KM_ARENA_NEW(arena, double, n);
  course->last_t = KM_ARENA_NEW(arena, double, n);
  course->last_move = KM_ARENA_NEW(arena, double, n);
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    course->older_t[i] = KM_ARENA_NEW(arena, double, n);
  course->rest = KM_ARENA_NEW(arena, double, n);
  for (int i = 0; i < KM_CURVE_MOVES; ++i)
    course->moves[i] = KM_ARENA_NEW(arena, double, n);
  return km_partition_reserve_like(&course->reference, &c->state->partition[c->substructure], sub->rows, sub->columns,
                                   arena);
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
  memcpy(to->rest, from->rest, bytes);
  to->equal_count = from->equal_count;
  for (int i = 0; i < from->equal_count; ++i)
    memcpy(to->moves[i], from->moves[i], bytes);
  km_partition_copy_pivots(&to->reference, &from->reference);
}

void km_step_history_begin(km_step_history *course, int columns) {
  course->last_h = 0.0;
  course->equal_count = 0;
  memset(course->rest, 0, (size_t)columns * sizeof *course->rest);
}

bool km_continuation_reserve(km_continuation *c, km_arena *arena) {
  size_t n = (size_t)km_continuation_sub(c)->columns;
  c->next_t = KM_ARENA_NEW(arena, double, n);
  c->next_rest = KM_ARENA_NEW(arena, double, n);
  c->move = KM_ARENA_NEW(arena, double, n);
  c->work = KM_ARENA_NEW(arena, double, n);
  c->from = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  return km_step_history_reserve(&c->course, c, arena);
}

double km_continuation_dot(const km_continuation *c, const double *a, const double *b) {
  return km_step_dot(c->mechanism, km_continuation_sub(c), a, b);
}

/* D⁻¹ Z Zᵀ D `from`, at unit length. */
static bool project(km_continuation *c, const double *from, double *t) {
  const km_substructure *sub = km_continuation_sub(c);
  const double *weight = c->mechanism->column_weight + sub->column_start;
  int freedom = km_partition_freedom(&c->state->partition[c->substructure]);
  if (freedom > KM_MANY_VECTORS) {
    memmove(t, from, (size_t)sub->columns * sizeof *t);
    return km_tangent_project(c->mechanism, c->state, c->substructure, t, c->work) > 1e-6;
  }
  const double *Z = km_state_null_space(c->mechanism, c->state, c->substructure, freedom);
  if (!Z)
    return false;
  memset(c->work, 0, (size_t)sub->columns * sizeof *c->work);
  for (int i = 0; i < freedom; ++i) {
    const double *z = Z + (size_t)i * (size_t)sub->columns;
    double dot = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      dot += z[k] * weight[k] * from[k];
    for (int k = 0; k < sub->columns; ++k)
      c->work[k] += dot * z[k];
  }
  double size = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    size += c->work[k] * c->work[k];
  size = sqrt(size);
  for (int k = 0; k < sub->columns; ++k)
    t[k] = c->work[k] / (size * weight[k]);
  return size > 1e-6;
}

bool km_continuation_tangent(km_continuation *c, const double *along, double *t) {
  const km_partition *p = &c->state->partition[c->substructure];
  if (c->steady.is_active)
    return km_constant_rank_tangent(&c->steady, c->mechanism, c->substructure, c->column, along, t);
  if (c->column < 0)
    return project(c, along, t);
  if (p->forced_dependent)
    return false;
  km_minimum_norm_rates(c->mechanism, c->state, c->substructure, c->column, t);
  return true;
}

static bool as_long(double h, double other) {
  return fabs(h - other) <= km_continuation_same * fabs(h);
}

/* The polynomial through nine poses in place of the cubic, where they agree. Two sums, that don't wait for each other. */
static void look_farther(km_continuation *c, double h) {
  const km_step_history *course = &c->course;
  const int columns = km_continuation_sub(c)->columns;
  double apart = 0.0;
  for (int k = 0; k < columns; ++k) {
    double even = h * (km_curve_tangents[0] * course->t[k] + km_curve_tangents[1] * course->last_t[k]);
    double odd = course->rest[k];
    for (int i = 0; i < KM_CURVE_MOVES; i += 2) {
      even += km_curve_moves[i] * course->moves[i][k];
      odd += km_curve_moves[i + 1] * course->moves[i + 1][k];
    }
    c->work[k] = even + odd;
    apart = km_larger(fabs(c->work[k] - c->move[k]), apart);
  }
  if (!(apart <= km_continuation_agreement * fabs(h)))
    return;
  double *cubic = c->move;
  c->move = c->work;
  c->work = cubic;
}

void km_continuation_predict(km_continuation *c, double h, bool alone) {
  const km_step_history *course = &c->course;
  int columns = km_continuation_sub(c)->columns;
  bool known = course->last_h != 0.0 && fabs(h) <= km_continuation_farther * fabs(course->last_h);
  if (known && alone) {
    km_curve_ahead(columns, course->last_h, course->last_move, course->last_t, course->t, h, c->move);
    bool equal = course->equal_count == KM_CURVE_MOVES && as_long(h, course->last_h);
    if (equal && c->column >= 0 && c->mechanism->ball_count == 0)
      look_farther(c, h);
    return;
  }
  double slope = known ? 0.5 * h / course->last_h : 0.0;
  for (int k = 0; k < columns; ++k)
    c->move[k] = known ? h * (course->t[k] + slope * (course->t[k] - course->last_t[k])) : h * course->t[k];
}

void km_continuation_place(km_continuation *c, double parameter) {
  c->state->q[c->coordinate] = parameter * c->mechanism->unit[c->coordinate];
}

/* Closes the loops where the step has led. The first step by arc length may begin at a singular configuration, beside
 * which rows that count look dependent as long as the loops are open. */
static bool close(km_continuation *c, km_closure *evidence) {
  if (c->steady.is_active)
    return km_constant_rank_close(&c->steady, c->mechanism, c->state, c->substructure, c->column, evidence);
  if (c->column < 0 && c->course.last_h == 0.0)
    return km_close_fully(km_loops_close, c->mechanism, c->state, c->substructure, c->column, evidence) == KM_CLOSED;
  return km_loops_close(c->mechanism, c->state, c->substructure, c->column, evidence) == KM_CLOSED;
}

km_step_outcome km_continuation_correct(km_continuation *c, const km_step_terms *terms) {
  const double *t = c->course.t, *next = c->next_t;
  km_closure evidence;
  km_state_move(c->mechanism, c->state, km_continuation_sub(c), c->move);
  if (c->column >= 0)
    km_continuation_place(c, terms->parameter);
  if (!close(c, &evidence) || !km_continuation_tangent(c, t, c->next_t))
    return KM_STEP_OPEN;
  memcpy(c->next_rest, evidence.last_step, (size_t)km_continuation_sub(c)->columns * sizeof *c->next_rest);
  const km_partition *p = &c->state->partition[c->substructure];
  if (p->rank < terms->least_rank || (km_continuation_is_singular(p) && !terms->leaves_end))
    return KM_STEP_OPEN; /* a singular pose has no tangent of its own */
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
  return passed >= 0 ? passed : km_state_limit_touched(c->state, sub, c->from, c->course.t, c->next_t, h);
}

/* The last step becomes an older one before a step of h; returns the tangent that is given up. On the way back the
 * same poses come again. */
static double *grow_older(km_step_history *course, double h, bool alone) {
  if (alone || course->last_h == 0.0 || h * course->last_h < 0.0) {
    course->older_count = 0;
    return course->last_t;
  }
  double *spare = course->older_t[KM_OLDER_STEPS - 1];
  for (int i = KM_OLDER_STEPS - 1; i > 0; --i) {
    course->older_t[i] = course->older_t[i - 1];
    course->older_h[i] = course->older_h[i - 1];
  }
  course->older_t[0] = course->last_t;
  course->older_h[0] = course->last_h;
  course->older_count += course->older_count < KM_OLDER_STEPS;
  return spare;
}

/* The last move joins those that are right to the last digit. */
static void grow_moves(km_continuation *c, double h) {
  km_step_history *course = &c->course;
  double *move = course->moves[KM_CURVE_MOVES - 1], *rest = c->next_rest;
  for (int i = KM_CURVE_MOVES - 1; i > 0; --i)
    course->moves[i] = course->moves[i - 1];
  for (int k = 0; k < km_continuation_sub(c)->columns; ++k)
    move[k] = course->last_move[k] + (rest[k] - course->rest[k]);
  course->moves[0] = move;
  c->next_rest = course->rest;
  course->rest = rest;
  course->equal_count = !as_long(h, course->last_h) ? 1 : course->equal_count + (course->equal_count < KM_CURVE_MOVES);
}

void km_continuation_accept(km_continuation *c, double h) {
  km_step_history *course = &c->course;
  bool alone = km_partition_freedom(&c->state->partition[c->substructure]) <= 1;
  double *spare = grow_older(course, h, alone);
  km_state_difference(c->state, km_continuation_sub(c), c->from, course->last_move);
  if (alone)
    grow_moves(c, h);
  else
    course->equal_count = 0;
  course->last_t = course->t;
  course->t = c->next_t;
  c->next_t = spare;
  course->last_h = h;
  km_partition_copy_pivots(&course->reference, &c->state->partition[c->substructure]);
}

void km_continuation_reject(km_continuation *c) {
  km_state_restore(c->state, km_continuation_sub(c), c->from);
  km_state_invalidate_pivots(c->state, c->substructure);
}

double km_continuation_arc(const km_continuation *c, const double *move, const double *t0, const double *t1) {
  static const double node[5] = {0.5, 0.23076534494715845, 0.7692346550528415, 0.046910077030668, 0.953089922969332};
  static const double share[5] = {0.28444444444444444, 0.23931433524968324, 0.23931433524968324, 0.11846344252809454,
                                  0.11846344252809454};
  const km_substructure *sub = km_continuation_sub(c);
  const double *weight = c->mechanism->column_weight + sub->column_start;
  double sign = km_continuation_dot(c, move, t0) < 0.0 ? -1.0 : 1.0;
  double length = sign * sqrt(km_continuation_dot(c, move, move));
  for (int pass = 0; pass < 4; ++pass) {
    double sum = 0.0;
    for (int i = 0; i < 5; ++i) {
      double u = node[i], d01 = 6 * u * (1 - u), d10 = (1 - u) * (1 - 3 * u), d11 = u * (3 * u - 2), square = 0.0;
      for (int k = 0; k < sub->columns; ++k) {
        double d = weight[k] * (d01 * move[k] + length * (d10 * t0[k] + d11 * t1[k]));
        square += d * d;
      }
      sum += share[i] * sqrt(square);
    }
    length = sign * sum;
  }
  return length;
}
