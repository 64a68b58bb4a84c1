/* Paths and labels: which body, frame, joint or coordinate a name means. */
#include "base/arguments.h"
#include "base/similar_names.h"
#include "exchange/json/name_path.h"
#include "exchange/json/read/reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const char *km_path_text(const km_value *value, char out[KM_PLACE_TEXT]) {
  km_path_names p;
  km_path_names_gather(value, &p);
  return km_path_names_text(p.names, p.count, out);
}

/* The joints that are called nearly so; while a file is read, they have names and no labels yet. */
static const char *nearest_joints(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]) {
  km_nearest nearest = {.wanted = wanted};
  for (int j = 0; j < model->joint_count; ++j)
    km_nearest_add(&nearest, model->joints[j].label ? model->joints[j].label : model->joints[j].name);
  return km_nearest_text(&nearest, out);
}

static const char *nearest_frames(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]) {
  km_arena arena = {0};
  km_nearest nearest = {.wanted = wanted};
  for (int f = 0; f < model->frame_count; ++f) {
    const char *const parts[] = {model->bodies[model->frames[f].body].name, model->frames[f].name};
    char text[KM_PLACE_TEXT];
    const char *name = km_arena_string(&arena, km_path_names_text(parts, 2, text));
    if (name)
      km_nearest_add(&nearest, name);
  }
  km_nearest_text(&nearest, out);
  km_arena_free(&arena);
  return out;
}

/* The assembly at the end of `count` names from the root; KM_NO_ASSEMBLY is the root itself. */
static int assembly_from_root(const km_reader *reader, const char *const *names, size_t count) {
  int assembly = KM_NO_ASSEMBLY;
  for (size_t i = 0; i < count; ++i) {
    int next = km_names_get(&reader->assemblies, assembly, names[i]);
    if (next < 0)
      return next == KM_LEFT_OUT ? KM_LEFT_OUT : -3;
    assembly = next;
  }
  return assembly;
}

/* Element named by `names` from the root in one of the tables, KM_NOT_FOUND or KM_LEFT_OUT. */
static int from_root(const km_reader *reader, const km_names *table, const char *const *names, size_t count) {
  if (count < 2)
    return KM_NOT_FOUND;
  int assembly = assembly_from_root(reader, names, count - 1);
  if (assembly == KM_LEFT_OUT)
    return KM_LEFT_OUT;
  return assembly < 0 ? KM_NOT_FOUND : km_names_get(table, assembly, names[count - 1]);
}

static int frame_of(const km_reader *reader, int body, const char *name) {
  return body < 0 ? body : km_names_get(&reader->frames, body, name);
}

/* Keeps the better of two readings: a frame found, else left out, else not found. */
static int better(int a, int b) {
  return a >= 0 ? a : b >= 0 ? b : a < b ? a : b;
}

static int find_frame(const km_reader *reader, const char *const *names, size_t count, int assembly) {
  if (strcmp(names[0], "fixed") == 0 && count <= 2)
    return frame_of(reader, 0, count == 2 ? names[1] : "origin");
  int named = KM_NOT_FOUND; /* readings whose last name is a frame win */
  if (count == 2)
    named = frame_of(reader, km_names_get(&reader->bodies, assembly, names[0]), names[1]);
  else if (count > 2)
    named = frame_of(reader, from_root(reader, &reader->bodies, names, count - 1), names[count - 1]);
  if (named >= 0)
    return named;
  int body =
      count == 1 ? km_names_get(&reader->bodies, assembly, names[0]) : from_root(reader, &reader->bodies, names, count);
  return better(named, frame_of(reader, body, "origin"));
}

/* Usual names of the inertial frame in other programs. */
static bool means_fixed(const char *path) {
  static const char *const names[] = {"ground",   "world",  "earth", "base", "frame",
                                      "inertial", "origin", "fix",   "Fixed"};
  size_t length = strcspn(path, "/");
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
    if (strlen(names[i]) == length && strncasecmp(path, names[i], length) == 0)
      return true;
  return false;
}

int km_reader_frame(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  km_path_names p;
  char text[KM_PLACE_TEXT], near[KM_NEAREST_TEXT];
  int frame = km_path_names_gather(value, &p) ? find_frame(reader, p.names, p.count, assembly) : KM_NOT_FOUND;
  if (frame == KM_NOT_FOUND && p.count == 1 && km_path_names_split(p.names[0], &p))
    frame = find_frame(reader, p.names, p.count, assembly);
  km_path_names_free(&p);
  reader->model->arena.failed = reader->model->arena.failed || p.failed;
  km_path_text(value, text);
  if (frame == KM_NOT_FOUND && !p.failed)
    km_reader_error(reader, place,
                    "\"%s\" names no body or frame; expected [body, frame] of this assembly, a path from the "
                    "root, or [\"fixed\", frame]%s; the nearest are %s",
                    text, means_fixed(text) ? ", as the inertial frame is called" : "",
                    nearest_frames(reader->model, text, near));
  return frame;
}

/* True if an assembly has the body, and it or its frame is inactive. */
static bool is_left_out(const km_reader *reader, const char *const *names, size_t count) {
  for (int a = 0; a < reader->model->assembly_count && count <= 2; ++a) {
    int body = km_names_get(&reader->bodies, a, names[0]);
    if (body == KM_LEFT_OUT || (count == 2 && frame_of(reader, body, names[1]) == KM_LEFT_OUT))
      return true;
  }
  return find_frame(reader, names, count, KM_NO_ASSEMBLY) == KM_LEFT_OUT;
}

int km_reader_frame_anywhere(km_reader *reader, const km_value *path, const km_place *place, const char *what) {
  km_path_names p, parts = {.count = 0};
  int frame = KM_NOT_FOUND;
  char text[KM_PLACE_TEXT];
  km_error problem;
  km_path_names_gather(path, &p);
  km_status status = km_model_find_frame(reader->model, p.names, p.count, &frame, &problem);
  bool out = status == KM_USAGE && p.count > 0 && is_left_out(reader, p.names, p.count);
  if (status == KM_USAGE && !out && p.count == 1 && km_path_names_split(p.names[0], &parts)) {
    out = is_left_out(reader, parts.names, parts.count);
    km_path_names_free(&parts);
  }
  reader->model->arena.failed = reader->model->arena.failed || status == KM_MEMORY || parts.failed;
  km_path_names_free(&p);
  if (out)
    km_reader_note(reader, place, "frame \"%s\" is left out of the model, and %s with it", km_path_text(path, text),
                   what);
  else if (status)
    km_reader_error(reader, place, "%s", problem.text);
  return out ? KM_LEFT_OUT : status ? KM_NOT_FOUND : frame;
}

/* A joint of this assembly, or one that a label names. */
static int joint_named(const km_reader *reader, const char *name, int assembly) {
  int joint = km_names_get(&reader->joints, assembly, name);
  if (joint == KM_NOT_FOUND)
    joint = km_names_get(&reader->labels, KM_LABEL_JOINT, name);
  if (joint == KM_NOT_FOUND && km_names_get(&reader->labels, KM_LABEL_FAULTY, name) >= 0)
    joint = KM_FAULTY;
  if (joint == KM_NOT_FOUND && km_names_get(&reader->labels, KM_LABEL_LEFT_OUT, name) >= 0)
    joint = KM_LEFT_OUT;
  return joint;
}

int km_reader_joint(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  km_path_names p;
  char text[KM_PLACE_TEXT], near[KM_NEAREST_TEXT];
  int joint = KM_NOT_FOUND;
  if (km_path_names_gather(value, &p)) {
    joint =
        p.count == 1 ? joint_named(reader, p.names[0], assembly) : from_root(reader, &reader->joints, p.names, p.count);
    if (joint == KM_NOT_FOUND && p.count == 1 && km_path_names_split(p.names[0], &p))
      joint = from_root(reader, &reader->joints, p.names, p.count);
    km_path_names_free(&p);
    reader->model->arena.failed = reader->model->arena.failed || p.failed;
  }
  if (joint == KM_NOT_FOUND && !p.failed)
    km_reader_error(reader, place,
                    "\"%s\" names no joint; expected a joint's label or its path from the root; the nearest are %s",
                    text, nearest_joints(reader->model, km_path_text(value, text), near));
  return joint;
}

int km_reader_coordinate(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  if (value->kind == KM_STRING && km_names_get(&reader->joints, assembly, value->string) == KM_NOT_FOUND) {
    int coordinate = km_names_get(&reader->labels, KM_LABEL_COORDINATE, value->string);
    if (coordinate >= 0)
      return coordinate;
  }
  int joint = km_reader_joint(reader, value, assembly, place);
  if (joint < 0)
    return joint;
  const km_model_joint *def = &reader->model->joints[joint];
  int freedom = km_model_freedom(reader->model, joint);
  if (freedom == 1)
    return def->first_coordinate;
  if (freedom == 0)
    km_reader_error(reader, place, "joint \"%s\" is rigid; expected a joint with a coordinate", def->label);
  else
    km_reader_error(reader, place, "joint \"%s\" has %d coordinates; expected one of them, as \"%s[0]\"", def->label,
                    freedom, def->label);
  return KM_NOT_FOUND;
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
                 nearest_joints(model, label, names));
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
  char text[KM_PLACE_TEXT];
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
                 nearest_frames(model, text, near));
}
