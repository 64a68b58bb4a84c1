/* Models, links and frames of an SDFormat file. */
#include "exchange/sdf/sdf.h"

#include <stdlib.h>
#include <string.h>

const char *km_sdf_text(const km_xml *element, const char *child) {
  const km_xml *e = km_xml_child(element, child);
  return e ? e->text : "";
}

double km_sdf_number(km_robot *robot, const km_xml *element, const char *child, double otherwise) {
  const km_xml *e = km_xml_child(element, child);
  double value = otherwise;
  if (e)
    km_robot_parse(robot, e, child, e->text, &value, 1);
  return value;
}

bool km_sdf_is_true(const char *text) {
  return text && (strcmp(text, "true") == 0 || strcmp(text, "1") == 0);
}

km_pose km_sdf_pose(km_robot *robot, const km_xml *element) {
  const km_xml *e = km_xml_child(element, "pose");
  const char *format = km_xml_attribute_of(e, "rotation_format");
  bool quaternion = format && strcmp(format, "quat_xyzw") == 0;
  double v[7];
  if (!e || !km_robot_parse(robot, e, "pose", e->text, v, quaternion ? 7 : 6))
    return km_pose_identity();
  km_pose pose = {km_rotation_identity(), km_vec3_from_array(v)};
  double unit = km_sdf_is_true(km_xml_attribute_of(e, "degrees")) ? M_PI / 180.0 : 1.0;
  km_robot_judge_digits(e->text, M_PI / 12.0 / unit, &robot->angles);
  if (quaternion && (v[3] != 0.0 || v[4] != 0.0 || v[5] != 0.0 || v[6] != 0.0))
    pose.R = km_quaternion_rotation(km_quaternion_normalised((km_quaternion){v[6], v[3], v[4], v[5]}));
  else if (!quaternion)
    pose.R = km_rotation_rpy((const double[3]){v[3] * unit, v[4] * unit, v[5] * unit});
  return pose;
}

/* A new entity under its name, written in `home`; -1: out of memory. */
static int add_entity(km_sdf *sdf, km_sdf_kind kind, const km_xml *at, const char *name, int home) {
  km_robot *robot = sdf->robot;
  int scope = home >= 0 && sdf->entities[home].is_merged ? sdf->entities[home].scope : home;
  km_names *names = kind == KM_SDF_JOINT ? &sdf->joints : &sdf->frames;
  if (!km_arena_grow(&robot->arena, (void **)&sdf->entities, &sdf->entity_room, (size_t)sdf->entity_count + 1,
                     sizeof *sdf->entities))
    return -1;
  if (scope >= 0 && !name[0])
    km_robot_error(robot, at, "a %s without a name; expected name=\"…\"", at->name);
  else if (scope >= 0 && km_names_get(names, scope, name) >= 0)
    km_robot_error(robot, at, "%s \"%.80s\": this name is used twice; expected a name of its own", at->name, name);
  else if (scope >= 0 && !km_names_set(names, scope, name, sdf->entity_count))
    robot->arena.failed = true;
  sdf->entities[sdf->entity_count] = (km_sdf_entity){.kind = kind,
                                                     .name = name,
                                                     .at = at,
                                                     .pose = km_xml_child(at, "pose"),
                                                     .scope = scope,
                                                     .home = home,
                                                     .base = -1,
                                                     .attached = -1,
                                                     .raw = km_pose_identity(),
                                                     .world = km_pose_identity(),
                                                     .first_link = -1};
  return sdf->entity_count++;
}

static const char *name_of(const km_xml *e) {
  const char *name = km_xml_attribute_of(e, "name");
  return name ? name : "";
}

/* The canonical link of a model is the one that it names, or the first one. */
static void choose_first(km_sdf_entity *model, const char *name, int index) {
  const char *canonical = km_xml_attribute_of(model->at, "canonical_link");
  if (model->first_link < 0 || (canonical && strcmp(canonical, name) == 0))
    model->first_link = index;
}

static void read_link(km_sdf *sdf, const km_xml *e, int home) {
  km_robot *robot = sdf->robot;
  int index = add_entity(sdf, KM_SDF_LINK, e, name_of(e), home);
  if (index < 0)
    return;
  int model = sdf->entities[index].scope;
  km_mass mass = km_sdf_mass(robot, e);
  sdf->entities[index].raw = km_sdf_pose(robot, e);
  if (sdf->entities[index].name[0])
    sdf->entities[index].body =
        km_robot_body(robot, e, sdf->entities[model].assembly, sdf->entities[index].name, &mass, NULL);
  choose_first(&sdf->entities[home], name_of(e), index);
  choose_first(&sdf->entities[model], name_of(e), index);
  for (const km_xml *v = km_xml_child(e, "visual"); v; v = km_xml_next(v))
    km_sdf_show(robot, v, name_of(e), sdf->entities[index].body);
  for (const km_xml *c = km_xml_child(e, "collision"); c; c = km_xml_next(c))
    km_robot_omit(robot, "collision shapes left out", name_of(e));
}

static void read_members(km_sdf *sdf, const km_xml *e, int home, const char *version);

static bool is_merging(const km_xml *include) {
  return include && km_sdf_is_true(km_xml_attribute_of(include, "merge"));
}

/* A model, or an included one with the name and pose that `include` gives it, or merged into the one around it. */
static void read_model(km_sdf *sdf, const km_xml *e, const km_xml *include, int home, const char *version) {
  const char *other = km_sdf_text(include, "name"), *own = other[0] ? other : name_of(e);
  bool merging = is_merging(include);
  const char *name = merging ? km_robot_text(sdf->robot, "_merged__%s__model__", own) : own;
  int index = add_entity(sdf, KM_SDF_MODEL, e, name, home);
  if (index < 0)
    return;
  km_sdf_entity *model = &sdf->entities[index];
  const km_sdf_entity *around = &sdf->entities[model->scope];
  long minor = version && strncmp(version, "1.", 2) == 0 ? strtol(version + 2, NULL, 10) : 99;
  bool replaced = km_xml_child(include, "pose") != NULL;
  const char *fixed = km_sdf_text(include, "static"), *placement = km_sdf_text(include, "placement_frame");
  model->raw = km_sdf_pose(sdf->robot, replaced ? include : e);
  model->pose = km_xml_child(replaced ? include : e, "pose");
  model->placement = placement[0] ? placement : km_xml_attribute_of(e, "placement_frame");
  model->old_axes = minor < 5;
  model->is_merged = merging;
  model->is_static = around->is_static || (!merging && km_sdf_is_true(fixed[0] ? fixed : km_sdf_text(e, "static")));
  model->assembly = merging ? around->assembly : km_robot_assembly(sdf->robot, e, model->name, around->assembly);
  read_members(sdf, e, index, version);
}

static void read_include(km_sdf *sdf, const km_xml *e, int home) {
  const char *version = NULL;
  km_sdf_file file = {NULL, sdf->file};
  const km_xml *model = km_sdf_include(sdf, e, &version, &file.path);
  if (!model)
    return;
  sdf->file = &file;
  read_model(sdf, model, e, home, version);
  sdf->file = file.outer;
}

/* Elements of a model or a world. */
static void read_members(km_sdf *sdf, const km_xml *around, int home, const char *version) {
  static const char *const silent[] = {
      "pose",  "static", "self_collide", "allow_auto_disable", "enable_wind",    "gravity", "physics",
      "scene", "audio",  "wind",         "atmosphere",         "magnetic_field", NULL};
  for (const km_xml *e = around->first; e && !sdf->robot->arena.failed; e = e->next) {
    if (strcmp(e->name, "link") == 0 && home > 0) {
      read_link(sdf, e, home);
    } else if (strcmp(e->name, "model") == 0) {
      read_model(sdf, e, NULL, home, version);
    } else if (strcmp(e->name, "include") == 0) {
      read_include(sdf, e, home);
    } else if (strcmp(e->name, "joint") == 0 || strcmp(e->name, "frame") == 0) {
      int index = add_entity(sdf, e->name[0] == 'j' ? KM_SDF_JOINT : KM_SDF_FRAME, e, name_of(e), home);
      if (index >= 0)
        sdf->entities[index].raw = km_sdf_pose(sdf->robot, e);
    } else if (strcmp(e->name, KM_SDF_TOLERANCE) == 0) {
      km_robot_parse(sdf->robot, e, e->name, e->text, &sdf->robot->settings.closure_tolerance, 1);
    } else {
      bool known = false;
      for (const char *const *s = silent; *s; ++s)
        known = known || strcmp(e->name, *s) == 0;
      if (!known && km_arena_grow(&sdf->robot->arena, (void **)&sdf->others, &sdf->other_room,
                                  (size_t)sdf->other_count + 1, sizeof *sdf->others))
        sdf->others[sdf->other_count++] = (km_sdf_other){e, home};
    }
  }
}

static void read_world(km_sdf *sdf, const km_xml *world, const char *version) {
  const km_xml *gravity = km_xml_child(world, "gravity");
  if (gravity)
    km_robot_parse(sdf->robot, gravity, "gravity", gravity->text, sdf->robot->settings.gravity, 3);
  read_members(sdf, world, 0, version);
  for (const km_xml *more = km_xml_next(world); more; more = km_xml_next(more))
    km_robot_omit(sdf->robot, "further worlds left out", name_of(more));
}

/* Named frames, as points of their links. */
static void add_frames(km_sdf *sdf) {
  for (int i = 1; i < sdf->entity_count; ++i) {
    const km_sdf_entity *frame = &sdf->entities[i];
    int link = frame->kind == KM_SDF_FRAME ? km_sdf_link_of(sdf, i) : -1;
    if (link < 0 || !sdf->entities[link].body.value)
      continue;
    km_pose back = km_pose_inverse(&sdf->entities[link].world), pose = km_pose_product(&back, &frame->world);
    km_robot_frame(sdf->robot, frame->at, sdf->entities[link].body,
                   km_robot_name_within(sdf->entities[link].name, frame->name), &pose);
  }
}

void km_sdf_read(km_robot *robot, km_xml *root) {
  km_sdf sdf = {.robot = robot};
  const char *version = km_xml_attribute_of(root, "version");
  const km_xml *world = km_xml_child(root, "world");
  robot->settings.gravity[2] = -9.8;
  if (add_entity(&sdf, KM_SDF_WORLD, root, "world", -1) == 0) {
    sdf.entities[0].body = km_builder_fixed(robot->builder);
    if (world)
      read_world(&sdf, world, version);
    for (const km_xml *e = km_xml_child(root, "model"); e; e = km_xml_next(e))
      read_model(&sdf, e, NULL, 0, version);
    if (!robot->failed && sdf.entity_count == 1 && !sdf.incomplete)
      km_robot_error(robot, root, "found no model; expected one in <sdf> or in a <world>");
  }
  if (!robot->failed && !robot->arena.failed)
    km_sdf_place_all(&sdf);
  if (!robot->failed && !robot->arena.failed) {
    add_frames(&sdf);
    km_sdf_add_joints(&sdf);
  }
  km_names_free(&sdf.frames);
  km_names_free(&sdf.joints);
}
