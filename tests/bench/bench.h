/* Timing and reporting shared by the benchmarks. A figure is a number to follow, never a pass or a fail; what
 * fails, loudly, is a disagreement between the results of what is compared. */
#ifndef BENCH_H
#define BENCH_H

#include <stdbool.h>

enum { BENCH_ROUNDS = 41, BENCH_MOST = 8 };

/* Something to be timed: `run` does its work once. */
typedef struct bench_contender {
  const char *name;
  void (*run)(void *context);
  void *context;
  double ns[BENCH_ROUNDS]; /* nanoseconds per call, one per round; set by bench_time */
  double median;           /* median of ns; set by bench_time */
} bench_contender;

/* Times all contenders in turn, BENCH_ROUNDS times over, each for about a millisecond a round: what slows the
 * machine down for a while slows all of them. */
void bench_time(bench_contender *contenders, int count);

/* Median over the rounds of a's time over b's. */
double bench_ratio(const bench_contender *a, const bench_contender *b);

double bench_median(double *values, int count); /* sorts them */
double bench_now(void);                         /* seconds */

/* One line of JSON on the standard output. */
void bench_figure(const char *bench, const char *figure, double value);

/* Says what disagrees and exits with 1. */
_Noreturn void bench_fail(const char *bench, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* bench_fail unless |a_i − b_i| ≤ tolerance for all i. */
void bench_agree(const char *bench, const char *what, const double *a, const double *b, int count, double tolerance);

/* The benchmarks, one a file. */
void bench_partition(void);
void bench_sweep(void);
void bench_lanes(void);
void bench_command(void);
void bench_large(void);
void bench_scale(void);
void bench_forces(void);
void bench_arm(void);
void bench_study(void);
void bench_load(void);
void bench_dynamics(void);
void bench_view(void); /* only if kview is built */

#endif
