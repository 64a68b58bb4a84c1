/* Branch points on a followed motion: where they are, and which way to go. */
#include "continuation/arc_motion.h"
#include "continuation/hermite_curve.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

static const double aside = 1e-3; /* distance of the poses that a branch point is interpolated from */
static const double first_step = 1e-3, longest_first = 0.25; /* away from a branch point */

/* Root of the cubic through four equally spaced values, near the middle, by Newton on Lagrange's form. */
static double cubic_root(const double g[4], double x, double spacing, double middle) {
  for (int i = 0; i < 20; ++i) {
    double u = (x - middle) / spacing, value = 0.0, slope = 0.0; /* nodes at u = -1.5, -0.5, 0.5, 1.5 */
    for (int k = 0; k < 4; ++k) {
      double product = g[k], derivative = 0.0, at = k - 1.5;
      for (int o = 0; o < 4; ++o)
        if (o != k)
          product *= (u - (o - 1.5)) / (at - (o - 1.5));
      for (int o = 0; o < 4; ++o) {
        if (o == k)
          continue;
        double partial = g[k] / (at - (o - 1.5));
        for (int n = 0; n < 4; ++n)
          if (n != k && n != o)
            partial *= (u - (n - 1.5)) / (at - (n - 1.5));
        derivative += partial;
      }
      value += product;
      slope += derivative;
    }
    x -= value / slope * spacing;
  }
  return x;
}

bool km_arc_motion_locate_branch(km_arc_motion *f, double length, double g_end) {
  const km_substructure *sub = km_arc_motion_sub(f);
  double guess = length * f->g / (f->g - g_end), g[4], reached;
  for (int k = 0; k < 4; ++k) {
    if (!km_arc_motion_step(f, guess + (2.0 * k - 3.0) * aside, &reached))
      return false;
    g[k] = km_arc_motion_saved_g(f);
    if (k != 1 && k != 2)
      continue;
    memcpy(k == 1 ? f->near_t : f->far_t, f->c.next_t, (size_t)sub->columns * sizeof *f->c.course.t);
    km_state_save(f->c.state, sub, k == 1 ? f->near : f->far);
  }
  double root = cubic_root(g, guess, 2.0 * aside, guess);
  if (!(fabs(root - guess) < 2.0 * aside))
    return false;
  km_state_restore(f->c.state, sub, f->far);
  km_state_difference(f->c.state, sub, f->near, f->c.move);
  km_state_restore(f->c.state, sub, f->near);
  double width = km_continuation_arc(&f->c, f->c.move, f->near_t, f->far_t);
  km_curve_between(sub->columns, width, f->c.move, f->near_t, f->far_t, root - guess + aside, f->c.work, f->c.next_t);
  km_state_move(f->c.mechanism, f->c.state, sub, f->c.work);
  km_loops_update(f->c.mechanism, f->c.state, sub);
  int worst;
  double residual = km_loops_residual(f->c.mechanism, f->c.state, sub, &worst);
  km_search_pivots(f->c.mechanism, f->c.state, f->c.substructure, KM_NO_DRIVER,
                   fmax(1e-7, km_rank_tolerance(f->c.mechanism, sub, residual)));
  /* Where constraints are redundant it may just be the pivot rows that become dependent. */
  int mobility = km_partition_freedom(&f->c.state->partition[f->c.substructure]);
  if (mobility > f->freedom) {
    f->branch = (km_branch_point){f->s + root, mobility, 0};
    f->branched = true;
    km_state_save(f->c.state, sub, f->branch_pose);
    memcpy(f->branch_t, f->c.next_t, (size_t)sub->columns * sizeof *f->c.course.t);
  }
  km_state_restore(f->c.state, sub, f->c.from);
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
  return true;
}

bool km_arc_motion_branch(const km_arc_motion *f, km_branch_point *out) {
  if (!f || !out)
    return false;
  if (f->branched)
    *out = f->branch;
  return f->branched;
}

void km_arc_motion_move_to_branch_point(km_arc_motion *f, double *tangent) {
  km_state_restore(f->c.state, km_arc_motion_sub(f), f->branch_pose);
  memcpy(tangent, f->branch_t, (size_t)km_arc_motion_sub(f)->columns * sizeof *tangent);
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
}

void km_arc_motion_continue(km_arc_motion *f) {
  km_loops_restore_cached(f->c.mechanism, f->c.state, f->c.substructure, f->c.from);
}

/* Continues from the saved pose, a branch point, along `direction`. */
static void set_out(km_arc_motion *f, const double *direction, double sense) {
  double size = sense * km_step_length(f->c.mechanism, km_arc_motion_sub(f), direction);
  for (int k = 0; k < km_arc_motion_sub(f)->columns; ++k)
    f->c.course.t[k] = direction[k] / size;
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
  km_step_history_begin(&f->c.course, km_arc_motion_sub(f)->columns); /* the step before was on another branch */
  f->g = 0.0;
}

void km_arc_motion_take_branch(km_arc_motion *f, const double *direction) {
  km_state_restore(f->c.state, km_arc_motion_sub(f), f->branch_pose);
  km_state_save(f->c.state, km_arc_motion_sub(f), f->c.from);
  set_out(f, direction, 1.0);
  f->s = f->branch.s;
  f->closed = false;
}

/* Freedom of the motion at a distance h along t; -1 if the configuration there is still singular. */
static int freedom_at(km_arc_motion *f, double h) {
  const km_substructure *sub = km_arc_motion_sub(f);
  const km_partition *p = &f->c.state->partition[f->c.substructure];
  km_closure evidence;
  for (int k = 0; k < sub->columns; ++k)
    f->c.move[k] = h * f->c.course.t[k];
  km_state_restore(f->c.state, sub, f->c.from);
  km_state_move(f->c.mechanism, f->c.state, sub, f->c.move);
  km_close_fully(km_loops_close, f->c.mechanism, f->c.state, f->c.substructure, KM_NO_DRIVER, &evidence);
  return km_continuation_is_singular(p) ? -1 : km_partition_freedom(p);
}

/* Freedom of the motion along t, which at its branch point can't be told from that of the others, and the first step:
 * the stretch on which pivots are too small is wide where branches touch. */
static int freedom_ahead(km_arc_motion *f) {
  const km_substructure *sub = km_arc_motion_sub(f);
  int most = km_partition_freedom(&f->c.state->partition[f->c.substructure]), freedom = most;
  for (double h = first_step; h <= longest_first; h *= 2.0) {
    int here = freedom_at(f, h), next = freedom_at(f, 2.0 * h);
    f->largest = h;
    freedom = here > 0 ? here : freedom;
    if (here > 0 && here == next)
      break;
  }
  km_state_restore(f->c.state, sub, f->c.from);
  km_loops_update(f->c.mechanism, f->c.state, sub);
  km_search_pivots(f->c.mechanism, f->c.state, f->c.substructure, KM_NO_DRIVER,
                   km_rank_tolerance(f->c.mechanism, sub, 0.0));
  return freedom;
}

void km_arc_motion_start_branch(km_arc_motion *f, const double *directions, int count) {
  const double *best = directions;
  double nearest = 0.0;
  for (int i = 0; i < count; ++i) {
    const double *x = directions + (size_t)i * (size_t)km_arc_motion_sub(f)->columns;
    double along = km_step_dot(f->c.mechanism, km_arc_motion_sub(f), x, f->c.course.t);
    if (fabs(along) > 1.000001 * fabs(nearest)) {
      nearest = along;
      best = x;
    }
  }
  set_out(f, best, nearest < 0.0 ? -1.0 : 1.0);
  f->freedom = freedom_ahead(f);
  f->origin_waits = true;
}
