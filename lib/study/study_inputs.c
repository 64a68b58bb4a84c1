/* Files on which the answers of a study depend besides its own text and the model's, as parts of the store's keys. */
#include "study/study_inputs.h"

#include "kmech/data.h"
#include "model/model.h"

#include <string.h>

/* Path of the table of poses that a path study names, relative to the study's folder. NULL: none. */
static const char *table_of(const char *study, const km_text *bytes, km_arena *arena) {
  const km_value *root = NULL;
  km_error ignored; /* computing the request reports errors of the file */
  if (km_json_parse(bytes->data ? bytes->data : "", bytes->size, arena, &root, &ignored) || !root)
    return NULL;
  const km_value *path = km_value_get(root, "path"), *csv = path ? km_value_get(path, "csv") : NULL;
  if (!csv || csv->kind != KM_STRING)
    return NULL;
  const char *slash = csv->string[0] == '/' ? NULL : strrchr(study, '/');
  km_text file = {0};
  km_text_format(&file, "%.*s%s", slash ? (int)(slash - study) + 1 : 0, study, csv->string);
  return km_text_move_to_arena(&file, arena);
}

/* Appends the hash of a file and, for a path study, of its table of poses. */
static km_status add_file(const char *file, bool is_study, km_arena *arena, km_text *out, km_error *error) {
  km_text bytes = {0};
  km_status status = km_file_read(file, &bytes, error);
  const char *table = status || !is_study ? NULL : table_of(file, &bytes, arena);
  if (!status)
    km_identity_add_bytes(out, bytes.data, bytes.size);
  km_text_free(&bytes);
  return status || !table ? status : add_file(table, false, arena, out, error);
}

km_status km_design_add_files(const km_design_study *s, const km_design_question *q, km_text *out, km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; i < q->option_count && !status; ++i) {
    km_arena arena = {0};
    const char *file = km_design_file(s->def, q, &q->options[i], &arena);
    if (file)
      status = add_file(file, true, &arena, out, error);
    if (!status && arena.failed)
      status = km_fail(error, KM_MEMORY, "out of memory for a study");
    km_arena_free(&arena);
  }
  return status;
}
