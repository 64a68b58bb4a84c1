/* Toggles, balances and peaks of sweeps against closed forms, however coarse the rows. */
#include "support/support.h"

#include "kmech/sweep.h"

#include <math.h>

/* models/fourbar: crank 0.15, coupler 0.5, rocker 0.45, ground 0.4. Its rocker turns round where crank and coupler are
 * in line, stretched or folded. */
static void dead_centres(double out[2]) {
  double ground = 0.4, crank = 0.15, coupler = 0.5, rocker = 0.45;
  for (int k = 0; k < 2; ++k) {
    double line = k ? coupler - crank : coupler + crank;
    double angle = acos((ground * ground + line * line - rocker * rocker) / (2.0 * ground * line));
    out[k] = k ? M_PI + angle : angle;
  }
}

static km_advantage_sweep lever(fixture *f, int input, int output, km_sweep_plan plan) {
  km_port in = {.kind = KM_PORT_JOINT, .coordinate = input, .name = "in"},
          out = {.kind = KM_PORT_JOINT, .coordinate = output, .name = "out"};
  km_advantage_sweep sweep;
  km_error error;
  if (km_advantage_sweep_run(f->mechanism, f->state, &plan, &in, &out, false, &sweep, &error))
    fail_msg("%s", error.text);
  return sweep;
}

static void toggles_are_located(void **state) {
  (void)state;
  static const int steps[] = {3, 17, 200};
  double centre[2];
  dead_centres(centre);
  for (int i = 0; i < 3; ++i) {
    for (int swapped = 0; swapped < 2; ++swapped) {
      fixture f = fixture_open("fourbar");
      km_sweep_plan plan = km_sweep_plan_default(f.model);
      plan.steps = steps[i];
      km_advantage_sweep sweep = lever(&f, swapped ? 3 : 0, swapped ? 0 : 3, plan);
      assert_int_equal(sweep.toggle_count, 2);
      for (int k = 0; k < 2; ++k) {
        assert_int_equal(sweep.toggles[k].state, swapped ? KM_ADVANTAGE_ZERO : KM_ADVANTAGE_INFINITE);
        assert_near(sweep.toggles[k].s, centre[k], 1e-9);
      }
      assert_int_equal(isfinite(sweep.lowest.value), swapped);
      km_advantage_sweep_free(&sweep);
      fixture_close(&f);
    }
  }
}

/* By arc length, with rows far apart: the toggles are those of the driven sweep. */
static void toggles_by_arc_length(void **state) {
  (void)state;
  double centre[2];
  dead_centres(centre);
  for (int coarse = 0; coarse < 2; ++coarse) {
    fixture f = fixture_open("fourbar"), at = fixture_open("fourbar");
    km_sweep_plan plan = {
        .coordinate = -1, .direction = 0, .sign = 1.0, .arclength = coarse ? 0.4 : 0.03, .steps = coarse ? 30 : 400};
    km_advantage_sweep sweep = lever(&f, 0, 3, plan);
    assert_in_range(sweep.toggle_count, 2, 4);
    for (size_t i = 0; i < sweep.toggle_count; ++i) {
      /* moves to the crank's position by arc length */
      km_arc_motion *follow;
      assert_int_equal(km_arc_motion_create(at.mechanism, at.state, 0, 1.0, false, &follow, NULL), KM_OK);
      assert_int_equal(km_arc_motion_advance(follow, sweep.toggles[i].s), KM_OK);
      double crank = fmod(km_state_coordinate(at.state, 0), 2.0 * M_PI);
      km_arc_motion_free(follow);
      assert_near(fmin(fabs(crank - centre[0]), fabs(crank - centre[1])), 0.0, 1e-7);
      fixture_close(&at);
      at = fixture_open("fourbar");
    }
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
    fixture_close(&at);
  }
}

/* A parallelogram's cranks turn alike, also at its change points, where for an instant there are two freedoms: the
 * motion that is followed counts. */
static void through_change_points(void **state) {
  (void)state;
  for (int by_length = 0; by_length < 2; ++by_length) {
    fixture f = parallelogram(0.3);
    km_sweep_plan plan = {
        .coordinate = 0, .from = -2.0 * M_PI, .to = 2.0 * M_PI, .steps = 8, .direction = 0, .sign = 1.0};
    if (by_length) {
      plan.arclength = 0.25;
      plan.steps = 60;
    }
    km_advantage_sweep sweep = lever(&f, 0, 3, plan);
    assert_int_equal(sweep.toggle_count, 0);
    for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
      assert_near(km_table_row(sweep.motion.table, r)[sweep.column], 1.0, 1e-8);
    assert_near(sweep.lowest.value, 1.0, 1e-8);
    assert_near(sweep.highest.value, 1.0, 1e-8);
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static size_t count(const km_statics_sweep *s, km_force_event_kind kind) {
  size_t found = 0;
  for (size_t i = 0; i < s->event_count; ++i)
    found += s->events[i].kind == kind;
  return found;
}

/* Slider-crank with a force F on the piston, no weights: the crank holds −F · dx/dθ, nothing at the dead centres, most
 * where d²x/dθ² = 0; the piston's own actuator holds F all the way. */
static void balances_and_peaks(void **state) {
  (void)state;
  static const int steps[] = {5, 90};
  static const double weightless[3] = {0, 0, 0};
  for (int i = 0; i < 2; ++i) {
    fixture f = fixture_open("slider_crank");
    km_sweep_plan plan = {.coordinate = 0, .from = 0.3, .to = 6.5, .steps = steps[i]};
    int crank = 0;
    km_load load = {f.model->joints[1].frame[1], {0, -50.0, 0}, {0, 0, 0}, false, NULL};
    km_forces *forces;
    km_statics statics;
    km_statics_sweep sweep;
    assert_int_equal(km_forces_create(f.mechanism, weightless, &load, 1, &forces, NULL), KM_OK);
    assert_int_equal(km_statics_create(f.mechanism, &crank, 1, KM_AXES_JOINT, &statics, NULL), KM_OK);
    assert_int_equal(km_statics_sweep_run(f.mechanism, f.state, &plan, forces, &statics, &sweep, NULL), KM_OK);
    assert_int_equal(count(&sweep, KM_FORCE_BALANCED), 2);
    assert_int_equal(count(&sweep, KM_FORCE_PEAK), 2);
    assert_int_equal(count(&sweep, KM_FORCE_UNBOUNDED), 0);
    for (size_t e = 0; e < sweep.event_count; ++e) {
      double s = sweep.events[e].s, sine = 0.6 * sin(s), root = sqrt(1.5 * 1.5 - sine * sine);
      if (sweep.events[e].kind == KM_FORCE_BALANCED)
        assert_near(remainder(s, M_PI), 0.0, 1e-9);
      else /* d²x/dθ² of x = 0.6 cos θ + root */
        assert_near(-0.6 * cos(s) - 0.36 * (cos(2.0 * s) / root + sine * sine * cos(s) * cos(s) / pow(root, 3)), 0.0,
                    1e-6);
    }
    km_statics_sweep_free(&sweep);
    km_statics_free(&statics);
    km_forces_free(forces);
    fixture_close(&f);
  }
}

/* An actuator at the rocker: no force is enough where the rocker turns round. */
static void forces_without_bound(void **state) {
  (void)state;
  double centre[2];
  dead_centres(centre);
  fixture f = fixture_open("fourbar");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  int rocker = 3;
  km_forces *forces;
  km_statics statics;
  km_statics_sweep sweep;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(f.mechanism, &rocker, 1, KM_AXES_JOINT, &statics, NULL), KM_OK);
  assert_int_equal(km_statics_sweep_run(f.mechanism, f.state, &plan, forces, &statics, &sweep, NULL), KM_OK);
  assert_int_equal(count(&sweep, KM_FORCE_UNBOUNDED), 2);
  for (size_t e = 0, k = 0; e < sweep.event_count; ++e)
    if (sweep.events[e].kind == KM_FORCE_UNBOUNDED)
      assert_near(sweep.events[e].s, centre[k++], 1e-8);
  km_statics_sweep_free(&sweep);
  km_statics_free(&statics);
  km_forces_free(forces);
  fixture_close(&f);
}

/* A four-bar whose rocker could slide along its hinge, if the loop let it. */
static fixture sliding_rocker(void) {
  return fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"crank\", \"mass\": 1}, "
      "{\"name\": \"coupler\", \"mass\": 2}, {\"name\": \"rocker\", \"mass\": 1}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"crank\"], \"at\": [0.73, -0.64]}, "
      "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"crank\", \"coupler\"], \"at\": [0.73, -0.49]}, "
      "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"coupler\", \"rocker\"], \"at\": [1.2, -0.2]}, "
      "{\"name\": \"D\", \"type\": \"cylindrical\", \"bodies\": [\"fixed\", \"rocker\"], \"at\": [1.13, -0.64], \"axis\": [0, 0, 1]}]}]}");
}

/* The slide stands: it holds nothing, also where no torque of the hinge is enough. */
static void what_stands_holds_nothing(void **state) {
  (void)state;
  fixture f = sliding_rocker();
  const km_sweep_plan plan = {.coordinate = 0, .from = 0.0, .to = 6.5, .steps = 50};
  const int rocker[2] = {3, 4};
  km_forces *forces;
  km_statics statics;
  km_statics_sweep sweep;
  assert_string_equal(f.model->coordinates[3].label, "D[0]");
  assert_int_equal(km_forces_create(f.mechanism, (double[3]){2.0, -9.81, 5.0}, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(f.mechanism, rocker, 2, KM_AXES_JOINT, &statics, NULL), KM_OK);
  assert_int_equal(km_statics_sweep_run(f.mechanism, f.state, &plan, forces, &statics, &sweep, NULL), KM_OK);
  assert_true(count(&sweep, KM_FORCE_UNBOUNDED) >= 2);
  for (size_t e = 0; e < sweep.event_count; ++e)
    assert_int_equal(sweep.events[e].actuator, 1);
  assert_true(sweep.largest[0].value == 0.0);
  km_statics_sweep_free(&sweep);
  km_statics_free(&statics);
  km_forces_free(forces);
  fixture_close(&f);
}

/* The point of a link on its own hinge stands, though rounding moves it: at no pose is there a leverage over it. */
static void no_leverage_over_a_pivot(void **state) {
  (void)state;
  fixture f = sliding_rocker();
  const km_sweep_plan plan = {.coordinate = 0, .from = 0.0, .to = 6.5, .steps = 50};
  const km_port in = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "in"},
                out = {
                    .kind = KM_PORT_POINT, .frame = f.model->joints[0].frame[1], .direction = {1, 0, 0}, .name = "out"};
  km_advantage_sweep sweep;
  assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &in, &out, false, &sweep, NULL), KM_OK);
  assert_int_equal(sweep.toggle_count, 1); /* rows from the first one on */
  assert_int_equal(sweep.toggles[0].state, KM_ADVANTAGE_INFINITE);
  for (size_t r = 0; r < km_table_rows(sweep.motion.table); ++r)
    assert_true(isinf(km_table_row(sweep.motion.table, r)[sweep.column]));
  km_advantage_sweep_free(&sweep);
  fixture_close(&f);
}

/* The twin cylinders of the boom share the load evenly; without the stick's cylinder the stick falls. */
static void excavator_under_gravity(void **state) {
  (void)state;
  fixture f = fixture_open("excavator");
  km_forces *forces;
  km_mobility mobility;
  km_load loads[8];
  int all[4], count = km_model_load_count(f.model);
  static const char *const names[4] = {"L", "M", "N", "O"};
  for (int i = 0; i < count; ++i)
    loads[i] = km_model_load_at(f.model, i);
  for (int i = 0; i < 4; ++i)
    assert_int_equal(km_model_find_coordinate(f.model, names[i], &all[i], NULL), KM_OK);
  km_mobility_compute(f.mechanism, f.state, &mobility);
  assert_int_equal(km_forces_create(f.mechanism, NULL, loads, count, &forces, NULL), KM_OK);
  for (int without = -1; without < 4; ++without) {
    km_statics statics;
    int some[4], used = 0;
    for (int i = 0; i < 4; ++i)
      if (i != without)
        some[used++] = all[i];
    assert_int_equal(km_statics_create(f.mechanism, some, used, KM_AXES_JOINT, &statics, NULL), KM_OK);
    km_statics_compute(f.mechanism, f.state, forces, &statics);
    assert_int_equal(statics.held, without < 2); /* one of the twins would do */
    if (without < 0)
      assert_near(statics.actuator_forces[0], statics.actuator_forces[1], 1e-9 * fabs(statics.actuator_forces[0]));
    int falling = 0;
    for (int d = 0; d < statics.direction_count; ++d) {
      falling += statics.falls[d];
      if (statics.falls[d]) /* the missing cylinder moves in it */
        assert_true(fabs(statics.directions[d * f.mechanism->coordinate_count + all[without]]) > 1e-3);
    }
    assert_int_equal(falling, without >= 2);
    km_statics_free(&statics);
  }
  km_forces_free(forces);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {claim_test(toggles_are_located, "A four-bar's dead centres by the cosine rule",
                                                "ends and events are located to 1e-9"),
                                     cmocka_unit_test(toggles_by_arc_length),
                                     cmocka_unit_test(through_change_points),
                                     cmocka_unit_test(balances_and_peaks),
                                     cmocka_unit_test(forces_without_bound),
                                     cmocka_unit_test(what_stands_holds_nothing),
                                     cmocka_unit_test(no_leverage_over_a_pivot),
                                     cmocka_unit_test(excavator_under_gravity)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
