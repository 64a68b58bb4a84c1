/* Paths and labels: which body, frame, joint or coordinate a name means. */
#include "base/arguments.h"
#include "base/similar_names.h"
#include "exchange/json/read/reader.h"
#include "model/element_lookup.h"
#include "model/name_path.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const char *km_path_text(const km_value *value, char out[KM_PLACE_TEXT]) {
  km_path_names p;
  km_path_names_gather(value, &p);
  return km_path_names_text(p.names, p.count, out);
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
                    km_nearest_frame_paths(reader->model, text, near));
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
                    text, km_nearest_joint_labels(reader->model, km_path_text(value, text), near));
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
