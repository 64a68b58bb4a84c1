/* The plane or sphere on which a point moves (space/surface/point_surface.h). */
#include "space/surface/point_surface.h"

#include "linalg/dense/singular_values.h"

#include <math.h>

enum { TERMS = 4 /* columns |p|², x, y, z */ };
static const double fitted = 1e-9;    /* smallest singular value of places on a surface: their own error is 1e-12 */
static const double curved = 1e-9;    /* |a| / |b|, places over their extent; a smaller one is a plane's */
static const double rounding = 1e-12; /* error of the centre, by the radius */

static km_vec3 axis(const km_point_surface *s, int i) {
  return km_vec3_from_array(s->axis[i]);
}

static void set_axis(km_point_surface *s, int i, km_vec3 a) {
  km_vec3_write(a, s->axis[i]);
}

static km_vec3 origin(const km_point_surface *s) {
  return km_vec3_from_array(s->origin);
}

static void set_origin(km_point_surface *s, km_vec3 o) {
  km_vec3_write(o, s->origin);
}

void km_point_surface_turn(km_point_surface *s, km_vec3 n) {
  km_vec3 x = {1.0, 0.0, 0.0}, y = {0.0, 1.0, 0.0}, start = fabs(n.x) < 0.9 ? x : y;
  km_vec3 first = km_vec3_axpy(-km_vec3_dot(start, n), n, start);
  first = km_vec3_scale(1.0 / km_vec3_norm(first), first);
  set_axis(s, 0, first);
  set_axis(s, 1, km_vec3_cross(n, first));
  set_axis(s, 2, n);
}

void km_point_surface_set_plane(km_point_surface *s, km_vec3 normal, km_vec3 place) {
  *s = (km_point_surface){.radius = 0.0};
  km_point_surface_turn(s, normal);
  set_origin(s, km_vec3_scale(km_vec3_dot(normal, place), normal));
}

/* Largest distance of the places from their mean. */
static double extent_of(const km_vec3 *places, int count, km_vec3 mean) {
  double extent = 0.0;
  for (int i = 0; i < count; ++i)
    extent = fmax(extent, km_vec3_norm(km_vec3_sub(places[i], mean)));
  return extent;
}

km_status km_point_surface_fit(const km_vec3 *places, int count, km_point_surface *out, km_error *error) {
  km_arena arena = {0};
  double *A = KM_ARENA_NEW(&arena, double, TERMS *(size_t)count),
         *U = KM_ARENA_NEW(&arena, double, TERMS *(size_t)count);
  double s[TERMS], Vt[TERMS * TERMS], mean_square = 0.0;
  km_vec3 mean = {0.0, 0.0, 0.0};
  for (int i = 0; i < count; ++i)
    mean = km_vec3_axpy(1.0 / count, places[i], mean);
  double extent = extent_of(places, count, mean);
  for (int i = 0; !arena.failed && i < count; ++i) {
    km_vec3 y = km_vec3_scale(1.0 / extent, km_vec3_sub(places[i], mean));
    A[i] = km_vec3_dot(y, y);
    A[count + i] = y.x;
    A[2 * count + i] = y.y;
    A[3 * count + i] = y.z;
    mean_square += A[i] / count;
  }
  for (int i = 0; !arena.failed && i < count; ++i)
    A[i] -= mean_square;
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the map")
                                  : km_singular_value_decomposition(count, TERMS, A, false, s, U, Vt, error);
  km_arena_free(&arena);
  if (status)
    return status;
  if (!(s[3] <= fitted * s[0]))
    return km_fail(error, KM_USAGE,
                   "the point moves on neither a plane nor a sphere; expected one of them for a workspace");
  double a = Vt[3];
  km_vec3 b = {Vt[TERMS + 3], Vt[2 * TERMS + 3], Vt[3 * TERMS + 3]};
  if (fabs(a) <= curved * km_vec3_norm(b)) {
    km_point_surface_set_plane(out, km_vec3_upright(b), mean);
    return KM_OK;
  }
  km_vec3 centre = km_vec3_scale(-0.5 / a, b); /* scaled places y have |y − centre|² = |centre|² + mean_square */
  *out = (km_point_surface){.radius = extent * sqrt(km_vec3_dot(centre, centre) + mean_square)};
  set_origin(out, km_vec3_axpy(extent, centre, mean));
  for (int i = 0; i < 3; ++i)
    if (fabs(out->origin[i]) <= rounding * out->radius)
      out->origin[i] = 0.0;
  km_point_surface_turn(out, km_vec3_upright((km_vec3){0.36, 0.48, 0.80}));
  return KM_OK;
}

/* Normal at a place. */
static km_vec3 normal_at(const km_point_surface *s, km_vec3 place) {
  if (s->radius == 0.0)
    return axis(s, 2);
  km_vec3 out = km_vec3_sub(place, origin(s));
  return km_vec3_scale(1.0 / km_vec3_norm(out), out);
}

double km_point_surface_distance(const km_point_surface *s, km_vec3 place) {
  km_vec3 out = km_vec3_sub(place, origin(s));
  return s->radius == 0.0 ? fabs(km_vec3_dot(out, axis(s, 2))) : fabs(km_vec3_norm(out) - s->radius);
}

void km_point_surface_tangents(const km_point_surface *s, km_vec3 place, km_vec3 tangent[2]) {
  km_vec3 pole = axis(s, 2), n = normal_at(s, place), sum = km_vec3_add(n, pole);
  for (int i = 0; i < 2; ++i)
    tangent[i] = km_vec3_axpy(-km_vec3_dot(axis(s, i), n) / (1.0 + km_vec3_dot(pole, n)), sum, axis(s, i));
}

void km_point_surface_chart(const km_point_surface *s, km_vec3 place, double chart[2]) {
  km_vec3 p = place;
  double scale = 1.0;
  if (s->radius != 0.0) {
    p = normal_at(s, place);
    scale = s->radius * sqrt(2.0 / (1.0 + km_vec3_dot(axis(s, 2), p)));
  }
  for (int i = 0; i < 2; ++i)
    chart[i] = scale * km_vec3_dot(axis(s, i), p);
}

void km_point_surface_chart_rate(const km_point_surface *s, km_vec3 place, km_vec3 velocity, double rate[2]) {
  double k = 1.0, change = 0.0; /* R dk/k */
  km_vec3 n = normal_at(s, place);
  if (s->radius != 0.0) {
    double sum = 1.0 + km_vec3_dot(axis(s, 2), n);
    k = sqrt(2.0 / sum);
    change = -0.5 * km_vec3_dot(axis(s, 2), velocity) / sum;
  }
  for (int i = 0; i < 2; ++i)
    rate[i] = k * (km_vec3_dot(axis(s, i), velocity) + change * km_vec3_dot(axis(s, i), n));
}

km_vec3 km_point_surface_place(const km_point_surface *s, const double chart[2]) {
  double along = 1.0, out = 0.0;
  if (s->radius != 0.0) {
    double square = (chart[0] * chart[0] + chart[1] * chart[1]) / (s->radius * s->radius);
    along = sqrt(fmax(1.0 - 0.25 * square, 0.0));
    out = s->radius * (1.0 - 0.5 * square);
  }
  km_vec3 place = km_vec3_axpy(out, axis(s, 2), origin(s));
  for (int i = 0; i < 2; ++i)
    place = km_vec3_axpy(along * chart[i], axis(s, i), place);
  return place;
}

double km_point_surface_area(const km_point_surface *s) {
  return 4.0 * M_PI * s->radius * s->radius;
}
