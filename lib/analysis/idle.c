/* Idle freedoms, found by test. Symbols: V twist of a body of the group, q̇ rates of its joints; each joint demands
 * V_child − V_parent = H q̇ with V = 0 outside the group. */
#include "kmech/idle.h"

#include "analysis/each_substructure.h"
#include "analysis/nearby.h"
#include "analysis/whole_jacobian.h"
#include "base/check.h"
#include "kinematics/poses.h"

#include <string.h>

/* The bodies of one substructure in groups that single-coordinate joints tie together. */
typedef struct groups {
  const km_mechanism *m;
  km_state *s;
  int index;
  int *parent; /* [body] union-find */
  int *size;   /* [body] of the group, at its representative */
  int *place;  /* [body] in its group, by the order of the model; -1 in none */
  bool *fixed; /* [body] at a representative: the group isn't free to be idle */
} groups;

static int find(const groups *g, int body) {
  while (g->parent[body] != body) {
    g->parent[body] = g->parent[g->parent[body]];
    body = g->parent[body];
  }
  return body;
}

static int body_at(const km_model *model, int joint, int end) {
  return model->frames[model->joints[joint].frame[end]].body;
}

static bool is_coupled(const km_model *model, int joint) {
  for (int i = 0; i < model->coupling_count; ++i)
    for (int k = 0; k < model->couplings[i].count; ++k)
      if (model->coordinates[model->couplings[i].coordinates[k]].joint == joint)
        return true;
  return false;
}

static void join(const groups *g, int a, int b) {
  int from = find(g, a), to = find(g, b);
  g->parent[from] = to;
  g->fixed[to] = g->fixed[to] || g->fixed[from];
}

/* Ties bodies by rigid, single-coordinate and coupled joints; what is tied to the inertial frame is fixed. */
static void tie(const groups *g) {
  const km_model *model = g->m->model;
  const km_topology *t = &g->m->topology;
  for (int i = t->joint_start[g->index]; i < t->joint_start[g->index + 1]; ++i) {
    int j = t->joint[i];
    if (km_joint_kind_of(model->joints[j].type)->freedom <= 1 || is_coupled(model, j))
      join(g, body_at(model, j, 0), body_at(model, j, 1));
  }
}

/* Writes the twist as six entries of a column, lengths over the substructure's size. */
static void put(const groups *g, km_twist h, km_vec3 about, double unit, double sign, double *column) {
  double entry[6];
  km_twist_entries(&g->m->substructures[g->index], h, about, unit, entry);
  for (int r = 0; r < 6; ++r)
    column[r] += sign * entry[r];
}

/* The group's joints and coordinates. */
static void count_joints(const groups *g, int group, int *joints, int *coordinates) {
  const km_model *model = g->m->model;
  const km_topology *t = &g->m->topology;
  *joints = *coordinates = 0;
  for (int i = t->joint_start[g->index]; i < t->joint_start[g->index + 1]; ++i) {
    int j = t->joint[i], first = model->joints[j].first_coordinate;
    if (find(g, body_at(model, j, 0)) != group && find(g, body_at(model, j, 1)) != group)
      continue;
    ++*joints;
    for (int c = first; c < first + km_model_freedom(model, j); ++c)
      *coordinates += g->m->column_of[c] >= 0;
  }
}

/* Fills the equations of joint `j` into six rows of A. Returns the next free column. */
static int fill_joint(const groups *g, int group, int j, km_vec3 about, int row, int rows, int next, double *A) {
  const km_model *model = g->m->model;
  int first = model->joints[j].first_coordinate;
  for (int end = 0; end < 2; ++end) {
    int body = body_at(model, j, end);
    if (find(g, body) != group)
      continue;
    for (int r = 0; r < 6; ++r)
      A[(size_t)(6 * g->place[body] + r) * (size_t)rows + (size_t)(row + r)] = end ? 1.0 : -1.0;
  }
  for (int c = first; c < first + km_model_freedom(model, j); ++c)
    if (g->m->column_of[c] >= 0)
      put(g, km_coordinate_twist(g->m, g->s, c), about, g->m->unit[c], -1.0, A + (size_t)next++ * (size_t)rows + row);
  return next;
}

/* Freedoms of the group while all other bodies stand; -1 when out of memory. */
static int freedoms(const groups *g, int group, int bodies) {
  const km_model *model = g->m->model;
  const km_topology *t = &g->m->topology;
  km_arena scratch = {0};
  km_partition p;
  int joints, coordinates;
  count_joints(g, group, &joints, &coordinates);
  int rows = 6 * joints, columns = 6 * bodies + coordinates, next = 6 * bodies, row = 0;
  double *A = KM_ARENA_NEW(&scratch, double, (size_t)rows *(size_t)columns);
  int found = -1;
  if (A && km_partition_reserve(&p, rows, columns, &scratch)) {
    km_vec3 about = g->s->pose[group].p;
    for (int i = t->joint_start[g->index]; i < t->joint_start[g->index + 1]; ++i) {
      int j = t->joint[i];
      if (find(g, body_at(model, j, 0)) != group && find(g, body_at(model, j, 1)) != group)
        continue;
      next = fill_joint(g, group, j, about, row, rows, next, A);
      row += 6;
    }
    km_partition_factor(&p, A, rows, columns, NULL, 1e-9 * columns);
    found = km_partition_freedom(&p);
  }
  km_arena_free(&scratch);
  return found;
}

/* Groups and the places of bodies in them. */
static bool make_groups(groups *g, const km_mechanism *m, km_state *s, int index, km_arena *arena) {
  size_t bodies = (size_t)m->model->body_count;
  *g = (groups){m,
                s,
                index,
                KM_ARENA_NEW(arena, int, bodies),
                KM_ARENA_NEW(arena, int, bodies),
                KM_ARENA_NEW(arena, int, bodies),
                KM_ARENA_NEW(arena, bool, bodies)};
  if (arena->failed)
    return false;
  const km_topology *t = &m->topology;
  for (int b = 0; b < m->model->body_count; ++b) {
    g->parent[b] = b;
    g->fixed[b] = true;
  }
  for (int i = t->body_start[index]; i < t->body_start[index + 1]; ++i)
    g->fixed[t->body[i]] = false; /* the others carry the substructure */
  tie(g);
  /* Only bodies of this substructure can be idle in it; each is counted once. */
  memset(g->place, -1, bodies * sizeof *g->place);
  for (int i = t->joint_start[index]; i < t->joint_start[index + 1]; ++i)
    for (int end = 0; end < 2; ++end) {
      int body = body_at(m->model, t->joint[i], end);
      if (g->place[body] < 0)
        g->place[body] = g->size[find(g, body)]++;
    }
  return true;
}

static bool add(const groups *g, int group, int count, km_idle_freedoms *out, size_t *capacity) {
  void *items = out->items;
  if (!km_reserve(&items, capacity, (size_t)out->count + 1, sizeof *out->items))
    return false;
  out->items = items;
  km_idle_freedom *item = &out->items[out->count++];
  *item = (km_idle_freedom){.substructure = g->index, .freedoms = count};
  for (int b = 1; b < g->m->model->body_count; ++b)
    if (g->place[b] >= 0 && find(g, b) == group)
      item->bodies[item->body_count++] = b;
  return true;
}

static bool find_in(const groups *g, km_idle_freedoms *out, size_t *capacity) {
  for (int b = 1; b < g->m->model->body_count; ++b) {
    if (g->place[b] < 0 || find(g, b) != b || g->fixed[b] || g->size[b] > KM_MOST_IDLE_BODIES)
      continue;
    int count = freedoms(g, b, g->size[b]);
    if (count < 0 || (count > 0 && !add(g, b, count, out, capacity)))
      return false;
  }
  return true;
}

/* Keeps of the groups found from `first` on what they also have a short way along the motion. */
static bool keep_lasting(const groups *g, int first, km_arena *arena, km_idle_freedoms *out) {
  size_t columns = (size_t)g->m->substructures[g->index].columns;
  double *saved = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *columns),
         *move = KM_ARENA_NEW(arena, double, columns);
  if (arena->failed)
    return false;
  bool moved = km_nearby_go(g->m, g->s, g->index, saved, move);
  int kept = first;
  for (int i = first; i < out->count; ++i) {
    km_idle_freedom item = out->items[i];
    int there = moved ? freedoms(g, find(g, item.bodies[0]), item.body_count) : item.freedoms;
    item.freedoms = there < item.freedoms ? there : item.freedoms;
    out->mobility += item.freedoms > 0 ? item.freedoms : 0;
    if (item.freedoms > 0)
      out->items[kept++] = item;
  }
  out->count = kept;
  km_nearby_return(g->m, g->s, g->index, saved);
  return true;
}

/* Can the substructure have any? Groups end at joints with several coordinates. */
static bool worth_looking(const km_mechanism *m, int index) {
  const km_topology *t = &m->topology;
  for (int i = t->joint_start[index]; i < t->joint_start[index + 1]; ++i)
    if (km_joint_kind_of(m->model->joints[t->joint[i]].type)->freedom > 1)
      return true;
  return false;
}

/* The whole search. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_idle_freedoms *out;
  size_t capacity;
} search;

static km_status look(void *self, int index, km_arena *arena, km_error *error) {
  search *f = self;
  groups g;
  int first = f->out->count;
  (void)error;
  if (!worth_looking(f->m, index))
    return KM_OK;
  bool done = make_groups(&g, f->m, f->s, index, arena) && find_in(&g, f->out, &f->capacity) &&
              (f->out->count == first || keep_lasting(&g, first, arena, f->out));
  return done ? KM_OK : KM_MEMORY;
}

km_status km_idle_freedoms_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                                km_idle_freedoms *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_idle_freedoms){0};
  km_status fits = km_check_state(m, s, error);
  if (fits)
    return fits;
  search f = {m, s, out, 0};
  km_mobility mobility;
  km_poses_update(m, s);
  km_mobility_update(m, s, &mobility);
  return km_each_substructure(m, look, &f, progress, context, "the idle freedoms", error);
}

static bool in_group(const km_idle_freedom *group, int body) {
  for (int i = 0; i < group->body_count; ++i)
    if (group->bodies[i] == body)
      return true;
  return false;
}

void km_idle_coordinates(const km_mechanism *m, const km_idle_freedoms *freedoms, bool *marks) {
  if (!m || !freedoms || !marks)
    return;
  memset(marks, 0, (size_t)m->coordinate_count * sizeof *marks);
  for (int i = 0; i < freedoms->count; ++i)
    for (int j = 0; j < m->model->joint_count; ++j) {
      int freedom = km_joint_kind_of(m->model->joints[j].type)->freedom;
      bool one = in_group(&freedoms->items[i], body_at(m->model, j, 0)),
           other = in_group(&freedoms->items[i], body_at(m->model, j, 1));
      for (int k = 0; k < freedom && freedom > 1 && one != other; ++k)
        marks[m->model->joints[j].first_coordinate + k] = true;
    }
}

void km_idle_freedoms_free(km_idle_freedoms *freedoms) {
  if (!freedoms)
    return;
  km_free(freedoms->items);
  *freedoms = (km_idle_freedoms){0};
}
