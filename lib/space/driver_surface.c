/* Surface of closed configurations with two controls (space/driver_surface.h). */
#include "space/driver_surface.h"

#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "space/real_solve.h"

#include <string.h>

const km_substructure *km_driver_surface_part(const km_driver_surface *f) {
  return &f->m->substructures[f->substructure];
}

static km_status check_driver(const km_driver_surface *f, int coordinate, km_error *error) {
  const km_mechanism *m = f->m;
  int own = m->substructure_of[coordinate];
  if (m->held[coordinate] || own < 0 || m->substructures[own].loop_count == 0 || m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" can't drive a map; expected a free hinge or slide of a loop",
                   m->model->coordinates[coordinate].label);
  return own == f->substructure
             ? KM_OK
             : km_fail(error, KM_USAGE, "both drivers of a map must be different joints of one part of the mechanism");
}

/* The part must have as many conditions as coordinates without the controls. */
static km_status check_part(const km_driver_surface *f, int joints, km_error *error) {
  const km_substructure *sub = km_driver_surface_part(f);
  for (int k = 0; k < sub->columns; ++k)
    if (f->m->ball_of[f->m->column_coordinate[sub->column_start + k]] >= 0)
      return km_fail(
          error, KM_USAGE,
          "this part of the mechanism has ball joints, which maps and turning curves don't cover; expected hinges and slides");
  if (f->rows != f->columns - 2)
    return km_fail(error, KM_USAGE,
                   "the part of the mechanism has %d coordinates and %d conditions; expected %s and no redundant "
                   "conditions",
                   sub->columns, f->rows, joints == 2 ? "two freedoms" : "one freedom");
  return KM_OK;
}

/* Axes of the plane in which the mechanism moves: a coordinate axis projected, and the one orthogonal to it. */
static km_status find_plane(km_driver_surface *f, km_error *error) {
  double normal[3];
  km_poses_compute(f->m, f->s);
  if (!km_mechanism_plane(f->m, f->s, normal))
    return km_fail(error, KM_USAGE, "the mechanism isn't planar; expected one for the workspace of a point");
  km_vec3 n = km_vec3_from_array(normal), x = {1.0, 0.0, 0.0}, y = {0.0, 1.0, 0.0};
  km_vec3 start = fabs(n.x) < 0.9 ? x : y;
  f->axis[0] = km_vec3_sub(start, km_vec3_scale(km_vec3_dot(start, n), n));
  f->axis[0] = km_vec3_scale(1.0 / km_vec3_norm(f->axis[0]), f->axis[0]);
  f->axis[1] = km_vec3_cross(n, f->axis[0]);
  return KM_OK;
}

km_status km_driver_surface_create(km_driver_surface *f, const int *drivers, km_arena *arena, km_error *error) {
  int joints = f->number ? 1 : 2;
  km_status status = KM_OK;
  f->substructure = f->m->substructure_of[drivers[0]];
  for (int d = 0; !status && d < joints; ++d)
    status = check_driver(f, drivers[d], error);
  if (!status) {
    f->columns = km_driver_surface_part(f)->columns + 2 - joints;
    f->rows = km_substructure_rows(f->m, f->substructure);
    status = check_part(f, joints, error);
  }
  if (status)
    return status;
  size_t n = (size_t)f->columns, r = (size_t)f->rows;
  f->saved_size = KM_SAVED_PER_COLUMN * n;
  f->other = KM_ARENA_NEW(arena, int, r + 1);
  f->J = KM_ARENA_NEW(arena, double, n *r + 1);
  f->A = KM_ARENA_NEW(arena, double, r *r + 1);
  f->row = KM_ARENA_NEW(arena, int, r + 1);
  f->step = KM_ARENA_NEW(arena, double, n);
  f->x = KM_ARENA_NEW(arena, double, r + 1);
  f->b = KM_ARENA_NEW(arena, double, r + 1);
  f->G = KM_ARENA_NEW(arena, double, 2 * n);
  f->frame_jacobian = KM_ARENA_NEW(arena, double, 6 * (size_t)f->m->coordinate_count);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the map");
  status = f->frame >= 0 ? find_plane(f, error) : KM_OK;
  if (status)
    return status;
  f->control[1] = f->columns - 1;
  for (int d = 0; d < joints; ++d)
    f->control[d] = f->m->column_of[drivers[d]];
  for (int k = 0, count = 0; k < f->columns; ++k)
    if (k != f->control[0] && k != f->control[1])
      f->other[count++] = k;
  return KM_OK;
}

void km_driver_surface_update(km_driver_surface *f) {
  km_loops_recompute(f->m, f->s, km_driver_surface_part(f));
  km_state_jacobian_dense(f->s, km_driver_surface_part(f), f->J);
}

bool km_driver_surface_factor(km_driver_surface *f, int *sign) {
  for (int i = 0; i < f->rows; ++i)
    for (int j = 0; j < f->rows; ++j)
      f->A[i * f->rows + j] = f->J[f->other[j] * f->rows + i];
  return km_real_factor(f->A, f->rows, f->row, sign);
}

int km_driver_surface_joints(const km_driver_surface *f) {
  return f->number ? f->columns - 1 : f->columns;
}

void km_driver_surface_update_output(km_driver_surface *f) {
  const km_substructure *sub = km_driver_surface_part(f);
  if (f->frame < 0)
    return;
  km_poses_compute(f->m, f->s);
  km_frame_jacobian(f->m, f->s, f->frame, f->frame_jacobian, NULL);
  for (int k = 0; k < sub->columns; ++k) {
    int c = f->m->column_coordinate[sub->column_start + k];
    const double *J = f->frame_jacobian + 6 * c;
    for (int i = 0; i < 2; ++i)
      f->G[i * sub->columns + k] =
          (f->axis[i].x * J[0] + f->axis[i].y * J[1] + f->axis[i].z * J[2]) * f->m->unit[c] / sub->size;
  }
}

void km_driver_surface_matrix(const km_driver_surface *f, km_singularity_kind kind, double *K) {
  int w = km_driver_surface_joints(f), r = f->rows;
  for (int i = 0; i < r; ++i)
    for (int k = 0; k < w; ++k)
      K[i * w + k] = f->J[k * r + i];
  for (int i = r; i < w; ++i)
    for (int k = 0; k < w; ++k)
      K[i * w + k] = kind == KM_SINGULARITY_OUTPUT ? f->G[(i - r) * w + k] : f->control[i - r] == k;
}

bool km_driver_surface_move(km_driver_surface *f, const double *step) {
  if (f->number) {
    double change = step[f->columns - 1] * (f->high[1] - f->low[1]);
    if (change != 0.0 && !km_design_number_set(f->number, f->number->value + change))
      return false;
  }
  km_state_move(f->m, f->s, km_driver_surface_part(f), step);
  return true;
}

void km_driver_surface_save(const km_driver_surface *f, double *saved) {
  km_state_save(f->s, km_driver_surface_part(f), saved);
  if (f->number)
    saved[f->saved_size - 1] = f->number->value;
}

void km_driver_surface_restore(km_driver_surface *f, const double *saved) {
  if (f->number)
    km_design_number_set(f->number, saved[f->saved_size - 1]);
  km_state_restore(f->s, km_driver_surface_part(f), saved);
}

double km_driver_surface_difference(const km_driver_surface *f, const double *saved, double *step) {
  const km_substructure *sub = km_driver_surface_part(f);
  double sum = 0.0;
  km_state_difference(f->s, sub, saved, step);
  if (f->number)
    step[f->columns - 1] = (f->number->value - saved[f->saved_size - 1]) / (f->high[1] - f->low[1]);
  for (int k = 0; k < f->columns; ++k) {
    if (k < sub->columns && km_coordinate_turns(f->m, f->m->column_coordinate[sub->column_start + k]))
      step[k] = remainder(step[k], 2.0 * M_PI);
    sum += step[k] * step[k];
  }
  return sqrt(sum);
}

double km_driver_surface_value(const km_driver_surface *f, int control) {
  if (f->number && control == 1)
    return f->number->value;
  return km_state_value(f->s, f->m->column_coordinate[km_driver_surface_part(f)->column_start + f->control[control]]);
}

bool km_driver_surface_is_inside(const km_driver_surface *f) {
  for (int d = 0; d < 2; ++d) {
    double value = km_driver_surface_value(f, d);
    if (value < f->low[d] || value > f->high[d])
      return false;
  }
  return true;
}
