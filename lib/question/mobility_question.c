/* Request of kind "mobility": mobility numbers over a sweep. */
#include "question/question.h"
#include "sweep/sweep_observer.h"

#include <math.h>

enum { SINGULARITIES, REDUNDANCIES, OPTIONS };

static const km_option options[OPTIONS] = {
    {"singularities", KM_OPTION_FLAG, NULL, "", NULL,
     "Add the smallest kept singular value, and locate its minima: where mobility is nearly gained", 0, 0, NULL, true},
    {"redundancies", KM_OPTION_FLAG, NULL, "", NULL,
     "Name the constraints that are redundant at every pose, as JSON always does", 0, 0, NULL, true},
};

typedef struct kind_data {
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
} kind_data;

static bool flag(const km_question *q, int option) {
  const km_option_value *v = km_question_own_value(q, option);
  return v && v->flag;
}

static km_status prepare(km_question *q, km_error *error) {
  (void)q;
  (void)error;
  return KM_OK;
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  q->plan.singularities = flag(q, SINGULARITIES);
  km_mobility_sweep_open(job, &((kind_data *)q->kind_data)->sweep);
}

static km_status conclude(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  return km_sweep_redundancies_find(q->m, &o->sweep.motion, flag(q, REDUNDANCIES), &o->redundancies, error);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

static int event_count(const km_question *q) {
  const kind_data *o = q->kind_data;
  return (int)(o->sweep.toggle_count + o->sweep.minimum_count);
}

static km_question_event event(const km_question *q, int index) {
  const kind_data *o = q->kind_data;
  int toggles = (int)o->sweep.toggle_count;
  if (index >= toggles) {
    const km_extreme *e = &o->sweep.minima[index - toggles];
    return (km_question_event){"minimum", "", e->s, e->number};
  }
  const km_toggle *t = &o->sweep.toggles[index];
  return (km_question_event){"toggle", km_model_coordinate_label(q->m->model, t->coordinate), t->s, 0.0};
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_question_keep_table(q, &o->sweep.motion);
  km_mobility_sweep_free(&o->sweep);
  km_sweep_redundancies_free(&o->redundancies);
}

static void clear_preparation(km_question *q) {
  (void)q;
}

const km_question_class km_mobility_question = {.name = "mobility",
                                                .options = options,
                                                .option_count = OPTIONS,
                                                .shared = km_motion_options,
                                                .shared_count = KM_MOTION_OPTIONS,
                                                .size = sizeof(kind_data),
                                                .prepare = prepare,
                                                .open = open_sweep,
                                                .conclude = conclude,
                                                .motion = motion,
                                                .event_count = event_count,
                                                .event = event,
                                                .clear_result = clear_result,
                                                .clear_preparation = clear_preparation};

const km_mobility_sweep *km_question_mobility(const km_question *q) {
  return km_question_has(q, &km_mobility_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}

const km_sweep_redundancies *km_question_redundancies(const km_question *q) {
  return km_question_has(q, &km_mobility_question) ? &((const kind_data *)q->kind_data)->redundancies : NULL;
}
