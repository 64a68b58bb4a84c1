/* Accelerations of a four-bar against Simbody's and MuJoCo's, and how much faster than real time simulations run. */
#include "dynamics/dynamics.h"
#include "bench.h"
#include "kmech/dynamics.h"
#include "machine.h"
#include "moving.h"
#include "peers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static void run_ours(void *context) {
  bench_moving *m = context;
  if (km_dynamics_evaluate(m->dynamics, m->state, false) != KM_DYNAMICS_DONE)
    bench_fail("dynamics", "no acceleration");
}

#ifdef BENCH_SIMBODY
static void run_simbody(void *context) {
  double a[3];
  bench_simbody_accelerate(context, a);
}
#endif

#ifdef BENCH_MUJOCO
static void run_mujoco(void *context) {
  double a[3];
  bench_mujoco_accelerate(context, a);
}

/* Checks that both agree at rest. */
static void agree_at_rest(bench_moving *m, const bench_fourbar *bars) {
  bench_fourbar still = *bars;
  double rates[3] = {bars->v[0], bars->v[1], bars->v[2]}, theirs[3];
  for (int i = 0; i < 3; ++i)
    m->state->rate[i] = still.v[i] = 0.0;
  bench_mujoco *mujoco = bench_mujoco_create(&still);
  bench_mujoco_accelerate(mujoco, theirs);
  run_ours(m);
  bench_agree("dynamics", "accelerations of MuJoCo at rest", m->state->acceleration, theirs, 3, 1e-2);
  bench_mujoco_free(mujoco);
  for (int i = 0; i < 3; ++i)
    m->state->rate[i] = rates[i];
  run_ours(m);
}
#endif

static void accelerations(void) {
  bench_moving m = bench_start(bench_fourbar_model);
  bench_contender all[3] = {{.name = "kmech", .run = run_ours, .context = &m}};
  int count = 1;
#if defined(BENCH_SIMBODY) || defined(BENCH_MUJOCO)
  const km_state *s = m.state;
  const bench_fourbar bars = bench_bars(s);
#endif
#ifdef BENCH_SIMBODY
  bench_simbody *simbody = bench_simbody_create(&bars);
  double theirs[3];
  bench_simbody_accelerate(simbody, theirs);
  bench_agree("dynamics", "accelerations of Simbody", s->acceleration, theirs, 3, 1e-4); /* its rods are 1e-6 thick */
  int at_simbody = count;
  all[count++] = (bench_contender){.name = "Simbody", .run = run_simbody, .context = simbody};
#endif
#ifdef BENCH_MUJOCO
  agree_at_rest(&m, &bars);
  bench_mujoco *mujoco = bench_mujoco_create(&bars);
  int at_mujoco = count;
  all[count++] = (bench_contender){.name = "MuJoCo", .run = run_mujoco, .context = mujoco};
#endif
  bench_time(all, count);
  bench_figure("dynamics", "fourbar acceleration ns", all[0].median);
#ifdef BENCH_SIMBODY
  bench_figure("dynamics", "fourbar acceleration, Simbody over ours", bench_ratio(&all[at_simbody], &all[0]));
  bench_simbody_free(simbody);
#endif
#ifdef BENCH_MUJOCO
  bench_figure("dynamics", "fourbar acceleration, MuJoCo over ours", bench_ratio(&all[at_mujoco], &all[0]));
  bench_mujoco_free(mujoco);
#endif
  bench_end(&m);
}

/* A row of four-bars as IFToMM's benchmark A02 has it, upright, pushed at 1 m/s: time of an integrator's step. */
static char *windows(int count) {
  km_text t = {0};
  km_text_add(&t, "{\"model_parameters\": {\"version\": \"1.1\", \"gravity\": [0, -9.81]}, \"assemblies\": [{\"name\": "
                  "\"a\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int i = 0; i < 2 * count + 1; ++i)
    km_text_format(&t,
                   "%s{\"name\": \"b%d\", \"mass\": 1, \"center_of_mass\": [%g, %g], \"moment_of_inertia\": {\"Izz\": "
                   "0.08333333333333333}}",
                   i ? "," : "", i, 0.5 * i, i % 2 ? 1.0 : 0.5);
  km_text_add(&t, "], \"joints\": [");
  for (int i = 0; i <= count; ++i)
    km_text_format(&t,
                   "%s{\"name\": \"A%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"b%d\"], \"at\": [%d, 0], "
                   "\"initial_velocity\": -1}",
                   i ? "," : "", i, 2 * i, i);
  for (int i = 0; i < 2 * count; ++i)
    km_text_format(&t,
                   ",{\"name\": \"B%d\", \"type\": \"revolute\", \"bodies\": [\"b%d\", \"b%d\"], \"at\": [%d, 1], "
                   "\"initial_velocity\": %d}",
                   i, i, i + 1, (i + 1) / 2, i % 2 ? -1 : 1);
  km_text_add(&t, "]}]}");
  return t.data;
}

/* Microseconds of a step and window, on the way to the first fold: the same for any number of windows if the work is
 * linear. The first part, in which memory is touched, doesn't count. */
static void row_of_windows(int count) {
  enum { PARTS = 6 };
  char *text = windows(count);
  bench_moving m = bench_start(text);
  km_simulation *run;
  km_error error = {0};
  km_simulation_def def = km_simulation_default();
  double times[PARTS];
  if (km_simulation_create(m.dynamics, m.state, &def, &run, &error))
    bench_fail("dynamics", "%d windows: %s", count, error.text);
  for (int i = 0; i < PARTS; ++i) {
    clock_t start_time = clock(); /* processor time of this process, because these parts are long enough to be
                                   * interrupted */
    long before = km_simulation_figures_of(run).steps;
    if (km_simulation_advance(run, 0.15 * (i + 1), NULL, NULL, &error))
      bench_fail("dynamics", "%d windows: %s", count, error.text);
    times[i] = 1e6 * (double)(clock() - start_time) / CLOCKS_PER_SEC /
               ((double)(km_simulation_figures_of(run).steps - before) * count);
  }
  km_simulation_free(run);
  char figure[80];
  snprintf(figure, sizeof figure, "a02 with %d windows, us a step and window", count);
  bench_figure("dynamics", figure, bench_median(times + 1, PARTS - 1));
  bench_end(&m);
  km_free(text);
}

/* Simulated seconds per second of a shipped model: the median of several runs. */
static void simulate(const char *name, double until, double every, double tolerance, double max_step) {
  double rates[9];
  for (int i = 0; i < 9; ++i) {
    bench_machine machine = bench_machine_load(name);
    km_forces *forces;
    km_history h;
    km_error error = {0};
    km_history_def def = km_history_default(machine.model);
    def.until = until;
    def.every = every;
    def.simulation.relative = def.simulation.absolute = tolerance;
    def.simulation.max_step = max_step;
    if (km_forces_create(machine.mechanism, NULL, NULL, 0, &forces, &error))
      bench_fail("dynamics", "%s: %s", name, error.text);
    double start_time = bench_now();
    if (km_history_run(machine.mechanism, forces, machine.state, &def, &h, &error))
      bench_fail("dynamics", "%s: %s", name, error.text);
    rates[i] = until / (bench_now() - start_time);
    km_history_free(&h);
    km_forces_free(forces);
    bench_machine_free(&machine);
  }
  char figure[80];
  snprintf(figure, sizeof figure, "%s, simulated seconds per second", name);
  bench_figure("dynamics", figure, bench_median(rates, 9));
}

void bench_dynamics(void) {
  accelerations();
  for (int windows = 10; windows <= 1000; windows *= 10)
    row_of_windows(windows);
  bench_equal_accuracy();
  bench_force_function();
  simulate("slider_crank", 20.0, 0.03, 1e-4, 0.01);
  simulate("bricard", 100.0, 0.01, 1e-11, 0.0);
  simulate("excavator_drop", 10.0, 0.03, 1e-4, 0.03);
  simulate("excavator", 10.0, 0.03, 1e-4, 0.03);
  simulate("vehicle_circle", 4.0, 0.1, 1e-4, 0.0);
}
