/* Mechanisms that are ready to be simulated. */
#include "moving.h"

#include "bench.h"
#include "exchange/json/json.h"
#include "kinematics/state.h"
#include "kmech/mechanism.h"

#include <string.h>

const char bench_fourbar_model[] =
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

bench_moving bench_start(const char *text) {
  bench_moving m = {0};
  km_assembly evidence;
  km_error error = {0};
  if (km_model_read(text, strlen(text), NULL, &m.model, NULL) ||
      km_mechanism_compile(m.model, NULL, 0, &m.mechanism, &error) || km_state_create(m.mechanism, &m.state, &error) ||
      km_assemble(m.mechanism, m.state, &evidence, &error) ||
      km_forces_create(m.mechanism, NULL, NULL, 0, &m.forces, &error) ||
      km_dynamics_create(m.mechanism, m.forces, &m.dynamics, &error) ||
      km_dynamics_project_rates(m.dynamics, m.state, NULL, &error) ||
      km_dynamics_accelerate(m.dynamics, m.state, &error))
    bench_fail("dynamics", "%s", error.text);
  return m;
}

void bench_end(bench_moving *m) {
  km_dynamics_free(m->dynamics);
  km_forces_free(m->forces);
  km_state_free(m->state);
  km_mechanism_free(m->mechanism);
  km_model_free(m->model);
}

bench_fourbar bench_bars(const km_state *s) {
  return (bench_fourbar){0.4, 1.0, 0.9, 1.1, 9.81, {s->q[0], s->q[1], s->q[2]}, {s->rate[0], s->rate[1], s->rate[2]}};
}
