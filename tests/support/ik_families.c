/* Inverse kinematics of random arms against many random starts. */
#include "support/arm_families.h"

#include "arm/ik/ik_branches.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ik_case {
  fixture f;
  km_arm *arm;
  km_arm_space space;
  km_pose target; /* as the arm sees it */
  km_ik_solutions branches;
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
  km_frame_pose given;
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
  c.listed = km_ik_solutions_find(c.arm, &given, seed, NULL, NULL, &c.branches, &error) == KM_OK;
  if (!km_arm_space_create(c.arm, &c.space))
    fail_msg("out of memory");
  return c;
}

static void close_case(ik_case *c) {
  km_ik_solutions_free(&c->branches);
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

/* True if the list has a solution at q. Near singular configurations two solutions are close, and Newton's method
 * ends between them. */
static bool is_listed(ik_case *c, const double *q) {
  double nearest = HUGE_VAL, sigma[KM_ARM_ROWS];
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
  bool fine = c.listed && (c.shape == ARM_GENERAL || (c.branches.confirmed && c.branches.closed_form));
  if (!fine)
    snprintf(why, size, "%s: listed %d, confirmed %d, closed form %d, %d poses", shapes[c.shape], c.listed,
             c.branches.confirmed, c.branches.closed_form, c.branches.count);
  for (int i = 0; i < c.branches.count && fine; ++i) {
    fine = reaches(&c, c.branches.pose + i * 6);
    if (!fine)
      snprintf(why, size, "%s: pose %d doesn't reach the target", shapes[c.shape], i + 1);
  }
  for (unsigned long i = 0; i < STARTS && fine && c.branches.confirmed; ++i) {
    double q[6];
    fine = !km_arm_search(c.arm, &c.space, &c.target, 1, 7919 * seed + i, q) || is_listed(&c, q);
    if (!fine)
      snprintf(why, size, "%s: of %d poses, start %lu finds another: %.6f %.6f %.6f %.6f %.6f %.6f", shapes[c.shape],
               c.branches.count, i, q[0], q[1], q[2], q[3], q[4], q[5]);
  }
  close_case(&c);
  return fine;
}

/* True if a component of the list passes through q; its points are at most 0.05 apart. */
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
  for (unsigned long i = 0; i < STARTS && fine && c.branches.confirmed; ++i) {
    double q[7];
    fine = !km_arm_search(c.arm, &c.space, &c.target, 1, 7919 * seed + i, q) || is_on_component(&c, q);
    if (!fine)
      snprintf(why, size, "%s, confirmed %d: of %d components, start %lu is on none", shapes[c.shape],
               c.branches.confirmed, c.branches.count, i);
  }
  close_case(&c);
  return fine;
}

static int by_size(const void *a, const void *b) {
  const double *x = a, *y = b;
  return *x < *y ? -1 : *x > *y;
}

/* Lengths of a self-motion's arcs, the longest at the end; the caller frees them. */
static double *arc_lengths(const km_selfmotion *m) {
  double *lengths = KM_NEW(double, (size_t)m->arc_count + 1);
  for (int i = 0; i < m->arc_count; ++i)
    lengths[i] = m->arcs[i].to - m->arcs[i].from;
  qsort(lengths, (size_t)m->arc_count, sizeof *lengths, by_size);
  return lengths;
}

static bool same_arcs(const km_selfmotion *one, const km_selfmotion *other, char *why, size_t size) {
  double *x = arc_lengths(one), *y = arc_lengths(other);
  bool same = one->arc_count == other->arc_count;
  for (int i = 0; i < one->arc_count && same; ++i) /* lengths of arcs are sums over chords, to steps⁴ */
    same = fabs(x[i] - y[i]) <= 1e-4;
  if (!same)
    snprintf(why, size, "%d arcs from one pose, %d from another of them; the longest %.9g and %.9g", one->arc_count,
             other->arc_count, one->arc_count ? x[one->arc_count - 1] : 0.0,
             other->arc_count ? y[other->arc_count - 1] : 0.0);
  km_free(x);
  km_free(y);
  return same;
}

/* From a pose of each of some arcs, which may be turns away. */
static bool same_from_any(const km_arm *a, const km_selfmotion *m, randomness *r, char *why, size_t size) {
  bool same = true;
  for (int trial = 0; trial < 3 && same && m->row_count > 0; ++trial) {
    km_selfmotion other;
    km_error error = {0};
    same = km_selfmotion_follow(a, m->row_q + below(r, m->row_count) * a->n, NULL, NULL, &other, &error) == KM_OK &&
           same_arcs(m, &other, why, size);
    km_selfmotion_free(&other);
  }
  return same;
}

static bool is_on_arc(const ik_case *c, const double *q) {
  const int n = c->arm->n;
  for (int i = 0; i < c->branches.count; ++i) {
    const km_selfmotion *m = &c->branches.items[i];
    for (int row = 0; row < m->row_count; ++row) {
      double sum = 0.0;
      for (int k = 0; k < n; ++k)
        sum += pow(m->row_q[row * n + k] - q[k], 2);
      if (sum < 0.04 * 0.04)
        return true;
    }
  }
  return false;
}

/* A random one of the turns at which a pose is within its limits; false: there is none. */
static bool turn_at_random(const km_arm *a, randomness *r, double *q) {
  for (int k = 0; k < a->n; ++k) {
    int first = (int)ceil((a->low[k] - q[k]) / (2.0 * M_PI)), last = (int)floor((a->high[k] - q[k]) / (2.0 * M_PI));
    if (last < first)
      return false;
    q[k] += 2.0 * M_PI * (first + below(r, last - first + 1));
  }
  return true;
}

bool family_turns(uint64_t seed, char *why, size_t size) {
  enum { STARTS = 200 };
  randomness r = {seed};
  ik_case c = open_case(&r, 7, true, seed);
  km_selfmotion motion;
  km_error error = {0};
  double q[7];
  bool fine = c.listed, found = false;
  if (!fine)
    snprintf(why, size, "the pose isn't reached");
  for (unsigned long i = 0; i < STARTS && fine && c.branches.confirmed; ++i) {
    if (!km_arm_search(c.arm, &c.space, &c.target, 1, 104729 * seed + i, q) || !turn_at_random(c.arm, &r, q))
      continue;
    found = true;
    fine = is_on_arc(&c, q);
    if (!fine)
      snprintf(why, size, "start %lu is on no arc of %d branches: %.4f %.4f %.4f %.4f %.4f %.4f %.4f", i,
               c.branches.count, q[0], q[1], q[2], q[3], q[4], q[5], q[6]);
  }
  if (fine && found) {
    fine = km_selfmotion_follow(c.arm, q, NULL, NULL, &motion, &error) == KM_OK &&
           same_from_any(c.arm, &motion, &r, why, size);
    km_selfmotion_free(&motion);
  }
  close_case(&c);
  return fine;
}
