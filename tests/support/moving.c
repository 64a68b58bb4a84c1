/* Mechanisms with masses and rates, and d'Alembert's principle as a judge of accelerations. */
#include "support/moving.h"
#include "linalg/factor_private.h"

#include "kinematics/body_poses.h"
#include "spatial/inertia.h"

#include <stdlib.h>
#include <string.h>

moving moving_of(fixture f) {
  moving m = {.f = f};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &m.forces, NULL), KM_OK);
  assert_int_equal(km_dynamics_create(f.mechanism, m.forces, &m.dynamics, NULL), KM_OK);
  return m;
}

void moving_close(moving *m) {
  km_dynamics_free(m->dynamics);
  km_forces_free(m->forces);
  fixture_close(&m->f);
}

void give_masses(km_model *model, randomness *r) {
  for (int b = 1; b < model->body_count; ++b) {
    double a = uniform(r, 0.01, 0.1), c = uniform(r, 0.01, 0.1);
    const double center[3] = {uniform(r, -0.3, 0.3), uniform(r, -0.3, 0.3), uniform(r, -0.3, 0.3)};
    const double inertia[6] = {a,
                               c,
                               a + c * uniform(r, 0.1, 0.9),
                               0.005 * uniform(r, -1, 1),
                               0.005 * uniform(r, -1, 1),
                               0.005 * uniform(r, -1, 1)};
    assert_int_equal(km_model_set_mass(model, b, uniform(r, 0.2, 3.0), center, inertia, NULL), KM_OK);
  }
  model->gravity = (km_vec3){uniform(r, -5, 5), uniform(r, -5, 5), -9.81};
}

void give_rates(moving *m, randomness *r) {
  const km_mechanism *mech = m->f.mechanism;
  for (int c = 0; c < mech->coordinate_count; ++c)
    if (!mech->held[c])
      m->f.state->rate[c] = uniform(r, -1.0, 1.0);
  assert_int_equal(km_dynamics_project_rates(m->dynamics, m->f.state, NULL, NULL), KM_OK);
}

/* The state's coordinates and rates after a time, by the first two terms of their series. */
static void go_on(const km_mechanism *m, km_state *s, const km_state *from, double time) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    s->q[c] = from->q[c] + time * from->rate[c] + 0.5 * time * time * from->acceleration[c];
    s->rate[c] = from->rate[c] + time * from->acceleration[c];
  }
  for (int b = 0; b < m->ball_count; ++b) {
    const double *w = &from->rate[m->ball_coordinate[b]], *a = &from->acceleration[m->ball_coordinate[b]];
    km_vec3 turn = {w[0] * time + 0.5 * a[0] * time * time, w[1] * time + 0.5 * a[1] * time * time,
                    w[2] * time + 0.5 * a[2] * time * time};
    s->ball[b] = km_quaternion_product(km_quaternion_exp(turn), from->ball[b]);
  }
}

/* Momenta of all bodies about the inertial origin. */
static void momenta(const km_mechanism *m, km_state *s, km_wrench *out) {
  km_poses_compute(m, s);
  for (int i = 0; i < m->topology.body_count - 1; ++i) {
    int b = m->arcs[i].body;
    const km_model_body *def = &m->model->bodies[b];
    km_inertia own = km_inertia_of_body(def->mass, def->center_of_mass, def->inertia);
    km_inertia there = km_inertia_transform(&s->pose[b], &own);
    out[b] = km_inertia_times(&there, km_body_twist(m, s, b, s->rate));
  }
}

/* Residue of a body's weight and rate of momentum, and the size of both. */
typedef struct balance {
  km_wrench rest;
  double force, moment;
} balance;

/* Power of the residual wrenches and joint forces over rates. */
static double power(const moving *m, const balance *body, const double *rates, double *largest) {
  const km_mechanism *mech = m->f.mechanism;
  double sum = 0.0;
  for (int i = 0; i < mech->topology.body_count - 1; ++i) {
    int b = mech->arcs[i].body;
    km_twist V = km_body_twist(mech, m->f.state, b, rates);
    sum += km_wrench_power(body[b].rest, V);
    *largest = fmax(*largest, body[b].force * km_vec3_norm(V.v) + body[b].moment * km_vec3_norm(V.w));
  }
  for (int c = 0; c < mech->coordinate_count; ++c)
    sum += km_forces_in_joint(m->forces, c) * rates[c];
  return sum;
}

static double over_substructures(const moving *m, const balance *body, double *rates, double *largest) {
  const km_mechanism *mech = m->f.mechanism;
  double worst = 0.0;
  for (int i = 0; i < mech->topology.substructure_count; ++i) {
    const km_substructure *sub = &mech->substructures[i];
    const km_factor *p = m->f.state->factor[i];
    double *direction = (double *)calloc((size_t)sub->columns, sizeof *direction);
    for (int k = p->rank; k < p->columns; ++k) {
      km_factor_null_vector(p, p->column[k], direction);
      memset(rates, 0, (size_t)mech->coordinate_count * sizeof *rates);
      for (int n = 0; n < sub->columns; ++n) {
        int c = mech->column_coordinate[sub->column_start + n];
        rates[c] = direction[n] * mech->unit[c];
      }
      worst = fmax(worst, fabs(power(m, body, rates, largest)));
    }
    free(direction);
  }
  return worst;
}

double dalembert(moving *m, double step) {
  const km_mechanism *mech = m->f.mechanism;
  size_t bodies = (size_t)mech->topology.body_count, coordinates = (size_t)mech->coordinate_count;
  km_wrench *before = (km_wrench *)calloc(bodies, sizeof *before), *after = (km_wrench *)calloc(bodies, sizeof *after);
  balance *body = (balance *)calloc(bodies, sizeof *body);
  double *rates = (double *)calloc(coordinates + 1, sizeof *rates), worst, largest = 1e-12;
  km_state *s;
  assert_int_equal(km_state_create(mech, &s, NULL), KM_OK);
  go_on(mech, s, m->f.state, -step);
  momenta(mech, s, before);
  go_on(mech, s, m->f.state, step);
  momenta(mech, s, after);
  for (size_t b = 1; b < bodies; ++b) {
    const km_model_body *def = &mech->model->bodies[b];
    km_wrench change =
        km_wrench_axpy(-0.5 / step, km_wrench_axpy(-1.0, before[b], after[b]), (km_wrench){{0, 0, 0}, {0, 0, 0}});
    km_pose X = m->f.state->pose[b];
    km_wrench weight = km_wrench_at(km_vec3_scale(def->mass, mech->model->gravity), (km_vec3){0, 0, 0},
                                    km_pose_point(&X, def->center_of_mass));
    body[b] = (balance){km_wrench_axpy(1.0, change, weight), km_vec3_norm(change.f) + km_vec3_norm(weight.f),
                        km_vec3_norm(change.t) + km_vec3_norm(weight.t)};
  }
  worst = over_substructures(m, body, rates, &largest);
  for (size_t c = 0; c < coordinates; ++c) {
    if (mech->substructure_of[c] >= 0 || mech->held[c])
      continue;
    memset(rates, 0, coordinates * sizeof *rates);
    rates[c] = 1.0;
    worst = fmax(worst, fabs(power(m, body, rates, &largest)));
  }
  km_state_free(s);
  free(before);
  free(after);
  free(body);
  free(rates);
  return worst / largest;
}

km_history history_of(fixture *f, double until, double every, double tolerance, bool reactions) {
  km_forces *forces;
  km_history out;
  km_error error = {0};
  km_history_def def = km_history_default(f->model);
  def.until = until;
  def.every = every;
  def.simulation.relative = def.simulation.absolute = tolerance;
  def.reactions = reactions;
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  if (km_history_run(f->mechanism, forces, f->state, &def, &out, &error))
    fail_msg("%s", error.text);
  km_forces_free(forces);
  return out;
}

double history_entry(const km_history *h, size_t row, const char *column) {
  int found = km_table_find(h->table, column);
  assert_true(found >= 0);
  return km_table_row(h->table, row)[found];
}

double history_end(const km_history *h, const char *column) {
  return history_entry(h, km_table_rows(h->table) - 1, column);
}
