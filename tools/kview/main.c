/* kview's commands. */
#include "kview/kview.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const kt_command commands[] = {
    {"open", "a page in the browser, where the mechanism moves by hand (`kview MODEL` for short)", kview_open},
    {"export", "the motion as one page that needs no server", kview_export},
    {0}};

static bool is_command(const char *word) {
  for (const kt_command *c = commands; c->name; ++c)
    if (strcmp(c->name, word) == 0)
      return true;
  return false;
}

/* `kview MODEL` is short for `kview open MODEL`. */
int main(int argc, char **argv) {
  static char open[] = "open";
  static const char about[] = "A mechanism in the hand: moved, seen through and changed in the browser.";
  bool model = argc > 1 && (argv[1][0] != '-' || !argv[1][1]) && !is_command(argv[1]);
  char **words = calloc((size_t)argc + 2, sizeof *words);
  if (!words) {
    fputs("kview: out of memory\n", stderr);
    return KT_INTERNAL;
  }
  int count = 0;
  for (int i = 0; i < argc; ++i) {
    if (i == 1 && model)
      words[count++] = open;
    words[count++] = argv[i];
  }
  kt_exit result = kt_run("kview", about, commands, count, words);
  free(words);
  return (int)result;
}
