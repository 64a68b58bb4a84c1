/* Maps over two drivers (docs/theory.md 4.19): one sheet for each assembly mode, followed from cell to cell.
 *
 *   predictor : dq = −A⁻¹ B du from a neighbour;   corrector: Newton's method with the drivers fixed
 *   accepted  : first correction ≤ 0.3 |dq|, and det A keeps its sign; else the step is halved
 *   N = (−A⁻¹ B; I);   m_j = N_j (Nᵀ N)⁻¹ N_jᵀ,   smallest singular values of A and of J */
#include "base/arguments.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "space/real_solve.h"
#include "space/singularity_curves.h"

#include <string.h>

enum { MOST_NEWTON = 8, MOST_SWEEPS = 30 };
static const double closed = 1e-13;          /* largest error of a cell: radians, sizes */
static const double most_correction = 0.3;   /* first correction over the predicted step */
static const double orthogonal = 1e-30;      /* squared cosine of columns that are orthogonal to rounding */
static const double shortest_part = 1e-3;    /* shortest step, a part of the way between grid points */
static const double least_correction = 1e-9; /* corrections below this are rounding */

typedef struct map_search {
  km_driver_surface f;
  const km_space_map_def *def;
  km_arena arena;
  int across, down;  /* grid points along both drivers */
  double *before;    /* [3 · columns] start of a step */
  double *saved, *N; /* [cell][3 · columns], [cell][2 · rows] */
  signed char *sign; /* [cell] of det A; 0: not reached */
  int *queue;
  double *transposed; /* [columns × rows] Jᵀ */
  km_space_map *out;
} map_search;

/* Value of an axis at a grid point, scaled. */
static double axis_value(const map_search *g, int axis, int i) {
  const km_space_axis *a = &g->def->axis[axis];
  int c = a->coordinate;
  double value = a->from + (a->to - a->from) * i / a->steps;
  return value * g->f.m->factor[c] / g->f.m->unit[c];
}

static double scaled_value(const map_search *g, int axis) {
  int c = g->def->axis[axis].coordinate;
  return g->f.s->q[c] / g->f.m->unit[c];
}

/* Closes the loops with the drivers fixed. On success A's factors, J and *sign belong to the configuration. */
static bool close_cell(map_search *g, double predicted, int *sign) {
  km_driver_surface *f = &g->f;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double error = 0.0, correction = 0.0;
    km_driver_surface_update(f);
    if (!km_driver_surface_factor(f, sign))
      return false;
    const double *e = km_state_error(f->s, km_driver_surface_part(f));
    for (int k = 0; k < f->rows; ++k) {
      error = fmax(error, fabs(e[k]));
      f->b[k] = -e[k];
    }
    if (error <= closed)
      return true;
    if (!isfinite(error))
      return false;
    km_real_solve(f->A, f->rows, f->row, f->b, f->x);
    memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
    for (int k = 0; k < f->rows; ++k) {
      f->step[f->other[k]] = f->x[k];
      correction = fmax(correction, fabs(f->x[k]));
    }
    if (i == 0 && correction > most_correction * predicted + least_correction)
      return false;
    if (i > 1 && correction < 1e-13) /* the error is rounding */
      return true;
    km_driver_surface_move(f, f->step);
  }
  return false;
}

/* N' = −A⁻¹ B at the present factors: N[2][rows]. */
static void tangents(map_search *g, double *N) {
  km_driver_surface *f = &g->f;
  for (int d = 0; d < 2; ++d) {
    for (int k = 0; k < f->rows; ++k)
      f->b[k] = -f->J[f->control[d] * f->rows + k];
    km_real_solve(f->A, f->rows, f->row, f->b, N + d * f->rows);
  }
}

/* Moves the drivers by `part` of the way to a grid point, from a configuration with tangents N. */
static bool advance(map_search *g, const double *target, const double *N, int sign, double part) {
  km_driver_surface *f = &g->f;
  double du[2], largest = 0.0;
  int reached;
  for (int d = 0; d < 2; ++d)
    du[d] = (target[d] - scaled_value(g, d)) * part;
  for (int k = 0; k < f->rows; ++k) {
    f->step[f->other[k]] = du[0] * N[k] + du[1] * N[f->rows + k];
    largest = fmax(largest, fabs(f->step[f->other[k]]));
  }
  for (int d = 0; d < 2; ++d) {
    f->step[f->control[d]] = du[d];
    largest = fmax(largest, fabs(du[d]));
  }
  km_driver_surface_move(f, f->step);
  return close_cell(g, largest, &reached) && reached == sign;
}

/* Moves to a grid point from the configuration g->before with tangents N; a rejected step is halved. */
static bool move_to(map_search *g, const double *target, double *N, int sign) {
  km_driver_surface *f = &g->f;
  double left = 1.0, step = 1.0; /* parts of the whole way */
  while (left > 0.0) {
    km_driver_surface_restore(f, g->before);
    step = fmin(step, left);
    if (advance(g, target, N, sign, step / left)) {
      left = step == left ? 0.0 : left - step;
      step *= 2.0;
      if (left > 0.0) {
        km_driver_surface_save(f, g->before);
        tangents(g, N);
      }
    } else {
      step *= 0.5;
      if (step < shortest_part)
        return false;
    }
  }
  return true;
}

/* Tries a cell from its neighbour. */
static bool reach(map_search *g, int from, int cell, double *N) {
  const double target[2] = {axis_value(g, 0, cell % g->across), axis_value(g, 1, cell / g->across)};
  size_t saved = g->f.saved_size, size = 2 * (size_t)g->f.rows;
  memcpy(g->before, g->saved + (size_t)from * saved, saved * sizeof *g->before);
  memcpy(N, g->N + (size_t)from * size, size * sizeof *N);
  return move_to(g, target, N, g->sign[from]);
}

/* Smallest singular value of a matrix with at least as many rows as columns, whose columns lie one after another, by
 * rotations of pairs of columns until they are orthogonal (one-sided Jacobi method, M. R. Hestenes 1958). A is
 * destroyed. */
static double smallest_singular_value(double *A, int rows, int columns) {
  bool is_rotated = true;
  for (int sweep = 0; is_rotated && sweep < MOST_SWEEPS; ++sweep) {
    is_rotated = false;
    for (int i = 0; i < columns; ++i)
      for (int j = i + 1; j < columns; ++j) {
        double *a = A + i * rows, *b = A + j * rows, aa = 0.0, bb = 0.0, ab = 0.0;
        for (int k = 0; k < rows; ++k) {
          aa += a[k] * a[k];
          bb += b[k] * b[k];
          ab += a[k] * b[k];
        }
        if (!(ab * ab > orthogonal * aa * bb))
          continue;
        is_rotated = true;
        double zeta = (bb - aa) / (2.0 * ab), t = copysign(1.0, zeta) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
        double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
        for (int k = 0; k < rows; ++k) {
          double kept = a[k];
          a[k] = c * kept - s * b[k];
          b[k] = s * kept + c * b[k];
        }
      }
  }
  double smallest = HUGE_VAL;
  for (int i = 0; i < columns; ++i) {
    double square = 0.0;
    for (int k = 0; k < rows; ++k)
      square += A[i * rows + k] * A[i * rows + k];
    smallest = fmin(smallest, square);
  }
  return sqrt(smallest);
}

/* Writes the row of the present cell. N: tangents there. */
static bool write_cell(map_search *g, int sheet, const double *N) {
  const km_driver_surface *f = &g->f;
  double *row = km_table_add_row(g->out->cells);
  if (!row)
    return false;
  *row++ = sheet;
  for (int c = 0; c < f->m->coordinate_count; ++c)
    row[c] = km_state_value(f->s, c);
  row += f->m->coordinate_count;
  double G[3] = {1.0, 0.0, 1.0}; /* Nᵀ N: (0,0), (0,1), (1,1) */
  for (int k = 0; k < f->rows; ++k) {
    G[0] += N[k] * N[k];
    G[1] += N[k] * N[f->rows + k];
    G[2] += N[f->rows + k] * N[f->rows + k];
  }
  double determinant = G[0] * G[2] - G[1] * G[1];
  for (int k = 0; k < f->columns; ++k) {
    double z[2] = {f->control[0] == k, f->control[1] == k};
    for (int i = 0; i < f->rows; ++i)
      if (f->other[i] == k) {
        z[0] = N[i];
        z[1] = N[f->rows + i];
      }
    row[f->m->column_coordinate[km_driver_surface_part(f)->column_start + k]] =
        (z[0] * z[0] * G[2] - 2.0 * z[0] * z[1] * G[1] + z[1] * z[1] * G[0]) / determinant;
  }
  row += f->m->coordinate_count;
  for (int j = 0; j < f->rows; ++j)
    memcpy(f->A + (size_t)j * (size_t)f->rows, f->J + (size_t)f->other[j] * (size_t)f->rows,
           (size_t)f->rows * sizeof *f->A);
  row[0] = smallest_singular_value(f->A, f->rows, f->rows);
  for (int i = 0; i < f->rows; ++i)
    for (int k = 0; k < f->columns; ++k)
      g->transposed[i * f->columns + k] = f->J[k * f->rows + i];
  row[1] = smallest_singular_value(g->transposed, f->columns, f->rows);
  return true;
}

/* Records the present cell and puts it into the queue. */
static bool record(map_search *g, int sheet, int cell, int sign, int *tail) {
  km_driver_surface *f = &g->f;
  double *N = g->N + (size_t)cell * 2 * (size_t)f->rows;
  tangents(g, N);
  km_driver_surface_save(f, g->saved + (size_t)cell * f->saved_size);
  g->sign[cell] = (signed char)sign;
  g->queue[(*tail)++] = cell;
  return write_cell(g, sheet, N);
}

/* Moves the state from a mode to the grid point nearest to it. Returns the cell; −1: it isn't reached. */
static int enter_grid(map_search *g, int *sign, double *N) {
  int at[2];
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &g->def->axis[d];
    double part = (km_state_value(g->f.s, a->coordinate) - a->from) / (a->to - a->from) * a->steps;
    at[d] = (int)round(fmin(fmax(part, 0.0), a->steps));
  }
  const double target[2] = {axis_value(g, 0, at[0]), axis_value(g, 1, at[1])};
  if (!close_cell(g, 1.0, sign))
    return -1;
  km_driver_surface_save(&g->f, g->before);
  tangents(g, N);
  return move_to(g, target, N, *sign) ? at[1] * g->across + at[0] : -1;
}

/* Visits the four neighbours of a cell. `*is_edge`: one of them isn't reached. */
static bool visit_neighbours(map_search *g, int sheet, int cell, double *N, int *tail, bool *is_edge) {
  const int side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (int k = 0; k < 4; ++k) {
    int i = cell % g->across + side[k][0], j = cell / g->across + side[k][1], next = j * g->across + i;
    if (i < 0 || j < 0 || i >= g->across || j >= g->down || g->sign[next])
      continue;
    if (!reach(g, cell, next, N))
      *is_edge = true;
    else if (!record(g, sheet, next, g->sign[cell], tail))
      return false;
  }
  return true;
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the map");
}

/* Follows one sheet from the state's mode. */
static km_status follow_sheet(map_search *g, int sheet, km_singularity_curves *curves, double *N, km_progress progress,
                              void *context, km_error *error) {
  int cells = g->across * g->down, tail = 0, sign;
  memset(g->sign, 0, (size_t)cells);
  int first = enter_grid(g, &sign, N);
  if (first < 0)
    return KM_OK;
  if (!record(g, sheet, first, sign, &tail))
    return no_memory(error);
  double reach_of_curve = 0.0;
  for (int d = 0; d < 2; ++d)
    reach_of_curve = fmax(reach_of_curve, fabs(axis_value(g, d, 1) - axis_value(g, d, 0)));
  for (int head = 0; head < tail; ++head) {
    bool is_edge = false;
    int cell = g->queue[head];
    if (head % 256 == 0 && progress && !progress(context, (double)head / cells))
      return km_fail(error, KM_CANCELLED, "stopped while the map was followed");
    if (!visit_neighbours(g, sheet, cell, N, &tail, &is_edge))
      return no_memory(error);
    const double *saved = g->saved + (size_t)cell * g->f.saved_size;
    if (is_edge && !km_singularity_curves_add(curves, saved, 3.0 * reach_of_curve))
      return no_memory(error);
  }
  ++g->out->sheet_count;
  return KM_OK;
}

/* ---- Preparation. */

static bool add_columns(const km_mechanism *m, km_table *table, const char *first, bool has_figures) {
  bool is_ok = table && km_table_add_column(table, first, "") >= 0;
  km_text name = {0};
  for (int k = 0; is_ok && k < (has_figures ? 2 : 1) * m->coordinate_count; ++k) {
    int c = k % m->coordinate_count;
    bool is_number = k >= m->coordinate_count;
    name.size = 0;
    km_text_format(&name, "%s.%s", is_number ? "m" : "q", m->model->coordinates[c].label);
    is_ok = !name.failed &&
            km_table_add_column(table, name.data, is_number ? "" : km_model_coordinate_unit(m->model, c)) >= 0;
  }
  if (is_ok && has_figures)
    is_ok = km_table_add_column(table, "sigma.input", "") >= 0 && km_table_add_column(table, "sigma.closure", "") >= 0;
  km_text_free(&name);
  return is_ok;
}

static km_status check_axes(const km_mechanism *m, const km_space_map_def *def, km_error *error) {
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &def->axis[d];
    km_status status = km_check_index(a->coordinate, m->coordinate_count, "coordinate", error);
    if (status)
      return status;
    if (!isfinite(a->from) || !isfinite(a->to) || a->from == a->to || a->steps < 1 || a->steps > KM_MAX_MAP_STEPS)
      return km_fail(
          error, KM_USAGE,
          "the range of joint \"%s\" is %g to %g in %d steps; expected two different numbers and 1 to %d steps",
          m->model->coordinates[a->coordinate].label, a->from, a->to, a->steps, KM_MAX_MAP_STEPS);
  }
  return def->axis[0].coordinate != def->axis[1].coordinate
             ? KM_OK
             : km_fail(error, KM_USAGE, "both drivers of a map must be different joints of one part of the mechanism");
}

/* Prepares the surface and the grid. */
static km_status prepare(map_search *g, km_error *error) {
  km_driver_surface *f = &g->f;
  const km_space_map_def *def = g->def;
  const int drivers[2] = {def->axis[0].coordinate, def->axis[1].coordinate};
  for (int d = 0; d < 2; ++d) {
    f->low[d] = fmin(def->axis[d].from, def->axis[d].to);
    f->high[d] = fmax(def->axis[d].from, def->axis[d].to);
  }
  km_status status = km_driver_surface_create(f, drivers, &g->arena, error);
  if (status)
    return status;
  size_t n = (size_t)f->columns, r = (size_t)f->rows;
  g->across = def->axis[0].steps + 1;
  g->down = def->axis[1].steps + 1;
  size_t cells = (size_t)g->across * (size_t)g->down;
  g->saved = KM_ARENA_NEW(&g->arena, double, cells * f->saved_size);
  g->N = KM_ARENA_NEW(&g->arena, double, cells * 2 * r + 1);
  g->sign = KM_ARENA_NEW(&g->arena, signed char, cells);
  g->queue = KM_ARENA_NEW(&g->arena, int, cells);
  g->before = KM_ARENA_NEW(&g->arena, double, f->saved_size);
  g->transposed = KM_ARENA_NEW(&g->arena, double, n *r + 1);
  if (g->arena.failed)
    return no_memory(error);
  g->out->cells = km_table_create();
  g->out->curves = km_table_create();
  return add_columns(f->m, g->out->cells, "sheet", true) && add_columns(f->m, g->out->curves, "curve", false)
             ? KM_OK
             : no_memory(error);
}

static km_status follow_sheets(map_search *g, const km_all_modes *modes, km_progress progress, void *context,
                               km_error *error) {
  km_driver_surface *f = &g->f;
  km_singularity_curves *curves = km_singularity_curves_create(f, g->out->curves);
  double *N = KM_ARENA_NEW(&g->arena, double, 2 * (size_t)f->rows + 1);
  km_status status = curves && N ? KM_OK : no_memory(error);
  for (int i = 0; !status && i < modes->count; ++i) {
    status =
        km_state_set_coordinates(f->m, f->s, modes->coordinates + (size_t)i * (size_t)f->m->coordinate_count, error);
    if (!status)
      status = follow_sheet(g, i + 1, curves, N, progress, context, error);
  }
  g->out->curve_count = km_singularity_curves_count(curves);
  km_singularity_curves_free(curves);
  return status;
}

km_status km_space_map_compute(const km_mechanism *m, const km_state *s, const km_space_map_def *def,
                               const km_all_modes *modes, km_progress progress, void *context, km_space_map *out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_space_map){0};
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(def && modes && (modes->coordinates || modes->count == 0), "definition or modes of the map",
                            error);
  if (!status)
    status = check_axes(m, def, error);
  if (status)
    return status;
  map_search g = {.f = {.m = m}, .def = def, .out = out};
  status = km_state_create(m, &g.f.s, error);
  if (!status) {
    km_state_copy(m, g.f.s, s);
    status = prepare(&g, error);
  }
  if (!status)
    status = follow_sheets(&g, modes, progress, context, error);
  km_arena_free(&g.arena);
  km_state_free(g.f.s);
  return status;
}

void km_space_map_free(km_space_map *map) {
  if (!map)
    return;
  km_table_free(map->cells);
  km_table_free(map->curves);
  *map = (km_space_map){0};
}
