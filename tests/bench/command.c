/* Whole commands, from the shell's point of view: processor's time over that of a program that does nothing, in
 * turn. */
#include "bench.h"
#include "process.h"

#include <stdio.h>

enum { RUNS = 15, WORDS = 10, LIMIT = 60 };

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

/* Milliseconds of the processor. */
static double run(const command *c, const bench_directory *directory) {
  bench_process end = bench_run("command", c->words, directory, LIMIT);
  if (end.status != 0)
    bench_fail("command", "%s failed", c->figure);
  return end.ms;
}

void bench_command(void) {
  bench_directory directory = bench_directory_make("command");
  for (int c = 0; c < COMMANDS; ++c) {
    run(&commands[c], &directory); /* reads files into the page cache */
    int files = bench_take_files(&directory);
    if (files != commands[c].files)
      bench_fail("command", "%s: %d files instead of %d", commands[c].figure, files, commands[c].files);
  }
  for (int i = 0; i < RUNS; ++i)
    for (int c = 0; c < COMMANDS; ++c)
      commands[c].ms[i] = run(&commands[c], &directory);
  bench_directory_remove(&directory);
  double nothing = bench_median(commands[0].ms, RUNS);
  for (int c = 1; c < COMMANDS; ++c) {
    char figure[80];
    snprintf(figure, sizeof figure, "%s, CPU ms", commands[c].figure);
    bench_figure("command", figure, bench_median(commands[c].ms, RUNS) - nothing);
  }
}
