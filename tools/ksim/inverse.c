/* ksim inverse: the forces of a motion that is prescribed as a whole. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/dynamics.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>
#include <stdio.h>

enum { MOST_RATES = 64 };

typedef struct options {
  kt_common common;
  kt_texts holds, sets, rates, frames;
  const char *model, *base, *format, *joints, *until, *steps;
  int axes;
  bool reactions;
  kt_formats formats;
} options;

typedef struct work {
  const options *o;
  kt_pose pose;
  char name[256];
  km_forces *forces;
  km_constant_rate rates[MOST_RATES];
  km_inverse_def def;
  km_history history;
  int *shown;
  int shown_count;
} work;

static kt_exit read_rates(work *w) {
  const options *o = w->o;
  kt_exit result = KT_DONE;
  if (o->rates.count > MOST_RATES)
    return kt_usage(&o->common, "--rate", "…", "at most 64 rates");
  for (int i = 0; i < o->rates.count && result == KT_DONE; ++i) {
    const char *rest = o->rates.items[i];
    kt_piece label = kt_split(&rest, "=");
    km_constant_rate *rate = &w->rates[w->def.rate_count];
    if (label.separator != '=')
      result = kt_usage(&o->common, "--rate", o->rates.items[i], "JOINT=RATE, as A=60rpm or A=2.5");
    else
      result = kt_coordinate(&o->common, w->pose.model, "--rate", label.text, &rate->coordinate);
    for (int k = 0; k < w->def.rate_count && result == KT_DONE; ++k)
      if (w->rates[k].coordinate == rate->coordinate)
        result = kt_usage(&o->common, "--rate", o->rates.items[i], "one rate for each joint");
    if (result == KT_DONE && (!ksim_read_rate(w->pose.model, rate->coordinate, rest, &rate->rate) || rate->rate == 0.0))
      result = kt_usage(&o->common, "--rate", o->rates.items[i],
                        "a rate other than 0 in the model's unit per time unit, or of an angle in rpm");
    km_free(label.text);
    w->def.rate_count += result == KT_DONE;
  }
  return result;
}

static kt_exit read_until(work *w) {
  const options *o = w->o;
  kt_exit result = ksim_read_number(&o->common, "--until", o->until, "a positive time of at most 1e60", &w->def.until);
  return result == KT_DONE && !(w->def.until > 0.0)
             ? kt_usage(&o->common, "--until", "is missing", "the end of the motion, in the model's time unit")
             : result;
}

static kt_exit prepare(work *w) {
  const options *o = w->o;
  kt_exit result = read_rates(w);
  w->def = km_inverse_default(w->pose.mechanism, w->rates, w->def.rate_count);
  double steps = w->def.steps;
  if (result == KT_DONE)
    result = read_until(w);
  if (result == KT_DONE)
    result = ksim_read_number(&o->common, "--steps", o->steps, "a number of steps", &steps);
  if (result == KT_DONE && (steps != floor(steps) || steps > 1e7))
    result = kt_usage(&o->common, "--steps", o->steps, "a whole number up to 10 000 000");
  w->def.steps = result == KT_DONE ? (int)steps : 0;
  w->def.reactions = o->reactions;
  w->def.axes = (km_axes)o->axes;
  if (result == KT_DONE)
    result = ksim_read_frames(&o->common, w->pose.model, &o->frames, &w->def.frames, &w->def.frame_count);
  w->shown = KM_NEW(int, (size_t)km_model_coordinate_count(w->pose.model) + 1);
  if (result == KT_DONE && !w->shown)
    result = KT_NO_MEMORY;
  if (result == KT_DONE && o->joints)
    result = kt_coordinates(&o->common, w->pose.model, "--joints", o->joints, w->shown, &w->shown_count);
  if (result != KT_DONE)
    return result;
  ksim_report_hinges(&o->common, o->model, w->pose.model);
  return ksim_forces(&o->common, o->model, &w->pose, &w->forces);
}

static void print_summary(const work *w, km_text *out) {
  const km_history *h = &w->history;
  const km_table *table = h->table;
  const char *time = km_model_units(w->pose.model).time->suffix;
  size_t rows = km_table_rows(table);
  km_text_format(out, "%s: %.6g %s, %zu rows\n", w->o->model, km_table_row(table, rows - 1)[0], time, rows);
  ksim_print_acting(w->o->reactions, w->pose.model, out);
  for (int i = 0; i < h->peak_count; ++i) {
    const km_force_peak *peak = &h->peaks[i];
    const char *unit = km_table_unit(table, peak->column);
    const char *label = km_model_coordinate_label(w->pose.model, peak->coordinate);
    if (peak->coordinate >= 0 && peak->value < 0.0)
      km_text_format(out, "  %s is driven by at most %.6g %s in size, %.6g at %.6g %s, %.6g rms\n", label, -peak->value,
                     unit, peak->value, peak->time, time, peak->rms);
    else if (peak->coordinate >= 0)
      km_text_format(out, "  %s is driven by at most %.6g %s at %.6g %s, %.6g rms\n", label, peak->value, unit,
                     peak->time, time, peak->rms);
    else
      km_text_format(out, "  shaking force at most %.6g %s at %.6g %s, %.6g rms\n", peak->value, unit, peak->time, time,
                     peak->rms);
  }
}

static const km_value *record(const void *context, km_arena *arena) {
  const work *w = context;
  return km_inverse_record(w->pose.mechanism, &w->history, w->history.why.text, w->o->model, arena);
}

static km_status chart(const void *context, km_chart **out, km_error *error) {
  const work *w = context;
  const km_plotted_history shown = {.mechanism = w->pose.mechanism,
                                    .table = w->history.table,
                                    .name = w->name,
                                    .joints = w->shown_count ? w->shown : NULL,
                                    .joint_count = w->shown_count};
  return km_inverse_chart(&shown, out, error);
}

static kt_exit deliver(const work *w) {
  const options *o = w->o;
  km_text summary = {0};
  print_summary(w, &summary);
  ksim_report_drives(&o->common, o->model, &w->pose, &w->history);
  kt_exit result = ksim_report_limits(&o->common, o->model, &w->pose, &w->history);
  const ksim_delivery delivery = {.common = &o->common,
                                  .formats = &o->formats,
                                  .base = o->base ? o->base : w->name,
                                  .word = "inverse",
                                  .table = w->history.table,
                                  .summary = &summary,
                                  .record = record,
                                  .chart = chart,
                                  .context = w};
  result = kt_worse(result, ksim_deliver(&delivery));
  km_text_free(&summary);
  return result;
}

static kt_exit run(const options *o) {
  work w = {.o = o};
  km_error error;
  kt_base_name(o->model, w.name, sizeof w.name);
  kt_exit result = kt_open(&o->common, o->model, &o->holds, &o->sets, &w.pose);
  if (result == KT_DONE)
    result = prepare(&w);
  if (result == KT_DONE) {
    kt_progress progress = kt_progress_start(&o->common);
    w.def.progress = kt_progress_show;
    w.def.context = &progress;
    km_status status = km_inverse_run(w.pose.mechanism, w.forces, w.pose.state, &w.def, &w.history, &error);
    kt_progress_end(&progress);
    result = kt_exit_of(status);
    if (status)
      kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
    if (w.history.table && km_table_rows(w.history.table) > 0)
      result = kt_worse(result, deliver(&w));
  }
  km_history_free(&w.history);
  km_forces_free(w.forces);
  km_free((km_traced_frame *)w.def.frames);
  km_free(w.shown);
  kt_close(&w.pose);
  return result;
}

kt_exit ksim_inverse(int argc, char **argv) {
  options o = {.common = KT_COMMON("ksim")};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"rate", 0, "JOINT=RATE",
       "Turn or move a joint at a constant rate: A=60rpm, or in the model's unit per time unit "
       "(repeatable; beside it the model's prescribed motions count)",
       KT_TEXTS, &o.rates, KT_ABOUT_MODEL},
      {"until", 0, "T", "End, in the model's time unit (default: one turn)", KT_TEXT, &o.until, KT_ABOUT_MODEL},
      {"steps", 0, "N", "Number of intervals (default 360)", KT_TEXT, &o.steps, KT_ABOUT_MODEL},
      KT_SET(&o.sets, KT_SET_FIRST),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_MODE(o.common),
      KT_POSE(o.common),
      {"frame", 0, "BODY/FRAME", "Add place, velocity and acceleration of a frame's origin (repeatable)", KT_TEXTS,
       &o.frames, KT_ABOUT_MODEL},
      {"reactions", 0, NULL, "Add the reaction in every joint", KT_FLAG, &o.reactions, KT_ABOUT_MODEL},
      {"axes", 0, "AXES", "Axes of the reactions: joint (default) or fixed", KT_WORD("joint or fixed"), &o.axes,
       KT_ABOUT_MODEL},
      {"joints", 0, "LIST", "Joints whose curves are drawn (default: up to eight that move)", KT_TEXT, &o.joints,
       KT_ABOUT_FILES},
      {"format", 0, "LIST", KT_FORMATS_HELP, KT_FORMATS_KIND, &o.format, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Files are BASE.inverse.FORMAT (default: the model's name); - is the standard output"),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "What a prescribed motion takes: the forces of its drives, the reactions in the joints, and the shaking force and "
      "moment on the ground. The motion must leave no freedom. Exit status 1 if it can't be gone to its end."
      "\vColumns: t; q.JOINT, v.JOINT, a.JOINT; f.JOINT, the force that drives a prescribed joint, along +q; "
      "energy_kinetic, energy_potential; loop_error; shaking.fx … tz, the sum of the inertia forces about the inertial "
      "origin; frame.BODY/FRAME.x … vx … ax; r.JOINT.fx … tz, parent on child. JSON: largest_forces (of, value, t, "
      "rms), located between rows too.",
      argc, argv);
  kt_exit result = ksim_read_formats(&o.common, o.format, o.base, false, "--format csv or json", &o.formats);
  return result == KT_DONE ? run(&o) : result;
}
