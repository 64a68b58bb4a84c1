/* The tree of bodies: poses, masses, sites, and what ties each body to its parent. */
#include "exchange/mjcf/mjcf.h"
#include "model/geometry/mass_properties.h"

#include <string.h>

enum { MOST_COPIES = 100000, MOST_JOINTS = 32 };

static void walk_copies(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, km_mjcf_visit visit, void *context) {
  km_robot *robot = m->robot;
  double count = km_robot_number(robot, e, "count", 0.0), offset[3] = {0};
  const char *separator = km_xml_attribute_of(e, "sep");
  km_robot_numbers(robot, e, "offset", offset, 3);
  if (!(count >= 1.0 && count == floor(count) && m->copies + count <= MOST_COPIES)) {
    km_robot_error(robot, e, "count: found %g copies; expected a whole number of at least 1, and at most %d in all",
                   count, MOST_COPIES);
    return;
  }
  km_pose step = km_mjcf_pose(m, e, &(km_mjcf_place){km_pose_identity(), NULL, ""});
  step.p = km_vec3_from_array(offset);
  km_pose here = km_pose_identity();
  int digits = (int)strlen(km_robot_text(robot, "%d", (int)count));
  for (int i = 0; i < (int)count && !robot->arena.failed; ++i) {
    km_mjcf_place inside = *place;
    inside.pose = km_pose_product(&place->pose, &here);
    inside.suffix = km_robot_text(robot, "%s%0*d%s", separator ? separator : "", digits, i, place->suffix);
    m->copies++;
    km_mjcf_walk(m, e, &inside, visit, context);
    here = km_pose_product(&here, &step);
  }
}

void km_mjcf_walk(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, km_mjcf_visit visit, void *context) {
  for (const km_xml *e = element->first; e && !m->robot->arena.failed; e = e->next) {
    if (strcmp(e->name, "replicate") == 0) {
      walk_copies(m, e, place, visit, context);
    } else if (strcmp(e->name, "frame") == 0) {
      km_mjcf_place inside = *place;
      km_pose own = km_mjcf_pose(m, e, place);
      inside.pose = km_pose_product(&place->pose, &own);
      inside.class = km_mjcf_class_inside(m, e, place->class);
      km_mjcf_walk(m, e, &inside, visit, context);
    } else {
      visit(m, e, place, context);
    }
  }
}

/* Contents of a body that are collected before it is added. */
typedef struct content {
  km_mass stated, weighed;
  bool is_stated;
  int joint_count;
  struct {
    const km_xml *element;
    km_mjcf_place place;
  } joints[MOST_JOINTS];
} content;

static void gather(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, void *context) {
  content *c = context;
  bool joint = strcmp(e->name, "joint") == 0 || strcmp(e->name, "freejoint") == 0;
  if (strcmp(e->name, "inertial") == 0) {
    c->stated = km_mjcf_inertial(m, e, place);
  } else if (strcmp(e->name, "geom") == 0 && !(c->is_stated && m->compiler.from_geoms == KM_MJCF_AUTO)) {
    if (m->compiler.from_geoms != KM_MJCF_NO)
      km_mjcf_weigh(m, e, place, &c->weighed);
  } else if (joint && c->joint_count == MOST_JOINTS) {
    km_robot_error(m->robot, e, "a body with more than %d joints; expected fewer", MOST_JOINTS);
  } else if (joint) {
    c->joints[c->joint_count].element = e;
    c->joints[c->joint_count++].place = *place;
  }
}

static void read_site(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, int body) {
  km_robot *robot = m->robot;
  const char *name = km_xml_attribute_of(e, "name");
  if (!name || !name[0])
    return;
  km_mjcf_line line;
  km_pose own = km_mjcf_find_line(m, e, place, &line) ? line.pose : km_mjcf_pose(m, e, place);
  km_pose pose = km_pose_product(&place->pose, &own);
  name = km_robot_text(robot, "%s%s%s", m->prefix, name, place->suffix);
  if (!km_arena_grow(&robot->arena, (void **)&m->sites, &m->site_room, (size_t)m->site_count + 1, sizeof *m->sites))
    return;
  if (km_names_get(&m->site_names, 0, name) >= 0)
    km_robot_error(robot, e, "site \"%.80s\": this name is used twice; expected a name of its own", name);
  else if (!km_names_set(&m->site_names, 0, name, m->site_count))
    robot->arena.failed = true;
  km_frame_id frame =
      km_robot_frame(robot, e, m->bodies[body].id, km_robot_name_within(m->bodies[body].name, name), &pose);
  m->sites[m->site_count++] = (km_mjcf_site){body, pose, frame};
}

/* Sites and bodies inside of a body. */
static void read_member(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, void *context) {
  int body = *(int *)context;
  if (strcmp(e->name, "body") == 0)
    km_mjcf_read_body(m, e, place, body);
  else if (strcmp(e->name, "site") == 0)
    read_site(m, e, place, body);
  else if (strcmp(e->name, "geom") == 0)
    km_mjcf_show(m, e, place, m->bodies[body].id);
  else if (strcmp(e->name, "attach") == 0)
    km_mjcf_attach(m, e, place, body);
  else if (strcmp(e->name, "composite") == 0 || strcmp(e->name, "flexcomp") == 0)
    km_robot_omit(m->robot, "composite and flexible bodies left out", km_xml_attribute_of(e, "prefix"));
}

static int add_body(km_mjcf *m, const char *name, km_body_id id, const km_pose *world) {
  km_robot *robot = m->robot;
  if (!km_arena_grow(&robot->arena, (void **)&m->bodies, &m->body_room, (size_t)m->body_count + 1, sizeof *m->bodies))
    return -1;
  if (!km_names_set(&m->body_names, 0, name, m->body_count))
    robot->arena.failed = true;
  m->bodies[m->body_count] = (km_mjcf_body){name, id, *world};
  return m->body_count++;
}

/* The joints of a body one after the other, with massless bodies between them. */
static void tie(km_mjcf *m, const km_xml *e, const content *c, int parent, km_body_id body, const char *name,
                const km_pose *pose) {
  km_robot *robot = m->robot;
  if (c->joint_count == 0) {
    km_robot_joint rigid = km_robot_joint_default();
    rigid = (km_robot_joint){.at = e,
                             .name = name,
                             .assembly = m->assembly,
                             .type = KM_RIGID,
                             .parent = m->bodies[parent].id,
                             .child = body,
                             .in_parent = *pose,
                             .in_child = rigid.in_child,
                             .axis = rigid.axis};
    rigid.name = km_robot_free_name(robot, &robot->joints, m->assembly.value, name, "rigid");
    if (parent == 0)
      km_robot_tie(robot, e, m->assembly, body, rigid.name, pose, robot->request->floating);
    else
      km_robot_add_joint(robot, &rigid);
    return;
  }
  km_mjcf_link link = {m->bodies[parent].id, {0}, *pose, parent == 0, name};
  for (int k = 0; k < c->joint_count; ++k) {
    bool last = k == c->joint_count - 1;
    const char *between = last ? name : km_robot_text(robot, "%s:%d", name, k + 1);
    link.child = last ? body
                      : km_robot_body(robot, e, m->assembly,
                                      km_robot_free_name(robot, &robot->bodies, m->assembly.value, between, "between"),
                                      NULL, NULL);
    km_mjcf_add_joint(m, c->joints[k].element, &c->joints[k].place, &link);
    link = (km_mjcf_link){link.child, {0}, km_pose_identity(), false, name};
  }
}

/* Applies the compiler's settings to a mass: lower bounds of mass and principal moments, and balancing of invalid
 * moments. */
static km_mass adjusted(const km_mjcf *m, km_mass mass) {
  double moments[3], sum = 0.0, largest = 0.0;
  km_vec3 axes[3];
  bool changes = false;
  mass.mass = fmax(mass.mass, m->compiler.least_mass);
  km_principal_axes(mass.inertia, moments, axes);
  for (int k = 0; k < 3; ++k) {
    changes = changes || moments[k] < m->compiler.least_inertia;
    moments[k] = fmax(moments[k], m->compiler.least_inertia);
    sum += moments[k];
    largest = fmax(largest, moments[k]);
  }
  bool impossible = largest > (sum - largest) * (1.0 + 1e-12);
  for (int k = 0; k < 3 && impossible && m->compiler.balances; ++k)
    moments[k] = sum / 3.0;
  if (changes || (impossible && m->compiler.balances))
    km_inertia_about(moments, axes, mass.inertia);
  return mass;
}

void km_mjcf_read_body(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, int parent) {
  km_robot *robot = m->robot;
  const char *own = km_xml_attribute_of(e, "name");
  km_pose local = km_mjcf_pose(m, e, place), pose = km_pose_product(&place->pose, &local);
  km_mjcf_place inside = {km_pose_identity(), km_mjcf_class_inside(m, e, place->class), place->suffix};
  const char *name = own && own[0] ? km_robot_text(robot, "%s%s%s", m->prefix, own, place->suffix)
                                   : km_robot_free_name(robot, &robot->bodies, m->assembly.value,
                                                        km_robot_text(robot, "body%d", m->body_count), "body");
  content *c = km_arena_alloc(&robot->arena, 1, sizeof *c);
  if (!c)
    return;
  if (km_names_get(&m->body_names, 0, name) >= 0) {
    km_robot_error(robot, e, "body \"%.80s\": this name is used twice; expected a name of its own", name);
    return;
  }
  c->is_stated = km_xml_child(e, "inertial") != NULL; /* whatever its position in the list of geoms */
  km_mjcf_walk(m, e, &inside, gather, c);
  bool stated = c->is_stated && (m->compiler.from_geoms != KM_MJCF_YES || c->weighed.mass == 0.0);
  km_mass mass = adjusted(m, stated ? c->stated : c->weighed);
  km_body_id id = km_robot_body(robot, e, m->assembly, name, &mass, NULL);
  km_pose world = km_pose_product(&m->bodies[parent].world, &pose);
  int index = id.value ? add_body(m, name, id, &world) : -1;
  if (index < 0)
    return;
  tie(m, e, c, parent, id, name, &pose);
  if (km_xml_attribute_of(e, "gravcomp"))
    km_robot_omit(robot, "compensations of gravity left out", name);
  km_mjcf_walk(m, e, &inside, read_member, &index);
}

/* Names that the file gives come before those that are made up for bodies and joints without one. */
static void reserve_names(km_mjcf *m, const km_xml *element) {
  for (const km_xml *e = element->first; e; e = e->next) {
    const char *name = km_xml_attribute_of(e, "name");
    bool joint = strcmp(e->name, "joint") == 0 || strcmp(e->name, "freejoint") == 0;
    bool named = name && name[0] && (joint || strcmp(e->name, "body") == 0);
    if (named && !km_names_set(joint ? &m->robot->joints : &m->robot->bodies, m->assembly.value, name, 0))
      m->robot->arena.failed = true;
    reserve_names(m, e);
  }
}

void km_mjcf_read_members(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, int body, bool frame) {
  km_mjcf_place inside = *place;
  if (frame) {
    km_pose own = km_mjcf_pose(m, e, place);
    inside.pose = km_pose_product(&place->pose, &own);
  }
  inside.class = km_mjcf_class_inside(m, e, place->class);
  km_mjcf_walk(m, e, &inside, read_member, &body);
}

void km_mjcf_read_bodies(km_mjcf *m) {
  km_pose world = km_pose_identity();
  km_mjcf_place place = {km_pose_identity(), NULL, ""};
  int index = add_body(m, "world", km_builder_fixed(m->robot->builder), &world);
  for (const km_xml *e = km_xml_child(m->root, "worldbody"); e; e = km_xml_next(e))
    reserve_names(m, e);
  for (const km_xml *e = km_xml_child(m->root, "worldbody"); e && index == 0; e = km_xml_next(e)) {
    place.class = km_mjcf_class_inside(m, e, NULL);
    km_mjcf_walk(m, e, &place, read_member, &index);
  }
}
