/* Pictures of a study: one overlay a question of variants, or of the start and the best design. */
#include "kstudy/kstudy.h"

#include "kmech/design_results.h"
#include "kmech/pictures.h"

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

/* Adds a design's answer, if it has one. False when out of memory. */
static bool add(overlay *v, const kstudy_open *o, int design, int question, const char *name) {
  km_asked_design *a = &v->asked[v->count];
  km_status status = km_design_study_ask(o->study, design, question, a, NULL);
  const char *kept = km_arena_string(&v->arena, name);
  if (status != KM_OK && status != KM_PARTIAL) {
    km_asked_design_free(a);
    return status != KM_MEMORY;
  }
  v->answers[v->count++] = (km_answered){a->question, kept, NULL, 0};
  return kept != NULL;
}

static bool gather(overlay *v, const kstudy_open *o, int question) {
  int designs = km_design_study_designs(o->study), best = km_design_study_best(o->study);
  if (o->def.optimise)
    return (designs < 1 || add(v, o, 0, question, "start")) && (best < 1 || add(v, o, best, question, "best"));
  bool good = true;
  for (int i = 0; i < designs && i < MOST_OVERLAID && good; ++i) {
    km_text name = {0};
    km_design_label(o->study, &o->def, i, &name);
    good = !name.failed && add(v, o, i, question, name.data ? name.data : "");
    km_text_free(&name);
  }
  return good;
}

/* Draws a plot that was made, or says why it wasn't; frees it. */
static kt_exit write_overlay(const kstudy_request *r, const kstudy_open *o, km_status made, km_chart *chart,
                             const km_error *why, const char *name, kt_format format) {
  km_text out = {0};
  km_error error = {.status = made};
  if (made)
    error = *why;
  km_status status = made ? made : km_chart_picture(chart, kt_picture_format(format), &out, &error);
  if (status)
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_write(&r->common, o->base, name, kt_format_word(format), &out);
  km_chart_free(chart);
  km_text_free(&out);
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
  km_plotted_table tables[MOST_OVERLAID];
  size_t columns[KM_MOST_DESIGN_FIGURES];
  size_t count = columns_of(&o->def.questions[question], km_question_table(v->asked[0].question), columns);
  for (int i = 0; i < v->count; ++i) {
    const km_table *table = km_question_table(v->asked[i].question);
    tables[i] = (km_plotted_table){table, v->answers[i].name, (size_t)km_table_find(table, "s"), columns};
  }
  km_chart *chart = NULL;
  km_error error;
  km_status status = km_table_chart(tables, v->count, (int)count, &chart, &error);
  return write_overlay(r, o, status, chart, &error, o->def.questions[question].name, format);
}

static kt_exit draw(const kstudy_request *r, const kstudy_open *o, const overlay *v, int question, kt_format format) {
  km_comparison comparison = {.answers = v->answers, .count = v->count, .ordered = o->def.axis_count > 0};
  km_chart *chart = NULL;
  km_error error;
  km_status status = km_question_chart(&comparison, &chart, &error);
  return write_overlay(r, o, status, chart, &error, o->def.questions[question].name, format);
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
  km_chart *chart = NULL;
  km_error error;
  km_status status = km_table_chart(tables, v->count, 1, &chart, &error);
  snprintf(name, sizeof name, "%.200s-paths", o->def.questions[question].name);
  return write_overlay(r, o, status, chart, &error, name, format);
}

static kt_exit plot_question(const kstudy_request *r, const kstudy_open *o, int question, const kt_formats *formats) {
  overlay *v = KM_NEW(overlay, 1);
  kt_exit result = v && gather(v, o, question) ? KT_DONE : KT_NO_MEMORY;
  bool track = strcmp(o->def.questions[question].kind, "track") == 0;
  for (int f = KT_SVG; f <= KT_PNG && result == KT_DONE && v->count > 0; ++f) {
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

/* A picture of the study itself; what has nothing to show is left out. */
typedef struct own_picture {
  km_designs_plot plot;
  int index, band;
  const char *subject, *word; /* of the file's name */
} own_picture;

static kt_exit write_own(const kstudy_request *r, kstudy_open *o, const own_picture *p, kt_format format) {
  char name[256];
  km_text out = {0};
  km_error error;
  km_status status = km_designs_picture(o->study, &o->def, name_of(o), p->plot, p->index, p->band,
                                        kt_picture_format(format), &out, &error);
  kt_exit result = KT_DONE;
  if (status && status != KM_NO_RESULT) {
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
    result = kt_exit_of(status);
  } else if (!status) {
    kstudy_word(p->subject, name, 200);
    snprintf(name + strlen(name), 50, "%s%s", p->subject[0] ? "-" : "", p->word);
    result = kt_write(&r->common, o->base, name, kt_format_word(format), &out);
  }
  km_text_free(&out);
  return result;
}

static kt_exit draw_figures(const kstudy_request *r, kstudy_open *o, kt_format format, const char *word,
                            km_designs_plot plot) {
  kt_exit result = KT_DONE;
  for (int f = 0; f < km_design_study_figures(o->study); ++f) {
    const own_picture picture = {plot, f, 0, km_design_study_figure(o->study, f)->name, word};
    result = kt_worse(result, write_own(r, o, &picture, format));
  }
  return result;
}

static kt_exit draw_bands(const kstudy_request *r, kstudy_open *o, kt_format format) {
  kt_exit result = KT_DONE;
  for (int q = 0; q < o->def.question_count; ++q)
    for (int b = 0; b < o->def.questions[q].band_count; ++b) {
      const own_picture picture = {KM_DESIGNS_BANDS, q, b, o->def.questions[q].bands[b], "bands"};
      result = kt_worse(result, write_own(r, o, &picture, format));
    }
  return result;
}

static kt_exit draw_own(const kstudy_request *r, kstudy_open *o, kt_format format) {
  kt_exit result = draw_bands(r, o, format);
  if (o->def.sample) {
    result = kt_worse(result, draw_figures(r, o, format, "histogram", KM_DESIGNS_HISTOGRAM));
    result = kt_worse(result, draw_figures(r, o, format, "scatter", KM_DESIGNS_SCATTER));
    result = kt_worse(result, draw_figures(r, o, format, "convergence", KM_DESIGNS_CONVERGENCE));
  }
  if (o->def.optimise) {
    bool front = o->def.optimise->goal_count == 2;
    const own_picture picture = {front ? KM_DESIGNS_FRONT : KM_DESIGNS_PROGRESS, 0, 0, "",
                                 front ? "front" : "progress"};
    result = kt_worse(result, write_own(r, o, &picture, format));
  }
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
