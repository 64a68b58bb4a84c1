/* Mobility analyses in words and tables for a terminal. */
#include "report/mobility_record.h"

#include "topology/mechanism.h"

#include <string.h>

static const char *plural(int count) {
  return count == 1 ? "" : "s";
}

/* A label padded to a width counted in characters, not bytes. */
static void padded(const char *label, int width, km_text *out) {
  int shown = 0;
  for (const char *c = label; *c; ++c)
    shown += ((unsigned char)*c & 0xC0) != 0x80;
  km_text_add(out, label);
  for (; shown < width; ++shown)
    km_text_add(out, " ");
}

static int widest_label(const km_model *model) {
  int width = 5;
  for (int c = 0; c < model->coordinate_count; ++c) {
    int length = (int)strlen(model->coordinates[c].label);
    if (length > width && length < 40)
      width = length;
  }
  return width;
}

static void print_joints(const km_mechanism *m, int substructure, km_text *out) {
  const km_topology *t = &m->topology;
  for (int k = t->joint_start[substructure]; k < t->joint_start[substructure + 1]; ++k)
    km_text_format(out, " %s", m->model->joints[t->joint[k]].label);
}

static void print_substructures(const km_mechanism *m, const km_state *s, km_text *out) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_substructure_mobility e;
    km_substructure_evidence(m, s, i, &e);
    km_text_format(out, "  %d: mobility %d, rank %d of %d coordinate%s in %d loop%s, joints", i + 1, e.mobility, e.rank,
                   e.coordinates, plural(e.coordinates), e.loops, plural(e.loops));
    print_joints(m, i, out);
    km_text_format(out, "\n     evidence: last pivot kept %.2g, first dropped %.2g, tolerance %.2g\n", e.last_pivot,
                   e.first_dropped, e.tolerance);
  }
}

static void print_loops(const km_mechanism *m, km_text *out) {
  const km_topology *t = &m->topology;
  for (int l = 0; l < t->loop_count; ++l) {
    km_text_format(out, "  %d: lambda %d, chord %s, joints", l + 1, m->loops[l].lambda,
                   m->model->joints[t->chord[l]].label);
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i)
      km_text_format(out, " %s", m->model->joints[t->member[i].joint].label);
    km_text_add(out, "\n");
  }
}

static void print_coordinates(const km_mechanism *m, const km_state *s, km_text *out) {
  const km_model *model = m->model;
  int width = widest_label(model);
  km_text_add(out, "  ");
  padded("joint", width, out);
  km_text_add(out, "  type          position            mobility number\n");
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_def *joint = &model->joints[j];
    const km_joint_kind *kind = km_joint_kind_of(joint->type);
    if (kind->freedom == 0) {
      km_text_add(out, "  ");
      padded(joint->label, width, out);
      km_text_format(out, "  %-11s  %12s %-4s  0\n", kind->word, "-", "");
    }
    for (int k = 0; k < kind->freedom; ++k) {
      int c = joint->first_coordinate + k;
      km_text_add(out, "  ");
      padded(model->coordinates[c].label, width, out);
      km_text_format(out, "  %-11s  %12.6g %-4s  %.6f%s\n", kind->word, km_state_coordinate(s, c),
                     km_model_coordinate_unit(model, c), km_mobility_number(s, c), m->held[c] ? "  (held)" : "");
    }
  }
}

void km_mobility_print(const km_mechanism *m, const km_state *s, const km_mobility *mobility, const char *name,
                       km_text *out) {
  const km_model *model = m->model;
  const km_topology *t = &m->topology;
  km_text_format(out, "%s: %d bod%s, %d joint%s with %d coordinate%s, %d loop%s, %d substructure%s\n", name,
                 model->body_count - 1, model->body_count == 2 ? "y" : "ies", model->joint_count,
                 plural(model->joint_count), model->coordinate_count, plural(model->coordinate_count), t->loop_count,
                 plural(t->loop_count), t->substructure_count, plural(t->substructure_count));
  km_text_format(out, "mobility %d at this pose (Kutzbach %d, extended Kutzbach %d), %d redundant constraint%s\n",
                 mobility->mobility, mobility->kutzbach, mobility->kutzbach_extended, mobility->redundant_constraints,
                 plural(mobility->redundant_constraints));
  km_text_format(out, "loops closed to %.2g, characteristic length %g %s\n", mobility->residual,
                 model->characteristic_length, model->units.length->suffix);
  if (t->loop_count)
    km_text_add(out, "\nloops\n");
  print_loops(m, out);
  if (t->substructure_count)
    km_text_add(out, "\nsubstructures\n");
  print_substructures(m, s, out);
  if (model->joint_count)
    km_text_add(out, "\n");
  if (model->joint_count)
    print_coordinates(m, s, out);
}

static void stop_reason(const km_mechanism *m, const km_reach *reach, km_text *out) {
  const km_model *model = m->model;
  if (reach->stop == KM_STOP_LIMIT) {
    km_text_format(out, "joint %s is at its limit", model->coordinates[reach->coordinate].label);
    return;
  }
  km_text_format(out, "the driver is at a toggle: it can't move substructure %d (joints", reach->substructure + 1);
  print_joints(m, reach->substructure, out);
  km_text_add(out, ") any further");
}

void km_sweep_stop_text(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep,
                        km_text *out) {
  bool by_length = plan->arclength > 0.0;
  if (sweep->start.stop) {
    km_text_add(out, "FROM is out of reach; located bound ");
    km_text_number(out, sweep->start.position);
    km_text_add(out, ": ");
    stop_reason(m, &sweep->start, out);
  }
  if (by_length && plan->cycle && sweep->cycle == 0.0 && !sweep->end.stop)
    km_text_add(out, "the motion doesn't come back to its start in so many rows");
  if (!sweep->end.stop || (sweep->start.stop && km_table_rows(sweep->table) == 1))
    return;
  if (sweep->start.stop)
    km_text_add(out, "; ");
  km_text_add(out, by_length ? "the motion ends at arc length " : "TO is out of reach; located end ");
  km_text_number(out, sweep->end.position);
  km_text_add(out, ": ");
  if (by_length && sweep->end.stop == KM_STOP_TOGGLE)
    km_text_add(out, sweep->end.position > 0.0 ? "no further step can be found" : "no loop moves at this pose");
  else
    stop_reason(m, &sweep->end, out);
}

/* The next best driver after the one of the given rank, by smallest number; ties in file order. */
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

/* " mm", or nothing for an arc length. */
static const char *s_unit(const km_mechanism *m, const km_sweep_plan *plan) {
  static const char *const units[] = {" rad", " deg", " m", " mm", " cm", " in"};
  for (size_t i = 0; i < sizeof units / sizeof *units && plan->arclength <= 0.0; ++i)
    if (strcmp(units[i] + 1, km_model_coordinate_unit(m->model, plan->coordinate)) == 0)
      return units[i];
  return "";
}

static void print_drivers(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep, int width,
                          km_text *out) {
  enum { MOST_NAMED = 10 };
  int found = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    found += km_sweep_drives(m, sweep, c);
  km_text_add(out, sweep->freedom > 1 ? "  keep their grip over the whole range:" : "  could drive the whole range:");
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
  const char *unit = s_unit(m, plan);
  for (int c = 0; c < m->coordinate_count; ++c) {
    int count = 0;
    for (size_t i = 0; i < sweep->toggle_count; ++i) {
      if (sweep->toggles[i].coordinate != c)
        continue;
      if (count++ == 0) {
        km_text_add(out, "  ");
        padded(m->model->coordinates[c].label, width, out);
        km_text_add(out, " loses its grip at");
      }
      km_text_format(out, "%s %.6g%s", count > 1 ? "," : "", sweep->toggles[i].s, unit);
    }
    if (count)
      km_text_add(out, "\n");
  }
}

static void print_cycle(const km_mobility_sweep *sweep, const km_sweep_plan *plan, km_text *out) {
  if (sweep->cycle > 0.0)
    km_text_format(out, "  the cycle closes at %.9g\n", sweep->cycle);
  else if (plan->cycle)
    km_text_add(out, "  the cycle isn't closed\n");
  for (size_t i = 0; i < sweep->branch_count; ++i)
    km_text_format(out, "  branch point at %.9g: mobility %d there, %d motions meet; %s\n", sweep->branches[i].s,
                   sweep->branches[i].mobility, sweep->branches[i].branches,
                   i == 0 && plan->branch > 1 ? "turned there" : "the smooth one was followed");
}

void km_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_mobility_sweep *sweep, const char *name,
                    km_text *out) {
  bool by_length = plan->arclength > 0.0;
  const char *label = by_length ? "arc length" : m->model->coordinates[plan->coordinate].label;
  size_t rows = km_table_rows(sweep->table);
  int s_column = km_table_find(sweep->table, "s");
  const double *first = km_table_row(sweep->table, 0), *last = km_table_row(sweep->table, rows - 1);
  km_text_format(out, "%s: %s from %.6g to %.6g%s, %zu row%s\n", name, label, first[s_column], last[s_column],
                 s_unit(m, plan), rows, rows == 1 ? "" : "s");
  km_text_format(out, "  mobility %d (Kutzbach %d), %d redundant constraint%s, loops closed to %.2g\n",
                 sweep->first.mobility, sweep->first.kutzbach, sweep->first.redundant_constraints,
                 plural(sweep->first.redundant_constraints), sweep->first.residual);
  print_cycle(sweep, plan, out);
  if (sweep->substructure >= 0)
    print_drivers(m, plan, sweep, widest_label(m->model), out);
  else if (plan->arclength <= 0.0)
    km_text_format(out, "  %s is in no loop: it drives itself, and every mobility number stays as it is\n", label);
}
