/* Random structures whose loops only seem to move, and random paradoxical linkages that do. */
#include "support/linkages.h"
#include "support/motion_families.h"

#include "kmech/mobility.h"

#include <complex.h>
#include <lapacke.h>
#include <stdio.h>
#include <string.h>

static bool is_mobility(const char *json, int mobility, const char *what, uint64_t seed) {
  fixture f = fixture_read(json);
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f.mechanism, f.state, NULL, NULL, &found, NULL), KM_OK);
  bool agrees = found.mobility == mobility && !found.undecided;
  if (!agrees)
    fprintf(stderr, "%s of seed %llu: finite mobility %d%s, expected %d; %s to %.3g\n", what, (unsigned long long)seed,
            found.mobility, found.undecided ? " or more" : "", mobility,
            found.motion_count ? km_motion_kind_name(found.motions[0].kind) : "",
            found.motion_count ? found.motions[0].confirmed_length : 0.0);
  km_finite_mobility_free(&found);
  fixture_close(&f);
  return agrees;
}

bool family_moving(uint64_t seed) {
  randomness r = {seed};
  int kind = below(&r, MOVING_KINDS);
  linkage l = moving_loop(kind, &r);
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  bool agrees = is_mobility(json, 1, moving_names[kind], seed);
  km_free(json);
  return agrees;
}

enum { ORDERS = 7 };

/* A four-bar: crank a, coupler b, rocker c, base d, its crank at θ; u + iv the point in the coupler's plane. */
typedef struct fourbar {
  double a, b, c, d, theta, u, v;
} fourbar;

typedef double _Complex number;
static const number i1 = (number)_Complex_I; /* √−1 */

/* Taylor coefficients in the crank's angle of e^{iθ} and of e^{iφ}, φ the coupler's angle: |a e^{iθ} + b e^{iφ} − d| =
 * c, by Newton's method on the series. */
static bool expand(const fourbar *f, number crank[ORDERS], number coupler[ORDERS]) {
  number power = cexp(i1 * f->theta);
  for (int k = 0; k < ORDERS; ++k, power *= i1 / (double)k)
    crank[k] = power;
  number base = f->a * crank[0] - f->d;
  double cosine = (f->c * f->c - creal(base * conj(base)) - f->b * f->b) / (2 * f->b * cabs(base));
  if (!(fabs(cosine) < 0.95))
    return false;
  memset(coupler, 0, ORDERS * sizeof *coupler);
  coupler[0] = base / cabs(base) * cexp(i1 * acos(cosine));
  /* Order by order: w = a e^{iθ} − d, x = e^{iφ}: Σ |w + b x|²_k = 0 and Σ |x|²_k = 0, linear in x_k. */
  for (int k = 1; k < ORDERS; ++k) {
    double unit = 0.0, circle = 0.0;
    for (int i = 0; i <= k; ++i) {
      number w = f->a * crank[i] - (i == 0 ? f->d : 0), o = f->a * crank[k - i] - (i == k ? f->d : 0);
      unit += creal(coupler[i] * conj(coupler[k - i]));
      circle += creal((w + f->b * coupler[i]) * conj(o + f->b * coupler[k - i]));
    }
    /* x_k = (α + iβ) x_0: 2α + unit = 0; 2b Re(conj(w0 + b x0) x_k) + circle = 0. */
    number whole = conj(base + f->b * coupler[0]) * coupler[0];
    double alpha = -0.5 * unit, beta = (circle / (2 * f->b) + alpha * creal(whole)) / cimag(whole);
    coupler[k] = (alpha + i1 * beta) * coupler[0];
  }
  return true;
}

/* The coupler point's Taylor coefficients across its tangent, over its speed: from 2 on they are 0 to the order of its
 * contact with the tangent. False where it stands. */
static bool deviations(const fourbar *f, double out[ORDERS], number *point, number *tangent) {
  number crank[ORDERS], coupler[ORDERS];
  if (!expand(f, crank, coupler))
    return false;
  number z = f->u + i1 * f->v, speed = f->a * crank[1] + z * coupler[1];
  *point = f->a * crank[0] + z * coupler[0];
  *tangent = speed / cabs(speed);
  for (int k = 0; k < ORDERS; ++k)
    out[k] = cimag(conj(*tangent) * (f->a * crank[k] + z * coupler[k])) / cabs(speed);
  return cabs(speed) > 0.1;
}

/* Changes u, v, θ, c (as many as there are conditions) until deviations 2 … order vanish. */
static bool refine(fourbar *f, int order) {
  double *unknown[4] = {&f->u, &f->v, &f->theta, &f->c}, at[ORDERS], there[ORDERS], A[16], b[4];
  number point, tangent;
  int n = order - 1;
  lapack_int pivots[4];
  for (int pass = 0; pass < 60 && n > 0; ++pass) {
    if (!deviations(f, at, &point, &tangent))
      return false;
    double size = 0.0;
    for (int i = 0; i < n; ++i)
      size = fmax(size, fabs(b[i] = -at[i + 2]));
    if (size < 3e-16 || pass == 59)
      return size < 1e-14;
    for (int k = 0; k < n; ++k) {
      double keep = *unknown[k], h = 1e-6;
      *unknown[k] = keep + h;
      if (!deviations(f, there, &point, &tangent))
        return false;
      for (int i = 0; i < n; ++i)
        A[k * n + i] = (there[i + 2] - at[i + 2]) / h;
      *unknown[k] = keep;
    }
    if (LAPACKE_dgesv(LAPACK_COL_MAJOR, n, 1, A, n, pivots, b, n))
      return false;
    double largest = 0.0;
    for (int i = 0; i < n; ++i)
      largest = fmax(largest, fabs(b[i]));
    for (int k = 0; k < n; ++k)
      *unknown[k] += b[k] * fmin(1.0, 0.3 / largest);
  }
  return true;
}

/* A coupler point in a straight slot along its tangent, which it meets to the given order and no further. */
static bool slotted(randomness *r, int order, linkage *out) {
  fourbar f = {.a = uniform(r, 0.3, 1.2), .b = uniform(r, 0.5, 1.5), .c = uniform(r, 0.5, 1.5), .d = 1.0};
  f.theta = uniform(r, -3, 3);
  f.u = uniform(r, -1, 1);
  f.v = uniform(r, -1, 1);
  double left[ORDERS];
  number p, t, crank[ORDERS], coupler[ORDERS];
  if (!refine(&f, order) || !deviations(&f, left, &p, &t) || !(fabs(left[order + 1]) > 1e-2) || !(cabs(p) < 4.0) ||
      !(f.c > 0.2) || !(f.c < 3.0) || !expand(&f, crank, coupler))
    return false;
  km_vec3 z = {0, 0, 1}, a = {f.a * creal(crank[0]), f.a * cimag(crank[0]), 0};
  km_vec3 b = {a.x + f.b * creal(coupler[0]), a.y + f.b * cimag(coupler[0]), 0}, at = {creal(p), cimag(p), 0};
  *out = (linkage){4,
                   6,
                   {{0, 1, false, {0, 0, 0}, z},
                    {1, 2, false, a, z},
                    {2, 3, false, b, z},
                    {0, 3, false, {f.d, 0, 0}, z},
                    {2, 4, false, at, z},
                    {0, 4, true, at, {creal(t), cimag(t), 0}}}};
  return true;
}

bool family_contact(uint64_t seed) {
  randomness r = {seed};
  int order = 1 + below(&r, 5);
  linkage l;
  char what[64];
  for (int tries = 0; !slotted(&r, order, &l); ++tries)
    if (tries == 2000)
      return true;
  snprintf(what, sizeof what, "contact of order %d", order);
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  bool agrees = is_mobility(json, 0, what, seed);
  km_free(json);
  return agrees;
}

/* Three bars between two bodies whose lines meet in one point. */
bool family_shaky(uint64_t seed) {
  randomness r = {seed};
  km_vec3 z = {0, 0, 1}, centre = random_point(&r);
  linkage l = {.bodies = 4, .joints = 6};
  for (int k = 0; k < 3; ++k) {
    double angle = 2.1 * k + uniform(&r, 0, 1), near = uniform(&r, 0.3, 0.8), far = near + uniform(&r, 0.3, 0.8);
    km_vec3 d = {cos(angle), sin(angle), 0};
    l.joint[2 * k] = (axis_joint){0, 1 + k, false, km_vec3_axpy(far, d, centre), z};
    l.joint[2 * k + 1] = (axis_joint){1 + k, 4, false, km_vec3_axpy(near, d, centre), z};
  }
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  bool agrees = is_mobility(json, 0, "concurrent bars", seed);
  km_free(json);
  return agrees;
}

/* A parallelogram laid flat: two motions of one freedom. */
bool family_change_point(uint64_t seed) {
  randomness r = {seed};
  double crank = uniform(&r, 0.2, 0.8), base = uniform(&r, 1, 2);
  km_vec3 at[4] = {{0, 0, 0}, {crank, 0, 0}, {base + crank, 0, 0}, {base, 0, 0}};
  km_vec3 z = {0, 0, 1}, along[4] = {z, z, z, z};
  linkage l = hinged_loop(at, along, 4);
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  bool agrees = is_mobility(json, 1, "flat parallelogram", seed);
  km_free(json);
  return agrees;
}
