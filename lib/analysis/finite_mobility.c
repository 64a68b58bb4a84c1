#include "kmech/finite_mobility.h"

#include "analysis/branches.h"
#include "analysis/second_order.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"

#include <stdint.h>
#include <string.h>

static const double first_step = 1e-3; /* of a trial, arc length */
static const double trial = 4e-3;      /* length that tells a real tangent from one that isn't */
static const double far = 0.05;        /* length to which listed motions are confirmed */
enum { STARTS_PER_FREEDOM = 40 };

/* One substructure at one pose. */
typedef struct finder {
  const km_mechanism *m;
  km_state *s;
  int index;
  const km_substructure *sub;
  km_second_order conditions;
  double *pose, *last; /* saved coordinates */
  double *x, *move, *a, *work;
  uint64_t random;
} finder;

static double uniform(finder *f) { /* -1 … 1, always the same sequence */
  f->random = f->random * 6364136223846793005u + 1442695040888963407u;
  return (double)(f->random >> 11) * 0x1p-52 - 1.0;
}

static bool make_finder(finder *f, const km_mechanism *m, km_state *s, int index, km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  size_t n = (size_t)sub->columns;
  *f = (finder){.m = m, .s = s, .index = index, .sub = sub, .random = 1};
  if (!km_second_order_build(m, s, index, arena, &f->conditions))
    return false;
  size_t k = (size_t)f->conditions.freedom;
  f->pose = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  f->last = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  f->x = KM_ARENA_NEW(arena, double, n);
  f->move = KM_ARENA_NEW(arena, double, n);
  f->a = KM_ARENA_NEW(arena, double, k);
  f->work = KM_ARENA_NEW(arena, double, 4 * k * k + 8 * k);
  if (arena->failed)
    return false;
  km_state_save(s, sub, f->pose);
  return true;
}

/* Scaled unit direction D⁻¹Z a. */
static void direction(const finder *f, const double *a, double *x) {
  const double *weight = f->m->column_weight + f->sub->column_start;
  int n = f->sub->columns;
  for (int c = 0; c < n; ++c) {
    double sum = 0.0;
    for (int k = 0; k < f->conditions.freedom; ++k)
      sum += f->conditions.Z[(size_t)k * (size_t)n + (size_t)c] * a[k];
    x[c] = sum / weight[c];
  }
}

/* Follows a direction from the pose, `sign` ahead or back, by predicting each step from the last: the arc length
 * to which the loops could be closed, up to `length`. The state is left at the end. */
static double follow(finder *f, const double *a, double sign, double length) {
  double h = first_step, done = 0.0;
  direction(f, a, f->x);
  for (int c = 0; c < f->sub->columns; ++c)
    f->move[c] = sign * h * f->x[c];
  km_state_restore(f->s, f->sub, f->pose);
  while (done < length) {
    km_closure evidence;
    km_state_save(f->s, f->sub, f->last);
    km_state_move(f->m, f->s, f->sub, f->move);
    f->s->pivoted[f->index] = KM_NEVER;
    bool closed = km_close(f->m, f->s, f->index, KM_NO_DRIVER, &evidence) == KM_CLOSED;
    if (!closed || evidence.correction > (done == 0.0 ? 0.05 : 0.3) * h) {
      km_state_restore(f->s, f->sub, f->last);
      return done;
    }
    km_state_difference(f->s, f->sub, f->last, f->move);
    done += km_step_length(f->m, f->sub, f->move);
    double next = fmin(1.5 * h, 0.01);
    for (int c = 0; c < f->sub->columns; ++c)
      f->move[c] *= next / h;
    h = next;
  }
  return done;
}

static bool is_real(finder *f, const double *a) {
  return follow(f, a, 1.0, trial) >= trial && follow(f, a, -1.0, trial) >= trial;
}

static void normalise(double *a, int k) {
  double sum = 0.0;
  for (int i = 0; i < k; ++i)
    sum += a[i] * a[i];
  for (int i = 0; i < k; ++i)
    a[i] /= sqrt(sum);
}

/* Are the basis vectors and as many random combinations of them all real? */
static bool all_real(finder *f) {
  int k = f->conditions.freedom;
  for (int trial_index = 0; trial_index < 2 * k; ++trial_index) {
    for (int i = 0; i < k; ++i)
      f->a[i] = trial_index < k ? trial_index == i : uniform(f);
    normalise(f->a, k);
    if (!is_real(f, f->a))
      return false;
  }
  return true;
}

/* A random tangent that meets the second order and is real; false if the start leads to none. */
static bool random_motion(finder *f) {
  int k = f->conditions.freedom;
  for (int i = 0; i < k; ++i)
    f->a[i] = uniform(f);
  normalise(f->a, k);
  return km_second_order_solve(&f->conditions, f->a, f->work) && is_real(f, f->a);
}

/* The largest number of independent motions whose random combinations are real too. basis[k × k]. */
static int common_span(finder *f, double *basis) {
  int k = f->conditions.freedom, found = 0;
  for (int start = 0; start < STARTS_PER_FREEDOM * k && found < k; ++start) {
    if (!random_motion(f))
      continue;
    memcpy(basis + (size_t)found * (size_t)k, f->a, (size_t)k * sizeof *basis);
    bool together = true;
    for (int mix = 0; mix < 3 && together && found > 0; ++mix) {
      memset(f->a, 0, (size_t)k * sizeof *f->a);
      for (int i = 0; i <= found; ++i) {
        double share = uniform(f);
        for (int r = 0; r < k; ++r)
          f->a[r] += share * basis[(size_t)i * (size_t)k + (size_t)r];
      }
      normalise(f->a, k);
      together = is_real(f, f->a);
    }
    /* A motion that the others span already adds nothing. */
    double rest = 1.0;
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i < found; ++i) {
        double dot = 0.0, *v = basis + (size_t)found * (size_t)k, *o = basis + (size_t)i * (size_t)k;
        for (int r = 0; r < k; ++r)
          dot += v[r] * o[r];
        for (int r = 0; r < k; ++r)
          v[r] -= dot * o[r];
      }
    rest = 0.0;
    for (int r = 0; r < k; ++r)
      rest += basis[(size_t)found * (size_t)k + (size_t)r] * basis[(size_t)found * (size_t)k + (size_t)r];
    if (!together || rest < 1e-6)
      continue;
    normalise(basis + (size_t)found * (size_t)k, k);
    ++found;
  }
  return found;
}

/* The dimension of the motion through the state's present pose, assumed to be one where just one family passes. */
static int dimension_here(const km_mechanism *m, km_state *s, int index, km_arena *arena) {
  finder f;
  if (!make_finder(&f, m, s, index, arena))
    return 0;
  int k = f.conditions.freedom, dimension = k;
  if (k > 1 && !all_real(&f)) {
    double *basis = KM_ARENA_NEW(arena, double, (size_t)((k + 1) * k));
    dimension = basis ? common_span(&f, basis) : 0;
  }
  km_state_restore(s, f.sub, f.pose);
  return dimension;
}

static void list_motion(finder *f, const double *a, km_motion_kind kind, double length, km_finite_mobility *out) {
  if (out->motion_count == KM_MOST_MOTIONS) {
    out->truncated = 1;
    return;
  }
  int coordinates = f->m->coordinate_count;
  double *rates = out->store + (size_t)out->motion_count * (size_t)coordinates;
  direction(f, a, f->x);
  for (int k = 0; k < f->sub->columns; ++k)
    rates[f->m->column_coordinate[f->sub->column_start + k]] = f->x[k] * f->m->column_weight[f->sub->column_start + k];
  out->motions[out->motion_count++] = (km_finite_motion){kind, f->index, rates, length};
}

static void list_basis(finder *f, km_motion_kind kind, km_finite_mobility *out) {
  int k = f->conditions.freedom;
  for (int i = 0; i < k; ++i) {
    for (int r = 0; r < k; ++r)
      f->a[r] = r == i;
    double length = kind == KM_MOTION_SHAKY ? 0.0 : fmin(follow(f, f->a, 1.0, far), follow(f, f->a, -1.0, far));
    list_motion(f, f->a, kind, length, out);
  }
}

/* Collects the different real motions; their largest dimension is the finite mobility. */
static int find_branches(finder *f, km_arena *arena, km_finite_mobility *out) {
  int k = f->conditions.freedom, best = 0, found = 0;
  double *lines = KM_ARENA_NEW(arena, double, (size_t)(KM_MOST_MOTIONS * k));
  for (int start = 0; lines && start < STARTS_PER_FREEDOM * k && found < KM_MOST_MOTIONS; ++start) {
    bool known = false;
    if (!random_motion(f))
      continue;
    for (int i = 0; i < found && !known; ++i) {
      double dot = 0.0;
      for (int r = 0; r < k; ++r)
        dot += lines[i * k + r] * f->a[r];
      known = fabs(dot) > 0.999;
    }
    if (known)
      continue;
    memcpy(lines + (size_t)found++ * (size_t)k, f->a, (size_t)k * sizeof *lines);
    double back = follow(f, f->a, -1.0, far), ahead = follow(f, f->a, 1.0, far);
    km_arena scratch = {0};
    int dimension = dimension_here(f->m, f->s, f->index, &scratch);
    km_arena_free(&scratch);
    best = dimension > best ? dimension : best;
    list_motion(f, lines + (size_t)(found - 1) * (size_t)k, KM_MOTION_BRANCH, fmin(ahead, back), out);
  }
  out->truncated = out->truncated || found == KM_MOST_MOTIONS;
  return best;
}

int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  km_arena arena = {0};
  finder f;
  int found = 0, n = m->substructures[index].columns;
  if (make_finder(&f, m, s, index, &arena) && f.conditions.conditions > 0 && !all_real(&f)) {
    for (int start = 0; start < STARTS_PER_FREEDOM * f.conditions.freedom && found < KM_MOST_BRANCHES; ++start) {
      if (!random_motion(&f))
        continue;
      double *x = directions + (size_t)found * (size_t)n;
      direction(&f, f.a, x);
      bool known = false;
      for (int i = 0; i < found && !known; ++i) {
        known = fabs(km_step_dot(m, f.sub, x, directions + (size_t)i * (size_t)n)) > 0.999;
      }
      found += !known;
    }
  }
  if (!arena.failed) {
    km_state_restore(s, f.sub, f.pose);
    km_loops_update(m, s, f.sub);
    km_pivot(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, f.sub, 0.0));
  }
  km_arena_free(&arena);
  return found;
}

static int find_in(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_finite_mobility *out) {
  finder f;
  if (!make_finder(&f, m, s, index, arena))
    return 0;
  int k = f.conditions.freedom, mobility = k;
  if (k > 0) {
    if (f.conditions.conditions == 0 || all_real(&f)) {
      list_basis(&f, KM_MOTION_REGULAR, out);
    } else {
      mobility = find_branches(&f, arena, out);
      if (mobility == 0)
        list_basis(&f, KM_MOTION_SHAKY, out);
    }
  }
  km_state_restore(s, f.sub, f.pose);
  km_loops_update(m, s, f.sub);
  s->pivoted[index] = KM_NEVER;
  return mobility;
}

km_status km_finite_mobility_find(const km_mechanism *m, km_state *s, km_finite_mobility *out, km_error *error) {
  *out = (km_finite_mobility){0};
  out->store = KM_NEW(double, (size_t)KM_MOST_MOTIONS *(size_t)(m->coordinate_count + 1));
  bool failed = !out->store;
  for (int c = 0; c < m->coordinate_count; ++c)
    out->mobility += m->substructure_of[c] < 0 && !m->held[c];
  for (int i = 0; i < m->topology.substructure_count && !failed; ++i) {
    km_arena arena = {0};
    out->mobility += find_in(m, s, i, &arena, out);
    failed = arena.failed;
    km_arena_free(&arena);
  }
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the finite mobility") : KM_OK;
}

void km_finite_mobility_free(km_finite_mobility *mobility) {
  km_free(mobility->store);
  *mobility = (km_finite_mobility){0};
}

const char *km_motion_kind_name(km_motion_kind kind) {
  static const char *const names[] = {"regular", "branch", "shaky"};
  return names[kind];
}
