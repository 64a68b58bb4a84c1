/* Request of kind "forces": forces of actuators and reactions over a sweep. */
#include "question/question.h"
#include "statics/statics.h"
#include "sweep/sweep_observer.h"

#include "kinematics/state.h"

#include <math.h>

enum { ACTUATORS, PUSH, LOAD, GRAVITY, AXES, OPTIONS };

static const km_option options[OPTIONS] = {
    {"actuators", KM_OPTION_COORDINATES, "JOINT,JOINT", "", "the model's analysis.actuators, else every free joint",
     "The joints that hold the mechanism", 0, 0, NULL, false},
    {"push", KM_OPTION_ENDS, "BODY/FRAME:DX,DY,DZ", "", NULL,
     "A force at a frame's origin along a direction holds too, as that of a hand; without other actuators it is the only "
     "one (repeatable)",
     0, 0, NULL, false},
    {"load", KM_OPTION_LOADS, "NAME=FX,FY,FZ[,TX,TY,TZ]", "force, force × length", NULL,
     "Give a load of the model another force (and torque), NAME=FACTOR: scale it; BODY/FRAME=… adds one at a frame's "
     "origin. :frame behind the numbers turns its axes with the frame (repeatable)",
     0, 0, NULL, false},
    {"gravity", KM_OPTION_VECTOR, "X,Y,Z", "length/time²", NULL, "Another gravity than the model's, length/time²", 0, 0,
     NULL, false},
    {"axes", KM_OPTION_WORD, "AXES", "", NULL,
     "Axes of the reactions: joint (of the child's joint frame, default) or fixed", 0, KM_AXES_FIXED, "joint or fixed",
     false},
};
_Static_assert(KM_AXES_JOINT == 0 && KM_AXES_FIXED == 1, "the words of `axes` stand in the order of km_axes");

typedef struct kind_data {
  km_forces *forces;
  km_statics statics;
  km_statics_sweep sweep;
} kind_data;

/* Creates the loads: the model's own unless others are set. */
static km_status create_loads(const km_question *q, const km_option_value *set, kind_data *o, km_error *error) {
  const km_option_value *gravity = km_question_own_value(q, GRAVITY);
  int count = set ? set->count : km_model_load_count(q->m->model);
  km_load *loads = KM_NEW(km_load, (size_t)count);
  if (!loads)
    return km_fail(error, KM_MEMORY, "out of memory for the loads");
  for (int i = 0; i < count; ++i)
    loads[i] = set ? set->loads[i] : km_model_load_at(q->m->model, i);
  km_status status = km_forces_create(q->m, gravity ? gravity->numbers : NULL, loads, count, &o->forces, error);
  km_free(loads);
  return status;
}

static void add_joint(const km_question *q, int coordinate, km_port *out, int *count) {
  out[(*count)++] = (km_port){
      .kind = KM_PORT_JOINT, .coordinate = coordinate, .name = km_model_coordinate_label(q->m->model, coordinate)};
}

/* Adds the model's actuators, except held ones. */
static void add_model_actuators(km_question *q, km_port *out, int *count) {
  const km_model *model = q->m->model;
  for (int i = 0; i < model->actuator_count; ++i) {
    if (!q->m->held[model->actuators[i]])
      add_joint(q, model->actuators[i], out, count);
    else
      km_messages_add(q->notes, KM_NOTE, "actuator %s is held and so rigid",
                      km_model_coordinate_label(model, model->actuators[i]));
  }
}

static km_status prepare_balance(km_question *q, kind_data *o, km_error *error) {
  const km_model *model = q->m->model;
  const km_option_value *joints = km_question_own_value(q, ACTUATORS), *pushes = km_question_own_value(q, PUSH),
                        *axes = km_question_own_value(q, AXES);
  km_axes wanted = axes ? (km_axes)axes->whole : KM_AXES_JOINT;
  if (!joints && !pushes && !model->actuators_given) {
    km_messages_add(q->notes, KM_NOTE, "no analysis.actuators and no `actuators`: every free joint holds");
    return km_statics_create_for(q->m, NULL, 0, wanted, &o->statics, error);
  }
  if (!joints && !pushes && model->actuator_count == 0)
    return km_fail(error, KM_USAGE, "analysis.actuators is empty; expected at least one joint, or `actuators`");
  size_t most =
      (size_t)model->actuator_count + (joints ? (size_t)joints->count : 0) + (pushes ? (size_t)pushes->count : 0);
  int count = 0;
  km_port *handles = KM_NEW(km_port, most);
  if (!handles)
    return km_fail(error, KM_MEMORY, "out of memory for the actuators");
  for (int i = 0; joints && i < joints->count; ++i)
    add_joint(q, joints->coordinates[i], handles, &count);
  if (!joints && !pushes)
    add_model_actuators(q, handles, &count);
  for (int i = 0; pushes && i < pushes->count; ++i)
    handles[count++] = pushes->ends[i];
  km_status status = km_statics_create_for(q->m, handles, count, wanted, &o->statics, error);
  km_free(handles);
  return status;
}

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  km_status status = create_loads(q, km_question_own_value(q, LOAD), o, error);
  if (!status)
    status = prepare_balance(q, o, error);
  if (!status && q->no_reactions)
    km_statics_skip_reactions(q->m, &o->statics);
  return status;
}

static void open_sweep(km_question *q, km_sweep_job *job) {
  kind_data *o = q->kind_data;
  km_statics_sweep_open(job, o->forces, &o->statics, &o->sweep);
}

static const km_sweep *motion(const km_question *q) {
  return &((const kind_data *)q->kind_data)->sweep.motion;
}

static int event_count(const km_question *q) {
  return (int)((const kind_data *)q->kind_data)->sweep.event_count;
}

static km_question_event event(const km_question *q, int index) {
  const km_statics_sweep *sweep = &((const kind_data *)q->kind_data)->sweep;
  const km_force_event *e = &sweep->events[index];
  const char *name = e->kind == KM_FORCE_BALANCED ? "zero" : e->kind == KM_FORCE_PEAK ? "peak" : "pole";
  return (km_question_event){name, sweep->actuators[e->actuator].name, e->s, e->value};
}

static void clear_result(km_question *q) {
  km_statics_sweep *sweep = &((kind_data *)q->kind_data)->sweep;
  km_question_keep_table(q, &sweep->motion);
  km_statics_sweep_free(sweep);
}

static void clear_preparation(km_question *q) {
  kind_data *o = q->kind_data;
  km_forces_free(o->forces);
  km_statics_free(&o->statics);
  o->forces = NULL;
  o->statics = (km_statics){0};
}

const km_question_class km_forces_question = {.name = "forces",
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
                                              .clear_result = clear_result,
                                              .clear_preparation = clear_preparation};

const km_statics_sweep *km_question_statics(const km_question *q) {
  return km_question_has(q, &km_forces_question) ? &((const kind_data *)q->kind_data)->sweep : NULL;
}

km_forces *km_question_forces(const km_question *q) {
  return km_question_is(q, &km_forces_question) ? ((const kind_data *)q->kind_data)->forces : NULL;
}

km_statics *km_question_balance(const km_question *q) {
  return km_question_is(q, &km_forces_question) ? &((kind_data *)q->kind_data)->statics : NULL;
}
