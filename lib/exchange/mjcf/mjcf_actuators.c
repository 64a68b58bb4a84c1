/* Actuators: which joints they drive, and with what force at most. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

/* An attribute of an actuator, whose kinds share their defaults. */
static const char *get(km_mjcf *m, const km_xml *e, const char *key) {
  static const char *const kinds[] = {"general", "motor", "position", "velocity", "intvelocity", NULL};
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  const char *found = km_mjcf_get(m, e, &place, key);
  for (const char *const *kind = kinds; *kind && !found; ++kind) {
    km_xml other = *e;
    other.name = (char *)*kind;
    found = km_mjcf_get(m, &other, &place, key);
  }
  return found;
}

/* The larger end of a range that counts; infinite: none does. */
static double most_of(km_mjcf *m, const km_xml *e, const char *range_key, const char *limited_key) {
  const char *range = get(m, e, range_key), *limited = get(m, e, limited_key);
  double ends[2];
  bool counts = limited && strcmp(limited, "auto") != 0 ? strcmp(limited, "true") == 0 : m->compiler.autolimits;
  if (!range || !counts || !km_robot_parse(m->robot, e, range_key, range, ends, 2))
    return HUGE_VAL;
  return fmax(fabs(ends[0]), fabs(ends[1]));
}

/* In the joint, behind the gear. A motor's control is its force. */
static double most_force(km_mjcf *m, const km_xml *e) {
  double gear[6] = {1}, force = most_of(m, e, "forcerange", "forcelimited");
  if (strcmp(e->name, "motor") == 0)
    force = fmin(force, most_of(m, e, "ctrlrange", "ctrllimited"));
  const char *text = get(m, e, "gear");
  if (text)
    km_robot_parse_some(m->robot, e, "gear", text, gear, 1, 6);
  return force < HUGE_VAL ? force * fabs(gear[0]) : HUGE_VAL;
}

static const char *joint_key(const km_xml *e) {
  return km_xml_attribute_of(e, "jointinparent") ? "jointinparent" : "joint";
}

/* Several actuators of one joint give the sum of their forces. */
void km_mjcf_read_forces(km_mjcf *m) {
  size_t room = 0;
  for (const km_xml *list = km_xml_child(m->root, "actuator"); list; list = km_xml_next(list))
    for (const km_xml *e = list->first; e; e = e->next) {
      const char *joint = km_xml_attribute_of(e, joint_key(e));
      if (!joint)
        continue;
      joint = km_mjcf_full(m, joint);
      int index = km_names_get(&m->driven_names, 0, joint);
      if (index < 0) {
        index = m->driven_count++;
        if (!km_names_set(&m->driven_names, 0, joint, index) ||
            !km_arena_grow(&m->robot->arena, (void **)&m->most_forces, &room, (size_t)m->driven_count,
                           sizeof *m->most_forces)) {
          m->robot->arena.failed = true;
          return;
        }
      }
      m->most_forces[index] += most_force(m, e);
    }
}

double km_mjcf_most_force(const km_mjcf *m, const char *joint) {
  int index = km_names_get(&m->driven_names, 0, joint);
  return index < 0 || !(m->most_forces[index] > 0.0) ? HUGE_VAL : m->most_forces[index];
}

void km_mjcf_read_actuators(km_mjcf *m) {
  bool *driven = KM_ARENA_NEW(&m->robot->arena, bool, (size_t)m->joint_count);
  for (const km_xml *list = km_xml_child(m->root, "actuator"); list && driven; list = km_xml_next(list))
    for (const km_xml *e = list->first; e; e = e->next) {
      const char *key = joint_key(e);
      if (!km_mjcf_is_here(m, e))
        continue;
      int joint = km_xml_attribute_of(e, key) ? km_mjcf_find(m, e, key, &m->joint_names, "joint") : -1;
      bool single = joint >= 0 && (m->joints[joint].type == KM_RZ || m->joints[joint].type == KM_TZ);
      km_error error;
      if (!single || driven[joint])
        km_robot_omit(m->robot, "actuators left out, as they drive no joint of their own",
                      km_xml_attribute_of(e, "name"));
      else if (km_model_add_actuator(m->robot->builder, (km_coordinate_ref){m->joints[joint].id, 0}, &error))
        m->robot->arena.failed = true;
      else
        driven[joint] = true;
    }
}
