/* State of one thread: allocation, coordinates, cached null spaces, locked coordinates, saved configurations. */
#include "kinematics/state.h"

#include "base/arguments.h"

#include <string.h>

/* Creates the dense or sparse factor of a substructure's Jacobian. */
static km_factor *create_factor(const km_mechanism *m, const km_substructure *sub, km_arena *arena) {
  const double *weight = m->column_weight + sub->column_start;
  const km_pattern *pattern = &sub->pattern;
  return pattern->start ? km_factor_create_sparse(sub->rows, sub->columns, pattern->start, pattern->row, weight, arena)
                        : km_factor_create(sub->rows, sub->columns, weight, arena);
}

/* Allocates all arrays of a state in its arena. */
static bool allocate_arrays(const km_mechanism *m, km_state *s) {
  km_arena *arena = &s->arena;
  const km_topology *t = &m->topology;
  size_t coordinates = (size_t)m->coordinate_count;
  size_t columns = (size_t)m->largest_columns;
  s->q = KM_ARENA_NEW(arena, double, coordinates);
  s->rate = KM_ARENA_NEW(arena, double, coordinates);
  s->rate_source = KM_ARENA_NEW(arena, km_rate_source, coordinates);
  s->acceleration = KM_ARENA_NEW(arena, double, coordinates);
  s->ball = KM_ARENA_NEW(arena, km_quaternion, (size_t)m->ball_count);
  s->jacobian = KM_ARENA_NEW(arena, double, m->matrix_size);
  s->error = KM_ARENA_NEW(arena, double, (size_t)m->error_size);
  s->misfit = KM_ARENA_NEW(arena, km_twist, (size_t)t->loop_count);
  s->factor = KM_ARENA_NEW(arena, km_factor *, (size_t)t->substructure_count);
  s->normal = KM_ARENA_NEW(arena, km_normal_equations *, (size_t)t->substructure_count);
  s->normal_count = t->substructure_count;
  s->cached = KM_ARENA_NEW(arena, km_cached_configuration, (size_t)t->substructure_count);
  s->pivot_driver = KM_ARENA_NEW(arena, int, (size_t)t->substructure_count);
  s->mobility_is_known = KM_ARENA_NEW(arena, bool, (size_t)t->substructure_count);
  s->mobility_number = KM_ARENA_NEW(arena, double, coordinates);
  s->pose = KM_ARENA_NEW(arena, km_pose, (size_t)t->body_count);
  s->slot = KM_ARENA_NEW(arena, km_pose, (size_t)m->largest_slots);
  s->planar_slot = KM_ARENA_NEW(arena, km_planar_pose, (size_t)m->largest_slots);
  s->twist = KM_ARENA_NEW(arena, km_twist, (size_t)m->twist_count);
  s->row_point = KM_ARENA_NEW(arena, km_vec3, (size_t)t->loop_count);
  s->slot_motion = KM_ARENA_NEW(arena, km_slot_motion, (size_t)m->largest_slots);
  s->work = KM_ARENA_NEW(arena, double, columns);
  s->projection = KM_ARENA_NEW(arena, double, columns);
  s->forced = KM_ARENA_NEW(arena, bool, columns);
  s->locked = KM_ARENA_NEW(arena, bool, coordinates);
  s->locked_column = KM_ARENA_NEW(arena, bool, coordinates);
  s->has_locked = KM_ARENA_NEW(arena, bool, (size_t)t->substructure_count);
  for (int i = 0; i < t->substructure_count && !arena->failed; ++i) {
    s->cached[i].coordinates = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)m->substructures[i].columns);
    s->factor[i] = create_factor(m, &m->substructures[i], arena);
    if (s->factor[i])
      km_factor_share_normal_equations(s->factor[i], &s->normal[i]);
    km_state_invalidate_pivots(s, i);
  }
  return !arena->failed;
}

/* Writes the constant Jacobian entries of linear couplings. Marks Jacobian, pivots and null space as stale. */
static void reset_substructure(const km_mechanism *m, km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  double *J = km_state_jacobian(s, sub);
  for (int k = 0; k < sub->coupling_count; ++k) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + k];
    for (int n = 0; n < coupling->term_count; ++n) {
      const km_term *term = &m->terms[coupling->term_start + n];
      if (term->column >= 0)
        J[term->value_index] = term->coefficient;
    }
  }
  s->cached[index].is_valid = false;
  s->mobility_is_known[index] = false;
  km_state_invalidate_pivots(s, index);
}

bool km_state_belongs_to(const km_mechanism *m, const km_state *s) {
  return m && s && s->mechanism == m;
}

km_status km_check_state(const km_mechanism *m, const km_state *s, km_error *error) {
  km_status status = km_check_given(m != NULL, "mechanism", error);
  if (!status)
    status = km_check_given(s != NULL, "state", error);
  return status || s->mechanism == m ? status : km_fail(error, KM_USAGE, "the state is one of another mechanism");
}

bool km_state_mobility_is_known(const km_mechanism *m, const km_state *s) {
  if (!km_state_belongs_to(m, s))
    return false;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (!s->mobility_is_known[i])
      return false;
  return true;
}

km_status km_state_create(const km_mechanism *m, km_state **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(m != NULL, "mechanism", error);
  if (fits)
    return fits;
  km_state *s = KM_NEW(km_state, 1);
  if (s)
    s->mechanism = m;
  if (!s || !allocate_arrays(m, s)) {
    km_state_free(s);
    return km_fail(error, KM_MEMORY, "out of memory for a state of the mechanism");
  }
  km_state_restart(s);
  *out = s;
  return KM_OK;
}

void km_state_restart(km_state *s) {
  if (!s)
    return;
  const km_mechanism *m = s->mechanism;
  km_state_unlock(s);
  km_state_set(m, s, m->start);
  memcpy(s->rate, m->start_rate, (size_t)m->coordinate_count * sizeof *s->rate);
  for (int c = 0; c < m->coordinate_count; ++c)
    s->rate_source[c] = m->start_stated[c] ? KM_RATE_MODEL : KM_RATE_FOLLOWS;
  memset(s->acceleration, 0, (size_t)m->coordinate_count * sizeof *s->acceleration);
  s->time = 0.0;
}

void km_state_free(km_state *s) {
  if (!s)
    return;
  for (int i = 0; s->normal && i < s->normal_count; ++i)
    km_normal_equations_free(s->normal[i]);
  km_arena_free(&s->arena);
  km_free(s);
}

/* Copies the stored entries of J to a dense matrix. */
void km_state_jacobian_dense(const km_state *s, const km_substructure *sub, double *J) {
  const km_pattern *pattern = &sub->pattern;
  const double *values = s->jacobian + sub->matrix_start;
  if (!pattern->start) {
    memcpy(J, values, pattern->size * sizeof *J);
    return;
  }
  memset(J, 0, (size_t)sub->rows * (size_t)sub->columns * sizeof *J);
  for (int c = 0; c < sub->columns; ++c)
    for (int i = pattern->start[c]; i < pattern->start[c + 1]; ++i)
      J[(size_t)c * (size_t)sub->rows + (size_t)pattern->row[i]] = values[i];
}

const double *km_state_basis(const km_state *s, int index) {
  s->mobility_is_known[index] = true;
  return km_factor_null_space(s->factor[index], km_factor_freedom(s->factor[index]));
}

/* Projection onto the null space by the row equations, with many freedoms. */
bool km_state_project_onto_motions(const km_mechanism *m, km_state *s, int index, const double *row, double *y) {
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  const km_factor *p = s->factor[index];
  if (!km_factor_avoids_basis(p))
    return false;
  for (int j = 0; j < sub->columns; ++j)
    y[j] = row[coordinate[j]] / m->scale[coordinate[j]];
  return km_factor_project_null_space(p, km_state_jacobian(s, sub), y, 1);
}

/* Forms the basis Z, or defers it with many freedoms. */
void km_state_mark_mobility_known(km_state *s, int index) {
  if (!km_factor_numbers_avoid_basis(s->factor[index]))
    km_state_basis(s, index);
  s->mobility_is_known[index] = true;
}

/* Mobility numbers from the row space if many freedoms, else from the basis Z. */
void km_state_mobility_numbers(const km_mechanism *m, km_state *s, int index, double *numbers) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  s->mobility_is_known[index] = true;
  if (km_factor_numbers_avoid_basis(p) && km_factor_mobility_numbers(p, km_state_jacobian(s, sub), numbers))
    return;
  const double *Z = km_state_basis(s, index);
  km_mobility_numbers(Z, sub->columns, Z ? km_factor_freedom(p) : 0, numbers);
}

static km_quaternion rotated_quaternion(const km_state *s, int ball, km_vec3 turn) {
  return km_quaternion_normalised(km_quaternion_product(km_quaternion_exp(turn), s->ball[ball]));
}

/* Sets the rotation vector of a ball joint from its quaternion, q = log(quaternion), nearest to the last one. */
static void update_ball_coordinates(const km_mechanism *m, km_state *s, int ball) {
  int c = m->ball_coordinate[ball];
  km_vec3 v = km_quaternion_log_near(s->ball[ball], km_vec3_from_array(&s->q[c]));
  km_vec3_write(v, s->q + c);
}

void km_state_rotate_ball(const km_mechanism *m, km_state *s, int ball, km_vec3 turn) {
  s->ball[ball] = rotated_quaternion(s, ball, turn);
  update_ball_coordinates(m, s, ball);
}

void km_state_set_ball(const km_mechanism *m, km_state *s, int ball, km_quaternion q) {
  s->ball[ball] = km_quaternion_normalised(q);
  update_ball_coordinates(m, s, ball);
}

/* q <- exp(step) q: adds scaled steps; ball joints rotate by their quaternion. */
static inline void add_step(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *step,
                            bool updates_ball_coordinates) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k) {
    const int c = coordinate[k], ball = m->ball_of[c];
    if (ball < 0) {
      s->q[c] += m->unit[c] * step[k];
      continue;
    }
    if (!s->locked[c]) { /* a zero rotation would still change the rounding */
      s->ball[ball] = rotated_quaternion(s, ball, km_vec3_from_array(step + k));
      if (updates_ball_coordinates)
        update_ball_coordinates(m, s, ball);
    }
    k += 2;
  }
}

void km_state_move(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *step) {
  add_step(m, s, sub, step, true);
}

void km_state_move_temporarily(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *step) {
  add_step(m, s, sub, step, false);
}

/* Sets all coordinates, and the quaternions of ball joints by exp(q). */
void km_state_set(const km_mechanism *m, km_state *s, const double *q) {
  memmove(s->q, q, (size_t)m->coordinate_count * sizeof *q);
  for (int b = 0; b < m->ball_count; ++b)
    s->ball[b] = km_quaternion_exp(km_vec3_from_array(&s->q[m->ball_coordinate[b]]));
}

/* Locks a coordinate and marks its substructure as stale. */
void km_state_lock(km_state *s, int coordinate) {
  const km_mechanism *m = s->mechanism;
  int i = m->substructure_of[coordinate], column = m->column_of[coordinate];
  s->locked[coordinate] = true;
  if (column < 0)
    return;
  s->locked_column[m->substructures[i].column_start + column] = true;
  s->has_locked[i] = true;
  s->cached[i].is_valid = false;
  s->mobility_is_known[i] = false;
  km_state_invalidate_pivots(s, i);
}

const bool *km_state_locked_columns(const km_state *s, int index) {
  return s->has_locked[index] ? s->locked_column + s->mechanism->substructures[index].column_start : NULL;
}

/* Unlocks all coordinates and marks all substructures as stale. */
void km_state_unlock(km_state *s) {
  const km_mechanism *m = s->mechanism;
  memset(s->locked, 0, (size_t)m->coordinate_count * sizeof *s->locked);
  memset(s->locked_column, 0, (size_t)m->coordinate_count * sizeof *s->locked_column);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    s->has_locked[i] = false;
    reset_substructure(m, s, i);
  }
}

void km_state_clear_locked(km_state *s, const km_substructure *sub) {
  const bool *locked = s->locked_column + sub->column_start;
  const km_pattern *pattern = &sub->pattern;
  double *J = km_state_jacobian(s, sub);
  for (int c = 0; c < sub->columns; ++c) {
    int begin = pattern->start ? pattern->start[c] : c * sub->rows;
    int end = pattern->start ? pattern->start[c + 1] : begin + sub->rows;
    for (int i = begin; i < end && locked[c]; ++i)
      J[i] = 0.0;
  }
}

/* Saves the coordinates by column, then the quaternions of the substructure's ball joints. */
void km_state_save(const km_state *s, const km_substructure *sub, double *saved) {
  const km_mechanism *m = s->mechanism;
  const int *coordinate = m->column_coordinate + sub->column_start, *order = m->ball_order + sub->ball_start;
  double *ball = saved + sub->columns;
  for (int k = 0; k < sub->columns; ++k)
    saved[k] = s->q[coordinate[k]];
  for (int i = 0; i < sub->ball_count; ++i, ball += 4)
    memcpy(ball, &s->ball[order[i]], sizeof *s->ball);
}

void km_state_restore(km_state *s, const km_substructure *sub, const double *saved) {
  const km_mechanism *m = s->mechanism;
  const int *coordinate = m->column_coordinate + sub->column_start, *order = m->ball_order + sub->ball_start;
  const double *ball = saved + sub->columns;
  for (int k = 0; k < sub->columns; ++k)
    s->q[coordinate[k]] = saved[k];
  for (int i = 0; i < sub->ball_count; ++i, ball += 4)
    memcpy(&s->ball[order[i]], ball, sizeof *s->ball);
}

bool km_state_is_at(const km_state *s, const km_substructure *sub, const double *saved) {
  const km_mechanism *m = s->mechanism;
  const int *coordinate = m->column_coordinate + sub->column_start, *order = m->ball_order + sub->ball_start;
  const double *ball = saved + sub->columns;
  for (int k = 0; k < sub->columns; ++k)
    if (memcmp(&s->q[coordinate[k]], &saved[k], sizeof *saved) != 0)
      return false;
  for (int i = 0; i < sub->ball_count; ++i, ball += 4)
    if (memcmp(&s->ball[order[i]], ball, sizeof *s->ball) != 0)
      return false;
  return true;
}

/* Scaled step between two configurations: differences of coordinates, logarithms of quaternions. */
void km_state_difference(const km_state *s, const km_substructure *sub, const double *saved, double *step) {
  const km_mechanism *m = s->mechanism;
  const int *coordinate = m->column_coordinate + sub->column_start, *order = m->ball_order + sub->ball_start;
  const double *ball = saved + sub->columns;
  for (int k = 0; k < sub->columns; ++k)
    step[k] = (s->q[coordinate[k]] - saved[k]) / m->unit[coordinate[k]];
  for (int i = 0; i < sub->ball_count; ++i, ball += 4) {
    int k = m->column_of[m->ball_coordinate[order[i]]];
    km_quaternion old;
    memcpy(&old, ball, sizeof old);
    km_vec3 v = km_quaternion_log(km_quaternion_product(s->ball[order[i]], km_quaternion_conjugate(old)));
    km_vec3_write(v, step + k);
  }
}

/* True for revolute coordinates only. */
bool km_coordinate_turns(const km_mechanism *m, int c) {
  if (!m || c < 0 || c >= m->coordinate_count)
    return false;
  const km_model_coordinate *def = &m->model->coordinates[c];
  km_joint_type type = m->model->joints[def->joint].type;
  return m->ball_of[c] < 0 && type != KM_SCREW && !km_joint_is_length(type, def->index);
}

void km_state_copy(const km_mechanism *m, km_state *to, const km_state *from) {
  memcpy(to->q, from->q, (size_t)m->coordinate_count * sizeof *to->q);
  for (int c = 0; c < m->coordinate_count; ++c) {
    to->rate[c] = m->held[c] ? 0.0 : from->rate[c];
    to->rate_source[c] = m->held[c] ? KM_RATE_FOLLOWS : from->rate_source[c];
  }
  to->time = from->time;
  memcpy(to->ball, from->ball, (size_t)m->ball_count * sizeof *to->ball);
}

km_status km_state_assign(const km_mechanism *m, km_state *to, const km_state *from, km_error *error) {
  km_status status = km_check_state(m, to, error);
  if (!status)
    status = km_check_state(m, from, error);
  if (!status)
    km_state_copy(m, to, from);
  return status;
}

/* Several numbers in the model's unit convert to the same q. The one with at most ten decimals is chosen: 30 degrees
 * are returned as 30, though 30 · (π/180) / (π/180) differs from 30. */
double km_convert_unit(double q, double factor) {
  double exact = q / factor, rounded = nearbyint(exact * 1e10) / 1e10;
  return rounded * factor == q ? rounded : exact;
}

double km_state_coordinate(const km_state *s, int coordinate) {
  if (!s || coordinate < 0 || coordinate >= s->mechanism->coordinate_count)
    return nan("");
  return km_state_value(s, coordinate);
}
