/* Record and summary of an allowance: misfits of redundant constraints, and the play that they need. */
#include "report/record/sweep_text.h"

#include "allowance/joint_fits.h"
#include "base/table.h"
#include "report/record/diagnosis_record.h"
#include "report/record/record.h"
#include "topology/mechanism.h"

#include <math.h>

static const char *const components[6] = {"along x", "along y", "along z", "about x", "about y", "about z"};

static double angle_of(const km_mechanism *m, double radians) {
  return radians / m->model->units.angle->si;
}

static void add_peak(km_value *item, const char *name, const char *place, const km_peak *peak, double unit,
                     km_arena *arena) {
  km_value_number(arena, item, name, peak->value / unit);
  km_value_number(arena, item, place, peak->s);
}

static bool is_angle(const km_allowance_constraint *c) {
  return c->joint >= 0 && c->component >= 3;
}

static double unit_of(const km_mechanism *m, const km_allowance_constraint *c) {
  return is_angle(c) ? m->model->units.angle->si : 1.0;
}

static void add_constraint(const km_mechanism *m, const km_allowance_constraint *c, km_value *list, km_arena *arena) {
  km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
  if (c->joint >= 0) {
    km_value_string(arena, item, "joint", m->model->joints[c->joint].label);
    km_value_string(arena, item, "component", components[c->component]);
  } else {
    km_value_number(arena, item, "coupling", c->component + 1);
  }
  add_peak(item, "worst", "worst_at", &c->worst, unit_of(m, c), arena);
  add_peak(item, "statistical", "statistical_at", &c->statistical, unit_of(m, c), arena);
}

static void add_joint(const km_mechanism *m, const km_allowance_joint *j, km_value *list, km_arena *arena) {
  km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
  km_value_string(arena, item, "joint", m->model->joints[j->joint].label);
  km_value_number(arena, item, "alone_worst", j->alone_worst);
  km_value_number(arena, item, "alone_statistical", j->alone_statistical);
  km_value_number(arena, item, "play_share", j->play_share);
  km_value_number(arena, item, "error_share", j->error_share);
  if (isnan(j->force_worst))
    return;
  km_value_number(arena, item, "force_worst", j->force_worst);
  km_value_number(arena, item, "force_statistical", j->force_statistical);
  km_value_number(arena, item, "moment_worst", j->moment_worst);
  km_value_number(arena, item, "moment_statistical", j->moment_statistical);
}

km_value *km_allowance_sweep_record(const km_mechanism *m, const km_allowance_sweep *sweep, const char *stopped_by,
                                    const char *name, km_arena *arena) {
  km_value *record = km_record_head(m, "kmob allowance", name, arena);
  km_table_record(sweep->motion.table, record, arena);
  const km_fit_defaults *d = &sweep->defaults;
  const double tolerance[2] = {d->position, angle_of(m, d->direction)}, play[2] = {d->play, angle_of(m, d->angle)};
  km_value_numbers(arena, record, "tolerance", tolerance, 2);
  km_value_numbers(arena, record, "clearance", play, 2);
  km_value_boolean(arena, record, "states_clearance", sweep->states_clearance);
  if (sweep->constraint_count > 0) {
    add_peak(record, "worst", "worst_at", &sweep->worst, 1.0, arena);
    add_peak(record, "statistical", "statistical_at", &sweep->statistical, 1.0, arena);
  }
  km_value *constraints = km_value_add(arena, record, "constraints", KM_LIST);
  for (int i = 0; i < sweep->constraint_count && !arena->failed; ++i)
    add_constraint(m, &sweep->constraints[i], constraints, arena);
  km_value *joints = km_value_add(arena, record, "joints", KM_LIST);
  for (int i = 0; i < sweep->joint_count && !arena->failed; ++i)
    add_joint(m, &sweep->joints[i], joints, arena);
  km_value *set = km_value_add(arena, record, "play_in", KM_OBJECT),
           *names = km_value_add(arena, set, "joints", KM_LIST);
  for (int i = 0; i < sweep->set_count && !arena->failed; ++i)
    km_value_string(arena, names, NULL, m->model->joints[sweep->set[i]].label);
  km_value_number(arena, set, "worst", sweep->set_worst);
  km_value_number(arena, set, "statistical", sweep->set_statistical);
  if (sweep->constraint_count > 0)
    km_remedy_set_record(m, &sweep->remedies, record, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}

/* "0.24 mm and 0.24 deg", or "2.4 times the play": a multiple of the play that the joints have. */
static void play_words(const km_mechanism *m, const km_allowance_sweep *sweep, double ratio, km_text *out) {
  if (!isfinite(ratio))
    km_text_add(out, "no play is enough");
  else if (sweep->states_clearance)
    km_text_format(out, "%.3g times the play", ratio);
  else
    km_text_format(out, "%.3g %s and %.3g %s", ratio * sweep->defaults.play, m->model->units.length->suffix,
                   angle_of(m, ratio * sweep->defaults.angle), m->model->units.angle->suffix);
}

/* Ratio from which the search for the largest one, right to 6 %, can't exclude 1. */
static const double nearly_used = 0.94;

static void print_need(const km_mechanism *m, const km_sweep_plan *plan, const km_allowance_sweep *sweep,
                       km_text *out) {
  if (!isfinite(sweep->worst.value)) {
    km_text_add(out, isnan(sweep->worst.value) ? "" : "  no play in these joints takes up the errors: it can bind\n");
    return;
  }
  km_text_add(out, sweep->states_clearance ? "  worst case: errors need " : "  every joint needs a play of ");
  play_words(m, sweep, sweep->worst.value, out);
  km_text_format(out, "%s (%.6g%s)", sweep->states_clearance ? "" : " in the worst case", sweep->worst.s,
                 km_sweep_unit(m, plan));
  if (sweep->states_clearance)
    km_text_add(out, sweep->worst.value > 1.0           ? ": it can bind"
                     : sweep->worst.value > nearly_used ? ": hardly any play is left"
                                                        : ": it can't bind");
  if (isfinite(sweep->statistical.value)) {
    km_text_add(out, sweep->states_clearance ? "\n  99.73 % of the mechanisms, at one position: at most " : ", ");
    play_words(m, sweep, sweep->statistical.value, out);
    km_text_add(out, sweep->states_clearance ? "" : " for 99.73 % of the mechanisms at one position");
  }
  km_text_add(out, "\n");
}

static void print_set(const km_mechanism *m, const km_allowance_sweep *sweep, km_text *out) {
  if (sweep->set_count == 0 || !isfinite(sweep->set_worst))
    return;
  km_text_add(out, "  play in");
  for (int i = 0; i < sweep->set_count; ++i)
    km_text_format(out, "%s %s",
                   i == 0                     ? ""
                   : i + 1 < sweep->set_count ? ","
                                              : " and",
                   m->model->joints[sweep->set[i]].label);
  km_text_add(out, " alone: ");
  play_words(m, sweep, sweep->set_worst, out);
  km_text_add(out, "; ");
  play_words(m, sweep, sweep->set_statistical, out);
  km_text_add(out, "\n");
}

static void print_gap(const km_mechanism *m, const km_sweep_plan *plan, const km_allowance_constraint *c, int width,
                      km_text *out) {
  km_text_add(out, "    ");
  if (c->joint >= 0) {
    km_text_padded(m->model->joints[c->joint].label, width, out);
    km_text_format(out, " %s", components[c->component]);
  } else {
    km_text_format(out, "coupling %d", c->component + 1);
  }
  if (isnan(c->worst.value)) {
    km_text_add(out, "  above a tenth of the size everywhere\n");
    return;
  }
  const char *unit = c->joint < 0 ? "" : is_angle(c) ? m->model->units.angle->suffix : m->model->units.length->suffix;
  km_text_format(out, "  %.3g %s (%.6g%s); %.3g %s\n", c->worst.value / unit_of(m, c), unit, c->worst.s,
                 km_sweep_unit(m, plan), c->statistical.value / unit_of(m, c), unit);
}

/* A joint's line: what it needs alone, its shares, and its forces without play. */
static void print_joint(const km_mechanism *m, const km_allowance_sweep *sweep, const km_allowance_joint *j, int width,
                        km_text *out) {
  km_text_add(out, "    ");
  km_text_padded(m->model->joints[j->joint].label, width, out);
  if (isfinite(j->play_share) && isfinite(j->error_share))
    km_text_format(out, "  %3.0f %% of the play, %3.0f %% of the errors", 100.0 * j->play_share,
                   100.0 * j->error_share);
  if (isfinite(j->alone_worst)) {
    km_text_add(out, "; alone ");
    play_words(m, sweep, j->alone_worst, out);
  }
  const char *force = m->model->units.force->suffix, *length = m->model->units.length->suffix;
  if (!isnan(j->force_worst))
    km_text_format(out, "; without play at most %.3g %s and %.3g %s %s, statistically %.3g %s and %.3g %s %s",
                   j->force_worst, force, j->moment_worst, force, length, j->force_statistical, force,
                   j->moment_statistical, force, length);
  km_text_add(out, "\n");
}

static bool states_tolerance(const km_model *model) {
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].fit.has_tolerance)
      return true;
  return false;
}

void km_allowance_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_allowance_sweep *sweep,
                              const char *name, km_text *out) {
  enum { MOST_SHOWN = 12 };
  const km_fit_defaults *d = &sweep->defaults;
  const int width = km_widest_label(m->model);
  km_sweep_print_range(m, plan, &sweep->motion, name, out);
  if (sweep->constraint_count == 0) {
    km_text_add(out, "  no constraint is redundant: it can be assembled whatever the errors of its parts\n");
    km_sweep_print_mobility(m, plan, &sweep->motion, out);
    return;
  }
  km_text_format(out, "  %d redundant constraint%s; errors of %.3g %s and %.3g %s of each joint on both bodies%s\n",
                 sweep->constraint_count, km_plural(sweep->constraint_count), d->position,
                 m->model->units.length->suffix, angle_of(m, d->direction), m->model->units.angle->suffix,
                 states_tolerance(m->model) ? ", or as stated" : "");
  if (sweep->defaults.states_play)
    km_text_format(out, "  play of %.3g %s and %.3g %s%s\n", d->play, m->model->units.length->suffix,
                   angle_of(m, d->angle), m->model->units.angle->suffix,
                   km_model_states_clearance(m->model) ? ", or as stated" : "");
  print_need(m, plan, sweep, out);
  print_set(m, sweep, out);
  km_text_add(out,
              "  gap at the joint that is assembled last: worst case; 99.73 % of the mechanisms at one position\n");
  for (int i = 0; i < sweep->constraint_count && i < MOST_SHOWN; ++i)
    print_gap(m, plan, &sweep->constraints[i], width, out);
  if (sweep->constraint_count > MOST_SHOWN)
    km_text_format(out, "    and %d more (--format json lists all)\n", sweep->constraint_count - MOST_SHOWN);
  km_text_add(out, "  shares of the joints at the most critical position\n");
  for (int i = 0; i < sweep->joint_count && i < MOST_SHOWN; ++i)
    print_joint(m, sweep, &sweep->joints[i], width, out);
  if (sweep->joint_count > MOST_SHOWN)
    km_text_format(out, "    and %d more (--format json lists all)\n", sweep->joint_count - MOST_SHOWN);
  km_sweep_print_mobility(m, plan, &sweep->motion, out);
  km_remedy_set_print(m, &sweep->remedies, out);
}
