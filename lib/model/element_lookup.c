/* Elements of a model by label or path, with suggestions for unknown names. */
#include "model/element_lookup.h"

#include "base/arguments.h"
#include "base/similar_names.h"
#include "model/name_path.h"

#include <stdio.h>
#include <string.h>

const char *km_nearest_joint_labels(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]) {
  km_nearest nearest = {.wanted = wanted};
  for (int j = 0; j < model->joint_count; ++j)
    km_nearest_add(&nearest, model->joints[j].label ? model->joints[j].label : model->joints[j].name);
  return km_nearest_text(&nearest, out);
}

const char *km_nearest_frame_paths(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]) {
  km_arena arena = {0};
  km_nearest nearest = {.wanted = wanted};
  for (int f = 0; f < model->frame_count; ++f) {
    const char *const parts[] = {model->bodies[model->frames[f].body].name, model->frames[f].name};
    char text[KM_PATH_TEXT];
    const char *name = km_arena_string(&arena, km_path_names_text(parts, 2, text));
    if (name)
      km_nearest_add(&nearest, name);
  }
  km_nearest_text(&nearest, out);
  km_arena_free(&arena);
  return out;
}

/* True if text … end is the joint's path from the root, its names joined by slashes; compared from the end. */
static bool is_path_of(const km_model *model, const km_model_joint *joint, const char *text, const char *end) {
  const char *name = joint->name;
  for (int assembly = joint->assembly;; assembly = model->assemblies[assembly].parent) {
    size_t length = strlen(name);
    if ((size_t)(end - text) < length || memcmp(end - length, name, length) != 0)
      return false;
    end -= length;
    if (assembly == KM_NO_ASSEMBLY)
      return end == text;
    if (end == text || *--end != '/')
      return false;
    name = model->assemblies[assembly].name;
  }
}

/* Labels are rarely looked up after reading (options only), so a linear search suffices. */
km_status km_model_find_joint(const km_model *model, const char *label, int *joint, km_error *error) {
  km_status fits = km_check_given(model && label && joint, "model, label or place for the result", error);
  if (fits)
    return fits;
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = 0; j < model->joint_count; ++j) {
      const km_model_joint *def = &model->joints[j];
      if (pass == 0 ? strcmp(def->label, label) == 0 : is_path_of(model, def, label, label + strlen(label))) {
        *joint = j;
        return KM_OK;
      }
    }
  }
  char names[KM_NEAREST_TEXT];
  return km_fail(error, KM_USAGE, "\"%s\" names no joint; %s %s", label,
                 model->joint_count > KM_NEAREST ? "the nearest are" : "the model has",
                 km_nearest_joint_labels(model, label, names));
}

km_status km_model_find_coordinate(const km_model *model, const char *label, int *coordinate, km_error *error) {
  km_status fits = km_check_given(model && label && coordinate, "model, label or place for the result", error);
  if (fits)
    return fits;
  for (int c = 0; c < model->coordinate_count; ++c) {
    if (strcmp(model->coordinates[c].label, label) == 0) {
      *coordinate = c;
      return KM_OK;
    }
  }
  const char *bracket = strrchr(label, '[');
  for (int c = 0; c < model->coordinate_count && bracket; ++c) { /* path[k] */
    const km_model_coordinate *def = &model->coordinates[c];
    char index[16];
    snprintf(index, sizeof index, "[%d]", def->index);
    if (strcmp(bracket, index) == 0 && km_model_freedom(model, def->joint) > 1 &&
        is_path_of(model, &model->joints[def->joint], label, bracket)) {
      *coordinate = c;
      return KM_OK;
    }
  }
  int joint;
  km_status status = km_model_find_joint(model, label, &joint, error);
  if (status)
    return status;
  int freedom = km_model_freedom(model, joint);
  *coordinate = model->joints[joint].first_coordinate;
  if (freedom == 1)
    return KM_OK;
  if (freedom == 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" is rigid; expected a joint with a coordinate", label);
  return km_fail(error, KM_USAGE, "joint \"%s\" has %d coordinates; expected one of them, as \"%s[0]\"", label, freedom,
                 label);
}

/* True if the body's path from the root ends in these names. */
static bool body_matches(const km_model *model, int body, const char *const *names, size_t count) {
  if (strcmp(model->bodies[body].name, names[count - 1]) != 0)
    return false;
  if (count == 1)
    return true;
  int assembly = model->bodies[body].assembly;
  for (size_t i = count - 1; i-- > 0; assembly = model->assemblies[assembly].parent)
    if (assembly < 0 || strcmp(model->assemblies[assembly].name, names[i]) != 0)
      return false;
  return assembly == KM_NO_ASSEMBLY;
}

static int frames_named(const km_model *model, const char *const *names, size_t count, const char *frame_name,
                        int *frame) {
  int found = 0;
  for (int f = 0; count > 0 && f < model->frame_count; ++f)
    if (strcmp(model->frames[f].name, frame_name) == 0 && body_matches(model, model->frames[f].body, names, count)) {
      *frame = f;
      ++found;
    }
  return found;
}

/* Number of frames that a path matches, and the last of them. */
static int frames_of_path(const km_model *model, const char *const *names, size_t count, int *frame) {
  int found = count ? frames_named(model, names, count - 1, names[count - 1], frame) : 0;
  return found || !count ? found : frames_named(model, names, count, "origin", frame);
}

km_status km_model_find_frame(const km_model *model, const char *const *names, size_t count, int *frame,
                              km_error *error) {
  km_status fits = km_check_given(model && frame, "model or place for the result", error);
  for (size_t i = 0; i < count && !fits; ++i)
    fits = km_check_given(names && names[i], "name of a frame", error);
  if (fits)
    return fits;
  char text[KM_PATH_TEXT];
  int found = frames_of_path(model, names, count, frame);
  km_path_names parts = {.count = 0};
  if (!found && count == 1 && km_path_names_split(names[0], &parts)) {
    found = frames_of_path(model, parts.names, parts.count, frame);
    km_path_names_free(&parts);
  }
  if (parts.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the path of a frame");
  if (found == 1)
    return KM_OK;
  km_path_names_text(names, count, text);
  if (found > 1)
    return km_fail(error, KM_USAGE, "\"%s\" names %d frames; expected the full path from the root", text, found);
  char near[KM_NEAREST_TEXT];
  return km_fail(error, KM_USAGE, "\"%s\" names no frame; expected body/frame; the nearest are %s", text,
                 km_nearest_frame_paths(model, text, near));
}
