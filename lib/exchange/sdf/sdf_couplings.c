/* Joints that imitate others, and gears between two joints. */
#include "exchange/sdf/sdf.h"

#include <string.h>

static const char *const axis_names[2] = {"axis", "axis2"};

/* An axis of a joint: its entity, and 0 for axis or 1 for axis2. */
typedef struct axis_of {
  int joint, axis;
} axis_of;

static const km_xml *mimic_of(const km_sdf *sdf, axis_of follower) {
  return km_xml_child(km_xml_child(sdf->entities[follower.joint].at, axis_names[follower.axis]), "mimic");
}

/* Axis and joint named by `mimic`; joint −1: none. */
static axis_of leader_of(const km_sdf *sdf, axis_of follower) {
  const km_xml *mimic = mimic_of(sdf, follower);
  const char *name = km_xml_attribute_of(mimic, "joint"), *axis = km_xml_attribute_of(mimic, "axis");
  const km_sdf_entity *e = &sdf->entities[follower.joint];
  int found = name ? km_names_get(&sdf->joints, e->scope, name) : -1;
  found = found >= 0 || !name ? found : km_sdf_find(sdf, e->home, name);
  if (found >= 0 && sdf->entities[found].kind != KM_SDF_JOINT)
    found = -1;
  return (axis_of){found, axis && strcmp(axis, axis_names[1]) == 0};
}

/* A follower's value where what it imitates is at 0. */
static double mimic_constant(const km_sdf *sdf, const km_xml *mimic, double ratio) {
  return km_sdf_number(sdf->robot, mimic, "offset", 0.0) - ratio * km_sdf_number(sdf->robot, mimic, "reference", 0.0);
}

double km_sdf_start(const km_sdf *sdf, int joint, int axis) {
  double value = 0.0, factor = 1.0;
  axis_of at = {joint, axis};
  for (int steps = 0; steps <= 2 * sdf->entity_count; ++steps) {
    const km_xml *mimic = mimic_of(sdf, at);
    axis_of next = leader_of(sdf, at);
    if (!mimic || next.joint < 0)
      return value;
    double ratio = km_sdf_number(sdf->robot, mimic, "multiplier", 1.0);
    value += factor * mimic_constant(sdf, mimic, ratio);
    factor *= ratio;
    at = next;
  }
  km_robot_error(sdf->robot, sdf->entities[joint].at, "joint \"%.80s\" imitates itself; expected another joint",
                 sdf->entities[joint].name);
  return 0.0;
}

static void couple(km_sdf *sdf, int joint, const char *name, km_coordinate_ref follower, km_coordinate_ref other,
                   double constant, double ratio) {
  const km_sdf_entity *e = &sdf->entities[joint];
  const double line[2] = {constant, ratio};
  km_robot_couple(sdf->robot, e->at, name, sdf->entities[e->scope].assembly, follower, other, line, 2);
}

static void add_mimic(km_sdf *sdf, axis_of follower) {
  const km_xml *mimic = mimic_of(sdf, follower);
  if (!mimic)
    return;
  axis_of leader = leader_of(sdf, follower);
  km_coordinate_ref own = sdf->axes[follower.joint][follower.axis];
  km_coordinate_ref other = leader.joint >= 0 ? sdf->axes[leader.joint][leader.axis] : (km_coordinate_ref){0};
  const char *name = km_xml_attribute_of(mimic, "joint");
  if (own.joint.value && other.joint.value) {
    double ratio = km_sdf_number(sdf->robot, mimic, "multiplier", 1.0);
    const char *coupling = sdf->entities[follower.joint].name;
    couple(sdf, follower.joint, follower.axis ? km_robot_text(sdf->robot, "%s:2", coupling) : coupling, own, other,
           mimic_constant(sdf, mimic, ratio), ratio);
  } else if (sdf->incomplete) {
    km_robot_omit(sdf->robot, "joints that imitate left out, as the other joint isn't there",
                  sdf->entities[follower.joint].name);
  } else {
    km_robot_error(sdf->robot, mimic,
                   "joint \"%.80s\" imitates %s of \"%.80s\"; expected two axes of joints that turn or slide",
                   sdf->entities[follower.joint].name, axis_names[leader.axis], name ? name : "");
  }
}

/* The joint between two links, and whether its coordinate counts the turn of `link` against `reference` about the axis
 * (in the world) positively. */
static int find_between(km_sdf *sdf, int reference, int link, km_vec3 axis, double *sense) {
  for (int i = 1; i < sdf->entity_count; ++i) {
    const km_sdf_entity *e = &sdf->entities[i];
    if (e->kind != KM_SDF_JOINT || !sdf->axes[i][0].joint.value || sdf->axes[i][1].joint.value)
      continue;
    int child = km_sdf_link_of(sdf, i);
    int parent = km_sdf_link_of(sdf, km_sdf_find(sdf, e->home, km_sdf_text(e->at, "parent")));
    bool forward = parent == reference && child == link, backward = parent == link && child == reference;
    if (!forward && !backward)
      continue;
    km_vec3 own = km_rotate(&e->world.R, km_sdf_axis(sdf, i, km_xml_child(e->at, "axis")));
    *sense = (forward ? 1.0 : -1.0) * (km_vec3_dot(own, axis) < 0.0 ? -1.0 : 1.0);
    return i;
  }
  return -1;
}

/* theta_2 = -ratio · theta_1: of the child and of the parent against the reference body. */
static void add_gear(km_sdf *sdf, int gear) {
  const km_sdf_entity *e = &sdf->entities[gear];
  const char *body = km_sdf_text(e->at, "gearbox_reference_body");
  int reference = km_sdf_link_of(sdf, km_sdf_need(sdf, e->home, body, e->at, "reference body"));
  int parent = km_sdf_link_of(sdf, km_sdf_need(sdf, e->home, km_sdf_text(e->at, "parent"), e->at, "parent"));
  int child = km_sdf_link_of(sdf, gear);
  const km_xml *axis = km_xml_child(e->at, "axis"), *axis2 = km_xml_child(e->at, "axis2");
  km_vec3 first = km_rotate(&e->world.R, km_sdf_axis(sdf, gear, axis));
  km_vec3 second = axis2 ? km_rotate(&e->world.R, km_sdf_axis(sdf, gear, axis2)) : first;
  double sense[2] = {1, 1};
  int one = find_between(sdf, reference, parent, first, &sense[0]);
  int two = find_between(sdf, reference, child, second, &sense[1]);
  if (one < 0 || two < 0)
    km_robot_error(sdf->robot, e->at,
                   "joint \"%.80s\": found no joint between \"%.80s\" and the %s of the gear; expected one with one "
                   "coordinate",
                   e->name, body, one < 0 ? "parent" : "child");
  else
    couple(sdf, gear, e->name, sdf->axes[two][0], sdf->axes[one][0], 0.0,
           -km_sdf_number(sdf->robot, e->at, "gearbox_ratio", 1.0) * sense[0] * sense[1]);
}

void km_sdf_add_couplings(km_sdf *sdf) {
  for (int i = 1; i < sdf->entity_count && !sdf->robot->failed; ++i) {
    const km_sdf_entity *e = &sdf->entities[i];
    const char *type = km_xml_attribute_of(e->at, "type");
    if (e->kind != KM_SDF_JOINT || sdf->entities[e->scope].is_static)
      continue;
    if (type && strcmp(type, "gearbox") == 0)
      add_gear(sdf, i);
    else
      for (int k = 0; k < 2; ++k)
        add_mimic(sdf, (axis_of){i, k});
  }
}
