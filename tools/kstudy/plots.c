/* Pictures of a study: one overlay a question of variants, or of the start and the best design. */
#include "kstudy/kstudy.h"

#include "report/plot/question_plot.h"
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

static kt_exit draw(const kstudy_request *r, const kstudy_open *o, const overlay *v, int question, kt_format format) {
  km_comparison comparison = {.answers = v->answers, .count = v->count, .ordered = o->def.axis_count > 0};
  km_text out = {0};
  km_error error;
  km_status status = km_question_plot(&comparison, kt_canvas_format(format), &out, &error);
  if (status)
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status
                       ? kt_exit_of(status)
                       : kt_write(&r->common, o->base, o->def.questions[question].name, kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit plot_question(const kstudy_request *r, const kstudy_open *o, int question, const kt_formats *formats) {
  overlay *v = KM_NEW(overlay, 1);
  kt_exit result = v ? KT_DONE : KT_INTERNAL;
  if (v)
    gather(v, o, question);
  for (int f = KT_SVG; f <= KT_PNG && v && v->count > 0; ++f)
    if (formats->wanted[f])
      result = kt_worse(result, draw(r, o, v, question, (kt_format)f));
  if (v)
    overlay_free(v);
  return result;
}

kt_exit kstudy_plot(const kstudy_request *r, kstudy_open *o, const kt_formats *formats) {
  kt_exit result = KT_DONE;
  for (int q = 0; q < o->def.question_count && !o->def.sample; ++q)
    result = kt_worse(result, plot_question(r, o, q, formats));
  return result;
}
