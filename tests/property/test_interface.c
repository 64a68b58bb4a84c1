/* Laws of the programming interface: frames against their motion, matrices against the mobility, arms against
 * frames. */
#include "kmech/arm.h"
#include "kmech/continuation.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "support/support.h"

#include <string.h>

/* The product of J and rates. */
static void multiply(const double *J, const double *rates, int coordinates, double twist[6]) {
  memset(twist, 0, 6 * sizeof *twist);
  for (int c = 0; c < coordinates; ++c)
    for (int r = 0; r < 6; ++r)
      twist[r] += J[6 * c + r] * rates[c];
}

/* Origin and first axis of a frame with the drive at s. */
static void look(fixture *f, km_driver_motion *drive, double s, int frame, km_frame_pose *out) {
  assert_int_equal(km_driver_motion_move_to(drive, s).stop, KM_STOP_NONE);
  km_poses_compute(f->mechanism, f->state);
  assert_int_equal(km_frame_place(f->mechanism, f->state, frame, out, NULL), KM_OK);
}

/* The twist at the drive's tangent is the central difference of the pose, whose error is h² of the third derivative. */
static void test_twists_are_derivatives(void **context) {
  (void)context;
  static const char *const names[] = {"fourbar", "slider_crank", "bricard", "bennett", "excavator", "klann"};
  for (size_t n = 0; n < sizeof names / sizeof *names; ++n) {
    fixture f = fixture_open(names[n]);
    int count = f.mechanism->coordinate_count, driver = f.model->sweep.coordinate >= 0 ? f.model->sweep.coordinate : 0;
    double *rates = KM_NEW(double, (size_t)count), *J = KM_NEW(double, 6 * (size_t)count), twist[6], other[6];
    km_driver_motion *drive;
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, driver, true, &drive, NULL), KM_OK);
    double factor = km_model_coordinate_factor(f.model, driver),
           s = km_state_coordinate(f.state, driver) + 0.1 / factor;
    double h = 1e-4 / factor, size = f.mechanism->length;
    for (int frame = 0; frame < km_model_frame_count(f.model); ++frame) {
      km_frame_pose here, ahead, back;
      look(&f, drive, s, frame, &here);
      assert_true(km_driver_motion_tangent(drive, rates));
      assert_int_equal(km_frame_twist(f.mechanism, f.state, frame, rates, twist, NULL), KM_OK);
      assert_int_equal(km_frame_jacobian(f.mechanism, f.state, frame, J, NULL), KM_OK);
      multiply(J, rates, count, other);
      look(&f, drive, s + h, frame, &ahead);
      look(&f, drive, s - h, frame, &back);
      for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        assert_near(other[k], twist[k], 1e-9 * size);
        assert_near(other[3 + k], twist[3 + k], 1e-9);
        assert_near((ahead.p[k] - back.p[k]) / 2e-4, twist[k], 1e-5 * size);
        double slope = (ahead.R[3 * k] - back.R[3 * k]) / 2e-4; /* ẋ = ω × x */
        assert_near(slope, twist[3 + i] * here.R[3 * j] - twist[3 + j] * here.R[3 * i], 1e-5);
      }
    }
    km_driver_motion_free(drive);
    km_free(rates);
    km_free(J);
    fixture_close(&f);
  }
}

static double dot(const double *a, const double *b, int n, int stride_a) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    sum += a[i * stride_a] * b[i];
  return sum;
}

/* J N = 0, Zᵀ Z = 1, m_j = Σ Z_jk², in every substructure of every model; rank + mobility = columns. */
static void test_matrices_agree_with_mobility(void **context) {
  (void)context;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    km_mobility mobility;
    int n = f.mechanism->coordinate_count, freedom;
    double *all = KM_NEW(double, (size_t)n *(size_t)n);
    km_state *fresh; /* a state without computed data */
    assert_int_equal(km_state_create(f.mechanism, &fresh, NULL), KM_OK);
    assert_int_equal(km_motions_basis(f.mechanism, fresh, all, &freedom, NULL),
                     km_substructure_count(f.mechanism) ? KM_USAGE : KM_OK);
    km_state_free(fresh);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(km_motions_basis(f.mechanism, f.state, all, &freedom, NULL), KM_OK);
    assert_int_equal(freedom, mobility.mobility);
    for (int s = 0; s < km_substructure_count(f.mechanism); ++s) {
      km_substructure_mobility e;
      km_substructure_evidence(f.mechanism, f.state, s, &e);
      int rows = km_substructure_rows(f.mechanism, s), columns = e.coordinates;
      assert_int_equal(e.rank + e.mobility, columns);
      double *J = KM_NEW(double, (size_t)rows *(size_t)columns);
      double *N = KM_NEW(double, (size_t)columns *(size_t)(e.mobility + 1));
      double *Z = KM_NEW(double, (size_t)columns *(size_t)(e.mobility + 1));
      assert_int_equal(km_substructure_jacobian(f.mechanism, f.state, s, J, NULL), KM_OK);
      assert_int_equal(km_substructure_null(f.mechanism, f.state, s, N, NULL), KM_OK);
      assert_int_equal(km_substructure_basis(f.mechanism, f.state, s, Z, NULL), KM_OK);
      for (int k = 0; k < e.mobility; ++k) {
        double size = sqrt(dot(N + k * columns, N + k * columns, columns, 1));
        for (int r = 0; r < rows; ++r) /* tolerance: residue of dropped rows by the rank tolerance */
          assert_near(dot(J + r, N + k * columns, columns, rows), 0.0, 10.0 * fmax(e.tolerance, 1e-9) * size);
        for (int l = 0; l < e.mobility; ++l)
          assert_near(dot(Z + k * columns, Z + l * columns, columns, 1), k == l ? 1.0 : 0.0, 1e-12);
      }
      for (int c = 0; c < columns; ++c) {
        double number = 0.0;
        for (int k = 0; k < e.mobility; ++k)
          number += Z[k * columns + c] * Z[k * columns + c];
        assert_near(number, km_mobility_number(f.state, km_substructure_coordinate(f.mechanism, s, c)), 1e-12);
      }
      km_free(J);
      km_free(N);
      km_free(Z);
    }
    km_free(all);
    fixture_close(&f);
  }
}

/* Perturbed coordinates are assembled to a closed configuration nearby; coordinates read equal those set. */
static void test_set_coordinates_stay_on_the_branch(void **context) {
  (void)context;
  randomness r = {7};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    int n = f.mechanism->coordinate_count;
    double *was = KM_NEW(double, (size_t)n), *off = KM_NEW(double, (size_t)n), *is = KM_NEW(double, (size_t)n);
    assert_int_equal(km_state_coordinates(f.mechanism, f.state, was, NULL), KM_OK);
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_true(km_state_mobility_is_known(f.mechanism, f.state));
    for (int c = 0; c < n; ++c)
      off[c] = was[c] + uniform(&r, -1e-3, 1e-3) * f.mechanism->unit[c] / km_model_coordinate_factor(f.model, c);
    assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, off, NULL), KM_OK);
    bool loops = f.mechanism->topology.substructure_count > 0; /* cached data of loops */
    assert_int_equal(km_state_mobility_is_known(f.mechanism, f.state), !loops);
    for (int i = 0; i < f.mechanism->topology.substructure_count; ++i)
      assert_int_equal(f.state->pivot_driver[i], KM_NEVER);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(km_state_set_coordinate(f.mechanism, f.state, 0, off[0], NULL),
                     f.mechanism->held[0] ? KM_USAGE : KM_OK);
    assert_int_equal(km_state_mobility_is_known(f.mechanism, f.state), !loops || f.mechanism->held[0]);
    assert_int_equal(km_state_coordinates(f.mechanism, f.state, is, NULL), KM_OK);
    for (int c = 0; c < n; ++c)
      assert_near(is[c], off[c], 1e-9 * (1.0 + fabs(off[c])));
    km_assembly evidence;
    assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
    km_state_coordinates(f.mechanism, f.state, is, NULL);
    for (int c = 0; c < n; ++c) /* least steps: no further than a few times what they were off */
      assert_near(is[c], off[c], 0.05 * f.mechanism->unit[c] / km_model_coordinate_factor(f.model, c));
    km_free(was);
    km_free(off);
    km_free(is);
    fixture_close(&f);
  }
}

/* The arm's effector is the frame of the mechanism, and what inverse kinematics finds reaches it. */
static void test_arms_agree_with_frames(void **context) {
  (void)context;
  randomness r = {3};
  static const char *const names[] = {"panda", "iiwa14", "robot7r"};
  for (int i = 0; i < 3; ++i) {
    fixture f = fixture_open(names[i]);
    int frame = km_model_frame_count(f.model) - 1;
    km_arm *arm;
    assert_int_equal(km_arm_create(f.mechanism, f.state, frame, KM_TASK_POSE, &arm, NULL), KM_OK);
    int n = km_arm_coordinates(arm), count = f.mechanism->coordinate_count;
    double q[32], near[32], found[32], J[6 * 32], whole[6 * 64], length = f.mechanism->length;
    for (int trial = 0; trial < 20; ++trial) {
      km_frame_pose a, b;
      for (int k = 0; k < n; ++k) {
        double low, high;
        int c = km_arm_coordinate(arm, k);
        bool limited = km_model_coordinate_limits(f.model, c, &low, &high);
        q[k] = limited ? uniform(&r, 0.8 * low + 0.2 * high, 0.2 * low + 0.8 * high) : uniform(&r, -1.0, 1.0);
        near[k] = q[k] + uniform(&r, -0.02, 0.02);
        km_state_set_coordinate(f.mechanism, f.state, c, q[k], NULL);
      }
      km_poses_compute(f.mechanism, f.state);
      assert_int_equal(km_arm_place(arm, q, &a, NULL), KM_OK);
      assert_int_equal(km_frame_place(f.mechanism, f.state, frame, &b, NULL), KM_OK);
      assert_int_equal(km_arm_jacobian(arm, q, J, NULL), KM_OK);
      assert_int_equal(km_frame_jacobian(f.mechanism, f.state, frame, whole, NULL), KM_OK);
      for (int k = 0; k < 12; ++k)
        assert_near(k < 9 ? a.R[k] : a.p[k - 9], k < 9 ? b.R[k] : b.p[k - 9], 1e-12 * (k < 9 ? 1.0 : 10.0 * length));
      for (int k = 0; k < n; ++k)
        for (int row = 0; row < 6; ++row)
          assert_near(J[6 * k + row], whole[6 * km_arm_coordinate(arm, k) + row],
                      1e-11 * (row < 3 ? 10.0 * length : 1.0));
      assert_true(count <= 64);
      if (km_arm_solve(arm, &a, near, 1, NULL, NULL, found, NULL) != KM_OK)
        fail_msg("%s: a pose that was reached isn't found again", names[i]);
      assert_int_equal(km_arm_place(arm, found, &b, NULL), KM_OK);
      for (int k = 0; k < 12; ++k)
        assert_near(k < 9 ? a.R[k] : a.p[k - 9], k < 9 ? b.R[k] : b.p[k - 9], 1e-10 * (k < 9 ? 1.0 : 10.0 * length));
    }
    km_arm_free(arm);
    fixture_close(&f);
  }
}

static bool refuse(void *asked, double done) {
  assert_true(done >= 0.0 && done <= 1.0);
  ++*(int *)asked;
  return false;
}

static void test_long_work_is_cancelled(void **context) {
  (void)context;
  int asked = 0;
  km_error error;
  fixture f = fixture_open("fourbar");
  km_modes modes;
  assert_int_equal(km_modes_find(f.mechanism, f.state, 0, 10, 1, refuse, &asked, &modes, &error), KM_CANCELLED);
  km_modes_free(&modes);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.progress = refuse;
  plan.context = &asked;
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_CANCELLED);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);

  f = fixture_open("panda");
  km_arm *arm;
  assert_int_equal(km_arm_create(f.mechanism, f.state, km_model_frame_count(f.model) - 1, KM_TASK_POSE, &arm, NULL),
                   KM_OK);
  double q[7], found[7];
  km_frame_pose pose;
  for (int k = 0; k < 7; ++k)
    q[k] = km_state_coordinate(f.state, km_arm_coordinate(arm, k));
  km_arm_place(arm, q, &pose, NULL);
  km_selfmotion motion;
  assert_int_equal(km_selfmotion_follow(arm, q, refuse, &asked, &motion, &error), KM_CANCELLED);
  km_selfmotion_free(&motion);
  km_ik_solutions branches;
  assert_int_equal(km_ik_solutions_find(arm, &pose, 1, refuse, &asked, &branches, &error), KM_CANCELLED);
  km_ik_solutions_free(&branches);
  pose.p[0] += 100.0; /* unreachable: the search is requested */
  assert_int_equal(km_arm_solve(arm, &pose, q, 1, refuse, &asked, found, &error), KM_CANCELLED);
  assert_int_equal(km_arm_solve(arm, &pose, q, 1, NULL, NULL, found, &error), KM_NO_RESULT);
  assert_int_equal(asked, 5);
  km_arm_free(arm);
  fixture_close(&f);
}

static void test_tables_as_columns_and_text(void **context) {
  (void)context;
  km_table *table = km_table_create();
  double values[2];
  char text[64], cut[6];
  km_table_add_column(table, "a", "mm");
  km_table_add_column(table, "b,c", NULL);
  for (int r = 0; r < 2; ++r) {
    double *row = km_table_add_row(table);
    row[0] = r;
    row[1] = 0.1 + r;
  }
  assert_int_equal(km_table_column(table, 1, values, NULL), KM_OK);
  assert_true(values[0] == 0.1 && values[1] == 1.1);
  assert_int_equal(km_table_column(table, 2, values, NULL), KM_USAGE);
  size_t size = km_table_csv(table, text, sizeof text);
  assert_string_equal(text, "a_mm,\"b,c\"\r\n0,0.1\r\n1,1.1\r\n");
  assert_int_equal(size, strlen(text));
  assert_int_equal(km_table_csv(table, NULL, 0), size);
  assert_int_equal(km_table_csv(table, cut, sizeof cut), size);
  assert_string_equal(cut, "a_mm,");
  km_table_free(table);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_twists_are_derivatives),
      cmocka_unit_test(test_matrices_agree_with_mobility),
      cmocka_unit_test(test_set_coordinates_stay_on_the_branch),
      cmocka_unit_test(test_arms_agree_with_frames),
      cmocka_unit_test(test_long_work_is_cancelled),
      cmocka_unit_test(test_tables_as_columns_and_text),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
