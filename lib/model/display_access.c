/* Access by index for programs that display a model: assemblies, types, frames, masses. */
#include "kmech/inspect.h"

#include "base/arguments.h"
#include "model/model.h"

#include <math.h>

static bool is_one(int index, int count) {
  return index >= 0 && index < count;
}

int km_model_assembly_count(const km_model *model) {
  return model ? model->assembly_count : 0;
}

const char *km_model_assembly_name(const km_model *model, int assembly) {
  return model && is_one(assembly, model->assembly_count) ? model->assemblies[assembly].name : "";
}

int km_model_assembly_parent(const km_model *model, int assembly) {
  return model && is_one(assembly, model->assembly_count) ? model->assemblies[assembly].parent : KM_NO_ASSEMBLY;
}

int km_model_body_assembly(const km_model *model, int body) {
  return model && body > 0 && body < model->body_count ? model->bodies[body].assembly : KM_NO_ASSEMBLY;
}

double km_model_body_mass(const km_model *model, int body, double center_of_mass[3]) {
  bool known = model && is_one(body, model->body_count);
  km_vec3 c = known ? model->bodies[body].center_of_mass : (km_vec3){nan(""), nan(""), nan("")};
  if (center_of_mass)
    km_vec3_write(c, center_of_mass);
  return known ? model->bodies[body].mass : nan("");
}

const char *km_model_body_mesh(const km_model *model, int body) {
  return model && is_one(body, model->body_count) ? model->bodies[body].mesh : NULL;
}

int km_model_joint_type(const km_model *model, int joint) {
  return model && is_one(joint, model->joint_count) ? (int)model->joints[joint].type : -1;
}

const char *km_joint_type_word(km_joint_type type) {
  return is_one((int)type, KM_JOINT_TYPES) ? km_joint_kind_of(type)->word : "";
}

int km_model_joint_frame(const km_model *model, int joint, bool child) {
  return model && is_one(joint, model->joint_count) ? model->joints[joint].frame[child ? 1 : 0] : -1;
}

km_status km_model_frame_pose(const km_model *model, int frame, double R[9], double T[3], km_error *error) {
  km_status status = km_check_given(model != NULL, "model", error);
  if (!status)
    status = km_check_given(R && T, "place for the result", error);
  if (!status)
    status = km_check_index(frame, model->frame_count, "frame", error);
  if (status)
    return status;
  const km_pose *pose = &model->frames[frame].pose;
  km_rotation_rows(&pose->R, R);
  km_vec3_write(pose->p, T);
  return KM_OK;
}

bool km_model_joint_is_drawn(const km_model *model, int joint) {
  if (!model || !is_one(joint, model->joint_count))
    return false;
  int assembly = model->joints[joint].assembly;
  return assembly >= 0 && model->assemblies[assembly].drawn;
}

int km_model_actuator_count(const km_model *model) {
  return model ? model->actuator_count : 0;
}

int km_model_actuator(const km_model *model, int index) {
  return model && is_one(index, model->actuator_count) ? model->actuators[index] : -1;
}

int km_model_hold_count(const km_model *model) {
  return model ? model->hold_count : 0;
}

km_hold km_model_hold_at(const km_model *model, int index) {
  if (!model || !is_one(index, model->hold_count))
    return (km_hold){-1, nan("")};
  return (km_hold){model->holds[index].coordinate, model->holds[index].value};
}

int km_model_sweep_coordinate(const km_model *model) {
  return model ? model->sweep.coordinate : -1;
}
