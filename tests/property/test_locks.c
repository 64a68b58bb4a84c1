/* A state that locks coordinates closes and moves as the mechanism that was compiled with them held. */
#include "support/support.h"

#include "support/random_mechanism.h"

#include "kinematics/loop_closing.h"
#include "kmech/continuation.h"

#include <math.h>
#include <string.h>

/* Locks some coordinates, a ball's together; notes them as holds. Returns how many. */
static int lock_some(fixture *f, randomness *r, km_hold *holds) {
  int count = 0;
  for (int j = 0; j < f->model->joint_count; ++j) {
    int first = f->model->joints[j].first_coordinate;
    bool together = false;
    for (int k = 0; k < km_model_freedom(f->model, j); ++k) {
      int c = first + k;
      together =
          f->mechanism->ball_of[c] >= 0 && k > 0 && f->mechanism->ball_of[c - 1] >= 0 ? together : below(r, 3) == 0;
      if (!together)
        continue;
      holds[count++] = (km_hold){c, km_state_coordinate(f->state, c)};
      km_state_lock(f->state, c);
    }
  }
  return count;
}

/* Moves every column that isn't locked by a little and closes the loops again. */
static void shake_and_close(fixture *f, const km_mechanism *m, km_state *s, uint64_t seed) {
  double *step = KM_NEW(double, (size_t)f->mechanism->largest_columns + 1);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    km_closure evidence;
    for (int k = 0; k < sub->columns; ++k) {
      int c = m->column_coordinate[sub->column_start + k];
      randomness own = {seed + 1000 * (uint64_t)c}; /* the coordinate in either mechanism */
      step[k] = s->locked[c] ? 0.0 : uniform(&own, -1e-4, 1e-4) / m->unit[c];
    }
    km_state_move(m, s, sub, step);
    km_loops_close(m, s, i, KM_NO_DRIVER, &evidence);
    assert_true(evidence.residual <= 1e-9);
  }
  km_free(step);
}

static void compare(fixture *f, const km_mechanism *held, km_state *other) {
  km_mobility a, b;
  km_mobility_compute(f->mechanism, f->state, &a);
  km_mobility_compute(held, other, &b);
  assert_int_equal(a.mobility, b.mobility);
  assert_int_equal(a.redundant_constraints, b.redundant_constraints);
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    assert_near(km_mobility_number(f->state, c), km_mobility_number(other, c), 1e-8);
    assert_near(f->state->q[c], other->q[c], 1e-8);
  }
}

static void as_compiled_with_holds(void **unused) {
  (void)unused;
  int fewer = 0;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, true);
    km_mobility before, after;
    km_mobility_compute(f.mechanism, f.state, &before);
    km_hold *holds = KM_NEW(km_hold, (size_t)f.model->coordinate_count + 1);
    int count = lock_some(&f, &r, holds);
    km_mechanism *held;
    km_state *other;
    km_compiling how = {.holds = holds, .hold_count = count, .length = f.mechanism->length};
    assert_int_equal(km_mechanism_compile_as(f.model, &how, &held, NULL), KM_OK);
    assert_int_equal(km_state_create(held, &other, NULL), KM_OK);
    km_state_copy(held, other, f.state);
    for (int c = 0; c < f.model->coordinate_count; ++c)
      assert_int_equal(held->held[c], f.state->locked[c]);
    compare(&f, held, other);
    shake_and_close(&f, f.mechanism, f.state, seed);
    shake_and_close(&f, held, other, seed);
    compare(&f, held, other);
    for (int i = 0; i < count; ++i) /* bit-equal: the coordinate isn't moved */
      assert_near(f.state->q[holds[i].coordinate], other->q[holds[i].coordinate], 0.0);
    km_mobility_compute(f.mechanism, f.state, &after);
    fewer += after.mobility < before.mobility;
    km_state_unlock(f.state);
    km_mobility_compute(f.mechanism, f.state, &after);
    assert_int_equal(after.mobility, before.mobility);
    km_state_free(other);
    km_mechanism_free(held);
    km_free(holds);
    fixture_close(&f);
  }
  assert_true(fewer >= 75);
}

static void a_locked_joint_is_no_driver(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  km_driver_motion *drive;
  km_arc_motion *follow;
  km_state_lock(f.state, 0);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, true, &drive, NULL), KM_USAGE);
  assert_int_equal(km_arc_motion_create(f.mechanism, f.state, 0, 1.0, true, &follow, NULL), KM_USAGE);
  assert_int_equal(km_arc_motion_create(f.mechanism, f.state, 1, 1.0, true, &follow, NULL),
                   KM_NO_RESULT); /* a structure */
  km_state_unlock(f.state);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, true, &drive, NULL), KM_OK);
  km_driver_motion_free(drive);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(as_compiled_with_holds),
                                     cmocka_unit_test(a_locked_joint_is_no_driver)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
