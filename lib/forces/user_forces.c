/* Forces and inputs of a program (docs/theory.md 11.8).
 *
 *   Q += τ(t, q, q̇) + Σ J_kᵀ (F_k; M_k),   power = τ · q̇ + Σ F_k · v_k + M_k · ω_k
 *
 * τ joint forces, F_k and M_k force and moment at the origin of frame k, v_k and ω_k its velocities. */
#include "forces/motion_forces.h"

#include "base/arguments.h"

#include <string.h>

km_status km_forces_set_user(km_forces *f, const km_user_forces *user, km_error *error) {
  km_status status =
      km_check_given(f != NULL && user != NULL && user->compute != NULL, "forces or their function", error);
  if (!status)
    status = km_check_list(user->frames, user->frame_count, "frames", error);
  for (int i = 0; !status && i < user->frame_count; ++i)
    status = km_check_index(user->frames[i], f->mechanism->model->frame_count, "frame", error);
  if (!status && f->moving)
    status =
        km_fail(error, KM_USAGE, "the forces already have equations of motion; expected the program's before these");
  if (status)
    return status;
  int *frames = KM_ARENA_NEW(&f->arena, int, (size_t)user->frame_count);
  if (!frames)
    return km_fail(error, KM_MEMORY, "out of memory for the forces");
  if (user->frame_count > 0)
    memcpy(frames, user->frames, (size_t)user->frame_count * sizeof *frames);
  f->user = *user;
  f->user.frames = frames;
  return KM_OK;
}

km_status km_forces_set_joint_force(km_forces *f, int coordinate, double force, km_error *error) {
  km_status status = km_check_given(f != NULL, "forces", error);
  if (!status)
    status = km_check_index(coordinate, f->mechanism->coordinate_count, "coordinate", error);
  if (!status && !isfinite(force))
    status = km_fail(error, KM_USAGE, "joint force %g; expected a finite number", force);
  if (!status)
    f->extra[coordinate] = force;
  return status;
}

km_status km_forces_set_load(km_forces *f, int index, const km_load *load, km_error *error) {
  km_status status = km_check_given(f != NULL && load != NULL, "forces or load", error);
  if (!status)
    status = km_check_index(index, f->load_count, "load", error);
  if (!status && load->frame != f->loads[index].frame)
    status = km_fail(error, KM_USAGE, "load %d acts at another frame; expected the one that it was created for", index);
  double sum = 0.0;
  for (int k = 0; k < 3 && !status; ++k)
    sum += load->force[k] + load->torque[k];
  if (!status && !isfinite(sum))
    status = km_fail(error, KM_USAGE, "load %d isn't finite; expected finite numbers", index);
  if (!status)
    f->loads[index] = *load;
  return status;
}

km_status km_forces_set_reference(km_forces *f, int module, double value, km_error *error) {
  km_status status = km_check_given(f != NULL, "forces", error);
  if (!status)
    status = km_check_index(module, f->mechanism->model->module_count, "force module", error);
  if (status)
    return status;
  const km_model_module *controller = &f->mechanism->model->modules[module];
  if (controller->type != KM_MODULE_PID)
    return km_fail(error, KM_USAGE, "force module \"%s\" has no reference; expected a controller", controller->name);
  if (isinf(value))
    return km_fail(error, KM_USAGE, "reference %g; expected a finite number", value);
  f->reference[module] = value;
  return KM_OK;
}

bool km_user_forces_prepare(km_forces *f) {
  size_t coordinates = (size_t)f->mechanism->coordinate_count, frames = (size_t)f->user.frame_count;
  km_moving_forces *moving = f->moving;
  moving->user_q = KM_ARENA_NEW(&f->arena, double, coordinates);
  moving->user_rate = KM_ARENA_NEW(&f->arena, double, coordinates);
  moving->user_joint = KM_ARENA_NEW(&f->arena, double, coordinates);
  moving->user_frames = KM_ARENA_NEW(&f->arena, km_frame_motion, frames);
  moving->user_wrenches = KM_ARENA_NEW(&f->arena, km_user_wrench, frames);
  return !f->arena.failed;
}

static void store(km_vec3 v, double out[3]) {
  km_vec3_write(v, out);
}

km_frame_motion km_frame_motion_of(const km_forces *f, int frame) {
  km_frame_motion out;
  const km_model_frame *def = &f->mechanism->model->frames[frame];
  km_pose X = km_pose_product(&f->pose[def->body], &def->pose);
  km_twist V = f->twist[def->body];
  store(km_vec3_add(X.p, f->origin), out.origin);
  for (int k = 0; k < 3; ++k) {
    out.axes[k] = X.R.axis[k].x;
    out.axes[3 + k] = X.R.axis[k].y;
    out.axes[6 + k] = X.R.axis[k].z;
  }
  store(km_point_velocity(V, X.p), out.velocity);
  store(V.w, out.angular_velocity);
  return out;
}

km_motion_sample km_user_sample(const km_mechanism *m, const km_state *s, km_forces *f) {
  km_moving_forces *moving = f->moving;
  for (int c = 0; c < m->coordinate_count; ++c) {
    moving->user_q[c] = km_state_value(s, c);
    moving->user_rate[c] = s->rate[c] / m->factor[c];
  }
  for (int i = 0; i < f->user.frame_count; ++i)
    moving->user_frames[i] = km_frame_motion_of(f, f->user.frames[i]);
  return (km_motion_sample){s->time, moving->user_q, moving->user_rate, moving->user_frames};
}

void km_user_forces_add(const km_mechanism *m, const km_state *s, km_forces *f) {
  km_moving_forces *moving = f->moving;
  const km_motion_sample sample = km_user_sample(m, s, f);
  memset(moving->user_joint, 0, (size_t)m->coordinate_count * sizeof *moving->user_joint);
  memset(moving->user_wrenches, 0, (size_t)f->user.frame_count * sizeof *moving->user_wrenches);
  moving->user_stopped = !f->user.compute(f->user.context, &sample, moving->user_joint, moving->user_wrenches);
  for (int c = 0; c < m->coordinate_count; ++c) {
    f->joint[c] += moving->user_joint[c];
    moving->motor_power += moving->user_joint[c] * s->rate[c];
  }
  for (int i = 0; i < f->user.frame_count; ++i) {
    int body = m->model->frames[f->user.frames[i]].body;
    km_vec3 point = km_vec3_sub(km_vec3_from_array(sample.frames[i].origin), f->origin);
    km_vec3 force = km_vec3_from_array(moving->user_wrenches[i]);
    km_vec3 moment = km_vec3_from_array(moving->user_wrenches[i] + 3);
    km_forces_add(f, body, force, moment, point);
    moving->motor_power += km_wrench_power(km_wrench_at(force, moment, point), f->twist[body]);
  }
}
