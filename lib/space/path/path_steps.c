/* Steps of closed configurations (space/path/path_steps.h). */
#include "space/path/path_steps.h"

#include "space/real_solve.h"

static const double most_correction = 0.5; /* first correction over the step */

km_status km_path_steps_create(km_path_steps *g, km_arena *a, km_error *error) {
  km_driver_surface *f = &g->f;
  km_status status = km_driver_surface_create(f, g->def->drivers, g->def->driver_count, a, error);
  if (!status)
    status = km_driver_surface_begin(f, a, error);
  if (status)
    return status;
  g->N = KM_ARENA_NEW(a, double, (size_t)(f->control_count * f->columns));
  g->towards = KM_ARENA_NEW(a, double, (size_t)f->columns);
  g->before = KM_ARENA_NEW(a, double, f->saved_size);
  for (int k = 0; k < f->columns && !g->def->ignore_limits; ++k)
    f->wraps[k] = f->wraps[k] && !km_model_coordinate_limits(f->m->model, km_driver_surface_coordinate(f, k),
                                                             &(double){0}, &(double){0});
  return a->failed ? km_fail(error, KM_MEMORY, "out of memory for the path") : KM_OK;
}

void km_path_steps_move_to(km_path_steps *g, const double *saved) {
  km_driver_surface_restore(&g->f, saved);
  km_driver_surface_update(&g->f);
  km_driver_surface_factor(&g->f, &g->sign);
}

double km_path_steps_input_value(km_path_steps *g) {
  return g->f.rows > 0 ? km_driver_surface_input_value(&g->f) : HUGE_VAL;
}

bool km_path_steps_is_allowed(km_path_steps *g, int sign) {
  km_driver_surface *f = &g->f;
  if ((g->sign != 0 && sign != g->sign) || !(km_path_steps_input_value(g) >= g->margin))
    return false;
  if (!g->def->ignore_limits && km_driver_surface_is_outside_limit(f))
    return false;
  if (!g->def->condition)
    return true;
  km_poses_compute(f->m, f->s);
  return g->def->condition(g->def->context, f->m, f->s);
}

double km_path_steps_difference(km_path_steps *g, const double *saved) {
  double length = km_driver_surface_difference(&g->f, saved, g->towards);
  for (int k = 0; k < g->f.columns; ++k)
    g->towards[k] = -g->towards[k];
  return length;
}

double km_path_steps_tangent(km_path_steps *g, const double *du) {
  km_driver_surface *f = &g->f;
  double sum = 0.0;
  for (int k = 0; k < f->columns; ++k) {
    f->step[k] = 0.0;
    for (int d = 0; d < f->control_count; ++d)
      f->step[k] += g->N[d * f->columns + k] * du[d];
    sum += f->step[k] * f->step[k];
  }
  return sqrt(sum);
}

bool km_path_steps_move(km_path_steps *g, double length, bool *is_whole) {
  km_driver_surface *f = &g->f;
  int sign;
  *is_whole = length <= KM_LONGEST_PATH_STEP;
  double part = *is_whole ? 1.0 : KM_LONGEST_PATH_STEP / length;
  for (int k = 0; k < f->columns; ++k)
    f->step[k] *= part;
  km_driver_surface_move(f, f->step);
  return km_driver_surface_close(f, most_correction * fmax(part * length, KM_EQUAL_PATH_CONFIGURATIONS), &sign) &&
         km_path_steps_is_allowed(g, sign);
}

/* du <- (Nᵀ N)⁻¹ Nᵀ g->towards. */
static bool project(km_path_steps *g) {
  int n = g->f.columns, drivers = g->f.control_count, sign;
  for (int i = 0; i < drivers; ++i) {
    g->right[i] = 0.0;
    for (int k = 0; k < n; ++k)
      g->right[i] += g->N[i * n + k] * g->towards[k];
    for (int j = 0; j < drivers; ++j) {
      g->square[i * drivers + j] = 0.0;
      for (int k = 0; k < n; ++k)
        g->square[i * drivers + j] += g->N[i * n + k] * g->N[j * n + k];
    }
  }
  if (!km_real_factor(g->square, drivers, g->small_row, &sign))
    return false;
  km_real_solve(g->square, drivers, g->small_row, g->right, g->du);
  return true;
}

bool km_path_steps_towards(km_path_steps *g, double distance) {
  bool is_whole;
  km_driver_surface_save(&g->f, g->before);
  km_driver_surface_rates(&g->f, g->N);
  if (!project(g))
    return false;
  for (int d = 0; distance <= KM_LONGEST_PATH_STEP && d < g->f.control_count; ++d) /* exactly the values of the end */
    g->du[d] = g->towards[g->f.control[d]];
  if (km_path_steps_move(g, km_path_steps_tangent(g, g->du), &is_whole))
    return true;
  km_path_steps_move_to(g, g->before);
  return false;
}
