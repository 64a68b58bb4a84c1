/* Path studies: JSON text into a definition. */
#include "exchange/json/study/study_reader.h"

#include "base/arguments.h"
#include "exchange/json/json.h"
#include "kmech/arm.h"

/* A call of the reader: numbers of messages before it, to identify those that it adds. */
typedef struct call {
  km_study_reader s;
  km_messages *own; /* list to be freed; NULL: the caller's list is used */
  size_t had, errors;
} call;

static km_status memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

static km_status begin(call *c, km_study_def *def, const char *folder, km_messages *messages, km_error *error) {
  *c = (call){.s.folder = folder};
  if (!def->memory)
    def->memory = KM_NEW(km_arena, 1);
  if (!messages)
    messages = c->own = km_messages_create();
  if (!def->memory || !messages) {
    km_messages_free(c->own);
    return memory(error);
  }
  c->s.arena = def->memory;
  c->s.reader.messages = messages;
  c->s.reader.arena = def->memory;
  c->had = km_messages_count(messages);
  c->errors = km_messages_errors(messages);
  return KM_OK;
}

static bool faulty(const call *c) {
  return km_messages_errors(c->s.reader.messages) > c->errors;
}

/* The first error that came, with `status`. */
static km_status first_error(const call *c, km_status status, km_error *error) {
  const km_messages *messages = c->s.reader.messages;
  for (size_t i = c->had; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, status, "%s", km_messages_text(messages, i));
  return km_fail(error, status, "the study is faulty");
}

/* Result of the call: `status` of the text, or of its contents. */
static km_status end(call *c, km_status status, bool option, km_error *error) {
  if (!status && c->s.arena->failed) /* NOLINT(*NullDereference): begin() has seen to it */
    status = memory(error);
  else if (!status && faulty(c))
    status = first_error(c, option ? KM_USAGE : c->s.reader.unreadable ? KM_IO : KM_MODEL, error);
  km_messages_free(c->own);
  return status;
}

void km_study_names_of(km_study_reader *s, const km_value *value, km_study_names *out) {
  size_t count = value->kind == KM_LIST ? value->count : 1;
  const char **items = KM_ARENA_NEW(s->arena, const char *, count);
  out->items = items;
  out->count = items ? (int)count : 0;
  const km_value *v = value->kind == KM_LIST ? value->first : value;
  for (int i = 0; i < out->count; ++i, v = v->next)
    items[i] = v->string;
}

static void read_names(km_study_reader *s, const km_value *root, const char *key, km_study_names *out) {
  const km_value *value = km_value_get(root, key);
  if (value && !out->place.option)
    km_study_names_of(s, value, out);
}

static void read_numbers(km_study_reader *s, const km_value *root, const char *key, km_study_numbers *out) {
  const km_value *value = km_value_get(root, key);
  if (!value || out->place.option)
    return;
  double *items = KM_ARENA_NEW(s->arena, double, value->count + 1);
  out->items = items;
  out->count = 0;
  for (const km_value *v = value->first; v && items; v = v->next)
    items[out->count++] = v->number;
}

static void read_task(km_study_reader *s, const km_value *root, km_study_def *def) {
  const char *word = km_reader_string(root, "task");
  km_place place = {NULL, "task", 0};
  km_error error;
  if (word && !def->task_place.option && km_task_of_word(word, &def->task, &error))
    km_reader_error(&s->reader, &place, "%s", error.text);
}

static void read_parts(km_study_reader *s, const km_value *root, km_study_def *def) {
  const km_value *methods = km_value_get(root, "methods"), *objective = km_value_get(root, "objective");
  const km_value *path = km_value_get(root, "path");
  def->model = km_reader_string(root, "model");
  read_names(s, root, "effector", &def->effector);
  read_names(s, root, "coordinates", &def->coordinates);
  read_numbers(s, root, "q0", &def->q0);
  read_numbers(s, root, "rates", &def->rates);
  read_task(s, root, def);
  if (methods && !def->methods_place.option)
    km_study_methods_of(s, methods, def);
  if (objective && !def->objective_place.option)
    km_study_objective_of(s, objective, &def->objective);
  if (path && !def->path.place.option)
    km_study_path_of(s, path, &def->path);
}

km_status km_study_read(const char *bytes, size_t size, const char *folder, km_messages *messages, km_study_def *def,
                        km_error *error) {
  call c;
  const km_value *root;
  km_status fits = km_check_given(bytes && folder && def, "text, folder or definition of a study", error);
  if (fits)
    return fits;
  km_status status = begin(&c, def, folder, messages, error);
  if (status)
    return status;
  status = km_json_parse(bytes, size, c.s.arena, &root, error);
  const char *other = status ? NULL : km_other_kind(root, &km_format_study);
  if (other)
    status = km_fail(error, KM_MODEL, "the file is %s; expected a path study", other);
  if (!status)
    km_format_check_as(root, &km_format_study, NULL, c.s.reader.messages);
  if (!status && !faulty(&c))
    read_parts(&c.s, root, def);
  return end(&c, status, false, error);
}

km_status km_study_read_path(const char *bytes, size_t size, const char *folder, km_study_place place,
                             km_messages *messages, km_study_def *def, km_error *error) {
  call c;
  const km_value *root;
  km_status fits = km_check_given(bytes && folder && place.text && def, "text, folder, place or definition", error);
  if (fits)
    return fits;
  km_status status = begin(&c, def, folder, messages, error);
  if (status)
    return status;
  const char *text = km_arena_string(c.s.arena, place.text);
  def->path = (km_study_path){.plan = km_path_plan_default(), .place = {text ? text : "path", place.option}};
  status = km_json_parse(bytes, size, c.s.arena, &root, error);
  if (!status) {
    const km_value *inner = km_value_get(root, "path");
    km_place at = {NULL, def->path.place.text, 0};
    km_format_check_as(inner ? inner : root, &km_format_path, &at, c.s.reader.messages);
    if (!faulty(&c))
      km_study_path_of(&c.s, inner ? inner : root, &def->path);
  }
  return end(&c, status, place.option, error);
}

km_status km_study_read_poses(const char *file, km_study_place place, km_messages *messages, km_study_def *def,
                              km_error *error) {
  call c;
  km_status fits = km_check_given(file && place.text && def, "file, place or definition", error);
  if (fits)
    return fits;
  km_status status = begin(&c, def, "", messages, error);
  if (status)
    return status;
  const char *text = km_arena_string(c.s.arena, place.text);
  def->path = (km_study_path){.plan = km_path_plan_default(), .place = {text ? text : "path", place.option}};
  km_study_poses_of(&c.s, file, &def->path);
  return end(&c, KM_OK, place.option, error);
}

void km_study_def_free(km_study_def *def) {
  if (!def)
    return;
  if (def->memory)
    km_arena_free(def->memory);
  km_free(def->memory);
  *def = km_study_def_default();
}
