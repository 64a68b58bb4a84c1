/* Equilibrium of the joints that no actuator holds: the actuated joints are held at their values, and the rest
 * configuration of the remaining mechanism is found under the same loads (docs/theory.md 9.7). */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "forces/forces.h"

/* Mechanism with the actuators held, and its equations of motion. */
typedef struct held_mechanism {
  km_mechanism *m;
  km_state *s;
  km_forces *forces;
  km_dynamics *dynamics;
} held_mechanism;

static void release(held_mechanism *h) {
  km_dynamics_free(h->dynamics);
  km_forces_free(h->forces);
  km_state_free(h->s);
  km_mechanism_free(h->m);
}

/* Coordinates that the mechanism holds already, and the actuators. */
static km_hold *list_holds(const km_mechanism *m, const km_state *s, const int *actuators, int count, int *out) {
  km_hold *holds = KM_NEW(km_hold, (size_t)m->coordinate_count + 1);
  *out = 0;
  for (int c = 0; c < m->coordinate_count && holds; ++c) {
    bool is_held = m->held[c];
    for (int i = 0; i < count; ++i)
      is_held = is_held || actuators[i] == c;
    if (is_held)
      holds[(*out)++] = (km_hold){c, km_state_coordinate(s, c)};
  }
  return holds;
}

/* Compiles the mechanism with the holds, at the state's configuration, under the forces' gravity and loads. */
static km_status create(const km_mechanism *m, const km_state *s, const km_forces *forces, const km_hold *holds,
                        int count, held_mechanism *h, km_error *error) {
  const double gravity[3] = {forces->stated_gravity.x, forces->stated_gravity.y, forces->stated_gravity.z};
  double *values = KM_NEW(double, (size_t)m->coordinate_count + 1);
  km_status status = values ? km_mechanism_compile(m->model, holds, count, &h->m, error)
                            : km_fail(error, KM_MEMORY, "out of memory for the equilibrium");
  if (!status)
    status = km_state_create(h->m, &h->s, error);
  for (int c = 0; c < m->coordinate_count && !status; ++c)
    values[c] = km_state_coordinate(s, c);
  if (!status)
    status = km_state_set_coordinates(h->m, h->s, values, error);
  if (!status)
    status = km_assemble(h->m, h->s, NULL, error);
  if (!status)
    status = km_forces_create(h->m, gravity, forces->loads, forces->load_count, &h->forces, error);
  if (!status)
    status = km_dynamics_create(h->m, h->forces, &h->dynamics, error);
  km_free(values);
  return status;
}

/* Moves the state of the whole mechanism to that of the held one. */
static km_status move_state(const km_mechanism *m, km_state *s, const held_mechanism *h, km_error *error) {
  double *values = KM_NEW(double, (size_t)m->coordinate_count + 1);
  if (!values)
    return km_fail(error, KM_MEMORY, "out of memory for the equilibrium");
  for (int c = 0; c < m->coordinate_count; ++c)
    values[c] = km_state_coordinate(h->s, c);
  km_status status = km_state_set_coordinates(m, s, values, error);
  km_free(values);
  return status ? status : km_assemble(m, s, NULL, error);
}

km_status km_equilibrium_hold(const km_mechanism *m, km_state *s, const km_forces *forces, const int *actuators,
                              int actuator_count, km_error *error) {
  km_status status =
      km_check_given(m != NULL && forces != NULL && forces->mechanism == m, "forces of this mechanism", error);
  if (!status)
    status = km_check_state(m, s, error);
  if (!status)
    status = km_check_list(actuators, actuator_count, "actuators", error);
  for (int i = 0; i < actuator_count && !status; ++i)
    status = km_check_index(actuators[i], m->coordinate_count, "coordinate", error);
  if (status)
    return status;
  held_mechanism h = {0};
  int count;
  km_hold *holds = list_holds(m, s, actuators, actuator_count, &count);
  status = holds ? create(m, s, forces, holds, count, &h, error)
                 : km_fail(error, KM_MEMORY, "out of memory for the equilibrium");
  if (!status)
    status = km_equilibrium_find(h.dynamics, h.s, false, NULL, NULL, error);
  if (!status)
    status = move_state(m, s, &h, error);
  release(&h);
  km_free(holds);
  return status;
}
