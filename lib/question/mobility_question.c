/* Request of kind "mobility": mobility numbers over a sweep. */
#include "question/question.h"
#include "sweep/sweep_observer.h"

#include <math.h>

enum { SINGULARITIES, REDUNDANCIES, TRANSMISSION, OUTPUT, CLEARANCE, BETWEEN, OPTIONS };

static const km_option options[OPTIONS] = {
    {"singularities", KM_OPTION_FLAG, NULL, "", NULL,
     "Add the smallest kept singular value, and locate its minima: where mobility is nearly gained", 0, 0, NULL, true},
    {"redundancies", KM_OPTION_FLAG, NULL, "", NULL,
     "Name the constraints that are redundant at every pose, as JSON always does", 0, 0, NULL, true},
    {"transmission", KM_OPTION_FLAG, NULL, "", NULL,
     "Add the transmission from the driver to an output as columns, as kma sweep does: angles of the hinges, indices, "
     "joint force index; nan where undefined",
     0, 0, NULL, true},
    {"output", KM_OPTION_END, "JOINT", "", "the model's analysis.mechanical_advantage",
     "Output of the transmission: a joint, or BODY/FRAME:DX,DY,DZ, a point along a direction", 0, 0, NULL, false},
    {"clearance", KM_OPTION_FLAG, NULL, "", NULL,
     "Add the distances of bodies by their shapes and meshes, and locate where they touch", 0, 0, NULL, false},
    {"between", KM_OPTION_BODY_PAIRS, "BODY,BODY", "", "all that no joint connects and that are apart at the pose",
     "With the clearance: two bodies whose distance is wanted (repeatable)", 0, 0, NULL, false},
};

typedef struct kind_data {
  km_port ports[2]; /* input and output of the transmission */
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
  km_clearance *clearance; /* NULL: not requested, or not created yet */
} kind_data;

static bool flag(const km_question *q, int option) {
  const km_option_value *v = km_question_own_value(q, option);
  return v && v->flag;
}

/* The driver, or for a motion by arc length the model's own input. */
static bool find_input(const km_question *q, km_port *out) {
  const int driver = q->plan.coordinate;
  if (!km_plan_is_driven(&q->plan) || driver < 0)
    return km_port_default(q->m->model, false, out);
  *out = (km_port){.kind = KM_PORT_JOINT, .coordinate = driver, .name = km_model_coordinate_label(q->m->model, driver)};
  return true;
}

static bool find_output(const km_question *q, km_port *out) {
  const km_option_value *v = km_question_own_value(q, OUTPUT);
  if (!v)
    return km_port_default(q->m->model, true, out);
  *out = v->end;
  if (out->kind == KM_PORT_JOINT)
    out->name = km_model_coordinate_label(q->m->model, out->coordinate);
  return true;
}

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  if (km_question_own_value(q, BETWEEN) && !flag(q, CLEARANCE))
    return km_fail(error, KM_USAGE, "`between`: expected `clearance` with it");
  if (!flag(q, TRANSMISSION))
    return KM_OK;
  if (!find_output(q, &o->ports[1]))
    return km_fail(error, KM_USAGE,
                   "`transmission`: the model's analysis.mechanical_advantage has no output; expected `output`");
  return KM_OK;
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  q->plan.singularities = flag(q, SINGULARITIES);
  kind_data *o = q->kind_data;
  const bool transmits = flag(q, TRANSMISSION);
  if (flag(q, CLEARANCE))
    job->status =
        km_question_prepare_clearance(q, job->s, km_question_own_value(q, BETWEEN), &o->clearance, job->error);
  if (job->status)
    return;
  q->plan.clearance = o->clearance;
  const bool has_input = transmits && find_input(q, &o->ports[0]);
  km_mobility_sweep_open(job, has_input ? o->ports : NULL, &o->sweep);
  if (transmits && !has_input)
    job->status = km_fail(job->error, KM_USAGE,
                          "`transmission` along an arc: the model's analysis.mechanical_advantage has no input");
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
  return (int)(o->sweep.toggle_count + o->sweep.minimum_count) + km_clearance_event_count(&o->sweep.clearances);
}

static km_question_event event(const km_question *q, int index) {
  const kind_data *o = q->kind_data;
  int toggles = (int)o->sweep.toggle_count, own = toggles + (int)o->sweep.minimum_count;
  if (index >= own)
    return km_clearance_event(&o->sweep.clearances, index - own);
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
  kind_data *o = q->kind_data;
  km_clearance_free(o->clearance);
  o->clearance = NULL;
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
