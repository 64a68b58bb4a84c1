/* Damages texts token by token as often as byte by byte. */
#include "mutations.h"
#include "target.h"

#include <stdlib.h>
#include <string.h>

/* libFuzzer's own. */
extern size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  if (seed % 2 == 0 || size == 0 || size > LONGEST)
    return LLVMFuzzerMutate(data, size, room);
  const input from = {(char *)data, size};
  input made = mutation_make(seed, &from, 1);
  size_t kept = made.size < room ? made.size : room;
  memcpy(data, made.bytes, kept);
  free(made.bytes);
  return kept;
}
