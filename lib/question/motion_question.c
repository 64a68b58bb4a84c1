/* Request of kind "motion": swings, velocities and accelerations over a sweep by a driver of constant rate. */
#include "question/question.h"
#include "sweep/sweep_observer.h"

#include <math.h>

enum { RATE, OPTIONS };

static const km_option options[OPTIONS] = {
    {"rate", KM_OPTION_SETTINGS, "JOINT=RATE", "the driver's per time", "1 of the driver's unit per time unit",
     "Constant rate of the driver: A=60rpm, or in the model's unit per time unit", 0, 0, NULL, true},
};

typedef struct kind_data {
  km_motion_sweep sweep;
  double rate; /* rate of the driver, its unit per time unit */
} kind_data;

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *rate = km_question_own_value(q, RATE);
  o->rate = rate ? rate->settings[0] : 1.0;
  if (rate && rate->count != 1)
    return km_fail(error, KM_USAGE, "`rate`: found %d joints; expected the driver alone", rate->count);
  if (o->rate == 0.0)
    return km_fail(error, KM_USAGE, "`rate` 0: expected a rate other than 0");
  return KM_OK;
}

/* Refuses a motion without a driver, and a rate of another joint. */
static km_status check_driver(const km_question *q, km_error *error) {
  const km_option_value *rate = km_question_own_value(q, RATE);
  int driver = q->plan.coordinate;
  if (driver < 0 || q->plan.arclength > 0.0 || q->plan.steps < 1)
    return km_fail(error, KM_USAGE, "a \"motion\" question is about a driver's range; expected `joint` and `range`");
  if (rate && rate->coordinates[0] != driver)
    return km_fail(
        error, KM_USAGE, "`rate`: \"%s\" isn't the driver; expected \"%s\", or `joint` and `range` of \"%s\"",
        km_model_coordinate_label(q->m->model, rate->coordinates[0]), km_model_coordinate_label(q->m->model, driver),
        km_model_coordinate_label(q->m->model, rate->coordinates[0]));
  if (rate && rate->settings[0] < 0.0 && q->plan.to > q->plan.from)
    return km_fail(error, KM_USAGE,
                   "`rate` %g: the range goes upwards; expected a positive rate, or the range reversed",
                   rate->settings[0]);
  return KM_OK;
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  kind_data *o = q->kind_data;
  job->out = &o->sweep.motion;
  job->status = check_driver(q, job->error);
  if (!job->status)
    km_motion_sweep_open(job, copysign(o->rate, q->plan.to - q->plan.from), &o->sweep);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

/* Extremes of the coordinates that swing, the least one first. */
static int event_count(const km_question *q) {
  return 2 * ((const kind_data *)q->kind_data)->sweep.swing_count;
}

static km_question_event event(const km_question *q, int index) {
  const km_swing *swing = &((const kind_data *)q->kind_data)->sweep.swings[index / 2];
  const char *label = km_model_coordinate_label(q->m->model, swing->coordinate);
  return index % 2 ? (km_question_event){"maximum", label, swing->s_high, swing->high}
                   : (km_question_event){"minimum", label, swing->s_low, swing->low};
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_question_keep_table(q, &o->sweep.motion);
  km_motion_sweep_free(&o->sweep);
}

const km_question_class km_motion_question = {.name = "motion",
                                              .options = options,
                                              .option_count = OPTIONS,
                                              .shared = km_motion_options,
                                              .shared_count = KM_MOTION_OPTIONS,
                                              .size = sizeof(kind_data),
                                              .prepare = prepare,
                                              .open = open_sweep,
                                              .motion = motion,
                                              .event_count = event_count,
                                              .event = event,
                                              .clear_result = clear_result};

const km_motion_sweep *km_question_velocities(const km_question *q) {
  return km_question_has(q, &km_motion_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}
