/* Following by arc length: cycles close, branch points are where they are known to be. */
#include "support/support.h"

#include "kmech/continuation.h"
#include "model/model.h"
#include "report/record/record.h"
#include "report/record/sweep_text.h"

#include <string.h>

static km_mobility_sweep follow(fixture *f, double length, int steps, bool cycle) {
  km_sweep_plan plan = {
      .coordinate = -1, .steps = steps, .arclength = length, .direction = -1, .sign = 1.0, .cycle = cycle};
  km_mobility_sweep sweep;
  km_error error = {0};
  km_status status = km_mobility_sweep_run(f->mechanism, f->state, &plan, &sweep, &error);
  if (status)
    fail_msg("%d %s", status, error.text);
  return sweep;
}

/* After the cycle every joint is where it was, up to full turns. */
static void cycles_close(void **state) {
  (void)state;
  static const char *const names[] = {"fourbar", "slider_crank", "bricard", "klann", "bennett", NULL};
  for (const char *const *name = names; *name; ++name) {
    fixture f = fixture_open(*name);
    km_mobility_sweep sweep = follow(&f, 0.05, 2000, true);
    assert_true(sweep.motion.cycle > 1.0);
    const double *first = km_table_row(sweep.motion.table, 0);
    for (int c = 0; c < f.model->coordinate_count; ++c) {
      double way = km_state_coordinate(f.state, c) - first[2 + c];
      if (strcmp(km_model_coordinate_unit(f.model, c), "rad") == 0)
        way -= 2.0 * M_PI * round(way / (2.0 * M_PI));
      assert_near(way, 0.0, 1e-9);
    }
    int residual = km_table_find(sweep.motion.table, "residual");
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
      assert_true(km_table_row(sweep.motion.table, r)[residual] <= 1e-12);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* Five held legs of a Stewart platform leave one freedom with a long cycle. Ball joints may return with other
 * rotation vectors, so bodies are compared. */
static void a_held_platform_comes_back(void **state) {
  (void)state;
  fixture f = fixture_open("stewart");
  km_hold holds[5];
  for (int i = 0; i < 5; ++i) {
    char leg[] = {'P', (char)('2' + i), 0};
    km_error error;
    assert_int_equal(km_model_find_coordinate(f.model, leg, &holds[i].coordinate, &error), KM_OK);
    holds[i].value = f.model->coordinates[holds[i].coordinate].position;
  }
  km_mechanism *mechanism;
  km_state *held;
  km_mobility_sweep sweep;
  km_error error;
  assert_int_equal(km_mechanism_compile_at(f.model, holds, 5, NULL, 0, &mechanism, &held, &error), KM_OK);
  km_sweep_plan plan = {.coordinate = -1, .steps = 2000, .arclength = 0.05, .direction = -1, .sign = 1.0};
  plan.cycle = plan.ignore_limits = true;
  size_t size = (size_t)f.model->body_count * sizeof(km_pose);
  km_pose *before = KM_NEW(km_pose, (size_t)f.model->body_count);
  km_poses_compute(mechanism, held);
  memcpy(before, held->pose, size);
  assert_int_equal(km_mobility_sweep_run(mechanism, held, &plan, &sweep, &error), KM_OK);
  assert_true(sweep.motion.cycle > 10.0);
  km_poses_compute(mechanism, held);
  for (int b = 1; b < f.model->body_count; ++b) {
    assert_near(km_vec3_norm(km_vec3_sub(held->pose[b].p, before[b].p)), 0.0, 1e-9);
    for (int k = 0; k < 3; ++k)
      assert_near(km_vec3_norm(km_vec3_sub(held->pose[b].R.axis[k], before[b].R.axis[k])), 0.0, 1e-9);
  }
  km_free(before);
  km_mobility_sweep_free(&sweep);
  km_state_free(held);
  km_mechanism_free(mechanism);
  fixture_close(&f);
}

/* The length of a cycle doesn't depend on the rows that it is cut into. */
static void length_is_a_property_of_the_motion(void **state) {
  (void)state;
  static const double steps[] = {0.02, 0.05, 0.13, 0.5};
  double length = 0.0;
  for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
    fixture f = fixture_open("fourbar");
    km_mobility_sweep sweep = follow(&f, steps[i], 2000, true);
    if (i == 0)
      length = sweep.motion.cycle;
    assert_near(sweep.motion.cycle, length, 1e-6 * length);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* A parallelogram with links 2 and 1, driven at `angle`: A = D = θ, B = -θ, C = θ; each turns at the same rate, so
 * that the arc is 2θ, and the branch points stand at θ = π and 2π. */
static void parallelogram_branches(void **state) {
  (void)state;
  fixture f = parallelogram(1.0);
  km_mobility_sweep sweep = follow(&f, 0.1, 1000, true);
  assert_near(sweep.motion.cycle, 4.0 * M_PI, 1e-9);
  assert_int_equal(sweep.motion.branch_count, 2);
  assert_near(sweep.motion.branches[0].s, 2.0 * (M_PI - 1.0), 1e-8);
  assert_near(sweep.motion.branches[1].s, 2.0 * (2.0 * M_PI - 1.0), 1e-8);
  assert_int_equal(sweep.motion.branches[0].mobility, 2);
  assert_int_equal(sweep.motion.branches[0].branches, 2);
  int a = km_table_find(sweep.motion.table, "q.A"), d = km_table_find(sweep.motion.table, "q.D");
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
    assert_near(km_table_row(sweep.motion.table, r)[a], km_table_row(sweep.motion.table, r)[d], 1e-8);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* If the directions of the branches aren't found, their number isn't stated. */
static void motions_not_found(void **state) {
  (void)state;
  fixture f = parallelogram(1.0);
  km_sweep_plan plan = {.coordinate = -1, .steps = 60, .arclength = 0.1, .direction = -1, .sign = 1.0, .branch = 1};
  km_mobility_sweep sweep = follow(&f, 0.1, 60, false);
  km_text text = {0};
  km_arena arena = {0};
  km_value *record = km_value_add(&arena, NULL, NULL, KM_OBJECT);
  assert_int_equal(sweep.motion.branch_count, 1);
  sweep.motion.branches[0].branches = 0;
  km_sweep_print(f.mechanism, &plan, &sweep.motion, "a parallelogram", &text);
  assert_non_null(strstr(text.data,
                         "branch point at 4.28318531: mobility 2 there, the motions that meet weren't found; "
                         "the smooth one was followed\n"));
  km_sweep_record(&sweep.motion, "", record, &arena);
  const km_value *branch = km_value_get(record, "branch_points")->first;
  assert_int_equal(km_value_get(branch, "branches")->kind, KM_NULL);
  km_arena_free(&arena);
  km_text_free(&text);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* The other motion of the parallelogram: the rocker's tip is that of the parallel pose, reflected in the line from
 * the crank's tip to the rocker's pivot. Motion 2 goes it ahead, 3 back; 1 stays parallel, and a fourth isn't there. */
static void parallelogram_turns_where_asked(void **state) {
  (void)state;
  enum { STEPS = 60 };
  double last[4] = {0};
  for (int branch = 1; branch <= 4; ++branch) {
    fixture f = parallelogram(1.0);
    km_mobility_sweep sweep;
    km_error error;
    km_sweep_plan plan = {
        .coordinate = -1, .steps = STEPS, .arclength = 0.1, .direction = -1, .sign = 1.0, .branch = branch};
    km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error);
    assert_int_equal(status, branch < 4 ? KM_OK : KM_USAGE);
    if (status)
      assert_non_null(strstr(error.text, "branch 4: 2 motions meet at 4.28318531; expected at most 3"));
    double corner = 2.0 * (M_PI - 1.0);
    for (size_t r = 0; !status && r < km_table_rows(sweep.motion.table); ++r) {
      const double *row = km_table_row(sweep.motion.table, r);
      double a = row[km_table_find(sweep.motion.table, "q.A")], d = row[km_table_find(sweep.motion.table, "q.D")];
      double ux = 2.0 - cos(a), uy = -sin(a), along = 2.0 * 2.0 * ux / (ux * ux + uy * uy);
      bool parallel = branch == 1 || row[1] < corner; /* else Q = P + 2 (v·u) u / u² − v, v = (2, 0) */
      assert_near(cos(d), parallel ? cos(a) : cos(a) + along * ux - 2.0 - 2.0, 1e-8);
      assert_near(sin(d), parallel ? sin(a) : sin(a) + along * uy, 1e-8);
      last[branch - 1] = a;
    }
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
  assert_near(last[0], 1.0 + 0.05 * STEPS, 1e-9);
  assert_near(last[1] - M_PI, M_PI - last[2], 1e-8); /* ahead as far as back */
  assert_true(fabs(last[1] - M_PI) > 0.1);
}

/* The drivers' toggles don't stop it: the four-bar of test_sweep whose crank can only rock goes round its cycle. */
static void toggles_are_passed(void **state) {
  (void)state;
  fixture f = fixture_open("slider_crank");
  km_mobility_sweep sweep = follow(&f, 0.05, 2000, true);
  int slider = 0, rod = 0;
  for (size_t i = 0; i < sweep.toggle_count; ++i) {
    const char *label = km_model_coordinate_label(f.model, sweep.toggles[i].coordinate);
    slider += strcmp(label, "B") == 0;
    rod += strcmp(label, "C") == 0;
  }
  assert_int_equal(slider, 2);
  assert_int_equal(rod, 2);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* Two freedoms, in many small steps as in few: the freedoms that the predictor decides don't drift off. */
static void small_steps_with_two_freedoms(void **state) {
  (void)state;
  static const double steps[] = {0.001, 0.01, 0.1};
  double end[3];
  for (int i = 0; i < 3; ++i) {
    fixture f = fixture_read(
        "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [2, 0, 0]}]}, \"assemblies\": [{\"name\": \"a\", "
        "\"bodies\": ["
        "{\"name\": \"b1\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]},"
        "{\"name\": \"b2\", \"frames\": [{\"name\": \"t\", \"T\": [1.2, 0, 0]}]},"
        "{\"name\": \"b3\", \"frames\": [{\"name\": \"t\", \"T\": [1.2, 0, 0]}]},"
        "{\"name\": \"b4\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}], \"joints\": ["
        "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b1\"], \"initial_displacement\": 1.8},"
        "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b1\", \"t\"], \"b2\"], "
        "\"initial_displacement\": -1.3},"
        "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b2\", \"t\"], [\"b3\", \"t\"]], "
        "\"initial_displacement\": 2.1},"
        "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b4\", \"t\"], \"b3\"], "
        "\"initial_displacement\": 1.3},"
        "{\"name\": \"E\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"b4\"], "
        "\"initial_displacement\": "
        "1.3}]}]}");
    km_mobility_sweep sweep = follow(&f, steps[i], (int)(0.5 / steps[i] + 0.5), false);
    assert_int_equal(sweep.motion.freedom, 2);
    assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
    end[i] = km_state_coordinate(f.state, 0);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
  /* Adams-Bashforth's second errs by the square of its steps. */
  assert_near(end[1], end[0], 1e-3);
  assert_near(end[2], end[0], 2e-2);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(cycles_close),
                                     cmocka_unit_test(a_held_platform_comes_back),
                                     cmocka_unit_test(length_is_a_property_of_the_motion),
                                     cmocka_unit_test(parallelogram_branches),
                                     cmocka_unit_test(motions_not_found),
                                     cmocka_unit_test(parallelogram_turns_where_asked),
                                     cmocka_unit_test(toggles_are_passed),
                                     cmocka_unit_test(small_steps_with_two_freedoms)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
