/* Opens a study: reads its model, finds the places of the parameters, tries its requests on a reference design, and
 * opens its store. */
#include "study/design_study.h"

#include "base/arguments.h"
#include "exchange/mesh/model_meshes.h"
#include "kmech/data.h"
#include "kmech/version.h"
#include "model/model.h"
#include "question/question.h"
#include "study/result_store.h"
#include "study/statistics/sampler.h"
#include "study/study_inputs.h"

#include <string.h>

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

/* Checks the syntax of the model file; its errors state that file. */
static km_status check_syntax(const km_design_study *s, const km_text *text, km_error *error) {
  km_arena arena = {0};
  const km_value *root;
  km_error found;
  km_status status = km_json_parse(text->data ? text->data : "", text->size, &arena, &root, &found);
  km_arena_free(&arena);
  return status ? km_fail(error, status, "%s: %s", s->def->model, found.text) : KM_OK;
}

/* Reads the text of the model. */
static km_status read_text(km_design_study *s, km_error *error) {
  km_text text = {0};
  if (s->def->bytes) {
    s->bytes = s->def->bytes;
    s->size = s->def->size;
    return KM_OK;
  }
  km_status status = km_file_read(s->def->model, &text, error);
  s->size = text.size;
  if (!status)
    status = check_syntax(s, &text, error);
  if (!status)
    s->bytes = km_text_move_to_arena(&text, &s->arena);
  km_text_free(&text);
  return !status && s->arena.failed ? no_memory(error) : status;
}

/* Chooses the reference design, whose characteristic length is used for all designs: the first variant or grid
 * point, as in kmob's comparison of variants; for samples and optimisations, the values of the file. */
static void choose_reference(km_design_study *s) {
  km_design_clear(s, s->reference);
  if (s->def->variant_count || s->def->axis_count)
    km_design_values(s, 0, s->reference);
}

/* Computes the columns of a request; *rows is the number of rows of a complete result. A sweep takes one step, which
 * is enough to find its columns. */
static km_status compute_columns(km_question *q, km_state *state, int *rows, km_error *error) {
  km_sweep_plan plan;
  km_option_value short_motion = {.whole = 1};
  *rows = 0;
  km_status status = KM_OK;
  if (q->kind->motion)
    status = km_question_make_plan(q, &plan, error);
  if (!status && q->kind->motion) {
    *rows = plan.steps + 1;
    status = km_question_set(q, "steps", &short_motion, error);
  }
  if (!status)
    status = km_question_compute(q, state, error);
  if (!q->kind->motion && (status == KM_OK || status == KM_PARTIAL))
    *rows = q->kind->planned_rows(q);
  return status;
}

/* Computes a request for the reference design, to check its options, figures and columns. */
static km_status try_question(km_design_study *s, int index, const km_model *model, km_error *error) {
  const km_design_question *def = &s->def->questions[index];
  km_mechanism *m = NULL;
  km_state *state = NULL;
  km_question *q = NULL;
  km_error found;
  km_status status = km_design_compile_at(model, def, &m, &state, &found);
  if (!status)
    status = km_question_create(m, def->kind, &q, &found);
  if (!status)
    status = km_design_set_options(s->def, def, model, q, &found);
  if (!status)
    status = compute_columns(q, state, &s->band_rows[index], &found);
  if (status == KM_OK || status == KM_PARTIAL)
    status = km_design_check_figures(def, q, s->units + s->first_figure[index], &s->arena, &found);
  if (status)
    km_fail(error, status, "ask.%.80s: %.800s", def->name, found.text);
  km_question_free(q);
  km_state_free(state);
  km_mechanism_free(m);
  return status;
}

static km_status try_questions(km_design_study *s, const km_model *model, km_error *error) {
  km_status status = KM_OK;
  for (int q = 0; q < s->def->question_count && !status; ++q)
    status = try_question(s, q, model, error);
  return status;
}

/* Characteristic length of the reference design. */
static km_status read_length(km_design_study *s, const km_model *model, km_error *error) {
  static const km_design_question plain = {0};
  km_mechanism *m = NULL;
  km_state *state = NULL;
  km_status status = km_design_compile_at(model, &plain, &m, &state, error);
  s->length = status ? 0.0 : km_mechanism_characteristic_length(m, NULL);
  km_state_free(state);
  km_mechanism_free(m);
  return status;
}

static km_status identify_meshes(km_design_study *s, const km_model *model, km_error *error) {
  km_text text = {0};
  km_status status = km_model_identify_meshes(model, &text, error);
  s->meshes = km_text_move_to_arena(&text, &s->arena);
  return status;
}

/* Reads length, figures, columns and meshes from the reference design. */
static km_status try_reference(km_design_study *s, km_error *error) {
  km_model *model = NULL;
  s->length = 0.0;
  km_status status = km_design_read_model(s, s->reference, &model, error);
  if (!status)
    status = read_length(s, model, error);
  if (!status)
    status = try_questions(s, model, error);
  if (!status)
    status = identify_meshes(s, model, error);
  km_model_free(model);
  return status;
}

/* Binds the study to its model. If the reference design is invalid, the values of the file are the reference; the
 * invalid design is then a result like any other. */
static km_status bind_model(km_design_study *s, km_error *error) {
  km_error second;
  km_status status = read_text(s, error);
  if (!status)
    status = km_design_check_bounds(s, error);
  if (!status)
    status = km_patch_find(s, error);
  if (status)
    return status;
  choose_reference(s);
  status = try_reference(s, error);
  if (!status || status == KM_MEMORY)
    return status;
  km_design_clear(s, s->reference);
  return try_reference(s, &second) ? status : KM_OK;
}

/* Lists the figures of all requests. */
static void list_figures(km_design_study *s) {
  for (int q = 0; q < s->def->question_count; ++q) {
    const km_design_question *question = &s->def->questions[q];
    s->first_figure[q] = s->figure_count;
    for (int f = 0; f < question->figure_count; ++f, ++s->figure_count) {
      s->figures[s->figure_count] = &question->figures[f];
      s->units[s->figure_count] = "";
    }
  }
  s->first_figure[s->def->question_count] = s->figure_count;
}

static void add_settings(km_text *out, const km_design_setting *settings, int count) {
  for (int i = 0; i < count; ++i) {
    km_identity_add_name(out, settings[i].coordinate);
    km_identity_add_numbers(out, &settings[i].value, 1);
  }
  km_text_add(out, "|");
}

/* Appends all settings of a request that affect its answers, for its hash. */
static void add_question(km_text *out, const km_design_question *q) {
  km_identity_add_name(out, q->kind ? q->kind : "function");
  for (int i = 0; i < q->option_count; ++i) {
    const km_design_option *o = &q->options[i];
    km_identity_add_name(out, o->name);
    km_text_add(out, o->flag ? "set" : "");
    km_identity_add_numbers(out, o->numbers, o->number_count);
    for (int k = 0; k < o->text_count; ++k)
      km_identity_add_name(out, o->texts[k]);
  }
  km_text_add(out, "|");
  add_settings(out, q->holds, q->hold_count);
  add_settings(out, q->sets, q->set_count);
  for (int f = 0; f < q->figure_count; ++f) { /* limits don't affect the answer */
    const km_design_figure *figure = &q->figures[f];
    km_text_format(out, "%d;", (int)figure->kind);
    km_identity_add_name(out, q->kind ? figure->column : figure->name);
    km_identity_add_numbers(out, &figure->at, 1);
    km_identity_add_numbers(out, figure->points, 3 * figure->point_count);
  }
  km_text_add(out, "|");
  for (int b = 0; b < q->band_count; ++b)
    km_identity_add_name(out, q->bands[b]);
}

/* Registers a request in the store by the hash of all inputs of its answers except model text and design. */
static km_status register_question(km_design_study *s, int index, km_error *error) {
  km_text text = {0};
  char key[KM_SHA256_TEXT];
  km_identity_add_name(&text, km_version());
  add_question(&text, &s->def->questions[index]);
  km_status status = km_design_add_files(s, &s->def->questions[index], &text, error);
  if (status) {
    km_text_free(&text);
    return status;
  }
  km_identity_add_numbers(&text, &s->length, 1);
  km_text_add(&text, s->meshes);
  bool failed = text.failed;
  if (!failed)
    km_sha256(text.data, text.size, key);
  km_text_free(&text);
  return failed ? no_memory(error)
                : km_store_question(s->store, key, s->def->questions[index].name, &s->question_ids[index], error);
}

/* Opens the store under the hash of model and parameter paths, and registers the requests. */
static km_status open_store(km_design_study *s, const char *path, bool replace, km_error *error) {
  km_text text = {0}, what = {0};
  char identity[KM_SHA256_TEXT], model[KM_SHA256_TEXT] = "";
  if (s->bytes)
    km_sha256(s->bytes, s->size, model);
  km_identity_add_name(&text, model);
  km_text_format(&what, "%s %.12s with", s->def->model ? s->def->model : s->bytes ? "the model" : "a function", model);
  for (int p = 0; p < s->def->parameter_count; ++p) {
    km_identity_add_name(&text, s->def->parameters[p].path);
    km_text_format(&what, "%s %s", p ? "," : "", s->def->parameters[p].path);
  }
  if (!s->def->parameter_count)
    km_text_add(&what, " no parameters");
  km_status status = text.failed || what.failed ? no_memory(error) : KM_OK;
  if (!status) {
    km_sha256(text.data, text.size, identity);
    status = km_store_open(path, identity, what.data, replace, &s->store, error);
  }
  km_text_free(&text);
  km_text_free(&what);
  for (int q = 0; q < s->def->question_count && !status; ++q)
    status = register_question(s, q, error);
  return status;
}

/* Binds the model and opens the store. */
static km_status open_study(km_design_study *s, const char *store, bool replace, km_error *error) {
  const km_design_study_def *def = s->def;
  s->base = KM_ARENA_NEW(&s->arena, double, (size_t)def->parameter_count + 1);
  s->reference = KM_ARENA_NEW(&s->arena, double, (size_t)def->parameter_count + 1);
  if (def->sample)
    s->sampler = km_sampler_create(def->sample);
  if (s->arena.failed || (def->sample && !s->sampler))
    return no_memory(error);
  list_figures(s);
  km_design_clear(s, s->base);
  km_status status = def->function ? KM_OK : bind_model(s, error);
  if (!status && s->arena.failed)
    status = no_memory(error);
  return status ? status : open_store(s, store, replace, error);
}

km_status km_design_study_open(const km_design_study_def *def, const char *store, bool replace, km_design_study **out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(def != NULL, "definition of a study", error);
  if (!status)
    status = km_design_check(def, error);
  if (status)
    return status;
  km_design_study *s = KM_NEW(km_design_study, 1);
  if (!s)
    return no_memory(error);
  s->def = def;
  s->meshes = "";
  status = open_study(s, store, replace, error);
  if (status) {
    km_design_study_free(s);
    return status;
  }
  *out = s;
  return KM_OK;
}

void km_design_study_free(km_design_study *s) {
  if (!s)
    return;
  km_design_free_statistics(s);
  km_store_free(s->store);
  km_sampler_free(s->sampler);
  km_free(s->trail.values);
  km_free(s->trail.starts);
  km_arena_free(&s->arena);
  km_free(s);
}

int km_design_study_figures(const km_design_study *s) {
  return s ? s->figure_count : 0;
}

const km_design_figure *km_design_study_figure(const km_design_study *s, int figure) {
  return s && figure >= 0 && figure < s->figure_count ? s->figures[figure] : NULL;
}

const char *km_design_study_figure_unit(const km_design_study *s, int figure) {
  return s && figure >= 0 && figure < s->figure_count ? s->units[figure] : "";
}
