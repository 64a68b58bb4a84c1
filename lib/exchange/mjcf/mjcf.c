/* A model of MuJoCo from its tree of elements. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

static void read_option(km_mjcf *m, const km_xml *option) {
  const km_xml *flag = km_xml_child(option, "flag");
  const char *gravity = km_xml_attribute_of(flag, "gravity");
  km_robot_numbers(m->robot, option, "gravity", m->robot->settings.gravity, 3);
  if (gravity && strcmp(gravity, "disable") == 0)
    memset(m->robot->settings.gravity, 0, sizeof m->robot->settings.gravity);
}

/* A tolerance that kmech wrote. */
static void read_custom(km_mjcf *m, const km_xml *custom) {
  for (const km_xml *e = km_xml_child(custom, "numeric"); e; e = km_xml_next(e)) {
    const char *name = km_xml_attribute_of(e, "name");
    if (name && strcmp(name, KM_MJCF_TOLERANCE) == 0)
      m->robot->settings.closure_tolerance = km_robot_number(m->robot, e, "data", 0.0);
  }
}

static void count_others(km_mjcf *m) {
  static const struct {
    const char *element, *kind;
  } others[] = {{"sensor", "sensors left out"},
                {"contact", "contact pairs and exclusions left out"},
                {"deformable", "deformable bodies left out"},
                {"extension", "extensions left out"}};
  for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
    for (const km_xml *e = km_xml_child(m->root, others[i].element); e; e = km_xml_next(e))
      for (const km_xml *member = e->first; member; member = member->next)
        km_robot_omit(m->robot, others[i].kind, km_xml_attribute_of(member, "name"));
}

void km_mjcf_read(km_robot *robot, km_xml *root) {
  km_mjcf m = {.robot = robot, .root = root, .prefix = "", .suffix = ""};
  robot->settings.gravity[2] = -9.81;
  km_mjcf_include(robot, root);
  m.assembly = km_robot_assembly(robot, root, km_xml_attribute_of(root, "model"), (km_assembly_id){0});
  km_mjcf_read_compiler(&m);
  km_mjcf_read_classes(&m);
  for (const km_xml *e = km_xml_child(root, "option"); e; e = km_xml_next(e))
    read_option(&m, e);
  for (const km_xml *e = km_xml_child(root, "custom"); e; e = km_xml_next(e))
    read_custom(&m, e);
  km_mjcf_read_forces(&m);
  km_mjcf_read_bodies(&m);
  if (!robot->failed && !robot->arena.failed) {
    km_mjcf_read_constraints(&m);
    km_mjcf_read_actuators(&m);
    km_mjcf_read_tendon_springs(&m);
    km_mjcf_count_tendons(&m);
    km_mjcf_read_keyframes(&m);
    count_others(&m);
  }
  km_names_free(&m.class_names);
  km_names_free(&m.missing_classes);
  km_names_free(&m.body_names);
  km_names_free(&m.joint_names);
  km_names_free(&m.site_names);
  km_names_free(&m.driven_names);
  km_names_free(&m.mesh_names);
}
