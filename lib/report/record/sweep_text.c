/* Text common to all sweeps, and text shared by reports. */
#include "report/record/sweep_text.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kmech/mobility.h"
#include "topology/mechanism.h"

#include <string.h>

const char *km_plural(int count) {
  return count == 1 ? "" : "s";
}

/* A label padded to a width counted in characters, not bytes. */
void km_text_padded(const char *label, int width, km_text *out) {
  int shown = 0;
  for (const char *c = label; *c; ++c)
    shown += ((unsigned char)*c & 0xC0) != 0x80;
  km_text_add(out, label);
  for (; shown < width; ++shown)
    km_text_add(out, " ");
}

int km_widest_label(const km_model *model) {
  int width = 5;
  for (int c = 0; c < model->coordinate_count; ++c) {
    int length = (int)strlen(model->coordinates[c].label);
    if (length > width && length < 40)
      width = length;
  }
  return width;
}

void km_joints_print(const km_mechanism *m, int substructure, km_text *out) {
  const km_topology *t = &m->topology;
  for (int k = t->joint_start[substructure]; k < t->joint_start[substructure + 1]; ++k)
    km_text_format(out, " %s", m->model->joints[t->joint[k]].label);
}

/* " with A, B held", as far as they lie in the substructure. */
static void held_words(const km_mechanism *m, int substructure, km_text *out) {
  int count = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->held[c] && m->substructure_of[c] == substructure)
      km_text_format(out, "%s%s", count++ ? ", " : " with ", m->model->coordinates[c].label);
  if (count)
    km_text_add(out, " held");
}

const char *km_sweep_unit(const km_mechanism *m, const km_sweep_plan *plan) {
  if (!m || !plan ||
      (plan->arclength <= 0.0 && km_check_index(plan->coordinate, m->coordinate_count, "coordinate", NULL)))
    return "";
  static const char *const units[] = {" rad", " deg", " m", " mm", " cm", " in"};
  for (size_t i = 0; i < sizeof units / sizeof *units && plan->arclength <= 0.0; ++i)
    if (strcmp(units[i] + 1, km_model_coordinate_unit(m->model, plan->coordinate)) == 0)
      return units[i];
  return "";
}

/* Element with the limit: for a ball joint its angle, not one of its coordinates. */
static const char *limited(const km_model *model, int c) {
  const km_model_joint *joint = &model->joints[model->coordinates[c].joint];
  return joint->most_turn > 0.0 ? joint->label : model->coordinates[c].label;
}

static void stop_reason(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep,
                        const km_motion_end *reach, int side, km_text *out) {
  if (reach->stop == KM_STOP_LIMIT) {
    km_text_format(out, "joint %s is at its limit", limited(m->model, reach->coordinate));
  } else if (reach->stop == KM_STOP_UNBOUNDED) {
    km_text_format(out, "%s slides away without bound", m->model->coordinates[reach->coordinate].label);
  } else if (sweep->freedom == 0) {
    km_text_add(out, "nothing can move, joints");
    km_joints_print(m, reach->substructure, out);
    km_text_add(out, " have no freedom");
    held_words(m, reach->substructure, out);
  } else if (sweep->rank_value[side] > 0.0) {
    km_text_format(out,
                   "the rank of substructure %d changes within the closure tolerance %g (singular value %.2g of the "
                   "largest one), which is no dead point; state a smaller tolerance, or more digits",
                   reach->substructure + 1, m->closure_tolerance, sweep->rank_value[side]);
  } else {
    const char *cause = sweep->causes[side];
    km_text_format(out, "%s is at a dead point%s%s", m->model->coordinates[plan->coordinate].label, cause ? ": " : "",
                   cause ? cause : "");
  }
}

/* The end of the motion towards FROM; with one row nothing of the range came after it. */
static void print_start(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, km_text *out) {
  bool reached = km_table_rows(sweep->table) > 1;
  km_text_format(
      out, reached ? "started at %.6g%s instead of %.6g: " : "stopped at %.6g%s, on the way to the range (%.6g): ",
      sweep->start.position, km_sweep_unit(m, plan), plan->from);
  stop_reason(m, plan, sweep, &sweep->start, 0, out);
}

static void print_end(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, km_text *out) {
  if (plan->arclength <= 0.0) {
    km_text_format(out, "stopped at %.6g%s, before the end of the range (%.6g): ", sweep->end.position,
                   km_sweep_unit(m, plan), plan->to);
    stop_reason(m, plan, sweep, &sweep->end, 1, out);
    return;
  }
  km_text_format(out, "the motion ends at arc length %.6g: ", sweep->end.position);
  if (sweep->end.stop == KM_STOP_TOGGLE)
    km_text_add(out, sweep->end.position > 0.0 ? "no further step can be found" : "no loop moves at this pose");
  else
    stop_reason(m, plan, sweep, &sweep->end, 1, out);
}

/* True if all elements named by the motion's end belong to this mechanism. */
static bool fits(const km_mechanism *m, const km_sweep_plan *plan, const km_motion_end *reach) {
  bool follows = plan->arclength > 0.0;
  bool driven = follows || (plan->coordinate >= 0 && plan->coordinate < m->coordinate_count);
  bool names = reach->stop == KM_STOP_LIMIT || reach->stop == KM_STOP_UNBOUNDED;
  bool limit = !names || (reach->coordinate >= 0 && reach->coordinate < m->coordinate_count);
  bool toggle = reach->stop != KM_STOP_TOGGLE || follows || reach->substructure < m->topology.substructure_count;
  return driven && limit && toggle;
}

void km_sweep_stop_text(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, km_text *out) {
  if (!m || !plan || !sweep || !out || !fits(m, plan, &sweep->start) || !fits(m, plan, &sweep->end))
    return;
  if (sweep->start.stop)
    print_start(m, plan, sweep, out);
  if (plan->arclength > 0.0 && plan->cycle && sweep->cycle == 0.0 && !sweep->end.stop)
    km_text_add(out, "the motion doesn't come back to its start in so many rows");
  if (!sweep->end.stop || (sweep->start.stop && km_table_rows(sweep->table) == 1))
    return;
  if (sweep->start.stop)
    km_text_add(out, "; ");
  print_end(m, plan, sweep, out);
}

static void print_branch(const km_branch_point *point, const char *taken, km_text *out) {
  km_text_format(out, "  branch point at %.9g: mobility %d there, ", point->s, point->mobility);
  if (point->branches >= KM_MAX_BRANCHES)
    km_text_format(out, "several motions meet; %s\n", taken);
  else if (point->branches > 0)
    km_text_format(out, "%d motions meet; %s\n", point->branches, taken);
  else
    km_text_format(out, "the motions that meet weren't found; %s\n", taken);
}

static void print_cycle(const km_sweep *sweep, const km_sweep_plan *plan, km_text *out) {
  if (sweep->cycle > 0.0)
    km_text_format(out, "  the cycle closes at %.9g\n", sweep->cycle);
  else if (plan->cycle)
    km_text_add(out, "  the cycle isn't closed\n");
  for (size_t i = 0; i < sweep->branch_count; ++i)
    print_branch(&sweep->branches[i], i == 0 && plan->branch > 1 ? "turned there" : "the smooth one was followed", out);
}

/* True if everything moves in one plane; marks a text without memory. */
static bool is_planar(const km_mechanism *m, km_text *out) {
  km_state *s = NULL;
  double normal[3];
  if (km_state_create(m, &s, NULL)) {
    out->failed = true;
    return false;
  }
  km_poses_compute(m, s);
  bool planar = km_mechanism_plane(m, s, normal);
  km_state_free(s);
  return planar;
}

void km_sweep_print_range(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, const char *name,
                          km_text *out) {
  bool by_length = plan->arclength > 0.0;
  const char *label = by_length ? "arc length" : m->model->coordinates[plan->coordinate].label;
  size_t rows = km_table_rows(sweep->table);
  int s_column = km_table_find(sweep->table, "s");
  const double *first = km_table_row(sweep->table, 0), *last = km_table_row(sweep->table, rows - 1);
  km_text_format(out, "%s: %s from %.6g to %.6g%s, %zu row%s\n", name, label, first[s_column], last[s_column],
                 km_sweep_unit(m, plan), rows, rows == 1 ? "" : "s");
}

void km_mobility_words(const km_mechanism *m, const km_sweep *sweep, km_text *out) {
  const km_mobility *first = &sweep->first;
  km_text_format(out, "%d", first->mobility);
  if (sweep->passive)
    km_text_format(out, " = %d + %d idle", first->mobility - sweep->passive, sweep->passive);
  if (is_planar(m, out))
    km_text_format(out, " (planar count %d)", first->kutzbach_planar);
  else
    km_text_format(out, " (Kutzbach %d), %d redundant constraint%s", first->kutzbach, first->redundant_constraints,
                   km_plural(first->redundant_constraints));
}

void km_sweep_print_mobility(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, km_text *out) {
  km_text_add(out, "  mobility ");
  km_mobility_words(m, sweep, out);
  km_text_format(out, ", loops closed to %.2g\n", sweep->first.residual);
  print_cycle(sweep, plan, out);
}

void km_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, const char *name,
                    km_text *out) {
  km_sweep_print_range(m, plan, sweep, name, out);
  km_sweep_print_mobility(m, plan, sweep, out);
}

/* Swings below this size, in radians or characteristic lengths, are rounding. */
static const double at_rest = 1e-9;

bool km_swing_print(const km_mechanism *m, const km_sweep_plan *plan, const km_swing *swing, int width, km_text *out) {
  const km_model *model = m->model;
  int c = swing->coordinate;
  double size = swing->high - swing->low;
  const char *unit = km_model_coordinate_unit(model, c), *s_unit = km_sweep_unit(m, plan);
  const char *driver = plan->arclength > 0.0 ? "s" : km_model_coordinate_label(model, plan->coordinate);
  if (!(size * m->factor[c] * m->scale[c] > at_rest) || m->held[c])
    return false;
  km_text_add(out, "  ");
  km_text_padded(model->coordinates[c].label, width, out);
  if (swing->goes_round)
    km_text_add(out, " goes round");
  else
    km_text_format(out, " %s by %.5g %s: %.5g at %s = %.5g%s to %.5g at %s = %.5g%s",
                   km_coordinate_turns(m, c) ? "swings" : "moves", size, unit, swing->low, driver, swing->s_low, s_unit,
                   swing->high, driver, swing->s_high, s_unit);
  return true;
}
