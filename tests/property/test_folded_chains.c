/* Folded chains of parallelograms: which of their 2^n branches are found, and what their constraints say twice. */
#include "support/folded.h"

#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "local/local_private.h"

#include <stdio.h>
#include <string.h>

enum { LOOPS = 60 };

static km_finite_mobility find(fixture *f) {
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  return found;
}

/* Every loop of the folded chain goes on as a parallelogram or crossed, 2^60 branches: some are found, first one
 * along which most cranks turn alike. */
static void a_folded_chain(void **state) {
  (void)state;
  fixture f = folded_chain(LOOPS);
  const km_mechanism *m = f.mechanism;
  km_finite_mobility found = find(&f);
  assert_int_equal(found.mobility, 2); /* index of the last coupler, in no loop */
  assert_true(found.undecided && found.truncated && found.motion_count >= 1);
  assert_int_equal(found.motions[0].kind, KM_MOTION_BRANCH);
  int first, last;
  assert_int_equal(km_model_find_coordinate(f.model, "P30", &first, NULL), KM_OK);
  assert_int_equal(km_model_find_coordinate(f.model, "P60", &last, NULL), KM_OK);
  assert_near(found.motions[0].direction[last], found.motions[0].direction[first], 1e-6);
  for (int i = 0; i < found.motion_count; ++i) { /* each is one of second order */
    double length = 0.0;
    for (int c = 0; c < m->coordinate_count; ++c)
      length += found.motions[i].direction[c] * found.motions[i].direction[c];
    assert_near(length, 1.0, 1e-9);
    assert_true(found.motions[i].confirmed_length > 0.3);
  }
  km_finite_mobility_free(&found);
  km_findings findings;
  bool told = false;
  assert_int_equal(km_check(m, f.state, NULL, NULL, NULL, &findings, NULL), KM_OK);
  for (size_t i = 0; i < findings.count; ++i)
    told = told || (strcmp(findings.items[i].kind, "undecided") == 0 &&
                    strstr(findings.items[i].statement, "only some of its directions were tried"));
  assert_true(told);
  km_findings_free(&findings);
  fixture_close(&f);
}

/* Loops that continue on the crossed branch. In a flat parallelogram with cranks a and coupler b, a ω + b ω_c = a ω'
 * and a ω² + b ω_c² = a ω'² give ω' = ω or ω' = −ω (b + a) / (b − a) = −3 ω. */
static void read_branch(const fixture *f, const km_finite_motion *motion, int n, bool *crossed) {
  double before = 0.0;
  for (int i = 0; i <= n; ++i) {
    char name[16];
    int crank;
    snprintf(name, sizeof name, "P%d", i);
    assert_int_equal(km_model_find_coordinate(f->model, name, &crank, NULL), KM_OK);
    double rate = motion->direction[crank];
    if (i > 0) {
      assert_near((rate - before) * (rate + 3.0 * before), 0.0, 1e-8); /* second order is met to 1e-9 */
      crossed[i - 1] = fabs(rate + 3.0 * before) < fabs(rate - before);
    }
    before = rate;
  }
}

/* All 2^n branches of a few loops are listed, each once. */
static void all_branches_of_folded_chains(void **state) {
  (void)state;
  for (int n = 1; n <= 6; ++n) {
    fixture f = folded_chain(n);
    km_finite_mobility found = find(&f);
    bool met[64] = {false};
    assert_int_equal(found.motion_count, 1 << n);
    assert_int_equal(found.truncated, found.motion_count == KM_MAX_FINITE_MOTIONS);
    for (int i = 0; i < found.motion_count; ++i) {
      bool crossed[6];
      int word = 0;
      read_branch(&f, &found.motions[i], n, crossed);
      for (int l = 0; l < n; ++l)
        word = 2 * word + crossed[l];
      assert_false(met[word]);
      met[word] = true;
    }
    km_finite_mobility_free(&found);
    fixture_close(&f);
  }
}

/* With more loops the first cranks move much less than the last ones, and their rows are dependent to within
 * rounding; each start is still on its branch. */
static void starts_in_folded_chains(void **state) {
  (void)state;
  static const int loops[] = {25, 30, 35, 40, 45};
  for (size_t i = 0; i < sizeof loops / sizeof *loops; ++i) {
    fixture f = folded_chain(loops[i]);
    km_arena arena = {0};
    double length;
    int found = 0, starts = 1200 / f.mechanism->substructures[0].columns;
    km_local *l = km_local_create(f.mechanism, f.state, 0, NULL, 0.0, &arena);
    assert_true(l && km_local_reserve_tangents(l, false));
    while (km_local_find_next(l, NULL, 0, &length))
      ++found;
    assert_int_equal(found, starts);
    km_local_free(l);
    km_arena_free(&arena);
    fixture_close(&f);
  }
}

/* Branches that differ in small rates only are two: each of the nine starts that 40 loops are given leads to one of
 * its own. */
static void branches_that_differ_little(void **state) {
  (void)state;
  fixture f = folded_chain(40);
  bool crossed[40];
  km_finite_mobility found = find(&f);
  assert_int_equal(found.motion_count, 9);
  for (int i = 0; i < found.motion_count; ++i)
    read_branch(&f, &found.motions[i], 40, crossed);
  km_finite_mobility_free(&found);
  fixture_close(&f);
}

/* A little further on no loop of it is flat any more: what each had too much along its links was the pose's. */
static void what_a_folded_chain_has_too_much(void **state) {
  (void)state;
  fixture f = folded_chain(LOOPS);
  km_redundancies found;
  int persistent = 0;
  assert_int_equal(km_redundancies_find(f.mechanism, f.state, NULL, NULL, &found, NULL), KM_OK);
  for (int i = 0; i < found.count; ++i)
    persistent += found.items[i].persistent;
  assert_int_equal(found.count, 4 * LOOPS);
  assert_int_equal(persistent, 3 * LOOPS);
  km_redundancies_free(&found);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_folded_chain),
      cmocka_unit_test(all_branches_of_folded_chains),
      cmocka_unit_test(starts_in_folded_chains),
      cmocka_unit_test(branches_that_differ_little),
      cmocka_unit_test(what_a_folded_chain_has_too_much),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
