/* Keyframes as named poses. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static int numbers_of(km_joint_type type) {
  return type == KM_FLOAT ? 7 : type == KM_SPHERICAL ? 4 : 1;
}

/* What MJCF tells by a place and a quaternion, as the joint's coordinates. */
static int take(km_joint_type type, const double *q, double out[KM_MAX_FREEDOM]) {
  int count = 0;
  if (type != KM_SPHERICAL && type != KM_FLOAT) {
    out[0] = q[0];
    return 1;
  }
  if (type == KM_FLOAT) {
    memcpy(out, q, 3 * sizeof *q);
    q += count = 3;
  }
  km_vec3 turn = km_quaternion_log(km_quaternion_normalised((km_quaternion){q[0], q[1], q[2], q[3]}));
  memcpy(out + count, &turn, sizeof turn);
  return count + 3;
}

static int count_words(const char *text) {
  static const char blanks[] = " \t\r\n";
  int count = 0;
  for (text += strspn(text, blanks); *text; text += strspn(text, blanks), ++count)
    text += strcspn(text, blanks);
  return count;
}

static const char *name_of(km_mjcf *m, const km_xml *key, int index) {
  const char *name = km_xml_attribute_of(key, "name");
  return name && name[0] ? name : km_robot_text(m->robot, "key%d", index);
}

static void read_key(km_mjcf *m, const km_xml *key, int index, int numbers) {
  km_robot *robot = m->robot;
  const char *text = km_xml_attribute_of(key, "qpos");
  size_t room = (size_t)(KM_MAX_FREEDOM * m->joint_count);
  double *given = KM_ARENA_NEW(&robot->arena, double, (size_t)numbers),
         *values = KM_ARENA_NEW(&robot->arena, double, room);
  km_coordinate_ref *refs = KM_ARENA_NEW(&robot->arena, km_coordinate_ref, room);
  int count = 0;
  km_error error;
  if (text && count_words(text) != numbers) {
    km_robot_omit(robot, "keyframes left out, as their numbers don't fit the joints", name_of(m, key, index));
    return;
  }
  if (robot->arena.failed || !text || !km_robot_parse(robot, key, "qpos", text, given, numbers))
    return;
  for (int j = 0; j < m->joint_count; ++j) {
    int taken = take(m->joints[j].type, given, values + count);
    given += numbers_of(m->joints[j].type);
    for (int k = 0; k < taken; ++k)
      refs[count + k] = (km_coordinate_ref){m->joints[j].id, k};
    count += taken;
  }
  km_status status = km_model_add_pose(robot->builder, name_of(m, key, index), refs, values, count, &error);
  if (status)
    km_robot_builder_failed(robot, key, status, &error);
}

void km_mjcf_read_keyframes(km_mjcf *m) {
  int numbers = 0, index = 0;
  for (int j = 0; j < m->joint_count; ++j)
    numbers += numbers_of(m->joints[j].type);
  for (const km_xml *list = km_xml_child(m->root, "keyframe"); list; list = km_xml_next(list))
    for (const km_xml *key = km_xml_child(list, "key"); key; key = km_xml_next(key))
      read_key(m, key, index++, numbers);
}
