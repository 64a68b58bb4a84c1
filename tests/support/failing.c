#include "support/failing.h"

#include <stdlib.h>

static long calls, failing;

void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);

void failing_arm(long n) {
  calls = 0;
  failing = n;
}

long failing_calls(void) {
  return calls;
}

bool failing_next(void) {
  return ++calls == failing;
}

void *__wrap_calloc(size_t count, size_t size) {
  return failing_next() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size) {
  return failing_next() ? NULL : __real_realloc(block, size);
}
