/* Spread of a four-bar's mechanical advantage for a coupler of length 3 with a standard deviation of 0.01. */
#include "fourbar.h"

#include <math.h>
#include <stdlib.h>

/* Leverage of A over D with the crank at 1 rad. */
static km_status leverage(double coupler, double *value, km_error *error) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_transfer *lever = NULL;
  km_mobility mobility;
  km_advantage advantage = {.value = (double)NAN};
  const km_port input = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "A"};
  const km_port output = {.kind = KM_PORT_JOINT, .coordinate = 3, .name = "D"};
  const km_hold crank = {0, 1.0};
  km_status status = fourbar_open(coupler, &model, error);
  if (!status)
    status = km_mechanism_compile_at(model, NULL, 0, &crank, 1, &mechanism, &state, error);
  if (!status)
    status = km_transfer_create(mechanism, &input, &output, &lever, error);
  if (!status)
    status = km_mobility_compute(mechanism, state, &mobility);
  if (!status)
    status = km_transfer_compute(mechanism, state, lever, &advantage);
  *value = advantage.value;
  km_transfer_free(lever);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status;
}

static double normal(void) { /* Box and Muller */
  double u = (rand() + 1.0) / (RAND_MAX + 2.0), v = rand() / (RAND_MAX + 1.0);
  return sqrt(-2.0 * log(u)) * cos(2.0 * 3.14159265358979324 * v);
}

int main(void) {
  enum { SAMPLES = 1000 };
  double sum = 0.0, squares = 0.0, value;
  km_error error;
  srand(1);
  for (int i = 0; i < SAMPLES; ++i) {
    if (leverage(3.0 + 0.01 * normal(), &value, &error)) {
      fprintf(stderr, "%s\n", error.text);
      return 1;
    }
    sum += value;
    squares += value * value;
  }
  double mean = sum / SAMPLES;
  printf("leverage %.4f, standard deviation %.4f\n", mean, sqrt(squares / SAMPLES - mean * mean));
  return 0;
}
