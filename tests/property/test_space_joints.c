/* Maps and paths of parts with dependent conditions and ball joints: closed forms, and planar mechanisms of which some
 * hinges are balls. */
#include "support/support.h"

#include "base/random.h"
#include "kmech/space.h"
#include "model/model.h"
#include "spatial/rotation.h"

#include <stdlib.h>

enum { TRIALS = 4, MOST_SHEETS = 8, MOST_ASPECTS = 40 };

static const double cone_error = 1.01e-5; /* radians: the search's 1e-5, and the chords of curves */

static km_space_map_def map_definition(const fixture *f, double range, int steps) {
  return (km_space_map_def){
      .axis = {{fixture_coordinate(f, "A"), -range, range, steps}, {fixture_coordinate(f, "E"), -range, range, steps}}};
}

static km_space_map compute_map(const fixture *f, const km_space_map_def *def) {
  km_all_modes modes;
  km_space_map map;
  km_error error = {0};
  if (km_map_modes_find(f->mechanism, f->state, def->axis[0].coordinate, def->axis[1].coordinate, 1, NULL, NULL, &modes,
                        &error) ||
      km_space_map_compute(f->mechanism, f->state, def, &modes, NULL, NULL, &map, &error))
    fail_msg("%s", error.text);
  km_all_modes_free(&modes);
  return map;
}

static km_space_map map_of(const fixture *f, double range, int steps, bool within_limits) {
  km_space_map_def def = map_definition(f, range, steps);
  def.within_limits = within_limits;
  return compute_map(f, &def);
}

/* The map with point "body/P". */
static km_space_map map_of_point(const fixture *f, const char *body, double range, int steps) {
  const char *const path[] = {body, "P"};
  km_space_map_def def = map_definition(f, range, steps);
  def.has_point = true;
  def.point_name = "P";
  assert_int_equal(km_model_find_frame(f->model, path, 2, &def.frame, NULL), KM_OK);
  return compute_map(f, &def);
}

/* ---- Spherical five-bars. */

static km_vec3 turned(km_vec3 axis, double angle, km_vec3 v) {
  km_vec3 u = km_vec3_scale(1.0 / km_vec3_norm(axis), axis);
  km_vec3 across = km_vec3_cross(u, v);
  return km_vec3_axpy(1.0 - cos(angle), km_vec3_cross(u, across), km_vec3_axpy(sin(angle), across, v));
}

/* Joints A to E in the order of the chain; all axes through a random point `at`, and P on that of C at distance 1. */
static fixture spherical_five_bar(uint64_t *random, km_vec3 axis[5], double at[3], bool is_reversed) {
  static const char *const body[] = {"fixed", "b1", "b2", "b3", "b4", "fixed"};
  const double rough[5][3] = {{1, 0, 0}, {0.6, -0.5, 0.7}, {0.1, 0.1, 1}, {-0.5, 0.6, 0.7}, {0, 1, 0}};
  km_text text = {0};
  for (int k = 0; k < 3; ++k)
    at[k] = 2.0 * km_uniform(random);
  for (int i = 0; i < 5; ++i) {
    const double *r = rough[i];
    double by[3] = {km_uniform(random), km_uniform(random), km_uniform(random)};
    axis[i] = (km_vec3){r[0] + 0.15 * by[0], r[1] + 0.15 * by[1], r[2] + 0.15 * by[2]};
    axis[i] = km_vec3_scale(1.0 / km_vec3_norm(axis[i]), axis[i]);
  }
  km_text_format(
      &text,
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"b1\"},"
      "{\"name\": \"b2\", \"frames\": [{\"name\": \"P\", \"T\": [%.17g, %.17g, %.17g]}]}, {\"name\": \"b3\"}, "
      "{\"name\": \"b4\"}], \"joints\": [",
      at[0] + axis[2].x, at[1] + axis[2].y, at[2] + axis[2].z);
  for (int k = 0; k < 5; ++k) {
    int i = is_reversed ? 4 - k : k, first = i == 3 || i == 4 ? i + 1 : i, second = i == 3 || i == 4 ? i : i + 1;
    km_text_format(&text,
                   "%s{\"name\": \"%c\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"], \"at\": [%.17g, %.17g, "
                   "%.17g], \"axis\": [%.17g, %.17g, %.17g]}",
                   k ? "," : "", 'A' + i, body[first], body[second], at[0], at[1], at[2], axis[i].x, axis[i].y,
                   axis[i].z);
  }
  km_text_format(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Axes of B, C by the chain of A, and of D; *gap: from C's axis by the chain of E. */
static double passive_product(const km_vec3 axis[5], const km_table *t, size_t row, double *gap) {
  double a = table_cell(t, row, "q.A"), e = table_cell(t, row, "q.E");
  km_vec3 B = turned(axis[0], a, axis[1]), D = turned(axis[4], e, axis[3]);
  km_vec3 C = turned(axis[0], a, turned(axis[1], table_cell(t, row, "q.B"), axis[2]));
  km_vec3 other = turned(axis[4], e, turned(axis[3], table_cell(t, row, "q.D"), axis[2]));
  *gap = km_vec3_norm(km_vec3_sub(C, other));
  return km_vec3_dot(B, km_vec3_cross(C, D));
}

/* The passive links are in one plane on a singularity curve, and on one side of it on a sheet. */
static void passive_axes_are_coplanar_on_the_curves(void **state) {
  (void)state;
  uint64_t random = 5;
  size_t points = 0;
  for (int trial = 0; trial < 2 * TRIALS; ++trial) {
    km_vec3 axis[5];
    double at[3];
    fixture f = spherical_five_bar(&random, axis, at, trial % 2);
    km_space_map map = map_of(&f, 2.0, 30, false);
    double gap;
    assert_in_range(map.sheet_count, 2, MOST_SHEETS); /* two of each region of the drivers' plane */
    assert_int_equal(map.sheet_count % 2, 0);
    double first[MOST_SHEETS + 1] = {0.0};
    int at_point[31][31] = {{0}}, sheets[2] = {0, 0};
    for (size_t k = 0; k < km_table_rows(map.cells); ++k) {
      int sheet = (int)table_cell(map.cells, k, "sheet");
      double product = passive_product(axis, map.cells, k, &gap);
      assert_at_most(gap, 1e-10);
      first[sheet] = first[sheet] == 0.0 ? product : first[sheet];
      assert_true(product * first[sheet] > 0.0);
      ++at_point[lround((table_cell(map.cells, k, "q.A") + 2.0) * 7.5)]
                [lround((table_cell(map.cells, k, "q.E") + 2.0) * 7.5)];
    }
    for (int i = 0; i < 31 * 31; ++i)
      assert_true(at_point[i / 31][i % 31] == 0 || at_point[i / 31][i % 31] == 2);
    for (int sheet = 1; sheet <= map.sheet_count; ++sheet)
      ++sheets[first[sheet] > 0.0];
    assert_int_equal(sheets[0], sheets[1]);
    for (size_t k = 0; k < km_table_rows(map.curves); ++k, ++points) {
      assert_at_most(fabs(passive_product(axis, map.curves, k, &gap)), 1e-8);
      assert_at_most(gap, 1e-10);
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
  assert_true(points > 2000);
}

static double angle_between(km_vec3 a, km_vec3 b) {
  return atan2(km_vec3_norm(km_vec3_cross(a, b)), km_vec3_dot(a, b));
}

/* Least and largest angle from the first axis of a chain of two that the third axis has. */
static void chain_limits(km_vec3 first, km_vec3 second, km_vec3 third, double limit[2]) {
  double a = angle_between(first, second), b = angle_between(second, third);
  limit[0] = fabs(a - b);
  limit[1] = fmin(a + b, 2.0 * M_PI - a - b);
}

/* Area on the unit sphere between both limits of both axes: ∫ 2 φ(θ) sin θ dθ, φ the turns about the first axis at
 * which the angle from the second is within its limits; midpoints. */
static double area_between(km_vec3 first, const double limit[2], km_vec3 second, const double other[2]) {
  enum { PARTS = 200000 };
  double between = angle_between(first, second), h = (limit[1] - limit[0]) / PARTS, sum = 0.0;
  for (int i = 0; i < PARTS; ++i) {
    double angle = limit[0] + (i + 0.5) * h, along = cos(angle) * cos(between), across = sin(angle) * sin(between);
    double low = fmin(fmax((cos(other[1]) - along) / across, -1.0), 1.0),
           high = fmin(fmax((cos(other[0]) - along) / across, -1.0), 1.0);
    sum += 2.0 * (acos(low) - acos(high)) * sin(angle) * h;
  }
  return sum;
}

/* The point of a wrist of two freedoms reaches the places whose angles from the axes of A and E both chains allow. */
static void the_wrist_reaches_what_both_chains_allow(void **state) {
  (void)state;
  uint64_t random = 5;
  for (int trial = 0; trial < 2 * TRIALS; ++trial) {
    km_vec3 axis[5];
    double at[3], limit[2][2], aspects = 0.0;
    fixture f = spherical_five_bar(&random, axis, at, trial % 2);
    km_space_map map = map_of_point(&f, "b2", M_PI, 60);
    chain_limits(axis[0], axis[1], axis[2], limit[0]);
    chain_limits(axis[4], axis[3], axis[2], limit[1]);
    assert_near(map.surface.radius, 1.0, 1e-10);
    for (int k = 0; k < 3; ++k)
      assert_near(map.surface.origin[k], at[k], 1e-10);
    for (size_t k = 0; k < km_table_rows(map.boundary); ++k) {
      const double *row = km_table_row(map.boundary, k) + 3;
      km_vec3 out = {row[0] - at[0], row[1] - at[1], row[2] - at[2]};
      double nearest = HUGE_VAL;
      for (int i = 0; i < 4; ++i)
        nearest = fmin(nearest, fabs(angle_between(axis[i < 2 ? 0 : 4], out) - limit[i / 2][i % 2]));
      assert_at_most(nearest, 1e-8);
      assert_near(km_vec3_norm(out), 1.0, 1e-10);
    }
    assert_near(map.workspace_area, area_between(axis[0], limit[0], axis[4], limit[1]), 1e-6);
    for (int i = 0; i < map.workspace_count; ++i) {
      assert_true(map.workspaces[i].area > 0.0);
      aspects += map.workspaces[i].area;
    }
    assert_near(aspects, 4.0 * map.workspace_area, 1e-6); /* each chain with two elbows */
    assert_int_equal(map.unbounded, 0);
    km_space_map_free(&map);
    fixture_close(&f);
  }
}

/* A head on a hinge about z and one about an axis at the angle `tilt` from z; its point P is at `point` from it. */
static fixture pan_and_tilt(double tilt, double point) {
  km_text text = {0};
  km_text_format(&text,
                 "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"pan\"}, "
                 "{\"name\": \"head\", \"frames\": [{\"name\": \"P\", \"T\": [%.17g, 0, %.17g]}]}], \"joints\": ["
                 "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"pan\"], \"at\": [0, 0, 0], "
                 "\"axis\": [0, 0, 1]}, {\"name\": \"E\", \"type\": \"revolute\", \"bodies\": [\"pan\", \"head\"], "
                 "\"at\": [0, 0, 0], \"axis\": [%.17g, 0, %.17g]}]}]}",
                 sin(tilt - point), cos(tilt - point), sin(tilt), cos(tilt));
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Angle between a cone's axis and z. */
static double cone_height(const km_aspect_workspace *at) {
  assert_near(hypot(hypot(at->cone[0], at->cone[1]), at->cone[2]), 1.0, 1e-12);
  return acos(at->cone[2]);
}

/* The places of a head are a zone of the sphere, which may be all of it, and around the end of its chart. The largest
 * cone without a singularity touches both of its circles. */
static void a_head_reaches_a_zone(void **state) {
  (void)state;
  const double angle[][2] = {{0.5 * M_PI, 0.5 * M_PI}, {0.9, 0.5}, {1.2, 1.2}, {1.0, 1.6}, {0.5, 2.9}};
  for (size_t i = 0; i < sizeof angle / sizeof *angle; ++i) {
    double tilt = angle[i][0], point = angle[i][1];
    fixture f = pan_and_tilt(tilt, point);
    km_space_map map = map_of_point(&f, "head", M_PI, 60);
    double low = fabs(tilt - point), high = fmin(tilt + point, 2.0 * M_PI - tilt - point);
    double area = 2.0 * M_PI * (cos(low) - cos(high));
    assert_near(map.workspace_area, area, 1e-6);
    assert_int_equal(map.workspace_count, 2);
    for (int k = 0; k < 2; ++k) {
      const km_aspect_workspace *at = &map.workspaces[k];
      assert_near(at->area, area, 1e-6);
      assert_near(at->half_angle, 0.5 * (high - low), cone_error);
      assert_near(cone_height(at), 0.5 * (high + low), 2e-5);
      assert_true(at->radius == 0.0);
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
}

/* A head that pans from −p to p and turns away from z by θ_0 to θ_1: the largest cone has the half-angle max over θ of
 * min(θ − θ_0, θ_1 − θ, asin(sin θ sin p)), the last one the angle from the meridians ±p. */
static void cones_within_ranges(void **state) {
  (void)state;
  const double range[][3] = {{0.4, 0.3, 1.1}, {1.0, 0.5, 1.1}, {0.3, 0.2, 2.7}, {0.2, 1.2, 2.9}};
  for (size_t i = 0; i < sizeof range / sizeof *range; ++i) {
    double p = range[i][0], low = range[i][1], high = range[i][2], largest = 0.0, height = 0.0;
    for (int k = 1; k < 1000000; ++k) {
      double theta = low + (high - low) * 1e-6 * k;
      double r = fmin(fmin(theta - low, high - theta), asin(sin(theta) * sin(p)));
      height = r > largest ? theta : height;
      largest = fmax(largest, r);
    }
    fixture f = pan_and_tilt(0.5 * M_PI, 0.5 * M_PI);
    const char *const path[] = {"head", "P"};
    km_space_map_def def = {
        .axis = {{fixture_coordinate(&f, "A"), -p, p, 20}, {fixture_coordinate(&f, "E"), low, high, 20}},
        .has_point = true,
        .point_name = "P"};
    assert_int_equal(km_model_find_frame(f.model, path, 2, &def.frame, NULL), KM_OK);
    km_space_map map = compute_map(&f, &def);
    assert_int_equal(map.workspace_count, 1);
    assert_near(map.workspaces[0].area, 2.0 * p * (cos(low) - cos(high)), 1e-6);
    assert_near(map.workspaces[0].half_angle, largest, cone_error);
    bool touches_both = largest < p - 1e-3; /* else the height of the cone is not sharp: r is flat at the equator */
    if (touches_both)
      assert_near(cone_height(&map.workspaces[0]), height, 1e-3);
    km_space_map_free(&map);
    fixture_close(&f);
  }
}

/* A wrist whose places are 10° to 130° away from both axes: the largest cone touches all four circles. */
static void the_largest_cone_of_a_wrist(void **state) {
  (void)state;
  fixture f = fixture_open("wrist");
  const char *const path[] = {"rod1", "P"};
  km_space_map_def def = map_definition(&f, M_PI, 60);
  def.has_point = true;
  def.point_name = "rod1/P";
  assert_int_equal(km_model_find_frame(f.model, path, 2, &def.frame, NULL), KM_OK);
  km_space_map map = compute_map(&f, &def);
  const km_aspect_workspace *largest = &map.workspaces[0];
  for (int i = 0; i < map.workspace_count; ++i)
    largest = map.workspaces[i].half_angle > largest->half_angle ? &map.workspaces[i] : largest;
  double along = cos(70.0 * M_PI / 180.0);
  assert_near(largest->half_angle, M_PI / 3.0, cone_error);
  assert_near(largest->cone[0], along, 2e-5);
  assert_near(largest->cone[1], along, 2e-5);
  assert_near(fabs(largest->cone[2]), sqrt(1.0 - 2.0 * along * along), 2e-5);
  km_space_map_free(&map);
  fixture_close(&f);
}

/* ---- A planar five-bar, as itself and otherwise. */

enum { PLAIN, BALL, ROD, PARALLEL, CARDAN, KINDS };

typedef struct five_bar {
  double crank[2][2], P[2]; /* ends of the cranks, and P, as drawn */
} five_bar;

static five_bar random_five_bar(uint64_t *random) {
  five_bar b = {.crank = {{-0.2, 0.6}, {1.2, 0.7}}, .P = {0.5, 1.15}};
  for (int k = 0; k < 2; ++k) {
    b.crank[0][k] += 0.2 * km_uniform(random);
    b.crank[1][k] += 0.2 * km_uniform(random);
    b.P[k] += 0.2 * km_uniform(random);
  }
  return b;
}

/* A joint with its axis along z at a place (x, y), in the frame that is turned by R. */
static void add_joint(km_text *out, const km_rotation *R, const char *name, const char *type, const char *bodies,
                      double x, double y, double limit) {
  km_vec3 at = km_vec3_add(km_vec3_scale(x, R->axis[0]), km_vec3_scale(y, R->axis[1])), z = R->axis[2];
  km_text_format(out, ", {\"name\": \"%s\", \"type\": \"%s\", \"bodies\": [%s], \"at\": [%.17g, %.17g, %.17g]", name,
                 type, bodies, at.x, at.y, at.z);
  if (limit > 0.0)
    km_text_format(out, ", \"limits\": [%.17g, %.17g]", *type == 's' ? 0.0 : -limit, limit);
  if (*type == 's')
    km_text_format(out, "}");
  else
    km_text_format(out, ", \"axis\": [%.17g, %.17g, %.17g]}", z.x, z.y, z.z);
}

/* BALL: a ball at P; ROD: at both ends of a rod; PARALLEL: a crank of three that stay parallel; CARDAN: a ball at
 * both ends of one rod and at one of the other. limit: of joint C's angle; 0: none. */
static fixture build(const five_bar *b, int kind, const km_rotation *R, double limit) {
  km_text text = {0};
  bool is_parallel = kind == PARALLEL;
  double x = b->crank[0][0], y = b->crank[0][1];
  km_vec3 P = km_vec3_add(km_vec3_scale(b->P[0], R->axis[0]), km_vec3_scale(b->P[1], R->axis[1]));
  km_text_format(
      &text,
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"b1\"}, {\"name\": "
      "\"b2\", \"frames\": [{\"name\": \"P\", \"T\": [%.17g, %.17g, %.17g]}]}, {\"name\": \"b3\"}, {\"name\": "
      "\"b4\"}%s], \"joints\": [",
      P.x, P.y, P.z, is_parallel ? ", {\"name\": \"bar\"}, {\"name\": \"p\"}, {\"name\": \"q\"}" : "");
  size_t start = text.size;
  add_joint(&text, R, "A", "revolute", "\"fixed\", \"b1\"", 0.0, 0.0, 0.0);
  add_joint(&text, R, "B", kind == CARDAN ? "spherical" : "revolute",
            is_parallel ? "\"bar\", \"b2\"" : "\"b1\", \"b2\"", x, y, 0.0);
  add_joint(&text, R, "C", kind == PLAIN || is_parallel ? "revolute" : "spherical", "\"b2\", \"b3\"", b->P[0], b->P[1],
            limit);
  add_joint(&text, R, "D", kind == ROD ? "spherical" : "revolute", "\"b4\", \"b3\"", b->crank[1][0], b->crank[1][1],
            0.0);
  add_joint(&text, R, "E", "revolute", "\"fixed\", \"b4\"", 1.0, 0.0, 0.0);
  if (is_parallel) {
    add_joint(&text, R, "F", "revolute", "\"b1\", \"bar\"", x, y, 0.0);
    add_joint(&text, R, "G", "revolute", "\"fixed\", \"p\"", -0.5, -0.18, 0.0);
    add_joint(&text, R, "H", "revolute", "\"p\", \"bar\"", x - 0.5, y - 0.18, 0.0);
    add_joint(&text, R, "I", "revolute", "\"q\", \"fixed\"", -0.3, 0.1, 0.0);
    add_joint(&text, R, "J", "revolute", "\"q\", \"bar\"", x - 0.3, y + 0.1, 0.0);
  }
  text.data[start] = ' ';
  km_text_format(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static double crank_distance(const five_bar *b, double alpha, double epsilon) {
  const double angle[2] = {alpha, epsilon};
  double end[2][2];
  for (int k = 0; k < 2; ++k) {
    double x = b->crank[k][0] - k, y = b->crank[k][1];
    end[k][0] = k + cos(angle[k]) * x - sin(angle[k]) * y;
    end[k][1] = sin(angle[k]) * x + cos(angle[k]) * y;
  }
  return hypot(end[1][0] - end[0][0], end[1][1] - end[0][1]);
}

/* The mechanisms have the sheets of the plain five-bar. Where they have its coordinates, σ_input is the same; on the
 * curves the rods are in line. */
static void balls_and_parallel_cranks_change_no_sheet(void **state) {
  (void)state;
  uint64_t random = 12;
  const km_rotation upright = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  km_rotation oblique = {{{0.6, 0.0, 0.8}, {0.48, 0.8, -0.36}, {-0.64, 0.6, 0.48}}};
  for (int trial = 0; trial < TRIALS; ++trial) {
    five_bar b = random_five_bar(&random);
    double rod[2] = {hypot(b.P[0] - b.crank[0][0], b.P[1] - b.crank[0][1]),
                     hypot(b.P[0] - b.crank[1][0], b.P[1] - b.crank[1][1])};
    fixture plain = build(&b, PLAIN, &upright, 0.0);
    km_space_map expected = map_of(&plain, 1.1, 24, false);
    assert_true(expected.curve_count > 0);
    for (int kind = BALL; kind < KINDS; ++kind) {
      fixture f = build(&b, kind, trial % 2 ? &oblique : &upright, 0.0);
      km_space_map map = map_of(&f, 1.1, 24, false);
      double ratio = f.mechanism->substructures[0].size / plain.mechanism->substructures[0].size;
      assert_int_equal(map.sheet_count, expected.sheet_count);
      assert_int_equal(map.curve_count, expected.curve_count);
      assert_int_equal(km_table_rows(map.cells), km_table_rows(expected.cells));
      for (size_t k = 0; k < km_table_rows(map.cells); ++k) {
        double sum = 0.0;
        for (int c = 0; c < f.mechanism->coordinate_count; ++c)
          sum += km_table_row(map.cells, k)[2 + f.mechanism->coordinate_count + c];
        assert_near(sum, 2.0, 1e-9); /* mobility numbers add up to the freedoms, without spins */
      }
      if (kind == BALL || kind == ROD) { /* the coordinates out of the plane don't move */
        double least[2] = {HUGE_VAL, HUGE_VAL};
        for (size_t k = 0; k < km_table_rows(map.cells); ++k) {
          least[0] = fmin(least[0], table_cell(map.cells, k, "sigma.input"));
          least[1] = fmin(least[1], table_cell(expected.cells, k, "sigma.input"));
        }
        assert_near(ratio, 1.0, 1e-12);
        assert_near(least[0], least[1], 1e-9);
      }
      for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
        double d = crank_distance(&b, table_cell(map.curves, k, "q.A"), table_cell(map.curves, k, "q.E"));
        assert_at_most(fmin(fabs(d - rod[0] - rod[1]), fabs(d - fabs(rod[0] - rod[1]))), 1e-8);
      }
      km_space_map_free(&map);
      fixture_close(&f);
    }
    km_space_map_free(&expected);
    fixture_close(&plain);
  }
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Areas of the aspects, ascending. */
static int aspect_areas(const km_space_map *map, double areas[MOST_ASPECTS]) {
  assert_in_range(map->workspace_count, 1, MOST_ASPECTS);
  for (int i = 0; i < map->workspace_count; ++i)
    areas[i] = map->workspaces[i].area;
  qsort(areas, (size_t)map->workspace_count, sizeof *areas, ascending);
  return map->workspace_count;
}

/* The mechanisms have the workspace and the aspects of the plain five-bar; over full turns, at which parallel cranks
 * would become others, also where a rod points against its first direction. */
static void balls_and_parallel_cranks_change_no_aspect(void **state) {
  (void)state;
  uint64_t random = 12;
  const km_rotation upright = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  km_rotation oblique = {{{0.6, 0.0, 0.8}, {0.48, 0.8, -0.36}, {-0.64, 0.6, 0.48}}};
  for (int kind = BALL; kind < KINDS; ++kind) {
    five_bar b = random_five_bar(&random);
    double range = kind == PARALLEL ? 1.1 : M_PI, expected[MOST_ASPECTS], areas[MOST_ASPECTS];
    fixture plain = build(&b, PLAIN, &upright, 0.0), f = build(&b, kind, kind % 2 ? &upright : &oblique, 0.0);
    km_space_map map = map_of_point(&f, "b2", range, 24), of_plain = map_of_point(&plain, "b2", range, 24);
    int count = aspect_areas(&of_plain, expected);
    assert_near(map.surface.radius, 0.0, 0.0);
    assert_near(map.workspace_area, of_plain.workspace_area, 1e-7);
    assert_int_equal(aspect_areas(&map, areas), count);
    for (int i = 0; i < count; ++i)
      assert_near(areas[i], expected[i], 1e-7);
    km_space_map_free(&map);
    km_space_map_free(&of_plain);
    fixture_close(&plain);
    fixture_close(&f);
  }
}

/* A ball joint's largest angle bounds a map as the limits of the hinge do whose place it has. */
static void largest_angles_bound_the_sheets(void **state) {
  (void)state;
  const double limit = 0.4;
  const km_rotation upright = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  uint64_t random = 9;
  for (int trial = 0; trial < TRIALS; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture hinge = build(&b, PLAIN, &upright, limit), ball = build(&b, BALL, &upright, limit);
    km_space_map expected = map_of(&hinge, 1.1, 24, true), map = map_of(&ball, 1.1, 24, true);
    size_t on_limit = 0;
    assert_int_equal(km_table_rows(map.cells), km_table_rows(expected.cells));
    assert_int_equal(map.curve_count, expected.curve_count);
    for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
      if (table_cell(map.curves, k, "kind") != KM_CURVE_LIMIT)
        continue;
      km_vec3 turn = {table_cell(map.curves, k, "q.C[0]"), table_cell(map.curves, k, "q.C[1]"),
                      table_cell(map.curves, k, "q.C[2]")};
      assert_near(km_vec3_norm(turn), limit, 1e-10);
      ++on_limit;
    }
    assert_true(on_limit > 20);
    km_space_map_free(&map);
    km_space_map_free(&expected);
    fixture_close(&hinge);
    fixture_close(&ball);
  }
}

/* A path of the mechanism with balls is one of the planar mechanism: the rods never pass their line. */
static void paths_keep_the_rods_from_their_line(void **state) {
  (void)state;
  const km_rotation upright = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const five_bar b = {.crank = {{0.0, 0.6}, {1.0, 0.6}}, .P = {0.5, 1.3483314773547883}};
  for (int kind = BALL; kind < KINDS; ++kind) {
    fixture f = build(&b, kind, &upright, 0.0);
    const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
    const double to[2] = {kind == PARALLEL ? 1.0 : 2.9, kind == PARALLEL ? 0.9 : -2.9};
    const km_space_path_def def = {.drivers = drivers, .driver_count = 2, .to_drivers = to, .seed = 1};
    km_space_path path;
    km_error error = {0};
    if (km_space_path_find(f.mechanism, f.state, &def, NULL, NULL, &path, &error))
      fail_msg("%s", error.text);
    assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
    size_t last = km_table_rows(path.table) - 1;
    for (size_t k = 0; k <= last; ++k) {
      double a = table_cell(path.table, k, "q.A"), e = table_cell(path.table, k, "q.E");
      assert_true(crank_distance(&b, a, e) < 1.8 && crank_distance(&b, a, e) > 0.0);
    }
    assert_near(remainder(table_cell(path.table, last, "q.A") - to[0], 2.0 * M_PI), 0.0, 1e-9);
    assert_near(remainder(table_cell(path.table, last, "q.E") - to[1], 2.0 * M_PI), 0.0, 1e-9);
    km_space_path_free(&path);
    fixture_close(&f);
  }
}

/* ---- A platform on three cranks with rods (3-RRR), one crank held. */

/* Determinant of three lines a x + b y + c = 0, a² + b² = 1: 0 where they meet in a point or are parallel. */
static double line_determinant(const double line[3][3]) {
  return line[0][0] * (line[1][1] * line[2][2] - line[1][2] * line[2][1]) -
         line[0][1] * (line[1][0] * line[2][2] - line[1][2] * line[2][0]) +
         line[0][2] * (line[1][0] * line[2][1] - line[1][1] * line[2][0]);
}

static void lines_of_the_rods_meet_on_the_curves(void **state) {
  (void)state;
  const double pin[3][2] = {{0.0, 0.0}, {2.0, 0.0}, {1.0, 1.8}};
  uint64_t random = 31;
  size_t points = 0;
  for (int trial = 0; trial < TRIALS; ++trial) {
    double knee[3][2] = {{-0.1, 0.6}, {1.6, -0.4}, {1.5, 1.4}}, corner[3][2] = {{0.7, 0.4}, {1.4, 0.4}, {1.0, 0.9}};
    km_text text = {0};
    km_text_format(&text,
                   "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"p\"}");
    for (int leg = 0; leg < 3; ++leg)
      km_text_format(&text, ", {\"name\": \"crank%d\"}, {\"name\": \"rod%d\"}", leg, leg);
    km_text_format(&text, "], \"joints\": [");
    for (int leg = 0; leg < 3; ++leg) {
      for (int k = 0; k < 2; ++k) {
        knee[leg][k] += 0.1 * km_uniform(&random);
        corner[leg][k] += 0.1 * km_uniform(&random);
      }
      km_text_format(
          &text,
          "%s{\"name\": \"%s\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"crank%d\"], \"at\": [%.17g, %.17g]},"
          "{\"name\": \"K%d\", \"type\": \"revolute\", \"bodies\": [\"crank%d\", \"rod%d\"], \"at\": [%.17g, %.17g]},"
          "{\"name\": \"R%d\", \"type\": \"revolute\", \"bodies\": [\"rod%d\", \"p\"], \"at\": [%.17g, %.17g]}",
          leg ? "," : "",
          leg == 0   ? "A"
          : leg == 1 ? "E"
                     : "held",
          leg, pin[leg][0], pin[leg][1], leg, leg, leg, knee[leg][0], knee[leg][1], leg, leg, corner[leg][0],
          corner[leg][1]);
    }
    km_text_format(&text, "]}]}");
    fixture f = fixture_read(text.data);
    km_text_free(&text);
    const km_hold hold = {fixture_coordinate(&f, "held"), 0.0};
    km_assembly evidence;
    km_state_free(f.state);
    km_mechanism_free(f.mechanism);
    assert_int_equal(km_mechanism_compile(f.model, &hold, 1, &f.mechanism, NULL), KM_OK);
    assert_int_equal(km_state_create(f.mechanism, &f.state, NULL), KM_OK);
    assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
    km_space_map map = map_of(&f, 1.5, 40, false);
    assert_true(map.curve_count > 0);
    for (size_t row = 0; row < km_table_rows(map.curves); ++row, ++points) {
      double line[3][3];
      for (int leg = 0; leg < 3; ++leg) {
        static const char *const driver[] = {"q.A", "q.E", "q.held"}, *const passive[] = {"q.K0", "q.K1", "q.K2"};
        double turn = table_cell(map.curves, row, driver[leg]),
               along = turn + table_cell(map.curves, row, passive[leg]);
        double kx = knee[leg][0] - pin[leg][0], ky = knee[leg][1] - pin[leg][1];
        double rx = corner[leg][0] - knee[leg][0], ry = corner[leg][1] - knee[leg][1], length = hypot(rx, ry);
        double x = pin[leg][0] + cos(turn) * kx - sin(turn) * ky, y = pin[leg][1] + sin(turn) * kx + cos(turn) * ky;
        line[leg][0] = -(sin(along) * rx + cos(along) * ry) / length;
        line[leg][1] = (cos(along) * rx - sin(along) * ry) / length;
        line[leg][2] = -line[leg][0] * x - line[leg][1] * y;
      }
      assert_at_most(fabs(line_determinant((const double(*)[3])line)), 1e-8);
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
  assert_true(points > 300);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(passive_axes_are_coplanar_on_the_curves),
                                     cmocka_unit_test(the_wrist_reaches_what_both_chains_allow),
                                     cmocka_unit_test(a_head_reaches_a_zone),
                                     cmocka_unit_test(cones_within_ranges),
                                     cmocka_unit_test(the_largest_cone_of_a_wrist),
                                     cmocka_unit_test(balls_and_parallel_cranks_change_no_sheet),
                                     cmocka_unit_test(balls_and_parallel_cranks_change_no_aspect),
                                     cmocka_unit_test(largest_angles_bound_the_sheets),
                                     cmocka_unit_test(paths_keep_the_rods_from_their_line),
                                     cmocka_unit_test(lines_of_the_rods_meet_on_the_curves)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
