/* Pictures of a study. */
#include "kstudy/kstudy.h"

#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

/* The study's name in pictures, which hold no path. */
static const char *name_of(const kstudy_open *o) {
  const char *slash = strrchr(o->base, '/');
  return slash ? slash + 1 : o->base;
}

/* A picture, and what its file's name says: SUBJECT-WORD, or the one that there is. */
typedef struct own_picture {
  km_designs_plot plot;
  int index, band;
  const char *question; /* stands before the subject of a band that several questions keep; or "" */
  const char *subject, *word;
} own_picture;

typedef struct own_pictures {
  own_picture *items;
  int count;
} own_pictures;

static void add(own_pictures *out, km_designs_plot plot, int index, const char *subject, const char *word) {
  out->items[out->count++] = (own_picture){plot, index, 0, "", subject, word};
}

static bool is_kept_elsewhere(const km_design_study_def *def, int question, const char *column) {
  for (int q = 0; q < def->question_count; ++q)
    for (int b = 0; b < def->questions[q].band_count; ++b)
      if (q != question && strcmp(def->questions[q].bands[b], column) == 0)
        return true;
  return false;
}

static void add_bands(const km_design_study_def *def, int q, own_pictures *out) {
  const km_design_question *question = &def->questions[q];
  for (int b = 0; b < question->band_count; ++b) {
    add(out, KM_DESIGNS_BANDS, q, question->bands[b], "bands");
    out->items[out->count - 1].band = b;
    if (is_kept_elsewhere(def, q, question->bands[b]))
      out->items[out->count - 1].question = question->name;
  }
}

static void add_figures(const km_design_study_def *def, const char *word, km_designs_plot plot, own_pictures *out) {
  int index = 0;
  for (int q = 0; q < def->question_count; ++q)
    for (int f = 0; f < def->questions[q].figure_count; ++f, ++index)
      add(out, plot, index, def->questions[q].figures[f].name, word);
}

/* Possible pictures of the study, by its definition; empty ones are omitted later. */
static bool list_pictures(kstudy_open *o, own_pictures *out) {
  const km_design_study_def *def = &o->def;
  size_t most = 1;
  for (int q = 0; q < def->question_count; ++q)
    most += 2 + (size_t)def->questions[q].band_count + 3 * (size_t)def->questions[q].figure_count;
  *out = (own_pictures){KM_ARENA_NEW(&o->arena, own_picture, most), 0};
  if (!out->items)
    return false;
  for (int q = 0; q < def->question_count; ++q)
    add_bands(def, q, out);
  if (def->sample) {
    add_figures(def, "histogram", KM_DESIGNS_HISTOGRAM, out);
    add_figures(def, "scatter", KM_DESIGNS_SCATTER, out);
    add_figures(def, "convergence", KM_DESIGNS_CONVERGENCE, out);
  }
  if (def->optimise) {
    bool front = def->optimise->goal_count == 2;
    add(out, front ? KM_DESIGNS_FRONT : KM_DESIGNS_PROGRESS, 0, "", front ? "front" : "progress");
  }
  for (int q = 0; q < def->question_count; ++q) { /* overlay of all variants, or of the start and the best design */
    add(out, KM_DESIGNS_ANSWERS, q, def->questions[q].name, "");
    add(out, KM_DESIGNS_PATHS, q, def->questions[q].name, "paths");
  }
  return true;
}

static void name_picture(const own_picture *p, char *out, size_t size) {
  char question[100], subject[KSTUDY_WORD];
  kstudy_word(p->question, question, sizeof question);
  kstudy_word(p->subject, subject, sizeof subject);
  snprintf(out, size, "%s%s%s%s%s", question, question[0] ? "." : "", subject, subject[0] && p->word[0] ? "-" : "",
           p->word);
}

kt_exit kstudy_check_names(const kstudy_request *r, kstudy_open *o) {
  own_pictures all;
  if (!list_pictures(o, &all))
    return KT_NO_MEMORY;
  for (int i = 0; i < all.count; ++i)
    for (int k = 0; k < i; ++k) {
      char name[KSTUDY_NAME], other[KSTUDY_NAME];
      name_picture(&all.items[i], name, sizeof name);
      name_picture(&all.items[k], other, sizeof other);
      if (strcmp(name, other) != 0)
        continue;
      kt_print_message(&r->common, KM_ERROR,
                       "%s: the pictures of \"%.80s\" and \"%.80s\" would both be %s.%s; expected names that differ",
                       o->name, all.items[k].subject, all.items[i].subject, o->base, name);
      return KT_BAD_MODEL;
    }
  return KT_DONE;
}

static kt_exit write_own(const kstudy_request *r, kstudy_open *o, const own_picture *p, kt_format format) {
  char name[KSTUDY_NAME];
  km_text out = {0};
  km_error error;
  km_status status = km_designs_picture(o->study, &o->def, name_of(o), p->plot, p->index, p->band,
                                        kt_picture_format(format), &out, &error);
  kt_exit result = KT_DONE;
  if (status && status != KM_NO_RESULT) {
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
    result = kt_exit_of(status);
  } else if (!status) {
    name_picture(p, name, sizeof name);
    result = kt_write(&r->common, o->base, name, kt_format_word(format), &out);
  }
  km_text_free(&out);
  return result;
}

kt_exit kstudy_plot(const kstudy_request *r, kstudy_open *o, const kt_formats *formats) {
  own_pictures all;
  if (!list_pictures(o, &all))
    return KT_NO_MEMORY;
  kt_exit result = KT_DONE;
  int designs = km_design_study_designs(o->study);
  if (!o->def.sample && !o->def.optimise && designs > KM_MAX_OVERLAID_DESIGNS)
    kt_print_message(&r->common, KM_NOTE,
                     "%s: the answers of the first %d of %d designs are drawn; kstudy export has the figures of all",
                     o->name, KM_MAX_OVERLAID_DESIGNS, designs);
  for (int f = KT_SVG; f <= KT_PNG; ++f)
    for (int i = 0; i < all.count && formats->wanted[f]; ++i)
      result = kt_worse(result, write_own(r, o, &all.items[i], (kt_format)f));
  return result;
}
