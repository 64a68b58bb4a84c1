/* Tangents that move one group of bodies while all others are at rest (docs/theory.md 6.6): null space of the rows of Z
 * outside the group. */
#include "local/passive_tangents.h"

#include "linalg/partition.h"

#include <string.h>

/* Passive tangents as coefficients of Z: orthonormal rows of V[freedom × freedom]. */
typedef struct passive_basis {
  km_tangents *f;
  int freedom, count;
  double *V;
} passive_basis;

static bool contains_body(const km_passive_freedom *group, int body) {
  bool found = false;
  for (int i = 0; i < group->body_count; ++i)
    found = found || group->bodies[i] == body;
  return found;
}

/* True if the column belongs to a joint at a body of the group. */
static bool is_column_of_group(const km_tangents *f, const km_passive_freedom *group, int column) {
  const km_model *model = f->m->model;
  const km_model_joint *joint =
      &model->joints[model->coordinates[f->m->column_coordinate[f->sub->column_start + column]].joint];
  return contains_body(group, model->frames[joint->frame[0]].body) ||
         contains_body(group, model->frames[joint->frame[1]].body);
}

/* Coefficients of tangents that move the group only: null space of the rows of Z outside the group. Returns their
 * number. */
static int find_group_null_space(const passive_basis *l, const km_passive_freedom *group, km_arena *arena,
                                 double **coefficients) {
  static const double tolerance = 1e-7;
  const double *Z = l->f->conditions.Z;
  int n = l->f->sub->columns, k = l->freedom, rows = 0;
  double *outside = KM_ARENA_NEW(arena, double, (size_t)n *(size_t)k),
         *unit_weight = KM_ARENA_NEW(arena, double, (size_t)k);
  bool *is_outside = KM_ARENA_NEW(arena, bool, (size_t)n);
  km_partition p;
  if (arena->failed)
    return 0;
  for (int c = 0; c < n; ++c) {
    is_outside[c] = !is_column_of_group(l->f, group, c);
    rows += is_outside[c];
  }
  for (int i = 0, at = 0; i < k; ++i) {
    unit_weight[i] = 1.0;
    for (int c = 0; c < n; ++c)
      if (is_outside[c])
        outside[at++] = Z[(size_t)i * (size_t)n + (size_t)c];
  }
  if (rows == 0 || !km_partition_reserve(&p, rows, k, arena))
    return 0;
  km_partition_factor(&p, outside, rows, k, NULL, tolerance);
  int count = km_partition_freedom(&p);
  *coefficients = KM_ARENA_NEW(arena, double, (size_t)(count * k));
  if (arena->failed)
    return 0;
  km_partition_null_space(&p, unit_weight, count, *coefficients);
  return count;
}

/* Adds the group's tangents that are finite to V. */
static void add_group_tangents(passive_basis *l, const km_passive_freedom *group, km_arena *arena) {
  double *coefficients = NULL;
  int k = l->freedom, count = find_group_null_space(l, group, arena, &coefficients);
  for (int i = 0; i < count && l->count < k; ++i)
    if (km_tangents_append_orthonormal(l->V, l->count, k, coefficients + (size_t)i * (size_t)k) &&
        km_tangents_is_finite(l->f, l->V + (size_t)l->count * (size_t)k))
      l->count++;
}

/* Removes the finite passive tangents of all groups from the basis. */
int km_passive_tangents_remove(km_tangents *f, const km_passive_freedoms *passive, double *directions) {
  km_arena arena = {0};
  passive_basis l = {.f = f, .freedom = f->conditions.freedom};
  l.V = KM_ARENA_NEW(&arena, double, (size_t)(l.freedom * l.freedom) + 1);
  for (int i = 0; i < passive->count && !arena.failed; ++i)
    if (passive->items[i].substructure == f->index)
      add_group_tangents(&l, &passive->items[i], &arena);
  for (int i = 0; i < l.count && directions; ++i)
    km_tangents_direction(f, l.V + (size_t)i * (size_t)l.freedom, directions + (size_t)i * (size_t)f->sub->columns);
  f->arena->failed = f->arena->failed || arena.failed || !km_tangents_remove(f, l.V, l.count);
  f->conditions.passive_count = l.count;
  km_arena_free(&arena);
  return l.count;
}
