/* A study's designs as CSV and as a record. */
#include "base/arguments.h"
#include "kmech/report.h"
#include "kmech/version.h"
#include "model/model.h"
#include "report/record/record.h"

#include <math.h>
#include <string.h>

void km_design_label(const km_design_study *s, const km_design_study_def *def, int design, km_text *out) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  if (!s || !def || !out || design < 0 || design >= km_design_study_designs(s))
    return;
  if (design < def->variant_count) {
    km_text_add(out, def->variants[design].name);
    return;
  }
  if (!def->axis_count || km_design_study_values(s, design, values, NULL)) {
    km_text_format(out, "%d", design);
    return;
  }
  for (int a = 0; a < def->axis_count; ++a) {
    int p = def->axes[a].parameter;
    km_text_format(out, "%s%s=%g", a ? ", " : "", def->parameters[p].name, values[p]);
  }
}

/* RFC 4180: a field with a comma, a quote or a line end is quoted. */
static void add_field(const char *text, km_text *out) {
  if (!strpbrk(text, ",\"\r\n")) {
    km_text_add(out, text);
    return;
  }
  km_text_add(out, "\"");
  for (const char *c = text; *c; ++c)
    km_text_bytes(out, *c == '"' ? "\"\"" : c, *c == '"' ? 2 : 1);
  km_text_add(out, "\"");
}

static void add_header(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  km_text_add(out, "design,name");
  for (int p = 0; p < def->parameter_count; ++p) {
    km_text_add(out, ",");
    add_field(def->parameters[p].name, out);
  }
  km_text_add(out, ",outcome");
  for (int f = 0; f < km_design_study_figures(s); ++f) {
    km_text name = {0};
    const char *unit = km_design_study_figure_unit(s, f);
    km_text_format(&name, *unit ? "%s_%s" : "%s", km_design_study_figure(s, f)->name, unit);
    km_text_add(out, ",");
    add_field(name.data ? name.data : "", out);
    out->failed = out->failed || name.failed;
    km_text_free(&name);
  }
  km_text_add(out, ",reason\r\n");
}

/* A parameter that the design leaves as it is shows the model's own value. */
static double shown_value(const km_design_study *s, const double *values, int parameter) {
  return isnan(values[parameter]) ? km_design_study_base(s, parameter) : values[parameter];
}

km_status km_designs_csv(const km_design_study *s, const km_design_study_def *def, km_text *out, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_design_result r;
  km_status status = km_check_given(s && def && out, "study or place for the result", error);
  if (status)
    return status;
  add_header(s, def, out);
  for (int i = 0; i < km_design_study_designs(s) && !status; ++i) {
    km_text name = {0};
    status = km_design_study_values(s, i, values, error);
    if (!status)
      status = km_design_study_result(s, i, &r, error);
    if (status)
      break;
    km_text_format(out, "%d,", i);
    km_design_label(s, def, i, &name);
    add_field(name.data ? name.data : "", out);
    for (int p = 0; p < def->parameter_count; ++p) {
      km_text_add(out, ",");
      km_text_number(out, shown_value(s, values, p));
    }
    km_text_format(out, ",%s", km_design_outcome_name(r.outcome));
    for (int f = 0; f < km_design_study_figures(s); ++f) {
      km_text_add(out, ",");
      km_text_number(out, r.figures[f]);
    }
    km_text_add(out, ",");
    add_field(r.reason, out);
    km_text_add(out, "\r\n");
    out->failed = out->failed || name.failed;
    km_text_free(&name);
  }
  return status || !out->failed ? status : km_fail(error, KM_MEMORY, "out of memory for a table");
}

static void add_number(km_arena *arena, km_value *object, const char *key, double x) {
  if (isfinite(x))
    km_value_number(arena, object, key, x);
  else
    km_value_add(arena, object, key, KM_NULL);
}

/* Reasons of null figures, by their names: "infinite", "minus infinite". */
static void add_states(const km_design_study *s, const km_design_result *r, km_arena *arena, km_value *design) {
  km_value *states = NULL;
  for (int f = 0; f < km_design_study_figures(s) && !arena->failed; ++f) {
    if (!isinf(r->figures[f]))
      continue;
    states = states ? states : km_value_add(arena, design, "states", KM_OBJECT);
    km_value_string(arena, states, km_design_study_figure(s, f)->name,
                    r->figures[f] > 0.0 ? "infinite" : "minus infinite");
  }
}

static km_status add_designs(const km_design_study *s, const km_design_study_def *def, km_arena *arena,
                             km_value *record, km_error *error) {
  km_value *list = km_value_add(arena, record, "designs", KM_LIST);
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_design_result r;
  km_status status = KM_OK;
  for (int i = 0; i < km_design_study_designs(s) && !arena->failed; ++i) {
    km_text name = {0};
    status = km_design_study_values(s, i, values, error);
    if (!status)
      status = km_design_study_result(s, i, &r, error);
    if (status)
      return status;
    km_value *design = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_number(arena, design, "design", i);
    km_design_label(s, def, i, &name);
    km_value_words(arena, design, "name", &name);
    km_value *parameters = km_value_add(arena, design, "parameters", KM_OBJECT);
    for (int p = 0; p < def->parameter_count && !arena->failed; ++p)
      add_number(arena, parameters, def->parameters[p].name, shown_value(s, values, p));
    km_value_string(arena, design, "outcome", km_design_outcome_name(r.outcome));
    if (r.reason[0])
      km_value_string(arena, design, "reason", km_arena_string(arena, r.reason));
    km_value *figures = km_value_add(arena, design, "figures", KM_OBJECT);
    for (int f = 0; f < km_design_study_figures(s) && !arena->failed; ++f)
      add_number(arena, figures, km_design_study_figure(s, f)->name, r.figures[f]);
    add_states(s, &r, arena, design);
  }
  return KM_OK;
}

static km_status add_statistics(km_design_study *s, km_arena *arena, km_value *record, km_error *error) {
  km_value *list = km_value_add(arena, record, "statistics", KM_LIST);
  km_status status = KM_OK;
  for (int f = 0; f < km_design_study_figures(s) && !status && !arena->failed; ++f) {
    km_design_statistics st;
    status = km_design_study_statistics(s, f, &st, error);
    if (status)
      return status;
    km_value *at = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, at, "figure", km_design_study_figure(s, f)->name);
    km_value_string(arena, at, "unit", km_design_study_figure_unit(s, f));
    km_value_number(arena, at, "count", st.count);
    add_number(arena, at, "mean", st.mean);
    add_number(arena, at, "mean_half_width", st.mean_half_width);
    add_number(arena, at, "deviation", st.deviation);
    add_number(arena, at, "least", st.least);
    add_number(arena, at, "greatest", st.greatest);
    km_value *quantiles = km_value_add(arena, at, "quantiles", KM_LIST);
    for (int k = 0; k < KM_DESIGN_QUANTILES && !arena->failed; ++k)
      add_number(arena, quantiles, NULL, st.quantiles[k]);
    km_value_number(arena, at, "good", st.good);
  }
  return status;
}

/* The model as its file has it, else as the first design has it; a study about a function has none. */
static km_status add_model(const km_design_study *s, const km_design_study_def *def, km_arena *arena, km_value *record,
                           km_error *error) {
  km_model *model = NULL;
  km_error ignored;
  if (def->function)
    return KM_OK;
  km_status status = def->bytes ? km_model_read(def->bytes, def->size, NULL, &model, &ignored)
                                : km_model_read_file(def->model, NULL, &model, &ignored);
  if (status && km_design_study_designs(s) > 0)
    status = km_design_study_model(s, 0, &model, &ignored);
  if (!status) {
    km_record_model(model, record, arena);
    km_value_number(arena, record, "characteristic_length", km_design_study_length(s));
  }
  km_model_free(model);
  return status == KM_MEMORY ? km_fail(error, KM_MEMORY, "out of memory for a record") : KM_OK;
}

km_status km_designs_record(km_design_study *s, const km_design_study_def *def, const char *name, km_arena *arena,
                            km_value **out, km_error *error) {
  km_design_yield yield;
  km_status status = km_check_given(s && def && name && arena && out, "study, name or place for the result", error);
  if (!status)
    status = km_design_study_yield(s, &yield, error);
  if (status)
    return status;
  km_value *record = *out = km_value_add(arena, NULL, NULL, KM_OBJECT);
  km_value_string(arena, record, "kmech", km_version());
  km_value_string(arena, record, "tool", "kstudy");
  km_value_string(arena, record, "study", name);
  if (def->model)
    km_value_string(arena, record, "model", def->model);
  status = add_model(s, def, arena, record, error);
  km_value_number(arena, record, "asked", yield.count);
  km_value_number(arena, record, "good", yield.good);
  add_number(arena, record, "share", yield.share);
  km_value *interval = km_value_add(arena, record, "share_interval", KM_LIST);
  if (!arena->failed)
    add_number(arena, interval, NULL, yield.share_low);
  if (!arena->failed)
    add_number(arena, interval, NULL, yield.share_high);
  int best = km_design_study_best(s);
  if (best >= 0)
    km_value_number(arena, record, "best", best);
  if (!status && !arena->failed)
    status = add_statistics(s, arena, record, error);
  if (!status && !arena->failed)
    status = add_designs(s, def, arena, record, error);
  return status || !arena->failed ? status : km_fail(error, KM_MEMORY, "out of memory for a record");
}
