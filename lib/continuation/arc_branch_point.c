/* Branch points of a continuation by arc length (theory 4.9, 4.10).
 *
 *   locate : four configurations around the zero of the chord of g; root of the cubic through their values of g;
 *            configuration on the curve through them (node_curve.h)
 *   leave  : tangent = direction of the branch; the first step grows from 1e-3 to 0.13 until the freedom of the
 *            branch is unambiguous */
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

bool km_arc_motion_locate_branch(km_arc_motion *f, double length, double g_end) {
  const km_substructure *sub = km_arc_motion_sub(f);
  double guess = length * f->g / (f->g - g_end), g[KM_CURVE_NODES], reached;
  f->curve.c = guess;
  f->curve.h = km_singular_step;
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    if (!km_arc_motion_step(f, guess + km_node_place[i] * km_singular_step, &reached))
      return false;
    g[i] = km_arc_motion_branch_function_after_step(f);
    km_node_curve_record(&f->curve, &f->c, i, f->c.next_t);
  }
  double u = km_node_curve_root(g, 0.0), root = guess + u * km_singular_step;
  if (!(fabs(u) < km_node_place[KM_CURVE_NODES - 1]))
    return false;
  km_node_curve_place(&f->curve, &f->c, root);
  km_node_curve_tangent(&f->curve, &f->c, root, f->c.next_t);
  double residual = km_loops_residual(f->c.mechanism, f->c.state, sub);
  km_search_pivots(f->c.mechanism, f->c.state, f->c.substructure, KM_NO_DRIVER,
                   fmax(km_singular_pivot, km_rank_tolerance(f->c.mechanism, sub, residual)));
  /* The rank decides, since with redundant constraints g can vanish because the pivot rows alone become dependent. */
  int mobility = km_factor_freedom(f->c.state->factor[f->c.substructure]);
  if (mobility > f->freedom) {
    f->branch = (km_branch_point){f->s + root, mobility, 0};
    f->branched = true;
    km_state_save(f->c.state, sub, f->branch_pose);
    memcpy(f->branch_t, f->c.next_t, (size_t)sub->columns * sizeof *f->c.history.t);
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

/* Sets the tangent to sense · direction, normalised, and clears the history. */
static void set_direction(km_arc_motion *f, const double *direction, double sense) {
  double size = sense * km_step_length(f->c.mechanism, km_arc_motion_sub(f), direction);
  for (int k = 0; k < km_arc_motion_sub(f)->columns; ++k)
    f->c.history.t[k] = direction[k] / size;
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
  km_step_history_begin(&f->c.history, km_arc_motion_sub(f)->columns); /* the last step was on another branch */
  f->g = 0.0;
}

void km_arc_motion_take_branch(km_arc_motion *f, const double *direction) {
  km_state_restore(f->c.state, km_arc_motion_sub(f), f->branch_pose);
  km_state_save(f->c.state, km_arc_motion_sub(f), f->c.from);
  set_direction(f, direction, 1.0);
  f->s = f->branch.s;
  f->closed = false;
}

/* Returns the freedom of the closed configuration h along t; -1 if it is still singular. */
static int find_freedom_after(km_arc_motion *f, double h) {
  const km_substructure *sub = km_arc_motion_sub(f);
  const km_factor *p = f->c.state->factor[f->c.substructure];
  km_closure evidence;
  for (int k = 0; k < sub->columns; ++k)
    f->c.move[k] = h * f->c.history.t[k];
  km_state_restore(f->c.state, sub, f->c.from);
  km_state_move(f->c.mechanism, f->c.state, sub, f->c.move);
  km_loops_close_fully(f->c.mechanism, f->c.state, f->c.substructure, &(km_pivoting){.driver = KM_NO_DRIVER},
                       &evidence);
  return km_continuation_is_singular(p) ? -1 : km_factor_freedom(p);
}

/* Returns the freedom of the branch along t and chooses the first step. The freedom at the branch point is that of
 * all branches together. The stretch with small pivots is wide if branches touch. */
static int find_branch_freedom(km_arc_motion *f) {
  const km_substructure *sub = km_arc_motion_sub(f);
  int most = km_factor_freedom(f->c.state->factor[f->c.substructure]), freedom = most;
  for (double h = km_singular_step; 2.0 * h < km_longest_step; h *= 2.0) {
    int freedom_after_h = find_freedom_after(f, h), next = find_freedom_after(f, 2.0 * h);
    f->largest = h;
    freedom = freedom_after_h > 0 ? freedom_after_h : freedom;
    if (freedom_after_h > 0 && freedom_after_h == next)
      break;
  }
  km_state_restore(f->c.state, sub, f->c.from);
  km_update_and_search_pivots(f->c.mechanism, f->c.state, f->c.substructure, KM_NO_DRIVER, 0.0);
  return freedom;
}

void km_arc_motion_start_branch(km_arc_motion *f, const double *directions, int count) {
  const double *best = directions;
  double nearest = 0.0;
  for (int i = 0; i < count; ++i) {
    const double *x = directions + (size_t)i * (size_t)km_arc_motion_sub(f)->columns;
    double along = km_step_dot(f->c.mechanism, km_arc_motion_sub(f), x, f->c.history.t);
    if (fabs(along) > 1.000001 * fabs(nearest)) {
      nearest = along;
      best = x;
    }
  }
  set_direction(f, best, nearest < 0.0 ? -1.0 : 1.0);
  f->freedom = find_branch_freedom(f);
  f->is_origin_pending = true;
}
