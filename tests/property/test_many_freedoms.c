/* Substructures with many freedoms: what is found without a basis of them is what a basis gives. */
#include "linalg/factor_private.h"
#include "support/chains.h"
#include "support/folded.h"
#include "support/lattices.h"
#include "support/laws.h"
#include "support/linkages.h"
#include "support/sheets.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "local/local_private.h"
#include "statics/statics.h"
#include "topology/mechanism.h"

#include <stdio.h>
#include <string.h>

enum { LOOPS = 60 };

static fixture five_bars(int n) {
  km_text text = {0};
  write_five_bars(&text, n, 0.0);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static void laws_of_many_freedoms(void **state) {
  (void)state;
  static const law laws[] = {law_jacobian, law_slopes, law_null_space, law_numbers, law_forced};
  fixture fixtures[] = {five_bars(LOOPS), folded_chain(LOOPS)};
  for (size_t i = 0; i < sizeof fixtures / sizeof *fixtures; ++i) {
    randomness r = {i + 1};
    for (size_t k = 0; k < sizeof laws / sizeof *laws; ++k)
      laws[k](&fixtures[i], &r);
    assert_true(km_factor_freedom(fixtures[i].state->factor[0]) > KM_MANY_VECTORS);
    fixture_close(&fixtures[i]);
  }
}

/* Where every row has a pivot at the coarse tolerance of an open pose, none can be missing at the fine one: the
 * pivots stay, and one search is all that closing takes. */
static void pivots_of_all_rows_stay(void **state) {
  (void)state;
  fixture f = five_bars(LOOPS);
  const km_mechanism *m = f.mechanism;
  const km_substructure *sub = &m->substructures[0];
  km_factor *p = f.state->factor[0];
  randomness r = {7};
  km_closure evidence;
  double *move = KM_NEW(double, (size_t)sub->columns);
  for (int trial = 0; trial < 5; ++trial) {
    for (int k = 0; k < sub->columns; ++k)
      move[k] = uniform(&r, -1e-3, 1e-3);
    km_state_move(m, f.state, sub, move);
    km_state_invalidate_pivots(f.state, 0);
    unsigned before = p->search_count;
    assert_int_equal(km_loops_close(m, f.state, 0, KM_NO_DRIVER, &evidence), KM_CLOSED);
    assert_true(evidence.iterations >= 2);
    assert_int_equal(p->rank, p->rows);
    assert_int_equal(p->search_count, before + 1);
  }
  km_free(move);
  fixture_close(&f);
}

/* The lower bound of the mobility and the number of listed motions. */
static int motions_listed(fixture *f, int *mobility) {
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  int count = found.motion_count;
  *mobility = found.mobility;
  km_finite_mobility_free(&found);
  fixture_close(f);
  return count;
}

/* A folded chain has a motion in which all loops open alike. Many freedoms are left at its first pose and one behind
 * it: what was enough for steps of many isn't for steps of one. */
static void chains_open_evenly(void **state) {
  (void)state;
  int mobility;
  fixture f = fixture_written(write_folded_chain, 150);
  assert_int_equal(motions_listed(&f, &mobility), 2);
  assert_int_equal(mobility, 1);
}

/* A sheet that lies flat folds along its lines, whichever they are: directions that meet all conditions of second
 * order are found, though there are more conditions than freedoms. */
static void flat_sheets_fold(void **state) {
  (void)state;
  int mobility;
  km_text text = {0};
  write_flat_miura(&text, 11, 11);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  assert_true(motions_listed(&f, &mobility) >= 2);
  assert_int_equal(mobility, 10);
}

/* Rows that were primary a step before don't hide the branches that a search at the closed pose leads to. */
static void long_chains_have_several_branches(void **state) {
  (void)state;
  int mobility;
  fixture f = fixture_written(write_folded_chain, 100);
  assert_true(motions_listed(&f, &mobility) >= 2);
}

/* The mobility is known before a basis is computed, and a basis is computed on request. */
static void bases_wait(void **state) {
  (void)state;
  fixture f = five_bars(LOOPS);
  km_mobility mobility;
  km_mobility_compute(f.mechanism, f.state, &mobility);
  assert_int_equal(mobility.mobility, LOOPS + 1);
  assert_int_equal(km_factor_known_null_vectors(f.state->factor[0]), 0);
  size_t n = (size_t)f.mechanism->coordinate_count;
  double *N = KM_NEW(double, n *n);
  int freedom;
  assert_int_equal(km_motions_basis(f.mechanism, f.state, N, &freedom, NULL), KM_OK);
  assert_int_equal(freedom, LOOPS + 1);
  for (size_t c = 0; c < n; ++c) {
    double sum = 0.0;
    for (size_t k = 0; k < (size_t)freedom; ++k)
      sum += N[k * n + c] * N[k * n + c] * f.mechanism->scale[c] * f.mechanism->scale[c];
    assert_near(sum, f.state->mobility_number[c], 1e-11);
  }
  km_free(N);
  fixture_close(&f);
}

/* Every bar of a platform spins; the group of the platform itself is solved by its entries. */
static void bars_of_a_platform(void **state) {
  (void)state;
  static const law laws[] = {law_jacobian, law_slopes, law_null_space, law_numbers};
  km_text text = {0};
  write_bars(&text, LOOPS, 0.0);
  fixture f = fixture_read(text.data);
  randomness r = {1};
  for (size_t k = 0; k < sizeof laws / sizeof *laws; ++k)
    laws[k](&f, &r);
  km_passive_freedoms idle;
  assert_int_equal(km_passive_freedoms_find(f.mechanism, f.state, NULL, NULL, &idle, NULL), KM_OK);
  assert_int_equal(idle.mobility, LOOPS);
  assert_int_equal(idle.count, LOOPS);
  km_passive_freedoms_free(&idle);
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f.mechanism, f.state, NULL, NULL, &found, NULL), KM_OK);
  assert_int_equal(found.mobility, LOOPS);
  assert_false(found.undecided);
  km_finite_mobility_free(&found);
  fixture_close(&f);
  km_text_free(&text);
}

static km_finite_mobility find(fixture *f) {
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  return found;
}

static void many_real_freedoms(void **state) {
  (void)state;
  fixture f = five_bars(LOOPS);
  km_finite_mobility found = find(&f);
  assert_int_equal(found.mobility, LOOPS + 1);
  assert_false(found.undecided);
  assert_true(found.truncated && found.motion_count == 1 && found.motions[0].kind == KM_MOTION_REGULAR);
  assert_true(found.motions[0].confirmed_length > 0.3);
  km_finite_mobility_free(&found);
  fixture_close(&f);
}

/* The motion of few freedoms that goes along x in one sense or the other; -1: none does. */
static int motion_along(const fixture *f, const km_finite_mobility *few, const km_local *t, const double *x) {
  const int *coordinate = f->mechanism->column_coordinate + t->sub->column_start;
  const double *weight = f->mechanism->column_weight + t->sub->column_start;
  for (int i = 0; i < few->motion_count; ++i) {
    double along = 0.0;
    for (int c = 0; c < t->sub->columns; ++c)
      along += weight[c] * x[c] * few->motions[i].direction[coordinate[c]];
    if (fabs(along) > 0.999)
      return i;
  }
  return -1;
}

/* All starts by columns at a pose that the basis decides: they find its branches, each of them, and no other ones; and
 * all tangents are real by the one where they are by the other. Returns whether there were any branches. */
static bool compare(fixture f) {
  const km_mechanism *m = f.mechanism;
  km_finite_mobility few = find(&f);
  km_arena arena = {0};
  bool met[KM_MAX_FINITE_MOTIONS] = {false};
  assert_false(few.undecided || few.truncated);
  km_local *l = km_local_create(m, f.state, 0, NULL, 0.0, &arena);
  assert_true(l && km_local_reserve_tangents(l, false));
  double *x = KM_ARENA_NEW(&arena, double, (size_t)l->sub->columns);
  bool regular = few.motion_count == 0 || few.motions[0].kind == KM_MOTION_REGULAR;
  bool branches = few.motion_count > 0 && few.motions[0].kind == KM_MOTION_BRANCH;
  if (l->freedom > 0)
    assert_int_equal(km_local_is_regular(l), regular);
  for (int start = 0; start < 100 * l->freedom && !regular; ++start) {
    if (!km_local_draw(l, &l->random, l->a) || !km_local_solve_second_order(l, l->a))
      continue;
    km_local_direction(l, l->a, x);
    if (km_local_follow_both_senses(l, x).verdict < KM_TANGENT_CONFIRMED)
      continue;
    int i = motion_along(&f, &few, l, x);
    assert_true(i >= 0 && few.motions[i].kind == KM_MOTION_BRANCH);
    met[i] = true;
  }
  for (int i = 0; i < few.motion_count && branches; ++i)
    assert_true(met[i]);
  km_local_free(l);
  km_arena_free(&arena);
  km_finite_mobility_free(&few);
  fixture_close(&f);
  return branches;
}

/* A four-bar on one line with a = c, b = d; otherwise it is infinitesimally mobile. */
static fixture flat_fourbar(randomness *r, bool change_point) {
  double crank = uniform(r, 0.2, 0.8), base = uniform(r, 1, 2), rocker = change_point ? crank : uniform(r, 0.2, 0.8);
  const km_vec3 z = {0, 0, 1}, along[4] = {z, z, z, z};
  const km_vec3 at[4] = {{0, 0, 0}, {crank, 0, 0}, {base + rocker, 0, 0}, {base, 0, 0}};
  linkage l = hinged_loop(at, along, 4);
  return linkage_open(&l, r);
}

static void sparse_is_dense(void **state) {
  (void)state;
  int branched = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    randomness r = {seed};
    branched += compare(flat_fourbar(&r, seed % 2));
    linkage l = moving_loop(below(&r, MOVING_KINDS), &r);
    branched += compare(linkage_open(&l, &r));
  }
  for (int n = 1; n <= 3; ++n)
    branched += compare(folded_chain(n));
  assert_true(branched >= 33);
}

static void hold(const fixture *f, km_forces *forces, const int *actuators, int count, km_statics *out) {
  assert_int_equal(km_statics_create(f->mechanism, actuators, count, KM_AXES_JOINT, out, NULL), KM_OK);
  assert_int_equal(km_statics_balance(f->mechanism, f->state, forces, out), KM_OK);
}

/* They move no actuator, and keep the loops closed. */
static void assert_unreached(const fixture *f, const km_statics *st, const int *actuators) {
  const km_substructure *sub = &f->mechanism->substructures[0];
  size_t rows = (size_t)sub->rows;
  double *J = KM_NEW(double, rows *(size_t)sub->columns), *error = KM_NEW(double, rows);
  km_state_jacobian_dense(f->state, sub, J);
  for (int d = 0; d < st->direction_count && d < KM_MAX_DIRECTIONS; ++d) {
    const double *rates = st->directions + (size_t)d * (size_t)f->mechanism->coordinate_count;
    for (int i = 0; i < st->actuator_count; ++i)
      assert_near(rates[actuators[i]], 0.0, 1e-9);
    memset(error, 0, rows * sizeof *error);
    for (int k = 0; k < sub->columns; ++k)
      for (size_t r = 0; r < rows; ++r) {
        int c = f->mechanism->column_coordinate[sub->column_start + k];
        error[r] += J[(size_t)k * rows + r] * rates[c] / f->mechanism->unit[c];
      }
    for (size_t r = 0; r < rows; ++r)
      assert_near(error[r], 0.0, 1e-9);
  }
  km_free(J);
  km_free(error);
}

/* Forces that hold balance the loads in every motion z of the whole basis, Z_Aᵀ F + Zᵀ D⁻¹ τ = 0, without a part that
 * does no work; otherwise the loads do work in the first direction. Every actuator counts for one freedom. */
static void assert_balanced(const fixture *f, const km_forces *forces, const km_statics *st, const int *actuators) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = &m->substructures[0];
  int freedom = km_factor_freedom(f->state->factor[0]), count = st->actuator_count;
  const double *z = km_state_basis(f->state, 0);
  double work = 0.0, *F = KM_NEW(double, (size_t)count + 1);
  for (int i = 0; i < count; ++i)
    F[i] = st->actuator_forces[i] / m->scale[actuators[i]];
  for (int k = 0; k < freedom && st->held; ++k, z += sub->columns) {
    double sum = 0.0;
    for (int j = 0; j < sub->columns; ++j)
      sum += z[j] * forces->joint[m->column_coordinate[j]] / m->scale[m->column_coordinate[j]];
    for (int i = 0; i < count; ++i)
      sum += z[m->column_of[actuators[i]]] * st->actuator_forces[i] / m->scale[actuators[i]];
    assert_near(sum, 0.0, 1e-9);
    for (int i = 0; i < count && count == m->coordinate_count; ++i) {
      double along = 0.0;
      for (int n = 0; n < count; ++n)
        along += z[m->column_of[actuators[n]]] * st->actuator_forces[n] / m->scale[actuators[n]];
      F[i] -= along * z[m->column_of[actuators[i]]];
    }
  }
  for (int i = 0; i < count && count == m->coordinate_count && st->held; ++i)
    assert_near(F[i], 0.0, 1e-9);
  for (int c = 0; c < m->coordinate_count && !st->held; ++c)
    work += forces->joint[c] * st->directions[c];
  assert_true(st->held || (st->falls[0] && work > 1e-6));
  assert_int_equal(st->direction_count, count < freedom ? freedom - count : 0);
  assert_int_equal(st->redundant, count > freedom);
  km_free(F);
}

/* Few actuators, or all joints, under loads that they hold or don't. */
static void forces_of_many_freedoms(void **state) {
  (void)state;
  enum { MOST = 7 };
  randomness r = {11};
  fixture f = five_bars(150); /* twice as many freedoms as actuators and stored directions */
  int coordinates = f.mechanism->coordinate_count, *all = KM_NEW(int, (size_t)coordinates), held = 0;
  km_mobility mobility;
  km_forces *forces;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  for (int c = 0; c < coordinates; ++c)
    all[c] = c;
  for (int n = 0; n < 40; ++n) {
    int actuators[MOST], count = n % 8 == 7 ? coordinates : n % (MOST + 1);
    km_statics many;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    km_forces_compute(f.mechanism, f.state, forces);
    forces->couple_size = 1.0;
    for (int c = 0; c < coordinates; ++c)
      forces->joint[c] = n % 3 == 0 ? 0.0 : uniform(&r, -1.0, 1.0);
    for (int i = 0; i < count && count < coordinates; ++i)
      actuators[i] = i * (coordinates / MOST) + (int)uniform(&r, 0.0, 20.0);
    hold(&f, forces, count < coordinates ? actuators : all, count, &many);
    assert_true(n > 0 ||
                km_factor_known_null_vectors(f.state->factor[0]) == 0); /* later those of the whole basis are there */
    assert_balanced(&f, forces, &many, count < coordinates ? actuators : all);
    assert_unreached(&f, &many, count < coordinates ? actuators : all);
    held += many.held;
    km_statics_free(&many);
  }
  assert_true(held > 10 && held < 30);
  km_forces_free(forces);
  km_free(all);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(laws_of_many_freedoms),
      cmocka_unit_test(bases_wait),
      cmocka_unit_test(pivots_of_all_rows_stay),
      cmocka_unit_test(chains_open_evenly),
      cmocka_unit_test(flat_sheets_fold),
      cmocka_unit_test(many_real_freedoms),
      cmocka_unit_test(long_chains_have_several_branches),
      cmocka_unit_test(sparse_is_dense),
      cmocka_unit_test(bars_of_a_platform),
      cmocka_unit_test(forces_of_many_freedoms),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
