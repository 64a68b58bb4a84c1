/* The options that say what arm, path and methods are meant; and how they become a study. */
#include "kredund/kredund.h"

#include "kmech/base.h"
#include "kmech/data.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void kredund_arm_options(kt_options *out, kredund_request *r) {
  const kt_option table[] = {
      {"model", 0, "FILE", "The arm's model, instead of a study's", KT_INPUT, &r->model, KT_ABOUT_MODEL},
      {"path", 0, "FILE", "The path: a study, its \"path\" object, or a CSV file of poses", KT_INPUT, &r->path,
       KT_ABOUT_MODEL},
      {"effector", 0, "BODY/FRAME", "The frame that follows the path", KT_TEXT, &r->effector, KT_ABOUT_MODEL},
      {"q", 0, "Q1,Q2,…", "Joint values to start from, in the study's order or from the base out", KT_TEXT, &r->q,
       KT_ABOUT_MODEL},
      KT_SET(&r->sets, "Move a joint of the model to a value first"),
      KT_HOLD(&r->holds, "Keep a joint of the model rigid at a value"),
      {"task", 0, "TASK", "pose (default), position, or axis (position and the z axis)",
       KT_TEXT_OF("pose or position or axis"), &r->task, KT_ABOUT_MODEL},
      {"objective", 0, "NAME",
       "What is made large: path-control, manipulability, singular-value, limit-distance, joint-travel, rate-margin, clearance; or "
       "small, by inverse dynamics: effort, relative-effort, energy, positive-work; or NAME=WEIGHT,…",
       KT_TEXT_OF(
           "path-control or manipulability or singular-value or limit-distance or joint-travel or rate-margin or clearance or "
           "effort or relative-effort or energy or positive-work"),
       &r->objective, KT_ABOUT_MODEL},
      {"rates", 0, "V1,V2,…", "Largest joint speeds, in the order of --q", KT_TEXT, &r->rates, KT_ABOUT_MODEL},
  };
  KT_OPTIONS_ADD(out, table);
  out->operand = (kt_operand){"study", "STUDY", false, &r->study, NULL};
}

void kredund_method_options(kt_options *out, kredund_request *r) {
  const kt_option table[] = {
      {"method", 0, "M,…", "greedy (or pinv), lookahead, fixed, dls, gradient, dp, global: instead of the study's",
       KT_TEXT_OF("greedy or pinv or lookahead or fixed or dls or gradient or dp or global"), &r->methods,
       KT_ABOUT_MODEL},
      {"branches", 0, "N", "Look-ahead: branches at a node, odd (3)", KT_TEXT, &r->branches, KT_ABOUT_METHOD},
      {"levels", 0, "N", "Look-ahead: levels of the tree (3)", KT_TEXT, &r->levels, KT_ABOUT_METHOD},
      {"angle", 0, "DEGREES", "Look-ahead: between branches (30); most of gradient, dp and global", KT_TEXT, &r->angle,
       KT_ABOUT_METHOD},
      {"stride", 0, "N", "Look-ahead: samples a level (1/12 of the path); dp: a stage (1/24)", KT_TEXT, &r->stride,
       KT_ABOUT_METHOD},
      {"value", 0, "WORD", "Look-ahead: a leaf's value, min (default) or sum", KT_TEXT_OF("min or sum"), &r->value,
       KT_ABOUT_METHOD},
  };
  KT_OPTIONS_ADD(out, table);
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
  km_status status = km_file_read(r->study, &text, &error);
  if (status) {
    kt_print_message(&r->common, KM_ERROR, "%s", error.text);
  } else if (is_model(out, &text)) {
    kt_print_message(&r->common, KM_ERROR,
                     "%s is a model, not a path study; expected a study, or the model as --model %s", out->name,
                     r->study);
    status = KM_USAGE;
  } else {
    status = km_study_read(text.data ? text.data : "", text.size, out->folder, messages, &out->def, &error);
    kt_report_messages(&r->common, out->name, messages, status, error.text);
  }
  km_messages_free(messages);
  km_text_free(&text);
  return kt_exit_of(status);
}

static kt_exit find_model(const kredund_request *r, kredund_open *out) {
  const char *written = out->def.model, *folder = out->folder;
  if (r->model)
    snprintf(out->model, sizeof out->model, "%s", r->model);
  else if (written)
    snprintf(out->model, sizeof out->model, "%s%s%s", written[0] == '/' || !folder[0] ? "" : folder,
             written[0] == '/' || !folder[0] ? "" : "/", written);
  else {
    kt_print_message(&r->common, KM_ERROR, "%s: model: found none; expected the arm's model file, or --model",
                     out->name);
    return KT_BAD_MODEL;
  }
  if (!r->model && access(out->model, R_OK) != 0) {
    kt_print_message(&r->common, KM_ERROR, "%s: model: %s: can't be opened: %s", out->name, out->model,
                     strerror(errno));
    return KT_USAGE;
  }
  kt_input(out->model);
  kt_base_name(out->model, out->model_name, sizeof out->model_name);
  kt_study_base(r->study, out->model, out->base, sizeof out->base);
  return KT_DONE;
}

double *kredund_start(const kredund_request *r, const kredund_open *open, kt_exit *exit) {
  km_error error;
  double *q = KM_NEW(double, (size_t)km_arm_coordinates(km_study_arm(open->study)) + 1);
  km_status status = q ? km_study_start(open->study, q, NULL, &error) : km_fail(&error, KM_MEMORY, "out of memory");
  *exit = kt_exit_of(status);
  if (!status)
    return q;
  kt_print_message(&r->common, KM_ERROR, "%s: %s", open->name, error.text);
  km_free(q);
  return NULL;
}

static void note_start(const kredund_request *r, const kredund_open *out) {
  double moved = 0.0;
  if (km_study_bound_path(out->study) && !km_study_start(out->study, NULL, &moved, NULL) && moved > 1e-6)
    kt_print_message(&r->common, KM_NOTE,
                     "%s: the starting pose isn't at the path's first pose; inverse kinematics moves it by up to "
                     "%.3g rad (slides: over L)",
                     out->name, moved);
}

/* True if --path is a complete study, which then states everything that the options don't. */
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

/* The options' say, then the study on its model. */
static kt_exit bind(const kredund_request *r, kredund_open *out) {
  km_error error;
  km_messages *messages = km_messages_create();
  kt_exit result = kredund_set_parts(r, out, messages);
  if (out->def.path.file)
    kt_input(out->def.path.file);
  km_status status = KM_OK;
  if (result == KT_DONE) {
    status =
        km_study_bind(out->pose.mechanism, out->pose.state, &out->def, r->common.seed, messages, &out->study, &error);
    status = status == KM_NO_RESULT ? KM_OK : status;
  }
  kt_exit told = kt_report_messages(&r->common, out->name, messages, status, error.text);
  km_messages_free(messages);
  return result == KT_DONE ? told : result;
}

static kt_exit move_to_request(const kredund_request *r, bool needs_path, kredund_open *out) {
  out->name = r->study ? strcmp(r->study, "-") == 0 ? "standard input" : r->study : r->model;
  char folder[4096] = "";
  if (r->study && strcmp(r->study, "-") != 0)
    kt_folder_of(r->study, folder, sizeof folder);
  out->folder = km_arena_string(&out->arena, folder);
  if (!out->folder)
    return KT_NO_MEMORY;
  out->def.path_optional = !needs_path;
  kredund_claim_parts(r, &out->def);
  kt_exit result = r->study ? read_study(r, out) : KT_DONE;
  if (result == KT_DONE)
    result = find_model(r, out);
  if (result == KT_DONE)
    result = kt_open_varied(&r->common, out->model, r->values, r->value_count, &r->holds, &r->sets, &out->pose);
  if (result != KT_DONE)
    return result;
  result = bind(r, out);
  if (!r->study && result == KT_BAD_MODEL)
    result = KT_USAGE; /* there is no file that could be bad */
  if (result == KT_DONE)
    note_start(r, out);
  return result;
}

kt_exit kredund_bind(const kredund_request *given, bool needs_path, kredund_open *out) {
  kredund_request r = *given;
  *out = (kredund_open){.def = km_study_def_default()};
  if (!r.study && !r.model) {
    kt_print_message(&r.common, KM_ERROR, "found neither a study nor --model; expected one of them");
    return KT_USAGE;
  }
  if (!r.study && r.path && strcmp(r.path, "-") != 0 && is_study(r.path)) {
    r.study = r.path;
    r.path = NULL;
  }
  return move_to_request(&r, needs_path, out);
}

void kredund_close(kredund_open *open) {
  km_study_free(open->study);
  km_study_def_free(&open->def);
  kt_close(&open->pose);
  km_arena_free(&open->arena);
}
