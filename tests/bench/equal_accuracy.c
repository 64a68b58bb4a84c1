/* A four-bar's simulation against Simbody's where both err as much. */
#include "moving.h"

#ifdef BENCH_SIMBODY
#include "bench.h"
#include "kinematics/state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TIMES = 5, SIZE = 3 * TIMES };

typedef struct ours {
  bench_moving moving;
  double q[3 + 1], rate[3 + 1]; /* the start; the loop's joint, too */
  double tolerance, way[SIZE];
} ours;

typedef struct theirs {
  bench_simbody *simbody;
  int integrator;
  double accuracy, way[SIZE];
} theirs;

static void run_ours(void *context) {
  ours *o = context;
  bench_moving *m = &o->moving;
  km_simulation_def def = km_simulation_default();
  km_simulation *run;
  km_error error = {0};
  def.relative = def.absolute = o->tolerance;
  memcpy(m->state->q, o->q, sizeof o->q);
  memcpy(m->state->rate, o->rate, sizeof o->rate);
  if (km_state_set_time(m->mechanism, m->state, 0.0, &error) ||
      km_simulation_create(m->dynamics, m->state, &def, &run, &error))
    bench_fail("dynamics", "%s", error.text);
  for (int t = 0; t < TIMES; ++t) {
    if (km_simulation_advance(run, t + 1.0, NULL, NULL, &error))
      bench_fail("dynamics", "%s", error.text);
    memcpy(o->way + 3 * t, m->state->q, 3 * sizeof *o->way);
  }
  km_simulation_free(run);
}

static void run_theirs(void *context) {
  theirs *t = context;
  bench_simbody_simulate(t->simbody, t->integrator, t->accuracy, TIMES, t->way);
}

/* The largest difference of an angle at any of the times. */
static double apart(const double *a, const double *b) {
  double most = 0.0;
  for (int i = 0; i < SIZE; ++i)
    most = fmax(most, fabs(a[i] - b[i]));
  return most;
}

static double error_of(theirs *t, double accuracy, const double *reference) {
  t->accuracy = accuracy;
  run_theirs(t);
  return apart(t->way, reference);
}

/* The tightest accuracy, in steps of a quarter of a decade, from which on the simulation still errs as much as ours: so
 * that Simbody has no more work than that. */
static double match(theirs *t, const double *reference, double error) {
  double accuracy = 1e-2, least = 1e-12;
  while (accuracy > least && error_of(t, accuracy * pow(10.0, -0.25), reference) >= error)
    accuracy *= pow(10.0, -0.25);
  return accuracy;
}

static void compare(ours *o, bench_simbody *simbody, int integrator, const double *reference, double error) {
  theirs t = {.simbody = simbody, .integrator = integrator};
  bench_contender all[] = {{.name = "kmech", .run = run_ours, .context = o},
                           {.name = bench_simbody_integrator(integrator), .run = run_theirs, .context = &t}};
  char figure[120];
  t.accuracy = match(&t, reference, error);
  run_theirs(&t);
  double theirs_error = apart(t.way, reference);
  bench_time(all, sizeof all / sizeof *all);
  snprintf(figure, sizeof figure, "fourbar %d s to 1e%.0f, error of Simbody's %s over ours", TIMES, log10(o->tolerance),
           all[1].name);
  bench_figure("dynamics", figure, theirs_error / error);
  snprintf(figure, sizeof figure, "fourbar %d s to 1e%.0f, Simbody's %s over ours", TIMES, log10(o->tolerance),
           all[1].name);
  bench_figure("dynamics", figure, bench_ratio(&all[1], &all[0]));
}

void bench_equal_accuracy(void) {
  ours o = {.moving = bench_start(bench_fourbar_model), .tolerance = 1e-12};
  const km_state *s = o.moving.state;
  const bench_fourbar bars = bench_bars(s);
  bench_simbody *simbody = bench_simbody_create(&bars);
  double reference[2][SIZE];
  memcpy(o.q, s->q, sizeof o.q);
  memcpy(o.rate, s->rate, sizeof o.rate);
  run_ours(&o);
  memcpy(reference[0], o.way, sizeof o.way);
  bench_simbody_simulate(simbody, 0, 1e-12, TIMES, reference[1]);
  bench_agree("dynamics", "simulations of Simbody", reference[0], reference[1], SIZE, 1e-7);
  static const double tolerances[] = {1e-5, 1e-7};
  for (int k = 0; k < 2; ++k) {
    o.tolerance = tolerances[k];
    run_ours(&o);
    double error = apart(o.way, reference[0]);
    for (int i = 0; i < BENCH_SIMBODY_INTEGRATORS; ++i)
      compare(&o, simbody, i, reference[1], error);
  }
  bench_simbody_free(simbody);
  bench_end(&o.moving);
}
#else
void bench_equal_accuracy(void) {}
#endif
