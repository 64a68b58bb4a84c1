/* Request of kind "clearance": distances of bodies over a sweep, and where they touch. */
#include "kinematics/body_poses.h"
#include "question/question.h"
#include "sweep/sweep_observer.h"

enum { BETWEEN, OPTIONS };

static const km_option options[OPTIONS] = {
    {"between", KM_OPTION_BODY_PAIRS, "BODY,BODY", "", "all that no joint connects and that are apart at the pose",
     "Two bodies whose clearance is wanted (repeatable)", 0, 0, NULL, false},
};

typedef struct kind_data {
  km_clearance_sweep sweep;
  km_clearance *clearance; /* NULL: not created yet */
} kind_data;

km_status km_question_prepare_clearance(const km_question *q, km_state *s, const km_option_value *between,
                                        km_clearance **out, km_error *error) {
  if (*out)
    return KM_OK;
  km_poses_compute(q->m, s);
  return km_clearance_create(q->m, s, between ? between->pairs : NULL, between ? between->count : 0, out, error);
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  kind_data *o = q->kind_data;
  job->status = km_question_prepare_clearance(q, job->s, km_question_own_value(q, BETWEEN), &o->clearance, job->error);
  q->plan.clearance = o->clearance;
  if (!job->status)
    km_clearance_sweep_open(job, &o->sweep);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

int km_clearance_event_count(const km_clearance_course *course) {
  return (int)course->contact_count + (course->smallest_pair >= 0);
}

km_question_event km_clearance_event(const km_clearance_course *course, int index) {
  if (index >= (int)course->contact_count)
    return (km_question_event){"minimum", km_clearance_pair_name(course->clearance, course->smallest_pair),
                               course->smallest.s, course->smallest.number};
  const km_contact_event *e = &course->contacts[index];
  return (km_question_event){"contact", km_clearance_pair_name(course->clearance, e->pair), e->s, 0.0};
}

static int event_count(const km_question *q) {
  return km_clearance_event_count(&((const kind_data *)q->kind_data)->sweep.course);
}

static km_question_event event(const km_question *q, int index) {
  const kind_data *o = q->kind_data;
  return km_clearance_event(&o->sweep.course, index);
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_question_keep_table(q, &o->sweep.motion);
  km_clearance_sweep_free(&o->sweep);
}

static void clear_preparation(km_question *q) {
  kind_data *o = q->kind_data;
  km_clearance_free(o->clearance);
  o->clearance = NULL;
}

const km_question_class km_clearance_question = {.name = "clearance",
                                                 .options = options,
                                                 .option_count = OPTIONS,
                                                 .shared = km_motion_options,
                                                 .shared_count = KM_MOTION_OPTIONS,
                                                 .size = sizeof(kind_data),
                                                 .open = open_sweep,
                                                 .motion = motion,
                                                 .event_count = event_count,
                                                 .event = event,
                                                 .clear_result = clear_result,
                                                 .clear_preparation = clear_preparation};

const km_clearance_sweep *km_question_clearances(const km_question *q) {
  return km_question_has(q, &km_clearance_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}
