/* Options of a study's request, converted to their types: labels and paths become indices of the model. */
#include "kmech/inspect.h"
#include "study/design_study.h"

#include <math.h>
#include <string.h>

enum { MAX_NAMES = 16 };

static const km_option *find_option(const char *kind, const char *name) {
  for (int k = 0; k < km_question_kinds(); ++k)
    for (int i = 0; strcmp(km_question_kind_name(k), kind) == 0 && km_question_option(k, i); ++i)
      if (strcmp(km_question_option(k, i)->name, name) == 0)
        return km_question_option(k, i);
  return NULL;
}

static km_status fail_expected(const km_design_option *o, const char *what, km_error *error) {
  return km_fail(error, KM_USAGE, "%s: expected %s", o->name, what);
}

/* Reads an option of `count` numbers without text. */
static km_status numbers_of(const km_design_option *o, int count, const char *what, double *out, km_error *error) {
  if (o->number_count != count || o->text_count > 0)
    return fail_expected(o, what, error);
  memcpy(out, o->numbers, (size_t)count * sizeof *out);
  return KM_OK;
}

/* Finds a frame by "body/frame": names separated by slashes. */
static km_status find_frame(const km_model *model, const char *text, size_t length, km_arena *arena, int *frame,
                            km_error *error) {
  const char *names[MAX_NAMES];
  size_t count = 0;
  char *copy = KM_ARENA_NEW(arena, char, length + 1);
  if (!copy)
    return km_fail(error, KM_MEMORY, "out of memory for a path");
  memcpy(copy, text, length);
  names[count++] = copy;
  for (char *c = copy; *c; ++c)
    if (*c == '/' && count < MAX_NAMES) {
      *c = '\0';
      names[count++] = c + 1;
    }
  return km_model_find_frame(model, names, count, frame, error);
}

/* Reads a direction dx,dy,dz and normalises it. */
static bool read_direction(const char *text, double out[3]) {
  for (int k = 0; k < 3; ++k) {
    char *end;
    out[k] = km_number_read(text, &end);
    if (end == text || *end != (k < 2 ? ',' : '\0'))
      return false;
    text = end + 1;
  }
  double size = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  for (int k = 0; k < 3 && size > 0.0; ++k)
    out[k] /= size;
  return size > 0.0 && isfinite(size);
}

/* Reads a port: a joint's label, or body/frame:dx,dy,dz. */
static km_status read_port(const km_design_option *o, const km_model *model, const char *text, km_arena *arena,
                           km_port *out, km_error *error) {
  const char *colon = strrchr(text, ':');
  *out = (km_port){.kind = KM_PORT_JOINT, .coordinate = -1, .name = text};
  km_status status = km_model_find_coordinate(model, text, &out->coordinate, error);
  if (!status || !colon)
    return status;
  out->kind = KM_PORT_POINT;
  if (!read_direction(colon + 1, out->direction))
    return fail_expected(o, "a joint, or BODY/FRAME:DX,DY,DZ, a point and a direction", error);
  return find_frame(model, text, (size_t)(colon - text), arena, &out->frame, error);
}

/* Reads an option with a list of coordinates, points or ports. */
static km_status read_lists(const km_option *what, const km_design_option *o, const km_model *model, km_arena *arena,
                            km_option_value *v, km_error *error) {
  int *coordinates = KM_ARENA_NEW(arena, int, (size_t)o->text_count + 1);
  km_sweep_point *points = KM_ARENA_NEW(arena, km_sweep_point, (size_t)o->text_count + 1);
  km_port *ends = KM_ARENA_NEW(arena, km_port, (size_t)o->text_count + 1);
  km_status status = ends ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for options");
  if (!status && (o->text_count == 0 || o->number_count > 0))
    status = fail_expected(o, "at least one name, and names alone", error);
  for (int i = 0; i < o->text_count && !status; ++i)
    if (what->type == KM_OPTION_COORDINATES) {
      status = km_model_find_coordinate(model, o->texts[i], &coordinates[i], error);
    } else if (what->type == KM_OPTION_POINTS) {
      points[i].name = o->texts[i];
      status = find_frame(model, o->texts[i], strlen(o->texts[i]), arena, &points[i].frame, error);
    } else {
      status = read_port(o, model, o->texts[i], arena, &ends[i], error);
    }
  v->coordinates = coordinates;
  v->points = points;
  v->ends = ends;
  v->count = o->text_count;
  return status;
}

/* Reads joints with a number each. */
static km_status read_settings(const km_design_option *o, const km_model *model, km_arena *arena, km_option_value *v,
                               km_error *error) {
  int *coordinates = KM_ARENA_NEW(arena, int, (size_t)o->text_count + 1);
  if (!coordinates)
    return km_fail(error, KM_MEMORY, "out of memory for options");
  if (o->text_count == 0 || o->number_count != o->text_count)
    return fail_expected(o, "{joint: number}", error);
  km_status status = KM_OK;
  for (int i = 0; i < o->text_count && !status; ++i)
    status = km_model_find_coordinate(model, o->texts[i], &coordinates[i], error);
  v->coordinates = coordinates;
  v->settings = o->numbers;
  v->count = o->text_count;
  return status;
}

/* Reads names of force modules, or "all". */
static km_status read_modules(const km_design_option *o, const km_model *model, km_arena *arena, km_option_value *v,
                              km_error *error) {
  int most = km_model_module_count(model);
  bool all = o->text_count == 1 && strcmp(o->texts[0], "all") == 0 && km_model_find_module(model, "all") < 0;
  v->count = all ? most : o->text_count;
  int *modules = KM_ARENA_NEW(arena, int, (size_t)v->count + 1);
  if (!modules)
    return km_fail(error, KM_MEMORY, "out of memory for options");
  if (o->text_count == 0 || o->number_count > 0)
    return fail_expected(o, "all, or names of force modules", error);
  for (int i = 0; i < v->count; ++i) {
    modules[i] = all ? i : km_model_find_module(model, o->texts[i]);
    if (modules[i] < 0)
      return km_fail(error, KM_USAGE, "%s: there is no force module \"%s\"", o->name, o->texts[i]);
  }
  v->modules = modules;
  return KM_OK;
}

/* Reads pairs of bodies, each as "arm,frame". */
static km_status read_pairs(const km_design_option *o, const km_model *model, km_arena *arena, km_option_value *v,
                            km_error *error) {
  km_body_pair *pairs = KM_ARENA_NEW(arena, km_body_pair, (size_t)o->text_count + 1);
  if (!pairs)
    return km_fail(error, KM_MEMORY, "out of memory for options");
  if (o->text_count == 0 || o->number_count > 0)
    return fail_expected(o, "pairs of bodies, such as \"arm,frame\"", error);
  for (int i = 0; i < o->text_count; ++i) {
    const char *comma = strchr(o->texts[i], ',');
    int frame[2];
    if (!comma)
      return fail_expected(o, "pairs of bodies, such as \"arm,frame\"", error);
    km_status status = find_frame(model, o->texts[i], (size_t)(comma - o->texts[i]), arena, &frame[0], error);
    if (!status)
      status = find_frame(model, comma + 1, strlen(comma + 1), arena, &frame[1], error);
    if (status)
      return status;
    for (int k = 0; k < 2; ++k)
      pairs[i].body[k] = km_model_frame_body(model, frame[k]);
  }
  v->pairs = pairs;
  v->count = o->text_count;
  return KM_OK;
}

/* Index of a word in a list such as "one or another". */
static int word_place(const char *words, const char *word) {
  int place = 0;
  for (const char *at = words; at; ++place) {
    const char *next = strstr(at, " or ");
    size_t length = next ? (size_t)(next - at) : strlen(at);
    if (strlen(word) == length && memcmp(at, word, length) == 0)
      return place;
    at = next ? next + 4 : NULL;
  }
  return -1;
}

/* Path of a file relative to the study's folder. NULL: out of memory. */
static const char *path_in_folder(const char *folder, const char *file, km_arena *arena) {
  km_text path = {0};
  if (folder && folder[0] && file[0] != '/')
    km_text_format(&path, "%s/", folder);
  km_text_add(&path, file);
  const char *kept = km_text_move_to_arena(&path, arena);
  return arena->failed ? NULL : kept;
}

const char *km_design_file(const km_design_study_def *study, const km_design_question *q, const km_design_option *o,
                           km_arena *arena) {
  const km_option *what = q->kind ? find_option(q->kind, o->name) : NULL;
  return what && what->type == KM_OPTION_FILE && o->text_count == 1 ? path_in_folder(study->folder, o->texts[0], arena)
                                                                    : NULL;
}

/* Reads the value of an option by its type. */
static km_status read_value(const km_option *what, const km_design_option *o, const km_model *model, const char *folder,
                            km_arena *arena, km_option_value *v, km_error *error) {
  double number = nan("");
  km_status status = KM_OK;
  bool one_text = o->text_count == 1 && o->number_count == 0;
  switch (what->type) {
  case KM_OPTION_FLAG:
    v->flag = o->flag;
    return o->text_count + o->number_count == 0 ? KM_OK : fail_expected(o, "true or false", error);
  case KM_OPTION_WHOLE:
    status = numbers_of(o, 1, "a whole number", &number, error);
    if (!status && !(number == floor(number) && fabs(number) < 2e9))
      return fail_expected(o, "a whole number", error);
    v->whole = status ? 0 : (int)number;
    return status;
  case KM_OPTION_NUMBER:
    return numbers_of(o, 1, "a number", v->numbers, error);
  case KM_OPTION_RANGE:
    return numbers_of(o, 2, "two numbers [from, to]", v->numbers, error);
  case KM_OPTION_PAIR:
    v->numbers[1] = 0.0; /* second one of one number */
    return numbers_of(o, o->number_count == 1 ? 1 : 2, "one or two numbers", v->numbers, error);
  case KM_OPTION_MODULES:
    return read_modules(o, model, arena, v, error);
  case KM_OPTION_BODY_PAIRS:
    return read_pairs(o, model, arena, v, error);
  case KM_OPTION_VECTOR:
    v->numbers[2] = 0.0; /* third component of two numbers */
    return numbers_of(o, o->number_count == 2 ? 2 : 3, "two or three numbers [x, y] or [x, y, z]", v->numbers, error);
  case KM_OPTION_WORD:
    v->whole = one_text ? word_place(what->words, o->texts[0]) : -1;
    return v->whole >= 0 ? KM_OK : fail_expected(o, what->words, error);
  case KM_OPTION_SENSE:
    if (o->text_count != 1 || o->number_count != 1)
      return fail_expected(o, "a joint and +1 or -1", error);
    v->numbers[0] = o->numbers[0];
    return km_model_find_coordinate(model, o->texts[0], &v->coordinate, error);
  case KM_OPTION_SETTINGS:
    return read_settings(o, model, arena, v, error);
  case KM_OPTION_COORDINATE:
    return one_text ? km_model_find_coordinate(model, o->texts[0], &v->coordinate, error)
                    : fail_expected(o, "a joint's label", error);
  case KM_OPTION_END:
    return one_text ? read_port(o, model, o->texts[0], arena, &v->end, error)
                    : fail_expected(o, "a joint, or BODY/FRAME:DX,DY,DZ", error);
  case KM_OPTION_COORDINATES:
  case KM_OPTION_POINTS:
  case KM_OPTION_ENDS:
    return read_lists(what, o, model, arena, v, error);
  case KM_OPTION_FILE:
    if (!one_text)
      return fail_expected(o, "a file's name", error);
    v->text = path_in_folder(folder, o->texts[0], arena);
    return v->text ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for options");
  case KM_OPTION_LOADS:
    break;
  }
  return km_fail(error, KM_USAGE,
                 "%s: studies take the model's own loads; expected a parameter such as "
                 "loads.payload.force.2 that changes one",
                 o->name);
}

static km_status fail_no_option(const km_design_question *q, const char *name, km_error *error) {
  return km_fail(error, KM_USAGE, "%s: there is no such option of a question about %s", name, q->kind);
}

/* Adds the points that figures of distance need to the option `point`. */
static km_status set_points(const km_design_question *q, const km_model *model, km_question *question,
                            km_error *error) {
  const char *texts[KM_MAX_DESIGN_FIGURES];
  km_design_option o = {.name = "point", .texts = texts};
  for (int i = 0; i < q->option_count; ++i)
    for (int k = 0; strcmp(q->options[i].name, "point") == 0 && k < q->options[i].text_count; ++k)
      if (o.text_count < KM_MAX_DESIGN_FIGURES)
        texts[o.text_count++] = q->options[i].texts[k];
  int given = o.text_count;
  for (int f = 0; f < q->figure_count; ++f) {
    bool there = q->figures[f].kind != KM_DESIGN_DISTANCE || o.text_count == KM_MAX_DESIGN_FIGURES;
    for (int k = 0; k < o.text_count && !there; ++k)
      there = strcmp(texts[k], q->figures[f].column) == 0;
    if (!there)
      texts[o.text_count++] = q->figures[f].column;
  }
  if (o.text_count == given)
    return KM_OK;
  km_arena arena = {0};
  km_option_value value = {0};
  const km_option *what = find_option(q->kind, "point");
  km_status status =
      what ? read_value(what, &o, model, NULL, &arena, &value, error) : fail_no_option(q, "point", error);
  if (!status)
    status = km_question_set(question, "point", &value, error);
  km_arena_free(&arena);
  return status;
}

km_status km_design_set_options(const km_design_study_def *study, const km_design_question *q, const km_model *model,
                                km_question *question, km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; i < q->option_count && !status; ++i) {
    km_arena arena = {0};
    km_option_value value = {0};
    const km_design_option *o = &q->options[i];
    const km_option *what = find_option(q->kind, o->name);
    status =
        what ? read_value(what, o, model, study->folder, &arena, &value, error) : fail_no_option(q, o->name, error);
    if (!status)
      status = km_question_set(question, o->name, &value, error);
    km_arena_free(&arena);
  }
  return status ? status : set_points(q, model, question, error);
}

km_status km_design_settings(const km_model *model, const km_design_setting *settings, int count, const char *what,
                             km_hold *out, int *out_count, km_error *error) {
  int own = *out_count;
  for (int i = 0; i < count; ++i) {
    km_hold hold = {.value = settings[i].value};
    km_error found;
    if (km_model_find_coordinate(model, settings[i].coordinate, &hold.coordinate, &found))
      return km_fail(error, KM_USAGE, "%s: %s", what, found.text);
    int at = 0;
    while (at < *out_count && out[at].coordinate != hold.coordinate)
      ++at;
    if (at >= own && at < *out_count)
      return km_fail(error, KM_USAGE, "%s: \"%s\" is named twice", what, settings[i].coordinate);
    out[at] = hold;
    *out_count += at == *out_count;
  }
  return KM_OK;
}
