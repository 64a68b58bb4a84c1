/* Requests: kinds, options, computation, results. */
#include "question/question.h"

#include "base/arguments.h"
#include "kinematics/state.h"

#include <string.h>

static const km_question_class *const kinds[] = {
    &km_mobility_question, &km_advantage_question, &km_forces_question,    &km_track_question,     &km_run_question,
    &km_inverse_question,  &km_motion_question,    &km_allowance_question, &km_clearance_question, &km_modes_question,
    &km_map_question,      &km_turning_question,   &km_volume_question};

int km_question_kinds(void) {
  return (int)(sizeof kinds / sizeof *kinds);
}

static const km_question_class *kind_at(int kind) {
  return kind >= 0 && kind < km_question_kinds() ? kinds[kind] : NULL;
}

const char *km_question_kind_name(int kind) {
  const km_question_class *k = kind_at(kind);
  return k ? k->name : "";
}

static const km_option *option_of(const km_question_class *kind, int index) {
  if (index >= 0 && index < kind->option_count)
    return &kind->options[index];
  int behind = index - kind->option_count;
  return index >= 0 && behind < kind->shared_count ? &kind->shared[behind] : NULL;
}

const km_option *km_question_option(int kind, int index) {
  const km_question_class *k = kind_at(kind);
  return k ? option_of(k, index) : NULL;
}

static const km_question_class *find_kind(const char *name, km_error *error) {
  for (int i = 0; name && i < km_question_kinds(); ++i)
    if (strcmp(kinds[i]->name, name) == 0)
      return kinds[i];
  km_text known = {0};
  for (int i = 0; i < km_question_kinds(); ++i)
    km_text_format(&known, "%s%s", i == 0 ? "" : i + 1 < km_question_kinds() ? ", " : " or ", kinds[i]->name);
  km_fail(error, KM_USAGE, "there is no kind of question \"%s\"; expected %s", name ? name : "",
          known.data ? known.data : "another one");
  km_text_free(&known);
  return NULL;
}

km_status km_question_create(const km_mechanism *m, const char *kind, km_question **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(m != NULL, "mechanism", error);
  if (status)
    return status;
  const km_question_class *class = find_kind(kind, error);
  if (!class)
    return KM_USAGE;
  km_question *q = KM_NEW(km_question, 1);
  if (!q)
    return km_fail(error, KM_MEMORY, "out of memory for a question");
  size_t options = (size_t)(class->option_count + class->shared_count) + 1;
  *q = (km_question){.m = m, .kind = class, .notes = km_messages_create()};
  q->values = KM_ARENA_NEW(&q->arena, km_option_value, options);
  q->is_set_value = KM_ARENA_NEW(&q->arena, bool, options);
  q->kind_data = km_arena_alloc(&q->arena, 1, class->size);
  if (q->arena.failed || !q->notes) {
    km_question_free(q);
    return km_fail(error, KM_MEMORY, "out of memory for a question");
  }
  *out = q;
  return KM_OK;
}

static void clear_result(km_question *q) {
  if (q->kind_data)
    q->kind->clear_result(q);
  q->has_result = false;
}

static void clear_preparation(km_question *q) {
  if (q->kind_data && q->kind->clear_preparation)
    q->kind->clear_preparation(q);
  q->is_prepared = false;
}

void km_question_free(km_question *q) {
  if (!q)
    return;
  clear_result(q);
  clear_preparation(q);
  km_messages_free(q->notes);
  km_sweep_workspace_free(&q->workspace);
  km_arena_free(&q->arena);
  km_free(q);
}

const km_option_value *km_question_own_value(const km_question *q, int index) {
  return q->is_set_value[index] ? &q->values[index] : NULL;
}

const km_option_value *km_question_motion_value(const km_question *q, int index) {
  return km_question_own_value(q, q->kind->option_count + index);
}

/* KM_USAGE unless an option with a list has as many items as it states. */
static km_status check_lists(const km_option *o, const km_option_value *v, km_error *error) {
  switch (o->type) {
  case KM_OPTION_COORDINATES:
    return km_check_list(v->coordinates, v->count, o->name, error);
  case KM_OPTION_SETTINGS: {
    km_status status = km_check_list(v->coordinates, v->count, o->name, error);
    return status ? status : km_check_list(v->settings, v->count, o->name, error);
  }
  case KM_OPTION_MODULES:
    return km_check_list(v->modules, v->count, o->name, error);
  case KM_OPTION_BODY_PAIRS:
    return km_check_list(v->pairs, v->count, o->name, error);
  case KM_OPTION_POINTS:
    return km_check_list(v->points, v->count, o->name, error);
  case KM_OPTION_ENDS:
    return km_check_list(v->ends, v->count, o->name, error);
  case KM_OPTION_LOADS:
    return km_check_list(v->loads, v->count, o->name, error);
  default:
    return KM_OK;
  }
}

/* KM_USAGE unless item i of an option's list refers to what exists. */
static km_status check_item(const km_mechanism *m, const km_option *o, const km_option_value *v, int i,
                            km_error *error) {
  km_status status = KM_OK;
  switch (o->type) {
  case KM_OPTION_SETTINGS:
    if (!isfinite(v->settings[i]))
      return km_fail(error, KM_USAGE, "`%s`: a value that isn't finite", o->name);
    return km_check_index(v->coordinates[i], m->coordinate_count, "coordinate", error);
  case KM_OPTION_COORDINATES:
    return km_check_index(v->coordinates[i], m->coordinate_count, "coordinate", error);
  case KM_OPTION_MODULES:
    return km_check_index(v->modules[i], m->model->module_count, "force module", error);
  case KM_OPTION_BODY_PAIRS:
    for (int k = 0; k < 2 && !status; ++k)
      status = km_check_index(v->pairs[i].body[k], m->model->body_count, "body", error);
    return status;
  case KM_OPTION_POINTS:
    status = km_check_index(v->points[i].frame, m->model->frame_count, "frame", error);
    return status ? status : km_check_given(v->points[i].name != NULL, "name of a point", error);
  case KM_OPTION_ENDS:
    return km_check_given(v->ends[i].name != NULL, "name of a point", error);
  default:
    return KM_OK;
  }
}

static km_status check_indices(const km_mechanism *m, const km_option *o, const km_option_value *v, km_error *error) {
  if (o->type == KM_OPTION_COORDINATE || o->type == KM_OPTION_SENSE)
    return km_check_index(v->coordinate, m->coordinate_count, "coordinate", error);
  km_status status = check_lists(o, v, error);
  for (int i = 0; i < v->count && !status; ++i)
    status = check_item(m, o, v, i, error);
  return status;
}

static km_status check_numbers(const km_option *o, const km_option_value *v, km_error *error) {
  bool two = o->type == KM_OPTION_RANGE || o->type == KM_OPTION_PAIR;
  int count = o->type == KM_OPTION_VECTOR ? 3 : two ? 2 : o->type == KM_OPTION_NUMBER ? 1 : 0;
  for (int k = 0; k < count; ++k)
    if (!isfinite(v->numbers[k]))
      return km_fail(error, KM_USAGE, "`%s`: a value that isn't finite", o->name);
  if (o->type == KM_OPTION_WHOLE && !(v->whole >= o->low && v->whole <= o->high))
    return km_fail(error, KM_USAGE, "`%s` %d: expected a whole number from %.0f to %.0f", o->name, v->whole, o->low,
                   o->high);
  if (o->type == KM_OPTION_NUMBER && !(v->numbers[0] > o->low && v->numbers[0] <= o->high))
    return km_fail(error, KM_USAGE, "`%s` %g: expected a number greater than %g and at most %g", o->name, v->numbers[0],
                   o->low, o->high);
  if (o->type == KM_OPTION_SENSE && !(fabs(v->numbers[0]) > 0.0))
    return km_fail(error, KM_USAGE, "`%s`: expected a joint with +1 or -1", o->name);
  if (o->type == KM_OPTION_FILE && !(v->text && v->text[0]))
    return km_fail(error, KM_USAGE, "`%s`: expected a file's name", o->name);
  if (o->type == KM_OPTION_WORD && (v->whole < 0 || v->whole > o->high))
    return km_fail(error, KM_USAGE, "`%s`: expected %s", o->name, o->words);
  return KM_OK;
}

/* Copies a caller's list into the request's arena. */
static void *copy_list(km_question *q, const void *list, int count, size_t size) {
  void *copy = km_arena_alloc(&q->arena, count > 0 ? (size_t)count : 1, size);
  if (copy && count > 0)
    memcpy(copy, list, (size_t)count * size);
  return copy;
}

static km_option_value copy_value(km_question *q, km_option_type type, const km_option_value *value) {
  km_option_value v = *value;
  if (type == KM_OPTION_COORDINATES || type == KM_OPTION_SETTINGS)
    v.coordinates = copy_list(q, v.coordinates, v.count, sizeof *v.coordinates);
  if (type == KM_OPTION_SETTINGS)
    v.settings = copy_list(q, v.settings, v.count, sizeof *v.settings);
  if (type == KM_OPTION_MODULES)
    v.modules = copy_list(q, v.modules, v.count, sizeof *v.modules);
  if (type == KM_OPTION_BODY_PAIRS)
    v.pairs = copy_list(q, v.pairs, v.count, sizeof *v.pairs);
  if (type == KM_OPTION_LOADS)
    v.loads = copy_list(q, v.loads, v.count, sizeof *v.loads);
  if (type == KM_OPTION_FILE)
    v.text = km_arena_string(&q->arena, v.text);
  if (type == KM_OPTION_END && v.end.name)
    v.end.name = km_arena_string(&q->arena, v.end.name);
  if (type == KM_OPTION_ENDS) {
    km_port *ends = copy_list(q, v.ends, v.count, sizeof *v.ends);
    for (int i = 0; i < v.count && ends; ++i)
      ends[i].name = km_arena_string(&q->arena, ends[i].name);
    v.ends = ends;
  }
  if (type == KM_OPTION_POINTS) {
    km_sweep_point *points = copy_list(q, v.points, v.count, sizeof *v.points);
    for (int i = 0; i < v.count && points; ++i)
      points[i].name = km_arena_string(&q->arena, points[i].name);
    v.points = points;
  }
  return v;
}

km_status km_question_set(km_question *q, const char *option, const km_option_value *value, km_error *error) {
  km_status status = km_check_given(q != NULL, "question", error);
  if (!status)
    status = km_check_given(option && value, "option or value", error);
  if (status)
    return status;
  int index = 0;
  const km_option *o = option_of(q->kind, 0);
  while (o && strcmp(o->name, option) != 0)
    o = option_of(q->kind, ++index);
  if (!o)
    return km_fail(error, KM_USAGE, "`%s`: there is no such option of a question about %s", option, q->kind->name);
  status = check_numbers(o, value, error);
  if (!status)
    status = check_indices(q->m, o, value, error);
  if (status)
    return status;
  km_option_value copy = copy_value(q, o->type, value);
  if (q->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the options of a question");
  q->values[index] = copy;
  q->is_set_value[index] = true;
  clear_result(q);
  clear_preparation(q);
  return KM_OK;
}

void km_question_observe(km_question *q, km_progress progress, void *context) {
  if (!q)
    return;
  q->progress = progress;
  q->context = context;
}

km_status km_question_prepare(km_question *q, km_error *error) {
  km_status status = km_check_given(q != NULL, "question", error);
  if (status || q->is_prepared)
    return status;
  km_messages_free(q->notes);
  q->notes = km_messages_create();
  status = q->notes ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a question");
  if (!status && q->kind->prepare)
    status = q->kind->prepare(q, error);
  q->is_prepared = !status;
  if (status)
    clear_preparation(q);
  return status;
}

void km_question_refresh(km_question *q) {
  if (!q)
    return;
  clear_result(q);
  clear_preparation(q);
}

const km_messages *km_question_notes(const km_question *q) {
  return q ? q->notes : NULL;
}

static void begin_result(km_question *q, km_error *error) {
  clear_result(q);
  if (error)
    error->text[0] = '\0'; /* a partial result can come without a message */
  q->plan.progress = q->progress;
  q->plan.context = q->context;
}

static void end_result(km_question *q, km_status status) {
  q->has_result = status == KM_OK || status == KM_PARTIAL;
}

static km_sweep_job open_sweep(km_question *q, km_state *s, km_error *error) {
  km_sweep_job job = {.m = q->m,
                      .s = s,
                      .plan = &q->plan,
                      .workspace = &q->workspace,
                      .error = error,
                      .table_only = q->table_only,
                      .read_columns = q->read_columns};
  begin_result(q, error);
  q->kind->open(q, &job);
  return job;
}

static km_status conclude(km_question *q, const km_sweep_job *job) {
  km_status status = job->status;
  if (q->kind->conclude && !q->table_only && (status == KM_OK || status == KM_PARTIAL)) {
    km_status found = q->kind->conclude(q, job->error);
    status = found ? found : status;
  }
  end_result(q, status);
  return status;
}

static km_status compute_result(km_question *q, km_state *s, km_error *error) {
  if (q->kind->open) {
    km_sweep_job job = open_sweep(q, s, error);
    km_sweeps_run(&job, 1);
    return conclude(q, &job);
  }
  begin_result(q, error);
  km_status status = q->kind->answer(q, s, error);
  end_result(q, status);
  return status;
}

void km_question_keep_table(km_question *q, km_sweep *motion) {
  if (!motion->table)
    return;
  km_table_free(q->workspace.table);
  q->workspace.table = motion->table;
  motion->table = NULL;
}

/* Prepares a request and its plan. */
static km_status prepare_with_plan(km_question *q, const km_state *s, km_error *error) {
  km_status status = km_question_prepare(q, error);
  if (!status)
    status = km_check_state(q->m, s, error);
  if (!status && q->kind->motion)
    status = km_question_make_plan(q, &q->plan, error);
  return status;
}

km_status km_question_compute(km_question *q, km_state *s, km_error *error) {
  km_status status = prepare_with_plan(q, s, error);
  return status ? status : compute_result(q, s, error);
}

void km_questions_compute(km_question *const *q, km_state *const *s, int count, km_status *statuses, km_error *errors) {
  km_sweep_job jobs[KM_BATCH_LANES];
  int request_of[KM_BATCH_LANES], count_open = 0;
  for (int i = 0; i < count; ++i) {
    statuses[i] = prepare_with_plan(q[i], s[i], &errors[i]);
    if (statuses[i])
      continue;
    if (q[i]->kind->open && q[i]->kind == q[0]->kind) {
      request_of[count_open] = i;
      jobs[count_open++] = open_sweep(q[i], s[i], &errors[i]);
    } else {
      statuses[i] = compute_result(q[i], s[i], &errors[i]);
    }
  }
  km_sweeps_run(jobs, count_open);
  for (int k = 0; k < count_open; ++k)
    statuses[request_of[k]] = conclude(q[request_of[k]], &jobs[k]);
}

km_status km_question_compute_here(km_question *q, km_state *s, km_error *error) {
  km_status status = km_question_prepare(q, error);
  if (!status)
    status = km_check_state(q->m, s, error);
  if (!status && !q->kind->motion)
    status = km_fail(error, KM_USAGE, "a \"%s\" question isn't about one pose", q->kind->name);
  if (status)
    return status;
  const km_option_value *points = km_question_motion_value(q, KM_MOTION_POINT);
  q->plan = (km_sweep_plan){.coordinate = -1, .direction = -1, .steps = 0};
  q->plan.points = points ? points->points : NULL;
  q->plan.point_count = points ? points->count : 0;
  return compute_result(q, s, error);
}

const km_sweep_plan *km_question_plan(const km_question *q) {
  return q && q->has_result && q->kind->motion ? &q->plan : NULL;
}

const km_sweep *km_question_motion(const km_question *q) {
  return q && q->has_result && q->kind->motion ? q->kind->motion(q) : NULL;
}

const km_table *km_question_table(const km_question *q) {
  const km_sweep *motion = km_question_motion(q);
  return motion ? motion->table : q && q->has_result ? q->kind->table(q) : NULL;
}

bool km_question_is(const km_question *q, const km_question_class *kind) {
  return q && q->is_prepared && q->kind == kind;
}

bool km_question_has(const km_question *q, const km_question_class *kind) {
  return q && q->has_result && q->kind == kind;
}
