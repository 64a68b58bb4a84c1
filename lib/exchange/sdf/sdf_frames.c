/* Frames that are relative to each other, names across models, and files that are included. */
#include "exchange/sdf/sdf.h"

#include "base/similar_names.h"

#include <string.h>
#include <sys/stat.h>

enum { MOST_INCLUDES = 1000 };

static int find_here(const km_sdf *sdf, int scope, const char *name) {
  int index = km_names_get(&sdf->frames, scope, name);
  return index >= 0 ? index : km_names_get(&sdf->joints, scope, name);
}

int km_sdf_find(const km_sdf *sdf, int home, const char *name) {
  int scope = sdf->entities[home].is_merged ? sdf->entities[home].scope : home;
  if (strcmp(name, "world") == 0)
    return 0;
  if (strcmp(name, "__model__") == 0)
    return home;
  for (;;) {
    if (strcmp(name, "__model__") == 0)
      return scope;
    int index = find_here(sdf, scope, name);
    const char *colons = strstr(name, "::");
    if (index >= 0 || !colons)
      return index;
    char part[256];
    size_t length = (size_t)(colons - name);
    if (length >= sizeof part)
      return -1;
    memcpy(part, name, length);
    part[length] = '\0';
    scope = km_names_get(&sdf->frames, scope, part);
    if (scope < 0)
      return -1;
    name = colons + 2;
  }
}

int km_sdf_need(km_sdf *sdf, int home, const char *name, const km_xml *at, const char *kind) {
  int index = km_sdf_find(sdf, home, name);
  if (index >= 0)
    return index;
  int scope = sdf->entities[home].is_merged ? sdf->entities[home].scope : home;
  km_nearest nearest = {.wanted = name};
  char text[KM_NEAREST_TEXT];
  for (int i = 1; i < sdf->entity_count; ++i)
    if (sdf->entities[i].scope == scope && !sdf->entities[i].is_merged)
      km_nearest_add(&nearest, sdf->entities[i].name);
  if (sdf->incomplete)
    km_robot_warn(sdf->robot, at, "the %s \"%.80s\" isn't there; what uses it is left out with it", kind, name);
  else
    km_robot_error(sdf->robot, at, "found the %s \"%.80s\", which isn't there; expected one of the model; nearest: %s",
                   kind, name, km_nearest_text(&nearest, text));
  return -1;
}

int km_sdf_link_of(const km_sdf *sdf, int entity) {
  for (int steps = 0; entity > 0 && steps <= sdf->entity_count; ++steps) {
    const km_sdf_entity *e = &sdf->entities[entity];
    if (e->kind == KM_SDF_LINK)
      return entity;
    int next = e->kind == KM_SDF_MODEL ? e->first_link : e->attached;
    if (e->kind == KM_SDF_MODEL && next < 0) /* a model without links of its own: the first one inside */
      for (int i = entity + 1; i < sdf->entity_count && next < 0; ++i)
        if (sdf->entities[i].kind == KM_SDF_MODEL && sdf->entities[i].scope == entity)
          next = i;
    entity = next;
  }
  return entity == 0 ? 0 : -1;
}

/* Joints are attached to their child, frames to what they say. */
static void attach(km_sdf *sdf, int index) {
  km_sdf_entity *e = &sdf->entities[index];
  const char *to = e->kind == KM_SDF_JOINT ? km_sdf_text(e->at, "child") : km_xml_attribute_of(e->at, "attached_to");
  if (e->kind == KM_SDF_JOINT && !to[0])
    km_robot_error(sdf->robot, e->at, "joint \"%.80s\" has no child; expected <child>", e->name);
  else if (e->kind == KM_SDF_JOINT)
    e->attached = km_sdf_need(sdf, e->home, to, km_xml_child(e->at, "child"), "child");
  else if (e->kind == KM_SDF_FRAME)
    e->attached = to && to[0] ? km_sdf_need(sdf, e->home, to, e->at, "frame") : e->home;
}

/* Base of `pose`: as stated, otherwise the child of a joint, the attachment of a frame, or the model. */
static void find_base(km_sdf *sdf, int index) {
  km_sdf_entity *e = &sdf->entities[index];
  const km_xml *pose = e->pose;
  const char *to = km_xml_attribute_of(pose, "relative_to"), *old = km_xml_attribute_of(pose, "frame");
  bool moves_with = e->kind == KM_SDF_JOINT || e->kind == KM_SDF_FRAME;
  e->base = moves_with ? e->attached : e->home;
  if (to && to[0])
    e->base = km_sdf_need(sdf, e->home, to, pose, "frame");
  else if (old && old[0] && km_sdf_find(sdf, e->home, old) >= 0)
    e->base = km_sdf_find(sdf, e->home, old);
  else if (old && old[0])
    km_robot_omit(sdf->robot, "frames of poses left out, as they aren't there", old);
}

/* A model whose pose is that of one of the frames inside: where that frame is in the model counts backwards. */
static void use_placement(km_sdf *sdf, int index) {
  km_sdf_entity *model = &sdf->entities[index];
  const char *name = model->placement;
  int frame = name && name[0] ? km_sdf_need(sdf, index, name, model->at, "frame") : -1;
  km_pose inside = km_pose_identity();
  int steps = 0;
  for (; frame >= 0 && frame != index && steps <= sdf->entity_count; ++steps) {
    inside = km_pose_product(&sdf->entities[frame].raw, &inside);
    frame = sdf->entities[frame].base;
  }
  if (frame != index)
    return;
  km_pose back = km_pose_inverse(&inside);
  model->raw = km_pose_product(&model->raw, &back);
}

/* Follows the bases to a known one, then computes the poses backwards; chain[entity_count]. */
static void place(km_sdf *sdf, int index, int *chain) {
  int count = 0;
  for (int i = index; i >= 0 && !sdf->entities[i].known; i = sdf->entities[i].base) {
    if (count == sdf->entity_count) {
      km_robot_error(sdf->robot, sdf->entities[index].at, "the pose of \"%.80s\" is relative to itself, in a circle",
                     sdf->entities[index].name);
      return;
    }
    chain[count++] = i;
  }
  while (count-- > 0) {
    km_sdf_entity *e = &sdf->entities[chain[count]];
    if (e->base >= 0)
      e->world = km_pose_product(&sdf->entities[e->base].world, &e->raw);
    e->known = true;
  }
}

void km_sdf_place_all(km_sdf *sdf) {
  int *chain = KM_ARENA_NEW(&sdf->robot->arena, int, (size_t)sdf->entity_count);
  if (!chain)
    return;
  for (int i = 1; i < sdf->entity_count; ++i)
    attach(sdf, i);
  for (int i = 1; i < sdf->entity_count; ++i)
    find_base(sdf, i);
  for (int i = sdf->entity_count - 1; i > 0; --i)
    if (sdf->entities[i].kind == KM_SDF_MODEL)
      use_placement(sdf, i);
  sdf->entities[0].known = true;
  for (int i = 1; i < sdf->entity_count && !sdf->robot->failed; ++i)
    place(sdf, i, chain);
}

/* The tree of the model.config in the model's folder, or of one beside the file or above it that has the model's name.
 * `folder`: where it is. */
static const km_xml *find_config(km_robot *robot, const char *uri, const km_xml *at, const char **folder) {
  const char *slash = strrchr(uri, '/'), *name = slash ? slash + 1 : uri;
  const char *path = km_robot_find_whole(robot, km_robot_text(robot, "%s/model.config", uri));
  *folder = uri;
  if (path)
    return km_robot_read_file(robot, path, at);
  path = km_robot_find_whole(robot, "model.config");
  const km_xml *tree = path ? km_robot_read_file(robot, path, at) : NULL;
  *folder = ".";
  return tree && strcmp(km_sdf_text(tree, "name"), name) == 0 ? tree : NULL;
}

/* The description's file: itself, or in a model's folder the last one that model.config names, or model.sdf. */
static const char *find_file(km_robot *robot, const char *uri, const km_xml *at) {
  const char *file = "model.sdf", *folder, *own = km_robot_find(robot, uri);
  if (own)
    return own;
  const km_xml *tree = find_config(robot, uri, at, &folder);
  for (const km_xml *sdf = km_xml_child(tree, "sdf"); sdf; sdf = km_xml_next(sdf))
    file = sdf->text;
  return km_robot_find_whole(robot, km_robot_text(robot, "%s/%s", tree ? folder : uri, file));
}

/* A file that holds itself would never end. */
static bool is_open(const km_sdf *sdf, const char *path) {
  struct stat own, other;
  if (stat(path, &own) != 0)
    return false;
  const char *main_file = sdf->robot->request->file;
  if (main_file && stat(main_file, &other) == 0 && own.st_dev == other.st_dev && own.st_ino == other.st_ino)
    return true;
  for (const km_sdf_file *file = sdf->file; file; file = file->outer)
    if (stat(file->path, &other) == 0 && own.st_dev == other.st_dev && own.st_ino == other.st_ino)
      return true;
  return false;
}

const km_xml *km_sdf_include(km_sdf *sdf, const km_xml *include, const char **version, const char **path) {
  km_robot *robot = sdf->robot;
  const char *uri = km_sdf_text(include, "uri");
  *path = uri[0] ? find_file(robot, uri, include) : NULL;
  if (!*path) {
    sdf->incomplete = true;
    km_robot_warn(robot, include,
                  "the model \"%.200s\" to include isn't there and is left out; expected it beside the file or in a "
                  "folder above",
                  uri);
    return NULL;
  }
  if (is_open(sdf, *path))
    km_robot_error(robot, include, "for the model \"%.200s\" found a file that includes it; expected another one", uri);
  else if (sdf->includes++ == MOST_INCLUDES)
    km_robot_error(robot, include, "\"%.200s\" is one include too many; expected at most a thousand", uri);
  if (robot->failed)
    return NULL;
  const km_xml *root = km_robot_read_file(robot, *path, include);
  if (root && strcmp(root->name, "robot") == 0) {
    *version = NULL;
    return km_sdf_from_urdf(robot, root);
  }
  const km_xml *model = km_xml_child(root, "model");
  *version = km_xml_attribute_of(root, "version");
  if (root && !model)
    km_robot_error(robot, include, "\"%.200s\" holds no model; expected one to include", *path);
  return model;
}
