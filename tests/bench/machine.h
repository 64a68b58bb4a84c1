/* A model of the collection, compiled and assembled at its own pose. */
#ifndef BENCH_MACHINE_H
#define BENCH_MACHINE_H

#include "kinematics/state.h"

typedef struct bench_machine {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
} bench_machine;

/* models/NAME.json; exits where that fails. */
bench_machine bench_machine_load(const char *name);
void bench_machine_free(bench_machine *machine);
int bench_machine_coordinate(const bench_machine *machine, const char *label);

#endif
