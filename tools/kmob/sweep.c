/* kmob sweep: mobility numbers over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

#include "report/mobility_plot.h"
#include "report/mobility_record.h"

enum { OPTION_POINT = 0x3101 };

static const struct argp_option table[] = {
    {"point", OPTION_POINT, "BODY/FRAME", 0, "Add the path of a frame's origin (repeatable)", 1},
    KT_FORMAT_OPTION,
    {"output", 'o', "BASE", 0, "Files are BASE.mobility.FORMAT (default: the model's name); - is the standard output",
     2},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kt_sweep_options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = o;
    return 0;
  case OPTION_POINT:
    kt_texts_add(&o->points, arg, state);
    return 0;
  case KT_OPTION_FORMAT:
    o->format = arg;
    return 0;
  case 'o':
    o->base = arg;
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

static km_status run(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  km_mobility_sweep *sweep = j->own = KM_NEW(km_mobility_sweep, 1);
  if (!sweep)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  *motion = &sweep->motion;
  return km_mobility_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, sweep, error);
}

static void print(const kt_sweep_job *j, km_text *out) {
  km_mobility_sweep_print(j->pose.mechanism, &j->plan, j->own, j->path, out);
}

static const km_table *rows(const kt_sweep_job *j) {
  return ((const km_mobility_sweep *)j->own)->motion.table;
}

static km_value *record(const kt_sweep_job *j, km_arena *arena) {
  return km_mobility_sweep_record(j->pose.mechanism, j->own, j->stopped_by.data ? j->stopped_by.data : "", j->path,
                                  arena);
}

static km_status plot(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out,
                      km_error *error) {
  km_plotted_sweep plotted[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i)
    plotted[i] = (km_plotted_sweep){jobs[i]->pose.mechanism, &jobs[i]->plan, jobs[i]->own, jobs[i]->base};
  return km_mobility_plot(plotted, count, format, out, error);
}

static void free_own(kt_sweep_job *j) {
  if (j->own)
    km_mobility_sweep_free(j->own);
  km_free(j->own);
}

kt_exit kmob_sweep(int argc, char **argv) {
  static const kt_sweeping sweeping = {"mobility", NULL, run, print, rows, record, plot, free_own};
  const struct argp_child children[] = {{&kt_sweep_argp, 0, NULL, 0}, {0}};
  const struct argp argp = {table,    parse, "MODEL...", "Mobility numbers of every joint over the range of a driver.",
                            children, NULL,  NULL};
  kt_sweep_options o = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}};
  kt_parse(&argp, argc, argv, &o);
  return kt_sweep(&o, &sweeping);
}
