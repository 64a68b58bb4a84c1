/* Errors, Jacobians and pivots of a configuration are cached, and computed again after any change of their inputs:
 * cached data have the bits of a fresh state. */
#include "linalg/factor_private.h"
#include "support/support.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/model.h"
#include "model/model.h"

#include <math.h>
#include <string.h>

/* The errors and Jacobians at the state's coordinates, of a state that has shown no pose yet. */
static km_state *fresh_state(const fixture *f) {
  km_state *fresh;
  assert_int_equal(km_state_create(f->mechanism, &fresh, NULL), KM_OK);
  km_state_copy(f->mechanism, fresh, f->state);
  for (int c = 0; c < f->mechanism->coordinate_count; ++c)
    if (f->state->locked[c])
      km_state_lock(fresh, c);
  return fresh;
}

static void compare_with_fresh(const fixture *f) {
  const km_mechanism *m = f->mechanism;
  km_state *fresh = fresh_state(f);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_loops_update(m, f->state, &m->substructures[i]);
    km_loops_update(m, fresh, &m->substructures[i]);
  }
  assert_memory_equal(f->state->jacobian, fresh->jacobian, m->matrix_size * sizeof(double));
  assert_memory_equal(f->state->error, fresh->error, (size_t)m->error_size * sizeof(double));
  km_state_free(fresh);
}

/* A little further in every coordinate, and back. */
static void other_poses(const fixture *f) {
  const km_mechanism *m = f->mechanism;
  double *step = KM_NEW(double, (size_t)m->largest_columns + 1);
  for (int sign = 1; sign >= -1; sign -= 2) {
    for (int i = 0; i < m->topology.substructure_count; ++i) {
      for (int k = 0; k < m->substructures[i].columns; ++k)
        step[k] = sign * 1e-3 * (k + 1);
      km_state_move(m, f->state, &m->substructures[i], step);
    }
    compare_with_fresh(f);
  }
  km_free(step);
}

static void locks(const fixture *f) {
  for (int c = 0; c < f->mechanism->coordinate_count; c += 2)
    km_state_lock(f->state, c);
  compare_with_fresh(f);
  km_state_unlock(f->state);
  compare_with_fresh(f);
}

/* The coordinates stay where they are. */
static void other_numbers(const fixture *f) {
  for (int i = 0; i < f->model->frame_count; ++i) {
    km_vec3 p = f->model->frames[i].pose.p;
    const double T[3] = {1.25 * p.x, 1.25 * p.y, 1.25 * p.z};
    assert_int_equal(km_model_set_frame(f->model, i, T, NULL, NULL), KM_OK);
  }
  assert_int_equal(km_mechanism_renumber(f->mechanism, NULL), KM_OK);
  compare_with_fresh(f);
}

static void found_anew(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    compare_with_fresh(&f);
    other_poses(&f);
    locks(&f);
    other_numbers(&f);
    fixture_close(&f);
  }
}

static const char gears[] =
    "{\"assemblies\": [{\"name\": \"gears\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}], \"joints\": ["
    "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\"], [\"a\"]]}, "
    "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\"], [\"b\"]]}], "
    "\"couplings\": [{\"name\": \"gear\", \"joints\": [\"A\", \"B\"], \"ratios\": [1, 2]}]}]}";

/* A coordinate that is held has no column, and is in the coupling all the same. */
static void held_coordinates_count(void **state) {
  (void)state;
  fixture f = fixture_read(gears);
  const km_hold hold = {0, 0.0};
  double q[2] = {0.25, 0.0};
  km_state_free(f.state);
  km_mechanism_free(f.mechanism);
  assert_int_equal(km_mechanism_compile(f.model, &hold, 1, &f.mechanism, NULL), KM_OK);
  assert_int_equal(km_state_create(f.mechanism, &f.state, NULL), KM_OK);
  compare_with_fresh(&f);
  km_state_set(f.mechanism, f.state, q);
  compare_with_fresh(&f);
  assert_true(fabs(f.state->error[0]) > 0.1);
  fixture_close(&f);
}

/* Pivots of register elimination are cached for equal requests. */
static void searched_once(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  const km_substructure *sub = &f.mechanism->substructures[0];
  const km_factor *p = f.state->factor[0];
  const double tolerance = 1e-9;
  double step[8] = {1e-3, 1e-3, 1e-3, 1e-3};
  km_loops_update(f.mechanism, f.state, sub);
  km_search_pivots(f.mechanism, f.state, 0, KM_NO_DRIVER, tolerance);
  unsigned searches = p->search_count;
  km_loops_update(f.mechanism, f.state, sub);
  km_search_pivots(f.mechanism, f.state, 0, KM_NO_DRIVER, tolerance);
  assert_int_equal(p->search_count, searches);
  km_search_pivots(f.mechanism, f.state, 0, 0, tolerance); /* another driver */
  assert_int_equal(p->search_count, ++searches);
  assert_int_equal(f.state->pivot_driver[0], 0);
  km_search_pivots(f.mechanism, f.state, 0, 0, 2.0 * tolerance);
  assert_int_equal(p->search_count, ++searches);
  km_state_move(f.mechanism, f.state, sub, step);
  km_loops_update(f.mechanism, f.state, sub);
  km_search_pivots(f.mechanism, f.state, 0, 0, 2.0 * tolerance);
  assert_int_equal(p->search_count, ++searches);
  assert_true(km_factor_refactor(f.state->factor[0], km_state_jacobian(f.state, sub), KM_BASIS_SHORT));
  km_search_pivots(f.mechanism, f.state, 0, 0, 2.0 * tolerance); /* a refactor has made the pivots' numbers others */
  assert_int_equal(p->search_count, ++searches);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(found_anew), cmocka_unit_test(held_coordinates_count),
                                     cmocka_unit_test(searched_once)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
