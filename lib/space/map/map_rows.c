/* Rows of the tables of a map (docs/theory.md 4.19).
 *
 *   N = (−A⁻¹ B; I);   m_j = N_j (Nᵀ N)⁻¹ N_jᵀ,   smallest singular values of A and of J
 *   D = G N            of a point on its plane or sphere: smallest singular value, |det D| */
#include "space/map/map_search.h"

#include "base/number/vectors.h"
#include "base/table.h"
#include "kmech/mobility.h"
#include "model/coordinate_column.h"

#include <string.h>

static const double singular = 1e-9; /* |det D| of a grid point on an output curve, over the squares of D */

/* x, y, z of the point. */
static bool add_point(const km_map_search *g, km_table *table) {
  static const char *const suffix[] = {".x", ".y", ".z"};
  const char *unit = km_model_units(g->f.m->model).length->suffix;
  bool is_ok = true;
  for (int i = 0; is_ok && g->f.frame >= 0 && i < 3; ++i)
    is_ok = km_table_add_joined_column(table, "point.", g->def->point_name, suffix[i], unit);
  return is_ok;
}

/* Chart of a point on a sphere. */
static bool add_chart(const km_map_search *g, km_table *table) {
  const char *unit = km_model_units(g->f.m->model).length->suffix;
  return g->f.point_surface.radius == 0.0 ||
         (km_table_add_joined_column(table, "chart.", g->def->point_name, ".x", unit) &&
          km_table_add_joined_column(table, "chart.", g->def->point_name, ".y", unit));
}

static bool add_cell_columns(const km_map_search *g, km_table *table) {
  const km_mechanism *m = g->f.m;
  const km_map_figures *figures = g->def->figures;
  int first = g->def->axis[0].coordinate, second = g->def->axis[1].coordinate;
  bool is_ok = table && km_model_add_coordinate_column(m->model, first, table) &&
               km_model_add_coordinate_column(m->model, second, table) &&
               km_table_add_joined_column(table, "sheet", "", "", "") &&
               km_table_add_joined_column(table, "aspect", "", "", "");
  for (int c = 0; is_ok && c < m->coordinate_count; ++c)
    is_ok = c == first || c == second || km_model_add_coordinate_column(m->model, c, table);
  for (int c = 0; is_ok && c < m->coordinate_count; ++c)
    is_ok = km_table_add_joined_column(table, "m.", m->model->coordinates[c].label, "", "");
  is_ok = is_ok && km_table_add_joined_column(table, "sigma.input", "", "", "") &&
          km_table_add_joined_column(table, "sigma.closure", "", "", "") && add_point(g, table);
  if (is_ok && g->f.frame >= 0)
    is_ok = km_table_add_joined_column(table, "sigma.output", "", "", "") &&
            km_table_add_joined_column(table, "manipulability", "", "", "") && add_chart(g, table);
  for (int i = 0; is_ok && figures && i < figures->count; ++i)
    is_ok = km_table_add_joined_column(table, figures->names[i], "", "", figures->units[i]);
  return is_ok;
}

static bool add_curve_columns(const km_map_search *g, km_table *table) {
  bool is_ok = table && km_table_add_joined_column(table, "curve", "", "", "") &&
               km_table_add_joined_column(table, "kind", "", "", "");
  for (int c = 0; is_ok && c < g->f.m->coordinate_count; ++c)
    is_ok = km_model_add_coordinate_column(g->f.m->model, c, table);
  return is_ok && add_point(g, table) && add_chart(g, table);
}

static bool add_boundary_columns(const km_map_search *g, km_table *table) {
  return table && km_table_add_joined_column(table, "loop", "", "", "") &&
         km_table_add_joined_column(table, "kind", "", "", "") &&
         km_table_add_joined_column(table, "curve", "", "", "") && add_point(g, table) && add_chart(g, table);
}

bool km_map_add_columns(km_map_search *g) {
  return add_cell_columns(g, g->out->cells) && add_curve_columns(g, g->out->curves) &&
         (g->f.frame < 0 || add_boundary_columns(g, g->out->boundary));
}

/* Copies N orthogonal to all spins z of rods: N <- N − z (zᵀ N) / (zᵀ z); rods have no joint in
 * common. */
static void leave_out_spins(km_driver_surface *f, const double *N, double *out, double *z) {
  int n = f->columns;
  memcpy(out, N, 2 * (size_t)n * sizeof *out);
  for (int i = 0; i < f->rod_count; ++i) {
    km_driver_surface_spin(f, i, z);
    double square = km_dot(z, z, n);
    for (int d = 0; d < 2; ++d) {
      double part = km_dot(z, N + d * n, n) / square;
      for (int k = 0; k < n; ++k)
        out[d * n + k] -= part * z[k];
    }
  }
}

/* Writes m_j of every coordinate. */
static void write_mobility_numbers(const km_driver_surface *f, const double *N, double *row) {
  int n = f->columns;
  double S[3] = {0.0, 0.0, 0.0}; /* Nᵀ N: (0,0), (0,1), (1,1) */
  for (int k = 0; k < n; ++k) {
    S[0] += N[k] * N[k];
    S[1] += N[k] * N[n + k];
    S[2] += N[n + k] * N[n + k];
  }
  double determinant = S[0] * S[2] - S[1] * S[1];
  for (int k = 0; k < n; ++k)
    row[km_driver_surface_coordinate(f, k)] =
        (N[k] * N[k] * S[2] - 2.0 * N[k] * N[n + k] * S[1] + N[n + k] * N[n + k] * S[0]) / determinant;
}

/* D = G N [2 × 2], rows x and y. */
static void output_jacobian(km_driver_surface *f, const double *N, double *D) {
  memset(D, 0, 4 * sizeof *D);
  km_driver_surface_update_output(f);
  for (int k = 0; k < f->columns; ++k)
    for (int i = 0; i < 2; ++i)
      for (int d = 0; d < 2; ++d)
        D[2 * i + d] += f->G[i * f->columns + k] * N[d * f->columns + k];
}

/* Writes place, smallest singular value and manipulability of the point. *sign: that of det D. Returns their number. */
static int write_output(km_map_search *g, const double *N, double *row, int *sign) {
  double D[4];
  *sign = 0;
  if (g->f.frame < 0)
    return 0;
  output_jacobian(&g->f, N, D);
  km_frame_position(g->f.m, g->f.s, g->f.frame, row);
  double determinant = D[0] * D[3] - D[1] * D[2], squares = D[0] * D[0] + D[1] * D[1] + D[2] * D[2] + D[3] * D[3];
  double root = sqrt(fmax(squares * squares - 4.0 * determinant * determinant, 0.0));
  row[3] = squares > 0.0 ? fabs(determinant) / sqrt(0.5 * (squares + root)) : 0.0;
  row[4] = fabs(determinant);
  *sign = fabs(determinant) <= singular * squares ? 0 : determinant < 0.0 ? -1 : 1;
  if (g->f.point_surface.radius == 0.0)
    return 5;
  row[5] = row[6] = 0.0; /* the chart is chosen at the end */
  return 7;
}

/* Writes the caller's figures. False: the caller ends the map, or out of memory. */
static bool write_figures(km_map_search *g, double *row) {
  const km_map_figures *figures = g->def->figures;
  if (!figures)
    return true;
  km_mobility mobility;
  km_state_copy(g->f.m, g->at, g->f.s);
  if (km_mobility_compute(g->f.m, g->at, &mobility))
    return false;
  g->is_ended = !figures->compute(figures->context, g->f.m, g->at, row);
  return !g->is_ended;
}

bool km_map_fill_row(km_map_search *g, int cell, int sheet, const double *N, int *output_sign) {
  km_driver_surface *f = &g->f;
  int coordinates = f->m->coordinate_count;
  double *row = g->rows + (size_t)cell * km_table_columns(g->out->cells);
  for (int d = 0; d < 2; ++d)
    *row++ = km_state_value(f->s, g->def->axis[d].coordinate);
  *row++ = sheet;
  *row++ = 0.0;
  for (int c = 0; c < coordinates; ++c)
    if (c != g->def->axis[0].coordinate && c != g->def->axis[1].coordinate)
      *row++ = km_state_value(f->s, c);
  memset(row, 0, (size_t)coordinates * sizeof *row);
  leave_out_spins(f, N, g->edge_N, f->step);
  write_mobility_numbers(f, g->edge_N, row);
  row += coordinates;
  *row++ = km_driver_surface_input_value(f);
  *row++ = km_driver_surface_closure_value(f);
  row += write_output(g, N, row, output_sign);
  km_kept_clearance_update(&f->kept, f->m, f->s);
  g->is_written[cell] = (!g->def->within_limits || !km_driver_surface_is_outside_limit(f)) &&
                        km_kept_clearance_least(&f->kept, -1) >= 0.0;
  return write_figures(g, row);
}
