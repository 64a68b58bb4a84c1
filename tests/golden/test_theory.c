/* Known answers of theory.md 5 over whole motions. */
#include "support/support.h"

#include "model/model.h"

#include <stdio.h>
#include <string.h>

static km_mobility_sweep sweep_of(fixture *f, const char *joint, double from, double to, int steps) {
  km_sweep_plan plan = {.from = from, .to = to, .steps = steps};
  km_mobility_sweep sweep;
  km_error error = {0};
  assert_int_equal(km_model_find_coordinate(f->model, joint, &plan.coordinate, &error), KM_OK);
  km_status status = km_mobility_sweep_run(f->mechanism, f->state, &plan, &sweep, &error);
  if (status && status != KM_PARTIAL)
    fail_msg("%s", error.text);
  return sweep;
}

static double cell(const km_mobility_sweep *sweep, size_t row, const char *column) {
  int index = km_table_find(sweep->motion.table, column);
  assert_true(index >= 0);
  return km_table_row(sweep->motion.table, row)[index];
}

/* All coordinates in the plane by a Rz chain: crank `alpha`, rod 1, slider along x. */
static fixture slider_crank(double alpha, double theta) {
  static const char text[] =
      "{\"fixed\": {\"frames\": [{\"name\": \"slide\", \"R\": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}]},"
      " \"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "  {\"name\": \"crank\", \"frames\": [{\"name\": \"tip\", \"T\": [%.17g, 0, 0]}]},"
      "  {\"name\": \"rod\", \"frames\": [{\"name\": \"tip\", \"T\": [1, 0, 0]}]}, {\"name\": \"piston\", \"frames\": "
      "[{\"name\": \"pin\", \"R\": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}]}],"
      " \"joints\": ["
      "  {\"name\": \"t1\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\"], [\"crank\"]], "
      "\"initial_displacement\": %.17g},"
      "  {\"name\": \"t2\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"tip\"], [\"rod\"]], "
      "\"initial_displacement\": %.17g},"
      "  {\"name\": \"t3\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"rod\", \"tip\"], [\"piston\"]], "
      "\"initial_displacement\": %.17g},"
      "  {\"name\": \"x\", \"type\": \"Tz\", \"body_frame_pairs\": [[\"fixed\", \"slide\"], [\"piston\", \"pin\"]], "
      "\"initial_displacement\": %.17g}]}]}";
  char buffer[2048];
  double beta = -asin(alpha * sin(theta)); /* the rod's angle */
  snprintf(buffer, sizeof buffer, text, alpha, theta, beta - theta, -beta, alpha * cos(theta) + cos(beta));
  return fixture_read(buffer);
}

/* x = α cos θ + cos β, sin β = −α sin θ; rates per θ̇ = 1. */
static void slider_crank_closed_form(void **state) {
  (void)state;
  static const double alphas[] = {0.001, 0.1, 0.5, 0.9, 0.99};
  for (size_t i = 0; i < sizeof alphas / sizeof *alphas; ++i) {
    double alpha = alphas[i];
    fixture f = slider_crank(alpha, 0.3);
    km_mobility_sweep sweep = sweep_of(&f, "t1", 0.0, 2.0 * M_PI, 360);
    assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
      double theta = cell(&sweep, r, "s"), sine = alpha * sin(theta), cosine = sqrt(1.0 - sine * sine);
      double beta_rate = -alpha * cos(theta) / cosine;
      double rates[4] = {1.0, beta_rate - 1.0, -beta_rate, -alpha * sin(theta) + beta_rate * sine}, sum = 0.0;
      for (int k = 0; k < 4; ++k)
        sum += rates[k] * rates[k];
      static const char *const columns[4] = {"m.t1", "m.t2", "m.t3", "m.x"};
      for (int k = 0; k < 4; ++k)
        assert_near(cell(&sweep, r, columns[k]), rates[k] * rates[k] / sum, 1e-9);
      assert_true(cell(&sweep, r, "residual") <= 1e-12);
    }
    assert_near(cell(&sweep, 0, "m.x"), 0.0, 1e-12); /* both dead centres */
    assert_near(cell(&sweep, 180, "m.x"), 0.0, 1e-12);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* α > 1: the crank can't turn round; its end is where the rod stands across the slide: sin θ = 1/α. */
static void long_crank_stops_where_it_must(void **state) {
  (void)state;
  static const double alphas[] = {1.0001, 1.2, 2.0, 10.0};
  for (size_t i = 0; i < sizeof alphas / sizeof *alphas; ++i) {
    fixture f = slider_crank(alphas[i], 0.05);
    km_mobility_sweep sweep = sweep_of(&f, "t1", 0.0, 2.0, 50);
    assert_int_equal(sweep.motion.end.stop, KM_STOP_TOGGLE);
    assert_near(sweep.motion.end.position, asin(1.0 / alphas[i]), 1e-9);
    assert_near(cell(&sweep, km_table_rows(sweep.motion.table) - 1, "m.t1"), 0.0, 1e-4);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* α = 1: at θ = π/2 the slider stands on the crank's axis and two motions branch; the sweep goes on smoothly. */
static void equal_crank_passes_its_branch_point(void **state) {
  (void)state;
  for (int steps = 100; steps <= 102; ++steps) { /* 100 lands on the branch points, the others between */
    fixture f = slider_crank(1.0, 0.3);
    km_mobility_sweep sweep = sweep_of(&f, "t1", 0.0, 2.0 * M_PI, steps);
    assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
      double theta = cell(&sweep, r, "s");
      assert_near(cell(&sweep, r, "q.x"), 2.0 * cos(theta), 1e-8);
      assert_true(cell(&sweep, r, "residual") <= 1e-12);
    }
    if (steps == 100)
      assert_near(cell(&sweep, 25, "dof"), 2.0, 0.0);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static void sarrus_numbers_are_constant(void **state) {
  (void)state;
  for (int legs = 3; legs <= 4; ++legs) {
    fixture f = fixture_open(legs == 3 ? "sarrus3" : "sarrus4");
    km_mobility_sweep sweep = sweep_of(&f, "B", -2.8, -0.3, 60);
    assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
      for (int j = 0; j < f.model->joint_count; ++j) {
        char column[16];
        snprintf(column, sizeof column, "m.%s", f.model->joints[j].label);
        double outer = 1.0 / (6.0 * legs);
        assert_near(cell(&sweep, r, column), j % 3 == 1 ? 4.0 * outer : outer, 1e-9);
      }
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* 1/6 each in the square pose; 0 and 1/3 alternating in the planar triangles; M = 1 throughout. */
static void bricard_square_and_triangle(void **state) {
  (void)state;
  fixture f = fixture_open("bricard");
  km_mobility_sweep sweep = sweep_of(&f, "B", -2.0, 2.0, 80);
  assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
  double nearest = 1.0;
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    assert_near(cell(&sweep, r, "dof"), 1.0, 0.0);
    assert_near(cell(&sweep, r, "m.A"), cell(&sweep, r, "m.C"), 1e-10);
    assert_near(cell(&sweep, r, "m.B"), cell(&sweep, r, "m.D"), 1e-10);
    nearest = fmin(nearest, fabs(cell(&sweep, r, "m.A") - 1.0 / 6.0));
  }
  assert_near(cell(&sweep, 40, "m.A"), 0.0, 1e-9);
  assert_near(cell(&sweep, 40, "m.B"), 1.0 / 3.0, 1e-9);
  assert_true(nearest < 0.01); /* the square pose lies between two rows */
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* Crank A and the joint D at its far end have no dead point; every other joint has one. */
static void klann_turns_round_on_one_branch(void **state) {
  (void)state;
  fixture f = fixture_open("klann");
  km_mobility_sweep sweep = sweep_of(&f, "A", 0.0, 2.0 * M_PI, 240);
  assert_int_equal(sweep.motion.end.stop, KM_STOP_NONE);
  for (int c = 0; c < f.model->coordinate_count; ++c) {
    const char *label = f.model->coordinates[c].label;
    char column[16];
    snprintf(column, sizeof column, "q.%s", label);
    double turns = strcmp(label, "A") == 0 ? 1.0 : strcmp(label, "D") == 0 ? -1.0 : 0.0;
    assert_near(cell(&sweep, 240, column) - cell(&sweep, 0, column), turns * 2.0 * M_PI, 1e-9);
    size_t toggles = 0;
    for (size_t i = 0; i < sweep.toggle_count; ++i)
      toggles += sweep.toggles[i].coordinate == c;
    assert_int_equal(toggles == 0, turns != 0.0);
  }
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    assert_true(cell(&sweep, r, "residual") <= 1e-12);
    assert_true(cell(&sweep, r, "m.A") > 0.05 && cell(&sweep, r, "m.D") > 0.05);
  }
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

static void excavator_twins_are_equal(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  km_mobility_sweep sweep = sweep_of(&f, "M", 1.9, 3.0, 40);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r) {
    assert_near(cell(&sweep, r, "m.L"), cell(&sweep, r, "m.M"), 1e-10);
    assert_near(cell(&sweep, r, "m.H"), cell(&sweep, r, "m.I"), 1e-10);
    assert_near(cell(&sweep, r, "m.B"), 1.0, 0.0);
    assert_near(cell(&sweep, r, "m.A"), 0.0, 0.0);
  }
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(slider_crank_closed_form,
                 "All mobility numbers of slider-cranks with α = 0.001 to 0.99 over a turn, in closed form",
                 "the loops are closed to 1e-12, over the least squared rate"),
      claim_test(long_crank_stops_where_it_must, "A crank longer than the rod turns to asin(1/α), α = 1.0001 to 10",
                 "ends of sweeps are located to 1e-9"),
      claim_test(equal_crank_passes_its_branch_point, "A crank as long as the rod passes its branch point: x = 2 cos θ",
                 "the root of what the loops are closed to, at the branch point"),
      claim_test(sarrus_numbers_are_constant,
                 "Sarrus: 1/18 and 2/9 with three legs, 1/24 and 1/6 with four, at every height (thesis 10.2.1)",
                 "the loops are closed to 1e-12, over the least pivot"),
      claim_test(bricard_square_and_triangle,
                 "Bricard: 0 and 1/3 alternating in the planar triangle, one freedom throughout (thesis 10.1.2)",
                 "the loops are closed to 1e-12, over the least pivot"),
      claim_test(klann_turns_round_on_one_branch, "Klann's leg closes its cycle on one branch",
                 "the loops are closed to 1e-12, over the least pivot"),
      claim_test(excavator_twins_are_equal,
                 "The twin cylinders of the excavator's boom have equal numbers (thesis 10.3)", "rounding"),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
