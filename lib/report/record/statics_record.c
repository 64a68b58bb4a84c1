/* The balance of forces, at a pose and over a sweep, as a record and as text. */
#include "report/record/statics_record.h"

#include "kinematics/state.h"
#include "report/record/words/forces_text.h"

#include "report/record/sweep_text.h"
#include "statics/statics.h"
#include "topology/mechanism.h"

#include <math.h>

static void add_directions(const km_mechanism *m, const km_statics *st, km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "undetermined_directions", KM_LIST);
  for (int d = 0; d < st->direction_count && d < KM_MAX_DIRECTIONS && !arena->failed; ++d) {
    const double *rates = st->directions + (size_t)d * (size_t)m->coordinate_count;
    km_text words = {0};
    km_direction_words(m, st, d, &words);
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_boolean(arena, item, "falls", st->falls[d]);
    km_value_words(arena, item, "statement", &words);
    km_value *rate = km_value_add(arena, item, "direction", KM_OBJECT);
    for (int c = 0; c < m->coordinate_count; ++c)
      if (rates[c] != 0.0)
        km_value_number(arena, rate, m->model->coordinates[c].label, rates[c]);
  }
}

static bool has_contact_friction(const km_statics *st) {
  bool has_friction = false;
  for (int i = 0; i < st->contact_count; ++i)
    has_friction = has_friction || st->contacts[i].friction_limit > 0.0;
  return has_friction;
}

static void add_reactions(const km_mechanism *m, const km_statics *st, km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "reactions", KM_OBJECT);
  for (int j = 0; j < m->model->joint_count && !arena->failed; ++j) {
    const km_reaction *r = &st->reactions[j];
    km_value *item = km_value_add(arena, list, m->model->joints[j].label, KM_OBJECT);
    km_value_numbers(arena, item, "force", r->force, 3);
    km_value_numbers(arena, item, "torque", r->torque, 3);
    km_value *flags = km_value_add(arena, item, "indeterminate", KM_LIST);
    for (int k = 0; k < 6; ++k)
      km_value_boolean(arena, flags, NULL, r->indeterminate[k]);
  }
}

/* The actuators that must give more than their drives can. */
static void add_excess(const km_mechanism *m, const km_port *actuators, const double *force, size_t stride, int count,
                       km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "beyond_max_force", KM_LIST);
  for (int i = 0; i < count && !arena->failed; ++i)
    if (km_actuator_passes(m, &actuators[i], *(const double *)((const char *)force + (size_t)i * stride)))
      km_value_string(arena, list, NULL, actuators[i].name);
}

/* Forces of contacts and of stops that act, and the actuators' forces that hold with friction of the contacts. */
static void add_contacts(const km_statics *st, km_value *record, km_arena *arena) {
  km_value *list = st->contact_count ? km_value_add(arena, record, "contacts", KM_LIST) : NULL;
  for (int i = 0; i < st->contact_count && !arena->failed; ++i) {
    const km_contact_force *contact = &st->contacts[i];
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "name", contact->name);
    km_value_string(arena, item, "kind", contact->coordinate < 0 ? "contact" : "stop");
    km_value_number(arena, item, "penetration", contact->penetration);
    km_value_number(arena, item, "normal_force", contact->normal);
    km_value_number(arena, item, "friction_limit", contact->friction_limit);
  }
  if (!has_contact_friction(st))
    return;
  km_value *ranges = km_value_add(arena, record, "holding_range", KM_OBJECT);
  for (int i = 0; i < st->actuator_count && !arena->failed; ++i) {
    const double force = st->actuator_forces[i], range[2] = {force - st->friction[i], force + st->friction[i]};
    km_value_numbers(arena, ranges, st->actuators[i].name, range, 2);
  }
}

km_value *km_statics_record(const km_mechanism *m, const km_state *s, const km_statics *st, const char *name,
                            km_arena *arena) {
  if (km_check_state(m, s, NULL) || !st || !st->work || st->work->mechanism != m || !name || !arena)
    return NULL;
  km_value *record = km_record_head(m, "kstatic", name, arena);
  km_value_boolean(arena, record, "held", st->held);
  add_directions(m, st, record, arena);
  km_value *actuators = km_value_add(arena, record, "actuator_forces", KM_OBJECT);
  for (int i = 0; i < st->actuator_count && !arena->failed; ++i)
    km_value_number(arena, actuators, st->actuators[i].name, st->actuator_forces[i]);
  add_excess(m, st->actuators, st->actuator_forces, sizeof(double), st->actuator_count, record, arena);
  add_contacts(st, record, arena);
  km_value_string(arena, record, "actuator_set",
                  !st->held       ? "can't hold"
                  : st->redundant ? "redundant, least norm"
                                  : "unique");
  km_value *least = km_value_add(arena, record, "least_norm_forces", KM_OBJECT);
  for (int c = 0; c < m->coordinate_count && !arena->failed; ++c)
    km_value_number(arena, least, m->model->coordinates[c].label, st->least_norm[c]);
  km_value_string(arena, record, "axes", st->axes == KM_AXES_FIXED ? "fixed" : "joint");
  km_value_string(arena, record, "reactions_with", st->held ? "actuator_forces" : "least_norm_forces");
  add_reactions(m, st, record, arena);
  km_reactions_note_record(m->model, record, arena);
  km_value_number(arena, record, "degree_of_indeterminacy", st->degree);
  km_held_record(m, record, arena);
  km_configuration_record(m, s, record, arena);
  return arena->failed ? NULL : record;
}

/* The fastest joints of a motion, three at most. */
void km_direction_words(const km_mechanism *m, const km_statics *st, int direction, km_text *out) {
  if (!m || !st || !st->work || st->work->mechanism != m || !out || direction < 0 || direction >= st->direction_count ||
      direction >= KM_MAX_DIRECTIONS)
    return;
  enum { MOST_NAMED = 4 };
  const double *rates = st->directions + (size_t)direction * (size_t)m->coordinate_count;
  double last = HUGE_VAL;
  int last_coordinate = -1;
  for (int i = 0; i < MOST_NAMED; ++i) {
    int best = -1;
    double size = 0.0;
    for (int c = 0; c < m->coordinate_count; ++c) {
      double rate = fabs(rates[c] / m->unit[c]);
      bool after = rate < last || (rate == last && c > last_coordinate);
      if (after && rate > size && rate > 1e-3) {
        best = c;
        size = rate;
      }
    }
    if (best < 0)
      return;
    km_text_format(out, "%s%s by %.3g %s", i ? ", " : "", m->model->coordinates[best].label, rates[best],
                   km_model_coordinate_is_length(m->model, best) ? m->model->units.length->suffix : "rad");
    last = size;
    last_coordinate = best;
  }
  km_text_add(out, ", …");
}

static void print_force(const km_mechanism *m, const km_port *actuator, int width, double force, km_text *out) {
  km_text_add(out, "  ");
  km_text_padded(actuator->name, width, out);
  km_text_format(out, "  %14.6g ", force);
  km_push_unit(m->model, actuator, out);
  km_text_add(out, "\n");
}

static km_port joint_handle(const km_mechanism *m, int coordinate) {
  return (km_port){.kind = KM_PORT_JOINT, .coordinate = coordinate, .name = m->model->coordinates[coordinate].label};
}

static void print_directions(const km_mechanism *m, const km_statics *st, km_text *out) {
  for (int d = 0; d < st->direction_count && d < KM_MAX_DIRECTIONS; ++d) {
    km_text_add(out, st->falls[d] ? "  the loads move " : "  out of the actuators' reach, but not loaded: ");
    km_direction_words(m, st, d, out);
    km_text_add(out, "\n");
  }
}

/* Text tables show a component below this share of the largest as 0. */
static const double rounding = 1e-12;

/* Forces and torques below these are 0: rounding is all there is. */
typedef struct grains {
  double force, torque;
} grains;

static grains grains_of(const km_mechanism *m, const km_statics *st) {
  double force = 0.0, torque = 0.0, size = 0.0;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    size = fmax(size, m->substructures[i].size);
  for (int j = 0; j < m->model->joint_count; ++j)
    for (int k = 0; k < 3; ++k) {
      force = fmax(force, fabs(st->reactions[j].force[k]));
      torque = fmax(torque, fabs(st->reactions[j].torque[k]));
    }
  return (grains){rounding * force, rounding * (torque + size * force)};
}

static double shown_component(const km_reaction *r, grains grain, int k) {
  double value = k < 3 ? r->force[k] : r->torque[k - 3];
  return fabs(value) < (k < 3 ? grain.force : grain.torque) ? 0.0 : value;
}

static bool is_zero_everywhere(const km_mechanism *m, const km_statics *st, grains grain, int k) {
  for (int j = 0; j < m->model->joint_count; ++j)
    if (shown_component(&st->reactions[j], grain, k) != 0.0)
      return false;
  return true;
}

static void print_contact(const km_mechanism *m, const km_contact_force *contact, int width, km_text *out) {
  const int c = contact->coordinate;
  km_text_add(out, "  ");
  km_text_padded(contact->name, width, out);
  km_text_format(out, "  %14.6g ", contact->normal);
  if (c >= 0)
    km_force_unit(m->model, c, out);
  else
    km_text_add(out, m->model->units.force->suffix);
  if (c >= 0)
    km_text_format(out, ", %.6g %s beyond the joint's limit", contact->penetration,
                   km_model_coordinate_unit(m->model, c));
  else
    km_text_format(out, ", %s %.6g %s", contact->penetration > 0.0 ? "penetration" : "gap", fabs(contact->penetration),
                   m->model->units.length->suffix);
  if (contact->friction_limit > 0.0)
    km_text_format(out, ", friction up to %.6g %s", contact->friction_limit, m->model->units.force->suffix);
  km_text_add(out, "\n");
}

static void print_contacts(const km_mechanism *m, const km_statics *st, int width, km_text *out) {
  if (!st->contact_count)
    return;
  km_text_add(out, "\nnormal forces of contacts and stops\n");
  for (int i = 0; i < st->contact_count; ++i)
    print_contact(m, &st->contacts[i], width, out);
  if (!has_contact_friction(st))
    return;
  km_text_add(out, "\nactuators with friction of the contacts: any force in the range holds\n");
  for (int i = 0; i < st->actuator_count; ++i) {
    km_text_add(out, "  ");
    km_text_padded(st->actuators[i].name, width, out);
    km_text_format(out, "  %14.6g to %.6g ", st->actuator_forces[i] - st->friction[i],
                   st->actuator_forces[i] + st->friction[i]);
    km_push_unit(m->model, &st->actuators[i], out);
    km_text_add(out, "\n");
  }
}

static void print_meshing(const km_model *model, km_text *out) {
  km_text words = {0};
  km_meshing_words(model, &words);
  if (words.size || words.failed)
    km_text_format(out, "  %s\n", words.failed ? "out of memory" : words.data);
  out->failed = out->failed || words.failed;
  km_text_free(&words);
}

/* Components that are 0 in every joint, as those out of the plane of a planar mechanism, have no column. */
static void print_reactions(const km_mechanism *m, const km_statics *st, int width, km_text *out) {
  static const char *const names[6] = {"fx", "fy", "fz", "tx", "ty", "tz"};
  const km_model *model = m->model;
  const grains grain = grains_of(m, st);
  bool shown[6], open = false;
  int left_out = 0;
  for (int k = 0; k < 6; ++k) {
    shown[k] = !is_zero_everywhere(m, st, grain, k);
    left_out += !shown[k];
  }
  km_text_format(out, "\nreactions of parent on child, about the child's joint frame, %s axes, with %s (%s, ",
                 st->axes == KM_AXES_FIXED ? "inertial" : "its",
                 st->held ? "the actuators' forces" : "the least-norm forces", model->units.force->suffix);
  km_torque_unit(model, out);
  km_text_add(out, ")\n");
  if (left_out < 6) {
    km_text_add(out, "  ");
    km_text_padded("joint", width, out);
    for (int k = 0; k < 6; ++k)
      if (shown[k])
        km_text_format(out, "  %12s", names[k]);
    km_text_add(out, "\n");
  }
  for (int j = 0; j < model->joint_count && left_out < 6; ++j) {
    km_text_add(out, "  ");
    km_text_padded(model->joints[j].label, width, out);
    for (int k = 0; k < 6; ++k) {
      bool indeterminate = st->reactions[j].indeterminate[k];
      if (shown[k])
        km_text_format(out, " %12.5g%s", shown_component(&st->reactions[j], grain, k), indeterminate ? "?" : " ");
      open = open || (shown[k] && indeterminate);
    }
    km_text_add(out, "\n");
  }
  for (int k = 0, listed = 0; k < 6; ++k)
    if (!shown[k])
      km_text_format(out, "%s%s", listed++ ? ", " : "  0 in every joint: ", names[k]);
  km_text_add(out, left_out ? "\n" : "");
  if (open)
    km_text_format(out,
                   "  ? statically indeterminate (%d redundant constraint%s): the least-squares sharing is shown\n",
                   st->degree, km_plural(st->degree));
  print_meshing(model, out);
}

void km_statics_print(const km_mechanism *m, const km_statics *st, const char *name, km_text *out) {
  if (!m || !st || !st->work || st->work->mechanism != m || !name || !out)
    return;
  int width = km_widest_label(m->model);
  km_text_format(
      out, "%s: %s\n", name,
      !st->held ? "the actuators can't hold this pose"
      : st->redundant
          ? "the actuators hold this pose; more actuators than freedoms, so the least-squares sharing is shown"
          : "the actuators hold this pose");
  km_text_add(out, "  ");
  km_gravity_words(m->model, st->gravity, out);
  km_modules_words(m->model, true, out);
  km_text_add(out, "\n");
  print_directions(m, st, out);
  if (st->actuator_count)
    km_text_add(out, "\nactuators\n");
  for (int i = 0; i < st->actuator_count; ++i)
    print_force(m, &st->actuators[i], width, st->actuator_forces[i], out);
  print_contacts(m, st, width, out);
  if (m->coordinate_count)
    km_text_add(out, "\nleast-norm forces of all joints\n");
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!m->held[c]) {
      const km_port handle = joint_handle(m, c);
      print_force(m, &handle, width, st->least_norm[c], out);
    }
  if (m->model->joint_count)
    print_reactions(m, st, width, out);
}

static const char *event_word(km_force_event_kind kind) {
  return kind == KM_FORCE_BALANCED ? "zero" : kind == KM_FORCE_PEAK ? "peak" : "unbounded";
}

km_value *km_statics_sweep_record(const km_mechanism *m, const km_statics_sweep *sweep, const char *stopped_by,
                                  const char *name, km_arena *arena) {
  km_value *record = km_record_head(m, "kstatic", name, arena);
  km_table_record(sweep->motion.table, record, arena);
  km_value *events = km_value_add(arena, record, "events", KM_LIST);
  for (size_t i = 0; i < sweep->event_count && !arena->failed; ++i) {
    const km_force_event *e = &sweep->events[i];
    km_value *item = km_value_add(arena, events, NULL, KM_OBJECT);
    km_value_string(arena, item, "actuator", sweep->actuators[e->actuator].name);
    km_value_string(arena, item, "event", event_word(e->kind));
    km_value_number(arena, item, "s", e->s);
    km_value_number(arena, item, "force", e->value);
  }
  if (sweep->actuator_count)
    add_excess(m, sweep->actuators, &sweep->largest->value, sizeof *sweep->largest, sweep->actuator_count, record,
               arena);
  km_reactions_note_record(m->model, record, arena);
  km_value_number(arena, record, "degree_of_indeterminacy", sweep->degree);
  km_value_number(arena, record, "rows_not_held", (double)sweep->unheld);
  km_held_record(m, record, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}

static void print_events(const km_statics_sweep *sweep, int actuator, km_force_event_kind kind, const char *words,
                         const char *unit, km_text *out) {
  int count = 0;
  for (size_t i = 0; i < sweep->event_count; ++i)
    if (sweep->events[i].actuator == actuator && sweep->events[i].kind == kind)
      km_text_format(out, "%s %.6g%s", count++ ? "," : words, sweep->events[i].s, unit);
}

void km_statics_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_statics_sweep *sweep,
                            const char *name, km_text *out) {
  const char *unit = km_sweep_unit(m, plan);
  int width = km_widest_label(m->model);
  km_sweep_print(m, plan, &sweep->motion, name, out);
  km_text_add(out, "  ");
  km_gravity_words(m->model, sweep->gravity, out);
  km_modules_words(m->model, true, out);
  km_text_add(out, "\n");
  for (int i = 0; i < sweep->actuator_count; ++i) {
    const km_force_event *largest = &sweep->largest[i];
    const km_port *actuator = &sweep->actuators[i];
    km_text_add(out, "  ");
    km_text_padded(actuator->name, width, out);
    if (isnan(largest->s)) {
      km_text_add(out, " never holds");
    } else if (largest->value == 0.0) {
      km_text_add(out, " has nothing to hold");
    } else if (isfinite(largest->value)) {
      km_text_format(out, " holds at most %.6g ", fabs(largest->value));
      km_push_unit(m->model, actuator, out);
      if (largest->value < 0.0)
        km_text_format(out, " in size, %.6g", largest->value);
      km_text_format(out, " at %.6g%s", largest->s, unit);
    }
    print_events(sweep, i, KM_FORCE_UNBOUNDED, " is unbounded at", unit, out);
    print_events(sweep, i, KM_FORCE_BALANCED, "; zero at", unit, out);
    km_text_add(out, "\n");
  }
  if (!sweep->loaded)
    km_text_add(out, "  nothing acts: no weight, load or spring\n");
  if (sweep->unheld)
    km_text_format(out, "  not held at %zu of %zu rows, first at %.6g%s\n", sweep->unheld,
                   km_table_rows(sweep->motion.table), sweep->first_unheld, unit);
  print_meshing(m->model, out);
}
