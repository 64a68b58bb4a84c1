/* One set of joint changes that ends all redundant constraints (theory 7.5).
 *
 *   configuration q₁: near the present one on the motion (5.8), so that nothing incidental counts
 *   proposal        : per substructure, remedy_search.c at q₁
 *   check           : the changed model is compiled at q₁; its redundant constraints and mobility are computed anew
 *
 * The motion of the original stays possible with all new coordinates at 0. The changed mechanism has no other motions
 * there if its rank is full and its mobility the same. */
#include "mobility/remedies/remedy_set.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kmech/mechanism.h"
#include "local/generic_neighbour.h"
#include "mobility/mobility_numbers.h"
#include "mobility/remedies/changed_model.h"
#include "mobility/remedies/remedy_search.h"
#include "mobility/substructure_loop.h"

#include <stdlib.h>
#include <string.h>

typedef struct set_search {
  const km_mechanism *m;
  km_state *s;
  bool *driven;   /* [joint] an input, an actuator or the driver of the sweep */
  double *values; /* [coordinate] configuration q₁, in the file's units */
  size_t capacity;
  km_remedy_set *out;
} set_search;

static void mark_driven(const km_model *model, bool *driven) {
  for (int i = 0; i < model->actuator_count; ++i)
    driven[model->coordinates[model->actuators[i]].joint] = true;
  const int others[] = {model->sweep.coordinate, model->advantage_input.coordinate};
  for (int i = 0; i < 2; ++i)
    if (others[i] >= 0)
      driven[model->coordinates[others[i]].joint] = true;
}

static bool add_changes(set_search *f, const km_remedy_search *found) {
  void *changes = f->out->changes;
  if (!km_reserve(&changes, &f->capacity, (size_t)(f->out->change_count + found->change_count), sizeof *found->changes))
    return false;
  f->out->changes = changes;
  for (int i = 0; i < found->change_count; ++i)
    f->out->changes[f->out->change_count++] = found->changes[i];
  return true;
}

/* Searches at the configuration of the state, whose partition and poses are those of the substructure. */
static bool search_here(set_search *f, int index, km_arena *arena) {
  km_left_space space;
  km_left_null null;
  km_remedy_search found;
  const km_factor *p = f->s->factor[index];
  const km_topology *t = &f->m->topology;
  const km_substructure *sub = &f->m->substructures[index];
  f->out->mobility += km_factor_freedom(p);
  for (int i = t->joint_start[index]; i < t->joint_start[index + 1]; ++i) {
    const km_model_joint *joint = &f->m->model->joints[t->joint[i]];
    for (int c = joint->first_coordinate; c < joint->first_coordinate + km_model_freedom(f->m->model, t->joint[i]); ++c)
      f->values[c] = km_state_coordinate(f->s, c);
  }
  int redundant = 6 * sub->loop_count + sub->coupling_count - km_factor_rank(p);
  f->out->redundant += redundant;
  if ((double)redundant * (t->joint_start[index + 1] - t->joint_start[index]) > KM_MAX_SET_SIZE) {
    f->out->is_too_large = true;
    f->out->remaining += redundant;
    return true;
  }
  if (!km_left_space_create(f->m, f->s, index, arena, &space) || !km_left_null_find(&space, arena, &null) ||
      !km_remedy_search_run(&space, &null, f->driven, arena, &found))
    return false;
  f->out->remaining += found.remaining + redundant - found.redundant;
  return add_changes(f, &found);
}

static km_status search_substructure(void *self, int index, km_arena *arena, km_error *error) {
  (void)error;
  set_search *f = self;
  const km_substructure *sub = &f->m->substructures[index];
  double *saved = KM_ARENA_NEW(arena, double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns));
  double *move = KM_ARENA_NEW(arena, double, (size_t)sub->columns);
  if (arena->failed)
    return KM_MEMORY;
  bool has_neighbour = km_generic_neighbour_enter(f->m, f->s, index, saved, move);
  bool ok = !has_neighbour || search_here(f, index, arena);
  km_generic_neighbour_leave(f->m, f->s, index, saved);
  return ok && (has_neighbour || search_here(f, index, arena)) ? KM_OK : KM_MEMORY;
}

/* Computes redundant constraints and mobility of the changed model at q₁. */
static km_status check_changed(const set_search *f, km_error *error) {
  km_model *model = NULL;
  km_mechanism *m = NULL;
  km_state *s = NULL;
  km_mobility found = {0};
  km_status status = km_changed_model(f->m, f->values, f->out, &model, error);
  km_hold *holds = status ? NULL : km_model_list_holds(model);
  if (!status && !holds)
    status = km_fail(error, KM_MEMORY, "out of memory for the set of remedies");
  if (!status)
    status = km_mechanism_compile(model, holds, model->hold_count, &m, error);
  if (!status)
    status = km_state_create(m, &s, error);
  if (!status)
    status = km_assemble(m, s, NULL, error);
  if (!status)
    status = km_mobility_compute(m, s, &found);
  f->out->is_checked =
      !status && found.redundant_constraints == f->out->remaining && found.mobility == f->out->mobility;
  km_state_free(s);
  km_mechanism_free(m);
  km_model_free(model);
  km_free(holds);
  return status == KM_MODEL ? KM_OK : status; /* loops that don't close: the set stays unchecked */
}

static int count_tree_coordinates(const km_mechanism *m) {
  int count = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    count += m->substructure_of[c] < 0 && !m->held[c];
  return count;
}

static km_status find_set(set_search *f, int finite_mobility, km_progress progress, void *context, km_error *error) {
  km_mobility mobility;
  const char *what = "the set of remedies";
  mark_driven(f->m->model, f->driven);
  km_poses_compute(f->m, f->s);
  km_ranks_update(f->m, f->s, KM_BASIS_ANY, &mobility);
  for (int c = 0; c < f->m->coordinate_count; ++c)
    f->values[c] = km_state_coordinate(f->s, c);
  f->out->mobility = count_tree_coordinates(f->m);
  km_status status = km_each_substructure(f->m, search_substructure, f, progress, context, what, error);
  km_poses_compute(f->m, f->s);
  if (status || f->out->redundant == 0)
    return status;
  f->out->is_infinitesimal = finite_mobility >= 0 && finite_mobility < f->out->mobility;
  if (f->out->is_infinitesimal) {
    f->out->change_count = 0;
    f->out->remaining = f->out->redundant;
  }
  return f->out->change_count ? check_changed(f, error) : KM_OK;
}

km_status km_remedy_set_find_with(const km_mechanism *m, km_state *s, int finite_mobility, km_progress progress,
                                  void *context, km_remedy_set *out, km_error *error) {
  km_arena arena = {0};
  set_search f = {.m = m,
                  .s = s,
                  .out = out,
                  .driven = KM_ARENA_NEW(&arena, bool, (size_t)m->model->joint_count),
                  .values = KM_ARENA_NEW(&arena, double, (size_t)m->coordinate_count)};
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the set of remedies")
                                  : find_set(&f, finite_mobility, progress, context, error);
  km_arena_free(&arena);
  return status;
}

km_status km_remedy_set_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                             km_remedy_set *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_remedy_set){0};
  km_status status = km_check_state(m, s, error);
  km_finite_mobility finite = {0};
  if (!status)
    status = km_finite_mobility_find(m, s, progress, context, &finite, error);
  if (!status)
    status = km_remedy_set_find_with(m, s, finite.undecided ? -1 : finite.mobility, progress, context, out, error);
  km_finite_mobility_free(&finite);
  return status;
}

km_status km_remedy_set_model(const km_mechanism *m, const km_state *s, const km_remedy_set *set, km_model **out,
                              km_error *error) {
  if (out)
    *out = NULL;
  km_status status = km_check_given(set && out, "set or place for the model", error);
  if (!status)
    status = km_check_state(m, s, error);
  if (status)
    return status;
  double *values = KM_NEW(double, (size_t)m->coordinate_count + 1);
  status = values ? km_state_coordinates(m, s, values, error)
                  : km_fail(error, KM_MEMORY, "out of memory for the changed model");
  if (!status)
    status = km_changed_model(m, values, set, out, error);
  km_free(values);
  return status;
}

void km_remedy_set_free(km_remedy_set *set) {
  if (!set)
    return;
  km_free(set->changes);
  *set = (km_remedy_set){0};
}
