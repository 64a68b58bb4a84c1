/* Columns of force modules over a motion: variable, force, power and work; forces, moments and slips of a tyre;
 * forces, penetration and slip of a contact; internal states. */
#include "base/table.h"
#include "base/text.h"
#include "forces/motion_forces.h"
#include "history/history_table.h"
#include "kmech/inspect.h"

#include <string.h>

static const char *const law_parts[] = {".variable", ".value", ".power", ".work"};
static const char *const tire_parts[] = {".fx", ".fy",   ".fz",         ".tx",    ".ty",
                                         ".tz", ".slip", ".slip_angle", ".power", ".work"};
static const char *const contact_parts[] = {".normal", ".friction", ".penetration", ".slip", ".power", ".work"};
enum {
  LAW_PARTS = sizeof law_parts / sizeof *law_parts,
  TIRE_PARTS = sizeof tire_parts / sizeof *tire_parts,
  CONTACT_PARTS = sizeof contact_parts / sizeof *contact_parts
};

/* Endings of a module's columns; returns their number. */
static int parts_of(const km_model_module *module, const char *const **out) {
  *out = module->type == KM_MODULE_TIRE ? tire_parts : module->type == KM_MODULE_CONTACT ? contact_parts : law_parts;
  return module->type == KM_MODULE_TIRE ? TIRE_PARTS : module->type == KM_MODULE_CONTACT ? CONTACT_PARTS : LAW_PARTS;
}

static bool is_length(const km_model *model, const km_module_input *in) {
  int c = in->port.coordinate;
  return c >= 0                      ? km_model_coordinate_is_length(model, c)
         : c == KM_MODULE_PORT_FRAME ? in->component < 3
                                     : in->distance <= KM_DISTANCE_Z;
}

/* Unit of the variable: angles in radians. */
static void variable_unit(const km_model *model, const km_model_module *module, km_text *out) {
  static const char *const rates[] = {"", "/", "/"}, *const powers[] = {"", "", "^2"};
  const char *time = model->units.time->suffix;
  if (module->variable == KM_VARIABLE_TIME) {
    km_text_add(out, time);
    return;
  }
  bool length = module->input_count == 0 || is_length(model, &module->inputs[0]);
  km_text_format(out, "%s%s%s%s", length ? model->units.length->suffix : "rad", rates[module->variable],
                 module->variable ? time : "", powers[module->variable]);
}

static void force_unit(const km_model *model, const km_model_module *module, km_text *out) {
  int c = module->output.coordinate;
  bool is_force = c >= 0 ? km_model_coordinate_is_length(model, c) : module->distance <= KM_DISTANCE_Z;
  if (is_force)
    km_text_add(out, model->units.force->suffix);
  else
    km_torque_unit(model, out);
}

/* Unit of part `part` of a module's columns. */
static void part_unit(const km_model *model, const km_model_module *module, const char *part, km_text *out) {
  bool is_tire = module->type == KM_MODULE_TIRE, is_contact = module->type == KM_MODULE_CONTACT;
  if (strcmp(part, ".variable") == 0)
    variable_unit(model, module, out);
  else if (strcmp(part, ".value") == 0)
    force_unit(model, module, out);
  else if ((is_tire && part[1] == 'f') || strcmp(part, ".normal") == 0 || strcmp(part, ".friction") == 0)
    km_text_add(out, model->units.force->suffix);
  else if (strcmp(part, ".penetration") == 0)
    km_text_add(out, model->units.length->suffix);
  else if (is_contact && strcmp(part, ".slip") == 0)
    km_text_format(out, "%s/%s", model->units.length->suffix, model->units.time->suffix);
  else if (strcmp(part, ".slip_angle") == 0)
    km_text_add(out, "rad");
  else if (strcmp(part, ".slip") != 0)
    km_torque_unit(model, out);
  if (strcmp(part, ".power") == 0)
    km_text_format(out, "/%s", model->units.time->suffix);
}

void km_history_module_columns(const km_history_writer *w, km_table *table, bool *failed) {
  const km_model *model = w->m->model;
  km_text unit = {0};
  for (int i = 0; i < w->module_count; ++i) {
    const km_model_module *module = &model->modules[w->modules[i]];
    const char *const *parts;
    for (int k = 0, count = parts_of(module, &parts); k < count; ++k) {
      const char *part = parts[k];
      unit.size = 0;
      part_unit(model, module, part, &unit);
      *failed = !km_table_add_joined_column(table, "module.", module->name, part,
                                            unit.size && !unit.failed ? unit.data : NULL) ||
                *failed;
    }
  }
  *failed = *failed || unit.failed;
  km_text_free(&unit);
}

double *km_history_write_modules(const km_history_writer *w, double *out) {
  for (int i = 0; i < w->module_count; ++i) {
    const km_model_module *module = &w->m->model->modules[w->modules[i]];
    const km_module_report *r = km_module_report_of(w->m, w->forces, module);
    const double work = km_simulation_module_work(w->simulation, w->modules[i]);
    const double law[LAW_PARTS] = {r->variable, r->force, r->power, work};
    const double tire[TIRE_PARTS] = {
        r->tire_force.x,  r->tire_force.y, r->tire_force.z, r->tire_moment.x, r->tire_moment.y,
        r->tire_moment.z, r->slip,         r->slip_angle,   r->power,         work};
    const double contact[CONTACT_PARTS] = {r->force, r->friction, r->depth, r->slip, r->power, work};
    const char *const *parts;
    const int count = parts_of(module, &parts);
    memcpy(out, count == TIRE_PARTS ? tire : count == CONTACT_PARTS ? contact : law, (size_t)count * sizeof *out);
    out += count;
  }
  return out;
}

void km_internal_column(const km_model *model, int index, km_text *name, km_text *unit) {
  const km_model_module *module = model->modules;
  for (int count; index >= (count = km_module_internal_count(module)); ++module)
    index -= count;
  if (module->type == KM_MODULE_PID) {
    km_text_format(name, "state.%s.integral", module->name);
    variable_unit(model, module, unit);
    km_text_format(unit, "*%s", model->units.time->suffix);
  } else {
    km_text_format(name, "state.%s.%s", module->name, index ? "slip_angle" : "slip");
    km_text_add(unit, index ? "rad" : "");
  }
}

void km_history_internal_columns(const km_history_writer *w, km_table *table, bool *failed) {
  km_text name = {0}, unit = {0};
  for (int i = 0; i < km_model_internal_count(w->m->model); ++i) {
    name.size = unit.size = 0;
    km_internal_column(w->m->model, i, &name, &unit);
    *failed = name.failed || unit.failed || km_table_add_column(table, name.data, unit.size ? unit.data : NULL) < 0 ||
              *failed;
  }
  km_text_free(&name);
  km_text_free(&unit);
}

double *km_history_write_internal(const km_history_writer *w, double *out) {
  const km_moving_forces *moving = w->forces->moving;
  memcpy(out, moving->internal_state, (size_t)moving->state_count * sizeof *out);
  return out + moving->state_count;
}
