/* Renumbering: new numbers in a compiled mechanism. They are compiled into a second set of arrays, which replaces the
 * first if the structure is equal: a failed call changes nothing. */
#include "topology/compile.h"

#include <string.h>

/* Creates the second set of arrays. */
static bool create_spare(km_mechanism *m) {
  km_mechanism *spare = KM_NEW(km_mechanism, 1);
  if (!spare)
    return false;
  m->spare = spare;
  spare->model = m->model;
  spare->topology = m->topology; /* its arrays stay in the first arena */
  spare->coordinate_count = m->coordinate_count;
  spare->closure_tolerance = m->closure_tolerance;
  spare->closure_tolerance_given = m->closure_tolerance_given;
  spare->spare_workspace = KM_ARENA_NEW(&spare->arena, km_compile_workspace, 1);
  if (spare->spare_workspace && km_compile_allocate(spare, spare->spare_workspace))
    return true;
  km_mechanism_free(spare);
  m->spare = NULL;
  return false;
}

/* Resets everything that km_compile_values accumulates. */
static void reset_counters(km_mechanism *s) {
  memset(s->held, 0, (size_t)s->coordinate_count * sizeof *s->held);
  memset(s->substructures, 0, (size_t)s->topology.substructure_count * sizeof *s->substructures);
  memset(s->loops, 0, (size_t)s->topology.loop_count * sizeof *s->loops);
  s->ball_count = 0;
  s->program_count = s->step_count = s->planar_step_count = s->entry_count = s->coupling_count = s->term_count =
      s->curve_size = s->twist_count = 0;
  s->largest_slots = s->largest_rows = s->largest_columns = 0;
  s->matrix_size = 0;
  s->error_size = 0;
}

/* True if programs, planarity, entries and motion-space dimensions are equal. */
static bool is_same_structure(const km_mechanism *a, const km_mechanism *b) {
  if (a->program_count != b->program_count || a->entry_count != b->entry_count || a->largest_slots != b->largest_slots)
    return false;
  for (int p = 0; p < a->program_count; ++p)
    if (a->programs[p].planar != b->programs[p].planar)
      return false;
  for (int l = 0; l < a->topology.loop_count; ++l)
    if (a->loops[l].lambda != b->loops[l].lambda)
      return false;
  return true;
}

/* Copies the storage of Jacobians, which depends on the structure only. */
static void copy_value_indices(const km_mechanism *from, km_mechanism *to) {
  for (int i = 0; i < from->entry_count; ++i) {
    to->entries[i].value_index = from->entries[i].value_index;
    to->entries[i].column_stride = from->entries[i].column_stride;
  }
  for (int i = 0; i < from->term_count; ++i)
    to->terms[i].value_index = from->terms[i].value_index;
  for (int s = 0; s < from->topology.substructure_count; ++s) {
    to->substructures[s].pattern = from->substructures[s].pattern;
    to->substructures[s].matrix_start = from->substructures[s].matrix_start;
  }
  to->matrix_size = from->matrix_size;
}

/* Swaps all numbers; the mechanism stays the owner of its spare. Factors of states borrow the weights, so these are
 * copied to their place. */
static void swap_numbers(km_mechanism *m, km_mechanism *spare) {
  km_mechanism old = *m;
  *m = *spare;
  *spare = old;
  m->spare = spare;
  spare->spare = NULL;
  memcpy(old.column_weight, m->column_weight, (size_t)m->coordinate_count * sizeof *m->column_weight);
  spare->column_weight = m->column_weight;
  m->column_weight = old.column_weight;
  km_compile_workspace *workspace = m->spare_workspace ? m->spare_workspace : spare->spare_workspace;
  m->spare_workspace = spare->spare_workspace = workspace;
  m->holds = old.holds;
  m->hold_count = old.hold_count;
  m->version = old.version + 1;
}

/* Compiles the new numbers into the spare arrays and swaps them if the structure is equal. */
km_status km_mechanism_renumber(km_mechanism *m, km_error *error) {
  if (!m)
    return km_fail(error, KM_USAGE, "found no mechanism");
  km_compiling options = {.holds = m->holds,
                          .hold_count = m->hold_count,
                          .length = m->length_source == KM_LENGTH_JOINTS ? m->length : 0.0,
                          .length_source = m->length_source};
  if (!m->spare && !create_spare(m))
    return km_fail(error, KM_MEMORY, "out of memory for new numbers");
  km_mechanism *spare = m->spare;
  reset_counters(spare);
  km_compile_values(spare, &options, spare->spare_workspace);
  if (!is_same_structure(m, spare))
    return km_fail(error, KM_PARTIAL,
                   "the new numbers change how a loop can move; expected to compile the model again");
  copy_value_indices(m, spare);
  swap_numbers(m, spare);
  return KM_OK;
}
