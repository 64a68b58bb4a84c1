/* The options that say what arm, path and methods are meant; and how they become a study. */
#include "kredund/kredund.h"

#include "base/file.h"
#include "base/memory.h"
#include "exchange/json/json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
  OPTION_MODEL = 0x2001,
  OPTION_PATH,
  OPTION_EFFECTOR,
  OPTION_Q,
  OPTION_TASK,
  OPTION_METHOD,
  OPTION_OBJECTIVE,
  OPTION_RATES,
  OPTION_BRANCHES,
  OPTION_LEVELS,
  OPTION_ANGLE,
  OPTION_STRIDE,
  OPTION_VALUE,
  OPTION_SET,
  OPTION_HOLD
};

static const struct argp_option table[] = {
    {"model", OPTION_MODEL, "FILE", 0, "The arm's model, instead of a study's", 1},
    {"path", OPTION_PATH, "FILE", 0, "The path: a study, its \"path\" object, or a CSV file of poses", 1},
    {"effector", OPTION_EFFECTOR, "BODY/FRAME", 0, "The frame that follows the path", 1},
    {"q", OPTION_Q, "Q1,Q2,…", 0, "Joint values to start from, in the study's order or from the base out", 1},
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Move a joint of the model to a value first", 1},
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint of the model rigid at a value", 1},
    {"task", OPTION_TASK, "TASK", 0, "pose (default), position, or axis (position and the z axis)", 1},
    {"objective", OPTION_OBJECTIVE, "NAME", 0,
     "path-control, manipulability, singular-value, limit-distance, joint-travel, rate-margin; or NAME=WEIGHT,…", 1},
    {"rates", OPTION_RATES, "V1,V2,…", 0, "Largest joint speeds, in the order of --q", 1},
    {0}};

static const struct argp_option method_table[] = {
    {"method", OPTION_METHOD, "M,…", 0,
     "greedy (or pinv), lookahead, fixed, dls, gradient, dp, global: instead of the study's", 1},
    {"branches", OPTION_BRANCHES, "N", 0, "Look-ahead: branches at a node, odd (3)", 2},
    {"levels", OPTION_LEVELS, "N", 0, "Look-ahead: levels of the tree (3)", 2},
    {"angle", OPTION_ANGLE, "DEGREES", 0, "Look-ahead: between branches (30); most of gradient, dp and global", 2},
    {"stride", OPTION_STRIDE, "N", 0, "Look-ahead: samples a level (1/12 of the path); dp: a stage (1/24)", 2},
    {"value", OPTION_VALUE, "WORD", 0, "Look-ahead: a leaf's value, min (default) or sum", 2},
    {0}};

/* Options of either table that are a text to keep. */
static bool keep(kredund_request *r, int key, char *arg) {
  const struct {
    int key;
    const char **at;
  } plain[] = {{OPTION_MODEL, &r->model},         {OPTION_PATH, &r->path},
               {OPTION_EFFECTOR, &r->effector},   {OPTION_Q, &r->q},
               {OPTION_TASK, &r->task},           {OPTION_METHOD, &r->methods},
               {OPTION_OBJECTIVE, &r->objective}, {OPTION_RATES, &r->rates},
               {OPTION_BRANCHES, &r->branches},   {OPTION_LEVELS, &r->levels},
               {OPTION_ANGLE, &r->angle},         {OPTION_STRIDE, &r->stride},
               {OPTION_VALUE, &r->value}};
  for (size_t i = 0; i < sizeof plain / sizeof *plain; ++i)
    if (plain[i].key == key) {
      *plain[i].at = arg;
      return true;
    }
  return false;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
  kredund_request *r = state->input;
  if (keep(r, key, arg))
    return 0;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &r->common;
    return 0;
  case OPTION_SET:
    kt_texts_add(&r->sets, arg, state);
    return 0;
  case OPTION_HOLD:
    kt_texts_add(&r->holds, arg, state);
    return 0;
  case ARGP_KEY_ARG:
    if (r->study)
      argp_error(state, "found a second study \"%s\"; expected one", arg);
    r->study = arg;
    return 0;
  case ARGP_KEY_END:
    if (!r->study && !r->model)
      argp_error(state, "found neither a study nor --model; expected one of them");
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

static error_t parse_methods(int key, char *arg, struct argp_state *state) {
  if (key == ARGP_KEY_INIT)
    state->child_inputs[0] = state->input;
  return keep(state->input, key, arg) ? 0 : ARGP_ERR_UNKNOWN;
}

static const struct argp_child common_children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
const struct argp kredund_request_argp = {.options = table, .parser = parse, .children = common_children};
static const struct argp_child request_children[] = {{&kredund_request_argp, 0, NULL, 0}, {0}};
const struct argp kredund_methods_argp = {
    .options = method_table, .parser = parse_methods, .children = request_children};

static void folder_of(const char *path, char *out, size_t size) {
  const char *slash = strrchr(path, '/');
  snprintf(out, size, "%.*s", slash ? (int)(slash - path) : 0, path);
  if (slash == path)
    snprintf(out, size, "/");
}

/* --path: poses, a study or its path object. */
static const km_value *read_path(kredund_open *open, const kredund_request *r, const char **folder, kt_exit *exit) {
  size_t length = strlen(r->path);
  char text[4096];
  if (length > 4 && strcmp(r->path + length - 4, ".csv") == 0) {
    km_value *object = km_value_add(&open->arena, NULL, NULL, KM_OBJECT);
    km_value_string(&open->arena, object, "csv", r->path);
    *folder = "";
    return object;
  }
  km_text bytes = {0};
  km_error error;
  const km_value *root = NULL;
  km_status status = km_file_read(r->path, &bytes, &error);
  if (!status)
    status = km_json_parse(bytes.data, bytes.size, &open->arena, &root, &error);
  km_text_free(&bytes);
  if (status) {
    kt_say(&r->common, KM_ERROR, "%s%s%s", status == KM_IO ? "" : r->path, status == KM_IO ? "" : ": ", error.text);
    *exit = kt_exit_of(status);
    return NULL;
  }
  folder_of(r->path, text, sizeof text);
  *folder = km_arena_string(&open->arena, text);
  const km_value *inner = km_value_get(root, "path");
  return inner ? inner : root;
}

/* What the reader found, with the file in front. */
static kt_exit tell(const kt_common *common, const char *name, const km_messages *messages, km_status status,
                    const char *text) {
  bool told = false;
  for (size_t i = 0; i < km_messages_count(messages); ++i) {
    km_severity severity = km_messages_severity(messages, i);
    kt_say(common, severity, "%s: %s", name, km_messages_text(messages, i));
    told = told || severity == KM_ERROR;
  }
  if (status && !told)
    kt_say(common, KM_ERROR, "%s: %s", name, text);
  return kt_exit_of(status);
}

static bool is_model(kredund_open *out, const km_text *text) {
  const km_value *root = NULL;
  return text->data && !km_json_parse(text->data, text->size, &out->arena, &root, NULL) &&
         km_value_get(root, "assemblies") && !km_value_get(root, "model") && !km_value_get(root, "path");
}

static kt_exit read_study(const kredund_request *r, kredund_open *out) {
  km_text text = {0};
  km_error error;
  km_messages *messages = km_messages_create();
  char folder[4096] = "";
  km_status status = KM_OK;
  if (r->study)
    status = km_file_read(r->study, &text, &error);
  else
    km_text_add(&text, "{}");
  if (status) {
    kt_say(&r->common, KM_ERROR, "%s", error.text);
  } else if (is_model(out, &text)) {
    kt_say(&r->common, KM_ERROR, "%s is a model, not a path study; expected a study, or the model as --model %s",
           out->name, r->study);
    status = KM_USAGE;
  } else {
    if (r->study && strcmp(r->study, "-") != 0)
      folder_of(r->study, folder, sizeof folder);
    status = km_study_read(text.data ? text.data : "", text.size, folder, messages, &out->study, &error);
    tell(&r->common, out->name, messages, status, error.text);
  }
  km_messages_free(messages);
  km_text_free(&text);
  return kt_exit_of(status);
}

/* Files are named after the study: its file's name without ending, or its folder's where the file is called study.json;
 * without a file, after the model. */
static void name_base(const char *study, kredund_open *out) {
  kt_base_name(out->model, out->model_name, sizeof out->model_name);
  kt_base_name(study && strcmp(study, "-") != 0 ? study : out->model, out->base, sizeof out->base);
  const char *slash = study ? strrchr(study, '/') : NULL;
  if (!study || strcmp(slash ? slash + 1 : study, "study.json") != 0)
    return;
  char *whole = realpath(study, NULL), *end = whole ? strrchr(whole, '/') : NULL;
  if (end)
    *end = '\0';
  const char *folder = whole ? strrchr(whole, '/') : NULL;
  if (folder && folder[1])
    snprintf(out->base, sizeof out->base, "%s", folder + 1);
  free(whole); /* the C library's */
}

static kt_exit find_model(const kredund_request *r, kredund_open *out) {
  const char *written = km_study_model(out->study), *folder = out->study->folder;
  if (r->model)
    snprintf(out->model, sizeof out->model, "%s", r->model);
  else if (written)
    snprintf(out->model, sizeof out->model, "%s%s%s", written[0] == '/' || !folder[0] ? "" : folder,
             written[0] == '/' || !folder[0] ? "" : "/", written);
  else {
    kt_say(&r->common, KM_ERROR, "%s: model: is missing; expected the arm's model file, or --model", out->name);
    return KT_BAD_MODEL;
  }
  name_base(r->study, out);
  return KT_DONE;
}

static kt_exit gather_changes(const kredund_request *r, kredund_open *out, km_study_changes *c) {
  kt_exit exit = KT_DONE;
  c->effector = -1;
  if (r->effector)
    exit = kt_frame(&r->common, out->pose.model, "--effector", r->effector, &c->effector);
  if (r->q && exit == KT_DONE)
    c->q0 = (km_study_change){kredund_as_list(out, r->q, true, &r->common, "--q", &exit), "--q"};
  if (r->rates && exit == KT_DONE)
    c->rates = (km_study_change){kredund_as_list(out, r->rates, true, &r->common, "--rates", &exit), "--rates"};
  if (r->task)
    c->task = (km_study_change){km_value_string(&out->arena, NULL, NULL, r->task), "--task"};
  if (r->objective && exit == KT_DONE)
    c->objective = (km_study_change){kredund_as_objective(out, r->objective, &r->common, &exit), "--objective"};
  if (exit == KT_DONE)
    c->methods = (km_study_change){kredund_as_methods(out, r, &exit), r->methods ? "--method" : "methods"};
  if (r->path && exit == KT_DONE)
    c->path = (km_study_change){read_path(out, r, &c->path_folder, &exit), "--path"};
  return out->arena.failed ? KT_INTERNAL : exit;
}

static void note_start(const kredund_request *r, const kredund_open *out) {
  const km_study *s = out->study;
  if (s->path && !s->start_status && s->start_moved > 1e-6)
    kt_say(&r->common, KM_NOTE,
           "%s: the starting pose isn't at the path's first pose; inverse kinematics moves it by up to "
           "%.3g",
           out->name, s->start_moved);
}

/* Is --path a whole study? Then it says everything that the options don't. */
static bool is_study(const char *path) {
  km_text bytes = {0};
  km_arena arena = {0};
  const km_value *root = NULL;
  bool found = km_file_read(path, &bytes, NULL) == KM_OK &&
               km_json_parse(bytes.data ? bytes.data : "", bytes.size, &arena, &root, NULL) == KM_OK &&
               km_value_get(root, "path");
  km_text_free(&bytes);
  km_arena_free(&arena);
  return found;
}

static kt_exit bring(const kredund_request *r, bool needs_path, kredund_open *out) {
  *out = (kredund_open){.name = r->study ? strcmp(r->study, "-") == 0 ? "standard input" : r->study : r->model};
  km_study_changes changes = {.path_optional = !needs_path};
  kt_exit result = read_study(r, out);
  if (result == KT_DONE)
    result = find_model(r, out);
  if (result == KT_DONE)
    result = kt_open(&r->common, out->model, &r->holds, &r->sets, &out->pose);
  if (result == KT_DONE)
    result = gather_changes(r, out, &changes);
  if (result != KT_DONE)
    return result;
  km_error error;
  km_messages *messages = km_messages_create();
  km_status status =
      km_study_bind_as(out->study, out->pose.mechanism, out->pose.state, &changes, r->common.seed, messages, &error);
  result = tell(&r->common, out->name, messages, status == KM_NO_RESULT ? KM_OK : status, error.text);
  km_messages_free(messages);
  if (!r->study && result == KT_BAD_MODEL)
    result = KT_USAGE; /* there is no file that could be bad */
  if (result == KT_DONE)
    note_start(r, out);
  return result;
}

kt_exit kredund_bring(const kredund_request *given, bool needs_path, kredund_open *out) {
  kredund_request r = *given;
  if (!r.study && r.path && strcmp(r.path, "-") != 0 && is_study(r.path)) {
    r.study = r.path;
    r.path = NULL;
  }
  return bring(&r, needs_path, out);
}

void kredund_close(kredund_open *open) {
  km_study_free(open->study);
  kt_close(&open->pose);
  km_arena_free(&open->arena);
}
