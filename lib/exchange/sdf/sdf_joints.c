/* Joints of all models, and what ties the rest to the world. */
#include "exchange/sdf/sdf.h"
#include "exchange/sdf/sdf_closures.h"

#include <string.h>

static const struct {
  const char *word;
  km_joint_type type;
} types[] = {{"revolute", KM_RZ},    {"continuous", KM_RZ},       {"prismatic", KM_TZ},        {"fixed", KM_RIGID},
             {"ball", KM_SPHERICAL}, {"universal", KM_UNIVERSAL}, {"revolute2", KM_UNIVERSAL}, {"screw", KM_SCREW}};

static const char *type_of(const km_sdf_entity *joint) {
  const char *word = km_xml_attribute_of(joint->at, "type");
  return word ? word : "";
}

static bool is_continuous(const km_sdf_entity *joint) {
  return strcmp(type_of(joint), "continuous") == 0;
}

static bool find_type(km_sdf *sdf, const km_sdf_entity *joint, km_joint_type *out) {
  for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
    if (strcmp(types[i].word, type_of(joint)) == 0) {
      *out = types[i].type;
      return true;
    }
  km_robot_error(sdf->robot, joint->at,
                 "joint \"%.80s\": found the type \"%.40s\"; expected revolute, continuous, prismatic, fixed, ball, "
                 "universal, revolute2, screw or gearbox",
                 joint->name, type_of(joint));
  return false;
}

km_vec3 km_sdf_axis(km_sdf *sdf, int joint, const km_xml *axis) {
  const km_sdf_entity *e = &sdf->entities[joint];
  const km_xml *xyz = km_xml_child(axis, "xyz");
  const char *in = km_xml_attribute_of(xyz, "expressed_in"), *old = km_sdf_text(axis, "use_parent_model_frame");
  double u[3] = {0, 0, 1};
  if (xyz && km_robot_parse(sdf->robot, xyz, "xyz", xyz->text, u, 3))
    km_robot_judge_digits(xyz->text, 0.0, &sdf->robot->angles);
  double length = km_vec3_norm(km_vec3_from_array(u));
  km_vec3 unit = length > 0.0 ? km_vec3_scale(1.0 / length, km_vec3_from_array(u)) : (km_vec3){0, 0, 1};
  if (!(length > 0.0))
    km_robot_error(sdf->robot, xyz, "joint \"%.80s\": its axis is 0 0 0; expected a direction", e->name);
  bool of_model = sdf->entities[e->home].old_axes || strcmp(old, "true") == 0 || strcmp(old, "1") == 0;
  int frame = in && in[0] ? km_sdf_need(sdf, e->home, in, xyz, "frame") : of_model ? e->home : -1;
  if (frame < 0 || frame == joint)
    return unit;
  km_vec3 turned = km_rotate_back(&e->world.R, km_rotate(&sdf->entities[frame].world.R, unit));
  return km_vec3_scale(1.0 / km_vec3_norm(turned), turned);
}

static void add_spring(km_sdf *sdf, const km_sdf_entity *e, const km_xml *axis, const char *name,
                       km_coordinate_ref coordinate) {
  const km_xml *dynamics = km_xml_child(axis, "dynamics");
  km_robot_spring(sdf->robot, e->at, name, coordinate, km_sdf_number(sdf->robot, dynamics, "spring_stiffness", 0.0),
                  km_sdf_number(sdf->robot, dynamics, "spring_reference", 0.0));
}

static double bound(km_robot *robot, const km_xml *limit, const char *key, double otherwise) {
  return km_robot_bound(robot, limit, key, km_sdf_text(limit, key), otherwise);
}

/* A negative effort or velocity means that there is no limit. */
static double most(km_robot *robot, const km_xml *limit, const char *key) {
  double value = bound(robot, limit, key, HUGE_VAL);
  return value < 0.0 ? HUGE_VAL : value;
}

void km_sdf_read_axis(km_robot *robot, const km_xml *axis, bool is_continuous, int k, km_robot_joint *joint) {
  const km_xml *limit = km_xml_child(axis, "limit"), *dynamics = km_xml_child(axis, "dynamics");
  joint->damping[k] = km_sdf_number(robot, dynamics, "damping", 0.0);
  km_robot_rotor(robot, joint, k, 0.0, km_sdf_number(robot, dynamics, "friction", 0.0));
  km_robot_drive(robot, joint, k, most(robot, limit, "effort"), most(robot, limit, "velocity"));
  if (limit && !is_continuous)
    km_robot_limit(robot, joint, k, bound(robot, limit, "lower", -HUGE_VAL), bound(robot, limit, "upper", HUGE_VAL));
}

/* The older `thread_pitch` counts radians per metre, and the other way. */
double km_sdf_pitch(km_robot *robot, const km_xml *e) {
  double newer = km_sdf_number(robot, e, "screw_thread_pitch", 0.0);
  double older = km_sdf_number(robot, e, "thread_pitch", 1.0);
  const char *name = km_xml_attribute_of(e, "name");
  if (newer == 0.0 && older == 0.0)
    km_robot_error(robot, e, "joint \"%.80s\": its thread_pitch is 0; expected another number", name ? name : "");
  return newer != 0.0 ? newer : -2.0 * M_PI / (older != 0.0 ? older : 1.0);
}

static km_pose from(const km_pose *link, const km_pose *world) {
  km_pose back = km_pose_inverse(link);
  return km_pose_product(&back, world);
}

/* Two hinges: of a universal joint where their axes are at right angles, else with a massless body between. */
static void add_two_hinges(km_sdf *sdf, int index, km_robot_joint *joint) {
  km_robot *robot = sdf->robot;
  const km_sdf_entity *e = &sdf->entities[index];
  const km_xml *first = km_xml_child(e->at, "axis"), *second = km_xml_child(e->at, "axis2");
  km_vec3 a = km_sdf_axis(sdf, index, first), b = km_sdf_axis(sdf, index, second);
  if (fabs(km_vec3_dot(a, b)) < 1e-9) {
    km_rotation axes = {{a, b, km_vec3_cross(a, b)}};
    km_pose turn = {km_rotation_orthonormal(&axes), {0, 0, 0}};
    joint->in_parent = km_pose_product(&joint->in_parent, &turn);
    joint->in_child = km_pose_product(&joint->in_child, &turn);
    for (int k = 0; k < 2; ++k)
      joint->position[k] = km_sdf_start(sdf, index, k);
    km_sdf_read_axis(robot, first, false, 0, joint);
    km_sdf_read_axis(robot, second, false, 1, joint);
    km_joint_id id = km_robot_add_joint(robot, joint);
    for (int k = 0; k < 2; ++k)
      sdf->axes[index][k] = (km_coordinate_ref){id, k};
    add_spring(sdf, e, first, joint->name, (km_coordinate_ref){id, 0});
    add_spring(sdf, e, second, joint->name, (km_coordinate_ref){id, 1});
    return;
  }
  const char *between = km_robot_free_name(robot, &robot->bodies, joint->assembly.value, e->name, "between");
  km_robot_joint other = *joint;
  joint->type = other.type = KM_RZ;
  joint->axis = a;
  other.axis = b;
  joint->child = other.parent = km_robot_body(robot, e->at, joint->assembly, between, NULL, NULL);
  joint->in_child = other.in_parent = km_pose_identity();
  other.name =
      km_robot_free_name(robot, &robot->joints, joint->assembly.value, km_robot_text(robot, "%s:2", e->name), "axis");
  joint->position[0] = km_sdf_start(sdf, index, 0);
  other.position[0] = km_sdf_start(sdf, index, 1);
  km_sdf_read_axis(robot, first, false, 0, joint);
  km_sdf_read_axis(robot, second, false, 0, &other);
  sdf->axes[index][0] = (km_coordinate_ref){km_robot_add_joint(robot, joint), 0};
  sdf->axes[index][1] = (km_coordinate_ref){km_robot_add_joint(robot, &other), 0};
  add_spring(sdf, e, first, joint->name, sdf->axes[index][0]);
  add_spring(sdf, e, second, other.name, sdf->axes[index][1]);
}

static int leader(const km_sdf *sdf, int entity) {
  while (sdf->leaders[entity] != entity)
    entity = sdf->leaders[entity] = sdf->leaders[sdf->leaders[entity]];
  return entity;
}

static void unite(km_sdf *sdf, int a, int b) {
  int one = leader(sdf, a), two = leader(sdf, b);
  if (one == two)
    sdf->robot->closes = true;
  sdf->leaders[one > two ? one : two] = one < two ? one : two;
}

static bool in_static(const km_sdf *sdf, int entity) {
  return sdf->entities[entity].scope >= 0 && sdf->entities[sdf->entities[entity].scope].is_static;
}

/* The links at a joint's ends; false: reported, or both are fixed to the world. */
static bool find_ends(km_sdf *sdf, int index, int *parent, int *child) {
  const km_sdf_entity *e = &sdf->entities[index];
  const char *name = km_sdf_text(e->at, "parent");
  int to = name[0] ? km_sdf_need(sdf, e->home, name, km_xml_child(e->at, "parent"), "parent") : -1;
  if (!name[0])
    km_robot_error(sdf->robot, e->at, "joint \"%.80s\" has no parent; expected <parent>", e->name);
  *parent = km_sdf_link_of(sdf, to);
  *child = km_sdf_link_of(sdf, index);
  if (sdf->incomplete && (to < 0 || *parent < 0 || *child < 0))
    km_robot_omit(sdf->robot, "joints left out, as their links are in a model that isn't there", e->name);
  else if (to >= 0 && (*parent < 0 || *child < 0))
    km_robot_error(sdf->robot, e->at, "joint \"%.80s\": one of its ends is no link", e->name);
  else if (to >= 0 && *parent == *child)
    km_robot_error(sdf->robot, e->at, "joint \"%.80s\": both ends are on \"%.80s\"; expected two links", e->name,
                   sdf->entities[*child].name);
  else
    return to >= 0;
  return false;
}

static void add_joint(km_sdf *sdf, int index) {
  km_robot *robot = sdf->robot;
  const km_sdf_entity *e = &sdf->entities[index];
  const km_xml *axis = km_xml_child(e->at, "axis");
  km_robot_joint joint = km_robot_joint_default();
  int parent, child;
  if (!find_type(sdf, e, &joint.type) || !find_ends(sdf, index, &parent, &child))
    return;
  joint.at = e->at;
  joint.name = e->name;
  joint.assembly = sdf->entities[e->scope].assembly;
  joint.parent = sdf->entities[parent].body;
  joint.child = sdf->entities[child].body;
  joint.in_parent = from(&sdf->entities[parent].world, &e->world);
  joint.in_child = from(&sdf->entities[child].world, &e->world);
  unite(sdf, parent, child);
  sdf->entities[child].is_child = true;
  if (joint.type == KM_UNIVERSAL) {
    add_two_hinges(sdf, index, &joint);
    return;
  }
  if (joint.type == KM_SCREW)
    joint.pitch = km_sdf_pitch(robot, e->at);
  bool single = joint.type == KM_RZ || joint.type == KM_TZ || joint.type == KM_SCREW;
  if (single) {
    joint.axis = km_sdf_axis(sdf, index, axis);
    joint.position[0] = km_sdf_start(sdf, index, 0);
    km_sdf_read_axis(robot, axis, is_continuous(e), 0, &joint);
  }
  km_joint_id id = robot->failed ? (km_joint_id){0} : km_robot_add_joint(robot, &joint);
  if (single && id.value) {
    sdf->axes[index][0] = (km_coordinate_ref){id, 0};
    add_spring(sdf, e, axis, e->name, (km_coordinate_ref){id, 0});
  }
}

/* Connects free parts to the inertial frame: all links of static models, otherwise one link of each connected part,
 * preferably one that is child of no joint. */
static void connect_rest(km_sdf *sdf, bool children_too) {
  for (int i = 1; i < sdf->entity_count; ++i) {
    const km_sdf_entity *e = &sdf->entities[i];
    bool fixed = in_static(sdf, i);
    bool tied = fixed ? children_too : leader(sdf, i) == 0 || (e->is_child && !children_too);
    if (e->kind != KM_SDF_LINK || !e->body.value || tied)
      continue;
    km_robot_tie(sdf->robot, e->at, sdf->entities[e->scope].assembly, e->body, e->name, &e->world,
                 !fixed && sdf->robot->request->floating);
    sdf->leaders[leader(sdf, i)] = 0;
  }
}

/* Scope of names in a model or world. */
typedef struct scope {
  km_sdf *sdf;
  int home;
} scope;

/* A link or frame by a name of the model around, or of the world. */
static bool find_link(void *context, const char *name, km_closure_end *out) {
  const scope *s = context;
  int entity = km_sdf_find(s->sdf, s->home, name);
  entity = entity >= 0 ? entity : km_sdf_find(s->sdf, 0, name);
  const km_sdf_entity *e = entity >= 0 ? &s->sdf->entities[entity] : NULL;
  int link = e && e->kind != KM_SDF_JOINT && e->kind != KM_SDF_MODEL ? km_sdf_link_of(s->sdf, entity) : -1;
  if (link < 0)
    return false;
  out->link = link;
  out->body = s->sdf->entities[link].body;
  out->world = s->sdf->entities[link].world;
  out->in_link = from(&out->world, &e->world);
  return true;
}

static void tie_links(void *context, int parent, int child) {
  const scope *s = context;
  unite(s->sdf, parent, child);
  s->sdf->entities[child].is_child = true;
}

/* Loops that are closed beside the joints. */
static void add_closures(km_sdf *sdf) {
  scope around = {.sdf = sdf};
  km_closures c = {.robot = sdf->robot, .context = &around, .find = find_link, .tie = tie_links};
  for (int i = 0; i < sdf->other_count; ++i) {
    around.home = sdf->others[i].home;
    c.assembly = sdf->entities[around.home].assembly;
    if (!km_closures_read(&c, sdf->others[i].at))
      km_robot_omit(sdf->robot, "elements for simulators left out", sdf->others[i].at->name);
  }
  for (int i = 1; i < sdf->entity_count; ++i) {
    const km_sdf_entity *e = &sdf->entities[i];
    around.home = e->home;
    c.assembly = sdf->entities[e->scope].assembly;
    if (e->kind == KM_SDF_LINK || e->kind == KM_SDF_FRAME)
      km_closures_pair(&c, e->at, e->name);
  }
}

void km_sdf_add_joints(km_sdf *sdf) {
  sdf->axes = km_arena_alloc(&sdf->robot->arena, (size_t)sdf->entity_count, sizeof *sdf->axes);
  sdf->leaders = KM_ARENA_NEW(&sdf->robot->arena, int, (size_t)sdf->entity_count);
  if (!sdf->axes || !sdf->leaders)
    return;
  for (int i = 0; i < sdf->entity_count; ++i)
    sdf->leaders[i] = i;
  for (int i = 1; i < sdf->entity_count; ++i) {
    const km_sdf_entity *e = &sdf->entities[i];
    if (e->kind == KM_SDF_JOINT && in_static(sdf, i))
      km_robot_omit(sdf->robot, "joints of static models left out", e->name);
    else if (e->kind == KM_SDF_JOINT && strcmp(type_of(e), "gearbox") != 0)
      add_joint(sdf, i);
  }
  add_closures(sdf);
  if (sdf->robot->failed)
    return;
  connect_rest(sdf, false);
  connect_rest(sdf, true);
  km_sdf_add_couplings(sdf);
}
