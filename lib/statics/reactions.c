/* Reactions of all joints (theory 9.4): Jᵀ μ = f + τ for the wrenches μ of the loops' chords, then down the tree.
 *
 *   reaction = wrench of the parent on the child = tree's part + Σ ± μ_l over the loops l through the joint */
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"
#include "statics/statics.h"

#include <string.h>

/* Most rows for dense matrices, which are faster for small substructures. */
enum { MOST_DENSE_ROWS = 120 };

static void reserve_dense(km_reaction_workspace *c, km_arena *arena) {
  size_t rows = (size_t)c->rows, columns = (size_t)c->columns;
  c->arm = KM_ARENA_NEW(arena, km_vec3, (size_t)c->joints);
  c->T = KM_ARENA_NEW(arena, double, rows *columns);
  c->nonzero_row = KM_ARENA_NEW(arena, int, rows);
  c->rhs = KM_ARENA_NEW(arena, double, columns);
  c->mu = KM_ARENA_NEW(arena, double, rows);
  c->moments = KM_ARENA_NEW(arena, km_arm_moments, (size_t)c->loops * (size_t)c->loops);
  c->stress_start = KM_ARENA_NEW(arena, int, rows + 1);
  c->stress = KM_ARENA_NEW(arena, km_stress_entry, rows * rows);
  c->metric = KM_ARENA_NEW(arena, double, rows *rows);
  c->image = KM_ARENA_NEW(arena, double, rows *rows);
  c->sample = KM_ARENA_NEW(arena, km_pair, 2 * rows + 6 * (size_t)c->joints);
  c->gram = KM_ARENA_NEW(arena, double, rows *rows);
  c->gradient = KM_ARENA_NEW(arena, double, rows);
  c->slope = KM_ARENA_NEW(arena, double, rows);
  c->share = KM_ARENA_NEW(arena, double, rows);
  c->factor = km_factor_create(c->columns, c->rows, NULL, arena);
}

km_status km_reaction_workspace_make_large(const km_mechanism *m, km_statics_workspace *w, int index, km_error *error) {
  km_reaction_workspace *c = &w->reactions_of[index];
  c->reported = KM_ARENA_NEW(&w->arena, double, 6 * (size_t)c->joints);
  c->indeterminate_out = KM_ARENA_NEW(&w->arena, bool, 6 * (size_t)c->joints);
  return km_body_equilibrium_create(m, index, &c->body_equilibrium, error);
}

static km_status reserve_one(const km_mechanism *m, km_statics_workspace *w, int index, km_error *error) {
  const km_topology *t = &m->topology;
  const km_substructure *sub = &m->substructures[index];
  km_reaction_workspace *c = &w->reactions_of[index];
  c->rows = 6 * sub->loop_count + sub->coupling_count;
  c->columns = sub->columns;
  c->loops = sub->loop_count;
  c->joints = t->joint_start[index + 1] - t->joint_start[index];
  c->joint = t->joint + t->joint_start[index];
  c->size = sub->size;
  for (int j = 0; j < c->joints; ++j)
    w->joint_index[c->joint[j]] = j;
  if (c->rows > MOST_DENSE_ROWS)
    return km_reaction_workspace_make_large(m, w, index, error);
  c->first = t->joint_loop_start;
  c->joint_loops = t->joint_loop;
  reserve_dense(c, &w->arena);
  return KM_OK;
}

km_status km_reaction_workspace_reserve(const km_mechanism *m, km_statics_workspace *w, km_error *error) {
  const km_topology *t = &m->topology;
  km_arena *arena = &w->arena;
  km_status status = KM_OK;
  w->reactions_of = KM_ARENA_NEW(arena, km_reaction_workspace, (size_t)t->substructure_count);
  w->frame = KM_ARENA_NEW(arena, km_pose, (size_t)t->joint_count);
  w->carried = KM_ARENA_NEW(arena, km_wrench, (size_t)t->joint_count);
  w->joint_index = KM_ARENA_NEW(arena, int, (size_t)t->joint_count);
  for (int i = 0; i < t->substructure_count && !arena->failed && !status; ++i)
    status = reserve_one(m, w, i, error);
  return status || !arena->failed ? status : km_fail(error, KM_MEMORY, "out of memory for the reactions");
}

void km_reaction_workspace_free(km_statics_workspace *w) {
  for (int i = 0; w->reactions_of && i < w->mechanism->topology.substructure_count; ++i)
    km_body_equilibrium_free(w->reactions_of[i].body_equilibrium);
}

/* Computes the frame in which a reaction is reported. */
static void set_frame(const km_mechanism *m, const km_forces *f, int joint, km_axes axes, km_pose *out) {
  const km_model_frame *frame = &m->model->frames[m->model->joints[joint].frame[1]];
  const km_pose *body = &f->pose[frame->body];
  for (int k = 0; k < 3; ++k)
    out->R.axis[k] = km_rotate(&body->R, frame->pose.R.axis[k]);
  if (axes == KM_AXES_FIXED)
    out->R = km_rotation_identity();
  out->p = km_pose_point(body, frame->pose.p);
}

/* Returns the reaction of a tree joint without loops: the parent holds the loads of the child's subtree. */
static km_wrench tree_reaction(const km_mechanism *m, const km_statics_workspace *w, int joint) {
  bool is_reversed = m->topology.is_reversed[joint];
  int body = km_joint_body(m->model, joint, !is_reversed);
  if (m->topology.arc[body] != joint)
    return (km_wrench){{0, 0, 0}, {0, 0, 0}}; /* a chord */
  return km_wrench_axpy(is_reversed ? 1.0 : -1.0, w->subtree[body], (km_wrench){{0, 0, 0}, {0, 0, 0}});
}

static double rank_tolerance(const km_mechanism *m, const km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  return km_rank_tolerance(m, sub, km_loops_residual(m, s, sub));
}

/* Removes the zero rows of J from Jᵀ, such as those normal to a plane: each is a self-stress by itself. */
static void remove_zero_rows(km_reaction_workspace *c) {
  int columns = c->columns, zero_row = c->rows;
  c->nonzero_row_count = 0;
  for (int r = 0; r < c->rows; ++r) {
    const double *from = c->T + (size_t)r * (size_t)columns;
    bool nonzero_row = false;
    for (int k = 0; k < columns && !nonzero_row; ++k)
      nonzero_row = from[k] != 0.0;
    if (!nonzero_row) {
      c->nonzero_row[--zero_row] = r;
      continue;
    }
    if (c->nonzero_row_count < r)
      memcpy(c->T + (size_t)c->nonzero_row_count * (size_t)columns, from, (size_t)columns * sizeof *from);
    c->nonzero_row[c->nonzero_row_count++] = r;
  }
}

/* Computes chord wrenches of one substructure that balance the loads: Jᵀ μ = f + τ. The null space of Jᵀ are the
 * self-stresses, without force along any motion. */
static void solve_chords(const km_mechanism *m, const km_state *s, int index, km_vec3 about, km_statics_workspace *w) {
  const km_substructure *sub = &m->substructures[index];
  km_reaction_workspace *c = &w->reactions_of[index];
  km_full_jacobian(m, s, index, w->twist, about, (size_t)c->columns, 1, c->T);
  remove_zero_rows(c);
  for (int k = 0; k < c->columns; ++k) { /* τ includes the force of a spring in the joint */
    int coordinate = m->column_coordinate[sub->column_start + k];
    c->rhs[k] = m->unit[coordinate] * (w->force[coordinate] + w->tau[coordinate]);
  }
  km_factor_compute(c->factor, c->T, c->columns, c->nonzero_row_count,
                    &(km_factor_options){.tolerance = rank_tolerance(m, s, index)});
  km_factor_solve(c->factor, c->rhs, c->share);
  memset(c->mu, 0, (size_t)c->rows * sizeof *c->mu);
  for (int i = 0; i < c->nonzero_row_count; ++i)
    c->mu[c->nonzero_row[i]] = c->share[i];
}

static void compute_small_substructure(const km_mechanism *m, const km_state *s, const km_forces *f, int index,
                                       km_statics *st) {
  km_statics_workspace *w = st->work;
  km_reaction_workspace *c = &w->reactions_of[index];
  km_vec3 about = km_frame_origin(m->model, f->pose, m->model->joints[c->joint[0]].frame[0]);
  solve_chords(m, s, index, about, w);
  for (int j = 0; j < c->joints; ++j)
    c->arm[j] = km_vec3_sub(w->frame[c->joint[j]].p, about);
  km_reactions_minimise_norm(c, w, m->length);
  st->degree += c->degree;
}

/* Computes the reactions of a large substructure from those of the tree alone; NaN without memory. */
static void compute_large_substructure(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_reaction_workspace *c = &st->work->reactions_of[index];
  for (int j = 0; j < c->joints; ++j) {
    memcpy(c->reported + 6 * j, st->reactions[c->joint[j]].force, 3 * sizeof *c->reported);
    memcpy(c->reported + 6 * j + 3, st->reactions[c->joint[j]].torque, 3 * sizeof *c->reported);
  }
  memset(c->indeterminate_out, 0, 6 * (size_t)c->joints * sizeof *c->indeterminate_out);
  int degree = km_body_equilibrium_solve(c->body_equilibrium, st->work, s, rank_tolerance(m, s, index), c->reported,
                                         c->indeterminate_out);
  for (int i = 0; i < 6 * c->joints && degree < 0; ++i)
    c->reported[i] = nan("");
  for (int j = 0; j < c->joints; ++j) {
    km_reaction *r = &st->reactions[c->joint[j]];
    memcpy(r->force, c->reported + 6 * j, sizeof r->force);
    memcpy(r->torque, c->reported + 6 * j + 3, sizeof r->torque);
    memcpy(r->indeterminate, c->indeterminate_out + 6 * j, sizeof r->indeterminate);
  }
  st->degree += degree > 0 ? degree : 0;
}

/* Writes a reaction along the axes of its frame. */
static void write_reaction(const km_statics_workspace *w, int joint, km_reaction *r) {
  const km_rotation *R = &w->frame[joint].R;
  for (int k = 0; k < 3; ++k) {
    r->force[k] = km_vec3_dot(R->axis[k], w->carried[joint].f);
    r->torque[k] = km_vec3_dot(R->axis[k], w->carried[joint].t);
  }
}

void km_reactions_compute(const km_mechanism *m, km_state *s, const km_forces *f, km_statics *st) {
  km_statics_workspace *w = st->work;
  st->degree = 0;
  for (int j = 0; j < m->topology.joint_count; ++j) {
    set_frame(m, f, j, st->axes, &w->frame[j]);
    w->carried[j] = km_wrench_about(tree_reaction(m, w, j), w->frame[j].p);
    memset(st->reactions[j].indeterminate, 0, sizeof st->reactions[j].indeterminate);
  }
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (!w->reactions_of[i].body_equilibrium)
      compute_small_substructure(m, s, f, i, st);
  for (int j = 0; j < m->topology.joint_count; ++j)
    write_reaction(w, j, &st->reactions[j]);
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (w->reactions_of[i].body_equilibrium)
      compute_large_substructure(m, s, i, st);
}

void km_statics_mark(const km_mechanism *m, km_statics *st) {
  km_statics_workspace *w = st->work;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (!w->reactions_of[i].body_equilibrium && w->reactions_of[i].degree > 0)
      km_indeterminate_components_mark(&w->reactions_of[i], w, st->reactions);
}
