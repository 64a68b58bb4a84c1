/* Closed configurations with as many controls as freedoms (space/driver_surface.h). */
#include "space/driver_surface.h"

#include "base/number/vectors.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_equations.h"
#include "local/generic_neighbour.h"
#include "space/real_solve.h"
#include "space/surface/point_motion.h"

#include <string.h>

enum { MOST_NEWTON = 8 };
static const double closed = 1e-13; /* largest error, and largest correction that is rounding: radians, sizes */

static const km_substructure *substructure_of(const km_driver_surface *f, const km_surface_part *part) {
  return part->substructure < 0 ? NULL : &f->m->substructures[part->substructure];
}

int km_driver_surface_coordinate(const km_driver_surface *f, int column) {
  const km_surface_part *part = &f->part[f->part_count - 1];
  while (column < part->column_start)
    --part;
  const km_substructure *sub = substructure_of(f, part);
  return sub ? f->m->column_coordinate[sub->column_start + column - part->column_start] : part->coordinate;
}

/* ---- Preparation. */

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the map");
}

/* Adds the part of a driver, unless it is there. *column: of the driver. */
static km_status add_part(km_driver_surface *f, int coordinate, int *column, km_error *error) {
  const km_mechanism *m = f->m;
  int own = m->substructure_of[coordinate];
  if (m->held[coordinate] || m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" can't be a driver here; expected a free hinge or slide",
                   m->model->coordinates[coordinate].label);
  bool is_loop = own >= 0 && m->substructures[own].loop_count > 0;
  int at = 0;
  while (at < f->part_count && !(is_loop && f->part[at].substructure == own))
    ++at;
  if (at == f->part_count) {
    const km_surface_part *before = at > 0 ? &f->part[at - 1] : NULL;
    f->part[f->part_count++] = (km_surface_part){
        .substructure = is_loop ? own : -1,
        .coordinate = coordinate,
        .columns = is_loop ? m->substructures[own].columns : 1,
        .rows = is_loop ? km_substructure_rows(m, own) : 0,
        .column_start = before ? before->column_start + before->columns : 0,
        .row_start = before ? before->row_start + before->rows : 0,
    };
    f->size = fmax(f->size, is_loop ? m->substructures[own].size : m->length);
  }
  *column = f->part[at].column_start + (is_loop ? m->column_of[coordinate] : 0);
  return KM_OK;
}

static const km_surface_part *part_with(const km_driver_surface *f, int substructure) {
  for (int i = 0; i < f->part_count; ++i)
    if (f->part[i].substructure == substructure)
      return &f->part[i];
  return NULL;
}

/* Updates the errors and the Jacobian of all conditions at the state's configuration. */
static void update_all(km_driver_surface *f) {
  memset(f->all_J, 0, (size_t)(f->conditions * f->columns) * sizeof *f->all_J);
  for (int i = 0; i < f->part_count; ++i) {
    const km_surface_part *part = &f->part[i];
    const km_substructure *sub = substructure_of(f, part);
    if (!sub)
      continue;
    km_loops_recompute(f->m, f->s, sub);
    km_state_jacobian_dense(f->s, sub, f->part_J);
    memcpy(f->all_e + part->row_start, km_state_error(f->s, sub), (size_t)part->rows * sizeof *f->all_e);
    for (int k = 0; k < part->columns; ++k)
      memcpy(f->all_J + (size_t)((part->column_start + k) * f->conditions + part->row_start),
             f->part_J + (size_t)(k * part->rows), (size_t)part->rows * sizeof *f->all_J);
  }
  for (int i = 0; i < f->rod_count; ++i) {
    const km_rod_spin *rod = &f->rods[i];
    int row = f->conditions - f->rod_count + i;
    int column = part_with(f, f->m->substructure_of[rod->coordinate])->column_start + f->m->column_of[rod->coordinate];
    km_vec3 gradient;
    f->all_e[row] = km_rod_spin_angle(rod, f->s, &gradient);
    f->all_J[column * f->conditions + row] = gradient.x;
    f->all_J[(column + 1) * f->conditions + row] = gradient.y;
    f->all_J[(column + 2) * f->conditions + row] = gradient.z;
  }
  f->gap = km_max_norm(f->all_e, f->conditions);
}

static void take_rows(km_driver_surface *f) {
  km_condition_rows_take(&f->primary, f->all_J, f->columns, f->J);
  km_condition_rows_take(&f->primary, f->all_e, 1, f->e);
}

km_status km_driver_surface_create(km_driver_surface *f, const int *drivers, int count, km_arena *arena,
                                   km_error *error) {
  km_status status = KM_OK;
  f->control_count = count + (f->number != NULL);
  for (int d = 0; !status && d < count; ++d)
    status = add_part(f, drivers[d], &f->control[d], error);
  if (status)
    return status;
  const km_surface_part *last = &f->part[f->part_count - 1];
  f->columns = last->column_start + last->columns + (f->number != NULL);
  f->rows = f->columns - f->control_count;
  f->saved_size = KM_SAVED_PER_COLUMN * (size_t)f->columns; /* the last two, which km_state_save leaves: rows, number */
  f->other = KM_ARENA_NEW(arena, int, (size_t)f->rows + 1);
  f->wraps = KM_ARENA_NEW(arena, bool, (size_t)f->columns);
  f->step = KM_ARENA_NEW(arena, double, (size_t)f->columns);
  if (arena->failed)
    return no_memory(error);
  if (f->number)
    f->control[count] = f->columns - 1;
  for (int k = 0, others = 0; k < f->columns; ++k) {
    bool is_control = false;
    for (int d = 0; d < f->control_count; ++d)
      is_control = is_control || f->control[d] == k;
    if (!is_control)
      f->other[others++] = k;
  }
  for (int k = 0; k < km_driver_surface_joints(f); ++k)
    f->wraps[k] = km_coordinate_turns(f->m, km_driver_surface_coordinate(f, k));
  return KM_OK;
}

/* ---- Freedoms and conditions. */

/* Freedoms of a part: at the state's configuration, or those that remain at a neighbour on its motion. −1: out of
 * memory. */
static int freedoms_of(km_driver_surface *f, const km_surface_part *part) {
  int own = part->substructure;
  if (own < 0)
    return 1;
  km_arena arena = {0};
  double *saved = KM_ARENA_NEW(&arena, double, KM_SAVED_PER_COLUMN *(size_t)part->columns);
  double *move = KM_ARENA_NEW(&arena, double, (size_t)part->columns);
  int freedoms = -1;
  if (!arena.failed) {
    freedoms = km_factor_freedom(f->s->factor[own]);
    if (km_generic_neighbour_enter(f->m, f->s, own, saved, move) && km_factor_freedom(f->s->factor[own]) < freedoms)
      freedoms = km_factor_freedom(f->s->factor[own]);
    km_generic_neighbour_leave(f->m, f->s, own, saved);
  }
  km_arena_free(&arena);
  return freedoms;
}

/* Finds the rods that can spin. */
static km_status find_rods(km_driver_surface *f, km_arena *arena, km_error *error) {
  km_passive_freedoms passive;
  km_status status = km_passive_freedoms_find(f->m, f->s, NULL, NULL, &passive, error);
  f->rods = KM_ARENA_NEW(arena, km_rod_spin, (size_t)passive.count + 1);
  if (!status && !f->rods)
    status = no_memory(error);
  km_poses_compute(f->m, f->s);
  for (int i = 0; !status && i < passive.count; ++i) {
    const km_passive_freedom *freedom = &passive.items[i];
    if (!part_with(f, freedom->substructure))
      continue;
    if (!km_rod_spin_create(f->m, f->s, freedom, &f->rods[f->rod_count++]))
      status =
          km_fail(error, KM_USAGE,
                  "body \"%s\" can move while all others stand still; expected no such freedom but the spin of a rod "
                  "between two ball joints",
                  f->m->model->bodies[freedom->bodies[0]].name);
  }
  km_passive_freedoms_free(&passive);
  return status;
}

static km_status check_freedoms(km_driver_surface *f, km_error *error) {
  int freedoms = -f->rod_count, drivers = f->control_count - (f->number != NULL);
  for (int i = 0; i < f->part_count; ++i) {
    int own = freedoms_of(f, &f->part[i]);
    if (own < 0)
      return no_memory(error);
    freedoms += own;
  }
  if (freedoms == drivers)
    return KM_OK;
  return km_fail(error, KM_USAGE,
                 "%d driver%s of a part of the mechanism with %d freedom%s; expected as many drivers as freedoms (more "
                 "freedoms: hold joints)",
                 drivers, drivers == 1 ? "" : "s", freedoms, freedoms == 1 ? "" : "s");
}

static bool allocate(km_driver_surface *f, km_arena *arena) {
  size_t n = (size_t)f->columns, r = (size_t)f->rows, all = (size_t)f->conditions, most = all > r ? all : r;
  f->all_J = KM_ARENA_NEW(arena, double, n *all + 1);
  f->all_e = KM_ARENA_NEW(arena, double, all + 1);
  f->J = all == r ? f->all_J : KM_ARENA_NEW(arena, double, n *r + 1);
  f->e = all == r ? f->all_e : KM_ARENA_NEW(arena, double, r + 1);
  f->part_J = KM_ARENA_NEW(arena, double, n *most + 1);
  f->A = KM_ARENA_NEW(arena, double, r *r + 1);
  f->row = KM_ARENA_NEW(arena, int, r + 1);
  f->x = KM_ARENA_NEW(arena, double, r + 1);
  f->b = KM_ARENA_NEW(arena, double, r + 1);
  f->G = KM_ARENA_NEW(arena, double, 2 * n);
  f->frame_jacobian = KM_ARENA_NEW(arena, double, 6 * (size_t)f->m->coordinate_count);
  return km_condition_rows_create(&f->primary, f->conditions, f->rows, f->columns, arena);
}

km_status km_driver_surface_begin(km_driver_surface *f, km_arena *arena, km_error *error) {
  const km_surface_part *last = &f->part[f->part_count - 1];
  km_mobility mobility;
  if (km_mobility_compute(f->m, f->s, &mobility))
    return no_memory(error);
  km_status status = find_rods(f, arena, error);
  if (!status)
    status = check_freedoms(f, error);
  if (status)
    return status;
  f->conditions = last->row_start + last->rows + f->rod_count;
  if (!allocate(f, arena))
    return no_memory(error);
  update_all(f);
  if (!km_condition_rows_choose(&f->primary, f->all_J))
    return no_memory(error);
  return f->frame >= 0 ? km_point_motion_find_surface(f, error) : KM_OK;
}

/* ---- Operations. */

void km_driver_surface_update(km_driver_surface *f) {
  update_all(f);
  take_rows(f);
}

bool km_driver_surface_exchange(km_driver_surface *f) {
  bool is_changed;
  km_condition_rows_exchange(&f->primary, f->all_J, &is_changed);
  if (is_changed)
    take_rows(f);
  return is_changed;
}

void km_driver_surface_stop_spins(km_driver_surface *f) {
  for (int i = 0; i < f->rod_count; ++i)
    km_rod_spin_reset(&f->rods[i], f->m, f->s);
}

void km_driver_surface_restart(km_driver_surface *f) {
  bool is_changed;
  f->primary.present = 0;
  km_driver_surface_stop_spins(f);
  update_all(f);
  if (!km_condition_rows_exchange(&f->primary, f->all_J, &is_changed))
    km_condition_rows_choose(&f->primary, f->all_J);
}

bool km_driver_surface_is_closed(const km_driver_surface *f) {
  return f->gap <= sqrt(6.0) * f->m->closure_tolerance; /* the tolerance is that of the mean square of six */
}

bool km_driver_surface_factor(km_driver_surface *f, int *sign) {
  for (int i = 0; i < f->rows; ++i)
    for (int j = 0; j < f->rows; ++j)
      f->A[i * f->rows + j] = f->J[f->other[j] * f->rows + i];
  return km_real_factor(f->A, f->rows, f->row, sign);
}

/* True if all conditions are satisfied, where Newton's method has ended. The primary rows may be exchanged. */
static bool finish(km_driver_surface *f, int *sign) {
  return km_driver_surface_is_closed(f) && (!km_driver_surface_exchange(f) || km_driver_surface_factor(f, sign));
}

bool km_driver_surface_close(km_driver_surface *f, double most, int *sign) {
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double error = 0.0, correction = 0.0;
    km_driver_surface_update(f);
    if (!km_driver_surface_factor(f, sign))
      return false;
    for (int k = 0; k < f->rows; ++k) {
      error = fmax(error, fabs(f->e[k]));
      f->b[k] = -f->e[k];
    }
    if (error <= closed)
      return finish(f, sign);
    if (!isfinite(error))
      return false;
    km_real_solve(f->A, f->rows, f->row, f->b, f->x);
    memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
    for (int k = 0; k < f->rows; ++k) {
      f->step[f->other[k]] = f->x[k];
      correction = fmax(correction, fabs(f->x[k]));
    }
    if (!(correction < HUGE_VAL) || (i == 0 && correction > most))
      return false;
    if (i > 1 && correction < closed) /* the error is rounding */
      return finish(f, sign);
    km_driver_surface_move(f, f->step);
  }
  return false;
}

void km_driver_surface_rates(km_driver_surface *f, double *N) {
  for (int d = 0; d < f->control_count; ++d) {
    double *column = N + d * f->columns;
    memset(column, 0, (size_t)f->columns * sizeof *column);
    for (int k = 0; k < f->rows; ++k)
      f->b[k] = -f->J[f->control[d] * f->rows + k];
    km_real_solve(f->A, f->rows, f->row, f->b, f->x);
    for (int k = 0; k < f->rows; ++k)
      column[f->other[k]] = f->x[k];
    column[f->control[d]] = 1.0;
  }
}

void km_driver_surface_spin(km_driver_surface *f, int rod, double *z) {
  memset(f->b, 0, (size_t)f->rows * sizeof *f->b);
  memset(z, 0, (size_t)f->columns * sizeof *z);
  f->b[f->rows - f->rod_count + rod] = 1.0; /* the condition depends on no other, so that it is primary */
  km_real_solve(f->A, f->rows, f->row, f->b, f->x);
  for (int k = 0; k < f->rows; ++k)
    z[f->other[k]] = f->x[k];
}

double km_driver_surface_input_value(km_driver_surface *f) {
  int rows = f->conditions - f->rod_count, rank = f->rows - f->rod_count;
  for (int j = 0; j < f->rows; ++j)
    memcpy(f->part_J + (size_t)(j * rows), f->all_J + (size_t)(f->other[j] * f->conditions),
           (size_t)rows * sizeof *f->all_J);
  return rank > 0 ? km_singular_value(f->part_J, rows, f->rows, rank) : nan("");
}

double km_driver_surface_closure_value(km_driver_surface *f) {
  int rows = f->conditions - f->rod_count, rank = f->rows - f->rod_count;
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < f->columns; ++k)
      f->part_J[i * f->columns + k] = f->all_J[k * f->conditions + i];
  return rank > 0 ? km_singular_value(f->part_J, f->columns, rows, rank) : nan("");
}

int km_driver_surface_joints(const km_driver_surface *f) {
  return f->number ? f->columns - 1 : f->columns;
}

km_vec3 km_driver_surface_place(const km_driver_surface *f) {
  double place[3];
  km_frame_position(f->m, f->s, f->frame, place);
  return km_vec3_from_array(place);
}

void km_driver_surface_update_output(km_driver_surface *f) {
  int w = km_driver_surface_joints(f);
  if (f->frame < 0)
    return;
  km_poses_compute(f->m, f->s);
  km_frame_jacobian(f->m, f->s, f->frame, f->frame_jacobian, NULL);
  km_vec3 tangent[2];
  km_point_surface_tangents(&f->point_surface, km_driver_surface_place(f), tangent);
  for (int k = 0; k < w; ++k) {
    int c = km_driver_surface_coordinate(f, k);
    const double *J = f->frame_jacobian + 6 * c;
    for (int i = 0; i < 2; ++i)
      f->G[i * w + k] = km_vec3_dot(tangent[i], km_vec3_from_array(J)) * f->m->unit[c] / f->size;
  }
}

void km_driver_surface_rows(const km_driver_surface *f, double *M, int width) {
  int columns = width < f->columns ? width : f->columns;
  for (int i = 0; i < f->rows; ++i)
    for (int k = 0; k < columns; ++k)
      M[i * width + k] = f->J[k * f->rows + i];
}

void km_driver_surface_matrix(const km_driver_surface *f, km_curve_kind kind, double *K) {
  int w = km_driver_surface_joints(f), r = f->rows;
  km_driver_surface_rows(f, K, w);
  for (int i = r; i < w; ++i)
    for (int k = 0; k < w; ++k)
      K[i * w + k] = kind == KM_CURVE_OUTPUT ? f->G[(i - r) * w + k] : f->control[i - r] == k;
}

double km_driver_surface_determinant(km_driver_surface *f, km_curve_kind kind, double *K, int *row) {
  km_driver_surface_update(f);
  if (kind == KM_CURVE_OUTPUT)
    km_driver_surface_update_output(f);
  km_driver_surface_matrix(f, kind, K);
  return km_real_determinant(K, km_driver_surface_joints(f), row);
}

bool km_driver_surface_move(km_driver_surface *f, const double *step) {
  if (f->number) {
    double change = step[f->columns - 1] * (f->high[1] - f->low[1]);
    if (change != 0.0 && !km_design_number_set(f->number, f->number->value + change))
      return false;
  }
  for (int i = 0; i < f->part_count; ++i) {
    const km_surface_part *part = &f->part[i];
    if (part->substructure >= 0)
      km_state_move(f->m, f->s, substructure_of(f, part), step + part->column_start);
    else
      f->s->q[part->coordinate] += step[part->column_start] * f->m->unit[part->coordinate];
  }
  return true;
}

void km_driver_surface_save(const km_driver_surface *f, double *saved) {
  for (int i = 0; i < f->part_count; ++i) {
    const km_surface_part *part = &f->part[i];
    double *own = saved + KM_SAVED_PER_COLUMN * part->column_start;
    if (part->substructure >= 0)
      km_state_save(f->s, substructure_of(f, part), own);
    else
      *own = f->s->q[part->coordinate];
  }
  saved[f->saved_size - 2] = f->primary.present;
  if (f->number)
    saved[f->saved_size - 1] = f->number->value;
}

void km_driver_surface_restore(km_driver_surface *f, const double *saved) {
  f->primary.present = (int)saved[f->saved_size - 2];
  if (f->number)
    km_design_number_set(f->number, saved[f->saved_size - 1]);
  for (int i = 0; i < f->part_count; ++i) {
    const km_surface_part *part = &f->part[i];
    const double *own = saved + KM_SAVED_PER_COLUMN * part->column_start;
    if (part->substructure >= 0)
      km_state_restore(f->s, substructure_of(f, part), own);
    else
      f->s->q[part->coordinate] = *own;
  }
}

double km_driver_surface_difference(const km_driver_surface *f, const double *saved, double *step) {
  int w = km_driver_surface_joints(f);
  double sum = 0.0;
  for (int i = 0; i < f->part_count; ++i) {
    const km_surface_part *part = &f->part[i];
    const double *own = saved + KM_SAVED_PER_COLUMN * part->column_start;
    if (part->substructure >= 0)
      km_state_difference(f->s, substructure_of(f, part), own, step + part->column_start);
    else
      step[part->column_start] = (f->s->q[part->coordinate] - *own) / f->m->unit[part->coordinate];
  }
  if (f->number)
    step[w] = (f->number->value - saved[f->saved_size - 1]) / (f->high[1] - f->low[1]);
  for (int k = 0; k < f->columns; ++k) {
    if (k < w && f->wraps[k])
      step[k] = remainder(step[k], 2.0 * M_PI);
    sum += step[k] * step[k];
  }
  return sqrt(sum);
}

double km_driver_surface_value(const km_driver_surface *f, int control) {
  return f->number && control == f->control_count - 1
             ? f->number->value
             : km_state_value(f->s, km_driver_surface_coordinate(f, f->control[control]));
}

/* Distance of a value to the nearer end of a range; negative outside. */
static double within(double value, double low, double high) {
  return fmin(value - low, high - value);
}

double km_driver_surface_margin(km_driver_surface *f, int column, int pair) {
  double least = HUGE_VAL;
  for (int d = 0; d < 2; ++d)
    if (f->control[d] != column && !f->is_full_turn[d])
      least = fmin(least, within(km_driver_surface_value(f, d), f->low[d], f->high[d]));
  for (int k = 0; k < km_driver_surface_joints(f) && f->keeps_limits; ++k)
    if (k != column)
      least = fmin(least, within(km_driver_surface_limited_value(f, k), km_driver_surface_low(f, k),
                                 km_driver_surface_high(f, k)));
  km_kept_clearance_update(&f->kept, f->m, f->s);
  return fmin(least, km_kept_clearance_least(&f->kept, pair));
}

void km_driver_surface_add_clearance_row(km_driver_surface *f, int pair, double *row) {
  km_clearance_gradient(f->kept.clearance, f->s, pair, &f->kept.pairs[pair], f->kept.gradient, NULL);
  for (int k = 0; k < km_driver_surface_joints(f); ++k) {
    int c = km_driver_surface_coordinate(f, k);
    row[k] += f->kept.gradient[c] * f->m->unit[c] / f->size;
  }
}

/* True if the column is the second or third one of a ball joint. */
static bool is_further_column(const km_driver_surface *f, int column) {
  int c = km_driver_surface_coordinate(f, column), ball = f->m->ball_of[c];
  return ball >= 0 && c != f->m->ball_coordinate[ball];
}

/* −1 for a strut drawn through itself: the limits are those of its length |q|. */
static double strut_sense(const km_driver_surface *f, int c) {
  return f->m->model->coordinates[c].is_strut && f->s->q[c] < 0.0 ? -1.0 : 1.0;
}

double km_driver_surface_limited_value(const km_driver_surface *f, int column) {
  int c = km_driver_surface_coordinate(f, column);
  if (f->m->ball_of[c] < 0)
    return strut_sense(f, c) * f->s->q[c];
  return is_further_column(f, column) ? 0.0 : km_norm(&f->s->q[c], 3);
}

void km_driver_surface_add_limited_row(const km_driver_surface *f, int column, double *row) {
  int c = km_driver_surface_coordinate(f, column);
  double angle = km_norm(&f->s->q[c], f->m->ball_of[c] < 0 ? 0 : 3);
  if (f->m->ball_of[c] < 0)
    row[column] += strut_sense(f, c);
  for (int k = 0; k < 3 && angle > 0.0; ++k) /* the axis is the same in both frames */
    row[column + k] += f->s->q[c + k] / angle;
}

double km_driver_surface_low(const km_driver_surface *f, int column) {
  int c = km_driver_surface_coordinate(f, column);
  return f->m->ball_of[c] < 0 ? f->m->low[c] : -HUGE_VAL;
}

double km_driver_surface_high(const km_driver_surface *f, int column) {
  int c = km_driver_surface_coordinate(f, column);
  return f->m->ball_of[c] < 0 ? f->m->high[c] : is_further_column(f, column) ? HUGE_VAL : f->m->max_ball_angle[c];
}

bool km_driver_surface_is_outside_limit(const km_driver_surface *f) {
  for (int k = 0; k < km_driver_surface_joints(f); ++k)
    if (km_state_is_outside(f->s, km_driver_surface_coordinate(f, k)))
      return true;
  return false;
}
