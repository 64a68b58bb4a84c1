/* Inverse kinematics of random arms against many random starts. */
#include "support/arm_families.h"

#include "redundancy/branches.h"

#include <stdio.h>
#include <string.h>

typedef struct ik_case {
  fixture f;
  km_arm *arm;
  km_arm_space space;
  km_pose target; /* as the arm sees it */
  km_branches branches;
  arm_shape shape;
  bool listed;
} ik_case;

static ik_case open_case(randomness *r, int n, bool roomy, unsigned long seed) {
  ik_case c = {.shape = (arm_shape)below(r, 3)};
  c.f = random_arm(r, n, c.shape, below(r, n - 2), roomy, roomy);
  c.arm = arm_of(&c.f, "hand", "tool", KM_TASK_POSE);
  double q[8];
  for (int k = 0; k < n; ++k)
    q[k] = roomy ? uniform(r, c.arm->low[k], c.arm->high[k]) : uniform(r, -M_PI, M_PI);
  km_pose pose = effector_by_bodies(&c.f, c.arm, q);
  km_effector_pose given;
  for (int k = 0; k < 3; ++k) {
    given.R[k] = pose.R.axis[k].x;
    given.R[3 + k] = pose.R.axis[k].y;
    given.R[6 + k] = pose.R.axis[k].z;
  }
  given.p[0] = pose.p.x;
  given.p[1] = pose.p.y;
  given.p[2] = pose.p.z;
  c.target = km_arm_from_model(c.arm, &pose);
  km_error error = {0};
  c.listed = km_branches_find(c.arm, &given, seed, &c.branches, &error) == KM_OK;
  if (!km_arm_space_create(c.arm, &c.space))
    fail_msg("out of memory");
  return c;
}

static void close_case(ik_case *c) {
  km_branches_free(&c->branches);
  km_arm_space_free(&c->space);
  km_arm_free(c->arm);
  fixture_close(&c->f);
}

static double apart(const km_arm *a, const double *x, const double *y) {
  double sum = 0.0;
  for (int k = 0; k < a->n; ++k)
    sum += pow(km_arm_difference(a, k, x[k], y[k]), 2);
  return sqrt(sum);
}

/* Is there a pose of the list at q? Near singular poses two of them lie close, and Newton's method ends between. */
static bool is_listed(ik_case *c, const double *q) {
  double nearest = (double)INFINITY, sigma[KM_ARM_ROWS];
  for (int i = 0; i < c->branches.count; ++i)
    nearest = fmin(nearest, apart(c->arm, c->branches.pose + i * c->arm->n, q));
  km_arm_update(c->arm, &c->space, q);
  km_arm_singular_values(c->arm, &c->space, sigma);
  return nearest <= 1e-9 + 1e-10 / sigma[KM_ARM_ROWS - 1];
}

static bool reaches(ik_case *c, const double *q) {
  km_pose pose = effector_by_bodies(&c->f, c->arm, q), target = km_arm_to_model(c->arm, &c->target);
  double left = km_vec3_norm(km_vec3_sub(pose.p, target.p));
  for (int k = 0; k < 3; ++k)
    left += km_vec3_norm(km_vec3_sub(pose.R.axis[k], target.R.axis[k]));
  return left < 1e-9;
}

bool family_six_hinges(uint64_t seed, char *why, size_t size) {
  enum { STARTS = 1500 };
  static const char *const shapes[] = {"general", "meeting", "parallel"};
  randomness r = {seed};
  ik_case c = open_case(&r, 6, false, seed);
  bool fine = c.listed && c.branches.confirmed && (c.branches.closed_form || c.shape == ARM_GENERAL);
  if (!fine)
    snprintf(why, size, "%s: listed %d, confirmed %d, closed form %d, %d poses", shapes[c.shape], c.listed,
             c.branches.confirmed, c.branches.closed_form, c.branches.count);
  for (int i = 0; i < c.branches.count && fine; ++i) {
    fine = reaches(&c, c.branches.pose + i * 6);
    if (!fine)
      snprintf(why, size, "%s: pose %d doesn't reach the target", shapes[c.shape], i + 1);
  }
  for (unsigned long i = 0; i < STARTS && fine; ++i) {
    double q[6];
    fine = !km_arm_search(c.arm, &c.space, &c.target, 1, 7919 * seed + i, q) || is_listed(&c, q);
    if (!fine)
      snprintf(why, size, "%s: of %d poses, start %lu finds another: %.6f %.6f %.6f %.6f %.6f %.6f", shapes[c.shape],
               c.branches.count, i, q[0], q[1], q[2], q[3], q[4], q[5]);
  }
  close_case(&c);
  return fine;
}

/* Does a component of the list pass through q? Its points are no more than .05 apart. */
static bool is_on_component(ik_case *c, const double *q) {
  bool on = false;
  for (int i = 0; i < c->branches.count && !on; ++i) {
    const km_selfmotion *m = &c->branches.items[i];
    for (int k = 0; k < m->count && !on; ++k)
      on = apart(c->arm, m->q + k * c->arm->n, q) < 0.04;
  }
  return on;
}

bool family_seven_hinges(uint64_t seed, char *why, size_t size) {
  enum { STARTS = 400 };
  static const char *const shapes[] = {"general", "meeting", "parallel"};
  randomness r = {seed};
  ik_case c = open_case(&r, 7, false, seed);
  bool fine = c.listed;
  if (!fine)
    snprintf(why, size, "%s: the pose isn't reached", shapes[c.shape]);
  for (unsigned long i = 0; i < STARTS && fine; ++i) {
    double q[7];
    fine = !km_arm_search(c.arm, &c.space, &c.target, 1, 7919 * seed + i, q) || is_on_component(&c, q);
    if (!fine)
      snprintf(why, size, "%s, confirmed %d: of %d components, start %lu is on none", shapes[c.shape],
               c.branches.confirmed, c.branches.count, i);
  }
  close_case(&c);
  return fine;
}
