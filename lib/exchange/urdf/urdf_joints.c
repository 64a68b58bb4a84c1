/* The joints of a robot, and those that follow others. */
#include "exchange/urdf/urdf.h"

#include "base/similar_names.h"

#include <string.h>

static const struct {
  const char *word;
  km_joint_type type;
} types[] = {{"revolute", KM_RZ},    {"continuous", KM_RZ},       {"prismatic", KM_TZ},
             {"fixed", KM_RIGID},    {"floating", KM_FLOAT},      {"planar", KM_PLANAR},
             {"ball", KM_SPHERICAL}, {"spherical", KM_SPHERICAL}, {"universal", KM_UNIVERSAL}};

static bool read_type(km_robot *robot, km_urdf_joint *joint) {
  const char *word = km_xml_attribute_of(joint->at, "type");
  for (size_t i = 0; word && i < sizeof types / sizeof *types; ++i)
    if (strcmp(types[i].word, word) == 0) {
      joint->type = types[i].type;
      return true;
    }
  km_robot_error(robot, joint->at,
                 "joint \"%.80s\": found the type \"%.40s\"; expected revolute, continuous, prismatic, fixed, floating "
                 "or planar",
                 joint->name, word ? word : "");
  return false;
}

static bool is_single(km_joint_type type) {
  return type == KM_RZ || type == KM_TZ;
}

static void read_joint(km_urdf *urdf, const km_xml *at) {
  km_robot *robot = urdf->robot;
  int index = urdf->joint_count++;
  km_urdf_joint *joint = &urdf->list[index];
  const char *name = km_xml_attribute_of(at, "name");
  *joint = (km_urdf_joint){.at = at, .name = name ? name : "", .mimics = -1, .type = KM_RIGID};
  if (!joint->name[0])
    km_robot_error(robot, at, "a joint without a name; expected name=\"…\"");
  else if (km_names_get(&urdf->joints, 0, name) >= 0)
    km_robot_error(robot, at, "joint \"%.80s\": this name is used twice; expected a name of its own", name);
  else if (!km_names_set(&urdf->joints, 0, name, index))
    robot->arena.failed = true;
  else
    read_type(robot, joint);
}

/* The body of <parent> or <child>; {0}: reported. `link`: its index, -1: the inertial frame. */
static km_body_id find_link(km_urdf *urdf, const km_urdf_joint *joint, const char *end, int *link) {
  const km_xml *at = km_xml_child(joint->at, end);
  const char *name = km_xml_attribute_of(at, "link");
  *link = name ? km_names_get(&urdf->links, 0, name) : -1;
  if (*link >= 0)
    return urdf->bodies[*link];
  if (name && strcmp(name, "world") == 0 && strcmp(end, "parent") == 0) {
    urdf->world_undeclared = true;
    return km_builder_fixed(urdf->robot->builder);
  }
  km_nearest nearest = {.wanted = name ? name : ""};
  for (int i = 0; i < urdf->link_count; ++i)
    if (urdf->elements[i])
      km_nearest_add(&nearest, km_xml_attribute_of(urdf->elements[i], "name"));
  char text[KM_NEAREST_TEXT];
  km_robot_error(urdf->robot, at ? at : joint->at,
                 "joint \"%.80s\": its %s is the link \"%.80s\", which isn't there; expected a link of the file; "
                 "nearest: %s",
                 joint->name, end, name ? name : "", km_nearest_text(&nearest, text));
  return (km_body_id){0};
}

static km_vec3 read_axis(km_robot *robot, const km_urdf_joint *joint) {
  const km_xml *axis = km_xml_child(joint->at, "axis");
  double u[3] = {1, 0, 0};
  bool needed = is_single(joint->type) || joint->type == KM_PLANAR;
  if (!needed)
    return (km_vec3){0, 0, 1};
  km_robot_numbers(robot, axis, "xyz", u, 3);
  double length = km_vec3_norm(km_vec3_from_array(u));
  if (length > 0.0)
    return km_vec3_scale(1.0 / length, km_vec3_from_array(u));
  km_robot_error(robot, axis, "joint \"%.80s\": its axis is 0 0 0; expected a direction", joint->name);
  return (km_vec3){0, 0, 1};
}

static double bound(km_robot *robot, const km_xml *limit, const char *key, double otherwise) {
  return km_robot_bound(robot, limit, key, km_xml_attribute_of(limit, key), otherwise);
}

static void read_limits(km_robot *robot, const km_urdf_joint *joint, km_robot_joint *def) {
  const km_xml *limit = km_xml_child(joint->at, "limit"), *dynamics = km_xml_child(joint->at, "dynamics");
  if (km_xml_child(joint->at, "safety_controller"))
    km_robot_omit(robot, "safety controllers left out", joint->name);
  if (!is_single(joint->type))
    return;
  def->damping[0] = km_robot_number(robot, dynamics, "damping", 0.0);
  km_robot_rotor(robot, def, 0, 0.0, km_robot_number(robot, dynamics, "friction", 0.0));
  km_robot_drive(robot, def, 0, bound(robot, limit, "effort", HUGE_VAL), bound(robot, limit, "velocity", HUGE_VAL));
  if (!limit || strcmp(km_xml_attribute_of(joint->at, "type"), "continuous") == 0)
    return;
  km_robot_limit(robot, def, 0, bound(robot, limit, "lower", 0.0), bound(robot, limit, "upper", 0.0));
  if (def->locked[0] && !(km_xml_attribute_of(limit, "lower") && km_xml_attribute_of(limit, "upper")))
    km_robot_warn(
        robot, limit,
        "joint \"%.80s\" is locked at 0, as a limit that isn't stated is 0; state lower and upper, or call its "
        "type continuous",
        joint->name);
}

static void add_joint(km_urdf *urdf, km_urdf_joint *joint) {
  km_robot *robot = urdf->robot;
  int parent, child;
  km_robot_joint def = km_robot_joint_default();
  def.at = joint->at;
  def.name = joint->name;
  def.assembly = urdf->assembly;
  def.type = joint->type;
  def.parent = find_link(urdf, joint, "parent", &parent);
  def.child = find_link(urdf, joint, "child", &child);
  def.in_parent = km_urdf_origin(robot, joint->at);
  def.axis = read_axis(robot, joint);
  km_robot_judge_origin(robot, km_xml_child(joint->at, "origin"));
  km_robot_judge_digits(km_xml_attribute_of(km_xml_child(joint->at, "axis"), "xyz"), 0.0, &robot->angles);
  def.position[0] = joint->position;
  read_limits(robot, joint, &def);
  if (child >= 0 && urdf->parents[child])
    km_robot_error(robot, joint->at,
                   "joint \"%.80s\": link \"%.80s\" is already the child of joint \"%.80s\"; expected a tree",
                   joint->name, km_xml_attribute_of(urdf->elements[child], "name"),
                   km_xml_attribute_of(urdf->parents[child], "name"));
  if (child >= 0)
    urdf->parents[child] = joint->at;
  km_urdf_tie(urdf, parent, child);
  if (!robot->failed)
    joint->id = km_robot_add_joint(robot, &def);
}

static void read_mimic(km_urdf *urdf, km_urdf_joint *joint) {
  km_robot *robot = urdf->robot;
  const km_xml *mimic = km_xml_child(joint->at, "mimic");
  const char *name = km_xml_attribute_of(mimic, "joint");
  if (!mimic)
    return;
  int index = name ? km_names_get(&urdf->joints, 0, name) : -1;
  if (index < 0) {
    km_robot_error(robot, mimic, "joint \"%.80s\" follows the joint \"%.80s\", which isn't there", joint->name,
                   name ? name : "");
    return;
  }
  joint->ratio = km_robot_number(robot, mimic, "multiplier", 1.0);
  joint->offset = km_robot_number(robot, mimic, "offset", 0.0);
  km_joint_type leader = urdf->list[index].type;
  if (!is_single(joint->type))
    km_robot_omit(robot, "followers that can't move left out", joint->name);
  else if (!is_single(leader) && leader != KM_RIGID) /* index of the followed coordinate */
    km_robot_omit(robot, "what follows joints with several coordinates moves by itself", joint->name);
  else
    joint->mimics = index;
}

/* The value in the file's pose: 0, or that which the joint that it follows gives. */
static void settle(km_urdf *urdf, int index) {
  km_urdf_joint *joint = &urdf->list[index];
  double value = 0.0, factor = 1.0;
  int at = index, steps = 0;
  for (; urdf->list[at].mimics >= 0 && steps <= urdf->joint_count; ++steps) {
    value += factor * urdf->list[at].offset;
    factor *= urdf->list[at].ratio;
    at = urdf->list[at].mimics;
  }
  if (steps > urdf->joint_count)
    km_robot_error(urdf->robot, joint->at, "joint \"%.80s\" follows itself; expected another joint", joint->name);
  joint->position = value;
}

static void couple(km_urdf *urdf, const km_urdf_joint *joint) {
  const km_urdf_joint *other = &urdf->list[joint->mimics];
  const double line[2] = {joint->offset, joint->ratio};
  km_coordinate_ref leader = {is_single(other->type) ? other->id : (km_joint_id){0}, 0};
  km_robot_couple(urdf->robot, joint->at, joint->name, urdf->assembly, (km_coordinate_ref){joint->id, 0}, leader, line,
                  2);
}

void km_urdf_read_joints(km_urdf *urdf, const km_xml *root) {
  for (const km_xml *e = km_xml_child(root, "joint"); e; e = km_xml_next(e))
    read_joint(urdf, e);
  for (int j = 0; j < urdf->joint_count; ++j)
    read_mimic(urdf, &urdf->list[j]);
  for (int j = 0; j < urdf->joint_count && !urdf->robot->failed; ++j)
    settle(urdf, j);
  for (int j = 0; j < urdf->joint_count; ++j)
    add_joint(urdf, &urdf->list[j]);
  for (int j = 0; j < urdf->joint_count && !urdf->robot->failed; ++j)
    if (urdf->list[j].mimics >= 0)
      couple(urdf, &urdf->list[j]);
}
