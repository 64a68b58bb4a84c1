/* Laws over a time or a joint's value: tables, cosines, steps, segments of a motion. */
#include "exchange/json/expression_values.h"
#include "exchange/json/formula.h"
#include "exchange/json/read/reader.h"

#include <math.h>
#include <string.h>

static void report_fault(km_reader *reader, km_curve_fault fault, double period, const km_place *place) {
  if (fault == KM_CURVE_MEMORY)
    reader->model->arena.failed = true;
  else if (fault == KM_CURVE_TOO_LONG)
    km_reader_error(reader, place, "longer than the period of %s; expected at most one period", KM_SHOWN(period));
  else if (fault == KM_CURVE_OPEN)
    km_reader_error(reader, place,
                    "the last row, a period after the first, has another value; expected the same value");
  else if (fault == KM_CURVE_MOVING)
    km_reader_error(reader, place,
                    "the motion isn't at rest here; expected a rate of 0 before a rise and at the end of "
                    "a period");
}

void km_check_rows(km_reader *reader, const km_value *table, const char *first_column, const km_place *place) {
  double last = -HUGE_VAL;
  km_place item = {place, NULL, 0};
  for (const km_value *row = table->first; row; row = row->next, ++item.index) {
    if (row->count != 2)
      km_reader_error(reader, &item, "found %zu numbers; expected [%s, value]", row->count, first_column);
    else if (!(row->first->number > last))
      km_reader_error(reader, &item, "%s %s doesn't come after the last one; expected increasing values", first_column,
                      KM_SHOWN(row->first->number));
    if (row->first)
      last = row->first->number;
  }
}

double km_read_period(km_reader *reader, const km_value *object, const km_place *place) {
  const km_value *period = km_value_get(object, "period");
  if (!period)
    return 0.0;
  km_reader_positive(reader, place, "period", period->number);
  return period->number > 0.0 ? period->number : 0.0;
}

void km_read_table(km_reader *reader, const km_value *object, bool cubic, double factor, const km_place *place,
                   km_law_curve *out) {
  const km_value *table = km_value_get(object, "table");
  km_place at = {place, "table", 0};
  double period = km_read_period(reader, object, place);
  size_t errors = km_messages_errors(reader->messages);
  km_check_rows(reader, table, "x", &at);
  if (table->count == 0)
    km_reader_error(reader, &at, "found no rows; expected at least one");
  double *rows = KM_ARENA_NEW(&reader->model->arena, double, 2 * table->count);
  if (!rows || km_messages_errors(reader->messages) > errors)
    return;
  double *number = rows;
  for (const km_value *row = table->first; row; row = row->next) {
    *number++ = factor * row->first->number;
    *number++ = row->last->number;
  }
  report_fault(reader, km_curve_from_rows(rows, (int)table->count, cubic, factor * period, &reader->model->arena, out),
               period, &at);
}

/* True if the key is "cubic". */
static bool read_interpolation(km_reader *reader, const km_value *object, const km_place *place) {
  const char *word = km_reader_string(object, "interpolation");
  km_place at = {place, "interpolation", 0};
  bool is_cubic = word && strcmp(word, "cubic") == 0;
  if (word && !is_cubic && strcmp(word, "linear") != 0)
    km_reader_error(reader, &at, "\"%.40s\" is not an interpolation; expected linear or cubic", word);
  return is_cubic;
}

void km_read_cosine(km_reader *reader, const km_value *object, double factor, const km_place *place,
                    km_law_curve *out) {
  const km_value *cosine = km_value_get(object, "cosine");
  double period = km_read_period(reader, object, place), angle = reader->model->units.angle->si;
  double *numbers = KM_ARENA_NEW(&reader->model->arena, double, 4);
  if (!km_value_get(object, "period"))
    km_reader_error(reader, place, "\"period\" is missing; expected the period of the cosine");
  if (!numbers || period == 0.0)
    return;
  numbers[0] = km_reader_number(cosine, "offset", 0.0);
  numbers[1] = km_reader_number(cosine, "amplitude", 0.0);
  numbers[2] = 2.0 * M_PI / (factor * period);
  numbers[3] = 0.5 * M_PI + angle * km_reader_number(cosine, "phase", 0.0);
  *out = (km_law_curve){.form = KM_CURVE_SINE, .count = 4, .numbers = numbers};
}

static void read_step(km_reader *reader, const km_value *object, double factor, const km_place *place,
                      km_law_curve *out) {
  const km_value *step = km_value_get(object, "step");
  km_place at = {place, "step", 0}, period_at = {place, "period", 0};
  km_reader_not_negative(reader, step, "width", &at);
  if (km_value_get(object, "period"))
    km_reader_error(reader, &period_at, "a step has no period; expected a table");
  report_fault(reader,
               km_curve_from_step(factor * km_reader_number(step, "at", 0.0),
                                  factor * km_reader_number(step, "width", 0.0), km_reader_number(step, "from", 0.0),
                                  km_reader_number(step, "to", 0.0), &reader->model->arena, out),
               0.0, &at);
}

/* Polynomial in the file's unit of x, as one in the model's. */
static void read_polynomial(km_reader *reader, const km_value *object, double factor, const km_place *place,
                            km_law_curve *out) {
  const km_value *polynomial = km_value_get(object, "polynomial");
  km_place period_at = {place, "period", 0}, at = {place, "polynomial", 0};
  double *numbers = KM_ARENA_NEW(&reader->model->arena, double, polynomial->count);
  if (km_value_get(object, "period"))
    km_reader_error(reader, &period_at, "a polynomial has no period; expected a table or a cosine");
  if (polynomial->count == 0)
    km_reader_error(reader, &at, "found a list of 0; expected at least one coefficient");
  int count = 0;
  double power = 1.0;
  for (const km_value *c = numbers ? polynomial->first : NULL; c; c = c->next, power /= factor)
    numbers[count++] = c->number * power;
  *out = (km_law_curve){.form = KM_CURVE_POLYNOMIAL, .count = count, .numbers = numbers};
}

/* Checks the text as expressions of numbers are checked, with t = 0. */
static km_status check_expression(const km_value *parameters, const char *text, km_error *error) {
  km_formulas *formulas = km_formulas_create(parameters);
  km_status status = formulas ? KM_OK : km_fail(error, KM_MEMORY, "out of memory while reading expressions");
  for (const km_value *p = parameters ? parameters->first : NULL; p && !status; p = p->next) {
    const km_value *number = km_parameter_number((km_value *)p);
    if (number && !km_formulas_define(formulas, p->key, number->number))
      status = km_fail(error, KM_MEMORY, "out of memory while reading expressions");
  }
  if (!status && km_value_get(parameters, "t"))
    status = km_fail(error, KM_MODEL, "the parameter \"t\" hides the time; expected another name of the parameter");
  double value;
  if (!status && !km_formulas_define(formulas, "t", 0.0))
    status = km_fail(error, KM_MEMORY, "out of memory while reading expressions");
  if (!status)
    status = km_formulas_evaluate(formulas, text, &value, error);
  km_formulas_free(formulas);
  return status;
}

bool km_parameter_value(const void *parameters, const char *name, size_t length, double *value) {
  const km_value *all = parameters;
  for (const km_value *p = all ? all->first : NULL; p; p = p->next) {
    const km_value *number = km_parameter_number((km_value *)p);
    if (number && strlen(p->key) == length && strncmp(p->key, name, length) == 0) {
      *value = number->number;
      return true;
    }
  }
  return false;
}

void km_read_expression(km_reader *reader, const char *text, const km_place *place, km_law_curve *out) {
  const km_value *parameters = km_value_get(reader->origin->root, "parameters");
  km_error error;
  double at[3];
  if (check_expression(parameters, text, &error)) {
    km_reader_error(reader, place, "\"%.60s\": %s", text, error.text);
    return;
  }
  const km_expression *expression = km_expression_compile(text, km_parameter_value, parameters, &reader->model->arena);
  if (!expression) {
    km_reader_error(reader, place, "\"%.60s\": it can't be read", text);
    return;
  }
  km_expression_at(expression, 0.0, at);
  if (!isfinite(at[1]) || !isfinite(at[2]))
    km_reader_error(reader, place, "\"%.60s\": its rate isn't finite at t = 0", text);
  *out = (km_law_curve){.form = KM_CURVE_EXPRESSION, .expression = expression};
}

/* The law `expression`, which reads the time alone. */
static void read_expression_law(km_reader *reader, const km_value *object, const km_place *place, km_law_curve *out) {
  km_place at = {place, "expression", 0}, over_at = {place, "over", 0}, period_at = {place, "period", 0};
  const km_value *over = km_value_get(object, "over");
  if (over && (over->kind != KM_STRING || strcmp(over->string, "t") != 0))
    km_reader_error(reader, &over_at, "an expression is one of the time; expected t");
  if (km_value_get(object, "period"))
    km_reader_error(reader, &period_at, "an expression has no period; expected a table or a cosine");
  km_read_expression(reader, km_reader_string(object, "expression"), &at, out);
}

static const char *const laws[] = {"table", "cosine", "step", "polynomial", "expression", NULL};

int km_count_laws(const km_value *object) {
  int count = 0;
  for (const char *const *law = laws; *law; ++law)
    count += km_value_get(object, *law) != NULL;
  return count;
}

void km_read_curve(km_reader *reader, const km_value *object, double factor, const km_place *place, km_law_curve *out) {
  bool is_cubic = read_interpolation(reader, object, place);
  if (km_value_get(object, "table"))
    km_read_table(reader, object, is_cubic, factor, place, out);
  else if (km_value_get(object, "cosine"))
    km_read_cosine(reader, object, factor, place, out);
  else if (km_value_get(object, "step"))
    read_step(reader, object, factor, place, out);
  else if (km_value_get(object, "expression"))
    read_expression_law(reader, object, place, out);
  else
    read_polynomial(reader, object, factor, place, out);
}

static void read_segment(km_reader *reader, const km_value *value, const km_place *place, km_motion_segment *out) {
  const km_value *rise = km_value_get(value, "rise"), *rate = km_value_get(value, "rate");
  const char *law = km_reader_string(value, "law");
  km_place law_at = {place, "law", 0};
  int found = law ? km_rise_find(law) : KM_RISE_CYCLOIDAL;
  *out = (km_motion_segment){.kind = rise   ? KM_SEGMENT_RISE
                                     : rate ? KM_SEGMENT_RATE
                                            : KM_SEGMENT_KEEP,
                             .rise = found < 0 ? KM_RISE_CYCLOIDAL : (km_rise)found,
                             .duration = km_reader_number(value, "duration", 0.0),
                             .by = rise ? rise->number : 0.0,
                             .rate = rate ? rate->number : 0.0};
  km_reader_positive(reader, place, "duration", out->duration);
  if (found < 0)
    km_reader_error(reader, &law_at, "\"%.40s\" is not a law; expected cycloidal, 3-4-5 or modified-trapezoid", law);
  if (rise && rate)
    km_reader_error(reader, place, "found \"rise\" and \"rate\"; expected one of them, or neither for a dwell");
}

void km_read_segments(km_reader *reader, const km_value *object, double start, const km_place *place,
                      km_law_curve *out) {
  const km_value *list = km_value_get(object, "segments");
  km_place at = {place, "segments", 0}, item = {&at, NULL, 0};
  double period = km_read_period(reader, object, place);
  km_arena scratch = {0};
  size_t errors = km_messages_errors(reader->messages);
  km_motion_segment *segments = KM_ARENA_NEW(&scratch, km_motion_segment, list->count);
  if (list->count == 0)
    km_reader_error(reader, &at, "found an empty list; expected at least one segment");
  for (const km_value *v = segments ? list->first : NULL; v; v = v->next, ++item.index)
    read_segment(reader, v, &item, &segments[item.index]);
  if (!segments) {
    reader->model->arena.failed = true;
  } else if (km_messages_errors(reader->messages) == errors) {
    int segment;
    km_curve_fault fault =
        km_curve_from_segments(segments, (int)list->count, start, period, &reader->model->arena, out, &segment);
    item.index = (size_t)segment;
    report_fault(reader, fault, period, item.index < list->count ? &item : &at);
  }
  km_arena_free(&scratch);
}
