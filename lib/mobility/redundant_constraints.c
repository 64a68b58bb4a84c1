/* Redundant constraints of a configuration (theory 7).
 *
 *   W = { w : wᵀ J_6 = 0 };   w = (f; τ) about c: force on the line through c + f × τ/|f|², pitch f·τ/|f|², or moment
 *   persistent: the vector remains, to half of its square, at a neighbouring configuration (7.3)
 *   remedies: joint types that remove the redundancy (7.4) */
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"
#include "kinematics/body_poses.h"
#include "kmech/mechanism.h"
#include "local/generic_neighbour.h"
#include "mobility/mobility_numbers.h"
#include "mobility/persistent_redundancy.h"
#include "mobility/substructure_loop.h"

#include <string.h>

/* Search in one substructure. */
typedef struct redundancy_search {
  km_left_space space;
  km_left_null null, neighbour; /* vectors at the configuration and at a neighbouring one */
  km_left_null separated;       /* those at the configuration; in single loops forces are separated from moments */
  bool *persistent;             /* [local_count + spanning_count] */
  double *work;                 /* [2 · spanning_count] */
  km_redundancies *out;
  size_t *capacity;
} redundancy_search;

/* Computes the left null vectors at a neighbouring configuration, to separate persistent from incidental
 * redundancies; without a motion they are the present ones. */
static bool find_neighbour_vectors(redundancy_search *f, km_arena *arena) {
  const km_left_space *a = &f->space;
  double *saved = KM_ARENA_NEW(arena, double, (size_t)(KM_SAVED_PER_COLUMN * a->sub->columns));
  double *move = KM_ARENA_NEW(arena, double, (size_t)a->sub->columns);
  if (arena->failed)
    return false;
  f->neighbour = f->null;
  bool found =
      !km_generic_neighbour_enter(a->m, a->s, a->index, saved, move) || km_left_null_find(a, arena, &f->neighbour);
  km_generic_neighbour_leave(a->m, a->s, a->index, saved);
  return found;
}

/* Describes a loop's wrench w: a force on a line with a pitch, or a moment. */
static void describe_wrench(const km_left_space *a, int block, const double *w, km_redundancy *item) {
  km_vec3 f = {w[0], w[1], w[2]}, c = {w[3], w[4], w[5]};
  double force = km_vec3_norm(f), moment = km_vec3_norm(c);
  item->rotation = force < 1e-6 * moment;
  km_vec3 d = item->rotation ? km_vec3_scale(1.0 / moment, c) : km_vec3_scale(1.0 / force, f);
  /* The sign is arbitrary: the largest entry is made positive. */
  double largest = fabs(d.x) > fabs(d.y) ? (fabs(d.x) > fabs(d.z) ? d.x : d.z) : (fabs(d.y) > fabs(d.z) ? d.y : d.z);
  if (largest < 0.0)
    d = km_vec3_scale(-1.0, d);
  km_vec3_write(d, item->direction);
  if (item->rotation)
    return;
  km_vec3 p = km_vec3_axpy(a->sub->size / (force * force), km_vec3_cross(f, c), a->about[block]);
  km_vec3_write(p, item->point);
  item->pitch = a->sub->size * km_vec3_dot(f, c) / (force * force);
}

/* Combines the left null vectors of one loop so that moments separate from forces: Gauss elimination with complete
 * pivoting on f. */
static void separate_moments(double *W, int count) {
  for (int n = 0; n < count && n < 3; ++n) {
    int best = n, component = 0;
    for (int i = n; i < count; ++i)
      for (int r = 0; r < 3; ++r)
        if (fabs(W[6 * i + r]) > fabs(W[6 * best + component]) + 1e-12) {
          best = i;
          component = r;
        }
    if (fabs(W[6 * best + component]) < 1e-9)
      return;
    for (int r = 0; r < 6; ++r) {
      double exchanged = W[6 * n + r];
      W[6 * n + r] = W[6 * best + r];
      W[6 * best + r] = exchanged;
    }
    for (int i = 0; i < count; ++i) {
      double factor = i == n ? 0.0 : W[6 * i + component] / W[6 * n + component];
      for (int r = 0; r < 6; ++r)
        W[6 * i + r] -= factor * W[6 * n + r];
    }
  }
}

static bool add_item(const redundancy_search *f, km_redundancy item) {
  void *items = f->out->items;
  if (!km_reserve(&items, f->capacity, (size_t)f->out->count + 1, sizeof item))
    return false;
  f->out->items = items;
  f->out->items[f->out->count++] = item;
  return true;
}

/* True if a loop's redundancy is out of the plane in which the loop moves. */
static bool is_out_of_plane(const redundancy_search *f, const km_redundancy *item) {
  double n[3], along = 0.0;
  if (!km_loop_plane(f->space.m, f->space.s, item->loop, n))
    return false;
  for (int k = 0; k < 3; ++k)
    along += n[k] * item->direction[k];
  return item->rotation ? fabs(along) < km_root_rounding : fabs(along) > 1.0 - km_root_rounding;
}

/* Separates moments from forces in the vectors of every single loop. */
static void separate_all_loops(redundancy_search *f) {
  const km_left_null *null = &f->null;
  double *local = f->separated.local;
  memcpy(local, null->local, 6 * (size_t)null->local_count * sizeof *local);
  for (int i = 0; i < f->space.sub->loop_count; ++i)
    separate_moments(local + 6 * null->first[i], null->first[i + 1] - null->first[i]);
}

/* Adds the redundancies of single loops. */
static bool add_single_loop_redundancies(const redundancy_search *f) {
  const km_topology *t = &f->space.m->topology;
  for (int i = 0; i < f->space.sub->loop_count; ++i)
    for (int k = f->null.first[i]; k < f->null.first[i + 1]; ++k) {
      const double *w = f->separated.local + 6 * k;
      km_redundancy item = {.substructure = f->space.index,
                            .loop = t->loop[t->loop_start[f->space.index] + i],
                            .loops = 1,
                            .persistent = f->persistent[k]};
      describe_wrench(&f->space, i, w, &item);
      km_remedies_find(&f->space, &f->null, i, w, f->work, &item);
      item.out_of_plane = is_out_of_plane(f, &item);
      if (!add_item(f, item))
        return false;
    }
  return true;
}

/* Returns the largest loop part of vector n (NULL: only couplings have parts) and the number of loops with a part. */
static const km_left_part *find_largest_part(const redundancy_search *f, int n, int *loops) {
  const km_left_null *null = &f->null;
  const km_left_part *largest_part = NULL;
  double largest = 0.0;
  *loops = 0;
  for (int i = null->part_start[n]; i < null->part_start[n + 1]; ++i) {
    const km_left_part *part = &null->part[i];
    if (part->block >= f->space.sub->loop_count)
      continue;
    double size = km_dot(part->w, part->w, 6);
    *loops += size > 1e-10;
    if (size > 1.0000001 * largest) {
      largest = size;
      largest_part = part;
    }
  }
  return largest_part;
}

/* Adds the redundancies that span several loops, each at the loop with its largest part. */
static bool add_spanning_redundancies(const redundancy_search *f) {
  const km_topology *t = &f->space.m->topology;
  for (int n = 0; n < f->null.spanning_count; ++n) {
    km_redundancy item = {.substructure = f->space.index, .persistent = f->persistent[f->null.local_count + n]};
    const km_left_part *largest_part = find_largest_part(f, n, &item.loops);
    if (!largest_part)
      continue;
    item.loop = t->loop[t->loop_start[f->space.index] + largest_part->block];
    describe_wrench(&f->space, largest_part->block, largest_part->w, &item);
    km_remedies_find(&f->space, &f->null, largest_part->block, largest_part->w, f->work, &item);
    if (!add_item(f, item))
      return false;
  }
  return true;
}

static km_status find_in_substructure(redundancy_search *f, km_arena *arena, km_error *error) {
  if (!km_left_null_find(&f->space, arena, &f->null))
    return KM_MEMORY;
  if (km_left_null_count(&f->null) == 0)
    return KM_OK;
  f->work = KM_ARENA_NEW(arena, double, 2 * (size_t)f->null.spanning_count);
  f->separated = f->null;
  f->separated.local = KM_ARENA_NEW(arena, double, 6 * (size_t)f->null.local_count);
  f->persistent = KM_ARENA_NEW(arena, bool, (size_t)km_left_null_count(&f->null));
  bool found = find_neighbour_vectors(f, arena) && !arena->failed;
  if (!found)
    return KM_MEMORY;
  separate_all_loops(f);
  km_status status = km_persistent_redundancy_find(&f->space, &f->separated, &f->neighbour, f->persistent, error);
  return !status && !(add_single_loop_redundancies(f) && add_spanning_redundancies(f)) ? KM_MEMORY : status;
}

/* Data of the search over all substructures. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_redundancies *out;
  size_t capacity;
} search;

static km_status search_substructure(void *self, int index, km_arena *arena, km_error *error) {
  search *all = self;
  redundancy_search f = {.out = all->out, .capacity = &all->capacity};
  return km_left_space_create(all->m, all->s, index, arena, &f.space) ? find_in_substructure(&f, arena, error)
                                                                      : KM_MEMORY;
}

km_status km_redundancies_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                               km_redundancies *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_redundancies){0};
  search all = {m, s, out, 0};
  return km_search_substructures(m, s, search_substructure, &all, progress, context, "the redundant constraints",
                                 error);
}

void km_redundancies_free(km_redundancies *redundancies) {
  if (!redundancies)
    return;
  km_free(redundancies->items);
  *redundancies = (km_redundancies){0};
}
