/* Expressions over named parameters. The only place that knows muParser; it is C++, so it is loaded with the first
 * expression: linked, every start of a tool would pay for it. Names are checked here, so that it meets none of its
 * other functions and constants. */
#include "exchange/json/formula.h"

#include "base/dynamic_library.h"
#include "base/name_map.h"
#include "base/similar_names.h"

#include <math.h>
#include <muParserDLL.h>
#include <string.h>

enum { LONGEST_FORMULA = 1000, LONGEST_NAME = 60 };

/* Function pointers in the order of the names in find_muparser. */
typedef struct muparser_functions {
  muParserHandle_t (*create)(int base);
  void (*release)(muParserHandle_t);
  void (*set)(muParserHandle_t, const char *);
  double (*evaluate)(muParserHandle_t);
  muBool_t (*failed)(muParserHandle_t);
  void (*reset)(muParserHandle_t);
  int (*position)(muParserHandle_t);
  void (*constant)(muParserHandle_t, const char *, double);
} muparser_functions;

struct km_formulas {
  const km_value *parameters;
  km_names defined;
  double *values;
  size_t count, room;
  const char **names;
  size_t name_room;
  const muparser_functions *muparser; /* NULL: not loaded yet */
  muParserHandle_t parser;            /* another form of the same function */
};

static const char *const functions[] = {"sqrt", "sin", "cos", "tan", "atan2", "abs", "min", "max", NULL};
static const char *const constants[] = {"pi", "deg", NULL};

static bool is_among(const char *name, const char *const *words) {
  for (; *words; ++words)
    if (strcmp(name, *words) == 0)
      return true;
  return false;
}

km_formulas *km_formulas_create(const km_value *parameters) {
  km_formulas *f = KM_NEW(km_formulas, 1);
  if (f)
    f->parameters = parameters;
  return f;
}

void km_formulas_free(km_formulas *f) {
  if (!f)
    return;
  if (f->parser)
    f->muparser->release(f->parser);
  km_names_free(&f->defined);
  km_free(f->values);
  km_free(f->names);
  km_free(f);
}

static bool starts_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

km_status km_formulas_check_name(const char *name, km_error *error) {
  size_t length = strlen(name);
  bool plain = starts_name(name[0]) && length <= LONGEST_NAME;
  for (const char *c = name; *c; ++c)
    plain = plain && (starts_name(*c) || is_digit(*c));
  if (!plain)
    return km_fail(error, KM_MODEL,
                   "\"%.80s\" can't be used in an expression; expected a name of up to %d letters, digits and "
                   "underscores that doesn't begin with a digit",
                   name, LONGEST_NAME);
  if (is_among(name, functions) || is_among(name, constants))
    return km_fail(error, KM_MODEL, "\"%s\" has a meaning of its own in expressions; expected another name", name);
  return KM_OK;
}

bool km_formulas_define(km_formulas *f, const char *name, double value) {
  void *values = f->values, *names = f->names;
  if (!km_reserve(&values, &f->room, f->count + 1, sizeof *f->values))
    return false;
  f->values = values;
  if (!km_reserve(&names, &f->name_room, f->count + 1, sizeof *f->names))
    return false;
  f->names = names;
  if (!km_names_set(&f->defined, 0, name, (int)f->count))
    return false;
  f->values[f->count] = value;
  f->names[f->count++] = name;
  if (f->parser)
    f->muparser->constant(f->parser, name, value);
  return true;
}

static const muparser_functions *find_muparser(km_error *error) {
  static const char *const files[] = {KM_MUPARSER, NULL};
  static const char *const names[] = {"mupCreate",     "mupRelease",     "mupSetExpr",     "mupEval", "mupError",
                                      "mupErrorReset", "mupGetErrorPos", "mupDefineConst", NULL};
  static muparser_functions found;
  static km_library library = {files, names, &found, false};
  const char *reason = km_library_load(&library);
  if (!reason)
    return &found;
  km_fail(error, KM_IO, "expressions can't be evaluated: %.300s; expected muParser to be installed", reason);
  return NULL;
}

static km_status load(km_formulas *f, km_error *error) {
  if (f->parser)
    return KM_OK;
  f->muparser = find_muparser(error);
  if (!f->muparser)
    return KM_IO;
  f->parser = f->muparser->create(muBASETYPE_FLOAT); /* never NULL: it throws where there is no memory */
  f->muparser->constant(f->parser, "pi", M_PI);
  f->muparser->constant(f->parser, "deg", M_PI / 180.0);
  for (size_t i = 0; i < f->count; ++i)
    f->muparser->constant(f->parser, f->names[i], f->values[i]);
  return KM_OK;
}

static km_status unknown(const km_formulas *f, const char *name, km_error *error) {
  char known[KM_NEAREST_TEXT];
  km_nearest nearest = {.wanted = name};
  if (km_value_get(f->parameters, name))
    return km_fail(error, KM_MODEL, "the parameter \"%s\" has no value yet; parameters may use earlier ones only",
                   name);
  for (size_t i = 0; i < f->count; ++i)
    km_nearest_add(&nearest, f->names[i]);
  for (const char *const *word = functions; *word; ++word)
    km_nearest_add(&nearest, *word);
  return km_fail(error, KM_MODEL, "there is no parameter or function \"%s\"; the nearest known names are %s", name,
                 km_nearest_text(&nearest, known));
}

/* Steps over a number: digits with a point and an exponent. */
static const char *after_number(const char *c) {
  while (is_digit(*c) || *c == '.')
    ++c;
  const char *exponent = c + 1 + (*c && (c[1] == '+' || c[1] == '-'));
  if ((*c == 'e' || *c == 'E') && is_digit(*exponent))
    for (c = exponent; is_digit(*c);)
      ++c;
  return c;
}

/* Steps over a name; NULL (with the error) if it means nothing. */
static const char *after_name(const km_formulas *f, const char *c, km_error *error) {
  char name[LONGEST_NAME + 1];
  size_t length = 0;
  while (starts_name(c[length]) || is_digit(c[length]))
    ++length;
  if (length > LONGEST_NAME) {
    km_fail(error, KM_MODEL, "there is no parameter \"%.*s…\"", LONGEST_NAME, c);
    return NULL;
  }
  memcpy(name, c, length);
  name[length] = '\0';
  if (is_among(name, functions) || is_among(name, constants) || km_names_get(&f->defined, 0, name) >= 0)
    return c + length;
  unknown(f, name, error);
  return NULL;
}

/* Only the characters and names that the format allows; at least one operator or name, because a number in quotation
 * marks is more likely a mistake. */
static km_status check_text(const km_formulas *f, const char *text, km_error *error) {
  bool more_than_number = false;
  if (strlen(text) > LONGEST_FORMULA)
    return km_fail(error, KM_MODEL, "it has more than %d characters", LONGEST_FORMULA);
  for (const char *c = text; *c;) {
    if (is_digit(*c) || *c == '.') {
      c = after_number(c);
    } else if (starts_name(*c)) {
      more_than_number = true;
      c = after_name(f, c, error);
      if (!c)
        return KM_MODEL;
    } else if (strchr("+-*/^(), ", *c)) {
      more_than_number = more_than_number || (*c != ' ' && c != text);
      ++c;
    } else {
      return km_fail(error, KM_MODEL, "character %d doesn't belong in an expression", (int)(c - text) + 1);
    }
  }
  return more_than_number ? KM_OK : km_fail(error, KM_MODEL, "a number stands without quotation marks");
}

km_status km_formulas_result(km_formulas *f, const char *text, double *value, km_error *error) {
  km_status status = check_text(f, text, error);
  if (!status)
    status = load(f, error);
  if (status)
    return status;
  f->muparser->set(f->parser, text);
  double result = f->muparser->evaluate(f->parser);
  if (f->muparser->failed(f->parser)) {
    int position = f->muparser->position(f->parser), length = (int)strlen(text);
    f->muparser->reset(f->parser);
    return position < 0 || position >= length
               ? km_fail(error, KM_MODEL, "it isn't complete")
               : km_fail(error, KM_MODEL, "it can't be read at character %d", position + 1);
  }
  *value = result;
  return KM_OK;
}

km_status km_formulas_evaluate(km_formulas *f, const char *text, double *value, km_error *error) {
  double result;
  km_status status = km_formulas_result(f, text, &result, error);
  if (!status && !isfinite(result))
    status = km_fail(error, KM_MODEL, "its value isn't finite");
  if (!status)
    *value = result;
  return status;
}
