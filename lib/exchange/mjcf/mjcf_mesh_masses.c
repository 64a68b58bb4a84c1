/* Mass properties of meshes by MuJoCo's rules. */
#include "exchange/mjcf/mjcf.h"

#include "model/geometry/hull.h"

#include <string.h>

/* Twice the area of a triangle, along its normal. */
static km_vec3 normal_of(const km_vec3 v[3]) {
  return km_vec3_cross(km_vec3_sub(v[1], v[0]), km_vec3_sub(v[2], v[0]));
}

static km_vec3 middle_of(const km_vec3 v[3]) {
  return km_vec3_scale(1.0 / 3.0, km_vec3_add(v[0], km_vec3_add(v[1], v[2])));
}

/* Contribution of a triangle: the pyramid between it and a point, or its area. */
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

/* Mass properties for density 1 as in MuJoCo's compiler (mjCMesh::Process): sums of pyramids from the surface's
 * centroid and, for the moments, from the centre of mass. The default's unsigned volumes count regions behind a dent
 * twice, but are positive for open or badly oriented surfaces. */
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

/* `hull`: only the convex hull of the mesh counts. */
static counting find_counting(km_mjcf *m, const km_xml *e, bool *hull) {
  const km_mjcf_place place = {km_pose_identity(), NULL, ""};
  const char *word = km_mjcf_get(m, e, &place, "inertia");
  *hull = word && strcmp(word, "convex") == 0;
  if (!word || strcmp(word, "legacy") == 0)
    return m->compiler.exact_meshes ? BY_VOLUME : BY_UNSIGNED_VOLUME;
  if (strcmp(word, "shell") != 0 && strcmp(word, "exact") != 0 && !*hull)
    km_robot_error(m->robot, e, "inertia: found \"%.40s\"; expected legacy, exact, convex or shell", word);
  return strcmp(word, "shell") == 0 ? BY_AREA : BY_VOLUME;
}

/* A mesh as it is to be weighed; the caller frees it. NULL: it can't be read, or has no hull. */
static km_mesh *read_counted(km_mjcf *m, const km_mjcf_mesh *found, bool hull) {
  km_mesh *mesh = km_mjcf_read_mesh(m, found), *around = NULL;
  km_error error;
  if (mesh)
    km_mesh_scale(mesh, found->scale);
  if (!mesh || !hull)
    return mesh;
  if (km_mesh_hull(mesh, &around, &error) == KM_MEMORY)
    m->robot->arena.failed = true;
  km_mesh_free(mesh);
  return around;
}

bool km_mjcf_weigh_mesh(km_mjcf *m, const char *name, km_mass *out) {
  km_robot *robot = m->robot;
  km_mjcf_mesh found;
  int known = km_names_get(&m->mesh_names, 0, name);
  if (known >= 0) {
    *out = m->mesh_masses[known];
    return true;
  }
  if (!km_mjcf_find_mesh(m, name, &found))
    return false;
  bool hull;
  counting how = find_counting(m, found.element, &hull);
  km_mesh *mesh = read_counted(m, &found, hull);
  if (!mesh)
    return false;
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
