/* Writes designs as model files: the best of an optimisation, the worst of a sample. */
#include "kstudy/kstudy.h"

#include "kmech/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static kt_exit write_text(const kstudy_request *r, const kstudy_open *o, const char *word, const km_text *bytes,
                          const km_assignment *values, int count) {
  km_error error;
  const char *to = kt_is_piped(o->base) ? NULL : o->base;
  size_t length = km_model_write_varied(bytes->data, bytes->size, values, count, o->def.model, to, NULL, 0, &error);
  km_text text = {.data = length ? KM_NEW(char, length + 1) : NULL, .size = length, .capacity = length + 1};
  kt_exit result = KT_NO_MEMORY;
  if (!length) {
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
    result = kt_exit_of(error.status);
  } else if (text.data && km_model_write_varied(bytes->data, bytes->size, values, count, o->def.model, to, text.data,
                                                length + 1, &error)) {
    result = kt_write(&r->common, o->base, word, "json", &text);
  }
  km_text_free(&text);
  return result;
}

static kt_exit write_design(const kstudy_request *r, const kstudy_open *o, int design, const char *word) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_assignment assignments[KM_MAX_DESIGN_PARAMETERS];
  km_text bytes = {0};
  km_error error;
  int count = 0;
  km_status status = km_design_study_values(o->study, design, values, &error);
  if (!status)
    status = km_file_read(o->def.model, &bytes, &error);
  for (int p = 0; p < o->def.parameter_count && !status; ++p)
    if (!isnan(values[p]))
      assignments[count++] = (km_assignment){o->def.parameters[p].path, values[p]};
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : write_text(r, o, word, &bytes, assignments, count);
  km_text_free(&bytes);
  return result;
}

void kstudy_word(const char *figure, char *out, size_t size) {
  size_t used = 0;
  for (const char *c = figure; *c && used + 1 < size; ++c)
    out[used++] = strchr(" /:\\", *c) ? '_' : *c;
  out[used] = '\0';
}

/* The worst design by a figure that has a preferred sense. */
static kt_exit write_worst(const kstudy_request *r, kstudy_open *o) {
  kt_exit result = KT_DONE;
  for (int f = 0; f < km_design_study_figures(o->study) && result == KT_DONE; ++f) {
    const km_design_figure *figure = km_design_study_figure(o->study, f);
    km_design_statistics st;
    char word[KSTUDY_NAME], name[KSTUDY_WORD];
    if (!figure->better || km_design_study_statistics(o->study, f, &st, NULL) || st.count == 0)
      continue;
    kstudy_word(figure->name, name, sizeof name);
    snprintf(word, sizeof word, "worst-%s", name);
    result = write_design(r, o, figure->better > 0 ? st.least_design : st.greatest_design, word);
  }
  return result;
}

kt_exit kstudy_write_models(const kstudy_request *r, kstudy_open *o) {
  int best = km_design_study_best(o->study);
  if (o->def.optimise)
    return best >= 0 ? write_design(r, o, best, "best") : KT_DONE;
  return o->def.sample ? write_worst(r, o) : KT_DONE;
}
