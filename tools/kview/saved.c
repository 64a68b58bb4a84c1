/* The model as it stands: its file's text with the present pose and design. */
#include "kview/messages.h"

#include "kmech/write.h"

#include <stdlib.h>

/* write: the text of a file with the present pose and design. */
km_status kv_write(const kv_call *c, km_error *error) {
  const kv_session *s = c->session;
  double *q = kv_session_coordinates(s);
  km_bytes text = {0};
  km_status status = q ? km_model_write(s->model, q, &text, error) : km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    km_text_format(&c->answer->bytes, "{\"kind\":\"file\",\"request\":%u,\"text\":", c->request);
    kv_add_string(&c->answer->bytes, text.data);
    km_text_add(&c->answer->bytes, "}");
  }
  km_bytes_free(&text);
  free(q);
  return status;
}
