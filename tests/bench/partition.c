/* Rank, null space and mobility numbers of the excavator from given values of its Jacobian: its substructures
 * one by one, pivots searched or kept, against LAPACK and our own elimination on the whole matrix. */
#include "bench.h"
#include "kinematics/loop_closing.h"
#include "kmech/continuation.h"
#include "lapack.h"
#include "linalg/factor_private.h"
#include "machine.h"

#include <stdlib.h>
#include <string.h>

enum { POSES = 16, PARTS = 3, ROWS = 30, COLUMNS = 20, BLOCK = 64 };
static const char name[] = "partition/excavator";
static const char *const drivers[PARTS] = {"M", "N", "O"};
/* Metres over all the poses: neighbours, as in a sweep or a simulation. The search bets on the last pivots
 * (register_elimination.c): on matrices that have nothing to do with each other it takes about twice as long, with
 * the same results. */
static const double stroke = 0.08;
static const double tolerance = 1e-8;

/* A substructure at every pose. */
typedef struct part {
  int rows, columns;
  const double *weight;
  const int *coordinate;
  double J[POSES][BLOCK];
  km_factor *found, *kept;
  double numbers[COLUMNS];
} part;

typedef struct problem {
  km_arena arena;
  part parts[PARTS];
  double whole[POSES][ROWS * COLUMNS]; /* six rows a loop, a column a joint, columns over their weights */
  km_factor *dense;
  double dense_numbers[COLUMNS];
  lapack_space lapack;
  int pose; /* the next one */
} problem;

/* The part's loops in the whole matrix: x, y and turn of the mechanism's plane are vx, vz and wy of six rows. */
static void place(problem *p, int pose, const part *a, int first_loop) {
  static const int row_of[3] = {0, 2, 4};
  for (int k = 0; k < a->columns; ++k)
    for (int r = 0; r < a->rows; ++r) {
      int row = 6 * (first_loop + r / 3) + row_of[r % 3];
      p->whole[pose][a->coordinate[k] * ROWS + row] = a->J[pose][k * a->rows + r] / a->weight[k];
    }
}

static void read_poses(problem *p, bench_machine *machine, int index) {
  const km_mechanism *m = machine->mechanism;
  int driver = bench_machine_coordinate(machine, drivers[index]), s = m->substructure_of[driver];
  const km_substructure *sub = &m->substructures[s];
  part *a = &p->parts[index];
  if (sub->rows != 3 * sub->loop_count || sub->rows * sub->columns > BLOCK)
    bench_fail(name, "the loops are not planar ones, or have grown");
  a->rows = sub->rows;
  a->columns = sub->columns;
  a->weight = m->column_weight + sub->column_start;
  a->coordinate = m->column_coordinate + sub->column_start;
  km_driver_motion *drive;
  if (km_driver_motion_create(m, machine->state, driver, false, &drive, NULL))
    bench_fail(name, "no drive for %s", drivers[index]);
  double from = km_state_coordinate(machine->state, driver);
  for (int i = 0; i < POSES; ++i) {
    if (km_driver_motion_move_to(drive, from + stroke * (i + 1) / POSES).stop)
      bench_fail(name, "%s can't move", drivers[index]);
    memcpy(a->J[i], km_state_jacobian(machine->state, sub), (size_t)(a->rows * a->columns) * sizeof(double));
    place(p, i, a, sub->loop_start);
  }
  km_driver_motion_free(drive);
  a->found = km_factor_create(a->rows, a->columns, a->weight, &p->arena);
  a->kept = km_factor_create(a->rows, a->columns, a->weight, &p->arena);
  km_factor_compute(a->kept, a->J[0], a->rows, a->columns, &(km_factor_options){.tolerance = tolerance});
}

/* The rigid joint A has no coordinate: 19 columns belong to joints, the last one is its empty one. */
static void read_problem(problem *p, bench_machine *machine) {
  *p = (problem){0};
  for (int i = 0; i < PARTS; ++i)
    read_poses(p, machine, i);
  p->dense = km_factor_create(ROWS, COLUMNS, NULL, &p->arena);
}

static int next_pose(problem *p) {
  return p->pose = (p->pose + 1) % POSES;
}

static void read_numbers(part *a, km_factor *partition) {
  int freedom = km_factor_freedom(partition);
  km_mobility_numbers(km_factor_null_space(partition, freedom), a->columns, freedom, a->numbers);
}

static void run_searched(void *context) {
  problem *p = context;
  int pose = next_pose(p);
  for (int i = 0; i < PARTS; ++i) {
    part *a = &p->parts[i];
    km_factor_compute(a->found, a->J[pose], a->rows, a->columns, &(km_factor_options){.tolerance = tolerance});
    read_numbers(a, a->found);
  }
}

static void run_kept(void *context) {
  problem *p = context;
  int pose = next_pose(p);
  for (int i = 0; i < PARTS; ++i) {
    part *a = &p->parts[i];
    if (!km_factor_refactor(a->kept, a->J[pose], KM_BASIS_SHORT))
      bench_fail(name, "the monitor refuses the pivots of the first pose");
    read_numbers(a, a->kept);
  }
}

static void run_dense(void *context) {
  problem *p = context;
  km_factor_compute(p->dense, p->whole[next_pose(p)], ROWS, COLUMNS, &(km_factor_options){.tolerance = tolerance});
  int freedom = km_factor_freedom(p->dense);
  km_mobility_numbers(km_factor_null_space(p->dense, freedom), COLUMNS, freedom, p->dense_numbers);
}

static void run_svd(void *context) {
  problem *p = context;
  lapack_by_svd(&p->lapack, p->whole[next_pose(p)], ROWS, COLUMNS, tolerance);
}

static void run_qr(void *context) {
  problem *p = context;
  lapack_by_qr(&p->lapack, p->whole[next_pose(p)], ROWS, COLUMNS, tolerance);
}

/* The numbers of the parts in the whole matrix's order, and the rank. */
static int gather(const problem *p, bool kept, double *numbers) {
  int rank = 0;
  for (int i = 0; i < COLUMNS; ++i)
    numbers[i] = 1.0; /* outside loops */
  for (int i = 0; i < PARTS; ++i) {
    const part *a = &p->parts[i];
    rank += kept ? a->kept->rank : a->found->rank;
    for (int k = 0; k < a->columns; ++k)
      numbers[a->coordinate[k]] = a->numbers[k];
  }
  return rank;
}

static void check(problem *p) {
  for (int i = 0; i < POSES; ++i) {
    void (*const run[])(void *) = {run_svd, run_searched, run_kept, run_dense, run_qr};
    double svd[COLUMNS], numbers[COLUMNS];
    int rank = 0, svd_rank = 0;
    for (int k = 0; k < 5; ++k) {
      p->pose = i;
      run[k](p);
      if (k == 1 || k == 2)
        rank = gather(p, k == 2, numbers);
      else
        memcpy(numbers, k == 3 ? p->dense_numbers : p->lapack.numbers, sizeof numbers);
      if (k == 3 || k == 4)
        rank = k == 3 ? p->dense->rank : p->lapack.rank;
      if (k == 0) {
        svd_rank = p->lapack.rank;
        memcpy(svd, numbers, sizeof svd);
        continue;
      }
      if (rank != svd_rank)
        bench_fail(name, "ranks disagree: %d and %d", rank, svd_rank);
      bench_agree(name, "mobility numbers", numbers, svd, COLUMNS, 1e-10);
    }
  }
}

void bench_partition(void) {
  static problem p;
  bench_machine machine = bench_machine_load("excavator");
  read_problem(&p, &machine);
  check(&p);
  bench_contender c[] = {{.name = "substructures", .run = run_searched, .context = &p},
                         {.name = "substructures, kept", .run = run_kept, .context = &p},
                         {.name = "whole, dense", .run = run_dense, .context = &p},
                         {.name = "whole, dgesdd", .run = run_svd, .context = &p},
                         {.name = "whole, dgeqp3", .run = run_qr, .context = &p}};
  bench_time(c, sizeof c / sizeof *c);
  bench_figure(name, "over_dgesdd", bench_ratio(&c[3], &c[0]));
  bench_figure(name, "over_dgeqp3", bench_ratio(&c[4], &c[0]));
  bench_figure(name, "over_dense", bench_ratio(&c[2], &c[0]));
  bench_figure(name, "kept_over_dgesdd", bench_ratio(&c[3], &c[1]));
  km_arena_free(&p.arena);
  bench_machine_free(&machine);
}
