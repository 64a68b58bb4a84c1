/* Finding the tangents along which a group moves while everything else stands, and the rest of the null space. */
#include "local/passive_tangents.h"

#include "linalg/partition.h"

#include <string.h>

/* What is taken out, by shares of Z's columns: orthonormal rows of V[freedom × freedom]. */
typedef struct leaving {
  km_tangents *f;
  int freedom, count;
  double *V;
} leaving;

static bool is_in(const km_passive_freedom *group, int body) {
  bool found = false;
  for (int i = 0; i < group->body_count; ++i)
    found = found || group->bodies[i] == body;
  return found;
}

/* Is the column one of a joint at a body of the group? */
static bool belongs(const km_tangents *f, const km_passive_freedom *group, int column) {
  const km_model *model = f->m->model;
  const km_model_joint *joint =
      &model->joints[model->coordinates[f->m->column_coordinate[f->sub->column_start + column]].joint];
  return is_in(group, model->frames[joint->frame[0]].body) || is_in(group, model->frames[joint->frame[1]].body);
}

/* The shares of Z that move nothing but the group: the null space of its other rows. Returns how many. */
static int find_shares(const leaving *l, const km_passive_freedom *group, km_arena *arena, double **shares) {
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
  km_partition_null_space(&p, one, count, *shares);
  return count;
}

static void take_out(leaving *l, const km_passive_freedom *group, km_arena *arena) {
  double *shares = NULL;
  int k = l->freedom, count = find_shares(l, group, arena, &shares);
  for (int i = 0; i < count && l->count < k; ++i)
    if (km_tangents_append_orthonormal(l->V, l->count, k, shares + (size_t)i * (size_t)k) &&
        km_tangents_is_finite(l->f, l->V + (size_t)l->count * (size_t)k))
      l->count++;
}

int km_passive_tangents_remove(km_tangents *f, const km_passive_freedoms *idle, double *directions) {
  km_arena arena = {0};
  leaving l = {.f = f, .freedom = f->conditions.freedom};
  l.V = KM_ARENA_NEW(&arena, double, (size_t)(l.freedom * l.freedom) + 1);
  for (int i = 0; i < idle->count && !arena.failed; ++i)
    if (idle->items[i].substructure == f->index)
      take_out(&l, &idle->items[i], &arena);
  for (int i = 0; i < l.count && directions; ++i)
    km_tangents_direction(f, l.V + (size_t)i * (size_t)l.freedom, directions + (size_t)i * (size_t)f->sub->columns);
  f->arena->failed = f->arena->failed || arena.failed || !km_tangents_remove(f, l.V, l.count);
  f->conditions.passive_count = l.count;
  km_arena_free(&arena);
  return l.count;
}
