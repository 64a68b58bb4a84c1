/* Enters values of options into the study's definition. */
#include "kredund/kredund.h"

#include "kmech/base.h"

#include <stdio.h>
#include <string.h>

void kredund_claim_parts(const kredund_request *r, km_study_def *def) {
  const struct {
    const char *option, *value;
    km_study_place *place;
  } parts[] = {{"--q", r->q, &def->q0.place},
               {"--rates", r->rates, &def->rates.place},
               {"--task", r->task, &def->task_place},
               {"--objective", r->objective, &def->objective_place},
               {"--method", r->methods, &def->methods_place},
               {"--path", r->path, &def->path.place}};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i)
    if (parts[i].value)
      *parts[i].place = (km_study_place){parts[i].option, true};
}

kt_exit kredund_fault(km_messages *messages, bool option, const char *place, const km_error *error) {
  km_messages_add(messages, KM_ERROR, "%s: %s", place, error->text);
  return option ? KT_USAGE : KT_BAD_MODEL;
}

static kt_exit set_numbers(const kredund_request *r, kredund_open *open, const char *text, km_study_numbers *out) {
  double *items = KM_ARENA_NEW(&open->arena, double, strlen(text) / 2 + 1);
  const char *rest = text;
  out->items = items;
  out->count = 0;
  for (char last = ','; last == ',' && items;) {
    kt_piece piece = kt_split(&rest, ",");
    bool fine = kt_number(piece.text, &items[out->count++]);
    last = piece.separator;
    km_free(piece.text);
    if (!fine)
      return kt_usage(&r->common, out->place.text, text, "numbers a,b,…");
  }
  return KT_DONE;
}

/* NAME=WEIGHT,… */
static kt_exit add_weighted(const kredund_request *r, kredund_open *open, km_messages *messages) {
  kt_exit result = KT_DONE;
  const char *rest = r->objective;
  for (char last = ','; last == ',' && result != KT_USAGE;) {
    kt_piece name = kt_split(&rest, "="), weight = kt_split(&rest, ",");
    double value = 0.0;
    km_error error;
    char place[128];
    last = weight.separator;
    if (name.separator != '=' || !kt_number(weight.text, &value)) {
      result = kt_usage(&r->common, "--objective", r->objective, "NAME, or NAME=WEIGHT,NAME=WEIGHT");
    } else if (km_objective_add(&open->def.objective, name.text, value, &error)) {
      snprintf(place, sizeof place, "--objective.%s", name.text);
      result = kredund_fault(messages, true, place, &error);
    }
    km_free(name.text);
    km_free(weight.text);
  }
  return result;
}

static kt_exit set_objective(const kredund_request *r, kredund_open *open, km_messages *messages) {
  km_error error;
  open->def.objective = (km_objective){{0}};
  if (strchr(r->objective, '='))
    return add_weighted(r, open, messages);
  return km_objective_add(&open->def.objective, r->objective, 1.0, &error)
             ? kredund_fault(messages, true, "--objective", &error)
             : KT_DONE;
}

static km_status read_path_text(const char *file, km_study_place place, km_messages *messages, km_study_def *def,
                                km_error *error) {
  char folder[4096];
  km_text bytes = {0};
  km_status status = km_file_read(file, &bytes, error);
  kt_folder_of(file, folder, sizeof folder);
  if (!status)
    status = km_study_read_path(bytes.data ? bytes.data : "", bytes.size, folder, place, messages, def, error);
  km_text_free(&bytes);
  return status;
}

/* --path: poses, a study or its path object. Errors of the file are reported with its name. */
static kt_exit set_path(const kredund_request *r, kredund_open *open, km_messages *messages) {
  const km_study_place place = open->def.path.place;
  size_t length = strlen(r->path), errors = km_messages_errors(messages);
  bool poses = length > 4 && strcmp(r->path + length - 4, ".csv") == 0;
  km_error error;
  km_status status = poses ? km_study_read_poses(r->path, place, messages, &open->def, &error)
                           : read_path_text(r->path, place, messages, &open->def, &error);
  if (status == KM_IO)
    kt_print_message(&r->common, KM_ERROR, "%s", error.text);
  else if (status && km_messages_errors(messages) == errors)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", r->path, error.text);
  return kt_exit_of(status);
}

kt_exit kredund_set_parts(const kredund_request *r, kredund_open *open, km_messages *messages) {
  km_study_def *def = &open->def;
  kt_exit result = KT_DONE;
  km_error error;
  if (r->effector)
    result = kt_frame(&r->common, open->pose.model, "--effector", r->effector, &def->frame);
  if (r->q && result == KT_DONE)
    result = set_numbers(r, open, r->q, &def->q0);
  if (r->rates && result == KT_DONE)
    result = set_numbers(r, open, r->rates, &def->rates);
  if (r->task && result == KT_DONE && km_task_of_word(r->task, &def->task, &error))
    result = kredund_fault(messages, true, "--task", &error);
  if (r->objective && result == KT_DONE)
    result = set_objective(r, open, messages);
  if (result == KT_DONE)
    result = kredund_set_methods(r, open, messages);
  if (r->path && result == KT_DONE)
    result = set_path(r, open, messages);
  return open->arena.failed ? KT_NO_MEMORY : result;
}
