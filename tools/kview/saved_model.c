/* The present model: its file's text with the present configuration and design. */
#include "kview/messages.h"

#include "kmech/data.h"
#include "kmech/exchange.h"

#include <stdlib.h>
#include <string.h>

/* Takes a member out of an object; NULL: it has none of that name. */
static km_value *copy_out(km_value *object, const char *key) {
  km_value *before = NULL;
  for (km_value *v = object->first; v; before = v, v = v->next)
    if (v->key && strcmp(v->key, key) == 0) {
      *(before ? &before->next : &object->first) = v->next;
      object->last = object->last == v ? before : object->last;
      --object->count;
      return v;
    }
  return NULL;
}

/* Folders that count from the file's own one, in full. */
static void add_folder(km_arena *arena, km_value *list, const char *folder, const char *name) {
  km_text path = {0};
  km_text_format(&path, name[0] == '/' ? "%s%s" : "%s/%s", name[0] == '/' ? "" : folder, name);
  if (path.failed)
    arena->failed = true;
  else
    km_value_string(arena, list, NULL, path.data);
  km_text_free(&path);
}

/* A page saves the file in another folder: meshes are then looked for in the model's own. */
static void name_folders(const kv_session *s, const char *bytes, size_t size, km_text *out) {
  char *full = realpath(s->opening.path, NULL);
  km_arena arena = {0};
  const km_value *parsed = NULL;
  km_error ignored;
  if (full && !km_json_parse(bytes, size, &arena, &parsed, &ignored)) {
    km_value *root = (km_value *)(size_t)parsed, *given = (km_value *)(size_t)km_value_get(root, "model_parameters");
    km_value *parameters = given ? given : km_value_add(&arena, root, "model_parameters", KM_OBJECT);
    km_value *dirs = parameters ? copy_out(parameters, "include_dir") : NULL;
    km_value *list = parameters ? km_value_add(&arena, parameters, "include_dir", KM_LIST) : NULL;
    *strrchr(full, '/') = '\0';
    for (const km_value *d = !dirs ? NULL : dirs->kind == KM_LIST ? dirs->first : dirs; list && d; d = d->next) {
      add_folder(&arena, list, full, d->string);
      if (d == dirs)
        break;
    }
    if (list)
      km_value_string(&arena, list, NULL, full);
    if (!arena.failed)
      km_json_write(root, out);
  }
  km_arena_free(&arena);
  free(full);
}

static bool has_meshes(const char *text) {
  return strstr(text, "\"definition\"") || strstr(text, "\"mesh\"");
}

/* write: the text of a file with the present pose and design. */
km_status kv_write(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  double *q = kv_session_coordinates(s);
  km_bytes text = {0};
  km_status status = q ? km_model_write(s->model, q, &text, error) : km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    km_text_format(&c->answer->bytes, "{\"kind\":\"file\",\"request\":%u,\"text\":", c->request);
    km_text named = {0};
    if (has_meshes(text.data))
      name_folders(s, text.data, text.size, &named);
    kv_add_string(&c->answer->bytes, named.data ? named.data : text.data);
    km_text_add(&c->answer->bytes, "}");
    km_text_free(&named);
    s->unsaved = false;
  }
  km_bytes_free(&text);
  free(q);
  return status;
}
