#include "bench.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

double bench_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double time_calls(const bench_contender *c, long calls) {
  double start = bench_now();
  for (long i = 0; i < calls; ++i)
    c->run(c->context);
  return bench_now() - start;
}

/* Number of calls that take about a millisecond. */
static long calibrate(const bench_contender *c) {
  long calls = 1;
  while (time_calls(c, calls) < 1e-3 && calls < 1L << 30)
    calls *= 2;
  return calls;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double bench_median(double *values, int count) {
  qsort(values, (size_t)count, sizeof *values, ascending);
  return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

void bench_time(bench_contender *contenders, int count) {
  long calls[BENCH_MOST];
  for (int i = 0; i < count; ++i)
    calls[i] = calibrate(&contenders[i]);
  for (int round = 0; round < BENCH_ROUNDS; ++round)
    for (int i = 0; i < count; ++i)
      contenders[i].ns[round] = 1e9 * time_calls(&contenders[i], calls[i]) / (double)calls[i];
  for (int i = 0; i < count; ++i) {
    double sorted[BENCH_ROUNDS];
    for (int round = 0; round < BENCH_ROUNDS; ++round)
      sorted[round] = contenders[i].ns[round];
    contenders[i].median = bench_median(sorted, BENCH_ROUNDS);
    fprintf(stderr, "  %-24s %12.1f ns\n", contenders[i].name, contenders[i].median);
  }
}

double bench_ratio(const bench_contender *a, const bench_contender *b) {
  double ratios[BENCH_ROUNDS];
  for (int round = 0; round < BENCH_ROUNDS; ++round)
    ratios[round] = a->ns[round] / b->ns[round];
  return bench_median(ratios, BENCH_ROUNDS);
}

void bench_figure(const char *bench, const char *figure, double value) {
  printf("{\"bench\": \"%s\", \"figure\": \"%s\", \"value\": %.4g}\n", bench, figure, value);
  fflush(stdout);
}

void bench_fail(const char *bench, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fprintf(stderr, "bench %s: ", bench);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  exit(1);
}

void bench_agree(const char *bench, const char *what, const double *a, const double *b, int count, double tolerance) {
  for (int i = 0; i < count; ++i)
    if (!(fabs(a[i] - b[i]) <= tolerance))
      bench_fail(bench, "%s disagree at %d: %.17g and %.17g", what, i, a[i], b[i]);
}
