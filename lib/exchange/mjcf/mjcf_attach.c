/* Models that are attached to a body of another one, under a prefix and with settings and defaults of their own. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

enum { DEEPEST = 16 };

const char *km_mjcf_full(const km_mjcf *m, const char *name) {
  return m->prefix[0] || m->suffix[0] ? km_robot_text(m->robot, "%s%s%s", m->prefix, name, m->suffix) : name;
}

/* The tree of an asset's file, its includes resolved; NULL: it isn't there. */
static km_xml *read_asset(km_mjcf *m, const km_xml *asset, const km_xml *attach) {
  const char *file = km_xml_attribute_of(asset, "file"), *path = file ? km_robot_find(m->robot, file) : NULL;
  km_xml *root = path ? km_robot_read_file(m->robot, path, attach) : NULL;
  if (root)
    km_mjcf_include(m->robot, root);
  return root;
}

/* The asset of that name, or without one, whose model is called so; its tree in `root`. */
static const km_xml *find_asset(km_mjcf *m, const km_xml *attach, const char *name, km_xml **root) {
  for (const km_xml *list = km_xml_child(m->root, "asset"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "model"); e; e = km_xml_next(e)) {
      const char *own = km_xml_attribute_of(e, "name");
      if (own && strcmp(own, name) != 0)
        continue;
      *root = read_asset(m, e, attach);
      const char *called = own ? own : *root ? km_xml_attribute_of(*root, "model") : NULL;
      if (*root && called && strcmp(called, name) == 0)
        return e;
    }
  return NULL;
}

/* The tree of the model that is attached; NULL: reported. `folder`: of its file, "" beside the main one. */
static km_xml *find_root(km_mjcf *m, const km_xml *attach, const char **folder) {
  const char *name = km_xml_attribute_of(attach, "model");
  km_xml *root = NULL;
  const km_xml *asset = name ? find_asset(m, attach, name, &root) : NULL;
  const char *file = km_xml_attribute_of(asset, "file"), *slash = file ? strrchr(file, '/') : NULL;
  *folder = slash ? km_robot_text(m->robot, "%.*s", (int)(slash - file), file) : "";
  if (asset)
    return root;
  if (!m->robot->failed)
    km_robot_error(
        m->robot, attach,
        "the model \"%.80s\" to attach isn't there; expected it among the assets, and its file beside the model",
        name ? name : "");
  return NULL;
}

/* The element `kind` of that name, and the class that counts there. */
static const km_xml *find_part(const km_xml *e, const char *kind, const char *name, const char **class) {
  for (; e; e = e->next) {
    const char *own = km_xml_attribute_of(e, "name"), *around = km_xml_attribute_of(e, "childclass");
    const char *before = *class;
    if (own && strcmp(e->name, kind) == 0 && strcmp(own, name) == 0)
      return e;
    *class = around ? around : before;
    const km_xml *found = find_part(e->first, kind, name, class);
    if (found)
      return found;
    *class = before;
  }
  return NULL;
}

/* Its bodies: one with all that it carries, the members of a frame, or those of the world. Returns the element of
 * those; NULL: it isn't there. */
static const km_xml *read_part(km_mjcf *child, const km_xml *attach, const km_mjcf_place *place, int body) {
  const char *name = km_xml_attribute_of(attach, "body"), *frame = km_xml_attribute_of(attach, "frame");
  km_mjcf_place inside = {place->pose, NULL, child->suffix};
  const km_xml *world = km_xml_child(child->root, "worldbody");
  const km_xml *part = name || frame ? find_part(world ? world->first : NULL, name ? "body" : "frame",
                                                 name ? name : frame, &inside.class)
                                     : world;
  if (!part)
    km_robot_error(child->robot, attach, "%s: found \"%.80s\", which isn't in the model to attach",
                   name ? "body" : "frame",
                   name    ? name
                   : frame ? frame
                           : "");
  else if (name)
    km_mjcf_read_body(child, part, &inside, body);
  else
    km_mjcf_read_members(child, part, &inside, body, frame != NULL);
  return part;
}

/* The tables of names grow on in the one around. */
static void return_result(const km_mjcf *child, km_mjcf *m) {
  m->bodies = child->bodies;
  m->joints = child->joints;
  m->sites = child->sites;
  m->body_names = child->body_names;
  m->joint_names = child->joint_names;
  m->site_names = child->site_names;
  m->body_count = child->body_count;
  m->joint_count = child->joint_count;
  m->site_count = child->site_count;
  m->body_room = child->body_room;
  m->joint_room = child->joint_room;
  m->site_room = child->site_room;
  m->copies = child->copies;
}

void km_mjcf_attach(km_mjcf *m, const km_xml *attach, const km_mjcf_place *place, int body) {
  km_robot *robot = m->robot;
  const char *prefix = km_xml_attribute_of(attach, "prefix"), *folder = "";
  bool own = km_xml_attribute_of(attach, "model") == NULL;
  const km_xml *root = own ? m->root : find_root(m, attach, &folder);
  if (root && m->depth == DEEPEST)
    km_robot_error(robot, attach, "models are attached to each other more than %d deep; expected fewer", DEEPEST);
  if (!root || m->depth == DEEPEST)
    return;
  km_mjcf child = *m;
  child.root = root;
  child.depth++;
  child.prefix = km_robot_text(robot, "%s%s", m->prefix, prefix ? prefix : "");
  child.suffix = place->suffix;
  child.class_names = child.missing_classes = child.driven_names = child.mesh_names = (km_names){0};
  child.classes = NULL;
  child.mesh_masses = NULL;
  child.most_forces = NULL;
  child.class_count = child.driven_count = child.mesh_count = 0;
  child.class_room = child.mesh_room = 0;
  km_mjcf_read_compiler(&child);
  if (folder[0])
    child.compiler.meshes = km_robot_text(robot, "%s%s%s", folder, child.compiler.meshes ? "/" : "",
                                          child.compiler.meshes ? child.compiler.meshes : "");
  km_mjcf_read_classes(&child);
  km_mjcf_read_forces(&child);
  const km_xml *part = read_part(&child, attach, place, body);
  if (!robot->failed && !robot->arena.failed) {
    km_mjcf_read_constraints(&child);
    km_mjcf_read_actuators(&child);
    km_mjcf_read_tendon_springs(&child);
    if (!own)
      km_mjcf_read_attached_keyframes(&child, part, m->joint_count);
  }
  return_result(&child, m);
  km_names_free(&child.class_names);
  km_names_free(&child.missing_classes);
  km_names_free(&child.driven_names);
  km_names_free(&child.mesh_names);
}

/* True if all names of a constraint or actuator, and the joints of its tendon, have been attached. */
bool km_mjcf_is_here(const km_mjcf *m, const km_xml *e) {
  static const struct {
    const char *key;
    size_t names;
  } keys[] = {{"body1", offsetof(km_mjcf, body_names)},          {"body2", offsetof(km_mjcf, body_names)},
              {"joint1", offsetof(km_mjcf, joint_names)},        {"joint2", offsetof(km_mjcf, joint_names)},
              {"joint", offsetof(km_mjcf, joint_names)},         {"site", offsetof(km_mjcf, site_names)},
              {"jointinparent", offsetof(km_mjcf, joint_names)}, {"site1", offsetof(km_mjcf, site_names)},
              {"site2", offsetof(km_mjcf, site_names)}};
  for (size_t i = 0; i < sizeof keys / sizeof *keys && m->depth > 0; ++i) {
    const char *name = km_xml_attribute_of(e, keys[i].key);
    const km_names *names = (const km_names *)((const char *)m + keys[i].names);
    if (name && km_names_get(names, 0, km_mjcf_full(m, name)) < 0)
      return false;
  }
  return m->depth == 0 || (km_mjcf_tendon_is_here(m, km_xml_attribute_of(e, "tendon1")) &&
                           km_mjcf_tendon_is_here(m, km_xml_attribute_of(e, "tendon2")));
}
