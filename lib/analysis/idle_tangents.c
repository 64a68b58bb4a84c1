/* Finding the tangents along which a group moves while everything else stands, and the rest of the null space. */
#include "analysis/idle_tangents.h"

#include "partition/partition.h"

#include <string.h>

/* What is taken out, by shares of Z's columns: orthonormal rows of V[freedom × freedom]. */
typedef struct leaving {
  km_tangents *f;
  int freedom, count;
  double *V;
} leaving;

static bool is_in(const km_idle_freedom *group, int body) {
  bool found = false;
  for (int i = 0; i < group->body_count; ++i)
    found = found || group->bodies[i] == body;
  return found;
}

/* Is the column one of a joint at a body of the group? */
static bool belongs(const km_tangents *f, const km_idle_freedom *group, int column) {
  const km_model *model = f->m->model;
  const km_model_joint *joint =
      &model->joints[model->coordinates[f->m->column_coordinate[f->sub->column_start + column]].joint];
  return is_in(group, model->frames[joint->frame[0]].body) || is_in(group, model->frames[joint->frame[1]].body);
}

/* The shares of Z that move nothing but the group: the null space of its other rows. Returns how many. */
static int find_shares(const leaving *l, const km_idle_freedom *group, km_arena *arena, double **shares) {
  static const double tolerance = 1e-7;
  const double *Z = l->f->conditions.Z;
  int n = l->f->sub->columns, k = l->freedom, rows = 0;
  double *outside = KM_ARENA_NEW(arena, double, (size_t)n *(size_t)k), *one = KM_ARENA_NEW(arena, double, (size_t)k);
  bool *out = KM_ARENA_NEW(arena, bool, (size_t)n);
  km_partition p;
  if (arena->failed)
    return 0;
  for (int c = 0; c < n; ++c) {
    out[c] = !belongs(l->f, group, c);
    rows += out[c];
  }
  for (int i = 0, at = 0; i < k; ++i) {
    one[i] = 1.0;
    for (int c = 0; c < n; ++c)
      if (out[c])
        outside[at++] = Z[(size_t)i * (size_t)n + (size_t)c];
  }
  if (rows == 0 || !km_partition_reserve(&p, rows, k, arena))
    return 0;
  km_partition_factor(&p, outside, rows, k, NULL, tolerance);
  int count = km_partition_freedom(&p);
  *shares = KM_ARENA_NEW(arena, double, (size_t)(count * k));
  if (arena->failed)
    return 0;
  km_partition_null(&p, one, count, *shares);
  return count;
}

/* Adds what of `a` lies outside the rows of V, of unit length; false where that is next to nothing. */
static bool add(double *V, int count, int k, const double *a) {
  static const double least = 1e-3;
  double *v = V + (size_t)count * (size_t)k, square = 0.0;
  memcpy(v, a, (size_t)k * sizeof *v);
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < count; ++i) {
      double dot = 0.0;
      for (int r = 0; r < k; ++r)
        dot += V[i * k + r] * v[r];
      for (int r = 0; r < k; ++r)
        v[r] -= dot * V[i * k + r];
    }
  for (int r = 0; r < k; ++r)
    square += v[r] * v[r];
  if (!(square > least * least))
    return false;
  km_tangents_normalise(v, k);
  return true;
}

static void take_out(leaving *l, const km_idle_freedom *group, km_arena *arena) {
  double *shares = NULL;
  int k = l->freedom, count = find_shares(l, group, arena, &shares);
  for (int i = 0; i < count && l->count < k; ++i)
    if (add(l->V, l->count, k, shares + (size_t)i * (size_t)k) &&
        km_tangents_is_real(l->f, l->V + (size_t)l->count * (size_t)k))
      l->count++;
}

/* Z becomes what stands at right angles to the rows of V. */
static bool keep_rest(leaving *l, km_arena *arena) {
  km_second_order *conditions = &l->f->conditions;
  int k = l->freedom, n = l->f->sub->columns, kept = l->count;
  double *unit = KM_ARENA_NEW(arena, double, (size_t)k);
  double *rest = KM_ARENA_NEW(l->f->arena, double, (size_t)(k - l->count) * (size_t)n + 1);
  if (arena->failed || l->f->arena->failed)
    return false;
  for (int i = 0; i < k && kept < k; ++i) {
    memset(unit, 0, (size_t)k * sizeof *unit);
    unit[i] = 1.0;
    kept += add(l->V, kept, k, unit);
  }
  for (int i = l->count; i < kept; ++i)
    for (int c = 0; c < n; ++c) {
      double sum = 0.0;
      for (int r = 0; r < k; ++r)
        sum += l->V[i * k + r] * conditions->Z[(size_t)r * (size_t)n + (size_t)c];
      rest[(size_t)(i - l->count) * (size_t)n + (size_t)c] = sum;
    }
  conditions->Z = rest;
  conditions->freedom = kept - l->count;
  conditions->idle = l->count;
  return kept == k;
}

int km_idle_tangents_leave(km_tangents *f, const km_idle_freedoms *idle, double *directions) {
  km_arena arena = {0};
  leaving l = {.f = f, .freedom = f->conditions.freedom};
  l.V = KM_ARENA_NEW(&arena, double, (size_t)(l.freedom * l.freedom) + 1);
  for (int i = 0; i < idle->count && !arena.failed; ++i)
    if (idle->items[i].substructure == f->index)
      take_out(&l, &idle->items[i], &arena);
  for (int i = 0; i < l.count && directions; ++i)
    km_tangents_direction(f, l.V + (size_t)i * (size_t)l.freedom, directions + (size_t)i * (size_t)f->sub->columns);
  bool whole = l.count == 0 || keep_rest(&l, &arena);
  f->arena->failed = f->arena->failed || arena.failed || !whole;
  for (int i = 0; i < f->conditions.freedom; ++i)
    f->length[i] = -1.0;
  km_arena_free(&arena);
  return l.count;
}
