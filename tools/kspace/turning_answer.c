/* Record and text of kspace turning. */
#include "kspace/turning_answer.h"

#include "kspace/kspace.h"

#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>

/* "A goes fully round for r up to 41.87"; nothing if it never does. */
static void print_turns(const km_turning *t, const km_turning_def *def, const char *driver, km_text *out) {
  bool is_first = true;
  for (int i = 0; i < t->interval_count; ++i) {
    if (!t->intervals[i].turns)
      continue;
    int first = i;
    while (i + 1 < t->interval_count && t->intervals[i + 1].turns)
      ++i;
    double from = t->intervals[first].from, to = t->intervals[i].to;
    if (is_first)
      km_text_format(out, "%s goes fully round for %s ", driver, def->path);
    km_text_add(out, is_first ? "" : " and ");
    if (first == 0 && i == t->interval_count - 1)
      km_text_format(out, "from %.6g to %.6g, the whole range", from, to);
    else if (first == 0)
      km_text_format(out, "below %.6g", to);
    else if (i == t->interval_count - 1)
      km_text_format(out, "above %.6g", from);
    else
      km_text_format(out, "from %.6g to %.6g", from, to);
    is_first = false;
  }
  if (is_first)
    km_text_format(out, "%s goes nowhere fully round for %s from %.6g to %.6g", driver, def->path, def->from, def->to);
  km_text_add(out, "\n");
}

/* Motion of the driver between two critical values. */
typedef enum driver_motion { TURNS, SWINGS, ENDLESS, NOT_FOUND, NOT_ASSEMBLED, NOT_DEFINED } driver_motion;

static driver_motion motion_of(const km_turning_interval *at) {
  if (!at->is_defined)
    return NOT_DEFINED;
  if (!at->is_assembled)
    return NOT_ASSEMBLED;
  if (at->turns)
    return TURNS;
  if (isnan(at->low))
    return NOT_FOUND;
  return isfinite(at->low) && isfinite(at->high) ? SWINGS : ENDLESS;
}

static void print_interval(const km_turning_interval *at, const char *driver, const char *unit, km_text *out) {
  km_text_format(out, "  %.6g to %.6g: ", at->from, at->to);
  switch (motion_of(at)) {
  case TURNS:
    km_text_format(out, "%s goes round", driver);
    break;
  case SWINGS:
    km_text_format(out, "%s swings, at %.6g from %.6g to %.6g %s", driver, 0.5 * (at->from + at->to), at->low, at->high,
                   unit);
    break;
  case ENDLESS:
    km_text_format(out, "%s moves without end", driver);
    break;
  case NOT_FOUND:
    km_text_format(out, "the swing of %s was not found", driver);
    break;
  case NOT_ASSEMBLED:
    km_text_add(out, "the circuit of the drawing is not there");
    break;
  default:
    km_text_add(out, "the model can't be read with these numbers");
  }
  if (at->is_defined)
    km_text_format(out, "; %d dead point%s in all circuits", at->dead_points, at->dead_points == 1 ? "" : "s");
  km_text_add(out, "\n");
}

static void print_critical(const km_turning_point *point, const km_turning_def *def, const char *driver,
                           const char *unit, km_text *out) {
  static const char *const words[] = {"", "two motions cross: circuits join or part",
                                      "an isolated configuration: a circuit appears or vanishes",
                                      "two dead points meet: the circuits stay"};
  double angle = fabs(point->driver) < 1e-6 ? 0.0 : point->driver; /* digits beyond are rounding */
  km_text_format(out, "  %s = %.10g with %s at %.6g %s: %s\n", def->path, point->number, driver, angle, unit,
                 words[point->kind]);
}

void kspace_print_turning(const km_model *model, const km_turning_def *def, const km_turning *t, km_text *out) {
  const char *driver = km_model_coordinate_label(model, def->driver);
  const char *unit = km_model_coordinate_unit(model, def->driver);
  km_text_format(out, "%s: ", def->file);
  if (t->is_stopped)
    km_text_format(out, "stopped: dead points of %s so far, for %s from %.6g to %.6g\n", driver, def->path, def->from,
                   def->to);
  else if (km_model_coordinate_is_length(model, def->driver))
    km_text_format(out, "dead points of %s for %s from %.6g to %.6g\n", driver, def->path, def->from, def->to);
  else
    print_turns(t, def, driver, out);
  for (int i = 0; i < t->interval_count; ++i)
    print_interval(&t->intervals[i], driver, unit, out);
  km_text_format(out, "%d critical value%s of %s\n", t->point_count, t->point_count == 1 ? "" : "s", def->path);
  for (int i = 0; i < t->point_count; ++i)
    print_critical(&t->points[i], def, driver, unit, out);
  km_text_format(out, "%d curve%s of dead points, %zu points, from the circuits of %d assembly mode%s%s\n",
                 t->curve_count, t->curve_count == 1 ? "" : "s", km_table_rows(t->curves), t->modes,
                 t->modes == 1 ? "" : "s",
                 t->is_complete             ? ""
                 : t->gap == KM_GAP_REFUSED ? " (others can't be listed)"
                                            : " (at least these)");
}

static void add_interval(const km_turning_interval *at, km_value *list, km_arena *arena) {
  static const char *const words[] = {"turns", "swings", "endless", "not found", "not assembled", "not defined"};
  driver_motion motion = motion_of(at);
  km_value *interval = km_value_add(arena, list, NULL, KM_OBJECT);
  km_value_number(arena, interval, "from", at->from);
  km_value_number(arena, interval, "to", at->to);
  km_value_string(arena, interval, "motion", words[motion]);
  km_value_number(arena, interval, "low", motion == SWINGS ? at->low : nan(""));
  km_value_number(arena, interval, "high", motion == SWINGS ? at->high : nan(""));
  km_value_number(arena, interval, "dead_points", motion == NOT_DEFINED ? nan("") : at->dead_points);
}

static void add_critical(const km_turning_point *point, km_value *list, km_arena *arena) {
  km_value *critical = km_value_add(arena, list, NULL, KM_OBJECT);
  km_value_number(arena, critical, "number", point->number);
  km_value_number(arena, critical, "driver", point->driver);
  km_value_string(arena, critical, "kind", km_turning_kind_name(point->kind));
  km_value_number(arena, critical, "curve", point->curve);
}

const km_value *kspace_turning_record(const kt_pose *pose, const km_turning_def *def, const km_turning *t,
                                      km_arena *arena) {
  km_value *record = km_record_head(pose->mechanism, "kspace turning", def->file, arena);
  km_value_string(arena, record, "driver", km_model_coordinate_label(pose->model, def->driver));
  km_value_string(arena, record, "number", def->path);
  km_value_number(arena, record, "from", def->from);
  km_value_number(arena, record, "to", def->to);
  kspace_record_completeness(t->is_stopped ? KM_GAP_STOPPED : t->gap, record, arena);
  km_value_number(arena, record, "modes", t->modes);
  km_value *intervals = km_value_add(arena, record, "intervals", KM_LIST);
  for (int i = 0; i < t->interval_count && !arena->failed; ++i)
    add_interval(&t->intervals[i], intervals, arena);
  km_value *critical = km_value_add(arena, record, "critical_values", KM_LIST);
  for (int i = 0; i < t->point_count && !arena->failed; ++i)
    add_critical(&t->points[i], critical, arena);
  km_value_number(arena, record, "curves", t->curve_count);
  km_table_record(t->curves, record, arena);
  return arena->failed ? NULL : record;
}
