/* Requests of kinds "run" and "inverse": a motion over time under the model's forces (km_history_run), and the forces
 * that a prescribed motion takes (km_inverse_run). Both start at the state's configuration and leave it there. */
#include "question/question.h"

#include "base/file.h"
#include "history/motion_cycle.h"
#include "kinematics/state.h"
#include "kmech/inspect.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

/* Options of both kinds, behind the kind's own ones. */
enum { RATE, UNTIL, FRAME, REACTIONS, SHARED_OPTIONS };
#define MOST 1e60 /* largest time and tolerance */

static const km_option shared[SHARED_OPTIONS] = {
    {"rate", KM_OPTION_SETTINGS, "JOINT=RATE", "the joint's per time", NULL,
     "Rate at the start of a run, instead of the model's (joints without a stated rate follow); constant rate of an inverse "
     "motion, beside the model's prescribed motions (repeatable)",
     0, 0, NULL, true},
    {"until", KM_OPTION_NUMBER, "T", "time",
     "the model's, else 10 s; of a rate of a hinge one turn, or a period of its loads", "End", 0, MOST, NULL, true},
    {"frame", KM_OPTION_POINTS, "BODY/FRAME", "", NULL,
     "Add position, velocity and acceleration of a frame's origin (repeatable)", 0, 0, NULL, true},
    {"reactions", KM_OPTION_FLAG, NULL, "", NULL, "Add the reaction in every joint", 0, 0, NULL, true},
};

enum {
  EVERY,
  FROM,
  EVENT,
  STOP,
  LIMIT_STOPS,
  IGNORE_LIMITS,
  AXES,
  FORCES,
  MOBILITY,
  RTOL,
  ATOL,
  MAX_STEP,
  INTEGRATOR,
  STABILISE,
  RUN_OPTIONS
};
enum { AXES_BODY = 2 }; /* word of `axes` behind those of km_axes */

static const km_option run_options[RUN_OPTIONS] = {
    {"every", KM_OPTION_NUMBER, "DT", "time", "the model's, else a 200th of the run", "Time between rows", 0, MOST,
     NULL, true},
    {"from", KM_OPTION_FILE, "TABLE.csv", "", NULL,
     "Continue from the last row of a run's table: its pose, its rates and its time", 0, 0, NULL, true},
    {"event", KM_OPTION_SETTINGS, "JOINT=VALUE", "the joint's", NULL, "Tell when a joint passes a value (repeatable)",
     0, 0, NULL, true},
    {"stop", KM_OPTION_SETTINGS, "JOINT=VALUE", "the joint's", NULL, "End where a joint passes a value (repeatable)", 0,
     0, NULL, true},
    {"limit-stops", KM_OPTION_PAIR, "K[,B]", "force/length", NULL,
     "Stops at the limits of joints without one: stiffness and damping (0), of hinges per radian, in the model's units",
     0, 0, NULL, true},
    {"ignore-limits", KM_OPTION_FLAG, NULL, "", NULL,
     "Pass limits where no stop acts; otherwise a run that passes one is partial", 0, 0, NULL, true},
    {"axes", KM_OPTION_WORD, "AXES", "", NULL,
     "Axes of the reactions: joint (default) or fixed. body: the frames' own axes for what `frame` adds, with angular "
     "velocity and acceleration",
     0, AXES_BODY, "joint or fixed or body", true},
    {"forces", KM_OPTION_MODULES, "NAME", "", NULL,
     "Add variable, force, power and work of a force module, or of all (repeatable)", 0, 0, NULL, true},
    {"mobility", KM_OPTION_FLAG, NULL, "", NULL, "Add every joint's mobility number", 0, 0, NULL, true},
    {"rtol", KM_OPTION_NUMBER, "E", "", "the model's, else 1e-7", "Relative tolerance of the run", 0, MOST, NULL, true},
    {"atol", KM_OPTION_NUMBER, "E", "", "the model's, else 1e-7",
     "Absolute tolerance of the run, of radians and characteristic lengths", 0, MOST, NULL, true},
    {"max-step", KM_OPTION_NUMBER, "DT", "time", NULL, "Longest step; of `integrator` fixed its length", 0, MOST, NULL,
     true},
    {"integrator", KM_OPTION_WORD, "NAME", "", "the model's, else adams",
     "adams (changes to bdf where the motion is stiff), bdf or fixed", 0, KM_INTEGRATOR_FIXED, "adams or bdf or fixed",
     true},
    {"stabilise", KM_OPTION_WORD, "HOW", "", NULL, "How loops stay closed: project (default) or baumgarte", 0,
     KM_STABILISE_BAUMGARTE, "project or baumgarte", true},
};
_Static_assert(KM_AXES_JOINT == 0 && KM_AXES_FIXED == 1, "the words of `axes` stand in the order of km_axes");

enum { STEPS, INVERSE_AXES, INVERSE_OPTIONS };

static const km_option inverse_options[INVERSE_OPTIONS] = {
    {"steps", KM_OPTION_WHOLE, "N", "", "360", "Number of intervals; N + 1 rows", 1, KM_MAX_SWEEP_STEPS, NULL, true},
    {"axes", KM_OPTION_WORD, "AXES", "", NULL, "Axes of the reactions: joint (default) or fixed", 0, KM_AXES_FIXED,
     "joint or fixed", true},
};

typedef struct kind_data {
  km_arena arena; /* lists of the definitions */
  km_crossing *crossings;
  km_constant_rate *rates;
  km_table *from; /* table of an earlier run; NULL: none */
  km_history_def run;
  km_inverse_def inverse;
  km_history history;
} kind_data;

static const km_option_value *shared_value(const km_question *q, int index) {
  return km_question_own_value(q, q->kind->option_count + index);
}

static bool is_flagged(const km_option_value *v) {
  return v && v->flag;
}

/* Replaces a number by that of an option that is set. */
static void take_number(const km_option_value *v, double *number) {
  if (v)
    *number = v->numbers[0];
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a motion over time");
}

static const km_traced_frame *frames_of(const km_question *q, kind_data *o, int *count) {
  const km_option_value *v = shared_value(q, FRAME);
  km_traced_frame *frames = KM_ARENA_NEW(&o->arena, km_traced_frame, (size_t)(v ? v->count : 0) + 1);
  *count = frames && v ? v->count : 0;
  for (int i = 0; i < *count; ++i)
    frames[i] = (km_traced_frame){v->points[i].frame, v->points[i].name};
  return frames;
}

/* Index of an option's word; 0: not set. */
static int word_of(const km_option_value *v) {
  return v ? v->whole : 0;
}

static km_status read_table(const char *file, km_table **out, km_error *error) {
  km_text text = {0};
  km_status status = km_file_read(file, &text, error);
  if (!status)
    status = km_csv_read(&text, file, out, error);
  km_text_free(&text);
  return status;
}

static void clear_preparation(km_question *q) {
  kind_data *o = q->kind_data;
  km_arena_free(&o->arena);
  km_table_free(o->from);
  *o = (kind_data){0};
}

/* Adds the values of an option as crossings. */
static void add_crossings(const km_option_value *v, bool stops, kind_data *o) {
  for (int i = 0; v && i < v->count; ++i)
    o->crossings[o->run.simulation.crossing_count++] =
        (km_crossing){.coordinate = v->coordinates[i], .value = v->settings[i], .stops = stops};
}

/* Times, tolerances and method of a run: the model's, replaced by the options. */
static void take_method(const km_question *q, km_history_def *def) {
  const km_option_value *until = shared_value(q, UNTIL), *method = km_question_own_value(q, INTEGRATOR);
  double every;
  km_model_simulated(q->m->model, NULL, &every);
  take_number(until, &def->until);
  if (until && !(every > 0.0))
    def->every = def->until / KM_HISTORY_ROWS;
  take_number(km_question_own_value(q, EVERY), &def->every);
  take_number(km_question_own_value(q, RTOL), &def->simulation.relative);
  take_number(km_question_own_value(q, ATOL), &def->simulation.absolute);
  take_number(km_question_own_value(q, MAX_STEP), &def->simulation.max_step);
  if (method)
    def->simulation.integrator = (km_integrator)method->whole;
  def->simulation.stabilisation = (km_stabilisation)word_of(km_question_own_value(q, STABILISE));
}

/* Columns of a run besides those of every run. */
static void take_columns(const km_question *q, kind_data *o) {
  const km_option_value *modules = km_question_own_value(q, FORCES);
  const int axes = word_of(km_question_own_value(q, AXES));
  km_history_def *def = &o->run;
  def->frames = frames_of(q, o, &def->frame_count);
  def->frame_rotations = axes == AXES_BODY;
  def->modules = modules ? modules->modules : NULL;
  def->module_count = modules ? modules->count : 0;
  def->reactions = is_flagged(shared_value(q, REACTIONS));
  def->axes = axes == KM_AXES_FIXED ? KM_AXES_FIXED : KM_AXES_JOINT;
  def->mobility = is_flagged(km_question_own_value(q, MOBILITY));
}

static void take_crossings(const km_question *q, kind_data *o) {
  const km_option_value *events = km_question_own_value(q, EVENT), *stops = km_question_own_value(q, STOP);
  const size_t count = (size_t)(events ? events->count : 0) + (size_t)(stops ? stops->count : 0);
  o->crossings = KM_ARENA_NEW(&o->arena, km_crossing, count + 1);
  if (!o->crossings)
    return;
  add_crossings(events, false, o);
  add_crossings(stops, true, o);
  o->run.simulation.crossings = o->crossings;
}

static void copy_rates(const km_option_value *rates, kind_data *o) {
  o->rates = KM_ARENA_NEW(&o->arena, km_constant_rate, (size_t)(rates ? rates->count : 0) + 1);
  for (int i = 0; rates && o->rates && i < rates->count; ++i)
    o->rates[i] = (km_constant_rate){rates->coordinates[i], rates->settings[i]};
}

static km_status prepare_run(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *from = km_question_own_value(q, FROM), *rates = shared_value(q, RATE);
  copy_rates(rates, o);
  if (o->arena.failed)
    return no_memory(error);
  o->run = km_history_default_at(q->m->model, o->rates, rates ? rates->count : 0);
  take_method(q, &o->run);
  if (o->run.simulation.integrator == KM_INTEGRATOR_FIXED && !(o->run.simulation.max_step > 0.0))
    return km_fail(error, KM_USAGE, "`integrator` fixed: expected `max-step` with it, the length of its steps");
  if (from && rates)
    return km_fail(error, KM_USAGE, "`from`: a table beside `rate`; expected one of them: both give the rates");
  take_columns(q, o);
  take_crossings(q, o);
  if (o->arena.failed)
    return no_memory(error);
  return from ? read_table(from->text, &o->from, error) : KM_OK;
}

/* Checks the rates of an inverse motion: other than 0, one for each joint. */
static km_status check_rates(const km_question *q, const km_option_value *rates, kind_data *o, km_error *error) {
  for (int i = 0; rates && i < rates->count; ++i) {
    const char *label = km_model_coordinate_label(q->m->model, rates->coordinates[i]);
    if (o->rates[i].rate == 0.0)
      return km_fail(error, KM_USAGE, "`rate` %s=0: expected a rate other than 0", label);
    for (int k = 0; k < i; ++k)
      if (o->rates[k].coordinate == o->rates[i].coordinate)
        return km_fail(error, KM_USAGE, "`rate`: \"%s\" is named twice; expected one rate for each joint", label);
  }
  return KM_OK;
}

static km_status prepare_inverse(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *rates = shared_value(q, RATE), *steps = km_question_own_value(q, STEPS);
  int count = rates ? rates->count : 0, frame_count;
  copy_rates(rates, o);
  const km_traced_frame *frames = frames_of(q, o, &frame_count);
  if (o->arena.failed)
    return no_memory(error);
  km_status status = check_rates(q, rates, o, error);
  if (status)
    return status;
  o->inverse = km_inverse_default(q->m, o->rates, count);
  o->inverse.frames = frames;
  o->inverse.frame_count = frame_count;
  take_number(shared_value(q, UNTIL), &o->inverse.until);
  if (!(o->inverse.until > 0.0))
    return km_fail(error, KM_USAGE, "`until` is missing; expected the end of the motion, in the model's time unit");
  if (steps)
    o->inverse.steps = steps->whole;
  o->inverse.reactions = is_flagged(shared_value(q, REACTIONS));
  o->inverse.axes = (km_axes)word_of(km_question_own_value(q, INVERSE_AXES));
  return KM_OK;
}

static void clear_result(km_question *q) {
  km_history_free(&((kind_data *)q->kind_data)->history);
}

/* Copies the configuration and the stated rates of a state, and states those of the option. */
static km_status create_start(const km_question *q, const km_state *from, km_state **out, km_error *error) {
  const km_option_value *rates = shared_value(q, RATE);
  km_status status = km_state_create(q->m, out, error);
  if (!status)
    km_state_copy(q->m, *out, from);
  for (int i = 0; rates && i < rates->count && !status; ++i)
    status = km_state_set_rate(q->m, *out, rates->coordinates[i], rates->settings[i], error);
  return status;
}

static km_status set_limit_stops(const km_question *q, km_forces *forces, km_error *error) {
  const km_option_value *stops = km_question_own_value(q, LIMIT_STOPS);
  if (!stops || !km_forces_set_limit_stops(forces, stops->numbers[0], stops->numbers[1], error))
    return KM_OK;
  return km_fail(error, KM_USAGE, "`limit-stops` %g,%g: expected a positive stiffness, and a damping of at least 0",
                 stops->numbers[0], stops->numbers[1]);
}

/* Moves a state to the end of the earlier run. */
static km_status resume(const km_question *q, kind_data *o, km_state *at, km_run_memory **memory, km_error *error) {
  km_error found;
  km_status status =
      km_history_resume(q->m, o->from, km_question_own_value(q, FROM)->text, at, &o->run.start, memory, &found);
  return status ? km_fail(error, status, "`from`: %s", found.text) : KM_OK;
}

/* The status of a motion over time: rows before its early end are a partial result. */
static km_status status_of(const km_history *h, km_status status) {
  bool some = h->table && km_table_rows(h->table) > 0;
  return some && status != KM_OK && status != KM_CANCELLED && status != KM_MEMORY ? KM_PARTIAL : status;
}

/* True if coordinates and rates over the time are all that is read. */
static bool reads_kinematics_only(const km_question *q) {
  bool reads_only = q->read_columns != NULL;
  for (const char *const *name = q->read_columns; reads_only && *name; ++name)
    reads_only = strcmp(*name, "t") == 0 || strncmp(*name, "q.", 2) == 0 || strncmp(*name, "v.", 2) == 0;
  return reads_only;
}

static km_status compute_run(km_question *q, km_forces *forces, km_state *at, km_error *error) {
  kind_data *o = q->kind_data;
  km_run_memory *memory = NULL;
  o->run.progress = q->progress;
  o->run.context = q->context;
  o->run.kinematics_only = reads_kinematics_only(q);
  km_status status = set_limit_stops(q, forces, error);
  if (!status && o->from)
    status = resume(q, o, at, &memory, error);
  o->run.simulation.memory = memory;
  if (!status)
    status = km_history_run(q->m, forces, at, &o->run, &o->history, error);
  km_run_memory_free(memory);
  o->run.simulation.memory = NULL;
  bool is_limit_passed = o->history.limit_count > 0 && !is_flagged(km_question_own_value(q, IGNORE_LIMITS));
  if (status == KM_PARTIAL || status == KM_OK) /* an end by `stop` is the end that is wanted */
    return is_limit_passed ? KM_PARTIAL : KM_OK;
  return status_of(&o->history, status);
}

static km_status compute_inverse(km_question *q, km_forces *forces, km_state *at, km_error *error) {
  kind_data *o = q->kind_data;
  o->inverse.progress = q->progress;
  o->inverse.context = q->context;
  return status_of(&o->history, km_inverse_run(q->m, forces, at, &o->inverse, &o->history, error));
}

static km_status answer(km_question *q, km_state *s, km_error *error) {
  km_forces *forces = NULL;
  km_state *at = NULL;
  km_status status = km_forces_create_own(q->m, &forces, error);
  if (!status)
    status = create_start(q, s, &at, error);
  if (!status)
    status = (q->kind == &km_run_question ? compute_run : compute_inverse)(q, forces, at, error);
  km_state_free(at);
  km_forces_free(forces);
  return status;
}

static const km_table *table(const km_question *q) {
  return ((const kind_data *)q->kind_data)->history.table;
}

static int planned_run_rows(const km_question *q) {
  const km_history_def *def = &((const kind_data *)q->kind_data)->run;
  return 1 + (int)fmin(KM_MAX_SWEEP_STEPS, ceil((def->until - def->start) / def->every - 1e-9));
}

static double planned_run_place(const km_question *q, int row) {
  const km_history_def *def = &((const kind_data *)q->kind_data)->run;
  return fmin(def->start + row * def->every, def->until);
}

static int planned_inverse_rows(const km_question *q) {
  return 1 + ((const kind_data *)q->kind_data)->inverse.steps;
}

static double planned_inverse_place(const km_question *q, int row) {
  const km_inverse_def *def = &((const kind_data *)q->kind_data)->inverse;
  return def->until * row / def->steps;
}

static void end_reason(const km_question *q, km_text *out) {
  const km_history *h = &((const kind_data *)q->kind_data)->history;
  const km_passed_limit *passed = h->limits;
  const km_model *model = q->m->model;
  const char *unit = model->units.time->suffix;
  if (h->why.text[0])
    km_text_add(out, h->why.text);
  else if (h->limit_count > 0)
    km_text_format(out, "%s passes its %s limit of %.6g %s at %.6g %s",
                   km_model_coordinate_label(model, passed->coordinate), passed->upper ? "upper" : "lower",
                   passed->limit, km_model_coordinate_unit(model, passed->coordinate), passed->time, unit);
}

/* Crossings of the run, then passed limits, then peaks of the driving forces and of the shaking force. */
static int event_count(const km_question *q) {
  const km_history *h = &((const kind_data *)q->kind_data)->history;
  return h->crossing_count + h->limit_count + h->peak_count;
}

static km_question_event event(const km_question *q, int index) {
  const kind_data *o = q->kind_data;
  const km_history *h = &o->history;
  const km_model *model = q->m->model;
  if (index < h->crossing_count) {
    const km_crossing *c = &o->crossings[h->crossings[index].crossing];
    return (km_question_event){"crossing", km_model_coordinate_label(model, c->coordinate), h->crossings[index].time,
                               c->value};
  }
  index -= h->crossing_count;
  if (index < h->limit_count)
    return (km_question_event){"limit", km_model_coordinate_label(model, h->limits[index].coordinate),
                               h->limits[index].time, h->limits[index].limit};
  const km_force_peak *peak = &h->peaks[index - h->limit_count];
  return (km_question_event){"peak", peak->coordinate < 0 ? "" : km_model_coordinate_label(model, peak->coordinate),
                             peak->time, peak->value};
}

const km_question_class km_run_question = {.name = "run",
                                           .options = run_options,
                                           .option_count = RUN_OPTIONS,
                                           .shared = shared,
                                           .shared_count = SHARED_OPTIONS,
                                           .size = sizeof(kind_data),
                                           .prepare = prepare_run,
                                           .answer = answer,
                                           .table = table,
                                           .planned_rows = planned_run_rows,
                                           .planned_place = planned_run_place,
                                           .end_reason = end_reason,
                                           .event_count = event_count,
                                           .event = event,
                                           .clear_result = clear_result,
                                           .clear_preparation = clear_preparation};

const km_question_class km_inverse_question = {.name = "inverse",
                                               .options = inverse_options,
                                               .option_count = INVERSE_OPTIONS,
                                               .shared = shared,
                                               .shared_count = SHARED_OPTIONS,
                                               .size = sizeof(kind_data),
                                               .prepare = prepare_inverse,
                                               .answer = answer,
                                               .table = table,
                                               .planned_rows = planned_inverse_rows,
                                               .planned_place = planned_inverse_place,
                                               .end_reason = end_reason,
                                               .event_count = event_count,
                                               .event = event,
                                               .clear_result = clear_result,
                                               .clear_preparation = clear_preparation};

const km_history *km_question_history(const km_question *q) {
  return km_question_has(q, &km_run_question) || km_question_has(q, &km_inverse_question)
             ? &((const kind_data *)q->kind_data)->history
             : NULL;
}

const km_history_def *km_question_run_def(const km_question *q) {
  return km_question_has(q, &km_run_question) ? &((const kind_data *)q->kind_data)->run : NULL;
}
