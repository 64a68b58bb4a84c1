/* Finds the plot of each kind of question. */
#include "report/charts/question_plot.h"

#include "base/table.h"
#include "question/question.h"
#include "report/charts/advantage_plot.h"
#include "report/charts/history_plot.h"
#include "report/charts/mobility_plot.h"
#include "report/charts/statics_plot.h"
#include "report/charts/table_plot.h"

#include <string.h>

enum { MOST_CURVES = 4 }; /* coordinates of several motions over time, where none are chosen */

static km_swept swept(const km_answered *a) {
  return (km_swept){a->question->m, km_question_plan(a->question), km_question_motion(a->question), a->name};
}

static bool plot_mobility(const km_comparison *c, km_arena *arena, km_plot *out) {
  km_plotted_sweep *sweeps = KM_ARENA_NEW(arena, km_plotted_sweep, (size_t)c->count);
  for (int i = 0; i < c->count && sweeps; ++i)
    sweeps[i] = (km_plotted_sweep){c->answers[i].question->m,
                                   km_question_plan(c->answers[i].question),
                                   km_question_mobility(c->answers[i].question),
                                   c->answers[i].name,
                                   c->answers[i].shown,
                                   c->answers[i].shown_count};
  return sweeps && km_mobility_plot_make(sweeps, c->count, c->ordered, arena, out);
}

static bool plot_advantage(const km_comparison *c, km_arena *arena, km_plot *out) {
  km_plotted_advantage *sweeps = KM_ARENA_NEW(arena, km_plotted_advantage, (size_t)c->count);
  for (int i = 0; i < c->count && sweeps; ++i)
    sweeps[i] = (km_plotted_advantage){swept(&c->answers[i]), km_question_advantage(c->answers[i].question)};
  return sweeps && km_advantage_plot_make(sweeps, c->count, c->ordered, true, arena, out);
}

static bool plot_statics(const km_comparison *c, km_arena *arena, km_plot *out) {
  km_plotted_statics *sweeps = KM_ARENA_NEW(arena, km_plotted_statics, (size_t)c->count);
  for (int i = 0; i < c->count && sweeps; ++i)
    sweeps[i] = (km_plotted_statics){swept(&c->answers[i]), km_question_statics(c->answers[i].question),
                                     c->answers[i].shown, c->answers[i].shown_count};
  return sweeps && km_statics_plot_make(sweeps, c->count, c->ordered, true, arena, out);
}

/* The tables of the answers with the columns of the first one, found by their names: other models may have others, or
 * lack some (their index is then past the last column). `x`: variable of the rows; NULL: the table's own. NULL when out
 * of memory. */
static km_plotted_table *tables_of(const km_comparison *c, const size_t *columns, size_t count, const char *x,
                                   km_arena *arena) {
  const km_table *first = km_question_table(c->answers[0].question);
  km_plotted_table *tables = KM_ARENA_NEW(arena, km_plotted_table, (size_t)c->count);
  size_t *found = KM_ARENA_NEW(arena, size_t, (size_t)c->count * count);
  for (int i = 0; i < c->count && !arena->failed; ++i, found += count) {
    const km_table *table = km_question_table(c->answers[i].question);
    for (size_t k = 0; k < count; ++k)
      found[k] = (size_t)km_table_find(table, km_table_name(first, columns[k]));
    int variable = x ? km_table_find(table, x) : km_table_variable(table);
    tables[i] = (km_plotted_table){table, c->answers[i].name, (size_t)variable, found};
  }
  return arena->failed ? NULL : tables;
}

/* Columns of the given names, as far as the first table has them. `x`: as tables_of. */
static bool plot_columns(const km_comparison *c, const char *const *names, const char *x, km_arena *arena,
                         km_plot *out) {
  enum { MOST_COLUMNS = 8 };
  size_t columns[MOST_COLUMNS], count = 0;
  for (int k = 0; names[k] && count < MOST_COLUMNS; ++k) {
    int column = km_table_find(km_question_table(c->answers[0].question), names[k]);
    if (column >= 0)
      columns[count++] = (size_t)column;
  }
  const km_plotted_table *tables = tables_of(c, columns, count, x, arena);
  return tables && km_table_plot_make(tables, (size_t)c->count, count, NULL, arena, out);
}

/* Margins of an arm along its path. */
static bool plot_tracks(const km_comparison *c, km_arena *arena, km_plot *out) {
  static const char *const names[] = {"limit_margin", "objective.path-control", "objective.singular-value", NULL};
  return plot_columns(c, names, "s", arena, out);
}

/* Label of the horizontal axis: the driver, or the arc length. False without memory. */
static bool label_driver(const km_question *q, km_arena *arena, km_plot *out) {
  const km_sweep_plan *plan = km_question_plan(q);
  km_text x = {0};
  if (plan->arclength > 0.0)
    km_text_add(&x, "arc length");
  else
    km_text_format(&x, "%s (%s)", km_model_coordinate_label(q->m->model, plan->coordinate),
                   km_model_coordinate_unit(q->m->model, plan->coordinate));
  out->x_label = km_text_move_to_arena(&x, arena);
  return !arena->failed;
}

/* Play that errors need, over the driver or the arc length. */
static bool plot_allowance(const km_comparison *c, km_arena *arena, km_plot *out) {
  static const char *const names[] = {"play.worst", "play.statistical", NULL};
  const km_question *first = c->answers[0].question;
  if (!plot_columns(c, names, "s", arena, out))
    return false;
  out->title = "Play that errors of the parts need, over the play of the joints";
  return label_driver(first, arena, out);
}

/* The pairs that come nearest to each other, over the driver or the arc length; pairs with equal least values once. */
static bool plot_clearances(const km_comparison *c, km_arena *arena, km_plot *out) {
  enum { MOST_PAIRS = 6 };
  const km_question *first = c->answers[0].question;
  const km_table *t = km_question_table(first);
  static const char prefix[] = "clearance.";
  const km_span pairs = km_table_span(t, prefix);
  size_t columns[MOST_PAIRS], count = 0;
  double least = -HUGE_VAL;
  for (size_t taken = 0; count < MOST_PAIRS && taken < pairs.count; ++count) {
    double next = HUGE_VAL;
    for (size_t k = 0; k < pairs.count; ++k) {
      const double value = km_table_row(t, km_table_extreme_row(t, pairs.first + k, 1.0))[pairs.first + k];
      if (value > least && value < next) {
        next = value;
        columns[count] = pairs.first + k;
      }
    }
    if (next == HUGE_VAL)
      break;
    least = next;
  }
  const char *names[MOST_PAIRS];
  for (size_t k = 0; k < count; ++k)
    names[k] = km_table_name(t, columns[k]) + strlen(prefix);
  km_text y_label = {0};
  km_text_format(&y_label, "clearance (%s)", km_table_unit(t, pairs.first));
  const km_chart_words words = {
      .title = "Clearance of bodies", .y_label = km_text_move_to_arena(&y_label, arena), .names = names};
  const km_plotted_table *tables = arena->failed ? NULL : tables_of(c, columns, count, "s", arena);
  if (!tables || !km_table_plot_make(tables, (size_t)c->count, count, &words, arena, out))
    return false;
  return label_driver(first, arena, out);
}

/* One motion over time, with the plot of a history. */
static bool plot_history(const km_answered *a, km_arena *arena, km_plot *out) {
  const km_plotted_history shown = km_question_plotted_history(a);
  return km_question_run_def(a->question) ? km_history_plot_make(&shown, arena, out)
                                          : km_inverse_plot_make(&shown, arena, out);
}

/* Several motions over time, one over another: chosen coordinates, else the first ones of runs and the driving forces
 * of inverse motions. */
static bool plot_histories(const km_comparison *c, km_arena *arena, km_plot *out) {
  const km_answered *first = &c->answers[0];
  bool chosen = first->shown != NULL, run = km_question_run_def(first->question) != NULL;
  km_span q = km_table_span(km_question_table(first->question), chosen || run ? "q." : "f.");
  size_t count = chosen ? (size_t)first->shown_count : q.count < MOST_CURVES ? q.count : MOST_CURVES;
  size_t *columns = KM_ARENA_NEW(arena, size_t, count + 1);
  if (arena->failed)
    return false;
  for (size_t k = 0; k < count; ++k)
    columns[k] = q.first + (chosen ? (size_t)first->shown[k] : k);
  const km_plotted_table *tables = tables_of(c, columns, count, NULL, arena);
  return tables && km_table_plot_make(tables, (size_t)c->count, count, NULL, arena, out);
}

/* Coordinates to draw: chosen ones, else the first that move besides the driver; at most MOST_CURVES. */
static size_t moving_coordinates(const km_answered *a, int *out) {
  const km_motion_sweep *sweep = km_question_velocities(a->question);
  const km_mechanism *m = a->question->m;
  size_t count = 0;
  for (int i = 0; a->shown && i < a->shown_count && count < MOST_CURVES; ++i)
    out[count++] = a->shown[i];
  for (int i = 0; !a->shown && i < sweep->swing_count && count < MOST_CURVES; ++i) {
    const km_swing *swing = &sweep->swings[i];
    int c = swing->coordinate;
    if (c != km_question_plan(a->question)->coordinate && m->ball_of[c] < 0 &&
        (swing->high - swing->low) * m->factor[c] * m->scale[c] > 1e-9)
      out[count++] = c;
  }
  return count;
}

/* Velocities and accelerations over the driver, and the speeds of traced points. */
static bool plot_motions(const km_comparison *c, km_arena *arena, km_plot *out) {
  const km_answered *first = &c->answers[0];
  const km_table *t = km_question_table(first->question);
  const km_sweep_plan *plan = km_question_plan(first->question);
  const size_t velocities = km_table_span(t, "v.").first, accelerations = km_table_span(t, "a.").first;
  int moving[MOST_CURVES];
  size_t joints = moving_coordinates(first, moving), count = 0;
  size_t *columns = KM_ARENA_NEW(arena, size_t, 2 * joints + (size_t)plan->point_count + 1);
  if (arena->failed)
    return false;
  for (size_t k = 0; k < joints; ++k)
    columns[count++] = velocities + (size_t)moving[k];
  for (size_t k = 0; k < joints; ++k)
    columns[count++] = accelerations + (size_t)moving[k];
  for (int i = 0; i < plan->point_count; ++i) {
    km_text name = {0};
    km_text_format(&name, "point.%s.speed", plan->points[i].name);
    columns[count++] = (size_t)km_table_find(t, name.data ? name.data : "t");
    km_text_free(&name);
  }
  if (count == 0)
    columns[count++] = velocities + (size_t)plan->coordinate;
  const km_plotted_table *tables = tables_of(c, columns, count, NULL, arena);
  if (!tables || !km_table_plot_make(tables, (size_t)c->count, count, NULL, arena, out))
    return false;
  out->title = "Velocities and accelerations";
  return label_driver(first->question, arena, out);
}

km_plotted_history km_question_plotted_history(const km_answered *a) {
  const km_question *q = a ? a->question : NULL;
  const km_history *h = km_question_history(q);
  const km_history_def *run = km_question_run_def(q);
  if (!h)
    return (km_plotted_history){0};
  return (km_plotted_history){.mechanism = q->m,
                              .table = h->table,
                              .crossings = run ? run->simulation.crossings : NULL,
                              .met = h->crossings,
                              .met_count = h->crossing_count,
                              .name = a->name,
                              .joints = a->shown,
                              .joint_count = a->shown_count};
}

km_status km_question_plot_make(const km_comparison *c, km_arena *arena, km_plot *out, km_error *error) {
  const km_question *first = c->answers[0].question;
  bool made;
  if (km_question_mobility(first))
    made = plot_mobility(c, arena, out);
  else if (km_question_advantage(first))
    made = plot_advantage(c, arena, out);
  else if (km_question_statics(first))
    made = plot_statics(c, arena, out);
  else if (km_question_velocities(first))
    made = plot_motions(c, arena, out);
  else if (km_question_allowance(first))
    made = plot_allowance(c, arena, out);
  else if (km_question_clearances(first))
    made = plot_clearances(c, arena, out);
  else if (km_question_history(first))
    made = c->count == 1 ? plot_history(&c->answers[0], arena, out) : plot_histories(c, arena, out);
  else
    made = plot_tracks(c, arena, out);
  return made ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a plot");
}
