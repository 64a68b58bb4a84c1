/* Joints inside of bodies. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static const struct {
  const char *word;
  km_joint_type type;
} types[] = {{"hinge", KM_RZ}, {"slide", KM_TZ}, {"ball", KM_SPHERICAL}, {"free", KM_FLOAT}};

km_joint_type km_mjcf_joint_type(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  const char *word = strcmp(e->name, "freejoint") == 0 ? "free" : km_mjcf_get(m, e, place, "type");
  word = word ? word : "hinge";
  for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
    if (strcmp(types[i].word, word) == 0)
      return types[i].type;
  km_robot_error(m->robot, e, "type: found \"%.40s\"; expected hinge, slide, ball or free", word);
  return KM_RZ;
}

static const char *name_of(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, const char *body) {
  const char *name = km_xml_attribute_of(e, "name");
  if (name && name[0])
    return km_robot_text(m->robot, "%s%s%s", m->prefix, name, place->suffix);
  return km_robot_free_name(m->robot, &m->robot->joints, m->assembly.value, body, "joint");
}

static void remember(km_mjcf *m, const char *name, km_joint_id id, km_joint_type type, double reference) {
  km_robot *robot = m->robot;
  if (!km_arena_grow(&robot->arena, (void **)&m->joints, &m->joint_room, (size_t)m->joint_count + 1,
                     sizeof *m->joints) ||
      !km_names_set(&m->joint_names, 0, name, m->joint_count))
    robot->arena.failed = true;
  else
    m->joints[m->joint_count++] = (km_mjcf_joint){name, id, type, reference};
}

/* As in the other formats, what no joint reaches is no limit. */
static double bound(double value) {
  return fabs(value) < 1e15 ? value : copysign(HUGE_VAL, value);
}

static void read_limits(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, km_robot_joint *joint, double unit) {
  const char *limited = km_mjcf_get(m, e, place, "limited");
  double range[2] = {0.0, 0.0};
  bool given = km_mjcf_numbers(m, e, place, "range", range, 2) == 2 && (range[0] != 0.0 || range[1] != 0.0);
  bool automatic = !limited || strcmp(limited, "auto") == 0; /* MuJoCo then takes a range of 0 0 for none */
  if (!(automatic ? given && m->compiler.autolimits : strcmp(limited, "true") == 0))
    return;
  if (joint->type == KM_SPHERICAL)
    km_robot_limit_turn(m->robot, joint, bound(range[1]) * unit);
  else
    km_robot_limit(m->robot, joint, 0, bound(range[0]) * unit, bound(range[1]) * unit);
}

/* Springs and dampers that are to be found from the inertia and a time constant. */
static bool is_timed(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  double timed[2] = {0};
  return km_mjcf_numbers(m, e, place, "springdamper", timed, 2) == 2 && timed[0] > 0.0 && timed[1] > 0.0;
}

/* The springs of a joint's coordinates; those of a ball are at rest in the file's pose. */
static void add_springs(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, const km_robot_joint *joint,
                        km_joint_id id, double unit) {
  double k = km_mjcf_number(m, e, place, "stiffness", 0.0), rest = km_mjcf_number(m, e, place, "springref", 0.0);
  if (is_timed(m, e, place)) {
    km_robot_omit(m->robot, "springs and dampers by time constants left out", joint->name);
    return;
  }
  for (int c = 0; c < km_joint_kind_of(joint->type)->freedom; ++c)
    km_robot_spring(m->robot, e, joint->name, (km_coordinate_ref){id, c}, k,
                    joint->type == KM_SPHERICAL ? 0.0 : unit * rest);
}

/* The largest force of actuators together that the joint lets through; infinite: any. */
static double accept_event(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  double range[2] = {0};
  const char *limited = km_mjcf_get(m, e, place, "actuatorfrclimited");
  bool given = km_mjcf_numbers(m, e, place, "actuatorfrcrange", range, 2) == 2;
  bool counts =
      given && (limited && strcmp(limited, "auto") != 0 ? strcmp(limited, "true") == 0 : m->compiler.autolimits);
  return counts ? fmax(fabs(range[0]), fabs(range[1])) : HUGE_VAL;
}

/* Damping, friction, rotor and drive: the same for each coordinate. */
static void read_dynamics(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, km_robot_joint *joint) {
  double damping = is_timed(m, e, place) ? 0.0 : km_mjcf_number(m, e, place, "damping", 0.0);
  double armature = km_mjcf_number(m, e, place, "armature", 0.0);
  double friction = km_mjcf_number(m, e, place, "frictionloss", 0.0);
  double force = fmin(accept_event(m, e, place), km_mjcf_most_force(m, joint->name));
  for (int k = 0; k < km_joint_kind_of(joint->type)->freedom; ++k) {
    joint->damping[k] = damping;
    km_robot_rotor(m->robot, joint, k, armature, friction);
    km_robot_drive(m->robot, joint, k, force, HUGE_VAL);
  }
}

/* Damping of a free body's velocity and angular velocity. */
static void read_free_dynamics(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, km_robot_joint *joint) {
  static const char *const others[] = {"stiffness", "armature", "frictionloss"};
  bool more = false;
  for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
    more = more || km_mjcf_number(m, e, place, others[i], 0.0) != 0.0;
  if (more)
    km_robot_omit(m->robot, "springs, rotors and friction of free joints left out", joint->name);
  for (int k = 0; k < km_joint_kind_of(joint->type)->freedom; ++k)
    joint->damping[k] = km_mjcf_number(m, e, place, "damping", 0.0);
}

/* The free pose of a body: its coordinates are its pose in the world. */
static void set_free(km_robot_joint *joint, const km_pose *pose) {
  km_vec3 turn = km_quaternion_log(km_rotation_quaternion(&pose->R));
  memcpy(joint->position, &pose->p, sizeof pose->p);
  memcpy(joint->position + 3, &turn, sizeof turn);
}

/* Adds the frames at the anchor. The coordinate has the reference value in the configuration of the file. */
static void set_single(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, const km_mjcf_link *link,
                       km_robot_joint *joint, double unit) {
  double p[3] = {0}, u[3] = {0, 0, 1};
  double reference = unit * km_mjcf_number(m, e, place, "ref", 0.0);
  km_mjcf_numbers(m, e, place, "pos", p, 3);
  if (km_mjcf_numbers(m, e, place, "axis", u, 3) == 3)
    km_robot_judge_digits(km_mjcf_get(m, e, place, "axis"), 0.0, &m->robot->angles);
  joint->axis = km_mjcf_unit(m->robot, e, "axis", u);
  km_pose anchor = {km_rotation_identity(), km_vec3_from_array(p)}, back = km_pose_identity();
  joint->in_child = km_pose_product(&place->pose, &anchor);
  joint->in_parent = km_pose_product(&link->pose, &joint->in_child);
  km_vec3 way = km_vec3_scale(-reference, joint->axis);
  if (joint->type == KM_RZ && reference != 0.0)
    back.R = km_quaternion_rotation(km_quaternion_exp(way));
  else if (joint->type == KM_TZ)
    back.p = way;
  joint->in_parent = km_pose_product(&joint->in_parent, &back);
  joint->position[0] = reference + km_mjcf_start_offset(m, joint->name);
}

void km_mjcf_add_joint(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, const km_mjcf_link *link) {
  km_robot_joint joint = km_robot_joint_default();
  joint.type = km_mjcf_joint_type(m, e, place);
  bool single = joint.type == KM_RZ || joint.type == KM_TZ;
  double unit = joint.type == KM_TZ ? 1.0 : m->compiler.angle;
  joint.at = e;
  joint.name = name_of(m, e, place, link->body);
  joint.assembly = m->assembly;
  joint.parent = link->parent;
  joint.child = link->child;
  if (joint.type == KM_FLOAT && !link->on_world)
    km_robot_error(m->robot, e,
                   "joint \"%.80s\": a free joint inside of a body; expected it only in the world's bodies",
                   joint.name);
  if (joint.type == KM_FLOAT) {
    set_free(&joint, &link->pose);
    read_free_dynamics(m, e, place, &joint);
  } else {
    set_single(m, e, place, link, &joint, single ? unit : 0.0);
    read_limits(m, e, place, &joint, unit);
    read_dynamics(m, e, place, &joint);
  }
  if (m->robot->failed)
    return;
  km_joint_id id = km_robot_add_joint(m->robot, &joint);
  if (!id.value)
    return;
  remember(m, joint.name, id, joint.type, single ? unit * km_mjcf_number(m, e, place, "ref", 0.0) : 0.0);
  if (joint.type != KM_FLOAT)
    add_springs(m, e, place, &joint, id, unit);
}
