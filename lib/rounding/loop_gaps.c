/* Gaps of loops, their Jacobian and their derivatives by numbers. */
#include "rounding/loop_gaps.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"
#include "model/initial_poses.h"

#include <string.h>

/* Index of loop i of the substructure. */
static int loop_index(const km_loop_gaps *g, int i) {
  const km_topology *t = &g->m->topology;
  return t->loop[t->loop_start[g->index] + i];
}

bool km_loop_gaps_create(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_loop_gaps *out) {
  const km_substructure *sub = &m->substructures[index];
  *out = (km_loop_gaps){.m = m,
                        .s = s,
                        .index = index,
                        .rows = 6 * sub->loop_count + sub->coupling_count,
                        .columns = sub->columns,
                        .about = km_joint_pose(m, s, m->topology.joint[m->topology.joint_start[index]]).p,
                        .twist = KM_ARENA_NEW(arena, km_twist, (size_t)m->coordinate_count),
                        .normal = KM_ARENA_NEW(arena, km_vec3, (size_t)sub->loop_count),
                        .is_hinged = KM_ARENA_NEW(arena, bool, (size_t)sub->loop_count),
                        .keeps_planes = true};
  if (arena->failed)
    return false;
  for (int p = sub->program_start; p < sub->program_start + sub->program_count; ++p)
    for (int k = m->programs[p].loop_start;
         m->programs[p].planar && k < m->programs[p].loop_start + m->programs[p].loop_count; ++k)
      for (int i = 0; i < sub->loop_count; ++i)
        if (loop_index(out, i) == m->loop_order[k]) {
          out->normal[i] = m->loops[m->loop_order[k]].plane_normal;
          out->is_hinged[i] = m->loops[m->loop_order[k]].pin_offset != 0.0;
        }
  return true;
}

void km_loop_gaps_replace(km_loop_gaps *g, const km_mechanism *m, km_state *s) {
  g->m = m;
  g->s = s;
  km_poses_compute(m, s);
}

/* Passes from one body of a joint to the other: the pose of the next body. */
static km_pose pass_joint(const km_loop_gaps *g, const km_member *member, const km_pose *from) {
  const km_model *model = g->m->model;
  const km_model_joint *joint = &model->joints[member->joint];
  const km_pose *parent = &model->frames[joint->frame[0]].pose, *child = &model->frames[joint->frame[1]].pose;
  km_pose motion = km_model_joint_motion(model, member->joint, g->s->q + joint->first_coordinate);
  km_pose before = km_pose_product(parent, &motion), back = km_pose_inverse(child);
  km_pose step = km_pose_product(&before, &back);
  if (member->is_reversed)
    step = km_pose_inverse(&step);
  return km_pose_product(from, &step);
}

static void remove_direction(km_vec3 n, double *column) {
  double along = n.x * column[0] + n.y * column[1] + n.z * column[2];
  column[0] -= along * n.x;
  column[1] -= along * n.y;
  column[2] -= along * n.z;
}

/* The normal of loop i in inertial axes. */
static km_vec3 inertial_normal(const km_loop_gaps *g, int i) {
  return km_rotate(&g->s->pose[g->m->topology.base[loop_index(g, i)]].R, g->normal[i]);
}

/* The direction of loop i in which an offset doesn't count; 0: none. */
static km_vec3 free_direction(const km_loop_gaps *g, int i) {
  return g->keeps_planes && g->is_hinged[i] ? inertial_normal(g, i) : (km_vec3){0, 0, 0};
}

/* The gap of a loop from the poses along its two sides. */
static void loop_gap(const km_loop_gaps *g, int i, double *e) {
  const km_topology *t = &g->m->topology;
  const km_substructure *sub = &g->m->substructures[g->index];
  int loop = loop_index(g, i);
  km_pose X = g->s->pose[t->base[loop]], Y = X;
  for (int k = t->member_start[loop]; k < t->member_start[loop + 1]; ++k) {
    km_pose *side = t->member[k].side > 0 ? &X : &Y;
    *side = pass_joint(g, &t->member[k], side);
  }
  km_pose back = km_pose_inverse(&Y), difference = km_pose_product(&X, &back);
  km_twist_entries(sub, km_twist_log(&difference), g->about, 1.0, e);
  remove_direction(free_direction(g, i), e);
}

void km_loop_gaps_compute(km_loop_gaps *g, double *e, double *J) {
  const km_mechanism *m = g->m;
  const km_substructure *sub = &m->substructures[g->index];
  km_poses_compute_in(m, g->s, g->index);
  for (int k = 0; k < g->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    g->twist[c] = km_coordinate_twist(m, g->s, c);
  }
  km_full_jacobian(m, g->s, g->index, g->twist, g->about, 1, (size_t)g->rows, J);
  for (int i = 0; i < sub->loop_count; ++i)
    loop_gap(g, i, e + 6 * i);
  if (sub->coupling_count > 0) {
    km_loops_update(m, g->s, sub);
    for (int i = 0; i < sub->coupling_count; ++i)
      e[6 * sub->loop_count + i] = km_state_error(g->s, sub)[m->couplings[sub->coupling_start + i].row];
  }
}

/* Twist entries of the body's displacement per unit of a number that places the frame at one end of a joint; false if
 * it doesn't. */
static bool end_entries(const km_loop_gaps *g, int joint, int end, const km_written_number *number, double entry[6]) {
  const km_model *model = g->m->model;
  int f = model->joints[joint].frame[end];
  if (f != number->frame[0] && f != number->frame[1])
    return false;
  const km_model_frame *frame = &model->frames[f];
  km_twist change = {number->move, number->turn};
  change.v = km_vec3_add(change.v, km_vec3_cross(frame->pose.p, change.w)); /* its velocity at the body's origin */
  km_twist_entries(&g->m->substructures[g->index], km_twist_transform(&g->s->pose[frame->body], change), g->about, 1.0,
                   entry);
  return true;
}

static void add_column(const km_loop_gaps *g, const km_member *member, const km_written_number *number, double half,
                       double *column) {
  double entry[6];
  for (int end = 0; end < 2; ++end)
    for (int r = 0; r < 6 && end_entries(g, member->joint, end, number, entry); ++r)
      column[r] += (end == 0 ? half : -half) * km_member_sign(member) * entry[r];
}

double km_loop_gaps_noise(const km_loop_gaps *g, const km_written_number *numbers, const double *half, int count) {
  const km_topology *t = &g->m->topology;
  double sum = 0.0, entry[6];
  for (int i = t->joint_start[g->index]; i < t->joint_start[g->index + 1]; ++i)
    for (int k = 0; k < count; ++k)
      for (int end = 0; end < 2; ++end)
        for (int r = 0; r < 6 && end_entries(g, t->joint[i], end, &numbers[k], entry); ++r)
          sum += half[k] * half[k] * entry[r] * entry[r];
  return sqrt(sum);
}

void km_loop_gaps_number_columns(const km_loop_gaps *g, const km_written_number *numbers, const double *half, int count,
                                 double *E) {
  const km_topology *t = &g->m->topology;
  const km_substructure *sub = &g->m->substructures[g->index];
  memset(E, 0, (size_t)g->rows * (size_t)count * sizeof *E);
  for (int i = 0; i < sub->loop_count; ++i) {
    int loop = loop_index(g, i);
    km_vec3 n = free_direction(g, i);
    for (int k = 0; k < count; ++k) {
      double *column = E + (size_t)k * (size_t)g->rows + 6 * i;
      for (int j = t->member_start[loop]; j < t->member_start[loop + 1]; ++j)
        add_column(g, &t->member[j], &numbers[k], half[k], column);
      remove_direction(n, column);
    }
  }
}

static bool is_in_loop(const km_loop_gaps *g, int loop, int frame) {
  const km_topology *t = &g->m->topology;
  for (int j = t->member_start[loop]; j < t->member_start[loop + 1]; ++j)
    for (int end = 0; end < 2; ++end)
      if (g->m->model->joints[t->member[j].joint].frame[end] == frame)
        return true;
  return false;
}

km_written_number km_loop_gaps_keep_plane(const km_loop_gaps *g, const km_written_number *number) {
  km_written_number kept = *number;
  for (int i = 0; i < g->m->substructures[g->index].loop_count; ++i) {
    if (km_vec3_norm(g->normal[i]) == 0.0 || !is_in_loop(g, loop_index(g, i), number->frame[0]))
      continue;
    const km_pose *body = &g->s->pose[g->m->model->frames[number->frame[0]].body];
    km_vec3 n = km_rotate_back(&body->R, inertial_normal(g, i));
    kept.move = km_vec3_axpy(-km_vec3_dot(n, kept.move), n, kept.move);
    kept.turn = km_vec3_scale(km_vec3_dot(n, kept.turn), n);
  }
  return kept;
}
