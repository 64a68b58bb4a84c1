/* Accelerations by clusters against those of the whole bordered system (133), solved as it stands. */
#include "dynamics/dynamics.h"
#include "kinematics/loop_equations.h"
#include "linalg/factor_private.h"
#include "support/moving.h"

#include <stdlib.h>
#include <string.h>

/* [M Jᵀ; J 0] [q̈; λ] = [Q; γ], by columns, in more digits than the equations under test have. */
typedef struct bordered {
  int coordinates, size;
  long double *A, *b;
} bordered;

static long double *entry(bordered *s, int row, int column) {
  return &s->A[(size_t)column * (size_t)s->size + (size_t)row];
}

/* True if `node` equals or is an ancestor of `other`. */
static bool carries(const km_tree *tree, int node, int other) {
  while (other > node)
    other = tree->nodes[other].parent;
  return other == node;
}

/* Velocity products and applied wrenches of every node, where all accelerations are 0. */
static void bias(moving *m, km_wrench *out) {
  km_dynamics *d = m->dynamics;
  const km_tree *tree = &d->tree;
  const km_forces *f = d->forces;
  km_twist *A = calloc((size_t)tree->node_count, sizeof *A);
  A[0] = (km_twist){km_vec3_scale(-1.0, f->stated_gravity), {0, 0, 0}};
  km_tree_update(d, m->f.state);
  for (int n = 1; n < tree->node_count; ++n) {
    A[n] = km_twist_axpy(1.0, d->node[n].zeta, A[tree->nodes[n].parent]);
    out[n] = km_wrench_axpy(1.0, d->node[n].p, km_inertia_times(&d->node[n].inertia, A[n]));
    if (!tree->nodes[n].has_mass)
      out[n] = d->node[n].p;
  }
  for (int i = 0; i < f->moving->loaded_body_count; ++i) {
    int body = f->moving->loaded_bodies[i];
    out[tree->node_of_body[body]] = km_wrench_axpy(-1.0, f->body[body], out[tree->node_of_body[body]]);
  }
  free(A);
}

/* M and Q: every coordinate's column moves all nodes that its own carries. */
static void fill_masses(moving *m, bordered *s) {
  const km_dynamics *d = m->dynamics;
  const km_tree *tree = &d->tree;
  km_wrench *w = calloc((size_t)tree->node_count, sizeof *w);
  bias(m, w);
  for (int i = 0; i < s->coordinates; ++i) {
    int n = tree->node_of_coordinate[i];
    s->b[i] = d->forces->joint[i];
    if (d->armature)
      *entry(s, i, i) += d->armature[i];
    for (int o = 1; n > 0 && o < tree->node_count; ++o) {
      if (!carries(tree, n, o))
        continue;
      s->b[i] -= km_wrench_power(w[o], d->column[i]);
      for (int j = 0; j < s->coordinates && tree->nodes[o].has_mass; ++j) {
        int k = tree->node_of_coordinate[j];
        if (k > 0 && carries(tree, k, o))
          *entry(s, i, j) += km_wrench_power(km_inertia_times(&d->node[o].inertia, d->column[j]), d->column[i]);
      }
    }
  }
  free(w);
}

/* The primary rows of J and γ; held coordinates don't move. */
static void fill_constraints(moving *m, bordered *s) {
  const km_mechanism *mechanism = m->f.mechanism;
  km_state *state = m->f.state;
  int row = s->coordinates;
  for (int i = 0; i < mechanism->topology.substructure_count; ++i) {
    const km_substructure *sub = &mechanism->substructures[i];
    const km_factor *p = state->factor[i];
    double *J = calloc((size_t)sub->rows * (size_t)sub->columns + 1, sizeof *J);
    double *gamma = calloc((size_t)sub->rows + 1, sizeof *gamma);
    km_state_jacobian_dense(state, sub, J);
    km_loops_velocity_products(mechanism, state, sub, state->rate, gamma);
    for (int r = 0; r < p->rank; ++r, ++row) {
      s->b[row] = gamma[p->row[r]];
      for (int k = 0; k < sub->columns; ++k) {
        int c = mechanism->column_coordinate[sub->column_start + k];
        double value = J[(size_t)k * (size_t)sub->rows + (size_t)p->row[r]] / mechanism->unit[c];
        *entry(s, row, c) = *entry(s, c, row) = value;
      }
    }
    free(J);
    free(gamma);
  }
  for (int c = 0; c < s->coordinates; ++c) {
    if (!mechanism->held[c])
      continue;
    for (int o = 0; o < s->size; ++o)
      *entry(s, c, o) = *entry(s, o, c) = 0.0L;
    *entry(s, c, c) = 1.0L;
    s->b[c] = 0.0L;
  }
}

/* Gauss's elimination with the largest entry of a column as pivot, in place of b. */
static void solve(bordered *s) {
  for (int k = 0; k < s->size; ++k) {
    int best = k;
    for (int r = k + 1; r < s->size; ++r)
      best = fabsl(*entry(s, r, k)) > fabsl(*entry(s, best, k)) ? r : best;
    for (int c = 0; c < s->size; ++c) {
      long double keep = *entry(s, k, c);
      *entry(s, k, c) = *entry(s, best, c);
      *entry(s, best, c) = keep;
    }
    long double keep = s->b[k];
    s->b[k] = s->b[best];
    s->b[best] = keep;
    for (int r = k + 1; r < s->size; ++r) {
      long double by = *entry(s, r, k) / *entry(s, k, k);
      for (int c = k; c < s->size && by != 0.0L; ++c)
        *entry(s, r, c) -= by * *entry(s, k, c);
      s->b[r] -= by * s->b[k];
    }
  }
  for (int k = s->size - 1; k >= 0; --k) {
    for (int c = k + 1; c < s->size; ++c)
      s->b[k] -= *entry(s, k, c) * s->b[c];
    s->b[k] /= *entry(s, k, k);
  }
}

/* The largest difference of accelerations over the largest one, in radians and characteristic lengths. */
static double difference(moving *m) {
  const km_mechanism *mechanism = m->f.mechanism;
  bordered s = {.coordinates = mechanism->coordinate_count, .size = mechanism->coordinate_count};
  for (int i = 0; i < mechanism->topology.substructure_count; ++i)
    s.size += km_factor_rank(m->f.state->factor[i]);
  s.A = calloc((size_t)s.size * (size_t)s.size + 1, sizeof *s.A);
  s.b = calloc((size_t)s.size + 1, sizeof *s.b);
  fill_masses(m, &s);
  fill_constraints(m, &s);
  solve(&s);
  double most = 0.0, largest = 0.0;
  for (int c = 0; c < s.coordinates; ++c) {
    double apart = mechanism->scale[c] * fabs((double)(s.b[c] - (long double)m->f.state->acceleration[c]));
    most = apart <= most ? most : apart;
    largest = fmax(largest, mechanism->scale[c] * fabs(m->f.state->acceleration[c]));
  }
  free(s.A);
  free(s.b);
  return most / largest;
}

/* Every model at random poses and rates, with random masses. */
static void test_every_model(void **data) {
  (void)data;
  enum { POSES = 5 };
  for (int i = 0; all_models[i]; ++i) {
    randomness r = {(uint64_t)i + 1};
    fixture f = fixture_open(all_models[i]);
    give_masses(f.model, &r);
    moving m = moving_of(f);
    for (int k = 0; k < POSES; ++k) {
      go_somewhere(&m.f, &r);
      give_rates(&m, &r);
      assert_int_equal(km_dynamics_accelerate(m.dynamics, m.f.state, NULL), KM_OK);
      assert_near(difference(&m), 0.0, 1e-12);
    }
    moving_close(&m);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_model)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
