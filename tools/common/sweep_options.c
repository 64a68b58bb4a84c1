/* The options of the sweep commands, and the plan that they make. */
#include "common/sweep.h"

#include "model/model.h"

#include <stdio.h>
#include <string.h>

void kt_sweep_options_add(kt_options *out, kt_sweep_options *o) {
  const kt_option table[] = {
      {"joint", 0, "JOINT", "The driver (default: the model's analysis.sweep)", KT_TEXT, &o->joint, KT_ABOUT_MODEL},
      {"range", 0, "FROM:TO", "Its range in the model's unit", KT_TEXT, &o->range, KT_ABOUT_MODEL},
      {"steps", 0, "N", "Number of intervals; N + 1 rows", KT_TEXT, &o->steps, KT_ABOUT_MODEL},
      {"arclength", 0, "DS", "Follow the motion by arc length instead, DS a row: through toggles", KT_TEXT,
       &o->arclength, KT_ABOUT_MODEL},
      {"direction", 0, "JOINT=+1", "Start so that this joint moves forwards (or -1: backwards)", KT_TEXT, &o->direction,
       KT_ABOUT_MODEL},
      {"cycle", 0, NULL, "Follow until the motion meets its start (at most --steps rows, default 100000)", KT_FLAG,
       &o->cycle, KT_ABOUT_MODEL},
      {"branch", 0, "K",
       "Motion to take at the first branch point: 1 goes on smoothly (default), 2 and 3 are the next one ahead and "
       "back, …",
       KT_TEXT, &o->branch, KT_ABOUT_MODEL},
      KT_HOLD(&o->holds, KT_HOLD_RIGID),
      KT_MODE(o->common),
      KT_SET(&o->sets, KT_SET_FIRST),
      {"ignore-limits", 0, NULL, "Pass joint limits", KT_FLAG, &o->ignore_limits, KT_ABOUT_MODEL},
      {"derivatives", 0, NULL, "Add the points' derivatives along the driver", KT_FLAG, &o->derivatives,
       KT_ABOUT_MODEL},
  };
  KT_OPTIONS_ADD(out, table);
}

void kt_sweep_options_several(kt_options *out, kt_sweep_options *o, const char *base_help) {
  const kt_option table[] = {
      {"format", 0, "LIST", KT_FORMATS_HELP, KT_TEXT, &o->format, KT_ABOUT_FILES},
      KT_BASE(&o->base, base_help),
  };
  kt_sweep_options_add(out, o);
  KT_OPTIONS_ADD(out, table);
  kt_common_options(out, &o->common, KT_USES_JOBS);
  out->operand = (kt_operand){"model", "MODEL...", true, NULL, &o->models};
}

static kt_exit read_range(const kt_common *common, const kt_sweep_options *o, km_sweep_plan *plan) {
  const char *colon = strchr(o->range, ':');
  char from[64];
  if (!colon || (size_t)(colon - o->range) >= sizeof from)
    return kt_usage(common, "--range", o->range, "FROM:TO");
  snprintf(from, sizeof from, "%.*s", (int)(colon - o->range), o->range);
  if (!kt_number(from, &plan->from) || !kt_number(colon + 1, &plan->to))
    return kt_usage(common, "--range", o->range, "two numbers FROM:TO");
  return KT_DONE;
}

static kt_exit read_steps(const kt_common *common, const kt_sweep_options *o, km_sweep_plan *plan) {
  double steps;
  if (!kt_number(o->steps, &steps) || steps < 1.0 || steps > 1e7 || steps != (double)(int)steps)
    return kt_usage(common, "--steps", o->steps, "a whole number from 1 to 10000000");
  plan->steps = (int)steps;
  return KT_DONE;
}

static kt_exit read_point(kt_sweep_job *j, const char *text) {
  km_sweep_point *point = &j->points[j->plan.point_count];
  kt_exit result = kt_frame(&j->common, j->pose.model, "--point", text, &point->frame);
  if (result != KT_DONE)
    return result;
  point->name = j->names[j->plan.point_count++] = kt_plain(text);
  return point->name ? KT_DONE : KT_INTERNAL;
}

/* --arclength --direction --cycle over the model's own. */
static kt_exit read_length(const kt_common *common, const kt_sweep_options *o, const km_model *model,
                           km_sweep_plan *plan) {
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

kt_exit kt_sweep_plan(kt_sweep_job *j) {
  const kt_sweep_options *o = j->options;
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
  if (o->derivatives && o->points.count == 0)
    return kt_usage(common, "--derivatives", "is alone", "--point with it: the points whose derivatives are wanted");
  j->plan.points = j->points;
  for (int i = 0; i < o->points.count && result == KT_DONE; ++i)
    result =
        i < KT_MOST_POINTS ? read_point(j, o->points.items[i]) : kt_usage(common, "--point", "", "at most 64 points");
  return result;
}
