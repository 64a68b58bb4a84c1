/* Joints and couplings of a description, as calls of the builder. */
#include "exchange/robot/robot.h"

#include <string.h>

km_robot_joint km_robot_joint_default(void) {
  km_joint_def plain = km_joint_default();
  km_robot_joint joint = {
      .type = KM_RIGID, .in_parent = km_pose_identity(), .in_child = km_pose_identity(), .axis = {0, 0, 1}};
  memcpy(joint.low, plain.low, sizeof joint.low);
  memcpy(joint.high, plain.high, sizeof joint.high);
  memcpy(joint.max_rate, plain.max_rate, sizeof joint.max_rate);
  memcpy(joint.max_force, plain.max_force, sizeof joint.max_force);
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

/* Holds the coordinates whose limits are equal. */
static void lock(km_robot *robot, const km_robot_joint *joint, km_joint_id id) {
  km_error error;
  for (int k = 0; k < KM_MAX_FREEDOM && id.value; ++k) {
    km_status status = joint->locked[k]
                           ? km_model_add_hold(robot->builder, (km_coordinate_ref){id, k}, joint->position[k], &error)
                           : KM_OK;
    if (status)
      km_robot_builder_failed(robot, joint->at, status, &error);
  }
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
  def.parent = km_robot_place(robot, joint->at, joint->parent, joint->name, &parent);
  def.child = km_robot_place(robot, joint->at, joint->child, joint->name, &child);
  def.pitch = joint->pitch;
  def.most_turn = joint->most_turn;
  memcpy(def.position, joint->position, sizeof def.position);
  memcpy(def.damping, joint->damping, sizeof def.damping);
  memcpy(def.low, joint->low, sizeof def.low);
  memcpy(def.high, joint->high, sizeof def.high);
  memcpy(def.max_rate, joint->max_rate, sizeof def.max_rate);
  memcpy(def.max_force, joint->max_force, sizeof def.max_force);
  memcpy(def.armature, joint->armature, sizeof def.armature);
  memcpy(def.constant_friction, joint->friction, sizeof def.constant_friction);
  km_status status =
      def.parent.value && def.child.value ? km_model_add_joint(robot->builder, &def, &id, &error) : KM_OK;
  if (status) {
    km_robot_builder_failed(robot, joint->at, status, &error);
    return id;
  }
  km_robot_take_name(robot, &robot->joints, joint->assembly.value, km_robot_text(robot, "%s", joint->name), id.value);
  lock(robot, joint, id);
  return id;
}

void km_robot_spring(km_robot *robot, const km_xml *at, const char *name, km_coordinate_ref coordinate,
                     double stiffness, double rest) {
  if (stiffness == 0.0 || !coordinate.joint.value)
    return;
  int size = 2;
  const double piece[2] = {stiffness * rest, -stiffness};
  km_force_def def = km_force_default();
  km_error error;
  def.name = coordinate.index == 0 ? name : km_robot_text(robot, "%s:%d", name, coordinate.index + 1);
  def.coordinate = coordinate;
  def.piece_sizes = &size;
  def.coefficients = piece;
  km_status status = km_model_add_force(robot->builder, &def, &error);
  if (status == KM_MEMORY)
    robot->arena.failed = true;
  else if (status)
    km_robot_error(robot, at, "%s", error.text);
}

void km_robot_couple(km_robot *robot, const km_xml *at, const char *name, km_assembly_id assembly,
                     km_coordinate_ref one, km_coordinate_ref two, const double *c, int count) {
  km_error error;
  const km_coordinate_ref ends[2] = {one, two};
  const double ratios[2] = {1.0, -c[1]};
  bool second = two.joint.value != 0;
  while (count > 2 && c[count - 1] == 0.0)
    count--;
  km_coupling_def def = {.name = name, .assembly = assembly, .count = second ? 2 : 1, .coordinates = ends};
  if (second && count > 2) {
    def.polynomial = c;
    def.polynomial_count = count;
  } else {
    def.ratios = ratios;
    def.constant_given = true;
    def.constant = c[0];
  }
  if (!one.joint.value)
    return;
  km_status status = km_model_add_coupling(robot->builder, &def, &error);
  if (status)
    km_robot_builder_failed(robot, at, status, &error);
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
  } else if (low == high && isfinite(low)) {
    joint->locked[k] = true;
    joint->position[k] = low;
    km_robot_omit(robot, "joints locked at the one value that their limits allow", joint->name);
  } else {
    km_robot_omit(robot, "limits left out, as the lower one isn't below the upper one", joint->name);
  }
}

void km_robot_limit_turn(km_robot *robot, km_robot_joint *joint, double most) {
  if (most > 0.0)
    joint->most_turn = isfinite(most) ? most : 0.0;
  else
    km_robot_omit(robot, "limits left out, as the lower one isn't below the upper one", joint->name);
}

void km_robot_drive(km_robot *robot, km_robot_joint *joint, int k, double force, double rate) {
  if (force > 0.0)
    joint->max_force[k] = force;
  else
    km_robot_omit(robot, "limits of efforts left out, as they aren't above 0", joint->name);
  if (rate > 0.0)
    joint->max_rate[k] = rate;
  else
    km_robot_omit(robot, "limits of rates left out, as they aren't above 0", joint->name);
}

void km_robot_rotor(km_robot *robot, km_robot_joint *joint, int k, double armature, double friction) {
  joint->armature[k] = fmax(armature, 0.0);
  joint->friction[k] = fmax(friction, 0.0);
  if (armature < 0.0)
    km_robot_omit(robot, "inertias of rotors left out, as they are negative", joint->name);
  if (friction < 0.0)
    km_robot_omit(robot, "constant frictions left out, as they are negative", joint->name);
}
