/* A whole command, from the shell's point of view: kmob sweep models/brake.json, 200 steps, CSV and SVG. */
#include "bench.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RUNS = 15 };
static const char name[] = "command/brake";

static void become_kmob(const char *directory) {
  int null = open("/dev/null", O_WRONLY);
  if (chdir(directory) || null < 0 || dup2(null, STDOUT_FILENO) < 0 || dup2(null, STDERR_FILENO) < 0)
    _exit(126);
  execl(BENCH_KMOB, "kmob", "sweep", "--steps", "200", "--format", "csv,svg", BENCH_MODELS "/brake.json", (char *)NULL);
  _exit(127);
}

/* Milliseconds of wall time. */
static double run(const char *directory) {
  double start = bench_now();
  int status;
  pid_t child = fork();
  if (child == 0)
    become_kmob(directory);
  if (child < 0 || waitpid(child, &status, 0) < 0)
    bench_fail(name, "the command can't be started");
  double end = bench_now();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    bench_fail(name, "%s failed", BENCH_KMOB);
  return 1e3 * (end - start);
}

/* Lines of the CSV file; the files are removed. */
static int take_files(const char *directory) {
  int lines = 0, pictures = 0;
  DIR *list = opendir(directory);
  for (struct dirent *entry; list && (entry = readdir(list));) {
    char path[1024];
    if (entry->d_name[0] == '.')
      continue;
    snprintf(path, sizeof path, "%s/%s", directory, entry->d_name);
    pictures += strstr(entry->d_name, ".svg") != NULL;
    FILE *file = strstr(entry->d_name, ".csv") ? fopen(path, "r") : NULL;
    for (int c; file && (c = getc(file)) != EOF;)
      lines += c == '\n';
    if (file)
      fclose(file);
    unlink(path);
  }
  if (list)
    closedir(list);
  if (pictures != 1)
    bench_fail(name, "%d pictures instead of 1", pictures);
  return lines;
}

void bench_command(void) {
  char directory[] = "/tmp/kmech_bench_XXXXXX";
  double ms[RUNS];
  if (!mkdtemp(directory))
    bench_fail(name, "no temporary directory");
  run(directory); /* into the page cache */
  int lines = take_files(directory);
  if (lines < 202)
    bench_fail(name, "%d lines in the CSV file, not a header and 201 rows", lines);
  for (int i = 0; i < RUNS; ++i)
    ms[i] = run(directory);
  take_files(directory);
  rmdir(directory);
  bench_figure(name, "ms", bench_median(ms, RUNS));
}
