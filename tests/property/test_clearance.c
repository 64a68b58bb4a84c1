/* Clearances: distances and depths of random convex bodies against all pairs of their features, round bodies against
 * closed forms, gradients against differences, invariance, threads, hulls of meshes. */
#include "support/arms.h"
#include "support/solids.h"
#include "support/support.h"

#include "base/parallel.h"
#include "clearance/convex.h"
#include "clearance/hull_error.h"
#include "kmech/clearance.h"
#include "kmech/inspect.h"
#include "model/geometry/hull.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Brute force: features of polyhedra */

static km_vec3 at(const km_mesh *m, int t, int k) {
  return m->vertices[m->triangles[t].corner[k % 3]];
}

static double clamp(double x) {
  return fmin(1.0, fmax(0.0, x));
}

/* A point and a triangle: only where the point projects into it; edges see to the rest. */
static double vertex_face(km_vec3 x, km_vec3 a, km_vec3 b, km_vec3 c) {
  km_vec3 e = km_vec3_sub(b, a), f = km_vec3_sub(c, a), d = km_vec3_sub(x, a), n = km_vec3_cross(e, f);
  double area = km_vec3_dot(n, n), u = km_vec3_dot(km_vec3_cross(d, f), n) / area,
         v = km_vec3_dot(km_vec3_cross(e, d), n) / area;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 ? fabs(km_vec3_dot(d, n)) / sqrt(area) : HUGE_VAL;
}

/* Two segments: the least over their inner points and ends. */
static double edge_edge(km_vec3 a, km_vec3 b, km_vec3 c, km_vec3 d) {
  km_vec3 u = km_vec3_sub(b, a), v = km_vec3_sub(d, c), w = km_vec3_sub(a, c);
  double uu = km_vec3_dot(u, u), uv = km_vec3_dot(u, v), vv = km_vec3_dot(v, v), uw = km_vec3_dot(u, w),
         vw = km_vec3_dot(v, w), det = uu * vv - uv * uv;
  double s[5] = {det > 1e-14 * uu * vv ? clamp((uv * vw - vv * uw) / det) : 0.0, 0.0, 1.0, clamp(-uw / uu),
                 clamp((uv - uw) / uu)};
  double least = HUGE_VAL;
  for (int i = 0; i < 5; ++i) {
    double t = clamp((uv * s[i] + vw) / vv);
    double again = clamp((uv * t - uw) / uu);
    km_vec3 x = km_vec3_axpy(again, u, km_vec3_axpy(-t, v, w));
    least = fmin(least, km_vec3_norm(x));
  }
  return least;
}

static double feature_distance(const km_mesh *a, const km_mesh *b) {
  double least = HUGE_VAL;
  for (int i = 0; i < a->triangle_count; ++i)
    for (int j = 0; j < b->triangle_count; ++j)
      for (int k = 0; k < 3; ++k) {
        least = fmin(least, vertex_face(at(a, i, k), at(b, j, 0), at(b, j, 1), at(b, j, 2)));
        least = fmin(least, vertex_face(at(b, j, k), at(a, i, 0), at(a, i, 1), at(a, i, 2)));
        for (int l = 0; l < 3; ++l)
          least = fmin(least, edge_edge(at(a, i, k), at(a, i, k + 1), at(b, j, l), at(b, j, l + 1)));
      }
  return least;
}

static double reach_along(const km_mesh *m, km_vec3 n) {
  double most = -HUGE_VAL;
  for (int v = 0; v < m->vertex_count; ++v)
    most = fmax(most, km_vec3_dot(n, m->vertices[v]));
  return most;
}

/* Overlap h_A(n) + h_B(−n) along ±n; infinite for no direction. */
static double overlap_along(const km_mesh *a, const km_mesh *b, km_vec3 n) {
  double length = km_vec3_norm(n);
  if (!(length > 1e-9))
    return HUGE_VAL;
  n = km_vec3_scale(1.0 / length, n);
  km_vec3 back = km_vec3_scale(-1.0, n);
  return fmin(reach_along(a, n) + reach_along(b, back), reach_along(a, back) + reach_along(b, n));
}

/* Least overlap over the normals of all faces and of all pairs of edges: the depth, if it is positive. */
static double feature_depth(const km_mesh *a, const km_mesh *b) {
  double least = HUGE_VAL;
  for (int side = 0; side < 2; ++side)
    for (int t = 0; t < (side ? b : a)->triangle_count; ++t) {
      const km_mesh *m = side ? b : a;
      km_vec3 n = km_vec3_cross(km_vec3_sub(at(m, t, 1), at(m, t, 0)), km_vec3_sub(at(m, t, 2), at(m, t, 0)));
      least = fmin(least, overlap_along(a, b, km_vec3_scale(1.0 / km_vec3_norm(n), n)));
    }
  for (int i = 0; i < a->triangle_count; ++i)
    for (int j = 0; j < b->triangle_count; ++j)
      for (int k = 0; k < 9; ++k) {
        km_vec3 u = km_vec3_sub(at(a, i, k % 3 + 1), at(a, i, k % 3)),
                v = km_vec3_sub(at(b, j, k / 3 + 1), at(b, j, k / 3));
        least = fmin(
            least, overlap_along(a, b, km_vec3_scale(1.0 / (km_vec3_norm(u) * km_vec3_norm(v)), km_vec3_cross(u, v))));
      }
  return least;
}

/* ---- Random bodies */

static km_vec3 random_vector(randomness *r, double size) {
  return (km_vec3){uniform(r, -size, size), uniform(r, -size, size), uniform(r, -size, size)};
}

static km_pose random_place(randomness *r, double distance) {
  return (km_pose){solid_turn(uniform(r, -3, 3), uniform(r, -3, 3), uniform(r, -3, 3)), random_vector(r, distance)};
}

static km_mesh *random_hull(randomness *r, int points) {
  km_mesh *cloud = km_mesh_create(points, 0), *hull = NULL;
  km_vec3 size = {uniform(r, 0.2, 1.0), uniform(r, 0.2, 1.0), uniform(r, 0.2, 1.0)};
  for (int i = 0; i < points; ++i)
    cloud->vertices[i] =
        (km_vec3){uniform(r, -size.x, size.x), uniform(r, -size.y, size.y), uniform(r, -size.z, size.z)};
  assert_int_equal(km_mesh_hull(cloud, &hull, NULL), KM_OK);
  km_mesh_free(cloud);
  return hull;
}

static km_mesh *random_polyhedron(randomness *r) {
  return below(r, 3) == 0 ? solid_box(uniform(r, 0.1, 2.0), uniform(r, 0.1, 2.0), uniform(r, 0.1, 2.0))
                          : random_hull(r, 4 + below(r, 12));
}

static km_convex part_of(const km_mesh *m) {
  km_convex part = {.count = m->vertex_count, .points = m->vertices};
  km_vec3 low, high;
  km_mesh_box(m, &low, &high);
  part.center = km_vec3_scale(0.5, km_vec3_add(low, high));
  part.reach = 0.5 * km_vec3_norm(km_vec3_sub(high, low));
  return part;
}

static km_convex_distance distance_of(const km_convex *a, const km_convex *b, const km_pose *pose) {
  return km_convex_distance_compute(&(km_convex_pair){{a, b}, *pose});
}

/* The result's own statement: distance = n · (b − a), n a unit vector, the parts behind their planes. */
static void assert_consistent(const km_convex *a, const km_convex *b, const km_pose *pose,
                              const km_convex_distance *d) {
  const km_convex_pair pair = {{a, b}, *pose};
  assert_near(km_vec3_norm(d->normal), 1.0, 1e-12);
  assert_near(km_vec3_dot(d->normal, km_vec3_sub(d->b, d->a)), d->distance, 1e-9);
  km_difference_point far = km_difference_support(&pair, d->normal);
  double widest = -km_vec3_dot(d->normal, far.w) - a->radius - b->radius; /* a lower bound of the distance */
  assert_near(widest, d->distance, 1e-9);
}

/* All pairs of features of polyhedra of coordinates up to 4 round to 1e-15, times the condition of a thin triangle. */
static void random_polyhedra(void **state) {
  randomness r = {11};
  int apart = 0, deep = 0;
  for (int k = 0; k < 3000; ++k) {
    km_mesh *a = random_polyhedron(&r), *b = random_polyhedron(&r);
    km_pose pose = random_place(&r, uniform(&r, 0.0, 2.0));
    km_convex pa = part_of(a), pb = part_of(b);
    km_convex_distance d = distance_of(&pa, &pb, &pose);
    assert_consistent(&pa, &pb, &pose, &d);
    solid_move(b, &pose.R, pose.p);
    double depth = feature_depth(a, b);
    bool overlaps = depth > 0.0;
    assert_near(d.distance, overlaps ? -depth : feature_distance(a, b), 1e-9);
    assert_true(d.error < 1e-11); /* a rounded direction of a distance of 1e-5 */
    apart += !overlaps;
    deep += overlaps;
    km_mesh_free(a);
    km_mesh_free(b);
  }
  assert_true(apart > 500 && deep > 500);
  (void)state;
}

/* Boxes along common axes, also touching and flush ones, with gaps g along each: the norm of the positive gaps, or the
 * largest one. */
static void aligned_boxes(void **state) {
  randomness r = {5};
  for (int k = 0; k < 3000; ++k) {
    double size[2][3], gap[3], square = 0.0, largest = -HUGE_VAL;
    km_pose pose = km_pose_identity();
    km_vec3 c = {0.25 * (below(&r, 33) - 16), 0.25 * (below(&r, 33) - 16), 0.25 * (below(&r, 33) - 16)};
    for (int i = 0; i < 6; ++i)
      size[i / 3][i % 3] = 0.5 * (1 + below(&r, 5));
    const double offset[3] = {c.x, c.y, c.z};
    for (int i = 0; i < 3; ++i) {
      gap[i] = fabs(offset[i]) - 0.5 * (size[0][i] + size[1][i]);
      largest = fmax(largest, gap[i]);
      square += fmax(0.0, gap[i]) * fmax(0.0, gap[i]);
    }
    km_mesh *a = solid_box(size[0][0], size[0][1], size[0][2]), *b = solid_box(size[1][0], size[1][1], size[1][2]);
    km_convex pa = part_of(a), pb = part_of(b);
    pose.p = c;
    km_convex_distance d = distance_of(&pa, &pb, &pose);
    assert_near(d.distance, largest > 0.0 ? sqrt(square) : largest, 1e-14);
    assert_consistent(&pa, &pb, &pose, &d);
    km_mesh_free(a);
    km_mesh_free(b);
  }
  (void)state;
}

/* ---- Round bodies */

/* Signed distance of a point (ρ, z) from a rectangle |ρ| ≤ radius, |z| ≤ half. */
static double from_rectangle(double rho, double z, double radius, double half) {
  double u = rho - radius, v = fabs(z) - half;
  return u > 0.0 || v > 0.0 ? hypot(fmax(u, 0.0), fmax(v, 0.0)) : fmax(u, v);
}

static km_convex round_part(km_vec3 *points, int count, double half, double radius, double disc) {
  points[0] = (km_vec3){0, 0, count > 1 ? -half : 0.0};
  points[1] = (km_vec3){0, 0, half};
  return (km_convex){.count = count,
                     .points = points,
                     .radius = radius,
                     .disc = disc,
                     .axis = {0, 0, 1},
                     .reach = half + radius + disc};
}

/* Spheres and cylinders. Their difference is a cylinder with a ball, or with parallel axes a cylinder. The gap of the
 * method ends at rounding of the size, about 1e-15; where the closest points are on curved surfaces it decreases by a
 * constant factor per step, and 1e-10 is left where steps cancel. */
static void cylinders(void **state) {
  randomness r = {3};
  for (int k = 0; k < 4000; ++k) {
    bool is_sphere = k % 2;
    double radius[2] = {uniform(&r, 0.1, 1.5), uniform(&r, 0.1, 1.5)},
           half[2] = {uniform(&r, 0.1, 2.0), uniform(&r, 0.1, 2.0)};
    km_vec3 ends[2][2], c = random_vector(&r, 3.0);
    km_convex a = round_part(ends[0], 2, half[0], 0.0, radius[0]),
              b = is_sphere ? round_part(ends[1], 1, 0.0, radius[1], 0.0)
                            : round_part(ends[1], 2, half[1], 0.0, radius[1]);
    km_pose pose = {solid_turn(0, 0, uniform(&r, -3, 3)), c};
    double exact = is_sphere ? from_rectangle(hypot(c.x, c.y), c.z, radius[0], half[0]) - radius[1]
                             : from_rectangle(hypot(c.x, c.y), c.z, radius[0] + radius[1], half[0] + half[1]);
    km_convex_distance d = distance_of(&a, &b, &pose);
    assert_near(d.distance, exact, 1e-10);
    assert_true(fabs(d.distance - exact) <= d.error + 1e-13);
    assert_consistent(&a, &b, &pose, &d);
  }
  (void)state;
}

/* Cylinders and capsules at any angle: the distance between a lower bound, of the plane across the normal, and the
 * points, which lie in the bodies. */
static void round_bodies_anywhere(void **state) {
  randomness r = {17};
  for (int k = 0; k < 4000; ++k) {
    km_vec3 ends[2][2];
    km_convex part[2];
    for (int i = 0; i < 2; ++i) {
      bool is_capsule = below(&r, 3) == 0;
      part[i] = round_part(ends[i], 2, uniform(&r, 0.1, 2.0), is_capsule ? uniform(&r, 0.1, 1.0) : 0.0,
                           is_capsule ? 0.0 : uniform(&r, 0.1, 1.0));
    }
    km_pose pose = random_place(&r, 3.0);
    km_convex_distance d = distance_of(&part[0], &part[1], &pose);
    assert_true(d.error < 1e-9);
    assert_consistent(&part[0], &part[1], &pose, &d);
    km_pose back = km_pose_inverse(&pose);
    km_vec3 b = km_pose_point(&back, d.b);
    if (d.distance < 0.0)
      continue;
    const km_vec3 own[2] = {d.a, b};
    for (int i = 0; i < 2; ++i) {
      double rho = hypot(own[i].x, own[i].y), z = own[i].z, half = -ends[i][0].z;
      double inside = part[i].disc > 0.0 ? from_rectangle(rho, z, part[i].disc, half)
                                         : hypot(rho, fmax(0.0, fabs(z) - half)) - part[i].radius;
      assert_true(inside < 1e-10);
    }
    km_convex_distance other = distance_of(&part[1], &part[0], &back);
    assert_near(other.distance, d.distance, 1e-9);
  }
  (void)state;
}

/* ---- Mechanisms */

/* A chain of five bodies of all shapes in space on a base that has a place; its second body has two shapes. */
static const char chain[] =
    "{\"model_parameters\":{\"version\":\"1.0\",\"units\":{\"angle\":\"radians\",\"length\":\"meters\"}},\"assemblies\":[{"
    "\"name\":\"arm\",\"bodies\":["
    "{\"name\":\"base\",\"shapes\":[{\"box\":[1.1,0.9,0.3]}],\"frames\":[{\"name\":\"out\",\"T\":[0.1,0.2,0.6]}]},"
    "{\"name\":\"a\",\"shapes\":[{\"cylinder\":[0.2,0.9],\"T\":[0.5,0,0.1],\"rotation_vector\":[0.3,0.8,0.1]},{\"sphere\":"
    "0.25,\"T\":[0.1,0.3,0.2]}],\"frames\":[{\"name\":\"out\",\"T\":[1,0.2,0.1]}]},"
    "{\"name\":\"b\",\"shapes\":[{\"capsule\":[0.15,0.7],\"T\":[0.4,0.1,0],\"rotation_vector\":[0,1.4,0]}],\"frames\":[{"
    "\"name\":\"out\",\"T\":[0.9,0.1,0.3]}]},"
    "{\"name\":\"c\",\"shapes\":[{\"box\":[0.7,0.3,0.2],\"T\":[0.3,0,0],\"rotation_vector\":[0.1,0.2,0.3]}],\"frames\":[{"
    "\"name\":\"out\",\"T\":[0.7,0.3,0]}]},"
    "{\"name\":\"d\",\"shapes\":[{\"box\":[0.2,0.6,0.25],\"T\":[0.1,0.2,0.1]}]}],"
    "\"joints\":[{\"name\":\"R\",\"type\":\"rigid\",\"body_frame_pairs\":[\"fixed\",\"base\"]},"
    "{\"name\":\"A\",\"type\":\"Rz\",\"body_frame_pairs\":[[\"base\",\"out\"],\"a\"]},"
    "{\"name\":\"B\",\"type\":\"Ry\",\"body_frame_pairs\":[[\"a\",\"out\"],\"b\"]},"
    "{\"name\":\"C\",\"type\":\"spherical\",\"body_frame_pairs\":[[\"b\",\"out\"],\"c\"]},"
    "{\"name\":\"D\",\"type\":\"Tx\",\"body_frame_pairs\":[\"d\",[\"c\",\"out\"]]}]}]}";
enum { CHAIN_PAIRS = 6, CHAIN_COORDINATES = 6 };

static km_clearance *clearance_of(const fixture *f) {
  km_clearance *out;
  km_error error;
  km_poses_compute(f->mechanism, f->state);
  if (km_clearance_create(f->mechanism, f->state, NULL, 0, &out, &error))
    fail_msg("%s", error.text);
  return out;
}

static void bend(const fixture *f, randomness *r) {
  for (int c = 0; c < CHAIN_COORDINATES; ++c)
    assert_int_equal(km_state_set_coordinate(f->mechanism, f->state, c, uniform(r, -1.2, 1.2), NULL), KM_OK);
  km_poses_compute(f->mechanism, f->state);
}

static void distances(const fixture *f, const km_clearance *w, km_pair_clearance *out) {
  km_poses_compute(f->mechanism, f->state);
  assert_int_equal(km_clearance_compute(w, f->state, out, NULL, NULL), KM_OK);
}

/* Differences of h = 1e-6 err by h² and 1e-15/h; closest points on curved surfaces are known to the root of the gap of
 * 1e-15. Ball joints rotate about the parent's axes, which a difference of rotation vectors isn't: C isn't tested. */
static void gradients(void **state) {
  randomness r = {23};
  fixture f = fixture_read(chain);
  km_clearance *w = clearance_of(&f);
  assert_int_equal(km_clearance_pair_count(w), CHAIN_PAIRS);
  static const int moved[4] = {0, 1, 5, 0};
  for (int k = 0; k < 200; ++k) {
    km_pair_clearance now[CHAIN_PAIRS], side[2][CHAIN_PAIRS];
    double gradient[CHAIN_COORDINATES], h = 1e-6;
    bend(&f, &r);
    for (int i = 0; i < 3; ++i) {
      int c = moved[i];
      double q = km_state_coordinate(f.state, c);
      for (int sign = 0; sign < 2; ++sign) {
        km_state_set_coordinate(f.mechanism, f.state, c, q + (sign ? h : -h), NULL);
        distances(&f, w, side[sign]);
      }
      km_state_set_coordinate(f.mechanism, f.state, c, q, NULL);
      distances(&f, w, now);
      for (int p = 0; p < CHAIN_PAIRS; ++p) {
        double ahead = (side[1][p].distance - now[p].distance) / h,
               behind = (now[p].distance - side[0][p].distance) / h;
        if (fabs(ahead - behind) > 1e-3) /* other parts or features are closest on one side */
          continue;
        assert_int_equal(km_clearance_gradient(w, f.state, p, &now[p], gradient, NULL), KM_OK);
        assert_near(gradient[c], 0.5 * (ahead + behind), 2e-6);
      }
    }
  }
  km_clearance_free(w);
  fixture_close(&f);
  (void)state;
}

/* Another place of the mechanism, and other units, give the same distances. */
static void places_and_units(void **state) {
  char *elsewhere = edited(chain, "rigid", "\"fixed\"", "[\"fixed\",\"here\"]");
  char *text = edited(
      elsewhere, NULL, "\"assemblies\":",
      "\"fixed\":{\"frames\":[{\"name\":\"here\",\"T\":[3,-5,2],\"rotation_vector\":[0.4,-1.1,2.0]}]},\"assemblies\":");
  fixture f = fixture_read(chain), moved = fixture_read(text);
  fixture scaled = fixture_in_units(&f, "degrees", "millimeters", NULL, NULL);
  km_clearance *w[3] = {clearance_of(&f), clearance_of(&moved), clearance_of(&scaled)};
  const fixture *of[3] = {&f, &moved, &scaled};
  const double length[3] = {1.0, 1.0, 1000.0}, angle[3] = {1.0, 1.0, 180.0 / solid_pi};
  for (int k = 0; k < 100; ++k) {
    km_pair_clearance out[3][CHAIN_PAIRS];
    for (int i = 0; i < 3; ++i) {
      randomness r = {(uint64_t)k};
      for (int c = 0; c < CHAIN_COORDINATES; ++c)
        km_state_set_coordinate(of[i]->mechanism, of[i]->state, c,
                                uniform(&r, -1.2, 1.2) * (c == 5 ? length[i] : angle[i]), NULL);
      distances(of[i], w[i], out[i]);
    }
    for (int p = 0; p < CHAIN_PAIRS; ++p)
      for (int i = 1; i < 3; ++i)
        assert_near(out[i][p].distance / length[i], out[0][p].distance, 1e-9);
  }
  for (int i = 0; i < 3; ++i)
    km_clearance_free(w[i]);
  fixture_close(&f);
  fixture_close(&moved);
  fixture_close(&scaled);
  km_free(elsewhere);
  km_free(text);
  (void)state;
}

enum { RUNS = 64 };
typedef struct shared {
  const fixture *f;
  const km_clearance *w;
  km_pair_clearance out[RUNS][CHAIN_PAIRS];
} shared;

static void compute_one(void *context, int index) {
  shared *s = context;
  km_state *state;
  randomness r = {(uint64_t)index};
  if (km_state_create(s->f->mechanism, &state, NULL))
    return;
  for (int c = 0; c < CHAIN_COORDINATES; ++c)
    km_state_set_coordinate(s->f->mechanism, state, c, uniform(&r, -1.2, 1.2), NULL);
  km_poses_compute(s->f->mechanism, state);
  km_clearance_compute(s->w, state, s->out[index], NULL, NULL);
  km_state_free(state);
}

static void threads(void **state) {
  fixture f = fixture_read(chain);
  km_clearance *w = clearance_of(&f);
  static shared one, four;
  one = four = (shared){.f = &f, .w = w};
  km_parallel_for(RUNS, 1, compute_one, &one);
  km_parallel_for(RUNS, 4, compute_one, &four);
  assert_true(one.out[RUNS - 1][0].distance > 0.0);
  assert_same_bits(&four.out[0][0].distance, &one.out[0][0].distance, sizeof one.out / sizeof(double));
  km_clearance_free(w);
  fixture_close(&f);
  (void)state;
}

/* ---- Sweeps of models */

/* Arms of 2, 0.12 high, in one plane, are sin 2θ apart, S = 2 cos θ; the upper one's corner, 0.05 beyond its pin and
 * 0.06 beside its line, passes the platform, 0.08 above the pin. Events are located to 1e-9 of the driver. */
static void scissor_lift(void **state) {
  fixture f = fixture_open("scissor_lift");
  km_clearance *w = clearance_of(&f);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.from = 1.2;
  plan.to = 1.9995;
  plan.steps = 7;
  plan.clearance = w;
  km_clearance_sweep sweep;
  assert_int_equal(km_clearance_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  const km_clearance_course *course = &sweep.course;
  assert_int_equal(course->contact_count, 2);
  for (size_t i = 0; i < 2; ++i) {
    assert_near(course->contacts[i].s, 2.0 * cos(0.5 * asin(0.12)), 4e-9);
    assert_false(course->contacts[i].separates);
  }
  double passing = HUGE_VAL, lowest = HUGE_VAL;
  for (int i = 0; i < course->pair_count; ++i) {
    const char *name = km_clearance_pair_name(w, i);
    if (strcmp(name, "upper_rising/platform") == 0)
      passing = course->least[i].number;
    lowest = fmin(lowest, course->least[i].number);
  }
  assert_near(passing, 0.08 - hypot(0.05, 0.06), 2e-6); /* samples every 1/360 of the range: (5e-4)² of its curvature */
  assert_near(course->smallest.number, lowest, 1e-9);
  int column = km_table_find(sweep.motion.table, "clearance.lower_rising/upper_rising");
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    const double *row = km_table_row(sweep.motion.table, r);
    double exact = sin(2.0 * acos(0.5 * row[1])) - 0.12;
    if (exact > 0.0)
      assert_near(row[column], exact, 1e-9);
  }
  km_clearance_sweep_free(&sweep);
  km_clearance_free(w);
  fixture_close(&f);
  (void)state;
}

/* All triangles of a body in the inertial frame. */
static km_mesh *placed_surface(const fixture *f, int body) {
  km_surface_patch patch;
  assert_int_equal(km_body_patch_count(f->model, body), 1);
  assert_int_equal(km_body_patch(f->model, body, 0, &patch, NULL), KM_OK);
  km_mesh *mesh = km_mesh_create(patch.vertex_count, patch.triangle_count);
  for (int v = 0; v < patch.vertex_count; ++v)
    mesh->vertices[v] = km_pose_point(&f->state->pose[body], km_vec3_from_array(patch.vertices + 3 * v));
  for (int t = 0; t < 3 * patch.triangle_count; ++t)
    mesh->triangles[t / 3].corner[t % 3] = patch.triangles[t];
  km_surface_patch_free(&patch);
  return mesh;
}

/* The excavator's meshes are unions of convex pieces: their hulls err by 1e-8 of a size of up to 6. At the pose, and at
 * the contact of the stick with the bucket's rod, against all features of the meshes themselves. */
static void excavator(void **state) {
  km_model *model;
  km_error error;
  if (km_model_read_file(MODELS_DIR "/excavator.json", NULL, &model, &error))
    fail_msg("%s", error.text);
  fixture f = fixture_of(model);
  km_clearance *w = clearance_of(&f);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  int contact = -1, count = km_clearance_pair_count(w);
  km_pair_clearance *now = calloc((size_t)count, sizeof *now);
  distances(&f, w, now);
  for (int i = 0; i < count; ++i) {
    km_body_pair pair = km_clearance_pair(w, i);
    if (strcmp(km_clearance_pair_name(w, i), "stick/bucket_rod") == 0)
      contact = i;
    if (now[i].distance > 0.2)
      continue;
    km_mesh *a = placed_surface(&f, pair.body[0]), *b = placed_surface(&f, pair.body[1]);
    assert_near(now[i].distance, feature_distance(a, b), 2e-7);
    km_mesh_free(a);
    km_mesh_free(b);
  }
  assert_int_equal(km_model_find_coordinate(f.model, "O", &plan.coordinate, NULL), KM_OK);
  plan.from = 2.64;
  plan.to = 1.61;
  plan.steps = 5;
  plan.clearance = w;
  km_clearance_sweep sweep;
  assert_int_equal(km_clearance_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  assert_int_equal(sweep.course.contact_count, 1);
  assert_int_equal(sweep.course.contacts[0].pair, contact);
  plan.from = sweep.course.contacts[0].s + 1e-6; /* just before: the meshes are apart by about that */
  plan.to = sweep.course.contacts[0].s + 2e-6;
  plan.steps = 1;
  km_clearance_sweep_free(&sweep);
  assert_int_equal(km_clearance_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  distances(&f, w, now);
  km_body_pair pair = km_clearance_pair(w, contact);
  km_mesh *a = placed_surface(&f, pair.body[0]), *b = placed_surface(&f, pair.body[1]);
  assert_near(feature_distance(a, b), now[contact].distance, 2e-7);
  assert_true(now[contact].distance > 0.0 && now[contact].distance < 4e-6);
  km_mesh_free(a);
  km_mesh_free(b);
  km_clearance_sweep_free(&sweep);
  km_clearance_free(w);
  free(now);
  fixture_close(&f);
  (void)state;
}

/* ---- Arms */

/* A planar arm of four capsules and a post; the tip's line leads past it. */
static const char arm_model[] =
    "{\"model_parameters\":{\"version\":\"1.1\",\"units\":{\"angle\":\"degrees\",\"length\":\"meters\"}},\"assemblies\":[{"
    "\"name\":\"planar\",\"bodies\":[{\"name\":\"post\",\"shapes\":[{\"cylinder\":[0.15,0.4],\"T\":[0.75,0.75,0]}]},"
    "{\"name\":\"a\",\"shapes\":[{\"capsule\":[0.04,0.6],\"T\":[0.3,0,0],\"rotation_vector\":[0,90,0]}],\"frames\":[{"
    "\"name\":\"end\",\"T\":[0.6,0,0]}]},"
    "{\"name\":\"b\",\"shapes\":[{\"capsule\":[0.04,0.6],\"T\":[0.3,0,0],\"rotation_vector\":[0,90,0]}],\"frames\":[{"
    "\"name\":\"end\",\"T\":[0.6,0,0]}]},"
    "{\"name\":\"c\",\"shapes\":[{\"capsule\":[0.04,0.5],\"T\":[0.25,0,0],\"rotation_vector\":[0,90,0]}],\"frames\":[{"
    "\"name\":\"end\",\"T\":[0.5,0,0]}]},"
    "{\"name\":\"d\",\"shapes\":[{\"capsule\":[0.03,0.3],\"T\":[0.15,0,0],\"rotation_vector\":[0,90,0]}],\"frames\":[{"
    "\"name\":\"tip\",\"T\":[0.35,0,0]}]}],"
    "\"joints\":[{\"name\":\"P\",\"type\":\"rigid\",\"body_frame_pairs\":[\"fixed\",\"post\"]},"
    "{\"name\":\"A\",\"type\":\"Rz\",\"body_frame_pairs\":[\"fixed\",\"a\"],\"initial_displacement\":100},"
    "{\"name\":\"B\",\"type\":\"Rz\",\"body_frame_pairs\":[[\"a\",\"end\"],\"b\"],\"initial_displacement\":-40},"
    "{\"name\":\"C\",\"type\":\"Rz\",\"body_frame_pairs\":[[\"b\",\"end\"],\"c\"],\"initial_displacement\":-50},"
    "{\"name\":\"D\",\"type\":\"Rz\",\"body_frame_pairs\":[[\"c\",\"end\"],\"d\"],\"initial_displacement\":-40}]}]}";
static const char arm_study[] =
    "{\"effector\":\"d/tip\",\"task\":\"position\",\"q0\":[100,-40,-50,-40],\"path\":{\"segments\":[{\"type\":\"line\",\"to\":"
    "[1.2,0.6,0],\"steps\":80}]},\"objective\":\"clearance\",\"methods\":[\"greedy\",\"lookahead\"]}";

/* Rows have the least clearance over L of their own configuration; the pseudo-inverse hits the post, look-ahead
 * doesn't, with the same bits for four threads. */
static void arm_past_a_post(void **state) {
  fixture f = fixture_read(arm_model);
  km_clearance *w = clearance_of(&f);
  km_study *study = study_of(&f, arm_study);
  km_track *greedy = track_of(study, 0, 1), *ahead = track_of(study, 1, 1), *again = track_of(study, 1, 4);
  const km_table *rows = km_track_rows(ahead);
  int column = km_table_find(rows, "objective.clearance"), q = km_table_find(rows, "q.A");
  km_pair_clearance *now = calloc((size_t)km_clearance_pair_count(w), sizeof *now);
  assert_int_equal(km_table_rows(rows), 81);
  for (size_t r = 0; r < km_table_rows(rows); ++r) {
    const double *row = km_table_row(rows, r);
    int nearest;
    for (int c = 0; c < 4; ++c)
      km_state_set_coordinate(f.mechanism, f.state, c, row[q + c], NULL);
    km_poses_compute(f.mechanism, f.state);
    assert_int_equal(km_clearance_compute(w, f.state, now, &nearest, NULL), KM_OK);
    assert_near(row[column], now[nearest].distance / km_arm_length(km_study_arm(study)), 1e-9);
  }
  assert_same_rows(ahead, again);
  assert_true(km_track_summarise(greedy).objective_min < 0.0);
  assert_true(km_track_summarise(ahead).objective_min > 0.0);
  km_track_free(greedy);
  km_track_free(ahead);
  km_track_free(again);
  free(now);
  km_study_free(study);
  km_clearance_free(w);
  fixture_close(&f);
  (void)state;
}

/* ---- Pairs and meshes */

static void pairs(void **state) {
  fixture f = fixture_read(chain);
  km_clearance *w = clearance_of(&f);
  int joined = 0;
  assert_int_equal(km_clearance_left_out_count(w), 4); /* base-a, a-b, b-c, c-d */
  for (int i = 0; i < 4; ++i)
    joined += km_clearance_left_out(w, i).reason == KM_LEFT_OUT_JOINED;
  assert_int_equal(joined, 4);
  assert_int_equal(km_clearance_part_count(w, 2), 2);
  assert_true(km_clearance_hull_error(w, 2) == 0.0);
  km_clearance_free(w);
  fixture_close(&f);
  (void)state;
}

/* An L of unit thickness with arms of 3 and 2, and a box, which is its own hull. */
static void hulls_of_meshes(void **state) {
  const double outline[6][2] = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
  km_mesh *ell = km_mesh_create(12, 20), *box = solid_box(1, 2, 3), *hull;
  static const int caps[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}};
  for (int v = 0; v < 12; ++v)
    ell->vertices[v] = (km_vec3){outline[v % 6][0], outline[v % 6][1], v / 6};
  for (int t = 0; t < 4; ++t)
    for (int k = 0; k < 3; ++k) {
      ell->triangles[t].corner[k] = caps[t][2 - k];
      ell->triangles[4 + t].corner[k] = 6 + caps[t][k];
    }
  for (int s = 0; s < 6; ++s) {
    int next = (s + 1) % 6;
    ell->triangles[8 + 2 * s] = (km_triangle){.corner = {s, next, 6 + next}};
    ell->triangles[9 + 2 * s] = (km_triangle){.corner = {s, 6 + next, 6 + s}};
  }
  assert_int_equal(km_mesh_hull(ell, &hull, NULL), KM_OK);
  double size = sqrt(9.0 + 4.0 + 1.0), error = km_hull_error(ell, hull, size);
  /* The face from (3, 1) to (1, 2) is farthest where the lines y = 1 and x = 1 are equally far: 2/3. */
  assert_true(error >= 2.0 / 3.0 - 1e-9 && error <= 2.0 / 3.0 + 2e-3 * size);
  km_mesh_free(hull);
  assert_int_equal(km_mesh_hull(box, &hull, NULL), KM_OK);
  assert_at_most(km_hull_error(box, hull, size), 1e-8 * size);
  km_mesh_free(hull);
  km_mesh_free(ell);
  km_mesh_free(box);
  (void)state;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(
          random_polyhedra,
          "Distances and depths of 3000 pairs of random convex polyhedra against all pairs of their vertices, edges and faces",
          "rounding of coordinates of size 1, over the least distance"),
      cmocka_unit_test(aligned_boxes),
      cmocka_unit_test(cylinders),
      cmocka_unit_test(round_bodies_anywhere),
      cmocka_unit_test(gradients),
      cmocka_unit_test(places_and_units),
      cmocka_unit_test(threads),
      claim_test(scissor_lift,
                 "A scissor lift's arms touch where sin 2θ is their height, and the clearance of each row",
                 "events are located to 1e-9 of the driver"),
      cmocka_unit_test(excavator),
      cmocka_unit_test(arm_past_a_post),
      cmocka_unit_test(pairs),
      cmocka_unit_test(hulls_of_meshes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
