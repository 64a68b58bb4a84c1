/* Assemblies, bodies and frames of a description, as calls of the builder. */
#include "exchange/robot/robot.h"

#include "model/geometry/mass_properties.h"

#include <string.h>

void km_robot_builder_failed(km_robot *robot, const km_xml *at, km_status status, const km_error *error) {
  if (status == KM_MEMORY)
    robot->arena.failed = true;
  else
    km_robot_error(robot, at, "%s", error->text);
}

const char *km_robot_free_name(km_robot *robot, const km_names *names, int scope, const char *name, const char *mark) {
  const char *free_name = name;
  for (int n = 1; km_names_get(names, scope, free_name) >= 0 || strcmp(free_name, "fixed") == 0 ||
                  strcmp(free_name, "origin") == 0 || !free_name[0];
       ++n) {
    if (robot->arena.failed)
      return name;
    free_name = n == 1 ? km_robot_text(robot, "%s:%s", name, mark) : km_robot_text(robot, "%s:%s%d", name, mark, n);
  }
  return free_name;
}

void km_robot_take_name(km_robot *robot, km_names *names, int scope, const char *name, int value) {
  if (!km_names_set(names, scope, name, value))
    robot->arena.failed = true;
}

km_assembly_id km_robot_assembly(km_robot *robot, const km_xml *at, const char *name, km_assembly_id parent) {
  km_assembly_id id = {0};
  km_error error;
  const char *own = name && name[0] ? name : "robot";
  own = strcmp(own, "fixed") == 0 ? "fixed:model" : own;
  km_status status = km_model_add_assembly(robot->builder, own, parent, &id, &error);
  if (status)
    km_robot_builder_failed(robot, at, status, &error);
  return id;
}

/* A mass or an inertia that no body can have is dropped. */
static km_mass sane_mass(km_robot *robot, const km_xml *at, const char *name, km_mass mass) {
  double moments[3], size = 0.0;
  if (mass.mass < 0.0) {
    km_robot_warn(robot, at, "body \"%.80s\": its mass is %g; it is taken as 0", name, mass.mass);
    return (km_mass){0};
  }
  for (int k = 0; k < 6; ++k)
    size = fmax(size, fabs(mass.inertia[k]));
  km_principal_moments(mass.inertia, moments);
  if (moments[0] < -1e-9 * size) {
    km_robot_warn(
        robot, at,
        "body \"%.80s\": a principal moment of inertia is negative, %.4g beside %.4g and %.4g; its inertia is "
        "taken as 0",
        name, moments[0], moments[1], moments[2]);
    memset(mass.inertia, 0, sizeof mass.inertia);
  }
  return mass;
}

km_body_id km_robot_body(km_robot *robot, const km_xml *at, km_assembly_id assembly, const char *name,
                         const km_mass *mass, const char *mesh) {
  km_body_id id = {0};
  km_error error;
  km_mass sane = mass ? sane_mass(robot, at, name, *mass) : (km_mass){0};
  km_body_def def = km_body_default();
  def.name =
      strcmp(name, "fixed") == 0 ? km_robot_free_name(robot, &robot->bodies, assembly.value, name, "body") : name;
  def.assembly = assembly;
  def.mass = sane.mass;
  memcpy(def.center_of_mass, &sane.center, sizeof def.center_of_mass);
  memcpy(def.inertia, sane.inertia, sizeof def.inertia);
  def.mesh = mesh;
  km_status status = km_model_add_body(robot->builder, &def, &id, &error);
  if (status)
    km_robot_builder_failed(robot, at, status, &error);
  else
    km_robot_take_name(robot, &robot->bodies, assembly.value, km_robot_text(robot, "%s", def.name), id.value);
  return id;
}

static bool is_identity(const km_pose *pose) {
  double rows[9];
  bool same = pose->p.x == 0.0 && pose->p.y == 0.0 && pose->p.z == 0.0;
  km_rotation_rows(&pose->R, rows);
  for (int k = 0; k < 9; ++k)
    same = same && rows[k] == (k % 4 == 0);
  return same;
}

km_frame_id km_robot_place(km_robot *robot, const km_xml *at, km_body_id body, const char *name, const km_pose *pose) {
  return is_identity(pose) ? km_builder_origin(robot->builder, body) : km_robot_frame(robot, at, body, name, pose);
}

km_frame_id km_robot_frame(km_robot *robot, const km_xml *at, km_body_id body, const char *name, const km_pose *pose) {
  km_frame_id id = {0};
  km_error error;
  km_frame_def def = km_frame_default();
  def.name = km_robot_free_name(robot, &robot->frames, body.value, name, "joint");
  memcpy(def.T, &pose->p, sizeof def.T);
  km_rotation_rows(&pose->R, def.R);
  robot->reach = fmax(robot->reach, km_vec3_norm(pose->p));
  km_status status = km_model_add_frame(robot->builder, body, &def, &id, &error);
  if (status)
    km_robot_builder_failed(robot, at, status, &error);
  else
    km_robot_take_name(robot, &robot->frames, body.value, km_robot_text(robot, "%s", def.name), id.value);
  return id;
}

const char *km_robot_name_within(const char *body, const char *name) {
  size_t length = strlen(body);
  return strncmp(name, body, length) == 0 && name[length] == '/' && name[length + 1] ? name + length + 1 : name;
}

void km_robot_shape(km_robot *robot, const km_xml *at, km_body_id body, km_shape_def *def, const km_pose *pose) {
  km_error error;
  bool sound = def->kind != KM_SHAPE_OF_MESH || def->scale[0] * def->scale[1] * def->scale[2] != 0.0;
  for (int k = 0; k < km_shape_sizes(def->kind); ++k)
    sound = sound && def->size[k] > 0.0;
  for (int k = 0; k < 4 && def->color[3] >= 0.0; ++k)
    def->color[k] = fmin(fmax(def->color[k], 0.0), 1.0);
  memcpy(def->T, &pose->p, sizeof def->T);
  km_rotation_rows(&pose->R, def->R);
  if (body.value < 2) /* the inertial frame, which has no shapes, or a body that was refused */
    return;
  if (!sound) {
    km_robot_omit(robot, "shapes without a size left out", km_xml_attribute_of(at, "name"));
    return;
  }
  km_status status = km_model_add_shape(robot->builder, body, def, &error);
  if (status)
    km_robot_builder_failed(robot, at, status, &error);
}

/* The element that is no URDF but a macro of it; NULL: none. */
static const km_xml *find_macro(const km_xml *element) {
  if (strncmp(element->name, "xacro:", 6) == 0)
    return element;
  for (const km_xml *e = element->first; e; e = e->next) {
    const km_xml *macro = find_macro(e);
    if (macro)
      return macro;
  }
  return NULL;
}

bool km_robot_refuses_macros(km_robot *robot, const km_xml *root) {
  const km_xml *macro = find_macro(root);
  if (macro)
    km_robot_error(robot, macro, "<%.40s> is a macro of xacro; expected a file in which xacro has expanded its macros",
                   macro->name);
  return macro != NULL;
}
