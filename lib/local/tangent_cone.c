/* Tangents of finite motions: random starts, second-order conditions, following in both senses (docs/theory.md
 * 5.2-5.4). */
#include "local/tangent_cone.h"

#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MAX_SECANT_STEPS = 5 }; /* secant iterations from a direction to that of a nearby motion */

/* Counts the tangents at the state's configuration and stores it. */
bool km_tangents_create(km_tangents *f, const km_mechanism *m, km_state *s, int index, km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  size_t n = (size_t)sub->columns;
  *f = (km_tangents){
      .m = m, .s = s, .index = index, .sub = sub, .min_verdict = KM_TANGENT_CONFIRMED, .random = 1, .arena = arena};
  arena->failed = !km_second_order_count_tangents(m, s, index, &f->conditions) || arena->failed;
  f->origin = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  f->last = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  f->end_ahead = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  f->x = KM_ARENA_NEW(arena, double, n);
  f->move = KM_ARENA_NEW(arena, double, n);
  f->direction = KM_ARENA_NEW(arena, double, n);
  f->chord = KM_ARENA_NEW(arena, double, n);
  f->secant = KM_ARENA_NEW(arena, double, n);
  if (arena->failed)
    return false;
  int worst;
  f->residual = km_loops_residual(m, s, sub, &worst);
  km_state_save(s, sub, f->origin);
  return true;
}

bool km_tangents_create_basis(km_tangents *f) {
  size_t k = (size_t)f->conditions.freedom;
  f->a = KM_ARENA_NEW(f->arena, double, k);
  f->previous = KM_ARENA_NEW(f->arena, double, k);
  f->length = KM_ARENA_NEW(f->arena, double, k);
  f->work = KM_ARENA_NEW(f->arena, double, 4 * k * k + 8 * k);
  if (f->arena->failed)
    return false;
  for (size_t i = 0; i < k; ++i)
    f->length[i] = -1.0;
  return km_second_order_create_basis(f->m, f->s, f->index, f->arena, &f->conditions);
}

/* Scaled tangent D⁻¹ Z a. */
void km_tangents_direction(const km_tangents *f, const double *a, double *x) {
  const double *weight = f->m->column_weight + f->sub->column_start;
  km_second_order_combine(&f->conditions, a, x);
  for (int c = 0; c < f->sub->columns; ++c)
    x[c] /= weight[c];
}

/* Averages the chords ahead and back into the secant: the curvature of the motion cancels to second order. */
static void add_to_secant(km_tangents *f, int sign) {
  double length = km_step_length(f->m, f->sub, f->chord);
  for (int c = 0; c < f->sub->columns; ++c)
    f->secant[c] = (sign > 0 ? 0.0 : f->secant[c]) + 0.5 * sign * f->chord[c] / length;
}

/* Follows a tangent ahead and back: the lower verdict and the shorter length. */
km_followed_tangent km_tangents_follow_both_senses(km_tangents *f, const double *direction) {
  km_followed_tangent worse = {HUGE_VAL, KM_TANGENT_CONFIRMED};
  for (int sign = 1; sign >= -1; sign -= 2) {
    km_followed_tangent followed = km_tangents_follow(f, direction, sign);
    f->has_undecided =
        f->has_undecided || followed.verdict == KM_TANGENT_LOST || followed.verdict == KM_TANGENT_UNDECIDED;
    if (followed.verdict < f->min_verdict)
      return (km_followed_tangent){0.0, followed.verdict};
    add_to_secant(f, sign);
    if (sign > 0)
      km_state_save(f->s, f->sub, f->end_ahead);
    worse = (km_followed_tangent){fmin(worse.length, followed.length),
                                  followed.verdict < worse.verdict ? followed.verdict : worse.verdict};
  }
  return worse;
}

/* True if a unit direction and a chord agree up to the curvature of the curve. */
static bool is_along(const km_tangents *f, const double *direction, const double *chord) {
  static const double max_deviation = 1e-3; /* bound of 1 − cos */
  double length = km_step_length(f->m, f->sub, chord);
  return length > 0.0 && 1.0 - fabs(km_step_dot(f->m, f->sub, chord, direction)) / length <= max_deviation;
}

bool km_tangents_secant_agrees(const km_tangents *f, const double *direction) {
  return f->conditions.freedom == 1 || is_along(f, direction, f->secant);
}

/* Follows the tangent `a` in both senses. */
bool km_tangents_is_finite(km_tangents *f, const double *a) {
  km_tangents_direction(f, a, f->direction);
  return km_tangents_follow_both_senses(f, f->direction).verdict >= f->min_verdict &&
         km_tangents_secant_agrees(f, f->direction);
}

void km_tangents_normalise(double *a, int k) {
  double sum = 0.0;
  for (int i = 0; i < k; ++i)
    sum += a[i] * a[i];
  for (int i = 0; i < k; ++i)
    a[i] /= sqrt(sum);
}

/* Follows all basis vectors and random combinations. */
bool km_tangents_all_finite(km_tangents *f) {
  int k = f->conditions.freedom, random = km_tangents_are_exact(f) ? 1 : k;
  random = k > 1 ? random : 0; /* a single tangent has no combinations */
  for (int attempt = 0; attempt < k + random; ++attempt) {
    for (int i = 0; i < k; ++i)
      f->a[i] = attempt < k ? attempt == i : km_uniform(&f->random);
    km_tangents_normalise(f->a, k);
    km_tangents_direction(f, f->a, f->direction);
    km_followed_tangent found = km_tangents_follow_both_senses(f, f->direction);
    if (found.verdict < f->min_verdict || !km_tangents_secant_agrees(f, f->direction) ||
        (attempt >= k && km_tangents_have_dropped(f)))
      return false;
    if (attempt < k)
      f->length[attempt] = found.length;
  }
  return true;
}

/* Regular configuration: one random tangent of exact data is finite, and the dimension stays. */
bool km_tangents_are_regular(km_tangents *f) {
  uint64_t random = 1;
  if (!km_tangents_are_exact(f))
    return false;
  for (int i = 0; i < f->conditions.freedom; ++i)
    f->a[i] = km_uniform(&random);
  km_tangents_normalise(f->a, f->conditions.freedom);
  km_tangents_direction(f, f->a, f->direction);
  if (km_tangents_follow(f, f->direction, 1.0).verdict != KM_TANGENT_CONFIRMED || km_tangents_have_dropped(f))
    return false;
  if (f->conditions.freedom == 1 || is_along(f, f->direction, f->chord))
    return true;
  add_to_secant(f, 1);
  km_tangents_follow(f, f->direction, -1.0);
  add_to_secant(f, -1);
  return km_tangents_secant_agrees(f, f->direction);
}

/* Computes the second-order conditions once, at the configuration. */
bool km_tangents_update_conditions(km_tangents *f) {
  if (f->conditions.is_built)
    return !f->arena->failed;
  km_state_restore(f->s, f->sub, f->origin);
  return km_second_order_build(f->m, f->s, f->index, f->arena, &f->conditions);
}

/* Finds a random tangent that satisfies the second-order conditions. */
static bool find_second_order_tangent(km_tangents *f) {
  int k = f->conditions.freedom;
  if (k == 1 || !km_tangents_update_conditions(f)) /* the only tangent was followed as it is */
    return false;
  for (int i = 0; i < k; ++i)
    f->a[i] = km_uniform(&f->random);
  km_tangents_normalise(f->a, k);
  return km_second_order_solve(&f->conditions, f->a, f->work);
}

/* Random starts on the tangent cone. */
bool km_tangents_satisfy_second_order(km_tangents *f) {
  for (int start = 0; start < KM_STARTS_PER_FREEDOM; ++start)
    if (find_second_order_tangent(f))
      return true;
  return false;
}

bool km_tangents_find_random(km_tangents *f) {
  return find_second_order_tangent(f) && km_tangents_is_finite(f, f->a);
}

/* True if two unit coefficient vectors are one tangent in either sense. */
static bool is_same(int k, const double *a, const double *b) {
  double cosine = 0.0;
  for (int r = 0; r < k; ++r)
    cosine += a[r] * b[r];
  return km_is_same_tangent(cosine);
}

/* True if the tangent `a` is among the known ones. */
static bool is_known_tangent(const km_tangents *f, const double *known, int count) {
  int k = f->conditions.freedom;
  for (int i = 0; i < count; ++i)
    if (is_same(k, known + (size_t)i * (size_t)k, f->a))
      return true;
  return false;
}

/* Coefficients of the secant in the basis, a = Zᵀ D secant, normalised. */
static void read_secant(const km_tangents *f, double *a) {
  const double *weight = f->m->column_weight + f->sub->column_start;
  int n = f->sub->columns;
  for (int k = 0; k < f->conditions.freedom; ++k) {
    a[k] = 0.0;
    for (int c = 0; c < n; ++c)
      a[k] += f->conditions.Z[(size_t)k * (size_t)n + (size_t)c] * weight[c] * f->secant[c];
  }
  km_tangents_normalise(a, f->conditions.freedom);
}

/* Follows the direction `a`. If it is refuted only at higher order, closing can have led to a nearby motion: its secant
 * replaces `a` and is followed, up to five times. */
static km_followed_tangent follow_with_secants(km_tangents *f) {
  int k = f->conditions.freedom;
  km_followed_tangent found;
  for (int i = 0; i < MAX_SECANT_STEPS; ++i) {
    km_tangents_direction(f, f->a, f->direction);
    found = km_tangents_follow_both_senses(f, f->direction);
    if (found.verdict < f->min_verdict)
      return found;
    memcpy(f->previous, f->a, (size_t)k * sizeof *f->a);
    read_secant(f, f->a);
    if (!km_second_order_solve(&f->conditions, f->a, f->work) || is_same(k, f->a, f->previous))
      break;
  }
  memcpy(f->a, f->previous, (size_t)k * sizeof *f->a);
  return found;
}

/* Finds a new branch tangent from random starts on the tangent cone. */
bool km_tangents_find_next(km_tangents *f, const double *known, int count, double *length) {
  int max_deviation = KM_STARTS_PER_FREEDOM * (count > f->conditions.freedom ? count : f->conditions.freedom);
  while (f->starts < max_deviation) {
    f->starts++;
    if (!find_second_order_tangent(f) || is_known_tangent(f, known, count))
      continue;
    const bool before = f->has_undecided;
    f->has_undecided = false;
    km_followed_tangent found = follow_with_secants(f);
    int dimension = f->has_undecided ? km_second_order_dimension(&f->conditions, f->a) : 0;
    f->undecided_dimension = dimension > f->undecided_dimension ? dimension : f->undecided_dimension;
    f->has_undecided = f->has_undecided || before;
    *length = found.length;
    if (found.verdict >= f->min_verdict && !is_known_tangent(f, known, count))
      return true;
  }
  return false;
}
