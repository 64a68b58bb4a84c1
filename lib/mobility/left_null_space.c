/* Data and column access of the six-row Jacobian for its left null vectors (theory 7.1). */
#include "mobility/left_null_space.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"

#include <string.h>

bool km_left_space_create(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_left_space *out) {
  const km_substructure *sub = &m->substructures[index];
  const km_topology *t = &m->topology;
  *out = (km_left_space){.m = m,
                         .s = s,
                         .index = index,
                         .sub = sub,
                         .rows = 6 * sub->loop_count + sub->coupling_count,
                         .tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub))};
  out->about = KM_ARENA_NEW(arena, km_vec3, (size_t)sub->loop_count);
  out->swap_result = KM_ARENA_NEW(arena, signed char, 4 * (size_t)m->model->joint_count);
  for (int i = 0; i < sub->loop_count && out->about; ++i)
    out->about[i] = km_joint_pose(m, s, t->chord[t->loop[t->loop_start[index] + i]]).p;
  return !arena->failed;
}

void km_left_for_each_column(const km_left_space *a, int block, km_left_column_visitor visit, void *out) {
  const km_topology *t = &a->m->topology;
  int loop = t->loop[t->loop_start[a->index] + block];
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i) {
    const km_member *member = &t->member[i];
    int first = a->m->model->joints[member->joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(a->m->model, member->joint); ++c) {
      if (a->m->column_of[c] < 0)
        continue;
      double column[6], sign = km_member_sign(member);
      km_twist_entries(a->sub, km_coordinate_twist(a->m, a->s, c), a->about[block], a->m->unit[c], column);
      for (int r = 0; r < 6; ++r)
        column[r] *= sign;
      visit(out, a->m->column_of[c], column);
    }
  }
}

static void count_column(void *out, int column, const double entry[6]) {
  (void)column;
  (void)entry;
  ++*(int *)out;
}

int km_left_column_count(const km_left_space *a, int block) {
  int count = 0;
  km_left_for_each_column(a, block, count_column, &count);
  return count;
}

void km_left_null_expand(const km_left_space *a, const km_left_null *null, int k, double *v) {
  int loop = 0, n = k - null->local_count;
  memset(v, 0, (size_t)a->rows * sizeof *v);
  if (n < 0) {
    while (null->first[loop + 1] <= k)
      ++loop;
    memcpy(v + 6 * loop, null->local + 6 * k, 6 * sizeof *v);
    return;
  }
  for (int i = null->part_start[n]; i < null->part_start[n + 1]; ++i)
    memcpy(v + km_left_row(a, null->part[i].block), null->part[i].w,
           (size_t)km_left_rows(a, null->part[i].block) * sizeof *v);
}
