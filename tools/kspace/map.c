/* kspace map: sheets over two drivers, and singularity curves. */
#include "kspace/kspace.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/space.h"

typedef struct options {
  kt_common common;
  kt_texts holds, sets, over;
  const char *model, *base; /* base: -o, or NULL */
} options;

static kt_exit bad_axis(const options *o, const char *text) {
  return kt_usage(&o->common, "--over", text, "JOINT=FROM:TO:N with N from 2 to 2001 values, for two different joints");
}

/* Reads JOINT=FROM:TO:N. */
static kt_exit read_axis(const options *o, const km_model *model, const char *text, km_space_axis *axis) {
  const char *rest = text;
  kt_piece label = kt_split(&rest, "=");
  kt_exit result =
      label.separator ? kt_coordinate(&o->common, model, "--over", label.text, &axis->coordinate) : bad_axis(o, text);
  km_free(label.text);
  kt_piece part[3] = {{0}};
  for (int i = 0; i < 3; ++i)
    part[i] = kt_split(&rest, ":");
  int values = 0;
  bool is_ok = part[1].separator && !part[2].separator && kt_number(part[0].text, &axis->from) &&
               kt_number(part[1].text, &axis->to) && kt_integer(part[2].text, 2, KM_MAX_MAP_STEPS + 1, &values);
  axis->steps = values - 1;
  for (int i = 0; i < 3; ++i)
    km_free(part[i].text);
  return result != KT_DONE || is_ok ? result : bad_axis(o, text);
}

/* Least and largest value of a column over the rows of a sheet. */
static void range_of(const km_table *table, double sheet, size_t column, double *low, double *high, size_t *rows) {
  *low = *high = 0.0;
  *rows = 0;
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    const double *row = km_table_row(table, r);
    if (row[0] != sheet)
      continue;
    *low = *rows == 0 || row[column] < *low ? row[column] : *low;
    *high = *rows == 0 || row[column] > *high ? row[column] : *high;
    ++*rows;
  }
}

static void print_map(const options *o, const km_model *model, const km_space_map_def *def, const km_all_modes *modes,
                      const km_space_map *map, km_text *out) {
  size_t points = (size_t)(def->axis[0].steps + 1) * (size_t)(def->axis[1].steps + 1);
  size_t input = km_table_span(map->cells, "sigma.input").first;
  km_text_format(out, "%s: %d sheet%s over %s and %s, from %d assembly mode%s%s\n", o->model, map->sheet_count,
                 map->sheet_count == 1 ? "" : "s", km_model_coordinate_label(model, def->axis[0].coordinate),
                 km_model_coordinate_label(model, def->axis[1].coordinate), modes->count, modes->count == 1 ? "" : "s",
                 modes->is_complete ? "" : " (at least these)");
  for (int i = 1; i <= modes->count; ++i) {
    double low, high;
    size_t rows;
    range_of(map->cells, i, input, &low, &high, &rows);
    if (rows > 0)
      km_text_format(out,
                     "  sheet %d: %zu of %zu grid points; smallest singular value of the input from %.3g to %.3g\n", i,
                     rows, points, low, high);
  }
  km_text_format(out, "%d singularity curve%s of the drivers bound%s them, %zu points\n", map->curve_count,
                 map->curve_count == 1 ? "" : "s", map->curve_count == 1 ? "s" : "", km_table_rows(map->curves));
}

static kt_exit run(const options *o, const kt_pose *pose) {
  km_space_map_def def = {0};
  km_all_modes modes = {0};
  km_space_map map = {0};
  km_error error;
  km_text out = {0};
  kt_exit result = o->over.count == 2 ? KT_DONE : bad_axis(o, o->over.count > 0 ? o->over.items[0] : "");
  for (int i = 0; result == KT_DONE && i < 2; ++i)
    result = read_axis(o, pose->model, o->over.items[i], &def.axis[i]);
  if (result == KT_DONE && def.axis[0].coordinate == def.axis[1].coordinate)
    result = bad_axis(o, o->over.items[1]);
  if (result != KT_DONE)
    return result;
  const int locked[2] = {def.axis[0].coordinate, def.axis[1].coordinate};
  const km_all_modes_def of_modes = {.locked = locked, .locked_count = 2, .seed = o->common.seed};
  kt_progress progress = kt_progress_start(&o->common);
  km_status status =
      km_all_modes_find(pose->mechanism, pose->state, &of_modes, kt_progress_show, &progress, &modes, &error);
  if (!status)
    status =
        km_space_map_compute(pose->mechanism, pose->state, &def, &modes, kt_progress_show, &progress, &map, &error);
  kt_progress_end(&progress);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  result = kt_exit_of(status);
  if (result == KT_DONE && o->base)
    result = kspace_write_csv(&o->common, o->base, map.cells, "map");
  if (result == KT_DONE && o->base)
    result = kspace_write_csv(&o->common, o->base, map.curves, "curves");
  if (result == KT_DONE) {
    print_map(o, pose->model, &def, &modes, &map, &out);
    result = kt_print(&o->common, &out);
  }
  if (result == KT_DONE && !modes.is_complete)
    result = KT_PARTIAL;
  km_text_free(&out);
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  return result;
}

kt_exit kspace_map(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      {"over", 0, "JOINT=FROM:TO:N", "A driver and its grid: N values from FROM to TO. Given twice", KT_TEXTS, &o.over,
       KT_ABOUT_MODEL},
      KT_SET(&o.sets, "Start from another pose: move a joint to a value"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      KT_BASE(&o.base, "Write the grid to BASE.map.csv and the curves to BASE.curves.csv"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED);
  kt_options_read(
      &all,
      "Maps over two drivers of a mechanism with two freedoms: one sheet for each assembly mode at the pose, followed from "
      "grid point to grid point, and the singularity curves of the drivers that bound the sheets."
      "\vA row of the grid has the configuration, all mobility numbers, and the smallest singular values of the input "
      "(the Jacobian of the closure without the drivers' columns) and of the closure. The curves are followed by "
      "continuation of the closure with a null vector; each point is on the curve to rounding. Limits are ignored. Exit "
      "status 1: the list of modes may lack some, and so the sheets. Ball joints, redundant conditions and more freedoms "
      "are refused.",
      argc, argv);
  kt_pose pose;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
