/* Model of a design: the model file with the design's parameter values. */
#include "base/arguments.h"
#include "continuation/target_configuration.h"
#include "kmech/continuation.h"
#include "kmech/rounding.h"
#include "model/model.h"
#include "study/design_study.h"

#include <math.h>
#include <string.h>

void km_design_clear(const km_design_study *s, double *values) {
  for (int p = 0; p < s->def->parameter_count; ++p)
    values[p] = nan("");
}

bool km_design_is_reference(const km_design_study *s, const double *values) {
  return memcmp(values, s->reference, (size_t)s->def->parameter_count * sizeof *values) == 0;
}

/* Assignments for the reader of the parameters that the design states. */
static int assignments_of(const km_design_study *s, const double *values, km_assignment *out) {
  int count = 0;
  for (int p = 0; p < s->def->parameter_count; ++p)
    if (!isnan(values[p]))
      out[count++] = (km_assignment){s->def->parameters[p].path, values[p]};
  return count;
}

km_status km_design_read_model(const km_design_study *s, const double *values, km_model **out, km_error *error) {
  km_assignment assignments[KM_MAX_DESIGN_PARAMETERS];
  km_read_def definition = {
      .file = s->def->model, .assignments = assignments, .assignment_count = assignments_of(s, values, assignments)};
  km_status status = km_model_read_as(s->bytes, s->size, &definition, NULL, out, error);
  if (!status)
    status = km_model_idealise(*out, false, NULL, NULL, error);
  if (!status && s->length > 0.0 && !km_design_is_reference(s, values)) {
    double unit = km_model_length_unit(*out);
    km_model_share_length(*out, s->length * unit / unit);
  }
  return status;
}

/* Held and set coordinates of a request, including the model's own holds. */
typedef struct held_and_set {
  km_hold *holds, *sets;
  int hold_count, set_count;
} held_and_set;

static void free_held_and_set(held_and_set *g) {
  km_free(g->holds);
  km_free(g->sets);
}

/* Finds the held and set coordinates; free them in any case. */
static km_status find_held_and_set(const km_model *m, const km_design_question *q, held_and_set *g, km_error *error) {
  *g = (held_and_set){.holds = KM_NEW(km_hold, (size_t)(m->coordinate_count + m->hold_count) + 1),
                      .sets = KM_NEW(km_hold, (size_t)m->coordinate_count + 1)};
  if (!g->holds || !g->sets)
    return km_fail(error, KM_MEMORY, "out of memory while moving to a pose");
  for (int h = 0; h < m->hold_count; ++h)
    g->holds[g->hold_count++] = (km_hold){m->holds[h].coordinate, m->holds[h].value};
  km_status status = km_design_settings(m, q->holds, q->hold_count, "hold", g->holds, &g->hold_count, error);
  if (!status)
    status = km_design_settings(m, q->sets, q->set_count, "set", g->sets, &g->set_count, error);
  for (int i = 0; i < g->set_count && !status; ++i)
    for (int k = 0; k < g->hold_count && !status; ++k)
      if (g->sets[i].coordinate == g->holds[k].coordinate)
        status = km_fail(error, KM_USAGE, "set: \"%s\" is held; expected a joint that is free to move",
                         km_model_coordinate_label(m, g->sets[i].coordinate));
  return status;
}

km_status km_design_compile_at(const km_model *m, const km_design_question *q, km_mechanism **mechanism,
                               km_state **state, km_error *error) {
  held_and_set g;
  km_status status = find_held_and_set(m, q, &g, error);
  if (!status)
    status = km_mechanism_compile_at(m, g.holds, g.hold_count, g.sets, g.set_count, mechanism, state, error);
  free_held_and_set(&g);
  return status;
}

km_status km_design_recompile_at(const km_mechanism *free, km_state *there, const km_design_question *q,
                                 km_mechanism **held, km_state **at, km_error *error) {
  held_and_set g;
  km_status status = find_held_and_set(free->model, q, &g, error);
  if (!status)
    status = km_mechanism_recompile_at(free, there, g.holds, g.hold_count, g.sets, g.set_count, held, at, error);
  free_held_and_set(&g);
  return status;
}

km_status km_design_study_model(const km_design_study *s, int design, km_model **out, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_status status = km_check_given(s && out, "study or place for its model", error);
  if (out)
    *out = NULL;
  if (!status && !s->bytes)
    status = km_fail(error, KM_USAGE, "the study is about a function; it has no model");
  if (!status)
    status = km_design_study_values(s, design, values, error);
  return status ? status : km_design_read_model(s, values, out, error);
}

void km_evaluated_design_free(km_evaluated_design *a) {
  if (!a)
    return;
  km_question_free(a->question);
  km_state_free(a->state);
  km_mechanism_free(a->mechanism);
  km_model_free(a->model);
  *a = (km_evaluated_design){0};
}

km_status km_design_study_evaluate(const km_design_study *s, int design, int question, km_evaluated_design *out,
                                   km_error *error) {
  if (!out)
    return km_check_given(false, "place for the answer", error);
  *out = (km_evaluated_design){0};
  km_status status = km_design_study_model(s, design, &out->model, error);
  if (!status)
    status = km_check_index(question, s->def->question_count, "question", error);
  if (status)
    return status;
  const km_design_question *q = &s->def->questions[question];
  status = km_design_compile_at(out->model, q, &out->mechanism, &out->state, error);
  if (!status)
    status = km_question_create(out->mechanism, q->kind, &out->question, error);
  if (!status)
    status = km_design_set_options(s->def, q, out->model, out->question, error);
  return status ? status : km_question_compute(out->question, out->state, error);
}
