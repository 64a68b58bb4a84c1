/* Serial chains: kinematics, and the columns of the null space, against the bodies' poses and LAPACK. */
#include "support/arms.h"

#include "arm/path_control.h"
#include "arm/tracking/objective.h"
#include "arm/tracking/seven_joint_arm.h"
#include "arm/tracking/tracker.h"
#include "kinematics/body_poses.h"
#include "kmech/arm.h"

#include <lapacke.h>
#include <stdio.h>
#include <string.h>

typedef struct subject {
  fixture f;
  km_arm *arm;
  km_arm_space space;
} subject;

static subject subject_of(int index, km_task task) {
  static const char *const models[] = {"iiwa14", "panda", "robot7r"}, *const bodies[] = {"flange", "flange", "link_7"};
  subject s = {.f = index < 3 ? fixture_open(models[index]) : odd_arm()};
  s.arm = index < 3 ? arm_of(&s.f, bodies[index], "tool", task) : arm_of(&s.f, "hand", "tip", task);
  assert_true(km_arm_space_create(s.arm, &s.space));
  return s;
}

static void subject_close(subject *s) {
  km_arm_space_free(&s->space);
  km_arm_free(s->arm);
  fixture_close(&s->f);
}

enum { SUBJECTS = 4 };

static void pose_is_that_of_the_bodies(void **state) {
  (void)state;
  randomness r = {7};
  for (int i = 0; i < SUBJECTS; ++i) {
    subject s = subject_of(i, KM_TASK_POSE);
    double far = km_vec3_norm(s.arm->origin);
    for (int trial = 0; trial < 20; ++trial) {
      double q[KM_ARM_MAX_JOINTS];
      random_pose(s.arm, &r, q);
      km_arm_update(s.arm, &s.space, q);
      km_pose own = km_arm_to_model(s.arm, &s.space.pose), theirs = effector_by_bodies(&s.f, s.arm, q);
      assert_true(km_vec3_norm(km_vec3_sub(own.p, theirs.p)) < 1e-14 * (1.0 + 4.0 * far));
      for (int k = 0; k < 3; ++k)
        assert_true(km_vec3_norm(km_vec3_sub(own.R.axis[k], theirs.R.axis[k])) < 1e-14);
    }
    subject_close(&s);
  }
}

/* Columns are the coordinates' twists at the effector's origin, v over L, slides times L. */
static void jacobian_is_that_of_the_twists(void **state) {
  (void)state;
  randomness r = {8};
  for (int i = 0; i < SUBJECTS; ++i) {
    subject s = subject_of(i, KM_TASK_POSE);
    double L = s.arm->length;
    for (int trial = 0; trial < 20; ++trial) {
      double q[KM_ARM_MAX_JOINTS];
      random_pose(s.arm, &r, q);
      km_arm_update(s.arm, &s.space, q);
      km_pose at = effector_by_bodies(&s.f, s.arm, q);
      for (int k = 0; k < s.arm->n; ++k) {
        const km_arc *arc = NULL;
        for (int b = 0; b < s.f.mechanism->topology.body_count - 1; ++b)
          if (s.f.mechanism->arcs[b].joint == s.f.model->coordinates[s.arm->coordinate[k]].joint)
            arc = &s.f.mechanism->arcs[b];
        km_twist t = km_coordinate_twist(s.f.mechanism, s.f.state, s.arm->coordinate[k]);
        double sign = arc->is_reversed ? -1.0 : 1.0, unit = s.arm->unit[k], far = 1e-13 * (1.0 + km_vec3_norm(at.p));
        km_vec3 v = km_vec3_scale(sign * unit / L, km_vec3_add(t.v, km_vec3_cross(t.w, at.p)));
        km_vec3 w = km_vec3_scale(sign * unit, t.w);
        const double *c = s.space.jacobian + 6 * k;
        assert_at_most(km_vec3_norm(km_vec3_sub(v, km_vec3_from_array(c))), far);
        assert_at_most(km_vec3_norm(km_vec3_sub(w, km_vec3_from_array(c + 3))), 1e-13);
      }
    }
    subject_close(&s);
  }
}

static double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    sum += a[i] * b[i];
  return sum;
}

/* Columns of every task: c₁ = (J⁺ξ, 1)/√(1 + |J⁺ξ|²), J⁺ by LAPACK's singular values; c₂ … are unit null vectors of
 * J. */
static void path_control_is_the_pseudo_inverse(void **state) {
  (void)state;
  randomness r = {9};
  for (int i = 0; i < SUBJECTS * 3; ++i) {
    subject s = subject_of(i % SUBJECTS, (km_task)(i / SUBJECTS));
    const int n = s.arm->n, rows = s.arm->rows, freedom = s.arm->freedom;
    for (int trial = 0; trial < 10; ++trial) {
      double q[KM_ARM_MAX_JOINTS], xi[6], path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS],
          J[6 * KM_ARM_MAX_JOINTS];
      double sigma[6], S[6], x[KM_ARM_MAX_JOINTS] = {0}, size = 0.0;
      random_pose(s.arm, &r, q);
      for (int k = 0; k < rows; ++k) {
        xi[k] = uniform(&r, -1.0, 1.0);
        size += xi[k] * xi[k];
      }
      for (int k = 0; k < rows; ++k)
        xi[k] /= sqrt(size);
      km_arm_update(s.arm, &s.space, q);
      memcpy(J, s.space.jacobian, (size_t)(rows * n) * sizeof *J);
      km_arm_singular_values(s.arm, &s.space, sigma);
      km_control_factor(s.arm, &s.space, xi, NULL);
      double z = km_control_columns(s.arm, &s.space, NULL, path, self);
      for (int f = 0; f < freedom; ++f) {
        assert_near(dot(self + f * n, self + f * n, n), 1.0, 1e-13);
        assert_near(dot(self + f * n, path, n), 0.0, 1e-12);
        for (int k = 0; k < rows; ++k) {
          double sum = 0.0;
          for (int c = 0; c < n; ++c)
            sum += J[c * rows + k] * self[f * n + c];
          assert_near(sum, 0.0, 1e-12);
        }
      }
      lapack_int rank;
      memcpy(x, xi, (size_t)rows * sizeof *x);
      double copy[6 * KM_ARM_MAX_JOINTS];
      memcpy(copy, J, sizeof copy);
      assert_int_equal(LAPACKE_dgelsd(LAPACK_COL_MAJOR, rows, n, 1, copy, rows, x, n, S, 1e-14, &rank), 0);
      for (int k = 0; k < rows; ++k)
        assert_near(sigma[k], S[k], 1e-13);
      double scale = 1.0 / sqrt(1.0 + dot(x, x, n)), worst = 1e-13 / (S[rows - 1] * scale);
      assert_near(z, scale, worst);
      for (int k = 0; k < n; ++k)
        assert_near(path[k], scale * x[k], worst);
    }
    subject_close(&s);
  }
}

/* Moving along c₁ moves the effector by +ξ. */
static void effector_moves_along_the_path(void **state) {
  (void)state;
  subject s = subject_of(2, KM_TASK_POSE);
  static const double xi[6] = {0.3, -0.4, 0.5, 0.2, 0.6, -0.3};
  const double h = 1e-8;
  double q[KM_ARM_MAX_JOINTS], path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS];
  for (int k = 0; k < s.arm->n; ++k)
    q[k] = s.f.state->q[s.arm->coordinate[k]];
  km_arm_update(s.arm, &s.space, q);
  km_pose before = s.space.pose;
  km_control_factor(s.arm, &s.space, xi, NULL);
  double z = km_control_columns(s.arm, &s.space, NULL, path, self), e[6];
  for (int k = 0; k < s.arm->n; ++k)
    q[k] -= h * path[k] / z; /* back: the error to where it was is then +ξ h */
  km_arm_update(s.arm, &s.space, q);
  km_arm_error(s.arm, &s.space, &before, e, NULL, NULL);
  for (int k = 0; k < 6; ++k)
    assert_near(e[k] / h, xi[k], 1e-5); /* |q′|² h, and rounding over h */
  subject_close(&s);
}

static const double golden_rows[6][8] = {{0.0000, -0.0134, -0.1356, -0.0256, 0.1756, -0.0123, -0.0936, 0.2853},
                                         {0.0000, 0.0200, 0.0000, 0.1821, 0.0073, -0.3956, -0.0074, 0.6905},
                                         {0.0000, -0.1343, 0.0136, 0.1766, -0.0106, -0.1770, 0.0040, -0.0611},
                                         {0.0000, 0.9950, -0.0978, -0.9791, 0.0604, 0.9981, -0.0584, 0.2548},
                                         {1.0000, 0.0000, 0.1986, -0.1947, -0.0038, -0.0040, 0.2024, -0.6369},
                                         {0.0000, -0.0998, -0.9751, 0.0585, 0.9981, -0.0604, -0.9775, -0.1671}};

static void thesis_columns(void **state) {
  (void)state;
  static const double want[8][2] = {{.2906, -.0847}, {-.0348, .0148}, {.0217, .8156},   {.5621, -.0026},
                                    {-.3434, .4313}, {.5439, .0146},  {-.3967, -.3758}, {.1638, 0}};
  double J[48], Z[64];
  km_control control;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 8; ++c)
      J[c * 6 + r] = golden_rows[r][c];
  assert_int_equal(km_control_of_matrix(J, 6, 8, Z, &control, NULL), KM_OK);
  assert_int_equal(control.freedom, 2);
  double sign = Z[8 + 2] < 0.0 ? -1.0 : 1.0;
  for (int r = 0; r < 8; ++r) {
    assert_near(Z[r], want[r][0], 1e-4);
    assert_near(sign * Z[8 + r], want[r][1], 1e-4);
  }
}

/* The model's own columns about the inertial origin are the thesis's (C and D against their joints' sense). */
static void thesis_robot(void **state) {
  (void)state;
  subject s = subject_of(2, KM_TASK_POSE);
  double q[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < 7; ++k)
    q[k] = s.f.state->q[s.arm->coordinate[k]];
  km_arm_update(s.arm, &s.space, q);
  km_vec3 p = km_arm_to_model(s.arm, &s.space.pose).p;
  for (int k = 0; k < 7; ++k) {
    const double *c = s.space.jacobian + 6 * k;
    km_vec3 w = km_vec3_from_array(c + 3), v = km_vec3_add(km_vec3_from_array(c), km_vec3_cross(p, w));
    double found[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
    for (int r = 0; r < 6; ++r)
      assert_near(found[r], golden_rows[r][k], 5e-4);
  }
  subject_close(&s);
}

/* A Z′ = 0, Z′ᵀZ′ = 1, last entries 0 but the first: for random matrices of every shape and rank. */
static void control_of_random_matrices(void **state) {
  (void)state;
  randomness r = {11};
  enum { MOST = 12 };
  for (int trial = 0; trial < 300; ++trial) {
    int columns = 2 + below(&r, MOST - 1), rows = 1 + below(&r, MOST), rank = 1 + below(&r, rows);
    double A[MOST * MOST] = {0}, Z[MOST * MOST];
    rank = rank < columns ? rank : columns - 1;
    for (int k = 0; k < rank; ++k) {
      double pose_error[MOST], right[MOST];
      for (int i = 0; i < MOST; ++i) {
        pose_error[i] = uniform(&r, -1.0, 1.0);
        right[i] = uniform(&r, -1.0, 1.0);
      }
      for (int c = 0; c < columns; ++c)
        for (int i = 0; i < rows; ++i)
          A[c * rows + i] += pose_error[i] * right[c];
    }
    km_control control;
    assert_int_equal(km_control_of_matrix(A, rows, columns, Z, &control, NULL), KM_OK);
    assert_int_equal(control.rank, rank);
    assert_true(Z[columns - 1] > 0.0);
    for (int k = 0; k < control.freedom; ++k) {
      const double *z = Z + k * columns;
      assert_true(k == 0 || z[columns - 1] == 0.0);
      for (int j = 0; j <= k; ++j)
        assert_near(dot(z, Z + j * columns, columns), j == k, 1e-11);
      for (int i = 0; i < rows; ++i) {
        double sum = 0.0;
        for (int c = 0; c < columns; ++c)
          sum += A[c * rows + i] * z[c];
        assert_near(sum, 0.0, 1e-8); /* rank 1e-9 · 12: pivots below count as 0 */
      }
    }
  }
}

static void control_refuses(void **state) {
  (void)state;
  double Z[16], bad[2] = {1.0, (double)NAN}, full[4] = {1, 0, 0, 1}, blocked[2] = {0.0, 1.0};
  km_control control;
  km_error error;
  assert_int_equal(km_control_of_matrix(bad, 1, 2, Z, &control, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "row 1, column 2"));
  assert_int_equal(km_control_of_matrix(full, 2, 2, Z, &control, &error), KM_NO_RESULT);
  assert_int_equal(km_control_of_matrix(blocked, 1, 2, Z, &control, &error), KM_NO_RESULT);
  assert_int_equal(km_control_of_matrix(full, 4, 1, Z, &control, &error), KM_USAGE);
}

/* The kernels' own sine and cosine, within an ulp or so of the library's; two at once have the same bits. */
static void sines(void **state) {
  (void)state;
  randomness r = {3};
  for (int trial = 0; trial < 20000; ++trial) {
    double size = trial % 3 == 0 ? 7.0 : trial % 3 == 1 ? 1e5 : 1e-3, x = uniform(&r, -size, size), sine, cosine;
    x = trial % 50 == 0 ? below(&r, 1000) * (M_PI / 4.0) : x;
    km_sincos(x, &sine, &cosine);
    assert_near(sine, sin(x), 2.3e-16);
    assert_near(cosine, cos(x), 2.3e-16);
    km_two_numbers sines, cosines;
    km_two_sincos((km_two_numbers){-x, x}, &sines, &cosines);
    for (int k = 0; k < 2; ++k) {
      assert_near(sines[k], k == 0 ? -sine : sine, 0.0);
      assert_near(cosines[k], cosine, 0.0);
    }
  }
}

unsigned km_lanes_step_plain(const km_arm *arm, km_lanes *lanes);

/* Lane l begins so that its predictor leads near q, and aims at the pose there. */
static void start_near(const km_study *study, km_tracker_space *space, randomness *r, const double *q, km_lanes *lanes,
                       int l) {
  const km_path_point *point = &study->path->points[0];
  double xi[6];
  lanes->start.z[l] = 0.5;
  lanes->start.ds[l] = 0.05;
  lanes->start.per_second[l] = lanes->start.speed[l] = 1.0;
  lanes->start.tan_phi[l] = uniform(r, -1.0, 1.0);
  for (int k = 0; k < 7; ++k) {
    lanes->start.path[k][l] = uniform(r, 0.2, 1.0);
    lanes->start.null[k][l] = uniform(r, -0.1, 0.1);
    lanes->start.last[k][l] = uniform(r, -1e-3, 1e-3);
    lanes->start.before[k][l] = uniform(r, -1e-3, 1e-3);
    double step = (lanes->start.path[k][l] + lanes->start.tan_phi[l] * lanes->start.null[k][l]) / 0.5 * 0.05;
    lanes->start.q[k][l] = q[k] - step + uniform(r, -1e-3, 1e-3);
  }
  km_arm_update(study->arm, &space->arm, q);
  km_arm_task_rows(study->arm, &space->arm.pose.R, point->twist, xi);
  km_lanes_set_target(lanes, l, &space->arm.pose, xi);
}

/* Nodes computed in SIMD lanes have the bits of nodes computed one by one, also if some fail, for every register
 * width. */
static void lanes_have_the_same_bits(void **state) {
  (void)state;
  static const char *const objectives[] = {"path-control", "singular-value"};
  randomness r = {17};
  int failed = 0, compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    fixture f = fixture_open(trial % 2 ? "panda" : "iiwa14");
    char text[1024];
    double x = uniform(&r, -1, 1), y = uniform(&r, -1, 1), z = uniform(&r, -0.5, 1);
    int steps = 2 + below(&r, 30);
    snprintf(
        text, sizeof text,
        "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"segments\": [{\"type\": \"line\", \"to\": [%g, %g, %g],"
        "\"steps\": %d}]}, \"objective\": \"%s\"}",
        x, y, z, steps, objectives[trial % 2]);
    km_study *study = study_of(&f, text);
    const km_tracker tracker = {study->arm, study->path, &study->objective};
    km_tracker_space space;
    km_arena arena = {0};
    km_path_node from[KM_STEP_BATCH], to[KM_STEP_BATCH], one;
    assert_true(km_tracker_space_create(study->arm, &space) && km_path_node_create(study->arm, &arena, &one));
    const km_path_node *start_is_valid[KM_STEP_BATCH];
    km_path_node *ends_at[KM_STEP_BATCH];
    km_step_choice choices[KM_STEP_BATCH];
    km_step_end ends[KM_STEP_BATCH];
    double tan_phi[KM_STEP_BATCH], q[7];
    for (int k = 0; k < 7; ++k)
      q[k] = km_arm_from_units(study->arm, k, study->start[k]);
    int count = 2 + below(&r, KM_STEP_BATCH - 1);
    for (int l = 0; l < KM_STEP_BATCH; ++l) {
      static const km_step_choice greedy_choice = {0};
      assert_true(km_path_node_create(study->arm, &arena, &from[l]) && km_path_node_create(study->arm, &arena, &to[l]));
      km_tracker_compute_node(&tracker, &space, 0, q, &greedy_choice, &from[l]);
      tan_phi[l] = uniform(&r, -3.0, 3.0);
      choices[l] = (km_step_choice){.tan_phi = &tan_phi[l]};
      start_is_valid[l] = &from[l];
      ends_at[l] = &to[l];
    }
    int samples[KM_STEP_BATCH] = {0}, last = study->path->samples - 1;
    for (int l = 1; l < count && last > 1; l += 2) /* some are a sample ahead of the others */
      if (!km_tracker_step(&tracker, &space, 0, 1.0, &from[l], &choices[l], &one).stop) {
        km_path_node_copy(study->arm, &from[l], &one);
        samples[l] = 1;
      }
    for (int k = 0; k < last - 1 && k < 4; ++k) {
      unsigned long before = space.arm.evaluations, told = 0;
      km_tracker_steps(&tracker, &space, samples, count, start_is_valid, choices, ends_at, ends);
      unsigned long abreast = space.arm.evaluations - before;
      for (int l = 0; l < count; ++l) {
        km_step_end end = km_tracker_step(&tracker, &space, samples[l], 1.0, &from[l], &choices[l], &one);
        told += ends[l].evaluations;
        assert_int_equal(end.stop, ends[l].stop);
        assert_int_equal(end.column, ends[l].column);
        failed += end.stop != KM_TRACK_COMPLETE;
        if (end.stop == KM_TRACK_SINGULAR)
          continue;
        ++compared;
        assert_memory_equal(one.q, to[l].q, 7 * sizeof(double));
        assert_memory_equal(one.path, to[l].path, 8 * sizeof(double));
        assert_memory_equal(one.self, to[l].self, 7 * sizeof(double));
        assert_memory_equal(one.corrections, to[l].corrections, 7 * sizeof(double));
        assert_memory_equal(&one.value, &to[l].value, sizeof(double));
        km_path_node_copy(study->arm, &from[l], &one);
        samples[l]++;
      }
      assert_true(space.arm.evaluations - before == 2 * abreast && told == abreast);
    }
    km_lanes a = {.used = trial % 3 ? (1u << count) - 1 : (1u << KM_LANES) - 1}, b;
    for (int l = 0; l < KM_LANES; ++l)
      start_near(study, &space, &r, q, &a, l);
    b = a;
    unsigned done = km_lanes_step(study->arm, &a);
    assert_int_equal(done & a.used, km_lanes_step_plain(study->arm, &b) & b.used);
    assert_int_equal(done & a.used, a.used);
    for (int l = 0; l < KM_LANES && a.used >> l; ++l)
      assert_true(a.jacobians[l] >= 1.0 && a.jacobians[l] == b.jacobians[l]);
    for (int l = 0; l < KM_LANES && a.used >> l; ++l)
      for (int k = 0; k < 7; ++k)
        assert_true(a.q[k][l] == b.q[k][l] && a.path[k][l] == b.path[k][l] && a.null[k][l] == b.null[k][l]);
    km_tracker_space_free(&space);
    km_arena_free(&arena);
    km_study_free(study);
    fixture_close(&f);
  }
  assert_true(failed > 5 && compared > 50); /* both kinds were met */
}

/* The predictor of a whole step: (c₁/z + tan φ·c₂/z)Δσ from a node. */
static void predicted(const km_arm *a, const km_path_node *from, const double *tan_phi, double ds, double *q) {
  for (int k = 0; k < a->n; ++k) {
    double rate = from->path[k];
    for (int j = 0; j < a->freedom; ++j)
      rate += tan_phi[j] * from->self[j * a->n + k];
    q[k] = from->q[k] + rate / from->z * ds;
  }
}

/* Every step ends at the configuration nearest to its predictor: their difference has no component along the null
 * space. So the result is the same when Newton starts from an extrapolation of previous correctors, with two
 * Jacobians a step instead of three. Newton ends with errors of 1e-12 across the null space; along it with the error
 * of the last step but one: the null space rotates by about |d|² over a corrector d. */
static void steps_end_nearest_to_their_predictors(void **state) {
  (void)state;
  static const struct {
    const char *model, *body, *task;
    double tan_phis[2];
  } cases[] = {{"iiwa14", "flange", "pose", {0.3}},
               {"panda", "flange", "pose", {0.0}},
               {"iiwa14", "flange", "axis", {0.2, -0.1}}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    fixture f = fixture_open(cases[i].model);
    char text[512];
    snprintf(text, sizeof text,
             "{\"effector\": [\"%s\", \"tool\"], \"task\": \"%s\", \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0],"
             "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [0.4, 0.35, 0.5], \"steps\": 100}]}}",
             cases[i].body, cases[i].task);
    km_study *study = study_of(&f, text);
    const km_arm *a = study->arm;
    const km_tracker tracker = {a, study->path, &study->objective};
    km_tracker_space space;
    km_arena arena = {0};
    km_path_node here, there, alone;
    assert_true(km_tracker_space_create(a, &space) && km_path_node_create(a, &arena, &here) &&
                km_path_node_create(a, &arena, &there) && km_path_node_create(a, &arena, &alone));
    const km_step_choice choice = {.tan_phi = cases[i].tan_phis};
    double q[KM_ARM_MAX_JOINTS], d[KM_ARM_MAX_JOINTS];
    for (int k = 0; k < a->n; ++k)
      q[k] = km_arm_from_units(a, k, study->start[k]);
    km_tracker_compute_node(&tracker, &space, 0, q, &choice, &here);
    unsigned long steps = 0, before;
    for (int sample = 0; sample < 60; ++sample) {
      double ds = study->path->points[sample + 1].s - study->path->points[sample].s, size = 0.0;
      before = space.arm.evaluations;
      assert_int_equal(km_tracker_step(&tracker, &space, sample, 1.0, &here, &choice, &there).stop, KM_TRACK_COMPLETE);
      steps += sample > 3 ? space.arm.evaluations - before : 2;
      predicted(a, &here, cases[i].tan_phis, ds, d);
      for (int k = 0; k < a->n; ++k) {
        d[k] = there.q[k] - d[k];
        size += d[k] * d[k];
      }
      assert_true(size > 1e-16); /* there was something to correct */
      for (int j = 0; j < a->freedom; ++j)
        assert_at_most(fabs(dot(there.self + j * a->n, d, a->n)), 1e-12 + 10.0 * size * size);
      here.correction_count = 0;
      km_tracker_step(&tracker, &space, sample, 1.0, &here, &choice, &alone);
      for (int k = 0; k < a->n; ++k)
        assert_near(alone.q[k], there.q[k], 1e-11 + 20.0 * size * size);
      km_path_node_copy(a, &here, &there);
    }
    assert_int_equal(steps, 2 * 60);
    km_tracker_space_free(&space);
    km_arena_free(&arena);
    km_study_free(study);
    fixture_close(&f);
  }
}

static void arms_that_are_none(void **state) {
  (void)state;
  km_arm *arm;
  km_error error;
  fixture f = fixture_open("fourbar");
  int frame = f.model->frame_count - 1;
  assert_int_equal(km_arm_create(f.mechanism, f.state, frame, KM_TASK_POSE, &arm, &error), KM_USAGE);
  assert_null(arm);
  fixture_close(&f);
  f = odd_arm();
  const char *names[2] = {"l3", "t"};
  assert_int_equal(km_model_find_frame(f.model, names, 2, &frame, &error), KM_OK);
  assert_int_equal(km_arm_create(f.mechanism, f.state, frame, KM_TASK_POSE, &arm, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "3 free coordinates; expected at least 6"));
  assert_int_equal(km_arm_create(f.mechanism, f.state, frame, KM_TASK_POSITION, &arm, &error), KM_OK);
  km_arm_free(arm);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pose_is_that_of_the_bodies),
      claim_test(jacobian_is_that_of_the_twists, "An arm's Jacobian is that of its bodies' twists, for four arms",
                 "rounding over the distance from the inertial frame"),
      claim_test(path_control_is_the_pseudo_inverse,
                 "The path-control column is that of LAPACK's pseudo-inverse, every task of four arms",
                 "rounding over the smallest singular value"),
      cmocka_unit_test(effector_moves_along_the_path),
      cmocka_unit_test(thesis_columns),
      cmocka_unit_test(thesis_robot),
      cmocka_unit_test(control_of_random_matrices),
      cmocka_unit_test(control_refuses),
      cmocka_unit_test(sines),
      cmocka_unit_test(lanes_have_the_same_bits),
      claim_test(steps_end_nearest_to_their_predictors,
                 "An arm's steps end at the pose nearest to their predictors, with two Jacobians each",
                 "the fourth power of the corrector"),
      cmocka_unit_test(arms_that_are_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
