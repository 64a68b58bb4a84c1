/* The report about what holds a mechanism: its facts, peaks, rows and reactions as blocks of a document. */
#include "report/document/statics_report.h"

#include "report/document/sweep_report.h"
#include "report/record/sweep_text.h"
#include "statics/statics.h"
#include "topology/mechanism.h"

#include <math.h>

static const char *unit_of(km_document_maker *k, const km_model *model, const km_port *actuator) {
  km_text text = {0};
  km_push_unit(model, actuator, &text);
  return km_text_move_to_arena(&text, &k->arena);
}

static const char *label_of(const km_plotted_statics *p, int actuator) {
  return p->sweep->actuators[actuator].name;
}

/* Facts on the first page: largest forces and their locations, or that the balance is impossible. */
static void add_lead(km_document_maker *k, const km_plotted_statics *p) {
  enum { MOST = 3 };
  const char *s_unit = km_sweep_unit(p->swept.mechanism, p->swept.plan), *stroke = km_report_stroke(k, &p->swept);
  km_text text = {0};
  if (p->sweep->unheld)
    km_text_format(&text, "The actuators can't hold the mechanism everywhere %s: first not at %.6g%s. ", stroke,
                   p->sweep->first_unheld, s_unit);
  else
    km_text_format(&text, "The actuators hold the mechanism %s. ", stroke);
  for (int i = 0, named = 0; i < p->sweep->actuator_count && named < MOST; ++i) {
    const km_force_event *largest = &p->sweep->largest[i];
    if (isnan(largest->s))
      continue;
    if (isinf(largest->value))
      km_text_format(&text, "%s%s takes a force that grows without bound at %.6g%s", named++ ? "; " : "",
                     label_of(p, i), largest->s, s_unit);
    else
      km_text_format(&text, "%s%s holds at most %s %s%s, at %.6g%s", named++ ? "; " : "", label_of(p, i),
                     km_report_number(k, fabs(largest->value)),
                     unit_of(k, p->swept.mechanism->model, &p->sweep->actuators[i]),
                     largest->value < 0.0 ? " in size, against its positive sense" : "", largest->s, s_unit);
  }
  km_text_add(&text, ".");
  km_document_lead(k, km_document_words(k, &text, ""));
}

static void add_facts(km_document_maker *k, const km_plotted_statics *p, const char *acting, const char *stopped_by) {
  km_report_facts facts = {.rows = 0};
  km_text names = {0};
  for (int i = 0; i < p->sweep->actuator_count; ++i)
    km_text_format(&names, "%s%s", i ? ", " : "", label_of(p, i));
  km_report_fact(&facts, "Actuators", km_document_words(k, &names, "none"));
  km_report_fact(&facts, "What acts", acting);
  km_report_fact(&facts, "Held at",
                 p->sweep->unheld ? km_document_format(k, "not at %zu of %zu rows, first at %.6g%s", p->sweep->unheld,
                                                       km_table_rows(p->swept.motion->table), p->sweep->first_unheld,
                                                       km_sweep_unit(p->swept.mechanism, p->swept.plan))
                                  : "every row");
  km_report_fact(
      &facts, "Static indeterminacy",
      p->sweep->degree
          ? km_document_format(k, "degree %d: of what statics leaves open the least answer is given", p->sweep->degree)
          : "none: statics determines every reaction");
  km_report_motion(k, &p->swept, stopped_by, &facts);
  km_report_close_facts(k, &facts);
}

static const char *where(km_document_maker *k, const km_plotted_statics *p, int actuator, km_force_event_kind kind) {
  enum { MOST_PLACES = 12 };
  km_text text = {0};
  int count = 0;
  for (size_t i = 0; i < p->sweep->event_count; ++i)
    if (p->sweep->events[i].actuator == actuator && p->sweep->events[i].kind == kind && count++ < MOST_PLACES)
      km_text_format(&text, "%s%.6g", text.size ? ", " : "", p->sweep->events[i].s);
  if (count > MOST_PLACES)
    km_text_format(&text, "; and %d more", count - MOST_PLACES);
  return km_document_words(k, &text, "–");
}

/* Largest force of each actuator, and its zeros and poles. */
static void add_peaks(km_document_maker *k, const km_plotted_statics *p) {
  enum { COLUMNS = 5 };
  size_t rows = (size_t)p->sweep->actuator_count + 1;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, rows *COLUMNS);
  const char *unit = km_sweep_unit(p->swept.mechanism, p->swept.plan);
  if (!cells)
    return;
  cells[0] = "actuator";
  cells[1] = "largest force";
  cells[2] = km_document_format(k, "at (%s)", unit[0] ? unit + 1 : "arc length");
  cells[3] = "nothing to hold at";
  cells[4] = "without bound at";
  for (int i = 0; i < p->sweep->actuator_count; ++i) {
    const km_force_event *largest = &p->sweep->largest[i];
    const char **row = cells + (size_t)(i + 1) * COLUMNS;
    row[0] = label_of(p, i);
    row[1] = km_document_format(k, "%s %s", km_report_number(k, largest->value),
                                unit_of(k, p->swept.mechanism->model, &p->sweep->actuators[i]));
    row[2] = km_report_number(k, largest->s);
    row[3] = where(k, p, i, KM_FORCE_BALANCED);
    row[4] = where(k, p, i, KM_FORCE_UNBOUNDED);
  }
  km_document_cells(k, KM_BLOCK_TABLE, cells, rows, COLUMNS);
}

static void add_rows(km_document_maker *k, const km_plotted_statics *p) {
  enum { MOST = 9 };
  const km_model *model = p->swept.mechanism->model;
  km_report_column columns[MOST] = {
      {km_report_s(&p->swept),
       p->swept.plan->arclength > 0.0
           ? "arc length"
           : km_document_format(k, "%s (%s)", km_model_coordinate_label(model, p->swept.plan->coordinate),
                                km_model_coordinate_unit(model, p->swept.plan->coordinate))}};
  size_t count = 1;
  for (int i = 0; i < p->sweep->actuator_count && count < MOST; ++i, ++count)
    columns[count] = (km_report_column){
        km_force_column(p->sweep, i),
        km_document_format(k, "%.60s (%s)", label_of(p, i), unit_of(k, model, &p->sweep->actuators[i]))};
  km_document_heading(k, "At chosen poses");
  if (count == MOST && p->sweep->actuator_count > MOST - 1)
    km_document_text(k, km_document_format(k, "The first %d of %d actuators.", MOST - 1, p->sweep->actuator_count));
  size_t places = p->sweep->event_count + (size_t)p->sweep->actuator_count;
  double *special = KM_ARENA_NEW(&k->arena, double, places);
  if (!special)
    return;
  for (int i = 0; i < p->sweep->actuator_count; ++i)
    special[i] = p->sweep->largest[i].s;
  for (size_t i = 0; i < p->sweep->event_count; ++i)
    special[(size_t)p->sweep->actuator_count + i] = p->sweep->events[i].s;
  km_report_rows(k, &p->swept, columns, count, special, places);
}

/* True if the actuator's force has the dimension of the first one's. */
static bool compares(km_document_maker *k, const km_plotted_statics *p, int actuator) {
  const km_model *model = p->swept.mechanism->model;
  return fabs(p->sweep->largest[actuator].value) > 0.0 &&
         strcmp(unit_of(k, model, &p->sweep->actuators[actuator]), unit_of(k, model, &p->sweep->actuators[0])) == 0;
}

/* The row at which some actuator holds most, of those that compare. */
static size_t worst_row(km_document_maker *k, const km_plotted_statics *p) {
  const km_table *table = p->swept.motion->table;
  bool *counts = KM_ARENA_NEW(&k->arena, bool, (size_t)p->sweep->actuator_count + 1);
  size_t worst = 0;
  double largest = -1.0;
  for (int i = 0; i < p->sweep->actuator_count && counts; ++i)
    counts[i] = compares(k, p, i);
  for (size_t r = 0; r < km_table_rows(table); ++r)
    for (int i = 0; i < p->sweep->actuator_count && counts; ++i) {
      double f = fabs(km_table_row(table, r)[km_force_column(p->sweep, i)]);
      if (isfinite(f) && f > largest && counts[i]) {
        largest = f;
        worst = r;
      }
    }
  return worst;
}

/* Reactions at one row; `?` behind what statics leaves open. */
static void add_reactions(km_document_maker *k, const km_plotted_statics *p, const km_statics *statics) {
  enum { COLUMNS = 7 };
  static const char *const heads[COLUMNS] = {"joint", "fx", "fy", "fz", "tx", "ty", "tz"};
  const km_model *model = p->swept.mechanism->model;
  size_t joints = (size_t)model->joint_count;
  const double *row = km_table_row(p->swept.motion->table, worst_row(k, p));
  size_t first = km_table_span(p->swept.motion->table, "r.").first;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (joints + 1) * COLUMNS);
  double forces = 0.0;
  if (!cells)
    return;
  for (size_t i = 0; i < 6 * joints; ++i)
    forces = fmax(forces, i % 6 < 3 ? fabs(row[first + i]) : 0.0);
  for (size_t c = 0; c < COLUMNS; ++c)
    cells[c] = heads[c];
  for (size_t j = 0; j < joints; ++j) {
    cells[(j + 1) * COLUMNS] = model->joints[j].label;
    for (size_t c = 0; c < 6; ++c) {
      double value = row[first + 6 * j + c];
      value = fabs(value) < 1e-9 * forces ? 0.0 : value; /* rounding */
      cells[(j + 1) * COLUMNS + 1 + c] =
          km_document_format(k, "%s%s", km_report_number(k, value), statics->reactions[j].indeterminate[c] ? "?" : "");
    }
  }
  km_text torque = {0};
  km_torque_unit(model, &torque);
  km_document_heading(k, "Reactions where an actuator holds most");
  km_document_text(k, km_document_format(
                          k,
                          "At %.6g%s. Wrench of parent on child through each joint, about the child's joint frame and "
                          "along its axes; forces in %s, torques in %s.%s",
                          row[km_report_s(&p->swept)], km_sweep_unit(p->swept.mechanism, p->swept.plan),
                          model->units.force->suffix, km_text_move_to_arena(&torque, &k->arena),
                          p->sweep->degree ? " ? marks what statics alone doesn't determine." : ""));
  km_document_cells(k, KM_BLOCK_TABLE, cells, joints + 1, COLUMNS);
  km_text meshing = {0};
  km_meshing_words(model, &meshing);
  if (meshing.size)
    km_document_text(k, km_document_format(k, "Note: %s.", km_text_move_to_arena(&meshing, &k->arena)));
}

void km_statics_report_make(km_document_maker *k, const km_plotted_statics *p, const km_statics *statics,
                            const char *acting, const char *stopped_by, bool brief) {
  km_plot plot;
  add_lead(k, p);
  add_facts(k, p, acting, stopped_by);
  if (brief)
    add_peaks(k, p);
  km_report_poses(k, &p->swept);
  if (brief)
    return;
  km_document_heading(k, "What the actuators hold");
  if (p->sweep->actuator_count && km_statics_plot_make(p, 1, false, false, &k->arena, &plot))
    km_report_plot(k, &plot, "actuator forces over the sweep", 230);
  add_peaks(k, p);
  add_rows(k, p);
  add_reactions(k, p, statics);
  km_report_model(
      k, &p->swept,
      "balance by the orthonormal null space Z of the loops' Jacobian; what statics leaves open is the answer "
      "of least norm");
}
