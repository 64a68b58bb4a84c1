/* Assembly modes: the poses that close the loops with the driver held. */
#include "kmech/modes.h"

#include "base/check.h"
#include "kinematics/assemble.h"
#include "kinematics/closure.h"

#include <stdint.h>
#include <string.h>

static const double different = 1e-6; /* of any coordinate, scaled */

typedef struct search {
  const km_mechanism *m; /* with the driver held */
  km_state *s;
  int substructure;
  double *saved, *found; /* [3 · columns]; [count × 3 · columns] saved coordinates of the modes */
  double *way;           /* [columns] */
  size_t capacity;
  int count;
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
  for (int k = 0; k < sub->columns; ++k)
    f->way[k] = uniform(f) * (f->m->unit[f->m->column_coordinate[sub->column_start + k]] == 1.0 ? M_PI : 1.0);
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

/* Hinges are written within half a turn of where the state has them; not where couplings count the turns. */
static double written(const search *f, const km_state *original, int c) {
  if (f->m->substructure_of[c] != f->substructure)
    return km_state_coordinate(original, c);
  if (km_coordinate_turns(f->m, c) && sub_of(f)->coupling_count == 0)
    f->s->q[c] = original->q[c] + remainder(f->s->q[c] - original->q[c], 2.0 * M_PI);
  return km_state_coordinate(f->s, c);
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
  out->isolated = done && km_partition_freedom(&f->s->partition[f->substructure]) == 0;
  done = done && collect(f, starts) && write_out(f, original, out);
  km_free(f->saved);
  km_free(f->way);
  km_free(f->found);
  if (f->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled");
  return done ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
}

/* The driver and all that the state's mechanism holds, held at their present values. */
static km_status hold_driver(const km_model *model, const km_state *s, int driver, km_mechanism **out,
                             km_error *error) {
  km_hold *holds = KM_NEW(km_hold, (size_t)model->coordinate_count);
  int count = 0;
  for (int c = 0; holds && c < model->coordinate_count; ++c)
    if (c == driver || s->mechanism->held[c])
      holds[count++] = (km_hold){c, km_state_coordinate(s, c)};
  km_compiling how = {.holds = holds,
                      .hold_count = count,
                      .length = s->mechanism->length,
                      .length_source = s->mechanism->length_source};
  km_status status = holds ? km_mechanism_compile_as(model, &how, out, error)
                           : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  km_free(holds);
  return status;
}

static km_status check_driver(const km_mechanism *m, int driver, km_error *error) {
  km_status status = km_check_index(driver, m->coordinate_count, "coordinate", error);
  if (!status && (m->held[driver] || m->substructure_of[driver] < 0 || m->ball_of[driver] >= 0))
    status =
        km_fail(error, KM_USAGE, "joint \"%s\" can't be the driver of assembly modes; expected a free joint of a loop",
                m->model->coordinates[driver].label);
  return status;
}

km_status km_modes_find(const km_mechanism *own, const km_state *s, int driver, int starts, unsigned long seed,
                        km_progress progress, void *context, km_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_modes){0};
  km_mechanism *m = NULL;
  km_state *state = NULL;
  km_status status = km_check_state(own, s, error);
  if (!status && (starts < 0 || starts > KM_MOST_MODE_STARTS))
    status = km_fail(error, KM_USAGE, "%d starts; expected 0 to %d", starts, KM_MOST_MODE_STARTS);
  if (!status)
    status = check_driver(own, driver, error);
  if (!status)
    status = hold_driver(own->model, s, driver, &m, error);
  if (!status)
    status = km_state_create(m, &state, error);
  if (!status) {
    search f = {.m = m,
                .s = state,
                .substructure = own->substructure_of[driver],
                .random = seed,
                .progress = progress,
                .context = context};
    status = search_modes(&f, s, starts, out, error);
  }
  km_state_free(state);
  km_mechanism_free(m);
  return status;
}

void km_modes_free(km_modes *modes) {
  if (!modes)
    return;
  km_free(modes->coordinates);
  *modes = (km_modes){0};
}
