/* Blocks shared by reports of sweeps: facts, configurations, plots, rows. */
#include "report/document/sweep_report.h"
#include "report/drawing/drawing_poses.h"

#include "kmech/version.h"
#include "report/charts/sweep_strip.h"
#include "report/drawing/drawing.h"
#include "report/plot/plot_over.h"
#include "report/record/sweep_text.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { POSES = 5, MOST_ROWS = 12 };

void km_report_fact(km_report_facts *facts, const char *name, const char *what) {
  if (facts->rows == 32)
    return;
  facts->cells[2 * facts->rows] = name;
  facts->cells[2 * facts->rows + 1] = what;
  facts->rows++;
}

void km_report_close_facts(km_document_maker *maker, const km_report_facts *facts) {
  const char **cells = KM_ARENA_NEW(&maker->arena, const char *, 2 * facts->rows);
  for (size_t i = 0; i < 2 * facts->rows && cells; ++i)
    cells[i] = facts->cells[i];
  if (cells)
    km_document_cells(maker, KM_BLOCK_FACTS, cells, facts->rows, 2);
}

const char *km_report_number(km_document_maker *maker, double value) {
  if (isnan(value))
    return "–";
  if (isinf(value))
    return value > 0.0 ? "∞" : "−∞";
  const char *text = km_document_format(maker, "%.6g", value == 0.0 ? 0.0 : value);
  return text[0] == '-' ? km_document_format(maker, "−%s", text + 1) : text;
}

const char *km_report_unit(km_document_maker *maker, const char *unit) {
  const char *power = strstr(unit, "^2");
  return power ? km_document_format(maker, "%.*s²%s", (int)(power - unit), unit, power + 2) : unit;
}

size_t km_report_s(const km_swept *s) {
  return (size_t)km_table_find(s->motion->table, "s");
}

static const char *swept_words(km_document_maker *maker, const km_swept *s) {
  const km_table *table = s->motion->table;
  const km_model *model = s->mechanism->model;
  size_t rows = km_table_rows(table);
  size_t column = km_report_s(s);
  double from = km_table_row(table, 0)[column], to = km_table_row(table, rows - 1)[column];
  if (s->plan->arclength > 0.0)
    return km_document_format(maker, "arc length %.6g to %.6g, %zu rows", from, to, rows);
  return km_document_format(maker, "%s from %.6g to %.6g %s, %zu rows",
                            km_model_coordinate_label(model, s->plan->coordinate), from, to,
                            km_model_coordinate_unit(model, s->plan->coordinate), rows);
}

static const char *held_words(km_document_maker *maker, const km_mechanism *m) {
  km_text text = {0};
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->held[c])
      km_text_format(&text, "%s%s", text.size ? ", " : "", m->model->coordinates[c].label);
  return km_document_words(maker, &text, NULL);
}

const char *km_report_stroke(km_document_maker *maker, const km_swept *s) {
  const km_table *table = s->motion->table;
  const km_model *model = s->mechanism->model;
  double from = km_table_row(table, 0)[km_report_s(s)],
         to = km_table_row(table, km_table_rows(table) - 1)[km_report_s(s)];
  if (s->plan->arclength > 0.0)
    return km_document_format(maker, "along an arc of length %.6g", to - from);
  return km_document_format(maker, "over the stroke of %s from %.6g to %.6g %s",
                            km_model_coordinate_label(model, s->plan->coordinate), from, to,
                            km_model_coordinate_unit(model, s->plan->coordinate));
}

void km_report_digits(const km_mechanism *m, km_report_facts *facts) {
  const char *words = m->model->digits;
  if (words && m->topology.loop_count > 0)
    km_report_fact(facts, "Dimensions", words[0] ? words : "as written: they close the loops within their digits");
}

void km_report_motion(km_document_maker *maker, const km_swept *s, const char *stopped_by, km_report_facts *facts) {
  km_report_fact(facts, "Swept", swept_words(maker, s));
  if (stopped_by[0])
    km_report_fact(facts, "Ended early", stopped_by);
  km_text mobility = {0};
  km_mobility_words(s->mechanism, s->motion, &mobility);
  km_report_fact(facts, "Mobility", km_document_words(maker, &mobility, ""));
  km_report_digits(s->mechanism, facts);
  const char *held = held_words(maker, s->mechanism);
  if (held)
    km_report_fact(facts, "Held", held);
}

void km_report_model(km_document_maker *maker, const km_swept *s, const char *method) {
  const km_model *model = s->mechanism->model;
  const km_units *u = &model->units;
  km_report_facts facts = {.rows = 0};
  km_document_heading(maker, "The model and the method");
  if (model->source)
    km_report_fact(&facts, "Source",
                   km_document_format(maker, "%.420s%s", model->source, strlen(model->source) > 420 ? " …" : ""));
  km_report_fact(&facts, "Method", method);
  km_report_fact(&facts, "Units",
                 km_document_format(maker, "%s, %s, %s, %s, %s", u->angle->word, u->length->word, u->mass->word,
                                    u->time->word, u->force->word));
  km_report_fact(&facts, "Characteristic length",
                 km_document_format(maker, "%g %s (%s)", s->mechanism->length, u->length->suffix,
                                    km_length_source_name(s->mechanism->length_source)));
  km_report_fact(&facts, "SHA-256 of its file", model->sha256);
  km_report_close_facts(maker, &facts);
}

static size_t row_of(const km_table *table, size_t index, size_t count) {
  size_t rows = km_table_rows(table);
  return count < 2 ? 0 : index * (rows - 1) / (count - 1);
}

static km_status draw_large(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  return km_drawing_place(context, canvas, (km_rectangle){0, 0, width, height}, error);
}

static km_status draw_strip(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  const km_plot_strip *strip = context;
  (void)height;
  (void)error;
  strip->draw(strip->context, canvas, 0, width);
  return KM_OK;
}

/* Poses of rows of the table, for one drawing. */
static km_drawing_def *make_drawing(km_document_maker *maker, const km_mechanism *m, const km_table *table,
                                    const char *name) {
  size_t bodies = (size_t)m->topology.body_count, rows = km_table_rows(table);
  size_t count = rows < POSES ? rows : POSES;
  km_drawing_def *drawing = KM_ARENA_NEW(&maker->arena, km_drawing_def, 1);
  km_pose *poses = KM_ARENA_NEW(&maker->arena, km_pose, count * bodies);
  double *q = KM_ARENA_NEW(&maker->arena, double, (size_t)m->coordinate_count);
  km_state *state;
  maker->arena.failed = maker->arena.failed || km_state_create(m, &state, NULL);
  if (maker->arena.failed)
    return NULL;
  for (size_t k = 0; k < count; ++k) {
    km_row_pose(m, table, row_of(table, k, count), state, q, poses + k * bodies);
  }
  km_state_free(state);
  *drawing = (km_drawing_def){
      .mechanism = m, .poses = poses, .pose_count = count, .full = count / 2, .name = name, .loads = true};
  return drawing;
}

void km_report_drawing(km_document_maker *maker, km_drawing_def *drawing, const char *shows, double height) {
  km_document_picture(maker, shows, height, draw_large, drawing);
}

/* One large drawing, and a strip of small ones. */
static void add_pictures(km_document_maker *maker, km_drawing_def *drawing, const km_plot_strip *strip,
                         const char *over) {
  km_plot_strip *kept = KM_ARENA_NEW(&maker->arena, km_plot_strip, 1);
  if (!drawing || !kept)
    return;
  *kept = *strip;
  km_document_heading(maker, "The mechanism");
  km_document_picture(
      maker,
      km_document_format(maker, "the mechanism in the middle of the %s, with the names of its joints; other poses pale",
                         over),
      250, draw_large, drawing);
  if (kept->height > 0.0)
    km_document_picture(maker, km_document_format(maker, "five poses over the %s", over), kept->height, draw_strip,
                        kept);
}

void km_report_poses(km_document_maker *maker, const km_swept *s) {
  km_sweep_strip *strip = KM_ARENA_NEW(&maker->arena, km_sweep_strip, 1);
  if (s->mechanism->topology.body_count < 2 || !strip)
    return;
  km_drawing_def *drawing = make_drawing(maker, s->mechanism, s->motion->table, s->name);
  const km_plot_strip drawn = km_sweep_strip_make(s, POSES, &maker->arena, strip);
  add_pictures(maker, drawing, &drawn, "sweep");
}

void km_report_run_poses(km_document_maker *maker, const km_mechanism *m, const km_table *table, const char *name) {
  km_sweep_strip *strip = KM_ARENA_NEW(&maker->arena, km_sweep_strip, 1);
  if (m->topology.body_count < 2 || !strip)
    return;
  km_drawing_def *drawing = make_drawing(maker, m, table, name);
  const km_plot_strip drawn = km_motion_strip_make(m, table, POSES, &maker->arena, strip);
  add_pictures(maker, drawing, &drawn, "motion");
}

static km_status draw_plot(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  return km_plot_place(context, canvas, width, height, error);
}

km_status km_report_find_over(const km_table *table, const char *over, size_t *column, km_error *error) {
  static const char *const prefixes[] = {"", "q.", "point.", "frame."};
  char name[512];
  for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; ++i) {
    snprintf(name, sizeof name, "%s%s", prefixes[i], over);
    const int found = km_table_find(table, name);
    if (found < 0)
      continue;
    *column = (size_t)found;
    return KM_OK;
  }
  return km_fail(error, KM_USAGE,
                 "found no column \"%.200s\" to draw over; expected a joint, BODY/FRAME.x, .y or .z of "
                 "a point whose path is followed, or another column of the table",
                 over);
}

const char *km_report_over_label(km_document_maker *maker, const km_table *table, size_t column) {
  static const char *const prefixes[] = {"q.", "point.", "frame."};
  const char *name = km_table_name(table, column), *unit = km_report_unit(maker, km_table_unit(table, column));
  for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; ++i)
    if (strncmp(name, prefixes[i], strlen(prefixes[i])) == 0)
      return km_document_format(maker, unit[0] ? "%s (%s)" : "%s", name + strlen(prefixes[i]), unit);
  return km_document_format(maker, unit[0] ? "%s (%s)" : "%s", name, unit);
}

km_status km_report_set_over(km_document_maker *maker, const km_table *table, const char *over, km_error *error) {
  const size_t rows = km_table_rows(table);
  size_t column = 0;
  const km_status status = over ? km_report_find_over(table, over, &column, error) : KM_OK;
  if (status || !over)
    return status;
  km_plot_over *axis = KM_ARENA_NEW(&maker->arena, km_plot_over, 1);
  double *values = KM_ARENA_NEW(&maker->arena, double, 2 * rows);
  if (!axis || !values)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  km_table_column(table, (size_t)km_table_variable(table), values, NULL);
  km_table_column(table, column, values + rows, NULL);
  *axis = (km_plot_over){values, values + rows, rows, km_report_over_label(maker, table, column), column};
  maker->over = axis;
  return KM_OK;
}

void km_report_plot(km_document_maker *maker, const km_plot *plot, const char *shows, double height) {
  km_plot *kept = KM_ARENA_NEW(&maker->arena, km_plot, 1);
  if (!kept)
    return;
  *kept = *plot;
  if (!maker->over || km_plot_set_over(kept, maker->over, &maker->arena))
    km_document_picture(maker, shows, height, draw_plot, kept);
}

/* The row nearest to a place. */
static size_t nearest_row(const km_table *table, size_t column, double s) {
  size_t best = 0;
  for (size_t r = 1; r < km_table_rows(table); ++r)
    if (fabs(km_table_row(table, r)[column] - s) < fabs(km_table_row(table, best)[column] - s))
      best = r;
  return best;
}

/* Marks a row; how many are marked now. */
static size_t mark(bool *marked, size_t row, size_t count) {
  count += !marked[row];
  marked[row] = true;
  return count;
}

/* The columns with the quantity across the curves behind the first one. */
static const km_report_column *with_over(km_document_maker *maker, const km_report_column *columns, size_t *count) {
  km_report_column *all = KM_ARENA_NEW(&maker->arena, km_report_column, *count + 1);
  if (!maker->over || !all)
    return columns;
  all[0] = columns[0];
  all[1] = (km_report_column){maker->over->column, maker->over->label};
  for (size_t c = 1; c < *count; ++c)
    all[c + 1] = columns[c];
  ++*count;
  return all;
}

void km_report_rows(km_document_maker *maker, const km_swept *s, const km_report_column *columns, size_t count,
                    const double *special, size_t special_count) {
  columns = with_over(maker, columns, &count);
  const km_table *table = s->motion->table;
  size_t rows = km_table_rows(table), shown = 0;
  bool *marked = KM_ARENA_NEW(&maker->arena, bool, rows);
  for (size_t i = 0; i < special_count && marked && shown + 2 < MOST_ROWS; ++i)
    if (isfinite(special[i]))
      shown = mark(marked, nearest_row(table, km_report_s(s), special[i]), shown);
  size_t even = rows < MOST_ROWS - shown ? rows : MOST_ROWS - shown;
  for (size_t i = 0; i < even && marked; ++i)
    shown = mark(marked, row_of(table, i, even), shown);
  const char **cells = KM_ARENA_NEW(&maker->arena, const char *, (shown + 1) * count);
  if (!cells || !marked)
    return;
  for (size_t c = 0; c < count; ++c)
    cells[c] = columns[c].head;
  for (size_t r = 0, line = 1; r < rows; ++r) {
    if (!marked[r])
      continue;
    for (size_t c = 0; c < count; ++c)
      cells[line * count + c] = km_report_number(maker, km_table_row(table, r)[columns[c].column]);
    ++line;
  }
  km_document_cells(maker, KM_BLOCK_TABLE, cells, shown + 1, count);
}

static bool stated(const char *text) {
  return text && *text;
}

/* Puts a paragraph behind the first block. */
static void insert_note(km_document_maker *k, const char *note) {
  size_t before = k->count;
  km_document_text(k, note);
  if (k->count == before || before < 1)
    return;
  km_block last = k->blocks[before];
  memmove(&k->blocks[2], &k->blocks[1], (before - 1) * sizeof *k->blocks);
  k->blocks[1] = last;
}

const char *km_report_subject(km_document_maker *k, const char *name, const km_model *model) {
  return km_document_format(k, "%s · SHA-256 %.16s…", name, model->sha256);
}

km_status km_report_finish(km_document_maker *k, const char *subject, const km_report_header *header, const char *tool,
                           const char *title, bool html, km_text *out, km_error *error) {
  const km_report_header none = {.title = NULL}, *h = header ? header : &none;
  if (stated(h->note))
    insert_note(k, h->note);
  km_document document = {.title = stated(h->title) ? h->title : title,
                          .subtitle =
                              km_document_format(k, "%s%s%s%sReport by %s %s", stated(h->author) ? h->author : "",
                                                 stated(h->author) ? " · " : "", stated(h->date) ? h->date : "",
                                                 stated(h->date) ? " · " : "", tool, KM_VERSION),
                          .logo = h->logo,
                          .footer = km_document_format(k, "%s · %s %s", subject, tool, KM_VERSION),
                          .blocks = k->blocks,
                          .count = k->count};
  km_status status = k->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a report")
                     : html          ? km_document_html(&document, out, error)
                                     : km_document_pdf(&document, out, error);
  km_arena_free(&k->arena);
  km_free(k);
  return status;
}
