/* Arms from a table of Denavit and Hartenberg's parameters (J. Denavit and R. Hartenberg 1955; J. Craig 1986).
 *
 *   standard : T_i = Rz(θ) Tz(d) Tx(a) Rx(α), the parameters of one row          z of joint i lies on link i − 1
 *   modified : T_i = Rx(α) Tx(a) Tz(d) Rz(θ), α and a of the link before it       z of joint i lies on link i
 *
 * A joint turns or slides about z where θ, or d, of a row has its variable; both are offsets. A fixed row adds its
 * transformation to the link. */
#include "kmob/dh_table.h"

#include "kmech/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = 64, COLUMNS = 9, FIELD = 64 };
enum { NAME, TYPE, A, ALPHA, D, THETA, LOWER, UPPER, MASS };
static const char *const columns[COLUMNS] = {"name", "type", "a", "alpha", "d", "theta", "min", "max", "mass"};

typedef struct dh_row {
  char name[FIELD];
  char type; /* 'R' turns, 'P' slides, 'F' is fixed */
  double numbers[COLUMNS];
} dh_row;

typedef struct dh_table {
  const kt_common *common;
  const char *file;
  int column[COLUMNS]; /* place in the header; −1: not there */
  int fields;          /* fields of the header, as of every row */
  char separator;      /* , or ; as in the header */
  dh_row rows[MOST_ROWS];
  int count, joints;
} dh_table;

/* Rotation by rows, and place. */
typedef struct dh_pose {
  double R[9], p[3];
} dh_pose;

static dh_pose product(const dh_pose *a, const dh_pose *b) {
  dh_pose out = {.p = {a->p[0], a->p[1], a->p[2]}};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      out.p[i] += a->R[3 * i + k] * b->p[k];
      for (int j = 0; j < 3; ++j)
        out.R[3 * i + j] += a->R[3 * i + k] * b->R[3 * k + j];
    }
  return out;
}

/* Sine and cosine, exact at whole quarter turns. */
static void sine_cosine(double angle, double radians_per_unit, double *s, double *c) {
  const double quarters = angle * radians_per_unit / M_PI_2, whole = nearbyint(quarters);
  const int quarter = (int)fmod(whole, 4.0);
  static const double sines[4] = {0.0, 1.0, 0.0, -1.0};
  *s = sin(angle * radians_per_unit);
  *c = cos(angle * radians_per_unit);
  if (fabs(quarters - whole) < 1e-9) {
    *s = sines[(quarter + 4) % 4];
    *c = sines[(quarter + 5) % 4];
  }
}

static dh_pose turn(char axis, double angle, const km_units *units) {
  double s, c;
  sine_cosine(angle, units->angle->si, &s, &c);
  if (axis == 'z')
    return (dh_pose){{c, -s, 0, s, c, 0, 0, 0, 1}, {0, 0, 0}};
  return (dh_pose){{1, 0, 0, 0, c, -s, 0, s, c}, {0, 0, 0}};
}

static dh_pose shift(double x, double z) {
  return (dh_pose){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {x, 0, z}};
}

static void apply(dh_pose *X, dh_pose step) {
  *X = product(X, &step);
}

static kt_exit complain(const dh_table *t, int line, const char *column, const char *text, const char *expected) {
  kt_print_message(t->common, KM_ERROR, "%s: line %d: %s: found \"%s\"; expected %s", t->file, line, column, text,
                   expected);
  return KT_BAD_MODEL;
}

static kt_exit check_limits(const dh_table *t, const dh_row *row, int line) {
  const double low = row->numbers[LOWER], high = row->numbers[UPPER];
  if ((isnan(low) && isnan(high)) || low <= high)
    return KT_DONE;
  kt_print_message(t->common, KM_ERROR, "%s: line %d: min, max: %s", t->file, line,
                   isnan(low) || isnan(high) ? "one of the limits is missing; expected both, or none"
                                             : "min is above max");
  return KT_BAD_MODEL;
}

/* Reads the next field of a line without blanks around it; false: the line has ended. */
static bool next_field(const dh_table *t, const char **at, const char *end, char out[FIELD]) {
  if (*at > end)
    return false;
  const char *comma = *at;
  while (comma < end && *comma != t->separator)
    ++comma;
  const char *first = *at, *last = comma;
  while (first < last && strchr(" \t\r\"", *first))
    ++first;
  while (last > first && strchr(" \t\r\"", last[-1]))
    --last;
  snprintf(out, FIELD, "%.*s", (int)(last - first), first);
  *at = comma + 1;
  return true;
}

static kt_exit read_header(dh_table *t, const char *at, const char *end, int line) {
  char field[FIELD];
  t->separator = memchr(at, ';', (size_t)(end - at)) ? ';' : ',';
  for (int c = 0; c < COLUMNS; ++c)
    t->column[c] = -1;
  for (int place = 0; next_field(t, &at, end, field); ++place) {
    int found = 0;
    while (found < COLUMNS && strcmp(columns[found], field) != 0)
      ++found;
    if (found == COLUMNS)
      return complain(t, line, "header", field, "name, type, a, alpha, d, theta, min, max or mass");
    if (t->column[found] >= 0)
      return complain(t, line, "header", field, "each column once");
    t->column[found] = place;
    t->fields = place + 1;
  }
  for (int c = A; c <= THETA; ++c)
    if (t->column[c] < 0)
      return complain(t, line, "header", columns[c], "the columns a, alpha, d and theta");
  return KT_DONE;
}

/* Letters, digits, _, - and . of a name that no other row has, and that bodies and frames of the model don't. */
static kt_exit check_name(const dh_table *t, const dh_row *row, int line) {
  static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  if (row->name[strspn(row->name, plain)] || strlen(row->name) >= FIELD - 1)
    return complain(t, line, "name", row->name, "up to 62 letters, digits, _, - and .");
  if (strcmp(row->name, "origin") == 0 || strcmp(row->name, "tool") == 0)
    return complain(t, line, "name", row->name, "another name: frames of the links are called so");
  for (int i = 0; i < t->count; ++i)
    if (strcmp(t->rows[i].name, row->name) == 0)
      return complain(t, line, "name", row->name, "a name that no other row has");
  return KT_DONE;
}

/* A fixed row has neither limits nor a mass. */
static kt_exit check_fixed(const dh_table *t, const dh_row *row, int line) {
  const double *n = row->numbers;
  return row->type != 'F' || (isnan(n[LOWER]) && isnan(n[UPPER]) && isnan(n[MASS]))
             ? KT_DONE
             : complain(t, line, "type", "F", "no min, max or mass: a fixed row is a part of its link");
}

static kt_exit read_cell(dh_table *t, dh_row *row, int column, const char *text, int line) {
  if (column == NAME) {
    snprintf(row->name, sizeof row->name, "%s", text);
    return KT_DONE;
  }
  if (column == TYPE) {
    row->type = text[0] ? text[0] : 'R';
    return strlen(text) <= 1 && strchr("RPF", row->type) ? KT_DONE
                                                         : complain(t, line, "type", text, "R, P or F (fixed)");
  }
  if (!text[0])
    return KT_DONE;
  return kt_number(text, &row->numbers[column]) ? KT_DONE : complain(t, line, columns[column], text, "a number");
}

static kt_exit read_row(dh_table *t, const char *at, const char *end, int line) {
  char field[FIELD];
  dh_row *row = &t->rows[t->count];
  kt_exit result = KT_DONE;
  if (t->count == MOST_ROWS)
    return complain(t, line, "row", "one more", "at most 64");
  *row = (dh_row){.type = 'R'};
  row->numbers[LOWER] = row->numbers[UPPER] = row->numbers[MASS] = nan("");
  int fields = 0;
  for (; next_field(t, &at, end, field) && result == KT_DONE; ++fields)
    for (int c = 0; c < COLUMNS && result == KT_DONE; ++c)
      if (t->column[c] == fields)
        result = read_cell(t, row, c, field, line);
  if (result == KT_DONE && fields != t->fields) {
    kt_print_message(t->common, KM_ERROR, "%s: line %d: found %d fields; expected %d, as in the header", t->file, line,
                     fields, t->fields);
    return KT_BAD_MODEL;
  }
  if (result == KT_DONE)
    result = check_limits(t, row, line);
  if (result == KT_DONE)
    result = check_fixed(t, row, line);
  t->joints += row->type != 'F';
  if (!row->name[0])
    snprintf(row->name, sizeof row->name, row->type == 'F' ? "fixed%d" : "J%d",
             row->type == 'F' ? t->count + 1 : t->joints);
  if (result == KT_DONE)
    result = check_name(t, row, line);
  ++t->count;
  return result;
}

static kt_exit read_lines(dh_table *t, const km_text *text) {
  static const char mark[] = "\xEF\xBB\xBF"; /* byte order mark */
  const bool marked = text->size >= 3 && memcmp(text->data, mark, 3) == 0;
  const char *at = text->data + (marked ? 3 : 0), *stop = text->data + text->size;
  bool has_header = false;
  kt_exit result = KT_DONE;
  for (int line = 1; at < stop && result == KT_DONE; ++line) {
    const char *end = memchr(at, '\n', (size_t)(stop - at));
    end = end ? end : stop;
    bool blank = strspn(at, " \t\r,;") >= (size_t)(end - at) || *at == '#';
    if (!blank && !has_header)
      result = read_header(t, at, end, line);
    else if (!blank)
      result = read_row(t, at, end, line);
    has_header = has_header || !blank;
    at = end + 1;
  }
  if (result == KT_DONE && t->joints == 0) {
    kt_print_message(t->common, KM_ERROR, "%s: no joint; expected a header and at least one row", t->file);
    return KT_BAD_MODEL;
  }
  return result;
}

static void write_numbers(const double *values, int count, km_text *out) {
  for (int i = 0; i < count; ++i) {
    km_text_add(out, i ? ", " : "");
    km_text_number(out, values[i] == 0.0 ? 0.0 : values[i]);
  }
}

static void write_frame(const char *name, const dh_pose *X, km_text *out) {
  km_text_format(out, "{\"name\": \"%s\", \"T\": [", name);
  write_numbers(X->p, 3, out);
  km_text_add(out, "], \"R\": [[");
  for (int i = 0; i < 3; ++i) {
    write_numbers(X->R + 3 * i, 3, out);
    km_text_add(out, i < 2 ? "], [" : "]]}");
  }
}

/* Frame of each joint on the link before it, and of the tool on the last one: frames[joints + 1]. */
static void place_frames(const dh_table *t, bool modified, const km_units *units, dh_pose *frames) {
  const dh_pose none = shift(0.0, 0.0);
  dh_pose X = none;
  int joint = 0;
  for (int i = 0; i < t->count; ++i) {
    const double *n = t->rows[i].numbers;
    if (modified) {
      apply(&X, turn('x', n[ALPHA], units));
      apply(&X, shift(n[A], n[D]));
    }
    apply(&X, turn('z', n[THETA], units));
    if (t->rows[i].type != 'F') {
      frames[joint++] = X;
      X = none;
    }
    if (!modified) {
      apply(&X, shift(n[A], n[D]));
      apply(&X, turn('x', n[ALPHA], units));
    }
  }
  frames[joint] = X;
}

static void write_joint(const dh_row *row, int index, km_text *out) {
  km_text_format(out, "   {\"name\": \"%s\", \"type\": \"%s\", \"body_frame_pairs\": [[\"", row->name,
                 row->type == 'P' ? "Tz" : "Rz");
  if (index)
    km_text_format(out, "link%d", index);
  else
    km_text_add(out, "fixed");
  km_text_format(out, "\", \"%s\"], [\"link%d\", \"origin\"]]", row->name, index + 1);
  if (!isnan(row->numbers[LOWER])) {
    const double low = row->numbers[LOWER], high = row->numbers[UPPER], middle = 0.5 * (low + high);
    km_text_add(out, ", \"limits\": [");
    write_numbers(&row->numbers[LOWER], 2, out);
    km_text_add(out, "]");
    if (middle != 0.0) {
      km_text_add(out, ", \"initial_displacement\": ");
      write_numbers(&middle, 1, out);
    }
  }
  km_text_add(out, "}");
}

static void write_model(const dh_table *t, bool modified, const km_units *units, km_text *out) {
  dh_pose frames[MOST_ROWS + 1];
  const dh_row *joints[MOST_ROWS];
  int count = 0;
  km_units copy = *units;
  for (int i = 0; i < t->count; ++i)
    if (t->rows[i].type != 'F')
      joints[count++] = &t->rows[i];
  place_frames(t, modified, units, frames);
  km_text_format(out, "{\n \"source\": \"An arm from a table of Denavit and Hartenberg's parameters (%s).\",\n",
                 modified ? "modified" : "standard");
  km_text_add(out, " \"model_parameters\": {\"version\": \"1.2\", \"units\": {");
  for (int q = 0; q < KM_QUANTITIES; ++q)
    km_text_format(out, "%s\"%s\": \"%s\"", q ? ", " : "", km_quantity_name((km_quantity)q),
                   (*km_units_slot(&copy, (km_quantity)q))->suffix);
  km_text_add(out, "}},\n \"fixed\": {\"frames\": [");
  write_frame(joints[0]->name, &frames[0], out);
  km_text_add(out, "]},\n \"assemblies\": [{\"name\": \"arm\",\n  \"bodies\": [\n");
  for (int j = 0; j < count; ++j) {
    km_text_format(out, "   {\"name\": \"link%d\"", j + 1);
    if (!isnan(joints[j]->numbers[MASS])) {
      km_text_add(out, ", \"mass\": ");
      km_text_number(out, joints[j]->numbers[MASS]);
    }
    km_text_add(out, ", \"frames\": [");
    write_frame(j + 1 < count ? joints[j + 1]->name : "tool", &frames[j + 1], out);
    km_text_add(out, j + 1 < count ? "]},\n" : "]}],\n");
  }
  km_text_add(out, "  \"joints\": [\n");
  for (int j = 0; j < count; ++j) {
    write_joint(joints[j], j, out);
    km_text_add(out, j + 1 < count ? ",\n" : "]}],\n");
  }
  km_text_add(out, " \"analysis\": {\"actuators\": [");
  for (int j = 0; j < count; ++j)
    km_text_format(out, "%s\"%s\"", j ? ", " : "", joints[j]->name);
  km_text_add(out, "]}\n}\n");
}

kt_exit kmob_dh_write(const kt_common *common, const char *file, bool modified, const km_units *units, km_text *out) {
  km_text text = {0};
  km_error error;
  dh_table *t = KM_NEW(dh_table, 1);
  if (!t)
    return KT_NO_MEMORY;
  t->common = common;
  t->file = file;
  km_status status = km_file_read(file, &text, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  kt_exit result = status ? kt_exit_of(status) : read_lines(t, &text);
  if (result == KT_DONE)
    write_model(t, modified, units, out);
  km_text_free(&text);
  km_free(t);
  return result;
}
