/* Poses from a CSV file: x, y, z and a quaternion w, x, y, z or a rotation vector; a column of times if it likes. */
#include "exchange/json/study/study_reader.h"

#include "base/file.h"

#include <stdio.h>
#include <string.h>

enum { MOST_COLUMNS = 16, X = 0, W = 3, QX = 4, RX = 7, TIME = 10, NOTHING = 11, MEANINGS = 12 };

typedef struct sheet {
  km_study_reader *s;
  const km_place *place;
  const char *file;
  int column[MEANINGS]; /* column of each meaning; −1: absent */
  int columns;
  int count; /* number of poses so far */
  km_frame_pose *poses;
  double *times, *turns;
  int *lines;
} sheet;

static void complain(const sheet *s, int line, int column, const char *what) {
  if (column > 0)
    km_reader_error(&s->s->reader, s->place, "%s, line %d, column %d: %s", s->file, line, column, what);
  else
    km_reader_error(&s->s->reader, s->place, "%s, line %d: %s", s->file, line, what);
}

/* Cuts a line at its commas; the number of fields, MOST_COLUMNS + 1 if there are more. */
static int cut(char *line, char **fields) {
  int count = 0;
  for (char *at = line; at; ++count) {
    if (count == MOST_COLUMNS)
      return MOST_COLUMNS + 1;
    fields[count] = at;
    at = strchr(at, ',');
    if (at)
      *at++ = '\0';
  }
  for (int i = 0; i < count; ++i) {
    fields[i] += strspn(fields[i], " \t\"");
    for (size_t n = strlen(fields[i]); n > 0 && strchr(" \t\r\"", fields[i][n - 1]);)
      fields[i][--n] = '\0';
  }
  return count;
}

static bool is_number(const char *text, double *out) {
  char *end;
  *out = km_number_read(text, &end);
  return end != text && *end == '\0';
}

/* Meaning of a header's word; a second x, y, z is the quaternion's. */
static int meaning_of(const sheet *s, const char *word) {
  static const char *const words[] = {"x", "y", "z", "w", NULL, NULL, NULL, "rx", "ry", "rz", "t"};
  char name[32];
  snprintf(name, sizeof name, "%.31s", word);
  name[strcspn(name, "_")] = '\0'; /* a unit */
  const char *plain = name[0] == 'q' && name[1] ? name + 1 : name;
  if (strcmp(name, "time") == 0)
    return TIME;
  for (int m = 0; m <= TIME; ++m)
    if (words[m] && strcmp(words[m], plain) == 0)
      return m <= 2 && (s->column[m] >= 0 || plain != name) ? QX + m : m;
  return NOTHING;
}

static bool read_header(sheet *s, char **fields, int count) {
  for (int i = 0; i < count; ++i) {
    int m = meaning_of(s, fields[i]);
    if (m == NOTHING || s->column[m] >= 0) {
      char what[160];
      snprintf(what, sizeof what, "\"%.40s\" is not a column; expected x,y,z and w,x,y,z or rx,ry,rz, and perhaps t",
               fields[i]);
      complain(s, 1, i + 1, what);
      return false;
    }
    s->column[m] = i;
  }
  return true;
}

/* Meaning by the number of columns, without a header. */
static void guess_columns(sheet *s, int count) {
  for (int k = 0; k < 3; ++k)
    s->column[X + k] = k;
  for (int k = 3; k < count; ++k)
    s->column[(count == 7 ? W : RX) + k - 3] = k;
}

/* A place, and all of a quaternion or all of a rotation vector, and nothing of the other. */
static bool complete(const sheet *s) {
  int place = 0, vector = 0, quaternion = s->column[W] >= 0;
  for (int k = 0; k < 3; ++k) {
    place += s->column[X + k] >= 0;
    quaternion += s->column[QX + k] >= 0;
    vector += s->column[RX + k] >= 0;
  }
  return place == 3 && ((quaternion == 4 && vector == 0) || (quaternion == 0 && vector == 3));
}

static bool read_turn(sheet *s, int line, const double *value) {
  const int *c = s->column;
  if (c[W] < 0) {
    for (int k = 0; k < 3; ++k)
      s->turns[3 * s->count + k] = value[c[RX + k]];
    return true;
  }
  km_quaternion q = {value[c[W]], value[c[QX]], value[c[QX + 1]], value[c[QX + 2]]};
  double norm = sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(fabs(norm - 1.0) <= 1e-3)) {
    char what[120];
    snprintf(what, sizeof what, "a quaternion of length %.6g; expected 1 (w first, then x, y, z)", norm);
    complain(s, line, 0, what);
    return false;
  }
  km_rotation R = km_quaternion_rotation(km_quaternion_normalised(q));
  km_rotation_rows(&R, s->poses[s->count].R);
  return true;
}

static bool read_time(sheet *s, int line, const double *value) {
  if (s->column[TIME] < 0)
    return true;
  double time = value[s->column[TIME]], before = s->count > 0 ? s->times[s->count - 1] : -(double)INFINITY;
  s->times[s->count] = time;
  if (time > before)
    return true;
  char what[100];
  snprintf(what, sizeof what, "time %.9g after %.9g; expected increasing times", time, before);
  complain(s, line, s->column[TIME] + 1, what);
  return false;
}

static bool add_pose(sheet *s, int line, const double *value) {
  for (int k = 0; k < 3; ++k)
    s->poses[s->count].p[k] = value[s->column[X + k]];
  s->lines[s->count] = line;
  if (!read_turn(s, line, value) || !read_time(s, line, value))
    return false;
  ++s->count;
  return true;
}

static int count_lines(const char *text) {
  int count = 1;
  for (; *text; ++text)
    count += *text == '\n';
  return count;
}

/* The first line that holds anything says what the columns mean, and may hold numbers at once. */
static bool read_columns(sheet *s, int line, char **fields, int found, bool *header) {
  double value;
  s->columns = found;
  *header = found <= MOST_COLUMNS && !is_number(fields[0], &value);
  if (*header && !read_header(s, fields, found))
    return false;
  if (!*header && (found == 6 || found == 7))
    guess_columns(s, found);
  if (!complete(s))
    complain(s, line, 0, "expected x,y,z and a quaternion w,x,y,z (7 columns) or a rotation vector (6 columns)");
  return complete(s);
}

static bool read_values(const sheet *s, int line, char **fields, int found, double *value) {
  char what[100];
  if (found != s->columns) {
    snprintf(what, sizeof what, "found %d columns; expected %d", found, s->columns);
    complain(s, line, 0, what);
    return false;
  }
  for (int i = 0; i < found; ++i)
    if (!is_number(fields[i], &value[i]) || !(fabs(value[i]) <= 1e60)) {
      snprintf(what, sizeof what, "found \"%.40s\"; expected a number", fields[i]);
      complain(s, line, i + 1, what);
      return false;
    }
  return true;
}

static bool read_line(sheet *s, int line, char *text) {
  char *fields[MOST_COLUMNS];
  double value[MOST_COLUMNS];
  bool header = false;
  if (text[strspn(text, " \t\r")] == '\0')
    return true;
  int found = cut(text, fields);
  if (s->columns == 0 && !read_columns(s, line, fields, found, &header))
    return false;
  return header || (read_values(s, line, fields, found, value) && add_pose(s, line, value));
}

static void read_lines(sheet *s, char *text) {
  size_t errors = km_messages_errors(s->s->reader.messages);
  bool fine = true;
  if (strncmp(text, "\xEF\xBB\xBF", 3) == 0)
    text += 3;
  int line = 1;
  for (char *next; text && *text && fine; text = next, ++line) {
    next = strchr(text, '\n');
    if (next)
      *next++ = '\0';
    fine = read_line(s, line, text);
  }
  if (s->count < 2 && km_messages_errors(s->s->reader.messages) == errors)
    km_reader_error(&s->s->reader, s->place, "%s holds %d pose%s; expected at least 2", s->file, s->count,
                    s->count == 1 ? "" : "s");
}

/* One spline whose samples are the poses. */
static void make_plan(sheet *s, km_study_path *out) {
  km_path_segment *segment = KM_ARENA_NEW(s->s->arena, km_path_segment, 1);
  if (!segment)
    return;
  *segment = km_path_segment_default(KM_PATH_SPLINE);
  segment->points = s->poses;
  segment->point_count = s->count;
  segment->times = s->column[TIME] >= 0 ? s->times : NULL;
  segment->own_start = segment->at_points = true;
  out->plan.segments = segment;
  out->plan.segment_count = 1;
  out->turns = s->column[W] < 0 ? s->turns : NULL;
  out->file = s->file;
  out->lines = s->lines;
}

static void read_text(sheet *s, char *text, km_study_path *out) {
  km_arena *arena = s->s->arena;
  size_t lines = (size_t)count_lines(text);
  s->poses = KM_ARENA_NEW(arena, km_frame_pose, lines);
  s->times = KM_ARENA_NEW(arena, double, lines);
  s->turns = KM_ARENA_NEW(arena, double, 3 * lines);
  s->lines = KM_ARENA_NEW(arena, int, lines);
  if (arena->failed)
    return;
  read_lines(s, text);
  make_plan(s, out);
}

void km_study_poses_of(km_study_reader *r, const char *file, km_study_path *out) {
  km_place path = {NULL, out->place.text, 0}, place = {&path, "csv", 0};
  sheet s = {.s = r, .place = &place, .file = km_arena_string(r->arena, file)};
  km_text text = {0};
  km_error error;
  for (int m = 0; m < MEANINGS; ++m)
    s.column[m] = -1;
  km_status status = km_file_read(file, &text, &error);
  if (status == KM_MEMORY || !s.file) {
    r->arena->failed = true;
  } else if (status) {
    km_reader_error(&r->reader, &place, "%s", error.text);
    r->reader.unreadable = true;
  } else if (text.size && strlen(text.data) < text.size) {
    km_reader_error(&r->reader, &place, "%s holds a NUL byte; expected text", file);
  } else if (text.size) {
    read_text(&s, text.data, out);
  } else {
    km_reader_error(&r->reader, &place, "%s is empty; expected poses", file);
  }
  km_text_free(&text);
}
