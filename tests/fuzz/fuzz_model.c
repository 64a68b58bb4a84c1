/* Feeds damaged models to the reader and, what it accepts, to the compiler, the assembly, the
 * mobility analysis and a short sweep.
 *
 *   fuzz_model N SEED FILES...        N inputs; input i is made from SEED + i alone, so each can be made again
 *   fuzz_model --replay FILES...      the files as they are (the corpus)
 *   fuzz_model --emit SEED FILES...   writes the input of that seed to the standard output
 *
 * Run it under sanitizers: it ends by itself only on a wrong answer (an error without words, a
 * status that no bad model may give, a mobility that can't be) or on an input that takes longer
 * than 20 s of processor time, and then says which seed it was. */
#include "judge.h"
#include "mutations.h"

#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

enum { MOST_FILES = 1024, SECONDS = 20 };

static const char *current = "?";       /* input being read, for the final message */
static unsigned long long current_seed; /* 0 with a file name instead */

static void say(const char *text) {
  ssize_t written = write(STDERR_FILENO, text, strlen(text));
  (void)written;
}

static void last_words(void) {
  char digits[24];
  size_t i = sizeof digits - 1;
  digits[i] = '\0';
  unsigned long long n = current_seed;
  do
    digits[--i] = (char)('0' + n % 10);
  while ((n /= 10) > 0);
  say("\nfuzz_model: it happened with ");
  say(current);
  say(" ");
  say(current_seed ? digits + i : "");
  say("\n");
}

static void on_signal(int number) {
  say(number == SIGPROF ? "\nfuzz_model: too slow" : "");
  last_words();
  _exit(1);
}

/* Called by the sanitizers' runtime; without one the reference stays null. */
extern void __sanitizer_set_death_callback(void (*callback)(void)) __attribute__((weak));

_Noreturn void fuzz_fail(const char *what) {
  say("fuzz_model: ");
  say(what);
  last_words();
  exit(1);
}

static input read_file(const char *path) {
  FILE *file = fopen(path, "rb");
  input in = {malloc(LONGEST), 0};
  if (!file || !in.bytes) {
    fprintf(stderr, "fuzz_model: %s: %s\n", path, strerror(errno));
    exit(2);
  }
  in.size = fread(in.bytes, 1, LONGEST, file);
  fclose(file);
  return in;
}

static void set_timer(int seconds) {
  struct itimerval timer = {.it_value.tv_sec = seconds};
  setitimer(ITIMER_PROF, &timer, NULL);
}

static int feed(const input *in, size_t choice) {
  set_timer(SECONDS);
  int depth = fuzz_model(in->bytes, in->size, choice);
  set_timer(0);
  return depth;
}

static void listen_for_trouble(void) {
  signal(SIGPROF, on_signal);
  signal(SIGABRT, on_signal);
  if (__sanitizer_set_death_callback)
    __sanitizer_set_death_callback(last_words);
}

int main(int argc, char **argv) {
  bool replay = argc > 2 && strcmp(argv[1], "--replay") == 0, emit = argc > 3 && strcmp(argv[1], "--emit") == 0;
  int first = replay ? 2 : 3;
  size_t count = argc > first ? (size_t)(argc - first) : 0, depths[3] = {0};
  input files[MOST_FILES];
  if (count == 0 || count > MOST_FILES) {
    fprintf(stderr, "usage: fuzz_model N SEED FILES... | --replay FILES... | --emit SEED FILES...\n");
    return 2;
  }
  for (size_t i = 0; i < count; ++i)
    files[i] = read_file(argv[first + (int)i]);
  listen_for_trouble();
  unsigned long long seed = replay ? 0 : strtoull(argv[2], NULL, 10);
  unsigned long long inputs = replay ? count : emit ? 0 : strtoull(argv[1], NULL, 10);
  for (unsigned long long i = 0; i < inputs; ++i) {
    input in = replay ? files[i] : mutation_make(seed + i, files, count);
    current = replay ? argv[first + (int)i] : "seed";
    current_seed = replay ? 0 : seed + i;
    depths[feed(&in, (size_t)(seed + i))]++;
    if (!replay)
      free(in.bytes);
  }
  if (emit) {
    input in = mutation_make(seed, files, count);
    fwrite(in.bytes, 1, in.size, stdout);
    free(in.bytes);
  } else {
    printf("%llu inputs: %zu refused, %zu read but not assembled, %zu assembled\n", inputs, depths[0], depths[1],
           depths[2]);
  }
  for (size_t i = 0; i < count; ++i)
    free(files[i].bytes);
  return 0;
}
