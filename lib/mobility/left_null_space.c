/* Left null vectors of the six-row Jacobian: those of single loops, then what several loops have together. */
#include "mobility/left_null_space.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"

#include <string.h>

/* Lists the loops of every joint. False when out of memory. */
static bool find_places(km_left_space *a, km_arena *arena) {
  const km_topology *t = &a->m->topology;
  const int *loops = t->loop + t->loop_start[a->index];
  size_t joints = (size_t)a->m->model->joint_count, members = 0;
  for (int i = 0; i < a->sub->loop_count; ++i)
    members += (size_t)(t->member_start[loops[i] + 1] - t->member_start[loops[i]]);
  int *first = KM_ARENA_NEW(arena, int, joints + 2);
  a->place = KM_ARENA_NEW(arena, km_loop_place, members);
  a->first_place = first;
  if (arena->failed)
    return false;
  for (int i = 0; i < a->sub->loop_count; ++i)
    for (int k = t->member_start[loops[i]]; k < t->member_start[loops[i] + 1]; ++k)
      first[t->member[k].joint + 2]++;
  for (size_t j = 0; j < joints; ++j)
    first[j + 2] += first[j + 1];
  /* First[j + 1] is where the next place of joint j goes, and ends up where the joint's places end. */
  for (int i = 0; i < a->sub->loop_count; ++i)
    for (int k = t->member_start[loops[i]]; k < t->member_start[loops[i] + 1]; ++k)
      a->place[first[t->member[k].joint + 1]++] = (km_loop_place){i, k};
  return true;
}

bool km_left_space_make(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_left_space *out) {
  const km_substructure *sub = &m->substructures[index];
  const km_topology *t = &m->topology;
  int worst;
  *out = (km_left_space){.m = m,
                         .s = s,
                         .index = index,
                         .sub = sub,
                         .rows = 6 * sub->loop_count + sub->coupling_count,
                         .tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst))};
  out->about = KM_ARENA_NEW(arena, km_vec3, (size_t)sub->loop_count);
  out->helps = KM_ARENA_NEW(arena, signed char, 4 * (size_t)m->model->joint_count);
  for (int i = 0; i < sub->loop_count && out->about; ++i)
    out->about[i] = km_joint_pose(m, s, t->chord[t->loop[t->loop_start[index] + i]]).p;
  return find_places(out, arena);
}

void km_left_visit(const km_left_space *a, int place, km_left_take take, void *out) {
  const km_topology *t = &a->m->topology;
  int loop = t->loop[t->loop_start[a->index] + place];
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i) {
    const km_member *member = &t->member[i];
    int first = a->m->model->joints[member->joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(a->m->model, member->joint); ++c) {
      if (a->m->column_of[c] < 0)
        continue;
      double column[6], sense = km_member_sign(member);
      km_twist_entries(a->sub, km_coordinate_twist(a->m, a->s, c), a->about[place], a->m->unit[c], column);
      for (int r = 0; r < 6; ++r)
        column[r] *= sense;
      take(out, a->m->column_of[c], column);
    }
  }
}

int km_left_solve(const double *T, int height, int rows, double tolerance, km_arena *arena, double *W) {
  km_partition p;
  double *one = KM_ARENA_NEW(arena, double, (size_t)rows);
  if (!one || !km_partition_reserve(&p, height, rows, arena))
    return -1;
  for (int r = 0; r < rows; ++r)
    one[r] = 1.0;
  km_partition_factor(&p, T, height, rows, NULL, tolerance);
  km_partition_null_space(&p, one, km_partition_freedom(&p), W);
  return km_partition_freedom(&p);
}
