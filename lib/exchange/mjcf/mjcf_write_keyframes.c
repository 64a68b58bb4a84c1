/* Named poses as keyframes, which state every joint in the order of the file. */
#include "exchange/mjcf/mjcf_write.h"

#include <math.h>
#include <string.h>

void km_mjcf_remember(km_written *w, km_mjcf_order *order, km_mjcf_kind kind, int joint,
                      const km_written_motion *motion) {
  size_t need = (size_t)order->count + 1;
  if (!km_arena_grow(&w->arena, (void **)&order->kinds, &order->kind_room, need, sizeof *order->kinds) ||
      !km_arena_grow(&w->arena, (void **)&order->joints, &order->joint_room, need, sizeof *order->joints) ||
      !km_arena_grow(&w->arena, (void **)&order->motions, &order->motion_room, need, sizeof *order->motions))
    return;
  order->kinds[order->count] = kind;
  order->joints[order->count] = joint;
  order->motions[order->count++] = motion ? *motion : (km_written_motion){.coordinate = -1};
}

/* The coordinates at a named pose, radians and metres; those that it doesn't name are where the file has them. False: a
 * loop or a coupling binds one of these, so that it would have to follow. */
static bool values_at(const km_written *w, const km_model_pose *pose, bool *named, double *q) {
  const km_model *m = w->model;
  bool loops = w->ordered < m->joint_count || m->coupling_count > 0;
  memset(named, 0, (size_t)m->coordinate_count * sizeof *named);
  memcpy(q, w->q, (size_t)m->coordinate_count * sizeof *q);
  for (int i = 0; i < pose->count; ++i) {
    int c = pose->coordinates[i];
    named[c] = true;
    q[c] = pose->values[i] * km_model_coordinate_factor(m, c) * km_written_unit(w, c);
  }
  for (int c = 0; c < m->coordinate_count; ++c)
    if (loops && !named[c])
      return false;
  return true;
}

/* A ball counts from the pose that is written, turned in the child: R' = R(reference)ᵀ R(q). */
static int add_ball(const km_written *w, const km_written_motion *motion, const double *q, double *out) {
  km_pose from = km_written_motion_at(motion, w->reference), to = km_written_motion_at(motion, q);
  km_rotation back = km_rotation_inverse(&from.R), R = km_rotation_product(&back, &to.R);
  km_written_quaternion(&R, out);
  return 4;
}

/* A free body: where it is in the world. */
static int add_free(km_written *w, int joint, const double *q, double *out) {
  km_written_joint way = km_written_pass(w, joint, 0);
  km_pose X = km_written_through(&way, q);
  memcpy(out, &X.p, sizeof X.p);
  km_written_quaternion(&X.R, out + 3);
  return 7;
}

static void add_key(km_written *w, const km_mjcf_order *order, const char *name, const double *q) {
  double *numbers = KM_ARENA_NEW(&w->arena, double, 7 * (size_t)order->count);
  int count = 0;
  if (!numbers)
    return;
  for (int i = 0; i < order->count; ++i) {
    const km_written_motion *motion = &order->motions[i];
    if (order->kinds[i] == KM_MJCF_BALL)
      count += add_ball(w, motion, q, numbers + count);
    else if (order->kinds[i] == KM_MJCF_FREE)
      count += add_free(w, order->joints[i], q, numbers + count);
    else
      numbers[count++] = q[motion->coordinate] * (order->kinds[i] == KM_MJCF_SLIDE_OF_SCREW ? motion->pitch : 1.0);
  }
  km_xml_begin(&w->xml, "key");
  km_xml_set(&w->xml, "name", name);
  km_xml_set_numbers(&w->xml, "qpos", numbers, count, true);
  km_xml_end(&w->xml, "key");
}

void km_mjcf_write_keyframes(km_written *w, const km_mjcf_order *order) {
  const km_model *m = w->model;
  double *q = KM_ARENA_NEW(&w->arena, double, (size_t)m->coordinate_count);
  bool *named = KM_ARENA_NEW(&w->arena, bool, (size_t)m->coordinate_count);
  if (!q || !named)
    return;
  km_xml_begin(&w->xml, "keyframe");
  for (int i = 0; i < m->pose_count; ++i)
    if (values_at(w, &m->poses[i], named, q))
      add_key(w, order, m->poses[i].name, q);
    else
      km_written_omit(w, "named poses not written, as joints that they don't name would have to follow",
                      m->poses[i].name);
  km_xml_end(&w->xml, "keyframe");
}
