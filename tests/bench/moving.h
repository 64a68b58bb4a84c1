/* A mechanism that is ready to be simulated, and the four-bar that is compared with other libraries. */
#ifndef BENCH_MOVING_H
#define BENCH_MOVING_H

#include "kmech/dynamics.h"
#include "peers.h"

typedef struct bench_moving {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
  km_forces *forces;
  km_dynamics *dynamics;
} bench_moving;

/* A model's text, assembled, with rates that keep its loops. */
bench_moving bench_start(const char *text);
void bench_end(bench_moving *moving);

/* Crank, coupler and rocker as rods, pushed and under gravity; and the same at a state of it for the others. */
extern const char bench_fourbar_model[];
bench_fourbar bench_bars(const km_state *state);

/* Time of a run with a program's force function over that with a force module. */
void bench_force_function(void);

/* Time of a simulation of it by Simbody over ours where both err as much. */
void bench_equal_accuracy(void);

#endif
