/* Arms whose motions change fewer rows of a task than it has: those that move in a plane, and SCARA arms. */
#include "support/arms.h"

#include "base/text.h"
#include "kmech/arm.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* An arm of revolute joints in an inclined plane: links of 1 m, each slightly rotated against the previous one. */
static fixture planar_arm(int links, const char *axes) {
  km_text text = {0};
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int k = 0; k < links; ++k)
    km_text_format(&text, "%s{\"name\": \"l%d\", \"frames\": [{\"name\": \"e\", \"T\": [1, 0, 0]}]}", k ? ", " : "", k);
  km_text_format(
      &text,
      "], \"joints\": [{\"name\": \"q0\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"base\"], [\"l0\"]], "
      "\"initial_displacement\": 0.3}");
  for (int k = 1; k < links; ++k)
    km_text_format(&text,
                   ", {\"name\": \"q%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l%d\", \"e\"], [\"l%d\"]], "
                   "\"initial_displacement\": 0.4}",
                   k, k - 1, k);
  km_text_format(&text, "]}], \"fixed\": {\"frames\": [{\"name\": \"base\", \"T\": [1, 2, 3], \"R\": %s}]}}", axes);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* An arm can change the part of a task spanned by its twists, whatever their plane; the remaining rows need no
 * joints. The Jacobian for programs has all rows. */
static void planar_arms_have_rows_of_their_plane(void **state) {
  (void)state;
  static const char *const axes[] = {"[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "[[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]"};
  static const struct {
    int links;
    km_task task;
    int freedom;
  } arms[] = {{2, KM_TASK_POSITION, 0},
              {3, KM_TASK_POSITION, 1},
              {3, KM_TASK_POSE, 0},
              {6, KM_TASK_POSE, 3},
              {7, KM_TASK_POSE, 4}};
  for (size_t i = 0; i < 2 * sizeof arms / sizeof *arms; ++i) {
    fixture f = planar_arm(arms[i / 2].links, axes[i % 2]);
    char last[16];
    snprintf(last, sizeof last, "l%d", arms[i / 2].links - 1);
    km_arm *arm = arm_of(&f, last, "e", arms[i / 2].task);
    const int n = arms[i / 2].links, rows = km_arm_rows(arm);
    assert_int_equal(km_arm_freedom(arm), arms[i / 2].freedom);
    assert_int_equal(rows, arms[i / 2].task == KM_TASK_POSE ? 6 : 3);
    double q[KM_ARM_MAX_JOINTS], J[6 * KM_ARM_MAX_JOINTS], near[KM_ARM_MAX_JOINTS];
    for (int k = 0; k < n; ++k)
      q[k] = 0.3 + 0.1 * k;
    assert_int_equal(km_arm_jacobian(arm, q, J, NULL), KM_OK);
    for (int k = 0; k < n; ++k) { /* speed of the tip by a central difference */
      const double step = 1e-5;
      km_frame_pose low, high;
      memcpy(near, q, sizeof q);
      near[k] = q[k] - step;
      assert_int_equal(km_arm_place(arm, near, &low, NULL), KM_OK);
      near[k] = q[k] + step;
      assert_int_equal(km_arm_place(arm, near, &high, NULL), KM_OK);
      for (int r = 0; r < 3; ++r)
        assert_near(J[k * rows + r], (high.p[r] - low.p[r]) / (2.0 * step), 1e-9);
    }
    /* A pose of its own is found again from another one; one beside the plane isn't. */
    km_frame_pose pose;
    assert_int_equal(km_arm_place(arm, q, &pose, NULL), KM_OK);
    for (int k = 0; k < n; ++k)
      near[k] = q[k] + 0.1;
    assert_int_equal(km_arm_solve(arm, &pose, near, 1, NULL, NULL, near, NULL), KM_OK);
    km_frame_pose back;
    assert_int_equal(km_arm_place(arm, near, &back, NULL), KM_OK);
    for (int r = 0; r < 3; ++r)
      assert_near(back.p[r], pose.p[r], 1e-11);
    for (int r = 0; r < 3; ++r)
      pose.p[r] += 0.01 * (i % 2 ? (const double[]){0.8, 0.0, 0.6}[r] : (const double[]){0.0, 0.0, 1.0}[r]);
    assert_int_equal(km_arm_solve(arm, &pose, near, 1, NULL, NULL, near, NULL), KM_NO_RESULT);
    km_arm_free(arm);
    fixture_close(&f);
  }
}

/* Three hinges in a plane that hold the tip make a four-bar: a self-motion keeps the tip's place all the way round. */
static void a_planar_arm_moves_about_its_tip(void **state) {
  (void)state;
  fixture f = planar_arm(3, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]");
  km_arm *arm = arm_of(&f, "l2", "e", KM_TASK_POSITION);
  const double q[3] = {0.3, 0.9, 0.8};
  km_selfmotion motion;
  km_frame_pose held, pose;
  assert_int_equal(km_selfmotion_follow(arm, q, NULL, NULL, &motion, NULL), KM_OK);
  assert_int_equal(km_arm_place(arm, q, &held, NULL), KM_OK);
  assert_true(motion.count > 20);
  for (int i = 0; i < motion.count; ++i) {
    assert_int_equal(km_arm_place(arm, motion.q + 3 * i, &pose, NULL), KM_OK);
    for (int r = 0; r < 3; ++r)
      assert_near(pose.p[r], held.p[r], 1e-10);
  }
  km_selfmotion_free(&motion);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Three hinges about parallel axes and a slide along them: four of a pose's six rows, and two elbows for every pose. */
static void a_scara_has_two_elbows(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"l0\", \"frames\": [{\"name\": \"e\", \"T\": [0.4, 0, 0]}]}, "
      "{\"name\": \"l1\", \"frames\": [{\"name\": \"e\", \"T\": [0.3, 0, 0]}]}, {\"name\": \"l2\"}, {\"name\": \"l3\", \"frames\": "
      "[{\"name\": \"e\", \"T\": [0, 0, -0.1]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": "
      "[\"fixed\", \"l0\"]}, {\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l0\", \"e\"], [\"l1\"]]}, {\"name\": \"C\", "
      "\"type\": \"Tz\", \"body_frame_pairs\": [[\"l1\", \"e\"], [\"l2\"]]}, {\"name\": \"D\", \"type\": \"Rz\", "
      "\"body_frame_pairs\": [\"l2\", \"l3\"]}]}]}");
  km_arm *arm = arm_of(&f, "l3", "e", KM_TASK_POSE);
  const double q[4] = {0.3, 0.7, 0.1, 0.2}, turned = 2.0 * atan2(0.3 * sin(0.7), 0.4 + 0.3 * cos(0.7));
  const double other[4] = {0.3 + turned, -0.7, 0.1, 1.2 - (0.3 + turned) + 0.7};
  km_frame_pose pose;
  km_ik_solutions solutions;
  assert_int_equal(km_arm_freedom(arm), 0);
  assert_int_equal(km_arm_place(arm, q, &pose, NULL), KM_OK);
  assert_int_equal(km_ik_solutions_find(arm, &pose, 1, NULL, NULL, &solutions, NULL), KM_OK);
  assert_int_equal(solutions.count, 2);
  int first = fabs(solutions.pose[1] - q[1]) < 1e-6 ? 0 : 1;
  for (int k = 0; k < 4; ++k) {
    assert_near(solutions.pose[4 * first + k], q[k], 1e-10);
    assert_near(solutions.pose[4 * (1 - first) + k], other[k], 1e-10);
  }
  km_ik_solutions_free(&solutions);
  km_arm_free(arm);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(planar_arms_have_rows_of_their_plane),
                                     cmocka_unit_test(a_planar_arm_moves_about_its_tip),
                                     cmocka_unit_test(a_scara_has_two_elbows)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
