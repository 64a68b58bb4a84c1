/* Feeds kview's sessions with messages that no page sends: verbs with any arguments, and damaged bytes.
 *
 *   fuzz_view N SEED MODELS...   N messages; a session goes on for 2000 of them, then takes the next model
 *
 * Run it under sanitizers: it ends by itself only where an answer isn't one, or leaves the loops open. */
#include "kview/messages.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST = 4096, SESSION = 2000 };

static uint64_t seed;

static uint64_t draw(void) { /* splitmix64 */
  uint64_t z = (seed += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

static int below(int count) {
  return (int)(draw() % (uint64_t)count);
}

static double between(double low, double high) {
  return low + (high - low) * (double)(draw() >> 11) / 9007199254740992.0;
}

/* Verbs with how many arguments they want; those that search for long come rarely. */
static const struct {
  const char *word;
  int arguments, share;
} verbs[] = {{"hello", 1, 10},   {"pose", 0, 10},       {"joint", 2, 200},  {"point", 10, 200}, {"place", 7, 20},
             {"hold", 2, 30},    {"mark", 0, 40},       {"undo", 1, 60},    {"ask", 5, 10},     {"again", 0, 5},
             {"track", 1, 4},    {"motions", 0, 20},    {"diagnose", 0, 1}, {"forces", 0, 30},  {"lever", 2, 30},
             {"modes", 1, 1},    {"mode", 1, 10},       {"pivot", 4, 80},   {"frame", 4, 80},   {"design", 9, 10},
             {"patch", 2, 10},   {"selfmotion", 1, 1},  {"write", 0, 10},   {"reload", 0, 1},   {"named", 1, 10},
             {"columns", 2, 10}, {"parameters", 2, 10}, {"map", 7, 1},      {"mapping", 8, 1},  {"mapped", 0, 2},
             {"stop", 0, 2},     {"boundary", 0, 2},    {"singular", 0, 2}, {"fly", 1, 5}};
enum { VERBS = (int)(sizeof verbs / sizeof *verbs) };

static int pick_verb(void) {
  int all = 0, v = 0;
  for (int i = 0; i < VERBS; ++i)
    all += verbs[i].share;
  for (int at = below(all); (at -= verbs[v].share) >= 0;)
    ++v;
  return v;
}

static int argument(char *out, size_t room) {
  static const char *const words[] = {"nan", "inf",  "-inf", "1e308", "-1e308",      "1e-320",    "x",
                                      "",    "0x10", "1e",   "-",     "99999999999", "2147483648"};
  int kind = below(20);
  if (kind < 10)
    return snprintf(out, room, " %d", below(24));
  if (kind < 17)
    return snprintf(out, room, " %.6g", between(-4.0, 4.0));
  if (kind < 19)
    return snprintf(out, room, " %.3g", between(-1e6, 1e6));
  return snprintf(out, room, " %s", words[below((int)(sizeof words / sizeof *words))]);
}

static size_t make(char *out) {
  int verb = pick_verb(), count = verbs[verb].arguments;
  int size = snprintf(out, LONGEST, "%d %s", below(1000), verbs[verb].word);
  if (below(20) == 0)
    count = below(12);
  for (int i = 0; i < count; ++i)
    size += argument(out + size, LONGEST - (size_t)size);
  for (int damage = below(8) == 0 ? 1 + below(4) : 0; damage > 0 && size > 0; --damage)
    out[below(size)] = (char)below(256);
  return (size_t)size;
}

static void fail(const kv_session *s, const char *what, const char *message, size_t size) {
  fprintf(stderr, "fuzz_view: %s: %s (loops open by %g): %.*s\n", s->opening.path, what, s->mobility.residual,
          (int)size, message);
  exit(1);
}

static void check(const kv_session *s, const kv_answer *answer, const char *message, size_t size) {
  static const char begin[] = "{\"kind\":\"";
  if (answer->bytes.failed || answer->bytes.size < 8)
    fail(s, "no answer", message, size);
  if (!answer->binary &&
      (memcmp(answer->bytes.data, begin, sizeof begin - 1) != 0 || answer->bytes.data[answer->bytes.size - 1] != '}'))
    fail(s, "a broken answer", message, size);
  if (!s->model || !(s->mobility.residual <= 1e-6))
    fail(s, "the loops are open", message, size);
}

static void open_model(kv_session *s, const char *path) {
  km_error error;
  kv_session_close(s);
  *s = (kv_session){.opening = {.path = path}, .asked = {.kind = -1}};
  if (kv_session_load(s, &error)) {
    fprintf(stderr, "fuzz_view: %s: %s\n", path, error.text);
    exit(2);
  }
}

int main(int argc, char **argv) {
  if (argc < 4) {
    fprintf(stderr, "usage: fuzz_view N SEED MODELS...\n");
    return 2;
  }
  long count = strtol(argv[1], NULL, 10);
  char message[LONGEST];
  kv_session session = {.asked = {.kind = -1}};
  seed = strtoull(argv[2], NULL, 10);
  for (long i = 0; i < count; ++i) {
    if (i % SESSION == 0)
      open_model(&session, argv[3 + (i / SESSION) % (argc - 3)]);
    size_t size = make(message);
    kv_answer answer;
    kv_answer_message(&session, message, size, &answer);
    check(&session, &answer, message, size);
    km_text_free(&answer.bytes);
  }
  kv_session_close(&session);
  printf("%ld messages\n", count);
  return 0;
}
