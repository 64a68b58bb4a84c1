/* Sweeps: the session's question over its motion, and how far a slider goes. */
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/inspect.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 5000, TRACK_STEPS = 48 };

/* Options that the kind of question doesn't have are left out. */
static bool has_option(int kind, const char *name) {
  const km_option *option;
  for (int i = 0; (option = km_question_option(kind, i)) != NULL; ++i)
    if (strcmp(option->name, name) == 0)
      return true;
  return false;
}

static bool has_two_surfaces(const km_model *model) {
  int count = 0;
  for (int b = 0; b <= km_model_body_count(model); ++b)
    count += km_body_patch_count(model, b) > 0;
  return count > 1;
}

/* True if the model has what a kind of question is about. */
static bool suits(const kv_session *s, int kind) {
  if (has_option(kind, "study"))
    return s->opening.study != NULL;
  bool is_clearance = strcmp(km_question_kind_name(kind), "clearance") == 0;
  return has_option(kind, "range") && (!is_clearance || has_two_surfaces(s->model));
}

int kv_question_kind(const kv_session *s, int index) {
  for (int kind = 0; kind < km_question_kinds(); ++kind)
    if (suits(s, kind) && index-- == 0)
      return kind;
  return -1;
}

static km_status set(km_question *question, int kind, const char *name, const km_option_value *value, km_error *error) {
  return has_option(kind, name) ? km_question_set(question, name, value, error) : KM_OK;
}

static km_status set_end(const kv_session *s, km_question *question, int kind, const char *name, int coordinate,
                         km_error *error) {
  km_option_value value = {.end = {.kind = KM_PORT_JOINT, .coordinate = coordinate}};
  value.end.name = km_model_coordinate_label(s->model, coordinate);
  return coordinate < 0 ? KM_OK : set(question, kind, name, &value, error);
}

static km_status make(const kv_session *s, const kv_asked *a, km_question **out, km_error *error) {
  km_option_value driver = {.coordinate = a->driver}, range = {.numbers = {a->from, a->to}};
  km_option_value steps = {.whole = a->steps}, length = {.numbers = {a->from}}, branch = {.whole = a->branch};
  km_option_value study = {.text = s->opening.study};
  km_status status = km_question_create(s->mechanism, km_question_kind_name(a->kind), out, error);
  if (!status && has_option(a->kind, "study")) /* it moves by the study's path, and by nothing else */
    return set(*out, a->kind, "study", &study, error);
  if (!status && a->driver >= 0)
    status = set(*out, a->kind, "joint", &driver, error);
  if (!status && a->driver >= 0)
    status = set(*out, a->kind, "range", &range, error);
  if (!status && a->driver < 0 && a->from > 0.0)
    status = set(*out, a->kind, "arclength", &length, error);
  if (!status)
    status = set(*out, a->kind, "steps", &steps, error);
  if (!status && a->driver < 0 && a->branch > 1)
    status = set(*out, a->kind, "branch", &branch, error);
  if (!status)
    status = set_end(s, *out, a->kind, "input", a->input, error);
  if (!status)
    status = set_end(s, *out, a->kind, "output", a->output, error);
  return status;
}

static km_status run(kv_session *s, km_question *question, km_error *error) {
  kv_limit limit = kv_limit_begin();
  km_question_observe(question, kv_limit_goes_on, &limit);
  km_status status = kv_session_probe(s, error);
  if (!status)
    status = km_question_compute(question, s->probe, error);
  km_question_observe(question, NULL, NULL);
  if (status == KM_CANCELLED)
    km_fail(error, KM_CANCELLED, "the sweep took more than %g s; ask for fewer steps", kv_most_seconds);
  return status == KM_PARTIAL ? KM_OK : status;
}

static void add_events(const km_question *question, km_text *out) {
  km_text_add(out, ",\"events\":[");
  for (int i = 0; i < km_question_event_count(question); ++i) {
    km_question_event e = km_question_event_at(question, i);
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, e.name);
    km_text_add(out, ",\"subject\":");
    kv_add_string(out, e.subject);
    km_text_add(out, ",\"s\":");
    kv_add_number(out, e.s);
    km_text_add(out, ",\"value\":");
    kv_add_number(out, e.value);
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

static void add_notes(const km_messages *notes, km_text *out) {
  km_text_add(out, ",\"notes\":[");
  for (size_t i = 0; i < km_messages_count(notes); ++i) {
    kv_add_comma(out);
    kv_add_string(out, km_messages_text(notes, i));
  }
  km_text_add(out, "]}");
}

/* Number of branches at the first branch point of a sweep by arc length; 0: none. */
static int count_branches(const km_question *question) {
  const km_sweep *motion = km_question_motion(question);
  return !motion                  ? 0
         : motion->start_branches ? motion->start_branches
         : motion->branch_count   ? motion->branches[0].branches
                                  : 0;
}

/* Reason why the sweep is shorter than requested; "" if it isn't. */
static void add_stop(const kv_session *s, const km_question *question, km_text *out) {
  const km_sweep *motion = km_question_motion(question);
  km_text text = {0};
  if (motion)
    km_sweep_stop_text(s->mechanism, km_question_plan(question), motion, &text);
  km_text_add(out, ",\"stopped\":");
  kv_add_string(out, text.data ? text.data : "");
  km_text_free(&text);
}

static km_status add_table(const kv_call *call, const kv_asked *a, const km_question *question, km_error *error) {
  const km_table *table = km_question_table(question);
  km_text header = {0};
  km_text_add(&header, "{\"question\":");
  kv_add_string(&header, km_question_kind_name(a->kind));
  km_text_format(&header, ",\"driver\":%d,\"branches\":%d", a->driver, count_branches(question));
  add_stop(call->session, question, &header);
  kv_add_columns(table, &header);
  add_events(question, &header);
  add_notes(km_question_notes(question), &header);
  km_status status = kv_add_table(call, &header, table, error);
  km_text_free(&header);
  return status;
}

static km_status answer(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_status status = s->question ? KM_OK : make(s, &s->asked, &s->question, error);
  if (!status)
    status = run(s, s->question, error);
  if (!status)
    return add_table(call, &s->asked, s->question, error);
  km_question_free(s->question);
  s->question = NULL;
  return status;
}

/* Message `ask KIND DRIVER FROM TO STEPS [INPUT OUTPUT [BRANCH]]`; INPUT, OUTPUT −1: none; DRIVER −1: by arc length
 * with step FROM (0: as the model states), at the first branch point along motion BRANCH. */
km_status kv_compute_question(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  const kv_asked asked = {.kind = kv_question_kind(s, kv_index(call, 0)),
                          .driver = kv_index(call, 1),
                          .from = call->arguments[2],
                          .to = call->arguments[3],
                          .steps = kv_index(call, 4),
                          .input = call->count > 5 ? kv_index(call, 5) : -1,
                          .output = call->count > 6 ? kv_index(call, 6) : -1,
                          .branch = call->count > 7 ? kv_index(call, 7) : 0};
  if (asked.steps > MOST_STEPS)
    return km_fail(error, KM_USAGE, "%d steps are more than a page shows; expected up to %d", asked.steps, MOST_STEPS);
  km_question_free(s->question);
  s->question = NULL;
  s->asked = asked;
  km_status status = answer(call, error);
  if (status)
    s->asked.kind = -1;
  return status;
}

/* again: the same question about the present design. */
km_status kv_recompute(const kv_call *call, km_error *error) {
  if (call->session->asked.kind < 0)
    return km_fail(error, KM_USAGE, "nothing was asked yet");
  return answer(call, error);
}

/* One way of a slider: how far it goes towards `to`, and the toggles of other joints on the way. */
static km_status go(const kv_call *call, int coordinate, double to, bool *first, km_error *error) {
  kv_session *s = call->session;
  km_text *out = &call->answer->bytes;
  const kv_asked way = {.kind = kv_question_kind(s, 0),
                        .driver = coordinate,
                        .from = km_state_coordinate(s->state, coordinate),
                        .to = to,
                        .steps = TRACK_STEPS,
                        .input = -1,
                        .output = -1};
  km_question *question = NULL;
  km_status status = way.from == to ? KM_OK : make(s, &way, &question, error);
  if (!status && question)
    status = run(s, question, error);
  for (int i = 0; !status && question && i < km_question_event_count(question); ++i) {
    km_question_event e = km_question_event_at(question, i);
    bool own = strcmp(e.subject, km_model_coordinate_label(s->model, coordinate)) == 0;
    if (strcmp(e.name, "minimum") == 0 || strcmp(e.name, "maximum") == 0)
      continue;
    if (!*first)
      km_text_add(out, ",");
    *first = false;
    km_text_add(out, "{\"name\":");
    kv_add_string(out, e.name);
    km_text_add(out, ",\"subject\":");
    kv_add_string(out, e.subject);
    km_text_format(out, ",\"own\":%s,\"s\":", own ? "true" : "false");
    kv_add_number(out, e.s);
    km_text_add(out, "}");
  }
  const km_sweep *motion = question ? km_question_motion(question) : NULL;
  if (motion && motion->end.stop) {
    if (!*first)
      km_text_add(out, ",");
    *first = false;
    km_text_format(out, "{\"name\":\"%s\",\"subject\":", motion->end.stop == KM_STOP_LIMIT ? "limit" : "end");
    kv_add_string(out, motion->end.coordinate >= 0 ? km_model_coordinate_label(s->model, motion->end.coordinate) : "");
    km_text_add(out, ",\"own\":true,\"s\":");
    kv_add_number(out, motion->end.position);
    km_text_add(out, "}");
  }
  km_question_free(question);
  return status;
}

/* track COORDINATE: what a slider meets on its way from the present pose to either side. */
km_status kv_track(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  int coordinate = kv_index(call, 0);
  double low, high, at = km_state_coordinate(s->state, coordinate);
  if (coordinate < 0 || coordinate >= km_model_coordinate_count(s->model))
    return km_fail(error, KM_USAGE, "there is no coordinate %d", coordinate);
  km_model_coordinate_limits(s->model, coordinate, &low, &high);
  const char *unit = km_model_coordinate_unit(s->model, coordinate);
  double turn = strcmp(unit, "deg") == 0   ? 180.0
                : strcmp(unit, "rad") == 0 ? 3.14159265358979
                                           : 2.0 * km_mechanism_characteristic_length(s->mechanism, NULL);
  low = fmax(low, at - turn);
  high = fmin(high, at + turn);
  bool first = true;
  km_text_format(&call->answer->bytes, "{\"kind\":\"track\",\"request\":%u,\"coordinate\":%d,\"low\":", call->request,
                 coordinate);
  kv_add_number(&call->answer->bytes, low);
  km_text_add(&call->answer->bytes, ",\"high\":");
  kv_add_number(&call->answer->bytes, high);
  km_text_add(&call->answer->bytes, ",\"events\":[");
  km_status status = low < at ? go(call, coordinate, low, &first, error) : KM_OK;
  if (!status && high > at)
    status = go(call, coordinate, high, &first, error);
  km_text_add(&call->answer->bytes, "]}");
  return status;
}
