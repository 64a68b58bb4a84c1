/* Request of kind "advantage": mechanical advantage over a sweep. */
#include "question/question.h"
#include "sweep/sweep_observer.h"

#include "base/text.h"
#include "kmech/inspect.h"

#include <math.h>

enum { INPUT, OUTPUT, TRANSMISSION, OPTIONS };

static const km_option options[OPTIONS] = {
    {"input", KM_OPTION_END, "JOINT", "", "the model's analysis.mechanical_advantage",
     "What is pushed: a joint, or BODY/FRAME:DX,DY,DZ, a point along a direction", 0, 0, NULL, false},
    {"output", KM_OPTION_END, "JOINT", "", NULL, "What pushes: a joint, or a point in the same way", 0, 0, NULL, false},
    {"transmission", KM_OPTION_FLAG, NULL, "", NULL,
     "Add transmission angle, virtual coefficient, Sutherland-Roth and Chen-Angeles indices, manipulability and "
     "condition number as columns, and the angles of each hinge of a planar linkage; nan where undefined",
     0, 0, NULL, true},
};

typedef struct kind_data {
  km_port ends[2]; /* input, output */
  km_advantage_sweep sweep;
} kind_data;

/* Returns a port from the options, else from the model. A joint's columns have its label. */
static bool read_port(const km_question *q, int option, km_port *out) {
  const km_option_value *v = km_question_own_value(q, option);
  if (!v)
    return km_port_default(q->m->model, option == OUTPUT, out);
  *out = v->end;
  if (out->kind == KM_PORT_JOINT)
    out->name = km_model_coordinate_label(q->m->model, out->coordinate);
  return true;
}

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  for (int j = -1; (j = km_model_next_without_radius(q->m->model, j + 1)) >= 0;)
    km_messages_add(
        q->notes, KM_NOTE,
        "joint %s has a coefficient of friction but no radius: it turns without friction, under a thrust along "
        "its axis too",
        q->m->model->joints[j].label);
  bool have_input = read_port(q, INPUT, &o->ends[0]), have_output = read_port(q, OUTPUT, &o->ends[1]);
  if (have_input && have_output)
    return KM_OK;
  return km_fail(error, KM_USAGE, "the model's analysis.mechanical_advantage has no %s; expected `%s`",
                 have_input ? "output" : "input", have_input ? "output" : "input");
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  kind_data *o = q->kind_data;
  const km_option_value *transmission = km_question_own_value(q, TRANSMISSION);
  km_advantage_sweep_open(job, &o->ends[0], &o->ends[1], transmission && transmission->flag, &o->sweep);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

/* Events: dead points, then both extrema. */
static int event_count(const km_question *q) {
  return (int)((const kind_data *)q->kind_data)->sweep.toggle_count + 2;
}

static km_question_event event(const km_question *q, int index) {
  const km_advantage_sweep *sweep = &((const kind_data *)q->kind_data)->sweep;
  int extreme = index - (int)sweep->toggle_count;
  if (extreme >= 0) {
    const km_peak *peak = extreme ? &sweep->highest : &sweep->lowest;
    return (km_question_event){extreme ? "maximum" : "minimum", "", peak->s, peak->value};
  }
  const km_advantage_toggle *t = &sweep->toggles[index];
  const char *name = t->state == KM_ADVANTAGE_ZERO ? "zero" : t->state == KM_ADVANTAGE_INFINITE ? "pole" : "undefined";
  double value = t->state == KM_ADVANTAGE_ZERO ? 0.0 : t->state == KM_ADVANTAGE_INFINITE ? HUGE_VAL : nan("");
  return (km_question_event){name, "", t->s, value};
}

static void clear_result(km_question *q) {
  km_advantage_sweep *sweep = &((kind_data *)q->kind_data)->sweep;
  km_question_keep_table(q, &sweep->motion);
  km_advantage_sweep_free(sweep);
}

const km_question_class km_advantage_question = {.name = "advantage",
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

const km_advantage_sweep *km_question_advantage(const km_question *q) {
  return km_question_has(q, &km_advantage_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}

const km_port *km_question_end(const km_question *q, bool output) {
  return km_question_is(q, &km_advantage_question) ? &((const kind_data *)q->kind_data)->ends[output] : NULL;
}
