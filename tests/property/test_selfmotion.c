/* Self-motions and branches of inverse kinematics. */
#include "support/arm_families.h"

#include "arm/ik/ik_branches.h"
#include "report/record/track_record.h"

#include <stdio.h>
#include <string.h>

static const double well_inside[7] = {0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0.0};

static km_selfmotion follow(const km_arm *arm, const double *q) {
  km_selfmotion motion;
  km_error error = {0};
  if (km_selfmotion_follow(arm, q, NULL, NULL, &motion, &error))
    fail_msg("%s", error.text);
  return motion;
}

static double limit_distance(const km_arm *arm, const double *q) {
  double worst = -HUGE_VAL;
  for (int k = 0; k < arm->n; ++k)
    worst = fmax(worst, km_arm_limit_excess(arm, k, q[k]));
  return worst;
}

/* Closed, the effector held, and the ends of arcs exactly where a joint meets its limit. */
static void curves_hold_the_effector(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_pose target = effector_by_bodies(&f, arm, well_inside);
  km_selfmotion motion = follow(arm, well_inside);
  assert_true(motion.closed && motion.error <= 1e-9 && motion.arc_count >= 1);
  for (int i = 0; i < motion.count; ++i) {
    km_pose at = effector_by_bodies(&f, arm, motion.q + 7 * i);
    assert_true(km_vec3_norm(km_vec3_sub(at.p, target.p)) < 1e-9);
    for (int k = 0; k < 3; ++k)
      assert_true(km_vec3_norm(km_vec3_sub(at.R.axis[k], target.R.axis[k])) < 1e-9);
    bool inside = false;
    for (int k = 0; k < motion.arc_count; ++k)
      for (int turn = -1; turn <= 0; ++turn) {
        double u = motion.u[i] + turn * motion.length;
        inside = inside || (u >= motion.arcs[k].from && u <= motion.arcs[k].to);
      }
    assert_int_equal(inside, limit_distance(arm, motion.q + 7 * i) <= 0.0);
  }
  for (int i = 0; i < motion.row_count; ++i) { /* the arcs are within the limits, and end at them */
    const double *q = motion.row_q + 7 * i;
    km_pose at = effector_by_bodies(&f, arm, q);
    assert_true(km_vec3_norm(km_vec3_sub(at.p, target.p)) < 1e-9);
    assert_true(limit_distance(arm, q) <= 1e-9);
    bool first = i == 0 || motion.row_arc[i] != motion.row_arc[i - 1];
    bool last = i + 1 == motion.row_count || motion.row_arc[i] != motion.row_arc[i + 1];
    if (first || last)
      assert_near(limit_distance(arm, q), 0.0, 1e-9);
  }
  km_selfmotion_free(&motion);
  km_arm_free(arm);
  fixture_close(&f);
}

/* An S-R-S arm with the wrist at a distance has joint 4 at rest: two of its limits never end a curve. The closed length
 * doesn't depend on where one starts. */
static void lengths_dont_depend_on_the_start(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_selfmotion one = follow(arm, well_inside);
  for (int i = 10; i < one.count; i += one.count / 5) {
    km_selfmotion other = follow(arm, one.q + 7 * i);
    assert_true(other.closed);
    assert_near(other.length, one.length, 1e-5); /* arcs over chords: steps⁴ */
    assert_int_equal(other.arc_count, one.arc_count);
    km_selfmotion_free(&other);
  }
  km_selfmotion_free(&one);
  km_arm_free(arm);
  fixture_close(&f);
}

/* A limit that cuts off all but the tip of a coordinate's swing leaves an arc far narrower than the steps. */
static void narrow_arcs_are_found(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (int k = 0; k < 7; ++k) { /* free but for joint 2 */
    arm->low[k] = -HUGE_VAL;
    arm->high[k] = HUGE_VAL;
  }
  km_arm_space space;
  assert_true(km_arm_space_create(arm, &space));
  km_arm_update(arm, &space, well_inside);
  km_selfmotion_curve curve = {.arm = arm, .space = &space, .target = space.pose};
  assert_true(km_selfmotion_curve_follow(&curve, well_inside, 100.0));
  double top = -HUGE_VAL;
  for (int i = 0; i < curve.count; ++i)
    for (int part = 0; part < 50; ++part) {
      double q[KM_ARM_MAX_JOINTS];
      assert_true(km_selfmotion_curve_interpolate(&curve, i, part / 50.0, q, NULL));
      top = fmax(top, q[1]);
    }
  for (double depth = 1e-2; depth > 1e-6; depth *= 0.1) {
    int count;
    arm->low[1] = top - depth;
    arm->high[1] = top + 0.5;
    km_arc_span *arcs = km_selfmotion_curve_arcs(&curve, &count);
    assert_true(count >= 1);
    for (int k = 0; k < count; ++k) {
      double width = arcs[k].to - arcs[k].from;
      assert_true(width > 0.0 && width < 20.0 * sqrt(depth));
      assert_int_equal(arcs[k].column[0], 1);
    }
    km_free(arcs);
  }
  km_selfmotion_curve_free(&curve);
  km_arm_space_free(&space);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Revolute joints with limits wider than a full turn. */
static void widen(km_arm *arm) {
  for (int k = 0; k < arm->n; ++k) {
    arm->high[k] = k % 2 ? 3.0 : 3.6;
    arm->low[k] = -arm->high[k];
  }
}

/* min over joints of the distance to the nearer limit over half the range, from a table's row alone. */
static double margin_of(const km_arm *arm, const km_table *table, size_t row) {
  double least = 1.0;
  for (int k = 0; k < arm->n; ++k) {
    char name[32];
    int column;
    snprintf(name, sizeof name, "q.A%d", k + 1);
    assert_true((column = km_table_find(table, name)) >= 0);
    double q = km_table_row(table, row)[column];
    least = fmin(least, fmin(q - arm->low[k], arm->high[k] - q) / (0.5 * (arm->high[k] - arm->low[k])));
  }
  return least;
}

static void check_margins(const km_arm *arm, const km_selfmotion *motion, bool all) {
  km_table *table = km_selfmotion_table(arm, motion, all);
  assert_non_null(table);
  int margin = km_table_find(table, "limit_margin");
  assert_true(margin >= 0 && km_table_rows(table) > 100);
  for (size_t i = 0; i < km_table_rows(table); ++i) {
    assert_near(km_table_row(table, i)[margin], margin_of(arm, table, i), 1e-12);
    if (!all)
      assert_true(km_table_row(table, i)[margin] > -1e-9);
  }
  km_table_free(table);
}

/* The margin of a row is that of its angles, whatever the width of the limits. */
static void margins_are_those_of_the_row(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (int wide = 0; wide < 2; ++wide) {
    if (wide)
      widen(arm);
    km_selfmotion motion = follow(arm, well_inside);
    check_margins(arm, &motion, false);
    check_margins(arm, &motion, true);
    km_selfmotion_free(&motion);
  }
  km_arm_free(arm);
  fixture_close(&f);
}

/* A joint that rotates fully along a closed curve continues until its limit ends the arc, beyond one turn if the
 * limits allow; without limits the curve is closed. */
static void hinges_turn_on_to_their_limits(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (int k = 0; k < arm->n; ++k) {
    arm->low[k] = -HUGE_VAL;
    arm->high[k] = HUGE_VAL;
  }
  km_selfmotion free_motion = follow(arm, well_inside);
  assert_true(free_motion.closed && !free_motion.continues_by_turns && free_motion.is_within_limits);
  int turning = -1;
  for (int k = 0; k < 7; ++k)
    if (fabs(free_motion.q[7 * (free_motion.count - 1) + k] - well_inside[k]) > 6.0)
      turning = k;
  assert_true(turning >= 0);
  for (double high = 3.6; high < 30.0; high += 6.0) {
    arm->low[turning] = -high;
    arm->high[turning] = high;
    km_selfmotion motion = follow(arm, well_inside);
    assert_true(motion.closed && motion.continues_by_turns && !motion.is_within_limits);
    assert_near(motion.length, free_motion.length, 1e-12);
    assert_int_equal(motion.arc_count, 1);
    assert_int_equal(motion.arcs[0].column[0], turning);
    assert_int_equal(motion.arcs[0].column[1], turning);
    const double *first = motion.row_q, *last = motion.row_q + 7 * (motion.row_count - 1);
    assert_near(fabs(first[turning]), high, 1e-9);
    assert_near(fabs(last[turning]), high, 1e-9);
    assert_near(fabs(last[turning] - first[turning]), 2.0 * high, 1e-9);
    for (int i = 7; i < 7 * motion.row_count; ++i)
      assert_true(fabs(motion.row_q[i] - motion.row_q[i - 7]) < 0.06);
    km_selfmotion_free(&motion);
  }
  km_selfmotion_free(&free_motion);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Limits that exclude a gap far smaller than a step end arcs on either side of it. */
static void narrow_gaps_are_found(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (double gap = 1e-2; gap > 1e-8; gap *= 0.1) {
    for (int k = 0; k < arm->n; ++k) {
      arm->high[k] = M_PI - gap;
      arm->low[k] = -arm->high[k];
    }
    km_selfmotion motion = follow(arm, well_inside);
    assert_true(motion.arc_count > 0 && !motion.is_within_limits);
    double missing = motion.length;
    for (int k = 0; k < motion.arc_count; ++k)
      missing -= motion.arcs[k].to - motion.arcs[k].from;
    assert_true(missing > 0.0 && missing < 100.0 * gap);
    for (int i = 0; i < motion.row_count; ++i) {
      assert_int_equal(km_arm_limit_passed(arm, motion.row_q + 7 * i), -1);
      for (int k = 0; k < 7 && i > 0 && motion.row_arc[i] == motion.row_arc[i - 1]; ++k)
        assert_true(fabs(motion.row_q[7 * i + k] - motion.row_q[7 * (i - 1) + k]) < 0.06);
    }
    km_selfmotion_free(&motion);
  }
  km_arm_free(arm);
  fixture_close(&f);
}

static km_ik_solutions find(const km_arm *arm, const km_pose *at, unsigned long seed) {
  km_frame_pose pose;
  for (int k = 0; k < 3; ++k) {
    pose.R[k] = at->R.axis[k].x;
    pose.R[3 + k] = at->R.axis[k].y;
    pose.R[6 + k] = at->R.axis[k].z;
  }
  pose.p[0] = at->p.x;
  pose.p[1] = at->p.y;
  pose.p[2] = at->p.z;
  km_ik_solutions branches;
  km_error error = {0};
  if (km_ik_solutions_find(arm, &pose, seed, NULL, NULL, &branches, &error))
    fail_msg("%s", error.text);
  return branches;
}

static void iiwa_has_eight_branches(void **state) {
  (void)state;
  randomness r = {5};
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (int trial = 0; trial < 6; ++trial) {
    double q[KM_ARM_MAX_JOINTS];
    for (int k = 0; k < 7; ++k)
      q[k] = well_inside[k] + (trial ? uniform(&r, -0.1, 0.1) : 0.0);
    km_pose at = effector_by_bodies(&f, arm, q);
    km_ik_solutions branches = find(arm, &at, (unsigned long)trial);
    assert_int_equal(branches.count, 8);
    assert_int_equal(branches.within, 8);
    for (int b = 0; b < branches.count; ++b) {
      km_pose there = effector_by_bodies(&f, arm, branches.pose + 7 * b);
      assert_true(km_vec3_norm(km_vec3_sub(at.p, there.p)) < 1e-9);
      assert_int_equal(km_arm_limit_passed(arm, branches.pose + 7 * b), -1);
    }
    km_ik_solutions_free(&branches);
  }
  km_arm_free(arm);
  fixture_close(&f);
}

/* Branches of joints with limits wider than a full turn: equal in number, every arc ends at limits, every solution
 * is valid. */
static void wide_limits_keep_the_branches(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  widen(arm);
  km_pose at = effector_by_bodies(&f, arm, well_inside);
  km_ik_solutions branches = find(arm, &at, 1);
  assert_int_equal(branches.count, 8);
  assert_int_equal(branches.within, 8);
  for (int b = 0; b < branches.count; ++b) {
    const km_selfmotion *m = &branches.items[b];
    assert_int_equal(km_arm_limit_passed(arm, branches.pose + 7 * b), -1);
    assert_near(branches.margin[b], km_arm_limit_distance(arm, branches.pose + 7 * b), 1e-12);
    assert_true(m->arc_count > 0 && !m->is_within_limits);
    for (int i = 0; i < m->row_count; ++i) {
      bool first = i == 0 || m->row_arc[i] != m->row_arc[i - 1];
      bool last = i + 1 == m->row_count || m->row_arc[i] != m->row_arc[i + 1];
      double margin = km_arm_limit_distance(arm, m->row_q + 7 * i);
      assert_true(margin > -1e-9 && (margin < 1e-9 || !(first || last)));
    }
  }
  km_ik_solutions_free(&branches);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Six coordinates: single poses, of which one is where we came from. */
static void six_joints_have_single_poses(void **state) {
  (void)state;
  static const double q[KM_ARM_MAX_JOINTS] = {0.2, 0.6, -1.4, 0.3, 0.9, 0.2};
  fixture f = fixture_open("iiwa14");
  int third;
  km_error error;
  assert_int_equal(km_model_find_coordinate(f.model, "A3", &third, &error), KM_OK);
  km_hold hold = {third, 0.1};
  km_state_free(f.state);
  km_mechanism_free(f.mechanism);
  assert_int_equal(km_mechanism_compile(f.model, &hold, 1, &f.mechanism, &error), KM_OK);
  assert_int_equal(km_state_create(f.mechanism, &f.state, &error), KM_OK);
  f.state->q[third] = 0.1;
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  assert_int_equal(arm->n, 6);
  km_pose at = effector_by_bodies(&f, arm, q);
  km_ik_solutions branches = find(arm, &at, 1);
  double nearest = HUGE_VAL;
  for (int b = 0; b < branches.count; ++b) {
    double distance = 0.0;
    for (int k = 0; k < 6; ++k)
      distance += fabs(branches.pose[6 * b + k] - q[k]);
    nearest = fmin(nearest, distance);
  }
  assert_true(nearest < 1e-9);
  assert_true(branches.count >= 2 && branches.count <= 16);
  km_ik_solutions_free(&branches);
  km_arm_free(arm);
  fixture_close(&f);
}

/* A UR5 by its published parameters, at a pose of which a search by random starts finds seven of eight: from any seed,
 * and with limits of a turn either way each at 2⁶ turns. */
static void a_ur5_reaches_a_pose_in_eight_ways(void **state) {
  (void)state;
  static const double quarter = 0.5 * M_PI, free_turns[6] = {0}, limits[6] = {6.28, 6.28, 6.28, 6.28, 6.28, 6.28};
  const double dh[6][3] = {{quarter, 0, 0.089159}, {0, -0.425, 0},         {0, -0.39225, 0},
                           {quarter, 0, 0.10915},  {-quarter, 0, 0.09465}, {0, 0, 0.0823}};
  km_vec3 turn = {-1.8627909832117735, -1.2907823993038978, -0.9755141860085286};
  km_pose at = {km_quaternion_rotation(km_quaternion_exp(turn)),
                {-0.007547234593810882, -0.03993273582117833, 0.15258758565913125}};
  for (unsigned long seed = 1; seed <= 6; ++seed) {
    fixture f = dh_arm(dh, 6, seed % 2 ? free_turns : limits, false);
    km_arm *arm = arm_of(&f, "l6", "t", KM_TASK_POSE);
    km_ik_solutions branches = find(arm, &at, seed);
    assert_int_equal(branches.count, 8);
    assert_true(branches.confirmed && branches.closed_form);
    for (int b = 0; b < branches.count; ++b) {
      km_pose there = effector_by_bodies(&f, arm, branches.pose + 6 * b);
      assert_true(km_vec3_norm(km_vec3_sub(at.p, there.p)) < 1e-11);
      for (int k = 0; k < 6 && seed % 2 == 0; ++k) {
        int first, last;
        km_arm_full_turn_range(arm, k, branches.pose[6 * b + k], branches.pose[6 * b + k], &first, &last);
        assert_int_equal(last - first, 1);
      }
    }
    km_ik_solutions_free(&branches);
    km_arm_free(arm);
    fixture_close(&f);
  }
}

/* The arm with a straight elbow: two of the eight solutions coincide, also with rounding. */
static void a_straight_elbow_is_one_pose(void **state) {
  (void)state;
  static const double quarter = 0.5 * M_PI, free_turns[6] = {0},
                      straight[KM_ARM_MAX_JOINTS] = {0.1, 0.2, 0.0, 0.4, 0.5, 0.6};
  const double dh[6][3] = {{quarter, 0, 0.089159}, {0, -0.425, 0},         {0, -0.39225, 0},
                           {quarter, 0, 0.10915},  {-quarter, 0, 0.09465}, {0, 0, 0.0823}};
  fixture f = dh_arm(dh, 6, free_turns, false);
  km_arm *arm = arm_of(&f, "l6", "t", KM_TASK_POSE);
  km_pose at = effector_by_bodies(&f, arm, straight);
  for (unsigned long seed = 1; seed <= 5; ++seed) {
    km_ik_solutions branches = find(arm, &at, seed);
    int singular = 0;
    for (int b = 0; b < branches.count; ++b)
      singular += branches.singular[b];
    assert_int_equal(branches.count, 7);
    assert_int_equal(singular, 1);
    assert_true(branches.confirmed);
    km_ik_solutions_free(&branches);
  }
  km_arm_free(arm);
  fixture_close(&f);
}

/* Two to spare: directions round the start, each held to the effector and ended by a limit or at π. */
static void surfaces_are_sampled_on_a_circle(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_AXIS);
  km_pose target = effector_by_bodies(&f, arm, well_inside);
  km_selfmotion motion = follow(arm, well_inside);
  assert_int_equal(motion.arc_count, KM_SELFMOTION_DIRECTIONS);
  assert_true(motion.error <= 1e-9);
  int ended = 0;
  for (int i = 0; i < motion.row_count; ++i) {
    const double *q = motion.row_q + 7 * i;
    km_pose at = effector_by_bodies(&f, arm, q);
    assert_true(km_vec3_norm(km_vec3_sub(at.p, target.p)) < 1e-9);
    assert_true(km_vec3_norm(km_vec3_sub(at.R.axis[2], target.R.axis[2])) < 1e-9);
    assert_true(limit_distance(arm, q) <= 1e-9);
    bool last = i + 1 == motion.row_count || motion.row_arc[i] != motion.row_arc[i + 1];
    if (last && motion.arcs[motion.row_arc[i]].column[1] >= 0) {
      assert_near(limit_distance(arm, q), 0.0, 1e-9);
      ++ended;
    } else if (last) {
      assert_near(motion.row_u[i], M_PI, 1e-9);
    }
  }
  assert_true(ended > 0);
  km_selfmotion_free(&motion);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Two parallel slides can diverge together for ever: the curve is cut where they are of no use any more. */
static void slides_that_leave(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"characteristic_length\": 1},"
      "\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"s\"}, {\"name\": \"t\"},"
      "{\"name\": \"b\", \"frames\": [{\"name\": \"n\", \"T\": [0.3, 0, 0.2]}]},"
      "{\"name\": \"c\", \"frames\": [{\"name\": \"n\", \"T\": [0, 0.2, 0.3]}]},"
      "{\"name\": \"d\", \"frames\": [{\"name\": \"n\", \"T\": [0.1, 0, 0.2]}]},"
      "{\"name\": \"e\"}, {\"name\": \"h\", \"frames\": [{\"name\": \"n\", \"T\": [0.1, 0.1, 0.1]}]}], \"joints\": ["
      "{\"name\": \"S\", \"type\": \"Tz\", \"body_frame_pairs\": [\"fixed\", \"s\"]},"
      "{\"name\": \"T\", \"type\": \"Tz\", \"body_frame_pairs\": [\"s\", \"t\"], \"limits\": [-0.5, 0.5]},"
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"t\", \"b\"], \"initial_displacement\": 0.3},"
      "{\"name\": \"B\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"b\", \"n\"], \"c\"], \"initial_displacement\": "
      "0.7},"
      "{\"name\": \"C\", \"type\": \"Rx\", \"body_frame_pairs\": [[\"c\", \"n\"], \"d\"], \"initial_displacement\": "
      "0.5},"
      "{\"name\": \"D\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"d\", \"n\"], \"e\"], \"initial_displacement\": "
      "0.4},"
      "{\"name\": \"E\", \"type\": \"Rz\", \"body_frame_pairs\": [\"e\", \"h\"], \"initial_displacement\": 0.2}]}]}");
  km_arm *arm = arm_of(&f, "h", "n", KM_TASK_POSE);
  double q[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < arm->n; ++k)
    q[k] = f.mechanism->start[arm->coordinate[k]];
  km_selfmotion motion = follow(arm, q);
  assert_false(motion.closed);
  assert_true(motion.length > arm->max_travel && motion.length < 4.0 * arm->max_travel);
  assert_int_equal(motion.arc_count, 1);
  assert_near(motion.arcs[0].to - motion.arcs[0].from, sqrt(2.0), 1e-9); /* T over its metre, S against it */
  km_selfmotion_free(&motion);
  km_pose at = effector_by_bodies(&f, arm, q);
  km_ik_solutions branches = find(arm, &at, 1);
  assert_true(branches.count >= 1 && branches.count <= 16);
  km_ik_solutions_free(&branches);
  km_arm_free(arm);
  fixture_close(&f);
}

static void out_of_reach(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_frame_pose pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {2.0, 0, 0.5}};
  km_ik_solutions branches;
  km_error error;
  assert_int_equal(km_ik_solutions_find(arm, &pose, 1, NULL, NULL, &branches, &error), KM_NO_RESULT);
  assert_non_null(strstr(error.text, "out of reach"));
  km_ik_solutions_free(&branches);
  km_arm_free(arm);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(curves_hold_the_effector),
      cmocka_unit_test(lengths_dont_depend_on_the_start),
      cmocka_unit_test(narrow_arcs_are_found),
      cmocka_unit_test(margins_are_those_of_the_row),
      cmocka_unit_test(hinges_turn_on_to_their_limits),
      cmocka_unit_test(narrow_gaps_are_found),
      cmocka_unit_test(iiwa_has_eight_branches),
      cmocka_unit_test(wide_limits_keep_the_branches),
      cmocka_unit_test(six_joints_have_single_poses),
      cmocka_unit_test(a_ur5_reaches_a_pose_in_eight_ways),
      cmocka_unit_test(a_straight_elbow_is_one_pose),
      cmocka_unit_test(surfaces_are_sampled_on_a_circle),
      cmocka_unit_test(slides_that_leave),
      cmocka_unit_test(out_of_reach),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
