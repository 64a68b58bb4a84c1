/* kmob graph: bodies, joints, loops and substructures as a graph. */
#include "kmob/kmob.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/report.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct options {
  kt_common common;
  const char *model, *format, *base;
  bool dot, svg;
} options;

static kt_exit read_formats(options *o) {
  const char *rest = o->format ? o->format : "dot";
  for (char last = ','; last == ',';) {
    kt_piece piece = kt_split(&rest, ",");
    bool dot = strcmp(piece.text, "dot") == 0, svg = strcmp(piece.text, "svg") == 0;
    km_free(piece.text);
    if (!dot && !svg)
      return kt_usage(&o->common, "--format", o->format, "some of dot,svg");
    o->dot = o->dot || dot;
    o->svg = o->svg || svg;
    last = piece.separator;
  }
  return KT_DONE;
}

/* The topology alone: loops need not close, so that a model that doesn't assemble can be looked at too. */
static kt_exit describe(const options *o, km_text *dot) {
  kt_exit result;
  km_error error;
  km_mechanism *mechanism = NULL;
  char name[256];
  km_model *model = kt_load(&o->common, o->model, &result);
  if (!model)
    return result;
  int count = km_model_hold_count(model);
  km_hold *holds = KM_NEW(km_hold, (size_t)count);
  for (int h = 0; holds && h < count; ++h)
    holds[h] = km_model_hold_at(model, h);
  km_status status = holds ? km_mechanism_compile(model, holds, count, &mechanism, &error)
                           : km_fail(&error, KM_MEMORY, "out of memory");
  kt_base_name(o->model, name, sizeof name);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else
    km_graph_write(mechanism, name, dot);
  km_free(holds);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return kt_exit_of(status);
}

/* Starts `dot -Tsvg` on a file, with its standard output in the pipe's writing end. 0 or an errno. */
static int start_graphviz(FILE *in, const int pipe_ends[2], pid_t *child) {
  char program[] = "dot", option[] = "-Tsvg";
  char *const argv[] = {program, option, NULL};
  posix_spawn_file_actions_t actions;
  int failed = posix_spawn_file_actions_init(&actions);
  if (failed)
    return failed;
  failed = posix_spawn_file_actions_adddup2(&actions, fileno(in), STDIN_FILENO);
  if (!failed)
    failed = posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
  if (!failed)
    failed = posix_spawnp(child, program, &actions, NULL, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  return failed;
}

static void read_all(int descriptor, km_text *out) {
  char chunk[1 << 14];
  ssize_t size;
  while ((size = read(descriptor, chunk, sizeof chunk)) > 0 || (size < 0 && errno == EINTR))
    if (size > 0)
      km_text_bytes(out, chunk, (size_t)size);
}

/* Runs graphviz on the file. The graph is in a file and not in a second pipe, so that neither side can wait
 * for the other. */
static bool run_graphviz(const options *o, FILE *in, km_text *svg) {
  int ends[2], how = 0;
  pid_t child;
  if (pipe2(ends, O_CLOEXEC) != 0) {
    kt_print_message(&o->common, KM_ERROR, "graphviz can't be started: %s", strerror(errno));
    return false;
  }
  int failed = start_graphviz(in, ends, &child);
  close(ends[1]);
  if (!failed)
    read_all(ends[0], svg);
  close(ends[0]);
  if (failed == ENOENT)
    kt_print_message(&o->common, KM_ERROR,
                     "--format svg: the program \"dot\" isn't found; expected graphviz to be installed "
                     "(Debian: apt-get install graphviz), or --format dot");
  else if (failed)
    kt_print_message(&o->common, KM_ERROR, "graphviz can't be started: %s", strerror(failed));
  if (failed)
    return false;
  while (waitpid(child, &how, 0) < 0 && errno == EINTR)
    ;
  if (how != 0)
    kt_print_message(&o->common, KM_ERROR,
                     "graphviz' \"dot\" failed on the graph; --format dot writes what it was given");
  return how == 0;
}

static kt_exit draw(const options *o, const km_text *dot, km_text *svg) {
  FILE *in = tmpfile();
  bool written = in && fwrite(dot->data, 1, dot->size, in) == dot->size && fflush(in) == 0;
  if (written)
    rewind(in);
  else
    kt_print_message(&o->common, KM_ERROR, "a temporary file can't be written: %s", strerror(errno));
  bool drawn = written && run_graphviz(o, in, svg);
  if (in)
    fclose(in);
  return drawn ? KT_DONE : KT_USAGE;
}

/* Everything is drawn before anything is written. */
static kt_exit run(const options *o) {
  km_text dot = {0}, svg = {0};
  char name[256];
  const char *base = o->base;
  kt_base_name(o->model, name, sizeof name);
  if (!base)
    base = o->dot && o->svg ? name : "-";
  if (kt_is_piped(base) && o->dot && o->svg) {
    kt_print_message(&o->common, KM_ERROR, "-o -: found two formats; expected one for the standard output");
    return KT_USAGE;
  }
  kt_exit result = describe(o, &dot);
  if (result == KT_DONE && dot.failed)
    result = KT_NO_MEMORY;
  if (result == KT_DONE && o->svg)
    result = draw(o, &dot, &svg);
  if (result == KT_DONE && o->dot)
    result = kt_write(&o->common, base, "graph", "dot", &dot);
  if (result == KT_DONE && o->svg)
    result = kt_write(&o->common, base, "graph", "svg", &svg);
  km_text_free(&dot);
  km_text_free(&svg);
  return result;
}

kt_exit kmob_graph(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"format", 0, "LIST", "Some of dot,svg (default dot); svg needs graphviz' program `dot`",
       KT_TEXT_OF("dot or svg"), &o.format, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Write BASE.graph.FORMAT (default: one format goes to the standard output, several into files "
                       "with the model's name)"),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  kt_options_read(&all,
                  "Bodies, joints, loops and kinematic substructures as a graph, in the DOT language or drawn by "
                  "graphviz.",
                  argc, argv);
  kt_exit result = read_formats(&o);
  return result == KT_DONE ? run(&o) : result;
}
