/* Reports about motions: swings, speeds and accelerations over a driver's range; forces, reactions and energies over
 * time. */
#include "report/document/motion_report.h"

#include "question/question.h"
#include "report/charts/history_plot.h"
#include "report/charts/question_plot.h"
#include "report/document/sweep_report.h"
#include "report/record/sweep_text.h"
#include "report/record/words/forces_text.h"
#include "report/record/words/speed_text.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

static const double rounding = 1e-9; /* part of the largest load, of a moment also of the largest force times the
                                      * characteristic length, below which another one is rounding */
enum { PANEL = 120, MOST_PLOT = 640, LEAD_JOINTS = 3 };

/* A plot without its strip, as high as its panels need. */
static void add_plot(km_document_maker *k, km_plot *plot, const char *shows) {
  plot->strip = (km_plot_strip){0};
  km_report_plot(k, plot, shows, fmin(MOST_PLOT, 40.0 + PANEL * (double)plot->panel_count));
}

/* Largest magnitude of a column, "12.3 rad/s at 0.4 s", or "–". */
static const char *peak_words(km_document_maker *k, const km_table *t, size_t column, const char *s_unit) {
  double value = nan(""), where = nan("");
  km_table_figure(t, km_table_name(t, column), KM_FIGURE_PEAK, 0, &value, &where, NULL);
  if (!isfinite(value))
    return "–";
  return km_document_format(k, "%.5g %s at %.5g%s", value, km_table_unit(t, column), where, s_unit);
}

/* ---- Over a driver's range. */

bool km_report_shows_swing(const km_mechanism *m, const km_sweep_plan *plan, const km_swing *swing) {
  int c = swing->coordinate;
  return c != plan->coordinate && m->ball_of[c] < 0 && !m->held[c] &&
         (swing->high - swing->low) * m->factor[c] * m->scale[c] > 1e-9;
}

static void add_motion_lead(km_document_maker *k, const km_swept *swept, const km_motion_sweep *sweep) {
  km_text text = {0};
  const km_model *model = swept->mechanism->model;
  km_text_format(&text, "While %s moves at %.5g %s/%s:", km_model_coordinate_label(model, swept->plan->coordinate),
                 sweep->rate, km_model_coordinate_unit(model, swept->plan->coordinate), model->units.time->suffix);
  int shown = 0;
  for (int i = 0; i < sweep->swing_count && shown < LEAD_JOINTS; ++i) {
    const km_swing *swing = &sweep->swings[i];
    if (!km_report_shows_swing(swept->mechanism, swept->plan, swing))
      continue;
    km_text_format(&text, "%s %s ", shown++ ? ";" : "", km_model_coordinate_label(model, swing->coordinate));
    if (swing->goes_round)
      km_text_add(&text, "goes round");
    else
      km_text_format(&text, "%s by %.5g %s, from %.5g to %.5g",
                     km_coordinate_turns(swept->mechanism, swing->coordinate) ? "swings" : "moves",
                     swing->high - swing->low, km_model_coordinate_unit(model, swing->coordinate), swing->low,
                     swing->high);
  }
  km_text_add(&text, ".");
  km_document_lead(k, km_document_words(k, &text, ""));
}

/* Swing, largest velocity and acceleration of each joint that moves. */
static void add_swings(km_document_maker *k, const km_swept *swept, const km_motion_sweep *sweep) {
  enum { COLUMNS = 6 };
  static const char *const heads[COLUMNS] = {
      "joint", "least", "greatest", "swing", "largest velocity", "largest acceleration"};
  const km_mechanism *m = swept->mechanism;
  const km_table *t = sweep->motion.table;
  const char *unit = km_sweep_unit(m, swept->plan);
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (size_t)(sweep->swing_count + 1) * COLUMNS);
  size_t rows = 1;
  for (size_t c = 0; c < COLUMNS && cells; ++c)
    cells[c] = heads[c];
  for (int i = 0; i < sweep->swing_count && cells; ++i) {
    const km_swing *swing = &sweep->swings[i];
    if (!km_report_shows_swing(m, swept->plan, swing))
      continue;
    const char **row = cells + COLUMNS * rows++, *own = km_model_coordinate_unit(m->model, swing->coordinate);
    size_t c = (size_t)swing->coordinate;
    row[0] = km_model_coordinate_label(m->model, swing->coordinate);
    row[1] = swing->goes_round ? "" : km_document_format(k, "%.5g %s at %.5g%s", swing->low, own, swing->s_low, unit);
    row[2] = swing->goes_round ? "" : km_document_format(k, "%.5g %s at %.5g%s", swing->high, own, swing->s_high, unit);
    row[3] = swing->goes_round ? "goes round" : km_document_format(k, "%.5g %s", swing->high - swing->low, own);
    row[4] = peak_words(k, t, km_table_span(t, "v.").first + c, unit);
    double where;
    row[5] = km_swing_acceleration(sweep, swing, &where) > 0.0
                 ? peak_words(k, t, km_table_span(t, "a.").first + c, unit)
                 : "–";
  }
  km_document_heading(k, "Joints");
  if (cells && rows > 1)
    km_document_cells(k, KM_BLOCK_TABLE, cells, rows, COLUMNS);
}

/* Path length and largest speed of the traced points. */
static void add_points(km_document_maker *k, const km_swept *swept, const km_table *t) {
  enum { COLUMNS = 3 };
  size_t rows = (size_t)swept->plan->point_count + 1;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, rows *COLUMNS);
  if (!cells || rows == 1)
    return;
  cells[0] = "point";
  cells[1] = "path";
  cells[2] = "largest speed";
  for (size_t i = 1; i < rows; ++i) {
    const char *name = swept->plan->points[i - 1].name;
    int path = km_table_find(t, km_document_format(k, "point.%s.path", name));
    const double *last = km_table_row(t, km_table_rows(t) - 1);
    cells[COLUMNS * i] = name;
    cells[COLUMNS * i + 1] = km_document_format(k, "%.5g %s", last[path], km_table_unit(t, (size_t)path));
    cells[COLUMNS * i + 2] = peak_words(k, t, (size_t)path - 1, km_sweep_unit(swept->mechanism, swept->plan));
  }
  km_document_heading(k, "Points");
  km_document_cells(k, KM_BLOCK_TABLE, cells, rows, COLUMNS);
}

void km_motion_report_make(km_document_maker *k, const km_answered *a, const char *stopped_by, bool brief) {
  const km_motion_sweep *sweep = km_question_velocities(a->question);
  const km_swept swept = {a->question->m, km_question_plan(a->question), &sweep->motion, a->name};
  const km_comparison one = {.answers = a, .count = 1};
  km_report_facts facts = {.rows = 0};
  km_plot plot;
  add_motion_lead(k, &swept, sweep);
  km_report_motion(k, &swept, stopped_by, &facts);
  km_report_close_facts(k, &facts);
  add_swings(k, &swept, sweep);
  add_points(k, &swept, sweep->motion.table);
  km_report_poses(k, &swept);
  if (brief)
    return;
  km_document_heading(k, "Velocities and accelerations");
  if (!km_question_plot_make(&one, &k->arena, &plot, NULL))
    add_plot(k, &plot, "velocities and accelerations over the driver");
  km_report_model(k, &swept,
                  "closed loops at every row; velocities and accelerations by the loops' first and second order");
}

/* ---- Over time. */

/* "0.0019 s (A = 35.1 deg)": a time and the place of a coordinate (−1: the driver). */
static const char *when_words(km_document_maker *k, const km_mechanism *m, const km_table *t, int coordinate,
                              double time) {
  km_text text = {0};
  km_text_format(&text, "%.5g %s", time, m->model->units.time->suffix);
  km_place_words(m, t, coordinate, time, &text);
  return km_document_words(k, &text, "");
}

static void add_history_lead(km_document_maker *k, const km_mechanism *m, const km_history *h, bool run) {
  const km_table *t = h->table;
  const char *time = m->model->units.time->suffix;
  km_text text = {0}, speed = {0};
  if (run)
    km_text_format(&text, "In %.5g %s the kinetic energy is at most %s.",
                   km_table_row(t, km_table_rows(t) - 1)[0] - km_table_row(t, 0)[0], time,
                   peak_words(k, t, (size_t)km_table_find(t, "energy_kinetic"), km_document_format(k, " %s", time)));
  km_speed_words(m, t, &speed);
  if (speed.size)
    km_text_format(&text, "%s%s. ", run ? " " : "", speed.data);
  km_text_free(&speed);
  for (int i = 0; i < h->peak_count && i < LEAD_JOINTS; ++i) {
    const km_force_peak *peak = &h->peaks[i];
    const char *unit = km_table_unit(t, peak->column), *when = when_words(k, m, t, peak->coordinate, peak->time);
    if (peak->coordinate >= 0)
      km_text_format(&text, "%s%s takes at most %.6g %s at %s, %.6g %s rms", i ? "; " : "",
                     km_model_coordinate_label(m->model, peak->coordinate), fabs(peak->value), unit, when, peak->rms,
                     unit);
    else
      km_text_format(&text, "%sshaking force at most %.5g %s at %s", i ? "; " : "", peak->value, unit, when);
  }
  if (h->peak_count)
    km_text_add(&text, ".");
  km_document_lead(k, km_document_words(k, &text, ""));
}

static void add_history_facts(km_document_maker *k, const km_mechanism *m, const km_history *h, bool run,
                              const char *stopped_by) {
  km_report_facts facts = {.rows = 0};
  const km_table *t = h->table;
  km_text acting = {0};
  km_acting_words(m->model, NULL, false, &acting);
  km_report_fact(&facts, "Time",
                 km_document_format(k, "%.6g to %.6g %s, %zu rows", km_table_row(t, 0)[0],
                                    km_table_row(t, km_table_rows(t) - 1)[0], m->model->units.time->suffix,
                                    km_table_rows(t)));
  if (stopped_by[0])
    km_report_fact(&facts, "Ended early", stopped_by);
  km_report_fact(&facts, "What acts", km_document_words(k, &acting, ""));
  km_report_fact(&facts, "Loops", km_document_format(k, "closed to %.1e of their size", h->worst_loop));
  km_report_digits(m, &facts);
  if (run && h->energy_scale > h->figures.rest_energy)
    km_report_fact(
        &facts, "Energy",
        km_document_format(k, "kept to %.1e of the largest kinetic energy", h->energy_error / h->energy_scale));
  for (int i = 0; i < h->limit_count; ++i)
    km_report_fact(&facts, "Limit passed",
                   km_document_format(k, "%s at %.5g %s", km_model_coordinate_label(m->model, h->limits[i].coordinate),
                                      h->limits[i].time, m->model->units.time->suffix));
  km_report_close_facts(k, &facts);
}

/* Bearing loads: largest reaction of each joint. */
static void add_bearings(km_document_maker *k, const km_mechanism *m, const km_table *t) {
  enum { COLUMNS = 5 };
  static const char *const heads[COLUMNS] = {"joint", "largest force", "at", "largest moment", "at"};
  km_span span = km_table_span(t, "r.");
  size_t joints = span.count / 6;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (joints + 1) * COLUMNS);
  if (!cells || joints == 0)
    return;
  double forces = 0.0, moments = 0.0, ignored;
  for (size_t j = 0; j < joints; ++j) {
    forces = fmax(forces, km_largest_norm(t, span.first + 6 * j, &ignored));
    moments = fmax(moments, km_largest_norm(t, span.first + 6 * j + 3, &ignored));
  }
  for (size_t c = 0; c < COLUMNS; ++c)
    cells[c] = heads[c];
  for (size_t j = 0; j < joints; ++j) {
    double at_force = 0.0, at_moment = 0.0;
    size_t first = span.first + 6 * j;
    double force = km_largest_norm(t, first, &at_force), moment = km_largest_norm(t, first + 3, &at_moment);
    const bool pushes = force > rounding * forces, twists = moment > rounding * fmax(moments, forces * m->length);
    const char **row = cells + COLUMNS * (j + 1);
    row[0] = m->model->joints[j].label;
    row[1] = pushes ? km_document_format(k, "%.5g %s", force, km_table_unit(t, first)) : "–";
    row[2] = pushes ? when_words(k, m, t, -1, at_force) : "";
    row[3] = twists ? km_document_format(k, "%.5g %s", moment, km_table_unit(t, first + 3)) : "–";
    row[4] = twists ? when_words(k, m, t, -1, at_moment) : "";
  }
  km_document_heading(k, "Bearing loads");
  km_document_text(k, "Magnitudes of force and moment of parent on child at each joint's frame, largest of all rows.");
  km_document_cells(k, KM_BLOCK_TABLE, cells, joints + 1, COLUMNS);
  km_text meshing = {0};
  km_meshing_words(m->model, &meshing);
  if (meshing.size)
    km_document_text(k, km_document_format(k, "Note: %s.", km_text_move_to_arena(&meshing, &k->arena)));
}

/* Driving forces with their peaks, also between rows, and root mean squares. */
static void add_peaks(km_document_maker *k, const km_mechanism *m, const km_history *h) {
  enum { COLUMNS = 4 };
  size_t rows = (size_t)h->peak_count + 1;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, rows *COLUMNS);
  if (!cells || rows == 1)
    return;
  cells[0] = "force";
  cells[1] = "largest";
  cells[2] = "at";
  cells[3] = "root mean square";
  for (size_t i = 1; i < rows; ++i) {
    const km_force_peak *peak = &h->peaks[i - 1];
    const char *unit = km_table_unit(h->table, peak->column), **row = cells + COLUMNS * i;
    row[0] = peak->coordinate < 0
                 ? "shaking force"
                 : km_document_format(k, "of %s", km_model_coordinate_label(m->model, peak->coordinate));
    row[1] = km_document_format(k, "%s %s", km_report_number(k, peak->value), unit);
    row[2] = when_words(k, m, h->table, peak->coordinate, peak->time);
    row[3] = km_document_format(k, "%s %s", km_report_number(k, peak->rms), unit);
  }
  km_document_heading(k, "Driving forces");
  km_document_cells(k, KM_BLOCK_TABLE, cells, rows, COLUMNS);
}

/* Events of a run in their order. */
static void add_events(km_document_maker *k, const km_answered *a) {
  int count = km_question_event_count(a->question);
  km_text text = {0};
  for (int i = 0; i < count; ++i) {
    km_question_event e = km_question_event_at(a->question, i);
    if (strcmp(e.name, "crossing") == 0)
      km_text_format(&text, "%s%s passes %.5g at %.6g %s", text.size ? "; " : "", e.subject, e.value, e.s,
                     a->question->m->model->units.time->suffix);
  }
  if (text.size) {
    km_document_heading(k, "Events");
    km_document_text(k, km_document_words(k, &text, ""));
  }
  km_text_free(&text);
}

void km_history_report_make(km_document_maker *k, const km_answered *a, const char *stopped_by, bool brief) {
  const km_mechanism *m = a->question->m;
  const km_history *h = km_question_history(a->question);
  const km_swept swept = {.mechanism = m, .name = a->name};
  const km_comparison one = {.answers = a, .count = 1};
  const bool run = km_question_run_def(a->question) != NULL;
  km_plot plot;
  add_history_lead(k, m, h, run);
  add_history_facts(k, m, h, run, stopped_by);
  add_peaks(k, m, h);
  add_events(k, a);
  add_bearings(k, m, h->table);
  km_report_run_poses(k, m, h->table, a->name);
  if (brief)
    return;
  km_document_heading(k, "Over time");
  if (!km_question_plot_make(&one, &k->arena, &plot, NULL))
    add_plot(k, &plot, run ? "coordinates, rates and energies over time" : "forces and coordinates over time");
  km_report_model(k, &swept,
                  run ? "equations of motion in independent coordinates, loops closed at every evaluation"
                      : "forces of the prescribed motion by the balance of its virtual power, row by row");
}
