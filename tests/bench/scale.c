/* Many four-bars: in substructures of their own, and chained into one. Time must be linear in both. The chain's
 * partition beside the dense engine and SuiteSparse's rank-revealing sparse QR. */
#include "bench.h"
#include "linalg/factor_private.h"

#include "base/text.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "support/chains.h"
#include "support/lattices.h"
#include "support/sheets.h"

#include <stdio.h>
#include <SuiteSparseQR_C.h>

/* Seconds to read, compile, assemble and analyse. */
static double whole(const char *bench, const km_text *text, int mobility) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_mobility found;
  km_error error;
  double start = bench_now();
  if (km_model_read(text->data, text->size, NULL, &model, &error) ||
      km_mechanism_compile(model, NULL, 0, &mechanism, &error) || km_state_create(mechanism, &state, &error) ||
      km_assemble(mechanism, state, NULL, &error))
    bench_fail(bench, "%s", error.text);
  km_mobility_compute(mechanism, state, &found);
  double end = bench_now();
  if (found.mobility != mobility)
    bench_fail(bench, "mobility %d instead of %d", found.mobility, mobility);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return end - start;
}

static void measure(const char *bench, void (*write)(km_text *, int), int n, int mobility) {
  enum { RUNS = 5 };
  double seconds[RUNS];
  char figure[32];
  km_text text = {0};
  write(&text, n);
  for (int i = 0; i < RUNS; ++i)
    seconds[i] = whole(bench, &text, mobility);
  km_text_free(&text);
  snprintf(figure, sizeof figure, "us_per_loop_%d", n);
  bench_figure(bench, figure, 1e6 * bench_median(seconds, RUNS) / n);
}

/* One factorisation of a chain's Jacobian by three engines. */
typedef struct engines {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
  km_factor *dense;
  km_arena arena;
  cholmod_common common;
  cholmod_sparse *J;
  double *whole;
  bool again; /* the sparse engine factors the matrix once more */
} engines;

/* Changes the tolerance in its last digits, so that the cached factorisation isn't used. */
static void run_sparse(void *context) {
  engines *e = context;
  double tolerance = km_rank_tolerance(e->mechanism, &e->mechanism->substructures[0], 0);
  km_search_pivots(e->mechanism, e->state, 0, KM_NO_DRIVER, e->again ? tolerance : tolerance * (1.0 + 1e-12));
  e->again = !e->again;
}

static void run_kept(void *context) {
  engines *e = context;
  if (!km_factor_refactor(e->state->factor[0], km_state_jacobian(e->state, &e->mechanism->substructures[0]),
                          KM_BASIS_SHORT))
    bench_fail("scale/engines", "the pivots of the same values are refused");
}

static void run_dense(void *context) {
  engines *e = context;
  const km_substructure *sub = &e->mechanism->substructures[0];
  km_factor_forget(e->dense);
  km_factor_compute(e->dense, e->whole, sub->rows, sub->columns,
                    &(km_factor_options){.tolerance = km_rank_tolerance(e->mechanism, sub, 0)});
}

/* R and the column order: what the null space needs. */
static void run_spqr(void *context) {
  engines *e = context;
  cholmod_sparse *R = NULL;
  SuiteSparse_long *E = NULL;
  SuiteSparseQR_C(SPQR_ORDERING_COLAMD, 1e-9, 0, 0, e->J, NULL, NULL, NULL, NULL, &R, &E, NULL, NULL, NULL, &e->common);
  cholmod_l_free((size_t)e->J->ncol, sizeof *E, E, &e->common);
  cholmod_l_free_sparse(&R, &e->common);
}

/* Some way along the motion: where nothing is parallel, hardly an entry is 0 by chance. */
static void go_on(engines *e) {
  const km_substructure *sub = &e->mechanism->substructures[0];
  double *move = KM_NEW(double, (size_t)sub->columns);
  km_mobility mobility;
  km_closure closure;
  km_mobility_compute(e->mechanism, e->state, &mobility);
  const double *Z = km_state_basis(e->state, 0), *weight = e->mechanism->column_weight + sub->column_start;
  for (int k = 0; k < km_factor_freedom(e->state->factor[0]) && move; ++k)
    for (int c = 0; c < sub->columns; ++c)
      move[c] += 2.0 * Z[(size_t)k * (size_t)sub->columns + (size_t)c] / weight[c];
  if (move)
    km_state_move(e->mechanism, e->state, sub, move);
  km_free(move);
  if (!move || km_loops_close(e->mechanism, e->state, 0, KM_NO_DRIVER, &closure) != KM_CLOSED)
    bench_fail("scale/engines", "the loops don't close");
}

static void open_engines(engines *e, const km_text *text, bool away) {
  km_error error;
  if (km_model_read(text->data, text->size, NULL, &e->model, &error) ||
      km_mechanism_compile(e->model, NULL, 0, &e->mechanism, &error) ||
      km_state_create(e->mechanism, &e->state, &error) || km_assemble(e->mechanism, e->state, NULL, &error))
    bench_fail("scale/engines", "%s", error.text);
  if (away)
    go_on(e);
  const km_substructure *sub = &e->mechanism->substructures[0];
  e->whole = KM_NEW(double, (size_t)sub->rows *(size_t)sub->columns);
  if (!e->whole)
    bench_fail("scale/engines", "out of memory");
  km_state_jacobian_dense(e->state, sub, e->whole);
  cholmod_l_start(&e->common);
  e->common.SPQR_nthreads = 1;
  cholmod_dense whole = {.nrow = (size_t)sub->rows,
                         .ncol = (size_t)sub->columns,
                         .nzmax = (size_t)sub->rows * (size_t)sub->columns,
                         .d = (size_t)sub->rows,
                         .x = e->whole,
                         .xtype = CHOLMOD_REAL};
  e->J = cholmod_l_dense_to_sparse(&whole, 1, &e->common);
  e->dense = km_factor_create(sub->rows, sub->columns, NULL, &e->arena);
  if (!e->dense)
    bench_fail("scale/engines", "out of memory");
}

static void close_engines(engines *e) {
  km_arena_free(&e->arena);
  km_free(e->whole);
  cholmod_l_free_sparse(&e->J, &e->common);
  cholmod_l_finish(&e->common);
  km_state_free(e->state);
  km_mechanism_free(e->mechanism);
  km_model_free(e->model);
}

/* The name is that of the model and of the figures, behind `over_spqr`. */
static void compare_engines(const char *name, const km_text *text, bool away, int n) {
  enum { MOST_DENSE = 40 };
  const char *const bench = "scale/engines";
  char figure[64];
  engines e = {0};
  open_engines(&e, text, away);
  bench_contender all[4] = {{.name = "sparse", .run = run_sparse, .context = &e},
                            {.name = "sparse, pivots kept", .run = run_kept, .context = &e},
                            {.name = "SPQR", .run = run_spqr, .context = &e},
                            {.name = "dense", .run = run_dense, .context = &e}};
  bench_time(all, n <= MOST_DENSE ? 4 : 3);
  const km_factor *p = e.state->factor[0];
  if (e.common.SPQR_istat[4] != p->rank || (n <= MOST_DENSE && e.dense->rank != p->rank))
    bench_fail(bench, "rank %d, by SPQR %d, dense %d", p->rank, (int)e.common.SPQR_istat[4], e.dense->rank);
  snprintf(figure, sizeof figure, "over_spqr%s_%d", name, n);
  bench_figure(bench, figure, bench_ratio(&all[2], &all[0]));
  snprintf(figure, sizeof figure, "kept_over_spqr%s_%d", name, n);
  bench_figure(bench, figure, bench_ratio(&all[2], &all[1]));
  if (n <= MOST_DENSE) {
    snprintf(figure, sizeof figure, "over_dense%s_%d", name, n);
    bench_figure(bench, figure, bench_ratio(&all[3], &all[0]));
  }
  close_engines(&e);
}

/* As it is drawn, where all columns are left with a single entry in turn, and away from there. */
static void compare_chains(int n) {
  km_text text = {0};
  write_chain(&text, n);
  compare_engines("", &text, false, n);
  compare_engines("_away", &text, true, n);
  km_text_free(&text);
}

static void compare_lattices(int n) {
  km_text trellis = {0}, sheet = {0};
  write_trellis(&trellis, n, n, 0.0);
  compare_engines("_trellis", &trellis, false, n * n);
  write_miura(&sheet, n + 1, n + 1, 0.0);
  compare_engines("_sheet", &sheet, false, n * n);
  km_text_free(&trellis);
  km_text_free(&sheet);
}

void bench_scale(void) {
  for (int n = 10; n <= 10000; n *= 10)
    measure("scale/separate", write_separate, n, n);
  static const int lengths[] = {10, 20, 40, 100, 300, 1000};
  /* The last chain link's coupler hangs free: one freedom more. */
  for (size_t i = 0; i < sizeof lengths / sizeof *lengths; ++i)
    measure("scale/chain", write_chain, lengths[i], 2);
  for (size_t i = 0; i < sizeof lengths / sizeof *lengths; ++i)
    compare_chains(lengths[i]);
  for (int n = 10; n <= 30; n *= 3)
    compare_lattices(n);
}
