/* ksim run: options, the run, its files. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

/* The method of --integrator, else of the model. */
static km_integrator choose_integrator(const ksim_work *w) {
  const ksim_options *o = w->options;
  km_integrator found = KM_INTEGRATOR_ADAMS;
  const char *stated = km_model_integration_type(w->pose.model);
  if (o->integrator >= 0)
    return (km_integrator)o->integrator;
  if (stated && !km_model_integrator(w->pose.model, &found))
    kt_print_message(
        &o->common, KM_NOTE,
        "%s: the model's integration_type \"%.80s\" isn't a method of ksim; adams is used, --integrator chooses another",
        o->model, stated);
  return found;
}

static kt_exit read_numbers(ksim_work *w) {
  const ksim_options *o = w->options;
  km_simulation_def *sim = &w->def.simulation;
  kt_exit result = ksim_read_number(&o->common, "--until", o->until, "a positive time of at most 1e60", &w->def.until);
  double step;
  km_model_simulated(w->pose.model, NULL, &step);
  if (o->until && !o->every && step <= 0.0)
    w->def.every = w->def.until / KM_HISTORY_ROWS;
  result = kt_worse(
      result, ksim_read_number(&o->common, "--every", o->every, "a positive time of at most 1e60", &w->def.every));
  result = kt_worse(
      result, ksim_read_number(&o->common, "--rtol", o->rtol, "a positive number of at most 1e60", &sim->relative));
  result = kt_worse(
      result, ksim_read_number(&o->common, "--atol", o->atol, "a positive number of at most 1e60", &sim->absolute));
  result = kt_worse(result, ksim_read_number(&o->common, "--max-step", o->max_step, "a positive time of at most 1e60",
                                             &sim->max_step));
  sim->integrator = choose_integrator(w);
  sim->stabilisation = (km_stabilisation)o->stabilise;
  if (sim->integrator == KM_INTEGRATOR_FIXED && !o->max_step && result == KT_DONE)
    return kt_usage(&o->common, "--integrator", "fixed", "--max-step, the length of its steps");
  return result;
}

/* JOINT=VALUE as crossings of its coordinates, behind those at hand. */
static kt_exit add_crossing(ksim_work *w, const char *option, char *text, bool stops) {
  km_simulation_def *def = &w->def.simulation;
  kt_settings one = {0}; /* the last of several values of a joint is used */
  void *crossings = w->crossings;
  kt_exit result = kt_settings_add(&w->options->common, w->pose.model, option, &text, 1, &one);
  size_t count = (size_t)def->crossing_count;
  if (!km_reserve(&crossings, &w->crossing_capacity, count + (size_t)one.count, sizeof *w->crossings))
    result = KT_NO_MEMORY;
  def->crossings = w->crossings = crossings;
  for (int k = 0; k < one.count && result == KT_DONE; ++k)
    w->crossings[def->crossing_count++] =
        (km_crossing){.coordinate = one.items[k].coordinate, .value = one.items[k].value, .stops = stops};
  kt_settings_free(&one);
  return result;
}

kt_exit ksim_read_crossings(ksim_work *w) {
  const ksim_options *o = w->options;
  kt_exit result = KT_DONE;
  for (int i = 0; i < (int)o->events.count && result == KT_DONE; ++i)
    result = add_crossing(w, "--event", o->events.items[i], false);
  for (int i = 0; i < (int)o->stops.count && result == KT_DONE; ++i)
    result = add_crossing(w, "--stop", o->stops.items[i], true);
  return result;
}

/* The force modules of --forces, each once: their names, or all. */
static kt_exit read_modules(ksim_work *w) {
  const ksim_options *o = w->options;
  const km_model *model = w->pose.model;
  int all = km_model_module_count(model);
  w->modules = KM_NEW(int, (size_t)all + (size_t)o->forces.count + 1);
  kt_exit result = w->modules ? kt_each_once(&o->common, "--forces", o->forces.items, o->forces.count) : KT_NO_MEMORY;
  for (int i = 0; i < (int)o->forces.count && result == KT_DONE; ++i) {
    const char *name = o->forces.items[i];
    int found = km_model_find_module(model, name);
    if (found < 0 && strcmp(name, "all") == 0 && o->forces.count == 1) {
      for (int k = 0; k < all; ++k)
        w->modules[w->def.module_count++] = k;
    } else if (found < 0) {
      result = kt_usage(&o->common, "--forces", name, "all, or the name of one force module");
    } else {
      w->modules[w->def.module_count++] = found;
    }
  }
  w->def.modules = w->modules;
  return result;
}

static kt_exit read_shown(ksim_work *w) {
  const ksim_options *o = w->options;
  w->shown = KM_NEW(int, (size_t)km_model_coordinate_count(w->pose.model) + 1);
  if (!w->shown)
    return KT_NO_MEMORY;
  return o->joints ? kt_coordinates(&o->common, w->pose.model, "--joints", o->joints, w->shown, &w->shown_count)
                   : KT_DONE;
}

static kt_exit prepare(ksim_work *w) {
  const ksim_options *o = w->options;
  w->def = km_history_default(w->pose.model);
  w->def.reactions = o->reactions;
  w->def.frame_rotations = o->axes == KSIM_AXES_BODY;
  w->def.axes = o->axes == KM_AXES_FIXED ? KM_AXES_FIXED : KM_AXES_JOINT;
  w->def.mobility = o->mobility;
  kt_exit result = ksim_set_rates(w);
  if (result == KT_DONE)
    result = ksim_continue(w);
  if (result == KT_DONE)
    result = read_numbers(w);
  if (result == KT_DONE)
    result = ksim_read_crossings(w);
  if (result == KT_DONE)
    result = ksim_read_frames(&o->common, w->pose.model, &o->frames, &w->def.frames, &w->def.frame_count);
  if (result == KT_DONE)
    result = read_modules(w);
  if (result == KT_DONE)
    result = read_shown(w);
  if (result != KT_DONE)
    return result;
  ksim_report_hinges(&o->common, o->model, w->pose.model);
  result = ksim_forces(&o->common, o->model, &w->pose, &w->forces);
  return result == KT_DONE && o->limit_stops ? ksim_set_limit_stops(w) : result;
}

/* Notes in addition to the files. */
static kt_exit tell(ksim_work *w, km_status status) {
  const ksim_options *o = w->options;
  const km_history *h = &w->history;
  const km_model *model = w->pose.model;
  const char *unit = km_model_units(model).time->suffix;
  if (h->figures.relative > w->def.simulation.relative * (1.0 + 1e-9))
    kt_print_message(&o->common, KM_NOTE,
                     "%s: a relative error of %.3g is less than rounding allows; steps keep to %.3g", o->model,
                     w->def.simulation.relative, h->figures.relative);
  if (h->figures.stiff && w->def.simulation.integrator == KM_INTEGRATOR_ADAMS)
    kt_print_message(&o->common, KM_NOTE, "%s: the motion is stiff; --integrator bdf took over", o->model);
  kt_detail(&o->common,
            "%s: an evaluation solves for accelerations by about %.0f multiplications, a dense system takes %.0f",
            o->model, h->effort.multiplications, h->effort.dense);
  ksim_report_drives(&o->common, o->model, &w->pose, h);
  kt_exit result = ksim_report_rates(w);
  if (!o->ignore_limits)
    result = kt_worse(result, ksim_report_limits(&o->common, o->model, &w->pose, h));
  double time = h->table && km_table_rows(h->table) ? km_table_row(h->table, km_table_rows(h->table) - 1)[0] : 0.0;
  if (status == KM_PARTIAL)
    snprintf(w->stopped_by, sizeof w->stopped_by, "--stop at %.9g %s", time, unit);
  else if (status)
    snprintf(w->stopped_by, sizeof w->stopped_by, "%.900s", h->why.text);
  if (status && status != KM_PARTIAL)
    kt_print_message(&o->common, KM_ERROR, "%s: the run ends at %.9g %s: %s", o->model, time, unit, h->why.text);
  return result;
}

static void print_summary(const ksim_work *w, km_text *out) {
  const km_history *h = &w->history;
  const km_model *model = w->pose.model;
  const char *unit = km_model_units(model).time->suffix;
  size_t rows = km_table_rows(h->table);
  km_text_format(out, "%s: %.6g %s, %zu rows; %ld steps, %ld evaluations, %d new partition%s\n", w->options->model,
                 km_table_row(h->table, rows - 1)[0], unit, rows, h->figures.steps, h->figures.evaluations,
                 h->figures.repartitions, h->figures.repartitions == 1 ? "" : "s");
  ksim_print_acting(w->options->reactions, model, out);
  km_text_format(out, "  loops closed to %.1e of their size; ", h->worst_loop);
  if (h->energy_scale > h->figures.rest_energy)
    km_text_format(out, "energy kept to %.1e of the largest kinetic energy\n", h->energy_error / h->energy_scale);
  else
    km_text_add(out, "nothing moves by more than the tolerances\n");
  for (int i = 0; i < h->crossing_count; ++i) {
    const km_crossing *crossing = &w->def.simulation.crossings[h->crossings[i].crossing];
    km_text_format(out, "  %s passes %.6g %s %s at %.9g %s\n", km_model_coordinate_label(model, crossing->coordinate),
                   crossing->value, km_model_coordinate_unit(model, crossing->coordinate),
                   h->crossings[i].sense > 0 ? "upwards" : "downwards", h->crossings[i].time, unit);
  }
}

static const km_value *record(const void *context, km_arena *arena) {
  const ksim_work *w = context;
  return km_history_record(w->pose.mechanism, &w->def, &w->history, w->stopped_by, w->options->model, arena);
}

km_status ksim_chart(const ksim_work *w, const km_table *table, km_chart **out, km_error *error) {
  const km_plotted_history shown = {
      w->pose.mechanism,         table,   w->def.simulation.crossings,      w->history.crossings,
      w->history.crossing_count, w->name, w->shown_count ? w->shown : NULL, w->shown_count};
  return km_history_chart(&shown, out, error);
}

static km_status chart(const void *context, km_chart **out, km_error *error) {
  const ksim_work *w = context;
  return ksim_chart(w, w->history.table, out, error);
}

static kt_exit deliver(const ksim_work *w) {
  const ksim_options *o = w->options;
  const char *base = o->base ? o->base : w->name;
  km_text summary = {0};
  print_summary(w, &summary);
  const ksim_delivery delivery = {.common = &o->common,
                                  .formats = &o->formats,
                                  .base = base,
                                  .word = "run",
                                  .table = w->history.table,
                                  .summary = &summary,
                                  .record = record,
                                  .chart = chart,
                                  .context = w};
  kt_exit result = ksim_deliver(&delivery);
  km_text_free(&summary);
  return o->animate ? kt_worse(result, ksim_animate(w, base)) : result;
}

static kt_exit simulate(ksim_work *w) {
  km_error error;
  kt_progress progress = kt_progress_start(&w->options->common);
  w->def.progress = kt_progress_show;
  w->def.context = &progress;
  km_status status = km_history_run(w->pose.mechanism, w->forces, w->pose.state, &w->def, &w->history, &error);
  kt_progress_end(&progress);
  bool some = w->history.table && km_table_rows(w->history.table) > 0;
  if (!some) {
    kt_print_message(&w->options->common, KM_ERROR, "%s: %s", w->options->model, error.text);
    return kt_exit_of(status);
  }
  kt_exit told = tell(w, status);
  kt_exit result = status == KM_PARTIAL ? KT_DONE : kt_exit_of(status); /* the requested end */
  return kt_worse(kt_worse(result, told), deliver(w));
}

static kt_exit run(ksim_options *o) {
  ksim_work w = {.options = o};
  kt_base_name(o->model, w.name, sizeof w.name);
  kt_exit result = kt_open(&o->common, o->model, &o->holds, &o->sets, &w.pose);
  if (result == KT_DONE)
    result = prepare(&w);
  if (result == KT_DONE)
    result = simulate(&w);
  km_history_free(&w.history);
  km_forces_free(w.forces);
  km_free(w.crossings);
  km_free(w.modules);
  km_run_memory_free(w.memory);
  km_free((km_traced_frame *)w.def.frames);
  km_free(w.shown);
  kt_close(&w.pose);
  return result;
}

static kt_exit check(ksim_options *o) {
  return ksim_read_formats(&o->common, o->format, o->base, o->animate, "--format csv or json, without --animate",
                           &o->formats);
}

kt_exit ksim_run(int argc, char **argv) {
  ksim_options o = {.common = KT_COMMON("ksim"), .integrator = -1};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"until", 0, "T", "End, in the model's time unit (default: the model's, else 10 s)", KT_TEXT, &o.until,
       KT_ABOUT_MODEL},
      {"every", 0, "DT", "Time between rows (default: the model's, else a 200th of the run)", KT_TEXT, &o.every,
       KT_ABOUT_MODEL},
      {"from", 0, "TABLE.csv", "Go on from the last row of a run's table: its pose, its rates and its time", KT_INPUT,
       &o.from, KT_ABOUT_MODEL},
      KT_SET(&o.sets, KT_SET_FIRST),
      {"rate", 0, "JOINT=RATE",
       "Rate at the start, instead of the model's: A=60rpm, or in the model's unit per time unit; joints without a stated "
       "rate follow (repeatable)",
       KT_TEXTS, &o.rates, KT_ABOUT_MODEL},
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_MODE(o.common),
      KT_POSE(o.common),
      {"event", 0, "JOINT=VALUE", "Tell when a joint passes a value (repeatable)", KT_TEXTS, &o.events, KT_ABOUT_MODEL},
      {"stop", 0, "JOINT=VALUE", "End where a joint passes a value (repeatable)", KT_TEXTS, &o.stops, KT_ABOUT_MODEL},
      {"limit-stops", 0, "K[,B]",
       "Stops at the limits of joints without one: stiffness and damping (0), of hinges per radian, in the model's units",
       KT_TEXT, &o.limit_stops, KT_ABOUT_MODEL},
      {"ignore-limits", 0, NULL, "Pass limits where no stop acts, without a warning and exit status 1", KT_FLAG,
       &o.ignore_limits, KT_ABOUT_MODEL},
      {"frame", 0, "BODY/FRAME", "Add place, velocity and acceleration of a frame's origin (repeatable)", KT_TEXTS,
       &o.frames, KT_ABOUT_MODEL},
      {"reactions", 0, NULL, "Add the reaction in every joint", KT_FLAG, &o.reactions, KT_ABOUT_MODEL},
      {"axes", 0, "AXES",
       "Axes of the reactions: joint (default) or fixed. body: the frames' own axes for what --frame adds, with angular "
       "velocity and acceleration",
       KT_WORD("joint or fixed or body"), &o.axes, KT_ABOUT_MODEL},
      {"forces", 0, "NAME", "Add variable, force, power and work of a force module, or of all (repeatable)", KT_TEXTS,
       &o.forces, KT_ABOUT_MODEL},
      {"mobility", 0, NULL, "Add every joint's mobility number", KT_FLAG, &o.mobility, KT_ABOUT_MODEL},
      {"rtol", 0, "E", "Relative error that steps may add up to (default: the model's, else 1e-7)", KT_TEXT, &o.rtol,
       KT_ABOUT_METHOD},
      {"atol", 0, "E", "Absolute error that they may add up to, of radians and characteristic lengths (the same)",
       KT_TEXT, &o.atol, KT_ABOUT_METHOD},
      {"max-step", 0, "DT", "Longest step; of --integrator fixed its length", KT_TEXT, &o.max_step, KT_ABOUT_METHOD},
      {"integrator", 0, "NAME",
       "adams (changes to bdf where the motion is stiff), bdf or fixed (default: the model's, else adams)",
       KT_WORD("adams or bdf or fixed"), &o.integrator, KT_ABOUT_METHOD},
      {"stabilise", 0, "HOW", "How loops stay closed: project (default) or baumgarte", KT_WORD("project or baumgarte"),
       &o.stabilise, KT_ABOUT_METHOD},
      {"joints", 0, "LIST", "Joints whose curves are drawn (default: up to eight that move)", KT_TEXT, &o.joints,
       KT_ABOUT_FILES},
      {"animate", 0, NULL, "Write BASE.motion.html too, which plays the motion", KT_FLAG, &o.animate, KT_ABOUT_FILES},
      {"format", 0, "LIST", KT_FORMATS_HELP, KT_FORMATS_KIND, &o.format, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Files are BASE.run.FORMAT (default: the model's name); - is the standard output"),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "The motion over time from the model's pose and initial rates, under gravity, loads, springs, dampers, motors, "
      "controllers, stops, tyres and prescribed motions. Exit status 1 if stated initial rates contradict each other or a "
      "joint passes a limit where no stop acts, 4 if the run can't go on; what was reached is written."
      "\vColumns: t; q.JOINT, v.JOINT, a.JOINT; f.JOINT, the force that drives a prescribed joint; energy_kinetic, "
      "energy_potential (0 at the start), energy_dissipated, motor_work; loop_error (rms, over the loop's size), "
      "evaluations, repartitions; integrator_step, integrator_order of the last step; state.NAME.integral, slip, "
      "slip_angle, which --from continues; frame.BODY/FRAME.x … vx … ax; r.JOINT.fx … tz; m.JOINT. Rates of balls are angular "
      "velocities along the axes of the parent frame. JSON keys beside those of every record: events, beyond_max_rate, "
      "beyond_max_force, limits_passed (joint, limit, t, beyond), changed_initial_rates (joint, stated, start).",
      argc, argv);
  kt_exit result = check(&o);
  return result == KT_DONE ? run(&o) : result;
}
