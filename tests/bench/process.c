/* Starting commands, waiting for them, and counting what they wrote. */
#include "process.h"

#include "bench.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

bench_directory bench_directory_make(const char *bench) {
  bench_directory directory = {"/tmp/kmech_bench_XXXXXX"};
  if (!mkdtemp(directory.path))
    bench_fail(bench, "no temporary directory");
  return directory;
}

void bench_directory_remove(const bench_directory *directory) {
  bench_take_files(directory);
  rmdir(directory->path);
}

int bench_take_files(const bench_directory *directory) {
  int files = 0;
  DIR *list = opendir(directory->path);
  for (struct dirent *entry; list && (entry = readdir(list));) {
    char path[1024];
    if (entry->d_name[0] == '.')
      continue;
    snprintf(path, sizeof path, "%s/%s", directory->path, entry->d_name);
    FILE *file = fopen(path, "r");
    files += file && getc(file) != EOF;
    if (file)
      fclose(file);
    unlink(path);
  }
  if (list)
    closedir(list);
  return files;
}

static _Noreturn void become(const char *const *words, const bench_directory *directory, int limit) {
  const struct rlimit most = {(rlim_t)limit, (rlim_t)limit + 1};
  int null = open("/dev/null", O_WRONLY);
  if (chdir(directory->path) || null < 0 || dup2(null, STDOUT_FILENO) < 0 || dup2(null, STDERR_FILENO) < 0 ||
      setrlimit(RLIMIT_CPU, &most))
    _exit(126);
  execv(words[0], (char *const *)words);
  _exit(127);
}

static double milliseconds(struct timeval t) {
  return 1e3 * (double)t.tv_sec + 1e-3 * (double)t.tv_usec;
}

bench_process bench_run(const char *bench, const char *const *words, const bench_directory *directory, int limit) {
  int status;
  struct rusage used;
  pid_t child = fork();
  if (child == 0)
    become(words, directory, limit);
  if (child < 0 || wait4(child, &status, 0, &used) < 0)
    bench_fail(bench, "%s can't be started", words[0]);
  double ms = milliseconds(used.ru_utime) + milliseconds(used.ru_stime);
  if (WIFSIGNALED(status) && WTERMSIG(status) != SIGXCPU)
    bench_fail(bench, "%s %s was ended by signal %d", words[0], words[1] ? words[1] : "", WTERMSIG(status));
  return (bench_process){WIFEXITED(status) ? WEXITSTATUS(status) : -1, ms};
}
