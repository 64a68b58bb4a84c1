/* The excavator's static balance (f̄, actuators, every reaction) against LAPACK's least-norm solution of all equations
 * of equilibrium at once, which gets its matrix for free; and its leverage, which needs the null space alone. */
#include "bench.h"
#include "kinematics/body_poses.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"
#include "machine.h"
#include "support/bordered.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

typedef struct holding {
  bench_machine machine;
  km_forces *forces;
  km_statics statics;
  km_transfer *lever;
  bordered all;
  double *A, *rhs, *sigma;
} holding;

static void run_ours(void *context) {
  holding *h = context;
  km_statics_compute(h->machine.mechanism, h->machine.state, h->forces, &h->statics);
}

static void run_lapack(void *context) {
  holding *h = context;
  int m = h->all.rows, n = h->all.columns, rank;
  memcpy(h->A, h->all.A, (size_t)m * (size_t)n * sizeof *h->A);
  memcpy(h->rhs, h->all.rhs, (size_t)(m > n ? m : n) * sizeof *h->rhs);
  if (LAPACKE_dgelsd(LAPACK_COL_MAJOR, m, n, 1, h->A, m, h->rhs, m > n ? m : n, h->sigma, 1e-9, &rank))
    bench_fail("forces", "dgelsd");
}

static void run_lever(void *context) {
  holding *h = context;
  km_advantage a;
  km_transfer_compute(h->machine.mechanism, h->machine.state, h->lever, &a);
}

static holding start(void) {
  holding h = {.machine = bench_machine_load("excavator")};
  const km_mechanism *m = h.machine.mechanism;
  km_state *s = h.machine.state;
  km_mobility mobility;
  km_port input = {.kind = KM_PORT_JOINT, .coordinate = bench_machine_coordinate(&h.machine, "L")};
  km_port output = {.kind = KM_PORT_JOINT, .coordinate = bench_machine_coordinate(&h.machine, "C")};
  km_mobility_compute(m, s, &mobility);
  if (km_forces_create(m, NULL, NULL, 0, &h.forces, NULL) ||
      km_statics_create(m, NULL, 0, KM_AXES_JOINT, &h.statics, NULL) ||
      km_transfer_create(m, &input, &output, &h.lever, NULL))
    bench_fail("forces", "no balance");
  run_ours(&h);
  km_poses_compute(m, s);
  h.all = bordered_make(m, s, h.forces, h.statics.least_norm, 1.0);
  size_t rows = (size_t)h.all.rows, columns = (size_t)h.all.columns;
  h.A = KM_NEW(double, rows *columns);
  h.rhs = KM_NEW(double, rows + columns);
  h.sigma = KM_NEW(double, rows + columns);
  return h;
}

static void check(holding *h) {
  double largest = 0.0;
  run_ours(h);
  run_lapack(h);
  for (int i = 0; i < h->all.columns; ++i)
    largest = fmax(largest, fabs(h->rhs[i]));
  for (int j = 0; j < h->machine.model->joint_count; ++j) {
    const km_reaction *r = &h->statics.reactions[j];
    bench_agree("forces", "forces", r->force, h->rhs + 6 * j, 3, 1e-9 * largest);
    bench_agree("forces", "torques", r->torque, h->rhs + 6 * j + 3, 3, 1e-9 * largest);
  }
}

void bench_forces(void) {
  holding h = start();
  check(&h);
  bench_contender c[] = {{.name = "balance", .run = run_ours, .context = &h},
                         {.name = "balance by dgelsd", .run = run_lapack, .context = &h},
                         {.name = "leverage", .run = run_lever, .context = &h}};
  bench_time(c, sizeof c / sizeof *c);
  bench_figure("forces/excavator", "lapack_over", bench_ratio(&c[1], &c[0]));
  bench_figure("forces/excavator", "balances_per_second", 1e9 / c[0].median);
  bench_figure("forces/excavator", "advantages_per_second", 1e9 / c[2].median);
  bordered_free(&h.all);
  km_free(h.A);
  km_free(h.rhs);
  km_free(h.sigma);
  km_transfer_free(h.lever);
  km_statics_free(&h.statics);
  km_forces_free(h.forces);
  bench_machine_free(&h.machine);
}
