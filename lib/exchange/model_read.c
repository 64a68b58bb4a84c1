/* Reads models of any format, recognised from the text. */
#include "base/arguments.h"
#include "exchange/json/json_model.h"
#include "exchange/mesh/mesh_folders.h"
#include "exchange/mesh/model_meshes.h"
#include "exchange/mjcf/mjcf.h"
#include "exchange/sdf/sdf.h"
#include "exchange/urdf/urdf.h"

#include <string.h>

/* XML begins with an angle bracket, after blanks and a byte order mark; JSON never does. UTF-16 has a zero byte next
 * to each of these characters. */
static bool is_xml(const char *bytes, size_t size) {
  static const char before[] = " \t\r\n\xEF\xBB\xBF\xFE\xFF";
  size_t i = 0;
  while (i < size && memchr(before, bytes[i], sizeof before))
    i++;
  return i < size && bytes[i] == '<';
}

static const struct {
  const char *root;
  km_robot_read read;
} formats[] = {{"robot", km_urdf_read}, {"mujoco", km_mjcf_read}, {"sdf", km_sdf_read}, {"gazebo", km_sdf_read}};

static km_status read_tree(km_xml *root, const km_read_def *def, km_messages *messages, km_model **out,
                           km_error *error) {
  for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
    if (strcmp(formats[i].root, root->name) == 0) {
      km_robot_request request = {def->file, def->floating, def->closure_tolerance, messages};
      return km_robot_build(formats[i].read, root, &request, out, error);
    }
  km_fail(error, KM_MODEL, "line %d, column %d: found the root element <%.60s>; expected robot, mujoco or sdf",
          root->line, root->column, root->name);
  km_messages_add(messages, KM_ERROR, "%s", error->text);
  return KM_MODEL;
}

static km_status read_xml(const char *bytes, size_t size, const km_read_def *def, km_messages *messages, km_model **out,
                          km_error *error) {
  km_arena arena = {0};
  km_xml *root;
  if (def->assignment_count > 0)
    return km_fail(error, KM_USAGE,
                   "found \"%.80s\" to vary in a robot description; expected a file of kmech's own format, which "
                   "`kmob convert` makes of it",
                   def->assignments[0].path);
  km_status status = km_xml_parse(bytes, size, NULL, &arena, &root, error);
  if (status == KM_MODEL)
    km_messages_add(messages, KM_ERROR, "%s", error->text);
  if (!status)
    status = read_tree(root, def, messages, out, error);
  if (!status && !km_folders_create(&(*out)->folders, def->file, &(*out)->arena)) {
    status = km_fail(error, KM_MEMORY, "out of memory while reading the model");
    km_model_free(*out);
    *out = NULL;
  }
  km_arena_free(&arena);
  return status;
}

km_status km_model_read_as(const char *bytes, size_t size, const km_read_def *def, km_messages *messages,
                           km_model **out, km_error *error) {
  km_error local;
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  if (!bytes)
    return km_check_given(false, "text of a model", error);
  if (!def)
    return km_check_given(false, "definition of the reading", error);
  if (def->assignment_count < 0 || (def->assignment_count > 0 && !def->assignments))
    return km_check_given(false, "assignments", error);
  if (!(def->closure_tolerance >= 0.0 && def->closure_tolerance < 0.1))
    return km_fail(error, KM_USAGE, "closure_tolerance: found %g; expected more than 0 and less than 0.1",
                   def->closure_tolerance);
  km_messages *own = messages ? NULL : km_messages_create();
  km_messages *list = messages ? messages : own;
  km_error *fault = error ? error : &local;
  km_status status = !list                 ? km_fail(fault, KM_MEMORY, "out of memory while reading the model")
                     : is_xml(bytes, size) ? read_xml(bytes, size, def, list, out, fault)
                                           : km_json_model(bytes, size, def, list, out, fault);
  km_messages_free(own);
  if (!status) {
    km_sha256(bytes, size, (*out)->sha256);
    if (def->file && !km_model_miss_meshes(*out, messages)) {
      status = km_fail(error, KM_MEMORY, "out of memory while reading the model");
      km_model_free(*out);
      *out = NULL;
    }
  }
  return status;
}

km_status km_model_read(const char *bytes, size_t size, km_messages *messages, km_model **out, km_error *error) {
  return km_model_read_as(bytes, size, &(km_read_def){0}, messages, out, error);
}

km_status km_model_read_varied(const char *bytes, size_t size, const char *file, const km_assignment *assignments,
                               int count, km_messages *messages, km_model **out, km_error *error) {
  return km_model_read_as(bytes, size,
                          &(km_read_def){.file = file, .assignments = assignments, .assignment_count = count}, messages,
                          out, error);
}

km_status km_model_read_file_as(const char *path, const km_read_def *def, km_messages *messages, km_model **out,
                                km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  if (!path)
    return km_check_given(false, "path of a model", error);
  if (!def)
    return km_check_given(false, "definition of the reading", error);
  km_text bytes = {0};
  km_read_def from = *def;
  from.file = path;
  km_status status = km_file_read(path, &bytes, error);
  if (!status)
    status = km_model_read_as(bytes.data ? bytes.data : "", bytes.size, &from, messages, out, error);
  km_text_free(&bytes);
  return status;
}

km_status km_model_read_file_varied(const char *path, const km_assignment *assignments, int count,
                                    km_messages *messages, km_model **out, km_error *error) {
  return km_model_read_file_as(path, &(km_read_def){.assignments = assignments, .assignment_count = count}, messages,
                               out, error);
}

km_status km_model_read_file(const char *path, km_messages *messages, km_model **out, km_error *error) {
  return km_model_read_file_as(path, &(km_read_def){0}, messages, out, error);
}
