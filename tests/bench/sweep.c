/* Whole points of a sweep: the driver moved by a step, the loops closed, the driven substructure's mobility
 * numbers. The slider-crank against its reduction by hand. */
#include "bench.h"
#include "hand.h"
#include "kmech/continuation.h"
#include "machine.h"
#include "mobility/mobility_numbers.h"

#include <math.h>
#include <stdio.h>

enum { POINTS = 200 };

/* A sweep there and back: every run goes the other way. */
typedef struct sweep {
  bench_machine machine;
  km_driver_motion *drive;
  const char *name;
  int driver, substructure;
  double from, to;
  bool backwards;
} sweep;

typedef struct by_hand {
  hand_crank crank;
  double from, to;
  bool backwards;
} by_hand;

static double target(double from, double to, int i, bool backwards) {
  return from + (to - from) * (backwards ? POINTS - i : i) / POINTS;
}

static void point(sweep *s, int i) {
  if (km_driver_motion_move_to(s->drive, target(s->from, s->to, i, s->backwards)).stop)
    bench_fail(s->name, "the driver stops at point %d", i);
  km_numbers_update(s->machine.mechanism, s->machine.state, s->substructure);
}

static void run_sweep(void *context) {
  sweep *s = context;
  for (int i = 1; i <= POINTS; ++i)
    point(s, i);
  s->backwards = !s->backwards;
}

static void run_hand(void *context) {
  by_hand *h = context;
  for (int i = 1; i <= POINTS; ++i)
    hand_crank_move(&h->crank, target(h->from, h->to, i, h->backwards));
  h->backwards = !h->backwards;
}

static sweep start(const char *model, const char *driver, double length) {
  sweep s = {.machine = bench_machine_load(model), .name = model};
  s.driver = bench_machine_coordinate(&s.machine, driver);
  s.substructure = s.machine.mechanism->substructure_of[s.driver];
  s.from = km_state_coordinate(s.machine.state, s.driver);
  s.to = s.from + length;
  if (km_driver_motion_create(s.machine.mechanism, s.machine.state, s.driver, false, &s.drive, NULL))
    bench_fail(model, "no drive");
  return s;
}

static void finish(sweep *s) {
  km_driver_motion_free(s->drive);
  bench_machine_free(&s->machine);
}

/* Crank 0.6 m, rod 1.5 m; the piston slides away from the crank's pivot. */
static by_hand start_hand(const sweep *s) {
  double crank = 0.6, rod = 1.5;
  by_hand h = {.crank = {.crank = crank, .rod = rod}, .from = s->from, .to = s->to};
  h.crank.weight = s->machine.mechanism->scale[bench_machine_coordinate(&s->machine, "B")];
  h.crank.beta = asin(-crank * sin(s->from) / rod);
  h.crank.x = crank * cos(s->from) + rod * cos(h.crank.beta);
  return h;
}

static void check(sweep *s, by_hand *h) {
  static const char *const joints[4] = {"A", "B", "C", "D"};
  for (int i = 1; i <= POINTS; ++i) {
    double numbers[4];
    point(s, i);
    hand_crank_move(&h->crank, target(h->from, h->to, i, h->backwards));
    for (int k = 0; k < 4; ++k)
      numbers[k] = s->machine.state->mobility_number[bench_machine_coordinate(&s->machine, joints[k])];
    bench_agree("sweep/slider_crank", "mobility numbers", numbers, h->crank.numbers, 4, 1e-10);
  }
  s->backwards = h->backwards = true;
}

static void report_speed(const bench_contender *c) {
  char name[64];
  snprintf(name, sizeof name, "sweep/%s", c->name);
  bench_figure(name, "points_per_second", 1e9 * POINTS / c->median);
}

void bench_sweep(void) {
  sweep slider = start("slider_crank", "A", 2.0 * M_PI);
  sweep klann = start("klann", "A", 2.0 * M_PI);
  sweep excavator = start("excavator", "M", 0.55);
  sweep stewart = start("stewart", "P1", 0.1); /* several freedoms: the others move least */
  sweep delta = start("delta", "A1", 0.6);
  by_hand hand = start_hand(&slider);
  check(&slider, &hand);
  bench_contender c[] = {{.name = "slider_crank", .run = run_sweep, .context = &slider},
                         {.name = "klann", .run = run_sweep, .context = &klann},
                         {.name = "excavator", .run = run_sweep, .context = &excavator},
                         {.name = "stewart", .run = run_sweep, .context = &stewart},
                         {.name = "delta", .run = run_sweep, .context = &delta},
                         {.name = "slider_crank by hand", .run = run_hand, .context = &hand}};
  bench_time(c, sizeof c / sizeof *c);
  bench_figure("sweep/slider_crank", "over_hand", bench_ratio(&c[0], &c[5]));
  for (int i = 0; i < 5; ++i)
    report_speed(&c[i]);
  finish(&slider);
  finish(&klann);
  finish(&excavator);
  finish(&stewart);
  finish(&delta);
}
