/* Pictures of a study: one overlay a question of variants, or of the start and the best design. */
#include "kstudy/kstudy.h"

#include "report/plot/designs_plot.h"
#include "report/plot/question_plot.h"
#include "report/plot/table_plot.h"
#include "report/record/designs_text.h"

#include <stdio.h>
#include <string.h>

enum { MOST_OVERLAID = 64 };

/* The designs that a picture compares. */
typedef struct overlay {
  km_asked_design asked[MOST_OVERLAID];
  km_answered answers[MOST_OVERLAID];
  km_arena arena;
  int count;
} overlay;

static void overlay_free(overlay *v) {
  for (int i = 0; i < v->count; ++i)
    km_asked_design_free(&v->asked[i]);
  km_arena_free(&v->arena);
  km_free(v);
}

/* Adds a design's answer, if it has one. */
static void add(overlay *v, const kstudy_open *o, int design, int question, const char *name) {
  km_asked_design *a = &v->asked[v->count];
  km_status status = km_design_study_ask(o->study, design, question, a, NULL);
  if (status != KM_OK && status != KM_PARTIAL) {
    km_asked_design_free(a);
    return;
  }
  v->answers[v->count++] = (km_answered){a->mechanism, a->question, km_arena_string(&v->arena, name), NULL, 0};
}

static void gather(overlay *v, const kstudy_open *o, int question) {
  int designs = km_design_study_designs(o->study), best = km_design_study_best(o->study);
  if (o->def.optimise) {
    if (designs > 0)
      add(v, o, 0, question, "start");
    if (best > 0)
      add(v, o, best, question, "best");
    return;
  }
  for (int i = 0; i < designs && i < MOST_OVERLAID; ++i) {
    km_text name = {0};
    km_design_label(o->study, &o->def, i, &name);
    add(v, o, i, question, name.data ? name.data : "");
    km_text_free(&name);
  }
}

static kt_exit write_overlay(const kstudy_request *r, const kstudy_open *o, km_status status, const km_error *error,
                             const char *name, kt_format format, km_text *out) {
  if (status)
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error->text);
  kt_exit result = status ? kt_exit_of(status) : kt_write(&r->common, o->base, name, kt_format_word(format), out);
  km_text_free(out);
  return result;
}

/* The columns that figures are taken from, each once; the distance from the limits where none has one. Returns how many. */
static size_t columns_of(const km_design_question *q, const km_table *table, size_t *y) {
  size_t count = 0;
  for (int f = 0; f < q->figure_count; ++f) {
    int column = q->figures[f].column ? km_table_find(table, q->figures[f].column) : -1;
    bool known = column < 0;
    for (size_t k = 0; k < count && !known; ++k)
      known = y[k] == (size_t)column;
    if (!known)
      y[count++] = (size_t)column;
  }
  int margin = km_table_find(table, "limit_margin");
  if (count == 0 && margin >= 0)
    y[count++] = (size_t)margin;
  return count;
}

/* What figures are taken from along the path, of all designs over each other. */
static kt_exit draw_tracks(const kstudy_request *r, const kstudy_open *o, const overlay *v, int question,
                           kt_format format) {
  const km_comparison comparison = {.answers = v->answers, .count = v->count};
  size_t columns[KM_MOST_DESIGN_FIGURES];
  size_t count = columns_of(&o->def.questions[question], km_question_table(v->asked[0].question), columns);
  km_text out = {0};
  km_error error;
  km_status status = km_question_plot_columns(&comparison, columns, count, kt_canvas_format(format), &out, &error);
  return write_overlay(r, o, status, &error, o->def.questions[question].name, format, &out);
}

static kt_exit draw(const kstudy_request *r, const kstudy_open *o, const overlay *v, int question, kt_format format) {
  km_comparison comparison = {.answers = v->answers, .count = v->count, .ordered = o->def.axis_count > 0};
  km_text out = {0};
  km_error error;
  km_status status = km_question_plot(&comparison, kt_canvas_format(format), &out, &error);
  return write_overlay(r, o, status, &error, o->def.questions[question].name, format, &out);
}

/* The paths of the first point that the question traces, over each other; nothing where it traces none. */
static kt_exit draw_paths(const kstudy_request *r, const kstudy_open *o, const overlay *v, int question,
                          kt_format format) {
  km_plotted_table tables[MOST_OVERLAID];
  size_t y[MOST_OVERLAID];
  char name[256];
  for (int i = 0; i < v->count; ++i) {
    const km_table *table = km_question_table(v->asked[i].question);
    km_span points = km_table_span(table, "point.");
    if (points.count < 3)
      return KT_DONE;
    y[i] = points.first + 1;
    tables[i] = (km_plotted_table){table, v->answers[i].name, points.first, &y[i]};
  }
  km_text out = {0};
  km_error error;
  km_status status = km_table_plot(tables, (size_t)v->count, 1, kt_canvas_format(format), &out, &error);
  snprintf(name, sizeof name, "%.200s-paths", o->def.questions[question].name);
  return write_overlay(r, o, status, &error, name, format, &out);
}

static kt_exit plot_question(const kstudy_request *r, const kstudy_open *o, int question, const kt_formats *formats) {
  overlay *v = KM_NEW(overlay, 1);
  kt_exit result = v ? KT_DONE : KT_INTERNAL;
  if (v)
    gather(v, o, question);
  bool track = strcmp(o->def.questions[question].kind, "track") == 0;
  for (int f = KT_SVG; f <= KT_PNG && v && v->count > 0; ++f) {
    if (!formats->wanted[f])
      continue;
    kt_exit drawn = (track ? draw_tracks : draw)(r, o, v, question, (kt_format)f);
    if (!track)
      drawn = kt_worse(drawn, draw_paths(r, o, v, question, (kt_format)f));
    result = kt_worse(result, drawn);
  }
  if (v)
    overlay_free(v);
  return result;
}

/* The study's name in pictures, which hold no path. */
static const char *name_of(const kstudy_open *o) {
  const char *slash = strrchr(o->base, '/');
  return slash ? slash + 1 : o->base;
}

/* One picture of the study itself; what has nothing to show is left out. */
typedef km_status (*draw_figure)(const km_designs_picture *picture, int figure, km_text *out, km_error *error);
typedef km_status (*draw_whole)(const km_designs_picture *picture, km_text *out, km_error *error);

static kt_exit write_picture(const kstudy_request *r, const kstudy_open *o, km_status status, const km_error *error,
                             const char *subject, const char *word, kt_format format, km_text *out) {
  char name[256];
  if (status == KM_NO_RESULT)
    return KT_DONE;
  if (status) {
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error->text);
    return kt_exit_of(status);
  }
  kstudy_word(subject, name, 200);
  snprintf(name + strlen(name), 50, "%s%s", subject[0] ? "-" : "", word);
  return kt_write(&r->common, o->base, name, kt_format_word(format), out);
}

static kt_exit draw_figures(const kstudy_request *r, kstudy_open *o, kt_format format, const char *word,
                            draw_figure draw_it) {
  const km_designs_picture picture = {
      .study = o->study, .def = &o->def, .name = name_of(o), .format = kt_canvas_format(format)};
  kt_exit result = KT_DONE;
  for (int f = 0; f < km_design_study_figures(o->study); ++f) {
    km_text out = {0};
    km_error error;
    km_status status = draw_it(&picture, f, &out, &error);
    const char *name = km_design_study_figure(o->study, f)->name;
    result = kt_worse(result, write_picture(r, o, status, &error, name, word, format, &out));
    km_text_free(&out);
  }
  return result;
}

static kt_exit draw_study(const kstudy_request *r, kstudy_open *o, kt_format format, const char *word,
                          draw_whole draw_it) {
  const km_designs_picture picture = {
      .study = o->study, .def = &o->def, .name = name_of(o), .format = kt_canvas_format(format)};
  km_text out = {0};
  km_error error;
  km_status status = draw_it(&picture, &out, &error);
  kt_exit result = write_picture(r, o, status, &error, "", word, format, &out);
  km_text_free(&out);
  return result;
}

static kt_exit draw_bands(const kstudy_request *r, kstudy_open *o, kt_format format) {
  const km_designs_picture picture = {
      .study = o->study, .def = &o->def, .name = name_of(o), .format = kt_canvas_format(format)};
  kt_exit result = KT_DONE;
  for (int q = 0; q < o->def.question_count; ++q)
    for (int b = 0; b < o->def.questions[q].band_count; ++b) {
      km_text out = {0};
      km_error error;
      km_status status = km_designs_bands(&picture, q, b, &out, &error);
      result =
          kt_worse(result, write_picture(r, o, status, &error, o->def.questions[q].bands[b], "bands", format, &out));
      km_text_free(&out);
    }
  return result;
}

static kt_exit draw_own(const kstudy_request *r, kstudy_open *o, kt_format format) {
  kt_exit result = draw_bands(r, o, format);
  if (o->def.sample) {
    result = kt_worse(result, draw_figures(r, o, format, "histogram", km_designs_histogram));
    result = kt_worse(result, draw_figures(r, o, format, "scatter", km_designs_scatter));
    result = kt_worse(result, draw_figures(r, o, format, "convergence", km_designs_convergence));
  }
  if (o->def.optimise && o->def.optimise->goal_count == 2)
    result = kt_worse(result, draw_study(r, o, format, "front", km_designs_front));
  else if (o->def.optimise)
    result = kt_worse(result, draw_study(r, o, format, "progress", km_designs_progress));
  return result;
}

kt_exit kstudy_plot(const kstudy_request *r, kstudy_open *o, const kt_formats *formats) {
  kt_exit result = KT_DONE;
  for (int f = KT_SVG; f <= KT_PNG; ++f)
    if (formats->wanted[f])
      result = kt_worse(result, draw_own(r, o, (kt_format)f));
  for (int q = 0; q < o->def.question_count && !o->def.sample; ++q)
    result = kt_worse(result, plot_question(r, o, q, formats));
  return result;
}
