/* Options of every motion, the plan that they define, and the events of every motion. */
#include "question/question.h"
#include "sweep/sweep.h"

#include "base/arguments.h"

#include <math.h>

const km_option km_motion_options[KM_MOTION_OPTIONS] = {
    {"joint", KM_OPTION_COORDINATE, "JOINT", "", "the model's analysis.sweep", "The driver", 0, 0, NULL, true},
    {"range", KM_OPTION_RANGE, "FROM:TO", "driver's", "the model's, or the joint's limits",
     "Its range in the model's unit", 0, 0, NULL, true},
    {"steps", KM_OPTION_WHOLE, "N", "", NULL, "Number of intervals; N + 1 rows", 1, KM_MAX_SWEEP_STEPS, NULL, true},
    {"arclength", KM_OPTION_NUMBER, "DS", "", NULL,
     "Follow the motion by arc length instead, DS a row: through dead points", KM_MIN_ARCLENGTH, KM_MAX_ARCLENGTH, NULL,
     true},
    {"direction", KM_OPTION_SENSE, "JOINT=+1", "", NULL, "Start so that this joint moves forwards (or -1: backwards)",
     0, 0, NULL, true},
    {"cycle", KM_OPTION_FLAG, NULL, "", NULL,
     "Follow until the motion meets its start (at most as many rows as `steps`, default 100000)", 0, 0, NULL, true},
    {"branch", KM_OPTION_WHOLE, "K", "", NULL,
     "Motion to take at the first branch point: 1 goes on smoothly (default), 2 and 3 are the next one ahead and back, "
     "…",
     1, 31, NULL, true},
    {"ignore-limits", KM_OPTION_FLAG, NULL, "", NULL, "Pass joint limits", 0, 0, NULL, true},
    {"derivatives", KM_OPTION_FLAG, NULL, "", NULL, "Add the points' derivatives along the driver", 0, 0, NULL, true},
    {"point", KM_OPTION_POINTS, "BODY/FRAME", "", NULL, "Add the path of a frame's origin (repeatable)", 0, 0, NULL,
     true},
};

static bool is_set(const km_question *q, int option) {
  const km_option_value *v = km_question_motion_value(q, option);
  return v && (v->flag || km_motion_options[option].type != KM_OPTION_FLAG);
}

static const char *label(const km_question *q, int coordinate) {
  return q->m->model->coordinates[coordinate].label;
}

/* Applies the driver and its range to the model's plan. */
static km_status plan_driver(const km_question *q, km_sweep_plan *plan, km_error *error) {
  const km_option_value *joint = km_question_motion_value(q, KM_MOTION_JOINT),
                        *range = km_question_motion_value(q, KM_MOTION_RANGE);
  if (joint && joint->coordinate != plan->coordinate) {
    km_model_coordinate_limits(q->m->model, joint->coordinate, &plan->from, &plan->to);
    if (!range && !(isfinite(plan->from) && isfinite(plan->to)))
      return km_fail(error, KM_USAGE, "`joint` %s: expected `range` with it, since the model has none for this joint",
                     label(q, joint->coordinate));
  }
  if (joint)
    plan->coordinate = joint->coordinate;
  if (range) {
    plan->from = range->numbers[0];
    plan->to = range->numbers[1];
  }
  return KM_OK;
}

/* Applies the arc length and its options to the model's plan. */
static km_status plan_length(const km_question *q, km_sweep_plan *plan, km_error *error) {
  const km_option_value *length = km_question_motion_value(q, KM_MOTION_ARCLENGTH),
                        *direction = km_question_motion_value(q, KM_MOTION_DIRECTION),
                        *branch = km_question_motion_value(q, KM_MOTION_BRANCH_POINT);
  bool driven = is_set(q, KM_MOTION_JOINT) || is_set(q, KM_MOTION_RANGE);
  if (length && driven)
    return km_fail(error, KM_USAGE, "`arclength` %g: expected it without `joint` and `range`", length->numbers[0]);
  if (length)
    plan->arclength = length->numbers[0];
  if (driven)
    plan->arclength = 0.0;
  plan->cycle = is_set(q, KM_MOTION_CYCLE);
  if (plan->arclength <= 0.0 && (direction || plan->cycle || branch))
    return km_fail(error, KM_USAGE, "`%s`: expected `arclength` with it",
                   plan->cycle ? "cycle"
                   : direction ? "direction"
                               : "branch");
  plan->branch = branch ? branch->whole : 1;
  if (plan->cycle)
    plan->steps = 100000;
  if (direction) {
    plan->direction = direction->coordinate;
    plan->sign = direction->numbers[0];
  }
  return KM_OK;
}

km_status km_question_make_plan(km_question *q, km_sweep_plan *out, km_error *error) {
  km_status given = km_check_given(q && out, "question or place for its plan", error);
  if (given)
    return given;
  if (!q->kind->motion)
    return km_fail(error, KM_USAGE, "a \"%s\" question has no plan of a sweep", q->kind->name);
  km_sweep_plan plan = km_sweep_plan_default(q->m->model);
  const km_option_value *steps = km_question_motion_value(q, KM_MOTION_STEPS),
                        *points = km_question_motion_value(q, KM_MOTION_POINT);
  km_status status = plan_driver(q, &plan, error);
  if (!status)
    status = plan_length(q, &plan, error);
  if (status)
    return status;
  if (plan.coordinate < 0 && plan.arclength <= 0.0)
    return km_fail(error, KM_USAGE, "the model has no analysis.sweep; expected `joint` and `range`, or `arclength`");
  if (steps)
    plan.steps = steps->whole;
  plan.ignore_limits = is_set(q, KM_MOTION_IGNORE_LIMITS);
  plan.derivatives = is_set(q, KM_MOTION_DERIVATIVES);
  if (plan.derivatives && !(points && points->count))
    return km_fail(error, KM_USAGE, "`derivatives`: expected `point` with it: the points whose derivatives are wanted");
  plan.points = points ? points->points : NULL;
  plan.point_count = points ? points->count : 0;
  *out = plan;
  return KM_OK;
}

/* Name of the event at an end of the motion. */
static const char *stop_name(km_stop stop) {
  return stop == KM_STOP_LIMIT ? "limit" : "end";
}

static int stop_count(const km_sweep *motion) {
  return (motion->start.stop != KM_STOP_NONE) + (motion->end.stop != KM_STOP_NONE);
}

static km_question_event stop_at(const km_question *q, const km_sweep *motion, int index) {
  const km_motion_end *reach = motion->start.stop != KM_STOP_NONE && index == 0 ? &motion->start : &motion->end;
  const char *subject = reach->stop == KM_STOP_LIMIT ? label(q, reach->coordinate) : "";
  return (km_question_event){stop_name(reach->stop), subject, reach->position, nan("")};
}

int km_question_event_count(const km_question *q) {
  const km_sweep *motion = km_question_motion(q);
  if (!q || !q->has_result)
    return 0;
  return q->kind->event_count(q) + (motion ? (int)motion->branch_count + stop_count(motion) : 0);
}

km_question_event km_question_event_at(const km_question *q, int index) {
  const km_sweep *motion = km_question_motion(q);
  if (index < 0 || index >= km_question_event_count(q))
    return (km_question_event){"", "", nan(""), nan("")};
  int own = q->kind->event_count(q);
  if (index < own)
    return q->kind->event(q, index);
  int branches = (int)motion->branch_count;
  if (index < own + branches)
    return (km_question_event){"branch point", "", motion->branches[index - own].s,
                               motion->branches[index - own].branches};
  return stop_at(q, motion, index - own - branches);
}
