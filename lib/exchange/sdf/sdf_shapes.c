/* Shapes of links, and their mass properties: as stated, or from collision shapes. */
#include "exchange/sdf/sdf.h"

#include "model/geometry/mass_properties.h"

/* A pose that no joint depends on: how it is rounded doesn't count. */
static km_pose loose_pose(km_robot *robot, const km_xml *element) {
  km_robot_digits rounding = robot->angles;
  km_pose pose = km_sdf_pose(robot, element);
  robot->angles = rounding;
  return pose;
}

/* Shape of an element `geometry`; false if it is unsupported. */
static bool read_shape(km_robot *robot, const km_xml *geometry, km_shape_def *def) {
  const km_xml *box = km_xml_child(geometry, "box"), *ball = km_xml_child(geometry, "sphere");
  const km_xml *round = km_xml_child(geometry, "cylinder"), *capsule = km_xml_child(geometry, "capsule");
  const km_xml *mesh = km_xml_child(geometry, "mesh"), *scale = km_xml_child(mesh, "scale");
  const km_xml *sides = km_xml_child(box, "size");
  *def = km_shape_default();
  if (mesh && km_sdf_text(mesh, "uri")[0]) {
    def->kind = KM_SHAPE_OF_MESH;
    def->mesh = km_robot_mesh(robot, km_sdf_text(mesh, "uri"));
    if (scale)
      km_robot_parse(robot, scale, "scale", scale->text, def->scale, 3);
  } else if (sides) {
    def->kind = KM_SHAPE_BOX;
    km_robot_parse(robot, sides, "size", sides->text, def->size, 3);
  } else if (ball) {
    def->size[0] = km_sdf_number(robot, ball, "radius", 0.0);
  } else if (round || capsule) {
    def->kind = round ? KM_SHAPE_CYLINDER : KM_SHAPE_CAPSULE;
    def->size[0] = km_sdf_number(robot, round ? round : capsule, "radius", 0.0);
    def->size[1] = km_sdf_number(robot, round ? round : capsule, "length", 0.0);
  }
  return mesh || sides || ball || round || capsule;
}

void km_sdf_show(km_robot *robot, const km_xml *visual, const char *link, km_body_id body) {
  const km_xml *color = km_xml_child(km_xml_child(visual, "material"), "diffuse");
  km_shape_def def;
  if (!read_shape(robot, km_xml_child(visual, "geometry"), &def)) {
    km_robot_omit(robot, "visual shapes left out", link);
    return;
  }
  if (color && km_robot_parse_some(robot, color, "diffuse", color->text, def.color, 3, 4) == 3)
    def.color[3] = 1.0;
  km_pose pose = loose_pose(robot, visual);
  km_robot_shape(robot, visual, body, &def, &pose);
}

/* A mesh of density 1; false: it isn't found, or has no volume. */
static bool weigh_mesh(km_robot *robot, const km_xml *mesh, const double scale[3], km_mass *out) {
  const char *path = km_robot_find(robot, km_sdf_text(mesh, "uri"));
  km_mesh *surface = NULL;
  km_error error;
  if (!path)
    return false;
  km_status status = km_mesh_read(path, &surface, &error);
  if (!status) {
    km_mesh_scale(surface, scale);
    status = km_mesh_weigh(surface, path, out, &error);
  }
  robot->arena.failed = robot->arena.failed || status == KM_MEMORY;
  km_mesh_free(surface);
  return status == KM_OK;
}

/* A collision's shape of density 1, in its own frame. */
static bool weigh_shape(km_robot *robot, const km_xml *geometry, km_mass *out) {
  const km_xml *ellipsoid = km_xml_child(geometry, "ellipsoid"), *cone = km_xml_child(geometry, "cone");
  const km_xml *radii = km_xml_child(ellipsoid, "radii");
  km_shape_def def = km_shape_default();
  double axes[3] = {0};
  *out = (km_mass){0};
  if (radii && km_robot_parse(robot, radii, "radii", radii->text, axes, 3))
    *out = km_solid_ellipsoid(axes);
  else if (cone)
    *out = km_solid_cone(km_sdf_number(robot, cone, "radius", 0.0), 0.5 * km_sdf_number(robot, cone, "length", 0.0));
  else if (!read_shape(robot, geometry, &def))
    return false;
  else if (def.kind == KM_SHAPE_OF_MESH)
    return weigh_mesh(robot, km_xml_child(geometry, "mesh"), def.scale, out);
  else if (def.kind == KM_SHAPE_BOX)
    *out = km_solid_box((const double[3]){0.5 * def.size[0], 0.5 * def.size[1], 0.5 * def.size[2]});
  else if (def.kind == KM_SHAPE_SPHERE)
    *out = km_solid_ellipsoid((const double[3]){def.size[0], def.size[0], def.size[0]});
  else if (def.kind == KM_SHAPE_CYLINDER)
    *out = km_solid_cylinder(def.size[0], 0.5 * def.size[1]);
  else
    *out = km_solid_capsule(def.size[0], 0.5 * def.size[1]);
  return out->mass > 0.0;
}

/* Mass properties of the collision shapes with their own densities, the link's, or that of water, scaled to a stated
 * mass. */
static km_mass weigh_link(km_robot *robot, const km_xml *link, const km_xml *inertial) {
  double density = km_sdf_number(robot, inertial, "density", 1000.0);
  double stated = km_sdf_number(robot, inertial, "mass", -1.0);
  const char *name = km_xml_attribute_of(link, "name");
  km_mass sum = {0}, part;
  if (!km_xml_child(link, "collision"))
    km_robot_error(robot, inertial,
                   "link \"%.80s\": its mass is that of its collision shapes, and it has none; expected one",
                   name ? name : "");
  for (const km_xml *c = km_xml_child(link, "collision"); c; c = km_xml_next(c)) {
    if (!weigh_shape(robot, km_xml_child(c, "geometry"), &part)) {
      km_robot_omit(robot, "collision shapes that aren't weighed, as their mesh isn't found or they have no volume",
                    name);
      continue;
    }
    km_pose pose = loose_pose(robot, c);
    part = km_mass_scaled(km_sdf_number(robot, c, "density", density), part);
    sum = km_mass_sum(sum, km_mass_moved(&pose, part));
  }
  if (stated < 0.0)
    return sum;
  return sum.mass > 0.0 ? km_mass_scaled(stated / sum.mass, sum) : (km_mass){.mass = stated};
}

/* A link without a statement of its mass has 1 kg and 1 kg·m². */
km_mass km_sdf_mass(km_robot *robot, const km_xml *link) {
  static const char *const keys[6] = {"ixx", "iyy", "izz", "ixy", "iyz", "ixz"};
  const km_xml *inertial = km_xml_child(link, "inertial"), *inertia = km_xml_child(inertial, "inertia");
  if (km_sdf_is_true(km_xml_attribute_of(inertial, "auto")))
    return weigh_link(robot, link, inertial);
  km_mass mass = {.mass = km_sdf_number(robot, inertial, "mass", 1.0)};
  for (int k = 0; k < 6; ++k)
    mass.inertia[k] = km_sdf_number(robot, inertia, keys[k], k < 3 ? 1.0 : 0.0);
  km_pose pose = loose_pose(robot, inertial);
  return km_mass_moved(&pose, mass);
}
