/* Maps over two drivers: five-bars against closed forms. */
#include "support/support.h"

#include "base/random.h"
#include "kmech/clearance.h"
#include "kmech/space.h"
#include "model/model.h"

enum { WORKSPACES = 12, TRIALS = 4 };
static const double ball = 0.01; /* radius of the spheres */

/* A five-bar: cranks of lengths a and d on the pins (0, 0) and (1, 0), rods of lengths b and c between their ends and
 * the point P. Joints A, E: cranks; B, D: their ends; C: P. */
typedef struct five_bar {
  double crank[2][2], P[2]; /* ends of the cranks, and P, as drawn */
} five_bar;

/* The mechanism; unless `post` is NULL with a sphere at the point, and a fixed sphere at `post`. */
static fixture build_with(const five_bar *b, const double *post) {
  km_text text = {0}, shape = {0}, body = {0}, joint = {0};
  if (post) {
    km_text_format(&shape, ", \"shapes\": [{\"sphere\": %g, \"T\": [%.17g, %.17g, 0]}]", ball, b->P[0], b->P[1]);
    km_text_format(&body, ", {\"name\": \"post\", \"shapes\": [{\"sphere\": %g, \"T\": [%.17g, %.17g, 0]}]}", ball,
                   post[0], post[1]);
    km_text_format(&joint, ",{\"name\": \"F\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"post\"]}");
  }
  km_text_format(&text,
                 "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"b1\"}, "
                 "{\"name\": \"b2\", \"frames\": [{\"name\": \"P\", \"T\": [%.17g, %.17g, 0]}]%s}, "
                 "{\"name\": \"b3\"}, {\"name\": \"b4\"}%s], \"joints\": ["
                 "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"b1\"], \"at\": [0, 0]},"
                 "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"b1\", \"b2\"], \"at\": [%.17g, %.17g]},"
                 "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"b2\", \"b3\"], \"at\": [%.17g, %.17g]},"
                 "{\"name\": \"D\", \"type\": \"revolute\", \"bodies\": [\"b4\", \"b3\"], \"at\": [%.17g, %.17g]},"
                 "{\"name\": \"E\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"b4\"], \"at\": [1, 0]}%s]}]}",
                 b->P[0], b->P[1], post ? shape.data : "", post ? body.data : "", b->crank[0][0], b->crank[0][1],
                 b->P[0], b->P[1], b->crank[1][0], b->crank[1][1], post ? joint.data : "");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  km_text_free(&shape);
  km_text_free(&body);
  km_text_free(&joint);
  return f;
}

static fixture build(const five_bar *b) {
  return build_with(b, NULL);
}

static five_bar random_five_bar(uint64_t *random) {
  five_bar b = {.crank = {{-0.2, 0.6}, {1.2, 0.7}}, .P = {0.5, 1.4}};
  for (int k = 0; k < 2; ++k) {
    b.crank[0][k] += 0.2 * km_uniform(random);
    b.crank[1][k] += 0.2 * km_uniform(random);
    b.P[k] += 0.2 * km_uniform(random);
  }
  return b;
}

/* Distance of the cranks' ends at angles from the drawn pose, and the ends. */
static double ends(const five_bar *b, double alpha, double epsilon, double end[2][2]) {
  const double angle[2] = {alpha, epsilon}, pin[2] = {0.0, 1.0};
  for (int k = 0; k < 2; ++k) {
    double x = b->crank[k][0] - pin[k], y = b->crank[k][1];
    end[k][0] = pin[k] + cos(angle[k]) * x - sin(angle[k]) * y;
    end[k][1] = sin(angle[k]) * x + cos(angle[k]) * y;
  }
  return hypot(end[1][0] - end[0][0], end[1][1] - end[0][1]);
}

/* `frame`: of the point P; -1: none. */
static km_space_map map_of(const fixture *f, double from, double to, int steps, int frame) {
  const int locked[2] = {fixture_coordinate(f, "A"), fixture_coordinate(f, "E")};
  const km_space_map_def def = {.axis = {{locked[0], from, to, steps}, {locked[1], from, to, steps}},
                                .has_point = frame >= 0,
                                .frame = frame,
                                .point_name = "P"};
  km_all_modes modes;
  km_space_map map;
  km_error error = {0};
  const km_all_modes_def of_modes = {.locked = locked, .locked_count = 2, .seed = 1};
  if (km_all_modes_find(f->mechanism, f->state, &of_modes, NULL, NULL, &modes, &error) ||
      km_space_map_compute(f->mechanism, f->state, &def, &modes, NULL, NULL, &map, &error))
    fail_msg("%s", error.text);
  km_all_modes_free(&modes);
  return map;
}

/* A grid point is reached if and only if the circles of the rods meet there and it is connected with the drawn pose;
 * every cell closes the rods, on the side of its mode. */
static void cells_close_the_rods(void **state) {
  (void)state;
  uint64_t random = 4;
  for (int trial = 0; trial < 6; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture f = build(&b);
    enum { STEPS = 40 };
    km_space_map map = map_of(&f, -1.5, 1.5, STEPS, -1);
    double rod[2] = {hypot(b.P[0] - b.crank[0][0], b.P[1] - b.crank[0][1]),
                     hypot(b.P[0] - b.crank[1][0], b.P[1] - b.crank[1][1])};
    int possible = 0, stack[(STEPS + 1) * (STEPS + 1)], size = 0;
    bool seen[STEPS + 1][STEPS + 1] = {{false}};
    stack[size++] = STEPS / 2 * (STEPS + 1) + STEPS / 2;
    seen[STEPS / 2][STEPS / 2] = true;
    while (size > 0) { /* closed form of the connected grid points */
      int i = stack[--size] % (STEPS + 1), j = stack[size] / (STEPS + 1);
      ++possible;
      for (int side = 0; side < 4; ++side) {
        int x = i + (side == 0) - (side == 1), y = j + (side == 2) - (side == 3);
        bool is_open = false;
        if (x < 0 || y < 0 || x > STEPS || y > STEPS || seen[y][x])
          continue;
        for (int part = 1; part <= 50; ++part) { /* the way from grid point to grid point */
          double end[2][2],
              u = part / 50.0,
              d = ends(&b, -1.5 + 3.0 * (i + u * (x - i)) / STEPS, -1.5 + 3.0 * (j + u * (y - j)) / STEPS, end);
          is_open = is_open || d >= rod[0] + rod[1] || d <= fabs(rod[0] - rod[1]);
        }
        if (is_open)
          continue;
        seen[y][x] = true;
        stack[size++] = y * (STEPS + 1) + x;
      }
    }
    assert_int_equal(map.sheet_count, 2);
    assert_int_equal(km_table_rows(map.cells), 2 * possible);
    for (size_t k = 0; k < km_table_rows(map.cells); ++k) {
      double end[2][2], alpha = table_cell(map.cells, k, "q.A");
      ends(&b, alpha, table_cell(map.cells, k, "q.E"), end);
      double turn = alpha + table_cell(map.cells, k, "q.B");
      double x = b.P[0] - b.crank[0][0], y = b.P[1] - b.crank[0][1];
      double P[2] = {end[0][0] + cos(turn) * x - sin(turn) * y, end[0][1] + sin(turn) * x + cos(turn) * y};
      assert_near(hypot(P[0] - end[1][0], P[1] - end[1][1]), rod[1], 1e-10);
      double side = (end[1][0] - end[0][0]) * (P[1] - end[0][1]) - (end[1][1] - end[0][1]) * (P[0] - end[0][0]);
      double drawn = (b.crank[1][0] - b.crank[0][0]) * (b.P[1] - b.crank[0][1]) -
                     (b.crank[1][1] - b.crank[0][1]) * (b.P[0] - b.crank[0][0]);
      assert_true((side * drawn > 0.0) == (table_cell(map.cells, k, "sheet") == 1.0));
      double sum = 0.0;
      for (size_t c = 0; c < 5; ++c)
        sum += km_table_row(map.cells, k)[7 + c];
      assert_near(sum, 2.0, 1e-12); /* mobility numbers add up to the freedoms */
      double input = table_cell(map.cells, k, "sigma.input");
      assert_true(input > 0.0 && table_cell(map.cells, k, "sigma.closure") >= input - 1e-12);
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
}

/* The rods are in line on a singularity curve: the cranks' ends are as far apart as both rods, or their difference. */
static void rods_are_in_line_on_the_curves(void **state) {
  (void)state;
  uint64_t random = 8;
  size_t points = 0;
  for (int trial = 0; trial < 6; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture f = build(&b);
    km_space_map map = map_of(&f, -2.0, 2.0, 40, -1);
    double rod[2] = {hypot(b.P[0] - b.crank[0][0], b.P[1] - b.crank[0][1]),
                     hypot(b.P[0] - b.crank[1][0], b.P[1] - b.crank[1][1])};
    assert_true(map.curve_count > 0);
    for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
      double end[2][2], d = ends(&b, table_cell(map.curves, k, "q.A"), table_cell(map.curves, k, "q.E"), end);
      assert_at_most(fmin(fabs(d - rod[0] - rod[1]), fabs(d - fabs(rod[0] - rod[1]))), 1e-9);
      ++points;
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
  assert_true(points > 500);
}

/* The point P can't move along a crank that is in line with its rod: then it is as far from the crank's pin as both, or
 * as their difference. In a cell, both rods hold P, and the sizes of D are those of the closed form. */
static void cranks_and_rods_are_in_line_where_the_output_is_singular(void **state) {
  (void)state;
  uint64_t random = 21;
  size_t points = 0;
  for (int trial = 0; trial < 4; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture f = build(&b);
    const char *const path[] = {"b2", "P"};
    int frame;
    assert_int_equal(km_model_find_frame(f.model, path, 2, &frame, NULL), KM_OK);
    km_space_map map = map_of(&f, -3.0, 3.0, 60, frame);
    double radius[2][2];
    for (int k = 0; k < 2; ++k) {
      double crank = hypot(b.crank[k][0] - k, b.crank[k][1]);
      double rod = hypot(b.P[0] - b.crank[k][0], b.P[1] - b.crank[k][1]);
      radius[k][0] = crank + rod;
      radius[k][1] = fabs(crank - rod);
    }
    for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
      if (table_cell(map.curves, k, "kind") != KM_CURVE_OUTPUT)
        continue;
      double x = table_cell(map.curves, k, "point.P.x"), y = table_cell(map.curves, k, "point.P.y"), least = HUGE_VAL;
      for (int pin = 0; pin < 2; ++pin)
        for (int side = 0; side < 2; ++side)
          least = fmin(least, fabs(hypot(x - pin, y) - radius[pin][side]));
      assert_at_most(least, 1e-9);
      ++points;
    }
    for (size_t k = 0; k < km_table_rows(map.cells); ++k) {
      double end[2][2], x = table_cell(map.cells, k, "point.P.x"), y = table_cell(map.cells, k, "point.P.y");
      ends(&b, table_cell(map.cells, k, "q.A"), table_cell(map.cells, k, "q.E"), end);
      for (int side = 0; side < 2; ++side)
        assert_near(hypot(x - end[side][0], y - end[side][1]),
                    hypot(b.P[0] - b.crank[side][0], b.P[1] - b.crank[side][1]), 1e-10);
      /* D = W⁻¹ V: w_i · Ṗ = w_i · (velocity of the crank's end), w_i along rod i */
      double w[2][2], v[2];
      for (int i = 0; i < 2; ++i) {
        w[i][0] = x - end[i][0];
        w[i][1] = y - end[i][1];
        v[i] = -w[i][0] * end[i][1] + w[i][1] * (end[i][0] - i);
      }
      double determinant = fabs(v[0] * v[1] / (w[0][0] * w[1][1] - w[0][1] * w[1][0]));
      double size = f.mechanism->substructures[0].size;
      assert_near(table_cell(map.cells, k, "manipulability") * size * size, determinant, 1e-9 * (1.0 + determinant));
      assert_true(table_cell(map.cells, k, "sigma.output") <=
                  sqrt(table_cell(map.cells, k, "manipulability")) * (1.0 + 1e-12));
    }
    km_space_map_free(&map);
    fixture_close(&f);
  }
  assert_true(points > 500);
}

/* Number of inverse solutions with both cranks in their ranges low … high, from the drawn pose. */
static int solutions(const five_bar *b, double low[2], double high[2], double x, double y) {
  int product = 1;
  for (int k = 0; k < 2; ++k) {
    double cx = b->crank[k][0] - k, cy = b->crank[k][1], crank = hypot(cx, cy), distance = hypot(x - k, y);
    double rod = hypot(b->P[0] - b->crank[k][0], b->P[1] - b->crank[k][1]);
    double cosine = (crank * crank + distance * distance - rod * rod) / (2.0 * crank * distance);
    int count = 0;
    for (int elbow = -1; elbow <= 1 && fabs(cosine) < 1.0; elbow += 2) {
      double angle = atan2(y, x - k) + elbow * acos(cosine) - atan2(cy, cx);
      angle = low[k] + fmod(angle - low[k] + 8.0 * M_PI, 2.0 * M_PI);
      count += angle <= high[k];
    }
    product *= count;
  }
  return product;
}

/* ∫ [N > 0] and ∫ N over the plane, N the number of inverse solutions: along lines of constant y, on which the changes
 * of N are bisected. */
static void integrate(const five_bar *b, double low[2], double high[2], double *area, double *sum) {
  enum { LINES = 240, POINTS = 500 };
  const double extent = 3.0, h = 2.0 * extent / LINES, step = 2.0 * extent / POINTS;
  *area = *sum = 0.0;
  for (int i = 0; i < LINES; ++i) {
    double y = -extent + (i + 0.5) * h;
    for (int j = 0; j < POINTS; ++j) {
      double from = -extent + j * step + 1e-3, to = from + step, middle = from;
      int first = solutions(b, low, high, from, y), last = solutions(b, low, high, to, y);
      double a = from, c = to;
      for (int k = 0; first != last && k < 40; ++k) {
        middle = 0.5 * (a + c);
        if (solutions(b, low, high, middle, y) == first)
          a = middle;
        else
          c = middle;
      }
      double part = first == last ? step : a - from;
      *area += h * ((first > 0) * part + (last > 0) * (step - part));
      *sum += h * (first * part + last * (step - part));
    }
  }
}

/* Every row of the outline is on a circle about a pin where a crank and its rod are in line, or on one about the end of
 * a crank at an end of its range; each loop closes. */
static void check_outline(const five_bar *b, double low[2], double high[2], const km_space_map *map) {
  const km_table *t = map->boundary;
  size_t first = 0;
  for (size_t i = 0; i < km_table_rows(t); ++i) {
    double x = table_cell(t, i, "point.P.x"), y = table_cell(t, i, "point.P.y"), least = HUGE_VAL;
    bool is_limit = table_cell(t, i, "kind") == KM_CURVE_LIMIT;
    assert_true(is_limit || table_cell(t, i, "kind") == KM_CURVE_OUTPUT);
    for (int k = 0; k < 2; ++k) {
      double crank = hypot(b->crank[k][0] - k, b->crank[k][1]);
      double rod = hypot(b->P[0] - b->crank[k][0], b->P[1] - b->crank[k][1]);
      for (int side = 0; side < 2; ++side) {
        double end[2][2], angle = side ? high[k] : low[k];
        ends(b, angle, angle, end);
        double off = is_limit ? hypot(x - end[k][0], y - end[k][1]) - rod
                              : hypot(x - k, y) - (side ? crank + rod : fabs(crank - rod));
        least = fmin(least, fabs(off));
      }
    }
    assert_at_most(least, 1e-8);
    if (i > 0 && table_cell(t, i, "loop") != table_cell(t, i - 1, "loop"))
      first = i;
    if (i + 1 == km_table_rows(t) || table_cell(t, i + 1, "loop") != table_cell(t, i, "loop"))
      assert_at_most(hypot(x - table_cell(t, first, "point.P.x"), y - table_cell(t, first, "point.P.y")),
                     fmax(map->gap, 1e-3));
  }
}

/* The workspace is where there is an inverse solution; its aspects have one each. Circles and rectangles are within. */
static void workspace_has_inverse_solutions(void **state) {
  (void)state;
  uint64_t random = 77;
  for (int trial = 0; trial < WORKSPACES; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture f = build(&b);
    const char *const path[] = {"b2", "P"};
    double low[2], high[2];
    for (int k = 0; k < 2; ++k) {
      bool is_turn = km_uniform(&random) < -0.4;
      low[k] = is_turn ? -M_PI : -1.4 + 0.9 * km_uniform(&random);
      high[k] = is_turn ? M_PI : 1.4 + 0.9 * km_uniform(&random);
    }
    km_space_map_def def = {.axis = {{fixture_coordinate(&f, "A"), low[0], high[0], 60},
                                     {fixture_coordinate(&f, "E"), low[1], high[1], 60}},
                            .has_point = true,
                            .point_name = "P"};
    assert_int_equal(km_model_find_frame(f.model, path, 2, &def.frame, NULL), KM_OK);
    km_all_modes modes;
    km_space_map map;
    assert_int_equal(km_map_modes_find(f.mechanism, f.state, def.axis[0].coordinate, def.axis[1].coordinate, 1, NULL,
                                       NULL, &modes, NULL),
                     KM_OK);
    assert_int_equal(km_space_map_compute(f.mechanism, f.state, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
    double area, sum, aspects = 0.0;
    integrate(&b, low, high, &area, &sum);
    for (int i = 0; i < map.workspace_count; ++i) {
      const km_aspect_workspace *at = &map.workspaces[i];
      assert_true(at->area > 0.0);
      aspects += isfinite(at->area) ? at->area : 0.0;
      for (int k = 0; k < 64; ++k) { /* chords are 1e-6 of the extent beside the curves */
        double r = at->radius - 1e-5, u = (k % 16) / 16.0 - 0.5, v = k < 32 ? 0.5 : -0.5;
        double x = at->rectangle[0] + (k & 16 ? u : v) * (at->width - 1e-5),
               y = at->rectangle[1] + (k & 16 ? v : u) * (at->height - 1e-5);
        if (r > 0.0)
          assert_true(solutions(&b, low, high, at->circle[0] + r * cos(0.1 * k), at->circle[1] + r * sin(0.1 * k)) > 0);
        if (fmin(at->width, at->height) > 1e-5)
          assert_true(solutions(&b, low, high, x, y) > 0);
      }
    }
    check_outline(&b, low, high, &map);
    assert_int_equal(map.unbounded, 0);
    assert_near(map.workspace_area, area, 1e-2);
    assert_near(aspects, sum, 1e-2 + 3e-3 * sum);
    km_space_map_free(&map);
    km_all_modes_free(&modes);
    fixture_close(&f);
  }
}

/* The workspace of the point, which keeps a clearance if it isn't NaN. */
static km_space_map workspace_of(const fixture *f, double least) {
  const char *const path[] = {"b2", "P"};
  const int drivers[2] = {fixture_coordinate(f, "A"), fixture_coordinate(f, "E")};
  km_clearance *clearance = NULL;
  km_all_modes modes;
  km_space_map map;
  km_space_map_def def = {.axis = {{drivers[0], -1.1, 1.3, 50}, {drivers[1], -1.1, 1.3, 50}},
                          .has_point = true,
                          .point_name = "P",
                          .least_clearance = least};
  km_poses_compute(f->mechanism, f->state);
  if (isfinite(least))
    assert_int_equal(km_clearance_create(f->mechanism, f->state, NULL, 0, &clearance, NULL), KM_OK);
  def.clearance = clearance;
  assert_int_equal(km_model_find_frame(f->model, path, 2, &def.frame, NULL), KM_OK);
  assert_int_equal(km_map_modes_find(f->mechanism, f->state, drivers[0], drivers[1], 1, NULL, NULL, &modes, NULL),
                   KM_OK);
  assert_int_equal(km_space_map_compute(f->mechanism, f->state, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
  km_all_modes_free(&modes);
  km_clearance_free(clearance);
  return map;
}

/* A post within the largest circle of an aspect takes a disc out of the workspace, on whose edge the curves are. */
static void a_post_takes_a_disc_out(void **state) {
  (void)state;
  uint64_t random = 9;
  size_t points = 0;
  for (int trial = 0; trial < TRIALS; ++trial) {
    five_bar b = random_five_bar(&random);
    fixture f = build(&b);
    km_space_map plain = workspace_of(&f, nan(""));
    const km_aspect_workspace *largest = &plain.workspaces[0];
    for (int i = 1; i < plain.workspace_count; ++i)
      largest = plain.workspaces[i].radius > largest->radius ? &plain.workspaces[i] : largest;
    const double *post = largest->circle, radius = 0.5 * largest->radius;
    fixture with_post = build_with(&b, post);
    km_space_map map = workspace_of(&with_post, radius - 2.0 * ball);
    for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
      if (table_cell(map.curves, k, "kind") != KM_CURVE_CLEARANCE)
        continue;
      double x = table_cell(map.curves, k, "point.P.x") - post[0], y = table_cell(map.curves, k, "point.P.y") - post[1];
      assert_near(hypot(x, y), radius, 1e-9);
      ++points;
    }
    assert_near(map.workspace_area, plain.workspace_area - M_PI * radius * radius, 1e-7);
    assert_int_equal(map.hole_count, plain.hole_count + 1);
    assert_int_equal(map.unbounded, 0);
    for (size_t k = 0; k < km_table_rows(map.cells); ++k)
      assert_true(hypot(table_cell(map.cells, k, "point.P.x") - post[0],
                        table_cell(map.cells, k, "point.P.y") - post[1]) >= radius - 1e-9);
    km_space_map_free(&map);
    km_space_map_free(&plain);
    fixture_close(&f);
    fixture_close(&with_post);
  }
  assert_true(points > 100);
}

/* Drivers of different parts: an arm of two hinges in no loop, whose second link carries a four-bar that a crank
 * drives. The end of the arm moves as l1 l2 sin q2, and the four-bar on its own. */
static void drivers_of_different_parts(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"upper\"}, "
      "{\"name\": \"fore\", \"frames\": [{\"name\": \"end\", \"T\": [1.7, 0, 0]}]}, {\"name\": \"crank\"}, "
      "{\"name\": \"coupler\"}, {\"name\": \"rocker\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"upper\"], \"at\": [0, 0]},"
      "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"upper\", \"fore\"], \"at\": [1, 0]},"
      "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"fore\", \"crank\"], \"at\": [1.2, 0]},"
      "{\"name\": \"D\", \"type\": \"revolute\", \"bodies\": [\"crank\", \"coupler\"], \"at\": [1.2, 0.1]},"
      "{\"name\": \"E\", \"type\": \"revolute\", \"bodies\": [\"coupler\", \"rocker\"], \"at\": [1.5, 0.3]},"
      "{\"name\": \"F\", \"type\": \"revolute\", \"bodies\": [\"fore\", \"rocker\"], \"at\": [1.55, 0]}]}]}");
  const char *const path[] = {"fore", "end"};
  int frame;
  assert_int_equal(km_model_find_frame(f.model, path, 2, &frame, NULL), KM_OK);
  for (int pair = 0; pair < 2; ++pair) {
    const int drivers[2] = {fixture_coordinate(&f, pair ? "B" : "A"), fixture_coordinate(&f, pair ? "C" : "B")};
    const km_space_map_def def = {.axis = {{drivers[0], -3.0, 3.0, 30}, {drivers[1], -3.0, 3.0, 30}},
                                  .has_point = !pair,
                                  .frame = frame,
                                  .point_name = "end"};
    km_all_modes modes;
    km_space_map map;
    assert_int_equal(km_map_modes_find(f.mechanism, f.state, drivers[0], drivers[1], 1, NULL, NULL, &modes, NULL),
                     KM_OK);
    assert_int_equal(modes.count, pair ? 2 : 1);
    assert_int_equal(km_space_map_compute(f.mechanism, f.state, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
    assert_int_equal(km_table_rows(map.cells), modes.count * 31 * 31);
    double size = f.mechanism->length;
    for (size_t k = 0; k < km_table_rows(map.cells) && !pair; ++k)
      assert_near(table_cell(map.cells, k, "manipulability") * size * size,
                  0.7 * fabs(sin(table_cell(map.cells, k, "q.B"))), 1e-12);
    for (size_t k = 0; k < km_table_rows(map.curves); ++k) {
      bool is_limit = table_cell(map.curves, k, "kind") == KM_CURVE_LIMIT;
      assert_true(!pair);
      assert_near(is_limit ? fmax(fabs(table_cell(map.curves, k, "q.A")), fabs(table_cell(map.curves, k, "q.B"))) - 3.0
                           : sin(table_cell(map.curves, k, "q.B")),
                  0.0, 1e-9);
    }
    assert_int_equal(map.curve_count, pair ? 0 : 5); /* four of them are ends of the ranges */
    assert_int_equal(map.aspect_count, 2);
    km_space_map_free(&map);
    km_all_modes_free(&modes);
  }
  fixture_close(&f);
}

/* The workspace depends neither on the order of the drivers nor on the sense of their ranges. */
static void order_and_sense_of_drivers_do_not_matter(void **state) {
  (void)state;
  uint64_t random = 5;
  five_bar b = random_five_bar(&random);
  fixture f = build(&b);
  const char *const path[] = {"b2", "P"};
  const int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")};
  double first = 0.0;
  for (int k = 0; k < 4; ++k) {
    km_space_map_def def = {.axis = {{drivers[k % 2], -1.1, 1.3, 50}, {drivers[1 - k % 2], -1.1, 1.3, 50}},
                            .has_point = true,
                            .point_name = "P"};
    if (k > 1)
      def.axis[0] = (km_space_axis){drivers[k % 2], 1.3, -1.1, 50};
    km_all_modes modes;
    km_space_map map;
    assert_int_equal(km_model_find_frame(f.model, path, 2, &def.frame, NULL), KM_OK);
    assert_int_equal(km_map_modes_find(f.mechanism, f.state, drivers[0], drivers[1], 1, NULL, NULL, &modes, NULL),
                     KM_OK);
    assert_int_equal(km_space_map_compute(f.mechanism, f.state, &def, &modes, NULL, NULL, &map, NULL), KM_OK);
    first = k == 0 ? map.workspace_area : first;
    assert_near(map.workspace_area, first, 1e-7); /* Hermite's error along 10 sizes of curves */
    assert_true(map.workspace_area > 0.1);
    km_space_map_free(&map);
    km_all_modes_free(&modes);
  }
  fixture_close(&f);
}

static bool stop_at_once(void *context, double done) {
  (void)context;
  (void)done;
  return false;
}

static void refusals(void **state) {
  (void)state;
  uint64_t random = 4;
  five_bar b = random_five_bar(&random);
  fixture f = build(&b);
  int A = fixture_coordinate(&f, "A"), E = fixture_coordinate(&f, "E");
  double zero[5] = {0};
  const km_all_modes modes = {.count = 1, .coordinates = zero};
  km_space_map map;
  km_error error;
  const km_space_map_def good = {.axis = {{A, -1.0, 1.0, 4}, {E, -1.0, 1.0, 4}}},
                         same = {.axis = {{A, -1.0, 1.0, 4}, {A, -1.0, 1.0, 4}}},
                         empty = {.axis = {{A, 1.0, 1.0, 4}, {E, -1.0, 1.0, 4}}},
                         index = {.axis = {{99, -1.0, 1.0, 4}, {E, -1.0, 1.0, 4}}};
  assert_int_equal(km_space_map_compute(f.mechanism, f.state, &good, &modes, stop_at_once, NULL, &map, &error),
                   KM_CANCELLED);
  km_space_map_free(&map);
  const km_space_map_def *bad[] = {&same, &empty, &index, NULL};
  for (int k = 0; k < 4; ++k) {
    assert_int_equal(km_space_map_compute(f.mechanism, f.state, bad[k], &modes, NULL, NULL, &map, &error), KM_USAGE);
    km_space_map_free(&map);
  }
  fixture_close(&f);
  f = fixture_open("fourbar");
  const km_space_map_def one_freedom = {.axis = {{0, -1.0, 1.0, 4}, {3, -1.0, 1.0, 4}}};
  assert_int_equal(km_state_coordinates(f.mechanism, f.state, zero, NULL), KM_OK);
  assert_int_equal(km_space_map_compute(f.mechanism, f.state, &one_freedom, &modes, NULL, NULL, &map, &error),
                   KM_USAGE);
  km_space_map_free(&map);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(cells_close_the_rods),
                                     cmocka_unit_test(rods_are_in_line_on_the_curves),
                                     cmocka_unit_test(cranks_and_rods_are_in_line_where_the_output_is_singular),
                                     cmocka_unit_test(workspace_has_inverse_solutions),
                                     cmocka_unit_test(order_and_sense_of_drivers_do_not_matter),
                                     cmocka_unit_test(a_post_takes_a_disc_out),
                                     cmocka_unit_test(drivers_of_different_parts),
                                     cmocka_unit_test(refusals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
