/* Pulling a point of a body: a damped least step in the motions that loops and limits allow, then the loops are closed.
 *
 * In a basis Z of the allowed D q̇ the point moves by A w, w the rates along the basis; w = Aᵀ(A Aᵀ + ε)⁻¹ e. Coordinates
 * that stand at a limit and are pushed against it take their rows out of the basis. */
#include "manipulation/manipulation.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/bifurcation.h"
#include "mobility/mobility_numbers.h"

#include <string.h>

enum { MOST_STEPS = 4, MOST_HALVINGS = 14, MOST_BARRIERS = 12 };
static const double damping = 1e-4, least_damping = 1e-10; /* ε: far from the target, and at it */
static const double far = 0.01;                            /* of L */
static const double arrived = 1e-9;                        /* of L */
static const double bent = 0.3;                            /* of a step: more correction shows another branch */
static const double least_cosine = 0.8; /* of the step with the motions that are possible behind it */
static const double at_limit = 1e-9;    /* scaled: so near it stands at it */
static const double settled = 1e-10;    /* a step that is no more than this leads nowhere */

typedef struct pull {
  km_manipulation *h;
  const km_manipulation_point *grip;
  double length; /* L */
  double e[3];   /* what is left, over L; without the part along the normal */
  int freedoms;
} pull;

static km_vec3 place_of(const pull *p) {
  return km_pose_point(&p->h->state->pose[p->grip->body], km_vec3_from_array(p->grip->point));
}

/* What is left over L, and its length. */
static double look(pull *p) {
  km_vec3 e = km_vec3_scale(1.0 / p->length, km_vec3_sub(km_vec3_from_array(p->grip->target), place_of(p)));
  km_vec3 normal = km_vec3_from_array(p->grip->normal);
  e = km_vec3_axpy(-km_vec3_dot(e, normal), normal, e);
  memcpy(p->e, (const double[]){e.x, e.y, e.z}, sizeof p->e);
  return km_vec3_norm(e);
}

/* Which substructures and coordinates carry the body, and how each coordinate moves the point. */
static void find_ways(pull *p) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  km_vec3 at = place_of(p), normal = km_vec3_from_array(p->grip->normal);
  memset(h->column, 0, (size_t)m->coordinate_count * sizeof *h->column);
  memset(h->on_way, 0, (size_t)m->topology.substructure_count * sizeof *h->on_way);
  h->way_count = 0;
  for (int body = p->grip->body; body > 0; body = m->topology.parent[body]) {
    int joint = m->topology.arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      if (m->held[c])
        continue;
      km_twist t = km_coordinate_twist(m, h->state, c);
      km_vec3 v = km_vec3_add(t.v, km_vec3_cross(t.w, at));
      v = km_vec3_axpy(-km_vec3_dot(v, normal), normal, v);
      h->column[c] = km_vec3_scale((m->topology.is_reversed[joint] ? -1.0 : 1.0) / (p->length * m->scale[c]), v);
      int index = m->substructure_of[c];
      if (index >= 0 && !h->on_way[index]) {
        h->on_way[index] = true;
        h->ways[h->way_count++] = index;
      }
    }
  }
}

/* The coordinates outside loops on the way, and the basis vectors of a substructure: columns of A. */
static void add_column(pull *p, km_vec3 v) {
  memcpy(p->h->A + 3 * (size_t)p->freedoms++, (const double[]){v.x, v.y, v.z}, 3 * sizeof *p->h->A);
}

static bool is_free_tree(const km_manipulation *h, int body, int *first, int *end) {
  const km_mechanism *m = h->mechanism;
  int joint = m->topology.arc[body];
  *first = m->model->joints[joint].first_coordinate;
  *end = *first + km_model_freedom(m->model, joint);
  return *end > *first && m->substructure_of[*first] < 0;
}

static void take_column_out(const double *rows, int rank, int n, double *z) {
  for (int r = 0; r < rank; ++r) {
    double dot = 0.0;
    for (int k = 0; k < n; ++k)
      dot += rows[(size_t)r * (size_t)n + (size_t)k] * z[k];
    for (int k = 0; k < n; ++k)
      z[k] -= dot * rows[(size_t)r * (size_t)n + (size_t)k];
  }
}

/* The basis rows of blocked coordinates, orthonormal, of one substructure; returns how many. */
static int barriers(km_manipulation *h, int index, const double *Z, int freedom) {
  const km_substructure *sub = &h->mechanism->substructures[index];
  int count = 0;
  for (int k = 0; k < sub->columns && count < freedom; ++k) {
    if (!h->blocked[h->mechanism->column_coordinate[sub->column_start + k]])
      continue;
    if (!km_reserve((void **)&h->barrier, &h->barrier_room, (size_t)(count + 1) * (size_t)freedom, sizeof *h->barrier))
      return count;
    double *row = h->barrier + (size_t)count * (size_t)freedom, size = 0.0;
    for (int i = 0; i < freedom; ++i)
      row[i] = Z[(size_t)i * (size_t)sub->columns + (size_t)k];
    take_column_out(h->barrier, count, freedom, row);
    for (int i = 0; i < freedom; ++i)
      size += row[i] * row[i];
    if (size < 1e-20)
      continue;
    for (int i = 0; i < freedom; ++i)
      row[i] /= sqrt(size);
    ++count;
  }
  return count;
}

static void columns_of(pull *p, int index) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const double *Z = km_state_basis(h->state, index);
  int freedom = km_partition_freedom(&h->state->partition[index]), start = p->freedoms;
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int i = 0; i < freedom; ++i) {
    km_vec3 v = {0, 0, 0};
    for (int k = 0; k < sub->columns; ++k)
      v = km_vec3_axpy(Z[(size_t)i * (size_t)sub->columns + (size_t)k], h->column[coordinate[k]], v);
    add_column(p, v);
  }
  if (h->blocking < 0)
    return;
  int count = barriers(h, index, Z, freedom);
  for (int axis = 0; axis < 3 && count; ++axis) { /* the rows of A, over this basis */
    for (int i = 0; i < freedom; ++i)
      h->w[i] = h->A[3 * (size_t)(start + i) + (size_t)axis];
    take_column_out(h->barrier, count, freedom, h->w);
    for (int i = 0; i < freedom; ++i)
      h->A[3 * (size_t)(start + i) + (size_t)axis] = h->w[i];
  }
}

/* x of (A Aᵀ + ε) x = e, by Cholesky's way in three dimensions. */
static void solve(const pull *p, double x[3]) {
  double e = fmin(1.0, km_vec3_norm(km_vec3_from_array(p->e)) / far), epsilon = fmax(damping * e * e, least_damping);
  double G[3][3] = {{epsilon, 0, 0}, {0, epsilon, 0}, {0, 0, epsilon}}, y[3];
  for (int k = 0; k < p->freedoms; ++k)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        G[i][j] += p->h->A[3 * k + i] * p->h->A[3 * k + j];
  for (int j = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i) {
      double sum = G[i][j];
      for (int k = 0; k < j; ++k)
        sum -= G[i][k] * G[j][k];
      G[i][j] = i == j ? sqrt(fmax(sum, 1e-30)) : sum / G[j][j];
    }
  for (int i = 0; i < 3; ++i) {
    y[i] = p->e[i];
    for (int k = 0; k < i; ++k)
      y[i] -= G[i][k] * y[k];
    y[i] /= G[i][i];
  }
  for (int i = 2; i >= 0; --i) {
    x[i] = y[i];
    for (int k = i + 1; k < 3; ++k)
      x[i] -= G[k][i] * x[k];
    x[i] /= G[i][i];
  }
}

/* Fills A, then z; returns |z|. */
static double find_step(pull *p) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  double x[3], square = 0.0;
  int first, end, k = 0;
  p->freedoms = 0;
  for (int i = 0; i < h->way_count; ++i)
    columns_of(p, h->ways[i]);
  for (int body = p->grip->body; body > 0; body = m->topology.parent[body])
    for (bool tree = is_free_tree(h, body, &first, &end); tree && first < end; ++first)
      if (!m->held[first])
        add_column(p, h->blocked[first] ? (km_vec3){0, 0, 0} : h->column[first]);
  solve(p, x);
  memset(h->z, 0, (size_t)m->coordinate_count * sizeof *h->z);
  for (int i = 0; i < p->freedoms; ++i) {
    h->w[i] = h->A[3 * i] * x[0] + h->A[3 * i + 1] * x[1] + h->A[3 * i + 2] * x[2];
    square += h->w[i] * h->w[i];
  }
  for (int i = 0; i < h->way_count; ++i) {
    const km_substructure *sub = &m->substructures[h->ways[i]];
    const double *Z = km_state_basis(h->state, h->ways[i]);
    const int *coordinate = m->column_coordinate + sub->column_start;
    for (int f = km_partition_freedom(&h->state->partition[h->ways[i]]); f > 0; --f, ++k, Z += sub->columns)
      for (int c = 0; c < sub->columns; ++c)
        h->z[coordinate[c]] += h->w[k] * Z[c];
  }
  for (int body = p->grip->body; body > 0; body = m->topology.parent[body])
    for (bool tree = is_free_tree(h, body, &first, &end); tree && first < end; ++first)
      if (!m->held[first])
        h->z[first] = h->w[k++];
  return sqrt(square);
}

/* Does the step push a coordinate that stands at its limit against it? Marks one more; false: none. */
static bool meet_barrier(km_manipulation *h) {
  const km_mechanism *m = h->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (h->blocked[c] || fabs(h->z[c]) < settled || (!isfinite(m->low[c]) && !isfinite(m->high[c])))
      continue;
    double q = h->state->q[c], slack = at_limit * m->unit[c];
    if ((h->z[c] > 0.0 && q >= m->high[c] - slack) || (h->z[c] < 0.0 && q <= m->low[c] + slack)) {
      h->blocked[c] = true;
      h->blocking = c;
      return true;
    }
  }
  return false;
}

/* The part of the step up to the first limit in a straight line; the coordinate, -1: none. */
static double room_to_limits(const km_manipulation *h) {
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

/* A ball's angle is limited as a whole: how far it is turned. */
static double turned(const double *q) {
  return km_vec3_norm(km_vec3_from_array(q));
}

/* Is a coordinate further outside its limits than before? Then it is the one that blocks; a ball only stops the hand. */
static bool leaves_limits(km_manipulation *h) {
  const km_mechanism *m = h->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c) {
    double q = h->state->q[c], old = h->saved_q[c], slack = 1e-12 * (m->unit[c] + fabs(q));
    if ((q > m->high[c] + slack && q > old) || (q < m->low[c] - slack && q < old))
      return true;
  }
  for (int b = 0; b < m->ball_count; ++b) {
    int c = m->ball_coordinate[b];
    double angle = turned(h->state->q + c);
    if (angle > m->max_ball_angle[c] + 1e-12 && angle > turned(h->saved_q + c)) {
      h->blocking = c;
      return true;
    }
  }
  return false;
}

/* The motions behind the step still hold it: no other branch, no singular pose. */
static bool holds_course(km_manipulation *h, int index, double part, const km_closure *evidence) {
  const km_mechanism *m = h->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  double size = 0.0, kept = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    size += h->z[coordinate[k]] * h->z[coordinate[k]];
  if (evidence->correction > bent * part * sqrt(size) + 1e-9 || h->state->partition[index].rank < h->rank[index])
    return false;
  km_numbers_update(m, h->state, index);
  const double *Z = km_state_basis(h->state, index);
  for (int f = km_partition_freedom(&h->state->partition[index]); f > 0; --f, Z += sub->columns) {
    double dot = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      dot += Z[k] * h->z[coordinate[k]];
    kept += dot * dot;
  }
  return kept >= least_cosine * least_cosine * size;
}

/* Goes by a part of z and closes the loops; false: not this far. */
static bool go(km_manipulation *h, double part) {
  const km_mechanism *m = h->mechanism;
  for (int i = 0; i < h->way_count; ++i) {
    const km_substructure *sub = &m->substructures[h->ways[i]];
    const int *coordinate = m->column_coordinate + sub->column_start;
    double *step = h->A; /* of find_step, which is done with it */
    km_closure evidence;
    for (int k = 0; k < sub->columns; ++k)
      step[k] = part * h->z[coordinate[k]] / m->column_weight[sub->column_start + k];
    km_state_move(m, h->state, sub, step);
    if (km_loops_close(m, h->state, h->ways[i], KM_NO_DRIVER, &evidence) != KM_CLOSED ||
        !holds_course(h, h->ways[i], part, &evidence))
      return false;
  }
  return true;
}

static void go_tree(const pull *p, double part) {
  km_manipulation *h = p->h;
  const km_mechanism *m = h->mechanism;
  int first, end;
  for (int body = p->grip->body; body > 0; body = m->topology.parent[body])
    for (bool tree = is_free_tree(h, body, &first, &end); tree && first < end; ++first) {
      if (m->held[first])
        continue;
      if (m->ball_of[first] < 0) {
        h->state->q[first] += part * h->z[first] / m->scale[first];
        continue;
      }
      km_state_rotate_ball(m, h->state, m->ball_of[first], km_vec3_scale(part, km_vec3_from_array(&h->z[first])));
      first += 2;
    }
}

/* Makes pivots, null spaces and Jacobians those of the present pose. */
static void renew(km_manipulation *h) {
  for (int i = 0; i < h->way_count; ++i) {
    km_loops_update(h->mechanism, h->state, &h->mechanism->substructures[h->ways[i]]);
    km_state_invalidate_pivots(h->state, h->ways[i]);
    km_numbers_update(h->mechanism, h->state, h->ways[i]);
  }
  km_poses_compute(h->mechanism, h->state);
}

/* At a branch point no direction is the mechanism's own; off it, ranks are what they are elsewhere. */
static km_status begin(pull *p, km_error *error) {
  km_manipulation *h = p->h;
  bool fresh = true;
  for (int i = 0; i < h->way_count; ++i) {
    int index = h->ways[i], best = -1;
    if (h->left[index])
      continue;
    fresh = false;
    const km_substructure *sub = &h->mechanism->substructures[index];
    for (int k = 0; k < sub->columns; ++k) {
      int c = h->mechanism->column_coordinate[sub->column_start + k];
      if (best < 0 || km_vec3_norm(h->column[c]) > km_vec3_norm(h->column[best]))
        best = c;
    }
    int motions = best < 0 ? 0 : km_branch_depart(h->mechanism, h->state, best, 0.0).branch_count;
    if (motions < 0)
      return km_fail(error, KM_MEMORY, "out of memory for a hand");
    h->left[index] = true;
  }
  if (fresh)
    return KM_OK;
  renew(h);
  find_ways(p);
  for (int i = 0; i < h->way_count; ++i) {
    int rank = h->state->partition[h->ways[i]].rank;
    h->rank[h->ways[i]] = rank > h->rank[h->ways[i]] ? rank : h->rank[h->ways[i]];
  }
  return KM_OK;
}

/* A step of at most `most`; returns its length, 0 where none is possible. */
static double step(pull *p, double most) {
  km_manipulation *h = p->h;
  double left = look(p), length;
  memset(h->blocked, 0, (size_t)h->mechanism->coordinate_count * sizeof *h->blocked);
  h->blocking = -1;
  find_ways(p);
  for (int i = 0; i <= MOST_BARRIERS; ++i) {
    length = find_step(p);
    if (length < settled || !meet_barrier(h))
      break;
  }
  if (length < settled)
    return 0.0;
  double part = fmin(fmin(1.0, most / length), room_to_limits(h));
  km_manipulation_save(h);
  for (int i = 0; i < MOST_HALVINGS && part * length > settled; ++i, part *= 0.5) {
    bool closed = go(h, part);
    if (closed) {
      go_tree(p, part);
      km_poses_compute(h->mechanism, h->state);
    }
    if (closed && !leaves_limits(h) && look(p) < left)
      return part * length;
    km_manipulation_restore(h);
  }
  renew(h);
  return 0.0;
}

static km_status check(const km_manipulation *h, const km_manipulation_point *grip, double most,
                       const km_manipulation_step *out, km_error *error) {
  km_status status = km_check_given(h != NULL, "hand", error);
  if (!status)
    status = km_check_given(grip != NULL, "grip", error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  if (!status)
    status = km_check_index(grip->body, h->mechanism->model->body_count, "body", error);
  if (!status && !(most > 0.0))
    return km_fail(error, KM_USAGE, "found a way of %g; expected more than 0", most);
  for (int k = 0; k < 3 && !status; ++k)
    if (!isfinite(grip->point[k]) || !isfinite(grip->target[k]) || !isfinite(grip->normal[k]))
      status = km_fail(error, KM_USAGE, "found a number that is not finite in a grip");
  return status;
}

km_status km_manipulation_pull_point(km_manipulation *h, const km_manipulation_point *grip, double most,
                                     km_manipulation_step *out, km_error *error) {
  km_status status = check(h, grip, most, out, error);
  if (status)
    return status;
  *out = (km_manipulation_step){.coordinate = -1};
  pull p = {.h = h, .grip = grip, .length = h->mechanism->length};
  km_driver_motion_free(h->drive);
  h->drive = NULL;
  h->driven = -1;
  find_ways(&p);
  status = begin(&p, error);
  if (status)
    return status;
  double left = look(&p), gone = most;
  for (int i = 0; i < MOST_STEPS && left > arrived && gone > settled; ++i) {
    double length = step(&p, gone);
    if (length <= 0.0) {
      out->stop = h->blocking >= 0 ? KM_MANIPULATION_LIMIT : KM_MANIPULATION_NEAREST;
      out->coordinate = h->blocking;
      break;
    }
    gone -= length;
    left = look(&p);
  }
  out->there = left <= arrived;
  out->left = left * p.length;
  return KM_OK;
}
