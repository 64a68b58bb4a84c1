/* Search for all configurations that reach a target pose: in closed form if there is one, else by Newton's method
 * from random starts. Each solution that lies on no known self-motion curve is followed along its own curve
 * (docs/theory.md 12.9). */
#include "arm/ik/ik_search.h"
#include "arm/ik/six_revolute_ik.h"
#include "base/random.h"

#include <string.h>

/* Calls the progress callback; false: cancelled or failed. */
static bool report_progress(km_ik_search *search, double done) {
  search->cancelled = search->cancelled || (search->progress && !search->progress(search->context, done));
  search->failed = search->failed || search->cancelled;
  return !search->failed;
}

/* Random start value: hinges within half a turn of the middle of their limits, slides within their limits, else
 * within L of 0. */
static double random_coordinate(const km_arm *a, int k, uint64_t *r) {
  bool limited = a->high[k] - a->low[k] < (double)INFINITY;
  double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
  double half = km_arm_is_hinge(a, k) ? M_PI : limited ? 0.5 * (a->high[k] - a->low[k]) : 1.0;
  return km_splitmix(r, middle - half, middle + half);
}

/* One random start: Newton's method to the target, hinges unwound, diverged slides rejected. */
static bool try_start(const km_arm *a, km_arm_space *s, const km_pose *target, uint64_t *r, double *q) {
  for (int k = 0; k < a->n; ++k)
    q[k] = random_coordinate(a, k, r);
  if (!km_arm_reach(a, s, target, NULL, 80, 0.7, q))
    return false;
  km_arm_unwind(a, q);
  return !km_arm_slide_diverged(a, q) && km_arm_reach(a, s, target, NULL, 3, 0.7, q);
}

bool km_arm_search(const km_arm *a, km_arm_space *s, const km_pose *target, int starts, unsigned long seed, double *q) {
  uint64_t r = seed;
  for (int i = 0; i < starts; ++i)
    if (try_start(a, s, target, &r, q))
      return true;
  return false;
}

enum { MAX_ARC_LENGTH = 200 }; /* longest arc length of a curve that doesn't close, radians */

static double distance(const km_arm *a, const double *x, const double *y) {
  double sum = 0.0;
  for (int k = 0; k < a->n; ++k) {
    double difference = km_arm_difference(a, k, x[k], y[k]);
    sum += difference * difference;
  }
  return sqrt(sum);
}

static double smallest_singular_value(km_ik_search *search, const double *q) {
  double sigma[KM_ARM_ROWS];
  km_arm_update(search->arm, &search->space, q);
  km_arm_singular_values(search->arm, &search->space, sigma);
  return sigma[search->arm->rows - 1];
}

/* True if two solutions are equal: closer than 1e-6, or closer than 1e-4 with distance · σ_min below 1e-11. Newton's
 * residual of 1e-12 corresponds to a joint error of 1e-12/σ_min. */
static bool is_same(km_ik_search *search, const double *x, const double *y) {
  static const double left = 1e-11, near = 1e-6, furthest = 1e-4;
  double apart = distance(search->arm, x, y);
  if (!(apart >= near && apart < furthest))
    return apart < near;
  return apart * fmin(smallest_singular_value(search, x), smallest_singular_value(search, y)) < left;
}

static bool is_known(km_ik_search *search, const double *q) {
  for (int i = 0; i < search->count; ++i) {
    const km_selfmotion_curve *c = &search->curves[i];
    if ((search->arm->freedom == 1 && km_selfmotion_curve_contains(c, q)) || is_same(search, c->q, q))
      return true;
  }
  return false;
}

/* True if the self-motions connect one configuration with the other: descends the distance in the null space,
 * closing the pose after each step. */
static bool is_connected(km_ik_search *search, const double *from, const double *to) {
  static const double none[KM_ARM_ROWS] = {0};
  const km_arm *a = search->arm;
  double q[KM_ARM_MAX_JOINTS], difference[KM_ARM_MAX_JOINTS], last = (double)INFINITY;
  memcpy(q, from, (size_t)a->n * sizeof *q);
  for (int step = 0; step < 150; ++step) {
    double left = 0.0, along[KM_ARM_MAX_JOINTS], size = 0.0;
    for (int k = 0; k < a->n; ++k) {
      difference[k] = km_arm_difference(a, k, q[k], to[k]);
      left += difference[k] * difference[k];
      along[k] = difference[k];
    }
    left = sqrt(left);
    if (left < 1e-6)
      return true;
    if (left > last * (1.0 - 1e-6))
      return false;
    last = left;
    km_arm_update(a, &search->space, q);
    km_control_factor(a, &search->space, none, NULL);
    km_control_project_out(a, &search->space, along);
    for (int k = 0; k < a->n; ++k) {
      along[k] = difference[k] - along[k];
      size += along[k] * along[k];
    }
    double scale = fmin(1.0, 0.1 / sqrt(size + 1e-30));
    for (int k = 0; k < a->n; ++k)
      q[k] += scale * along[k];
    if (!km_arm_reach(a, &search->space, &search->target, NULL, 20, 0.2, q))
      return false;
  }
  return false;
}

/* True if the null space is larger than the spare freedoms: a singular configuration, possibly one of a surface. */
static bool is_singular(km_ik_search *search, const double *q) {
  static const double none[KM_ARM_ROWS] = {0};
  km_arm_update(search->arm, &search->space, q);
  km_control_factor(search->arm, &search->space, none, NULL);
  return search->space.null_count > search->arm->freedom;
}

/* True if q is connected with a known solution, which is then replaced by the one with the larger limit distance. */
static bool is_connected_to_known(km_ik_search *search, const double *q) {
  for (int i = 0; i < search->count; ++i) {
    double *other = search->curves[i].q;
    if (!is_connected(search, q, other) && !is_connected(search, other, q))
      continue;
    if (search->curves[i].count == 1 &&
        km_arm_limit_distance(search->arm, q) > km_arm_limit_distance(search->arm, other))
      memcpy(other, q, (size_t)search->arm->n * sizeof *q);
    return true;
  }
  return false;
}

static bool add_curve(km_ik_search *search, const double *q, double longest) {
  if (!km_reserve((void **)&search->curves, &search->capacity, (size_t)search->count + 1, sizeof *search->curves))
    return false;
  km_selfmotion_curve *c = &search->curves[search->count];
  *c = (km_selfmotion_curve){.arm = search->arm, .space = &search->space, .target = search->target};
  search->count++;
  return km_selfmotion_curve_follow(c, q, longest);
}

enum { MAX_BRANCHES = 128 };

/* Adds a solution: if it isn't known, its curve is followed. */
static void add_if_new(km_ik_search *search, double *q) {
  bool singular = is_singular(search, q), spreads = search->arm->freedom > 1 || singular;
  search->known_in_row++;
  if (search->count == MAX_BRANCHES || is_known(search, q) || (spreads && is_connected_to_known(search, q)))
    return;
  search->known_in_row = 0;
  search->has_families = search->has_families || singular;
  search->failed = !add_curve(search, q, spreads ? 0.0 : MAX_ARC_LENGTH);
}

/* Sign of the determinant of the arm's 6 × 6 Jacobian at q, by Gaussian elimination. */
static int determinant_sign(km_ik_search *search, const double *q) {
  double A[KM_ARM_ROWS][KM_ARM_ROWS];
  int sense = 1;
  km_arm_update(search->arm, &search->space, q);
  memcpy(A, search->space.jacobian, sizeof A);
  for (int c = 0; c < KM_ARM_ROWS; ++c) {
    int best = c;
    for (int r = c + 1; r < KM_ARM_ROWS; ++r)
      best = fabs(A[r][c]) > fabs(A[best][c]) ? r : best;
    if (A[best][c] == 0.0)
      return 0;
    if (best != c)
      sense = -sense;
    if (A[best][c] < 0.0)
      sense = -sense;
    for (int k = c; k < KM_ARM_ROWS; ++k) {
      double swap = A[c][k];
      A[c][k] = A[best][k];
      A[best][k] = swap;
    }
    for (int r = c + 1; r < KM_ARM_ROWS; ++r)
      for (int k = KM_ARM_ROWS - 1; k >= c; --k)
        A[r][k] -= A[r][c] / A[c][c] * A[c][k];
  }
  return sense;
}

static bool all_hinges(const km_arm *a) {
  for (int k = 0; k < a->n; ++k)
    if (a->motions[k].primitive != KM_REVOLUTE)
      return false;
  return true;
}

bool km_ik_search_is_singular(km_ik_search *search, int branch) {
  static const double small = 1e-5; /* Newton's method ends about 1e-6 from a double solution */
  return search->curves[branch].count == 1 && smallest_singular_value(search, search->curves[branch].q) < small;
}

/* True if the count of solutions is balanced. The configurations of six hinges form a torus, whose map to poses has
 * degree 0: as many solutions have a positive determinant as a negative one. An unbalanced count is incomplete. */
static bool is_balanced(km_ik_search *search) {
  const km_arm *a = search->arm;
  int sum = 0;
  if (a->freedom != 0 || a->rows != KM_ARM_ROWS || !all_hinges(a) || search->has_families)
    return true;
  for (int i = 0; i < search->count; ++i)
    sum += km_ik_search_is_singular(search, i)
               ? 0
               : determinant_sign(search, search->curves[i].q); /* double solutions cancel */
  return sum == 0;
}

/* Adds all closed-form solutions with the joint `fixed` (−1: none) at its value in `from`. False: no closed form, or
 * it leaves a family of solutions. */
static bool add_closed_form(km_ik_search *search, const double *from, int fixed) {
  km_six_hinges six;
  double angles[KM_SIX_MAX_SOLUTIONS][KM_SIX], q[KM_ARM_MAX_JOINTS];
  if (!km_six_hinges_find(search->arm, &search->space, from, fixed, &six))
    return false;
  int count = km_six_hinges_solve(&six, &search->target, angles);
  for (int i = 0; i < count && !search->failed; ++i) {
    memcpy(q, from, (size_t)search->arm->n * sizeof *q);
    for (int k = 0; k < KM_SIX; ++k)
      q[six.column[k]] += angles[i][k];
    if (!km_arm_reach(search->arm, &search->space, &search->target, NULL, 80, 0.7, q))
      continue;
    km_arm_unwind(search->arm, q);
    if (km_arm_reach(search->arm, &search->space, &search->target, NULL, 3, 0.7, q))
      add_if_new(search, q);
  }
  return count >= 0;
}

/* Closed form of six hinges; of seven, each hinge in turn is fixed at 48 angles. That finds all curves along which a
 * hinge outside the group moves, not those along which only the group moves. */
static bool solve_closed(km_ik_search *search) {
  enum { ANGLES = 48 };
  double q[KM_ARM_MAX_JOINTS] = {0};
  bool found = false;
  if (search->arm->freedom == 0)
    return add_closed_form(search, q, -1);
  for (int fixed = 0; fixed < search->arm->n && search->arm->n == KM_SIX + 1 && all_hinges(search->arm); ++fixed) {
    for (int i = 0; i < ANGLES && report_progress(search, (double)(fixed * ANGLES + i) / (search->arm->n * ANGLES));
         ++i) {
      q[fixed] = 2.0 * M_PI * i / ANGLES;
      if (!add_closed_form(search, q, fixed))
        break;
      found = true;
    }
    q[fixed] = 0.0;
  }
  return found;
}

/* Newton's method from random starts, until many solutions in a row are known and the count is balanced. */
static void search_random(km_ik_search *search, unsigned long seed) {
  enum { MAX_STARTS = 4000, MAX_UNBALANCED = 20000, MAX_FAILED_STARTS = 600 };
  static const int required_known[] = {500, 250, 60};
  const int spare = search->arm->freedom < 2 ? search->arm->freedom : 2,
            most = spare == 0 ? MAX_UNBALANCED : MAX_STARTS;
  uint64_t r = seed;
  double q[KM_ARM_MAX_JOINTS];
  search->known_in_row = 0;
  for (search->starts = 0;
       search->starts < most && search->count < MAX_BRANCHES && report_progress(search, (double)search->starts / most);
       ++search->starts) {
    if (search->starts == MAX_FAILED_STARTS && search->count == 0)
      return;
    if (search->known_in_row >= required_known[spare]) {
      search->confirmed = is_balanced(search);
      search->known_in_row = 0; /* if it isn't balanced, the search continues for as many solutions */
    }
    if (search->confirmed)
      return;
    if (!try_start(search->arm, &search->space, &search->target, &r, q))
      continue;
    search->converged++;
    add_if_new(search, q);
  }
}

/* Closed form if there is one, then random starts unless the count is confirmed. */
km_status km_ik_search_run(const km_arm *a, const km_pose *target, unsigned long seed, km_progress progress,
                           void *context, km_ik_search *search, km_error *error) {
  *search = (km_ik_search){.arm = a, .target = *target, .progress = progress, .context = context};
  if (!km_arm_space_create(a, &search->space))
    return km_fail(error, KM_MEMORY, "out of memory for the branches");
  search->closed_form = solve_closed(search);
  search->confirmed =
      search->closed_form && a->freedom == 0 && search->count > 0 && !search->has_families && is_balanced(search);
  if (!search->confirmed && !search->failed)
    search_random(search, seed);
  if (search->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for branches was cancelled");
  if (search->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the branches");
  if (search->count == 0)
    return km_fail(error, KM_NO_RESULT, "the pose is out of reach: none of %d starts comes to it", search->starts);
  return KM_OK;
}

void km_ik_search_free(km_ik_search *search) {
  for (int i = 0; i < search->count; ++i)
    km_selfmotion_curve_free(&search->curves[i]);
  km_free(search->curves);
  km_arm_space_free(&search->space);
}
