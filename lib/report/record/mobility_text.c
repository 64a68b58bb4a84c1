/* Mobility analyses in words and tables for a terminal. */
#include "report/record/mobility_record.h"

#include "kinematics/state.h"

#include "kmech/mechanism.h"
#include "report/record/singular_value_record.h"
#include "sweep/sweep.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

static void print_substructures(const km_mechanism *m, const km_state *s, bool verbose, km_text *out) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_substructure_mobility e;
    km_substructure_evidence(m, s, i, &e);
    km_text_format(out, "  %d: mobility %d, rank %d of %d coordinate%s in %d loop%s, joints", i + 1, e.mobility, e.rank,
                   e.coordinates, km_plural(e.coordinates), e.loops, km_plural(e.loops));
    km_joints_print(m, i, out);
    km_text_add(out, "\n");
    if (verbose)
      km_text_format(out, "     evidence: last pivot kept %.2g, first dropped %.2g, tolerance %.2g\n", e.last_pivot,
                     e.first_dropped, e.tolerance);
  }
}

static bool moves_in_plane(const km_mechanism *m, int loop) {
  for (int p = 0; p < m->program_count; ++p)
    for (int i = 0; i < m->programs[p].loop_count; ++i)
      if (m->loop_order[m->programs[p].loop_start + i] == loop)
        return m->programs[p].planar;
  return false;
}

static void print_loop_kind(const km_mechanism *m, int loop, km_text *out) {
  int lambda = m->loops[loop].lambda;
  if (moves_in_plane(m, loop))
    km_text_add(out, "planar loop");
  else if (lambda == 6)
    km_text_add(out, "spatial loop");
  else
    km_text_format(out, "loop with a motion space of dimension %d", lambda);
}

/* ": crank-rocker, joint A goes round" of a four-bar. */
static void print_four_bar(const km_mechanism *m, const km_state *s, int loop, km_text *out) {
  const km_model *model = m->model;
  km_four_bar f;
  if (!km_four_bar_find(m, s, loop, &f))
    return;
  km_text_format(out, ": %s", km_four_bar_name(f.kind));
  const int before = f.joints[(f.shortest + 3) % 4], after = f.joints[f.shortest];
  if (f.kind == KM_FOUR_BAR_TRIPLE_ROCKER)
    km_text_format(out, ", no hinge goes round: link %s (%.5g) is too long by %.5g %s",
                   model->bodies[f.bodies[f.longest]].name, f.lengths[f.longest], f.excess,
                   model->units.length->suffix);
  else if (f.kind == KM_FOUR_BAR_CRANK_ROCKER)
    km_text_format(out, ", joint %s goes round", model->joints[f.shortest == 1 ? before : after].label);
  else if (f.kind != KM_FOUR_BAR_CHANGE_POINT)
    km_text_format(out, ", joints %s and %s go round", model->joints[before].label, model->joints[after].label);
}

static void print_loops(const km_mechanism *m, const km_state *s, km_text *out) {
  const km_topology *t = &m->topology;
  for (int l = 0; l < t->loop_count; ++l) {
    km_text_format(out, "  %d: ", l + 1);
    print_loop_kind(m, l, out);
    km_text_format(out, ", closed at joint %s, joints", m->model->joints[t->chord[l]].label);
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i)
      km_text_format(out, " %s", m->model->joints[t->member[i].joint].label);
    print_four_bar(m, s, l, out);
    km_text_add(out, "\n");
  }
}

static void print_coordinates(const km_mechanism *m, const km_state *s, km_text *out) {
  const km_model *model = m->model;
  int width = km_widest_label(model);
  km_text_add(out, "  ");
  km_text_padded("joint", width, out);
  km_text_add(out, "  type          position            mobility number\n");
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    const km_joint_kind *kind = km_joint_kind_of(joint->type);
    if (kind->freedom == 0) {
      km_text_add(out, "  ");
      km_text_padded(joint->label, width, out);
      km_text_format(out, "  %-11s  %12s %-4s  0\n", kind->word, "-", "");
    }
    for (int k = 0; k < kind->freedom; ++k) {
      int c = joint->first_coordinate + k;
      km_text_add(out, "  ");
      km_text_padded(model->coordinates[c].label, width, out);
      km_text_format(out, "  %-11s  %12.6g %-4s  %.6f%s\n", kind->word, km_state_coordinate(s, c),
                     km_model_coordinate_unit(model, c), km_mobility_number(s, c), m->held[c] ? "  (held)" : "");
    }
  }
}

static void print_finite(const km_finite_mobility *finite, km_text *out) {
  int branches = 0, shaky = 0;
  double followed = HUGE_VAL;
  for (int i = 0; i < finite->motion_count; ++i) {
    branches += finite->motions[i].kind == KM_MOTION_BRANCH;
    shaky += finite->motions[i].kind == KM_MOTION_SHAKY;
    if (finite->motions[i].kind == KM_MOTION_UNDECIDED)
      followed = fmin(followed, finite->motions[i].confirmed_length);
  }
  if (finite->undecided)
    km_text_format(out, "finite mobility undecided, at least %d", finite->mobility);
  else
    km_text_format(out, "finite mobility %d", finite->mobility);
  if (followed == 0.0)
    km_text_add(out, ": no motion along the directions that first order allows is confirmed, and none is ruled out");
  else if (isfinite(followed))
    km_text_format(out,
                   ": the loops stay within the closure tolerance for an arc of %.2g, and what opens them there tells "
                   "neither a motion nor a structure",
                   followed);
  if (branches)
    branches = km_finite_mobility_branches(finite);
  if (branches == 1 && !finite->truncated)
    km_text_add(out, ": not all motions that first order allows are real");
  else if (branches && finite->truncated)
    km_text_add(out, ": a branch point, where several motions meet");
  else if (branches)
    km_text_format(out, ": a branch point, where %d motions meet", branches);
  if (shaky)
    km_text_format(out, "%s it shakes: %d direction%s that first order allows, but no motion follows",
                   branches || isfinite(followed) ? "; also" : ":", shaky, shaky == 1 ? "" : "s");
  if (finite->undecided && finite->truncated)
    km_text_add(out, "; only some of the directions that first order allows were tried");
  km_text_add(out, "\n");
}

/* "(planar count 1)" of a planar mechanism; six freedoms a body are counted in space, or where all is printed. */
static void print_counts(const km_mobility *mobility, bool planar, bool verbose, km_text *out) {
  km_text_format(out, "mobility %d at this pose (", mobility->mobility);
  if (planar)
    km_text_format(out, "planar count %d%s", mobility->kutzbach_planar, verbose ? "; " : ")\n");
  if (!planar || verbose)
    km_text_format(out, "Kutzbach %d, extended Kutzbach %d), %d redundant constraint%s\n", mobility->kutzbach,
                   mobility->kutzbach_extended, mobility->redundant_constraints,
                   km_plural(mobility->redundant_constraints));
}

void km_mobility_print(const km_mechanism *m, const km_state *s, const km_mobility *mobility,
                       const km_finite_mobility *finite, const char *name, bool verbose, km_text *out) {
  if (km_check_state(m, s, NULL) || !mobility || !name || !out)
    return;
  const km_model *model = m->model;
  const km_topology *t = &m->topology;
  km_text_format(out, "%s: %d bod%s, %d joint%s with %d coordinate%s, %d loop%s, %d substructure%s\n", name,
                 model->body_count - 1, model->body_count == 2 ? "y" : "ies", model->joint_count,
                 km_plural(model->joint_count), model->coordinate_count, km_plural(model->coordinate_count),
                 t->loop_count, km_plural(t->loop_count), t->substructure_count, km_plural(t->substructure_count));
  double n[3];
  const bool planar = km_mechanism_plane(m, s, n);
  print_counts(mobility, planar, verbose, out);
  if (finite)
    print_finite(finite, out);
  if (planar)
    km_text_format(out, "planar: everything moves across (%.4g, %.4g, %.4g)\n", n[0], n[1], n[2]);
  km_text_format(out, "loops closed to %.2g, characteristic length %g %s (%s)\n", mobility->residual, m->length,
                 model->units.length->suffix, km_length_source_name(m->length_source));
  if (t->loop_count)
    km_text_add(out, "\nloops\n");
  print_loops(m, s, out);
  if (t->substructure_count)
    km_text_add(out, "\nsubstructures\n");
  print_substructures(m, s, verbose, out);
  if (model->joint_count)
    km_text_add(out, "\n");
  if (model->joint_count)
    print_coordinates(m, s, out);
}

/* The best driver after that of the given rank, by smallest mobility number; ties in file order. */
static int next_driver(const km_mechanism *m, const km_mobility_sweep *sweep, int last) {
  int best = -1;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (!km_sweep_drives(m, sweep, c))
      continue;
    double number = sweep->extremes[c].number;
    bool after =
        last < 0 || number < sweep->extremes[last].number || (number == sweep->extremes[last].number && c > last);
    if (after && (best < 0 || number > sweep->extremes[best].number))
      best = c;
  }
  return best;
}

static void print_drivers(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep, int width,
                          km_text *out) {
  enum { MOST_NAMED = 10 };
  int found = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    found += km_sweep_drives(m, sweep, c);
  km_text_add(out, sweep->motion.freedom - sweep->motion.passive > 1 ? "  without a dead point over the whole range:"
                                                                     : "  could drive the whole range:");
  if (found == 0)
    km_text_add(out, " none");
  for (int i = 0, c = -1; i < found && i < MOST_NAMED; ++i) {
    c = next_driver(m, sweep, c);
    km_text_format(out, "%s %s (%s%.2g)", i ? "," : "", m->model->coordinates[c].label, i ? "" : "least number ",
                   sweep->extremes[c].number);
  }
  if (found > MOST_NAMED)
    km_text_format(out, " and %d more", found - MOST_NAMED);
  km_text_add(out, "\n");
  const char *unit = km_sweep_unit(m, plan);
  for (int c = 0; c < m->coordinate_count; ++c) {
    int count = 0, all = 0;
    for (size_t i = 0; i < sweep->toggle_count; ++i)
      all += sweep->toggles[i].coordinate == c;
    for (size_t i = 0; i < sweep->toggle_count; ++i) {
      if (sweep->toggles[i].coordinate != c)
        continue;
      if (count++ == 0) {
        km_text_add(out, "  ");
        km_text_padded(m->model->coordinates[c].label, width, out);
        km_text_add(out, all > 1 ? " has dead points at" : " has a dead point at");
      }
      km_text_format(out, "%s %.6g%s", count > 1 ? "," : "", sweep->toggles[i].s, unit);
    }
    if (count)
      km_text_add(out, "\n");
  }
}

/* Ranges with more redundant constraints than the rest of the sweep. */
static void print_extra(const km_sweep_redundancies *r, const char *unit, km_text *out) {
  enum { MOST_SHOWN = 8 };
  if (r->extra_count == 0)
    return;
  km_text_add(out, "  redundant at poses only:");
  for (size_t i = 0; i < r->extra_count && i < MOST_SHOWN; ++i)
    km_text_format(out, "%s %d more at %.6g%s", i ? "," : "", r->extra[i].more, r->extra[i].s, unit);
  if (r->extra_count > MOST_SHOWN)
    km_text_format(out, " and at %zu other poses", r->extra_count - MOST_SHOWN);
  km_text_add(out, "\n");
}

/* Swings of the joints besides the driver. */
static void print_swings(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep,
                         km_text *out) {
  int width = km_widest_label(m->model), shown = 0, more = 0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    km_text line = {0};
    if (m->ball_of[c] >= 0 || (plan->arclength <= 0.0 && c == plan->coordinate))
      continue;
    km_swing swing = km_swing_with_toggles(m, sweep, c);
    bool moves = km_swing_print(m, plan, &swing, width, &line);
    if (moves && shown < KM_SWINGS_SHOWN)
      km_text_format(out, "%s\n", line.data ? line.data : "");
    shown += moves && shown < KM_SWINGS_SHOWN;
    more += moves;
    out->failed = out->failed || line.failed;
    km_text_free(&line);
  }
  if (more > shown)
    km_text_format(out, "  %d more joint%s\n", more - shown, more - shown == 1 ? " moves" : "s move");
}

void km_mobility_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep,
                             const km_sweep_redundancies *redundancies, const char *name, km_text *out) {
  km_sweep_print_range(m, plan, &sweep->motion, name, out);
  km_clearance_course_print(m, plan, &sweep->clearances, out);
  print_swings(m, plan, sweep, out);
  km_sweep_print_mobility(m, plan, &sweep->motion, out);
  print_extra(redundancies, km_sweep_unit(m, plan), out);
  km_singularities_print(sweep, km_sweep_unit(m, plan), out);
  if (sweep->motion.substructure >= 0)
    print_drivers(m, plan, sweep, km_widest_label(m->model), out);
  else if (plan->arclength <= 0.0)
    km_text_format(out, "  %s is in no loop: it drives itself, and every mobility number stays as it is\n",
                   m->model->coordinates[plan->coordinate].label);
}
