/* The report about leverage: its facts, curve, transmission metrics and rows as blocks of a document. */
#include "report/document/advantage_report.h"

#include "report/document/sweep_report.h"
#include "report/record/advantage_record.h"
#include "report/record/sweep_text.h"
#include "report/record/transmission_record.h"
#include "topology/mechanism.h"
#include "transfer/transmission_metrics.h"

#include <math.h>
#include <string.h>

static const char *peak_words(km_document_maker *k, const km_plotted_advantage *p, const km_peak *peak) {
  if (isnan(peak->s))
    return "none: nowhere finite";
  const char *unit = km_advantage_unit(p->swept.mechanism->model, &p->sweep->input, &p->sweep->output);
  return km_document_format(k, "%s%s%s at %.6g%s", km_report_number(k, peak->value), unit[0] ? " " : "", unit, peak->s,
                            km_sweep_unit(p->swept.mechanism, p->swept.plan));
}

static const char *toggle_words(km_document_maker *k, const km_plotted_advantage *p) {
  km_text text = {0};
  enum { MOST = 12 };
  for (size_t i = 0; i < p->sweep->toggle_count && i < MOST; ++i)
    km_text_format(&text, "%s%s at %.9g%s", i ? "; " : "", km_advantage_toggle_name(&p->sweep->toggles[i]),
                   p->sweep->toggles[i].s, km_sweep_unit(p->swept.mechanism, p->swept.plan));
  if (p->sweep->toggle_count > MOST)
    km_text_format(&text, "; and %zu more", p->sweep->toggle_count - MOST);
  return km_document_words(k, &text, "none in the range");
}

/* "at 82 deg, 269.7 deg", of infinite toggles. */
static const char *pole_words(km_document_maker *k, const km_plotted_advantage *p, int *count) {
  enum { MOST = 6 };
  km_text text = {0};
  *count = 0;
  for (size_t i = 0; i < p->sweep->toggle_count; ++i)
    if (p->sweep->toggles[i].state == KM_ADVANTAGE_INFINITE && ++*count <= MOST)
      km_text_format(&text, "%s%.6g%s", *count > 1 ? ", " : "", p->sweep->toggles[i].s,
                     km_sweep_unit(p->swept.mechanism, p->swept.plan));
  if (*count > MOST)
    km_text_format(&text, " and %d more", *count - MOST);
  return km_document_words(k, &text, "");
}

/* "2.86 at the start, 1.71 at the end (end/start 0.597: falls by 40.3 %)". */
static const char *ends_words(km_document_maker *k, const km_plotted_advantage *p) {
  const km_table *table = p->swept.motion->table;
  const double *first = km_table_row(table, 0), *last = km_table_row(table, km_table_rows(table) - 1);
  km_text progression = {0};
  km_progression_words(p->sweep, &progression);
  return km_document_format(k, "%s at the start, %s at the end%s", km_report_number(k, first[p->sweep->column]),
                            km_report_number(k, last[p->sweep->column]), km_document_words(k, &progression, ""));
}

/* Facts on the first page. */
static void add_lead(km_document_maker *k, const km_plotted_advantage *p) {
  const km_advantage_sweep *sweep = p->sweep;
  const char *stroke = km_report_stroke(k, &p->swept), *in = sweep->input.name, *out = sweep->output.name;
  int count;
  const char *poles = pole_words(k, p, &count);
  km_peak size = {fabs(sweep->least.value), sweep->least.s};
  if (isnan(sweep->lowest.s))
    km_document_lead(
        k, km_document_format(k, "The mechanical advantage of %s over %s is nowhere finite %s.", in, out, stroke));
  else if (count)
    km_document_lead(k, km_document_format(k,
                                           "The mechanical advantage of %s over %s has a size of at least %s and grows "
                                           "without bound at the dead point%s at %s, %s.",
                                           in, out, peak_words(k, p, &size), count > 1 ? "s" : "", poles, stroke));
  else
    km_document_lead(k,
                     km_document_format(
                         k, "The mechanical advantage of %s over %s is %s, and lies between %s and %s, %s. %s", in, out,
                         ends_words(k, p), peak_words(k, p, &sweep->lowest), peak_words(k, p, &sweep->highest), stroke,
                         sweep->toggle_count ? "Its dead points are listed below." : "It has no dead point there."));
}

/* "at least 37.6 deg, at 90 deg": the least of the transmission angle and its supplement; NULL: no row has one. */
static const char *least_angle_words(km_document_maker *k, const km_plotted_advantage *p) {
  const km_table *table = p->swept.motion->table;
  const int column = km_table_find(table, km_transmission_name(0));
  const double half_turn = M_PI / p->swept.mechanism->model->units.angle->si;
  km_peak least = {HUGE_VAL, 0.0};
  for (size_t r = 0; r < km_table_rows(table) && column >= 0; ++r) {
    const double *row = km_table_row(table, r), angle = fmin(row[column], half_turn - row[column]);
    if (angle < least.value)
      least = (km_peak){angle, row[1]};
  }
  return isfinite(least.value)
             ? km_document_format(k, "at least %.3g %s, at %.6g%s", least.value, km_table_unit(table, (size_t)column),
                                  least.s, km_sweep_unit(p->swept.mechanism, p->swept.plan))
             : NULL;
}

static void add_facts(km_document_maker *k, const km_plotted_advantage *p, const char *stopped_by) {
  km_report_facts facts = {.rows = 0};
  const char *angle = least_angle_words(k, p);
  if (angle)
    km_report_fact(&facts, "Transmission angle", angle);
  km_report_fact(&facts, "Start, end", ends_words(k, p));
  km_report_fact(&facts, "Minimum", peak_words(k, p, &p->sweep->lowest));
  km_report_fact(&facts, "Maximum", peak_words(k, p, &p->sweep->highest));
  km_report_fact(&facts, "Least size", peak_words(k, p, &p->sweep->least));
  km_report_fact(&facts, "Dead points", toggle_words(k, p));
  km_report_motion(k, &p->swept, stopped_by, &facts);
  km_report_close_facts(k, &facts);
}

/* True if the metric is defined in some row. */
static bool defined(const km_table *table, int column) {
  for (size_t r = 0; r < km_table_rows(table) && column >= 0; ++r)
    if (isfinite(km_table_row(table, r)[column]))
      return true;
  return false;
}

static bool agree(const km_table *table, size_t a, size_t b) {
  for (size_t r = 0; r < km_table_rows(table); ++r)
    if (!(fabs(km_table_row(table, r)[a] - km_table_row(table, r)[b]) < 1e-9))
      return false;
  return true;
}

static void add_metric_plot(km_document_maker *k, const km_plotted_advantage *p, const int *metrics, int count,
                            const char *title, const char *y_label, double height) {
  const km_table *table = p->swept.motion->table;
  km_swept_line *lines = KM_ARENA_NEW(&k->arena, km_swept_line, (size_t)count);
  km_named_metric names[KM_TRANSMISSION_METRICS];
  km_transmission empty = {.no_wrench = NULL};
  size_t used = 0;
  km_plot plot;
  if (!lines)
    return;
  km_transmission_list(p->swept.mechanism, &empty, &p->sweep->output, names);
  for (int i = 0; i < count; ++i) {
    int column = km_table_find(table, names[metrics[i]].name);
    if (used > 0 && column >= 0 && agree(table, lines[0].column, (size_t)column))
      lines[0].name = km_document_format(k, "%s, %s", lines[0].name, names[metrics[i]].words);
    else if (defined(table, column))
      lines[used++] = (km_swept_line){0, (size_t)column, names[metrics[i]].words, 0};
  }
  km_sweep_picture picture = {.title = title,
                              .y_label = y_label,
                              .sweeps = &p->swept,
                              .sweep_count = 1,
                              .lines = lines,
                              .line_count = used,
                              .panel_count = 1};
  if (used == 0 || !km_sweep_plot_make(&picture, &k->arena, &plot))
    return;
  if (metrics[0] == 2) { /* indices lie between 0 and 1 */
    plot.y_low = 0.0;
    plot.y_high = 1.0;
  }
  km_report_plot(k, &plot, title, height);
}

static void add_transmission(km_document_maker *k, const km_plotted_advantage *p, const km_transmission *t) {
  static const int indices[2] = {2, 3}, angle[1] = {0}, condition[1] = {5};
  const km_table *table = p->swept.motion->table;
  km_named_metric list[KM_TRANSMISSION_METRICS];
  const char *last = NULL;
  bool any = false;
  km_text missing = {0};
  km_transmission_list(p->swept.mechanism, t, &p->sweep->output, list);
  for (int i = 0; i < KM_TRANSMISSION_METRICS; ++i) {
    if (defined(table, km_table_find(table, list[i].name))) {
      any = true;
      continue;
    }
    const char *why = list[i].metric->why ? list[i].metric->why : "no row has a value";
    if (last && strcmp(last, why) == 0)
      km_text_format(&missing, ", %s", list[i].words);
    else
      km_text_format(&missing, "%s%s — %s", missing.size ? ". " : "Undefined here: ", why, list[i].words);
    last = why;
  }
  if (missing.size)
    km_text_add(&missing, ".");
  const char *words = km_document_words(k, &missing, NULL);
  if (any)
    km_document_heading(k, "Transmission");
  if (any && words)
    km_document_text(k, words);
  add_metric_plot(k, p, indices, 2, "Transmission indices", "index", 150);
  add_metric_plot(k, p, angle, 1, "Transmission angle",
                  km_document_format(k, "angle (%s)", p->swept.mechanism->model->units.angle->suffix), 150);
  add_metric_plot(k, p, condition, 1, "Condition of the Jacobian", "condition number", 150);
}

static void add_table(km_document_maker *k, const km_plotted_advantage *p) {
  const km_model *model = p->swept.mechanism->model;
  const km_table *table = p->swept.motion->table;
  const char *unit = km_advantage_unit(model, &p->sweep->input, &p->sweep->output);
  km_report_column columns[12] = {
      {km_report_s(&p->swept),
       p->swept.plan->arclength > 0.0
           ? "arc length"
           : km_document_format(k, "%s (%s)", km_model_coordinate_label(model, p->swept.plan->coordinate),
                                km_model_coordinate_unit(model, p->swept.plan->coordinate))},
      {km_advantage_column(p->sweep, false), unit[0] ? km_document_format(k, "MA (%s)", unit) : "MA"}};
  size_t count = 2;
  if (p->sweep->friction)
    columns[count++] = (km_report_column){km_advantage_column(p->sweep, true), "with friction"};
  static const char *const heads[KM_TRANSMISSION_METRICS] = {"transm. angle", "virtual coeff.", "Sutherland-Roth",
                                                             "Chen-Angeles",  "manipulability", "condition"};
  km_named_metric list[KM_TRANSMISSION_METRICS];
  km_transmission empty = {.no_wrench = NULL};
  km_transmission_list(p->swept.mechanism, &empty, &p->sweep->output, list);
  for (int i = 0; i < KM_TRANSMISSION_METRICS; ++i) {
    int column = km_table_find(table, list[i].name);
    if (defined(table, column))
      columns[count++] = (km_report_column){
          (size_t)column, list[i].unit[0] ? km_document_format(k, "%s (%s)", heads[i], list[i].unit) : heads[i]};
  }
  km_document_heading(k, "At chosen poses");
  size_t places = p->sweep->toggle_count + 2;
  double *special = KM_ARENA_NEW(&k->arena, double, places);
  for (size_t i = 0; i < p->sweep->toggle_count && special; ++i)
    special[2 + i] = p->sweep->toggles[i].s;
  if (!special)
    return;
  special[0] = p->sweep->lowest.s;
  special[1] = p->sweep->highest.s;
  km_report_rows(k, &p->swept, columns, count, special, places);
}

void km_advantage_report_make(km_document_maker *k, const km_plotted_advantage *p, const km_transmission *transmission,
                              const char *stopped_by, bool brief) {
  km_plot plot;
  add_lead(k, p);
  add_facts(k, p, stopped_by);
  km_report_poses(k, &p->swept);
  if (brief)
    return;
  km_document_heading(k, "Leverage");
  if (km_advantage_plot_make(p, 1, false, false, &k->arena, &plot))
    km_report_plot(k, &plot, "mechanical advantage over the sweep", 230);
  km_document_text(k, "Mechanical advantage is the input's rate over the output's, signed, angles in radians. Without "
                      "losses an input force f balances an output force −MA · f.");
  /* Three plots of transmission metrics fill a page; one shares the page with the table. */
  bool many = defined(p->swept.motion->table, km_table_find(p->swept.motion->table, "sutherland_roth"));
  if (many)
    add_table(k, p);
  add_transmission(k, p, transmission);
  if (!many)
    add_table(k, p);
  km_report_model(k, &p->swept,
                  p->sweep->method == KM_ADVANTAGE_SINGLE_FREEDOM
                      ? "one freedom: the ratio of the rates in the only motion there is, Z_i / Z_k"
                      : "several freedoms: the least motion that moves the input, by the orthonormal null space Z; the "
                        "other joints follow, none is locked");
}
