/* kma sweep and kma report: mechanical advantage over a driver's range. */
#include "common/report.h"
#include "kma/kma.h"

#include "kmech/advantage_sweep.h"
#include "report/document/advantage_report.h"
#include "report/plot/advantage_plot.h"
#include "report/record/advantage_record.h"

#include <string.h>

typedef struct options {
  kt_sweep_options sweep;
  kma_ends_options ends;
  bool transmission;
} options;

/* What is made of one model. */
typedef struct product {
  kma_ends ends;
  km_advantage_sweep sweep;
  km_transmission transmission; /* of the last row; for a report */
} product;

/* A point with a direction is an end, one without is a path to add. */
static void part_points(options *o) {
  kt_texts *points = &o->ends.points;
  int ends = 0;
  for (int i = 0; i < points->count; ++i)
    if (kma_has_direction(points->items[i]))
      points->items[ends++] = points->items[i];
    else
      o->sweep.points.items[o->sweep.points.count++] = points->items[i];
  points->count = ends;
}

static void read_options(options *o, kt_options *all, const char *about, int argc, char **argv) {
  const kt_option point[] = {
      {"point", 0, "BODY/FRAME[:DX,DY,DZ]",
       "With a direction: a point as output (a second one: as input before it); without: add the path of a frame's "
       "origin (repeatable)",
       KT_TEXTS, &o->ends.points, KT_ABOUT_MODEL}};
  kma_ends_options_add(all, &o->ends);
  KT_OPTIONS_ADD(all, point);
  kt_options_read(all, about, argc, argv);
  part_points(o);
  o->sweep.own = o;
}

static kt_exit prepare(kt_sweep_job *j) {
  product *p = j->own = KM_NEW(product, 1);
  return p ? kma_ends_read(&j->common, j->path, j->pose.model, &((const options *)j->options->own)->ends, &p->ends)
           : KT_INTERNAL;
}

static km_status run(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  product *p = j->own;
  *motion = &p->sweep.motion;
  return km_advantage_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, &p->ends.input, &p->ends.output,
                                ((const options *)j->options->own)->transmission, &p->sweep, error);
}

static void print(const kt_sweep_job *j, km_text *out) {
  km_advantage_sweep_print(j->pose.mechanism, &j->plan, &((const product *)j->own)->sweep, j->path, out);
}

static const km_table *rows(const kt_sweep_job *j) {
  return ((const product *)j->own)->sweep.motion.table;
}

static km_value *record(const kt_sweep_job *j, km_arena *arena) {
  return km_advantage_sweep_record(j->pose.mechanism, &((const product *)j->own)->sweep,
                                   j->stopped_by.data ? j->stopped_by.data : "", j->path, arena);
}

static km_status plot(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out,
                      km_error *error) {
  km_plotted_advantage plotted[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i) {
    const km_advantage_sweep *sweep = &((const product *)jobs[i]->own)->sweep;
    plotted[i] =
        (km_plotted_advantage){{jobs[i]->pose.mechanism, &jobs[i]->plan, &sweep->motion, jobs[i]->base}, sweep};
  }
  return km_advantage_plot(plotted, count, format, out, error);
}

static void free_own(kt_sweep_job *j) {
  product *p = j->own;
  if (p) {
    km_advantage_sweep_free(&p->sweep);
    kma_ends_free(&p->ends);
  }
  km_free(p);
}

kt_exit kma_sweep(int argc, char **argv) {
  static const kt_sweeping sweeping = {"advantage", prepare, run, print, rows, record, plot, free_own};
  options o = {.sweep = {.common = KT_COMMON("kma")}};
  kt_options all = {0};
  const kt_option transmission[] = {
      {"transmission", 0, NULL,
       "Add transmission angle, virtual coefficient, Sutherland-Roth and Chen-Angeles indices, manipulability and "
       "condition number as columns; nan where undefined",
       KT_FLAG, &o.transmission, KT_ABOUT_MODEL}};
  kt_sweep_options_several(&all, &o.sweep, KT_SWEEP_BASE("advantage"));
  KT_OPTIONS_ADD(&all, transmission);
  read_options(
      &o, &all,
      "Mechanical advantage of an input over an output over the range of a driver, with its toggles and extremes."
      "\vColumns beside those of every sweep: ma.INPUT/OUTPUT, with a unit such as _rad/mm where it mixes an angle and "
      "a length (inf, nan where infinite, undefined); force_ratio.INPUT/OUTPUT with the joints' friction, where there "
      "is some; with --transmission transmission_angle, virtual_coefficient, sutherland_roth, chen_angeles, "
      "manipulability, condition_number. JSON adds input, output, method, toggles [{state, s}], minimum and maximum "
      "{value, s, state}, held_joints.",
      argc, argv);
  return kt_sweep(&o.sweep, &sweeping);
}

/* The sweep with its metrics, and why they are undefined where the sweep ends. */
static km_status run_report(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  product *p = j->own;
  *motion = &p->sweep.motion;
  km_status status = km_advantage_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, &p->ends.input, &p->ends.output,
                                            true, &p->sweep, error);
  km_transmission_work *work;
  km_mobility mobility;
  if (status && status != KM_PARTIAL)
    return status;
  km_status made = km_transmission_create(j->pose.mechanism, &p->ends.input, &p->ends.output, &work, error);
  if (made)
    return made;
  km_mobility_update(j->pose.mechanism, j->pose.state, &mobility);
  km_transmission_update(j->pose.mechanism, j->pose.state, work, &p->transmission);
  km_transmission_free(work);
  return status;
}

static km_status write_report(const kt_sweep_job *j, bool html, km_text *out, km_error *error) {
  const product *p = j->own;
  km_plotted_advantage plotted = {{j->pose.mechanism, &j->plan, &p->sweep.motion, j->base}, &p->sweep};
  return km_advantage_report(&plotted, &p->transmission, j->stopped_by.data ? j->stopped_by.data : "", html, out,
                             error);
}

kt_exit kma_report(int argc, char **argv) {
  static const kt_reporting reporting = {"advantage-report", prepare, run_report, write_report, free_own};
  options o = {.sweep = {.common = KT_COMMON("kma")}};
  kt_options all = {0};
  kt_report_options(&all, &o.sweep, KT_REPORT_BASE("advantage-report"));
  read_options(&o, &all,
               "A report to hand on: the mechanism in its poses, the leverage curve with its extremes and toggles, "
               "transmission metrics and a table, as PDF pages or one HTML file.",
               argc, argv);
  return kt_report(&o.sweep, &reporting);
}
