#include "machine.h"
#include "bench.h"
#include "kmech/mechanism.h"

#include <stdio.h>

bench_machine bench_machine_load(const char *name) {
  bench_machine machine = {0};
  char path[512];
  km_error error = {0};
  km_assembly evidence;
  snprintf(path, sizeof path, "%s/%s.json", BENCH_MODELS, name);
  if (km_model_read_file(path, NULL, &machine.model, &error) ||
      km_mechanism_compile(machine.model, NULL, 0, &machine.mechanism, &error) ||
      km_state_create(machine.mechanism, &machine.state, &error) ||
      km_assemble(machine.mechanism, machine.state, &evidence, &error))
    bench_fail(name, "%s", error.text);
  return machine;
}

void bench_machine_free(bench_machine *machine) {
  km_state_free(machine->state);
  km_mechanism_free(machine->mechanism);
  km_model_free(machine->model);
}

int bench_machine_coordinate(const bench_machine *machine, const char *label) {
  int coordinate;
  km_error error = {0};
  if (km_model_find_coordinate(machine->model, label, &coordinate, &error))
    bench_fail(label, "%s", error.text);
  return coordinate;
}
