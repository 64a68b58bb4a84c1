/* Bodies, frames and joints of a description, as calls of the builder. */
#include "exchange/robot/robot.h"

#include "model/mass_properties.h"

#include <stdio.h>
#include <string.h>

/* A call of the builder failed: short of memory, or a fault that is told at the element. */
static void builder_failed(km_robot *robot, const km_xml *at, km_status status, const km_error *error) {
  if (status == KM_MEMORY)
    robot->arena.failed = true;
  else
    km_robot_error(robot, at, "%s", error->text);
}

const char *km_robot_free_name(km_robot *robot, const km_names *names, int scope, const char *name, const char *mark) {
  const char *free_name = name;
  for (int n = 1; km_names_get(names, scope, free_name) >= 0 || strcmp(free_name, "fixed") == 0 ||
                  strcmp(free_name, "origin") == 0 || !free_name[0];
       ++n) {
    if (robot->arena.failed)
      return name;
    free_name = n == 1 ? km_robot_text(robot, "%s:%s", name, mark) : km_robot_text(robot, "%s:%s%d", name, mark, n);
  }
  return free_name;
}

static void take_name(km_robot *robot, km_names *names, int scope, const char *name, int value) {
  if (!km_names_set(names, scope, name, value))
    robot->arena.failed = true;
}

km_assembly_id km_robot_assembly(km_robot *robot, const km_xml *at, const char *name, km_assembly_id parent) {
  km_assembly_id id = {0};
  km_error error;
  const char *own = name && name[0] ? name : "robot";
  own = strcmp(own, "fixed") == 0 ? "fixed:model" : own;
  km_status status = km_model_add_assembly(robot->builder, own, parent, &id, &error);
  if (status)
    builder_failed(robot, at, status, &error);
  return id;
}

/* A mass or an inertia that no body can have is dropped. */
static km_robot_mass sane_mass(km_robot *robot, const km_xml *at, const char *name, km_robot_mass mass) {
  double moments[3], size = 0.0;
  if (mass.mass < 0.0) {
    km_robot_warn(robot, at, "body \"%.80s\": its mass is %g; it is taken as 0", name, mass.mass);
    return (km_robot_mass){0};
  }
  for (int k = 0; k < 6; ++k)
    size = fmax(size, fabs(mass.inertia[k]));
  km_principal_moments(mass.inertia, moments);
  if (moments[0] < -1e-9 * size) {
    km_robot_warn(
        robot, at,
        "body \"%.80s\": a principal moment of inertia is negative, %.4g beside %.4g and %.4g; its inertia is "
        "taken as 0",
        name, moments[0], moments[1], moments[2]);
    memset(mass.inertia, 0, sizeof mass.inertia);
  }
  return mass;
}

km_body_id km_robot_body(km_robot *robot, const km_xml *at, km_assembly_id assembly, const char *name,
                         const km_robot_mass *mass, const char *mesh) {
  km_body_id id = {0};
  km_error error;
  km_robot_mass sane = mass ? sane_mass(robot, at, name, *mass) : (km_robot_mass){0};
  km_body_def def = km_body_default();
  if (!name[0]) {
    km_robot_error(robot, at, "found an empty name of a body; expected at least one character");
    return id;
  }
  def.name =
      strcmp(name, "fixed") == 0 ? km_robot_free_name(robot, &robot->bodies, assembly.value, name, "body") : name;
  def.assembly = assembly;
  def.mass = sane.mass;
  memcpy(def.center_of_mass, &sane.center, sizeof def.center_of_mass);
  memcpy(def.inertia, sane.inertia, sizeof def.inertia);
  def.mesh = mesh;
  km_status status = km_model_add_body(robot->builder, &def, &id, &error);
  if (status)
    builder_failed(robot, at, status, &error);
  else
    take_name(robot, &robot->bodies, assembly.value, km_robot_text(robot, "%s", def.name), id.value);
  return id;
}

static bool is_identity(const km_pose *pose) {
  double rows[9];
  bool same = pose->p.x == 0.0 && pose->p.y == 0.0 && pose->p.z == 0.0;
  km_rotation_rows(&pose->R, rows);
  for (int k = 0; k < 9; ++k)
    same = same && rows[k] == (k % 4 == 0);
  return same;
}

km_frame_id km_robot_frame(km_robot *robot, const km_xml *at, km_body_id body, const char *name, const km_pose *pose) {
  km_frame_id id = {0};
  km_error error;
  if (is_identity(pose))
    return km_builder_origin(robot->builder, body);
  km_frame_def def = km_frame_default();
  def.name = km_robot_free_name(robot, &robot->frames, body.value, name, "joint");
  memcpy(def.T, &pose->p, sizeof def.T);
  km_rotation_rows(&pose->R, def.R);
  robot->reach = fmax(robot->reach, km_vec3_norm(pose->p));
  km_status status = km_model_add_frame(robot->builder, body, &def, &id, &error);
  if (status)
    builder_failed(robot, at, status, &error);
  else
    take_name(robot, &robot->frames, body.value, km_robot_text(robot, "%s", def.name), id.value);
  return id;
}

km_robot_joint km_robot_joint_default(void) {
  km_joint_def plain = km_joint_default();
  km_robot_joint joint = {
      .type = KM_RIGID, .in_parent = km_pose_identity(), .in_child = km_pose_identity(), .axis = {0, 0, 1}};
  memcpy(joint.low, plain.low, sizeof joint.low);
  memcpy(joint.high, plain.high, sizeof joint.high);
  return joint;
}

/* The joint's letter and the turn of its frames that lays that letter's axis onto `axis`. */
static km_joint_type letter(const km_robot_joint *joint, km_rotation *turn) {
  const double u[3] = {joint->axis.x, joint->axis.y, joint->axis.z};
  *turn = km_rotation_identity();
  bool single = joint->type == KM_RZ || joint->type == KM_TZ;
  for (int k = 0; single && k < 3; ++k)
    if (u[k] == 1.0)
      return (km_joint_type)((joint->type == KM_RZ ? KM_RX : KM_TX) + k);
  *turn = km_rotation_onto(2, joint->axis);
  return joint->type;
}

static bool has_axis(km_joint_type type) {
  return type == KM_RZ || type == KM_TZ || type == KM_CYLINDRICAL || type == KM_PLANAR || type == KM_SCREW;
}

km_joint_id km_robot_add_joint(km_robot *robot, const km_robot_joint *joint) {
  km_joint_id id = {0};
  km_error error;
  km_rotation turn = km_rotation_identity();
  if (joint->parent.value == 0 || joint->child.value == 0)
    return id;
  if (km_names_get(&robot->joints, joint->assembly.value, joint->name) > 0) {
    km_robot_error(robot, joint->at, "joint \"%.80s\": this name is used twice; expected a name of its own",
                   joint->name);
    return id;
  }
  km_joint_def def = km_joint_default();
  def.type = has_axis(joint->type) ? letter(joint, &turn) : joint->type;
  km_pose about = {turn, {0, 0, 0}};
  km_pose parent = km_pose_product(&joint->in_parent, &about), child = km_pose_product(&joint->in_child, &about);
  def.name = joint->name;
  def.assembly = joint->assembly;
  def.parent = km_robot_frame(robot, joint->at, joint->parent, joint->name, &parent);
  def.child = km_robot_frame(robot, joint->at, joint->child, joint->name, &child);
  def.pitch = joint->pitch;
  memcpy(def.position, joint->position, sizeof def.position);
  memcpy(def.damping, joint->damping, sizeof def.damping);
  memcpy(def.low, joint->low, sizeof def.low);
  memcpy(def.high, joint->high, sizeof def.high);
  km_status status =
      def.parent.value && def.child.value ? km_model_add_joint(robot->builder, &def, &id, &error) : KM_OK;
  if (status)
    builder_failed(robot, joint->at, status, &error);
  else
    take_name(robot, &robot->joints, joint->assembly.value, km_robot_text(robot, "%s", joint->name), id.value);
  return id;
}

void km_robot_couple(km_robot *robot, const km_xml *at, const char *name, km_assembly_id assembly,
                     km_coordinate_ref one, km_coordinate_ref two, double ratio) {
  km_error error;
  const km_coordinate_ref ends[2] = {one, two};
  const double ratios[2] = {1.0, -ratio};
  int count = two.joint.value ? 2 : 1;
  if (!one.joint.value)
    return;
  km_status status =
      km_model_add_coupling(robot->builder, &(km_coupling_def){name, assembly, count, ends, ratios}, &error);
  if (status)
    builder_failed(robot, at, status, &error);
}

void km_robot_tie(km_robot *robot, const km_xml *at, km_assembly_id assembly, km_body_id body, const char *name,
                  const km_pose *pose, bool floating) {
  km_robot_joint joint = km_robot_joint_default();
  joint.at = at;
  joint.assembly = assembly;
  joint.name = km_robot_free_name(robot, &robot->joints, assembly.value, name, "tie");
  joint.parent = km_builder_fixed(robot->builder);
  joint.child = body;
  if (floating) {
    km_vec3 turn = km_quaternion_log(km_rotation_quaternion(&pose->R));
    joint.type = KM_FLOAT;
    memcpy(joint.position, &pose->p, sizeof pose->p);
    memcpy(joint.position + 3, &turn, sizeof turn);
  } else {
    joint.in_parent = *pose;
  }
  km_robot_add_joint(robot, &joint);
}

void km_robot_limit(km_robot *robot, km_robot_joint *joint, int k, double low, double high) {
  if (low < high) {
    joint->low[k] = low;
    joint->high[k] = high;
    if (joint->position[k] < low || joint->position[k] > high)
      km_robot_omit(robot, "joints that start outside of their limits", joint->name);
  } else {
    km_robot_omit(robot, "limits left out, as the lower one isn't below the upper one", joint->name);
  }
}
