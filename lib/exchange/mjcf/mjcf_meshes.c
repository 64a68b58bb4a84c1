/* Meshes that geoms name: where they are, and their surfaces. */
#include "exchange/mjcf/mjcf.h"

#include "model/geometry/hull.h"

#include <string.h>

static const km_xml *find_element(const km_mjcf *m, const char *name) {
  for (const km_xml *list = km_xml_child(m->root, "asset"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "mesh"); e; e = km_xml_next(e)) {
      const char *own = km_xml_attribute_of(e, "name"), *file = km_xml_attribute_of(e, "file");
      const char *slash = file ? strrchr(file, '/') : NULL, *base = slash ? slash + 1 : file;
      const char *dot = base ? strrchr(base, '.') : NULL;
      size_t stem = dot ? (size_t)(dot - base) : base ? strlen(base) : 0;
      bool named = own ? strcmp(own, name) == 0 : base && strlen(name) == stem && strncmp(base, name, stem) == 0;
      if (named && (file || km_xml_attribute_of(e, "vertex")))
        return e;
    }
  return NULL;
}

bool km_mjcf_find_mesh(km_mjcf *m, const char *name, km_mjcf_mesh *out) {
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  const km_xml *e = find_element(m, name);
  double at[3] = {0}, turn[4] = {1, 0, 0, 0};
  if (!e)
    return false;
  const char *folder = m->compiler.meshes, *file = km_xml_attribute_of(e, "file");
  *out = (km_mjcf_mesh){.element = e, .scale = {1, 1, 1}};
  if (file)
    out->file = km_robot_text(m->robot, "%s%s%s", folder ? folder : "", folder ? "/" : "", file);
  km_mjcf_numbers(m, e, &place, "scale", out->scale, 3);
  km_mjcf_numbers(m, e, &place, "refpos", at, 3);
  km_mjcf_numbers(m, e, &place, "refquat", turn, 4);
  /* Vertices are scale · Rᵀ (v - at); where the scale isn't the same along all axes, R is the identity. */
  km_quaternion q = {turn[0], turn[1], turn[2], turn[3]};
  km_rotation R = km_quaternion_rotation(km_quaternion_normalised(q));
  out->pose.R = km_rotation_inverse(&R);
  km_vec3 p = km_rotate(&out->pose.R, km_vec3_from_array(at));
  out->pose.p = (km_vec3){-out->scale[0] * p.x, -out->scale[1] * p.y, -out->scale[2] * p.z};
  return true;
}

/* Numbers of an attribute, three a piece; NULL: there are none, or they are no whole pieces. */
static double *read_threes(km_mjcf *m, const km_xml *e, const char *key, int *count) {
  const char *text = km_xml_attribute_of(e, key);
  int numbers = text ? km_robot_count(text) : 0;
  *count = numbers / 3;
  double *out = numbers % 3 == 0 && numbers > 0 ? KM_ARENA_NEW(&m->robot->arena, double, (size_t)numbers) : NULL;
  if (numbers % 3)
    km_robot_error(m->robot, e, "%s: found %d numbers; expected three for each", key, numbers);
  return out && km_robot_parse(m->robot, e, key, text, out, numbers) ? out : NULL;
}

static bool copy_faces(km_mjcf *m, const km_xml *e, const double *corners, km_mesh *mesh) {
  for (int k = 0; k < 3 * mesh->triangle_count; ++k) {
    double corner = corners[k];
    if (!(corner >= 0.0 && corner < mesh->vertex_count && corner == floor(corner))) {
      km_robot_error(m->robot, e, "face: found the vertex %g; expected one of the %d, from 0", corner,
                     mesh->vertex_count);
      return false;
    }
    mesh->triangles[k / 3].corner[k % 3] = (int)corner;
  }
  return true;
}

/* Reads a mesh whose vertices are in the model; without faces it is their convex hull. */
static km_mesh *read_inline(km_mjcf *m, const km_xml *e) {
  int vertices, faces;
  const double *at = read_threes(m, e, "vertex", &vertices), *corners = read_threes(m, e, "face", &faces);
  km_mesh *mesh = at ? km_mesh_create(vertices, faces) : NULL, *hull = NULL;
  km_error error;
  m->robot->arena.failed = m->robot->arena.failed || (at && !mesh);
  if (!mesh)
    return NULL;
  for (int v = 0; v < vertices; ++v)
    mesh->vertices[v] = km_vec3_from_array(at + 3 * v);
  if (faces && corners && copy_faces(m, e, corners, mesh))
    return mesh;
  if (!faces && km_mesh_hull(mesh, &hull, &error) == KM_MEMORY)
    m->robot->arena.failed = true;
  km_mesh_free(mesh);
  return hull;
}

km_mesh *km_mjcf_read_mesh(km_mjcf *m, const km_mjcf_mesh *mesh) {
  km_mesh *out = NULL;
  km_error error;
  const char *path = mesh->file ? km_robot_find(m->robot, mesh->file) : NULL;
  if (!mesh->file)
    return read_inline(m, mesh->element);
  km_status status = path ? km_mesh_read(path, &out, &error) : KM_OK;
  m->robot->arena.failed = m->robot->arena.failed || status == KM_MEMORY;
  return status ? NULL : out;
}
