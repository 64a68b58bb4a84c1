/* The model as it stands: its file's text with the present pose, and the places of the frames that were moved. */
#include "kview/messages.h"

#include "kmech/write.h"

#include <stdlib.h>
#include <string.h>

/* The numbers that a changed design gives to the text. */
typedef struct changes {
  kv_buffer paths; /* ended by NULs */
  km_assignment *items;
  size_t *path_at; /* into `paths` */
  int count;
} changes;

/* A name in a path: a dot or backslash takes a backslash before it. */
static void add_name(kv_buffer *out, const char *name) {
  for (const char *at = name; *at; ++at) {
    if (*at == '.' || *at == '\\')
      kv_add(out, "\\");
    kv_add_bytes(out, at, 1);
  }
}

static void add_assembly(kv_buffer *out, const km_model *model, int assembly) {
  if (assembly < 0)
    return;
  add_assembly(out, model, km_model_assembly_parent(model, assembly));
  add_name(out, km_model_assembly_name(model, assembly));
  kv_add(out, ".");
}

static void add_change(changes *c, size_t path, double value) {
  c->path_at[c->count] = path;
  c->items[c->count++].value = value;
}

static void add_frame(const kv_session *s, int frame, const double T[3], changes *c) {
  int body = km_model_frame_body(s->model, frame);
  for (int k = 0; k < 3; ++k) {
    size_t start = c->paths.size;
    add_assembly(&c->paths, s->model, km_model_body_assembly(s->model, body));
    add_name(&c->paths, km_model_body_name(s->model, body));
    kv_add(&c->paths, ".");
    add_name(&c->paths, km_model_frame_name(s->model, frame));
    kv_add(&c->paths, ".T.%d", k);
    kv_add_bytes(&c->paths, "", 1);
    add_change(c, start, T[k]);
  }
}

/* Of a drawing: the point at which both frames of a joint are. */
static void add_point(const kv_session *s, int joint, const double T[3], changes *c) {
  int body = km_model_frame_body(s->model, km_model_joint_frame(s->model, joint, true));
  for (int k = 0; k < 3; ++k) {
    size_t start = c->paths.size;
    add_assembly(&c->paths, s->model, km_model_body_assembly(s->model, body));
    add_name(&c->paths, km_model_joint_label(s->model, joint));
    kv_add(&c->paths, ".at.%d", k);
    kv_add_bytes(&c->paths, "", 1);
    add_change(c, start, T[k]);
  }
}

/* Is the frame made by a joint of a drawing that the text still is? */
static int drawn_joint(const kv_session *s, int frame, bool drawing) {
  for (int j = 0; drawing && j < km_model_joint_count(s->model); ++j)
    if (km_model_joint_is_drawn(s->model, j) &&
        (km_model_joint_frame(s->model, j, false) == frame || km_model_joint_frame(s->model, j, true) == frame))
      return j;
  return -1;
}

static km_status gather(const kv_session *s, const double *T, bool drawing, changes *c, km_error *error) {
  for (int f = 0; f < km_model_frame_count(s->model); ++f) {
    int joint = drawn_joint(s, f, drawing);
    if (memcmp(T + 3 * f, s->file_places + 3 * f, 3 * sizeof *T) == 0)
      continue;
    if (strcmp(km_model_frame_name(s->model, f), "origin") == 0)
      return km_fail(error, KM_USAGE,
                     "a joint of \"%s\" is at the body's own origin, which a file can't move; expected a frame of the "
                     "body for it",
                     km_model_body_name(s->model, km_model_frame_body(s->model, f)));
    if (joint < 0)
      add_frame(s, f, T + 3 * f, c);
    else if (km_model_joint_frame(s->model, joint, true) == f)
      add_point(s, joint, T + 3 * f, c);
  }
  return c->paths.failed ? km_fail(error, KM_MEMORY, "out of memory") : KM_OK;
}

/* Does the text still say where drawn joints are? A pose other than the drawn one makes frames of them. */
static bool is_drawing(const kv_session *s, const km_bytes *text) {
  for (int j = 0; j < km_model_joint_count(s->model); ++j)
    if (km_model_joint_is_drawn(s->model, j)) {
      double value;
      km_error error;
      kv_buffer path = {0};
      add_name(&path, km_model_joint_label(s->model, j));
      kv_add(&path, ".at.0");
      const char *one = path.failed ? "" : path.data;
      bool drawing = km_model_read_numbers(text->data, text->size, &one, 1, &value, NULL, &error) == KM_OK;
      kv_buffer_free(&path);
      return drawing;
    }
  return false;
}

/* The text with the changes in it; the caller frees `*out`. */
static km_status apply(const km_bytes *text, changes *c, char **out, km_error *error) {
  for (int i = 0; i < c->count; ++i)
    c->items[i].path = c->paths.data + c->path_at[i];
  size_t size = km_model_write_varied(text->data, text->size, c->items, c->count, NULL, 0, error);
  *out = size ? malloc(size + 1) : NULL;
  if (*out)
    km_model_write_varied(text->data, text->size, c->items, c->count, *out, size + 1, error);
  else if (size)
    return km_fail(error, KM_MEMORY, "out of memory");
  return size ? KM_OK : error->status;
}

static km_status change(const kv_session *s, const km_bytes *text, char **out, km_error *error) {
  size_t room = 3 * (size_t)km_model_frame_count(s->model);
  double *T = kv_frame_places(s->model);
  changes c = {.items = calloc(room, sizeof *c.items), .path_at = calloc(room, sizeof *c.path_at)};
  km_status status = T && c.items && c.path_at ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status)
    status = gather(s, T, is_drawing(s, text), &c, error);
  if (!status)
    status = apply(text, &c, out, error);
  kv_buffer_free(&c.paths);
  free(c.items);
  free(c.path_at);
  free(T);
  return status;
}

/* The file as it was read, at a pose: the session's own model has taken over other numbers. */
static km_status write_file(const kv_session *s, const double *q, km_bytes *out, km_error *error) {
  km_model *model;
  km_read_def def = {.floating = s->opening.floating};
  if (kv_session_is_stale(s))
    return km_fail(error, KM_USAGE, "the file has changed in the meantime");
  km_status status = km_model_load_as(s->opening.path, &def, NULL, &model, error);
  if (!status)
    status = km_model_write(model, q, out, error);
  km_model_free(model);
  return status;
}

/* write: the text of a file with the present pose and design. */
km_status kv_write(const kv_call *c, km_error *error) {
  const kv_session *s = c->session;
  double *q = calloc((size_t)km_model_coordinate_count(s->model) + 1, sizeof *q);
  km_bytes text = {0};
  char *changed = NULL;
  km_status status =
      q ? km_state_coordinates(s->mechanism, s->state, q, error) : km_fail(error, KM_MEMORY, "out of memory");
  if (!status)
    status = write_file(s, q, &text, error);
  if (!status && s->edited)
    status = change(s, &text, &changed, error);
  if (!status) {
    kv_add(&c->answer->bytes, "{\"kind\":\"file\",\"request\":%u,\"text\":", c->request);
    kv_add_string(&c->answer->bytes, changed ? changed : text.data);
    kv_add(&c->answer->bytes, "}");
  }
  free(changed);
  km_bytes_free(&text);
  free(q);
  return status;
}
