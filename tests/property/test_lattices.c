/* Ranks of substructures of up to ten thousand loops, anywhere in space, against SuiteSparse's rank-revealing QR. */
#include "support/chains.h"
#include "support/lattices.h"
#include "support/laws.h"
#include "support/sheets.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "topology/short_loops.h"

#include <SuiteSparseQR_C.h>

/* SPQR's rank of the Jacobian that the partition had, with the same tolerance. */
static int rank_by_spqr(fixture *f, double tolerance) {
  const km_substructure *sub = &f->mechanism->substructures[0];
  const km_pattern *pattern = &sub->pattern;
  cholmod_common common;
  cholmod_l_start(&common);
  cholmod_triplet *T =
      cholmod_l_allocate_triplet((size_t)sub->rows, (size_t)sub->columns, pattern->size, 0, CHOLMOD_REAL, &common);
  const double *values = km_state_jacobian(f->state, sub);
  for (int c = 0, k = 0; c < sub->columns; ++c) {
    int first = pattern->start ? pattern->start[c] : c * sub->rows;
    int end = pattern->start ? pattern->start[c + 1] : first + sub->rows;
    for (int i = first; i < end; ++i, ++k) {
      ((SuiteSparse_long *)T->i)[k] = pattern->start ? pattern->row[i] : i - first;
      ((SuiteSparse_long *)T->j)[k] = c;
      ((double *)T->x)[k] = values[i];
    }
  }
  T->nnz = pattern->size;
  cholmod_sparse *J = cholmod_l_triplet_to_sparse(T, 0, &common), *R = NULL;
  SuiteSparse_long *E = NULL;
  SuiteSparseQR_C(SPQR_ORDERING_COLAMD, tolerance, 0, 0, J, NULL, NULL, NULL, NULL, &R, &E, NULL, NULL, NULL, &common);
  int rank = (int)common.SPQR_istat[4];
  cholmod_l_free((size_t)sub->columns, sizeof *E, E, &common);
  cholmod_l_free_sparse(&R, &common);
  cholmod_l_free_sparse(&J, &common);
  cholmod_l_free_triplet(&T, &common);
  cholmod_l_finish(&common);
  return rank;
}

/* One substructure of `loops` loops, in the plane if `planar`; mobility 1. */
static void check(const km_text *text, int loops, bool planar) {
  assert_false(text->failed);
  fixture f = fixture_read(text->data);
  km_mobility mobility;
  km_substructure_mobility evidence;
  km_mobility_compute(f.mechanism, f.state, &mobility);
  assert_int_equal(km_substructure_count(f.mechanism), 1);
  km_substructure_evidence(f.mechanism, f.state, 0, &evidence);
  assert_int_equal(evidence.loops, loops);
  for (int l = 0; l < loops && planar; ++l)
    assert_int_equal(f.mechanism->loops[l].lambda, 3);
  assert_near(evidence.rank, rank_by_spqr(&f, evidence.tolerance * km_factor_get_evidence(f.state->factor[0]).scale),
              0.0);
  assert_int_equal(mobility.mobility, 1);
  assert_true(mobility.residual < 1e-9);
  fixture_close(&f);
}

typedef void (*writer)(km_text *out, int rows, int columns, double away);

static void chain(km_text *out, int rows, int columns, double away) {
  write_drawn_chain(out, rows * columns, away);
}

/* `more`: bodies more than loops in each direction; panels share corners, bars don't. */
static void check_sizes(writer write, int most, int more) {
  static const double away[] = {0.0, 1000.0};
  for (int n = 2; n <= most; n *= 3)
    for (size_t i = 0; i < sizeof away / sizeof *away; ++i) {
      km_text text = {0};
      write(&text, n + more, n + 1 + more, away[i]);
      check(&text, n * (n + 1), more == 0);
      km_text_free(&text);
    }
}

static void chains(void **state) {
  (void)state;
  check_sizes(chain, 99, 0);
}

static void trellises(void **state) {
  (void)state;
  check_sizes(write_trellis, 99, 0);
}

static void miuras(void **state) {
  (void)state;
  check_sizes(write_miura, 99, 1);
}

/* Loops of large substructures share joints that no tree's loops share. */
static void laws_of_large_lattices(void **state) {
  (void)state;
  static const law laws[] = {law_jacobian, law_slopes, law_null_space, law_numbers, law_forced, law_twists};
  static const writer writers[] = {chain, write_trellis, write_miura};
  for (size_t i = 0; i < sizeof writers / sizeof *writers; ++i) {
    km_text text = {0};
    randomness r = {i + 1};
    writers[i](&text, 8, 9, 0.0);
    fixture f = fixture_read(text.data);
    assert_true(f.mechanism->topology.loop_count > KM_MAX_TREE_LOOPS);
    go_somewhere(&f, &r);
    for (size_t k = 0; k < sizeof laws / sizeof *laws; ++k)
      laws[k](&f, &r);
    fixture_close(&f);
    km_text_free(&text);
  }
}

typedef struct shape {
  void (*write)(km_text *out, int rows, int columns);
  int loops, mobility;
} shape;

static void folded(km_text *out, int rows, int columns) {
  write_folded_chain(out, rows * columns);
}

static void five_bars(km_text *out, int rows, int columns) {
  write_five_bars(out, rows * columns, 0.0);
}

static void flat_five_bars(km_text *out, int rows, int columns) {
  write_flat_five_bars(out, rows * columns);
}

static void stretched_five_bars(km_text *out, int rows, int columns) {
  write_stretched_five_bars(out, rows * columns);
}

static void ball_couplers(km_text *out, int rows, int columns) {
  write_ball_couplers(out, rows * columns);
}

static void balls(km_text *out, int rows, int columns) {
  write_balls(out, rows * columns);
}

static void bars(km_text *out, int rows, int columns) {
  write_bars(out, rows * columns + 1, 0.0);
}

/* Links on one line, or panels in one plane, let every link or fold move at first. */
static void shapes_move_as_is_said(void **state) {
  (void)state;
  enum { R = 8, C = 9, N = R * C };
  static const shape shapes[] = {
      {folded, N, N + 1},
      {five_bars, N, N + 1},
      {flat_five_bars, N, 2 * N + 1},
      {stretched_five_bars, N, 2 * N + 1},
      {ball_couplers, N, N + 1},
      {balls, N, 3 * N + 3},
      {bars, N, N + 1},
      {write_grid, N, R + C - 1},
      {write_bent_grid, N, R + C - 1},
      {write_stiff_grid, 2 * N, 1},
      {write_bent_trellis, N, 1},
      {write_flat_miura, (R - 1) * (C - 1), R + C - 2},
      {write_triangles, (R - 1) * (C - 1), 2 * (R + C) - 3},
  };
  for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
    km_text text = {0};
    shapes[i].write(&text, R, C);
    fixture f = fixture_read(text.data);
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(f.mechanism->topology.loop_count, shapes[i].loops);
    assert_int_equal(km_substructure_count(f.mechanism), 1);
    assert_int_equal(mobility.mobility, shapes[i].mobility);
    assert_at_most(mobility.residual, 1e-9);
    fixture_close(&f);
    km_text_free(&text);
  }
}

/* A chain whose links lie on one line has a motion of every link, and a step loses what it has of all of them. */
static void many_motions(void **state) {
  (void)state;
  enum { LOOPS = 60 };
  km_text text = {0};
  randomness r = {5};
  write_chain(&text, LOOPS);
  fixture f = fixture_read(text.data);
  const km_mechanism *m = f.mechanism;
  const km_substructure *sub = &m->substructures[0];
  size_t columns = (size_t)sub->columns;
  double *zero = KM_NEW(double, (size_t)m->coordinate_count), *x = KM_NEW(double, columns);
  double *rest = KM_NEW(double, columns);
  assert_int_equal(km_state_set_coordinates(m, f.state, zero, NULL), KM_OK);
  km_loops_update(m, f.state, sub);
  law_numbers(&f, &r);
  int freedom = km_factor_freedom(f.state->factor[0]);
  assert_true(freedom > KM_MANY_VECTORS && km_factor_rank(f.state->factor[0]) > KM_MANY_VECTORS);
  const double *weight = m->column_weight + sub->column_start, *Z = km_factor_null_space(f.state->factor[0], freedom);
  for (size_t c = 0; c < columns; ++c)
    rest[c] = x[c] = uniform(&r, -1.0, 1.0);
  for (int k = 0; k < freedom; ++k) {
    double along = 0.0;
    for (size_t c = 0; c < columns; ++c)
      along += Z[(size_t)k * columns + c] * weight[c] * x[c];
    for (size_t c = 0; c < columns; ++c)
      rest[c] -= along * Z[(size_t)k * columns + c] / weight[c];
  }
  km_minimum_norm_step(m, f.state, 0, KM_NO_DRIVER, x);
  for (size_t c = 0; c < columns; ++c)
    assert_near(x[c], rest[c], 1e-11);
  km_free(zero);
  km_free(x);
  km_free(rest);
  fixture_close(&f);
  km_text_free(&text);
}

/* A crank turns those behind it in the same way, whatever comes behind these. As they were drawn many entries of the
 * rows are 0 that aren't any longer once they move, and the couplers turn about themselves: one freedom of many, few
 * or more. */
static void cranks_turn_alike(void **state) {
  (void)state;
  enum { FIRST = 5 };
  static const int loops[] = {FIRST, 2 * FIRST, 40, 60};
  double turned[FIRST + 1];
  for (int i = 0; i < 4; ++i) {
    km_text text = {0};
    write_ball_couplers(&text, loops[i]);
    fixture f = fixture_read(text.data);
    km_driver_motion *drive;
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
    assert_int_equal(km_driver_motion_move_to(drive, 0.1).stop, KM_STOP_NONE);
    for (int k = 0; k <= FIRST; ++k)
      if (i == 0)
        turned[k] = km_state_coordinate(f.state, k);
      else
        assert_near(km_state_coordinate(f.state, k), turned[k], 1e-12);
    km_driver_motion_free(drive);
    fixture_close(&f);
    km_text_free(&text);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(chains, "Ranks of chains of up to 9900 loops are those of SuiteSparse's rank-revealing QR",
                 "none: whole numbers"),
      claim_test(trellises, "Ranks of trellises of up to 9900 loops are those of SuiteSparse's rank-revealing QR",
                 "none: whole numbers"),
      claim_test(miuras, "Ranks of folded sheets of up to 9900 loops are those of SuiteSparse's rank-revealing QR",
                 "none: whole numbers"),
      cmocka_unit_test(shapes_move_as_is_said),
      cmocka_unit_test(laws_of_large_lattices),
      cmocka_unit_test(many_motions),
      cmocka_unit_test(cranks_turn_alike),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
