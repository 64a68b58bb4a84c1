/* Assembly modes: the configurations that close the loops with the driver locked (docs/theory.md 4.13).
 *
 *   random starts: hinges uniform in [−π, π], slides within one size;   closing by 4.3;   equal modes merged
 *
 * Evidence: the number of starts that led to each mode, and the number of modes found once. */
#include "base/number/tolerances.h"
#include "kmech/mechanism.h"

#include "base/arguments.h"
#include "kinematics/assembly.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/modes/mode_identity.h"
#include "kinematics/modes/mode_normalisation.h"

#include <string.h>

/* One assembly mode. */
typedef struct mode {
  double *saved;         /* [3 · columns] saved coordinates */
  km_pose *pose;         /* [body] in the inertial frame */
  int find_count;        /* number of starts that led to it */
  bool is_within_limits; /* the mode satisfies the joint limits */
} mode;

typedef struct mode_search {
  const km_mechanism *m;
  km_state *s; /* the search's state, with the driver locked */
  const km_state *original;
  int driver;
  km_arena arena;
  km_mode_workspace work; /* closings from random starts */
  km_body_placement *placements;
  mode *modes;
  size_t capacity;
  int count, closed;
  bool is_mobile; /* a mode has a mobility above 0 */
  km_progress progress;
  void *context;
  bool cancelled;
} mode_search;

static const km_substructure *substructure_of_search(const mode_search *f) {
  return &f->m->substructures[f->work.substructure];
}

/* Index of the mode with the present poses of all bodies; -1: a new mode. */
static int find_mode(const mode_search *f) {
  double size = substructure_of_search(f)->size;
  km_poses_compute(f->m, f->s);
  for (int i = 0; i < f->count; ++i)
    if (km_is_same_mode(f->m, f->placements, f->modes[i].pose, f->s->pose, size, km_root_rounding))
      return i;
  return -1;
}

/* Adds the present configuration as a mode, normalised unless it is the first. False when out of memory. */
static bool add_mode(mode_search *f) {
  size_t bodies = (size_t)f->m->model->body_count;
  void *modes = f->modes;
  mode added = {.saved =
                    KM_ARENA_NEW(&f->arena, double, (size_t)(KM_SAVED_PER_COLUMN * substructure_of_search(f)->columns)),
                .pose = KM_ARENA_NEW(&f->arena, km_pose, bodies),
                .find_count = 1};
  if (f->arena.failed || !km_reserve(&modes, &f->capacity, (size_t)f->count + 1, sizeof *f->modes))
    return false;
  f->modes = modes;
  f->is_mobile = f->is_mobile || km_factor_freedom(f->s->factor[f->work.substructure]) > 0;
  memcpy(added.pose, f->s->pose, bodies * sizeof *added.pose);
  bool is_first = f->count == 0;
  added.is_within_limits =
      is_first || (km_mode_normalise(&f->work) && km_state_find_outside_limit(f->s, substructure_of_search(f)) < 0);
  km_state_save(f->s, substructure_of_search(f), added.saved);
  f->modes[f->count++] = added;
  return !f->arena.failed;
}

/* Counts the present configuration to its mode, or adds a new one. False when out of memory. */
static bool record_mode(mode_search *f) {
  int found = find_mode(f);
  ++f->closed;
  if (found < 0)
    return add_mode(f);
  ++f->modes[found].find_count;
  return true;
}

/* Closes the loops from random starts around the first mode and records each result. */
static bool run_starts(mode_search *f, int starts) {
  if (!record_mode(f))
    return false;
  for (int i = 0; i < starts; ++i) {
    f->cancelled = f->progress && !f->progress(f->context, (double)i / starts);
    if (f->cancelled)
      return false;
    km_state_restore(f->s, substructure_of_search(f), f->modes[0].saved);
    km_mode_randomise(&f->work);
    if ((km_mode_close(&f->work) && !record_mode(f)) || f->arena.failed || f->work.failed)
      return false;
  }
  return true;
}

/* Returns a coordinate for output. A value that is 0 to the rounding of closing is written as 0. */
static double output_coordinate(const mode_search *f, int c) {
  if (f->m->substructure_of[c] != f->work.substructure)
    return km_state_coordinate(f->original, c);
  return fabs(f->s->q[c]) <= km_solved_rounding * f->m->unit[c] ? 0.0 : km_state_coordinate(f->s, c);
}

/* Copies the modes within the joint limits to the result and counts the others. */
static bool write_modes(mode_search *f, km_modes *out) {
  int n = f->m->coordinate_count;
  out->coordinates = KM_NEW(double, (size_t)f->count *(size_t)n);
  if (!out->coordinates)
    return false;
  for (int i = 0; i < f->count; ++i) {
    out->once += f->modes[i].find_count == 1;
    out->outside += !f->modes[i].is_within_limits;
    if (!f->modes[i].is_within_limits)
      continue;
    km_state_restore(f->s, substructure_of_search(f), f->modes[i].saved);
    for (int c = 0; c < n; ++c)
      out->coordinates[(size_t)out->count * (size_t)n + (size_t)c] = output_coordinate(f, c);
    ++out->count;
  }
  out->closed = f->closed;
  return true;
}

/* Closes the first mode, runs the starts and writes the result. */
static km_status search_modes(mode_search *f, int starts, km_modes *out, km_error *error) {
  bool is_ok = km_mode_workspace_reserve(&f->work, &f->arena), is_mobile = false, is_closed = true;
  f->placements = KM_ARENA_NEW(&f->arena, km_body_placement, (size_t)f->m->model->body_count);
  is_ok = is_ok && !f->arena.failed;
  if (is_ok) {
    f->arena.failed = !km_body_placements(f->m, f->placements);
    km_state_copy(f->m, f->s, f->original);
    is_closed = km_mode_close(&f->work);
    is_ok = is_closed && !f->arena.failed && !f->work.failed;
    is_mobile = is_ok && f->driver < 0 && km_factor_freedom(f->s->factor[f->work.substructure]) > 0;
    is_ok = is_ok && !is_mobile && run_starts(f, starts) && write_modes(f, out);
  }
  out->isolated = is_ok && !f->is_mobile;
  bool is_open = !is_closed && !f->arena.failed && !f->work.failed;
  km_free(f->modes);
  km_arena_free(&f->arena);
  if (is_open)
    return km_fail(error, KM_USAGE, "the loops of the state are open; expected an assembled one");
  if (is_mobile)
    return km_fail(
        error, KM_USAGE,
        "assembly modes need a driver, since the mechanism moves: the model has no analysis.sweep with a joint; "
        "expected one by --set");
  if (f->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled");
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
}

/* Loop-containing substructure with the most coordinates; -1: none. */
int km_mode_substructure(const km_mechanism *m) {
  int best = -1;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (m->substructures[i].loop_count > 0 &&
        (best < 0 || m->substructures[i].columns > m->substructures[best].columns))
      best = i;
  return best;
}

/* Checks that the driver is a free joint of a loop, or that the model has a loop. */
static km_status check_driver(const km_mechanism *m, int driver, km_error *error) {
  if (driver == -1)
    return km_mode_substructure(m) >= 0
               ? KM_OK
               : km_fail(error, KM_USAGE, "the model has no loop; expected one that closes in different ways");
  km_status status = km_check_index(driver, m->coordinate_count, "coordinate", error);
  if (!status && (m->held[driver] || m->substructure_of[driver] < 0 || m->ball_of[driver] >= 0))
    status =
        km_fail(error, KM_USAGE, "joint \"%s\" can't be the driver of assembly modes; expected a free joint of a loop",
                m->model->coordinates[driver].label);
  return status;
}

/* Searches the assembly modes with a copy of the state whose driver is locked. */
km_status km_modes_find(const km_mechanism *m, const km_state *s, int driver, int starts, unsigned long seed,
                        km_progress progress, void *context, km_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_modes){0};
  km_state *state = NULL;
  km_status status = km_check_state(m, s, error);
  if (!status && (starts < 0 || starts > KM_MAX_MODE_STARTS))
    status = km_fail(error, KM_USAGE, "%d starts; expected 0 to %d", starts, KM_MAX_MODE_STARTS);
  if (!status)
    status = check_driver(m, driver, error);
  if (!status)
    status = km_state_create(m, &state, error);
  if (!status) {
    if (driver >= 0)
      km_state_lock(state, driver);
    mode_search f = {.m = m,
                     .s = state,
                     .original = s,
                     .driver = driver,
                     .work = {.m = m,
                              .s = state,
                              .original = s,
                              .substructure = driver >= 0 ? m->substructure_of[driver] : km_mode_substructure(m),
                              .random = seed},
                     .progress = progress,
                     .context = context};
    status = search_modes(&f, starts, out, error);
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
