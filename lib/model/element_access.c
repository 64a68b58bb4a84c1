/* Access by index: names, owners, limits. */
#include "model/model.h"

#include "base/arguments.h"
#include "base/similar_names.h"
#include "kmech/inspect.h"

#include <math.h>
#include <string.h>

static bool has_frame(const km_model *model, int frame) {
  return model && frame >= 0 && frame < model->frame_count;
}

int km_model_frame_count(const km_model *model) {
  return model ? model->frame_count : 0;
}

const char *km_model_frame_name(const km_model *model, int frame) {
  return has_frame(model, frame) ? model->frames[frame].name : "";
}

int km_model_frame_body(const km_model *model, int frame) {
  return has_frame(model, frame) ? model->frames[frame].body : -1;
}

int km_model_coordinate_joint(const km_model *model, int coordinate) {
  bool known = model && coordinate >= 0 && coordinate < model->coordinate_count;
  return known ? model->coordinates[coordinate].joint : -1;
}

bool km_model_coordinate_limits(const km_model *model, int coordinate, double *low, double *high) {
  if (!low || !high)
    return false;
  *low = *high = nan("");
  if (!model || coordinate < 0 || coordinate >= model->coordinate_count)
    return false;
  *low = model->coordinates[coordinate].low;
  *high = model->coordinates[coordinate].high;
  return isfinite(*low) || isfinite(*high);
}

void km_model_free(km_model *model) {
  if (!model)
    return;
  km_arena_free(&model->arena);
  km_free(model);
}

int km_model_body_count(const km_model *model) {
  if (!model)
    return 0;
  return model->body_count - 1;
}
int km_model_joint_count(const km_model *model) {
  if (!model)
    return 0;
  return model->joint_count;
}
int km_model_coordinate_count(const km_model *model) {
  if (!model)
    return 0;
  return model->coordinate_count;
}
const char *km_model_word_text(const km_model *model, km_model_word word) {
  return model && (int)word >= 0 && word < KM_MODEL_WORDS ? model->words[word] : NULL;
}

const char *km_model_body_name(const km_model *model, int body) {
  if (!model || body < 0 || body >= model->body_count)
    return "";
  return model->bodies[body].name;
}

const char *km_model_joint_label(const km_model *model, int joint) {
  if (!model || joint < 0 || joint >= model->joint_count)
    return "";
  return model->joints[joint].label;
}
const char *km_model_coordinate_label(const km_model *model, int coordinate) {
  if (!model || coordinate < 0 || coordinate >= model->coordinate_count)
    return "";
  return model->coordinates[coordinate].label;
}
const char *km_model_coordinate_unit(const km_model *model, int coordinate) {
  if (!model || coordinate < 0 || coordinate >= model->coordinate_count)
    return "";
  const km_model_coordinate *c = &model->coordinates[coordinate];
  return km_joint_is_length(model->joints[c->joint].type, c->index) ? model->units.length->suffix
                                                                    : model->units.angle->suffix;
}
int km_model_joint_freedom(const km_model *model, int joint, int *first) {
  if (!model || !first || joint < 0 || joint >= model->joint_count)
    return 0;
  *first = model->joints[joint].first_coordinate;
  return km_model_freedom(model, joint);
}
void km_model_share_length(km_model *model, double length) {
  if (!model || !(length > 0.0 && isfinite(length)))
    return;
  model->characteristic_length = length;
  model->length_shared = true;
}

double km_model_length_unit(const km_model *model) {
  if (!model)
    return nan("");
  return model->units.length->si;
}
const char *km_model_sha256(const km_model *model) {
  if (!model)
    return "";
  return model->sha256;
}

int km_model_pose_count(const km_model *model) {
  return model ? model->pose_count : 0;
}

const char *km_model_pose_name(const km_model *model, int pose) {
  return model && pose >= 0 && pose < model->pose_count ? model->poses[pose].name : "";
}

km_status km_model_find_pose(const km_model *model, const char *name, int *pose, km_error *error) {
  km_status status = km_check_given(model && name && pose, "model, name or place for the result", error);
  if (status)
    return status;
  km_nearest nearest = {.wanted = name};
  char names[KM_NEAREST_TEXT];
  for (*pose = 0; *pose < model->pose_count; ++*pose) {
    if (strcmp(model->poses[*pose].name, name) == 0)
      return KM_OK;
    km_nearest_add(&nearest, model->poses[*pose].name);
  }
  if (model->pose_count == 0)
    return km_fail(error, KM_USAGE, "\"%.80s\" names no pose: the model names none", name);
  return km_fail(error, KM_USAGE, "\"%.80s\" names no pose; the nearest of %d are %s", name, model->pose_count,
                 km_nearest_text(&nearest, names));
}

double km_model_pose_value(const km_model *model, int pose, int coordinate) {
  if (!model || pose < 0 || pose >= model->pose_count)
    return (double)NAN;
  const km_model_pose *p = &model->poses[pose];
  for (int k = 0; k < p->count; ++k)
    if (p->coordinates[k] == coordinate)
      return p->values[k];
  return (double)NAN;
}

bool km_joint_is_coupled(const km_model *model, int joint) {
  for (int i = 0; i < model->coupling_count; ++i)
    for (int k = 0; k < model->couplings[i].count; ++k)
      if (model->coordinates[model->couplings[i].coordinates[k]].joint == joint)
        return true;
  return false;
}

bool km_model_coordinate_is_length(const km_model *model, int coordinate) {
  if (!model || coordinate < 0 || coordinate >= model->coordinate_count)
    return false;
  const km_model_coordinate *c = &model->coordinates[coordinate];
  return km_joint_is_length(model->joints[c->joint].type, c->index);
}

km_units km_model_units(const km_model *model) {
  return model ? model->units : km_units_default();
}

const char *km_model_first_friction(const km_model *m) {
  for (int j = 0; m && j < m->joint_count; ++j)
    if (m->joints[j].friction.coefficient > 0.0)
      return m->joints[j].label;
  for (int c = 0; m && c < m->coordinate_count; ++c)
    if (m->coordinates[c].friction > 0.0)
      return m->coordinates[c].label;
  for (int i = 0; m && i < m->module_count; ++i)
    if (m->modules[i].type == KM_MODULE_FRICTION)
      return m->modules[i].name;
  return NULL;
}

/* True if the joint has coordinates and all are angles. */
static bool rotates_only(const km_model *model, int joint) {
  const int first = model->joints[joint].first_coordinate, freedom = km_model_freedom(model, joint);
  bool alone = freedom > 0;
  for (int c = first; c < first + freedom; ++c)
    alone = alone && !km_model_coordinate_is_length(model, c);
  return alone;
}

int km_model_next_without_radius(const km_model *m, int from) {
  for (int j = from < 0 ? 0 : from; m && j < m->joint_count; ++j)
    if (m->joints[j].friction.coefficient > 0.0 && m->joints[j].friction.radius == 0.0 && rotates_only(m, j))
      return j;
  return -1;
}

void km_model_simulated(const km_model *model, double *span, double *step) {
  if (span)
    *span = model ? model->simulation.span : 0.0;
  if (step)
    *step = model ? model->simulation.step : 0.0;
}

const char *km_model_integration_type(const km_model *model) {
  return model ? model->simulation.integration_type : NULL;
}

int km_module_internal_count(const km_model_module *module) {
  return module->type == KM_MODULE_PID ? 1 : module->type == KM_MODULE_TIRE ? 2 : 0;
}

int km_model_internal_count(const km_model *model) {
  int count = 0;
  for (int i = 0; model && i < model->module_count; ++i)
    count += km_module_internal_count(&model->modules[i]);
  return count;
}

int km_model_module_count(const km_model *model) {
  return model ? model->module_count : 0;
}

const char *km_model_module_name(const km_model *model, int index) {
  return model && index >= 0 && index < model->module_count ? model->modules[index].name : "";
}

int km_model_find_module(const km_model *model, const char *name) {
  int found = -1, count = 0;
  for (int i = 0; model && name && i < model->module_count; ++i)
    if (strcmp(model->modules[i].name, name) == 0) {
      found = i;
      ++count;
    }
  return count == 1 ? found : -1;
}
