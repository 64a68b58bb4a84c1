/* Figures of merit that reports of several models, variants or studies compare.
 *
 *   spread of a figure = (max − min) / max(|max|, |min|) over the compared things
 *
 * A figure differs if its spread is more than a unit of its fifth digit, the last one shown. */
#include "report/document/comparison/compared_figures.h"

#include "question/question.h"
#include "report/document/motion_report.h"
#include "report/record/advantage_record.h"
#include "report/record/sweep_text.h"
#include "sweep/sweep.h"

#include <math.h>
#include <string.h>

static const double shown_digits = 1e-5; /* spread below which two values can be written alike */
static const double rounding = 1e-9;     /* part of the largest value of its unit below which a figure is rounding */

void km_compared_add(km_compared_figures *out, km_compared_figure figure) {
  if (out->count < KM_MOST_COMPARED)
    out->items[out->count++] = figure;
}

/* Adds the extreme or the peak of a column. */
static void add_column(km_compared_figures *out, const km_table *t, size_t column, km_figure kind, km_better better,
                       const char *name) {
  double value = nan("");
  km_table_figure(t, km_table_name(t, column), kind, 0.0, &value, NULL, NULL);
  km_compared_add(out,
                  (km_compared_figure){name, km_table_unit(t, column), value, better, km_table_name(t, column), false});
}

/* ---- Each kind of answer. */

static void list_motion(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_motion_sweep *sweep = km_question_velocities(q);
  const km_table *t = sweep->motion.table;
  const km_sweep_plan *plan = km_question_plan(q);
  for (int i = 0; i < sweep->swing_count; ++i) {
    const km_swing *swing = &sweep->swings[i];
    size_t c = (size_t)swing->coordinate;
    const char *label = km_model_coordinate_label(q->m->model, swing->coordinate);
    if (!km_report_shows_swing(q->m, plan, swing))
      continue;
    const size_t own = km_table_span(t, "q.").first + c;
    km_compared_add(
        out,
        (km_compared_figure){
            km_document_format(k, km_coordinate_turns(q->m, swing->coordinate) ? "swing of %s" : "stroke of %s", label),
            km_table_unit(t, own), swing->high - swing->low, KM_BETTER_NEITHER, km_table_name(t, own), false});
    add_column(out, t, km_table_span(t, "v.").first + c, KM_FIGURE_PEAK, KM_BETTER_NEITHER,
               km_document_format(k, "largest velocity of %s", label));
    const size_t acceleration = km_table_span(t, "a.").first + c;
    double where;
    km_compared_add(out,
                    (km_compared_figure){km_document_format(k, "largest acceleration of %s", label),
                                         km_table_unit(t, acceleration), km_swing_acceleration(sweep, swing, &where),
                                         KM_BETTER_LESS, km_table_name(t, acceleration), false});
  }
  for (int i = 0; i < plan->point_count; ++i) {
    const char *name = plan->points[i].name;
    int path = km_table_find(t, km_document_format(k, "point.%s.path", name));
    int speed = km_table_find(t, km_document_format(k, "point.%s.speed", name));
    if (path >= 0)
      add_column(out, t, (size_t)path, KM_FIGURE_MAX, KM_BETTER_NEITHER, km_document_format(k, "path of %s", name));
    if (speed >= 0)
      add_column(out, t, (size_t)speed, KM_FIGURE_PEAK, KM_BETTER_NEITHER,
                 km_document_format(k, "largest speed of %s", name));
  }
}

/* Least transmission angle of each hinge. */
static void list_hinges(km_document_maker *k, const km_mechanism *m, const km_advantage_sweep *sweep,
                        km_compared_figures *out) {
  const km_table *t = sweep->motion.table;
  for (size_t c = 0; c < km_table_columns(t); ++c) {
    const char *hinge = km_transmission_hinge(m, sweep, c);
    if (hinge)
      add_column(out, t, c, KM_FIGURE_MIN, KM_BETTER_MORE,
                 km_document_format(k, "least transmission angle at %s", hinge));
  }
}

static void list_advantage(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_advantage_sweep *sweep = km_question_advantage(q);
  const char *unit = km_table_unit(sweep->motion.table, sweep->column),
             *column = km_table_name(sweep->motion.table, sweep->column);
  const struct {
    const char *name;
    double value;
  } figures[] = {{"least advantage", sweep->lowest.value},
                 {"greatest advantage", sweep->highest.value},
                 {"least size of the advantage", fabs(sweep->least.value)}};
  for (size_t i = 0; i < sizeof figures / sizeof *figures; ++i)
    km_compared_add(out,
                    (km_compared_figure){figures[i].name, unit, figures[i].value, KM_BETTER_NEITHER, column, false});
  km_compared_add(out, (km_compared_figure){"advantage at the end over that at the start", "", km_progression(sweep),
                                            KM_BETTER_NEITHER, NULL, false});
  km_compared_add(out,
                  (km_compared_figure){"dead points", "", (double)sweep->toggle_count, KM_BETTER_NEITHER, NULL, false});
  list_hinges(k, q->m, sweep, out);
}

/* Largest reaction force and moment of each joint. */
static void list_reactions(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_table *t = km_question_table(q);
  km_span span = km_table_span(t, "r.");
  for (size_t j = 0; j < span.count / 6; ++j) {
    double ignored = 0.0;
    const size_t force = span.first + 6 * j;
    const char *label = km_model_joint_label(q->m->model, (int)j);
    km_compared_add(out, (km_compared_figure){km_document_format(k, "largest reaction force in %s", label),
                                              km_table_unit(t, force), km_largest_norm(t, force, &ignored),
                                              KM_BETTER_LESS, NULL, true});
    km_compared_add(out, (km_compared_figure){km_document_format(k, "largest reaction moment in %s", label),
                                              km_table_unit(t, force + 3), km_largest_norm(t, force + 3, &ignored),
                                              KM_BETTER_LESS, NULL, true});
  }
}

static void list_statics(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_statics_sweep *sweep = km_question_statics(q);
  const km_table *t = sweep->motion.table;
  for (int i = 0; i < sweep->actuator_count; ++i) {
    const size_t column = km_table_span(t, "f.").first + (size_t)i;
    km_compared_add(out, (km_compared_figure){km_document_format(k, "largest force of %s", sweep->actuators[i].name),
                                              km_table_unit(t, column), fabs(sweep->largest[i].value), KM_BETTER_LESS,
                                              km_table_name(t, column), false});
  }
  list_reactions(k, q, out);
}

static void list_inverse(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_history *h = km_question_history(q);
  for (int i = 0; i < h->peak_count; ++i) {
    const km_force_peak *peak = &h->peaks[i];
    const char *unit = km_table_unit(h->table, peak->column),
               *column = peak->parts == 1 ? km_table_name(h->table, peak->column) : NULL,
               *of = peak->coordinate < 0
                         ? "shaking force"
                         : km_document_format(k, "driving force of %s",
                                              km_model_coordinate_label(q->m->model, peak->coordinate));
    km_compared_add(out, (km_compared_figure){km_document_format(k, "largest %s", of), unit, fabs(peak->value),
                                              KM_BETTER_LESS, column, false});
    km_compared_add(out, (km_compared_figure){km_document_format(k, "root mean square %s", of), unit, peak->rms,
                                              KM_BETTER_LESS, column, false});
  }
  list_reactions(k, q, out);
}

static void list_run(km_document_maker *k, const km_question *q, km_compared_figures *out) {
  const km_history *h = km_question_history(q);
  const km_table *t = h->table;
  const km_span coordinates = km_table_span(t, "q."), rates = km_table_span(t, "v.");
  static const char *const columns[] = {"energy_kinetic", "energy_dissipated", "motor_work"};
  static const char *const names[] = {"largest kinetic energy", "energy dissipated", "work of motors"};
  for (size_t i = 0; i < sizeof columns / sizeof *columns; ++i)
    add_column(out, t, (size_t)km_table_find(t, columns[i]), KM_FIGURE_MAX, KM_BETTER_NEITHER, names[i]);
  for (int c = 0; c < q->m->coordinate_count; ++c) {
    const char *label = km_model_coordinate_label(q->m->model, c);
    if (q->m->held[c])
      continue;
    add_column(out, t, coordinates.first + (size_t)c, KM_FIGURE_SPAN, KM_BETTER_NEITHER,
               km_document_format(k, "range of %s", label));
    add_column(out, t, rates.first + (size_t)c, KM_FIGURE_PEAK, KM_BETTER_NEITHER,
               km_document_format(k, "largest velocity of %s", label));
  }
  list_reactions(k, q, out);
}

void km_compared_list(km_document_maker *k, const km_answered *a, km_compared_figures *out) {
  const km_question *q = a->question;
  if (km_question_velocities(q))
    list_motion(k, q, out);
  else if (km_question_run_def(q))
    list_run(k, q, out);
  else if (km_question_history(q))
    list_inverse(k, q, out);
  else if (km_question_statics(q))
    list_statics(k, q, out);
  else if (km_question_advantage(q))
    list_advantage(k, q, out);
}

/* ---- All of them. */

static bool is_same(const km_compared_figure *a, const km_compared_figure *b) {
  return strcmp(a->name, b->name) == 0 && strcmp(a->unit, b->unit) == 0;
}

/* Row of a figure; a new one behind the others where there is none. NULL when out of memory. */
static km_compared_row *find_row(km_document_maker *k, km_compared_rows *rows, const km_compared_figure *figure,
                                 int count) {
  for (size_t i = 0; i < rows->count; ++i)
    if (is_same(rows->items[i].figure, figure))
      return &rows->items[i];
  km_compared_row *row = &rows->items[rows->count];
  *row = (km_compared_row){.figure = figure, .values = KM_ARENA_NEW(&k->arena, double, (size_t)count), .best = -1};
  for (int i = 0; i < count && row->values; ++i)
    row->values[i] = nan("");
  rows->count += row->values != NULL;
  return row->values ? row : NULL;
}

static void compare(km_compared_row *row, int count) {
  int finite = 0;
  row->low = HUGE_VAL;
  row->high = -HUGE_VAL;
  for (int i = 0; i < count; ++i)
    if (isfinite(row->values[i])) {
      ++finite;
      row->low = fmin(row->low, row->values[i]);
      row->high = fmax(row->high, row->values[i]);
    }
  const double size = finite ? fmax(fabs(row->low), fabs(row->high)) : 0.0;
  row->spread = finite == 0 ? 0.0 : finite < count ? 1.0 : size > 0.0 ? (row->high - row->low) / size : 0.0;
  const double best = row->figure->better == KM_BETTER_MORE ? row->high : row->low;
  for (int i = 0; i < count && row->figure->better != KM_BETTER_NEITHER && row->spread > shown_digits; ++i)
    if (row->best < 0 && row->values[i] == best)
      row->best = i;
}

/* Largest finite size of the figures of a unit. */
static double size_of_unit(const km_compared_rows *rows, const char *unit) {
  double size = 0.0;
  for (size_t i = 0; i < rows->count; ++i)
    if (strcmp(rows->items[i].figure->unit, unit) == 0 && rows->items[i].low <= rows->items[i].high)
      size = fmax(size, fmax(fabs(rows->items[i].low), fabs(rows->items[i].high)));
  return size;
}

/* Drops figures that are rounding beside the largest of their unit. */
static void drop_rounding(km_document_maker *k, km_compared_rows *rows) {
  size_t kept = 0;
  double *least = KM_ARENA_NEW(&k->arena, double, rows->count + 1);
  for (size_t i = 0; i < rows->count && least; ++i)
    least[i] = rounding * size_of_unit(rows, rows->items[i].figure->unit);
  for (size_t i = 0; i < rows->count && least; ++i) {
    const km_compared_row row = rows->items[i];
    if (row.low > row.high || fmax(fabs(row.low), fabs(row.high)) > least[i])
      rows->items[kept++] = row;
  }
  rows->count = least ? kept : rows->count;
}

/* True if row a precedes row b. */
static bool precedes(const km_compared_row *a, const km_compared_row *b) {
  const bool a_differs = a->spread > shown_digits, b_differs = b->spread > shown_digits;
  if (a_differs != b_differs)
    return a_differs;
  if (a->figure->secondary != b->figure->secondary)
    return b->figure->secondary;
  return a->spread > b->spread;
}

/* Sorts by insertion, stable. */
static void sort(km_compared_rows *rows) {
  for (size_t i = 1; i < rows->count; ++i) {
    const km_compared_row row = rows->items[i];
    size_t k = i;
    for (; k > 0 && precedes(&row, &rows->items[k - 1]); --k)
      rows->items[k] = rows->items[k - 1];
    rows->items[k] = row;
  }
}

/* Length of the words in front of what a figure is of: "largest force" of "largest force of A". */
static size_t kind_length(const char *name) {
  static const char *const joins[] = {" of ", " in ", " at "};
  size_t length = strlen(name);
  for (size_t i = 0; i < sizeof joins / sizeof *joins; ++i) {
    const char *found = strstr(name, joins[i]);
    if (found && (size_t)(found - name) < length)
      length = (size_t)(found - name);
  }
  return length;
}

static bool is_of_kind(const km_compared_row *a, const km_compared_row *b) {
  const size_t length = kind_length(a->figure->name);
  return length == kind_length(b->figure->name) && strncmp(a->figure->name, b->figure->name, length) == 0;
}

/* Moves the first row of each kind in front of the others, among those that differ and aren't secondary. */
static void lead_with_kinds(km_compared_rows *rows) {
  size_t leading = 0;
  for (size_t i = 0; i < rows->different && !rows->items[i].figure->secondary; ++i) {
    const km_compared_row row = rows->items[i];
    bool is_first = true;
    for (size_t k = 0; k < leading && is_first; ++k)
      is_first = !is_of_kind(&rows->items[k], &row);
    for (size_t k = i; k > leading && is_first; --k)
      rows->items[k] = rows->items[k - 1];
    if (is_first)
      rows->items[leading++] = row;
  }
}

km_compared_rows km_compared_merge(km_document_maker *k, const km_compared_figures *figures, int count) {
  size_t most = 0;
  for (int i = 0; i < count; ++i)
    most += figures[i].count;
  km_compared_rows rows = {.items = KM_ARENA_NEW(&k->arena, km_compared_row, most + 1)};
  if (!rows.items)
    return rows;
  for (int i = 0; i < count; ++i)
    for (size_t f = 0; f < figures[i].count; ++f) {
      km_compared_row *row = find_row(k, &rows, &figures[i].items[f], count);
      if (row)
        row->values[i] = figures[i].items[f].value;
    }
  for (size_t i = 0; i < rows.count; ++i)
    compare(&rows.items[i], count);
  drop_rounding(k, &rows);
  sort(&rows);
  while (rows.different < rows.count && rows.items[rows.different].spread > shown_digits)
    ++rows.different;
  lead_with_kinds(&rows);
  return rows;
}
