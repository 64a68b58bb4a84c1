/* Commands on mechanisms of 400 and 2000 loops of every shape: processor time minus that of an empty program. The
 * limits are 0.5 s and 5 s. */
#include "bench.h"
#include "process.h"

#include "support/lattices.h"
#include "support/random_graph.h"
#include "support/sheets.h"

#include <stdio.h>
#include <string.h>

enum { WORDS = 20, RUNS = 3, LIMIT = 20 /* s */ };

/* A mechanism of so many loops, about, in a drawing at which all coordinates are 0. */
typedef struct shape {
  const char *name;
  void (*write)(km_text *out, int loops);
  void (*weave)(km_text *out, int rows, int columns); /* instead of `write` */
  int per_cell;                                       /* loops of a cell of what is woven */
  bool at_corners;                                    /* a loop about each inner corner, in place of one in each cell */
  const char *input, *output; /* joints of kma; no output: no joint drives it, no input: the first one does */
} shape;

static void write_chain_here(km_text *out, int loops) {
  write_drawn_chain(out, loops, 0.0);
}

static void write_five_bars_here(km_text *out, int loops) {
  write_five_bars(out, loops, 0.0);
}

static void write_bars_here(km_text *out, int loops) {
  write_bars(out, loops + 1, 0.0);
}

static void write_trellis_here(km_text *out, int rows, int columns) {
  write_trellis(out, rows, columns, 0.0);
}

static void write_miura_here(km_text *out, int rows, int columns) {
  write_miura(out, rows, columns, 0.0);
}

static void write_near_graph(km_text *out, int loops) {
  write_random_graph(out, loops, 2);
}

static void write_wide_graph(km_text *out, int loops) {
  write_random_graph(out, loops, loops);
}

static void write_ladder(km_text *out, int loops) {
  write_grid(out, 1, loops);
}

static const shape shapes[] = {
    {.name = "chain", .write = write_chain_here, .output = "last"},
    {.name = "folded chain", .write = write_folded_chain, .output = "last"},
    {.name = "five-bars", .write = write_five_bars_here, .output = "last"},
    {.name = "flat five-bars", .write = write_flat_five_bars, .output = "last"},
    {.name = "stretched five-bars", .write = write_stretched_five_bars, .output = "last"},
    {.name = "ball couplers", .write = write_ball_couplers, .output = "j1"},
    {.name = "balls", .write = write_balls},
    {.name = "bars", .write = write_bars_here},
    {.name = "random graph", .write = write_near_graph, .input = "last", .output = "j2"},
    {.name = "wide random graph", .write = write_wide_graph, .input = "last", .output = "j2"},
    {.name = "ladder", .write = write_ladder, .output = "last"},
    {.name = "grid", .weave = write_grid, .per_cell = 1, .output = "last"},
    {.name = "bent grid", .weave = write_bent_grid, .per_cell = 1, .output = "last"},
    {.name = "stiff grid", .weave = write_stiff_grid, .per_cell = 2, .output = "last"},
    {.name = "trellis", .weave = write_trellis_here, .per_cell = 1, .output = "last"},
    {.name = "bent trellis", .weave = write_bent_trellis, .per_cell = 1, .output = "last"},
    {.name = "Miura-ori", .weave = write_miura_here, .per_cell = 1, .at_corners = true, .output = "last"},
    {.name = "flat Miura-ori", .weave = write_flat_miura, .per_cell = 1, .at_corners = true, .output = "last"},
    {.name = "triangles", .weave = write_triangles, .per_cell = 1, .at_corners = true, .output = "last"},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

#define MODEL "model.json"

typedef struct command {
  const char *figure;
  bool drives; /* joints of `--joint`, `--input` and `--output` */
  const char *words[WORDS];
} command;

#define SWEEP "--range", "0:0.1", "--steps", "10", "--format", "csv"
static const command commands[] = {
    {.figure = "info", .words = {BENCH_TOOLS "/kmob", "info", MODEL}},
    {.figure = "check", .words = {BENCH_TOOLS "/kmob", "check", MODEL}},
    {.figure = "draw", .words = {BENCH_TOOLS "/kmob", "draw", MODEL}},
    {.figure = "graph", .words = {BENCH_TOOLS "/kmob", "graph", MODEL}},
    {.figure = "kstatic at", .words = {BENCH_TOOLS "/kstatic", "at", MODEL}},
    {.figure = "sweep", .drives = true, .words = {BENCH_TOOLS "/kmob", "sweep", SWEEP, MODEL, "--joint"}},
    {.figure = "kma sweep",
     .drives = true,
     .words = {BENCH_TOOLS "/kma", "sweep", SWEEP, MODEL, "--joint", "", "--input", "", "--output"}},
};
enum { COMMANDS = sizeof commands / sizeof *commands };

/* As many rows as columns, or fewer. */
static void weave(const shape *s, km_text *out, int loops) {
  int cells = loops / s->per_cell, rows = 1;
  for (int i = 2; i * i <= cells; ++i)
    rows = cells % i ? rows : i;
  s->weave(out, rows + s->at_corners, cells / rows + s->at_corners);
}

static void write_model(const shape *s, int loops, const bench_directory *directory) {
  char path[sizeof directory->path + sizeof MODEL];
  km_text text = {0};
  if (s->write)
    s->write(&text, loops);
  else
    weave(s, &text, loops);
  snprintf(path, sizeof path, "%s/" MODEL, directory->path);
  FILE *file = fopen(path, "w");
  if (!file || fwrite(text.data, 1, text.size, file) != text.size || fclose(file))
    bench_fail("large", "%s can't be written", path);
  km_text_free(&text);
}

/* Milliseconds of the processor, those of the limit where that ended the command. */
static double run(const command *c, const shape *s, const bench_directory *directory) {
  const char *words[WORDS];
  memcpy(words, c->words, sizeof words);
  for (int i = 0; i + 1 < WORDS && c->drives; ++i)
    if (words[i] && strcmp(words[i], "--output") == 0)
      words[i + 1] = s->output;
    else if (words[i] && (strcmp(words[i], "--joint") == 0 || strcmp(words[i], "--input") == 0))
      words[i + 1] = s->input ? s->input : "j0";
  bench_process end = bench_run("large", words, directory, LIMIT);
  if (end.status > 1) /* 1: an answer too, that something is found, or that a part of the range is out of reach */
    bench_fail("large", "%s of %s: exit status %d", c->figure, s->name, end.status);
  return end.ms;
}

/* Median of several; what takes long is run once. */
static double measure(const command *c, const shape *s, const bench_directory *directory) {
  double ms[RUNS];
  for (int i = 0; i < RUNS; ++i)
    if ((ms[i] = run(c, s, directory)) > 2000.0)
      return ms[i];
  return bench_median(ms, RUNS);
}

void bench_large(void) {
  static const command nothing = {.figure = "nothing", .words = {"/bin/true"}};
  bench_directory directory = bench_directory_make("large");
  double least = measure(&nothing, &shapes[0], &directory);
  for (int loops = 400; loops <= 2000; loops *= 5)
    for (int s = 0; s < SHAPES; ++s) {
      write_model(&shapes[s], loops, &directory);
      for (int c = 0; c < COMMANDS; ++c) {
        char figure[80];
        if (commands[c].drives && !shapes[s].output)
          continue;
        snprintf(figure, sizeof figure, "%s, %s, %d loops, CPU ms", commands[c].figure, shapes[s].name, loops);
        bench_figure("large", figure, measure(&commands[c], &shapes[s], &directory) - least);
      }
    }
  bench_directory_remove(&directory);
}
