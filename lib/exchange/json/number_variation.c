/* Finds the numbers of a model file that paths name, and gives them other values. */
#include "exchange/json/number_variation.h"

#include "base/similar_names.h"
#include "exchange/json/expression_values.h"
#include "exchange/json/format/format.h"
#include "exchange/json/read/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_TOKENS = 64, READINGS = 2 };

/* A place that a number is at, or would be added at. */
typedef struct reading {
  km_value *number; /* NULL: `key` of `object` isn't stated */
  km_value *object;
  const km_field *field;
  int component; /* component of a point that isn't stated or has too few numbers; −1: none */
  char place[KM_PLACE_TEXT];
} reading;

typedef struct search {
  const char *tokens[MOST_TOKENS];
  size_t count;
  reading readings[READINGS];
  int found;      /* readings, those past READINGS too */
  size_t deepest; /* tokens that led somewhere */
  km_nearest nearest;
  const km_value *pair; /* frames of a joint that isn't drawn, whose point was named */
} search;

/* A node on the way: a value, what it is, and where. */
typedef struct node {
  km_value *value;
  const km_object_format *format; /* format of an object; NULL: unknown */
  const km_field *field;          /* that the value is or lies in */
  const km_place *place;
} node;

static void find(search *s, node at, size_t token);

static void add(search *s, reading found, const km_place *place) {
  km_place_text(place, found.place);
  for (int i = 0; i < s->found && i < READINGS; ++i)
    if (strcmp(s->readings[i].place, found.place) == 0)
      return;
  if (s->found < READINGS)
    s->readings[s->found] = found;
  s->found++;
}

/* The tokens before this one led somewhere. */
static void reach(search *s, size_t token) {
  if (token > s->deepest || !s->nearest.wanted)
    s->nearest = (km_nearest){.wanted = token < s->count ? s->tokens[token] : ""};
  if (token > s->deepest)
    s->deepest = token;
}

/* A name that could have stood at this token. */
static void offer(search *s, size_t token, const char *name) {
  reach(s, token);
  if (token == s->deepest)
    km_nearest_add(&s->nearest, name);
}

static const char *name_of(const km_value *element) {
  const km_value *name = km_value_get(element, "name");
  return name && name->kind == KM_STRING ? name->string : NULL;
}

static int index_of(const char *token) {
  char *end;
  long index = token[0] >= '0' && token[0] <= '9' ? strtol(token, &end, 10) : -1;
  return index >= 0 && *end == '\0' && index < 1000000 ? (int)index : -1;
}

static bool is_point(const km_field *field) {
  return field && (field->shape == KM_SHAPE_POINT || field->shape == KM_SHAPE_VECTOR);
}

static const char *const letters[3] = {"x", "y", "z"};

/* Index of a number in a list: a number, or the letter of a point's component; −1: none. */
static int item_of(const km_field *field, const char *token) {
  for (int k = 0; k < 3 && is_point(field); ++k)
    if (strcmp(token, letters[k]) == 0)
      return k;
  return index_of(token);
}

static void find_items(search *s, node list, size_t token) {
  int wanted = item_of(list.field, s->tokens[token]), index = 0;
  for (int k = 0; k < 3 && is_point(list.field); ++k)
    offer(s, token, letters[k]);
  const km_object_format *format = list.field && list.field->shape == KM_SHAPE_OBJECTS ? list.field->object : NULL;
  for (km_value *v = list.value->first; v; v = v->next, ++index) {
    km_place place = {list.place, NULL, (size_t)index};
    const char *name = format ? name_of(v) : NULL;
    if (name)
      offer(s, token, name);
    if (index == wanted || (name && strcmp(name, s->tokens[token]) == 0))
      find(s, (node){v, format, list.field, &place}, token + 1);
  }
}

/* Component k of a point that the file may not state, or state with two numbers. */
static void find_component(search *s, node object, const km_field *field, int k, size_t token) {
  km_value *point = (km_value *)km_value_get(object.value, field->key), *number = point ? point->first : NULL;
  km_place place = {object.place, field->key, 0};
  km_place item = {&place, NULL, (size_t)k};
  if (token + 1 != s->count || (point && point->kind != KM_LIST))
    return;
  for (int i = 0; i < k && number; ++i)
    number = number->next;
  add(s, (reading){.number = number, .object = object.value, .field = field, .component = k}, &item);
}

static bool is_place_of_element(const km_field *field) {
  return field->shape == KM_SHAPE_POINT && (strcmp(field->key, "T") == 0 || strcmp(field->key, "at") == 0);
}

/* The points of a joint are those of a drawing: another joint has frames in their place. */
static bool may_have(const node *object, const km_field *field) {
  bool point = object->format == &km_format_joint && field->shape == KM_SHAPE_POINT;
  return !point || km_joint_is_drawn(object->value);
}

/* A field that the file doesn't state, at the token that may name it or, of an element's place, its component. */
static void find_unstated_field(search *s, node object, const km_field *field, size_t token) {
  const km_value *stated = km_value_get(object.value, field->key);
  bool named = strcmp(field->key, s->tokens[token]) == 0;
  bool single = field->shape == KM_SHAPE_NUMBER || field->shape == KM_SHAPE_COORDINATES;
  km_place place = {object.place, field->key, 0};
  if (km_shape_is_numeric(field->shape) && token > 0)
    offer(s, token, field->key);
  if (named && !stated && single && token + 1 == s->count)
    add(s, (reading){.object = object.value, .field = field, .component = -1}, &place);
  for (int k = 0; k < 3 && is_place_of_element(field); ++k) {
    if (token > 0)
      offer(s, token, letters[k]);
    if (strcmp(s->tokens[token], letters[k]) == 0)
      find_component(s, object, field, k, token);
  }
  int item = token + 2 == s->count ? item_of(field, s->tokens[token + 1]) : -1;
  if (named && field->shape == KM_SHAPE_POINT && item >= 0 && item < 3)
    find_component(s, object, field, item, token + 1);
}

/* Numbers that the format has and the file doesn't state: single numbers, and components of points. */
static void find_unstated(search *s, node object, size_t token) {
  for (const km_field *field = object.format->fields; field->key; ++field) {
    if (may_have(&object, field)) {
      find_unstated_field(s, object, field, token);
    } else if (strcmp(field->key, "at") == 0 &&
               (strcmp(s->tokens[token], "at") == 0 || item_of(field, s->tokens[token]) >= 0)) {
      reach(s, token);
      s->pair = km_value_get(object.value, "body_frame_pairs");
    }
  }
}

static bool may_be_number(const km_field *field) {
  return field && (km_shape_is_numeric(field->shape) || field->shape == KM_SHAPE_PARAMETERS);
}

static void find_members(search *s, node object, size_t token) {
  for (km_value *v = object.value->first; v; v = v->next) {
    const km_field *field = object.format ? km_format_field(object.format, v->key) : object.field;
    km_place place = {object.place, v->key, 0};
    if (!field || field->shape == KM_SHAPE_ANY)
      continue;
    bool holds = field->shape == KM_SHAPE_OBJECT || field->shape == KM_SHAPE_END;
    node member = {v, holds ? field->object : NULL, field, &place};
    if (field->object || may_be_number(field))
      offer(s, token, v->key);
    if (strcmp(v->key, s->tokens[token]) == 0)
      find(s, member, token + 1);
    if (object.format && field->shape == KM_SHAPE_OBJECTS && v->kind == KM_LIST)
      find_items(s, member, token);
  }
  if (object.format)
    find_unstated(s, object, token);
}

static void find(search *s, node at, size_t token) {
  reach(s, token);
  bool number = at.value->kind == KM_NUMBER || at.value->kind == KM_STRING;
  if (token == s->count && number && may_be_number(at.field)) {
    add(s, (reading){.number = at.value, .object = at.value, .field = at.field, .component = -1}, at.place);
  } else if (token == s->count) {
    for (const km_value *v = at.value->first; v; v = v->next)
      if (v->key)
        offer(s, token, v->key);
  } else if (at.value->kind == KM_OBJECT) {
    find_members(s, at, token);
  } else if (at.value->kind == KM_LIST) {
    find_items(s, at, token);
  }
}

/* The path may begin at any object that the format knows. */
static void find_below(search *s, node object) {
  find_members(s, object, 0);
  for (km_value *v = object.value->first; v; v = v->next) {
    const km_field *field = km_format_field(object.format, v->key);
    km_place place = {object.place, v->key, 0};
    km_place item = {&place, NULL, 0};
    if (!field || !field->object)
      continue;
    if (v->kind == KM_OBJECT && field->shape == KM_SHAPE_OBJECT)
      find_below(s, (node){v, field->object, field, &place});
    for (km_value *o = field->shape == KM_SHAPE_OBJECTS ? v->first : NULL; o; o = o->next, ++item.index)
      if (o->kind == KM_OBJECT)
        find_below(s, (node){o, field->object, field, &item});
  }
}

/* Takes the path apart at its dots; the names lie in `copy`. */
static km_status split(const char *path, char *copy, search *s, km_error *error) {
  char *end = copy;
  s->tokens[s->count++] = end;
  for (const char *c = path; *c; ++c) {
    if (*c == '.') {
      *end++ = '\0';
      if (s->count == MOST_TOKENS)
        return km_fail(error, KM_USAGE, "\"%.80s\" has too many parts; expected at most %d", path, MOST_TOKENS);
      s->tokens[s->count++] = end;
    } else {
      if (*c == '\\' && c[1])
        ++c;
      *end++ = *c;
    }
  }
  return KM_OK;
}

/* The paths of a pair of frames: "coupler.end.x or rocker.end.x". */
static km_status has_frames(const search *s, const char *path, km_error *error) {
  char names[3 * KM_PLACE_TEXT] = "";
  for (const km_value *v = s->pair->first; v; v = v->next) {
    char text[KM_PLACE_TEXT];
    km_path_text(v, text);
    for (char *c = text; *c; ++c)
      *c = *c == '/' ? '.' : *c;
    size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, "%s%.200s.x", used ? " or " : "", text);
  }
  return km_fail(error, KM_USAGE,
                 "\"%.80s\" names no number of the model: the joint isn't drawn at a point, it connects two frames; "
                 "expected one of theirs, as %.160s",
                 path, names);
}

static km_status not_one(const search *s, const char *path, km_error *error) {
  char names[KM_NEAREST_TEXT];
  if (s->found > 1)
    return km_fail(error, KM_USAGE, "\"%.80s\" names several numbers, %s and %s; expected a path to one, from the root",
                   path, s->readings[0].place, s->readings[1].place);
  if (s->pair)
    return has_frames(s, path, error);
  km_nearest_text(&s->nearest, names);
  if (s->deepest == s->count && s->nearest.count == 0)
    return km_fail(error, KM_USAGE, "\"%.80s\" isn't a number of the model", path);
  if (s->deepest == s->count)
    return km_fail(error, KM_USAGE, "\"%.80s\" names no single number; expected one of its parts, as %s", path, names);
  return km_fail(error, KM_USAGE,
                 "\"%.80s\" names no number of the model: there is no \"%.60s\"; the nearest names are %s", path,
                 s->tokens[s->deepest], names);
}

static void set_number(const reading *r, double value, km_arena *arena) {
  km_value *number = r->number;
  if (!number && r->component < 0)
    number = km_value_number(arena, r->object, r->field->key, value);
  if (!number && r->component >= 0) {
    km_value *point = (km_value *)km_value_get(r->object, r->field->key);
    if (!point)
      point = km_value_add(arena, r->object, r->field->key, KM_LIST);
    while (point && point->count < 3 && !arena->failed)
      km_value_number(arena, point, NULL, 0.0);
    number = point ? point->first : NULL;
    for (int i = 0; i < r->component && number; ++i)
      number = number->next;
  }
  if (!number)
    return;
  number->kind = KM_NUMBER;
  number->number = value;
  number->string = NULL;
}

/* A parameter's number, where the path is its name. */
static km_value *parameter_of(km_value *root, const search *s) {
  km_value *parameters = (km_value *)km_value_get(root, "parameters");
  km_value *found = s->count == 1 ? (km_value *)km_value_get(parameters, s->tokens[0]) : NULL;
  return found ? km_parameter_number(found) : NULL;
}

/* The one place that the path names. */
static km_status locate(km_value *root, const char *path, reading *out, km_error *error) {
  search s = {0};
  node whole = {root, &km_format_model, NULL, NULL};
  char *copy = KM_NEW(char, strlen(path) + 1);
  km_status status = copy ? split(path, copy, &s, error) : km_fail(error, KM_MEMORY, "out of memory for a path");
  if (!status) {
    km_value *parameter = parameter_of(root, &s);
    const km_value *parameters = km_value_get(root, "parameters");
    for (const km_value *v = parameters && !parameter ? parameters->first : NULL; v; v = v->next)
      offer(&s, 0, v->key);
    if (parameter)
      s.readings[s.found++] = (reading){.number = parameter};
    else
      find_members(&s, whole, 0);
    if (!s.found) /* nothing from the root: from anywhere */
      find_below(&s, whole);
    if (s.found == 1)
      *out = s.readings[0];
    else
      status = not_one(&s, path, error);
  }
  km_free(copy);
  return status;
}

static km_status assign(km_value *root, const km_assignment *a, km_arena *arena, km_error *error) {
  reading found;
  km_status status = locate(root, a->path, &found, error);
  if (!status)
    set_number(&found, a->value, arena);
  return !status && arena->failed ? km_fail(error, KM_MEMORY, "out of memory for a variant") : status;
}

static km_status check_path(const char *path, km_error *error) {
  return path && path[0] ? KM_OK : km_fail(error, KM_USAGE, "a path is empty; expected one such as crank.tip.x");
}

km_status km_model_vary(km_value *root, const km_assignment *assignments, int count, km_arena *arena, km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; i < count && !status; ++i) {
    status = check_path(assignments[i].path, error);
    if (!status && !isfinite(assignments[i].value))
      status = km_fail(error, KM_USAGE, "\"%.80s\": found a value that isn't finite", assignments[i].path);
    else if (!status && root->kind == KM_OBJECT)
      status = assign(root, &assignments[i], arena, error);
  }
  return status;
}

km_status km_model_find_number(km_value *root, const char *path, double *value, km_error *error) {
  reading found = {0};
  km_status status = check_path(path, error);
  if (!status && root->kind == KM_OBJECT)
    status = locate(root, path, &found, error);
  *value = !status && found.number && found.number->kind == KM_NUMBER ? found.number->number : nan("");
  return status;
}
