/* Programs of kmech's own that the library starts, whose standard output it reads. What they do can neither crash nor stop
 * the caller. */
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

/* Starts `name` with one argument; it has no input, and its messages are dropped. NULL, or why it can't be started: static text or the thread's own, good until the next call in
 * this thread. After success km_helper_end is due. Safe in a process of several threads: nothing of the caller runs between fork and exec.
 *
 * The program lies in the folder KMECH_LIBEXEC of the environment, in libexec/kmech of the folder of the file that holds the
 * library (the shared library, else the program) or of one of the two folders above that, or where kmech was configured to be
 * installed: so it is found in a build folder and in an installation that was moved. */
const char *km_helper_start(km_helper *helper, const char *name, const char *argument);
/* Reads so many bytes; false if the output ends before. */
bool km_helper_read(km_helper *helper, void *out, size_t size);
/* Closes the output and waits for the end. Returns the signal that ended the program; 0: it ended by itself, or its status can't be
 * had since the caller's process ignores SIGCHLD. */
int km_helper_end(km_helper *helper);

#endif
