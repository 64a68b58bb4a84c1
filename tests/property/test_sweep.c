/* Driving: exact, on one branch, and independent of how the range is cut. */
#include "support/motion_families.h"
#include "support/support.h"

#include "model/model.h"

#include <stdio.h>
#include <string.h>

static km_mobility_sweep run(const char *name, int steps, double from_share, double to_share, bool ignore_limits) {
  fixture f = fixture_open(name);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  double from = plan.from, length = plan.to - plan.from;
  plan.from = from + from_share * length;
  plan.to = from + to_share * length;
  plan.steps = steps;
  plan.ignore_limits = ignore_limits;
  km_mobility_sweep sweep;
  km_error error = {0};
  km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error);
  if (status && status != KM_PARTIAL)
    fail_msg("%s: %s", name, error.text);
  fixture_close(&f);
  return sweep;
}

static void rows_do_not_depend_on_steps(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    if (!has_one_freedom(*name))
      continue;
    km_mobility_sweep coarse = run(*name, 12, 0.0, 1.0, false), fine = run(*name, 12 * 37, 0.0, 1.0, false);
    assert_int_equal(coarse.motion.end.stop, KM_STOP_NONE);
    assert_int_equal(fine.motion.end.stop, KM_STOP_NONE);
    for (size_t r = 0; r <= 12; ++r)
      for (size_t c = 1; c < km_table_columns(coarse.motion.table); ++c)
        assert_near(km_table_row(coarse.motion.table, r)[c], km_table_row(fine.motion.table, 37 * r)[c], 1e-8);
    km_mobility_sweep_free(&coarse);
    km_mobility_sweep_free(&fine);
  }
}

/* With other freedoms the path of least motion is followed to 1e-4, also where rows lie so close that each step goes
 * on from those before it. */
static void least_motion_converges(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    if (has_one_freedom(*name))
      continue;
    km_mobility_sweep coarse = run(*name, 10, 0.4, 0.6, false);
    for (int times = 8; times <= 160; times *= 20) {
      km_mobility_sweep fine = run(*name, 10 * times, 0.4, 0.6, false);
      for (size_t r = 0; r <= 10; ++r)
        for (size_t c = 1; c < km_table_columns(coarse.motion.table); ++c)
          assert_near(km_table_row(coarse.motion.table, r)[c], km_table_row(fine.motion.table, (size_t)times * r)[c],
                      1e-4);
      km_mobility_sweep_free(&fine);
    }
    km_mobility_sweep_free(&coarse);
  }
}

/* There and back in 200 rows each way, perhaps with a look at a place beside every row. Out: the coordinates at the
 * end of both ways. */
static void go_and_return(const char *name, bool looks, double *far, double *back) {
  fixture f = fixture_open(name);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_driver_motion *drive = NULL;
  double start = km_state_coordinate(f.state, plan.coordinate), length = 0.1 * (plan.to - plan.from);
  size_t bytes = (size_t)f.mechanism->coordinate_count * sizeof *far;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, plan.coordinate, true, &drive, NULL), KM_OK);
  for (int row = 1; row <= 400; ++row) {
    double at = start + length * (row <= 200 ? row : 400 - row) / 200.0;
    assert_int_equal(km_driver_motion_move_to(drive, at).stop, KM_STOP_NONE);
    if (looks) {
      km_driver_motion_save(drive);
      km_driver_motion_move_to(drive, at + 0.003 * length);
      km_driver_motion_move_to(drive, at - 0.004 * length);
      km_driver_motion_restore(drive);
    }
    if (row % 200 == 0)
      memcpy(row == 200 ? far : back, f.state->q, bytes);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

/* The minimum-norm path is a curve: the return ends at its start, within the step tolerance. Sampling leaves the
 * history of the next steps unchanged. */
static void least_motion_is_one_curve(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    if (has_one_freedom(*name))
      continue;
    fixture f = fixture_open(*name);
    double far[64], back[64], far_looked[64], back_looked[64];
    size_t count = (size_t)f.mechanism->coordinate_count;
    assert_true(count <= 64);
    go_and_return(*name, false, far, back);
    go_and_return(*name, true, far_looked, back_looked);
    assert_memory_equal(far, far_looked, count * sizeof *far);
    assert_memory_equal(back, back_looked, count * sizeof *back);
    for (size_t c = 0; c < count; ++c)
      assert_near(back[c], f.state->q[c], 2e-7 * f.mechanism->unit[c]);
    fixture_close(&f);
  }
}

/* The pose behind `rows` rows towards start + length. */
static void go(const char *name, double length, int rows, double *q) {
  fixture f = fixture_open(name);
  km_driver_motion *drive = NULL;
  int coordinate = km_sweep_plan_default(f.model).coordinate;
  double start = km_state_coordinate(f.state, coordinate);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, coordinate, true, &drive, NULL), KM_OK);
  for (int row = 1; row <= rows; ++row)
    assert_int_equal(km_driver_motion_move_to(drive, start + length * row / rows).stop, KM_STOP_NONE);
  memcpy(q, f.state->q, (size_t)f.mechanism->coordinate_count * sizeof *q);
  km_driver_motion_free(drive);
  fixture_close(&f);
}

static double apart(const double *a, const double *b, int count) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i)
    largest = fmax(largest, fabs(a[i] - b[i]));
  return largest;
}

/* Steps that go on from those before are of fourth order, in balls too: with twice as many rows the path is 16 times
 * as close to its limit; at least 10 times. */
static void least_motion_is_of_fourth_order(void **state) {
  (void)state;
  double limit[36], coarse[36], fine[36];
  go("stewart", 0.16, 640, limit);
  go("stewart", 0.16, 40, coarse);
  go("stewart", 0.16, 80, fine);
  assert_true(apart(fine, limit, 36) < 0.1 * apart(coarse, limit, 36));
}

static void the_way_back_is_the_way_there(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    if (!has_one_freedom(*name))
      continue;
    km_mobility_sweep there = run(*name, 40, 0.0, 1.0, false), back = run(*name, 40, 1.0, 0.0, false);
    for (size_t r = 0; r <= 40; ++r)
      for (size_t c = 1; c < km_table_columns(there.motion.table); ++c)
        assert_near(km_table_row(there.motion.table, r)[c], km_table_row(back.motion.table, 40 - r)[c], 1e-8);
    km_mobility_sweep_free(&there);
    km_mobility_sweep_free(&back);
  }
}

static void same_input_same_bits(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    km_mobility_sweep a = run(*name, 30, 0.2, 0.4, false), b = run(*name, 30, 0.2, 0.4, false);
    for (size_t r = 0; r < km_table_rows(a.motion.table); ++r)
      assert_memory_equal(km_table_row(a.motion.table, r), km_table_row(b.motion.table, r),
                          km_table_columns(a.motion.table) * sizeof(double));
    km_mobility_sweep_free(&a);
    km_mobility_sweep_free(&b);
  }
}

/* A four-bar whose crank can only rock: the ends are where coupler and rocker stretch, by the cosine rule. */
static void ends_are_located(void **state) {
  (void)state;
  static const char text[] =
      "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [4, 0, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "["
      "{\"name\": \"l\", \"frames\": [{\"name\": \"t\", \"T\": [3, 0, 0]}]}, {\"name\": \"c\", \"frames\": [{\"name\": "
      "\"t\", \"T\": [2, 0, 0]}]},"
      "{\"name\": \"r\", \"frames\": [{\"name\": \"t\", \"T\": [2.5, 0, 0]}]}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"l\"], \"initial_displacement\": 0.9%s},"
      "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l\", \"t\"], \"c\"], \"initial_displacement\": "
      "-1.0},"
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c\", \"t\"], [\"r\", \"t\"]], "
      "\"initial_displacement\": 2.0},"
      "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"r\"], "
      "\"initial_displacement\": 2.0}]}]}";
  char buffer[2048];
  for (int limited = 0; limited < 2; ++limited) {
    snprintf(buffer, sizeof buffer, text, limited ? ", \"limits\": [0.4, 1.1]" : "");
    fixture f = fixture_read(buffer);
    double stretched = acos((16.0 + 9.0 - 4.5 * 4.5) / 24.0);
    km_driver_motion *drive;
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
    km_motion_end reach = km_driver_motion_move_to(drive, 3.0);
    assert_int_equal(reach.stop, limited ? KM_STOP_LIMIT : KM_STOP_TOGGLE);
    assert_near(reach.position, limited ? fmin(1.1, stretched) : stretched, 1e-9);
    assert_int_equal(km_driver_motion_move_to(drive, 3.0).stop, reach.stop); /* no further the second time */
    reach = km_driver_motion_move_to(drive, 0.41);                           /* and back again */
    assert_int_equal(reach.stop, KM_STOP_NONE);
    assert_near(km_state_coordinate(f.state, 0), 0.41, 0.0);
    km_driver_motion_free(drive);
    fixture_close(&f);
  }
}

/* A parallelogram passes its change points as a parallelogram, also where a row stands exactly on one. */
static void parallelogram_stays_one(void **state) {
  (void)state;
  for (int steps = 30; steps < 40; ++steps) {
    fixture f = parallelogram(1.0);
    km_sweep_plan plan = {.coordinate = 0, .from = -2.0 * M_PI, .to = 2.0 * M_PI, .steps = steps};
    km_mobility_sweep sweep;
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
    int a = km_table_find(sweep.motion.table, "q.A"), d = km_table_find(sweep.motion.table, "q.D");
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
      assert_near(km_table_row(sweep.motion.table, r)[a], km_table_row(sweep.motion.table, r)[d], 1e-8);
    for (size_t i = 0; i < sweep.motion.branch_count; ++i) { /* events at the multiples of π */
      assert_near(remainder(sweep.motion.branches[i].s, M_PI), 0.0, 1e-8);
      assert_int_equal(sweep.motion.branches[i].mobility, 2);
      assert_int_equal(sweep.motion.branches[i].branches, 2);
    }
    assert_in_range(sweep.motion.branch_count, 3, 5); /* the range's ends are two of them */
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* A branch point with two branches: the sweep stays on one of them, forth and back. */
static void a_branch_point_can_be_the_start(void **state) {
  (void)state;
  fixture f = parallelogram(0.0);
  km_sweep_plan plan = {.coordinate = 0, .from = -1.0, .to = 1.0, .steps = 8};
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  assert_int_equal(sweep.motion.start_branches, 2);
  int a = km_table_find(sweep.motion.table, "q.A"), d = km_table_find(sweep.motion.table, "q.D");
  const double *first = km_table_row(sweep.motion.table, 0);
  bool parallel = fabs(first[a] - first[d]) < 1e-8;
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    const double *row = km_table_row(sweep.motion.table, r);
    /* crossed: tan(D/2) = (1 + 2)/(1 - 2) tan(A/2) = -3 tan(A/2) for links 1 and 2 */
    assert_near(parallel ? row[d] : tan(0.5 * row[d]), parallel ? row[a] : -3.0 * tan(0.5 * row[a]), 1e-8);
  }
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* The parallelogram's motion has A = D, B = -A, C = A: arc length 2|A|, round after 4π. */
static void arc_length_can_start_at_a_branch_point(void **state) {
  (void)state;
  fixture f = parallelogram(0.0);
  km_sweep_plan plan = {.coordinate = 0, .direction = 0, .sign = 1.0, .arclength = 0.1, .steps = 200, .cycle = true};
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  assert_int_equal(sweep.motion.start_branches, 2);
  int a = km_table_find(sweep.motion.table, "q.A"), d = km_table_find(sweep.motion.table, "q.D");
  const double *first = km_table_row(sweep.motion.table, 1);
  assert_near(first[a], 0.05, 1e-8); /* the crossed motion would move A less */
  assert_near(first[d], 0.05, 1e-8);
  assert_near(sweep.motion.cycle, 4.0 * M_PI, 1e-8);
  assert_int_equal(km_table_rows(sweep.motion.table), 126);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* Every row's numbers are those of its pose, the start's too, for which nothing has to move. */
static void numbers_belong_to_their_rows(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    for (int by_length = 0; by_length < 2; ++by_length) {
      fixture f = fixture_open(*name), at = fixture_open(*name);
      int count = km_model_coordinate_count(f.model);
      double *q = KM_NEW(double, (size_t)count);
      for (int c = 0; c < count; ++c)
        q[c] = km_state_coordinate(f.state, c) * km_model_coordinate_factor(f.model, c);
      q[count - 1] += 1e-10; /* the start's residual stays the start's */
      km_state_set(f.mechanism, f.state, q);
      double now = km_state_coordinate(f.state, 0);
      km_sweep_plan plan = {.coordinate = 0, .from = now, .to = now + 0.01, .steps = 2, .direction = -1, .sign = 1.0};
      plan.arclength = by_length ? 0.01 : 0.0;
      km_mobility_sweep sweep;
      km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL);
      assert_true(status == KM_OK || status == KM_PARTIAL);
      for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
        const double *row = km_table_row(sweep.motion.table, r);
        km_mobility mobility;
        for (int c = 0; c < count; ++c)
          q[c] = row[2 + c] * km_model_coordinate_factor(at.model, c);
        km_state_set(at.mechanism, at.state, q);
        km_mobility_compute(at.mechanism, at.state, &mobility);
        for (int c = 0; c < count; ++c) {
          char column[64];
          snprintf(column, sizeof column, "m.%s", km_model_coordinate_label(at.model, c));
          assert_near(row[km_table_find(sweep.motion.table, column)], km_mobility_number(at.state, c), 1e-7);
        }
        /* setting the pose again may round differently */
        assert_near(row[km_table_find(sweep.motion.table, "residual")], mobility.residual, 1e-15);
      }
      km_free(q);
      km_mobility_sweep_free(&sweep);
      fixture_close(&f);
      fixture_close(&at);
    }
  }
}

/* Points and their derivatives along the driver or the arc length, against the points of the rows on both sides: a
 * central difference errs by a third of its change when the step doubles. */
static void derivatives_are_those_of_the_rows(void **state) {
  (void)state;
  static const char *const names[] = {"fourbar", "klann", "excavator", "toggle_press", "brake"};
  for (size_t n = 0; n < 2 * sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n / 2]);
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_sweep_point points[2] = {{f.model->frame_count - 1, "last"}, {f.model->frame_count / 2, "middle"}};
    km_mobility_sweep sweep;
    km_error error = {0};
    plan.points = points;
    plan.point_count = 2;
    plan.derivatives = true;
    plan.steps = 400;
    if (n % 2) {
      plan.arclength = 1e-3;
      plan.sign = 1.0;
    }
    km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error);
    assert_true(status == KM_OK || status == KM_PARTIAL);
    const km_table *table = sweep.motion.table;
    size_t first = km_table_span(table, "point.").first;
    assert_int_equal(km_table_span(table, "point.").count, 12);
    double largest = 0.0;
    for (size_t r = 0; r < km_table_rows(table); ++r)
      for (size_t c = 0; c < 12; ++c)
        largest = fmax(largest, fabs(km_table_row(table, r)[first + c]));
    int judged = 0;
    for (size_t r = 2; r + 3 < km_table_rows(table); ++r)
      for (size_t c = 0; c < 12; ++c) {
        size_t place = first + (c < 6 ? 0 : 6) + c % 3;
        const double *row[5];
        for (size_t k = 0; k < 5; ++k)
          row[k] = km_table_row(table, r - 2 + k);
        double near = (row[3][place] - row[1][place]) / (row[3][1] - row[1][1]);
        double far = (row[4][place] - row[0][place]) / (row[4][1] - row[0][1]);
        double rest = 1e-5 * largest; /* next order, which remains if the first vanishes */
        if (fabs(far - near) > 1e-2 * largest)
          continue; /* next to a turning point of the driver */
        assert_near(near, row[2][place + 3], fabs(far - near) + rest);
        judged += fabs(near) > 1e-3 * largest;
      }
    assert_true(judged > 200);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static bool cancel(void *context, double done) {
  (void)done;
  return --*(int *)context > 0;
}

static void a_sweep_can_be_cancelled(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  int left = 5;
  plan.progress = cancel;
  plan.context = &left;
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_CANCELLED);
  assert_true(km_table_rows(sweep.motion.table) < 10);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

static void ends_do_not_depend_on_steps(void **state) {
  (void)state;
  static const uint64_t seeds[] = {1795710037, 1795710151, 1795710519, /* more motions than rows */
                                   7800, 910078}; /* a step that missed its target by rounding spoiled the next one */
  for (uint64_t seed = 1; seed <= 60; ++seed)
    assert_true(family_least_path(seed));
  for (size_t i = 0; i < sizeof seeds / sizeof *seeds; ++i)
    assert_true(family_least_path(seeds[i]));
}

static void rows_are_within_limits(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 300; ++seed)
    assert_true(family_limits(seed));
}

/* A bar between two slides, at right angles to both: a branch point, where a sweep looks for the motion that moves its
 * driver most. */
static void a_held_driver_is_refused(void **unused) {
  (void)unused;
  fixture f = fixture_read(
      "{\"fixed\": {\"frames\": [{\"name\": \"right\", \"T\": [1, 0, 0]}]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": "
      "[{\"name\": \"a\"}, {\"name\": \"b\"}, {\"name\": \"bar\", \"frames\": [{\"name\": \"end\", \"T\": [1, 0, 0]}]}], "
      "\"joints\": [{\"name\": \"A\", \"type\": \"Tz\", \"body_frame_pairs\": [[\"fixed\"], [\"a\"]]}, "
      "{\"name\": \"B\", \"type\": \"Tz\", \"body_frame_pairs\": [[\"fixed\", \"right\"], [\"b\"]]}, "
      "{\"name\": \"P\", \"type\": \"spherical\", \"body_frame_pairs\": [[\"a\"], [\"bar\"]]}, "
      "{\"name\": \"R\", \"type\": \"spherical\", \"body_frame_pairs\": [[\"b\"], [\"bar\", \"end\"]]}]}]}");
  km_mechanism *mechanism;
  km_state *state;
  km_hold hold = {0, 0.0};
  km_mobility_sweep sweep = {0};
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.coordinate = 0;
  assert_int_equal(km_mechanism_compile(f.model, &hold, 1, &mechanism, NULL), KM_OK);
  assert_int_equal(km_state_create(mechanism, &state, NULL), KM_OK);
  assert_int_equal(km_assemble(mechanism, state, NULL, NULL), KM_OK);
  assert_int_equal(km_mobility_sweep_run(mechanism, state, &plan, &sweep, NULL), KM_USAGE);
  km_mobility_sweep_free(&sweep);
  km_state_free(state);
  km_mechanism_free(mechanism);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_held_driver_is_refused),
      cmocka_unit_test(rows_do_not_depend_on_steps),
      cmocka_unit_test(least_motion_converges),
      cmocka_unit_test(least_motion_is_one_curve),
      cmocka_unit_test(least_motion_is_of_fourth_order),
      cmocka_unit_test(the_way_back_is_the_way_there),
      cmocka_unit_test(same_input_same_bits),
      cmocka_unit_test(ends_are_located),
      cmocka_unit_test(parallelogram_stays_one),
      cmocka_unit_test(numbers_belong_to_their_rows),
      cmocka_unit_test(a_branch_point_can_be_the_start),
      cmocka_unit_test(arc_length_can_start_at_a_branch_point),
      cmocka_unit_test(ends_do_not_depend_on_steps),
      cmocka_unit_test(rows_are_within_limits),
      cmocka_unit_test(a_sweep_can_be_cancelled),
      cmocka_unit_test(derivatives_are_those_of_the_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
