/* Messages of a page to kview, a line each; the first byte chooses the model. Every answer is one, and the loops stay
 * closed. */
#include "target.h"

#include "kview/messages.h"

#include <string.h>

enum { MOST_MESSAGES = 40 };

static const char *const models[] = {MODELS_DIR "/fourbar.json", MODELS_DIR "/slider_crank.json",
                                     MODELS_DIR "/robot7r.json", MODELS_DIR "/delta.json"};

static void tell(kv_session *s, const char *message, size_t size) {
  static const char begin[] = "{\"kind\":\"";
  kv_answer answer;
  kv_answer_message(s, message, size, &answer);
  if (answer.bytes.failed || answer.bytes.size < 8)
    fuzz_fail("no answer");
  if (!answer.binary &&
      (memcmp(answer.bytes.data, begin, sizeof begin - 1) != 0 || answer.bytes.data[answer.bytes.size - 1] != '}'))
    fuzz_fail("a broken answer");
  if (!s->model || !(s->mobility.residual <= 1e-6))
    fuzz_fail("the loops are open");
  km_text_free(&answer.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 2)
    return 0;
  km_error error;
  kv_session session = {.opening = {.path = models[data[0] % 4]}, .asked = {.kind = -1}};
  if (kv_session_load(&session, &error))
    fuzz_fail(error.text);
  const char *at = (const char *)data + 1, *end = (const char *)data + size;
  for (int i = 0; i < MOST_MESSAGES && at < end; ++i) {
    const char *line = memchr(at, '\n', (size_t)(end - at));
    size_t length = (size_t)((line ? line : end) - at);
    tell(&session, at, length);
    at += length + 1;
  }
  kv_session_close(&session);
  return 0;
}
