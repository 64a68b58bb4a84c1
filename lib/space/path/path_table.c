/* Tables of a path (space/path/path_table.h). */
#include "space/path/path_table.h"

#include "base/table.h"
#include "model/coordinate_column.h"
#include "space/path/path_spline.h"

enum {
  LEAST_INTERVALS = 100
}; /* rows of the motion: the spline through 101 of them has a cycloid's acceleration to 5e-4 */

/* Place of a coordinate among the drivers; −1: it is none. */
static int driver_index(const km_path_steps *g, int coordinate) {
  int d = g->f.control_count - 1;
  while (d >= 0 && g->def->drivers[d] != coordinate)
    --d;
  return d;
}

/* Adds q. of the drivers, q. of the others and sigma.input. */
static bool add_configuration_columns(const km_path_steps *g, km_table *table) {
  bool is_ok = true;
  for (int d = 0; is_ok && d < g->f.control_count; ++d)
    is_ok = km_model_add_coordinate_column(g->f.m->model, g->def->drivers[d], table);
  for (int c = 0; is_ok && c < g->f.m->coordinate_count; ++c)
    is_ok = driver_index(g, c) >= 0 || km_model_add_coordinate_column(g->f.m->model, c, table);
  return is_ok && km_table_add_joined_column(table, "sigma.input", "", "", "");
}

bool km_path_table_create(const km_path_steps *g, km_space_path *out) {
  out->table = km_table_create();
  out->motion = km_table_create();
  out->explored = km_table_create();
  bool is_ok = out->table && out->motion && out->explored && km_table_add_joined_column(out->table, "s", "", "", "") &&
               km_table_add_joined_column(out->motion, "t", "", "", "") &&
               km_table_add_joined_column(out->explored, "tree", "", "", "") &&
               km_table_add_joined_column(out->explored, "parent", "", "", "");
  for (int d = 0; is_ok && d < g->f.control_count; ++d)
    is_ok = km_model_add_coordinate_column(g->f.m->model, g->def->drivers[d], out->motion);
  return is_ok && add_configuration_columns(g, out->table) && add_configuration_columns(g, out->explored);
}

/* Fills the columns of add_configuration_columns: values[coordinate], then the smallest singular value of the input,
 * which is returned. */
static double fill_configuration(km_path_steps *g, const double *values, double *row) {
  double *other = row + g->f.control_count;
  for (int c = 0; c < g->f.m->coordinate_count; ++c) {
    int driver = driver_index(g, c);
    *(driver >= 0 ? &row[driver] : other++) = values[c];
  }
  return *other = km_path_steps_input_value(g);
}

static void copy_values(const km_path_steps *g, double *values) {
  for (int c = 0; c < g->f.m->coordinate_count; ++c)
    values[c] = km_state_value(g->f.s, c);
}

/* Writes the row of a point, to which the state is moved. values[coordinate] is workspace. */
static bool write_row(km_path_steps *g, const km_path_points *points, int point, double *values, km_space_path *out) {
  const km_driver_surface *f = &g->f;
  const km_mechanism *m = f->m;
  double *row = km_table_add_row(out->table);
  if (!row)
    return false;
  km_path_steps_move_to(g, points->saved[point]);
  copy_values(g, values);
  for (int k = 0; k < f->columns; ++k) {
    int c = km_driver_surface_coordinate(f, k);
    values[c] = points->q[(size_t)point * (size_t)f->columns + (size_t)k] * m->unit[c] / m->factor[c];
  }
  row[0] = points->x[point];
  double sigma = fill_configuration(g, values, row + 1);
  out->ends[point > 0] = sigma;
  out->least_margin = fmin(out->least_margin, sigma);
  return true;
}

bool km_path_table_write_explored(km_path_steps *g, const km_path_tree *tree, km_arena *arena, km_table *explored) {
  double *values = KM_ARENA_NEW(arena, double, (size_t)g->f.m->coordinate_count);
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < tree[side].count; ++i) {
      double *row = values ? km_table_add_row(explored) : NULL;
      if (!row)
        return false;
      row[0] = side + 1;
      row[1] = tree[side].parent[i] < 0 ? -1 : tree[side].parent[i] + side * tree[0].count;
      km_path_steps_move_to(g, tree[side].saved[i]);
      copy_values(g, values);
      fill_configuration(g, values, row + 2);
    }
  return true;
}

/* Rest at the only point of a path. */
static bool write_rest(const km_path_steps *g, const km_space_path *out) {
  for (int i = 0; i < 2; ++i) {
    double *row = km_table_add_row(out->motion);
    if (!row)
      return false;
    row[0] = i;
    for (int d = 0; d < g->f.control_count; ++d)
      row[1 + d] = km_table_row(out->table, 0)[1 + d];
  }
  return true;
}

/* The drivers at equal steps of time, none of which is longer than the mean one of the path. */
static bool write_motion(const km_path_spline *spline, double length, km_table *motion) {
  int steps = 2 * (spline->count - 1), intervals = steps > LEAST_INTERVALS ? steps : LEAST_INTERVALS;
  for (int i = 0; i <= intervals; ++i) {
    double t = (double)i / intervals, *row = km_table_add_row(motion);
    if (!row)
      return false;
    *row = t;
    for (int d = 0; d < spline->drivers; ++d)
      row[1 + d] = km_path_spline_value(spline, d, length * (t - sin(2.0 * M_PI * t) / (2.0 * M_PI)));
  }
  return true;
}

static bool interpolate(const km_path_steps *g, const km_path_points *points, km_arena *arena, km_space_path *out) {
  int count = points->count, drivers = g->f.control_count;
  double *u = KM_ARENA_NEW(arena, double, (size_t)drivers *(size_t)count);
  km_path_spline spline = {0};
  for (int i = 0; u && i < count; ++i)
    for (int d = 0; d < drivers; ++d)
      u[d * count + i] = km_table_row(out->table, (size_t)i)[1 + d];
  bool done = u && km_path_spline_create(points->x, u, count, drivers, out->is_smooth, &spline) &&
              write_motion(&spline, out->length, out->motion);
  km_path_spline_free(&spline);
  return done;
}

bool km_path_table_write(km_path_steps *g, const km_path_points *points, km_arena *arena, km_space_path *out) {
  double *values = KM_ARENA_NEW(arena, double, (size_t)g->f.m->coordinate_count);
  out->least_margin = HUGE_VAL;
  out->length = points->x[points->count - 1];
  for (int i = 0; i < points->count; ++i)
    if (!values || !write_row(g, points, i, values, out))
      return false;
  return points->count < 2 ? write_rest(g, out) : interpolate(g, points, arena, out);
}
