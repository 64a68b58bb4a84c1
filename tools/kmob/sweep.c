/* kmob sweep: mobility numbers over a driver's range. */
#include "kmob/kmob.h"

#include "base/json.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "model/model.h"
#include "report/csv.h"
#include "report/mobility_plot.h"
#include "report/mobility_record.h"

#include <stdio.h>
#include <string.h>

enum {
  OPTION_HOLD = 0x3001,
  OPTION_FORMAT,
  OPTION_RANGE,
  OPTION_STEPS,
  OPTION_POINT,
  OPTION_DERIVATIVES,
  OPTION_IGNORE,
  OPTION_JOINT,
  OPTION_SET,
  OPTION_ARCLENGTH,
  OPTION_DIRECTION,
  OPTION_CYCLE,
  OPTION_BRANCH,
  MOST_MODELS = 64,
  MOST_POINTS = 64
};

typedef struct options {
  kt_common common;
  kmob_texts holds, sets, points, models;
  const char *joint, *range, *steps, *base, *arclength, *direction, *branch;
  kt_formats formats;
  bool derivatives, ignore_limits, cycle;
} options;

static const struct argp_option table[] = {
    {"joint", OPTION_JOINT, "JOINT", 0, "The driver (default: the model's analysis.sweep)", 1},
    {"range", OPTION_RANGE, "FROM:TO", 0, "Its range in the model's unit", 1},
    {"steps", OPTION_STEPS, "N", 0, "Number of intervals; N + 1 rows", 1},
    {"arclength", OPTION_ARCLENGTH, "DS", 0, "Follow the motion by arc length instead, DS a row: through toggles", 1},
    {"direction", OPTION_DIRECTION, "JOINT=+1", 0, "Start so that this joint moves forwards (or -1: backwards)", 1},
    {"cycle", OPTION_CYCLE, NULL, 0, "Follow until the motion meets its start (at most --steps rows, default 100000)",
     1},
    {"branch", OPTION_BRANCH, "K", 0,
     "Motion to take at the first branch point: 1 goes on smoothly (default), 2 and 3 are the next one ahead and back, "
     "…",
     1},
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Start from another pose: move a joint to a value first", 1},
    {"ignore-limits", OPTION_IGNORE, NULL, 0, "Pass joint limits", 1},
    {"point", OPTION_POINT, "BODY/FRAME", 0, "Add the path of a frame's origin (repeatable)", 1},
    {"derivatives", OPTION_DERIVATIVES, NULL, 0, "Add the points' derivatives along the driver", 1},
    {"format", OPTION_FORMAT, "LIST", 0, "Some of csv,json,svg,pdf,png (default csv,svg)", 2},
    {"output", 'o', "BASE", 0, "Files are BASE.mobility.FORMAT (default: the model's name); - is the standard output",
     2},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &o->common;
    return 0;
  case OPTION_JOINT:
    o->joint = arg;
    return 0;
  case OPTION_RANGE:
    o->range = arg;
    return 0;
  case OPTION_STEPS:
    o->steps = arg;
    return 0;
  case OPTION_ARCLENGTH:
    o->arclength = arg;
    return 0;
  case OPTION_DIRECTION:
    o->direction = arg;
    return 0;
  case OPTION_CYCLE:
    o->cycle = true;
    return 0;
  case OPTION_BRANCH:
    o->branch = arg;
    return 0;
  case OPTION_HOLD:
    kmob_texts_add(&o->holds, arg, state);
    return 0;
  case OPTION_SET:
    kmob_texts_add(&o->sets, arg, state);
    return 0;
  case OPTION_POINT:
    kmob_texts_add(&o->points, arg, state);
    return 0;
  case OPTION_DERIVATIVES:
    o->derivatives = true;
    return 0;
  case OPTION_IGNORE:
    o->ignore_limits = true;
    return 0;
  case OPTION_FORMAT:
    if (!kt_formats_parse(&o->common, arg, &o->formats))
      argp_failure(state, KT_USAGE, 0, "try --help");
    return 0;
  case 'o':
    o->base = arg;
    return 0;
  case ARGP_KEY_ARG:
    kmob_texts_add(&o->models, arg, state);
    return 0;
  case ARGP_KEY_NO_ARGS:
    argp_error(state, "no model is given");
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

/* One model of the sweep, with all that its files are made of. */
typedef struct job {
  const options *options;
  kt_common common; /* with a log of its own */
  km_text log;
  const char *path;
  char base[256];
  kmob_pose pose;
  km_sweep_plan plan;
  km_sweep_point points[MOST_POINTS];
  km_mobility_sweep sweep;
  km_text stopped_by;
  kt_exit result;
} job;

static kt_exit read_range(const kt_common *common, const options *o, km_sweep_plan *plan) {
  const char *colon = strchr(o->range, ':');
  char from[64];
  if (!colon || (size_t)(colon - o->range) >= sizeof from)
    return kt_usage(common, "--range", o->range, "FROM:TO");
  snprintf(from, sizeof from, "%.*s", (int)(colon - o->range), o->range);
  if (!kt_number(from, &plan->from) || !kt_number(colon + 1, &plan->to))
    return kt_usage(common, "--range", o->range, "two numbers FROM:TO");
  return KT_DONE;
}

static kt_exit read_steps(const kt_common *common, const options *o, km_sweep_plan *plan) {
  double steps;
  if (!kt_number(o->steps, &steps) || steps < 1.0 || steps > 1e7 || steps != (double)(int)steps)
    return kt_usage(common, "--steps", o->steps, "a whole number from 1 to 10000000");
  plan->steps = (int)steps;
  return KT_DONE;
}

static kt_exit read_point(job *j, const char *text) {
  km_sweep_point *point = &j->points[j->plan.point_count];
  kt_exit result = kt_frame(&j->common, j->pose.model, "--point", text, &point->frame);
  if (result != KT_DONE)
    return result;
  point->name = text;
  j->plan.point_count++;
  return KT_DONE;
}

/* --arclength --direction --cycle over the model's own. */
static kt_exit read_length(const kt_common *common, const options *o, const km_model *model, km_sweep_plan *plan) {
  bool driven = o->joint || o->range;
  if (o->arclength && driven)
    return kt_usage(common, "--arclength", o->arclength, "it without --joint and --range");
  if (o->arclength && (!kt_number(o->arclength, &plan->arclength) || plan->arclength <= 0.0))
    return kt_usage(common, "--arclength", o->arclength, "a number greater than 0");
  if (driven)
    plan->arclength = 0.0;
  if ((o->direction || o->cycle) && plan->arclength <= 0.0)
    return kt_usage(common, o->cycle ? "--cycle" : "--direction", "", "--arclength with it");
  double branch = 1.0;
  if (o->branch && (plan->arclength <= 0.0 || !kt_number(o->branch, &branch) || branch < 1.0 || branch > 31.0 ||
                    branch != (double)(int)branch))
    return kt_usage(common, "--branch", o->branch, "a whole number from 1 to 31, with --arclength");
  plan->branch = (int)branch;
  if (o->cycle && !o->steps)
    plan->steps = 100000;
  plan->cycle = o->cycle;
  if (!o->direction)
    return KT_DONE;
  const char *rest = o->direction;
  kt_piece label = kt_split(&rest, "=");
  kt_exit result = KT_DONE;
  if (label.separator != '=' || !kt_number(rest, &plan->sign) || plan->sign == 0.0)
    result = kt_usage(common, "--direction", o->direction, "JOINT=+1 or JOINT=-1");
  else
    result = kt_coordinate(common, model, "--direction", label.text, &plan->direction);
  km_free(label.text);
  return result;
}

static kt_exit make_plan(job *j) {
  const options *o = j->options;
  const kt_common *common = &j->common;
  const km_model *model = j->pose.model;
  kt_exit result = KT_DONE;
  j->plan = km_sweep_plan_default(model);
  if (o->joint) {
    int own = j->plan.coordinate;
    result = kt_coordinate(common, model, "--joint", o->joint, &j->plan.coordinate);
    if (result == KT_DONE && j->plan.coordinate != own && !o->range)
      return kt_usage(common, "--joint", o->joint, "a --range with it, since the model has none for this joint");
  }
  if (result == KT_DONE)
    result = read_length(common, o, model, &j->plan);
  if (result == KT_DONE && j->plan.coordinate < 0 && j->plan.arclength <= 0.0) {
    kt_say(common, KM_ERROR, "%s: the model has no analysis.sweep; expected --joint and --range, or --arclength",
           j->path);
    return KT_USAGE;
  }
  if (result == KT_DONE && o->range)
    result = read_range(common, o, &j->plan);
  if (result == KT_DONE && o->steps)
    result = read_steps(common, o, &j->plan);
  j->plan.ignore_limits = o->ignore_limits;
  j->plan.derivatives = o->derivatives;
  j->plan.points = j->points;
  for (int i = 0; i < o->points.count && result == KT_DONE; ++i)
    result = i < MOST_POINTS ? read_point(j, o->points.items[i]) : kt_usage(common, "--point", "", "at most 64 points");
  return result;
}

static void run_sweep(job *j) {
  const kt_common *common = &j->common;
  kt_progress progress = kt_progress_start(common);
  j->plan.progress = kt_progress_show;
  j->plan.context = &progress;
  km_error error;
  km_status status = km_mobility_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, &j->sweep, &error);
  kt_progress_end(&progress);
  if (status == KM_OK || status == KM_PARTIAL) {
    km_sweep_stop_text(j->pose.mechanism, &j->plan, &j->sweep, &j->stopped_by);
    if (status == KM_PARTIAL)
      kt_say(common, KM_ERROR, "%s: %s", j->path, j->stopped_by.data);
    if (j->sweep.start_branches > 0)
      kt_say(common, KM_NOTE,
             "%s: the starting pose is a branch point; of %d motions the one %s "
             "is taken (--set starts from another pose)",
             j->path, j->sweep.start_branches,
             j->plan.arclength > 0.0 ? "nearest to the direction asked for" : "that moves the driver most");
    else if (j->sweep.freedom > 1 && j->plan.arclength <= 0.0)
      kt_say(common, KM_NOTE, "%s: more than one freedom is left; the others move least (--hold keeps joints)",
             j->path);
  } else {
    kt_say(common, KM_ERROR, "%s: %s", j->path, error.text);
  }
  j->result = kt_exit_of(status);
}

static void start_job(void *context, int index) {
  job *j = (job *)context + index;
  const options *o = j->options;
  kt_base_name(j->path, j->base, sizeof j->base);
  j->result = kmob_open(&j->common, j->path, &o->holds, &o->sets, &j->pose);
  if (j->result == KT_DONE)
    j->result = make_plan(j);
  if (j->result == KT_DONE)
    run_sweep(j);
}

static bool delivers(const job *j) {
  return j->result == KT_DONE || j->result == KT_PARTIAL;
}

static kt_exit write_table(const job *j, const char *base, kt_format format) {
  km_text out = {0};
  if (format == KT_CSV) {
    km_csv_write(j->sweep.table, &out);
  } else {
    km_arena arena = {0};
    const km_value *record =
        km_sweep_record(j->pose.mechanism, &j->sweep, j->stopped_by.data ? j->stopped_by.data : "", j->path, &arena);
    if (record)
      km_json_write(record, &out);
    else
      out.failed = true;
    km_arena_free(&arena);
  }
  kt_exit result = kt_write(&j->options->common, base, "mobility", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

/* One plot for all the models that were swept. */
static kt_exit write_plot(const options *o, job *jobs, int count, const char *base, kt_format format) {
  km_plotted_sweep plotted[MOST_MODELS];
  int shown = 0;
  for (int i = 0; i < count; ++i)
    if (delivers(&jobs[i]))
      plotted[shown++] = (km_plotted_sweep){jobs[i].pose.mechanism, &jobs[i].plan, &jobs[i].sweep, jobs[i].base};
  km_text out = {0};
  km_error error;
  km_status status = km_mobility_plot(plotted, shown, kt_canvas_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&o->common, base, "mobility", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit deliver(const options *o, job *jobs, int count) {
  kt_exit result = KT_DONE;
  int first = -1;
  for (int i = 0; i < count; ++i) {
    const job *j = &jobs[i];
    if (!delivers(j))
      continue;
    first = first < 0 ? i : first;
    km_text summary = {0};
    if (!o->common.quiet && !(o->base && strcmp(o->base, "-") == 0)) {
      km_sweep_print(j->pose.mechanism, &j->plan, &j->sweep, j->path, &summary);
      result = kt_worse(result, kt_print(&o->common, &summary));
    }
    km_text_free(&summary);
    /* Several models keep their own names; -o then names the plot that they share. */
    const char *base = o->base && count == 1 ? o->base : j->base;
    for (int f = KT_CSV; f <= KT_JSON; ++f)
      if (o->formats.wanted[f])
        result = kt_worse(result, write_table(j, base, (kt_format)f));
  }
  for (int f = KT_SVG; f <= KT_PNG && first >= 0; ++f)
    if (o->formats.wanted[f])
      result = kt_worse(result, write_plot(o, jobs, count, o->base ? o->base : jobs[first].base, (kt_format)f));
  return result;
}

/* Tables are named after their models: two of one name would overwrite each other. */
static bool names_differ(const options *o) {
  char a[256], b[256];
  for (int i = 0; i < o->models.count; ++i) {
    kt_base_name(o->models.items[i], a, sizeof a);
    for (int k = 0; k < i; ++k) {
      kt_base_name(o->models.items[k], b, sizeof b);
      if (strcmp(o->models.items[i], "-") == 0 && strcmp(o->models.items[k], "-") == 0) {
        kt_say(&o->common, KM_ERROR, "the standard input (-) is given twice; it can be read only once");
        return false;
      }
      if (strcmp(a, b) == 0) {
        kt_say(&o->common, KM_ERROR, "%s and %s would write the same files; expected models of different names",
               o->models.items[k], o->models.items[i]);
        return false;
      }
    }
  }
  return true;
}

static kt_exit run(const options *o) {
  int count = o->models.count;
  job *jobs = KM_NEW(job, (size_t)count);
  kt_exit result = jobs ? KT_DONE : KT_INTERNAL;
  for (int i = 0; i < count && jobs; ++i) {
    jobs[i].options = o;
    jobs[i].path = o->models.items[i];
    jobs[i].common = o->common;
    jobs[i].common.log = count > 1 ? &jobs[i].log : NULL;
  }
  if (jobs)
    km_parallel_for(count, o->common.jobs, start_job, jobs);
  for (int i = 0; i < count && jobs; ++i) {
    kt_flush(&jobs[i].common);
    result = kt_worse(result, jobs[i].result);
  }
  if (jobs)
    result = kt_worse(result, deliver(o, jobs, count));
  for (int i = 0; i < count && jobs; ++i) {
    km_mobility_sweep_free(&jobs[i].sweep);
    km_text_free(&jobs[i].stopped_by);
    kmob_close(&jobs[i].pose);
  }
  km_free(jobs);
  return result;
}

kt_exit kmob_sweep(int argc, char **argv) {
  const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
  const struct argp argp = {table,    parse, "MODEL...", "Mobility numbers of every joint over the range of a driver.",
                            children, NULL,  NULL};
  options o = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}};
  o.formats.wanted[KT_CSV] = o.formats.wanted[KT_SVG] = true;
  kt_parse(&argp, argc, argv, &o);
  if (o.models.count > MOST_MODELS)
    return kt_usage(&o.common, "MODEL", "…", "at most 64 models");
  bool tables_only = !o.formats.wanted[KT_SVG] && !o.formats.wanted[KT_PDF] && !o.formats.wanted[KT_PNG];
  if (o.base && strcmp(o.base, "-") == 0 && (o.models.count > 1 || kt_formats_count(&o.formats) != 1 || !tables_only))
    return kt_usage(&o.common, "-o", "-", "one model and --format csv or json");
  return names_differ(&o) ? run(&o) : KT_USAGE;
}
