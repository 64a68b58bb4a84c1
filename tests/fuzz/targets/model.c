/* A model's text, in any format: read, closed, balanced, swept, and every joint recomputed. */
#include "target.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  fuzz_model(data, size, size);
  return 0;
}
