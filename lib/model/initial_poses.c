/* Initial poses of the bodies, before loops are closed. */
#include "model/initial_poses.h"

km_pose km_model_joint_motion(const km_model *model, int joint, const double *q) {
  const km_model_joint *def = &model->joints[joint];
  const km_joint_kind *kind = km_joint_kind_of(def->type);
  km_pose X = km_pose_identity();
  for (int i = 0; i < kind->motion_count; ++i) {
    double value[3] = {0};
    int freedom = km_primitive_freedom(kind->motions[i].primitive);
    for (int k = 0; k < freedom; ++k)
      value[k] = *q++;
    km_pose step = km_motion_pose(kind->motions[i], def->pitch / (2.0 * M_PI), value);
    X = km_pose_product(&X, &step);
  }
  return X;
}

km_pose km_model_start_motion(const km_model *model, int joint) {
  double q[KM_MAX_FREEDOM] = {0};
  int first = model->joints[joint].first_coordinate;
  for (int k = 0; k < km_model_freedom(model, joint); ++k)
    q[k] = model->coordinates[first + k].position * km_model_coordinate_factor(model, first + k);
  return km_model_joint_motion(model, joint, q);
}

static bool is_drawn(const km_model *model, int body) {
  int assembly = model->bodies[body].assembly;
  return body == 0 || (assembly != KM_NO_ASSEMBLY && model->assemblies[assembly].drawn);
}

/* Places the second body of a joint from the first. False if both or none are placed. */
static bool pass(const km_model *model, int joint, bool *known, km_pose *pose) {
  const km_model_frame *a = &model->frames[model->joints[joint].frame[0]],
                       *b = &model->frames[model->joints[joint].frame[1]];
  if (known[a->body] == known[b->body])
    return false;
  bool forward = known[a->body];
  const km_model_frame *from = forward ? a : b, *to = forward ? b : a;
  km_pose motion = km_model_start_motion(model, joint), back = km_pose_inverse(&to->pose);
  if (!forward)
    motion = km_pose_inverse(&motion);
  km_pose X = km_pose_product(&pose[from->body], &from->pose);
  X = km_pose_product(&X, &motion);
  pose[to->body] = km_pose_product(&X, &back);
  return known[to->body] = true;
}

bool km_model_start_poses(const km_model *model, km_pose *pose) {
  bool *known = KM_NEW(bool, (size_t)model->body_count);
  if (!known)
    return false;
  for (int b = 0; b < model->body_count; ++b) {
    pose[b] = km_pose_identity();
    known[b] = is_drawn(model, b);
  }
  for (bool more = true; more;) {
    more = false;
    for (int j = 0; j < model->joint_count; ++j)
      more = pass(model, j, known, pose) || more;
  }
  km_free(known);
  return true;
}
