/* Laws of the equations of motion, on random mechanisms. */
#include "support/moving.h"
#include "support/random_mechanism.h"

#include <stdlib.h>
#include <string.h>

/* A random mechanism with masses and rates, assembled; false where the generator made none. */
static bool any_mechanism(uint64_t seed, moving *out, randomness *r) {
  *r = (randomness){seed};
  char *text = random_mechanism(r, true);
  fixture f;
  km_error error;
  bool good = fixture_try(text, &f, &error) == KM_OK;
  free(text);
  if (!good) {
    fixture_close(&f);
    return false;
  }
  give_masses(f.model, r);
  *out = moving_of(f);
  give_rates(out, r);
  return true;
}

/* d'Alembert's principle by momenta along the motion, which no part of the equations of motion computes. Central
 * differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16 / 1e-5. */
static void test_dalembert(void **data) {
  (void)data;
  int judged = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    moving m;
    randomness r;
    km_error error = {0};
    if (!any_mechanism(seed, &m, &r))
      continue;
    assert_int_equal(km_dynamics_accelerate(m.dynamics, m.f.state, &error), KM_OK);
    km_poses_compute(m.f.mechanism, m.f.state);
    assert_near(dalembert(&m, 1e-5), 0.0, 1e-7);
    judged++;
    moving_close(&m);
  }
  assert_true(judged > 250);
}

/* Largest |J v| over the loops, of rates as large as 1. */
static double opening(const moving *m) {
  const km_mechanism *mech = m->f.mechanism;
  double worst = 0.0;
  for (int i = 0; i < mech->topology.substructure_count; ++i) {
    const km_substructure *sub = &mech->substructures[i];
    double *J = (double *)calloc((size_t)sub->rows * (size_t)sub->columns + 1, sizeof *J);
    km_state_jacobian_dense(m->f.state, sub, J);
    for (int r = 0; r < sub->rows; ++r) {
      double sum = 0.0;
      for (int k = 0; k < sub->columns; ++k) {
        int c = mech->column_coordinate[sub->column_start + k];
        sum += J[k * sub->rows + r] * m->f.state->rate[c] / mech->unit[c];
      }
      worst = fmax(worst, fabs(sum));
    }
    free(J);
  }
  return worst;
}

static double scaled_size(const km_mechanism *m, const double *rate) {
  double square = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->substructure_of[c] >= 0)
      square += m->scale[c] * m->scale[c] * rate[c] * rate[c];
  return sqrt(square);
}

/* States the rates of `motion` for a random part of the coordinates, 0 for none of the others. */
static int state_some(moving *m, const double *motion, km_rate_source source, double share, randomness *r) {
  km_state *s = m->f.state;
  int stated = 0;
  for (int c = 0; c < m->f.mechanism->coordinate_count; ++c) {
    if (m->f.mechanism->held[c] || uniform(r, 0.0, 1.0) > share)
      continue;
    s->rate[c] = motion[c];
    s->rate_source[c] = source;
    stated++;
  }
  return stated;
}

/* Rates that are stated for a part of the joints and belong to a motion are kept, the others are the least: no
 * larger than those of the motion that the statements are from. */
static void test_stated_rates(void **data) {
  (void)data;
  int judged = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    moving m;
    randomness r;
    if (!any_mechanism(seed, &m, &r))
      continue;
    const km_mechanism *mech = m.f.mechanism;
    km_state *s = m.f.state;
    size_t size = (size_t)mech->coordinate_count * sizeof(double);
    double *motion = (double *)malloc(size + 1);
    memcpy(motion, s->rate, size);
    memset(s->rate, 0, size);
    if (state_some(&m, motion, seed % 2 ? KM_RATE_CALLER : KM_RATE_MODEL, 0.3, &r) > 0) {
      double whole = scaled_size(mech, motion);
      assert_int_equal(km_dynamics_project_rates(m.dynamics, s, NULL, NULL), KM_OK);
      assert_true(opening(&m) <= 1e-9 * (1.0 + whole));
      for (int c = 0; c < mech->coordinate_count; ++c)
        if (s->rate_source[c] != KM_RATE_FOLLOWS)
          assert_near(mech->scale[c] * s->rate[c], mech->scale[c] * motion[c], 1e-9 * (1.0 + whole));
      assert_true(scaled_size(mech, s->rate) <= whole * (1.0 + 1e-9) + 1e-9);
      judged++;
    }
    free(motion);
    moving_close(&m);
  }
  assert_true(judged > 200);
}

/* The caller's rates are kept whatever the model states. */
static void test_contradicting_rates(void **data) {
  (void)data;
  int judged = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    moving m;
    randomness r;
    if (!any_mechanism(seed, &m, &r))
      continue;
    const km_mechanism *mech = m.f.mechanism;
    km_state *s = m.f.state;
    size_t size = (size_t)mech->coordinate_count * sizeof(double);
    double *motion = (double *)malloc(size + 1), *other = (double *)malloc(size + 1), change = 0.0;
    memcpy(motion, s->rate, size);
    for (int c = 0; c < mech->coordinate_count; ++c)
      other[c] = uniform(&r, -1.0, 1.0);
    memset(s->rate, 0, size);
    state_some(&m, other, KM_RATE_MODEL, 1.0, &r);
    state_some(&m, motion, KM_RATE_CALLER, 0.3, &r);
    assert_int_equal(km_dynamics_project_rates(m.dynamics, s, &change, NULL), KM_OK);
    assert_true(opening(&m) <= 1e-8 * (1.0 + scaled_size(mech, motion)));
    for (int c = 0; c < mech->coordinate_count; ++c)
      if (s->rate_source[c] == KM_RATE_CALLER)
        assert_near(mech->scale[c] * s->rate[c], mech->scale[c] * motion[c], 1e-8 * (1.0 + scaled_size(mech, motion)));
    judged += change > 1e-3;
    free(motion);
    free(other);
    moving_close(&m);
  }
  assert_true(judged > 100);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(test_dalembert,
                 "Accelerations satisfy d'Alembert's principle by momenta along the motion, on 300 random mechanisms",
                 "central differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16/1e-5"),
      claim_test(
          test_stated_rates,
          "Stated initial rates of a part of the joints are kept where a motion has them, on 300 random mechanisms",
          "pivots down to 1e-3 of the largest, squared"),
      cmocka_unit_test(test_contradicting_rates)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
