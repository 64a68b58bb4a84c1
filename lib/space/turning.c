/* Dead points of a driver over one number of the design (docs/theory.md 4.20; D. H. Myszka, A. P. Murray, C. W. Wampler
 * 2012).
 *
 *   e(q, p) = 0,  A(q, p) z = 0            curve of dead points; A: J without the driver's column
 *   dp/ds = 0                              critical value: circuits join, part, appear or vanish, or dead points meet
 *   between critical values                the number of dead points and the driver's swing keep their kind
 *
 * Starts: at each step of p the circuit of each assembly mode is followed by arc length. Roots of the driver's rate are
 * dead points; from a minimum of its magnitude Newton's method leads to dead points at another p. A mode is carried
 * from step to step by minimum-norm closing with all coordinates free. */
#include "base/arguments.h"
#include "kinematics/loop_closing.h"
#include "kmech/continuation.h"
#include "model/coordinate_column.h"
#include "space/curves/surface_curves.h"
#include "space/driver_circuit.h"

#include <stdlib.h>
#include <string.h>

static const double most_correction = 0.3; /* |D δ| of one step of the number: radians, sizes */
static const double shortest_step = 1e-4;  /* shortest step of the number, a part of the range */
static const double same_driver = 1e-6;    /* distance of the driver at equal critical values: radians, length unit */
static const double same_number = 1e-9;    /* distance of equal critical values, a part of the range */

/* Parts of the work: models/ spend 1 % of the time on modes and 99 % on circuits; intervals take the rest. */
static const double share_of_modes = 0.05, share_of_circuits = 0.9;

typedef struct turning_search {
  km_driver_surface f;
  km_design_number number;
  const km_turning_def *def;
  km_arena arena;
  km_surface_curves *curves;
  km_driver_circuit circuit; /* the one at the present number */
  double *before;            /* [saved_size] */
  km_progress_stage stage;   /* modes, the circuits of each, and what holds between critical values */
} turning_search;

const char *km_turning_kind_name(km_turning_kind kind) {
  static const char *const names[] = {"none", "crossing", "isolated", "cusp"};
  return kind >= KM_TURNING_NONE && kind <= KM_TURNING_CUSP ? names[kind] : "";
}

/* The substructure that moves. */
static int part_of(const turning_search *g) {
  return g->f.part[0].substructure;
}

/* ---- The number. */

/* Carries the closed configuration to another value of the number. False where it is lost; the state is then at the
 * last value. */
static bool walk(turning_search *g, double value) {
  double width = g->def->to - g->def->from, step = value - g->number.value;
  while (g->number.value != value) {
    km_closure closure;
    double left = value - g->number.value;
    step = fabs(step) < fabs(left) ? step : left;
    km_driver_surface_save(&g->f, g->before);
    bool is_ok = km_design_number_set(&g->number, step == left ? value : g->number.value + step);
    km_state_invalidate_pivots(g->f.s, part_of(g));
    is_ok = is_ok && km_loops_close(g->f.m, g->f.s, part_of(g), KM_NO_DRIVER, &closure) == KM_CLOSED &&
            closure.correction <= most_correction;
    if (is_ok) {
      step *= 2.0;
      continue;
    }
    km_driver_surface_restore(&g->f, g->before);
    step *= 0.5;
    if (fabs(step) < shortest_step * width)
      return false;
  }
  return true;
}

/* Adds the curves at the state's circuit. The state returns. */
static km_status add_curves(turning_search *g, km_error *error) {
  km_driver_swing swing;
  km_status status = km_driver_circuit_follow(&g->circuit, &swing, error);
  for (int i = 0; !status && i < g->circuit.start_count; ++i)
    if (!km_surface_curves_add(g->curves, &(km_surface_curve){.kind = KM_CURVE_INPUT},
                               g->circuit.starts + (size_t)i * g->f.saved_size, 0.0))
      status = km_fail(error, KM_MEMORY, "out of memory for the curves of dead points");
  km_driver_surface_restore(&g->f, g->circuit.place);
  return status;
}

static km_status report(turning_search *g, double done, km_error *error) {
  return km_progress_stage_report(&g->stage, done)
             ? KM_OK
             : km_fail(error, KM_CANCELLED, "stopped while dead points were followed");
}

/* Adds the curves that meet the circuit of one mode at the steps of the number. start: its saved configuration. */
static km_status search_from(turning_search *g, const double *start, km_error *error) {
  int steps = g->def->steps > 0 ? g->def->steps : KM_DEFAULT_TURNING_STEPS;
  km_status status = KM_OK;
  double own = start[g->f.saved_size - 1];
  for (int sense = 1; !status && sense >= -1; sense -= 2) {
    bool is_there = true;
    km_driver_surface_restore(&g->f, start);
    for (int k = 0; !status && is_there && k <= steps; ++k) {
      int at = sense > 0 ? k : steps - k;
      double value = at == steps ? g->def->to : g->def->from + (g->def->to - g->def->from) * at / steps;
      if ((value - own) * sense < 0.0)
        continue;
      is_there = walk(g, value);
      if (is_there)
        status = add_curves(g, error);
      if (!status)
        status = report(g, sense > 0 ? 0.5 * k / steps : 0.5 + 0.5 * k / steps, error);
    }
  }
  return status;
}

/* ---- Critical values and what holds between them. */

static int by_number(const void *a, const void *b) {
  double x = ((const km_turning_point *)a)->number, y = ((const km_turning_point *)b)->number;
  return (x > y) - (x < y);
}

/* True if the points are one critical value, which a curve passed at its start and at its end, or which curves of
 * several modes have. */
static bool is_same_value(const turning_search *g, const km_turning_point *a, const km_turning_point *b) {
  int d = g->def->driver;
  double away = (a->driver - b->driver) * g->f.m->factor[d];
  if (km_coordinate_turns(g->f.m, d))
    away = remainder(away, 2.0 * M_PI);
  return a->kind == b->kind && fabs(a->number - b->number) <= same_number * (g->def->to - g->def->from) &&
         fabs(away) <= same_driver;
}

static bool copy_points(turning_search *g, km_turning *out) {
  int count;
  const km_turning_point *points = km_surface_curves_critical(g->curves, &count);
  out->points = KM_NEW(km_turning_point, (size_t)count + 1);
  out->intervals = KM_NEW(km_turning_interval, 2 * (size_t)count + 3); /* an interval may be split at either end */
  if (!out->points || !out->intervals)
    return false;
  for (int i = 0; i < count; ++i) {
    bool is_known = false;
    for (int k = 0; k < out->point_count && !is_known; ++k)
      is_known = is_same_value(g, &points[i], &out->points[k]);
    if (!is_known)
      out->points[out->point_count++] = points[i];
  }
  qsort(out->points, (size_t)out->point_count, sizeof *out->points, by_number);
  double from = g->def->from, least = same_number * (g->def->to - g->def->from);
  for (int i = 0; i <= out->point_count; ++i) {
    double to = i < out->point_count ? out->points[i].number : g->def->to;
    if (to - from <= least)
      continue; /* equal values of two curves */
    out->intervals[out->interval_count++] = (km_turning_interval){.from = from, .to = to};
    from = to;
  }
  return true;
}

/* Number of points of the curves with this number. */
static int count_dead_points(const km_table *curves, double number) {
  int count = 0;
  for (size_t i = 1; i < km_table_rows(curves); ++i) {
    const double *a = km_table_row(curves, i - 1), *b = km_table_row(curves, i);
    count += a[0] == b[0] && (a[1] < number) != (b[1] < number);
  }
  return count;
}

/* Examines the model's circuit in the middle of an interval. */
static km_status examine(turning_search *g, km_turning_interval *at, km_error *error) {
  km_driver_swing swing;
  double unit = g->f.m->factor[g->def->driver];
  at->low = at->high = nan("");
  at->is_assembled = walk(g, 0.5 * (at->from + at->to));
  km_driver_surface_save(&g->f, g->circuit.place);
  at->is_defined = at->is_assembled || km_design_number_set(&g->number, 0.5 * (at->from + at->to));
  km_driver_surface_restore(&g->f, g->circuit.place);
  km_status status = at->is_assembled ? km_driver_circuit_follow(&g->circuit, &swing, error) : KM_OK;
  if (!status && at->is_assembled) {
    at->turns = swing.turns;
    bool is_found = swing.low <= swing.high;
    at->low = is_found ? swing.low / unit : nan("");
    at->high = is_found ? swing.high / unit : nan("");
  }
  return status;
}

/* The number nearest to `bad` that the file can be read with, from `good` on. The state is at the last such number. */
static double bound_of_numbers(turning_search *g, double good, double bad) {
  double least = same_number * (g->def->to - g->def->from);
  while (fabs(bad - good) > least) {
    double middle = 0.5 * (good + bad);
    *(km_design_number_set(&g->number, middle) ? &good : &bad) = middle;
  }
  return good;
}

/* Splits interval k, in the middle of which the file can't be read, at the bound of the numbers. `sense`: outwards.
 * False if no part of it can be read. */
static bool split_interval(turning_search *g, km_turning *out, int k, int sense) {
  km_turning_interval *at = &out->intervals[k];
  double start = sense > 0 ? at->from : at->to;
  double inside = start + sense * 1e-6 * (at->to - at->from);
  km_driver_surface_save(&g->f, g->circuit.place);
  if (!km_design_number_set(&g->number, inside)) {
    km_driver_surface_restore(&g->f, g->circuit.place);
    return false;
  }
  double bound = bound_of_numbers(g, inside, 0.5 * (at->from + at->to));
  km_driver_surface_restore(&g->f, g->circuit.place);
  memmove(at + 1, at, (size_t)(out->interval_count++ - k) * sizeof *at);
  at[0].to = bound;
  at[1].from = bound;
  return true;
}

/* Examines all intervals, outwards from the model's own number. */
static km_status examine_intervals(turning_search *g, const double *start, km_turning *out, km_error *error) {
  km_status status = KM_OK;
  double own = start[g->f.saved_size - 1];
  for (int sense = 1; !status && sense >= -1; sense -= 2) {
    bool was_split = false;
    km_driver_surface_restore(&g->f, start);
    for (int k = sense > 0 ? 0 : out->interval_count - 1; !status && k >= 0 && k < out->interval_count; k += sense) {
      km_turning_interval *at = &out->intervals[k];
      if ((0.5 * (at->from + at->to) - own) * sense < 0.0)
        continue;
      status = examine(g, at, error);
      if (!status && !at->is_defined && !was_split && split_interval(g, out, k, sense)) {
        was_split = true; /* examine the part that can be read */
        k -= sense > 0 ? 1 : -2;
      } else {
        was_split = false;
      }
    }
  }
  for (int k = 0; k < out->interval_count; ++k) {
    km_turning_interval *at = &out->intervals[k];
    at->dead_points = count_dead_points(out->curves, 0.5 * (at->from + at->to));
  }
  return status;
}

/* ---- Preparation. */

static bool add_columns(const km_mechanism *m, km_table *table) {
  static const char *const first[] = {"curve", "number", "critical"};
  bool is_ok = table != NULL;
  for (int i = 0; is_ok && i < 3; ++i)
    is_ok = km_table_add_column(table, first[i], "") >= 0;
  for (int c = 0; is_ok && c < m->coordinate_count; ++c)
    is_ok = km_model_add_coordinate_column(m->model, c, table);
  return is_ok;
}

static km_status check_definition(const km_mechanism *m, const km_turning_def *def, km_error *error) {
  km_status status = km_check_given(def && def->file && def->path, "definition, file or number of the design", error);
  if (!status)
    status = km_check_index(def->driver, m->coordinate_count, "coordinate", error);
  if (!status && !(isfinite(def->from) && isfinite(def->to) && def->from < def->to && def->steps >= 0 &&
                   def->steps <= KM_MAX_TURNING_STEPS))
    status = km_fail(error, KM_USAGE,
                     "%s from %g to %g in %d steps; expected a range from low to high, and at most %d "
                     "steps",
                     def->path, def->from, def->to, def->steps, KM_MAX_TURNING_STEPS);
  return status;
}

static km_status prepare(turning_search *g, const km_mechanism *m, const km_state *s, km_turning *out,
                         km_error *error) {
  const km_turning_def *def = g->def;
  km_driver_surface *f = &g->f;
  *f = (km_driver_surface){
      .m = m, .low = {-HUGE_VAL, def->from}, .high = {HUGE_VAL, def->to}, .number = &g->number, .frame = -1};
  km_status status = km_driver_circuit_create(f, def->driver, &g->arena, &g->circuit, error);
  if (!status)
    status = km_design_number_open(m, s, f->part[0].substructure, def->file, def->path, &g->number, error);
  if (status)
    return status;
  f->m = g->number.m;
  f->s = g->number.s;
  status = km_driver_surface_begin(f, &g->arena, error);
  if (status)
    return status;
  out->curves = km_table_create();
  g->before = KM_ARENA_NEW(&g->arena, double, f->saved_size);
  if (!g->arena.failed && add_columns(m, out->curves))
    g->curves = km_surface_curves_create(f, out->curves);
  return g->curves ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the curves of dead points");
}

/* The modes with the driver locked; the state's own alone where they can't be listed. */
static km_status find_modes(const km_mechanism *m, const km_state *s, turning_search *g, km_all_modes *modes,
                            km_error *error) {
  const km_all_modes_def all = {.locked = &g->def->driver, .locked_count = 1, .seed = g->def->seed};
  km_progress_stage_next(&g->stage, share_of_modes);
  km_status status = km_all_modes_find(m, s, &all, km_progress_stage_report, &g->stage, modes, error);
  if (status != KM_USAGE)
    return status;
  modes->gap = KM_GAP_REFUSED;
  return KM_OK;
}

/* Begins the stage of a mode's circuits. */
static void begin_mode(turning_search *g, int i, const km_all_modes *modes) {
  double count = fmax(modes->count, 1.0);
  km_progress_stage_next(&g->stage, share_of_modes + share_of_circuits * (i + 1.0) / count);
}

static km_status search(turning_search *g, const km_all_modes *modes, km_turning *out, km_error *error) {
  const km_mechanism *m = g->f.m;
  double *start = KM_ARENA_NEW(&g->arena, double, g->f.saved_size);
  double *own = KM_ARENA_NEW(&g->arena, double, g->f.saved_size);
  km_status status = start && own ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the curves of dead points");
  if (status)
    return status;
  km_driver_surface_save(&g->f, own);
  begin_mode(g, 0, modes);
  status = search_from(g, own, error);
  for (int i = 1; !status && i < modes->count; ++i) {
    begin_mode(g, i, modes);
    km_driver_surface_restore(&g->f, own);
    status = km_state_set_coordinates(m, g->f.s, modes->coordinates + (size_t)i * (size_t)m->coordinate_count, error);
    if (!status)
      km_driver_surface_restart(&g->f);
    km_driver_surface_save(&g->f, start);
    if (!status)
      status = search_from(g, start, error);
  }
  out->curve_count = km_surface_curves_count(g->curves);
  out->modes = modes->count > 0 ? modes->count : 1;
  if ((!status || status == KM_CANCELLED) && !copy_points(g, out))
    status = km_fail(error, KM_MEMORY, "out of memory for the critical values");
  km_progress_stage_next(&g->stage, 1.0);
  return status ? status : examine_intervals(g, own, out, error);
}

km_status km_turning_find(const km_mechanism *m, const km_state *s, const km_turning_def *def, km_progress progress,
                          void *context, km_turning *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_turning){0};
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = check_definition(m, def, error);
  if (status)
    return status;
  turning_search g = {.def = def, .stage = {.progress = progress, .context = context}};
  km_all_modes modes = {0};
  status = prepare(&g, m, s, out, error);
  if (!status)
    status = find_modes(m, s, &g, &modes, error);
  if (!status)
    status = search(&g, &modes, out, error);
  out->is_complete = modes.is_complete;
  out->gap = modes.gap;
  out->is_stopped = status == KM_CANCELLED;
  if (out->is_stopped)
    out->interval_count = 0;
  km_all_modes_free(&modes);
  km_surface_curves_free(g.curves);
  km_design_number_close(&g.number);
  km_arena_free(&g.arena);
  return status;
}

void km_turning_free(km_turning *turning) {
  if (!turning)
    return;
  km_table_free(turning->curves);
  km_free(turning->points);
  km_free(turning->intervals);
  *turning = (km_turning){0};
}
