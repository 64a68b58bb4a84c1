/* The motions that meet at a branch point, and leaving one. */
#include "kinematics/branches.h"

#include "kinematics/closure.h"
#include "kinematics/loops.h"
#include "kinematics/many_tangents.h"

#include <string.h>

/* Counts the direction behind the `found` ones if it isn't one of them, in one sense or the other. */
static int count_new(const km_tangents *f, const double *directions, int found) {
  size_t n = (size_t)f->sub->columns;
  for (int i = 0; i < found; ++i)
    if (fabs(km_step_dot(f->m, f->sub, directions + (size_t)found * n, directions + (size_t)i * n)) > 0.999)
      return found;
  return found + 1;
}

static int find_in_few(km_tangents *f, double *directions) {
  int found = 0;
  if (!km_tangents_make_basis(f) || km_tangents_all_real(f))
    return 0;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * f->conditions.freedom && found < KM_MOST_BRANCHES; ++start) {
    if (!km_tangents_random(f))
      continue;
    km_tangents_direction(f, f->a, directions + (size_t)found * (size_t)f->sub->columns);
    found = count_new(f, directions, found);
  }
  return found;
}

static int find_in_many(km_tangents *f, double *directions) {
  km_many_tangents many;
  int found = 0;
  double length;
  if (km_many_tangents_make(&many, f) && !km_many_tangents_all_real(&many, &length))
    while (found < KM_MOST_BRANCHES && km_many_tangents_next(&many, &length)) {
      memcpy(directions + (size_t)found * (size_t)f->sub->columns, many.x, (size_t)f->sub->columns * sizeof *many.x);
      found = count_new(f, directions, found);
    }
  km_many_tangents_free(&many);
  return found;
}

int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  km_arena arena = {0};
  km_tangents f;
  int found = 0;
  bool made = km_tangents_make(&f, m, s, index, &arena);
  f.enough = KM_UNDECIDED; /* rounded data have branches too */
  if (made && f.conditions.redundant)
    found = (km_tangents_are_many(&f) ? find_in_many : find_in_few)(&f, directions);
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
