/* Request of kind "allowance": play that redundant constraints need for errors of the parts, over a sweep. */
#include "question/question.h"
#include "sweep/sweep_observer.h"

enum { TOLERANCE, CLEARANCE, OPTIONS };

/* Tolerance of joints without one: round numbers, to be replaced by those of the drawing. */
static const double default_position = 1e-4 /* m */, default_direction = 0.1 /* degrees */;

static const km_option options[OPTIONS] = {
    {"tolerance", KM_OPTION_PAIR, "PLACE[,ANGLE]", "length, angle", "0.1 mm,0.1 deg",
     "How far the place of a joint on each of its bodies may be off, and the angle of its axes (without it 0), in the "
     "model's units, where the joint states no tolerance",
     0, 0, NULL, false},
    {"clearance", KM_OPTION_PAIR, "PLAY[,ANGLE]", "length, angle", "as large as the tolerance",
     "Play of joints that state no clearance, in every direction and (without it 0) about every axis that they "
     "constrain, in the model's units",
     0, 0, NULL, false},
};

typedef struct kind_data {
  km_allowance_sweep sweep;
  km_fit_defaults defaults;
} kind_data;

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_model *model = q->m->model;
  const km_option_value *tolerance = km_question_own_value(q, TOLERANCE),
                        *clearance = km_question_own_value(q, CLEARANCE);
  const double radian = model->units.angle->si;
  o->defaults.position = tolerance ? tolerance->numbers[0] : default_position / km_model_length_unit(model);
  o->defaults.direction = tolerance ? tolerance->numbers[1] * radian : default_direction * M_PI / 180.0;
  o->defaults.play = clearance ? clearance->numbers[0] : o->defaults.position;
  o->defaults.angle = clearance ? clearance->numbers[1] * radian : o->defaults.direction;
  o->defaults.states_play = clearance != NULL;
  const double number[4] = {o->defaults.position, o->defaults.direction, o->defaults.play, o->defaults.angle};
  for (int k = 0; k < 4; ++k)
    if (number[k] < 0.0)
      return km_fail(error, KM_USAGE, "`%s` %g is negative; expected numbers of at least 0",
                     k < 2 ? "tolerance" : "clearance", k % 2 ? number[k] / radian : number[k]);
  return KM_OK;
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  kind_data *o = q->kind_data;
  km_allowance_sweep_open(job, &o->defaults, &o->sweep);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

/* The rows with the largest ratios. */
static int event_count(const km_question *q) {
  return ((const kind_data *)q->kind_data)->sweep.constraint_count > 0 ? 2 : 0;
}

static km_question_event event(const km_question *q, int index) {
  const km_allowance_sweep *sweep = &((const kind_data *)q->kind_data)->sweep;
  const km_peak *peak = index ? &sweep->statistical : &sweep->worst;
  return (km_question_event){"maximum", index ? "play.statistical" : "play.worst", peak->s, peak->value};
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_question_keep_table(q, &o->sweep.motion);
  km_allowance_sweep_free(&o->sweep);
}

const km_question_class km_allowance_question = {.name = "allowance",
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

const km_allowance_sweep *km_question_allowance(const km_question *q) {
  return km_question_has(q, &km_allowance_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}
