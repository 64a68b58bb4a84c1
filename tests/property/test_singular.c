/* Singular values over sweeps: those of LAPACKE's SVD, and minima where mobility is gained. */
#include "support/support.h"

#include "kmech/sweep.h"
#include "model/model.h"

#include <lapacke.h>
#include <string.h>

static double kept_by_lapacke(const fixture *f, int index) {
  const km_substructure *sub = &f->mechanism->substructures[index];
  int rows = sub->rows, columns = sub->columns, most = rows < columns ? rows : columns;
  double *A = KM_NEW(double, (size_t)(rows * columns)), *values = KM_NEW(double, (size_t)most + 1), none[1];
  km_state_jacobian_dense(f->state, sub, A);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      A[c * rows + r] /= f->mechanism->column_weight[sub->column_start + c];
  assert_int_equal(LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'N', rows, columns, A, rows, values, none, 1, none, 1), 0);
  double kept = values[km_factor_rank(f->state->factor[index]) - 1];
  km_free(A);
  km_free(values);
  return kept;
}

static km_sweep_plan plan_of(const fixture *f) {
  km_sweep_plan plan = km_sweep_plan_default(f->model);
  plan.singularities = true;
  return plan;
}

static void those_of_lapacke(void **state) {
  (void)state;
  static const char *const names[] = {"fourbar", "slider_crank", "klann", "brake", "excavator", "sarrus3", NULL};
  for (const char *const *name = names; *name; ++name) {
    fixture f = fixture_open(*name);
    km_sweep_plan plan = plan_of(&f);
    km_mobility_sweep sweep;
    km_error error;
    plan.steps = 7;
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
    const km_table *table = sweep.motion.table;
    double kept = km_table_row(table, 7)[km_table_find(table, "singular_value")];
    double expected = kept_by_lapacke(&f, sweep.motion.substructure);
    assert_near(kept, expected, 1e-12); /* matrices have entries of about 1 */
    assert_true(sweep.smallest.number <= kept);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* Laid flat, a parallelogram gains a mobility, and one more constraint is redundant there. The others stay. */
static void minima_where_mobility_is_gained(void **state) {
  (void)state;
  fixture f = parallelogram(0.7);
  km_sweep_plan plan = plan_of(&f);
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
  km_error error;
  plan.coordinate = 0;
  plan.from = 0.7;
  plan.to = 5.6;
  plan.steps = 8; /* no row is a change point */
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
  assert_near(sweep.smallest.number, 0.0, 1e-7);
  assert_near(sweep.smallest.s, M_PI, 1e-6);
  assert_int_equal(km_sweep_redundancies_find(f.mechanism, &sweep.motion, true, &redundancies, &error), KM_OK);
  assert_int_equal(redundancies.persistent.count, 3);
  assert_int_equal(redundancies.extra_count, 1);
  assert_near(redundancies.extra[0].s, M_PI, 1e-8);
  assert_int_equal(redundancies.extra[0].more, 1);
  km_sweep_redundancies_free(&redundancies);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(those_of_lapacke, "The smallest singular value along a sweep is LAPACK's",
                 "rounding, of matrices of size about 1"),
      cmocka_unit_test(minima_where_mobility_is_gained),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
