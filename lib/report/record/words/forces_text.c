/* Text about gravity, loads and forces, and about meshing forces that reactions omit. */
#include "report/record/words/forces_text.h"

#include "kmech/report.h"
#include "report/record/record.h"
#include "topology/mechanism.h"

#include <string.h>

enum { MOST_NAMED = 6 };

void km_gravity_words(const km_model *m, const double gravity[3], km_text *out) {
  if (!m || !out)
    return;
  const km_units *u = &m->units;
  km_vec3 g = gravity ? km_vec3_from_array(gravity) : m->gravity;
  if (km_vec3_norm(g) == 0.0)
    km_text_add(out, "no gravity");
  else
    km_text_format(out, "gravity (%g, %g, %g) %s/%s²", g.x, g.y, g.z, u->length->suffix, u->time->suffix);
}

/* ": force (0, -1, 0) N on piston, turning with it times a law over A". */
static void load_words(const km_model *model, int frame, const double *force, const double *torque, bool turning,
                       const km_load_scale *scale, km_text *out) {
  const km_units *u = &model->units;
  const bool pushes = force[0] != 0.0 || force[1] != 0.0 || force[2] != 0.0;
  if (pushes)
    km_text_format(out, ": force (%g, %g, %g) %s", force[0], force[1], force[2], u->force->suffix);
  if (torque[0] != 0.0 || torque[1] != 0.0 || torque[2] != 0.0)
    km_text_format(out, "%s torque (%g, %g, %g) %s*%s", pushes ? " and" : ":", torque[0], torque[1], torque[2],
                   u->force->suffix, u->length->suffix);
  km_text_format(out, " on %s%s", model->bodies[model->frames[frame].body].name, turning ? ", turning with it" : "");
  if (scale)
    km_text_format(out, " times a law over %s",
                   scale->coordinate < 0 ? "time" : km_model_coordinate_label(model, scale->coordinate));
}

static void all_loads_words(const km_model *model, const km_forces *forces, km_text *out) {
  const int count = forces ? forces->load_count : model->load_count;
  for (int i = 0; i < count && i < MOST_NAMED; ++i) {
    if (forces) {
      const km_load *load = &forces->loads[i];
      if (i < model->load_count)
        km_text_format(out, "; %s", model->loads[i].name);
      else
        km_text_format(out, "; at %s", model->frames[load->frame].name);
      load_words(model, load->frame, load->force, load->torque, load->turning, load->scale, out);
    } else {
      const km_applied_load *own = &model->loads[i];
      km_text_format(out, "; %s", own->name);
      const double force[3] = {own->force.x, own->force.y, own->force.z};
      const double torque[3] = {own->torque.x, own->torque.y, own->torque.z};
      load_words(model, own->frame, force, torque, own->turning, own->scale, out);
    }
  }
  if (count > MOST_NAMED)
    km_text_format(out, "; %d more loads", count - MOST_NAMED);
}

/* " in C", " between rod and bore", " on wheel": where a module acts. */
static void place_words(const km_model *model, const km_module_port *port, km_text *out) {
  if (port->coordinate >= 0)
    km_text_format(out, " in %s", km_model_coordinate_label(model, port->coordinate));
  else if (port->coordinate == KM_MODULE_PORT_FRAMES)
    km_text_format(out, " between %s and %s", model->bodies[model->frames[port->frame[0]].body].name,
                   model->bodies[model->frames[port->frame[1]].body].name);
  else
    km_text_format(out, " on %s", model->bodies[model->frames[port->frame[0]].body].name);
}

/* "gas: spring between rod and door"; a strut's own "gas spring in lift". */
static void module_words(const km_model *model, const km_model_module *module, km_text *out) {
  static const char *const words[KM_MODULE_TYPES] = {"spring",     "damper", "friction", "motor",
                                                     "controller", "tyre",   "contact"};
  const int c = module->output.coordinate;
  const char *label = c >= 0 ? km_model_coordinate_label(model, c) : "";
  const size_t length = strlen(label);
  const bool is_own = length > 0 && strncmp(module->name, label, length) == 0 && module->name[length] == ':';
  const bool is_law = module->type == KM_MODULE_MOTOR && module->variable == KM_VARIABLE_DISPLACEMENT;
  if (is_own)
    for (const char *word = module->name + length + 1; *word; ++word)
      km_text_format(out, "%c", *word == '_' ? ' ' : *word);
  else
    km_text_format(out, "%s: %s", module->name, is_law ? "force by a law" : words[module->type]);
  place_words(model, &module->output, out);
  if (is_law && module->input_count == 1 && module->input.coordinate >= 0)
    km_text_format(out, " over %s", km_model_coordinate_label(model, module->input.coordinate));
}

void km_modules_words(const km_model *model, bool at_rest, km_text *out) {
  int count = 0;
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *module = &model->modules[i];
    const bool acts = !at_rest || module->type == KM_MODULE_STIFFNESS || module->type == KM_MODULE_CONTACT;
    if (!acts || ++count > MOST_NAMED)
      continue;
    km_text_add(out, "; ");
    module_words(model, module, out);
  }
  if (count > MOST_NAMED)
    km_text_format(out, "; %d more forces", count - MOST_NAMED);
}

/* Damping and friction of joints. */
static void joints_words(const km_model *model, km_text *out) {
  int damped = 0, rubbing = 0;
  for (int c = 0; c < model->coordinate_count; ++c)
    if (model->coordinates[c].damping > 0.0 && ++damped <= MOST_NAMED)
      km_text_format(out, "%s %s", damped > 1 ? "," : "; damping in", km_model_coordinate_label(model, c));
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].friction.coefficient > 0.0 && ++rubbing <= MOST_NAMED)
      km_text_format(out, "%s %s", rubbing > 1 ? "," : "; friction in", model->joints[j].label);
}

void km_acting_words(const km_model *model, const km_forces *forces, bool at_rest, km_text *out) {
  const double stated[3] = {forces ? forces->stated_gravity.x : 0.0, forces ? forces->stated_gravity.y : 0.0,
                            forces ? forces->stated_gravity.z : 0.0};
  km_gravity_words(model, forces ? stated : NULL, out);
  all_loads_words(model, forces, out);
  km_modules_words(model, at_rest, out);
  if (!at_rest)
    joints_words(model, out);
}

void km_meshing_words(const km_model *m, km_text *out) {
  int count = 0, first = -1;
  if (!m || !out)
    return;
  for (int i = 0; i < m->coupling_count; ++i)
    if (m->couplings[i].count > 1) {
      first = first < 0 ? i : first;
      count++;
    }
  if (count == 0)
    return;
  km_text_format(out, "the reactions leave out meshing forces: coupling %s", m->couplings[first].name);
  if (count > 1)
    km_text_format(out, " (and %d more)", count - 1);
  km_text_add(
      out, " acts along the coordinates of its joints alone, so that no bearing carries what teeth, racks or belts put "
           "on it, and the value about or along a coupled axis is the coupling's");
}

void km_reactions_note_record(const km_model *m, km_value *record, km_arena *arena) {
  km_text words = {0};
  km_meshing_words(m, &words);
  if (words.size || words.failed)
    km_value_words(arena, record, "reactions_note", &words);
}
