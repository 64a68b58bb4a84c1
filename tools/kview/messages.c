/* Messages of a page: NUMBER VERB ARGUMENT…, read strictly and answered one by one. */
#include "kview/messages.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Largest displacement of a pull in one message, in radians and characteristic lengths. */
static const double most_way = 0.35;

int kv_index(const kv_call *call, int argument) {
  double value = argument < call->count ? call->arguments[argument] : -1.0;
  return value >= 0.0 && value < 1e9 && value == floor(value) ? (int)value : -1;
}

void kv_add_error(unsigned request, const km_error *error, km_text *out) {
  km_text_format(out, "{\"kind\":\"error\",\"request\":%u,\"text\":", request);
  kv_add_string(out, error->text);
  km_text_add(out, "}");
}

static km_status give_pose(const kv_call *c) {
  c->answer->binary = true;
  kv_add_pose(c->session, c->request, &c->answer->bytes);
  return KM_OK;
}

/* The answer to what changed the model: its description. */
static km_status describe_changed(const kv_call *c, km_status status) {
  if (!status)
    kv_describe(c->session, c->request, &c->answer->bytes);
  return status;
}

static km_status hello(const kv_call *c, km_error *error) {
  if (kv_index(c, 0) != KV_PROTOCOL)
    return km_fail(error, KM_USAGE, "this server speaks version %d of the protocol", KV_PROTOCOL);
  kv_describe(c->session, c->request, &c->answer->bytes);
  return KM_OK;
}

static km_status pose(const kv_call *c, km_error *error) {
  (void)error;
  return give_pose(c);
}

/* joint COORDINATE TARGET [WAY] */
static km_status pull_joint(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  double way = c->count > 2 && c->arguments[2] > 0.0 ? c->arguments[2] : most_way;
  km_status status = km_manipulation_pull_joint(s->hand, kv_index(c, 0), c->arguments[1], way, &s->move, error);
  if (status)
    return status;
  kv_session_follow(s);
  return give_pose(c);
}

/* point BODY x y z X Y Z nx ny nz: the point in the body's frame, the target, the normal of the view. */
static km_status pull_point(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  km_manipulation_point grip = {.body = kv_index(c, 0)};
  memcpy(grip.point, c->arguments + 1, sizeof grip.point);
  memcpy(grip.target, c->arguments + 4, sizeof grip.target);
  memcpy(grip.normal, c->arguments + 7, sizeof grip.normal);
  double size =
      sqrt(grip.normal[0] * grip.normal[0] + grip.normal[1] * grip.normal[1] + grip.normal[2] * grip.normal[2]);
  for (int k = 0; k < 3 && size > 0.0; ++k)
    grip.normal[k] /= size;
  km_status status = km_manipulation_pull_point(s->hand, &grip, most_way, &s->move, error);
  if (status)
    return status;
  kv_session_follow(s);
  return give_pose(c);
}

/* place q…: every coordinate; the loops close next to them. */
static km_status place(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  int n = km_model_coordinate_count(s->model);
  if (c->count != n)
    return km_fail(error, KM_USAGE, "found %d values; expected one for each of the %d coordinates", c->count, n);
  km_status status = kv_session_place(s, c->arguments, error);
  s->move = (km_manipulation_step){.coordinate = -1, .is_reached = true};
  return status ? status : give_pose(c);
}

/* hold COORDINATE 0|1 */
static km_status hold(const kv_call *c, km_error *error) {
  km_status status = kv_session_hold(c->session, kv_index(c, 0), c->arguments[1] != 0.0, error);
  return describe_changed(c, status); /* loops and substructures are others */
}

static km_status mark(const kv_call *c, km_error *error) {
  km_status status = kv_session_mark(c->session, error);
  return status ? status : give_pose(c);
}

/* undo -1|1 */
static km_status undo(const kv_call *c, km_error *error) {
  km_status status = kv_session_step(c->session, c->arguments[0] < 0.0 ? -1 : 1, error);
  c->session->move = (km_manipulation_step){.coordinate = -1, .is_reached = true};
  return status ? status : give_pose(c);
}

/* pivot JOINT X Y Z, in the inertial frame */
static km_status pivot(const kv_call *c, km_error *error) {
  km_status status = kv_session_move_pivot(c->session, kv_index(c, 0), c->arguments + 1, error);
  return describe_changed(c, status);
}

/* frame FRAME x y z, in its body */
static km_status frame(const kv_call *c, km_error *error) {
  km_status status = kv_session_move_frame(c->session, kv_index(c, 0), c->arguments + 1, error);
  return describe_changed(c, status);
}

/* design T…: three numbers a frame */
static km_status design(const kv_call *c, km_error *error) {
  int n = 3 * km_model_frame_count(c->session->model);
  if (c->count != n)
    return km_fail(error, KM_USAGE, "found %d numbers; expected %d, three for each frame", c->count, n);
  km_status status = kv_session_set_design(c->session, c->arguments, NULL, error);
  return describe_changed(c, status);
}

static km_status reload(const kv_call *c, km_error *error) {
  km_status status = kv_session_load(c->session, error);
  return describe_changed(c, status);
}

static const struct {
  const char *word;
  int least, most; /* arguments */
  kv_verb *run;
} verbs[] = {
    {"hello", 1, 1, hello},
    {"pose", 0, 0, pose},
    {"joint", 2, 3, pull_joint},
    {"point", 10, 10, pull_point},
    {"place", 0, KV_MOST_ARGUMENTS, place},
    {"named", 1, 1, kv_named},
    {"hold", 2, 2, hold},
    {"mark", 0, 0, mark},
    {"undo", 1, 1, undo},
    {"ask", 5, 8, kv_compute_question},
    {"again", 0, 0, kv_recompute},
    {"track", 1, 1, kv_track},
    {"motions", 0, 0, kv_motions},
    {"diagnose", 0, 0, kv_diagnose},
    {"forces", 0, 0, kv_forces},
    {"lever", 2, 2, kv_lever},
    {"map", 7, 8, kv_map},
    {"mapping", 7, 8, kv_mapping},
    {"mapped", 0, 0, kv_mapped},
    {"stop", 0, 0, kv_stop},
    {"singular", 0, 0, kv_singular},
    {"boundary", 0, 0, kv_boundary},
    {"modes", 1, 1, kv_modes},
    {"mode", 1, 1, kv_mode},
    {"selfmotion", 1, 1, kv_selfmotion},
    {"columns", 2, 2, kv_columns},
    {"pivot", 4, 4, pivot},
    {"frame", 4, 4, frame},
    {"design", 0, KV_MOST_ARGUMENTS, design},
    {"parameters", 1, KV_MOST_ARGUMENTS, kv_set_parameters},
    {"patch", 2, 2, kv_patch},
    {"write", 0, 0, kv_write},
    {"reload", 0, 0, reload},
};
enum { VERBS = (int)(sizeof verbs / sizeof *verbs) };

static char *skip(char *at) {
  while (*at == ' ')
    ++at;
  return at;
}

/* The arguments behind a verb into `out`; -1: one isn't a finite number, or there are too many. */
static int read_arguments(char *at, double *out) {
  int count = 0;
  for (at = skip(at); *at; at = skip(at)) {
    char *end;
    double value = strtod(at, &end);
    if (end == at || (*end && *end != ' ') || !isfinite(value) || count == KV_MOST_ARGUMENTS)
      return -1;
    out[count++] = value;
    at = end;
  }
  return count;
}

static km_status answer(kv_session *s, char *text, double *arguments, kv_call *call, km_error *error) {
  char *at = text;
  if (!isdigit((unsigned char)*at))
    return km_fail(error, KM_USAGE, "a message begins with its number");
  call->request = (unsigned)strtoul(at, &at, 10);
  at = skip(at);
  size_t length = strcspn(at, " ");
  int verb = VERBS - 1;
  while (verb >= 0 && (strlen(verbs[verb].word) != length || memcmp(verbs[verb].word, at, length) != 0))
    --verb;
  if (verb < 0)
    return km_fail(error, KM_USAGE, "\"%.*s\" is not a verb", (int)(length < 40 ? length : 40), at);
  call->count = read_arguments(at + length, arguments);
  if (call->count < 0)
    return km_fail(error, KM_USAGE, "%s: an argument isn't a finite number, or there are too many", verbs[verb].word);
  if (call->count < verbs[verb].least || call->count > verbs[verb].most)
    return km_fail(error, KM_USAGE, "%s: expected %d to %d numbers", verbs[verb].word, verbs[verb].least,
                   verbs[verb].most);
  if (!s->model)
    return km_fail(error, KM_USAGE, "no model is open");
  return verbs[verb].run(call, error);
}

void kv_answer_message(kv_session *s, const char *message, size_t size, kv_answer *out) {
  *out = (kv_answer){0};
  bool fits = size <= KV_MOST_MESSAGE;
  char *text = malloc(fits ? size + 1 : 1);
  double *arguments = malloc(fits ? (size / 2 + 2) * sizeof *arguments : 1);
  kv_call call = {.session = s, .arguments = arguments, .answer = out};
  km_status status = KM_OK;
  if (!text || !arguments)
    status = km_fail(&out->fault, KM_MEMORY, "out of memory");
  else if (!fits)
    status = km_fail(&out->fault, KM_USAGE, "a message of more than %d bytes", KV_MOST_MESSAGE);
  else if (memchr(message, '\0', size))
    status = km_fail(&out->fault, KM_USAGE, "a message with a NUL in it");
  if (!status) {
    memcpy(text, message, size);
    text[size] = '\0';
    status = answer(s, text, arguments, &call, &out->fault);
  }
  free(text);
  free(arguments);
  if (!status && !out->bytes.failed) {
    out->fault = (km_error){0};
    return;
  }
  km_text_free(&out->bytes);
  out->binary = false;
  if (!status)
    km_fail(&out->fault, KM_MEMORY, "out of memory");
  kv_add_error(call.request, &out->fault, &out->bytes);
}
