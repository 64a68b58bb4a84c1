/* First configurations of a workspace, its plane or space, and its box (docs/theory.md 4.23).
 *
 *   closures : random values of all coordinates, then the loops are closed
 *   motions  : straight in the tangent space from a known configuration, carried on, until a bound or about a turn
 *   plane    : the points' differences d_i by Gram-Schmidt, the longest remainder first; its normal is orthogonal
 *   box      : extrema of each coordinate, from the farthest known points on; 0.5 % more at each end */
#include "space/surface/point_surface.h"
#include "space/volume/volume_search.h"

#include "base/random.h"

#include <string.h>

enum {
  CLOSURES = 256,
  MOTIONS = 1024,
  GROUP = 64, /* searches whose configurations the next ones begin at */
  EXTREMA = 8 /* searches for each end of the box */
};
static const double flat = 1e-8;        /* remainder of the longest difference that is none: closed to 1e-12 L */
static const double box_margin = 0.005; /* part of the extent, at each end */
static const double closures_end = 0.2; /* 256 of 1280 searches */
static const double start_part = 0.05;  /* 2 to 4 % of the time of 10 000 samples in models/ are before them */

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the workspace");
}

bool km_volume_add_known(km_volume_search *g, const double *x, const double *saved, bool is_start) {
  void *known = g->known;
  bool is_ok = km_reserve(&known, &g->known_capacity, (size_t)g->known_count + 1, sizeof *g->known);
  g->known = known;
  if (!is_ok)
    return false;
  km_known_point *added = &g->known[g->known_count++];
  *added = (km_known_point){.saved = saved, .is_start = is_start};
  memcpy(added->x, x, sizeof added->x);
  return true;
}

km_status km_volume_report(km_volume_search *g, double done, km_error *error) {
  if (km_progress_stage_report(&g->stage, done))
    return KM_OK;
  return km_fail(error, KM_CANCELLED, "stopped before %s decided",
                 g->out->samples > 0 ? "all samples were" : "any sample was");
}

/* ---- Searches for configurations, each of which depends on its number alone. */

typedef enum outcome { OUTCOME_NONE, OUTCOME_FOUND, OUTCOME_ENDLESS, OUTCOME_NO_MEMORY } outcome;

typedef struct search_group {
  km_volume_search *g;
  int first, count;             /* their numbers */
  const int *from;              /* [count] known configurations at which searches for extrema begin */
  double *saved;                /* [count][saved_size] configurations found */
  double (*x)[3];               /* [count] their points */
  outcome *result;              /* [count] */
  int *rank;                    /* [count] of the point's motions */
  int share_first, share_count; /* range of the present share */
  outcome (*find)(const struct search_group *group, km_moved_point *p, int index); /* one search */
} search_group;

static outcome find_closure(const search_group *s, km_moved_point *p, int index) {
  uint64_t random = km_volume_random(s->g, s->first + index);
  bool is_closed;
  km_moved_point_restore(p, s->g->home);
  if (km_moved_point_assemble(p, &random, &is_closed))
    return OUTCOME_NO_MEMORY;
  return is_closed ? OUTCOME_FOUND : OUTCOME_NONE;
}

static outcome find_by_motion(const search_group *s, km_moved_point *p, int index) {
  uint64_t random = km_volume_random(s->g, CLOSURES + s->first + index);
  km_moved_point_restore(p, s->g->known[(int)km_splitmix(&random, 0.0, s->g->known_count)].saved);
  if (!km_moved_point_begin(p))
    return OUTCOME_NONE;
  km_moved_point_move_at_random(p, &random);
  return OUTCOME_FOUND;
}

static outcome find_extremum(const search_group *s, km_moved_point *p, int index) {
  int end = index / EXTREMA;
  km_moved_point_restore(p, s->g->known[s->from[index]].saved);
  if (!km_moved_point_begin(p))
    return OUTCOME_NONE;
  return km_moved_point_find_extremum(p, end / 2, end % 2 == 0 ? -1.0 : 1.0) ? OUTCOME_FOUND : OUTCOME_ENDLESS;
}

static void search_share(void *context, int job) {
  search_group *s = context;
  km_moved_point *p = &s->g->point[job];
  for (int i = s->share_first + job; i < s->share_first + s->share_count; i += s->g->jobs) {
    s->result[i] = s->find(s, p, i);
    s->rank[i] = km_moved_point_rank(p);
    km_moved_point_save(p, s->saved + (size_t)i * p->saved_size);
    memcpy(s->x[i], p->x, sizeof s->x[i]);
  }
}

/* Makes the searches share by share. KM_CANCELLED: the caller ends them. */
static km_status search_shares(search_group *s, km_error *error) {
  int most = KM_VOLUME_SHARE * s->g->jobs;
  km_status status = KM_OK;
  for (s->share_first = 0; !status && s->share_first < s->count; s->share_first += s->share_count) {
    int left = s->count - s->share_first;
    s->share_count = left < most ? left : most;
    status = km_volume_report(s->g, (double)s->share_first / s->count, error);
    if (!status)
      km_parallel_for(s->g->jobs, s->g->jobs, search_share, s);
  }
  return status;
}

static km_status search_all(search_group *s, km_error *error) {
  km_volume_search *g = s->g;
  size_t size = g->point[0].saved_size, count = (size_t)s->count;
  s->saved = KM_ARENA_NEW(&g->arena, double, count *size);
  s->result = KM_ARENA_NEW(&g->arena, outcome, count);
  s->rank = KM_ARENA_NEW(&g->arena, int, count);
  void *x = km_arena_alloc(&g->arena, count, sizeof *s->x);
  s->x = x;
  if (g->arena.failed)
    return no_memory(error);
  km_status status = search_shares(s, error);
  for (int i = 0; !status && i < s->count; ++i) {
    if (s->result[i] == OUTCOME_NO_MEMORY)
      return no_memory(error);
    if (s->result[i] == OUTCOME_FOUND && s->rank[i] > g->rank)
      g->rank = s->rank[i];
  }
  return status;
}

/* Adds the configurations of searches in order, but those in which the point has fewer motions than in others. */
static km_status add_found(search_group *s, km_error *error) {
  km_volume_search *g = s->g;
  km_status status = search_all(s, error);
  for (int i = 0; !status && i < s->count; ++i)
    if (s->result[i] == OUTCOME_FOUND && s->rank[i] == g->rank &&
        !km_volume_add_known(g, s->x[i], s->saved + (size_t)i * g->point[0].saved_size, true))
      return no_memory(error);
  return status;
}

/* ---- The first configurations. */

/* The state's own configuration, which is known if it is within the bounds or can return to them. */
static km_status add_home(km_volume_search *g, const km_state *state, km_error *error) {
  km_moved_point *p = &g->point[0];
  km_state_copy(p->m, p->s, state);
  g->home = KM_ARENA_NEW(&g->arena, double, 2 * p->saved_size);
  if (!g->home)
    return no_memory(error);
  km_moved_point_save(p, g->home);
  km_moved_point_restore(p, g->home);
  bool is_within = km_moved_point_return(p);
  km_moved_point_save(p, g->home + p->saved_size);
  return !is_within || km_volume_add_known(g, p->x, g->home + p->saved_size, true) ? KM_OK : no_memory(error);
}

/* ---- The plane or space of the point. */

/* The longest difference of a known point from the first one, without its components along directions[count]. */
static km_vec3 longest_remainder(const km_volume_search *g, const km_vec3 *directions, int count) {
  km_vec3 longest = {0.0, 0.0, 0.0}, first = km_vec3_from_array(g->known[0].x);
  for (int i = 1; i < g->known_count; ++i) {
    km_vec3 d = km_vec3_sub(km_vec3_from_array(g->known[i].x), first);
    for (int k = 0; k < count; ++k)
      d = km_vec3_axpy(-km_vec3_dot(d, directions[k]), directions[k], d);
    if (km_vec3_norm(d) > km_vec3_norm(longest))
      longest = d;
  }
  return longest;
}

/* Number of directions in which the known points differ; their unit vectors. */
static int find_directions(const km_volume_search *g, km_vec3 *directions) {
  double first = 0.0;
  for (int k = 0; k < 3; ++k) {
    km_vec3 d = longest_remainder(g, directions, k);
    double length = km_vec3_norm(d);
    first = k == 0 ? length : first;
    if (!(length > flat * fmax(first, g->point[0].m->length)))
      return k;
    directions[k] = km_vec3_scale(1.0 / length, d);
  }
  return 3;
}

/* Takes the plane of two directions. */
static void set_plane(km_volume_search *g, const km_vec3 *directions) {
  static const km_vec3 axes[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  km_vec3 n = km_vec3_cross(directions[0], directions[1]), axis[2];
  for (int i = 0; i < 3; ++i)
    if (km_vec3_norm(km_vec3_cross(n, axes[i])) < flat)
      n = axes[i];
  km_point_surface plane;
  km_point_surface_set_plane(&plane, n, km_vec3_from_array(g->known[0].x));
  for (int k = 0; k < 2; ++k)
    axis[k] = km_vec3_upright(km_vec3_from_array(plane.axis[k]));
  g->origin = km_vec3_from_array(plane.origin);
  for (int j = 0; j < g->jobs; ++j) {
    g->point[j].dimension = 2;
    memcpy(g->point[j].axis, axis, sizeof axis);
  }
  for (int i = 0; i < g->known_count; ++i) {
    km_vec3 x = km_vec3_from_array(g->known[i].x);
    for (int k = 0; k < 2; ++k)
      g->known[i].x[k] = km_vec3_dot(x, axis[k]);
    g->known[i].x[2] = 0.0;
  }
}

static km_status find_plane(km_volume_search *g, km_error *error) {
  km_vec3 directions[3];
  int dimension = find_directions(g, directions);
  if (g->rank < 2)
    return km_fail(error, KM_USAGE,
                   "point \"%s\" has %d freedom%s; expected three, or two in a plane: its workspace has no size",
                   g->def->point_name, g->rank, g->rank == 1 ? "" : "s");
  if (g->rank < dimension)
    return km_fail(
        error, KM_USAGE,
        "point \"%s\" moves with two freedoms on a curved surface; expected three freedoms, or two in a plane",
        g->def->point_name);
  if (dimension == 2)
    set_plane(g, directions);
  return KM_OK;
}

km_status km_volume_start(km_volume_search *g, const km_state *state, km_error *error) {
  km_status status = add_home(g, state, error);
  search_group closures = {.g = g, .count = CLOSURES, .find = find_closure};
  km_progress_stage_next(&g->stage, start_part * closures_end);
  if (!status && !g->def->own_circuit)
    status = add_found(&closures, error);
  if (!status && g->known_count == 0)
    status = km_fail(error, KM_NO_RESULT, "no configuration was found%s%s",
                     g->def->within_limits ? " within the limits" : "", g->def->clearance ? " with the clearance" : "");
  for (int first = 0; !status && first < MOTIONS; first += GROUP) {
    search_group motions = {.g = g, .first = first, .count = GROUP, .find = find_by_motion};
    km_progress_stage_next(&g->stage, start_part * (closures_end + (1.0 - closures_end) * (first + GROUP) / MOTIONS));
    status = add_found(&motions, error);
  }
  return status ? status : find_plane(g, error);
}

/* ---- The box. */

/* Known configurations at which searches for an end of an axis begin: the farthest, and others by chance. */
static void choose_starts(const km_volume_search *g, int axis, double sense, int *from) {
  uint64_t random = km_volume_random(g, -1 - axis);
  for (int k = 0; k < EXTREMA; ++k) {
    from[k] = (int)km_splitmix(&random, 0.0, g->known_count);
    for (int i = 0; k < EXTREMA / 2 && i < g->known_count; ++i) {
      bool is_chosen = false;
      for (int j = 0; j < k; ++j)
        is_chosen = is_chosen || from[j] == i;
      if (!is_chosen && sense * g->known[i].x[axis] > sense * g->known[from[k]].x[axis])
        from[k] = i;
    }
  }
}

/* Extends low and high by a place. */
static void extend(double *low, double *high, const double *x, int dimension) {
  for (int k = 0; k < dimension; ++k) {
    low[k] = fmin(low[k], x[k]);
    high[k] = fmax(high[k], x[k]);
  }
}

/* Ends of the known points and of the extrema. KM_USAGE: an extremum doesn't exist. */
static km_status find_extent(const km_volume_search *g, const search_group *extrema, double *low, double *high,
                             km_error *error) {
  int dimension = g->point[0].dimension;
  for (int k = 0; k < dimension; ++k) {
    low[k] = HUGE_VAL;
    high[k] = -HUGE_VAL;
  }
  for (int i = 0; i < g->known_count; ++i)
    extend(low, high, g->known[i].x, dimension);
  for (int i = 0; i < extrema->count; ++i) {
    if (extrema->result[i] == OUTCOME_ENDLESS)
      return km_fail(error, KM_USAGE,
                     "point \"%s\" moves without end; expected limits of the slides and screws that carry it%s",
                     g->def->point_name, g->def->within_limits ? "" : ", and --limits");
    if (extrema->result[i] == OUTCOME_FOUND)
      extend(low, high, extrema->x[i], dimension);
  }
  return KM_OK;
}

km_status km_volume_find_box(km_volume_search *g, bool *is_grown, km_error *error) {
  int dimension = g->point[0].dimension, from[6 * EXTREMA];
  double low[3], high[3];
  for (int end = 0; end < 2 * dimension; ++end)
    choose_starts(g, end / 2, end % 2 == 0 ? -1.0 : 1.0, from + end * EXTREMA);
  search_group extrema = {.g = g, .count = 2 * dimension * EXTREMA, .from = from, .find = find_extremum};
  km_status status = search_all(&extrema, error);
  if (!status)
    status = find_extent(g, &extrema, low, high, error);
  if (status)
    return status;
  *is_grown = false;
  for (int k = 0; k < dimension; ++k)
    if (low[k] < g->low[k] || high[k] > g->high[k]) {
      *is_grown = true;
      g->low[k] = low[k] - box_margin * (high[k] - low[k]);
      g->high[k] = high[k] + box_margin * (high[k] - low[k]);
    }
  return KM_OK;
}
