/* All assembly modes of a mechanism with some coordinates locked (docs/theory.md 4.15 to 4.17). */
#include "base/number/tolerances.h"
#include "kmech/space.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/modes/mode_identity.h"
#include "kmech/mobility.h"
#include "space/complex/real_endpoints.h"
#include "space/mode_proof.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_STARTS = 1000 /* random configurations, where the state doesn't close */ };
/* Parts of the work: solutions over the complex numbers, which take 0.3 to 0.9 of the time in models/, and their way to
 * the closed loops; the list is the rest. */
static const double share_of_graph = 0.8, share_of_ends = 0.15;

/* One mode before the result is written. */
typedef struct found_mode {
  double *saved;         /* [3 · columns] */
  km_pose *pose;         /* [body] */
  const double *ordered; /* [coordinate] values by which modes are ordered */
  km_mode_evidence evidence;
} found_mode;

typedef struct modes_search {
  km_mechanism *m; /* the given mechanism with loops cut at ball joints, whose rotations are then no unknowns */
  km_state *original;
  km_state *s; /* state with the locked coordinates */
  const km_all_modes_def *def;
  int substructure, passive; /* passive: mobility of passive freedoms */
  km_arena arena;
  km_complex_closure closure;
  km_mode_workspace work;
  km_body_placement *placements;
  km_real_endpoints ends;
  found_mode *modes;
  int count;
  km_progress_stage stage;
  bool is_stopped; /* `progress` ended a stage; those behind it are not stopped again */
} modes_search;

const char *km_mode_gap_name(km_mode_gap gap) {
  static const char *const names[] = {"complete",    "trace", "lost",    "singular",
                                      "self-motion", "limit", "stopped", "refused"};
  return gap >= KM_GAP_NONE && gap <= KM_GAP_REFUSED ? names[gap] : "";
}

static const km_substructure *substructure_of(const modes_search *f) {
  return &f->m->substructures[f->substructure];
}

/* ---- The subject: substructure and locks. */

/* Compiles the model of m with loops cut at ball joints, and copies the state. */
static km_status cut_at_balls(modes_search *f, const km_mechanism *m, const km_state *s, km_error *error) {
  km_compiling options = km_mechanism_options(m);
  options.cuts_balls = true;
  km_status status = km_mechanism_compile_as(m->model, &options, &f->m, error);
  if (!status)
    status = km_state_create(f->m, &f->original, error);
  if (!status)
    status = km_state_create(f->m, &f->s, error);
  if (!status) {
    km_state_copy(f->m, f->original, s);
    km_state_copy(f->m, f->s, s);
  }
  return status;
}

/* Chooses the substructure of the locked coordinates, else the largest one. */
static km_status choose_substructure(modes_search *f, km_error *error) {
  const km_mechanism *m = f->m;
  f->substructure = -1;
  for (int i = 0; i < f->def->locked_count; ++i) {
    int c = f->def->locked[i];
    km_status status = km_check_index(c, m->coordinate_count, "coordinate", error);
    if (status)
      return status;
    const char *label = m->model->coordinates[c].label;
    int own = m->substructure_of[c];
    if (m->held[c] || own < 0 || m->substructures[own].loop_count == 0)
      return km_fail(error, KM_USAGE,
                     "joint \"%s\" can't be locked for assembly modes; expected a free joint of a loop", label);
    if (f->substructure >= 0 && f->substructure != own)
      return km_fail(error, KM_USAGE,
                     "joint \"%s\" is in another part of the mechanism than \"%s\"; expected joints of one part, whose "
                     "assembly modes are searched",
                     label, m->model->coordinates[f->def->locked[0]].label);
    f->substructure = own;
  }
  if (f->substructure < 0)
    f->substructure = km_mode_substructure(m);
  return f->substructure >= 0
             ? KM_OK
             : km_fail(error, KM_USAGE, "the model has no loop; expected one that closes in different ways");
}

/* Closes the loops from random configurations with the locked values; the first that closes takes the place of the
 * state. */
static km_status close_from_elsewhere(modes_search *f, km_error *error) {
  bool is_closed = false;
  for (int i = 0; i < MOST_STARTS && !is_closed && !f->work.failed; ++i) {
    km_mode_randomise(&f->work);
    is_closed = km_mode_close(&f->work);
  }
  if (!is_closed && !f->work.failed)
    return km_fail(error, KM_NO_RESULT,
                   "no assembly mode was found with the joints at these values, from %d random starts", MOST_STARTS);
  if (f->work.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  km_state_copy(f->m, f->original, f->s);
  return KM_OK;
}

/* Locks the coordinates, all three of a ball joint, and closes the loops. */
static km_status lock_and_close(modes_search *f, km_error *error) {
  for (int i = 0; i < f->def->locked_count; ++i) {
    int c = f->def->locked[i], ball = f->m->ball_of[c];
    if (ball < 0)
      km_state_lock(f->s, c);
    for (int k = 0; ball >= 0 && k < 3; ++k)
      km_state_lock(f->s, f->m->ball_coordinate[ball] + k);
  }
  if (!km_mode_workspace_reserve(&f->work, &f->arena))
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return km_mode_close(&f->work) ? KM_OK : close_from_elsewhere(f, error);
}

/* Says how many joints must be locked. */
static km_status explain_freedom(int freedom, km_error *error) {
  return km_fail(error, KM_USAGE,
                 "the bodies can still move in %d way%s, so that there are no separate assembly modes; lock %d joint%s "
                 "more",
                 freedom, freedom == 1 ? "" : "s", freedom, freedom == 1 ? "" : "s");
}

static km_status compile_system(modes_search *f, uint64_t *random, km_error *error) {
  int freedom = 0;
  km_passive_freedoms passive;
  km_status status = km_passive_freedoms_find(f->m, f->s, NULL, NULL, &passive, error);
  for (int i = 0; !status && i < passive.count; ++i)
    if (passive.items[i].substructure == f->substructure)
      f->passive += passive.items[i].freedoms;
  km_passive_freedoms_free(&passive);
  if (!status)
    status = km_complex_closure_create(f->m, f->s, f->substructure, random, &f->arena, &f->closure, &freedom, error);
  return freedom > 0 ? explain_freedom(freedom, error) : status;
}

/* ---- The list of modes. */

/* Coordinates by which modes are ordered; values within rounding of 0 are 0. */
static const double *ordering_values(modes_search *f) {
  double *values = KM_ARENA_NEW(&f->arena, double, (size_t)f->m->coordinate_count);
  for (int c = 0; values && c < f->m->coordinate_count; ++c)
    values[c] = fabs(f->s->q[c]) <= km_root_rounding * f->m->unit[c] ? 0.0 : f->s->q[c];
  return values;
}

/* True if bodies move along first-order motions that the locked coordinates allow, beyond passive freedoms. */
static bool is_singular(modes_search *f) {
  const km_factor *p = f->s->factor[f->substructure];
  km_update_and_search_pivots(f->m, f->s, f->substructure, KM_NO_DRIVER, 0.0);
  return km_factor_freedom(p) > f->passive;
}

/* Notes that `progress` ended a stage; the result is what is known by then. */
static km_status note_stop(modes_search *f, km_status status) {
  if (status != KM_CANCELLED)
    return status;
  f->is_stopped = true;
  f->stage.progress = NULL;
  return KM_OK;
}

/* Judges a singular mode: it moves, unless no finite motion leads on. A stopped judgement counts as moving. */
static km_status judge_motion(modes_search *f, km_mode_evidence *evidence, km_error *error) {
  km_finite_mobility finite = {0};
  km_status status = f->is_stopped
                         ? KM_CANCELLED
                         : km_finite_mobility_find(f->m, f->s, km_progress_stage_report, &f->stage, &finite, error);
  evidence->moves = status == KM_CANCELLED || (!status && (finite.undecided || finite.mobility > f->passive));
  km_finite_mobility_free(&finite);
  return note_stop(f, status);
}

/* Adds the state's configuration as a mode, unless it is known. */
static km_status add_mode(modes_search *f, bool is_first, km_error *error) {
  const km_substructure *sub = substructure_of(f);
  size_t bodies = (size_t)f->m->model->body_count;
  bool is_normal = is_first || km_mode_normalise(&f->work);
  km_poses_compute(f->m, f->s);
  for (int i = 0; i < f->count; ++i)
    if (km_is_same_mode(f->m, f->placements, f->modes[i].pose, f->s->pose, sub->size, km_root_rounding))
      return KM_OK;
  found_mode *mode = &f->modes[f->count];
  *mode = (found_mode){.saved = KM_ARENA_NEW(&f->arena, double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns)),
                       .pose = KM_ARENA_NEW(&f->arena, km_pose, bodies),
                       .ordered = ordering_values(f)};
  if (f->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  km_state_save(f->s, sub, mode->saved);
  memcpy(mode->pose, f->s->pose, bodies * sizeof *mode->pose);
  km_loops_update(f->m, f->s, sub);
  mode->evidence.residual = km_loops_residual(f->m, f->s, sub);
  mode->evidence.is_within_limits = is_normal && km_state_find_outside_limit(f->s, sub) < 0;
  mode->evidence.is_singular = is_singular(f);
  ++f->count;
  return mode->evidence.is_singular ? judge_motion(f, &mode->evidence, error) : KM_OK;
}

/* Proves a mode by its configuration. */
static bool prove_mode(modes_search *f, found_mode *mode) {
  km_wide *x = KM_NEW(km_wide, (size_t)f->closure.length);
  km_mode_proof proof;
  if (!x)
    return false;
  km_state_restore(f->s, substructure_of(f), mode->saved);
  km_complex_from_state(&f->closure, f->s, x);
  bool is_ok = km_mode_prove(&f->closure, x, &proof);
  mode->evidence.is_certified = proof.is_proved;
  mode->evidence.kantorovich = proof.h;
  mode->evidence.error_bound = proof.error_bound;
  mode->evidence.radius = proof.radius;
  km_free(x);
  return is_ok;
}

static int compare_modes(const void *a, const void *b, void *context) {
  const found_mode *first = a, *second = b;
  const modes_search *f = context;
  for (int c = 0; c < f->m->coordinate_count; ++c) {
    double difference = first->ordered[c] - second->ordered[c];
    if (fabs(difference) > km_root_rounding * f->m->unit[c])
      return difference < 0.0 ? -1 : 1;
  }
  return 0;
}

/* Collects the state's own mode and all real ends, in order. */
static km_status collect_modes(modes_search *f, bool *is_first_found, km_error *error) {
  const km_substructure *sub = substructure_of(f);
  double *own = KM_ARENA_NEW(&f->arena, double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns));
  f->modes = KM_ARENA_NEW(&f->arena, found_mode, (size_t)f->ends.count + 1);
  f->placements = KM_ARENA_NEW(&f->arena, km_body_placement, (size_t)f->m->model->body_count);
  if (f->arena.failed || !km_body_placements(f->m, f->placements))
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  km_state_copy(f->m, f->s, f->original);
  if (!km_mode_close(&f->work)) /* lock_and_close closed it */
    return km_fail(error, KM_MODEL, "the loops of the state are open; expected an assembled one");
  km_state_save(f->s, sub, own);
  km_status status = add_mode(f, true, error);
  *is_first_found = false;
  for (int i = 0; !status && i < f->ends.count; ++i) {
    km_state_restore(f->s, sub, f->ends.items[i]);
    km_poses_compute(f->m, f->s);
    *is_first_found = *is_first_found ||
                      km_is_same_mode(f->m, f->placements, f->modes[0].pose, f->s->pose, sub->size, km_root_rounding);
    status = add_mode(f, false, error);
  }
  if (!status && f->count > 2)
    qsort_r(f->modes + 1, (size_t)f->count - 1, sizeof *f->modes, compare_modes, f);
  for (int i = 0; !status && i < f->count; ++i)
    if (!prove_mode(f, &f->modes[i]))
      status = km_fail(error, KM_MEMORY, "out of memory for the proofs of the assembly modes");
  return status;
}

/* ---- The result. */

/* Decides the verdict. */
static void judge_completeness(const modes_search *f, const km_fibre_search *search, bool is_first_found,
                               km_all_modes *out) {
  bool moves = false;
  for (int i = 0; i < f->count; ++i)
    moves = moves || f->modes[i].evidence.moves;
  out->gap = f->is_stopped                                  ? KM_GAP_STOPPED
             : moves                                        ? KM_GAP_MOVES
             : search->is_exhausted && !search->is_complete ? KM_GAP_LIMIT
             : !search->is_complete                         ? KM_GAP_TRACE
             : f->ends.singular > 0                         ? KM_GAP_SINGULAR
             : f->ends.lost > 0 || !is_first_found          ? KM_GAP_LOST
                                                            : KM_GAP_NONE;
  out->is_complete = out->gap == KM_GAP_NONE;
  out->complex_solutions = search->graph.node[0].count;
  out->section_points = search->section_points;
  out->trace_difference = search->trace_difference;
  out->samples = search->samples;
  out->found_once = search->found_once;
  out->infinite = f->ends.infinite;
  out->singular = f->ends.singular;
  /* Good-Turing: the share of unseen solutions is about found_once / samples. */
  double unseen = out->samples > out->found_once ? (double)out->found_once / out->samples : 0.0;
  out->estimate = (int)round(out->complex_solutions / (1.0 - unseen));
}

/* Writes one mode to place `k` of the result. */
static km_status write_mode(modes_search *f, const found_mode *mode, int k, km_all_modes *out) {
  int n = f->m->coordinate_count;
  km_mobility mobility;
  km_state_unlock(f->s);
  km_state_restore(f->s, substructure_of(f), mode->saved);
  km_state_invalidate_pivots(f->s, f->substructure);
  if (km_mobility_compute(f->m, f->s, &mobility))
    return KM_MEMORY;
  out->evidence[k] = mode->evidence;
  out->evidence[k].mobility = mobility.mobility;
  for (int c = 0; c < n; ++c) {
    bool is_zero =
        f->m->substructure_of[c] == f->substructure && fabs(f->s->q[c]) <= km_solved_rounding * f->m->unit[c];
    out->coordinates[(size_t)k * (size_t)n + (size_t)c] = is_zero ? 0.0 : km_state_coordinate(f->s, c);
    out->mobility_numbers[(size_t)k * (size_t)n + (size_t)c] = km_mobility_number(f->s, c);
  }
  return KM_OK;
}

static km_status write_modes(modes_search *f, km_all_modes *out, km_error *error) {
  size_t size = (size_t)f->count * (size_t)f->m->coordinate_count;
  out->coordinates = KM_NEW(double, size);
  out->mobility_numbers = KM_NEW(double, size);
  out->evidence = KM_NEW(km_mode_evidence, (size_t)f->count);
  bool is_ok = out->coordinates && out->mobility_numbers && out->evidence;
  out->substructure = f->substructure;
  for (int i = 0; is_ok && i < f->count; ++i) {
    bool is_outside = !f->modes[i].evidence.is_within_limits;
    out->outside += is_outside;
    if (is_outside && f->def->within_limits && i > 0)
      continue;
    is_ok = write_mode(f, &f->modes[i], out->count, out) == KM_OK;
    out->count += is_ok;
  }
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
}

/* Follows the solutions over the complex numbers, and those found to the closed loops. */
static km_status follow_solutions(modes_search *f, const km_wide *centre, uint64_t *random, km_fibre_search *search,
                                  km_error *error) {
  int limit = f->def->max_solutions > 0 ? f->def->max_solutions : KM_DEFAULT_MODE_SOLUTIONS;
  km_progress_stage_next(&f->stage, share_of_graph);
  km_status status = note_stop(f, km_fibre_search_run(&f->closure, centre, limit, random, &f->arena,
                                                      km_progress_stage_report, &f->stage, search, error));
  search->graph.cancelled = false;
  km_progress_stage_next(&f->stage, share_of_graph + share_of_ends);
  return status ? status
                : note_stop(f, km_real_endpoints_find(search, &f->closure, &f->work, &f->arena, &f->ends, error));
}

/* The search from a locked and closed state. */
static km_status search_modes(modes_search *f, km_all_modes *out, km_error *error) {
  uint64_t random = 2 * (uint64_t)f->def->seed + 1;
  bool is_first_found = false;
  km_fibre_search search = {0};
  km_status status = compile_system(f, &random, error);
  km_wide *centre = status ? NULL : KM_ARENA_NEW(&f->arena, km_wide, (size_t)f->closure.length);
  if (!status && !centre)
    status = km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  if (!status) {
    km_complex_from_state(&f->closure, f->s, centre);
    status = follow_solutions(f, centre, &random, &search, error);
  }
  km_progress_stage_next(&f->stage, 1.0);
  if (!status)
    status = collect_modes(f, &is_first_found, error);
  if (!status)
    status = write_modes(f, out, error);
  if (!status)
    judge_completeness(f, &search, is_first_found, out);
  km_fibre_search_free(&search);
  km_free(f->ends.items);
  return !status && f->is_stopped ? km_fail(error, KM_CANCELLED, "stopped while assembly modes were searched") : status;
}

km_status km_all_modes_find(const km_mechanism *m, const km_state *s, const km_all_modes_def *def, km_progress progress,
                            void *context, km_all_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_all_modes){.trace_difference = nan("")};
  modes_search f = {.def = def, .stage = {.progress = progress, .context = context}};
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(def != NULL, "definition of the search", error);
  if (!status)
    status = km_check_list(def->locked, def->locked_count, "locked coordinates", error);
  if (!status)
    status = cut_at_balls(&f, m, s, error);
  if (!status)
    status = choose_substructure(&f, error);
  if (!status) {
    f.work = (km_mode_workspace){
        .m = f.m, .s = f.s, .original = f.original, .substructure = f.substructure, .random = def->seed};
    status = lock_and_close(&f, error);
  }
  if (!status)
    status = search_modes(&f, out, error);
  km_arena_free(&f.arena);
  km_state_free(f.s);
  km_state_free(f.original);
  km_mechanism_free(f.m);
  return status;
}

void km_all_modes_free(km_all_modes *modes) {
  if (!modes)
    return;
  km_free(modes->coordinates);
  km_free(modes->mobility_numbers);
  km_free(modes->evidence);
  *modes = (km_all_modes){0};
}
