/* Motion of a body's point towards a target (theory 4.14): damped least squares in the motions that loops and limits
 * allow, then the loops are closed.
 *
 *   w = Aᵀ (A Aᵀ + ε)⁻¹ e,  z = Z w:   A velocities of the point over L in the basis Z of D q̇, e displacement
 *   ε = max(min(|e|, 0.01)², 1e-9)
 *   active limits : their coordinates are locked while the step is found
 *   rejected      : correction > 1/4 of the step, lower rank, cosine with the new tangent space < 0.8 */
#include "base/number/tolerances.h"
#include "manipulation/manipulation.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/bifurcation.h"
#include "local/local.h"
#include "mobility/mobility_numbers.h"

#include <string.h>

enum { MAX_STEPS = 4, MAX_HALVINGS = 14, MAX_ACTIVE_LIMITS = 12 };
static const double max_damping = 0.01; /* √ε far from the target, relative to L */

typedef struct point_motion {
  km_manipulation *h;
  const km_manipulation_point *target_point;
  double length; /* L */
  double e[3];   /* remaining displacement over L, without the part along the normal */
  int freedoms;
} point_motion;

static km_vec3 point_position(const point_motion *p) {
  return km_pose_point(&p->h->state->pose[p->target_point->body], km_vec3_from_array(p->target_point->point));
}

/* Computes the displacement over L; returns its length. */
static double update_remaining(point_motion *p) {
  km_vec3 e =
      km_vec3_scale(1.0 / p->length, km_vec3_sub(km_vec3_from_array(p->target_point->target), point_position(p)));
  km_vec3 normal = km_vec3_from_array(p->target_point->normal);
  e = km_vec3_axpy(-km_vec3_dot(e, normal), normal, e);
  km_vec3_write(e, p->e);
  return km_vec3_norm(e);
}

/* Finds the substructures and the coordinates outside them that carry the body, and the point's velocity for each
 * coordinate. */
static void find_path(point_motion *p) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  km_vec3 at = point_position(p), normal = km_vec3_from_array(p->target_point->normal);
  memset(h->column, 0, (size_t)m->coordinate_count * sizeof *h->column);
  memset(h->is_on_path, 0, (size_t)m->topology.substructure_count * sizeof *h->is_on_path);
  h->substructure_count_on_path = h->tree_count = 0;
  for (int body = p->target_point->body; body > 0; body = m->topology.parent[body]) {
    int joint = m->topology.arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      if (m->held[c])
        continue;
      km_twist t = km_coordinate_twist(m, h->state, c);
      km_vec3 v = km_point_velocity(t, at);
      v = km_vec3_axpy(-km_vec3_dot(v, normal), normal, v);
      h->column[c] = km_vec3_scale((m->topology.is_reversed[joint] ? -1.0 : 1.0) / (p->length * m->scale[c]), v);
      int index = m->substructure_of[c];
      if (index < 0)
        h->tree[h->tree_count++] = c;
      else if (!h->is_on_path[index]) {
        h->is_on_path[index] = true;
        h->substructures[h->substructure_count_on_path++] = index;
      }
    }
  }
}

/* Appends a column to A. */
static void add_column(point_motion *p, km_vec3 v) {
  km_vec3_write(v, p->h->A + 3 * (size_t)p->freedoms++);
}

/* Appends the columns of a substructure's basis to A. Coordinates at active limits are locked in it. */
static void add_substructure_columns(point_motion *p, int index) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const double *Z = km_state_basis(h->state, index);
  int freedom = km_factor_freedom(h->state->factor[index]);
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int i = 0; i < freedom; ++i) {
    km_vec3 v = {0, 0, 0};
    for (int k = 0; k < sub->columns; ++k)
      v = km_vec3_axpy(Z[(size_t)i * (size_t)sub->columns + (size_t)k], h->column[coordinate[k]], v);
    add_column(p, v);
  }
}

/* Solves (A Aᵀ + ε) x = e, 3 × 3 symmetric, by Cramer's rule. */
static km_vec3 solve_damped(const point_motion *p) {
  km_vec3 e = km_vec3_from_array(p->e);
  double damping = fmin(km_vec3_norm(e), max_damping), epsilon = fmax(damping * damping, km_relative_zero);
  km_vec3 G[3] = {{epsilon, 0, 0}, {0, epsilon, 0}, {0, 0, epsilon}};
  for (int k = 0; k < p->freedoms; ++k)
    for (int i = 0; i < 3; ++i)
      G[i] = km_vec3_axpy(p->h->A[3 * k + i], km_vec3_from_array(p->h->A + 3 * k), G[i]);
  km_vec3 cofactor = km_vec3_cross(G[1], G[2]),
          x = {km_vec3_dot(e, cofactor), km_vec3_dot(e, km_vec3_cross(G[2], G[0])),
               km_vec3_dot(e, km_vec3_cross(G[0], G[1]))};
  return km_vec3_scale(1.0 / km_vec3_dot(G[0], cofactor), x);
}

/* Computes A and the step z = Z Aᵀ x; returns |z|. */
static double find_step(point_motion *p) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  double square = 0.0;
  int k = 0;
  p->freedoms = 0;
  for (int i = 0; i < h->substructure_count_on_path; ++i)
    add_substructure_columns(p, h->substructures[i]);
  for (int i = 0; i < h->tree_count; ++i)
    add_column(p, h->blocked[h->tree[i]] ? (km_vec3){0, 0, 0} : h->column[h->tree[i]]);
  km_vec3 x = solve_damped(p);
  memset(h->z, 0, (size_t)m->coordinate_count * sizeof *h->z);
  for (int i = 0; i < p->freedoms; ++i) {
    h->w[i] = km_vec3_dot(x, km_vec3_from_array(h->A + 3 * i));
    square += h->w[i] * h->w[i];
  }
  for (int i = 0; i < h->substructure_count_on_path; ++i) {
    const km_substructure *sub = &m->substructures[h->substructures[i]];
    const double *Z = km_state_basis(h->state, h->substructures[i]);
    const int *coordinate = m->column_coordinate + sub->column_start;
    for (int f = km_factor_freedom(h->state->factor[h->substructures[i]]); f > 0; --f, ++k, Z += sub->columns)
      for (int c = 0; c < sub->columns; ++c)
        h->z[coordinate[c]] += h->w[k] * Z[c];
  }
  for (int i = 0; i < h->tree_count; ++i)
    h->z[h->tree[i]] = h->w[k++];
  return sqrt(square);
}

/* Activates one limit against which the step moves a coordinate; false: none. */
static bool activate_limit(km_manipulation *h) {
  const km_mechanism *m = h->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (h->blocked[c] || fabs(h->z[c]) < km_relative_zero || (!isfinite(m->low[c]) && !isfinite(m->high[c])))
      continue;
    double q = h->state->q[c], slack = km_relative_zero * m->unit[c];
    if ((h->z[c] > 0.0 && q >= m->high[c] - slack) || (h->z[c] < 0.0 && q <= m->low[c] + slack)) {
      h->blocked[c] = true;
      h->blocking = c;
      if (m->substructure_of[c] >= 0) {
        km_state_lock(h->state, c);
        km_update_and_search_pivots(m, h->state, m->substructure_of[c], KM_NO_DRIVER, 0.0);
      }
      return true;
    }
  }
  return false;
}

/* Returns the part of the step up to the first limit. */
static double part_to_limits(const km_manipulation *h) {
  const km_mechanism *m = h->mechanism;
  double part = 1.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    double q = h->state->q[c], step = h->z[c] / m->scale[c];
    if (step > 0.0 && q <= m->high[c] && q + step > m->high[c])
      part = fmin(part, (m->high[c] - q) / step);
    if (step < 0.0 && q >= m->low[c] && q + step < m->low[c])
      part = fmin(part, (m->low[c] - q) / step);
  }
  return part;
}

/* Returns the rotation angle of a ball joint. */
static double rotation_angle(const double *q) {
  return km_vec3_norm(km_vec3_from_array(q));
}

/* True if a coordinate is further outside its limits than before; a ball joint is then reported as the obstacle. */
static bool exceeds_limits(km_manipulation *h) {
  const km_mechanism *m = h->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c) {
    double q = h->state->q[c], old = h->saved_q[c], slack = 1e-12 * (m->unit[c] + fabs(q));
    if ((q > m->high[c] + slack && q > old) || (q < m->low[c] - slack && q < old))
      return true;
  }
  for (int b = 0; b < m->ball_count; ++b) {
    int c = m->ball_coordinate[b];
    double angle = rotation_angle(h->state->q + c);
    if (angle > m->max_ball_angle[c] + 1e-12 && angle > rotation_angle(h->saved_q + c)) {
      h->blocking = c;
      return true;
    }
  }
  return false;
}

/* True if the step stays on its branch: small correction, same rank, and the step lies in the new tangent space. */
static bool stays_on_branch(km_manipulation *h, int index, double part, const km_closure *evidence) {
  const km_mechanism *m = h->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  double size = 0.0, projected = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    size += h->z[coordinate[k]] * h->z[coordinate[k]];
  if (evidence->correction > km_correction_ratio * part * sqrt(size) + km_relative_zero ||
      km_factor_rank(h->state->factor[index]) < h->rank[index])
    return false;
  km_numbers_update(m, h->state, index);
  const double *Z = km_state_basis(h->state, index);
  for (int f = km_factor_freedom(h->state->factor[index]); f > 0; --f, Z += sub->columns) {
    double dot = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      dot += Z[k] * h->z[coordinate[k]];
    projected += dot * dot;
  }
  return projected >= km_min_direction_cosine * km_min_direction_cosine * size;
}

/* Moves by a part of z and closes the loops; false if the step is rejected. */
static bool move_substructures(km_manipulation *h, double part) {
  const km_mechanism *m = h->mechanism;
  for (int i = 0; i < h->substructure_count_on_path; ++i) {
    const km_substructure *sub = &m->substructures[h->substructures[i]];
    const int *coordinate = m->column_coordinate + sub->column_start;
    double *step = h->A; /* reused as workspace */
    km_closure evidence;
    for (int k = 0; k < sub->columns; ++k)
      step[k] = part * h->z[coordinate[k]] / m->column_weight[sub->column_start + k];
    km_state_move(m, h->state, sub, step);
    if (km_loops_close(m, h->state, h->substructures[i], KM_NO_DRIVER, &evidence) != KM_CLOSED ||
        !stays_on_branch(h, h->substructures[i], part, &evidence))
      return false;
  }
  return true;
}

static void move_tree_joints(km_manipulation *h, double part) {
  const km_mechanism *m = h->mechanism;
  for (int i = 0; i < h->tree_count; ++i) {
    int c = h->tree[i];
    if (m->ball_of[c] < 0) {
      h->state->q[c] += part * h->z[c] / m->scale[c];
      continue;
    }
    km_state_rotate_ball(m, h->state, m->ball_of[c], km_vec3_scale(part, km_vec3_from_array(&h->z[c])));
    i += 2;
  }
}

/* Updates pivots, null spaces and Jacobians for the present configuration. */
static void update_state(km_manipulation *h) {
  for (int i = 0; i < h->mechanism->topology.substructure_count; ++i) {
    km_loops_update(h->mechanism, h->state, &h->mechanism->substructures[i]);
    km_state_invalidate_pivots(h->state, i);
    km_numbers_update(h->mechanism, h->state, i);
  }
  km_poses_compute(h->mechanism, h->state);
}

/* Leaves a branch point at the start of each substructure, and records the regular ranks. */
static km_status leave_branch_points(point_motion *p, km_error *error) {
  km_manipulation *h = p->h;
  bool is_initialised = true;
  for (int i = 0; i < h->substructure_count_on_path; ++i) {
    int index = h->substructures[i], best = -1;
    if (h->has_left_branch_point[index])
      continue;
    is_initialised = false;
    const km_substructure *sub = &h->mechanism->substructures[index];
    for (int k = 0; k < sub->columns; ++k) {
      int c = h->mechanism->column_coordinate[sub->column_start + k];
      if (best < 0 || km_vec3_norm(h->column[c]) > km_vec3_norm(h->column[best]))
        best = c;
    }
    int motions = best < 0 ? 0 : km_branch_depart(h->mechanism, h->state, best, 0.0).branch_count;
    if (motions < 0)
      return km_fail(error, KM_MEMORY, "out of memory for a hand");
    h->has_left_branch_point[index] = true;
  }
  if (is_initialised)
    return KM_OK;
  update_state(h);
  find_path(p);
  for (int i = 0; i < h->substructure_count_on_path; ++i) {
    int rank = km_factor_rank(h->state->factor[h->substructures[i]]);
    h->rank[h->substructures[i]] = rank > h->rank[h->substructures[i]] ? rank : h->rank[h->substructures[i]];
  }
  return KM_OK;
}

/* Takes a step of at most `most`; returns its length, 0 if none is possible. */
static double step(point_motion *p, double most) {
  km_manipulation *h = p->h;
  double has_left_branch_point = update_remaining(p), length;
  memset(h->blocked, 0, (size_t)h->mechanism->coordinate_count * sizeof *h->blocked);
  h->blocking = -1;
  find_path(p);
  for (int i = 0; i <= MAX_ACTIVE_LIMITS; ++i) {
    length = find_step(p);
    if (length < km_relative_zero || !activate_limit(h))
      break;
  }
  if (h->blocking >= 0) {
    km_state_unlock(h->state);
    update_state(h);
  }
  if (length < km_relative_zero)
    return 0.0;
  double part = fmin(fmin(1.0, most / length), part_to_limits(h));
  km_manipulation_save(h);
  for (int i = 0; i < MAX_HALVINGS && part * length > km_relative_zero; ++i, part *= 0.5) {
    bool closed = move_substructures(h, part);
    if (closed) {
      move_tree_joints(h, part);
      km_poses_compute(h->mechanism, h->state);
    }
    if (closed && !exceeds_limits(h) && update_remaining(p) < has_left_branch_point)
      return part * length;
    km_manipulation_restore(h);
  }
  update_state(h);
  return 0.0;
}

static km_status check(const km_manipulation *h, const km_manipulation_point *target_point, double most,
                       const km_manipulation_step *out, km_error *error) {
  km_status status = km_manipulation_check(h, most, out, error);
  if (!status)
    status = km_check_given(target_point != NULL, "grip", error);
  if (!status)
    status = km_check_index(target_point->body, h->mechanism->model->body_count, "body", error);
  for (int k = 0; k < 3 && !status; ++k)
    if (!isfinite(target_point->point[k]) || !isfinite(target_point->target[k]) || !isfinite(target_point->normal[k]))
      status = km_fail(error, KM_USAGE, "found a number that is not finite in a grip");
  return status;
}

km_status km_manipulation_pull_point(km_manipulation *h, const km_manipulation_point *target_point, double most,
                                     km_manipulation_step *out, km_error *error) {
  km_status status = check(h, target_point, most, out, error);
  if (status)
    return status;
  *out = (km_manipulation_step){.coordinate = -1};
  point_motion p = {.h = h, .target_point = target_point, .length = h->mechanism->length};
  km_driver_motion_free(h->drive);
  h->drive = NULL;
  h->driven = -1;
  find_path(&p);
  status = leave_branch_points(&p, error);
  if (status)
    return status;
  double has_left_branch_point = update_remaining(&p), remaining_length = most;
  for (int i = 0; i < MAX_STEPS && has_left_branch_point > km_relative_zero && remaining_length > km_relative_zero;
       ++i) {
    double length = step(&p, remaining_length);
    if (length <= 0.0) {
      out->stop = h->blocking >= 0 ? KM_MANIPULATION_LIMIT : KM_MANIPULATION_NEAREST;
      out->coordinate = h->blocking;
      break;
    }
    remaining_length -= length;
    has_left_branch_point = update_remaining(&p);
  }
  out->is_reached = has_left_branch_point <= km_relative_zero;
  out->remaining = has_left_branch_point * p.length;
  return KM_OK;
}
