/* Inverse kinematics: records of all branches, and the solution closest to a given configuration (docs/theory.md
 * 12.9). */
#include "arm/ik/ik_search.h"

#include "arm/arm_arguments.h"

#include <stdlib.h>
#include <string.h>

/* Index of the curve's point with the largest limit distance. */
static int best_point(const km_arm *a, const km_selfmotion_curve *c, double *margin) {
  int best = 0;
  *margin = -(double)INFINITY;
  for (int i = 0; i < c->count; ++i) {
    double q[KM_ARM_MAX_JOINTS];
    memcpy(q, c->q + i * a->n, (size_t)a->n * sizeof *q);
    km_arm_unwind(a, q);
    double distance = km_arm_limit_distance(a, q);
    if (distance > *margin) {
      *margin = distance;
      best = i;
    }
  }
  return best;
}

/* Configuration in the middle of an arc, hinges unwound. */
static bool arc_middle(const km_arm *a, const km_selfmotion_curve *c, const km_arc_span *arc, double *q) {
  if (!km_selfmotion_curve_at(c, 0.5 * (arc->from + arc->to), q))
    return false;
  km_arm_unwind(a, q);
  return true;
}

/* Best limit distance among the middles of arcs; a narrow arc can contain no point of the curve. */
static double best_middle(const km_arm *a, const km_selfmotion_curve *c, const km_selfmotion *m, double *q) {
  double best = -(double)INFINITY, at[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < m->arc_count; ++k) {
    if (!arc_middle(a, c, &m->arcs[k], at))
      continue;
    double distance = km_arm_limit_distance(a, at);
    if (distance > best) {
      best = distance;
      memcpy(q, at, (size_t)a->n * sizeof *q);
    }
  }
  return best;
}

/* Shifts the curve by full turns so that point i is unwound; its arcs are then those through that point. */
static void unwind_at(const km_arm *a, km_selfmotion_curve *c, int i) {
  double turn[KM_ARM_MAX_JOINTS];
  memcpy(turn, c->q + i * a->n, (size_t)a->n * sizeof *turn);
  km_arm_unwind(a, turn);
  for (int k = 0; k < a->n; ++k)
    turn[k] -= c->q[i * a->n + k];
  for (int j = 0; j < c->count; ++j)
    for (int k = 0; k < a->n; ++k)
      c->q[j * a->n + k] += turn[k];
}

/* Record of one branch, with its configuration of largest limit distance. */
static km_status write_branch(km_ik_search *search, km_selfmotion_curve *c, km_selfmotion *out, double *pose,
                              double *margin, km_error *error) {
  const km_arm *a = search->arm;
  double q[KM_ARM_MAX_JOINTS];
  int best = best_point(a, c, margin);
  unwind_at(a, c, best);
  memcpy(q, c->q + best * a->n, (size_t)a->n * sizeof *q);
  if (a->freedom == 1) {
    km_status status = km_selfmotion_export(c, out, error);
    if (status)
      return status;
    double middle[KM_ARM_MAX_JOINTS], there = best_middle(a, c, out, middle);
    if (there > *margin) {
      *margin = there;
      memcpy(q, middle, (size_t)a->n * sizeof *q);
    }
  }
  km_arm_unwind(a, q);
  for (int k = 0; k < a->n; ++k)
    pose[k] = km_arm_to_units(a, k, q[k]);
  return KM_OK;
}

typedef struct branch_order {
  int index;
  double margin, length;
  const double *pose;
  int columns;
} branch_order;

/* Sorts branches within the limits first, then by their configurations. */
static int compare_branches(const void *a, const void *b) {
  const branch_order *x = a, *y = b;
  if ((x->margin >= 0.0) != (y->margin >= 0.0))
    return x->margin >= 0.0 ? -1 : 1;
  for (int k = 0; k < x->columns; ++k)
    if (fabs(x->pose[k] - y->pose[k]) > 1e-6)
      return x->pose[k] < y->pose[k] ? -1 : 1;
  return x->index - y->index;
}

/* Records of all branches, sorted: branches within the limits first. */
static km_status write_solutions(km_ik_search *search, km_ik_solutions *out, km_error *error) {
  size_t count = (size_t)search->count, n = (size_t)search->arm->n;
  km_selfmotion *items = KM_NEW(km_selfmotion, count + 1);
  double *pose = KM_NEW(double, count *n + 1), *margin = KM_NEW(double, count + 1);
  branch_order *order = KM_NEW(branch_order, count + 1);
  bool *singular = KM_NEW(bool, count + 1);
  out->items = KM_NEW(km_selfmotion, count + 1);
  out->pose = KM_NEW(double, count *n + 1);
  out->margin = KM_NEW(double, count + 1);
  out->singular = KM_NEW(bool, count + 1);
  km_status status =
      items && pose && margin && order && singular && out->singular && out->items && out->pose && out->margin
          ? KM_OK
          : km_fail(error, KM_MEMORY, "out of memory for the branches");
  for (int i = 0; i < search->count && !status; ++i) {
    status = write_branch(search, &search->curves[i], &items[i], pose + (size_t)i * n, &margin[i], error);
    singular[i] = km_ik_search_is_singular(search, i);
    order[i] = (branch_order){i, margin[i], items[i].length, pose + (size_t)i * n, search->arm->n};
  }
  if (!status && count > 1)
    qsort(order, count, sizeof *order, compare_branches);
  for (int i = 0; i < search->count && !status; ++i) {
    int from = order[i].index;
    out->items[i] = items[from];
    items[from] = (km_selfmotion){0};
    memcpy(out->pose + (size_t)i * n, pose + (size_t)from * n, n * sizeof *pose);
    out->margin[i] = margin[from];
    out->singular[i] = singular[from];
    out->within += margin[from] >= 0.0;
    out->count++;
  }
  for (int i = 0; i < search->count && items; ++i)
    km_selfmotion_free(&items[i]);
  km_free(items);
  km_free(pose);
  km_free(margin);
  km_free(order);
  km_free(singular);
  return status;
}

km_status km_ik_solutions_find(const km_arm *a, const km_frame_pose *given, unsigned long seed, km_progress progress,
                               void *context, km_ik_solutions *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_ik_solutions){0};
  km_status fits = km_check_given(a && given, "arm or pose", error);
  if (!fits)
    fits = km_check_pose(given, error);
  if (fits)
    return fits;
  km_ik_search search;
  *out = (km_ik_solutions){0};
  km_pose target = km_arm_pose_of(a, given);
  km_status status = km_ik_search_run(a, &target, seed, progress, context, &search, error);
  out->starts = search.starts;
  out->converged = search.converged;
  out->closed_form = search.closed_form;
  out->confirmed = search.confirmed;
  if (!status)
    status = write_solutions(&search, out, error);
  km_ik_search_free(&search);
  return status;
}

void km_ik_solutions_free(km_ik_solutions *b) {
  if (!b)
    return;
  for (int i = 0; i < b->count; ++i)
    km_selfmotion_free(&b->items[i]);
  km_free(b->items);
  km_free(b->pose);
  km_free(b->margin);
  km_free(b->singular);
  *b = (km_ik_solutions){0};
}

static double distance_between(const km_arm *a, const double *x, const double *y) {
  double sum = 0.0;
  for (int k = 0; k < a->n; ++k)
    sum += (x[k] - y[k]) * (x[k] - y[k]);
  return sqrt(sum);
}

/* Takes a configuration, shifted to the closest full turns, as the best one if it is within the limits, closer to
 * `near` than the best so far, and reaches the target. */
static void update_nearest(km_ik_search *search, double *at, const double *near, double *best, double *q) {
  const km_arm *a = search->arm;
  km_arm_shift_to_nearest(a, near, at);
  double distance = distance_between(a, at, near);
  if (km_arm_limit_passed(a, at) >= 0 || distance >= *best ||
      !km_arm_reach(a, &search->space, &search->target, NULL, 5, 0.1, at))
    return;
  *best = distance;
  memcpy(q, at, (size_t)a->n * sizeof *q);
}

/* Finds the configuration closest to `near` among all points of branches within the limits and all middles of arcs. */
static bool find_nearest(km_ik_search *search, const double *near, double *q) {
  double best = (double)INFINITY, at[KM_ARM_MAX_JOINTS];
  for (int b = 0; b < search->count; ++b) {
    const km_selfmotion_curve *c = &search->curves[b];
    for (int i = 0; i < c->count; ++i) {
      memcpy(at, c->q + i * search->arm->n, (size_t)search->arm->n * sizeof *at);
      km_arm_unwind(search->arm, at);
      update_nearest(search, at, near, &best, q);
    }
    int arc_count = 0;
    km_arc_span *arcs = search->arm->freedom == 1 ? km_selfmotion_curve_arcs(c, &arc_count) : NULL;
    for (int k = 0; arcs && k < arc_count; ++k)
      if (arc_middle(search->arm, c, &arcs[k], at))
        update_nearest(search, at, near, &best, q);
    km_free(arcs);
  }
  return best < (double)INFINITY;
}

/* Closest configuration: Newton's method from `near`, else the best point of all branches. */
km_status km_arm_nearest(const km_arm *a, const km_pose *target, const double *near, unsigned long seed,
                         km_progress progress, void *context, double *q, km_error *error) {
  km_ik_search search;
  km_arm_space space;
  if (!km_arm_space_create(a, &space))
    return km_fail(error, KM_MEMORY, "out of memory for inverse kinematics");
  memcpy(q, near, (size_t)a->n * sizeof *q);
  bool there = km_arm_reach(a, &space, target, NULL, 100, 0.2, q) && km_arm_limit_passed(a, q) < 0 &&
               distance_between(a, q, near) < 3.0;
  km_arm_space_free(&space);
  if (there)
    return KM_OK;
  km_status status = km_ik_search_run(a, target, seed, progress, context, &search, error);
  if (!status && !find_nearest(&search, near, q))
    status = km_fail(error, KM_NO_RESULT,
                     "the pose is reached on %d branch%s, but never with all joints within their limits", search.count,
                     search.count == 1 ? "" : "es");
  km_ik_search_free(&search);
  return status;
}
