/* Inverse kinematics: every branch, by Newton's method from many starts and following each solution's curve. */
#include "redundancy/branches.h"
#include "redundancy/random.h"

#include <stdlib.h>
#include <string.h>

/* Hinges within a half turn of the middle of their limits, slides within the limits or one L of 0. */
static double scatter(const km_arm *a, int k, km_random *r) {
  bool limited = a->high[k] - a->low[k] < (double)INFINITY;
  double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
  double half = km_arm_turns(a, k) ? M_PI : limited ? 0.5 * (a->high[k] - a->low[k]) : 1.0;
  return km_random_between(r, middle - half, middle + half);
}

void km_arm_unwind(const km_arm *a, double *q) {
  for (int k = 0; k < a->n; ++k) {
    bool limited = a->high[k] - a->low[k] < (double)INFINITY;
    double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
    if (km_arm_turns(a, k))
      q[k] = middle + km_arm_difference(a, k, middle, q[k]);
  }
}

bool km_arm_turns_once(const km_arm *a, int column) {
  return km_arm_turns(a, column) && a->high[column] - a->low[column] < 2.0 * M_PI - 1e-9;
}

void km_arm_bring_within(const km_arm *a, double *q) {
  double all[KM_ARM_MOST];
  memcpy(all, q, (size_t)a->n * sizeof *q);
  km_arm_unwind(a, all);
  for (int k = 0; k < a->n; ++k)
    if (km_arm_turns_once(a, k))
      q[k] = all[k];
}

static bool try_start(const km_arm *a, km_arm_space *s, const km_pose *target, km_random *r, double *q) {
  for (int k = 0; k < a->n; ++k)
    q[k] = scatter(a, k, r);
  if (!km_arm_reach(a, s, target, NULL, 80, 0.7, q))
    return false;
  km_arm_unwind(a, q);
  return !km_arm_slides_away(a, q) && km_arm_reach(a, s, target, NULL, 3, 0.7, q);
}

bool km_arm_search(const km_arm *a, km_arm_space *s, const km_pose *target, int starts, unsigned long seed, double *q) {
  km_random r = {seed};
  for (int i = 0; i < starts; ++i)
    if (try_start(a, s, target, &r, q))
      return true;
  return false;
}

enum { LONGEST = 200 }; /* radians: of a curve that doesn't close */

/* A search in progress. */
typedef struct finder {
  const km_arm *arm;
  km_arm_space space;
  km_pose target;
  km_loop_curve *curves;
  size_t capacity;
  int count, starts, converged;
} finder;

static bool is_known(const finder *f, const double *q) {
  for (int i = 0; i < f->count; ++i) {
    const km_loop_curve *c = &f->curves[i];
    if (f->arm->freedom == 1 ? km_loop_curve_passes(c, q) : false)
      return true;
    double distance = 0.0;
    for (int k = 0; k < f->arm->n; ++k) {
      double way = km_arm_difference(f->arm, k, c->q[k], q[k]);
      distance += way * way;
    }
    if (sqrt(distance) < 1e-6)
      return true;
  }
  return false;
}

/* With two spare freedoms and more: can one pose be led to the other within the self-motions? */
static bool leads(finder *f, const double *from, const double *to) {
  static const double none[KM_ARM_ROWS] = {0};
  const km_arm *a = f->arm;
  double q[KM_ARM_MOST], way[KM_ARM_MOST], last = (double)INFINITY;
  memcpy(q, from, (size_t)a->n * sizeof *q);
  for (int step = 0; step < 150; ++step) {
    double left = 0.0, along[KM_ARM_MOST], size = 0.0;
    for (int k = 0; k < a->n; ++k) {
      way[k] = km_arm_difference(a, k, q[k], to[k]);
      left += way[k] * way[k];
      along[k] = way[k];
    }
    left = sqrt(left);
    if (left < 1e-6)
      return true;
    if (left > last * (1.0 - 1e-6))
      return false;
    last = left;
    km_arm_update(a, &f->space, q);
    km_control_factor(a, &f->space, none, NULL);
    km_control_project_out(a, &f->space, along);
    for (int k = 0; k < a->n; ++k) {
      along[k] = way[k] - along[k];
      size += along[k] * along[k];
    }
    double scale = fmin(1.0, 0.1 / sqrt(size + 1e-30));
    for (int k = 0; k < a->n; ++k)
      q[k] += scale * along[k];
    if (!km_arm_reach(a, &f->space, &f->target, NULL, 20, 0.2, q))
      return false;
  }
  return false;
}

/* More directions than the arm has to spare: singular poses, which may fill surfaces. */
static bool is_singular(finder *f, double *q) {
  static const double none[KM_ARM_ROWS] = {0};
  km_arm_update(f->arm, &f->space, q);
  km_control_factor(f->arm, &f->space, none, NULL);
  return f->space.null_count > f->arm->freedom;
}

/* Of poses that can be led to each other the one furthest from the limits stands for all. */
static bool is_led_to(finder *f, const double *q) {
  for (int i = 0; i < f->count; ++i) {
    double *other = f->curves[i].q;
    if (!leads(f, q, other) && !leads(f, other, q))
      continue;
    if (f->curves[i].count == 1 && km_arm_limit_distance(f->arm, q) > km_arm_limit_distance(f->arm, other))
      memcpy(other, q, (size_t)f->arm->n * sizeof *q);
    return true;
  }
  return false;
}

static bool add(finder *f, const double *q, double longest) {
  if (!km_reserve((void **)&f->curves, &f->capacity, (size_t)f->count + 1, sizeof *f->curves))
    return false;
  km_loop_curve *c = &f->curves[f->count];
  *c = (km_loop_curve){.arm = f->arm, .space = &f->space, .target = f->target};
  f->count++;
  return km_loop_curve_follow(c, q, longest);
}

/* Until so many solutions in a row are on known branches. */
static bool search(finder *f, unsigned long seed) {
  enum { MOST_STARTS = 4000, HOPELESS = 600, MOST_BRANCHES = 128 };
  int idle = 0, patience = f->arm->freedom == 1 ? 250 : 60;
  km_random r = {seed};
  double q[KM_ARM_MOST];
  for (f->starts = 0; f->starts < MOST_STARTS && idle < patience && f->count < MOST_BRANCHES; ++f->starts) {
    if (f->starts == HOPELESS && f->converged == 0)
      return true;
    if (!try_start(f->arm, &f->space, &f->target, &r, q))
      continue;
    f->converged++;
    ++idle;
    bool spreads = f->arm->freedom > 1 || is_singular(f, q);
    if (is_known(f, q) || (spreads && is_led_to(f, q)))
      continue;
    idle = 0;
    if (!add(f, q, spreads ? 0.0 : LONGEST))
      return false;
  }
  return true;
}

/* The point of a branch's arcs (or of all of it) that is furthest from the limits; its index. */
static int best_point(const km_arm *a, const km_loop_curve *c, double *margin) {
  int best = 0;
  *margin = -(double)INFINITY;
  for (int i = 0; i < c->count; ++i) {
    double q[KM_ARM_MOST];
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

/* The pose in the middle of an arc, hinges unwound. */
static bool middle_of(const km_arm *a, const km_loop_curve *c, const km_arc_span *arc, double *q) {
  if (!km_loop_curve_at(c, 0.5 * (arc->from + arc->to), q))
    return false;
  km_arm_unwind(a, q);
  return true;
}

/* A narrow arc may hold none of the curve's points: then its middle stands for it. */
static double best_middle(const km_arm *a, const km_loop_curve *c, const km_selfmotion *m, double *q) {
  double best = -(double)INFINITY, at[KM_ARM_MOST];
  for (int k = 0; k < m->arc_count; ++k) {
    if (!middle_of(a, c, &m->arcs[k], at))
      continue;
    double distance = km_arm_limit_distance(a, at);
    if (distance > best) {
      best = distance;
      memcpy(q, at, (size_t)a->n * sizeof *q);
    }
  }
  return best;
}

/* The same curve by full turns, so that point i is unwound: its arcs are then those that pass there. */
static void unwind_at(const km_arm *a, km_loop_curve *c, int i) {
  double turn[KM_ARM_MOST];
  memcpy(turn, c->q + i * a->n, (size_t)a->n * sizeof *turn);
  km_arm_unwind(a, turn);
  for (int k = 0; k < a->n; ++k)
    turn[k] -= c->q[i * a->n + k];
  for (int j = 0; j < c->count; ++j)
    for (int k = 0; k < a->n; ++k)
      c->q[j * a->n + k] += turn[k];
}

static km_status describe(finder *f, km_loop_curve *c, km_selfmotion *out, double *pose, double *margin,
                          km_error *error) {
  const km_arm *a = f->arm;
  double q[KM_ARM_MOST];
  int best = best_point(a, c, margin);
  unwind_at(a, c, best);
  memcpy(q, c->q + best * a->n, (size_t)a->n * sizeof *q);
  if (a->freedom == 1) {
    km_status status = km_selfmotion_export(c, out, error);
    if (status)
      return status;
    double middle[KM_ARM_MOST], there = best_middle(a, c, out, middle);
    if (there > *margin) {
      *margin = there;
      memcpy(q, middle, (size_t)a->n * sizeof *q);
    }
  }
  km_arm_unwind(a, q);
  for (int k = 0; k < a->n; ++k)
    pose[k] = km_arm_shown(a, k, q[k]);
  return KM_OK;
}

typedef struct place {
  int index;
  double margin, length;
  const double *pose;
  int columns;
} place;

/* Branches within the limits first, then by their first pose. */
static int by_place(const void *a, const void *b) {
  const place *x = a, *y = b;
  if ((x->margin >= 0.0) != (y->margin >= 0.0))
    return x->margin >= 0.0 ? -1 : 1;
  for (int k = 0; k < x->columns; ++k)
    if (fabs(x->pose[k] - y->pose[k]) > 1e-6)
      return x->pose[k] < y->pose[k] ? -1 : 1;
  return x->index - y->index;
}

static km_status deliver(finder *f, km_branches *out, km_error *error) {
  size_t count = (size_t)f->count, n = (size_t)f->arm->n;
  km_selfmotion *items = KM_NEW(km_selfmotion, count + 1);
  double *pose = KM_NEW(double, count *n + 1), *margin = KM_NEW(double, count + 1);
  place *order = KM_NEW(place, count + 1);
  out->items = KM_NEW(km_selfmotion, count + 1);
  out->pose = KM_NEW(double, count *n + 1);
  out->margin = KM_NEW(double, count + 1);
  km_status status = items && pose && margin && order && out->items && out->pose && out->margin
                         ? KM_OK
                         : km_fail(error, KM_MEMORY, "out of memory for the branches");
  for (int i = 0; i < f->count && !status; ++i) {
    status = describe(f, &f->curves[i], &items[i], pose + (size_t)i * n, &margin[i], error);
    order[i] = (place){i, margin[i], items[i].length, pose + (size_t)i * n, f->arm->n};
  }
  if (!status && count > 1)
    qsort(order, count, sizeof *order, by_place);
  for (int i = 0; i < f->count && !status; ++i) {
    int from = order[i].index;
    out->items[i] = items[from];
    items[from] = (km_selfmotion){0};
    memcpy(out->pose + (size_t)i * n, pose + (size_t)from * n, n * sizeof *pose);
    out->margin[i] = margin[from];
    out->within += margin[from] >= 0.0;
    out->count++;
  }
  for (int i = 0; i < f->count && items; ++i)
    km_selfmotion_free(&items[i]);
  km_free(items);
  km_free(pose);
  km_free(margin);
  km_free(order);
  return status;
}

static km_pose read_pose(const km_arm *a, const km_effector_pose *given) {
  const double *R = given->R;
  km_pose pose = {{{{R[0], R[3], R[6]}, {R[1], R[4], R[7]}, {R[2], R[5], R[8]}}}, km_vec3_make(given->p)};
  return km_arm_from_model(a, &pose);
}

static km_status find(const km_arm *a, const km_pose *target, unsigned long seed, finder *f, km_error *error) {
  *f = (finder){.arm = a, .target = *target};
  if (!km_arm_space_create(a, &f->space) || !search(f, seed))
    return km_fail(error, KM_MEMORY, "out of memory for the branches");
  if (f->count == 0)
    return km_fail(error, KM_PARTIAL, "the pose is out of reach: none of %d starts comes to it", f->starts);
  return KM_OK;
}

static void forget(finder *f) {
  for (int i = 0; i < f->count; ++i)
    km_loop_curve_free(&f->curves[i]);
  km_free(f->curves);
  km_arm_space_free(&f->space);
}

km_status km_branches_find(const km_arm *a, const km_effector_pose *given, unsigned long seed, km_branches *out,
                           km_error *error) {
  finder f;
  *out = (km_branches){0};
  km_pose target = read_pose(a, given);
  km_status status = find(a, &target, seed, &f, error);
  out->starts = f.starts;
  out->converged = f.converged;
  if (!status)
    status = deliver(&f, out, error);
  forget(&f);
  return status;
}

void km_branches_free(km_branches *b) {
  for (int i = 0; i < b->count; ++i)
    km_selfmotion_free(&b->items[i]);
  km_free(b->items);
  km_free(b->pose);
  km_free(b->margin);
  *b = (km_branches){0};
}

static double distance_between(const km_arm *a, const double *x, const double *y) {
  double sum = 0.0;
  for (int k = 0; k < a->n; ++k)
    sum += (x[k] - y[k]) * (x[k] - y[k]);
  return sqrt(sum);
}

/* Takes a pose over if it is within the limits and nearer than the best so far. */
static void take_nearer(const km_arm *a, const double *at, const double *near, double *best, double *q) {
  double distance = distance_between(a, at, near);
  if (km_arm_limit_passed(a, at) >= 0 || distance >= *best)
    return;
  *best = distance;
  memcpy(q, at, (size_t)a->n * sizeof *q);
}

/* Of all branches' points within the limits, and of the middles of their arcs, however narrow, the nearest. */
static bool nearest_of(finder *f, const double *near, double *q) {
  double best = (double)INFINITY, at[KM_ARM_MOST];
  for (int b = 0; b < f->count; ++b) {
    const km_loop_curve *c = &f->curves[b];
    for (int i = 0; i < c->count; ++i) {
      memcpy(at, c->q + i * f->arm->n, (size_t)f->arm->n * sizeof *at);
      km_arm_unwind(f->arm, at);
      take_nearer(f->arm, at, near, &best, q);
    }
    int arc_count = 0;
    km_arc_span *arcs = f->arm->freedom == 1 ? km_loop_curve_arcs(c, &arc_count) : NULL;
    for (int k = 0; arcs && k < arc_count; ++k)
      if (middle_of(f->arm, c, &arcs[k], at))
        take_nearer(f->arm, at, near, &best, q);
    km_free(arcs);
  }
  return best < (double)INFINITY;
}

km_status km_arm_nearest(const km_arm *a, const km_pose *target, const double *near, unsigned long seed, double *q,
                         km_error *error) {
  finder f;
  km_arm_space space;
  if (!km_arm_space_create(a, &space))
    return km_fail(error, KM_MEMORY, "out of memory for inverse kinematics");
  memcpy(q, near, (size_t)a->n * sizeof *q);
  bool there = km_arm_reach(a, &space, target, NULL, 100, 0.2, q) && km_arm_limit_passed(a, q) < 0 &&
               distance_between(a, q, near) < 3.0;
  km_arm_space_free(&space);
  if (there)
    return KM_OK;
  km_status status = find(a, target, seed, &f, error);
  if (!status && !nearest_of(&f, near, q))
    status =
        km_fail(error, KM_PARTIAL, "the pose is reached on %d branch%s, but never with all joints within their limits",
                f.count, f.count == 1 ? "" : "es");
  else if (!status && !km_arm_reach(a, &f.space, target, NULL, 5, 0.1, q))
    status = km_fail(error, KM_DIVERGED, "inverse kinematics gave out");
  forget(&f);
  return status;
}
