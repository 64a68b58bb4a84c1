/* Progress callback of Python: after 20 ms of work at the earliest, so that its cost is negligible. */
#include <kmech/kmech.h>

#include <time.h>

static bool kmech_python_progress(void *context, double done);

typedef struct kmech_watch {
  void *handle; /* handle of the Python callback */
  double last;  /* seconds */
} kmech_watch;

static double seconds(void) {
  struct timespec now;
#ifdef CLOCK_MONOTONIC_COARSE
  clock_gettime(CLOCK_MONOTONIC_COARSE, &now); /* a tenth of the price; good to 4 ms */
#else
  clock_gettime(CLOCK_MONOTONIC, &now);
#endif
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool kmech_progress(void *context, double done) {
  kmech_watch *watch = context;
  if (seconds() - watch->last < 0.02)
    return true;
  bool goes_on = kmech_python_progress(watch->handle, done);
  watch->last = seconds(); /* the call may wait for other threads of Python */
  return goes_on;
}

static km_progress kmech_progress_function(void) {
  return kmech_progress;
}
