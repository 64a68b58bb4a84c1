/* Designs that outlive the session they were made in: a page that is loaded again, and a file that is read again, go
 * on from them. */
#include "kview/session.h"

#include "kmech/exchange.h"

#include <stdlib.h>
#include <string.h>

/* The frames and parameters that a design has numbers for, in their order. */
static void add_parts(const kv_session *s, km_text *out) {
  for (int f = 0; f < km_model_frame_count(s->model); ++f)
    km_text_format(out, "%d:%s\n", km_model_frame_body(s->model, f), km_model_frame_name(s->model, f));
  for (int p = 0; p < s->parameters.count; ++p)
    km_text_format(out, "%s\n", s->parameters.items[p].name);
  km_text_add(out, "\n");
}

void kv_design_free(kv_design *d) {
  if (!d)
    return;
  km_text_free(&d->parts);
  km_text_free(&d->file);
  free(d->values);
  free(d->places);
  free(d);
}

static bool write_file(const kv_session *s, km_text *out) {
  double *q = kv_session_coordinates(s);
  km_bytes text = {0};
  km_error error;
  bool written = q && !km_model_write(s->model, q, &text, &error);
  if (written)
    km_text_bytes(out, text.data, text.size);
  km_bytes_free(&text);
  free(q);
  return written && !out->failed;
}

kv_design *kv_session_keep(const kv_session *s) {
  if (!s->model || !s->edited)
    return NULL;
  size_t count = (size_t)s->parameters.count;
  kv_design *d = calloc(1, sizeof *d);
  if (!d)
    return NULL;
  d->unsaved = s->unsaved;
  d->values = malloc((count + 1) * sizeof *d->values);
  d->places = kv_frame_places(s->model);
  for (size_t p = 0; d->values && p < count; ++p)
    d->values[p] = s->parameters.items[p].value;
  add_parts(s, &d->parts);
  if (d->values && d->places && !d->parts.failed && write_file(s, &d->file))
    return d;
  kv_design_free(d);
  return NULL;
}

bool kv_session_restore(kv_session *s, const kv_design *d) {
  km_text parts = {0};
  km_error ignored;
  add_parts(s, &parts);
  bool fits = !parts.failed && parts.size == d->parts.size && memcmp(parts.data, d->parts.data, parts.size) == 0;
  km_text_free(&parts);
  if (!fits || (s->parameters.count > 0 && kv_session_set_parameters(s, d->values, &ignored)) ||
      kv_session_set_design(s, d->places, NULL, &ignored))
    return false;
  kv_session_note_edits(s);
  s->unsaved = d->unsaved;
  return kv_session_mark(s, &ignored) == KM_OK;
}
