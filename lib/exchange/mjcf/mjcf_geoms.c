/* Masses of bodies: as they are stated, or from their geoms. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

typedef struct shape {
  const char *type;
  double size[3];
} shape;

bool km_mjcf_find_line(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, km_mjcf_line *out) {
  double ends[6];
  if (km_mjcf_numbers(m, e, place, "fromto", ends, 6) != 6)
    return false;
  km_vec3 from = km_vec3_from_array(ends), to = km_vec3_from_array(ends + 3), along = km_vec3_sub(from, to);
  const double u[3] = {along.x, along.y, along.z};
  *out = (km_mjcf_line){
      {km_rotation_onto(2, km_mjcf_unit(m->robot, e, "fromto", u)), km_vec3_scale(0.5, km_vec3_add(from, to))},
      0.5 * km_vec3_norm(along)};
  return true;
}

/* Shapes defined by the ends of their axis: sets the length in the sizes, and the pose. */
static bool has_line(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, shape *s, km_pose *pose) {
  km_mjcf_line line;
  if (!km_mjcf_find_line(m, geom, place, &line))
    return false;
  bool across = strcmp(s->type, "box") == 0 || strcmp(s->type, "ellipsoid") == 0;
  s->size[across ? 2 : 1] = line.half;
  if (across)
    s->size[1] = s->size[0];
  *pose = line.pose;
  return true;
}

/* A solid of density 1 about its own frame. False: its volume isn't known here. */
static bool solid_of(const shape *s, km_mass *out) {
  const double ball[3] = {s->size[0], s->size[0], s->size[0]};
  if (strcmp(s->type, "sphere") == 0)
    *out = km_solid_ellipsoid(ball);
  else if (strcmp(s->type, "ellipsoid") == 0)
    *out = km_solid_ellipsoid(s->size);
  else if (strcmp(s->type, "box") == 0)
    *out = km_solid_box(s->size);
  else if (strcmp(s->type, "cylinder") == 0)
    *out = km_solid_cylinder(s->size[0], s->size[1]);
  else if (strcmp(s->type, "capsule") == 0)
    *out = km_solid_capsule(s->size[0], s->size[1]);
  else
    return false;
  return true;
}

static bool is_flat(const char *type) {
  return strcmp(type, "plane") == 0 || strcmp(type, "hfield") == 0;
}

void km_mjcf_weigh(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, km_mass *sum) {
  const char *type = km_mjcf_get(m, geom, place, "type"), *mesh = km_mjcf_get(m, geom, place, "mesh");
  double group = km_mjcf_number(m, geom, place, "group", 0.0), density = km_mjcf_number(m, geom, place, "density", 1e3);
  double mass = km_mjcf_number(m, geom, place, "mass", -1.0);
  shape s = {type ? type : "sphere", {0}};
  km_mass solid = {0};
  if (group < m->compiler.groups[0] || group > m->compiler.groups[1] || mass == 0.0 || (mass < 0.0 && density == 0.0) ||
      is_flat(s.type))
    return;
  km_mjcf_numbers(m, geom, place, "size", s.size, 3);
  km_pose own;
  if (!has_line(m, geom, place, &s, &own))
    own = km_mjcf_pose(m, geom, place);
  bool known =
      mesh && strcmp(s.type, "mesh") == 0 ? km_mjcf_weigh_mesh(m, mesh, &solid) : !mesh && solid_of(&s, &solid);
  if (!known) {
    km_robot_omit(m->robot,
                  "shapes that aren't weighed, as their mesh isn't found, has no volume or gives a plain form its "
                  "size",
                  km_xml_attribute_of(geom, "name"));
    return;
  }
  if (!(solid.mass > 0.0)) {
    km_robot_error(m->robot, geom, "size: a %.20s of no volume; expected sizes greater than 0", s.type);
    return;
  }
  solid = km_mass_scaled(mass > 0.0 ? mass / solid.mass : density, solid);
  km_pose pose = km_pose_product(&place->pose, &own);
  *sum = km_mass_sum(*sum, km_mass_moved(&pose, solid));
}

km_mass km_mjcf_inertial(km_mjcf *m, const km_xml *e, const km_mjcf_place *place) {
  static const int order[6] = {0, 1, 2, 3, 5, 4}; /* theirs: xx yy zz xy xz yz */
  km_mass mass = {.mass = km_robot_number(m->robot, e, "mass", 0.0)};
  double full[6];
  if (km_robot_numbers(m->robot, e, "fullinertia", full, 6))
    for (int k = 0; k < 6; ++k)
      mass.inertia[k] = full[order[k]];
  else
    km_robot_numbers(m->robot, e, "diaginertia", mass.inertia, 3);
  km_pose own = km_mjcf_pose(m, e, place), pose = km_pose_product(&place->pose, &own);
  return km_mass_moved(&pose, mass);
}

/* Sizes are halves, but for radii. */
static bool set_kind(const shape *s, km_shape_def *def) {
  bool box = strcmp(s->type, "box") == 0, cylinder = strcmp(s->type, "cylinder") == 0;
  def->kind = box                               ? KM_SHAPE_BOX
              : cylinder                        ? KM_SHAPE_CYLINDER
              : strcmp(s->type, "capsule") == 0 ? KM_SHAPE_CAPSULE
                                                : KM_SHAPE_SPHERE;
  for (int k = 0; k < km_shape_sizes(def->kind); ++k)
    def->size[k] = (k == 0 && !box ? 1.0 : 2.0) * s->size[k];
  return def->kind != KM_SHAPE_SPHERE || strcmp(s->type, "sphere") == 0;
}

/* A geom's own colour, or that of its material. */
static void read_color(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, double color[4]) {
  const char *material = km_mjcf_get(m, geom, place, "material");
  if (km_mjcf_numbers(m, geom, place, "rgba", color, 4) > 0 || !material)
    return;
  for (const km_xml *list = km_xml_child(m->root, "asset"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "material"); e; e = km_xml_next(e)) {
      const char *name = km_xml_attribute_of(e, "name");
      if (name && strcmp(name, material) == 0) {
        const km_mjcf_place plain = {km_pose_identity(), NULL, ""};
        km_mjcf_numbers(m, e, &plain, "rgba", color, 4);
        return;
      }
    }
}

void km_mjcf_show(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, km_body_id body) {
  const double hidden = 3; /* group that MuJoCo's viewer hides: by convention contact shapes */
  const char *type = km_mjcf_get(m, geom, place, "type"), *mesh = km_mjcf_get(m, geom, place, "mesh");
  shape s = {type ? type : "sphere", {0}};
  km_shape_def def = km_shape_default();
  if (km_mjcf_number(m, geom, place, "group", 0.0) >= hidden)
    return;
  km_mjcf_numbers(m, geom, place, "size", s.size, 3);
  km_pose own;
  if (!has_line(m, geom, place, &s, &own))
    own = km_mjcf_pose(m, geom, place);
  km_mjcf_mesh found;
  if (mesh && strcmp(s.type, "mesh") == 0)
    def.kind = KM_SHAPE_OF_MESH;
  bool known = def.kind == KM_SHAPE_OF_MESH ? km_mjcf_find_mesh(m, mesh, &found) && found.file : set_kind(&s, &def);
  if (!known) {
    km_robot_omit(m->robot, "shapes left out of drawings", km_xml_attribute_of(geom, "name"));
    return;
  }
  read_color(m, geom, place, def.color);
  if (def.kind == KM_SHAPE_OF_MESH) {
    def.mesh = km_robot_mesh(m->robot, found.file);
    memcpy(def.scale, found.scale, sizeof def.scale);
    own = km_pose_product(&own, &found.pose);
  }
  km_pose pose = km_pose_product(&place->pose, &own);
  km_robot_shape(m->robot, geom, body, &def, &pose);
}
