/* Pictures of a study. */
#include "kstudy/kstudy.h"

#include "kmech/design_results.h"
#include "kmech/pictures.h"

#include <stdio.h>
#include <string.h>

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
    bool both = p->subject[0] && p->word[0];
    snprintf(name + strlen(name), 50, "%s%s", both ? "-" : "", p->word);
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

/* A picture a question of all variants over each other, or of the start and the best design. */
static kt_exit draw_answers(const kstudy_request *r, kstudy_open *o, kt_format format) {
  kt_exit result = KT_DONE;
  for (int q = 0; q < o->def.question_count; ++q) {
    const char *name = o->def.questions[q].name;
    const own_picture answers = {KM_DESIGNS_ANSWERS, q, 0, name, ""}, paths = {KM_DESIGNS_PATHS, q, 0, name, "paths"};
    result = kt_worse(result, write_own(r, o, &answers, format));
    result = kt_worse(result, write_own(r, o, &paths, format));
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
    if (formats->wanted[f]) {
      result = kt_worse(result, draw_own(r, o, (kt_format)f));
      result = kt_worse(result, draw_answers(r, o, (kt_format)f));
    }
  return result;
}
