/* The numbers of a model file by their paths: what they are now, and the file with others in it. */
#include "base/arguments.h"
#include "exchange/json/expression_values.h"
#include "exchange/json/json.h"
#include "exchange/json/json_meshes.h"
#include "exchange/json/number_variation.h"
#include "exchange/mesh/mesh_folders.h"

#include <ctype.h>
#include <string.h>

static bool is_word(char c) {
  return isalnum((unsigned char)c) || c == '_';
}

/* True if an expression uses the name. */
static bool mentions(const char *text, const char *name) {
  size_t length = strlen(name);
  for (const char *at = strstr(text, name); at; at = strstr(at + 1, name))
    if ((at == text || !is_word(at[-1])) && !is_word(at[length]))
      return true;
  return false;
}

/* True if the name occurs in a composed expression, or inside `parameters`. Evaluated numbers keep their
 * expressions. */
static bool is_mixed(const km_value *value, const char *name, bool parameters) {
  bool used = value->kind == KM_NUMBER && value->string && mentions(value->string, name);
  if (used && (parameters || strcmp(value->string, name) != 0))
    return true;
  for (const km_value *v = value->first; v; v = v->next)
    if (is_mixed(v, name, parameters || (v->key && strcmp(v->key, "parameters") == 0)))
      return true;
  return false;
}

static km_status read_numbers(km_value *root, const char *const *paths, int count, double *values, bool *plain,
                              km_error *error) {
  const km_value *parameters = km_value_get(root, "parameters");
  km_messages *messages = km_messages_create();
  km_status status = messages ? km_model_evaluate(root, messages, error)
                              : km_fail(error, KM_MEMORY, "out of memory while reading the model");
  km_messages_free(messages);
  for (int i = 0; i < count && !status; ++i)
    status = km_model_find_number(root, paths[i], &values[i], error);
  for (int i = 0; i < count && !status && plain; ++i)
    plain[i] = !km_value_get(parameters, paths[i]) || !is_mixed(root, paths[i], false);
  return status;
}

km_status km_model_read_numbers(const char *bytes, size_t size, const char *const *paths, int count, double *values,
                                bool *plain, km_error *error) {
  km_status status = km_check_given(bytes != NULL, "text of a model", error);
  if (!status)
    status = km_check_list(paths, count, "paths", error);
  if (!status)
    status = km_check_list(values, count, "values", error);
  if (status)
    return status;
  km_arena arena = {0};
  km_value *root;
  status = km_json_parse_open(bytes, size, &arena, &root, error);
  if (!status)
    status = read_numbers(root, paths, count, values, plain, error);
  km_arena_free(&arena);
  return status;
}

/* The meshes of the text as the file `to` sees them. */
static km_status rename_meshes(km_value *root, const char *from, const char *to, km_arena *arena, km_error *error) {
  km_folders folders = {0};
  if (!km_folders_create(&folders, from, arena))
    return km_fail(error, KM_MEMORY, "out of memory for the folder of a model");
  km_read_folders(km_value_get(km_value_get(root, "model_parameters"), "include_dir"), arena, &folders);
  return km_rename_meshes(root, &folders, to, arena, error);
}

/* The whole text; its failure is memory's. */
static km_status write_varied(const char *bytes, size_t size, const km_assignment *assignments, int count,
                              const char *from, const char *to, km_text *out, km_error *error) {
  km_arena arena = {0};
  km_value *root;
  km_status status = km_json_parse_open(bytes, size, &arena, &root, error);
  if (!status)
    status = km_model_vary(root, assignments, count, &arena, error);
  if (!status && to)
    status = rename_meshes(root, from, to, &arena, error);
  if (!status)
    km_json_write(root, out);
  if (!status && (out->failed || arena.failed))
    status = km_fail(error, KM_MEMORY, "out of memory for a model's text");
  km_arena_free(&arena);
  return status;
}

size_t km_model_write_varied(const char *bytes, size_t size, const km_assignment *assignments, int count,
                             const char *from, const char *to, char *text, size_t room, km_error *error) {
  km_status given = km_check_given(bytes != NULL, "text of a model", error);
  if (!given)
    given = km_check_list(assignments, count, "assignments", error);
  if (given)
    return 0;
  km_text out = {0};
  km_status status = write_varied(bytes, size, assignments, count, from, to, &out, error);
  size_t written = status ? 0 : out.size;
  if (!status && text && room > 0) {
    size_t fits = written < room - 1 ? written : room - 1;
    memcpy(text, out.data, fits);
    text[fits] = '\0';
  }
  km_text_free(&out);
  return written;
}
