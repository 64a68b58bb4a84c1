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
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "kmech/space.h"
#include "space/real_solve.h"

#include <string.h>

enum { MOST_NEWTON = 8, MOST_CHAIN = 400, SHORTENINGS = 200, MODE_STARTS = 60, MOST_STRAIGHT = 5000, MOST_MODES = 16 };
static const double longest_step = 0.04;   /* radians, sizes */
static const double least_progress = 0.3;  /* part of a step: less ends a chain of steps */
static const double closed = 1e-12;        /* largest error: radians, sizes */
static const double most_correction = 0.5; /* first correction over the step */
static const double mode_distance = 1e-4;  /* distance of different assembly modes */
static const double same = 1e-6;           /* distance of equal configurations */
static const double slide_room = 1.0;      /* random slides without limits lie so many sizes around both ends */

/* Configurations reached from one end. */
typedef struct path_tree {
  double **saved; /* [count] as km_state_save */
  int *parent;    /* [count] −1: the end */
  int count;
  size_t saved_capacity, parent_capacity;
} path_tree;

typedef struct path_search {
  const km_mechanism *m;
  const km_space_path_def *def;
  const km_substructure *sub;
  km_state *s;
  km_arena arena;
  int columns, rows, drivers;
  int driver[KM_MAX_PATH_DRIVERS], *other; /* columns */
  double *J, *A, *LU, *N;                  /* [rows × columns], [rows²] twice, [drivers × columns] */
  double *b, *x, *step, *towards;          /* [columns] */
  double square[KM_MAX_PATH_DRIVERS * KM_MAX_PATH_DRIVERS], du[KM_MAX_PATH_DRIVERS], right[KM_MAX_PATH_DRIVERS];
  int *row, small_row[KM_MAX_PATH_DRIVERS];
  double *before, *sample; /* saved configurations */
  size_t saved_size;
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

static void update(path_search *g) {
  km_loops_recompute(g->m, g->s, g->sub);
  km_state_jacobian_dense(g->s, g->sub, g->J);
}

/* Factors A; *sign is that of det A. */
static bool factor(path_search *g, int *sign) {
  for (int i = 0; i < g->rows; ++i)
    for (int j = 0; j < g->rows; ++j)
      g->LU[i * g->rows + j] = g->J[g->other[j] * g->rows + i];
  return km_real_factor(g->LU, g->rows, g->row, sign);
}

/* Closes the loops with the drivers fixed, by Newton's method; A's factors then belong to the configuration. */
static bool close_loops(path_search *g, double step, int *sign) {
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double error = 0.0, correction = 0.0;
    const double *e = km_state_error(g->s, g->sub);
    update(g);
    if (!factor(g, sign))
      return false;
    for (int k = 0; k < g->rows; ++k) {
      error = fmax(error, fabs(e[k]));
      g->b[k] = -e[k];
    }
    if (error <= closed)
      return true;
    km_real_solve(g->LU, g->rows, g->row, g->b, g->x);
    memset(g->step, 0, (size_t)g->columns * sizeof *g->step);
    for (int k = 0; k < g->rows; ++k) {
      g->step[g->other[k]] = g->x[k];
      correction = fmax(correction, fabs(g->x[k]));
    }
    if (!isfinite(correction) || (i == 0 && correction > most_correction * step))
      return false;
    km_state_move(g->m, g->s, g->sub, g->step);
  }
  return false;
}

/* N by driver: the rates of all coordinates per unit rate of each driver, at the present factors. */
static void compute_rates(path_search *g) {
  for (int d = 0; d < g->drivers; ++d) {
    double *N = g->N + d * g->columns;
    memset(N, 0, (size_t)g->columns * sizeof *N);
    for (int k = 0; k < g->rows; ++k)
      g->b[k] = -g->J[g->driver[d] * g->rows + k];
    km_real_solve(g->LU, g->rows, g->row, g->b, g->x);
    for (int k = 0; k < g->rows; ++k)
      N[g->other[k]] = g->x[k];
    N[g->driver[d]] = 1.0;
  }
}

/* Smallest singular value of A at the last update. */
static double singular_value(path_search *g) {
  for (int j = 0; j < g->rows; ++j)
    memcpy(g->A + (size_t)(j * g->rows), g->J + (size_t)(g->other[j] * g->rows), (size_t)g->rows * sizeof *g->A);
  return km_smallest_singular_value(g->A, g->rows, g->rows);
}

/* True if the closed configuration may be on a path. */
static bool is_allowed(path_search *g, int sign) {
  if ((g->sign != 0 && sign != g->sign) || !(singular_value(g) >= g->margin))
    return false;
  if (!g->def->ignore_limits && km_state_find_outside_limit(g->s, g->sub) >= 0)
    return false;
  if (!g->def->condition)
    return true;
  km_poses_compute(g->m, g->s);
  return g->def->condition(g->def->context, g->m, g->s);
}

/* Step from the present to a saved configuration; hinges without limits take the shorter path. Returns its length. */
static double difference(const path_search *g, const double *saved, double *step) {
  double sum = 0.0;
  km_state_difference(g->s, g->sub, saved, step);
  for (int k = 0; k < g->columns; ++k) {
    int c = g->m->column_coordinate[g->sub->column_start + k];
    bool is_free = g->def->ignore_limits || !km_model_coordinate_limits(g->m->model, c, &(double){0}, &(double){0});
    step[k] = km_coordinate_turns(g->m, c) && is_free ? -remainder(step[k], 2.0 * M_PI) : -step[k];
    sum += step[k] * step[k];
  }
  return sqrt(sum);
}

/* One step towards a configuration, `distance` away by g->towards. False: it isn't allowed; the state returns. */
static bool step_towards(path_search *g, double distance) {
  int n = g->columns, f = g->drivers, sign;
  km_state_save(g->s, g->sub, g->before);
  compute_rates(g);
  for (int i = 0; i < f; ++i) {
    g->right[i] = 0.0;
    for (int k = 0; k < n; ++k)
      g->right[i] += g->N[i * n + k] * g->towards[k];
    for (int j = 0; j < f; ++j) {
      g->square[i * f + j] = 0.0;
      for (int k = 0; k < n; ++k)
        g->square[i * f + j] += g->N[i * n + k] * g->N[j * n + k];
    }
  }
  if (!km_real_factor(g->square, f, g->small_row, &sign))
    return false;
  km_real_solve(g->square, f, g->small_row, g->right, g->du);
  bool is_last = distance <= longest_step; /* the drivers then have the values of the end */
  double length = 0.0;
  for (int k = 0; k < n; ++k) {
    g->step[k] = 0.0;
    for (int i = 0; i < f; ++i)
      g->step[k] += g->N[i * n + k] * (is_last ? g->towards[g->driver[i]] : g->du[i]);
    length += g->step[k] * g->step[k];
  }
  length = sqrt(length);
  double part = length > longest_step ? longest_step / length : 1.0;
  for (int k = 0; k < n; ++k)
    g->step[k] *= part;
  km_state_move(g->m, g->s, g->sub, g->step);
  if (close_loops(g, fmax(part * length, same), &sign) && is_allowed(g, sign))
    return true;
  km_state_restore(g->s, g->sub, g->before);
  update(g);
  factor(g, &sign);
  return false;
}

/* ---- Trees. */

/* Adds the state's configuration. Returns its index; −1 when out of memory. */
static int add_node(path_search *g, path_tree *t, int parent) {
  void *saved = t->saved, *parents = t->parent;
  double *place = KM_ARENA_NEW(&g->arena, double, g->saved_size);
  if (!place || !km_reserve(&saved, &t->saved_capacity, (size_t)t->count + 1, sizeof *t->saved))
    return -1;
  t->saved = saved;
  if (!km_reserve(&parents, &t->parent_capacity, (size_t)t->count + 1, sizeof *t->parent))
    return -1;
  t->parent = parents;
  km_state_save(g->s, g->sub, place);
  t->saved[t->count] = place;
  t->parent[t->count] = parent;
  return t->count++;
}

/* Moves the state to the node of a tree that is nearest to a saved configuration. Returns its index. */
static int move_to_nearest(path_search *g, const path_tree *t, const double *saved) {
  int nearest = 0, sign;
  double least = HUGE_VAL;
  km_state_restore(g->s, g->sub, saved);
  for (int i = 0; i < t->count; ++i) {
    double distance = difference(g, t->saved[i], g->towards);
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  km_state_restore(g->s, g->sub, t->saved[nearest]);
  update(g);
  factor(g, &sign);
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
  km_state_restore(g->s, g->sub, g->tree[0].saved[0]);
  if (g->tree[1].count > 0)
    difference(g, g->tree[1].saved[0], g->towards);
  else
    memset(g->towards, 0, (size_t)g->columns * sizeof *g->towards);
  for (int k = 0; k < g->columns; ++k) {
    int c = g->m->column_coordinate[g->sub->column_start + k];
    double u = km_uniform(&g->random), low, high, unit = g->m->factor[c] / g->m->unit[c];
    bool is_limited = km_model_coordinate_limits(g->m->model, c, &low, &high) && isfinite(low) && isfinite(high);
    double here = g->s->q[c] / g->m->unit[c];
    if (is_limited && !g->def->ignore_limits)
      g->step[k] = unit * (0.5 * (low + high) + 0.5 * u * (high - low)) - here;
    else if (km_coordinate_turns(g->m, c))
      g->step[k] = M_PI * u;
    else
      g->step[k] = 0.5 * g->towards[k] + u * (slide_room + 0.5 * fabs(g->towards[k]));
  }
  km_state_move(g->m, g->s, g->sub, g->step);
  km_state_save(g->s, g->sub, g->sample);
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
  int sign;
  km_state_restore(g->s, g->sub, path[i]);
  update(g);
  factor(g, &sign);
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

/* Writes the row of the state's configuration. `place`[columns]: its coordinates, continuous along the path. */
static bool write_row(path_search *g, const double *place, double sigma, km_space_path *out) {
  const km_mechanism *m = g->m;
  double *row = km_table_add_row(out->table);
  if (!row)
    return false;
  double *other = row + 1 + g->drivers;
  *row++ = out->length;
  for (int c = 0; c < m->coordinate_count; ++c) {
    bool is_own = m->substructure_of[c] == (int)(g->sub - m->substructures) && !m->held[c];
    double value = is_own ? place[m->column_of[c]] * m->unit[c] / m->factor[c] : km_state_value(g->s, c);
    int driver = 0;
    while (driver < g->drivers && g->def->drivers[driver] != c)
      ++driver;
    *(driver < g->drivers ? &row[driver] : other++) = value;
  }
  *other = sigma;
  return true;
}

static bool write_path(path_search *g, double *const *path, int count, km_space_path *out) {
  double *place = KM_ARENA_NEW(&g->arena, double, (size_t)g->columns);
  out->least_margin = HUGE_VAL;
  for (int i = 0; place && i < count; ++i) {
    km_state_restore(g->s, g->sub, path[i]);
    double step = i > 0 ? difference(g, path[i - 1], g->towards) : 0.0;
    for (int k = 0; k < g->columns; ++k) {
      int c = g->m->column_coordinate[g->sub->column_start + k];
      place[k] = i > 0 ? place[k] - g->towards[k] : g->s->q[c] / g->m->unit[c];
    }
    out->length += step;
    if (i > 0 && step <= same && i + 1 < count)
      continue; /* both trees have met here */
    update(g);
    double sigma = singular_value(g);
    out->ends[i > 0] = sigma;
    out->least_margin = fmin(out->least_margin, sigma);
    if (!write_row(g, place, sigma, out))
      return false;
  }
  return place != NULL;
}

/* ---- Preparation. */

static bool add_columns(const path_search *g, km_table *table) {
  const km_mechanism *m = g->m;
  bool is_ok = table && km_table_add_joined_column(table, "s", "", "", "");
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; is_ok && k < (pass == 0 ? g->drivers : m->coordinate_count); ++k) {
      int c = pass == 0 ? g->def->drivers[k] : k;
      bool is_driver = false;
      for (int d = 0; pass == 1 && d < g->drivers; ++d)
        is_driver = is_driver || g->def->drivers[d] == c;
      is_ok = is_driver || km_table_add_joined_column(table, "q.", m->model->coordinates[c].label, "",
                                                      km_model_coordinate_unit(m->model, c));
    }
  return is_ok && km_table_add_joined_column(table, "sigma.input", "", "", "");
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the path");
}

static km_status check_drivers(path_search *g, km_error *error) {
  const km_mechanism *m = g->m;
  int part = -1;
  for (int d = 0; d < g->drivers; ++d) {
    int c = g->def->drivers[d];
    km_status status = km_check_index(c, m->coordinate_count, "coordinate", error);
    if (status)
      return status;
    int own = m->substructure_of[c];
    if (m->held[c] || own < 0 || m->substructures[own].loop_count == 0 || m->ball_of[c] >= 0)
      return km_fail(error, KM_USAGE, "joint \"%s\" can't drive a path; expected a free hinge or slide of a loop",
                     m->model->coordinates[c].label);
    if (part >= 0 && own != part)
      return km_fail(error, KM_USAGE, "all drivers of a path must be joints of one part of the mechanism");
    for (int i = 0; i < d; ++i)
      if (g->def->drivers[i] == c)
        return km_fail(error, KM_USAGE, "joint \"%s\" drives the path twice", m->model->coordinates[c].label);
    part = own;
    g->driver[d] = m->column_of[c];
  }
  g->sub = &m->substructures[part];
  g->columns = g->sub->columns;
  g->rows = km_substructure_rows(m, part);
  for (int k = 0; k < g->columns; ++k)
    if (m->ball_of[m->column_coordinate[g->sub->column_start + k]] >= 0)
      return km_fail(error, KM_USAGE, "paths don't cover ball joints; expected hinges and slides");
  if (g->rows != g->columns - g->drivers)
    return km_fail(
        error, KM_USAGE,
        "the part of the mechanism has %d coordinates and %d conditions; expected %d drivers and no redundant "
        "conditions",
        g->columns, g->rows, g->columns - g->rows);
  return KM_OK;
}

static km_status prepare(path_search *g, km_error *error) {
  size_t n = (size_t)g->columns, r = (size_t)g->rows;
  km_arena *a = &g->arena;
  g->saved_size = KM_SAVED_PER_COLUMN * n;
  g->other = KM_ARENA_NEW(a, int, r + 1);
  g->J = KM_ARENA_NEW(a, double, n *r + 1);
  g->A = KM_ARENA_NEW(a, double, r *r + 1);
  g->LU = KM_ARENA_NEW(a, double, r *r + 1);
  g->N = KM_ARENA_NEW(a, double, n *(size_t)g->drivers);
  g->b = KM_ARENA_NEW(a, double, n);
  g->x = KM_ARENA_NEW(a, double, n);
  g->step = KM_ARENA_NEW(a, double, n);
  g->towards = KM_ARENA_NEW(a, double, n);
  g->row = KM_ARENA_NEW(a, int, r + 1);
  g->before = KM_ARENA_NEW(a, double, g->saved_size);
  g->sample = KM_ARENA_NEW(a, double, g->saved_size);
  if (a->failed)
    return no_memory(error);
  for (int k = 0, count = 0; k < g->columns; ++k) {
    bool is_driver = false;
    for (int d = 0; d < g->drivers; ++d)
      is_driver = is_driver || g->driver[d] == k;
    if (!is_driver)
      g->other[count++] = k;
  }
  return KM_OK;
}

/* Makes the state's configuration a root of a tree if it may be on a path. *sign: of det A; 0: the loops are open. */
static km_status add_end(path_search *g, int side, km_space_path *out, int *sign, bool *is_added, km_error *error) {
  if (!close_loops(g, HUGE_VAL, sign)) {
    *sign = 0;
    *is_added = false;
    return KM_OK;
  }
  *is_added = is_allowed(g, *sign);
  double sigma = singular_value(g);
  out->ends[side] = isnan(out->ends[side]) ? sigma : fmax(out->ends[side], sigma);
  return *is_added && add_node(g, &g->tree[side], -1) < 0 ? no_memory(error) : KM_OK;
}

/* Assembles the loops with the drivers at the values of the end, from random values of the others. */
static km_status assemble_end(path_search *g, bool *is_closed) {
  draw_sample(g);
  km_state_restore(g->s, g->sub, g->sample);
  for (int d = 0; d < g->drivers; ++d) {
    int c = g->def->drivers[d];
    km_state_set_coordinate(g->m, g->s, c, g->def->to_drivers[d], NULL);
    km_state_lock(g->s, c);
  }
  km_state_invalidate_pivots(g->s, (int)(g->sub - g->m->substructures));
  km_status status = km_assemble_one(g->m, g->s, (int)(g->sub - g->m->substructures), g->before, is_closed);
  km_state_unlock(g->s);
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
  for (int k = 0; !status && k < g->columns; ++k) { /* other parts stay */
    int c = g->m->column_coordinate[g->sub->column_start + k];
    status = km_state_set_coordinate(g->m, g->s, c, g->def->to[c], error);
  }
  if (!status)
    status = add_end(g, 1, out, &sign, &is_added, error);
  out->outcome = is_added ? KM_SPACE_PATH_NOT_FOUND : sign == -g->sign ? KM_SPACE_PATH_SEPARATED : KM_SPACE_PATH_END;
  return status;
}

/* Moves the drivers straight from the start to their values at the end, hinges through their turns as stated.
 * *is_there: every step is allowed. node[0], node[1]: the end in both trees. */
static km_status drive_straight(path_search *g, bool *is_there, int node[2], km_error *error) {
  int n = g->columns, sign;
  *is_there = false;
  km_state_restore(g->s, g->sub, g->tree[0].saved[0]);
  update(g);
  factor(g, &sign);
  for (int at = 0; !*is_there;) {
    double length = 0.0;
    compute_rates(g);
    memset(g->step, 0, (size_t)n * sizeof *g->step);
    for (int d = 0; d < g->drivers; ++d) {
      int c = g->def->drivers[d];
      double value = g->def->to ? g->def->to[c] : g->def->to_drivers[d];
      double du = value * g->m->factor[c] / g->m->unit[c] - g->s->q[c] / g->m->unit[c];
      for (int k = 0; k < n; ++k)
        g->step[k] += g->N[d * n + k] * du;
    }
    for (int k = 0; k < n; ++k)
      length += g->step[k] * g->step[k];
    length = sqrt(length);
    *is_there = length <= longest_step;
    double part = *is_there ? 1.0 : longest_step / length;
    for (int k = 0; k < n; ++k)
      g->step[k] *= part;
    km_state_move(g->m, g->s, g->sub, g->step);
    if (g->tree[0].count > MOST_STRAIGHT || !close_loops(g, fmax(part * length, same), &sign) || !is_allowed(g, sign)) {
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
  int node[2] = {0, 0}, count = 0, sign;
  bool is_cancelled = false;
  km_status status = drive_straight(g, &out->is_straight, node, error);
  if (status)
    return status;
  bool is_met = out->is_straight;
  for (int i = 0; i < g->tree[1].count && !is_met; ++i) {
    km_state_restore(g->s, g->sub, g->tree[0].saved[0]);
    update(g);
    factor(g, &sign);
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
  path_search g = {.m = m, .def = def, .drivers = def->driver_count, .random = def->seed};
  g.margin = def->margin > 0.0 ? def->margin : KM_DEFAULT_PATH_MARGIN;
  status = check_drivers(&g, error);
  if (!status)
    status = prepare(&g, error);
  if (!status)
    status = km_state_create(m, &g.s, error);
  if (!status) {
    km_state_copy(m, g.s, s);
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
  km_state_free(g.s);
  return status;
}

void km_space_path_free(km_space_path *path) {
  if (!path)
    return;
  km_table_free(path->table);
  *path = (km_space_path){0};
}
