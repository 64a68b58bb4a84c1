/* Whole commands, each a process of its own in a directory for what it writes. */
#ifndef BENCH_PROCESS_H
#define BENCH_PROCESS_H

/* A new directory; bench_directory_remove removes it with its files. */
typedef struct bench_directory {
  char path[32];
} bench_directory;
bench_directory bench_directory_make(const char *bench);
void bench_directory_remove(const bench_directory *directory);
/* Removes all files, and returns how many had something in them. */
int bench_take_files(const bench_directory *directory);

/* Exit status of a process, and its user and system processor time in milliseconds. */
typedef struct bench_process {
  int status; /* -1: the limit ended it */
  double ms;
} bench_process;
/* Runs a program by its words (NULL at the end), which ends after `limit` seconds of the processor. */
bench_process bench_run(const char *bench, const char *const *words, const bench_directory *directory, int limit);

#endif
