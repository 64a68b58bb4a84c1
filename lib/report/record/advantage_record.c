/* Mechanical advantage, at a pose and over a sweep, as a record and as text. */
#include "report/record/advantage_record.h"

#include "base/table.h"
#include "kinematics/state.h"

#include "report/record/sweep_text.h"
#include "report/record/transmission_record.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

static void add_losses(const km_losses *losses, const km_advantage *a, km_value *record, km_arena *arena) {
  km_value *item = km_value_add(arena, record, "force_ratio", KM_OBJECT);
  km_value_number(arena, item, "ideal", a->value);
  km_value_number(arena, item, "actual", losses->ratio);
  km_value_number(arena, item, "efficiency", losses->efficiency);
  if (losses->why)
    km_value_string(arena, item, "undefined", losses->why);
  km_value_boolean(arena, item, "locks_itself", losses->locks);
  if (losses->locks)
    km_value_number(arena, item, "locks_from", losses->locks_from);
}

/* True if a port refers to an element of this mechanism. */
static bool fits(const km_mechanism *m, const km_port *h) {
  return h->name && (h->kind != KM_PORT_JOINT || (h->coordinate >= 0 && h->coordinate < m->coordinate_count));
}

km_value *km_advantage_record(const km_mechanism *m, const km_state *s, const km_port *input, const km_port *output,
                              const km_advantage *a, const km_transmission *t, const km_losses *losses,
                              const char *name, km_arena *arena) {
  if (km_check_state(m, s, NULL) || !input || !output || !a || !t || !losses || !name || !arena || !fits(m, input) ||
      !fits(m, output))
    return NULL;
  km_value *record = km_record_head(m, "kma", name, arena);
  const char *unit = km_advantage_unit(m->model, input, output);
  km_value_string(arena, record, "input", input->name);
  km_value_string(arena, record, "output", output->name);
  km_value_number(arena, record, "mechanical_advantage", a->value);
  km_value_number(arena, record, "velocity_ratio", a->velocity_ratio);
  km_value_string(arena, record, "state", km_advantage_state_name(a->state));
  km_value_string(arena, record, "method", km_advantage_method_name(a->method));
  if (unit[0])
    km_value_string(arena, record, "unit", unit);
  else
    km_value_add(arena, record, "unit", KM_NULL);
  add_losses(losses, a, record, arena);
  km_transmission_record(m, t, output, record, arena);
  km_held_record(m, record, arena);
  km_configuration_record(m, s, record, arena);
  return arena->failed ? NULL : record;
}

void km_advantage_words(const km_mechanism *m, const km_port *input, const km_port *output, const km_advantage *a,
                        km_text *out) {
  const char *unit = km_advantage_unit(m->model, input, output);
  switch (a->state) {
  case KM_ADVANTAGE_FINITE:
    km_text_format(out, "mechanical advantage %.9g%s%s", a->value, unit[0] ? " " : "", unit);
    break;
  case KM_ADVANTAGE_ZERO:
    km_text_format(out, "mechanical advantage 0: %s stands while %s moves (a dead point)", input->name, output->name);
    break;
  case KM_ADVANTAGE_INFINITE:
    km_text_format(out, "mechanical advantage infinite: %s stands while %s moves (a dead point)", output->name,
                   input->name);
    break;
  default:
    km_text_format(out, "mechanical advantage undefined: neither %s nor %s moves", input->name, output->name);
  }
}

void km_advantage_print(const km_mechanism *m, const km_port *input, const km_port *output, const km_advantage *a,
                        const km_transmission *t, const km_losses *losses, const char *name, km_text *out) {
  if (!m || !input || !output || !a || !t || !losses || !name || !out || !fits(m, input) || !fits(m, output))
    return;
  const char *unit = km_advantage_unit(m->model, output, input);
  km_text_format(out, "%s: %s over %s\n  ", name, input->name, output->name);
  km_advantage_words(m, input, output, a, out);
  km_text_add(out, "\n");
  if (a->state == KM_ADVANTAGE_FINITE)
    km_text_format(out, "  velocity ratio %.9g%s%s: the rate of %s over that of %s\n", a->velocity_ratio,
                   unit[0] ? " " : "", unit, output->name, input->name);
  if (a->state != KM_ADVANTAGE_UNDEFINED)
    km_text_add(out, a->method == KM_ADVANTAGE_SINGLE_FREEDOM
                         ? "  one freedom: the input moves in one way only\n"
                         : "  several freedoms: the others move least (--hold keeps joints)\n");
  int held = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->held[c])
      km_text_format(out, "%s %s", held++ ? "," : "  held:", m->model->coordinates[c].label);
  km_text_add(out, held ? "\n" : "");
  if (losses->locks)
    km_text_format(out, "  with friction it locks itself: no input force is enough from %.4g of this friction on\n",
                   losses->locks_from);
  else if (!losses->why)
    km_text_format(out, "  with friction the force ratio is %.6g: efficiency %.4g\n", losses->ratio,
                   losses->efficiency);
  else if (a->state == KM_ADVANTAGE_FINITE && km_model_has_friction(m->model))
    km_text_format(out, "  with friction: %s\n", losses->why);
  km_transmission_print(m, t, output, out);
}

static void add_peak(km_value *record, const char *key, const km_peak *peak, km_arena *arena) {
  km_value *item = km_value_add(arena, record, key, KM_OBJECT);
  km_value_number(arena, item, "value", peak->value);
  km_value_number(arena, item, "s", peak->s);
  if (isnan(peak->s))
    km_value_string(arena, item, "state", "undefined");
  else
    km_value_string(arena, item, "state", isfinite(peak->value) ? "finite" : "infinite");
}

km_value *km_advantage_sweep_record(const km_mechanism *m, const km_advantage_sweep *sweep, const char *stopped_by,
                                    const char *name, km_arena *arena) {
  km_value *record = km_record_head(m, "kma", name, arena);
  km_value_string(arena, record, "input", sweep->input.name);
  km_value_string(arena, record, "output", sweep->output.name);
  km_value_string(arena, record, "method", km_advantage_method_name(sweep->method));
  km_table_record(sweep->motion.table, record, arena);
  km_value *toggles = km_value_add(arena, record, "toggles", KM_LIST);
  for (size_t i = 0; i < sweep->toggle_count && !arena->failed; ++i) {
    km_value *toggle = km_value_add(arena, toggles, NULL, KM_OBJECT);
    km_value_string(arena, toggle, "state", km_advantage_state_name(sweep->toggles[i].state));
    km_value_number(arena, toggle, "s", sweep->toggles[i].s);
  }
  add_peak(record, "minimum", &sweep->lowest, arena);
  add_peak(record, "maximum", &sweep->highest, arena);
  add_peak(record, "least_size", &sweep->least, arena);
  km_value_number(arena, record, "end_over_start", km_progression(sweep));
  km_held_record(m, record, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}

static void print_state(const km_advantage_sweep *sweep, km_advantage_state state, const char *words,
                        const char *s_unit, km_text *out) {
  int count = 0;
  for (size_t i = 0; i < sweep->toggle_count; ++i)
    if (sweep->toggles[i].state == state)
      km_text_format(out, "%s %.6g%s", count++ ? "," : words, sweep->toggles[i].s, s_unit);
  km_text_add(out, count ? "\n" : "");
}

static int count_poles(const km_advantage_sweep *sweep) {
  int count = 0;
  for (size_t i = 0; i < sweep->toggle_count; ++i)
    count += sweep->toggles[i].state == KM_ADVANTAGE_INFINITE;
  return count;
}

double km_progression(const km_advantage_sweep *sweep) {
  const km_table *t = sweep->motion.table;
  const double start = km_table_row(t, 0)[sweep->column], end = km_table_row(t, km_table_rows(t) - 1)[sweep->column];
  return start != 0.0 && isfinite(start) && isfinite(end) ? end / start : nan("");
}

void km_progression_words(const km_advantage_sweep *sweep, km_text *out) {
  const double ratio = km_progression(sweep);
  if (!isfinite(ratio))
    return;
  km_text_format(out, " (end/start %.4g", ratio);
  if (ratio > 0.0)
    km_text_format(out, ": %s by %.3g %%", ratio < 1.0 ? "falls" : "rises", 100.0 * fabs(ratio - 1.0));
  km_text_add(out, ")");
}

/* Its extremes, or where it grows without bound its least size. */
static void print_range(const km_advantage_sweep *sweep, const char *s_unit, km_text *out) {
  const km_peak *low = &sweep->lowest, *high = &sweep->highest, *least = &sweep->least;
  int poles = count_poles(sweep);
  if (isnan(low->s)) {
    km_text_add(out, " nowhere finite");
  } else if (!poles) {
    const km_table *t = sweep->motion.table;
    km_text_format(out, " %.6g at the start, %.6g at the end", km_table_row(t, 0)[sweep->column],
                   km_table_row(t, km_table_rows(t) - 1)[sweep->column]);
    km_progression_words(sweep, out);
    km_text_format(out, "; least %.6g at %.6g%s, greatest %.6g at %.6g%s\n", low->value, low->s, s_unit, high->value,
                   high->s, s_unit);
    return;
  } else {
    km_text_format(out, " its size is at least %.6g at %.6g%s and", fabs(least->value), least->s, s_unit);
  }
  print_state(sweep, KM_ADVANTAGE_INFINITE,
              poles > 1 ? " grows without bound at the dead points at" : " grows without bound at the dead point at",
              s_unit, out);
  km_text_add(out, poles ? "" : "\n");
}

static const char prefix[] = "transmission."; /* beginning of the columns with the angles of hinges */

/* True if the joint connects the link that the input turns. */
static bool is_at_input(const km_mechanism *m, const km_port *input, int joint) {
  const km_model *model = m->model;
  if (input->kind != KM_PORT_JOINT)
    return false;
  const km_model_joint *driver = &model->joints[model->coordinates[input->coordinate].joint];
  for (int side = 0; side < 2; ++side)
    for (int end = 0; end < 2; ++end) {
      const int body = model->frames[driver->frame[side]].body;
      if (body != 0 && body == km_joint_body(model, joint, end))
        return true;
    }
  return false;
}

const char *km_transmission_hinge(const km_mechanism *m, const km_advantage_sweep *sweep, size_t column) {
  static const double least_degrees = 1.0; /* a hinge that stays below has no load to pass on */
  const km_table *t = sweep->motion.table;
  const char *name = km_table_name(t, column);
  const double degree = M_PI / 180.0 / m->model->units.angle->si;
  if (strncmp(name, prefix, sizeof prefix - 1) != 0)
    return NULL;
  const char *label = name + sizeof prefix - 1;
  for (int j = 0; j < m->model->joint_count; ++j)
    if (strcmp(m->model->joints[j].label, label) == 0 && is_at_input(m, &sweep->input, j))
      return NULL;
  const size_t row = km_table_extreme_row(t, column, -1.0);
  return row < km_table_rows(t) && km_table_row(t, row)[column] > least_degrees * degree ? label : NULL;
}

/* Least transmission angle of each hinge over the rows. */
static void print_hinges(const km_mechanism *m, const km_advantage_sweep *sweep, const char *s_unit, km_text *out) {
  const km_table *t = sweep->motion.table;
  int count = 0, s = km_table_find(t, "s");
  for (size_t c = 0; c < km_table_columns(t) && s >= 0; ++c) {
    const char *hinge = km_transmission_hinge(m, sweep, c);
    const size_t row = hinge ? km_table_extreme_row(t, c, 1.0) : km_table_rows(t);
    if (row == km_table_rows(t))
      continue;
    km_text_add(out, count++ ? ";" : "  least transmission angles of the hinges:");
    km_text_format(out, " %s %.4g %s at %.6g%s", hinge, km_table_row(t, row)[c], km_table_unit(t, c),
                   km_table_row(t, row)[s], s_unit);
  }
  km_text_add(out, count ? "\n" : "");
}

void km_advantage_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_advantage_sweep *sweep,
                              const char *name, km_text *out) {
  const char *unit = km_advantage_unit(m->model, &sweep->input, &sweep->output), *s_unit = km_sweep_unit(m, plan);
  km_sweep_print(m, plan, &sweep->motion, name, out);
  km_text_format(out, "  mechanical advantage of %s over %s%s%s%s:", sweep->input.name, sweep->output.name,
                 unit[0] ? " (" : "", unit, unit[0] ? ")" : "");
  print_range(sweep, s_unit, out);
  print_hinges(m, sweep, s_unit, out);
  if (sweep->method == KM_ADVANTAGE_LEAST_MOTION && sweep->motion.freedom - sweep->motion.passive > 1)
    km_text_add(out, "  several freedoms: the others move least (--hold keeps joints)\n");
  print_state(sweep, KM_ADVANTAGE_ZERO, "  zero at", s_unit, out);
  print_state(sweep, KM_ADVANTAGE_UNDEFINED, "  undefined at", s_unit, out);
}
