/* Notes about geometry: offsets along hinge axes, substructures that are rigid by rounding, doubtful ranks. */
#include "mobility/geometry_notes.h"
#include "base/number/tolerances.h"

#include "kinematics/assembly.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/rank_evidence.h"

/* Adds the note about a loop whose ends are offset along its hinge axes. */
static void note_pin_offset(const km_mechanism *m, int index, km_messages *messages) {
  const km_loop *loop = &m->loops[index];
  const km_model *model = m->model;
  const km_topology *t = &m->topology;
  double size = m->substructures[t->substructure_of_loop[index]].size;
  if (!(fabs(loop->pin_offset) > km_root_rounding)) /* smaller ones come from the digits of a file */
    return;
  int base = t->base[index];
  km_vec3 n = loop->plane_normal;
  km_messages_add(
      messages, KM_NOTE,
      "loop %d: at %.80s its ends are %.4g %s apart along the hinge axes, direction (%.4g, %.4g, %.4g) of body %.80s; "
      "taken for one point, since a hinge's frames may lie anywhere along its axis",
      index + 1, model->joints[t->chord[index]].label, size * fabs(loop->pin_offset), model->units.length->suffix,
      n.x + 0.0, n.y + 0.0, n.z + 0.0, model->bodies[base].name);
}

/* Returns the residual at the file's initial displacements; NaN without memory. */
static double residual_at_start(const km_mechanism *m, int index) {
  km_state *start = NULL;
  double misfit = nan("");
  if (!km_state_create(m, &start, NULL)) {
    km_loops_update(m, start, &m->substructures[index]);
    misfit = km_loops_residual(m, start, &m->substructures[index]);
  }
  km_state_free(start);
  return misfit;
}

/* True if rounding of the data explains a pivot of this size in a substructure without redundant constraints:
 *
 *   misfit >= 1e-5 pivot   the loops do not close without it; for a file with rounded rotations at its start too
 *   first <= 100 pivot     a larger residual at the start means a poor start, not rounding
 *
 * A small pivot that is geometry, such as a link a millionth as long as the others, leaves loops that close. */
static bool is_rounding(const km_mechanism *m, int index, double pivot, double misfit) {
  const double smallest_misfit = 1e-5 * pivot, first = residual_at_start(m, index);
  bool is_poor = first > 100.0 * pivot, is_rounded = m->model->rotation_misfit >= 1e-2 * pivot;
  return is_rounded ? fmax(first, misfit) >= smallest_misfit : !is_poor && misfit >= smallest_misfit;
}

/* Adds the note about a substructure that is rigid as written because of a pivot small enough for rounding. */
static void note_rigid_by_rounding(const km_mechanism *m, km_state *s, int index, km_messages *messages) {
  static const double largest_pivot = 1e-3; /* relative to the largest one: the error of three digits */
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  km_suggestion suggestion;
  if (m->closure_tolerance_given || sub->pattern.start || sub->loop_count == 0)
    return;
  km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, 0.0);
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  double pivot = km_factor_rank(p) > 0 ? evidence.last_pivot / evidence.scale : 1.0;
  bool is_redundant = km_factor_rank(p) < sub->rows;
  if (km_factor_freedom(p) > 0 || pivot > largest_pivot || !km_assemble_suggest(m, index, 1, &suggestion) ||
      !(is_redundant || is_rounding(m, index, pivot, suggestion.misfit)))
    return;
  km_messages_add(messages, KM_NOTE,
                  "substructure %d (joint %.80s and others) is rigid as written, but within %.1g of its size of one of "
                  "mobility %d: look for a wrong digit; if its numbers are rounded, state \"closure_tolerance\": %g or "
                  "give --closure-tolerance %g",
                  index + 1, m->model->joints[m->topology.joint[m->topology.joint_start[index]]].label, pivot,
                  suggestion.mobility, suggestion.tolerance, suggestion.tolerance);
}

void km_pin_offset_notes(const km_mechanism *m, km_messages *messages) {
  for (int l = 0; l < m->topology.loop_count; ++l)
    note_pin_offset(m, l, messages);
}

void km_nearly_movable_notes(const km_mechanism *m, km_state *s, km_messages *messages) {
  for (int i = 0; i < m->topology.substructure_count; ++i)
    note_rigid_by_rounding(m, s, i, messages);
}

void km_geometry_notes(const km_mechanism *m, km_state *s, km_messages *messages) {
  if (!km_state_belongs_to(m, s) || !messages)
    return;
  km_pin_offset_notes(m, messages);
  km_nearly_movable_notes(m, s, messages);
}

km_status km_rank_doubts(const km_mechanism *m, km_state *s, km_messages *messages, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (status)
    return status;
  km_poses_compute(m, s);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_rank_evidence e;
    status = km_rank_evidence_find(m, s, i, &e, error);
    if (status)
      return status;
    if (e.doubtful)
      km_messages_add(
          messages, KM_WARNING,
          "the rank of substructure %d is doubtful: the smallest singular value kept is %.2g of the largest "
          "one, the largest dropped %.2g",
          i + 1, e.kept, e.dropped);
  }
  return KM_OK;
}
