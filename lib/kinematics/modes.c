/* Assembly modes: the poses that close the loops with the driver held. */
#include "kmech/modes.h"

#include "base/check.h"
#include "kinematics/assemble.h"
#include "kinematics/closure.h"

#include <stdint.h>
#include <string.h>

static const double different = 1e-6; /* of any coordinate, scaled */

typedef struct search {
  const km_mechanism *m;
  km_state *s; /* with the driver locked */
  int substructure;
  double *saved, *found; /* [3 · columns]; [count × 3 · columns] saved coordinates of the modes */
  double *way;           /* [columns] */
  size_t capacity;
  int count;
  bool moves; /* something still moves in one of them */
  uint64_t random;
  km_progress progress;
  void *context;
  bool cancelled;
} search;

/* splitmix64, -1 … 1. */
static double uniform(search *f) {
  uint64_t z = (f->random += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

static const km_substructure *sub_of(const search *f) {
  return &f->m->substructures[f->substructure];
}

/* A random start: hinges anywhere, slides within the size of the substructure around the first pose. */
static void scatter(search *f) {
  const km_substructure *sub = sub_of(f);
  km_state_restore(f->s, sub, f->found);
  for (int k = 0; k < sub->columns; ++k) {
    int c = f->m->column_coordinate[sub->column_start + k];
    f->way[k] = f->s->locked[c] ? 0.0 : uniform(f) * (f->m->unit[c] == 1.0 ? M_PI : 1.0);
  }
  km_state_move(f->m, f->s, sub, f->way);
}

static bool is_new(search *f) {
  const km_substructure *sub = sub_of(f);
  for (int i = 0; i < f->count; ++i) {
    double largest = 0.0;
    km_state_difference(f->s, sub, f->found + (size_t)(i * KM_SAVED_PER_COLUMN * sub->columns), f->way);
    for (int k = 0; k < sub->columns; ++k) {
      bool hinge = km_coordinate_turns(f->m, f->m->column_coordinate[sub->column_start + k]);
      double way = hinge ? remainder(f->way[k], 2.0 * M_PI) : f->way[k];
      largest = fmax(largest, fabs(way));
    }
    if (largest < different)
      return false;
  }
  return true;
}

static bool keep(search *f) {
  size_t each = (size_t)(KM_SAVED_PER_COLUMN * sub_of(f)->columns);
  void *found = f->found;
  if (!km_reserve(&found, &f->capacity, (size_t)(f->count + 1) * each, sizeof *f->found))
    return false;
  f->found = found;
  f->moves = f->moves || km_partition_freedom(&f->s->partition[f->substructure]) > 0;
  km_state_save(f->s, sub_of(f), f->found + (size_t)f->count++ * each);
  return true;
}

static bool collect(search *f, int starts) {
  if (!keep(f))
    return false;
  for (int i = 0; i < starts; ++i) {
    f->cancelled = f->progress && !f->progress(f->context, (double)i / starts);
    if (f->cancelled)
      return false;
    scatter(f);
    if (km_assemble_one(f->m, f->s, f->substructure, f->saved) && is_new(f) && !keep(f))
      return false;
  }
  return true;
}

/* Hinges are written within half a turn of where the state has them, just half a turn ahead of it; not where couplings
 * count the turns. What closing the loops may leave of 0 is 0. */
static double written(const search *f, const km_state *original, int c) {
  static const double rounding = 1e-12; /* radians, or substructure sizes */
  if (f->m->substructure_of[c] != f->substructure)
    return km_state_coordinate(original, c);
  double *q = &f->s->q[c];
  if (km_coordinate_turns(f->m, c) && sub_of(f)->coupling_count == 0) {
    double turn = remainder(*q - original->q[c], 2.0 * M_PI);
    *q = original->q[c] + (turn < different - M_PI ? turn + 2.0 * M_PI : turn);
  }
  return fabs(*q) <= rounding * f->m->unit[c] ? 0.0 : km_state_coordinate(f->s, c);
}

static bool write_out(search *f, const km_state *original, km_modes *out) {
  int n = f->m->coordinate_count;
  out->coordinates = KM_NEW(double, (size_t)f->count *(size_t)n);
  if (!out->coordinates)
    return false;
  for (int i = 0; i < f->count; ++i) {
    km_state_restore(f->s, sub_of(f), f->found + (size_t)(i * KM_SAVED_PER_COLUMN * sub_of(f)->columns));
    for (int c = 0; c < n; ++c)
      out->coordinates[i * n + c] = written(f, original, c);
  }
  out->count = f->count;
  return true;
}

static km_status search_modes(search *f, const km_state *original, int starts, km_modes *out, km_error *error) {
  size_t columns = (size_t)sub_of(f)->columns;
  f->saved = KM_NEW(double, KM_SAVED_PER_COLUMN *columns);
  f->way = KM_NEW(double, columns);
  km_state_copy(f->m, f->s, original);
  bool done = f->saved && f->way && km_assemble_one(f->m, f->s, f->substructure, f->saved);
  done = done && collect(f, starts) && write_out(f, original, out);
  out->isolated = done && !f->moves;
  km_free(f->saved);
  km_free(f->way);
  km_free(f->found);
  if (f->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled");
  return done ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
}

static km_status check_driver(const km_mechanism *m, int driver, km_error *error) {
  km_status status = km_check_index(driver, m->coordinate_count, "coordinate", error);
  if (!status && (m->held[driver] || m->substructure_of[driver] < 0 || m->ball_of[driver] >= 0))
    status =
        km_fail(error, KM_USAGE, "joint \"%s\" can't be the driver of assembly modes; expected a free joint of a loop",
                m->model->coordinates[driver].label);
  return status;
}

km_status km_modes_find(const km_mechanism *m, const km_state *s, int driver, int starts, unsigned long seed,
                        km_progress progress, void *context, km_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_modes){0};
  km_state *state = NULL;
  km_status status = km_check_state(m, s, error);
  if (!status && (starts < 0 || starts > KM_MOST_MODE_STARTS))
    status = km_fail(error, KM_USAGE, "%d starts; expected 0 to %d", starts, KM_MOST_MODE_STARTS);
  if (!status)
    status = check_driver(m, driver, error);
  if (!status)
    status = km_state_create(m, &state, error);
  if (!status) {
    search f = {.m = m,
                .s = state,
                .substructure = m->substructure_of[driver],
                .random = seed,
                .progress = progress,
                .context = context};
    km_state_lock(state, driver);
    status = search_modes(&f, s, starts, out, error);
  }
  km_state_free(state);
  return status;
}

void km_modes_free(km_modes *modes) {
  if (!modes)
    return;
  km_free(modes->coordinates);
  *modes = (km_modes){0};
}
