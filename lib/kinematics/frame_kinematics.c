/* Pose, twist and Jacobian of one frame.
 *
 *   J_j = ±h_j at the frame's origin, of the joints between the inertial frame and the body along the spanning tree
 *
 * J is that of the tree: v = dp/dt of the frame's origin, ω of its body, along the inertial axes. The rate of a chord
 * has no column (0). With loops only rates in range(N) are possible, so the twists of a frame are J N. */
#include "base/arguments.h"
#include "kinematics/body_poses.h"

#include <string.h>

static km_status check_frame(const km_mechanism *m, const km_state *s, int frame, const void *out, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  return status ? status : km_check_index(frame, m->model->frame_count, "frame", error);
}

static km_pose frame_pose(const km_mechanism *m, const km_state *s, int frame) {
  const km_model_frame *def = &m->model->frames[frame];
  return km_pose_product(&s->pose[def->body], &def->pose);
}

km_status km_frame_pose_make(const double p[3], const double turn[3], km_frame_pose *out, km_error *error) {
  km_status status = km_check_given(p && turn && out, "place, rotation vector or place for the result", error);
  for (int k = 0; k < 3 && !status; ++k)
    if (!isfinite(p[k]) || !isfinite(turn[k]))
      status = km_fail(error, KM_USAGE, "a pose of %g and %g; expected finite numbers", p[k], turn[k]);
  if (status)
    return status;
  const km_pose pose = {km_quaternion_rotation(km_quaternion_exp(km_vec3_from_array(turn))), km_vec3_from_array(p)};
  km_pose_write(&pose, out);
  return KM_OK;
}

/* Converts a pose to the public structure, row-major. */
void km_pose_write(const km_pose *X, km_frame_pose *out) {
  km_rotation_rows(&X->R, out->R);
  km_vec3_write(X->p, out->p);
}

/* Pose of a frame in the inertial frame. */
km_status km_frame_place(const km_mechanism *m, const km_state *s, int frame, km_frame_pose *out, km_error *error) {
  km_status status = check_frame(m, s, frame, out, error);
  if (status)
    return status;
  km_pose X = frame_pose(m, s, frame);
  km_pose_write(&X, out);
  return KM_OK;
}

/* Unit twist of a coordinate at the point p, in the sense away from the inertial frame. */
static km_twist column_at_point(const km_mechanism *m, const km_state *s, int coordinate, bool is_reversed, km_vec3 p) {
  km_twist t = km_coordinate_twist(m, s, coordinate), none = {{0, 0, 0}, {0, 0, 0}};
  t.v = km_vec3_add(t.v, km_vec3_cross(t.w, p));
  return km_twist_axpy(is_reversed ? -1.0 : 1.0, t, none);
}

/* Tree Jacobian of a frame: a column per coordinate between its body and the inertial frame. */
km_status km_frame_jacobian(const km_mechanism *m, const km_state *s, int frame, double *J, km_error *error) {
  km_status status = check_frame(m, s, frame, J, error);
  if (status)
    return status;
  km_vec3 p = frame_pose(m, s, frame).p;
  memset(J, 0, 6 * (size_t)m->coordinate_count * sizeof *J);
  for (int body = m->model->frames[frame].body; body > 0; body = m->topology.parent[body]) {
    int joint = m->topology.arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      km_twist t = column_at_point(m, s, c, m->topology.is_reversed[joint], p);
      const double column[6] = {t.v.x, t.v.y, t.v.z, t.w.x, t.w.y, t.w.z};
      if (!m->held[c])
        memcpy(J + 6 * (size_t)c, column, sizeof column);
    }
  }
  return KM_OK;
}

/* Twist of a frame: sum of the joint twists along the tree, shifted to the frame's origin. */
km_status km_frame_twist(const km_mechanism *m, const km_state *s, int frame, const double *rates, double twist[6],
                         km_error *error) {
  km_status status = check_frame(m, s, frame, twist, error);
  if (!status)
    status = km_check_given(rates != NULL, "rates", error);
  if (status)
    return status;
  km_vec3 p = frame_pose(m, s, frame).p;
  km_twist sum = km_body_twist(m, s, m->model->frames[frame].body, rates);
  sum.v = km_vec3_add(sum.v, km_vec3_cross(sum.w, p));
  const double values[6] = {sum.v.x, sum.v.y, sum.v.z, sum.w.x, sum.w.y, sum.w.z};
  memcpy(twist, values, sizeof values);
  return KM_OK;
}
