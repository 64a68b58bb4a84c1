/* Mass properties of a closed surface (docs/theory.md 14.1). A tetrahedron 0abc has the signed volume V = d/6, d =
 * a·(b × c), and with s = a + b + c the integrals ∫ x dV = d/24 s, ∫ x xᵀ dV = d/120 (s sᵀ + a aᵀ + b bᵀ + c cᵀ),
 * exact because the integrands are quadratic. The sum over a closed surface is the integral over its interior. */
#include "model/geometry/mass_properties.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct side {
  int low, high; /* vertices */
  int sense;     /* +1: traversed from the lower to the higher vertex */
} side;

static int by_ends(const void *a, const void *b) {
  const side *x = a, *y = b;
  if (x->low != y->low)
    return x->low < y->low ? -1 : 1;
  return (x->high > y->high) - (x->high < y->high);
}

static void list_sides(const km_mesh *mesh, side *sides) {
  for (int t = 0; t < mesh->triangle_count; ++t)
    for (int k = 0; k < 3; ++k) {
      int from = mesh->triangles[t].corner[k], to = mesh->triangles[t].corner[(k + 1) % 3];
      *sides++ = from < to ? (side){from, to, +1} : (side){to, from, -1};
    }
}

km_status km_mesh_check(const km_mesh *mesh, km_mesh_faults *out, km_error *error) {
  size_t count = 3 * (size_t)mesh->triangle_count;
  side *sides = KM_NEW(side, count);
  *out = (km_mesh_faults){0};
  if (!sides)
    return km_fail(error, KM_MEMORY, "out of memory while checking a mesh");
  list_sides(mesh, sides);
  qsort(sides, count, sizeof *sides, by_ends);
  for (size_t i = 0, next; i < count; i = next) {
    int turns = 0; /* traversals in one sense minus those in the other */
    for (next = i; next < count && by_ends(&sides[i], &sides[next]) == 0; ++next)
      turns += sides[next].sense;
    if (turns % 2 != 0)
      out->open_edges++;
    else if (turns != 0)
      out->mixed_edges++;
  }
  km_free(sides);
  return KM_OK;
}

/* Sums over the tetrahedra, about `origin`. */
typedef struct integrals {
  double d;         /* 6 ∫ 1 dV */
  km_vec3 first;    /* 24 ∫ x dV */
  double second[6]; /* 120 ∫ xx yy zz xy yz zx dV */
} integrals;

static void add_tetrahedron(integrals *sum, km_vec3 a, km_vec3 b, km_vec3 c) {
  double d = km_vec3_dot(a, km_vec3_cross(b, c));
  km_vec3 s = km_vec3_add(a, km_vec3_add(b, c));
  const km_vec3 points[4] = {s, a, b, c};
  sum->d += d;
  sum->first = km_vec3_axpy(d, s, sum->first);
  for (int i = 0; i < 4; ++i) {
    km_vec3 p = points[i];
    const double products[6] = {p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.y * p.z, p.z * p.x};
    for (int k = 0; k < 6; ++k)
      sum->second[k] += d * products[k];
  }
}

/* Second moments about the origin → inertia about the centre c of a body of volume V. */
static void inertia_about_centre(const double second[6], double volume, km_vec3 c, double inertia[6]) {
  double xx = second[0] - volume * c.x * c.x, yy = second[1] - volume * c.y * c.y, zz = second[2] - volume * c.z * c.z;
  inertia[0] = yy + zz;
  inertia[1] = zz + xx;
  inertia[2] = xx + yy;
  inertia[3] = volume * c.x * c.y - second[3];
  inertia[4] = volume * c.y * c.z - second[4];
  inertia[5] = volume * c.z * c.x - second[5];
}

km_status km_mass_properties_of(const km_mesh *mesh, km_mass_properties *out, km_error *error) {
  static const double least_volume = 1e-12; /* relative to size³; below, rounding of the vertices decides */
  double second[6];
  km_vec3 low, high;
  integrals sum = {0};
  *out = (km_mass_properties){0};
  km_mesh_box(mesh, &low, &high);
  double size = km_vec3_norm(km_vec3_sub(high, low));
  km_vec3 origin = km_vec3_axpy(0.5, km_vec3_sub(high, low), low); /* a point near the surface, against cancellation */
  for (int t = 0; t < mesh->triangle_count; ++t) {
    const int *corner = mesh->triangles[t].corner;
    add_tetrahedron(&sum, km_vec3_sub(mesh->vertices[corner[0]], origin),
                    km_vec3_sub(mesh->vertices[corner[1]], origin), km_vec3_sub(mesh->vertices[corner[2]], origin));
  }
  if (!(fabs(sum.d) > 6.0 * least_volume * size * size * size))
    return km_fail(error, KM_MODEL, "encloses no volume");
  out->inside_out = sum.d < 0.0;
  out->volume = fabs(sum.d) / 6.0;
  km_vec3 centre = km_vec3_scale(1.0 / (4.0 * sum.d), sum.first);
  out->center = km_vec3_add(origin, centre);
  for (int k = 0; k < 6; ++k)
    second[k] = (out->inside_out ? -1.0 : 1.0) * sum.second[k] / 120.0;
  inertia_about_centre(second, out->volume, centre, out->inertia);
  return KM_OK;
}

static km_status check_closed(const km_mesh *mesh, const char *name, km_error *error) {
  km_mesh_faults faults;
  km_status status = km_mesh_check(mesh, &faults, error);
  if (status)
    return status;
  if (faults.open_edges)
    return km_fail(error, KM_MODEL, "%s: has %d open edge%s; expected a closed surface to go with a density", name,
                   faults.open_edges, faults.open_edges == 1 ? "" : "s");
  if (faults.mixed_edges)
    return km_fail(error, KM_MODEL,
                   "%s: has %d edge%s between faces that look opposite ways; expected all to look "
                   "outwards",
                   name, faults.mixed_edges, faults.mixed_edges == 1 ? "" : "s");
  return KM_OK;
}

km_status km_mesh_weigh(const km_mesh *mesh, const char *name, km_mass *out, km_error *error) {
  km_mass_properties found;
  km_error local;
  km_status status = check_closed(mesh, name, error);
  if (!status && km_mass_properties_of(mesh, &found, &local))
    status = km_fail(error, KM_MODEL, "%s: %.200s; expected a closed surface to go with a density", name, local.text);
  if (status)
    return status;
  *out = (km_mass){.mass = found.volume, .center = found.center};
  for (int k = 0; k < 6; ++k)
    out->inertia[k] = found.inertia[k];
  double moments[3];
  km_principal_moments(out->inertia, moments);
  if (moments[0] < -1e-9 * moments[2])
    return km_fail(
        error, KM_MODEL,
        "%s: a part of it is inside out, so that it counts as a hole beside the rest; expected all faces to look outwards",
        name);
  return KM_OK;
}

/* Jacobi rotation of the symmetric A in the plane p, q that makes A_pq zero; rotates the axes too. */
static void annihilate(double A[3][3], km_vec3 axes[3], int p, int q) {
  if (A[p][q] == 0.0)
    return;
  double theta = (A[q][q] - A[p][p]) / (2.0 * A[p][q]);
  double t = copysign(1.0, theta) / (fabs(theta) + hypot(theta, 1.0)); /* the smaller of the two angles */
  double c = 1.0 / hypot(t, 1.0), s = t * c;
  int r = 3 - p - q;
  double pr = A[p][r], qr = A[q][r];
  A[p][p] -= t * A[p][q];
  A[q][q] += t * A[p][q];
  A[p][q] = A[q][p] = 0.0;
  A[p][r] = A[r][p] = c * pr - s * qr;
  A[q][r] = A[r][q] = s * pr + c * qr;
  km_vec3 first = axes[p], second = axes[q];
  axes[p] = km_vec3_axpy(-s, second, km_vec3_scale(c, first));
  axes[q] = km_vec3_axpy(s, first, km_vec3_scale(c, second));
}

void km_principal_axes(const double I[6], double moments[3], km_vec3 axes[3]) {
  enum { SWEEPS = 12 }; /* convergence is quadratic: six sweeps suffice */
  double scale = 0.0;
  for (int k = 0; k < 6; ++k)
    scale = fmax(scale, fabs(I[k]));
  double one = scale > 0.0 ? scale : 1.0;
  double A[3][3] = {
      {I[0] / one, I[3] / one, I[5] / one}, {I[3] / one, I[1] / one, I[4] / one}, {I[5] / one, I[4] / one, I[2] / one}};
  for (int k = 0; k < 3; ++k)
    axes[k] = (km_vec3){k == 0, k == 1, k == 2};
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    annihilate(A, axes, 0, 1);
    annihilate(A, axes, 1, 2);
    annihilate(A, axes, 0, 2);
  }
  for (int k = 0; k < 3; ++k)
    moments[k] = scale * A[k][k];
}

void km_inertia_about(const double moments[3], const km_vec3 axes[3], double I[6]) {
  static const int row[6] = {0, 1, 2, 0, 1, 2}, column[6] = {0, 1, 2, 1, 2, 0};
  for (int k = 0; k < 6; ++k) {
    I[k] = 0.0;
    for (int a = 0; a < 3; ++a) {
      const double u[3] = {axes[a].x, axes[a].y, axes[a].z};
      I[k] += moments[a] * u[row[k]] * u[column[k]];
    }
  }
}

void km_principal_moments(const double I[6], double moments[3]) {
  double found[3];
  km_vec3 axes[3];
  km_principal_axes(I, found, axes);
  moments[0] = fmin(fmin(found[0], found[1]), found[2]);
  moments[2] = fmax(fmax(found[0], found[1]), found[2]);
  moments[1] = found[0] + found[1] + found[2] - moments[0] - moments[2];
}
