/* Tangents that move one group of bodies while all others are at rest (docs/theory.md 6.6): null space of the rows of Z
 * outside the group. */
#include "local/local_private.h"

#include <string.h>

static bool contains_body(const km_passive_freedom *group, int body) {
  bool found = false;
  for (int i = 0; i < group->body_count; ++i)
    found = found || group->bodies[i] == body;
  return found;
}

/* True if the column belongs to a joint at a body of the group. */
static bool is_column_of_group(const km_local *l, const km_passive_freedom *group, int column) {
  const km_model *model = l->m->model;
  const km_model_joint *joint =
      &model->joints[model->coordinates[l->m->column_coordinate[l->sub->column_start + column]].joint];
  return contains_body(group, model->frames[joint->frame[0]].body) ||
         contains_body(group, model->frames[joint->frame[1]].body);
}

/* Coefficients of tangents that move the group only: null space of the rows of Z outside the group. Returns their
 * number. */
static int find_group_null_space(const km_local *l, const km_passive_freedom *group, km_arena *arena,
                                 double **coefficients) {
  int n = l->sub->columns, k = l->freedom, rows = 0;
  double *outside = KM_ARENA_NEW(arena, double, (size_t)n *(size_t)k);
  if (!outside)
    return 0;
  for (int c = 0; c < n; ++c)
    rows += !is_column_of_group(l, group, c);
  for (int c = 0, row = 0; c < n; ++c)
    if (!is_column_of_group(l, group, c)) {
      for (int i = 0; i < k; ++i)
        outside[i * rows + row] = l->Z[i * n + c];
      row++;
    }
  return rows == 0 ? 0 : km_dense_null_space(outside, rows, k, l->tolerance, arena, coefficients);
}

/* Adds the group's tangents that are finite to the `found` orthonormal rows of V; returns their number. */
static int add_group_tangents(km_local *l, const km_passive_freedom *group, km_arena *arena, double *V, int found) {
  double *coefficients = NULL;
  int k = l->freedom, count = find_group_null_space(l, group, arena, &coefficients);
  for (int i = 0; i < count && found < k; ++i)
    found += km_append_orthonormal(V, found, k, coefficients + (size_t)i * (size_t)k) &&
             km_local_is_finite(l, V + (size_t)found * (size_t)k);
  return found;
}

/* Removes the finite passive tangents of all groups from the basis. */
int km_local_remove_passive(km_local *l, const km_passive_freedoms *passive, double *directions) {
  km_arena arena = {0};
  int k = l->freedom, found = 0;
  double *V = KM_ARENA_NEW(&arena, double, (size_t)(k * k) + 1);
  for (int i = 0; i < (passive ? passive->count : 0) && !arena.failed; ++i)
    if (passive->items[i].substructure == l->index)
      found = add_group_tangents(l, &passive->items[i], &arena, V, found);
  for (int i = 0; i < found && directions; ++i)
    km_local_direction(l, V + (size_t)i * (size_t)k, directions + (size_t)i * (size_t)l->sub->columns);
  bool is_ok = !arena.failed &&
               (found == 0 || (km_complete_basis(V, found, k) && km_local_restrict(l, V + found * k, k - found)));
  l->arena->failed = l->arena->failed || !is_ok;
  l->passive_count += found;
  km_arena_free(&arena);
  return found;
}

int km_local_count_passive(km_local *l, const km_passive_freedom *group) {
  km_passive_freedom item = *group;
  const km_passive_freedoms single_group = {1, group->freedoms, &item};
  if (l->freedom > KM_MANY_VECTORS || !km_local_reserve_tangents(l, true))
    return group->freedoms;
  return km_local_remove_passive(l, &single_group, NULL);
}
