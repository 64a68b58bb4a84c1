/* Maps over two drivers (docs/theory.md 4.19): one sheet for each assembly mode, followed from cell to cell.
 *
 *   predictor : dq = −A⁻¹ B du from a neighbour;   corrector: Newton's method with the drivers fixed
 *   accepted  : first correction ≤ 0.3 |dq|, and det A keeps its sign; else the step is halved
 *   N = (−A⁻¹ B; I);   m_j = N_j (Nᵀ N)⁻¹ N_jᵀ,   smallest singular values of A and of J
 *   D = G N            of a point in its plane: smallest singular value, |det D| */
#include "base/arguments.h"
#include "base/table.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "space/singularity_curves.h"

#include <string.h>

enum {
  LEAST_CELLS = 10 /* grid points of a sheet that begins at a curve */,
  CURVE_STRIDE = 4 /* points of a curve from one start of sheets to the next */
};
static const double most_correction = 0.3;   /* first correction over the predicted step */
static const double shortest_part = 1e-3;    /* shortest step, a part of the way between grid points */
static const double leaving_distance = 0.05; /* distance of a start from its singularity curve */
static const double same_turn = 1e-6; /* difference of angles and configurations that are one but for full turns */
static const double least_correction = 1e-9; /* corrections below this are rounding */

/* A configuration that a sheet has at a grid point. */
typedef struct known_configuration {
  const double *saved;
  const struct known_configuration *next;
} known_configuration;

typedef struct map_search {
  km_driver_surface f;
  const km_space_map_def *def;
  km_arena arena;
  int across, down;                  /* grid points along both drivers */
  double *before;                    /* [3 · columns] start of a step */
  double *saved, *N;                 /* [cell][3 · columns], [cell][2 · columns] */
  signed char *sign;                 /* [cell] of det A; 0: not reached */
  const known_configuration **known; /* [cell] those of all sheets */
  int *queue;
  signed char *output_sign; /* [cell] of det D; 0: no point */
  double *rows;             /* [cell × columns of the table] of the present sheet */
  bool *is_written;         /* [cell] it has a row */
  int *aspect;              /* [cell] its aspect; 0: none yet */
  int aspect_count;         /* aspects of all sheets so far */
  bool is_ended;            /* the caller's figures end the map */
  km_state *at;             /* state for the caller's figures; NULL: none */
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

/* Closes the loops with the drivers fixed, where a step was predicted. */
static bool close_cell(map_search *g, double predicted, int *sign) {
  return km_driver_surface_close(&g->f, most_correction * predicted + least_correction, sign);
}

/* Moves the drivers by `part` of the way to a grid point, from a configuration with tangents N. */
static bool advance(map_search *g, const double *target, const double *N, int sign, double part) {
  km_driver_surface *f = &g->f;
  double du[2], largest = 0.0;
  int reached;
  for (int d = 0; d < 2; ++d)
    du[d] = (target[d] - scaled_value(g, d)) * part;
  for (int k = 0; k < f->columns; ++k) {
    f->step[k] = du[0] * N[k] + du[1] * N[f->columns + k];
    largest = fmax(largest, fabs(f->step[k]));
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
        km_driver_surface_rates(&g->f, N);
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
  size_t saved = g->f.saved_size, size = 2 * (size_t)g->f.columns;
  memcpy(g->before, g->saved + (size_t)from * saved, saved * sizeof *g->before);
  memcpy(N, g->N + (size_t)from * size, size * sizeof *N);
  return move_to(g, target, N, g->sign[from]);
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
static int write_output(map_search *g, const double *N, double *row, int *sign) {
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
  *sign = determinant < 0.0 ? -1 : 1;
  return 5;
}

/* Writes the caller's figures. False: the caller ends the map, or out of memory. */
static bool write_figures(map_search *g, double *row) {
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

/* Fills the row of the present cell, its aspect left open. N: tangents there. *output_sign: that of det D. */
static bool fill_row(map_search *g, int cell, int sheet, const double *N, int *output_sign) {
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
  write_mobility_numbers(f, N, row);
  row += coordinates;
  *row++ = km_driver_surface_input_value(f);
  *row++ = km_driver_surface_closure_value(f);
  row += write_output(g, N, row, output_sign);
  g->is_written[cell] = !g->def->within_limits || !km_driver_surface_is_outside_limit(f);
  return write_figures(g, row);
}

/* The cell across the seam of an axis that is a full turn of a hinge: the same configuration; −1: there is none. */
static int across_seam(map_search *g, int cell, int axis) {
  const km_space_axis *a = &g->def->axis[axis];
  int i = cell % g->across, j = cell / g->across, last = axis == 0 ? g->across - 1 : g->down - 1;
  int at = axis == 0 ? i : j, other = last - at;
  double turn = fabs(a->to - a->from) * g->f.m->factor[a->coordinate];
  if ((at != 0 && at != last) || !km_coordinate_turns(g->f.m, a->coordinate) || fabs(turn - 2.0 * M_PI) > same_turn)
    return -1;
  int next = axis == 0 ? j * g->across + other : other * g->across + i;
  if (!g->sign[next])
    return -1;
  km_driver_surface_restore(&g->f, g->saved + (size_t)cell * g->f.saved_size);
  return km_driver_surface_difference(&g->f, g->saved + (size_t)next * g->f.saved_size, g->f.step) < same_turn ? next
                                                                                                               : -1;
}

/* Numbers the aspect of a cell: all cells that steps of the grid connect without a singularity of the drivers or of the
 * output. `stack`[cell] is workspace. */
static void number_aspect(map_search *g, int first, int *stack) {
  const int side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  int size = 0;
  g->aspect[first] = ++g->aspect_count;
  stack[size++] = first;
  while (size > 0) {
    int cell = stack[--size];
    for (int k = 0; k < 4; ++k) {
      int i = cell % g->across + side[k][0], j = cell / g->across + side[k][1], next = j * g->across + i;
      if (i < 0 || j < 0 || i >= g->across || j >= g->down || !g->sign[next] || g->aspect[next] ||
          g->output_sign[next] != g->output_sign[cell])
        continue;
      g->aspect[next] = g->aspect_count;
      stack[size++] = next;
    }
    for (int d = 0; d < 2; ++d) {
      int next = across_seam(g, cell, d);
      if (next < 0 || g->aspect[next])
        continue;
      g->aspect[next] = g->aspect_count;
      stack[size++] = next;
    }
  }
}

/* Writes the rows of the sheet's `count` cells, in the order in which they were reached. */
static bool write_sheet(map_search *g, int count) {
  size_t width = km_table_columns(g->out->cells);
  memset(g->aspect, 0, (size_t)g->across * (size_t)g->down * sizeof *g->aspect);
  for (int i = 0; i < count; ++i) {
    int cell = g->queue[i];
    if (!g->aspect[cell])
      number_aspect(g, cell, g->queue + count);
    double *row = g->is_written[cell] ? km_table_add_row(g->out->cells) : NULL;
    if (row) {
      memcpy(row, g->rows + (size_t)cell * width, width * sizeof *row);
      row[3] = g->aspect[cell];
    } else if (g->is_written[cell]) {
      return false;
    }
  }
  return true;
}

/* True if a sheet has the state's configuration at this cell, full turns of hinges left out. */
static bool is_known(const map_search *g, int cell) {
  for (const known_configuration *at = g->known[cell]; at; at = at->next)
    if (km_driver_surface_difference(&g->f, at->saved, g->f.step) < same_turn)
      return true;
  return false;
}

static bool note_configuration(map_search *g, int cell) {
  known_configuration *known = KM_ARENA_NEW(&g->arena, known_configuration, 1);
  double *saved = KM_ARENA_NEW(&g->arena, double, g->f.saved_size);
  if (!known || !saved)
    return false;
  km_driver_surface_save(&g->f, saved);
  *known = (known_configuration){saved, g->known[cell]};
  g->known[cell] = known;
  return true;
}

/* Records the present cell and puts it into the queue. */
static bool record(map_search *g, int sheet, int cell, int sign, int *tail) {
  km_driver_surface *f = &g->f;
  double *N = g->N + (size_t)cell * 2 * (size_t)f->columns;
  int output_sign = 0;
  km_driver_surface_rates(&g->f, N);
  km_driver_surface_save(f, g->saved + (size_t)cell * f->saved_size);
  g->sign[cell] = (signed char)sign;
  g->queue[(*tail)++] = cell;
  bool is_ok = note_configuration(g, cell) && fill_row(g, cell, sheet, N, &output_sign);
  g->output_sign[cell] = (signed char)output_sign;
  return is_ok;
}

/* Moves the state from a mode to the grid point nearest to it. Returns the cell; −1: it isn't reached. */
static int enter_grid(map_search *g, int *sign, double *N) {
  int at[2];
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &g->def->axis[d];
    if (km_coordinate_turns(g->f.m, a->coordinate)) { /* the full turn that is nearest to the range */
      double middle = 0.5 * (a->from + a->to) * g->f.m->factor[a->coordinate];
      g->f.s->q[a->coordinate] = middle + remainder(g->f.s->q[a->coordinate] - middle, 2.0 * M_PI);
    }
    double part = (km_state_value(g->f.s, a->coordinate) - a->from) / (a->to - a->from) * a->steps;
    at[d] = (int)round(fmin(fmax(part, 0.0), a->steps));
  }
  const double target[2] = {axis_value(g, 0, at[0]), axis_value(g, 1, at[1])};
  if (!close_cell(g, 1.0, sign))
    return -1;
  km_driver_surface_save(&g->f, g->before);
  km_driver_surface_rates(&g->f, N);
  return move_to(g, target, N, *sign) ? at[1] * g->across + at[0] : -1;
}

/* Visits the four neighbours of a cell. `*is_edge`: one of them isn't reached. `*is_turned`: det D has another sign
 * there. */
static bool visit_neighbours(map_search *g, int sheet, int cell, double *N, int *tail, bool *is_edge, bool *is_turned) {
  const int side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (int k = 0; k < 4; ++k) {
    int i = cell % g->across + side[k][0], j = cell / g->across + side[k][1], next = j * g->across + i;
    if (i < 0 || j < 0 || i >= g->across || j >= g->down)
      continue;
    if (!g->sign[next] && !reach(g, cell, next, N))
      *is_edge = true;
    else if (!g->sign[next] && !is_known(g, next) && !record(g, sheet, next, g->sign[cell], tail))
      return false;
    *is_turned = *is_turned || (g->sign[next] && g->output_sign[cell] * g->output_sign[next] < 0);
  }
  return true;
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the map");
}

/* Status where a cell wasn't recorded. */
static km_status not_recorded(const map_search *g, km_error *error) {
  return g->is_ended ? km_fail(error, KM_CANCELLED, "a figure of the map can't be computed, or ended it")
                     : no_memory(error);
}

/* Follows one sheet from the state's configuration; it counts if it has at least `least` grid points. */
static km_status follow_sheet(map_search *g, int sheet, int least, km_singularity_curves *curves, double *N,
                              km_progress progress, void *context, km_error *error) {
  int cells = g->across * g->down, tail = 0, sign;
  memset(g->sign, 0, (size_t)cells);
  int first = enter_grid(g, &sign, N);
  if (first < 0 || is_known(g, first))
    return KM_OK;
  if (!record(g, sheet, first, sign, &tail))
    return not_recorded(g, error);
  double reach_of_curve = 0.0;
  for (int d = 0; d < 2; ++d)
    reach_of_curve = fmax(reach_of_curve, fabs(axis_value(g, d, 1) - axis_value(g, d, 0)));
  for (int head = 0; head < tail; ++head) {
    bool is_edge = false, is_turned = false;
    int cell = g->queue[head];
    if (head % 256 == 0 && progress && !progress(context, (double)head / cells))
      return km_fail(error, KM_CANCELLED, "stopped while the map was followed");
    if (!visit_neighbours(g, sheet, cell, N, &tail, &is_edge, &is_turned))
      return not_recorded(g, error);
    const double *saved = g->saved + (size_t)cell * g->f.saved_size;
    if ((is_edge && !km_singularity_curves_add(curves, KM_SINGULARITY_INPUT, saved, 3.0 * reach_of_curve)) ||
        (is_turned && !km_singularity_curves_add(curves, KM_SINGULARITY_OUTPUT, saved, 3.0 * reach_of_curve)))
      return no_memory(error);
  }
  if (tail < least)
    return KM_OK; /* grid points at the edge of another sheet */
  ++g->out->sheet_count;
  return write_sheet(g, tail) ? KM_OK : no_memory(error);
}

/* ---- Preparation. */

static bool add_coordinate(const km_mechanism *m, km_table *table, int c) {
  return km_table_add_joined_column(table, "q.", m->model->coordinates[c].label, "",
                                    km_model_coordinate_unit(m->model, c));
}

/* x, y, z of the point. */
static bool add_point(const map_search *g, km_table *table) {
  static const char *const suffix[] = {".x", ".y", ".z"};
  const char *unit = km_model_units(g->f.m->model).length->suffix;
  bool is_ok = true;
  for (int i = 0; is_ok && g->f.frame >= 0 && i < 3; ++i)
    is_ok = km_table_add_joined_column(table, "point.", g->def->point_name, suffix[i], unit);
  return is_ok;
}

static bool add_cell_columns(const map_search *g, km_table *table) {
  const km_mechanism *m = g->f.m;
  const km_map_figures *figures = g->def->figures;
  int first = g->def->axis[0].coordinate, second = g->def->axis[1].coordinate;
  bool is_ok = table && add_coordinate(m, table, first) && add_coordinate(m, table, second) &&
               km_table_add_joined_column(table, "sheet", "", "", "") &&
               km_table_add_joined_column(table, "aspect", "", "", "");
  for (int c = 0; is_ok && c < m->coordinate_count; ++c)
    is_ok = c == first || c == second || add_coordinate(m, table, c);
  for (int c = 0; is_ok && c < m->coordinate_count; ++c)
    is_ok = km_table_add_joined_column(table, "m.", m->model->coordinates[c].label, "", "");
  is_ok = is_ok && km_table_add_joined_column(table, "sigma.input", "", "", "") &&
          km_table_add_joined_column(table, "sigma.closure", "", "", "") && add_point(g, table);
  if (is_ok && g->f.frame >= 0)
    is_ok = km_table_add_joined_column(table, "sigma.output", "", "", "") &&
            km_table_add_joined_column(table, "manipulability", "", "", "");
  for (int i = 0; is_ok && figures && i < figures->count; ++i)
    is_ok = km_table_add_joined_column(table, figures->names[i], "", "", figures->units[i]);
  return is_ok;
}

static bool add_curve_columns(const map_search *g, km_table *table) {
  bool is_ok = table && km_table_add_joined_column(table, "curve", "", "", "") &&
               km_table_add_joined_column(table, "kind", "", "", "");
  for (int c = 0; is_ok && c < g->f.m->coordinate_count; ++c)
    is_ok = add_coordinate(g->f.m, table, c);
  return is_ok && add_point(g, table);
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
  km_status status = def->has_point ? km_check_index(def->frame, m->model->frame_count, "frame", error) : KM_OK;
  if (!status && def->has_point)
    status = km_check_given(def->point_name != NULL, "name of the point", error);
  if (status)
    return status;
  return def->axis[0].coordinate != def->axis[1].coordinate
             ? KM_OK
             : km_fail(error, KM_USAGE, "both drivers of a map are the same joint; expected two");
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
  km_status status = km_driver_surface_create(
      f, drivers, 2, "two freedoms and no redundant conditions (more freedoms: hold joints)", &g->arena, error);
  if (status)
    return status;
  g->across = def->axis[0].steps + 1;
  g->down = def->axis[1].steps + 1;
  size_t cells = (size_t)g->across * (size_t)g->down;
  g->saved = KM_ARENA_NEW(&g->arena, double, cells * f->saved_size);
  g->N = KM_ARENA_NEW(&g->arena, double, cells * 2 * (size_t)f->columns);
  g->known = KM_ARENA_NEW(&g->arena, const known_configuration *, cells);
  g->sign = KM_ARENA_NEW(&g->arena, signed char, cells);
  g->output_sign = KM_ARENA_NEW(&g->arena, signed char, cells);
  g->queue = KM_ARENA_NEW(&g->arena, int, 2 * cells); /* and the stack of number_aspect */
  g->before = KM_ARENA_NEW(&g->arena, double, f->saved_size);
  if (g->arena.failed)
    return no_memory(error);
  g->out->cells = km_table_create();
  g->out->curves = km_table_create();
  if (!add_cell_columns(g, g->out->cells) || !add_curve_columns(g, g->out->curves))
    return no_memory(error);
  g->rows = KM_ARENA_NEW(&g->arena, double, cells *km_table_columns(g->out->cells));
  g->is_written = KM_ARENA_NEW(&g->arena, bool, cells);
  g->aspect = KM_ARENA_NEW(&g->arena, int, cells);
  if (def->figures)
    status = km_state_create(f->m, &g->at, error);
  return g->arena.failed ? no_memory(error) : status;
}

/* Closes the loops of an open configuration with all coordinates free. */
static bool close_freely(map_search *g) {
  for (int i = 0; i < g->f.part_count; ++i) {
    km_closure closure;
    int part = g->f.part[i].substructure;
    if (part < 0)
      continue;
    km_state_invalidate_pivots(g->f.s, part);
    if (km_loops_close(g->f.m, g->f.s, part, KM_NO_DRIVER, &closure) != KM_CLOSED)
      return false;
  }
  return true;
}

/* Follows the sheets on both sides of the drivers' singularity curves that no mode has led to. `sheet`: the last number
 * in use. */
static km_status follow_sheets_of_curves(map_search *g, km_singularity_curves *curves, int sheet, double *N,
                                         km_progress progress, void *context, km_error *error) {
  km_status status = KM_OK;
  bool is_point = true;
  for (size_t i = 0; !status && is_point; i += CURVE_STRIDE)
    for (int side = -1; !status && side <= 1; side += 2) {
      int before = g->out->sheet_count;
      if (km_singularity_curves_leave(curves, i, side * leaving_distance, &is_point) && close_freely(g))
        status = follow_sheet(g, sheet + 1, LEAST_CELLS, curves, N, progress, context, error);
      sheet += g->out->sheet_count > before;
    }
  return status;
}

static km_status follow_sheets(map_search *g, const km_all_modes *modes, km_progress progress, void *context,
                               km_error *error) {
  km_driver_surface *f = &g->f;
  km_singularity_curves *curves = km_singularity_curves_create(f, g->out->curves);
  double *N = KM_ARENA_NEW(&g->arena, double, 2 * (size_t)f->columns);
  km_status status = curves && N ? KM_OK : no_memory(error);
  for (int i = 0; !status && i < modes->count; ++i) {
    status =
        km_state_set_coordinates(f->m, f->s, modes->coordinates + (size_t)i * (size_t)f->m->coordinate_count, error);
    if (!status)
      status = follow_sheet(g, i + 1, 1, curves, N, progress, context, error);
  }
  if (!status && modes->count > 0 && !g->def->own_sheet)
    status = follow_sheets_of_curves(g, curves, modes->count, N, progress, context, error);
  g->out->curve_count = km_singularity_curves_count(curves);
  g->out->aspect_count = g->aspect_count;
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
  map_search g = {.f = {.m = m, .frame = def->has_point ? def->frame : -1}, .def = def, .out = out};
  status = km_state_create(m, &g.f.s, error);
  if (!status) {
    km_state_copy(m, g.f.s, s);
    status = prepare(&g, error);
  }
  if (!status)
    status = follow_sheets(&g, modes, progress, context, error);
  km_arena_free(&g.arena);
  km_state_free(g.f.s);
  km_state_free(g.at);
  return status;
}

const char *km_singularity_kind_name(km_singularity_kind kind) {
  return kind == KM_SINGULARITY_INPUT ? "input" : kind == KM_SINGULARITY_OUTPUT ? "output" : "";
}

void km_space_map_free(km_space_map *map) {
  if (!map)
    return;
  km_table_free(map->cells);
  km_table_free(map->curves);
  *map = (km_space_map){0};
}
