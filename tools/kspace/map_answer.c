/* Record and text of kspace map. */
#include "kspace/map_answer.h"

#include "kspace/kspace.h"

#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

static const double same_value = 1e-8; /* change of a driver that rests, over its range */

/* Least and largest finite value of a column over the rows of a sheet. */
static void range_of(const km_table *table, double sheet, size_t column, double *low, double *high, size_t *rows) {
  *low = HUGE_VAL;
  *high = -HUGE_VAL;
  *rows = 0;
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    const double *row = km_table_row(table, r);
    if (row[2] != sheet)
      continue;
    if (isfinite(row[column])) {
      *low = fmin(*low, row[column]);
      *high = fmax(*high, row[column]);
    }
    ++*rows;
  }
}

/* Prints the ranges of the singular values and of the columns behind them. */
static void print_sheet(const km_space_map *map, int sheet, size_t points, km_text *out) {
  const km_table *t = map->cells;
  double low, high;
  size_t rows, first = km_table_span(t, "sigma.input").first;
  range_of(t, sheet, first, &low, &high, &rows);
  if (rows == 0)
    return;
  km_text_format(out, "  sheet %d: %zu of %zu grid points", sheet, rows, points);
  for (size_t c = first; c < km_table_columns(t); ++c) {
    const char *name = km_table_name(t, c), *unit = km_table_unit(t, c);
    range_of(t, sheet, c, &low, &high, &rows);
    if (strcmp(name, "sigma.closure") != 0 && low <= high && strncmp(name, "chart.", 6) != 0 &&
        (strncmp(name, "point.", 6) != 0 || high - low > 0.0))
      km_text_format(out, "; %s %.3g to %.3g%s%s", name, low, high, unit && *unit ? " " : "", unit ? unit : "");
  }
  km_text_add(out, "\n");
}

/* True if both drivers have one value along the curve that begins at a row: its points are exact to rounding. */
static bool is_one_pair(const km_space_map_def *def, const km_table *curves, size_t first) {
  const double *start = km_table_row(curves, first);
  bool is_one = true;
  for (size_t r = first; is_one && r < km_table_rows(curves) && km_table_row(curves, r)[0] == start[0]; ++r)
    for (int d = 0; d < 2; ++d) {
      const km_space_axis *axis = &def->axis[d];
      double change = km_table_row(curves, r)[2 + axis->coordinate] - start[2 + axis->coordinate];
      is_one = is_one && fabs(change) <= same_value * fabs(axis->to - axis->from);
    }
  return is_one;
}

/* Number of curves of a kind; *pairs: of those that are one pair of the drivers' values each. */
static int count_curves(const km_space_map_def *def, const km_table *curves, km_curve_kind kind, int *pairs) {
  int count = 0;
  *pairs = 0;
  for (size_t r = 0; r < km_table_rows(curves); ++r) {
    const double *row = km_table_row(curves, r);
    bool is_first = r == 0 || km_table_row(curves, r - 1)[0] != row[0];
    if (!is_first || (int)row[1] != (int)kind)
      continue;
    ++count;
    *pairs += is_one_pair(def, curves, r);
  }
  return count;
}

/* Area, and holes; of a sphere the parts that aren't reached, one more than the holes of a chart. */
static void print_area(const km_space_map_def *def, const km_space_map *map, const char *length, km_text *out) {
  double radius = map->surface.radius, whole = 4.0 * M_PI * radius * radius;
  km_text_format(out, "workspace of %s: area %.6g %s²", def->point_name, map->workspace_area, length);
  if (radius == 0.0)
    km_text_format(out, ", %d hole%s\n", map->hole_count, map->hole_count == 1 ? "" : "s");
  else if (map->workspace_area < (1.0 - same_value) * whole)
    km_text_format(out, "; %d part%s of the sphere out of reach\n", map->hole_count + 1,
                   map->hole_count == 0 ? "" : "s");
  else
    km_text_add(out, ", the whole sphere\n");
}

/* Half-angle of a cone in the model's unit of angle. */
static double half_angle(const km_model *model, const km_aspect_workspace *at) {
  return at->half_angle / km_model_units(model).angle->si;
}

/* Largest circle, rectangle and cone of the aspect in which each is largest, and the area of the whole. */
static void print_workspace(const km_model *model, const km_space_map_def *def, const km_space_map *map, km_text *out) {
  const char *length = km_model_units(model).length->suffix;
  const km_aspect_workspace *circle = NULL, *rectangle = NULL, *cone = NULL;
  for (int i = 0; i < map->workspace_count; ++i) {
    const km_aspect_workspace *at = &map->workspaces[i];
    if (at->radius > 0.0 && (!circle || at->radius > circle->radius))
      circle = at;
    if (at->width > 0.0 && (!rectangle || at->width * at->height > rectangle->width * rectangle->height))
      rectangle = at;
    if (at->half_angle > 0.0 && (!cone || at->half_angle > cone->half_angle))
      cone = at;
  }
  if (isfinite(map->workspace_area))
    print_area(def, map, length, out);
  else
    km_text_format(out, "workspace of %s: its outline isn't closed: a curve is missing, which more --steps may find\n",
                   def->point_name);
  if (map->surface.radius > 0.0)
    km_text_format(out, "  on a sphere of radius %.6g %s around %.6g, %.6g, %.6g\n", map->surface.radius, length,
                   map->surface.origin[0], map->surface.origin[1], map->surface.origin[2]);
  if (circle)
    km_text_format(out,
                   "  largest circle without a singularity: radius %.6g %s around %.6g, %.6g, %.6g, in aspect %d\n",
                   circle->radius, length, circle->circle[0], circle->circle[1], circle->circle[2], circle->aspect);
  if (cone)
    km_text_format(out,
                   "  largest cone without a singularity: half-angle %.6g %s around the direction %.6g, %.6g, %.6g, in "
                   "aspect %d\n",
                   half_angle(model, cone), km_model_units(model).angle->suffix, cone->cone[0], cone->cone[1],
                   cone->cone[2], cone->aspect);
  if (rectangle)
    km_text_format(out, "  largest rectangle: %.6g by %.6g %s around %.6g, %.6g, %.6g, in aspect %d\n",
                   rectangle->width, rectangle->height, length, rectangle->rectangle[0], rectangle->rectangle[1],
                   rectangle->rectangle[2], rectangle->aspect);
  if (map->gap > 0.0 && isfinite(map->gap))
    km_text_format(out, "  its outline has a gap of %.3g %s, closed by a straight line\n", map->gap, length);
  if (map->unbounded > 0)
    km_text_format(
        out,
        "  %d of %d checked grid points lie outside the outline: a curve is missing, which more --steps may find\n",
        map->unbounded, map->checked);
}

/* Ends the first line with the number of sheets that no mode leads to: their drivers don't reach those of the pose. */
static void print_further_sheets(const km_space_map *map, int modes, km_text *out) {
  int further = 0;
  for (size_t r = 0; r < km_table_rows(map->cells); ++r) {
    double sheet = km_table_row(map->cells, r)[2];
    further += sheet > modes && (r == 0 || km_table_row(map->cells, r - 1)[2] != sheet);
  }
  if (further > 0)
    km_text_format(out, "; %d of them from singularity curves or random configurations", further);
  km_text_add(out, "\n");
}

/* Prints the numbers of curves by kind, and of the aspects that they bound. */
static void print_curves(const km_space_map_def *def, const km_space_map *map, km_text *out) {
  int pairs, of_outputs, inputs = count_curves(def, map->curves, KM_CURVE_INPUT, &pairs);
  inputs -= pairs;
  km_text_format(out, "%d singularity curve%s of the drivers bound%s them\n", inputs, inputs == 1 ? "" : "s",
                 inputs == 1 ? "s" : "");
  if (pairs > 0)
    km_text_format(out, "%d further curve%s of the map: the mechanism moves there while the drivers rest\n", pairs,
                   pairs == 1 ? " is a single point" : "s are single points");
  if (def->has_point) {
    int outputs = count_curves(def, map->curves, KM_CURVE_OUTPUT, &of_outputs);
    km_text_format(out, "%d singularity curve%s of the output: %s can't move in some direction there\n", outputs,
                   outputs == 1 ? "" : "s", def->point_name);
    if (!map->is_stopped) /* some aspects of a stopped map are missing */
      km_text_format(out, "%d aspect%s free of both\n", map->aspect_count, map->aspect_count == 1 ? " is" : "s are");
  }
  km_text_format(out, "%zu points of curves\n", km_table_rows(map->curves));
}

void kspace_print_map(const kt_pose *pose, const char *file, const km_space_map_def *def, const km_all_modes *modes,
                      const km_space_map *map, km_text *out) {
  const km_model *model = pose->model;
  size_t points = (size_t)(def->axis[0].steps + 1) * (size_t)(def->axis[1].steps + 1);
  const int drivers[2] = {def->axis[0].coordinate, def->axis[1].coordinate};
  km_text_format(out, "%s: %d sheet%s over %s and %s, from %d assembly mode%s%s", file, map->sheet_count,
                 map->sheet_count == 1 ? "" : "s", km_model_coordinate_label(model, drivers[0]),
                 km_model_coordinate_label(model, drivers[1]), modes->count, modes->count == 1 ? "" : "s",
                 modes->is_complete ? "" : " (at least these)");
  print_further_sheets(map, modes->count, out);
  for (int i = 1; i <= modes->count + map->sheet_count; ++i)
    print_sheet(map, i, points, out);
  print_curves(def, map, out);
  if (map->is_stopped)
    km_text_add(out, "stopped: further sheets and curves are missing\n");
  else if (def->has_point)
    print_workspace(model, def, map, out);
  if (!def->within_limits)
    kspace_print_limits(pose, drivers, 2, out);
}

static void add_place(km_value *to, const char *name, const double *place, km_arena *arena) {
  km_value *list = km_value_add(arena, to, name, KM_LIST);
  for (int i = 0; i < 3 && list; ++i)
    km_value_number(arena, list, NULL, place[i]);
}

static void add_aspect(const km_model *model, const km_aspect_workspace *at, km_value *list, km_arena *arena) {
  km_value *aspect = km_value_add(arena, list, NULL, KM_OBJECT);
  km_value_number(arena, aspect, "aspect", at->aspect);
  km_value_number(arena, aspect, "area", at->area);
  if (at->radius > 0.0) {
    add_place(aspect, "circle", at->circle, arena);
    km_value_number(arena, aspect, "radius", at->radius);
  }
  if (at->width > 0.0) {
    add_place(aspect, "rectangle", at->rectangle, arena);
    km_value_number(arena, aspect, "width", at->width);
    km_value_number(arena, aspect, "height", at->height);
  }
  if (at->half_angle > 0.0) {
    add_place(aspect, "cone", at->cone, arena);
    km_value_number(arena, aspect, "half_angle", half_angle(model, at));
  }
}

static void add_workspace(const km_model *model, const km_space_map_def *def, const km_space_map *map, km_value *record,
                          km_arena *arena) {
  km_value *workspace = km_value_add(arena, record, "workspace", KM_OBJECT);
  km_value_string(arena, workspace, "point", def->point_name);
  if (map->surface.radius > 0.0) {
    km_value *sphere = km_value_add(arena, workspace, "sphere", KM_OBJECT);
    add_place(sphere, "centre", map->surface.origin, arena);
    km_value_number(arena, sphere, "radius", map->surface.radius);
    add_place(sphere, "pole", map->surface.axis[2], arena);
  }
  km_value_number(arena, workspace, "area", map->workspace_area);
  km_value_number(arena, workspace, "holes", map->hole_count);
  km_value_number(arena, workspace, "gap", map->gap);
  km_value_number(arena, workspace, "outside", map->unbounded);
  km_value_number(arena, workspace, "checked", map->checked);
  km_value *aspects = km_value_add(arena, workspace, "aspects", KM_LIST);
  for (int i = 0; i < map->workspace_count && !arena->failed; ++i)
    add_aspect(model, &map->workspaces[i], aspects, arena);
}

const km_value *kspace_map_record(const kt_pose *pose, const char *file, const km_space_map_def *def,
                                  const km_all_modes *modes, const km_space_map *map, km_arena *arena) {
  km_value *record = km_record_head(pose->mechanism, "kspace map", file, arena);
  km_value *drivers = km_value_add(arena, record, "drivers", KM_LIST);
  for (int d = 0; d < 2 && !arena->failed; ++d) {
    km_value *driver = km_value_add(arena, drivers, NULL, KM_OBJECT);
    km_value_string(arena, driver, "joint", km_model_coordinate_label(pose->model, def->axis[d].coordinate));
    km_value_number(arena, driver, "from", def->axis[d].from);
    km_value_number(arena, driver, "to", def->axis[d].to);
    km_value_number(arena, driver, "steps", def->axis[d].steps);
  }
  kspace_record_completeness(map->is_stopped ? KM_GAP_STOPPED : modes->gap, record, arena);
  km_value_number(arena, record, "modes", modes->count);
  km_value_number(arena, record, "sheets", map->sheet_count);
  km_value_number(arena, record, "aspects", map->aspect_count);
  km_value_number(arena, record, "curves", map->curve_count);
  if (def->has_point && !map->is_stopped)
    add_workspace(pose->model, def, map, record, arena);
  km_table_record(map->cells, record, arena);
  return arena->failed ? NULL : record;
}
