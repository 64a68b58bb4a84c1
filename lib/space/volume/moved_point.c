/* Closed configurations of a mechanism as a point of it is moved (space/volume/moved_point.h). */
#include "space/volume/moved_point.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "kinematics/assembly.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/mobility_numbers.h"
#include "space/real_solve.h"
#include "topology/chain.h"

#include <string.h>

enum {
  MOST_STEPS = 100,
  MOST_TARGETS = 1000, /* five times those that end a workspace without end */
  MOST_RETURNS = 20,
  STEP_RETURNS = 3,
  RANDOM_STEPS = 12 /* half a turn in all */
};
static const double reached = 1e-9;        /* distance over L of a point that is there */
static const double longest_step = 0.3;    /* radians; lengths over the larger of L and the stroke */
static const double least_decrease = 1e-6; /* share of |d|² that a step may still promise where the point is blocked */
static const double largest_damping = 1e8; /* μ: steps of at most |A|/μ are rejected by rounding only */
static const double target_distance = 0.5; /* the next target of an extremum is so far, over the travel */
static const double endless = 100.0;       /* distance over the travel */
static const double kept_decrease = 1e-4;  /* least share of the promised decrease (L. Armijo 1966) */
static const double rank_share = 1e-6;     /* smaller singular values of A over the largest are those of a rank */
static const double least_advance = 1e-6;  /* advance over the travel that is none: an extremum is reached */
static const double least_share = 1e-6;    /* shorter parts of a random step end at a bound */

/* ---- Preparation. */

static void add_part(km_moved_point *p, int substructure) {
  for (int i = 0; i < p->part_count; ++i)
    if (p->part[i] == substructure)
      return;
  p->part[p->part_count++] = substructure;
}

/* Lists the parts, and the joints of none, on the way to the body. */
static void find_columns(km_moved_point *p) {
  const km_mechanism *m = p->m;
  int trees = 0, *tree = p->coordinate + m->coordinate_count;
  for (int body = m->model->frames[p->frame].body; body > 0; body = m->topology.parent[body]) {
    int joint = m->topology.arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      if (m->held[c])
        continue;
      if (m->substructure_of[c] >= 0)
        add_part(p, m->substructure_of[c]);
      else
        tree[trees++] = c;
    }
  }
  for (int i = 0; i < p->part_count; ++i) {
    const km_substructure *sub = &m->substructures[p->part[i]];
    memcpy(p->coordinate + p->columns, m->column_coordinate + sub->column_start,
           (size_t)sub->columns * sizeof *p->coordinate);
    p->columns += sub->columns;
  }
  p->tree_start = p->columns;
  memcpy(p->coordinate + p->columns, tree, (size_t)trees * sizeof *tree);
  p->columns += trees;
}

/* Travel of a slide or screw between its limits, model's unit; infinite without limits that count; 0: neither. */
static double stroke_of(const km_moved_point *p, int c) {
  const km_mechanism *m = p->m;
  const km_model_coordinate *coordinate = &m->model->coordinates[c];
  double range = p->keeps_limits ? m->high[c] - m->low[c] : HUGE_VAL;
  if (km_model_coordinate_is_length(m->model, c))
    return range;
  return m->model->joints[coordinate->joint].type == KM_SCREW
             ? range * fabs(km_pitch_per_radian(m->model, coordinate->joint, 1.0))
             : 0.0;
}

/* Finds the travel, and the longest change of each column in a step. */
static void find_travel(km_moved_point *p) {
  p->travel = p->m->length;
  p->is_bounded = true;
  for (int k = 0; k < p->columns; ++k) {
    int c = p->coordinate[k];
    double stroke = stroke_of(p, c);
    p->is_bounded = p->is_bounded && isfinite(stroke);
    p->travel += isfinite(stroke) ? stroke : 0.0;
    p->longest[k] = longest_step;
    if (km_model_coordinate_is_length(p->m->model, c) && isfinite(stroke))
      p->longest[k] *= fmax(1.0, stroke * p->m->scale[c]);
  }
}

km_status km_moved_point_create(km_moved_point *p, km_arena *arena, km_error *error) {
  size_t all = (size_t)p->m->coordinate_count;
  p->part = KM_ARENA_NEW(arena, int, (size_t)p->m->topology.substructure_count + 1);
  p->rank = KM_ARENA_NEW(arena, int, (size_t)p->m->topology.substructure_count + 1);
  p->coordinate = KM_ARENA_NEW(arena, int, 2 * all + 1);
  if (!arena->failed)
    find_columns(p);
  size_t n = (size_t)p->columns + 1;
  p->saved_size = all + 4 * (size_t)p->m->ball_count + 1;
  p->Z = KM_ARENA_NEW(arena, double, n *n);
  p->z = KM_ARENA_NEW(arena, double, n);
  p->longest = KM_ARENA_NEW(arena, double, n);
  p->move = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  p->jacobian = KM_ARENA_NEW(arena, double, 6 * all + 1);
  p->before = KM_ARENA_NEW(arena, double, p->saved_size);
  if (!arena->failed)
    find_travel(p);
  bool is_ok = km_kept_clearance_create(&p->kept, p->m, arena) &&
               km_bounded_step_create(&p->step, (int)n, 2 * (int)n + km_kept_clearance_count(&p->kept), arena);
  return is_ok && !arena->failed ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the workspace");
}

void km_moved_point_save(const km_moved_point *p, double *saved) {
  size_t all = (size_t)p->m->coordinate_count;
  memcpy(saved, p->s->q, all * sizeof *saved);
  for (int b = 0; b < p->m->ball_count; ++b)
    memcpy(saved + all + 4 * b, &p->s->ball[b], 4 * sizeof *saved);
}

/* Restores a configuration, and leaves the pivots. */
static void go_back(km_moved_point *p, const double *saved) {
  size_t all = (size_t)p->m->coordinate_count;
  memcpy(p->s->q, saved, all * sizeof *saved);
  for (int b = 0; b < p->m->ball_count; ++b)
    memcpy(&p->s->ball[b], saved + all + 4 * b, 4 * sizeof *saved);
}

void km_moved_point_restore(km_moved_point *p, const double *saved) {
  go_back(p, saved);
  for (int i = 0; i < p->part_count; ++i)
    km_state_invalidate_pivots(p->s, p->part[i]);
}

/* ---- The point and its motions at the state's closed configuration. */

/* Copies the bases of the parts to Z, and adds the joints of none. False when out of memory. */
static bool update_basis(km_moved_point *p) {
  int start = 0;
  p->freedoms = 0;
  for (int i = 0; i < p->part_count; ++i) {
    const km_substructure *sub = &p->m->substructures[p->part[i]];
    km_motions_update(p->m, p->s, p->part[i]);
    const double *basis = km_state_basis(p->s, p->part[i]);
    if (!basis && km_factor_has_failed(p->s->factor[p->part[i]]))
      return false;
    for (int k = 0; k < km_factor_freedom(p->s->factor[p->part[i]]); ++k) {
      double *row = p->Z + (size_t)(p->freedoms++ * p->columns);
      memset(row, 0, (size_t)p->columns * sizeof *row);
      memcpy(row + start, basis + (size_t)k * (size_t)sub->columns, (size_t)sub->columns * sizeof *row);
    }
    start += sub->columns;
  }
  for (int k = p->tree_start; k < p->columns; ++k) {
    double *row = p->Z + (size_t)(p->freedoms++ * p->columns);
    memset(row, 0, (size_t)p->columns * sizeof *row);
    row[k] = 1.0;
  }
  return true;
}

static void update_place(km_moved_point *p) {
  double at[3];
  km_poses_compute(p->m, p->s);
  km_frame_position(p->m, p->s, p->frame, at);
  for (int i = 0; i < p->dimension; ++i)
    p->x[i] = km_vec3_dot(p->axis[i], km_vec3_from_array(at));
}

/* A: velocities of the point over L for each row of Z. */
static void update_point_rows(km_moved_point *p) {
  km_bounded_step *step = &p->step;
  km_frame_jacobian(p->m, p->s, p->frame, p->jacobian, NULL);
  step->rows = p->dimension;
  step->columns = p->freedoms;
  for (int f = 0; f < p->freedoms; ++f) {
    km_vec3 v = {0.0, 0.0, 0.0};
    for (int k = 0; k < p->columns; ++k) {
      int c = p->coordinate[k];
      double share = p->Z[f * p->columns + k] / (p->m->length * p->m->scale[c]);
      v = km_vec3_axpy(share, km_vec3_from_array(p->jacobian + 6 * c), v);
    }
    for (int i = 0; i < p->dimension; ++i)
      step->A[f * p->dimension + i] = km_vec3_dot(p->axis[i], v);
  }
}

static bool update(km_moved_point *p) {
  if (!update_basis(p))
    return false;
  update_place(p);
  update_point_rows(p);
  return true;
}

int km_moved_point_rank(km_moved_point *p) {
  int rank = 0;
  double largest = 0.0;
  for (int i = 1; i <= p->dimension && i <= p->freedoms; ++i) {
    for (int f = 0; f < p->freedoms; ++f)
      for (int r = 0; r < p->dimension; ++r)
        p->step.matrix[r * p->freedoms + f] = p->step.A[f * p->dimension + r];
    double sigma = km_singular_value(p->step.matrix, p->freedoms, p->dimension, i);
    largest = fmax(largest, sigma);
    rank += sigma > rank_share * largest;
  }
  return rank;
}

/* ---- Bounds. */

/* Adds the row `sense` · (change of a coordinate, or of a ball joint's angle) <= slack. */
static void add_limit(km_moved_point *p, int k, double sense, double slack) {
  km_bounded_step *step = &p->step;
  double *row = step->bound + step->bound_count * step->most_columns;
  int c = p->coordinate[k], ball = p->m->ball_of[c];
  const double *q = p->s->q + c;
  double angle = ball < 0 ? 0.0 : km_norm(q, 3);
  for (int f = 0; f < p->freedoms; ++f) {
    const double *Z = p->Z + f * p->columns + k;
    double change = ball < 0 ? Z[0] / p->m->scale[c] : angle > 0.0 ? km_dot(q, Z, 3) / angle : 0.0;
    row[f] = sense * change * p->m->scale[c];
  }
  step->slack[step->bound_count++] = slack * p->m->scale[c];
}

/* Limits that a step can exceed. */
static void add_limits(km_moved_point *p, int k) {
  int c = p->coordinate[k], ball = p->m->ball_of[c];
  double q = p->s->q[c], sense = 1.0, near = 1.01 * p->longest[k] / p->m->scale[c];
  if (ball >= 0) {
    double room = p->m->max_ball_angle[c] - km_norm(p->s->q + c, 3);
    if (c == p->m->ball_coordinate[ball] && room < near)
      add_limit(p, k, 1.0, room);
    return;
  }
  if (p->m->model->coordinates[c].is_strut && q < 0.0) /* the limits are those of its length */
    sense = -1.0;
  if (p->m->high[c] - sense * q < near)
    add_limit(p, k, sense, p->m->high[c] - sense * q);
  if (sense * q - p->m->low[c] < near)
    add_limit(p, k, -sense, sense * q - p->m->low[c]);
}

/* Adds the row −∂(distance)/∂w <= excess, over L. */
static void add_clearance(km_moved_point *p, int pair) {
  km_bounded_step *step = &p->step;
  double excess = km_kept_clearance_excess(&p->kept, pair) / p->m->length;
  if (!(excess < longest_step * p->travel / p->m->length))
    return;
  double *row = step->bound + step->bound_count * step->most_columns;
  km_clearance_gradient(p->kept.clearance, p->s, pair, &p->kept.pairs[pair], p->kept.gradient, NULL);
  for (int f = 0; f < p->freedoms; ++f) {
    row[f] = 0.0;
    for (int k = 0; k < p->columns; ++k) {
      int c = p->coordinate[k];
      row[f] -= p->kept.gradient[c] * p->Z[f * p->columns + k] / (p->m->length * p->m->scale[c]);
    }
  }
  step->slack[step->bound_count++] = excess;
}

static void update_bounds(km_moved_point *p) {
  p->step.bound_count = 0;
  for (int k = 0; p->keeps_limits && k < p->columns; ++k)
    add_limits(p, k);
  km_kept_clearance_update(&p->kept, p->m, p->s);
  for (int i = 0; i < km_kept_clearance_count(&p->kept); ++i)
    add_clearance(p, i);
}

/* Largest excess over a bound; 0: none. After km_poses_compute. */
static double excess(km_moved_point *p) {
  double most = 0.0;
  for (int k = 0; p->keeps_limits && k < p->columns; ++k)
    most = fmax(most, fabs(km_state_excess(p->s, p->coordinate[k])) * p->m->scale[p->coordinate[k]]);
  km_kept_clearance_update(&p->kept, p->m, p->s);
  return fmax(most, -km_kept_clearance_least(&p->kept, -1) / p->m->length);
}

/* Closes the loops of all parts, whose ranks steps then keep. */
static bool close_loops(km_moved_point *p) {
  km_closure evidence;
  for (int i = 0; i < p->part_count; ++i) {
    km_loops_update(p->m, p->s, &p->m->substructures[p->part[i]]);
    if (km_loops_close(p->m, p->s, p->part[i], KM_NO_DRIVER, &evidence) != KM_CLOSED)
      return false;
    p->rank[i] = km_factor_rank(p->s->factor[p->part[i]]);
  }
  return update(p);
}

bool km_moved_point_begin(km_moved_point *p) {
  return close_loops(p) && !(excess(p) > 0.0);
}

/* ---- Steps. */

/* D dq of the step w; returns its length. */
static double compute_step(km_moved_point *p, double part) {
  for (int k = 0; k < p->columns; ++k) {
    p->z[k] = 0.0;
    for (int f = 0; f < p->freedoms; ++f)
      p->z[k] += part * p->step.w[f] * p->Z[f * p->columns + k];
  }
  return km_norm(p->z, p->columns);
}

/* Moves a part by z and closes its loops. False if the correction is long or the rank lower: another branch is near. */
static bool move_part(km_moved_point *p, int i, int start, double length) {
  const km_substructure *sub = &p->m->substructures[p->part[i]];
  km_closure evidence;
  for (int k = 0; k < sub->columns; ++k)
    p->move[k] = p->z[start + k] / p->m->column_weight[sub->column_start + k];
  km_state_move(p->m, p->s, sub, p->move);
  return km_loops_close(p->m, p->s, p->part[i], KM_NO_DRIVER, &evidence) == KM_CLOSED &&
         evidence.correction <= km_correction_ratio * length + km_relative_zero &&
         km_factor_rank(p->s->factor[p->part[i]]) >= p->rank[i];
}

static void move_trees(km_moved_point *p) {
  for (int k = p->tree_start; k < p->columns; ++k) {
    int c = p->coordinate[k];
    if (p->m->ball_of[c] < 0) {
      p->s->q[c] += p->z[k] / p->m->scale[c];
    } else {
      km_state_rotate_ball(p->m, p->s, p->m->ball_of[c], km_vec3_from_array(p->z + k));
      k += 2;
    }
  }
}

/* Moves by z, of this length. False if a part isn't closed. */
static bool advance(km_moved_point *p, double length) {
  for (int i = 0, start = 0; i < p->part_count; ++i) {
    if (!move_part(p, i, start, length))
      return false;
    start += p->m->substructures[p->part[i]].columns;
  }
  move_trees(p);
  update_place(p);
  return true;
}

/* Length of a step over the longest one. */
static double step_share(km_moved_point *p) {
  double square = 0.0;
  compute_step(p, 1.0);
  for (int k = 0; k < p->columns; ++k)
    square += p->z[k] * p->z[k] / (p->longest[k] * p->longest[k]);
  return sqrt(square);
}

/* The part of a step that is taken: its length is limited. */
static double taken_part(km_moved_point *p) {
  return 1.0 / fmax(step_share(p), 1.0);
}

/* Moves back within the bounds by `most` minimum-norm steps. False: a bound is still exceeded. */
static bool return_to_bounds(km_moved_point *p, int most) {
  static const double rest[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < most && excess(p) > 0.0; ++i) {
    if (!update(p))
      return false;
    update_bounds(p);
    if (!km_bounded_step_find(&p->step, rest, 1.0) || !advance(p, compute_step(p, taken_part(p))))
      return false;
  }
  return !(excess(p) > 0.0);
}

bool km_moved_point_return(km_moved_point *p) {
  return close_loops(p) && return_to_bounds(p, MOST_RETURNS) && update(p);
}

/* Returns to the saved configuration `before`. */
static void step_back(km_moved_point *p) {
  km_moved_point_restore(p, p->before);
  km_moved_point_begin(p);
}

/* Moves by z, of this length, from the saved configuration `before`; closing the loops moves coordinates beyond their
 * bounds by the square of it, from where they return. False, and back there, if that fails. */
static bool take_step(km_moved_point *p, double length) {
  bool is_ok = advance(p, length) && return_to_bounds(p, STEP_RETURNS);
  if (!is_ok)
    step_back(p);
  return is_ok;
}

/* Displacement to the target over L; returns its length. */
static double displacement(const km_moved_point *p, const double *target, double *d) {
  for (int i = 0; i < p->dimension; ++i)
    d[i] = (target[i] - p->x[i]) / p->m->length;
  return km_norm(d, p->dimension);
}

/* Takes the step w if the point comes nearer by enough; *mu follows. */
static bool approach(km_moved_point *p, const double *target, double part, double promised, double *mu) {
  double d[3], before = displacement(p, target, d);
  bool is_taken = take_step(p, compute_step(p, part));
  double after = displacement(p, target, d), taken = before * before - after * after;
  if (is_taken && !(taken > kept_decrease * promised)) {
    step_back(p);
    is_taken = false;
  }
  *mu *= !is_taken ? 4.0 : taken > 0.75 * promised ? 1.0 / 3.0 : taken < 0.25 * promised ? 2.0 : 1.0;
  return is_taken;
}

km_point_end km_moved_point_move_to(km_moved_point *p, const double *target) {
  double d[3], mu = 1.0;
  for (int i = 0; i < MOST_STEPS && mu < largest_damping; ++i) {
    double distance = displacement(p, target, d);
    if (distance <= reached)
      return KM_POINT_REACHED;
    update_bounds(p);
    km_moved_point_save(p, p->before);
    if (!km_bounded_step_find(&p->step, d, mu * distance))
      return KM_POINT_UNSETTLED;
    double part = taken_part(p), promised = km_bounded_step_decrease(&p->step, d) * part;
    if (promised * fmax(mu, 1.0) <= least_decrease * distance * distance)
      return KM_POINT_BLOCKED;
    if (approach(p, target, part, promised, &mu) && !update(p))
      return KM_POINT_UNSETTLED;
  }
  return KM_POINT_UNSETTLED;
}

bool km_moved_point_find_extremum(km_moved_point *p, int axis, double sense) {
  double target[3], start = p->x[axis], most = p->is_bounded ? HUGE_VAL : endless * p->travel;
  for (int i = 0; i < MOST_TARGETS; ++i) {
    double before = p->x[axis];
    memcpy(target, p->x, sizeof target);
    target[axis] += sense * target_distance * p->travel;
    km_point_end end = km_moved_point_move_to(p, target);
    if (end == KM_POINT_UNSETTLED)
      return true;
    if (end == KM_POINT_BLOCKED && !(sense * (p->x[axis] - before) > least_advance * p->travel))
      return true;
    if (!(fabs(p->x[axis] - start) < most))
      return false;
  }
  return true;
}

void km_moved_point_move_at_random(km_moved_point *p, uint64_t *random) {
  for (int f = 0; f < p->freedoms; ++f)
    p->step.w[f] = km_splitmix(random, -1.0, 1.0);
  for (int i = 0; i < RANDOM_STEPS; ++i) {
    double share = step_share(p);
    if (!(share > least_share))
      return;
    km_moved_point_save(p, p->before);
    if (!take_step(p, compute_step(p, 1.0 / share)) || !update(p))
      return;
    for (int f = 0; f < p->freedoms; ++f) /* the direction, carried on */
      p->step.w[f] = km_dot(p->Z + f * p->columns, p->z, p->columns);
  }
}

/* ---- Random starts. */

/* Turns hinges by full turns into their limits. */
static void turn_into_limits(km_moved_point *p) {
  for (int k = 0; k < p->columns; ++k) {
    int c = p->coordinate[k];
    if (km_coordinate_turns(p->m, c) && isfinite(p->m->low[c]) && isfinite(p->m->high[c]))
      p->s->q[c] -= 2.0 * M_PI * round((p->s->q[c] - 0.5 * (p->m->low[c] + p->m->high[c])) / (2.0 * M_PI));
  }
}

/* Random values of all columns: within limits, else hinges over a full turn, slides ± the size, balls anywhere. */
static void randomise(km_moved_point *p, uint64_t *random) {
  for (int k = 0; k < p->columns; ++k) {
    int c = p->coordinate[k];
    double u = km_splitmix(random, -1.0, 1.0), low = p->m->low[c], high = p->m->high[c];
    if (p->keeps_limits && isfinite(low) && isfinite(high))
      p->z[k] = (0.5 * (low + high) + 0.5 * u * (high - low) - p->s->q[c]) * p->m->scale[c];
    else
      p->z[k] = u * (km_model_coordinate_is_length(p->m->model, c) ? 1.0 : M_PI);
  }
}

km_status km_moved_point_assemble(km_moved_point *p, uint64_t *random, bool *is_closed) {
  randomise(p, random);
  *is_closed = true;
  for (int i = 0, start = 0; *is_closed && i < p->part_count; ++i) {
    const km_substructure *sub = &p->m->substructures[p->part[i]];
    for (int k = 0; k < sub->columns; ++k)
      p->move[k] = p->z[start + k] / p->m->column_weight[sub->column_start + k];
    km_state_move(p->m, p->s, sub, p->move);
    km_state_invalidate_pivots(p->s, p->part[i]);
    if (km_assemble_one(p->m, p->s, p->part[i], p->move, is_closed) == KM_MEMORY)
      return KM_MEMORY;
    start += sub->columns;
  }
  if (!*is_closed)
    return KM_OK;
  move_trees(p);
  if (p->keeps_limits)
    turn_into_limits(p);
  *is_closed = km_moved_point_return(p);
  return KM_OK;
}
