/* Paths without a singularity of the drivers: five-bars and 3-RPR platforms, every segment against closed forms. */
#include "support/support.h"

#include "base/random.h"
#include "kinematics/loop_equations.h"
#include "kmech/continuation.h"
#include "kmech/mobility.h"
#include "kmech/space.h"
#include "model/model.h"

#include <stdio.h>

enum { PAIRS = 50 };

static km_space_path path_to(const fixture *f, const km_space_path_def *def) {
  km_space_path path;
  km_error error = {0};
  if (km_space_path_find(f->mechanism, f->state, def, NULL, NULL, &path, &error))
    fail_msg("%s", error.text);
  return path;
}

/* The motion begins and ends at rest at the ends of the path, and its acceleration is continuous: a corner of the path
 * would change it from row to row by all of it. */
static void assert_smooth(const km_space_path *path, int drivers) {
  size_t last = km_table_rows(path->motion) - 1, end = km_table_rows(path->table) - 1;
  double n = (double)last, most = 0.0, jump = 0.0;
  assert_true(path->is_smooth);
  for (int d = 1; d <= drivers; ++d) {
    double before = 0.0;
    for (size_t r = 1; r < last; ++r) {
      double acceleration = n * n *
                            (km_table_row(path->motion, r + 1)[d] - 2.0 * km_table_row(path->motion, r)[d] +
                             km_table_row(path->motion, r - 1)[d]);
      most = fmax(most, fabs(acceleration));
      jump = fmax(jump, fabs(acceleration - before));
      before = acceleration;
    }
    double first = km_table_row(path->table, 0)[d], final = km_table_row(path->table, end)[d];
    double least = 7.0 * path->length / (n * n * n); /* 2π²/3 τ³ of the length in the first step of a cycloid */
    assert_near(km_table_row(path->motion, 0)[d], first, 1e-12);
    assert_near(km_table_row(path->motion, last)[d], final, 1e-12);
    assert_near(km_table_row(path->motion, 1)[d], first, least);
    assert_near(km_table_row(path->motion, last - 1)[d], final, least);
  }
  assert_at_most(jump, 0.25 * most);
}

/* ---- Five-bar of models/five_bar.json: cranks of 0.6 on pins 1 apart, rods of 0.9. */

/* Ends of the cranks, drawn upright, at angles; returns their distance. */
static double crank_ends(double a, double e, double end[2][2]) {
  const double angle[2] = {a, e};
  for (int k = 0; k < 2; ++k) {
    end[k][0] = k - 0.6 * sin(angle[k]);
    end[k][1] = 0.6 * cos(angle[k]);
  }
  return hypot(end[1][0] - end[0][0], end[1][1] - end[0][1]);
}

/* Sense of the triangle of both cranks' ends and the point P, at a row: the sign of the input's determinant. */
static double side_of(const km_table *table, size_t row) {
  double end[2][2], a = table_cell(table, row, "q.A"), turn = a + table_cell(table, row, "q.B");
  crank_ends(a, table_cell(table, row, "q.E"), end);
  double x = 0.5, y = 1.3483314773547883 - 0.6; /* rod 1, drawn */
  double P[2] = {end[0][0] + cos(turn) * x - sin(turn) * y, end[0][1] + sin(turn) * x + cos(turn) * y};
  assert_near(hypot(P[0] - end[1][0], P[1] - end[1][1]), 0.9, 1e-10);
  return (end[1][0] - end[0][0]) * (P[1] - end[0][1]) - (end[1][1] - end[0][1]) * (P[0] - end[0][0]);
}

static void five_bars_keep_their_mode(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
  uint64_t random = 11;
  int around = 0;
  for (int pair = 0; pair < PAIRS;) {
    double values[2], end[2][2];
    values[0] = 1.6 + 1.5 * km_uniform(&random); /* half of the pairs behind the place where the rods can't meet */
    values[1] = pair % 2 ? M_PI * km_uniform(&random) : -1.6 + 1.5 * km_uniform(&random);
    double distance = crank_ends(values[0], values[1], end);
    if (distance < 0.2 || distance > 1.7) /* the circles of the rods meet between 0 and 1.8 */
      continue;
    ++pair;
    km_space_path path =
        path_to(&f, &(km_space_path_def){.drivers = drivers, .driver_count = 2, .to_drivers = values, .seed = 1});
    size_t rows = km_table_rows(path.table);
    assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
    for (size_t r = 0; r < rows; ++r) {
      assert_true(side_of(path.table, r) > 0.0);
      assert_true(table_cell(path.table, r, "sigma.input") >= KM_DEFAULT_PATH_MARGIN);
      if (r == 0)
        continue;
      for (int part = 1; part < 10; ++part) { /* the drivers between two rows */
        double u = part / 10.0, a = table_cell(path.table, r - 1, "q.A"), e = table_cell(path.table, r - 1, "q.E");
        a += u * (table_cell(path.table, r, "q.A") - a);
        e += u * (table_cell(path.table, r, "q.E") - e);
        distance = crank_ends(a, e, end);
        assert_true(distance > 0.0 && distance < 1.8);
      }
      assert_at_most(table_cell(path.table, r, "s") - table_cell(path.table, r - 1, "s"), 0.05);
    }
    for (int d = 0; d < 2; ++d)
      assert_near(remainder(table_cell(path.table, rows - 1, d ? "q.E" : "q.A") - values[d], 2.0 * M_PI), 0.0, 1e-6);
    assert_smooth(&path, 2);
    around += !path.is_straight;
    km_space_path_free(&path);
  }
  assert_true(around >= 5);
  fixture_close(&f);
}

/* ---- Planar platform on three legs, each a hinge, a slide and a hinge. */

static const double base[3][2] = {{0.0, 0.0}, {2.0, 0.1}, {0.9, 1.8}},
                    drawn[3][2] = {{0.95, 0.35}, {1.4, 0.95}, {0.7, 1.0}};

static fixture build_platform(void) {
  km_text text = {0};
  km_text_add(&text,
              "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"platform\"}");
  for (int k = 0; k < 3; ++k)
    km_text_format(&text, ", {\"name\": \"tube%d\"}, {\"name\": \"rod%d\"}", k, k);
  km_text_add(&text, "], \"joints\": [");
  for (int k = 0; k < 3; ++k)
    km_text_format(
        &text,
        "%s{\"name\": \"R%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"tube%d\"], \"at\": [%g, %g]},"
        "{\"name\": \"P%d\", \"type\": \"prismatic\", \"bodies\": [\"tube%d\", \"rod%d\"], \"at\": [%g, %g], "
        "\"axis\": [%.17g, %.17g, 0]},"
        "{\"name\": \"B%d\", \"type\": \"revolute\", \"bodies\": [\"rod%d\", \"platform\"], \"at\": [%g, %g]}",
        k ? "," : "", k, k, base[k][0], base[k][1], k, k, k, drawn[k][0], drawn[k][1], drawn[k][0] - base[k][0],
        drawn[k][1] - base[k][1], k, k, drawn[k][0], drawn[k][1]);
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Coordinates of a pose (place of the first hinge, angle) with legs of positive lengths, and the determinant there. */
static void configuration_of(const fixture *f, const double pose[3], double *q) {
  for (int k = 0; k < 3; ++k) {
    double x = drawn[k][0] - drawn[0][0], y = drawn[k][1] - drawn[0][1], c = cos(pose[2]), s = sin(pose[2]);
    double leg[2] = {pose[0] + c * x - s * y - base[k][0], pose[1] + s * x + c * y - base[k][1]};
    double own[2] = {drawn[k][0] - base[k][0], drawn[k][1] - base[k][1]};
    char label[3][4] = {"R0", "P0", "B0"};
    for (int i = 0; i < 3; ++i)
      label[i][1] = (char)('0' + k);
    double turn = remainder(atan2(leg[1], leg[0]) - atan2(own[1], own[0]), 2.0 * M_PI);
    q[fixture_coordinate(f, label[0])] = turn;
    q[fixture_coordinate(f, label[1])] = hypot(leg[0], leg[1]) - hypot(own[0], own[1]);
    q[fixture_coordinate(f, label[2])] = remainder(pose[2] - turn, 2.0 * M_PI);
  }
}

/* Determinant of the legs' lines, of unit direction, at a pose. */
static double lines_of(const double pose[3]) {
  double line[3][3], c = cos(pose[2]), s = sin(pose[2]);
  for (int k = 0; k < 3; ++k) {
    double x = drawn[k][0] - drawn[0][0], y = drawn[k][1] - drawn[0][1];
    double leg[2] = {pose[0] + c * x - s * y - base[k][0], pose[1] + s * x + c * y - base[k][1]};
    for (int i = 0; i < 2; ++i)
      line[k][i] = leg[i] / hypot(leg[0], leg[1]);
    line[k][2] = base[k][0] * line[k][1] - base[k][1] * line[k][0];
  }
  return line[0][0] * (line[1][1] * line[2][2] - line[1][2] * line[2][1]) -
         line[0][1] * (line[1][0] * line[2][2] - line[1][2] * line[2][0]) +
         line[0][2] * (line[1][0] * line[2][1] - line[1][1] * line[2][0]);
}

static void draw_pose(uint64_t *random, double pose[3]) {
  do {
    pose[0] = 0.95 + 0.8 * km_uniform(random);
    pose[1] = 0.35 + 0.8 * km_uniform(random);
    pose[2] = M_PI * km_uniform(random);
  } while (fabs(lines_of(pose)) < 0.1);
}

/* Pose of the platform at a row, by the first leg; the other legs must hold it. */
static void pose_at(const fixture *f, const km_table *table, size_t row, double pose[3]) {
  double angle = table_cell(table, row, "q.R0"), length = hypot(drawn[0][0] - base[0][0], drawn[0][1] - base[0][1]),
         q[9];
  double direction = atan2(drawn[0][1] - base[0][1], drawn[0][0] - base[0][0]) + angle;
  length += table_cell(table, row, "q.P0");
  pose[0] = base[0][0] + length * cos(direction);
  pose[1] = base[0][1] + length * sin(direction);
  pose[2] = angle + table_cell(table, row, "q.B0");
  configuration_of(f, pose, q);
  for (int k = 1; k < 3; ++k) {
    char label[] = "q.P0";
    label[3] = (char)('0' + k);
    double own = hypot(drawn[k][0] - base[k][0], drawn[k][1] - base[k][1]);
    assert_near(fabs(own + table_cell(table, row, label)), own + q[fixture_coordinate(f, label + 2)], 1e-9);
  }
}

/* Product of the lines' determinant and the signs of the legs' lengths: the sign of the input's determinant. */
static double input_sign(const fixture *f, const km_table *table, size_t row, double pose[3]) {
  pose_at(f, table, row, pose);
  double sign = lines_of(pose);
  for (int k = 0; k < 3; ++k) {
    char label[] = "q.P0";
    label[3] = (char)('0' + k);
    sign *= hypot(drawn[k][0] - base[k][0], drawn[k][1] - base[k][1]) + table_cell(table, row, label);
  }
  return sign;
}

static void platforms_keep_the_sign_of_their_lines(void **state) {
  (void)state;
  fixture f = build_platform();
  const int drivers[3] = {fixture_coordinate(&f, "P0"), fixture_coordinate(&f, "P1"), fixture_coordinate(&f, "P2")};
  uint64_t random = 5;
  int around = 0;
  for (int pair = 0; pair < PAIRS; ++pair) {
    double from[3], to[3], start[9], end[9];
    draw_pose(&random, from);
    do
      draw_pose(&random, to);
    while (lines_of(from) * lines_of(to) < 0.0);
    configuration_of(&f, from, start);
    configuration_of(&f, to, end);
    assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, start, NULL), KM_OK);
    km_space_path path =
        path_to(&f, &(km_space_path_def){.drivers = drivers, .driver_count = 3, .to = end, .seed = 1, .margin = 0.005});
    assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
    assert_true(path.is_smooth);
    around += !path.is_straight;
    double last[3] = {0.0}, sign = 0.0;
    for (size_t r = 0; r < km_table_rows(path.table); ++r) {
      double at[3], now = input_sign(&f, path.table, r, at);
      sign = r == 0 ? now : sign;
      assert_true(now * sign > 0.0);
      if (r > 0)
        assert_at_most(hypot(at[0] - last[0], at[1] - last[1]), 0.2);
      memcpy(last, at, sizeof last);
    }
    assert_near(hypot(last[0] - to[0], last[1] - to[1]), 0.0, 1e-5);
    assert_near(remainder(last[2] - to[2], 2.0 * M_PI), 0.0, 1e-5);
    km_space_path_free(&path);
  }
  assert_true(around >= 5);
  fixture_close(&f);
}

/* A slice of the platform's three freedoms, the third leg held: the legs' lines meet in a point on the singularity
 * curves of the other two. */
static void lines_meet_on_the_curves_of_a_slice(void **state) {
  (void)state;
  fixture f = build_platform();
  const int drivers[2] = {fixture_coordinate(&f, "P0"), fixture_coordinate(&f, "P1")};
  const km_hold hold = {fixture_coordinate(&f, "P2"), 0.0};
  km_mechanism *held;
  km_state *at;
  assert_int_equal(km_mechanism_compile_at(f.model, &hold, 1, NULL, 0, &held, &at, NULL), KM_OK);
  km_all_modes modes;
  km_space_map map;
  const km_space_map_def def = {.axis = {{drivers[0], -0.6, 1.2, 30}, {drivers[1], -0.6, 1.2, 30}}};
  assert_int_equal(km_map_modes_find(held, at, drivers[0], drivers[1], 1, NULL, NULL, &modes, NULL), KM_OK);
  assert_int_equal(km_space_map_compute(held, at, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
  assert_true(km_table_rows(map.curves) > 100);
  for (size_t r = 0; r < km_table_rows(map.curves); ++r) {
    double pose[3];
    pose_at(&f, map.curves, r, pose);
    assert_near(lines_of(pose), 0.0, 1e-9);
  }
  size_t cells = km_table_rows(map.cells), last = cells - 1;
  double q[9] = {0.0};
  for (int c = 0; c < 9; ++c) { /* the configurations are the same from a cell of the last sheet */
    char name[8];
    snprintf(name, sizeof name, "q.%s", km_model_coordinate_label(f.model, c));
    q[c] = table_cell(map.cells, last, name);
  }
  assert_true(map.sheet_count > modes.count);
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  assert_int_equal(km_state_set_coordinates(held, at, q, NULL), KM_OK);
  assert_int_equal(km_map_modes_find(held, at, drivers[0], drivers[1], 1, NULL, NULL, &modes, NULL), KM_OK);
  assert_int_equal(km_space_map_compute(held, at, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
  assert_at_most(fabs((double)km_table_rows(map.cells) - (double)cells), 10.0); /* grid points at the edges */
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  km_state_free(at);
  km_mechanism_free(held);
  fixture_close(&f);
}

/* The other assembly mode at the same cranks can't be reached without a singularity. */
static void opposite_modes_are_separated(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
  const km_all_modes_def all = {.locked = drivers, .locked_count = 2, .seed = 1};
  km_all_modes modes;
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &all, NULL, NULL, &modes, NULL), KM_OK);
  assert_int_equal(modes.count, 2);
  km_space_path path =
      path_to(&f, &(km_space_path_def){.drivers = drivers, .driver_count = 2, .to = modes.coordinates + 5});
  assert_int_equal(path.outcome, KM_SPACE_PATH_SEPARATED);
  assert_int_equal(km_table_rows(path.table), 0);
  km_space_path_free(&path);
  km_all_modes_free(&modes);
  const double far[2] = {M_PI / 2.0, -M_PI / 2.0}; /* the ends of the cranks are 2.2 apart */
  path = path_to(&f, &(km_space_path_def){.drivers = drivers, .driver_count = 2, .to_drivers = far});
  assert_int_equal(path.outcome, KM_SPACE_PATH_END);
  assert_true(isnan(path.ends[1]) && path.ends[0] > 0.5);
  km_space_path_free(&path);
  fixture_close(&f);
}

static bool keep_below(void *context, const km_mechanism *mechanism, const km_state *state) {
  (void)mechanism;
  return km_state_coordinate(state, 0) < *(const double *)context;
}

/* Both cranks within 3 rad, so that no path leads around the place where the rods can't meet. */
static bool stay_within(void *context, const km_mechanism *mechanism, const km_state *state) {
  const int *drivers = context;
  (void)mechanism;
  return fabs(km_state_coordinate(state, drivers[0])) < 3.0 && fabs(km_state_coordinate(state, drivers[1])) < 3.0;
}

static bool stop_at_once(void *context, double done) {
  (void)context;
  (void)done;
  return false;
}

/* A search that is ended has the trees that it has grown: every configuration is allowed, and one step from its
 * parent. */
static void a_stopped_search_keeps_its_trees(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
  const double around[2] = {2.9, -2.9};
  const km_space_path_def def = {.drivers = drivers,
                                 .driver_count = 2,
                                 .to_drivers = around,
                                 .condition = stay_within,
                                 .context = (void *)(size_t)drivers};
  km_space_path path;
  km_error error;
  assert_int_equal(km_space_path_find(f.mechanism, f.state, &def, stop_at_once, NULL, &path, &error), KM_CANCELLED);
  assert_int_equal(path.outcome, KM_SPACE_PATH_STOPPED);
  assert_int_equal(km_table_rows(path.table), 0);
  size_t rows = km_table_rows(path.explored), ends = 0;
  assert_true(rows > 10 && rows == (size_t)path.configurations);
  for (size_t r = 0; r < rows; ++r) {
    double parent = table_cell(path.explored, r, "parent"), tree = table_cell(path.explored, r, "tree");
    double A = table_cell(path.explored, r, "q.A"), E = table_cell(path.explored, r, "q.E");
    assert_true(table_cell(path.explored, r, "sigma.input") >= KM_DEFAULT_PATH_MARGIN);
    assert_true(fabs(A) < 3.0 && fabs(E) < 3.0);
    if (parent < 0.0) {
      bool is_start = tree == 1.0;
      ++ends;
      assert_at_most(hypot(A - (is_start ? 0.0 : around[0]), E - (is_start ? 0.0 : around[1])), 1e-12);
      continue;
    }
    assert_true(parent < (double)r && table_cell(path.explored, (size_t)parent, "tree") == tree);
    double dA = A - table_cell(path.explored, (size_t)parent, "q.A");
    double dE = E - table_cell(path.explored, (size_t)parent, "q.E");
    assert_true(hypot(dA, dE) > 0.0 && hypot(dA, dE) <= 0.04 * (1.0 + 1e-9));
  }
  assert_true(ends >= 2);
  km_space_path_free(&path);
  fixture_close(&f);
}

static void conditions_and_refusals(void **state) {
  (void)state;
  fixture f = fixture_open("five_bar");
  const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")}, same[2] = {drivers[0], drivers[0]};
  const double values[2] = {-2.7, 0.3};
  double most = 0.5;
  km_space_path path = path_to(
      &f, &(km_space_path_def){
              .drivers = drivers, .driver_count = 2, .to_drivers = values, .condition = keep_below, .context = &most});
  assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
  for (size_t r = 0; r < km_table_rows(path.table); ++r)
    assert_true(table_cell(path.table, r, "q.A") < most);
  km_space_path_free(&path);
  const km_space_path_def good = {.drivers = drivers, .driver_count = 2, .to_drivers = values};
  km_space_path_def bad[5] = {good, good, good, good, good};
  bad[0].driver_count = 1;
  bad[1].drivers = same;
  bad[2].to_drivers = NULL;
  bad[3].margin = -1.0;
  bad[4].driver_count = KM_MAX_PATH_DRIVERS + 1;
  km_error error;
  for (int k = 0; k < 5; ++k) {
    assert_int_equal(km_space_path_find(f.mechanism, f.state, &bad[k], NULL, NULL, &path, &error), KM_USAGE);
    km_space_path_free(&path);
  }
  assert_string_equal(km_space_path_outcome_name(KM_SPACE_PATH_SEPARATED), "separated");
  assert_string_equal(km_space_path_outcome_name((km_space_path_outcome)9), "");
  fixture_close(&f);
}

/* Two hinges in no loop, whose drivers are never singular: around a disk of their plane. */
typedef struct disk {
  double middle[2];
  int joint[2];
} disk;

static double distance_of(const disk *d, const double values[2]) {
  return hypot(values[0] - d->middle[0], values[1] - d->middle[1]);
}

/* Outside the disk, and not round the back of the hinges. */
static bool stay_outside(void *context, const km_mechanism *mechanism, const km_state *state) {
  const disk *d = context;
  (void)mechanism;
  double distance =
      distance_of(d, (double[2]){km_state_coordinate(state, d->joint[0]), km_state_coordinate(state, d->joint[1])});
  return distance >= 0.5 && distance < 2.5;
}

static void arms_go_around_obstacles(void **state) {
  (void)state;
  fixture f = fixture_open("double_pendulum");
  const int drivers[2] = {0, 1};
  const double start = km_state_coordinate(f.state, 0), other = km_state_coordinate(f.state, 1);
  const double end[2] = {start + 2.0, other};
  disk blocked = {{start + 1.0, other}, {0, 1}};
  km_space_path path = path_to(
      &f,
      &(km_space_path_def){
          .drivers = drivers, .driver_count = 2, .to_drivers = end, .condition = stay_outside, .context = &blocked});
  assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
  assert_false(path.is_straight);
  assert_smooth(&path, 2);
  for (size_t r = 0; r < km_table_rows(path.table); ++r)
    assert_true(distance_of(&blocked, km_table_row(path.table, r) + 1) >= 0.5);
  double shortest = sqrt(3.0) + M_PI / 6.0; /* two tangents, and a sixth of the disk's edge */
  assert_true(path.length >= shortest - 0.01 && path.length <= 1.1 * shortest);
  assert_true(isinf(path.least_margin));
  km_space_path_free(&path);
  fixture_close(&f);
}

/* A ball that the effector of an arm mustn't enter. */
typedef struct ball_obstacle {
  int frame;
  double centre[3];
  double radius;
} ball_obstacle;

static double distance_from_centre(const ball_obstacle *b, const km_mechanism *m, const km_state *s) {
  double place[3];
  km_frame_position(m, s, b->frame, place);
  return hypot(hypot(place[0] - b->centre[0], place[1] - b->centre[1]), place[2] - b->centre[2]);
}

static bool stay_out_of_ball(void *context, const km_mechanism *mechanism, const km_state *state) {
  const ball_obstacle *b = context;
  return distance_from_centre(b, mechanism, state) >= b->radius;
}

/* All seven joints of an arm are drivers: its hand goes around a ball in the middle of the straight path. */
static void a_7r_arm_goes_around_a_ball(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  const char *const hand[] = {"flange", "tool"};
  int drivers[7];
  double start[7], middle[7], end[7];
  ball_obstacle ball = {.radius = 0.15};
  assert_int_equal(km_model_find_frame(f.model, hand, 2, &ball.frame, NULL), KM_OK);
  km_state_coordinates(f.mechanism, f.state, start, NULL);
  for (int k = 0; k < 7; ++k) {
    drivers[k] = k;
    end[k] = start[k] + (k == 0 ? 1.6 : k == 3 ? 0.2 : 0.0);
    middle[k] = 0.5 * (start[k] + end[k]);
  }
  assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, middle, NULL), KM_OK);
  km_poses_compute(f.mechanism, f.state);
  km_frame_position(f.mechanism, f.state, ball.frame, ball.centre);
  assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, start, NULL), KM_OK);
  km_space_path path = path_to(
      &f,
      &(km_space_path_def){
          .drivers = drivers, .driver_count = 7, .to_drivers = end, .condition = stay_out_of_ball, .context = &ball});
  assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
  assert_false(path.is_straight);
  assert_smooth(&path, 7);
  for (size_t r = 0; r < km_table_rows(path.table); ++r) {
    const double *q = km_table_row(path.table, r) + 1;
    assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, q, NULL), KM_OK);
    km_poses_compute(f.mechanism, f.state);
    assert_true(distance_from_centre(&ball, f.mechanism, f.state) >= ball.radius);
    for (int k = 0; k < 7; ++k) {
      double low, high;
      km_model_coordinate_limits(f.model, k, &low, &high);
      assert_true(q[k] >= low - 1e-12 && q[k] <= high + 1e-12);
    }
  }
  for (int k = 0; k < 7; ++k)
    assert_near(km_table_row(path.table, km_table_rows(path.table) - 1)[1 + k], end[k], 1e-9);
  km_space_path_free(&path);
  fixture_close(&f);
}

/* The cylinders of an excavator's boom and stick, each of a part of its own, and its turntable in no loop. */
static void drivers_of_different_parts(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  const int drivers[3] = {fixture_coordinate(&f, "L"), fixture_coordinate(&f, "N"), fixture_coordinate(&f, "B")};
  const double end[3] = {2.6, 2.7, 1.0};
  km_space_path path =
      path_to(&f, &(km_space_path_def){.drivers = drivers, .driver_count = 3, .to_drivers = end, .seed = 1});
  assert_int_equal(path.outcome, KM_SPACE_PATH_FOUND);
  assert_smooth(&path, 3);
  const double *last = km_table_row(path.table, km_table_rows(path.table) - 1);
  for (int d = 0; d < 3; ++d)
    assert_near(last[1 + d], end[d], 1e-9);
  double q[64] = {0.0};
  for (int c = 0; c < km_model_coordinate_count(f.model); ++c) {
    char name[64];
    snprintf(name, sizeof name, "q.%s", km_model_coordinate_label(f.model, c));
    q[c] = table_cell(path.table, km_table_rows(path.table) - 1, name);
  }
  assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, q, NULL), KM_OK);
  for (int k = 0; k < f.mechanism->topology.substructure_count; ++k) {
    assert_at_most(km_loops_residual(f.mechanism, f.state, &f.mechanism->substructures[k]), 1e-11);
  }
  km_space_path_free(&path);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(five_bars_keep_their_mode),
                                     cmocka_unit_test(platforms_keep_the_sign_of_their_lines),
                                     cmocka_unit_test(lines_meet_on_the_curves_of_a_slice),
                                     cmocka_unit_test(opposite_modes_are_separated),
                                     cmocka_unit_test(a_stopped_search_keeps_its_trees),
                                     cmocka_unit_test(conditions_and_refusals),
                                     cmocka_unit_test(arms_go_around_obstacles),
                                     cmocka_unit_test(a_7r_arm_goes_around_a_ball),
                                     cmocka_unit_test(drivers_of_different_parts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
