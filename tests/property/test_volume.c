/* Size of a point's workspace by samples: every sample against closed forms and inverse solutions of its own. */
#include "support/support.h"

#include "kmech/clearance.h"
#include "kmech/report.h"
#include "kmech/space.h"
#include "kmech/volume.h"
#include "report/charts/map_axes.h"
#include "space/volume/moved_point.h"

#include <stdio.h>
#include <string.h>

/* Index of the frame "body/frame". */
static int frame_of(const fixture *f, const char *name) {
  char body[40];
  const char *slash = strchr(name, '/'), *path[2] = {body, slash + 1};
  int frame = -1;
  snprintf(body, sizeof body, "%.*s", (int)(slash - name), name);
  assert_int_equal(km_model_find_frame(f->model, path, 2, &frame, NULL), KM_OK);
  return frame;
}

static km_space_volume volume_of(const fixture *f, const char *point, km_space_volume_def def) {
  km_space_volume volume;
  km_error error = {0};
  def.point_name = point;
  def.frame = frame_of(f, point);
  if (km_space_volume_find(f->mechanism, f->state, &def, NULL, NULL, &volume, &error))
    fail_msg("%s", error.text);
  return volume;
}

/* True if a place can be reached, by a method of its own. */
typedef bool (*is_reachable)(const double place[3]);

/* Every sample is reached if and only if the place can be. Returns the number of undecided ones. */
static int assert_samples(const km_space_volume *v, is_reachable is_inside) {
  int undecided = 0;
  assert_int_equal(km_table_rows(v->points), v->samples);
  assert_int_equal(v->reached + v->not_reached + v->undecided, v->samples);
  for (size_t r = 0; r < km_table_rows(v->points); ++r) {
    const double *row = km_table_row(v->points, r);
    undecided += row[3] < 0.0;
    if (row[3] >= 0.0 && (row[3] == 1.0) != is_inside(row))
      fail_msg("(%.17g, %.17g, %.17g) is %sreached", row[0], row[1], row[2], row[3] == 1.0 ? "" : "not ");
  }
  assert_int_equal(undecided, v->undecided);
  return undecided;
}

/* ---- Arm of three hinges: about z, then two about y; links of 0.5 and 0.3. */

#define ARM(BASE, LIMITS_A, LIMITS_B, LIMITS_C)                                                                        \
  "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"radians\", \"length\": \"meters\", "         \
  "\"mass\": \"kilograms\", \"time\": \"seconds\", \"force\": \"newtons\"}}, \"fixed\": {\"frames\": [{\"name\": "     \
  "\"base\", " BASE "}]}, \"assemblies\": [{\"name\": \"arm\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\", "     \
  "\"frames\": [{\"name\": \"end\", \"T\": [0.5, 0, 0]}]}, {\"name\": \"c\", \"frames\": [{\"name\": \"tip\", \"T\": " \
  "[0.3, 0, 0]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"base\"], "   \
  "[\"a\", \"origin\"]]" LIMITS_A "}, {\"name\": \"B\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"a\", "             \
  "\"origin\"], [\"b\", \"origin\"]], \"initial_displacement\": 0.3" LIMITS_B "}, {\"name\": \"C\", \"type\": "        \
  "\"Ry\", \"body_frame_pairs\": [[\"b\", \"end\"], [\"c\", \"origin\"]], \"initial_displacement\": 0.6" LIMITS_C      \
  "}]}]}"

#define AT_ORIGIN "\"T\": [0, 0, 0]"
static const double arm_volume = 4.0 / 3.0 * M_PI * (0.512 - 0.008);

static bool is_in_shell(const double p[3]) {
  double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  return r >= 0.2 && r <= 0.8;
}

static void an_arm_reaches_a_hollow_ball(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  km_space_volume v = volume_of(&f, "c/tip", (km_space_volume_def){.seed = 1});
  assert_int_equal(v.dimension, 3);
  assert_true(v.is_complete);
  assert_int_equal(assert_samples(&v, is_in_shell), 0);
  assert_true(v.low <= arm_volume && arm_volume <= v.high);
  for (int k = 0; k < 3; ++k) { /* 0.5 % of 1.6 at each end */
    assert_near(v.box_low[k], -0.808, 1e-5);
    assert_near(v.box_high[k], 0.808, 1e-5);
  }
  km_space_volume_free(&v);
  fixture_close(&f);
}

/* The base turned about (1, 2, 2)/3 by a right angle and shifted by (1, 2, 3). */
static bool is_in_shifted_shell(const double p[3]) {
  const double q[3] = {p[0] - 1.0, p[1] - 2.0, p[2] - 3.0};
  return is_in_shell(q);
}

static void frames_and_units_dont_matter(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  fixture small = fixture_in_units(&f, "degrees", "millimeters", NULL, NULL);
  fixture turned = fixture_read(
      ARM("\"T\": [1, 2, 3], \"R\": [[0.1111111111111111, -0.4444444444444444, 0.8888888888888888], "
          "[0.8888888888888888, 0.4444444444444444, 0.1111111111111111], [-0.4444444444444444, 0.7777777777777778, "
          "0.4444444444444444]]",
          "", "", ""));
  km_space_volume v = volume_of(&f, "c/tip", (km_space_volume_def){.samples = 1000, .seed = 3});
  km_space_volume w = volume_of(&small, "c/tip", (km_space_volume_def){.samples = 1000, .seed = 3});
  assert_int_equal(v.reached, w.reached);
  assert_near(1e9 * v.volume / w.volume, 1.0, 1e-4); /* extrema are exact to 1e-6 of the length */
  km_space_volume t = volume_of(&turned, "c/tip", (km_space_volume_def){.samples = 1000, .seed = 3});
  assert_samples(&t, is_in_shifted_shell);
  km_space_volume_free(&v);
  km_space_volume_free(&w);
  km_space_volume_free(&t);
  fixture_close(&f);
  fixture_close(&small);
  fixture_close(&turned);
}

/* The number of 200 intervals that have the true volume: binomial, 190 and a standard deviation of 3.1 if 95 % have.
 * Fewer than 180 have a probability below 0.002; the seeds are fixed. */
static void nineteen_of_twenty_intervals_are_true(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  int count = 0;
  double square = 0.0, promised = 0.0;
  for (unsigned long seed = 1; seed <= 200; ++seed) {
    km_space_volume v = volume_of(&f, "c/tip", (km_space_volume_def){.samples = 500, .seed = seed});
    count += v.low <= arm_volume && arm_volume <= v.high;
    square += (v.volume - arm_volume) * (v.volume - arm_volume) / 200.0;
    promised += v.standard_error * v.standard_error / 200.0;
    km_space_volume_free(&v);
  }
  assert_true(count >= 180);
  assert_true(count < 200); /* intervals that are always true are too long: a probability of 4e-5 */
  assert_near(square / promised, 1.0, 4.0 * sqrt(2.0 / 200.0)); /* four standard deviations of χ²/200 */
  fixture_close(&f);
}

/* ---- Joint limits. */

static bool is_angle_in(double angle, double low, double high) {
  double turned = low + fmod(fmod(angle - low, 2.0 * M_PI) + 2.0 * M_PI, 2.0 * M_PI);
  return turned <= high;
}

/* Both elbows on both sides of the axis, A in [−1, 2], B in [−0.5, 1.2], C in [−0.4, 2.5]. */
static bool is_in_limits(const double p[3]) {
  double r = hypot(p[0], p[1]);
  for (int side = -1; side <= 1; side += 2)
    for (int elbow = -1; elbow <= 1; elbow += 2) {
      double x = side * r, z = -p[2], cosine = (r * r + z * z - 0.34) / 0.3;
      if (fabs(cosine) > 1.0)
        return false;
      double C = elbow * acos(cosine), B = atan2(z, x) - atan2(0.3 * sin(C), 0.5 + 0.3 * cos(C));
      if (is_angle_in(atan2(side * p[1], side * p[0]), -1.0, 2.0) && is_angle_in(B, -0.5, 1.2) &&
          is_angle_in(C, -0.4, 2.5))
        return true;
    }
  return false;
}

static void limits_count_where_they_do(void **state) {
  (void)state;
  fixture f = fixture_read(
      ARM(AT_ORIGIN, ", \"limits\": [-1.0, 2.0]", ", \"limits\": [-0.5, 1.2]", ", \"limits\": [-0.4, 2.5]"));
  km_space_volume v = volume_of(&f, "c/tip", (km_space_volume_def){.within_limits = true, .seed = 2});
  assert_int_equal(assert_samples(&v, is_in_limits), 0);
  km_space_volume_free(&v);
  v = volume_of(&f, "c/tip", (km_space_volume_def){.samples = 1000, .seed = 2});
  assert_int_equal(assert_samples(&v, is_in_shell), 0);
  km_space_volume_free(&v);
  fixture_close(&f);
}

/* ---- The delta robot of models/: arms of 0.25 at 0.2, rods of 0.55, platform of 0.06; limits of A1 to A3. */

static bool leg_reaches(const double p[3], double turn) {
  double x = cos(turn) * p[0] + sin(turn) * p[1] + 0.06 - 0.2, y = cos(turn) * p[1] - sin(turn) * p[0];
  double z = p[2] + 0.03, reach = hypot(x, z);
  double cosine = (reach * reach + 0.0625 - (0.3025 - y * y)) / (0.5 * reach);
  if (!(y * y <= 0.3025) || fabs(cosine) > 1.0)
    return false;
  return is_angle_in(atan2(-z, x) + acos(cosine), -0.9, 1.5) || is_angle_in(atan2(-z, x) - acos(cosine), -0.9, 1.5);
}

static bool is_in_delta(const double p[3]) {
  return leg_reaches(p, 0.0) && leg_reaches(p, 2.0 * M_PI / 3.0) && leg_reaches(p, 4.0 * M_PI / 3.0);
}

static void a_delta_robot_agrees_with_its_legs(void **state) {
  (void)state;
  fixture f = fixture_open("delta");
  km_space_volume v =
      volume_of(&f, "platform/tool",
                (km_space_volume_def){.own_circuit = true, .within_limits = true, .samples = 3000, .seed = 1});
  assert_int_equal(v.dimension, 3);
  assert_int_equal(assert_samples(&v, is_in_delta), 0);
  km_space_volume_free(&v);
  fixture_close(&f);
}

/* ---- Planes. */

/* Within 1.5 of both pins and outside 0.3 of each. */
static bool is_in_five_bar(const double p[3]) {
  double a = hypot(p[0], p[1]), b = hypot(p[0] - 1.0, p[1]);
  return p[2] == 0.0 && a <= 1.5 && b <= 1.5 && a >= 0.3 && b >= 0.3;
}

static void a_five_bar_has_the_area_of_its_map(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  double lens = 2.0 * 2.25 * acos(1.0 / 3.0) - 0.5 * sqrt(8.0), area = lens - 2.0 * M_PI * 0.09;
  km_space_volume v = volume_of(&f, "rod1/P", (km_space_volume_def){.seed = 1});
  assert_int_equal(v.dimension, 2);
  assert_true(assert_samples(&v, is_in_five_bar) <= v.samples / 1000);
  assert_true(v.low <= area && area <= v.high);
  km_space_volume_free(&v);
  km_space_map map;
  km_all_modes modes;
  km_error error;
  km_space_map_def def = {.has_point = true, .frame = frame_of(&f, "rod1/P"), .point_name = "rod1/P"};
  for (int d = 0; d < 2; ++d)
    def.axis[d] = (km_space_axis){fixture_coordinate(&f, d ? "E" : "A"), -M_PI, M_PI, 60};
  assert_int_equal(km_map_modes_find(f.mechanism, f.state, def.axis[0].coordinate, def.axis[1].coordinate, 1, NULL,
                                     NULL, &modes, &error),
                   KM_OK);
  assert_int_equal(km_space_map_compute(f.mechanism, f.state, &def, &modes, NULL, NULL, &map, &error), KM_OK);
  assert_near(map.workspace_area, area, 1e-6);
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  fixture_close(&f);
}

/* A redundant arm of links 1, 0.6, 0.5, 0.4 in the plane x = y: a disc of 2.5. */
static bool is_in_disc(const double p[3]) {
  return fabs(p[0] - p[1]) < 1e-9 && sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) <= 2.5;
}

static void a_redundant_arm_is_ordinary(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"radians\", \"length\": \"meters\", "
      "\"mass\": \"kilograms\", \"time\": \"seconds\", \"force\": \"newtons\"}}, \"fixed\": {\"frames\": [{\"name\": "
      "\"base\", \"R\": [[0.7071067811865476, 0.7071067811865475, 0], [0.7071067811865475, -0.7071067811865476, 0], "
      "[0, 0, -1]]}]}, \"assemblies\": [{\"name\": \"arm\", \"bodies\": [{\"name\": \"a\", \"frames\": [{\"name\": "
      "\"end\", \"T\": [1, 0, 0]}]}, {\"name\": \"b\", \"frames\": [{\"name\": \"end\", \"T\": [0.6, 0, 0]}]}, "
      "{\"name\": \"c\", \"frames\": [{\"name\": \"end\", \"T\": [0.5, 0, 0]}]}, {\"name\": \"d\", \"frames\": "
      "[{\"name\": \"tip\", \"T\": [0.4, 0, 0]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Ry\", "
      "\"body_frame_pairs\": [[\"fixed\", \"base\"], [\"a\", \"origin\"]]}, {\"name\": \"B\", \"type\": \"Ry\", "
      "\"body_frame_pairs\": [[\"a\", \"end\"], [\"b\", \"origin\"]]}, {\"name\": \"C\", \"type\": \"Ry\", "
      "\"body_frame_pairs\": [[\"b\", \"end\"], [\"c\", \"origin\"]]}, {\"name\": \"D\", \"type\": \"Ry\", "
      "\"body_frame_pairs\": [[\"c\", \"end\"], [\"d\", \"origin\"]]}]}]}");
  km_space_volume v = volume_of(&f, "d/tip", (km_space_volume_def){.samples = 3000, .own_circuit = true, .seed = 5});
  assert_int_equal(v.dimension, 2);
  assert_int_equal(assert_samples(&v, is_in_disc), 0);
  assert_true(v.low <= M_PI * 6.25 && M_PI * 6.25 <= v.high);
  km_space_volume_free(&v);
  fixture_close(&f);
}

/* ---- Clearance: a ball of 0.1 on two slides, 2 by 1, and a fixed ball of 0.2 at (1, 0.5). */

#define GANTRY(LIMITS)                                                                                                 \
  "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"radians\", \"length\": \"meters\", "         \
  "\"mass\": \"kilograms\", \"time\": \"seconds\", \"force\": \"newtons\"}}, \"fixed\": {\"frames\": [{\"name\": "     \
  "\"middle\", \"T\": [1, 0.5, 0]}]}, \"assemblies\": [{\"name\": \"g\", "                                             \
  "\"bodies\": [{\"name\": \"post\", \"shapes\": [{\"sphere\": 0.2}]}, {\"name\": \"x\"}, {\"name\": \"ball\", "       \
  "\"shapes\": [{\"sphere\": 0.1}]}], \"joints\": [{\"name\": \"P\", \"type\": \"rigid\", \"body_frame_pairs\": "      \
  "[[\"fixed\", \"middle\"], [\"post\", \"origin\"]]}, {\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": "     \
  "[[\"fixed\", \"origin\"], [\"x\", \"origin\"]]" LIMITS ", \"initial_displacement\": 0.1}, {\"name\": \"Y\", "       \
  "\"type\": \"Ty\", \"body_frame_pairs\": [[\"x\", \"origin\"], [\"ball\", \"origin\"]], \"limits\": [0, 1], "        \
  "\"initial_displacement\": 0.1}]}]}"

static bool is_clear(const double p[3]) {
  return p[0] >= 0.0 && p[0] <= 2.0 && p[1] >= 0.0 && p[1] <= 1.0 && hypot(p[0] - 1.0, p[1] - 0.5) >= 0.35;
}

static void bodies_keep_their_clearance(void **state) {
  (void)state;
  fixture f = fixture_read(GANTRY(", \"limits\": [0, 2]"));
  km_clearance *clearance;
  km_error error;
  km_poses_compute(f.mechanism, f.state);
  assert_int_equal(km_clearance_create(f.mechanism, f.state, NULL, 0, &clearance, &error), KM_OK);
  km_space_volume v = volume_of(
      &f, "ball/origin",
      (km_space_volume_def){
          .within_limits = true, .clearance = clearance, .least_clearance = 0.05, .samples = 3000, .seed = 1});
  double area = 2.0 - M_PI * 0.35 * 0.35;
  assert_int_equal(assert_samples(&v, is_clear), 0);
  assert_true(v.low <= area && area <= v.high);
  km_space_volume_free(&v);
  km_clearance_free(clearance);
  fixture_close(&f);
}

/* ---- Extents that differ. */

/* Three slides: a box of 1 by 1 by 1e-4. */
#define SLIDES                                                                                                         \
  "{\"model_parameters\": {\"version\": \"1.0\", \"units\": {\"angle\": \"radians\", \"length\": \"meters\", "         \
  "\"mass\": \"kilograms\", \"time\": \"seconds\", \"force\": \"newtons\"}}, \"assemblies\": [{\"name\": \"s\", "      \
  "\"bodies\": [{\"name\": \"x\"}, {\"name\": \"y\"}, {\"name\": \"z\"}], \"joints\": [{\"name\": \"X\", \"type\": "   \
  "\"Tx\", \"body_frame_pairs\": [[\"fixed\", \"origin\"], [\"x\", \"origin\"]], \"limits\": [0, 1]}, {\"name\": "     \
  "\"Y\", \"type\": \"Ty\", \"body_frame_pairs\": [[\"x\", \"origin\"], [\"y\", \"origin\"]], \"limits\": [0, 1]}, "   \
  "{\"name\": \"Z\", \"type\": \"Tz\", \"body_frame_pairs\": [[\"y\", \"origin\"], [\"z\", \"origin\"]], "             \
  "\"limits\": [0, 1e-4]}]}]}"

static bool is_in_thin_box(const double p[3]) {
  return p[0] >= 0.0 && p[0] <= 1.0 && p[1] >= 0.0 && p[1] <= 1.0 && p[2] >= 0.0 && p[2] <= 1e-4;
}

static void a_thin_box_has_no_more_samples(void **state) {
  (void)state;
  fixture f = fixture_read(SLIDES);
  for (int samples = 100; samples <= 3000; samples = 3 * samples + 1) {
    km_space_volume v =
        volume_of(&f, "z/origin", (km_space_volume_def){.within_limits = true, .samples = samples, .seed = 1});
    assert_true(v.samples <= samples && v.samples > 3 * samples / 4);
    assert_int_equal(assert_samples(&v, is_in_thin_box), 0);
    assert_true(v.low <= 1e-4 && 1e-4 <= v.high);
    km_space_volume_free(&v);
  }
  fixture_close(&f);
}

/* The gantry with a stroke of 400: its length is 1. */
static bool is_in_long_gantry(const double p[3]) {
  return fabs(p[0]) <= 200.0 && p[1] >= 0.0 && p[1] <= 1.0;
}

static void a_long_slide_has_ends(void **state) {
  (void)state;
  fixture f = fixture_read(GANTRY(", \"limits\": [-200, 200]"));
  for (int own = 0; own < 2; ++own) {
    km_space_volume v =
        volume_of(&f, "ball/origin", (km_space_volume_def){.own_circuit = own, .within_limits = true, .samples = 1000});
    assert_int_equal(assert_samples(&v, is_in_long_gantry), 0);
    assert_true(v.low <= 400.0 && 400.0 <= v.high);
    km_space_volume_free(&v);
  }
  fixture_close(&f);
}

/* ---- Threads, refusals, cancellation. */

static void threads_dont_matter(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  km_space_volume a = volume_of(&f, "rod1/P", (km_space_volume_def){.samples = 1000, .seed = 7, .jobs = 1});
  km_space_volume b = volume_of(&f, "rod1/P", (km_space_volume_def){.samples = 1000, .seed = 7, .jobs = 5});
  size_t width = km_table_columns(a.points);
  for (size_t r = 0; r < km_table_rows(a.points); ++r)
    assert_memory_equal(km_table_row(a.points, r), km_table_row(b.points, r), width * sizeof(double));
  assert_same_bits(&a.high, &b.high, 1);
  km_space_volume_free(&a);
  km_space_volume_free(&b);
  fixture_close(&f);
}

static void assert_refused(const fixture *f, const char *point, km_space_volume_def def, km_status expected,
                           const char *word) {
  km_space_volume v;
  km_error error = {0};
  def.point_name = point;
  def.frame = frame_of(f, point);
  assert_int_equal(km_space_volume_find(f->mechanism, f->state, &def, NULL, NULL, &v, &error), expected);
  if (!strstr(error.text, word))
    fail_msg("\"%s\" lacks \"%s\"", error.text, word);
  assert_null(v.points);
  km_space_volume_free(&v);
}

static void wrong_inputs_are_refused(void **state) {
  (void)state;
  fixture arm = fixture_read(ARM(AT_ORIGIN, "", "", "")), gantry = fixture_read(GANTRY(""));
  assert_refused(&arm, "b/end", (km_space_volume_def){0}, KM_USAGE, "curved surface");
  assert_refused(&arm, "a/origin", (km_space_volume_def){0}, KM_USAGE, "0 freedoms");
  assert_refused(&arm, "c/tip", (km_space_volume_def){.samples = 99}, KM_USAGE, "99 samples");
  assert_refused(&gantry, "ball/origin", (km_space_volume_def){.within_limits = true}, KM_USAGE, "without end");
  assert_refused(&gantry, "x/origin", (km_space_volume_def){0}, KM_USAGE, "1 freedom;");
  fixture_close(&arm);
  fixture_close(&gantry);
}

static bool stop_at_half(void *context, double done) {
  (void)context;
  return done < 0.5;
}

static void a_stopped_search_says_what_it_knows(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  km_space_volume v;
  km_error error;
  const km_space_volume_def def = {.frame = frame_of(&f, "c/tip"), .point_name = "c/tip", .seed = 1};
  assert_int_equal(km_space_volume_find(f.mechanism, f.state, &def, stop_at_half, NULL, &v, &error), KM_CANCELLED);
  assert_false(v.is_complete);
  assert_true(v.is_stopped);
  assert_true(v.undecided > 0);
  assert_true(v.low <= arm_volume && arm_volume <= v.high);
  km_space_volume_free(&v);
  fixture_close(&f);
}

static bool stop_at_once(void *context, double done) {
  ++*(int *)context;
  assert_true(done < 0.05);
  return false;
}

static void a_search_stops_before_its_samples(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  km_space_volume v;
  km_error error;
  int calls = 0;
  const km_space_volume_def def = {.frame = frame_of(&f, "c/tip"), .point_name = "c/tip"};
  assert_int_equal(km_space_volume_find(f.mechanism, f.state, &def, stop_at_once, &calls, &v, &error), KM_CANCELLED);
  assert_int_equal(calls, 1);
  assert_null(v.points);
  km_space_volume_free(&v);
  fixture_close(&f);
}

typedef struct progress_seen {
  double last;
  int before_samples, calls;
} progress_seen;

static bool see_progress(void *context, double done) {
  progress_seen *seen = context;
  assert_true(done >= seen->last && done <= 1.0);
  seen->last = done;
  ++seen->calls;
  seen->before_samples += done < 0.05;
  return true;
}

static void progress_grows_from_the_first_search_on(void **state) {
  (void)state;
  fixture f = fixture_read(ARM(AT_ORIGIN, "", "", ""));
  km_space_volume v;
  km_error error;
  progress_seen seen = {.last = 0.0};
  const km_space_volume_def def = {.frame = frame_of(&f, "c/tip"), .point_name = "c/tip", .samples = 1000};
  assert_int_equal(km_space_volume_find(f.mechanism, f.state, &def, see_progress, &seen, &v, &error), KM_OK);
  assert_true(seen.before_samples >= 80); /* 1280 closures and motions, 16 of each share */
  assert_true(seen.calls > seen.before_samples);
  km_space_volume_free(&v);
  fixture_close(&f);
}

/* Locked cranks of a five-bar whose ends are 2.2 from each other; the rods are 1.8 long. */
static void open_loops_are_no_configuration(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  km_arena arena = {0};
  km_error error;
  km_moved_point p = {.m = f.mechanism,
                      .s = f.state,
                      .frame = frame_of(&f, "rod1/P"),
                      .dimension = 2,
                      .axis = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}};
  assert_int_equal(km_moved_point_create(&p, &arena, &error), KM_OK);
  assert_true(km_moved_point_return(&p));
  const int cranks[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
  for (int i = 0; i < 2; ++i) {
    f.state->q[cranks[i]] = i == 0 ? 0.5 * M_PI : -0.5 * M_PI;
    km_state_lock(f.state, cranks[i]);
  }
  assert_false(km_moved_point_return(&p));
  km_arena_free(&arena);
  fixture_close(&f);
}

/* A box of 1 × 2 × 4 in 2 × 2 × 2 cells with both samples of the first cell reached: the depth is 2/4 of the extent
 * along each axis where that cell is, 1/2, 1 and 2, and 0 elsewhere. Each shade is in the bar of colours too. */
static void a_picture_has_the_depths(void **state) {
  (void)state;
  km_space_volume v = {.dimension = 3,
                       .axis = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.6, 0.8}},
                       .box_high = {1.0, 2.0, 4.0},
                       .cells = {2, 2, 2},
                       .samples = 16,
                       .reached = 2,
                       .points = km_table_create()};
  assert_true(km_table_add_column(v.points, "point.a/b.x", "m") >= 0);
  for (int k = 1; k < 4; ++k)
    assert_true(km_table_add_column(v.points, (const char *[]){"", "y", "z", "reached"}[k], "") >= 0);
  for (int i = 0; i < v.samples; ++i)
    km_table_add_row(v.points)[3] = i < 2;
  km_text svg = {0};
  km_error error;
  assert_int_equal(km_space_volume_picture(&v, NULL, KM_PICTURE_SVG, &svg, &error), KM_OK);
  for (int shade = 0; shade < KM_MAP_SHADES; ++shade) {
    km_colour c = km_map_shade(shade);
    char fill[40];
    int count = 0;
    snprintf(fill, sizeof fill, "fill=\"#%02x%02x%02x\"", (unsigned)lround(255.0 * c.red),
             (unsigned)lround(255.0 * c.green), (unsigned)lround(255.0 * c.blue));
    for (const char *at = svg.data; (at = strstr(at, fill)) != NULL; ++at)
      ++count;
    assert_int_equal(count, shade == 4 || shade == 8 || shade == 15 ? 2 : 1);
  }
  km_text name = {0};
  km_space_volume_axis_text(&v, 2, &name);
  assert_string_equal(name.data, "along (0, 0.6, 0.8)");
  km_text_free(&name);
  km_text_free(&svg);
  v.samples = 18;
  assert_int_equal(km_space_volume_picture(&v, NULL, KM_PICTURE_SVG, &svg, &error), KM_USAGE);
  km_table_free(v.points);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_arm_reaches_a_hollow_ball),
      cmocka_unit_test(frames_and_units_dont_matter),
      cmocka_unit_test(nineteen_of_twenty_intervals_are_true),
      cmocka_unit_test(limits_count_where_they_do),
      cmocka_unit_test(a_delta_robot_agrees_with_its_legs),
      cmocka_unit_test(a_five_bar_has_the_area_of_its_map),
      cmocka_unit_test(a_redundant_arm_is_ordinary),
      cmocka_unit_test(bodies_keep_their_clearance),
      cmocka_unit_test(a_thin_box_has_no_more_samples),
      cmocka_unit_test(a_long_slide_has_ends),
      cmocka_unit_test(threads_dont_matter),
      cmocka_unit_test(wrong_inputs_are_refused),
      cmocka_unit_test(a_stopped_search_says_what_it_knows),
      cmocka_unit_test(a_search_stops_before_its_samples),
      cmocka_unit_test(progress_grows_from_the_first_search_on),
      cmocka_unit_test(open_loops_are_no_configuration),
      cmocka_unit_test(a_picture_has_the_depths),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
