/* What acts on the model and what holds it: the options that kstatic's commands share. */
#include "kstatic/loads.h"

#include "base/memory.h"
#include "topology/mechanism.h"

#include <string.h>

void kstatic_options_add(kt_options *out, kstatic_options *o) {
  const kt_option table[] = {
      {"actuators", 0, "JOINT,JOINT",
       "The joints that hold the mechanism (default: the model's analysis.actuators, else every free joint)", KT_TEXT,
       &o->actuators, KT_ABOUT_MODEL},
      {"load", 0, "NAME=FX,FY,FZ[,TX,TY,TZ]",
       "Give a load of the model another force (and torque), NAME=FACTOR: scale it; BODY/FRAME=… adds one at a frame's "
       "origin. :frame behind the numbers turns its axes with the frame (repeatable)",
       KT_TEXTS, &o->loads, KT_ABOUT_MODEL},
      {"gravity", 0, "X,Y,Z", "Another gravity than the model's, length/time²", KT_TEXT, &o->gravity, KT_ABOUT_MODEL},
      {"axes", 0, "AXES", "Axes of the reactions: joint (of the child's joint frame, default) or fixed",
       KT_WORD("joint or fixed"), &o->axes, KT_ABOUT_MODEL},
  };
  _Static_assert(KM_AXES_JOINT == 0 && KM_AXES_FIXED == 1, "the words of --axes stand in the order of km_axes");
  KT_OPTIONS_ADD(out, table);
}

static kt_exit read_gravity(const kt_common *common, const char *text, double out[3]) {
  return kt_numbers(text, 3, out) ? KT_DONE : kt_usage(common, "--gravity", text, "three numbers X,Y,Z");
}

static kt_exit make_forces(const kt_common *common, const char *path, const kt_pose *pose, const kstatic_options *o,
                           km_forces **out) {
  kstatic_loads loads = {0};
  double gravity[3];
  km_error error;
  kt_exit result = o->gravity ? read_gravity(common, o->gravity, gravity) : KT_DONE;
  if (result == KT_DONE)
    result = kstatic_loads_read(common, pose->model, &o->loads, &loads);
  if (result == KT_DONE) {
    km_status status =
        km_forces_create(pose->mechanism, o->gravity ? gravity : NULL, loads.items, loads.count, out, &error);
    if (status)
      kt_say(common, KM_ERROR, "%s: %s", path, error.text);
    result = kt_exit_of(status);
  }
  kstatic_loads_free(&loads);
  return result;
}

/* The actuators: of --actuators, else the model's, else every free coordinate. */
static kt_exit read_actuators(const kt_common *common, const char *path, const km_mechanism *m, const char *text,
                              int *out, int *count, bool *all) {
  const km_model *model = m->model;
  bool given = model->actuators_given;
  if (text)
    return kt_coordinates(common, model, "--actuators", text, out, count);
  if (given && model->actuator_count == 0) {
    kt_say(common, KM_ERROR, "%s: analysis.actuators is empty; expected at least one joint, or --actuators", path);
    return KT_USAGE;
  }
  if (!given)
    kt_say(common, KM_NOTE, "%s: no analysis.actuators and no --actuators: every free joint holds", path);
  *all = !given;
  for (int i = 0; i < model->actuator_count; ++i) {
    if (!m->held[model->actuators[i]])
      out[(*count)++] = model->actuators[i];
    else
      kt_say(common, KM_NOTE, "%s: actuator %s is held and so rigid", path,
             km_model_coordinate_label(model, model->actuators[i]));
  }
  return KT_DONE;
}

kt_exit kstatic_prepare(const kt_common *common, const char *path, const kt_pose *pose, const kstatic_options *o,
                        kstatic_balance *out) {
  km_error error;
  bool all = false;
  int count = 0, *actuators = KM_NEW(int, (size_t)pose->model->coordinate_count);
  *out = (kstatic_balance){0};
  kt_exit result = actuators ? make_forces(common, path, pose, o, &out->forces) : KT_INTERNAL;
  if (result == KT_DONE)
    result = read_actuators(common, path, pose->mechanism, o->actuators, actuators, &count, &all);
  if (result == KT_DONE) {
    km_status status =
        km_statics_create(pose->mechanism, all ? NULL : actuators, count, (km_axes)o->axes, &out->statics, &error);
    if (status)
      kt_say(common, KM_ERROR, "%s: %s", path, error.text);
    result = kt_exit_of(status);
  }
  km_free(actuators);
  return result;
}

void kstatic_free(kstatic_balance *balance) {
  km_statics_free(&balance->statics);
  km_forces_free(balance->forces);
}

void kstatic_words(const km_model *model, const kstatic_options *o, km_text *out) {
  km_text_format(out, "gravity (%g, %g, %g) %s/%s²", model->gravity.x, model->gravity.y, model->gravity.z,
                 model->units.length->suffix, model->units.time->suffix);
  if (o->gravity) {
    out->size = 0;
    km_text_format(out, "gravity (%s) %s/%s²", o->gravity, model->units.length->suffix, model->units.time->suffix);
  }
  for (int i = 0; i < model->load_count; ++i) {
    const km_applied_load *load = &model->loads[i];
    km_text_format(out, "; %s: force (%g, %g, %g) %s on %s%s", load->name, load->force.x, load->force.y, load->force.z,
                   model->units.force->suffix, model->bodies[model->frames[load->frame].body].name,
                   load->turning ? ", turning with it" : "");
  }
  for (int i = 0; i < o->loads.count; ++i)
    km_text_format(out, "; --load %s", o->loads.items[i]);
  int springs = 0;
  for (int i = 0; i < model->module_count; ++i)
    springs += model->modules[i].type == KM_MODULE_STIFFNESS;
  if (springs)
    km_text_format(out, "; %d spring%s", springs, springs == 1 ? "" : "s");
}
