/* Meshes that geoms name: where their files are, and what they weigh as MuJoCo counts. */
#include "exchange/mjcf/mjcf.h"

#include "model/mesh.h"

#include <string.h>

static const km_xml *find_element(const km_mjcf *m, const char *name) {
  for (const km_xml *list = km_xml_child(m->root, "asset"); list; list = km_xml_next(list))
    for (const km_xml *e = km_xml_child(list, "mesh"); e; e = km_xml_next(e)) {
      const char *own = km_xml_attribute_of(e, "name"), *file = km_xml_attribute_of(e, "file");
      const char *slash = file ? strrchr(file, '/') : NULL, *base = slash ? slash + 1 : file;
      const char *dot = base ? strrchr(base, '.') : NULL;
      size_t stem = dot ? (size_t)(dot - base) : base ? strlen(base) : 0;
      bool named = own ? strcmp(own, name) == 0 : base && strlen(name) == stem && strncmp(base, name, stem) == 0;
      if (named && file)
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
  const char *folder = m->compiler.meshes;
  *out = (km_mjcf_mesh){.element = e, .scale = {1, 1, 1}};
  out->file =
      km_robot_text(m->robot, "%s%s%s", folder ? folder : "", folder ? "/" : "", km_xml_attribute_of(e, "file"));
  km_mjcf_numbers(m, e, &place, "scale", out->scale, 3);
  km_mjcf_numbers(m, e, &place, "refpos", at, 3);
  km_mjcf_numbers(m, e, &place, "refquat", turn, 4);
  /* Vertices are scale · Rᵀ (v - at); where the scale isn't the same along all axes, R is the identity. */
  km_quaternion q = {turn[0], turn[1], turn[2], turn[3]};
  km_rotation R = km_quaternion_rotation(km_quaternion_normalised(q));
  out->pose.R = km_rotation_inverse(&R);
  km_vec3 p = km_rotate(&out->pose.R, km_vec3_make(at));
  out->pose.p = (km_vec3){-out->scale[0] * p.x, -out->scale[1] * p.y, -out->scale[2] * p.z};
  return true;
}

/* Twice the area of a triangle, along its normal. */
static km_vec3 normal_of(const km_vec3 v[3]) {
  return km_vec3_cross(km_vec3_sub(v[1], v[0]), km_vec3_sub(v[2], v[0]));
}

static km_vec3 middle_of(const km_vec3 v[3]) {
  return km_vec3_scale(1.0 / 3.0, km_vec3_add(v[0], km_vec3_add(v[1], v[2])));
}

/* How a triangle counts: by the pyramid between it and a point, or by its own area. */
typedef enum counting { BY_VOLUME, BY_UNSIGNED_VOLUME, BY_AREA } counting;

static double size_of(const km_vec3 v[3], km_vec3 from, counting how) {
  km_vec3 n = normal_of(v);
  double volume = km_vec3_dot(km_vec3_sub(middle_of(v), from), n) / 6.0;
  return how == BY_AREA ? 0.5 * km_vec3_norm(n) : how == BY_UNSIGNED_VOLUME ? fabs(volume) : volume;
}

static void corners(const km_mesh *mesh, int t, km_vec3 origin, km_vec3 v[3]) {
  for (int k = 0; k < 3; ++k)
    v[k] = km_vec3_sub(mesh->vertices[mesh->triangles[t].corner[k]], origin);
}

/* Its weighted mean over the triangles: of their middles, or of the pyramids' centres, which are a quarter nearer to
 * their top. */
static km_vec3 mean(const km_mesh *mesh, km_vec3 from, counting how) {
  km_vec3 sum = {0, 0, 0}, v[3];
  double total = 0.0, near = how == BY_AREA ? 0.0 : 0.25;
  for (int t = 0; t < mesh->triangle_count; ++t) {
    corners(mesh, t, (km_vec3){0, 0, 0}, v);
    double size = size_of(v, from, how);
    km_vec3 center = km_vec3_add(km_vec3_scale(1.0 - near, middle_of(v)), km_vec3_scale(near, from));
    sum = km_vec3_axpy(size, center, sum);
    total += size;
  }
  return total > 0.0 ? km_vec3_scale(1.0 / total, sum) : from;
}

/* ∫ x_i x_j over the pyramid with its top at the origin, or over the triangle, of size 1. */
static double product(const km_vec3 v[3], int i, int j, counting how) {
  const double x[3][3] = {{v[0].x, v[0].y, v[0].z}, {v[1].x, v[1].y, v[1].z}, {v[2].x, v[2].y, v[2].z}};
  double sum = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      sum += (a == b ? 2.0 : 1.0) * x[a][i] * x[b][j];
  return sum / (how == BY_AREA ? 12.0 : 20.0);
}

/* Mass properties of density 1 as MuJoCo's compiler finds them (mjCMesh::Process): by pyramids seen from the middle of
 * the surface and, for the moments, from the centre of mass. The unsigned volumes of the default count twice what lies
 * behind a dent, but those of an open or badly oriented surface stay positive. */
static km_mass weigh(const km_mesh *mesh, counting how) {
  static const int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
  km_vec3 middle = mean(mesh, (km_vec3){0, 0, 0}, BY_AREA), v[3];
  km_mass out = {.center = mean(mesh, middle, how)};
  double P[6] = {0};
  for (int t = 0; t < mesh->triangle_count; ++t) {
    corners(mesh, t, out.center, v);
    double size = size_of(v, (km_vec3){0, 0, 0}, how);
    out.mass += size;
    for (int k = 0; k < 6; ++k)
      P[k] += size * product(v, pair[k][0], pair[k][1], how);
  }
  const double moments[6] = {P[1] + P[2], P[0] + P[2], P[0] + P[1], -P[3], -P[4], -P[5]};
  memcpy(out.inertia, moments, sizeof moments);
  return out;
}

static void scale(km_mesh *mesh, const double by[3]) {
  bool mirrored = by[0] * by[1] * by[2] < 0.0;
  for (int v = 0; v < mesh->vertex_count; ++v) {
    km_vec3 *p = &mesh->vertices[v];
    *p = (km_vec3){by[0] * p->x, by[1] * p->y, by[2] * p->z};
  }
  for (int t = 0; t < mesh->triangle_count && mirrored; ++t) {
    int corner = mesh->triangles[t].corner[1];
    mesh->triangles[t].corner[1] = mesh->triangles[t].corner[2];
    mesh->triangles[t].corner[2] = corner;
  }
}

static bool find_counting(km_mjcf *m, const km_xml *e, counting *out) {
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  const char *word = km_mjcf_get(m, e, &place, "inertia");
  *out = !word || strcmp(word, "legacy") == 0 ? (m->compiler.exact_meshes ? BY_VOLUME : BY_UNSIGNED_VOLUME)
         : strcmp(word, "shell") == 0         ? BY_AREA
                                              : BY_VOLUME;
  return !word || strcmp(word, "convex") != 0;
}

bool km_mjcf_weigh_mesh(km_mjcf *m, const char *name, km_mass *out) {
  km_robot *robot = m->robot;
  km_mjcf_mesh found;
  km_mesh *mesh = NULL;
  km_error error;
  counting how;
  int known = km_names_get(&m->mesh_names, 0, name);
  if (known >= 0) {
    *out = m->mesh_masses[known];
    return true;
  }
  const char *path = km_mjcf_find_mesh(m, name, &found) ? km_robot_find(robot, found.file) : NULL;
  if (!path || !find_counting(m, found.element, &how) || km_mesh_read(path, &mesh, &error))
    return false;
  scale(mesh, found.scale);
  *out = weigh(mesh, how);
  km_mesh_free(mesh);
  *out = km_mass_moved(&found.pose, *out);
  if (!km_arena_grow(&robot->arena, (void **)&m->mesh_masses, &m->mesh_room, (size_t)m->mesh_count + 1,
                     sizeof *m->mesh_masses) ||
      !km_names_set(&m->mesh_names, 0, name, m->mesh_count)) {
    robot->arena.failed = true;
    return false;
  }
  m->mesh_masses[m->mesh_count++] = *out;
  return true;
}
