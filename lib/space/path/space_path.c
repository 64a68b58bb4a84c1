/* Paths between two configurations without a singularity of the drivers (docs/theory.md 4.21): both ends, the straight
 * path of the drivers, else the search by two trees; then the smooth path. */
#include "base/arguments.h"
#include "base/table.h"
#include "kinematics/assembly.h"
#include "space/path/path_curve.h"
#include "space/path/path_table.h"

enum { MODE_STARTS = 60, MOST_STRAIGHT = 5000, MOST_MODES = 16 };
static const double mode_distance = 1e-4; /* distance of different assembly modes */

typedef struct path_search {
  const km_space_path_def *def;
  km_arena arena;
  km_path_steps steps;
  km_path_trees trees;
} path_search;

const char *km_space_path_outcome_name(km_space_path_outcome outcome) {
  static const char *const names[] = {"found", "separated", "end", "not found", "stopped"};
  return outcome >= KM_SPACE_PATH_FOUND && outcome <= KM_SPACE_PATH_STOPPED ? names[outcome] : "";
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the path");
}

/* Makes the state's configuration a root of a tree if it may be on a path. *sign: of det A; 0: the loops are open. */
static km_status add_end(path_search *g, int side, km_space_path *out, int *sign, bool *is_added, km_error *error) {
  km_driver_surface_restart(&g->steps.f);
  if (!km_driver_surface_close(&g->steps.f, HUGE_VAL, sign)) {
    *sign = 0;
    *is_added = false;
    return KM_OK;
  }
  *is_added = km_path_steps_is_allowed(&g->steps, *sign);
  double sigma = km_path_steps_input_value(&g->steps);
  out->ends[side] = isnan(out->ends[side]) ? sigma : fmax(out->ends[side], sigma);
  return *is_added && km_path_trees_add(&g->trees, &g->trees.tree[side], -1) < 0 ? no_memory(error) : KM_OK;
}

/* Assembles the loops with the drivers at the values of the end, from random values of the others. */
static km_status assemble_end(path_search *g, bool *is_closed) {
  km_driver_surface *f = &g->steps.f;
  km_status status = KM_OK;
  km_path_trees_sample(&g->trees);
  for (int d = 0; d < f->control_count; ++d) {
    int c = g->def->drivers[d];
    km_state_set_coordinate(f->m, f->s, c, g->def->to_drivers[d], NULL);
    km_state_lock(f->s, c);
  }
  *is_closed = true;
  for (int i = 0; i < f->part_count && !status && *is_closed; ++i) {
    if (f->part[i].substructure < 0)
      continue;
    km_state_invalidate_pivots(f->s, f->part[i].substructure);
    status = km_assemble_one(f->m, f->s, f->part[i].substructure, g->steps.before, is_closed);
  }
  km_state_unlock(f->s);
  return status;
}

/* Adds the assembly modes at the end's values of the drivers that random starts find. */
static km_status add_modes(path_search *g, km_space_path *out, km_error *error) {
  km_path_tree *t = &g->trees.tree[1];
  bool is_opposite = false, has_same_sign = false;
  for (int i = 0; i < MODE_STARTS && t->count < MOST_MODES; ++i) {
    bool is_closed = false, is_added;
    int sign = 0;
    if (assemble_end(g, &is_closed) == KM_MEMORY)
      return no_memory(error);
    if (is_closed)
      km_driver_surface_stop_spins(&g->steps.f);
    bool is_known = !is_closed;
    for (int k = 0; k < t->count && !is_known; ++k)
      is_known = km_path_steps_difference(&g->steps, t->saved[k]) < mode_distance;
    if (is_known)
      continue;
    km_status status = add_end(g, 1, out, &sign, &is_added, error);
    if (status)
      return status;
    is_opposite = is_opposite || sign * g->steps.sign < 0;
    has_same_sign = has_same_sign || sign * g->steps.sign > 0;
  }
  out->outcome = t->count > 0                    ? KM_SPACE_PATH_NOT_FOUND
                 : is_opposite && !has_same_sign ? KM_SPACE_PATH_SEPARATED
                                                 : KM_SPACE_PATH_END;
  return KM_OK;
}

/* Both ends. */
static km_status add_ends(path_search *g, km_space_path *out, km_error *error) {
  km_driver_surface *f = &g->steps.f;
  int sign = 0;
  bool is_added = false;
  km_status status = add_end(g, 0, out, &sign, &is_added, error);
  g->steps.sign = f->conditions > f->rows ? 0 : sign; /* else the signs of both ends can't be compared */
  out->outcome = KM_SPACE_PATH_END;
  out->is_at_start = !is_added;
  if (status || !is_added)
    return status;
  if (!g->def->to)
    return add_modes(g, out, error);
  for (int k = 0; !status && k < f->columns; ++k) { /* other parts stay */
    int c = km_driver_surface_coordinate(f, k);
    status = km_state_set_coordinate(f->m, f->s, c, g->def->to[c], error);
  }
  if (!status)
    status = add_end(g, 1, out, &sign, &is_added, error);
  out->outcome = is_added                   ? KM_SPACE_PATH_NOT_FOUND
                 : sign * g->steps.sign < 0 ? KM_SPACE_PATH_SEPARATED
                                            : KM_SPACE_PATH_END;
  return status;
}

/* Moves the drivers straight from the start to their values at the end, hinges through their turns as stated.
 * *is_there: every step is allowed. node[0], node[1]: the end in both trees. */
static km_status drive_straight(path_search *g, bool *is_there, int node[2], km_error *error) {
  km_path_steps *steps = &g->steps;
  km_path_tree *tree = g->trees.tree;
  km_driver_surface *f = &steps->f;
  *is_there = false;
  km_path_steps_move_to(steps, tree[0].saved[0]);
  for (int at = 0; !*is_there;) {
    km_driver_surface_rates(f, steps->N);
    for (int d = 0; d < f->control_count; ++d) {
      int c = g->def->drivers[d];
      double value = g->def->to ? g->def->to[c] : g->def->to_drivers[d];
      steps->du[d] = value * f->m->factor[c] / f->m->unit[c] - f->s->q[c] / f->m->unit[c];
    }
    if (tree[0].count > MOST_STRAIGHT ||
        !km_path_steps_move(steps, km_path_steps_tangent(steps, steps->du), is_there)) {
      *is_there = false;
      return KM_OK;
    }
    at = km_path_trees_add(&g->trees, &tree[0], at);
    if (at < 0)
      return no_memory(error);
    node[0] = at;
  }
  for (node[1] = tree[1].count - 1; node[1] >= 0; --node[1])
    if (km_path_steps_difference(steps, tree[1].saved[node[1]]) <= KM_EQUAL_PATH_CONFIGURATIONS)
      return KM_OK;
  *is_there = g->def->to == NULL; /* another mode at the end will do */
  node[1] = *is_there ? km_path_trees_add(&g->trees, &tree[1], -1) : -1;
  return *is_there && node[1] < 0 ? no_memory(error) : KM_OK;
}

/* Shortens the path between both nodes, rounds its corners and writes it. False when out of memory. */
static bool finish(path_search *g, const int node[2], km_space_path *out) {
  km_path_points points;
  int count = 0;
  double **path = km_path_trees_join(&g->trees, node, &count);
  if (path && !out->is_straight)
    count = km_path_trees_shorten(&g->trees, path, count);
  if (!path || count < 0 || !km_path_points_create(&g->steps, path, count, &g->arena, &points))
    return false;
  out->is_smooth = out->is_straight || points.count < 3;
  return (out->is_smooth || km_path_curve_smooth(&g->trees, &points, &out->is_smooth)) &&
         km_path_table_write(&g->steps, &points, &g->arena, out);
}

/* The straight path of the drivers first, then steps towards each end, then the trees. */
static km_status search(path_search *g, km_progress progress, void *context, km_space_path *out, km_error *error) {
  km_path_tree *tree = g->trees.tree;
  int node[2] = {0, 0};
  bool is_cancelled = false;
  km_status status = drive_straight(g, &out->is_straight, node, error);
  if (status)
    return status;
  bool is_met = out->is_straight;
  for (int i = 0; i < tree[1].count && !is_met; ++i) {
    km_path_steps_move_to(&g->steps, tree[0].saved[0]);
    node[0] = km_path_trees_chain(&g->trees, &tree[0], 0, tree[1].saved[i], KM_MOST_PATH_CHAIN, &is_met);
    node[1] = i;
    if (node[0] < 0)
      return no_memory(error);
  }
  if (!is_met && !km_path_trees_grow(&g->trees, progress, context, &is_cancelled, node))
    return no_memory(error);
  out->configurations = tree[0].count + tree[1].count;
  if (node[0] < 0 && !km_path_table_write_explored(&g->steps, tree, &g->arena, out->explored))
    return no_memory(error);
  if (is_cancelled) {
    out->outcome = KM_SPACE_PATH_STOPPED;
    return km_fail(error, KM_CANCELLED, "stopped while a path was searched");
  }
  if (node[0] < 0)
    return KM_OK;
  if (!finish(g, node, out))
    return no_memory(error);
  out->outcome = KM_SPACE_PATH_FOUND;
  return KM_OK;
}

/* Drivers must be different coordinates; the surface checks which ones they may be. */
static km_status check_drivers(const km_mechanism *m, const km_space_path_def *def, km_error *error) {
  for (int d = 0; d < def->driver_count; ++d) {
    km_status status = km_check_index(def->drivers[d], m->coordinate_count, "coordinate", error);
    if (status)
      return status;
    if (!def->to && !isfinite(def->to_drivers[d]))
      return km_fail(error, KM_USAGE, "the end of joint \"%s\" is %g; expected a number",
                     m->model->coordinates[def->drivers[d]].label, def->to_drivers[d]);
    for (int i = 0; i < d; ++i)
      if (def->drivers[i] == def->drivers[d])
        return km_fail(error, KM_USAGE, "joint \"%s\" drives the path twice",
                       m->model->coordinates[def->drivers[d]].label);
  }
  return KM_OK;
}

static km_status prepare(path_search *g, const km_state *s, km_space_path *out, km_error *error) {
  km_status status = km_state_create(g->steps.f.m, &g->steps.f.s, error);
  if (status)
    return status;
  km_state_copy(g->steps.f.m, g->steps.f.s, s);
  status = km_path_steps_create(&g->steps, &g->arena, error);
  if (status)
    return status;
  g->trees.sample = KM_ARENA_NEW(&g->arena, double, g->steps.f.saved_size);
  return g->trees.sample && km_path_table_create(&g->steps, out) ? KM_OK : no_memory(error);
}

km_status km_space_path_find(const km_mechanism *m, const km_state *s, const km_space_path_def *def,
                             km_progress progress, void *context, km_space_path *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_space_path){.ends = {nan(""), nan("")}};
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(def && def->drivers && (def->to || def->to_drivers),
                            "definition, drivers or end of the path", error);
  if (!status && (def->driver_count < 1 || def->driver_count > KM_MAX_PATH_DRIVERS || !(def->margin >= 0.0)))
    status = km_fail(error, KM_USAGE, "%d drivers and a margin of %g; expected 1 to %d, and no negative margin",
                     def->driver_count, def->margin, KM_MAX_PATH_DRIVERS);
  if (!status)
    status = check_drivers(m, def, error);
  if (status)
    return status;
  path_search g = {.def = def, .steps = {.f = {.m = m, .frame = -1}, .def = def}};
  g.steps.margin = def->margin > 0.0 ? def->margin : KM_DEFAULT_PATH_MARGIN;
  g.trees = (km_path_trees){.steps = &g.steps, .arena = &g.arena, .random = def->seed};
  status = prepare(&g, s, out, error);
  if (!status)
    status = add_ends(&g, out, error);
  if (!status && out->outcome == KM_SPACE_PATH_NOT_FOUND)
    status = search(&g, progress, context, out, error);
  km_path_trees_free(&g.trees);
  km_arena_free(&g.arena);
  km_state_free(g.steps.f.s);
  return status;
}

void km_space_path_free(km_space_path *path) {
  if (!path)
    return;
  km_table_free(path->table);
  km_table_free(path->motion);
  km_table_free(path->explored);
  *path = (km_space_path){0};
}
