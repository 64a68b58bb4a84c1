/* Continuation of a one-parameter self-motion by arc length (docs/theory.md 12.8).
 *
 *   tangent t: unit null vector of J;   predictor q + h t;   corrector: Newton with minimum-norm steps to the same pose
 *   accepted if the correction is at most 0.2 h and t·t' > 0.98;   arc length = chord (1 + angle(t, t')²/24)
 *
 * Between points the curve is the cubic Hermite interpolant, projected onto the pose. */
#include "arm/ik/ik_branches.h"
#include "base/number/vectors.h"

#include <string.h>

static const double max_step = 0.05; /* largest step, radians */

double km_arm_difference(const km_arm *a, int column, double from, double to) {
  return km_arm_is_hinge(a, column) ? remainder(to - from, 2.0 * M_PI) : to - from;
}

/* Unit tangent t[n] of the self-motion at the configuration of the space, oriented along `guide`. False: not unique. */
static bool tangent(const km_arm *a, km_arm_space *s, const double *guide, double *t) {
  static const double none[KM_ARM_ROWS] = {0};
  double path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS] = {0};
  km_control_factor(a, s, none, NULL);
  if (a->freedom > 1 && guide) { /* several freedoms: projection of the guide on the null space */
    double size = 0.0;
    memcpy(path, guide, (size_t)a->n * sizeof *path);
    km_control_project_out(a, s, path);
    for (int k = 0; k < a->n; ++k) {
      t[k] = guide[k] - path[k];
      size += t[k] * t[k];
    }
    for (int k = 0; k < a->n; ++k)
      t[k] /= sqrt(size);
    return size > 0.0;
  }
  km_control_columns(a, s, guide, path, self);
  memcpy(t, self, (size_t)a->n * sizeof *t);
  return s->null_count == 1;
}

/* Projects q onto the target pose by Newton's method; false if it moves farther than `most`. */
static bool project(const km_arm *a, km_arm_space *s, const km_pose *target, double most, double *q) {
  double before[KM_ARM_MAX_JOINTS], moved = 0.0;
  memcpy(before, q, (size_t)a->n * sizeof *q);
  if (!km_arm_reach(a, s, target, NULL, 10, 1.0, q))
    return false;
  for (int k = 0; k < a->n; ++k)
    moved += (q[k] - before[k]) * (q[k] - before[k]);
  return sqrt(moved) <= most;
}

/* Appends a point with arc length, configuration and tangent. */
static bool add(km_selfmotion_curve *c, double u, const double *q, const double *t) {
  size_t n = (size_t)c->arm->n;
  if (c->count == c->capacity) {
    int capacity = c->capacity ? 2 * c->capacity : 256;
    double *us = km_resize(c->u, (size_t)capacity, sizeof *us);
    c->u = us ? us : c->u;
    double *qs = us ? km_resize(c->q, (size_t)capacity * n, sizeof *qs) : NULL;
    c->q = qs ? qs : c->q;
    double *ts = qs ? km_resize(c->t, (size_t)capacity * n, sizeof *ts) : NULL;
    c->t = ts ? ts : c->t;
    if (!ts) {
      c->failed = true;
      return false;
    }
    c->capacity = capacity;
  }
  c->u[c->count] = u;
  memcpy(c->q + (size_t)c->count * n, q, n * sizeof *q);
  memcpy(c->t + (size_t)c->count * n, t, n * sizeof *t);
  c->count++;
  return true;
}

/* Arc length over a chord: chord · (1 + angle²/24) with the angle between the end tangents; error of fourth order. */
static double arc_over(double chord, const double *t0, const double *t1, int n) {
  double cosine = km_dot(t0, t1, n);
  double angle = cosine < 1.0 ? acos(cosine < -1.0 ? -1.0 : cosine) : 0.0;
  return chord * (1.0 + angle * angle / 24.0);
}

/* Predictor and corrector over a step h from (q, t); false: rejected, because the curvature is too large for h. */
static bool step(const km_selfmotion_curve *c, const double *q, const double *t, double h, double *next, double *next_t,
                 double *difference) {
  const int n = c->arm->n;
  double chord = 0.0;
  for (int k = 0; k < n; ++k)
    next[k] = q[k] + h * t[k];
  if (!project(c->arm, c->space, &c->target, 0.2 * h, next))
    return false;
  tangent(c->arm, c->space, t, next_t);
  for (int k = 0; k < n; ++k)
    chord += (next[k] - q[k]) * (next[k] - q[k]);
  *difference = arc_over(sqrt(chord), t, next_t, n);
  return km_dot(t, next_t, n) > 0.98;
}

/* True if the curve closes on the step after q: the start lies ahead within the distance `within`, with its tangent.
 * *left is the remaining arc length. */
static bool is_closed_by(const km_selfmotion_curve *c, const double *start, const double *start_t, const double *q,
                         const double *t, double within, double *left) {
  const int n = c->arm->n;
  double difference[KM_ARM_MAX_JOINTS], along = 0.0, off = 0.0;
  for (int k = 0; k < n; ++k)
    difference[k] = km_arm_difference(c->arm, k, q[k], start[k]);
  along = km_dot(difference, t, n);
  for (int k = 0; k < n; ++k)
    off += (difference[k] - along * t[k]) * (difference[k] - along * t[k]);
  if (!(along >= 0.0 && along <= within && sqrt(off) <= 0.1 * within && km_dot(t, start_t, n) > 0.9))
    return false;
  *left = arc_over(sqrt(km_dot(difference, difference, n)), t, start_t, n);
  return true;
}

bool km_arm_slide_diverged(const km_arm *a, const double *q) {
  for (int k = 0; k < a->n; ++k)
    if (a->motions[k].primitive == KM_PRISMATIC && fabs(q[k]) > a->max_travel)
      return true;
  return false;
}

/* Adds points from the start in one direction until the curve closes, is longer than `longest`, or ends at a
 * singularity (step below 1e-7). */
static void trace(km_selfmotion_curve *c, const double *start, const double *start_t, double longest, double sense) {
  enum { MAX_POINTS = 40000 };
  const int n = c->arm->n;
  double q[KM_ARM_MAX_JOINTS], t[KM_ARM_MAX_JOINTS], next[KM_ARM_MAX_JOINTS], next_t[KM_ARM_MAX_JOINTS],
      u = 0.0, h = max_step, difference, left;
  memcpy(q, start, (size_t)n * sizeof *q);
  for (int k = 0; k < n; ++k)
    t[k] = sense * start_t[k];
  while (u < longest && c->count < MAX_POINTS) {
    c->cancelled = c->progress && !c->progress(c->context, u / longest);
    c->failed = c->failed || c->cancelled;
    if (c->failed)
      return;
    double reach = fmin(h, longest - u);
    if (!step(c, q, t, reach, next, next_t, &difference)) {
      h *= 0.5;
      if (h < 1e-7)
        return;
      continue;
    }
    memcpy(q, next, (size_t)n * sizeof *q);
    memcpy(t, next_t, (size_t)n * sizeof *t);
    u += difference;
    double shown[KM_ARM_MAX_JOINTS];
    for (int k = 0; k < n; ++k)
      shown[k] = sense * t[k];
    if (!add(c, sense * u, q, shown))
      return;
    if (km_arm_slide_diverged(c->arm, q))
      return;
    h = fmin(1.5 * h, max_step);
    if (c->arm->freedom == 1 && sense > 0.0 && u > 2.0 * difference &&
        is_closed_by(c, start, start_t, q, t, 1.01 * h, &left)) {
      c->closed = true;
      c->length = u + left;
      return;
    }
  }
}

/* Reverses the order of the points. */
static void reverse(km_selfmotion_curve *c) {
  int n = c->arm->n;
  for (int i = 0, k = c->count - 1; i < k; ++i, --k) {
    double swap = c->u[i];
    c->u[i] = c->u[k];
    c->u[k] = swap;
    for (int j = 0; j < n; ++j) {
      swap = c->q[i * n + j];
      c->q[i * n + j] = c->q[k * n + j];
      c->q[k * n + j] = swap;
      swap = c->t[i * n + j];
      c->t[i * n + j] = c->t[k * n + j];
      c->t[k * n + j] = swap;
    }
  }
}

/* Orients the tangent at the start: its largest entry is positive. */
static void orient_tangent(double *t, int n) {
  double largest = 0.0;
  for (int k = 0; k < n; ++k)
    if (fabs(t[k]) > 1.000001 * fabs(largest))
      largest = t[k];
  for (int k = 0; k < n && largest < 0.0; ++k)
    t[k] = -t[k];
}

/* Continuation forward from the start and, unless the curve closes, backward. */
bool km_selfmotion_curve_follow(km_selfmotion_curve *c, const double *q, double longest) {
  const int n = c->arm->n;
  double start[KM_ARM_MAX_JOINTS], t[KM_ARM_MAX_JOINTS];
  memcpy(start, q, (size_t)n * sizeof *q);
  km_arm_update(c->arm, c->space, start);
  tangent(c->arm, c->space, c->sense, t);
  if (!c->sense)
    orient_tangent(t, n);
  c->count = 0;
  c->closed = c->failed = false;
  if (!add(c, 0.0, start, t))
    return false;
  trace(c, start, t, longest, 1.0);
  if (c->closed || c->failed || c->arm->freedom > 1) {
    c->length = c->closed ? c->length : c->u[c->count - 1];
    return !c->failed;
  }
  km_selfmotion_curve back = *c;
  back.count = back.capacity = 0;
  back.u = back.q = back.t = NULL;
  trace(&back, start, t, longest, -1.0);
  reverse(&back);
  for (int i = 0; i < c->count && !back.failed; ++i)
    add(&back, c->u[i], c->q + i * n, c->t + i * n);
  km_selfmotion_curve_free(c);
  *c = back;
  c->length = c->failed ? 0.0 : c->u[c->count - 1] - c->u[0];
  return !c->failed;
}

void km_selfmotion_curve_free(km_selfmotion_curve *c) {
  km_free(c->u);
  km_free(c->q);
  km_free(c->t);
  c->u = c->q = c->t = NULL;
  c->count = c->capacity = 0;
}

/* Vector `move` from point i to the next one, cyclic on a closed curve, and the tangent there; returns the arc
 * length between them. */
static double next_point(const km_selfmotion_curve *c, int i, double *move, const double **t1) {
  const int n = c->arm->n;
  bool last = i == c->count - 1;
  const double *a = c->q + i * n, *b = last ? c->q : a + n;
  for (int k = 0; k < n; ++k)
    move[k] = last ? km_arm_difference(c->arm, k, a[k], b[k]) : b[k] - a[k];
  *t1 = last ? c->t : c->t + (i + 1) * n;
  return last ? c->length - c->u[i] : c->u[i + 1] - c->u[i];
}

/* Cubic Hermite interpolation between two points, projected onto the target pose. */
bool km_selfmotion_curve_interpolate(const km_selfmotion_curve *c, int i, double x, double *q, double *t) {
  const int n = c->arm->n;
  double move[KM_ARM_MAX_JOINTS];
  const double *a = c->q + i * n, *t0 = c->t + i * n, *t1;
  double h = next_point(c, i, move, &t1);
  double h01 = x * x * (3.0 - 2.0 * x), h10 = x * (1.0 - x) * (1.0 - x), h11 = x * x * (x - 1.0);
  for (int k = 0; k < n; ++k)
    q[k] = a[k] + h01 * move[k] + h * (h10 * t0[k] + h11 * t1[k]);
  if (!project(c->arm, c->space, &c->target, 0.5 * max_step, q))
    return false;
  if (t)
    tangent(c->arm, c->space, t0, t);
  return true;
}

/* Full turns of a hinge over one round, from its accumulated angle. */
double km_selfmotion_curve_turn(const km_selfmotion_curve *c, int column) {
  const int n = c->arm->n;
  if (!c->closed || !km_arm_is_hinge(c->arm, column))
    return 0.0;
  double first = c->q[column], last = c->q[(c->count - 1) * n + column];
  double round_trip = last - first + km_arm_difference(c->arm, column, last, first);
  return 2.0 * M_PI * round(round_trip / (2.0 * M_PI));
}

/* Configuration at an arc length, also in other rounds of a closed curve. */
bool km_selfmotion_curve_at(const km_selfmotion_curve *c, double u, double *q) {
  double rounds = c->closed ? floor(u / c->length) : 0.0;
  int i = 0;
  u -= rounds * c->length;
  while (i + 1 < c->count && c->u[i + 1] <= u)
    ++i;
  double span = i == c->count - 1 ? c->length - c->u[i] : c->u[i + 1] - c->u[i];
  if (!km_selfmotion_curve_interpolate(c, i, span > 0.0 ? fmin(fmax((u - c->u[i]) / span, 0.0), 1.0) : 0.0, q, NULL))
    return false;
  for (int k = 0; k < c->arm->n && rounds != 0.0; ++k)
    q[k] += rounds * km_selfmotion_curve_turn(c, k);
  return true;
}

/* Searches the foot of the perpendicular of q near each point within two steps. */
bool km_selfmotion_curve_contains(const km_selfmotion_curve *c, const double *q) {
  const int n = c->arm->n;
  double difference[KM_ARM_MAX_JOINTS], at[KM_ARM_MAX_JOINTS];
  for (int i = 0; i < c->count; ++i) {
    double distance = 0.0;
    for (int k = 0; k < n && distance < 0.01; ++k) {
      difference[k] = km_arm_difference(c->arm, k, c->q[i * n + k], q[k]);
      distance += difference[k] * difference[k];
    }
    if (distance >= 0.01) /* farther than two steps */
      continue;
    double along = km_dot(difference, c->t + i * n, n), off = 0.0;
    for (int pass = 0; pass < 3; ++pass) { /* foot of the perpendicular: step along the tangent, project, repeat */
      for (int k = 0; k < n; ++k)
        at[k] = c->q[i * n + k] + along * c->t[i * n + k];
      if (!project(c->arm, c->space, &c->target, max_step, at))
        break;
      double more = 0.0;
      off = 0.0;
      for (int k = 0; k < n; ++k) {
        double left = km_arm_difference(c->arm, k, at[k], q[k]);
        more += left * c->t[i * n + k];
        off += left * left;
      }
      along += more;
    }
    if (sqrt(off) < 1e-5)
      return true;
  }
  return false;
}
