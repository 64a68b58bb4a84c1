/* The search for all poses that reach a target: in closed form where there is one, else by Newton's method from many
 * starts; each solution that lies on no known curve is followed along its own. */
#include "arm/ik/ik_search.h"
#include "arm/ik/six_revolute_ik.h"
#include "arm/methods/splitmix.h"

#include <string.h>

/* Asks whether to go on; false where not, or where it has failed already. */
static bool goes_on(km_finder *f, double done) {
  f->cancelled = f->cancelled || (f->progress && !f->progress(f->context, done));
  f->failed = f->failed || f->cancelled;
  return !f->failed;
}

/* Hinges within a half turn of the middle of their limits, slides within the limits or one L of 0. */
static double scatter(const km_arm *a, int k, km_random *r) {
  bool limited = a->high[k] - a->low[k] < (double)INFINITY;
  double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
  double half = km_arm_turns(a, k) ? M_PI : limited ? 0.5 * (a->high[k] - a->low[k]) : 1.0;
  return km_random_between(r, middle - half, middle + half);
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

static double distance(const km_arm *a, const double *x, const double *y) {
  double sum = 0.0;
  for (int k = 0; k < a->n; ++k) {
    double way = km_arm_difference(a, k, x[k], y[k]);
    sum += way * way;
  }
  return sqrt(sum);
}

static double smallest_singular_value(km_finder *f, const double *q) {
  double sigma[KM_ARM_ROWS];
  km_arm_update(f->arm, &f->space, q);
  km_arm_singular_values(f->arm, &f->space, sigma);
  return sigma[f->arm->rows - 1];
}

/* Newton's method leaves some 1e-12, which near singular poses is a longer way in the joints: two of its ends there are
 * one solution, or two that can't be told apart. */
static bool is_same(km_finder *f, const double *x, const double *y) {
  static const double left = 1e-11, near = 1e-6, furthest = 1e-4;
  double apart = distance(f->arm, x, y);
  if (!(apart >= near && apart < furthest))
    return apart < near;
  return apart * fmin(smallest_singular_value(f, x), smallest_singular_value(f, y)) < left;
}

static bool is_known(km_finder *f, const double *q) {
  for (int i = 0; i < f->count; ++i) {
    const km_loop_curve *c = &f->curves[i];
    if ((f->arm->freedom == 1 && km_loop_curve_passes(c, q)) || is_same(f, c->q, q))
      return true;
  }
  return false;
}

/* With two spare freedoms and more: can one pose be led to the other within the self-motions? */
static bool leads(km_finder *f, const double *from, const double *to) {
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
static bool is_singular(km_finder *f, const double *q) {
  static const double none[KM_ARM_ROWS] = {0};
  km_arm_update(f->arm, &f->space, q);
  km_control_factor(f->arm, &f->space, none, NULL);
  return f->space.null_count > f->arm->freedom;
}

/* Of poses that can be led to each other the one furthest from the limits stands for all. */
static bool is_led_to(km_finder *f, const double *q) {
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

static bool add(km_finder *f, const double *q, double longest) {
  if (!km_reserve((void **)&f->curves, &f->capacity, (size_t)f->count + 1, sizeof *f->curves))
    return false;
  km_loop_curve *c = &f->curves[f->count];
  *c = (km_loop_curve){.arm = f->arm, .space = &f->space, .target = f->target};
  f->count++;
  return km_loop_curve_follow(c, q, longest);
}

enum { MOST_BRANCHES = 128 };

/* A solution: if it isn't known, its curve is followed. */
static void consider(km_finder *f, double *q) {
  bool singular = is_singular(f, q), spreads = f->arm->freedom > 1 || singular;
  f->idle++;
  if (f->count == MOST_BRANCHES || is_known(f, q) || (spreads && is_led_to(f, q)))
    return;
  f->idle = 0;
  f->families = f->families || singular;
  f->failed = !add(f, q, spreads ? 0.0 : LONGEST);
}

/* The sign of the determinant of the arm's six columns at q. */
static int sense_of(km_finder *f, const double *q) {
  double A[KM_ARM_ROWS][KM_ARM_ROWS];
  int sense = 1;
  km_arm_update(f->arm, &f->space, q);
  memcpy(A, f->space.jacobian, sizeof A);
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

bool km_finder_is_singular(km_finder *f, int branch) {
  static const double small = 1e-5; /* where solutions meet Newton's method ends within some 1e-6 of them */
  return f->curves[branch].count == 1 && smallest_singular_value(f, f->curves[branch].q) < small;
}

/* The poses of six hinges are a torus, which can be drawn away from any target: so as many solutions have a positive
 * determinant as a negative one (the mapping's degree is 0). A count that isn't balanced lacks some. */
static bool is_balanced(km_finder *f) {
  const km_arm *a = f->arm;
  int sum = 0;
  if (a->freedom != 0 || a->rows != KM_ARM_ROWS || !all_hinges(a) || f->families)
    return true;
  for (int i = 0; i < f->count; ++i)
    sum += km_finder_is_singular(f, i) ? 0 : sense_of(f, f->curves[i].q); /* two that are one cancel */
  return sum == 0;
}

/* Every pose of the closed form with the column `held` (-1: none) at its value in q. False: there is none, or it leaves
 * a family of poses. */
static bool solve_six(km_finder *f, const double *from, int held) {
  km_six_hinges six;
  double turns[KM_SIX_MOST][KM_SIX], q[KM_ARM_MOST];
  if (!km_six_hinges_find(f->arm, &f->space, from, held, &six))
    return false;
  int count = km_six_hinges_solve(&six, &f->target, turns);
  for (int i = 0; i < count && !f->failed; ++i) {
    memcpy(q, from, (size_t)f->arm->n * sizeof *q);
    for (int k = 0; k < KM_SIX; ++k)
      q[six.column[k]] += turns[i][k];
    if (!km_arm_reach(f->arm, &f->space, &f->target, NULL, 80, 0.7, q))
      continue;
    km_arm_unwind(f->arm, q);
    if (km_arm_reach(f->arm, &f->space, &f->target, NULL, 3, 0.7, q))
      consider(f, q);
  }
  return count >= 0;
}

/* Of seven hinges one is held, at many angles of its turn; each of them in its turn. That finds the curves along which
 * a hinge that leaves a group turns, however short: not those along which only the group itself does. */
static bool solve_closed(km_finder *f) {
  enum { ANGLES = 48 };
  double q[KM_ARM_MOST] = {0};
  bool found = false;
  if (f->arm->freedom == 0)
    return solve_six(f, q, -1);
  for (int held = 0; held < f->arm->n && f->arm->n == KM_SIX + 1 && all_hinges(f->arm); ++held) {
    for (int i = 0; i < ANGLES && goes_on(f, (double)(held * ANGLES + i) / (f->arm->n * ANGLES)); ++i) {
      q[held] = 2.0 * M_PI * i / ANGLES;
      if (!solve_six(f, q, held))
        break;
      found = true;
    }
    q[held] = 0.0;
  }
  return found;
}

/* Until so many solutions in a row are on known branches, and the count is balanced. */
static void search(km_finder *f, unsigned long seed) {
  enum { MOST_STARTS = 4000, MOST_UNBALANCED = 20000, HOPELESS = 600 };
  static const int patience[] = {500, 250, 60};
  const int spare = f->arm->freedom < 2 ? f->arm->freedom : 2, most = spare == 0 ? MOST_UNBALANCED : MOST_STARTS;
  km_random r = {seed};
  double q[KM_ARM_MOST];
  f->idle = 0;
  for (f->starts = 0; f->starts < most && f->count < MOST_BRANCHES && goes_on(f, (double)f->starts / most);
       ++f->starts) {
    if (f->starts == HOPELESS && f->count == 0)
      return;
    if (f->idle >= patience[spare]) {
      f->confirmed = is_balanced(f);
      f->idle = 0; /* if it isn't, as long again */
    }
    if (f->confirmed)
      return;
    if (!try_start(f->arm, &f->space, &f->target, &r, q))
      continue;
    f->converged++;
    consider(f, q);
  }
}

km_status km_finder_run(const km_arm *a, const km_pose *target, unsigned long seed, km_progress progress, void *context,
                        km_finder *f, km_error *error) {
  *f = (km_finder){.arm = a, .target = *target, .progress = progress, .context = context};
  if (!km_arm_space_create(a, &f->space))
    return km_fail(error, KM_MEMORY, "out of memory for the branches");
  f->closed_form = solve_closed(f);
  f->confirmed = f->closed_form && a->freedom == 0 && f->count > 0 && !f->families && is_balanced(f);
  if (!f->confirmed && !f->failed)
    search(f, seed);
  if (f->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for branches was cancelled");
  if (f->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the branches");
  if (f->count == 0)
    return km_fail(error, KM_NO_RESULT, "the pose is out of reach: none of %d starts comes to it", f->starts);
  return KM_OK;
}

void km_finder_free(km_finder *f) {
  for (int i = 0; i < f->count; ++i)
    km_loop_curve_free(&f->curves[i]);
  km_free(f->curves);
  km_arm_space_free(&f->space);
}
