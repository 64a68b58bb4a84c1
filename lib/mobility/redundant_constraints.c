/* Redundant constraints by name: left null vectors of the loops, and the swaps of joints that end them. */
#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kmech/mechanism.h"
#include "local/generic_neighbour.h"
#include "mobility/mobility_numbers.h"
#include "mobility/persistent_redundancy.h"
#include "mobility/substructure_loop.h"

#include <string.h>

/* One substructure at one pose. */
typedef struct finder {
  km_left_space space;
  km_left_null null, nearby; /* at the pose, and a short way along the motion */
  double *separated;         /* [6 · local_count] those of single loops, forces apart from couples */
  bool *lasting;             /* [local_count + whole_count] */
  double *work;              /* [2 · whole_count] */
  km_redundancies *out;
  size_t *capacity;
} finder;

/* The left null vectors a short way along the motion: a redundancy that isn't among them was the pose's. Where nothing
 * moves, they are those of the pose. */
static bool look_nearby(finder *f, km_arena *arena) {
  const km_left_space *a = &f->space;
  double *saved = KM_ARENA_NEW(arena, double, (size_t)(KM_SAVED_PER_COLUMN * a->sub->columns));
  double *move = KM_ARENA_NEW(arena, double, (size_t)a->sub->columns);
  if (arena->failed)
    return false;
  f->nearby = f->null;
  bool found =
      !km_generic_neighbour_enter(a->m, a->s, a->index, saved, move) || km_left_null_find(a, arena, &f->nearby);
  km_generic_neighbour_leave(a->m, a->s, a->index, saved);
  return found;
}

/* The physical meaning of a loop's wrench w: a force on a line, with a pitch, or a couple. */
static void describe(const km_left_space *a, int place, const double *w, km_redundancy *item) {
  km_vec3 f = {w[0], w[1], w[2]}, c = {w[3], w[4], w[5]};
  double force = km_vec3_norm(f), couple = km_vec3_norm(c);
  item->rotation = force < 1e-6 * couple;
  km_vec3 d = item->rotation ? km_vec3_scale(1.0 / couple, c) : km_vec3_scale(1.0 / force, f);
  /* The sense of a constraint means nothing: the largest entry is made positive. */
  double largest = fabs(d.x) > fabs(d.y) ? (fabs(d.x) > fabs(d.z) ? d.x : d.z) : (fabs(d.y) > fabs(d.z) ? d.y : d.z);
  if (largest < 0.0)
    d = km_vec3_scale(-1.0, d);
  memcpy(item->direction, &(double[3]){d.x, d.y, d.z}, sizeof item->direction);
  if (item->rotation)
    return;
  km_vec3 p = km_vec3_axpy(a->sub->size / (force * force), km_vec3_cross(f, c), a->about[place]);
  memcpy(item->point, &(double[3]){p.x, p.y, p.z}, sizeof item->point);
  item->pitch = a->sub->size * km_vec3_dot(f, c) / (force * force);
}

/* Left null vectors of one loop are turned so that couples come apart from forces: the forces' parts are
 * eliminated as far as they go (Gauss with complete pivoting on f). */
static void separate(double *W, int count) {
  for (int n = 0; n < count && n < 3; ++n) {
    int best = n, at = 0;
    for (int i = n; i < count; ++i)
      for (int r = 0; r < 3; ++r)
        if (fabs(W[6 * i + r]) > fabs(W[6 * best + at]) + 1e-12) {
          best = i;
          at = r;
        }
    if (fabs(W[6 * best + at]) < 1e-9)
      return;
    for (int r = 0; r < 6; ++r) {
      double swap = W[6 * n + r];
      W[6 * n + r] = W[6 * best + r];
      W[6 * best + r] = swap;
    }
    for (int i = 0; i < count; ++i) {
      double share = i == n ? 0.0 : W[6 * i + at] / W[6 * n + at];
      for (int r = 0; r < 6; ++r)
        W[6 * i + r] -= share * W[6 * n + r];
    }
  }
}

static bool add_item(const finder *f, km_redundancy item) {
  void *items = f->out->items;
  if (!km_reserve(&items, f->capacity, (size_t)f->out->count + 1, sizeof item))
    return false;
  f->out->items = items;
  f->out->items[f->out->count++] = item;
  return true;
}

/* Does a loop's redundancy lie across the plane that the loop moves in? */
static bool is_across(const finder *f, const km_redundancy *item) {
  static const double aligned = 1e-6; /* of directions that come from null vectors */
  double n[3], along = 0.0;
  if (!km_loop_plane(f->space.m, f->space.s, item->loop, n))
    return false;
  for (int k = 0; k < 3; ++k)
    along += n[k] * item->direction[k];
  return item->rotation ? fabs(along) < aligned : fabs(along) > 1.0 - aligned;
}

/* The vectors of single loops, turned. */
static void separate_all(finder *f) {
  const km_left_null *null = &f->null;
  memcpy(f->separated, null->local, 6 * (size_t)null->local_count * sizeof *f->separated);
  for (int i = 0; i < f->space.sub->loop_count; ++i)
    separate(f->separated + 6 * null->first[i], null->first[i + 1] - null->first[i]);
}

/* The redundancies that single loops have by themselves. */
static bool single_loops(const finder *f) {
  const km_topology *t = &f->space.m->topology;
  for (int i = 0; i < f->space.sub->loop_count; ++i)
    for (int k = f->null.first[i]; k < f->null.first[i + 1]; ++k) {
      const double *w = f->separated + 6 * k;
      km_redundancy item = {.substructure = f->space.index,
                            .loop = t->loop[t->loop_start[f->space.index] + i],
                            .loops = 1,
                            .lasting = f->lasting[k]};
      describe(&f->space, i, w, &item);
      km_remedies_find(&f->space, &f->null, i, w, f->work, &item);
      item.out_of_plane = is_across(f, &item);
      if (!add_item(f, item))
        return false;
    }
  return true;
}

static double square(const double w[6]) {
  double sum = 0.0;
  for (int r = 0; r < 6; ++r)
    sum += w[r] * w[r];
  return sum;
}

/* The part of the loop that has most of vector n, NULL: only couplings have; and how many loops have any. */
static const km_left_part *chief_part(const finder *f, int n, int *loops) {
  const km_left_null *null = &f->null;
  const km_left_part *chief = NULL;
  double largest = 0.0;
  *loops = 0;
  for (int i = null->part_start[n]; i < null->part_start[n + 1]; ++i) {
    const km_left_part *part = &null->part[i];
    if (part->place >= f->space.sub->loop_count)
      continue;
    double size = square(part->w);
    *loops += size > 1e-10;
    if (size > 1.0000001 * largest) {
      largest = size;
      chief = part;
    }
  }
  return chief;
}

/* What several loops have only together. */
static bool several_loops(const finder *f) {
  const km_topology *t = &f->space.m->topology;
  for (int n = 0; n < f->null.whole_count; ++n) {
    km_redundancy item = {.substructure = f->space.index, .lasting = f->lasting[f->null.local_count + n]};
    const km_left_part *chief = chief_part(f, n, &item.loops);
    if (!chief)
      continue;
    item.loop = t->loop[t->loop_start[f->space.index] + chief->place];
    describe(&f->space, chief->place, chief->w, &item);
    km_remedies_find(&f->space, &f->null, chief->place, chief->w, f->work, &item);
    if (!add_item(f, item))
      return false;
  }
  return true;
}

static km_status find_in(finder *f, km_arena *arena, km_error *error) {
  if (!km_left_null_find(&f->space, arena, &f->null))
    return KM_MEMORY;
  if (km_left_null_count(&f->null) == 0)
    return KM_OK;
  f->work = KM_ARENA_NEW(arena, double, 2 * (size_t)f->null.whole_count);
  f->separated = KM_ARENA_NEW(arena, double, 6 * (size_t)f->null.local_count);
  f->lasting = KM_ARENA_NEW(arena, bool, (size_t)km_left_null_count(&f->null));
  bool found = look_nearby(f, arena) && !arena->failed;
  if (!found)
    return KM_MEMORY;
  separate_all(f);
  km_status status = km_persistent_redundancy_find(&f->space, &f->null, f->separated, &f->nearby, f->lasting, error);
  return !status && !(single_loops(f) && several_loops(f)) ? KM_MEMORY : status;
}

/* The whole search. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_redundancies *out;
  size_t capacity;
} search;

static km_status look(void *self, int index, km_arena *arena, km_error *error) {
  search *all = self;
  finder f = {.out = all->out, .capacity = &all->capacity};
  return km_left_space_make(all->m, all->s, index, arena, &f.space) ? find_in(&f, arena, error) : KM_MEMORY;
}

km_status km_redundancies_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                               km_redundancies *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_redundancies){0};
  km_status fits = km_check_state(m, s, error);
  if (fits)
    return fits;
  search all = {m, s, out, 0};
  km_mobility mobility;
  km_poses_compute(m, s);
  km_ranks_update(m, s, &mobility);
  return km_each_substructure(m, look, &all, progress, context, "the redundant constraints", error);
}

void km_redundancies_free(km_redundancies *redundancies) {
  if (!redundancies)
    return;
  km_free(redundancies->items);
  *redundancies = (km_redundancies){0};
}
