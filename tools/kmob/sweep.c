/* kmob sweep: mobility numbers over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

#include "report/plot/mobility_plot.h"
#include "report/record/mobility_record.h"

enum { OPTION_POINT = 0x3101, OPTION_SINGULARITIES };

typedef struct options {
  kt_sweep_options sweep;
  bool singularities;
} options;

/* What is known of one model's sweep. */
typedef struct findings {
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
} findings;

static const struct argp_option table[] = {
    {"point", OPTION_POINT, "BODY/FRAME", 0, "Add the path of a frame's origin (repeatable)", 1},
    {"singularities", OPTION_SINGULARITIES, NULL, 0,
     "Add the smallest kept singular value, and locate its minima: where mobility is nearly gained", 1},
    KT_FORMAT_OPTION,
    {"base", 'o', "BASE", 0, "Files are BASE.mobility.FORMAT (default: the model's name); - is the standard output", 2},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &o->sweep;
    return 0;
  case OPTION_POINT:
    kt_texts_add(&o->sweep.points, arg, state);
    return 0;
  case OPTION_SINGULARITIES:
    o->singularities = true;
    return 0;
  case KT_OPTION_FORMAT:
    o->sweep.format = arg;
    return 0;
  case 'o':
    o->sweep.base = arg;
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

static km_status run(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  const options *o = j->options->own;
  findings *f = j->own = KM_NEW(findings, 1);
  if (!f)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  j->plan.singularities = o->singularities;
  *motion = &f->sweep.motion;
  km_status status = km_mobility_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, &f->sweep, error);
  if (status != KM_OK && status != KM_PARTIAL)
    return status;
  km_status found =
      km_sweep_redundancies_find(j->pose.mechanism, *motion, o->sweep.formats.wanted[KT_JSON], &f->redundancies, error);
  return found ? found : status;
}

static void print(const kt_sweep_job *j, km_text *out) {
  const findings *f = j->own;
  km_mobility_sweep_print(j->pose.mechanism, &j->plan, &f->sweep, &f->redundancies, j->path, out);
}

static const km_table *rows(const kt_sweep_job *j) {
  return ((const findings *)j->own)->sweep.motion.table;
}

static km_value *record(const kt_sweep_job *j, km_arena *arena) {
  const findings *f = j->own;
  return km_mobility_sweep_record(j->pose.mechanism, &f->sweep, &f->redundancies,
                                  j->stopped_by.data ? j->stopped_by.data : "", j->path, arena);
}

static km_status plot(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out,
                      km_error *error) {
  km_plotted_sweep plotted[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i)
    plotted[i] = (km_plotted_sweep){jobs[i]->pose.mechanism, &jobs[i]->plan, &((const findings *)jobs[i]->own)->sweep,
                                    jobs[i]->base};
  return km_mobility_plot(plotted, count, format, out, error);
}

static void free_own(kt_sweep_job *j) {
  findings *f = j->own;
  if (!f)
    return;
  km_mobility_sweep_free(&f->sweep);
  km_sweep_redundancies_free(&f->redundancies);
  km_free(f);
}

kt_exit kmob_sweep(int argc, char **argv) {
  static const kt_sweeping sweeping = {"mobility", NULL, run, print, rows, record, plot, free_own};
  const struct argp_child children[] = {{&kt_sweep_argp, 0, NULL, 0}, {0}};
  const struct argp argp = {table,    parse, "MODEL...", "Mobility numbers of every joint over the range of a driver.",
                            children, NULL,  NULL};
  options o = {.sweep = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}}};
  o.sweep.own = &o;
  kt_parse(&argp, argc, argv, &o);
  return kt_sweep(&o.sweep, &sweeping);
}
