/* The links of a robot, and what ties them. */
#include "exchange/urdf/urdf.h"
#include "exchange/sdf/sdf_closures.h"

#include <string.h>

km_pose km_urdf_origin(km_robot *robot, const km_xml *element) {
  const km_xml *origin = km_xml_child(element, "origin");
  double xyz[3] = {0}, rpy[3] = {0};
  km_robot_numbers(robot, origin, "xyz", xyz, 3);
  km_robot_numbers(robot, origin, "rpy", rpy, 3);
  return (km_pose){km_rotation_rpy(rpy), km_vec3_from_array(xyz)};
}

static km_mass read_inertial(km_robot *robot, const km_xml *link) {
  static const char *const keys[6] = {"ixx", "iyy", "izz", "ixy", "iyz", "ixz"};
  const km_xml *inertial = km_xml_child(link, "inertial"), *inertia = km_xml_child(inertial, "inertia");
  km_mass mass = {.mass = km_robot_number(robot, km_xml_child(inertial, "mass"), "value", 0.0)};
  for (int k = 0; k < 6; ++k)
    mass.inertia[k] = km_robot_number(robot, inertia, keys[k], 0.0);
  km_pose pose = km_urdf_origin(robot, inertial);
  return km_mass_moved(&pose, mass);
}

static bool is_plain(km_robot *robot, const km_xml *visual, const km_xml *mesh) {
  double scale[3] = {1, 1, 1}, xyz[3] = {0}, rpy[3] = {0};
  const km_xml *origin = km_xml_child(visual, "origin");
  km_robot_numbers(robot, mesh, "scale", scale, 3);
  km_robot_numbers(robot, origin, "xyz", xyz, 3);
  km_robot_numbers(robot, origin, "rpy", rpy, 3);
  for (int k = 0; k < 3; ++k)
    if (scale[k] != 1.0 || xyz[k] != 0.0 || rpy[k] != 0.0)
      return false;
  return true;
}

static const char *mesh_of(const km_xml *visual) {
  const char *file = km_xml_attribute_of(km_xml_child(km_xml_child(visual, "geometry"), "mesh"), "filename");
  return file && file[0] ? file : NULL;
}

/* The mesh that is the link's definition: the first one that lies in the link's own frame, in metres. */
static const km_xml *definition_of(km_robot *robot, const km_xml *link) {
  for (const km_xml *v = km_xml_child(link, "visual"); v; v = km_xml_next(v))
    if (mesh_of(v) && is_plain(robot, v, km_xml_child(km_xml_child(v, "geometry"), "mesh")))
      return v;
  return NULL;
}

/* The colour of a visual: its own, or that of the material by its name. */
static void read_color(km_robot *robot, const km_xml *root, const km_xml *visual, double color[4]) {
  const km_xml *material = km_xml_child(visual, "material"), *own = km_xml_child(material, "color");
  const char *name = km_xml_attribute_of(material, "name");
  for (const km_xml *m = km_xml_child(root, "material"); m && !own && name; m = km_xml_next(m)) {
    const char *other = km_xml_attribute_of(m, "name");
    own = other && strcmp(other, name) == 0 ? km_xml_child(m, "color") : NULL;
  }
  if (own)
    km_robot_numbers(robot, own, "rgba", color, 4);
}

static void read_visual(km_robot *robot, const km_xml *root, const km_xml *v, const char *link, km_body_id body) {
  const km_xml *geometry = km_xml_child(v, "geometry");
  const km_xml *box = km_xml_child(geometry, "box"), *ball = km_xml_child(geometry, "sphere");
  const km_xml *round = km_xml_child(geometry, "cylinder"), *capsule = km_xml_child(geometry, "capsule");
  km_shape_def def = km_shape_default();
  if (mesh_of(v)) {
    def.kind = KM_SHAPE_OF_MESH;
    def.mesh = km_robot_mesh(robot, mesh_of(v));
    km_robot_numbers(robot, km_xml_child(geometry, "mesh"), "scale", def.scale, 3);
  } else if (box) {
    def.kind = KM_SHAPE_BOX;
    km_robot_numbers(robot, box, "size", def.size, 3);
  } else if (ball) {
    def.size[0] = km_robot_number(robot, ball, "radius", 0.0);
  } else if (round || capsule) {
    def.kind = round ? KM_SHAPE_CYLINDER : KM_SHAPE_CAPSULE;
    def.size[0] = km_robot_number(robot, round ? round : capsule, "radius", 0.0);
    def.size[1] = km_robot_number(robot, round ? round : capsule, "length", 0.0);
  } else {
    km_robot_omit(robot, "visual shapes left out", link);
    return;
  }
  read_color(robot, root, v, def.color);
  km_pose pose = km_urdf_origin(robot, v);
  km_robot_shape(robot, v, body, &def, &pose);
}

static void read_shapes(km_robot *robot, const km_xml *root, const km_xml *link, const char *name, km_body_id body) {
  const km_xml *definition = definition_of(robot, link);
  for (const km_xml *v = km_xml_child(link, "visual"); v; v = km_xml_next(v))
    if (v != definition)
      read_visual(robot, root, v, name, body);
  for (const km_xml *c = km_xml_child(link, "collision"); c; c = km_xml_next(c))
    km_robot_omit(robot, "collision shapes left out", name);
}

static const char *name_of(km_robot *robot, const km_xml *element) {
  const char *name = km_xml_attribute_of(element, "name");
  if (!name || !name[0])
    km_robot_error(robot, element, "a %s without a name; expected name=\"…\"", element->name);
  return name ? name : "";
}

static void read_link(km_urdf *urdf, const km_xml *root, const km_xml *link) {
  km_robot *robot = urdf->robot;
  const char *name = name_of(robot, link);
  int index = urdf->link_count++;
  if (!name[0])
    return;
  if (km_names_get(&urdf->links, 0, name) >= 0) {
    km_robot_error(robot, link, "link \"%.80s\": this name is used twice; expected a name of its own", name);
    return;
  }
  if (!km_names_set(&urdf->links, 0, name, index))
    robot->arena.failed = true;
  km_mass mass = read_inertial(robot, link);
  urdf->elements[index] = link;
  const km_xml *definition = definition_of(robot, link);
  const char *mesh = definition ? km_robot_mesh(robot, mesh_of(definition)) : NULL;
  urdf->bodies[index] = km_robot_body(robot, link, urdf->assembly, name, &mass, mesh);
  read_shapes(robot, root, link, name, urdf->bodies[index]);
}

/* An element beside links and joints, or what `gazebo` holds. False: it closes no loop. */
static bool reads_closures(const km_closures *closures, const km_xml *e) {
  bool some = false;
  if (strcmp(e->name, "gazebo") != 0)
    return km_closures_read(closures, e);
  for (const km_xml *m = e->first; m && !km_xml_attribute_of(e, "reference"); m = m->next)
    some = km_closures_read(closures, m) || some;
  return some;
}

/* Elements of other programs: some close loops. */
static void read_others(const km_closures *closures, const km_xml *root) {
  km_robot *robot = closures->robot;
  static const char *const known[] = {"link", "joint", "material", NULL};
  for (const km_xml *e = root->first; e; e = e->next) {
    bool is_known = false;
    for (const char *const *k = known; *k; ++k)
      is_known = is_known || strcmp(e->name, *k) == 0;
    if (strcmp(e->name, "transmission") == 0)
      km_robot_omit(robot, "transmissions left out", km_xml_attribute_of(e, "name"));
    else if (!is_known && !reads_closures(closures, e))
      km_robot_omit(robot, "elements for other programs left out", e->name);
  }
}

/* The pose of a link where all joints are at 0: up the joints whose child each is, as far as they lead to a root. */
static km_pose world_of(km_urdf *urdf, int link) {
  km_pose X = km_pose_identity();
  for (int steps = 0; link >= 0 && urdf->parents[link] && steps <= urdf->link_count; ++steps) {
    km_pose origin = km_urdf_origin(urdf->robot, urdf->parents[link]);
    X = km_pose_product(&origin, &X);
    const char *parent = km_xml_attribute_of(km_xml_child(urdf->parents[link], "parent"), "link");
    link = parent ? km_names_get(&urdf->links, 0, parent) : -1;
  }
  return X;
}

static bool find_link(void *context, const char *name, km_closure_end *out) {
  km_urdf *urdf = context;
  int link = km_names_get(&urdf->links, 0, name);
  if (link < 0 && strcmp(name, "world") != 0)
    return false;
  out->link = link;
  out->body = link < 0 ? km_builder_fixed(urdf->robot->builder) : urdf->bodies[link];
  out->world = world_of(urdf, link);
  return true;
}

static void tie_links(void *context, int parent, int child) {
  km_urdf_tie(context, parent, child);
}

static void read_closures(km_urdf *urdf, const km_xml *root) {
  km_closures closures = {
      .robot = urdf->robot, .assembly = urdf->assembly, .context = urdf, .find = find_link, .tie = tie_links};
  if (urdf->robot->failed || urdf->robot->arena.failed)
    return;
  read_others(&closures, root);
  for (int i = 0; i < urdf->link_count; ++i)
    if (urdf->elements[i])
      km_closures_pair(&closures, urdf->elements[i], km_xml_attribute_of(urdf->elements[i], "name"));
}

static int leader_of(const km_urdf *urdf, int link) {
  while (link >= 0 && urdf->leaders[link] != link)
    link = urdf->leaders[link];
  return link;
}

void km_urdf_tie(km_urdf *urdf, int parent, int child) {
  int one = leader_of(urdf, parent), two = leader_of(urdf, child);
  if (one >= 0 && two >= 0)
    urdf->leaders[one > two ? one : two] = one < two ? one : two;
}

/* Connects the root to the inertial frame. There must be one root; bodies connected to it by a closed loop need no
 * parent. */
static void tie_root(km_urdf *urdf, const km_xml *root) {
  int top = -1;
  km_pose origin = km_pose_identity();
  for (int i = 0; i < urdf->link_count; ++i) {
    if (urdf->parents[i] || !urdf->elements[i] || (top >= 0 && leader_of(urdf, i) == leader_of(urdf, top)))
      continue;
    const char *name = km_xml_attribute_of(urdf->elements[i], "name");
    if (top >= 0 || urdf->world_undeclared)
      km_robot_error(urdf->robot, urdf->elements[i],
                     "link \"%.80s\" is child of no joint, nor is \"%.80s\"; expected one root link", name,
                     top >= 0 ? km_xml_attribute_of(urdf->elements[top], "name") : "world");
    else
      km_robot_tie(urdf->robot, urdf->elements[i], urdf->assembly, urdf->bodies[i], name, &origin,
                   urdf->robot->request->floating);
    top = top >= 0 ? top : i;
  }
  if (top < 0 && !urdf->world_undeclared)
    km_robot_error(urdf->robot, root,
                   urdf->link_count ? "every link is child of a joint; expected one root link"
                                    : "found no link; expected at least one");
}

static int count_children(const km_xml *root, const char *name) {
  int count = 0;
  for (const km_xml *e = km_xml_child(root, name); e; e = km_xml_next(e))
    count++;
  return count;
}

void km_urdf_read(km_robot *robot, km_xml *root) {
  km_urdf urdf = {.robot = robot};
  if (km_robot_refuses_macros(robot, root))
    return;
  robot->settings.gravity[2] = -9.81;
  urdf.assembly = km_robot_assembly(robot, root, km_xml_attribute_of(root, "name"), (km_assembly_id){0});
  size_t links = (size_t)count_children(root, "link"), joints = (size_t)count_children(root, "joint");
  urdf.bodies = KM_ARENA_NEW(&robot->arena, km_body_id, links);
  urdf.parents = KM_ARENA_NEW(&robot->arena, const km_xml *, links);
  urdf.elements = KM_ARENA_NEW(&robot->arena, const km_xml *, links);
  urdf.leaders = KM_ARENA_NEW(&robot->arena, int, links);
  urdf.list = KM_ARENA_NEW(&robot->arena, km_urdf_joint, joints);
  if (!robot->arena.failed) {
    for (size_t i = 0; i < links; ++i)
      urdf.leaders[i] = (int)i;
    for (const km_xml *e = km_xml_child(root, "link"); e; e = km_xml_next(e))
      read_link(&urdf, root, e);
    km_urdf_read_joints(&urdf, root);
    read_closures(&urdf, root);
    tie_root(&urdf, root);
  }
  km_names_free(&urdf.links);
  km_names_free(&urdf.joints);
}
