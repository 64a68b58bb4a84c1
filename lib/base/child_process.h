/* Child processes: programs of kmech that the library starts and whose standard output it reads. A crash or an
 * endless loop of the child doesn't affect the caller. */
#ifndef KM_BASE_CHILD_PROCESS_H
#define KM_BASE_CHILD_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <sys/types.h>

typedef struct km_helper {
  pid_t process;
  FILE *output;
} km_helper;

/* Starts the program `name` with one argument, without input; its standard error is discarded. Returns NULL, or the
 * reason of a failure: static or thread-local text, valid until the next call in this thread. km_helper_end must be
 * called after success. Safe in a process with several threads: nothing of the caller runs between fork and exec.
 * The program lies in the folder KMECH_LIBEXEC of the environment, or in libexec/kmech of the folder that holds the
 * library (the shared library, else the program) or of one of the two folders above it, or in the configured
 * installation folder. So a build folder and an installation that was moved both work. */
const char *km_helper_start(km_helper *helper, const char *name, const char *argument);
/* Reads `size` bytes; false if the output ends before. */
bool km_helper_read(km_helper *helper, void *out, size_t size);
/* Closes the output and waits for the end. Returns the signal that ended the program; 0 if it exited, or if its
 * status is unknown because the process ignores SIGCHLD. */
int km_helper_end(km_helper *helper);

#endif
