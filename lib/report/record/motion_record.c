/* Record and summary of a motion: swings, speeds and accelerations of joints, paths of points. */
#include "report/record/sweep_text.h"

#include "base/table.h"
#include "report/record/record.h"
#include "topology/mechanism.h"

#include <math.h>

static void add_swing(const km_model *model, const km_swing *swing, km_value *list, km_arena *arena) {
  km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
  km_value_string(arena, item, "joint", km_model_coordinate_label(model, swing->coordinate));
  km_value_number(arena, item, "least", swing->low);
  km_value_number(arena, item, "least_at", swing->s_low);
  km_value_number(arena, item, "greatest", swing->high);
  km_value_number(arena, item, "greatest_at", swing->s_high);
  km_value_boolean(arena, item, "goes_round", swing->goes_round);
}

km_value *km_motion_sweep_record(const km_mechanism *m, const km_motion_sweep *sweep, const char *stopped_by,
                                 const char *name, km_arena *arena) {
  km_value *record = km_record_head(m, "kmob motion", name, arena);
  km_table_record(sweep->motion.table, record, arena);
  km_value_number(arena, record, "rate", sweep->rate);
  km_value *swings = km_value_add(arena, record, "swings", KM_LIST);
  for (int i = 0; i < sweep->swing_count && !arena->failed; ++i)
    add_swing(m->model, &sweep->swings[i], swings, arena);
  km_sweep_record(&sweep->motion, stopped_by, record, arena);
  return arena->failed ? NULL : record;
}

/* ", at most V at JOINT = s" of the largest magnitude in a column. */
static void print_most(const km_table *t, int column, const char *words, const char *s_unit, km_text *out) {
  double value, where;
  if (column >= 0 && !km_table_figure(t, km_table_name(t, (size_t)column), KM_FIGURE_PEAK, 0, &value, &where, NULL) &&
      isfinite(value))
    km_text_format(out, "%s %.6g %s (%.6g%s)", words, value, km_table_unit(t, (size_t)column), where, s_unit);
}

double km_swing_acceleration(const km_motion_sweep *sweep, const km_swing *swing, double *where) {
  static const double rounding = 1e-9; /* part of v²/swing, the acceleration of a motion of this speed and extent */
  const km_table *t = sweep->motion.table;
  const size_t c = (size_t)swing->coordinate;
  const char *velocity = km_table_name(t, km_table_span(t, "v.").first + c);
  const char *acceleration = km_table_name(t, km_table_span(t, "a.").first + c);
  double v = nan(""), a = nan("");
  *where = nan("");
  km_table_figure(t, velocity, KM_FIGURE_PEAK, 0, &v, NULL, NULL);
  km_table_figure(t, acceleration, KM_FIGURE_PEAK, 0, &a, where, NULL);
  return a <= rounding * v * v / (swing->high - swing->low) ? 0.0 : a;
}

static void print_joint(const km_mechanism *m, const km_sweep_plan *plan, const km_motion_sweep *sweep,
                        const km_swing *swing, int width, km_text *out) {
  const km_table *t = sweep->motion.table;
  const char *unit = km_sweep_unit(m, plan);
  int c = swing->coordinate;
  if (!km_swing_print(m, plan, swing, width, out))
    return;
  print_most(t, (int)km_table_span(t, "v.").first + c, "; at most", unit, out);
  double where;
  if (km_swing_acceleration(sweep, swing, &where) > 0.0)
    print_most(t, (int)km_table_span(t, "a.").first + c, ",", unit, out);
  km_text_add(out, "\n");
}

/* "  coupler/tip  path of 0.3 m, at most 0.5 m/s (0.2 rad)" */
static void print_point(const km_mechanism *m, const km_sweep_plan *plan, const km_table *t, const char *point,
                        km_text *out) {
  km_text column = {0};
  km_text_format(&column, "point.%s.path", point);
  int path = km_table_find(t, column.data ? column.data : "");
  if (path >= 0) {
    km_text_format(out, "  %s  path of %.6g %s", point, km_table_row(t, km_table_rows(t) - 1)[path],
                   km_table_unit(t, (size_t)path));
    print_most(t, path - 1, ", at most", km_sweep_unit(m, plan), out);
    km_text_add(out, "\n");
  }
  out->failed = out->failed || column.failed;
  km_text_free(&column);
}

void km_motion_sweep_print(const km_mechanism *m, const km_sweep_plan *plan, const km_motion_sweep *sweep,
                           const char *name, km_text *out) {
  const km_table *t = sweep->motion.table;
  int width = km_widest_label(m->model), shown = 0, more = 0;
  km_sweep_print_range(m, plan, &sweep->motion, name, out);
  km_text_format(out, "  %s at %.6g %s/%s, %.6g %s in all\n", km_model_coordinate_label(m->model, plan->coordinate),
                 sweep->rate, km_model_coordinate_unit(m->model, plan->coordinate), m->model->units.time->suffix,
                 km_table_row(t, km_table_rows(t) - 1)[km_table_find(t, "t")], m->model->units.time->suffix);
  for (int i = 0; i < plan->point_count; ++i)
    print_point(m, plan, t, plan->points[i].name, out);
  for (int i = 0; i < sweep->swing_count; ++i) {
    km_text line = {0};
    if (m->ball_of[sweep->swings[i].coordinate] < 0 && sweep->swings[i].coordinate != plan->coordinate)
      print_joint(m, plan, sweep, &sweep->swings[i], width, &line);
    bool moves = line.size > 0;
    if (moves && shown < KM_SWINGS_SHOWN)
      km_text_add(out, line.data);
    shown += moves && shown < KM_SWINGS_SHOWN;
    more += moves;
    out->failed = out->failed || line.failed;
    km_text_free(&line);
  }
  if (more > shown)
    km_text_format(out, "  %d more joint%s\n", more - shown, more - shown == 1 ? " moves" : "s move");
  km_sweep_print_mobility(m, plan, &sweep->motion, out);
}
