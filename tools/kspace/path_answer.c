/* Record and text of kspace path. */
#include "kspace/path_answer.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>

void kspace_print_path(const kspace_path_answer *a, km_text *out) {
  const km_space_path *path = &a->path;
  size_t rows = km_table_rows(path->table);
  km_text_format(out, "%s: ", a->model);
  switch (path->outcome) {
  case KM_SPACE_PATH_FOUND:
    km_text_format(out, "a path of %zu step%s%s, length %.4g\n", rows > 0 ? rows - 1 : 0, rows == 2 ? "" : "s",
                   path->is_straight ? ", straight" : "", path->length);
    if (isfinite(path->least_margin))
      km_text_format(
          out, "smallest singular value of the input: %.4g at the start, %.4g at the end, at least %.4g between\n",
          path->ends[0], path->ends[1], path->least_margin);
    if (!path->is_smooth)
      km_text_add(out, "no smooth path is allowed beside this one: the drivers turn corners\n");
    break;
  case KM_SPACE_PATH_SEPARATED:
    km_text_format(out,
                   "no path: the determinant of the input has opposite signs at the start and %s, so that each path "
                   "passes a singularity of the drivers\n",
                   a->has_free_end ? "in the assembly modes that were found at the end" : "at the end");
    break;
  case KM_SPACE_PATH_END:
    if (isnan(path->ends[!path->is_at_start]))
      km_text_format(out, "no path: the drivers are singular at the %s, or no loop closes there\n",
                     path->is_at_start ? "start" : "end");
    else if (isinf(path->ends[!path->is_at_start]))
      km_text_format(out, "no path: the %s is beyond a limit or lacks the clearance\n",
                     path->is_at_start ? "start" : "end");
    else
      km_text_format(
          out,
          "no path: the %s is beyond a limit, lacks the clearance, or is nearer to a singularity than the margin %.4g: "
          "the smallest singular value there is %.4g\n",
          path->is_at_start ? "start" : "end", a->margin, path->ends[!path->is_at_start]);
    break;
  case KM_SPACE_PATH_STOPPED:
    km_text_format(out, "stopped: no path was found so far, among %d configurations; there may be one\n",
                   path->configurations);
    break;
  default:
    km_text_format(out, "no path was found among %d configurations; there may be one\n", path->configurations);
  }
  if (!path->is_straight && path->outcome == KM_SPACE_PATH_FOUND)
    km_text_format(out, "the straight path is blocked; the search took %d configurations\n", path->configurations);
}

const km_value *kspace_path_record(const kspace_path_answer *a, km_arena *arena) {
  const km_space_path *path = &a->path;
  km_value *record = km_record_head(a->pose->mechanism, "kspace path", a->model, arena);
  km_value *drivers = km_value_add(arena, record, "drivers", KM_LIST);
  for (int d = 0; d < a->driver_count; ++d)
    km_value_string(arena, drivers, NULL, km_model_coordinate_label(a->pose->model, a->drivers[d]));
  km_value_string(arena, record, "outcome", km_space_path_outcome_name(path->outcome));
  if (path->outcome == KM_SPACE_PATH_END)
    km_value_string(arena, record, "end", path->is_at_start ? "start" : "end");
  km_value_number(arena, record, "margin", a->margin);
  km_value_numbers(arena, record, "ends", path->ends, 2);
  km_value_number(arena, record, "configurations", path->configurations);
  if (path->outcome == KM_SPACE_PATH_FOUND) {
    km_value_boolean(arena, record, "straight", path->is_straight);
    km_value_boolean(arena, record, "smooth", path->is_smooth);
    km_value_number(arena, record, "length", path->length);
    km_value_number(arena, record, "least_margin", path->least_margin);
  }
  km_table_record(path->table, record, arena);
  if (km_table_rows(path->explored) > 0)
    km_table_record(path->explored, km_value_add(arena, record, "explored", KM_OBJECT), arena);
  return arena->failed ? NULL : record;
}
