/* Paths between two configurations without a singularity of the drivers (docs/theory.md 4.21).
 *
 *   J = (A B),  e(q) = 0;   du drivers:  dq = N du,  N = (−A⁻¹ B; I)
 *   step towards q':  du = (Nᵀ N)⁻¹ Nᵀ (q' − q), |N du| <= LONGEST, then Newton's method with the drivers fixed
 *   kept if          sign det A stays, σ_min(A) >= margin, within limits, the caller's condition holds
 *
 * Two trees, one from each end: one steps towards a random configuration, the other towards what the first has reached
 * (J. Kuffner, S. LaValle 2000). Shortening: the path between two of its configurations becomes the steps that lead
 * straight from one to the other, where they do. */
#include "base/arguments.h"
#include "base/random.h"
#include "base/table.h"
#include "kinematics/assembly.h"
#include "kmech/mobility.h"
#include "space/driver_surface.h"
#include "space/real_solve.h"

#include <stdio.h>
#include <string.h>

enum { MOST_CHAIN = 400, SHORTENINGS = 200, MODE_STARTS = 60, MOST_STRAIGHT = 5000, MOST_MODES = 16 };
static const double longest_step = 0.04;   /* radians, sizes */
static const double least_progress = 0.3;  /* part of a step: less ends a chain of steps */
static const double most_correction = 0.5; /* first correction over the step */
static const double mode_distance = 1e-4;  /* distance of different assembly modes */
static const double same = 1e-6;           /* distance of equal configurations */
static const double slide_room = 1.0;      /* half range of random slides without limits, beyond both ends: sizes */

/* Configurations reached from one end. */
typedef struct path_tree {
  double **saved; /* [count] as km_state_save */
  int *parent;    /* [count] −1: the end */
  int count;
  size_t saved_capacity, parent_capacity;
} path_tree;

typedef struct path_search {
  km_driver_surface f; /* configurations of one substructure; controls: the drivers */
  const km_space_path_def *def;
  km_arena arena;
  double *N;       /* [drivers × columns] */
  double *towards; /* [columns] step to a configuration */
  double square[KM_MAX_PATH_DRIVERS * KM_MAX_PATH_DRIVERS], du[KM_MAX_PATH_DRIVERS], right[KM_MAX_PATH_DRIVERS];
  int small_row[KM_MAX_PATH_DRIVERS];
  double *before, *sample; /* saved configurations */
  double margin;
  int sign; /* sign of det A along the path */
  path_tree tree[2];
  uint64_t random;
} path_search;

const char *km_space_path_outcome_name(km_space_path_outcome outcome) {
  static const char *const names[] = {"found", "separated", "end", "not found"};
  return outcome >= KM_SPACE_PATH_FOUND && outcome <= KM_SPACE_PATH_NOT_FOUND ? names[outcome] : "";
}

/* ---- One configuration. */

static int part_of(const path_search *g) {
  return g->f.part[0].substructure;
}

/* Moves the state to a saved configuration; A's factors are then those there. */
static void move_to(path_search *g, const double *saved) {
  int sign;
  km_driver_surface_restore(&g->f, saved);
  km_driver_surface_update(&g->f);
  km_driver_surface_factor(&g->f, &sign);
}

/* True if the closed configuration may be on a path. */
static bool is_allowed(path_search *g, int sign) {
  km_driver_surface *f = &g->f;
  if ((g->sign != 0 && sign != g->sign) || !(km_driver_surface_input_value(f) >= g->margin))
    return false;
  if (!g->def->ignore_limits && km_driver_surface_is_outside_limit(f))
    return false;
  if (!g->def->condition)
    return true;
  km_poses_compute(f->m, f->s);
  return g->def->condition(g->def->context, f->m, f->s);
}

/* Step from the present to a saved configuration; hinges without limits take the shorter path. Returns its length. */
static double difference(const path_search *g, const double *saved, double *step) {
  double length = km_driver_surface_difference(&g->f, saved, step);
  for (int k = 0; k < g->f.columns; ++k)
    step[k] = -step[k];
  return length;
}

/* Moves the drivers by du, or by the part of it whose step N du is as long as a step may be, with N at the present
 * configuration. *is_whole: by all of it. False: it isn't allowed; the state's configuration is
 * then undefined. */
static bool move_drivers(path_search *g, const double *du, bool *is_whole) {
  km_driver_surface *f = &g->f;
  int n = f->columns, sign;
  double length = 0.0;
  for (int k = 0; k < n; ++k) {
    f->step[k] = 0.0;
    for (int d = 0; d < f->control_count; ++d)
      f->step[k] += g->N[d * n + k] * du[d];
    length += f->step[k] * f->step[k];
  }
  length = sqrt(length);
  *is_whole = length <= longest_step;
  double part = *is_whole ? 1.0 : longest_step / length;
  for (int k = 0; k < n; ++k)
    f->step[k] *= part;
  km_driver_surface_move(f, f->step);
  return km_driver_surface_close(f, most_correction * fmax(part * length, same), &sign) && is_allowed(g, sign);
}

/* du <- (Nᵀ N)⁻¹ Nᵀ g->towards. */
static bool project(path_search *g) {
  int n = g->f.columns, drivers = g->f.control_count, sign;
  for (int i = 0; i < drivers; ++i) {
    g->right[i] = 0.0;
    for (int k = 0; k < n; ++k)
      g->right[i] += g->N[i * n + k] * g->towards[k];
    for (int j = 0; j < drivers; ++j) {
      g->square[i * drivers + j] = 0.0;
      for (int k = 0; k < n; ++k)
        g->square[i * drivers + j] += g->N[i * n + k] * g->N[j * n + k];
    }
  }
  if (!km_real_factor(g->square, drivers, g->small_row, &sign))
    return false;
  km_real_solve(g->square, drivers, g->small_row, g->right, g->du);
  return true;
}

/* One step towards a configuration, `distance` away by g->towards. False: it isn't allowed; the state returns. */
static bool step_towards(path_search *g, double distance) {
  bool is_whole;
  km_driver_surface_save(&g->f, g->before);
  km_driver_surface_rates(&g->f, g->N);
  if (!project(g))
    return false;
  for (int d = 0; distance <= longest_step && d < g->f.control_count; ++d) /* exactly the values of the end */
    g->du[d] = g->towards[g->f.control[d]];
  if (move_drivers(g, g->du, &is_whole))
    return true;
  move_to(g, g->before);
  return false;
}

/* ---- Trees. */

/* Adds the state's configuration. Returns its index; −1 when out of memory. */
static int add_node(path_search *g, path_tree *t, int parent) {
  void *saved = t->saved, *parents = t->parent;
  double *place = KM_ARENA_NEW(&g->arena, double, g->f.saved_size);
  if (!place || !km_reserve(&saved, &t->saved_capacity, (size_t)t->count + 1, sizeof *t->saved))
    return -1;
  t->saved = saved;
  if (!km_reserve(&parents, &t->parent_capacity, (size_t)t->count + 1, sizeof *t->parent))
    return -1;
  t->parent = parents;
  km_driver_surface_save(&g->f, place);
  t->saved[t->count] = place;
  t->parent[t->count] = parent;
  return t->count++;
}

/* Moves the state to the node of a tree that is nearest to a saved configuration. Returns its index. */
static int move_to_nearest(path_search *g, const path_tree *t, const double *saved) {
  int nearest = 0;
  double least = HUGE_VAL;
  km_driver_surface_restore(&g->f, saved);
  for (int i = 0; i < t->count; ++i) {
    double distance = difference(g, t->saved[i], g->towards);
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  move_to(g, t->saved[nearest]);
  return nearest;
}

/* Steps from the state, node `from` of a tree, towards a saved configuration as long as that comes nearer. Returns the
 * last node; −1 when out of memory. *is_there: the configuration was reached. */
static int chain(path_search *g, path_tree *t, int from, const double *saved, int most, bool *is_there) {
  *is_there = false;
  for (int i = 0; i < most; ++i) {
    double before = difference(g, saved, g->towards);
    *is_there = before <= same;
    if (*is_there || !step_towards(g, before))
      return from;
    double after = difference(g, saved, g->towards);
    *is_there = after <= same;
    if (!*is_there && before - after < least_progress * fmin(longest_step, before))
      return from;
    from = add_node(g, t, from);
    if (from < 0 || *is_there)
      return from;
  }
  return from;
}

/* A random configuration, open. */
static void draw_sample(path_search *g) {
  km_driver_surface *f = &g->f;
  km_driver_surface_restore(f, g->tree[0].saved[0]);
  if (g->tree[1].count > 0)
    difference(g, g->tree[1].saved[0], g->towards);
  else
    memset(g->towards, 0, (size_t)f->columns * sizeof *g->towards);
  for (int k = 0; k < f->columns; ++k) {
    int c = km_driver_surface_coordinate(f, k);
    double u = km_uniform(&g->random), low, high, unit = f->m->factor[c] / f->m->unit[c];
    bool is_limited = km_model_coordinate_limits(f->m->model, c, &low, &high) && isfinite(low) && isfinite(high);
    double here = f->s->q[c] / f->m->unit[c];
    if (is_limited && !g->def->ignore_limits)
      f->step[k] = unit * (0.5 * (low + high) + 0.5 * u * (high - low)) - here;
    else if (km_coordinate_turns(f->m, c))
      f->step[k] = M_PI * u;
    else
      f->step[k] = 0.5 * g->towards[k] + u * (slide_room + 0.5 * fabs(g->towards[k]));
  }
  km_driver_surface_move(f, f->step);
  km_driver_surface_save(f, g->sample);
}

/* Grows both trees until they meet. *node: where, in each tree; −1: they don't. False when out of memory. */
static bool grow(path_search *g, km_progress progress, void *context, bool *is_cancelled, int node[2]) {
  int most = g->def->most > 0 ? g->def->most : KM_DEFAULT_PATH_CONFIGURATIONS;
  node[0] = node[1] = -1;
  for (int side = 0, tries = 0; g->tree[0].count + g->tree[1].count < most && tries < most; side = 1 - side, ++tries) {
    bool is_there;
    path_tree *a = &g->tree[side], *b = &g->tree[1 - side];
    draw_sample(g);
    int reached = chain(g, a, move_to_nearest(g, a, g->sample), g->sample, MOST_CHAIN, &is_there);
    if (reached < 0)
      return false;
    const double *target = a->saved[reached];
    int met = chain(g, b, move_to_nearest(g, b, target), target, MOST_CHAIN, &is_there);
    if (met < 0)
      return false;
    if (is_there) {
      node[side] = reached;
      node[1 - side] = met;
      return true;
    }
    *is_cancelled = progress && !progress(context, (double)(a->count + b->count) / most);
    if (*is_cancelled)
      return true;
  }
  return true;
}

/* ---- The path. */

/* Joins both branches: path[count] from one end to the other. NULL when out of memory. */
static double **join(path_search *g, const int node[2], int *count) {
  int lengths[2] = {0, 0};
  for (int side = 0; side < 2; ++side)
    for (int i = node[side]; i >= 0; i = g->tree[side].parent[i])
      ++lengths[side];
  *count = lengths[0] + lengths[1];
  double **path = KM_ARENA_NEW(&g->arena, double *, (size_t)*count);
  if (!path)
    return NULL;
  int at = lengths[0];
  for (int i = node[0]; i >= 0; i = g->tree[0].parent[i])
    path[--at] = g->tree[0].saved[i];
  at = lengths[0];
  for (int i = node[1]; i >= 0; i = g->tree[1].parent[i])
    path[at++] = g->tree[1].saved[i];
  return path;
}

/* Replaces the part from path[i] to path[j] by the steps straight from one to the other, if they are fewer. Returns the
 * new count; −1 when out of memory. */
static int shorten(path_search *g, double **path, int count, int i, int j) {
  path_tree part = {0};
  bool is_there;
  move_to(g, path[i]);
  int last = chain(g, &part, -1, path[j], j - i - 1, &is_there);
  int added = part.count - 1; /* the last one is path[j] */
  bool is_shorter = is_there && last >= 0 && added < j - i - 1;
  if (is_shorter) {
    for (int k = 0; k < added; ++k)
      path[i + 1 + k] = part.saved[k];
    memmove(path + i + 1 + added, path + j, (size_t)(count - j) * sizeof *path);
  }
  km_free(part.saved);
  km_free(part.parent);
  return g->arena.failed ? -1 : is_shorter ? count - (j - i - 1 - added) : count;
}

static int shorten_all(path_search *g, double **path, int count) {
  for (int k = 0; k < SHORTENINGS && count > 2; ++k) {
    int i = (int)((0.5 + 0.5 * km_uniform(&g->random)) * (count - 1)),
        j = (int)((0.5 + 0.5 * km_uniform(&g->random)) * count);
    int low = i < j ? i : j, high = i < j ? j : i;
    if (high - low > 1)
      count = shorten(g, path, count, low, high);
    if (count < 0)
      return -1;
  }
  return count;
}

/* Place of a coordinate among the drivers; −1: it is none. */
static int driver_index(const path_search *g, int coordinate) {
  int d = g->f.control_count - 1;
  while (d >= 0 && g->def->drivers[d] != coordinate)
    --d;
  return d;
}

/* Writes the row of the state's configuration. `place`[columns]: its coordinates, continuous along the path. */
static bool write_row(path_search *g, const double *place, double sigma, km_space_path *out) {
  const km_mechanism *m = g->f.m;
  double *row = km_table_add_row(out->table);
  if (!row)
    return false;
  double *other = row + 1 + g->f.control_count;
  *row++ = out->length;
  for (int c = 0; c < m->coordinate_count; ++c) {
    bool is_own = m->substructure_of[c] == part_of(g) && !m->held[c];
    double value = is_own ? place[m->column_of[c]] * m->unit[c] / m->factor[c] : km_state_value(g->f.s, c);
    int driver = driver_index(g, c);
    *(driver >= 0 ? &row[driver] : other++) = value;
  }
  *other = sigma;
  return true;
}

static bool write_path(path_search *g, double *const *path, int count, km_space_path *out) {
  km_driver_surface *f = &g->f;
  double *place = KM_ARENA_NEW(&g->arena, double, (size_t)f->columns);
  out->least_margin = HUGE_VAL;
  for (int i = 0; place && i < count; ++i) {
    km_driver_surface_restore(f, path[i]);
    double step = i > 0 ? difference(g, path[i - 1], g->towards) : 0.0;
    for (int k = 0; k < f->columns; ++k) {
      int c = km_driver_surface_coordinate(f, k);
      place[k] = i > 0 ? place[k] - g->towards[k] : f->s->q[c] / f->m->unit[c];
    }
    out->length += step;
    if (i > 0 && step <= same && i + 1 < count)
      continue; /* both trees have met here */
    km_driver_surface_update(f);
    double sigma = km_driver_surface_input_value(f);
    out->ends[i > 0] = sigma;
    out->least_margin = fmin(out->least_margin, sigma);
    if (!write_row(g, place, sigma, out))
      return false;
  }
  return place != NULL;
}

/* ---- Preparation. */

static bool add_columns(const path_search *g, km_table *table) {
  const km_mechanism *m = g->f.m;
  bool is_ok = table && km_table_add_joined_column(table, "s", "", "", "");
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; is_ok && k < (pass == 0 ? g->f.control_count : m->coordinate_count); ++k) {
      int c = pass == 0 ? g->def->drivers[k] : k;
      is_ok = (pass == 1 && driver_index(g, c) >= 0) ||
              km_table_add_joined_column(table, "q.", m->model->coordinates[c].label, "",
                                         km_model_coordinate_unit(m->model, c));
    }
  return is_ok && km_table_add_joined_column(table, "sigma.input", "", "", "");
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the path");
}

/* Checks that the drivers are different joints of one part with loops. *part: its index. */
static km_status check_drivers(const path_search *g, int *part, km_error *error) {
  const km_mechanism *m = g->f.m;
  *part = -1;
  for (int d = 0; d < g->def->driver_count; ++d) {
    int c = g->def->drivers[d];
    km_status status = km_check_index(c, m->coordinate_count, "coordinate", error);
    if (status)
      return status;
    int own = m->substructure_of[c];
    if (m->held[c] || own < 0 || m->substructures[own].loop_count == 0 || m->ball_of[c] >= 0)
      return km_fail(error, KM_USAGE, "joint \"%s\" can't drive a path; expected a free hinge or slide of a loop",
                     m->model->coordinates[c].label);
    if (*part >= 0 && own != *part)
      return km_fail(error, KM_USAGE, "all drivers of a path must be joints of one part of the mechanism");
    for (int i = 0; i < d; ++i)
      if (g->def->drivers[i] == c)
        return km_fail(error, KM_USAGE, "joint \"%s\" drives the path twice", m->model->coordinates[c].label);
    *part = own;
  }
  const km_substructure *sub = &m->substructures[*part];
  for (int k = 0; k < sub->columns; ++k)
    if (m->ball_of[m->column_coordinate[sub->column_start + k]] >= 0)
      return km_fail(error, KM_USAGE, "paths don't cover ball joints; expected hinges and slides");
  return KM_OK;
}

static km_status prepare(path_search *g, km_error *error) {
  km_driver_surface *f = &g->f;
  km_arena *a = &g->arena;
  char expected[64];
  int part;
  km_status status = check_drivers(g, &part, error);
  if (status)
    return status;
  snprintf(expected, sizeof expected, "%d drivers and no redundant conditions",
           f->m->substructures[part].columns - km_substructure_rows(f->m, part));
  status = km_driver_surface_create(f, g->def->drivers, g->def->driver_count, expected, a, error);
  if (status)
    return status;
  g->N = KM_ARENA_NEW(a, double, (size_t)(f->control_count * f->columns));
  g->towards = KM_ARENA_NEW(a, double, (size_t)f->columns);
  g->before = KM_ARENA_NEW(a, double, f->saved_size);
  g->sample = KM_ARENA_NEW(a, double, f->saved_size);
  for (int k = 0; k < f->columns && !g->def->ignore_limits; ++k)
    f->wraps[k] = f->wraps[k] && !km_model_coordinate_limits(f->m->model, km_driver_surface_coordinate(f, k),
                                                             &(double){0}, &(double){0});
  return a->failed ? no_memory(error) : KM_OK;
}

/* Makes the state's configuration a root of a tree if it may be on a path. *sign: of det A; 0: the loops are open. */
static km_status add_end(path_search *g, int side, km_space_path *out, int *sign, bool *is_added, km_error *error) {
  if (!km_driver_surface_close(&g->f, HUGE_VAL, sign)) {
    *sign = 0;
    *is_added = false;
    return KM_OK;
  }
  *is_added = is_allowed(g, *sign);
  double sigma = km_driver_surface_input_value(&g->f);
  out->ends[side] = isnan(out->ends[side]) ? sigma : fmax(out->ends[side], sigma);
  return *is_added && add_node(g, &g->tree[side], -1) < 0 ? no_memory(error) : KM_OK;
}

/* Assembles the loops with the drivers at the values of the end, from random values of the others. */
static km_status assemble_end(path_search *g, bool *is_closed) {
  km_driver_surface *f = &g->f;
  draw_sample(g);
  for (int d = 0; d < f->control_count; ++d) {
    int c = g->def->drivers[d];
    km_state_set_coordinate(f->m, f->s, c, g->def->to_drivers[d], NULL);
    km_state_lock(f->s, c);
  }
  km_state_invalidate_pivots(f->s, part_of(g));
  km_status status = km_assemble_one(f->m, f->s, part_of(g), g->before, is_closed);
  km_state_unlock(f->s);
  return status;
}

/* Adds the assembly modes at the end's values of the drivers that random starts find. */
static km_status add_modes(path_search *g, km_space_path *out, km_error *error) {
  path_tree *t = &g->tree[1];
  bool is_opposite = false, has_same_sign = false;
  for (int i = 0; i < MODE_STARTS && t->count < MOST_MODES; ++i) {
    bool is_closed = false, is_added;
    int sign = 0;
    if (assemble_end(g, &is_closed) == KM_MEMORY)
      return no_memory(error);
    bool is_known = !is_closed;
    for (int k = 0; k < t->count && !is_known; ++k)
      is_known = difference(g, t->saved[k], g->towards) < mode_distance;
    if (is_known)
      continue;
    km_status status = add_end(g, 1, out, &sign, &is_added, error);
    if (status)
      return status;
    is_opposite = is_opposite || sign == -g->sign;
    has_same_sign = has_same_sign || sign == g->sign;
  }
  out->outcome = t->count > 0                    ? KM_SPACE_PATH_NOT_FOUND
                 : is_opposite && !has_same_sign ? KM_SPACE_PATH_SEPARATED
                                                 : KM_SPACE_PATH_END;
  return KM_OK;
}

/* Both ends. */
static km_status add_ends(path_search *g, km_space_path *out, km_error *error) {
  int sign = 0;
  bool is_added = false;
  km_status status = add_end(g, 0, out, &sign, &is_added, error);
  g->sign = sign;
  out->outcome = KM_SPACE_PATH_END;
  out->is_at_start = !is_added;
  if (status || !is_added)
    return status;
  if (!g->def->to)
    return add_modes(g, out, error);
  for (int k = 0; !status && k < g->f.columns; ++k) { /* other parts stay */
    int c = km_driver_surface_coordinate(&g->f, k);
    status = km_state_set_coordinate(g->f.m, g->f.s, c, g->def->to[c], error);
  }
  if (!status)
    status = add_end(g, 1, out, &sign, &is_added, error);
  out->outcome = is_added ? KM_SPACE_PATH_NOT_FOUND : sign == -g->sign ? KM_SPACE_PATH_SEPARATED : KM_SPACE_PATH_END;
  return status;
}

/* Moves the drivers straight from the start to their values at the end, hinges through their turns as stated.
 * *is_there: every step is allowed. node[0], node[1]: the end in both trees. */
static km_status drive_straight(path_search *g, bool *is_there, int node[2], km_error *error) {
  km_driver_surface *f = &g->f;
  *is_there = false;
  move_to(g, g->tree[0].saved[0]);
  for (int at = 0; !*is_there;) {
    km_driver_surface_rates(f, g->N);
    for (int d = 0; d < f->control_count; ++d) {
      int c = g->def->drivers[d];
      double value = g->def->to ? g->def->to[c] : g->def->to_drivers[d];
      g->du[d] = value * f->m->factor[c] / f->m->unit[c] - f->s->q[c] / f->m->unit[c];
    }
    if (g->tree[0].count > MOST_STRAIGHT || !move_drivers(g, g->du, is_there)) {
      *is_there = false;
      return KM_OK;
    }
    at = add_node(g, &g->tree[0], at);
    if (at < 0)
      return no_memory(error);
    node[0] = at;
  }
  for (node[1] = g->tree[1].count - 1; node[1] >= 0; --node[1])
    if (difference(g, g->tree[1].saved[node[1]], g->towards) <= same)
      return KM_OK;
  *is_there = g->def->to == NULL; /* another mode at the end will do */
  node[1] = *is_there ? add_node(g, &g->tree[1], -1) : -1;
  return *is_there && node[1] < 0 ? no_memory(error) : KM_OK;
}

/* The straight path of the drivers first, then steps towards each end, then the trees. */
static km_status search(path_search *g, km_progress progress, void *context, km_space_path *out, km_error *error) {
  int node[2] = {0, 0}, count = 0;
  bool is_cancelled = false;
  km_status status = drive_straight(g, &out->is_straight, node, error);
  if (status)
    return status;
  bool is_met = out->is_straight;
  for (int i = 0; i < g->tree[1].count && !is_met; ++i) {
    move_to(g, g->tree[0].saved[0]);
    node[0] = chain(g, &g->tree[0], 0, g->tree[1].saved[i], MOST_CHAIN, &is_met);
    node[1] = i;
    if (node[0] < 0)
      return no_memory(error);
  }
  if (!is_met && !grow(g, progress, context, &is_cancelled, node))
    return no_memory(error);
  out->configurations = g->tree[0].count + g->tree[1].count;
  if (is_cancelled)
    return km_fail(error, KM_CANCELLED, "stopped while a path was searched");
  if (node[0] < 0)
    return KM_OK;
  double **path = join(g, node, &count);
  count = path ? shorten_all(g, path, count) : -1;
  if (count < 0 || !write_path(g, path, count, out))
    return no_memory(error);
  out->outcome = KM_SPACE_PATH_FOUND;
  return KM_OK;
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
  if (status)
    return status;
  path_search g = {.f = {.m = m, .frame = -1}, .def = def, .random = def->seed};
  g.margin = def->margin > 0.0 ? def->margin : KM_DEFAULT_PATH_MARGIN;
  status = prepare(&g, error);
  if (!status)
    status = km_state_create(m, &g.f.s, error);
  if (!status) {
    km_state_copy(m, g.f.s, s);
    out->table = km_table_create();
    status = add_columns(&g, out->table) ? add_ends(&g, out, error) : no_memory(error);
  }
  if (!status && out->outcome == KM_SPACE_PATH_NOT_FOUND)
    status = search(&g, progress, context, out, error);
  for (int side = 0; side < 2; ++side) {
    km_free(g.tree[side].saved);
    km_free(g.tree[side].parent);
  }
  km_arena_free(&g.arena);
  km_state_free(g.f.s);
  return status;
}

void km_space_path_free(km_space_path *path) {
  if (!path)
    return;
  km_table_free(path->table);
  *path = (km_space_path){0};
}
