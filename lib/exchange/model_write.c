/* Models as the text of files. */
#include "kmech/exchange.h"

#include "base/arguments.h"
#include "exchange/json/json.h"
#include "exchange/json/json_meshes.h"
#include "exchange/json/write/convert.h"
#include "exchange/robot/robot_write.h"

#include <math.h>
#include <string.h>

static const struct {
  const char *ending;
  km_robot_write write; /* NULL: JSON */
} formats[] = {[KM_FORMAT_JSON] = {".json", NULL},
               [KM_FORMAT_URDF] = {".urdf", km_urdf_write},
               [KM_FORMAT_MJCF] = {".xml", km_mjcf_write},
               [KM_FORMAT_SDF] = {".sdf", km_sdf_write}};
enum { FORMATS = (int)(sizeof formats / sizeof *formats) };

km_model_format km_model_format_of(const char *file) {
  const char *ending = file ? strrchr(file, '.') : NULL;
  for (int i = 0; ending && i < FORMATS; ++i)
    if (strcmp(ending, formats[i].ending) == 0)
      return (km_model_format)i;
  return KM_FORMAT_JSON;
}

km_status km_model_rename_meshes(const km_model *model, const km_value *tree, const char *file, km_arena *arena,
                                 km_error *error) {
  km_status status = km_check_given(model && tree && arena, !model ? "model" : tree ? "arena" : "tree", error);
  return status ? status : km_rename_meshes((km_value *)tree, &model->folders, file, arena, error);
}

static km_status write_json(const km_model *model, const double *q, const char *file, km_text *text, km_error *error) {
  km_arena arena = {0};
  const km_value *value = NULL;
  km_status status = km_model_convert(model, &model->units, q, false, &arena, &value, error);
  if (!status)
    status = km_model_rename_meshes(model, value, file, &arena, error);
  if (!status)
    km_json_write(value, text);
  km_arena_free(&arena);
  return status;
}

static km_status write_robot(const km_model *model, km_robot_write write, const double *q, const char *file,
                             km_messages *messages, km_text *text, km_error *error) {
  km_written w;
  km_text_add(text, "<?xml version=\"1.0\"?>\n");
  km_status status = km_written_make(model, q, file, messages, text, &w, error);
  if (!status)
    status = write(&w, error);
  if (!status && w.arena.failed)
    status = km_fail(error, KM_MEMORY, "out of memory while writing the model");
  if (!status)
    km_written_tell(&w);
  km_written_free(&w);
  return status;
}

km_status km_model_write_as(const km_model *model, km_model_format format, const double *q, const char *file,
                            km_messages *messages, km_bytes *out, km_error *error) {
  km_text text = {0};
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_bytes){0};
  km_status status = km_check_given(model != NULL, "model", error);
  if (!status)
    status = km_check_index((int)format, FORMATS, "format of models", error);
  for (int c = 0; q && !status && c < model->coordinate_count; ++c)
    if (!isfinite(q[c]))
      status = km_fail(error, KM_USAGE, "found a displacement that is not finite");
  if (status)
    return status;
  status = formats[format].write ? write_robot(model, formats[format].write, q, file, messages, &text, error)
                                 : write_json(model, q, file, &text, error);
  if (!status)
    return km_text_move_to_bytes(&text, out, error);
  km_text_free(&text);
  return status;
}

km_status km_model_write(const km_model *model, const double *q, km_bytes *out, km_error *error) {
  return km_model_write_as(model, KM_FORMAT_JSON, q, NULL, NULL, out, error);
}
