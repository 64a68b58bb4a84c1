/* The motions that meet at a branch point, and leaving one. */
#include "kinematics/branches.h"

#include "kinematics/closure.h"
#include "kinematics/loops.h"
#include "kinematics/tangents.h"

int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  km_arena arena = {0};
  km_tangents f;
  int found = 0, n = m->substructures[index].columns;
  bool made = km_tangents_make(&f, m, s, index, &arena);
  f.enough = KM_UNDECIDED; /* rounded data have branches too */
  if (made && f.conditions.redundant && !km_tangents_all_real(&f)) {
    for (int start = 0; start < KM_STARTS_PER_FREEDOM * f.conditions.freedom && found < KM_MOST_BRANCHES; ++start) {
      if (!km_tangents_random(&f))
        continue;
      double *x = directions + (size_t)found * (size_t)n;
      km_tangents_direction(&f, f.a, x);
      bool known = false;
      for (int i = 0; i < found && !known; ++i) {
        known = fabs(km_step_dot(m, f.sub, x, directions + (size_t)i * (size_t)n)) > 0.999;
      }
      found += !known;
    }
  }
  if (arena.failed) {
    found = -1;
  } else if (f.conditions.redundant) { /* a regular pose has its pivots already */
    km_state_restore(s, f.sub, f.pose);
    km_loops_update(m, s, f.sub);
    km_pivot(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, f.sub, 0.0));
  }
  km_arena_free(&arena);
  return found;
}

static int fastest(const double *directions, int count, int columns, int column) {
  int best = -1;
  double largest = 0.0;
  for (int i = 0; i < count; ++i) {
    double rate = fabs(directions[(size_t)i * (size_t)columns + (size_t)column]);
    if (rate > 1.000001 * largest) {
      largest = rate;
      best = i;
    }
  }
  return best;
}

int km_branch_leave(const km_mechanism *m, km_state *s, int coordinate) {
  static const double short_step = 5e-3;
  int index = m->substructure_of[coordinate];
  if (index < 0 || km_state_holds(s, coordinate)) /* a held one leads nowhere */
    return 0;
  const km_substructure *sub = &m->substructures[index];
  double *directions = KM_NEW(double, (size_t)KM_MOST_BRANCHES *(size_t)sub->columns);
  if (!directions)
    return -1;
  int count = km_branch_directions(m, s, index, directions);
  int best = fastest(directions, count, sub->columns, m->column_of[coordinate]);
  if (best >= 0) {
    km_closure evidence;
    double *step = directions + (size_t)best * (size_t)sub->columns;
    for (int k = 0; k < sub->columns; ++k)
      step[k] *= short_step;
    km_state_move(m, s, sub, step);
    km_state_forget_pivots(s, index);
    km_loops_close(m, s, index, KM_NO_DRIVER, &evidence);
  }
  km_free(directions);
  return count;
}
