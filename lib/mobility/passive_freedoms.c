/* Passive degrees of freedom (theory 6.6), by test of groups of bodies.
 *
 *   J_g q̇_g = 0,  g: columns of the joints at bodies of the group;   passive freedoms = columns − rank J_g
 *
 * A group is joined by rigid, single-coordinate and coupled joints; all its other joints have several coordinates. */
#include "kmech/mobility.h"

#include "base/arguments.h"
#include "base/number/union_find.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/generic_neighbour.h"
#include "local/local.h"
#include "mobility/mobility_numbers.h"
#include "mobility/substructure_loop.h"

#include <string.h>

/* The bodies of one substructure in groups (union-find). */
typedef struct body_groups {
  const km_mechanism *m;
  km_state *s;
  int index;
  int *parent;         /* [body] union-find */
  int *size;           /* [body] size of the group, at its representative */
  int *index_in_group; /* [body] index in its group, in the order of the model; -1 in none */
  bool *is_fixed;      /* [body] at a representative: the group cannot be passive */
  int *column_group;   /* [2 · columns] representatives at both ends of each column's joint */
  int *row_index;      /* [rows] index of each row among those of the present group; -1: none */
} body_groups;

static void unite(const body_groups *g, int a, int b) {
  int absorbed = km_set_root(g->parent, a), to = km_set_root(g->parent, b);
  g->parent[absorbed] = to;
  g->is_fixed[to] = g->is_fixed[to] || g->is_fixed[absorbed];
}

/* Unites the bodies of rigid, single-coordinate and coupled joints. A group that contains the base of the
 * substructure is fixed. */
static void unite_across_simple_joints(const body_groups *g) {
  const km_model *model = g->m->model;
  const km_topology *t = &g->m->topology;
  for (int i = t->joint_start[g->index]; i < t->joint_start[g->index + 1]; ++i) {
    int j = t->joint[i];
    if (km_joint_kind_of(model->joints[j].type)->freedom <= 1 || km_joint_is_coupled(model, j))
      unite(g, km_joint_body(model, j, 0), km_joint_body(model, j, 1));
  }
}

/* The columns of J in joints at bodies of a group, compressed. */
typedef struct group_columns {
  int rows, count;  /* rows with an entry, in the order in which they are met; columns */
  int *start, *row; /* rows of column c: row[start[c] … start[c + 1]-1], */
  double *value;    /* and its entries */
} group_columns;

static bool collect_columns(const body_groups *g, int group, km_arena *arena, group_columns *out) {
  const km_substructure *sub = &g->m->substructures[g->index];
  const km_pattern *pattern = &sub->pattern;
  const double *J = km_state_jacobian(g->s, sub);
  size_t capacity = 0, value_capacity = 0, column_capacity = 0;
  *out = (group_columns){0};
  memset(g->row_index, -1, (size_t)sub->rows * sizeof *g->row_index);
  for (int k = 0; k < sub->columns; ++k) {
    if (g->column_group[2 * k] != group && g->column_group[2 * k + 1] != group)
      continue;
    int first = pattern->start ? pattern->start[k] : k * sub->rows;
    int end = pattern->start ? pattern->start[k + 1] : first + sub->rows;
    int at = out->count ? out->start[out->count] : 0;
    size_t size = (size_t)(at + end - first) + 1;
    if (!km_arena_grow(arena, (void **)&out->start, &column_capacity, (size_t)out->count + 2, sizeof *out->start) ||
        !km_arena_grow(arena, (void **)&out->row, &capacity, size, sizeof *out->row) ||
        !km_arena_grow(arena, (void **)&out->value, &value_capacity, size, sizeof *out->value))
      return false;
    for (int i = first; i < end; ++i, ++at) {
      int *index = &g->row_index[pattern->start ? pattern->row[i] : i - first];
      if (*index < 0)
        *index = out->rows++;
      out->row[at] = *index;
      out->value[at] = J[i];
    }
    out->start[++out->count] = at;
  }
  return out->count > 0;
}

/* Returns the dimension of the null space; -1: no memory. */
static int find_nullity(const body_groups *g, const group_columns *e, km_arena *scratch) {
  const km_substructure *sub = &g->m->substructures[g->index];
  double tolerance = km_rank_tolerance(g->m, sub, km_loops_residual(g->m, g->s, sub));
  km_factor *p = km_factor_create_sparse(e->rows, e->count, e->start, e->row, NULL, scratch);
  if (!p)
    return -1;
  km_factor_compute(p, e->value, e->rows, e->count,
                    &(km_factor_options){.tolerance = tolerance, .basis = KM_BASIS_NONE});
  return km_factor_has_failed(p) ? -1 : km_factor_freedom(p);
}

/* Returns the freedoms of the group with all other bodies at rest; -1: no memory. */
static int find_group_freedoms(const body_groups *g, int group) {
  km_arena scratch = {0};
  group_columns e;
  int found = collect_columns(g, group, &scratch, &e) ? find_nullity(g, &e, &scratch) : scratch.failed ? -1 : 0;
  km_arena_free(&scratch);
  return found;
}

/* Builds the candidate groups of passive freedoms: bodies connected by rigid, single-coordinate or coupled joints are
 * united (union-find). Numbers the bodies of each group. */
static bool make_groups(body_groups *g, const km_mechanism *m, km_state *s, int index, km_arena *arena) {
  size_t bodies = (size_t)m->model->body_count;
  *g = (body_groups){m,
                     s,
                     index,
                     KM_ARENA_NEW(arena, int, bodies),
                     KM_ARENA_NEW(arena, int, bodies),
                     KM_ARENA_NEW(arena, int, bodies),
                     KM_ARENA_NEW(arena, bool, bodies),
                     KM_ARENA_NEW(arena, int, 2 * (size_t)m->substructures[index].columns),
                     KM_ARENA_NEW(arena, int, (size_t)m->substructures[index].rows)};
  if (arena->failed)
    return false;
  const km_topology *t = &m->topology;
  for (int b = 0; b < m->model->body_count; ++b) {
    g->parent[b] = b;
    g->is_fixed[b] = true;
  }
  for (int i = t->body_start[index]; i < t->body_start[index + 1]; ++i)
    g->is_fixed[t->body[i]] = false; /* other bodies are the base of the substructure */
  unite_across_simple_joints(g);
  /* Only bodies of this substructure can be passive in it; each is counted once. */
  memset(g->index_in_group, -1, bodies * sizeof *g->index_in_group);
  for (int i = t->joint_start[index]; i < t->joint_start[index + 1]; ++i)
    for (int end = 0; end < 2; ++end) {
      int body = km_joint_body(m->model, t->joint[i], end);
      if (g->index_in_group[body] < 0)
        g->index_in_group[body] = g->size[km_set_root(g->parent, body)]++;
    }
  for (int k = 0; k < 2 * m->substructures[index].columns; ++k) {
    int coordinate = m->column_coordinate[m->substructures[index].column_start + k / 2];
    g->column_group[k] =
        km_set_root(g->parent, km_joint_body(m->model, m->model->coordinates[coordinate].joint, k % 2));
  }
  return true;
}

static bool add_group(const body_groups *g, int group, int count, km_passive_freedoms *out, size_t *capacity) {
  void *items = out->items;
  if (!km_reserve(&items, capacity, (size_t)out->count + 1, sizeof *out->items))
    return false;
  out->items = items;
  km_passive_freedom *item = &out->items[out->count++];
  *item = (km_passive_freedom){.substructure = g->index, .freedoms = count};
  for (int b = 1; b < g->m->model->body_count; ++b)
    if (g->index_in_group[b] >= 0 && km_set_root(g->parent, b) == group)
      item->bodies[item->body_count++] = b;
  return true;
}

static bool find_in_groups(const body_groups *g, km_passive_freedoms *out, size_t *capacity) {
  for (int b = 1; b < g->m->model->body_count; ++b) {
    if (g->index_in_group[b] < 0 || km_set_root(g->parent, b) != b || g->is_fixed[b] ||
        g->size[b] > KM_MAX_PASSIVE_BODIES)
      continue;
    int count = find_group_freedoms(g, b);
    if (count < 0 || (count > 0 && !add_group(g, b, count, out, capacity)))
      return false;
  }
  return true;
}

/* Returns how many of a group's freedoms are finite motions, for a configuration without a neighbouring one. */
static int count_finite_freedoms(const body_groups *g, const km_passive_freedom *group) {
  km_arena arena = {0};
  km_local *l = km_local_create(g->m, g->s, g->index, NULL, 0.0, &arena);
  int count = l ? km_local_count_passive(l, group) : -1;
  km_local_restore(l);
  count = arena.failed ? -1 : count;
  km_local_free(l);
  km_arena_free(&arena);
  return count;
}

/* True if the configuration differs from the saved one by over half of the attempted move: closing the loops can
 * return to it. */
static bool has_moved(const body_groups *g, const double *saved, double *move) {
  const km_substructure *sub = &g->m->substructures[g->index];
  double tried = km_step_length(g->m, sub, move);
  km_state_difference(g->s, sub, saved, move);
  return km_step_length(g->m, sub, move) > 0.5 * tried;
}

/* Reduces the groups found from `first` on to their persistent freedoms: those at a neighbouring configuration or,
 * without one, those that are finite motions. */
static bool keep_persistent(const body_groups *g, int first, km_arena *arena, km_passive_freedoms *out) {
  size_t columns = (size_t)g->m->substructures[g->index].columns;
  double *saved = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *columns),
         *move = KM_ARENA_NEW(arena, double, columns);
  if (arena->failed)
    return false;
  bool moved = km_generic_neighbour_enter(g->m, g->s, g->index, saved, move) && has_moved(g, saved, move), ok = true;
  if (!moved)
    km_generic_neighbour_leave(g->m, g->s, g->index, saved);
  int count = first;
  for (int i = first; i < out->count; ++i) {
    km_passive_freedom item = out->items[i];
    int persistent_freedoms =
        moved ? find_group_freedoms(g, km_set_root(g->parent, item.bodies[0])) : count_finite_freedoms(g, &item);
    ok = ok && persistent_freedoms >= 0;
    item.freedoms = persistent_freedoms < item.freedoms ? persistent_freedoms : item.freedoms;
    out->mobility += item.freedoms > 0 ? item.freedoms : 0;
    if (item.freedoms > 0)
      out->items[count++] = item;
  }
  out->count = count;
  if (moved)
    km_generic_neighbour_leave(g->m, g->s, g->index, saved);
  return ok;
}

/* True if the substructure can have passive freedoms: it has a joint with several coordinates. */
static bool can_have_passive_freedoms(const km_mechanism *m, int index) {
  const km_topology *t = &m->topology;
  for (int i = t->joint_start[index]; i < t->joint_start[index + 1]; ++i)
    if (km_joint_kind_of(m->model->joints[t->joint[i]].type)->freedom > 1)
      return true;
  return false;
}

/* Data of the search over all substructures. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_passive_freedoms *out;
  size_t capacity;
} search;

static km_status search_substructure(void *self, int index, km_arena *arena, km_error *error) {
  search *f = self;
  body_groups g;
  int first = f->out->count;
  (void)error;
  if (!can_have_passive_freedoms(f->m, index))
    return KM_OK;
  bool done = make_groups(&g, f->m, f->s, index, arena) && find_in_groups(&g, f->out, &f->capacity) &&
              (f->out->count == first || keep_persistent(&g, first, arena, f->out));
  return done ? KM_OK : KM_MEMORY;
}

km_status km_passive_freedoms_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                                   km_passive_freedoms *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_passive_freedoms){0};
  search f = {m, s, out, 0};
  return km_search_substructures(m, s, search_substructure, &f, progress, context, "the passive freedoms", error);
}

static bool in_group(const km_passive_freedom *group, int body) {
  for (int i = 0; i < group->body_count; ++i)
    if (group->bodies[i] == body)
      return true;
  return false;
}

void km_passive_coordinates(const km_mechanism *m, const km_passive_freedoms *freedoms, bool *marks) {
  if (!m || !freedoms || !marks)
    return;
  memset(marks, 0, (size_t)m->coordinate_count * sizeof *marks);
  for (int i = 0; i < freedoms->count; ++i)
    for (int j = 0; j < m->model->joint_count; ++j) {
      int freedom = km_joint_kind_of(m->model->joints[j].type)->freedom;
      bool one = in_group(&freedoms->items[i], km_joint_body(m->model, j, 0)),
           other = in_group(&freedoms->items[i], km_joint_body(m->model, j, 1));
      for (int k = 0; k < freedom && freedom > 1 && one != other; ++k)
        marks[m->model->joints[j].first_coordinate + k] = true;
    }
}

void km_passive_freedoms_free(km_passive_freedoms *freedoms) {
  if (!freedoms)
    return;
  km_free(freedoms->items);
  *freedoms = (km_passive_freedoms){0};
}
