/* Complete points of batched sweeps: every driver moved by a step, loops closed, mobility numbers computed. Compared
 * with single sweeps. */
#include "bench.h"
#include "continuation/batch/batch.h"
#include "machine.h"
#include "mobility/mobility_numbers.h"

#include <math.h>
#include <stdio.h>

enum { POINTS = 200 };

/* Equal machines, there and back. */
typedef struct samples {
  bench_machine machines[KM_BATCH_LANES];
  km_driver_motion *drives[KM_BATCH_LANES];
  km_batch *lanes; /* NULL: one after the other */
  const char *name;
  double from, to;
  bool backwards;
} samples;

static double target(const samples *s, int i) {
  return s->from + (s->to - s->from) * (s->backwards ? POINTS - i : i) / POINTS;
}

static void numbers(const samples *s, int i) {
  const bench_machine *m = &s->machines[i];
  if (!km_driver_motion_is_batched(s->drives[i]))
    km_numbers_update(m->mechanism, m->state, s->drives[i]->c.substructure);
}

static void run_beside(void *context) {
  samples *s = context;
  double targets[KM_BATCH_LANES];
  km_motion_end reaches[KM_BATCH_LANES];
  for (int p = 1; p <= POINTS; ++p) {
    for (int i = 0; i < KM_BATCH_LANES; ++i)
      targets[i] = target(s, p);
    km_batch_move_to(s->lanes, (1u << KM_BATCH_LANES) - 1, targets, reaches);
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      if (reaches[i].stop)
        bench_fail(s->name, "the driver stops at point %d", p);
      numbers(s, i);
    }
  }
  s->backwards = !s->backwards;
}

static void run_alone(void *context) {
  samples *s = context;
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    for (int p = 1; p <= POINTS; ++p) {
      if (km_driver_motion_move_to(s->drives[i], target(s, p)).stop)
        bench_fail(s->name, "the driver stops at point %d", p);
      numbers(s, i);
    }
  s->backwards = !s->backwards;
}

static samples open_samples(const char *model, const char *driver, double length, bool beside) {
  samples s = {.name = model};
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    s.machines[i] = bench_machine_load(model);
    int c = bench_machine_coordinate(&s.machines[i], driver);
    s.from = km_state_coordinate(s.machines[i].state, c);
    if (km_driver_motion_create(s.machines[i].mechanism, s.machines[i].state, c, false, &s.drives[i], NULL))
      bench_fail(model, "no drive");
  }
  s.to = s.from + length;
  if (beside && (km_batch_create(NULL, s.drives, KM_BATCH_LANES, &s.lanes, NULL) || !s.lanes))
    bench_fail(model, "no lanes");
  return s;
}

static void close_samples(samples *s) {
  km_batch_free(NULL, s->lanes);
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    km_driver_motion_free(s->drives[i]);
    bench_machine_free(&s->machines[i]);
  }
}

static void measure(const char *model, const char *driver, double length) {
  samples beside = open_samples(model, driver, length, true), alone = open_samples(model, driver, length, false);
  bench_contender c[] = {{.name = "side by side", .run = run_beside, .context = &beside},
                         {.name = "one by one", .run = run_alone, .context = &alone}};
  char name[64];
  bench_time(c, sizeof c / sizeof *c);
  snprintf(name, sizeof name, "lanes/%s", model);
  bench_figure(name, "million_points_per_second", 1e3 * POINTS * KM_BATCH_LANES / c[0].median);
  bench_figure(name, "over_one_by_one", bench_ratio(&c[1], &c[0]));
  close_samples(&beside);
  close_samples(&alone);
}

void bench_lanes(void) {
  measure("slider_crank", "A", 2.0 * M_PI);
  measure("excavator", "M", 0.55);
  measure("klann", "A", 2.0 * M_PI);
  measure("bennett", "A", 2.0 * M_PI);
  measure("rssr", "A", 2.0 * M_PI);
  measure("delta", "A1", 0.3);
  measure("stewart", "P1", 0.1);
}
