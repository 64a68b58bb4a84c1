/* First configurations of a workspace, its plane or space, and its box (docs/theory.md 4.23).
 *
 *   closures : random values of all coordinates, then the loops are closed
 *   motions  : straight in the tangent space from a known configuration, carried on, until a bound or about a turn
 *   plane    : the points' differences d_i by Gram-Schmidt, the longest remainder first; its normal is orthogonal
 *   box      : extrema of each coordinate, by climbs from the farthest known points; 0.5 % more at each end */
#include "space/surface/point_surface.h"
#include "space/volume/volume_search.h"

#include "base/random.h"

#include <string.h>

enum { CLOSURES = 256, MOTIONS = 1024, BATCH = 64, CLIMBS = 8 };
static const double flat = 1e-8;        /* remainder of the longest difference that is none */
static const double box_margin = 0.005; /* part of the extent, at each end */
static const double endless = 100.0;    /* extent over L of a workspace without end */

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

/* ---- Batches of configurations, each made from its number alone. */

typedef enum made { MADE_NONE, MADE, MADE_ENDLESS, MADE_WITHOUT_MEMORY } made;

typedef struct batch {
  km_volume_search *g;
  int first, count;                                                      /* their numbers */
  const int *from;                                                       /* [count] known configurations of climbs */
  double *saved;                                                         /* [count][saved_size] */
  double (*x)[3];                                                        /* [count] */
  made *result;                                                          /* [count] */
  int *rank;                                                             /* [count] of the point's motions */
  made (*make)(const struct batch *batch, km_moved_point *p, int index); /* makes one */
} batch;

static made make_closure(const batch *b, km_moved_point *p, int index) {
  uint64_t random = km_volume_random(b->g, b->first + index);
  bool is_closed;
  km_moved_point_restore(p, b->g->home);
  if (km_moved_point_assemble(p, &random, &is_closed))
    return MADE_WITHOUT_MEMORY;
  return is_closed ? MADE : MADE_NONE;
}

static made make_motion(const batch *b, km_moved_point *p, int index) {
  uint64_t random = km_volume_random(b->g, CLOSURES + b->first + index);
  km_moved_point_restore(p, b->g->known[(int)km_splitmix(&random, 0.0, b->g->known_count)].saved);
  if (!km_moved_point_begin(p))
    return MADE_NONE;
  km_moved_point_wander(p, &random);
  return MADE;
}

static made make_climb(const batch *b, km_moved_point *p, int index) {
  int end = index / CLIMBS;
  km_moved_point_restore(p, b->g->known[b->from[index]].saved);
  if (!km_moved_point_begin(p))
    return MADE_NONE;
  return km_moved_point_climb(p, end / 2, end % 2 == 0 ? -1.0 : 1.0, endless * p->m->length) ? MADE : MADE_ENDLESS;
}

static void make_share(void *context, int job) {
  batch *b = context;
  km_moved_point *p = &b->g->point[job];
  for (int i = job; i < b->count; i += b->g->jobs) {
    b->result[i] = b->make(b, p, i);
    b->rank[i] = km_moved_point_rank(p);
    km_moved_point_save(p, b->saved + (size_t)i * p->saved_size);
    memcpy(b->x[i], p->x, sizeof b->x[i]);
  }
}

static km_status make_all(batch *b, km_error *error) {
  km_volume_search *g = b->g;
  size_t size = g->point[0].saved_size, count = (size_t)b->count;
  b->saved = KM_ARENA_NEW(&g->arena, double, count *size);
  b->result = KM_ARENA_NEW(&g->arena, made, count);
  b->rank = KM_ARENA_NEW(&g->arena, int, count);
  void *x = km_arena_alloc(&g->arena, count, sizeof *b->x);
  b->x = x;
  if (g->arena.failed)
    return no_memory(error);
  km_parallel_for(g->jobs, g->jobs, make_share, b);
  for (int i = 0; i < b->count; ++i) {
    if (b->result[i] == MADE_WITHOUT_MEMORY)
      return no_memory(error);
    if (b->result[i] == MADE && b->rank[i] > g->rank)
      g->rank = b->rank[i];
  }
  return KM_OK;
}

/* Makes a batch and adds its configurations in order, but those in which the point has fewer motions than in others. */
static km_status add_batch(batch *b, km_error *error) {
  km_volume_search *g = b->g;
  km_status status = make_all(b, error);
  for (int i = 0; !status && i < b->count; ++i)
    if (b->result[i] == MADE && b->rank[i] == g->rank &&
        !km_volume_add_known(g, b->x[i], b->saved + (size_t)i * g->point[0].saved_size, true))
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
  bool is_within = km_moved_point_begin(p) || km_moved_point_return(p);
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
    axis[k] = km_vec3_from_array(plane.axis[k]);
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
  batch closures = {.g = g, .count = CLOSURES, .make = make_closure};
  if (!status && !g->def->own_circuit)
    status = add_batch(&closures, error);
  if (!status && g->known_count == 0)
    status = km_fail(error, KM_NO_RESULT, "no configuration was found%s%s",
                     g->def->within_limits ? " within the limits" : "", g->def->clearance ? " with the clearance" : "");
  for (int first = 0; !status && first < MOTIONS; first += BATCH) {
    batch motions = {.g = g, .first = first, .count = BATCH, .make = make_motion};
    status = add_batch(&motions, error);
  }
  return status ? status : find_plane(g, error);
}

/* ---- The box. */

/* Known configurations from which climbs along an axis begin: the farthest, and others by chance. */
static void choose_starts(const km_volume_search *g, int axis, double sense, int *from) {
  uint64_t random = km_volume_random(g, -1 - axis);
  for (int k = 0; k < CLIMBS; ++k) {
    from[k] = (int)km_splitmix(&random, 0.0, g->known_count);
    for (int i = 0; k < CLIMBS / 2 && i < g->known_count; ++i) {
      bool is_chosen = false;
      for (int j = 0; j < k; ++j)
        is_chosen = is_chosen || from[j] == i;
      if (!is_chosen && sense * g->known[i].x[axis] > sense * g->known[from[k]].x[axis])
        from[k] = i;
    }
  }
}

/* Extends low and high by the places of the known points and of the climbs' ends. KM_USAGE: a climb has no end. */
static km_status find_extent(const km_volume_search *g, const batch *climbs, double *low, double *high,
                             km_error *error) {
  for (int k = 0; k < g->point[0].dimension; ++k) {
    low[k] = HUGE_VAL;
    high[k] = -HUGE_VAL;
    for (int i = 0; i < g->known_count + climbs->count; ++i) {
      const double *x = i < g->known_count ? g->known[i].x : climbs->x[i - g->known_count];
      made result = i < g->known_count ? MADE : climbs->result[i - g->known_count];
      if (result == MADE_ENDLESS)
        return km_fail(
            error, KM_USAGE,
            "point \"%s\" moves without end; expected a workspace that ends (with --limits those of slides end "
            "it)",
            g->def->point_name);
      if (result == MADE) {
        low[k] = fmin(low[k], x[k]);
        high[k] = fmax(high[k], x[k]);
      }
    }
  }
  return KM_OK;
}

km_status km_volume_find_box(km_volume_search *g, bool *is_grown, km_error *error) {
  int dimension = g->point[0].dimension, from[6 * CLIMBS];
  double low[3], high[3];
  for (int end = 0; end < 2 * dimension; ++end)
    choose_starts(g, end / 2, end % 2 == 0 ? -1.0 : 1.0, from + end * CLIMBS);
  batch climbs = {.g = g, .count = 2 * dimension * CLIMBS, .from = from, .make = make_climb};
  km_status status = make_all(&climbs, error);
  if (!status)
    status = find_extent(g, &climbs, low, high, error);
  *is_grown = false;
  for (int k = 0; !status && k < dimension; ++k)
    if (low[k] < g->out->box_low[k] || high[k] > g->out->box_high[k]) {
      *is_grown = true;
      g->out->box_low[k] = low[k] - box_margin * (high[k] - low[k]);
      g->out->box_high[k] = high[k] + box_margin * (high[k] - low[k]);
    }
  return status;
}
