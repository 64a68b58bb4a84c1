/* Accelerations of a four-bar against Simbody's, and how much faster than real time simulations run. */
#include "dynamics/dynamics.h"
#include "bench.h"
#include "exchange/json/json.h"
#include "kmech/history.h"
#include "machine.h"
#include "peers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char fourbar[] =
    "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": ["
    "{\"name\": \"crank\", \"mass\": 1, \"center_of_mass\": [0.2, 0, 0], \"moment_of_inertia\": {\"Izz\": "
    "0.0133333333333333333}, \"frames\": [{\"name\": \"end\", \"T\": [0.4, 0, 0]}]},"
    "{\"name\": \"coupler\", \"mass\": 1, \"center_of_mass\": [0.5, 0, 0], \"moment_of_inertia\": {\"Izz\": "
    "0.0833333333333333333}, \"frames\": [{\"name\": \"end\", \"T\": [1, 0, 0]}]},"
    "{\"name\": \"rocker\", \"mass\": 1, \"center_of_mass\": [0.45, 0, 0], \"moment_of_inertia\": {\"Izz\": 0.0675}, "
    "\"frames\": [{\"name\": \"end\", \"T\": [0.9, 0, 0]}]}], \"joints\": ["
    "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"crank\"], \"initial_displacement\": 0.9, "
    "\"initial_velocity\": 2},"
    "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"end\"], [\"coupler\"]], "
    "\"initial_displacement\": -0.5},"
    "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"ground\"], [\"rocker\"]], "
    "\"initial_displacement\": 1.5},"
    "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"coupler\", \"end\"], [\"rocker\", \"end\"]], "
    "\"initial_displacement\": 1}]}], \"fixed\": {\"frames\": [{\"name\": \"ground\", \"T\": [1.1, 0, 0]}]}}";

typedef struct moving {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
  km_forces *forces;
  km_dynamics *dynamics;
} moving;

static void run_ours(void *context) {
  moving *m = context;
  if (km_dynamics_evaluate(m->dynamics, m->state, false) != KM_DYNAMICS_DONE)
    bench_fail("dynamics", "no acceleration");
}

static moving start(void) {
  moving m = {0};
  km_assembly evidence;
  km_error error = {0};
  if (km_model_read(fourbar, strlen(fourbar), NULL, &m.model, NULL) ||
      km_mechanism_compile(m.model, NULL, 0, &m.mechanism, &error) || km_state_create(m.mechanism, &m.state, &error) ||
      km_assemble(m.mechanism, m.state, &evidence, &error) ||
      km_forces_create(m.mechanism, NULL, NULL, 0, &m.forces, &error) ||
      km_dynamics_create(m.mechanism, m.forces, &m.dynamics, &error) ||
      km_dynamics_project_rates(m.dynamics, m.state, NULL, &error) ||
      km_dynamics_accelerate(m.dynamics, m.state, &error))
    bench_fail("dynamics", "the four-bar: %s", error.text);
  return m;
}

static void end(moving *m) {
  km_dynamics_free(m->dynamics);
  km_forces_free(m->forces);
  km_state_free(m->state);
  km_mechanism_free(m->mechanism);
  km_model_free(m->model);
}

#ifdef BENCH_SIMBODY
static void run_simbody(void *context) {
  double a[3];
  bench_simbody_accelerate(context, a);
}
#endif

static void accelerations(void) {
  moving m = start();
  bench_contender all[2] = {{.name = "kmech", .run = run_ours, .context = &m}};
  int count = 1;
#ifdef BENCH_SIMBODY
  const km_state *s = m.state;
  const bench_fourbar bars = {
      0.4, 1.0, 0.9, 1.1, 9.81, {s->q[0], s->q[1], s->q[2]}, {s->rate[0], s->rate[1], s->rate[2]}};
  bench_simbody *simbody = bench_simbody_create(&bars);
  double theirs[3];
  bench_simbody_accelerate(simbody, theirs);
  bench_agree("dynamics", "accelerations of Simbody", s->acceleration, theirs, 3, 1e-4); /* its rods are 1e-6 thick */
  all[count++] = (bench_contender){.name = "Simbody", .run = run_simbody, .context = simbody};
#endif
  bench_time(all, count);
  bench_figure("dynamics", "fourbar acceleration ns", all[0].median);
#ifdef BENCH_SIMBODY
  bench_figure("dynamics", "fourbar acceleration, Simbody over ours", bench_ratio(&all[1], &all[0]));
  bench_simbody_free(simbody);
#endif
  end(&m);
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
  simulate("slider_crank", 20.0, 0.03, 1e-4, 0.01);
  simulate("bricard", 100.0, 0.01, 1e-11, 0.0);
  simulate("excavator_drop", 10.0, 0.03, 1e-4, 0.03);
  simulate("excavator", 10.0, 0.03, 1e-4, 0.03);
  simulate("vehicle_circle", 4.0, 0.1, 1e-4, 0.0);
}
