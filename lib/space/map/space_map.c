/* Maps over two drivers (docs/theory.md 4.19): sheets from modes, random configurations and curves, followed from cell
 * to cell (map_steps.c). */
#include "base/arguments.h"
#include "base/random.h"
#include "base/table.h"
#include "kinematics/loop_closing.h"
#include "space/map/map_store.h"
#include "space/map/map_workspace.h"

#include <string.h>

enum {
  LEAST_CELLS = 10 /* grid points of a sheet that begins at a curve or at random */,
  SPREAD_POINTS = 1024, /* grid points that may be random starts */
  SPREAD_STRIDE = 32,
  CLOSING_ROUNDS = 4, /* eight steps of Newton's method each */
  CURVE_STRIDE = 4,   /* points of a curve from one start of sheets to the next */
  PART_CELLS = 64     /* grid points of a part of the search */
};
static const double leaving_distance = 0.05; /* distance of a start from its singularity curve */
/* Part of the work before each share of km_map_share: about that of the five-bar's and the wrist's maps. */
static const double share_ends[] = {0.0, 0.4, 0.6, 0.7, 1.0};
static const double share_of_modes = 0.1; /* maps of models/ spend less of their time on modes */
static const double most_curve_distance =
    0.1; /* largest one of grid points to a known curve for which they don't look for another */

/* Writes the rows of the sheet's cells, in the order in which they were reached. */
static bool write_sheet(km_map_search *g) {
  size_t width = km_table_columns(g->out->cells);
  memset(g->aspect, 0, (size_t)g->across * (size_t)g->down * sizeof *g->aspect);
  for (int i = 0; i < g->tail; ++i) {
    int cell = g->queue[i];
    if (!g->is_written[cell])
      continue;
    bool is_singular = g->f.frame >= 0 && g->output_sign[cell] == 0;
    if (!g->aspect[cell] && !is_singular)
      km_map_number_aspect(g, cell, g->queue + g->tail);
    double *row = km_table_add_row(g->out->cells);
    if (!row)
      return false;
    memcpy(row, g->rows + (size_t)cell * width, width * sizeof *row);
    row[3] = g->known[cell]->aspect = g->aspect[cell];
  }
  return true;
}

km_known_configuration *km_map_find_known(const km_map_search *g, int cell) {
  km_known_configuration *at = g->known[cell];
  while (at && !km_map_is_at(g, at->saved))
    at = at->next;
  return at;
}

bool km_map_note_configuration(km_map_search *g, int cell) {
  km_known_configuration *known = KM_ARENA_NEW(&g->arena, km_known_configuration, 1);
  double *saved = KM_ARENA_NEW(&g->arena, double, g->f.saved_size);
  if (!known || !saved)
    return false;
  km_driver_surface_save(&g->f, saved);
  *known = (km_known_configuration){.saved = saved, .next = g->known[cell]};
  g->known[cell] = known;
  return true;
}

/* Records the present cell and puts it into the queue. */
static bool record(km_map_search *g, int cell, int sign) {
  km_driver_surface *f = &g->f;
  double *N = g->N + (size_t)cell * 2 * (size_t)f->columns;
  int output_sign = 0;
  km_driver_surface_rates(&g->f, N);
  km_driver_surface_save(f, g->saved + (size_t)cell * f->saved_size);
  g->sign[cell] = (signed char)sign;
  g->queue[g->tail++] = cell;
  bool is_ok = km_map_note_configuration(g, cell) && km_map_fill_row(g, cell, g->sheet, N, &output_sign);
  g->output_sign[cell] = (signed char)output_sign;
  for (int d = 0; d < 2 && f->frame >= 0; ++d) {
    const double step = km_map_axis_value(g, d, 1) - km_map_axis_value(g, d, 0),
                 du[2] = {d == 0 ? step : 0.0, d == 1 ? step : 0.0};
    double *at = g->output + 3 * (size_t)cell;
    at[0] = km_map_output_determinant(g, N, du, &at[1 + d]);
  }
  return is_ok;
}

/* Visits the four neighbours of a cell. `*is_edge`: one of them isn't reached. `*is_turned`: det D has another sign
 * there. */
static bool visit_neighbours(km_map_search *g, int cell, double *N, bool *is_edge, bool *is_turned) {
  for (int k = 0; k < 4; ++k) {
    int next = km_map_neighbour(g, cell, k);
    if (next < 0)
      continue;
    if (!g->sign[next] && !km_map_reach(g, cell, next, N))
      *is_edge = true;
    else if (!g->sign[next] && !km_map_find_known(g, next) && !record(g, next, g->sign[cell]))
      return false;
    *is_turned = *is_turned || (g->sign[next] && g->output_sign[cell] != g->output_sign[next]);
  }
  return true;
}

/* A number that is 0 on the curves of a kind, at a cell: σ_input, or |det (J; G)|. */
static double distance_number(const km_map_search *g, int cell, km_curve_kind kind) {
  size_t width = km_table_columns(g->out->cells);
  return kind == KM_CURVE_INPUT ? g->rows[(size_t)cell * width + g->sigma_input] : fabs(g->output[3 * (size_t)cell]);
}

/* True if a cell's number is less than at all four neighbours, which are on its side of the curves. */
static bool is_least(const km_map_search *g, int cell, km_curve_kind kind) {
  double value = distance_number(g, cell, kind);
  for (int k = 0; k < 4; ++k) {
    int next = km_map_neighbour(g, cell, k);
    if (next < 0 || !g->sign[next] || g->output_sign[next] != g->output_sign[cell] ||
        distance_number(g, next, kind) <= value)
      return false;
  }
  return true;
}

/* Adds the curves nearest to a cell that is nearer to them than its neighbours: those that cross no step of the
 * grid. */
static bool add_inner_curves(km_map_search *g, int cell) {
  bool is_ok = true;
  for (int kind = KM_CURVE_INPUT; is_ok && kind <= KM_CURVE_OUTPUT; ++kind) {
    const km_surface_curve curve = {.kind = (km_curve_kind)kind};
    if ((kind == KM_CURVE_INPUT || g->f.frame >= 0) && is_least(g, cell, curve.kind))
      is_ok = km_surface_curves_add(g->curves, &curve, g->saved + (size_t)cell * g->f.saved_size, 0.0);
  }
  return is_ok;
}

/* Adds the limits that the configuration of a cell exceeds, from there: within them a ball joint's angle may be 0. */
static bool add_exceeded_limits(km_map_search *g, int cell) {
  const km_driver_surface *f = &g->f;
  const double *saved = g->saved + (size_t)cell * f->saved_size;
  bool is_ok = true;
  for (int k = 0; is_ok && k < km_driver_surface_joints(f); ++k) {
    km_driver_surface_restore(&g->f, saved);
    double q = km_driver_surface_limited_value(f, k), low = km_driver_surface_low(f, k),
           high = km_driver_surface_high(f, k);
    const km_surface_curve limit = {.kind = KM_CURVE_LIMIT, .column = k, .bound = q > high ? high : low};
    if (q > high || q < low)
      is_ok = km_surface_curves_add(g->curves, &limit, saved, g->curve_distance);
  }
  return is_ok;
}

/* Adds the curves of the pairs of bodies that are too near to each other at a neighbour. */
static bool add_near_pairs(km_map_search *g, int cell, int neighbour) {
  km_driver_surface *f = &g->f;
  bool is_ok = true;
  for (int pair = 0; is_ok && pair < km_kept_clearance_count(&f->kept); ++pair) {
    const km_surface_curve curve = {.kind = KM_CURVE_CLEARANCE, .column = pair, .bound = f->kept.least};
    km_driver_surface_restore(f, g->saved + (size_t)neighbour * f->saved_size);
    km_kept_clearance_update(&f->kept, f->m, f->s);
    if (km_kept_clearance_excess(&f->kept, pair) < 0.0)
      is_ok = km_surface_curves_add(g->curves, &curve, g->saved + (size_t)cell * f->saved_size, g->curve_distance);
  }
  return is_ok;
}

/* Adds the limits at a cell: an end of a driver's range, for the workspace of a point, and limits of joints. */
static bool add_limits(km_map_search *g, int cell) {
  const int at[2] = {cell % g->across, cell / g->across}, last[2] = {g->across - 1, g->down - 1};
  bool is_ok = true;
  for (int d = 0; is_ok && g->f.frame >= 0 && d < 2; ++d) {
    const km_space_axis *a = &g->def->axis[d];
    double bound = (at[d] == 0 ? a->from : a->to) * g->f.m->factor[a->coordinate];
    const km_surface_curve limit = {.kind = KM_CURVE_LIMIT,
                                    .column = g->f.control[d],
                                    .bound = bound,
                                    .is_signed = bound < 0.0 && g->f.m->model->coordinates[a->coordinate].is_strut};
    if ((at[d] == 0 || at[d] == last[d]) && g->is_written[cell] && km_map_axis_ends(g, d))
      is_ok = km_surface_curves_add(g->curves, &limit, g->saved + (size_t)cell * g->f.saved_size, g->curve_distance);
  }
  for (int k = 0; is_ok && g->is_written[cell] && k < 4; ++k) {
    int next = km_map_neighbour(g, cell, k);
    if (next >= 0 && g->sign[next] && !g->is_written[next])
      is_ok = (!g->f.keeps_limits || add_exceeded_limits(g, next)) && add_near_pairs(g, cell, next);
  }
  return is_ok;
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the map");
}

/* Status where a cell wasn't recorded. */
static km_status not_recorded(const km_map_search *g, km_error *error) {
  return g->is_ended ? km_fail(error, KM_CANCELLED, "a figure of the map can't be computed, or ended it")
                     : no_memory(error);
}

void km_map_begin_part(km_map_search *g, km_map_share share, size_t i, size_t count) {
  double from = share_ends[share], width = share_ends[share + 1] - from;
  g->stage.from = from + width * (double)i / (double)count;
  g->stage.to = from + width * (double)(i + 1) / (double)count;
}

km_status km_map_report(km_map_search *g, double done, km_error *error) {
  return km_progress_stage_report(&g->stage, done) ? KM_OK
                                                   : km_fail(error, KM_CANCELLED, "stopped while the map was followed");
}

/* End of the part of the queue that begins at `first`, as far as the queue goes. */
static size_t part_end(const km_map_search *g, size_t first) {
  size_t tail = (size_t)g->tail;
  return first + PART_CELLS < tail ? first + PART_CELLS : tail;
}

/* A km_map_work: visits the neighbours of a part of the queue, and adds the curves at its edges. */
static km_status extend_sheet(km_map_search *g, size_t first, km_error *error) {
  const km_surface_curve input = {.kind = KM_CURVE_INPUT}, output = {.kind = KM_CURVE_OUTPUT};
  for (size_t head = first; head < part_end(g, first); ++head) {
    bool is_edge = false, is_turned = false;
    int cell = g->queue[head];
    if (!visit_neighbours(g, cell, g->start_N, &is_edge, &is_turned))
      return not_recorded(g, error);
    const double *saved = g->saved + (size_t)cell * g->f.saved_size;
    if ((is_edge && !km_surface_curves_add(g->curves, &input, saved, g->curve_distance)) ||
        (is_turned && !km_surface_curves_add(g->curves, &output, saved, g->curve_distance)))
      return no_memory(error);
  }
  return KM_OK;
}

/* A km_map_work: adds the curves within a part of the sheet, and its limits. */
static km_status add_further_curves(km_map_search *g, size_t first, km_error *error) {
  for (size_t i = first; i < part_end(g, first); ++i)
    if (!add_inner_curves(g, g->queue[i]) || !add_limits(g, g->queue[i]))
      return no_memory(error);
  return KM_OK;
}

/* Does the work for all parts of the queue, which it may extend. */
static km_status do_parts(km_map_search *g, km_map_work work, km_error *error) {
  km_status status = KM_OK;
  for (size_t first = 0; !status && first < (size_t)g->tail; first = part_end(g, first)) {
    status = km_map_report(g, (double)first / (g->across * g->down), error);
    if (!status)
      status = km_map_do(g, work, first, error);
  }
  return status;
}

/* Follows one sheet from the state's configuration; it counts if it has at least `least` grid points. */
static km_status follow_sheet(km_map_search *g, int sheet, int least, km_error *error) {
  int sign, first = km_map_enter_grid(g, &sign, g->start_N);
  if (first < 0 || km_map_find_known(g, first))
    return KM_OK;
  memset(g->sign, 0, (size_t)g->across * (size_t)g->down);
  memset(g->is_written, 0, (size_t)g->across * (size_t)g->down * sizeof *g->is_written);
  g->sheet = sheet;
  g->tail = 0;
  if (!record(g, first, sign))
    return not_recorded(g, error);
  km_status status = do_parts(g, extend_sheet, error);
  if (!status)
    status = do_parts(g, add_further_curves, error);
  if (status)
    return status;
  if (g->tail < least) { /* grid points at the edge of another sheet, which may reach them */
    for (int i = 0; i < g->tail; ++i)
      g->known[g->queue[i]] = g->known[g->queue[i]]->next;
    return KM_OK;
  }
  ++g->out->sheet_count;
  g->last_sheet = sheet;
  return write_sheet(g) ? KM_OK : no_memory(error);
}

/* ---- Preparation. */

km_status km_map_check_definition(const km_mechanism *m, const km_space_map_def *def, km_error *error) {
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

/* Moves the state to a mode. */
static km_status move_to_mode(km_map_search *g, const km_all_modes *modes, int i, km_error *error) {
  const km_mechanism *m = g->f.m;
  return km_state_set_coordinates(m, g->f.s, modes->coordinates + (size_t)i * (size_t)m->coordinate_count, error);
}

/* Prepares the surface at the first mode; without modes at the state's configuration: the tables' columns depend on the
 * surface of the point. */
static km_status prepare_surface(km_map_search *g, const km_all_modes *modes, km_error *error) {
  km_driver_surface *f = &g->f;
  const km_space_map_def *def = g->def;
  const int drivers[2] = {def->axis[0].coordinate, def->axis[1].coordinate};
  for (int d = 0; d < 2; ++d) {
    f->low[d] = fmin(def->axis[d].from, def->axis[d].to);
    f->high[d] = fmax(def->axis[d].from, def->axis[d].to);
  }
  for (int d = 0; d < 2; ++d)
    f->is_full_turn[d] = !km_map_axis_ends(g, d);
  f->keeps_limits = def->within_limits;
  f->kept = (km_kept_clearance){.clearance = def->clearance, .least = def->least_clearance};
  km_status status = km_driver_surface_create(f, drivers, 2, &g->arena, error);
  if (!status && !km_kept_clearance_create(&f->kept, f->m, &g->arena))
    status = no_memory(error);
  if (!status && modes->count > 0)
    status = move_to_mode(g, modes, 0, error);
  return status ? status : km_driver_surface_begin(f, &g->arena, error);
}

/* Prepares the grid and the tables. */
static km_status prepare_grid(km_map_search *g, km_error *error) {
  km_driver_surface *f = &g->f;
  const km_space_map_def *def = g->def;
  for (int d = 0; d < 2; ++d)
    g->curve_distance = fmax(g->curve_distance, 3.0 * fabs(km_map_axis_value(g, d, 1) - km_map_axis_value(g, d, 0)));
  g->curve_distance = fmin(g->curve_distance, most_curve_distance);
  g->across = def->axis[0].steps + 1;
  g->down = def->axis[1].steps + 1;
  size_t cells = (size_t)g->across * (size_t)g->down;
  g->saved = KM_ARENA_NEW(&g->arena, double, cells * f->saved_size);
  g->N = KM_ARENA_NEW(&g->arena, double, cells * 2 * (size_t)f->columns);
  g->known = KM_ARENA_NEW(&g->arena, km_known_configuration *, cells);
  g->sign = KM_ARENA_NEW(&g->arena, signed char, cells);
  g->output_sign = KM_ARENA_NEW(&g->arena, signed char, cells);
  g->output = KM_ARENA_NEW(&g->arena, double, f->frame >= 0 ? 3 * cells : 1);
  g->queue = KM_ARENA_NEW(&g->arena, int, 2 * cells); /* and the stack of number_aspect */
  g->before = KM_ARENA_NEW(&g->arena, double, f->saved_size);
  g->edge_N = KM_ARENA_NEW(&g->arena, double, 2 * (size_t)f->columns);
  g->kept_N = KM_ARENA_NEW(&g->arena, double, 2 * (size_t)f->columns);
  g->K = KM_ARENA_NEW(&g->arena, double, (size_t)f->columns *(size_t)f->columns);
  g->row = KM_ARENA_NEW(&g->arena, int, (size_t)f->columns);
  if (g->arena.failed)
    return no_memory(error);
  g->out->cells = km_table_create();
  g->out->curves = km_table_create();
  g->out->boundary = f->frame >= 0 ? km_table_create() : NULL;
  if (!km_map_add_columns(g))
    return no_memory(error);
  g->sigma_input = (size_t)km_table_find(g->out->cells, "sigma.input");
  g->curves = km_surface_curves_create(f, g->out->curves);
  g->start_N = KM_ARENA_NEW(&g->arena, double, 2 * (size_t)f->columns);
  g->rows = KM_ARENA_NEW(&g->arena, double, cells *km_table_columns(g->out->cells));
  g->is_written = KM_ARENA_NEW(&g->arena, bool, cells);
  g->aspect = KM_ARENA_NEW(&g->arena, int, cells);
  if (g->arena.failed || !g->curves)
    return no_memory(error);
  return def->figures ? km_state_create(f->m, &g->at, error) : KM_OK;
}

/* Closes the loops of an open configuration with all coordinates free. */
static bool close_freely(km_map_search *g) {
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

/* Begins the part of the next point of the curves: its crossing curves are added, and its sides are followed. */
static km_status begin_point(km_map_search *g, km_error *error) {
  size_t count;
  km_surface_curves_points(g->curves, &count);
  km_map_begin_part(g, KM_MAP_SHARE_CURVES, g->crossed_points + g->left_points, 2 * count + 1);
  return km_map_report(g, 0.0, error);
}

/* Follows the sheets on both sides of the drivers' singularity curves that no mode has led to. */
static km_status follow_sheets_of_curves(km_map_search *g, km_error *error) {
  km_status status = KM_OK;
  bool is_point = true;
  for (; !status && is_point; g->left_points += is_point ? CURVE_STRIDE : 0) {
    status = begin_point(g, error);
    for (int side = -1; !status && side <= 1; side += 2)
      if (km_surface_curves_leave(g->curves, g->left_points, side * leaving_distance, &is_point) && close_freely(g))
        status = follow_sheet(g, g->last_sheet + 1, LEAST_CELLS, error);
  }
  return status;
}

/* Closes the loops at a grid point, from other coordinates at random, less full turns from `home`. */
static bool close_at_random(km_map_search *g, int cell, const double *home, uint64_t *random) {
  km_driver_surface *f = &g->f;
  const int at[2] = {cell % g->across, cell / g->across};
  bool is_closed = false;
  int sign;
  km_driver_surface_restore(f, home);
  for (int k = 0; k < f->columns; ++k)
    f->step[k] = M_PI * km_uniform(random); /* a hinge: a full turn; a slide: ±π sizes */
  for (int d = 0; d < 2; ++d)
    f->step[f->control[d]] = km_map_axis_value(g, d, at[d]) - km_map_scaled_value(g, d);
  km_driver_surface_move(f, f->step);
  for (int i = 0; i < CLOSING_ROUNDS && !is_closed; ++i)
    is_closed = km_driver_surface_close(f, HUGE_VAL, &sign);
  if (!is_closed)
    return false;
  km_driver_surface_difference(f, home, f->step);
  km_driver_surface_restore(f, home);
  km_driver_surface_move(f, f->step);
  km_driver_surface_restart(f);
  return true;
}

/* Number i of van der Corput's sequence in a base, in [0, 1). */
static double van_der_corput(int i, int base) {
  double value = 0.0, digit = 1.0 / base;
  for (; i > 0; i /= base, digit /= base)
    value += digit * (i % base);
  return value;
}

/* Follows sheets from random configurations at evenly spread grid points (J. H. Halton 1960), those without a sheet so
 * far and every SPREAD_STRIDE-th: those of motions that don't reach the drivers' values of the modes. `home`: a
 * configuration. */
static km_status follow_sheets_of_random_starts(km_map_search *g, const double *home, km_error *error) {
  km_status status = KM_OK;
  uint64_t random = 11;
  for (int i = 1; !status && i <= SPREAD_POINTS; ++i) {
    int cell = (int)(van_der_corput(i, 2) * g->across) + (int)(van_der_corput(i, 3) * g->down) * g->across;
    if (i % SPREAD_STRIDE != 0 && g->known[cell])
      continue;
    km_map_begin_part(g, KM_MAP_SHARE_RANDOM_STARTS, (size_t)i - 1, SPREAD_POINTS);
    if (close_at_random(g, cell, home, &random))
      status = follow_sheet(g, g->last_sheet + 1, LEAST_CELLS, error);
  }
  return status;
}

/* A km_map_work: adds the curve that crosses at a point. */
static km_status add_crossing_curve(km_map_search *g, size_t point, km_error *error) {
  size_t count;
  const km_curve_point *at = &km_surface_curves_points(g->curves, &count)[point];
  const km_surface_curve other = {.kind = at->crossing};
  return km_surface_curves_add(g->curves, &other, at->saved, 0.0) ? KM_OK : no_memory(error);
}

/* Adds the curves that cross known ones: some are no edge of a sheet, such as a point of the drivers' plane. */
static km_status add_crossing_curves(km_map_search *g, km_error *error) {
  km_status status = KM_OK;
  size_t count;
  km_surface_curves_points(g->curves, &count);
  for (; !status && g->crossed_points < count; ++g->crossed_points) {
    const km_curve_point *at = &km_surface_curves_points(g->curves, &count)[g->crossed_points];
    if (!at->is_crossing || at->crossing == at->of.kind)
      continue;
    status = km_map_do(g, add_crossing_curve, g->crossed_points, error);
    if (!status)
      status = begin_point(g, error);
    km_surface_curves_points(g->curves, &count);
  }
  return status;
}

/* Adds curves and sheets that known curves lead to, until there are no further ones. */
static km_status follow_curves(km_map_search *g, km_error *error) {
  km_status status = KM_OK;
  for (int before = -1; !status && before < km_surface_curves_count(g->curves);) {
    before = km_surface_curves_count(g->curves);
    status = add_crossing_curves(g, error);
    if (!status && !g->def->own_sheet)
      status = follow_sheets_of_curves(g, error);
  }
  return status;
}

/* Follows the sheets of all modes, and those that random starts lead to. */
static km_status follow_sheets(km_map_search *g, const km_all_modes *modes, km_error *error) {
  km_driver_surface *f = &g->f;
  km_status status = KM_OK;
  double *home = KM_ARENA_NEW(&g->arena, double, f->saved_size);
  if (!home)
    return no_memory(error);
  for (int i = 0; !status && i < modes->count; ++i) {
    status = move_to_mode(g, modes, i, error);
    km_map_begin_part(g, KM_MAP_SHARE_MODES, (size_t)i, (size_t)modes->count);
    if (!status) {
      km_driver_surface_restart(f);
      if (i == 0)
        km_driver_surface_save(f, home);
      status = follow_sheet(g, i + 1, 1, error);
    }
  }
  g->last_sheet = modes->count;
  return status || modes->count == 0 || g->def->own_sheet ? status : follow_sheets_of_random_starts(g, home, error);
}

/* Finds sheets, curves and the workspace. */
static km_status find(km_map_search *g, const km_all_modes *modes, km_error *error) {
  km_status status = follow_sheets(g, modes, error);
  if (!status)
    status = follow_curves(g, error);
  g->out->curve_count = km_surface_curves_count(g->curves);
  g->out->aspect_count = g->aspect_count;
  return status || g->f.frame < 0 ? status : km_map_find_workspace(g, error);
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
    status = km_map_check_definition(m, def, error);
  if (status)
    return status;
  km_map_search g = {.f = {.m = m, .frame = def->has_point ? def->frame : -1},
                     .def = def,
                     .stage = {.progress = progress, .context = context},
                     .out = out};
  status = km_state_create(m, &g.f.s, error);
  if (!status) {
    km_state_copy(m, g.f.s, s);
    status = prepare_surface(&g, modes, error);
  }
  if (!status)
    status = prepare_grid(&g, error);
  if (!status)
    status = km_map_check_modes(&g, modes, error);
  if (!status)
    status = find(&g, modes, error);
  out->is_stopped = status == KM_CANCELLED;
  km_surface_curves_free(g.curves);
  km_arena_free(&g.arena);
  km_state_free(g.f.s);
  km_state_free(g.at);
  return status;
}

km_status km_space_map_find(const km_mechanism *m, const km_state *s, const km_space_map_def *def, unsigned long seed,
                            km_progress progress, void *context, km_all_modes *modes, km_space_map *out,
                            km_error *error) {
  if (!modes || !out)
    return km_check_given(false, "place for the modes or the map", error);
  *modes = (km_all_modes){0};
  *out = (km_space_map){0};
  if (!def)
    return km_check_given(false, "definition of the map", error);
  km_progress_stage stage = {.progress = progress, .context = context};
  km_progress_stage_next(&stage, share_of_modes);
  km_status status = def->store ? km_map_store_modes(def->store, m, s, km_progress_stage_report, &stage, modes, error)
                                : km_map_modes_find(m, s, def->axis[0].coordinate, def->axis[1].coordinate, seed,
                                                    km_progress_stage_report, &stage, modes, error);
  km_progress_stage_next(&stage, 1.0);
  if (!status && def->own_sheet) {
    modes->count = modes->count > 1 ? 1 : modes->count;
    modes->is_complete = true;
    modes->gap = KM_GAP_NONE;
  }
  return status ? status : km_space_map_compute(m, s, def, modes, km_progress_stage_report, &stage, out, error);
}

const char *km_curve_kind_name(km_curve_kind kind) {
  return kind == KM_CURVE_INPUT       ? "input"
         : kind == KM_CURVE_OUTPUT    ? "output"
         : kind == KM_CURVE_LIMIT     ? "limit"
         : kind == KM_CURVE_CLEARANCE ? "clearance"
                                      : "";
}

void km_space_map_free(km_space_map *map) {
  if (!map)
    return;
  km_table_free(map->cells);
  km_table_free(map->curves);
  km_table_free(map->boundary);
  km_free(map->workspaces);
  *map = (km_space_map){0};
}
