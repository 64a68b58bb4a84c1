/* Whole commands, from the shell's point of view: processor's time over that of a program that does nothing, in turn. */
#include "bench.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RUNS = 15, WORDS = 10 };

#define BRAKE BENCH_MODELS "/brake.json"

typedef struct command {
  const char *figure;
  int files; /* that it writes */
  const char *words[WORDS];
  double ms[RUNS];
} command;

static command commands[] = {
    {.figure = "nothing", .words = {"/bin/true"}},
    {.figure = "info", .words = {BENCH_TOOLS "/kmob", "info", BRAKE}},
    {.figure = "csv", .files = 1, .words = {BENCH_TOOLS "/kmob", "sweep", "--steps", "200", "--format", "csv", BRAKE}},
    {.figure = "csv and svg",
     .files = 2,
     .words = {BENCH_TOOLS "/kmob", "sweep", "--steps", "200", "--format", "csv,svg", BRAKE}},
    {.figure = "png", .files = 1, .words = {BENCH_TOOLS "/kmob", "sweep", "--steps", "200", "--format", "png", BRAKE}},
    {.figure = "pdf", .files = 1, .words = {BENCH_TOOLS "/kmob", "sweep", "--steps", "200", "--format", "pdf", BRAKE}},
    {.figure = "report, html",
     .files = 1,
     .words = {BENCH_TOOLS "/kma", "report", "--steps", "200", "--format", "html", BRAKE}},
    {.figure = "report, pdf",
     .files = 1,
     .words = {BENCH_TOOLS "/kma", "report", "--steps", "200", "--format", "pdf", BRAKE}},
    {.figure = "draw --meshes", .files = 1, .words = {BENCH_TOOLS "/kmob", "draw", "--meshes", BRAKE}},
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static void become(const command *c, const char *directory) {
  int null = open("/dev/null", O_WRONLY);
  if (chdir(directory) || null < 0 || dup2(null, STDOUT_FILENO) < 0 || dup2(null, STDERR_FILENO) < 0)
    _exit(126);
  execv(c->words[0], (char *const *)c->words);
  _exit(127);
}

static double milliseconds(struct timeval t) {
  return 1e3 * (double)t.tv_sec + 1e-3 * (double)t.tv_usec;
}

/* Milliseconds of the processor, of the user and the system. */
static double run(const command *c, const char *directory) {
  int status;
  struct rusage used;
  pid_t child = fork();
  if (child == 0)
    become(c, directory);
  if (child < 0 || wait4(child, &status, 0, &used) < 0)
    bench_fail("command", "%s can't be started", c->words[0]);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    bench_fail("command", "%s failed", c->figure);
  return milliseconds(used.ru_utime) + milliseconds(used.ru_stime);
}

/* Files that have something in them; all are removed. */
static int take_files(const char *directory) {
  int files = 0;
  DIR *list = opendir(directory);
  for (struct dirent *entry; list && (entry = readdir(list));) {
    char path[1024];
    if (entry->d_name[0] == '.')
      continue;
    snprintf(path, sizeof path, "%s/%s", directory, entry->d_name);
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

void bench_command(void) {
  char directory[] = "/tmp/kmech_bench_XXXXXX";
  if (!mkdtemp(directory))
    bench_fail("command", "no temporary directory");
  for (int c = 0; c < COMMANDS; ++c) {
    run(&commands[c], directory); /* into the page cache */
    int files = take_files(directory);
    if (files != commands[c].files)
      bench_fail("command", "%s: %d files instead of %d", commands[c].figure, files, commands[c].files);
  }
  for (int i = 0; i < RUNS; ++i)
    for (int c = 0; c < COMMANDS; ++c)
      commands[c].ms[i] = run(&commands[c], directory);
  take_files(directory);
  rmdir(directory);
  double nothing = bench_median(commands[0].ms, RUNS);
  for (int c = 1; c < COMMANDS; ++c) {
    char figure[80];
    snprintf(figure, sizeof figure, "%s, CPU ms", commands[c].figure);
    bench_figure("command", figure, bench_median(commands[c].ms, RUNS) - nothing);
  }
}
