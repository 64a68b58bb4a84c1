/* A progress bar on a terminal, after the first second; the end of long work by a signal. */
#include "common/common.h"

#include <signal.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

double kt_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static volatile sig_atomic_t interrupted;
static struct sigaction before_interrupt, before_termination;

static void interrupt(int signal_number) {
  interrupted = signal_number;
}

void kt_interrupts_catch(void) {
  const struct sigaction action = {.sa_handler = interrupt, .sa_flags = (int)SA_RESETHAND};
  sigaction(SIGINT, &action, &before_interrupt);
  sigaction(SIGTERM, &action, &before_termination);
}

void kt_interrupts_release(void) {
  sigaction(SIGINT, &before_interrupt, NULL);
  sigaction(SIGTERM, &before_termination, NULL);
}

bool kt_is_interrupted(void) {
  return interrupted != 0;
}

kt_progress kt_progress_start(const kt_common *common) {
  return (kt_progress){
      .shown = !common->quiet && common->jobs == 1 && isatty(STDERR_FILENO), .start = kt_clock(), .last = kt_clock()};
}

bool kt_progress_show(void *context, double done) {
  kt_progress *p = context;
  double time = p->shown ? kt_clock() : 0.0;
  if (!p->shown || time - p->start < 1.0 || time - p->last < 0.1)
    return !interrupted;
  p->last = time;
  p->drawn = true;
  fprintf(stderr, "\r%3.0f %% ", 100.0 * done);
  return !interrupted;
}

void kt_progress_end(kt_progress *p) {
  if (p->drawn)
    fputs("\r      \r", stderr);
}
