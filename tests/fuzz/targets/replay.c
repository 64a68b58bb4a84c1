/* Gives a target the files of a corpus, as a test. Usage: replay_TARGET FILES... */
#include "target.h"

#include <stdio.h>
#include <stdlib.h>

static void replay(const char *path) {
  FILE *file = fopen(path, "rb");
  uint8_t *bytes = malloc(1 << 20);
  if (!file || !bytes) {
    fprintf(stderr, "%s: can't be read\n", path);
    exit(2);
  }
  size_t size = fread(bytes, 1, 1 << 20, file);
  fclose(file);
  fprintf(stderr, "%s\n", path);
  LLVMFuzzerTestOneInput(bytes, size);
  free(bytes);
}

int main(int argc, char **argv) {
  for (int i = 1; i < argc; ++i)
    replay(argv[i]);
  printf("%d inputs\n", argc - 1);
  return argc > 1 ? 0 : 2;
}
