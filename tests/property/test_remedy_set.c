/* Sets of remedies (theory 7.5): the changed model has no redundant constraints, the same mobility and the same motion.
 * Its rank is that of LAPACKE's singular values; its motion is compared with that of the original. */
#include "support/linkages.h"
#include "support/planar.h"
#include "support/random_mechanism.h"
#include "support/support.h"

#include "kmech/mobility.h"
#include "model/model.h"

#include <stdlib.h>
#include <string.h>

static km_remedy_set find(fixture *f) {
  km_remedy_set set;
  km_error error;
  if (km_remedy_set_find(f->mechanism, f->state, NULL, NULL, &set, &error))
    fail_msg("%s", error.text);
  return set;
}

/* The changed model at the configuration of the fixture. */
static fixture changed(const fixture *f, const km_remedy_set *set) {
  km_error error;
  km_model *model;
  if (km_remedy_set_model(f->mechanism, f->state, set, &model, &error))
    fail_msg("%s", error.text);
  return fixture_of(model);
}

/* Redundant constraints and mobility of all substructures by singular values. */
static km_mobility count_by_svd(const fixture *f) {
  km_mobility found = {0};
  for (int i = 0; i < km_substructure_count(f->mechanism); ++i) {
    km_substructure_mobility sub;
    km_substructure_evidence(f->mechanism, f->state, i, &sub);
    double *numbers = calloc((size_t)sub.coordinates + 1, sizeof *numbers);
    int rank = numbers_by_svd(f, i, numbers);
    free(numbers);
    found.mobility += sub.coordinates - rank;
    found.redundant_constraints += 6 * sub.loops + f->mechanism->substructures[i].coupling_count - rank;
  }
  for (int c = 0; c < f->mechanism->coordinate_count; ++c)
    found.mobility += f->mechanism->substructure_of[c] < 0;
  return found;
}

/* The set does what it states at the configuration of the fixture. */
static void does_what_it_states(const fixture *f, const km_remedy_set *set) {
  fixture other = changed(f, set);
  km_mobility found = count_by_svd(&other);
  assert_int_equal(found.redundant_constraints, set->remaining);
  assert_int_equal(found.mobility, set->mobility);
  fixture_close(&other);
}

static int freedoms_of(const km_remedy_set *set) {
  int sum = 0;
  for (int i = 0; i < set->change_count; ++i)
    sum += set->changes[i].freedoms;
  return sum;
}

/* The proposals of the first configuration hold along the motions of the models. */
static void models_lose_all(void **state) {
  (void)state;
  static const char *const names[] = {"bennett", "bricard", "sarrus3", "sarrus4",      "scissor_lift", "fourbar",
                                      "klann",   "brake",   "delta",   "slider_crank", "peaucellier",  "jansen"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    randomness r = {n + 1};
    fixture f = fixture_open(names[n]);
    km_remedy_set set = find(&f);
    assert_true(set.redundant > 0);
    assert_int_equal(set.remaining, 0);
    assert_true(set.is_checked);
    assert_false(set.is_infinitesimal || set.is_too_large);
    assert_int_equal(freedoms_of(&set), set.redundant);
    for (int pose = 0; pose < 3; ++pose) {
      go_somewhere(&f, &r);
      does_what_it_states(&f, &set);
    }
    km_remedy_set_free(&set);
    fixture_close(&f);
  }
}

/* Overconstrained loops with random dimensions: Bennett, Bricard, Sarrus and others. */
static void overconstrained_loops_lose_all(void **state) {
  (void)state;
  for (int kind = 0; kind < MOVING_KINDS; ++kind)
    for (uint64_t seed = 1; seed <= 6; ++seed) {
      randomness r = {seed + 100 * (uint64_t)kind};
      linkage l = moving_loop(kind, &r);
      fixture f = linkage_open(&l, &r);
      km_remedy_set set = find(&f);
      if (set.remaining || !set.is_checked)
        fail_msg("%s, seed %d: %d of %d remain", moving_names[kind], (int)seed, set.remaining, set.redundant);
      does_what_it_states(&f, &set);
      km_remedy_set_free(&set);
      fixture_close(&f);
    }
}

/* A proposal for any mechanism: as many freedoms as constraints that end, each joint at most once. */
static void random_mechanisms_keep_their_mobility(void **state) {
  (void)state;
  int complete = 0, partial = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, seed % 3 == 0);
    km_remedy_set set = find(&f);
    assert_int_equal(freedoms_of(&set), set.redundant - set.remaining);
    for (int i = 0; i < set.change_count; ++i)
      for (int k = 0; k < i; ++k)
        assert_int_not_equal(set.changes[i].joint, set.changes[k].joint);
    assert_true(set.change_count == 0 || set.is_checked);
    complete += set.redundant > 0 && set.remaining == 0;
    partial += set.remaining > 0;
    km_remedy_set_free(&set);
    fixture_close(&f);
  }
  assert_true(complete >= 5);
}

/* The joint drives both mechanisms by `travel`; the joints that keep their type have equal values, in at least two of
 * them. */
static void moves_alike(const char *name, const char *driver, double travel) {
  fixture f = fixture_open(name);
  km_remedy_set set = find(&f);
  fixture other = changed(&f, &set);
  int c, d, compared = 0;
  km_error error;
  assert_int_equal(km_model_find_coordinate(f.model, driver, &c, &error), KM_OK);
  assert_int_equal(km_model_find_coordinate(other.model, driver, &d, &error), KM_OK);
  double value = km_state_coordinate(f.state, c) + travel;
  assert_int_equal(km_state_move_to(f.mechanism, f.state, &(km_hold){c, value}, 1, &error), KM_OK);
  assert_int_equal(km_state_move_to(other.mechanism, other.state, &(km_hold){d, value}, 1, &error), KM_OK);
  for (int k = 0; k < km_model_coordinate_count(f.model); ++k) {
    int same;
    if (km_model_find_coordinate(other.model, km_model_coordinate_label(f.model, k), &same, &error))
      continue;
    assert_near(km_state_coordinate(other.state, same), km_state_coordinate(f.state, k), 1e-9);
    ++compared;
  }
  assert_true(compared >= 2);
  fixture_close(&other);
  km_remedy_set_free(&set);
  fixture_close(&f);
}

static void the_motion_stays(void **state) {
  (void)state;
  moves_alike("bennett", "A", 0.7);
  moves_alike("sarrus3", "A", 0.3);
  moves_alike("scissor_lift", "Y", -0.2);
  moves_alike("fourbar", "A", 0.7);
  moves_alike("klann", "A", 0.7);
}

/* Planar linkages in any plane of space: three constraints for each loop. */
static void planar_linkages_lose_all(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    randomness r = {seed};
    planar p = planar_random(&r, 1 + (int)(seed % 2), 1 + (int)(seed % 3), false);
    char *text = planar_text(&p);
    fixture f = fixture_read(text);
    km_remedy_set set = find(&f);
    assert_int_equal(set.redundant, 3 * f.mechanism->topology.loop_count);
    assert_int_equal(set.remaining, 0);
    assert_true(set.is_checked);
    does_what_it_states(&f, &set);
    km_remedy_set_free(&set);
    fixture_close(&f);
    km_free(text);
  }
}

/* Two hinges between the same bodies need a series of joints. Five constraints are redundant:
 * one hinge becomes spherical and the other a ball that slides in a cylinder. */
static void two_hinges_on_one_line(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"door\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"leaf\"}], \"joints\": ["
      "{\"name\": \"low\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"leaf\"], \"at\": [0, 0, 0]},"
      "{\"name\": \"high\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"leaf\"], \"at\": [0, 0, 2]}]}]}");
  km_remedy_set set = find(&f);
  assert_int_equal(set.redundant, 5);
  assert_int_equal(set.remaining, 0);
  assert_int_equal(set.change_count, 2);
  assert_true(set.is_checked);
  int spherical = 0, sliding = 0;
  for (int i = 0; i < 2; ++i) {
    spherical += strcmp(set.changes[i].to, "spherical") == 0;
    sliding += strcmp(set.changes[i].to, "sphere-cylinder") == 0;
  }
  assert_int_equal(spherical, 1);
  assert_int_equal(sliding, 1);
  does_what_it_states(&f, &set);
  km_remedy_set_free(&set);
  fixture_close(&f);
}

/* A flat parallelogram has one constraint more than beside its change point; the set is for the motion. */
static void incidental_constraints_do_not_count(void **state) {
  (void)state;
  fixture f = parallelogram(0.0);
  km_remedy_set set = find(&f);
  assert_int_equal(set.redundant, 3);
  assert_int_equal(set.remaining, 0);
  assert_int_equal(set.mobility, 1);
  assert_true(set.is_checked);
  km_remedy_set_free(&set);
  fixture_close(&f);
}

/* A joint that can't have these motions is refused. */
static void unfit_changes_are_refused(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_joint_change change = {0, "planar", 2, 3};
  km_remedy_set set = {.change_count = 1, .changes = &change};
  km_model *model;
  km_error error;
  assert_int_equal(km_remedy_set_model(f.mechanism, f.state, &set, &model, &error), KM_USAGE);
  assert_null(model);
  assert_non_null(strstr(error.text, "joint A can't become planar"));
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(models_lose_all),
      cmocka_unit_test(overconstrained_loops_lose_all),
      cmocka_unit_test(random_mechanisms_keep_their_mobility),
      cmocka_unit_test(planar_linkages_lose_all),
      cmocka_unit_test(the_motion_stays),
      cmocka_unit_test(two_hinges_on_one_line),
      cmocka_unit_test(incidental_constraints_do_not_count),
      cmocka_unit_test(unfit_changes_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
