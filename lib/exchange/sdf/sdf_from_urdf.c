/* Robots of URDF that are included, as models: each element becomes that of SDFormat which says the same. */
#include "exchange/sdf/sdf.h"

#include <string.h>

/* Appends a child with the location of `at` in the file. NULL: out of memory. */
static km_xml *add(km_robot *robot, km_xml *parent, const char *name, const km_xml *at) {
  km_xml *e = KM_ARENA_NEW(&robot->arena, km_xml, 1);
  if (!e)
    return NULL;
  *e = (km_xml){.name = name, .text = "", .line = at->line, .column = at->column, .file = at->file, .parent = parent};
  if (parent && parent->last)
    parent->last->next = e;
  else if (parent)
    parent->first = e;
  if (parent)
    parent->last = e;
  return e;
}

static void set(km_robot *robot, km_xml *e, const char *name, const char *value) {
  km_xml_attribute *list = e ? KM_ARENA_NEW(&robot->arena, km_xml_attribute, (size_t)e->attribute_count + 1) : NULL;
  if (!list)
    return;
  if (e->attribute_count > 0)
    memcpy(list, e->attributes, (size_t)e->attribute_count * sizeof *list);
  list[e->attribute_count++] = (km_xml_attribute){name, value};
  e->attributes = list;
}

/* An attribute as an element of its own; nothing where it is absent and nothing else counts then. */
static void copy(km_robot *robot, km_xml *to, const char *name, const km_xml *from, const char *key,
                 const char *otherwise) {
  const char *value = km_xml_attribute_of(from, key);
  value = value ? value : otherwise;
  km_xml *e = to && value ? add(robot, to, name, from ? from : to) : NULL;
  if (e)
    e->text = value;
}

/* The element `origin` as a pose, in the frame of `base`; NULL: in the one around. */
static void add_pose(km_robot *robot, km_xml *to, const km_xml *of, const char *base) {
  const km_xml *origin = km_xml_child(of, "origin");
  const char *xyz = km_xml_attribute_of(origin, "xyz"), *rpy = km_xml_attribute_of(origin, "rpy");
  km_xml *pose = to ? add(robot, to, "pose", origin ? origin : of) : NULL;
  if (!pose)
    return;
  pose->text = km_robot_text(robot, "%s %s", xyz ? xyz : "0 0 0", rpy ? rpy : "0 0 0");
  if (base)
    set(robot, pose, "relative_to", base);
}

/* Inertia entries that aren't stated are 0 in URDF, not 1. */
static void add_inertial(km_robot *robot, km_xml *link, const km_xml *from) {
  static const char *const keys[6] = {"ixx", "iyy", "izz", "ixy", "iyz", "ixz"};
  const km_xml *inertial = km_xml_child(from, "inertial");
  km_xml *to = add(robot, link, "inertial", inertial ? inertial : from);
  km_xml *inertia = to ? add(robot, to, "inertia", to) : NULL;
  copy(robot, to, "mass", km_xml_child(inertial, "mass"), "value", "0");
  for (int k = 0; k < 6; ++k)
    copy(robot, inertia, keys[k], km_xml_child(inertial, "inertia"), keys[k], "0");
  if (inertial)
    add_pose(robot, to, inertial, NULL);
}

static void add_geometry(km_robot *robot, km_xml *to, const km_xml *from) {
  static const char *const kinds[] = {"box", "sphere", "cylinder", "capsule", "mesh"};
  static const char *const keys[][2] = {
      {"size", "size"}, {"radius", "radius"}, {"length", "length"}, {"filename", "uri"}, {"scale", "scale"}};
  km_xml *geometry = add(robot, to, "geometry", from);
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds && geometry; ++i) {
    const km_xml *shape = km_xml_child(km_xml_child(from, "geometry"), kinds[i]);
    km_xml *copied = shape ? add(robot, geometry, kinds[i], shape) : NULL;
    for (size_t k = 0; k < sizeof keys / sizeof *keys && copied; ++k)
      copy(robot, copied, keys[k][1], shape, keys[k][0], NULL);
  }
}

/* Its own colour, or that of the robot's material by its name. */
static void add_color(km_robot *robot, km_xml *to, const km_xml *root, const km_xml *visual) {
  const km_xml *own = km_xml_child(visual, "material"), *color = km_xml_child(own, "color");
  const char *name = km_xml_attribute_of(own, "name");
  for (const km_xml *m = km_xml_child(root, "material"); m && name && !color; m = km_xml_next(m)) {
    const char *other = km_xml_attribute_of(m, "name");
    color = other && strcmp(other, name) == 0 ? km_xml_child(m, "color") : NULL;
  }
  if (color)
    copy(robot, add(robot, to, "material", own), "diffuse", color, "rgba", NULL);
}

static void add_shapes(km_robot *robot, km_xml *link, const km_xml *root, const km_xml *from) {
  for (const km_xml *e = from->first; e; e = e->next) {
    bool visual = strcmp(e->name, "visual") == 0;
    km_xml *to = visual || strcmp(e->name, "collision") == 0 ? add(robot, link, e->name, e) : NULL;
    if (!to)
      continue;
    add_pose(robot, to, e, NULL);
    add_geometry(robot, to, e);
    if (visual)
      add_color(robot, to, root, e);
  }
}

static const char *end_of(const km_xml *joint, const char *end) {
  const char *name = km_xml_attribute_of(km_xml_child(joint, end), "link");
  return name ? name : "";
}

static bool is_world(const char *name) {
  return strcmp(name, "world") == 0;
}

/* Places a link at the origin of its parent joint, whose frame is the link's frame. The pose is relative to the
 * parent link, given by its name, because a joint may have the name of a link. */
static void place(km_robot *robot, km_xml *link, const km_xml *root, const char *name) {
  for (const km_xml *joint = km_xml_child(root, "joint"); joint; joint = km_xml_next(joint)) {
    const char *parent = end_of(joint, "parent");
    if (strcmp(end_of(joint, "child"), name) != 0)
      continue;
    add_pose(robot, link, joint, is_world(parent) ? NULL : parent);
    return;
  }
}

static void add_link(km_robot *robot, km_xml *model, const km_xml *root, const km_xml *from) {
  const char *name = km_xml_attribute_of(from, "name");
  km_xml *link = add(robot, model, "link", from);
  if (!link)
    return;
  set(robot, link, "name", name ? name : "");
  place(robot, link, root, name ? name : "");
  add_inertial(robot, link, from);
  add_shapes(robot, link, root, from);
}

static void add_axis(km_robot *robot, km_xml *joint, const km_xml *from) {
  const km_xml *limit = km_xml_child(from, "limit"), *dynamics = km_xml_child(from, "dynamics");
  const km_xml *mimic = km_xml_child(from, "mimic");
  km_xml *axis = add(robot, joint, "axis", from), *to = NULL;
  if (!axis)
    return;
  copy(robot, axis, "xyz", km_xml_child(from, "axis"), "xyz", "1 0 0");
  if (limit && (to = add(robot, axis, "limit", limit)) != NULL) {
    copy(robot, to, "lower", limit, "lower", "0");
    copy(robot, to, "upper", limit, "upper", "0");
    copy(robot, to, "effort", limit, "effort", NULL);
    copy(robot, to, "velocity", limit, "velocity", NULL);
  }
  if (dynamics && (to = add(robot, axis, "dynamics", dynamics)) != NULL) {
    copy(robot, to, "damping", dynamics, "damping", NULL);
    copy(robot, to, "friction", dynamics, "friction", NULL);
  }
  if (mimic && (to = add(robot, axis, "mimic", mimic)) != NULL) {
    const char *leader = km_xml_attribute_of(mimic, "joint");
    set(robot, to, "joint", leader ? leader : "");
    copy(robot, to, "multiplier", mimic, "multiplier", NULL);
    copy(robot, to, "offset", mimic, "offset", NULL);
  }
}

static void add_joint(km_robot *robot, km_xml *model, const km_xml *from) {
  const char *name = km_xml_attribute_of(from, "name"), *type = km_xml_attribute_of(from, "type");
  bool fixed = type && strcmp(type, "fixed") == 0;
  km_xml *joint = add(robot, model, "joint", from);
  if (!joint)
    return;
  set(robot, joint, "name", name ? name : "");
  set(robot, joint, "type", !type ? "" : strcmp(type, "spherical") == 0 ? "ball" : type);
  copy(robot, joint, "parent", km_xml_child(from, "parent"), "link", "");
  copy(robot, joint, "child", km_xml_child(from, "child"), "link", "");
  if (!fixed)
    add_axis(robot, joint, from);
}

/* Copies an element of another program, which may close a loop. */
static void add_copy(km_robot *robot, km_xml *model, const km_xml *from) {
  km_xml *to = add(robot, model, from->name, from);
  if (!to)
    return;
  to->text = from->text;
  to->attributes = from->attributes;
  to->attribute_count = from->attribute_count;
  to->first = from->first;
  to->last = from->last;
}

static void add_other(km_robot *robot, km_xml *model, const km_xml *e) {
  if (strcmp(e->name, "gazebo") != 0) {
    add_copy(robot, model, e);
    return;
  }
  for (const km_xml *m = e->first; m && !km_xml_attribute_of(e, "reference"); m = m->next)
    add_copy(robot, model, m);
}

const km_xml *km_sdf_from_urdf(km_robot *robot, const km_xml *root) {
  const char *name = km_xml_attribute_of(root, "name");
  km_xml *model = km_robot_refuses_macros(robot, root) ? NULL : add(robot, NULL, "model", root);
  if (!model)
    return NULL;
  set(robot, model, "name", name && name[0] ? name : "robot");
  for (const km_xml *e = root->first; e; e = e->next) {
    const char *own = km_xml_attribute_of(e, "name");
    if (strcmp(e->name, "link") == 0 && !(own && is_world(own)))
      add_link(robot, model, root, e);
    else if (strcmp(e->name, "joint") == 0)
      add_joint(robot, model, e);
    else if (strcmp(e->name, "link") != 0 && strcmp(e->name, "material") != 0)
      add_other(robot, model, e);
  }
  return model;
}
