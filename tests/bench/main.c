/* kmech_bench [NAME]: the benchmarks whose names begin with NAME, or all. */
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
  const char *name;
  void (*run)(void);
} benches[] = {
    {"partition", bench_partition}, {"sweep", bench_sweep},       {"lanes", bench_lanes}, {"command", bench_command},
    {"scale", bench_scale},         {"forces", bench_forces},     {"arm", bench_arm},     {"study", bench_study},
    {"load", bench_load},           {"dynamics", bench_dynamics}, {"large", bench_large},
#ifdef BENCH_VIEW
    {"view", bench_view},
#endif
};

/* The BLAS reads its number of threads when it is loaded: start again with that set. */
static void pin_blas(char **argv) {
  if (getenv("OPENBLAS_NUM_THREADS"))
    return;
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  execv("/proc/self/exe", argv);
}

int main(int argc, char **argv) {
  pin_blas(argv);
  const char *wanted = argc > 1 ? argv[1] : "";
  size_t length = strcspn(wanted, "/"); /* partition/excavator is a part of partition */
  int found = 0;
  for (size_t i = 0; i < sizeof benches / sizeof *benches; ++i) {
    if (strncmp(benches[i].name, wanted, length) != 0)
      continue;
    fprintf(stderr, "%s\n", benches[i].name);
    benches[i].run();
    ++found;
  }
  if (!found)
    fprintf(
        stderr,
        "kmech_bench: no bench \"%s\"; there are partition, sweep, lanes, command, scale, forces, arm, study, load, "
        "dynamics, large\n",
        wanted);
  return found ? EXIT_SUCCESS : EXIT_FAILURE;
}
