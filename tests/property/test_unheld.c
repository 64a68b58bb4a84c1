/* What actuators can't hold: every direction that is told is a motion of the loops in which no actuator moves, as large
 * as 1, and if loads act on it they drive it. */
#include "support/random_mechanism.h"
#include "support/support.h"

#include "analysis/statics.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"

#include <math.h>

/* Some joints with a coordinate of their own. */
static int choose(const fixture *f, randomness *r, int *actuators) {
  int count = 0;
  for (int c = 0; c < f->model->coordinate_count; ++c)
    if (f->mechanism->ball_of[c] < 0 && below(r, 4) == 0)
      actuators[count++] = c;
  return count;
}

/* J r = 0 in scaled rows. */
static void check_allowed(fixture *f, const double *rates) {
  const km_mechanism *m = f->mechanism;
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    double *J = KM_NEW(double, (size_t)sub->rows *(size_t)sub->columns + 1);
    km_state_jacobian_dense(f->state, sub, J);
    for (int r = 0; r < sub->rows; ++r) {
      double sum = 0.0, size = 0.0;
      for (int k = 0; k < sub->columns; ++k) {
        int c = m->column_coordinate[sub->column_start + k];
        sum += J[k * sub->rows + r] * rates[c] / m->unit[c];
        size += fabs(J[k * sub->rows + r]);
      }
      assert_near(sum, 0.0, 1e-7 * (1.0 + size));
    }
    km_free(J);
  }
}

static double largest_of(const fixture *f, const double *rates) {
  double largest = 0.0;
  for (int c = 0; c < f->model->coordinate_count; ++c)
    largest = fmax(largest, fabs(rates[c] / f->mechanism->unit[c]));
  return largest;
}

static void check_directions(fixture *f, const km_statics *st, const int *actuators, int count, const double *tau) {
  for (int d = 0; d < st->direction_count && d < KM_MOST_DIRECTIONS; ++d) {
    const double *rates = st->directions + (size_t)d * (size_t)f->model->coordinate_count;
    check_allowed(f, rates);
    assert_near(largest_of(f, rates), 1.0, 1e-12);
    for (int a = 0; a < count; ++a)
      assert_near(rates[actuators[a]] / f->mechanism->unit[actuators[a]], 0.0, 1e-6);
    double power = 0.0, size = 0.0;
    for (int c = 0; c < f->model->coordinate_count; ++c) {
      power += tau[c] * rates[c];
      size += fabs(tau[c] * rates[c]);
    }
    if (st->falls[d])
      assert_true(power > 0.0);
    else
      assert_near(power, 0.0, 1e-6 * size + 1e-9);
  }
}

static void random_mechanisms(void **state) {
  (void)state;
  int directions = 0, falling = 0, held = 0;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    char *text = random_mechanism(&r, true);
    fixture f = fixture_read(text);
    km_free(text);
    if (f.mechanism->coordinate_count)
      go_somewhere(&f, &r);
    int *actuators = KM_NEW(int, (size_t)f.model->coordinate_count + 1), count = choose(&f, &r, actuators);
    double *tau = KM_NEW(double, (size_t)f.model->coordinate_count + 1);
    const km_load load = {.frame = f.model->frame_count - 1,
                          .force = {uniform(&r, -5, 5), uniform(&r, -5, 5), uniform(&r, -5, 5)}};
    km_forces *forces;
    km_statics st;
    km_mobility mobility;
    km_mobility_update(f.mechanism, f.state, &mobility);
    assert_int_equal(km_forces_create(f.mechanism, NULL, &load, 1, &forces, NULL), KM_OK);
    assert_int_equal(km_statics_create(f.mechanism, actuators, count, KM_AXES_JOINT, &st, NULL), KM_OK);
    km_statics_update(f.mechanism, f.state, forces, &st);
    for (int c = 0; c < f.model->coordinate_count; ++c)
      tau[c] = st.work->tau[c];
    check_directions(&f, &st, actuators, count, tau);
    directions += st.direction_count;
    falling += st.direction_count > 0 && st.falls[0];
    held += st.held;
    km_statics_free(&st);
    km_forces_free(forces);
    km_free(tau);
    km_free(actuators);
    fixture_close(&f);
  }
  assert_true(directions > 200 && falling > 20 && held > 80);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(random_mechanisms)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
