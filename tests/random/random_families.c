/* Runs the families of random cases over new seeds: random_families SECONDS SEED [WORD]. Each family whose name
 * contains WORD gets an equal share of the time, at least one case, and counts agreements with its reference. Cases
 * run in child processes, so that a crash or an endless case is counted, too. */
#include "support/families.h"
#include "support/motion_families.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { LONGEST = 300 }; /* seconds that a case may take */

typedef struct count {
  unsigned long agreed, disagreed, undecided, broken;
} count;

enum { DISAGREES, AGREES, UNDECIDED };

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The cases from `seed` on, until the time is over: a byte to the pipe for each. */
static void run_cases(const family *f, uint64_t seed, double end, int pipe_end) {
  do {
    char verdict = f->agrees(seed) ? AGREES : DISAGREES;
    verdict = family_is_undecided() ? UNDECIDED : verdict;
    if (verdict == DISAGREES)
      fprintf(stderr, "%s disagrees at seed %llu\n", f->name, (unsigned long long)seed);
    if (write(pipe_end, &verdict, 1) != 1)
      break;
    ++seed;
  } while (now() < end);
}

/* Starts the child; −1 if it can't be started. */
static pid_t start(const family *f, uint64_t seed, double end, int *out) {
  int ends[2];
  if (pipe(ends) != 0)
    return -1;
  pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    run_cases(f, seed, end, ends[1]);
    _exit(0);
  }
  close(ends[1]);
  *out = ends[0];
  return child;
}

/* Counts the verdicts that come; returns how many. A case that takes too long ends its child. */
static uint64_t gather(pid_t child, int pipe_end, count *c) {
  uint64_t cases = 0;
  struct pollfd wait_for = {.fd = pipe_end, .events = POLLIN};
  for (char verdict;;) {
    if (poll(&wait_for, 1, LONGEST * 1000) == 0)
      kill(child, SIGKILL);
    ssize_t got = read(pipe_end, &verdict, 1);
    if (got < 0 && errno == EINTR)
      continue;
    if (got != 1)
      return cases;
    ++cases;
    c->agreed += verdict == AGREES;
    c->disagreed += verdict == DISAGREES;
    c->undecided += verdict == UNDECIDED;
  }
}

static count run_family(const family *f, uint64_t seed, double seconds) {
  count c = {0};
  double end = now() + seconds;
  bool first = true;
  while (first || now() < end) {
    int pipe_end, how = 0;
    pid_t child = start(f, seed, end, &pipe_end);
    if (child < 0) {
      perror("a case can't be started");
      exit(2);
    }
    seed += gather(child, pipe_end, &c);
    close(pipe_end);
    waitpid(child, &how, 0);
    if (how != 0) {
      fprintf(stderr, "%s breaks at seed %llu\n", f->name, (unsigned long long)seed);
      ++c.broken;
      ++seed;
    }
    first = false;
  }
  return c;
}

int main(int argc, char **argv) {
  double seconds = argc > 1 ? strtod(argv[1], NULL) : 0.0;
  uint64_t seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
  const char *word = argc > 3 ? argv[3] : "";
  int families = 0;
  unsigned long wrong = 0;
  for (const family *f = all_families; f->name; ++f)
    families += strstr(f->name, word) != NULL;
  if (argc < 3 || seconds <= 0.0 || families == 0) {
    fprintf(stderr, "usage: random_families SECONDS SEED [WORD of a family's name]\n");
    return 2;
  }
  for (const family *f = all_families; f->name; ++f) {
    if (!strstr(f->name, word))
      continue;
    count c = run_family(f, seed, seconds / families);
    printf("%-20s %8lu of %lu agree", f->name, c.agreed, c.agreed + c.disagreed + c.undecided + c.broken);
    if (c.undecided)
      printf(", %lu undecided", c.undecided);
    printf(c.broken ? ", %lu break\n" : "\n", c.broken);
    fflush(stdout);
    wrong += c.disagreed + c.broken;
  }
  printf("seeds from %llu on: %lu wrong\n", (unsigned long long)seed, wrong);
  return wrong ? 1 : 0;
}
