/* Loads that actuators can and can't balance, joints and pushed points together, whatever parts they move: balancing
 * forces leave no power in any motion; every reported direction is a motion of the loops of length 1 in which no
 * actuator moves, and if loads act on it they drive it. */
#include "support/random_mechanism.h"
#include "support/support.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "statics/statics.h"

#include <math.h>
#include <string.h>

enum { MOST_ACTUATORS = 200 };

/* Some joints with a coordinate of their own, and up to two points. */
static int choose(const fixture *f, randomness *r, km_port *actuators) {
  int count = 0;
  for (int c = 0; c < f->model->coordinate_count && count < MOST_ACTUATORS - 2; ++c)
    if (f->mechanism->ball_of[c] < 0 && below(r, 4) == 0)
      actuators[count++] = (km_port){.kind = KM_PORT_JOINT, .coordinate = c, .name = "joint"};
  for (int i = below(r, 3); i > 0; --i) {
    km_port *point = &actuators[count];
    km_statics statics;
    double turn = uniform(r, -M_PI, M_PI);
    *point = (km_port){.kind = KM_PORT_POINT,
                       .frame = below(r, f->model->frame_count),
                       .direction = {0.6 * cos(turn), 0.6 * sin(turn), 0.8},
                       .name = "point"};
    /* Some points stand still, or push a joint in no loop that is held already. */
    count += km_statics_create_for(f->mechanism, actuators, count + 1, KM_AXES_JOINT, &statics, NULL) == KM_OK;
    km_statics_free(&statics);
  }
  return count;
}

/* Rate of an actuator; that of a point by its frame's twist. */
static double rate_of(fixture *f, const km_port *actuator, const double *rates) {
  double twist[6];
  if (actuator->kind == KM_PORT_JOINT)
    return rates[actuator->coordinate];
  assert_int_equal(km_frame_twist(f->mechanism, f->state, actuator->frame, rates, twist, NULL), KM_OK);
  return twist[0] * actuator->direction[0] + twist[1] * actuator->direction[1] + twist[2] * actuator->direction[2];
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

static double unit_of(const fixture *f, const km_port *actuator) {
  return actuator->kind == KM_PORT_JOINT ? f->mechanism->unit[actuator->coordinate] : f->mechanism->length;
}

static void check_directions(fixture *f, const km_statics *st, const km_port *actuators, int count, const double *tau) {
  for (int d = 0; d < st->direction_count && d < KM_MAX_DIRECTIONS; ++d) {
    const double *rates = st->directions + (size_t)d * (size_t)f->model->coordinate_count;
    check_allowed(f, rates);
    assert_near(largest_of(f, rates), 1.0, 1e-12);
    for (int a = 0; a < count; ++a)
      assert_near(rate_of(f, &actuators[a], rates) / unit_of(f, &actuators[a]), 0.0, 1e-6);
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

/* The power of loads and actuators in one motion. */
static void check_power(fixture *f, const km_statics *st, const km_port *actuators, int count, const double *tau,
                        const double *rates) {
  double power = 0.0, size = 1.0;
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    power += tau[c] * rates[c];
    size += fabs(tau[c] * rates[c]);
  }
  for (int a = 0; a < count; ++a) {
    double part = st->actuator_forces[a] * rate_of(f, &actuators[a], rates);
    power += part;
    size += fabs(part);
  }
  assert_near(power, 0.0, 1e-8 * size);
}

/* Motions of a basis: those of the substructures, and each joint outside loops. */
static void check_balance(fixture *f, const km_statics *st, const km_port *actuators, int count, const double *tau) {
  const km_mechanism *m = f->mechanism;
  double *rates = KM_NEW(double, (size_t)m->coordinate_count + 1);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    for (int k = 0; k < km_factor_freedom(f->state->factor[i]); ++k) {
      memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
      for (int j = 0; j < sub->columns; ++j) {
        int c = m->column_coordinate[sub->column_start + j];
        rates[c] = km_state_basis(f->state, i)[k * sub->columns + j] / m->scale[c];
      }
      check_power(f, st, actuators, count, tau, rates);
    }
  }
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->substructure_of[c] >= 0 || m->held[c])
      continue;
    memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
    rates[c] = 1.0;
    check_power(f, st, actuators, count, tau, rates);
  }
  km_free(rates);
}

typedef struct tally {
  int directions, falling, held, pushed;
} tally;

static void check(fixture *f, randomness *r, tally *all) {
  km_port actuators[MOST_ACTUATORS];
  int count = choose(f, r, actuators);
  double *tau = KM_NEW(double, (size_t)f->model->coordinate_count + 1);
  const km_load load = {.frame = f->model->frame_count - 1,
                        .force = {uniform(r, -5, 5), uniform(r, -5, 5), uniform(r, -5, 5)}};
  km_forces *forces;
  km_statics st, every;
  km_mobility mobility;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  km_poses_compute(f->mechanism, f->state);
  assert_int_equal(km_forces_create(f->mechanism, NULL, &load, 1, &forces, NULL), KM_OK);
  assert_int_equal(km_statics_create_for(f->mechanism, actuators, count, KM_AXES_JOINT, &st, NULL), KM_OK);
  assert_int_equal(km_statics_create(f->mechanism, NULL, 0, KM_AXES_JOINT, &every, NULL), KM_OK);
  km_statics_compute(f->mechanism, f->state, forces, &every); /* its τ has no pushes */
  km_statics_compute(f->mechanism, f->state, forces, &st);
  for (int c = 0; c < f->model->coordinate_count; ++c)
    tau[c] = every.work->tau[c];
  check_directions(f, &st, actuators, count, tau);
  if (st.held)
    check_balance(f, &st, actuators, count, tau);
  all->directions += st.direction_count;
  all->falling += st.direction_count > 0 && st.falls[0];
  all->held += st.held;
  all->pushed += st.held && count && actuators[count - 1].kind == KM_PORT_POINT;
  km_statics_free(&st);
  km_statics_free(&every);
  km_forces_free(forces);
  km_free(tau);
}

static void random_mechanisms(void **state) {
  (void)state;
  tally all = {0};
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, true);
    check(&f, &r, &all);
    fixture_close(&f);
  }
  assert_true(all.directions > 200 && all.falling > 15 && all.held > 80 && all.pushed > 40);
}

/* Bodies moved by several substructures and joints outside loops. */
static void shipped_models(void **state) {
  (void)state;
  static const char *const names[] = {"excavator", "vehicle", "stewart", "brake", "iiwa14", "delta"};
  tally all = {0};
  randomness r = {3};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
    for (int n = 0; n < 12; ++n) {
      fixture f = fixture_open(names[i]);
      go_somewhere(&f, &r);
      check(&f, &r, &all);
      fixture_close(&f);
    }
  assert_true(all.directions > 120 && all.falling > 25 && all.held > 25 && all.pushed > 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(random_mechanisms), cmocka_unit_test(shipped_models)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
