/* Keyframes as named poses. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static int numbers_of(km_joint_type type) {
  return type == KM_FLOAT ? 7 : type == KM_SPHERICAL ? 4 : 1;
}

/* Converts position and quaternion of MJCF to the joint's coordinates. */
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
  bool none = q[0] == 0.0 && q[1] == 0.0 && q[2] == 0.0 && q[3] == 0.0; /* MuJoCo treats it as the identity */
  km_quaternion turned = {none ? 1.0 : q[0], q[1], q[2], q[3]};
  km_vec3 turn = km_quaternion_log(km_quaternion_normalised(turned));
  memcpy(out + count, &turn, sizeof turn);
  return count + 3;
}

/* A keyframe's name: with those that it is attached under. */
static const char *name_of(km_mjcf *m, const km_xml *key, int index) {
  const char *name = km_xml_attribute_of(key, "name");
  return km_mjcf_full(m, name && name[0] ? name : km_robot_text(m->robot, "key%d", index));
}

/* Range of a keyframe's numbers for the joints read: after `skipped` numbers, of `all`. */
typedef struct span {
  int skipped, all;
} span;

static void read_key(km_mjcf *m, const km_xml *key, int index, int first_joint, span numbers) {
  km_robot *robot = m->robot;
  const char *text = km_xml_attribute_of(key, "qpos");
  size_t room = (size_t)(KM_MAX_FREEDOM * (m->joint_count - first_joint));
  double *given = KM_ARENA_NEW(&robot->arena, double, (size_t)numbers.all),
         *values = KM_ARENA_NEW(&robot->arena, double, room);
  km_coordinate_ref *refs = KM_ARENA_NEW(&robot->arena, km_coordinate_ref, room);
  int count = 0;
  km_error error;
  if (text && km_robot_count(text) != numbers.all) {
    km_robot_omit(robot, "keyframes left out, as their numbers don't fit the joints", name_of(m, key, index));
    return;
  }
  if (robot->arena.failed || !text || !km_robot_parse(robot, key, "qpos", text, given, numbers.all))
    return;
  given += numbers.skipped;
  for (int j = first_joint; j < m->joint_count; ++j) {
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

static void read_keys(km_mjcf *m, int first_joint, span numbers) {
  int index = 0;
  for (const km_xml *list = km_xml_child(m->root, "keyframe"); list; list = km_xml_next(list))
    for (const km_xml *key = km_xml_child(list, "key"); key; key = km_xml_next(key))
      read_key(m, key, index++, first_joint, numbers);
}

static int count_numbers(const km_mjcf *m, int first_joint) {
  int numbers = 0;
  for (int j = first_joint; j < m->joint_count; ++j)
    numbers += numbers_of(m->joints[j].type);
  return numbers;
}

void km_mjcf_read_keyframes(km_mjcf *m) {
  read_keys(m, 0, (span){0, count_numbers(m, 0)});
}

typedef struct counting {
  const km_xml *part; /* a body, up to which is counted; NULL: to the end */
  bool bodies;        /* they follow the joints of the enclosing body, whatever their position in the text */
  int numbers;
  bool met, open; /* open: another model is attached there, whose joints aren't known */
} counting;

static void count_members(km_mjcf *m, const km_xml *body, const km_mjcf_place *place, counting *c);

static void count_member(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, void *context) {
  counting *c = context;
  bool body = strcmp(e->name, "body") == 0, joint = strcmp(e->name, "joint") == 0;
  c->met = c->met || (c->bodies && e == c->part);
  if (c->met)
    return;
  if (c->bodies && body)
    count_members(m, e, place, c);
  c->open = c->open || strcmp(e->name, "attach") == 0;
  if (!c->bodies && (joint || strcmp(e->name, "freejoint") == 0))
    c->numbers += numbers_of(km_mjcf_joint_type(m, e, place));
}

/* Adds up the numbers of the joints of a body and of those inside. */
static void count_members(km_mjcf *m, const km_xml *body, const km_mjcf_place *place, counting *c) {
  const char *class = km_xml_attribute_of(body, "childclass");
  const km_mjcf_place inside = {km_pose_identity(), class ? class : place->class, ""};
  c->bodies = false;
  km_mjcf_walk(m, body, &inside, count_member, c);
  c->bodies = true;
  km_mjcf_walk(m, body, &inside, count_member, c);
}

/* The first body in a part of a model. */
static const km_xml *first_body(const km_xml *part) {
  for (const km_xml *e = part; e; e = e->next) {
    const km_xml *found = strcmp(e->name, "body") == 0 ? e : e->first ? first_body(e->first) : NULL;
    if (found)
      return found;
  }
  return NULL;
}

/* Number of a keyframe's numbers before the part; false if unknown. */
static bool count_before(km_mjcf *m, const km_xml *part, int *numbers) {
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  counting c = {.part = part};
  int copies = m->copies;
  for (const km_xml *world = km_xml_child(m->root, "worldbody"); world && !c.met; world = km_xml_next(world))
    count_members(m, world, &place, &c);
  m->copies = copies;
  *numbers = c.numbers;
  return !c.open && (c.met || !part);
}

void km_mjcf_read_attached_keyframes(km_mjcf *m, const km_xml *part, int first_joint) {
  span numbers = {0, count_numbers(m, first_joint)};
  const km_xml *list = km_xml_child(m->root, "keyframe");
  bool whole = strcmp(part->name, "worldbody") == 0, told = whole;
  if (!whole && list)
    told = count_before(m, strcmp(part->name, "body") == 0 ? part : first_body(part->first), &numbers.skipped) &&
           count_before(m, NULL, &numbers.all);
  if (told)
    read_keys(m, first_joint, numbers);
  else if (list)
    km_robot_omit(m->robot, "keyframes left out, as their numbers don't fit the joints", name_of(m, list->first, 0));
}
