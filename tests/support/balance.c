/* Balance of forces by equations that the library does not use. */
#include "support/balance.h"

#include "forces/forces.h"
#include "kinematics/body_poses.h"
#include "kmech/statics.h"
#include "support/bordered.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

enum { LOADS = 3 };

/* A mechanism with random loads on random frames, balanced. */
typedef struct balance {
  fixture *f;
  km_load loads[LOADS];
  km_forces *forces;
  km_statics statics;
  km_mobility mobility;
  double size; /* residue of the forces, and of their moments over the length `reach` */
  double reach;
} balance;

static km_vec3 random_vector(randomness *r, double size) {
  return (km_vec3){uniform(r, -size, size), uniform(r, -size, size), uniform(r, -size, size)};
}

static balance balance_open(fixture *f, randomness *r, km_axes axes) {
  balance b = {.f = f};
  const km_model *model = f->model;
  for (int i = 0; i < LOADS; ++i) {
    km_vec3 force = random_vector(r, 100.0), torque = random_vector(r, 10.0);
    b.loads[i] = (km_load){below(r, model->frame_count),
                           {force.x, force.y, force.z},
                           {torque.x, torque.y, torque.z},
                           below(r, 2) == 1,
                           NULL};
  }
  km_mobility_compute(b.f->mechanism, b.f->state, &b.mobility);
  assert_int_equal(km_forces_create(b.f->mechanism, NULL, b.loads, LOADS, &b.forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(f->mechanism, NULL, 0, axes, &b.statics, NULL), KM_OK);
  km_statics_compute(b.f->mechanism, b.f->state, b.forces, &b.statics);
  km_poses_compute(b.f->mechanism, b.f->state);
  for (int i = 0; i < model->frame_count; ++i) {
    double place[3];
    km_frame_position(f->mechanism, f->state, i, place);
    b.reach = fmax(b.reach, km_vec3_norm(km_vec3_from_array(place)));
  }
  for (int j = 0; j < model->joint_count; ++j)
    b.size = fmax(b.size, km_vec3_norm(km_vec3_from_array(b.statics.reactions[j].force)));
  b.size += b.forces->force_size + b.forces->couple_size / b.reach;
  return b;
}

static void balance_close(balance *b) {
  km_statics_free(&b->statics);
  km_forces_free(b->forces);
}

/* A reaction (fixed axes) about the inertial origin. */
static km_wrench reaction(const balance *b, int joint) {
  const km_reaction *r = &b->statics.reactions[joint];
  const km_model_frame *frame = &b->f->model->frames[b->f->model->joints[joint].frame[1]];
  km_vec3 p = km_pose_point(&b->f->state->pose[frame->body], frame->pose.p);
  return km_wrench_at(km_vec3_from_array(r->force), km_vec3_from_array(r->torque), p);
}

/* Force and moment of every body add up to nothing. */
void law_equilibrium(fixture *f, randomness *r) {
  balance b = balance_open(f, r, KM_AXES_FIXED);
  const km_model *model = b.f->model;
  for (int body = 1; body < model->body_count; ++body) {
    km_wrench sum = applied_to(b.forces, body);
    for (int j = 0; j < model->joint_count; ++j)
      for (int end = 0; end < 2; ++end)
        if (model->frames[model->joints[j].frame[end]].body == body)
          sum = km_wrench_axpy(end ? 1.0 : -1.0, reaction(&b, j), sum);
    assert_near(km_vec3_norm(sum.f), 0.0, 1e-10 * b.size);
    assert_near(km_vec3_norm(sum.t), 0.0, 1e-10 * b.size * b.reach);
  }
  balance_close(&b);
}

static bool is_coupled(const km_model *model, int coordinate) {
  for (int i = 0; i < model->coupling_count; ++i)
    for (int k = 0; k < model->couplings[i].count; ++k)
      if (model->couplings[i].coordinates[k] == coordinate)
        return true;
  return false;
}

/* The wrench through a joint has the actuator's and the springs' force along its motion. */
void law_transmitted(fixture *f, randomness *r) {
  balance b = balance_open(f, r, KM_AXES_FIXED);
  for (int c = 0; c < b.f->model->coordinate_count; ++c) {
    km_twist h = km_coordinate_twist(b.f->mechanism, b.f->state, c);
    double found = km_wrench_power(reaction(&b, b.f->model->coordinates[c].joint), h);
    double expected = b.statics.least_norm[c] + km_forces_in_joint(b.forces, c);
    if (!is_coupled(b.f->model, c)) /* a gear's force goes through its joints too */
      assert_near(found, expected, 1e-10 * b.size * fmax(b.reach, 1.0));
  }
  assert_int_equal(b.statics.degree, b.mobility.redundant_constraints);
  assert_true(b.statics.held);
  balance_close(&b);
}

/* f̄ = D Z y, and the range of Z is D times the null space of J: J D⁻² f̄ = 0 (scaled by the columns' units). */
void law_least_norm(fixture *f, randomness *r) {
  balance b = balance_open(f, r, KM_AXES_JOINT);
  const km_mechanism *m = f->mechanism;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    int rows;
    double *J = whole_jacobian(f, s, &rows);
    for (int i = 0; i < rows; ++i) {
      double sum = 0.0, size = 0.0;
      for (int k = 0; k < sub->columns; ++k) {
        int c = m->column_coordinate[sub->column_start + k];
        double x = b.statics.least_norm[c] / (m->scale[c] * m->scale[c] * m->unit[c]);
        sum += J[k * rows + i] * x;
        size += fabs(J[k * rows + i] * x);
      }
      assert_near(sum, 0.0, 1e-10 * size + 1e-13 * b.size * fmax(b.reach, 1.0) / (m->scale[0] * m->scale[0]));
    }
    km_free(J);
  }
  balance_close(&b);
}

/* Loads, springs and actuators have no power in any free motion: the drives' tangents are some. */
void law_virtual_work(fixture *f, randomness *r) {
  balance b = balance_open(f, r, KM_AXES_JOINT);
  const km_mechanism *m = b.f->mechanism;
  double *rates = KM_NEW(double, (size_t)m->coordinate_count);
  for (int c = 0; c < m->coordinate_count; ++c) {
    km_driver_motion *drive;
    if (km_driver_motion_create(m, b.f->state, c, true, &drive, NULL))
      continue;
    if (km_driver_motion_tangent(drive, rates)) {
      double power = 0.0, size = 0.0;
      for (int i = 0; i < m->coordinate_count; ++i) {
        power += (b.statics.least_norm[i] + km_forces_in_joint(b.forces, i)) * rates[i];
        size += fabs(b.statics.least_norm[i] * rates[i]);
      }
      for (int body = 1; body < b.f->model->body_count; ++body) {
        km_wrench w = applied_to(b.forces, body);
        km_twist t = km_body_twist(b.f->mechanism, b.f->state, body, rates);
        power += km_wrench_power(w, t);
        size += km_vec3_norm(w.f) * km_vec3_norm(t.v) + km_vec3_norm(w.t) * km_vec3_norm(t.w);
      }
      assert_near(power, 0.0, 1e-10 * size + 1e-13 * b.size * fmax(b.reach, 1.0));
    }
    km_driver_motion_free(drive);
  }
  km_free(rates);
  balance_close(&b);
}

/* The least-norm solution of LAPACK, and the components that its null space leaves open. */
void law_reactions(fixture *f, randomness *r) {
  balance b = balance_open(f, r, KM_AXES_JOINT);
  bordered e = bordered_make(f->mechanism, f->state, b.forces, b.statics.least_norm, b.reach);
  lapack_int rank;
  int least = e.rows < e.columns ? e.rows : e.columns, m = e.rows, n = e.columns;
  double *s = KM_NEW(double, (size_t)least), *A = KM_NEW(double, (size_t)m *(size_t)n);
  double *U = KM_NEW(double, (size_t)m *(size_t)m), *Vt = KM_NEW(double, (size_t)n *(size_t)n);
  /* Least in |force|² + |torque / L|²: torques over L are the unknowns. */
  double L = km_mechanism_characteristic_length(f->mechanism, NULL);
  for (int i = 0; i < 6 * f->model->joint_count; ++i)
    for (int k = 0; k < m && i % 6 >= 3; ++k)
      e.A[(size_t)i * (size_t)m + (size_t)k] *= L;
  memcpy(A, e.A, (size_t)m * (size_t)n * sizeof *A);
  assert_int_equal(LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'A', m, n, A, m, s, U, m, Vt, n), 0);
  assert_int_equal(LAPACKE_dgelsd(LAPACK_COL_MAJOR, m, n, 1, e.A, m, e.rhs, m > n ? m : n, s, 1e-9, &rank), 0);
  assert_int_equal(n - rank, b.statics.degree);
  bool gears = b.f->model->coupling_count > 0; /* LAPACK's norm counts their multipliers, ours doesn't */
  for (int i = 0; i < 6 * b.f->model->joint_count; ++i) {
    const km_reaction *reaction = &b.statics.reactions[i / 6];
    double found = i % 6 < 3 ? reaction->force[i % 6] : reaction->torque[i % 6 - 3], open = 0.0;
    for (int k = rank; k < n; ++k)
      open = fmax(open, fabs(Vt[(size_t)i * (size_t)n + (size_t)k]));
    if (!gears || open < 1e-12)
      assert_near(found, i % 6 < 3 ? e.rhs[i] : L * e.rhs[i], 1e-8 * b.size * fmax(b.reach, 1.0));
    if (open < 1e-12 || open > 1e-6)
      assert_int_equal(reaction->indeterminate[i % 6], open > 1e-6);
  }
  km_free(s);
  km_free(A);
  km_free(U);
  km_free(Vt);
  bordered_free(&e);
  balance_close(&b);
}
