/* Poses from a CSV file: x, y, z and a quaternion w, x, y, z or a rotation vector; a column of times if it likes. */
#include "arm/study.h"
#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_COLUMNS = 16, X = 0, W = 3, QX = 4, RX = 7, TIME = 10, NOTHING = 11, MEANINGS = 12 };

typedef struct sheet {
  km_reader *reader;
  const km_place *place;
  const char *file;
  int column[MEANINGS]; /* of each meaning, −1: absent */
  int columns;
} sheet;

static void complain(const sheet *s, int line, int column, const char *what) {
  if (column > 0)
    km_reader_error(s->reader, s->place, "%s, line %d, column %d: %s", s->file, line, column, what);
  else
    km_reader_error(s->reader, s->place, "%s, line %d: %s", s->file, line, what);
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
  *out = strtod(text, &end);
  return end != text && *end == '\0';
}

/* What a header's word means; x, y, z the second time are the quaternion's. */
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

/* Without a header the number of columns tells. */
static void guess_columns(sheet *s, int count) {
  for (int k = 0; k < 3; ++k)
    s->column[X + k] = k;
  for (int k = 3; k < count; ++k)
    s->column[(count == 7 ? W : RX) + k - 3] = k;
}

static bool whole(const sheet *s) {
  bool quaternion = true, vector = true, place = true;
  for (int k = 0; k < 3; ++k) {
    place = place && s->column[X + k] >= 0;
    quaternion = quaternion && s->column[QX + k] >= 0;
    vector = vector && s->column[RX + k] >= 0;
  }
  quaternion = quaternion && s->column[W] >= 0;
  return place && quaternion != vector;
}

static bool read_row(const sheet *s, const km_arm *arm, int line, const double *value, km_pose *out) {
  const int *c = s->column;
  km_pose pose = {km_rotation_identity(), {value[c[X]], value[c[X + 1]], value[c[X + 2]]}};
  if (c[W] >= 0) {
    km_quaternion q = {value[c[W]], value[c[QX]], value[c[QX + 1]], value[c[QX + 2]]};
    double norm = sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!(fabs(norm - 1.0) <= 1e-3)) {
      char what[120];
      snprintf(what, sizeof what, "a quaternion of length %.6g; expected 1 (w first, then x, y, z)", norm);
      complain(s, line, 0, what);
      return false;
    }
    pose.R = km_quaternion_rotation(km_quaternion_normalised(q));
  } else {
    double unit = arm->mechanism->model->units.angle->si;
    km_vec3 v = {value[c[RX]] * unit, value[c[RX + 1]] * unit, value[c[RX + 2]] * unit};
    pose.R = km_quaternion_rotation(km_quaternion_exp(v));
  }
  *out = km_arm_from_model(arm, &pose);
  return true;
}

static int count_lines(const char *text) {
  int count = 1;
  for (; *text; ++text)
    count += *text == '\n';
  return count;
}

/* Is there a way, and time, from the pose before to this one? */
static bool goes_on(const sheet *s, int line, const km_pose *poses, const double *times, int index) {
  if (index == 0)
    return true;
  if (!(km_poses_apart(&poses[index - 1], &poses[index]) > KM_SAME_POSE)) {
    complain(s, line, 0, "the same pose as the one before; expected a way to go");
    return false;
  }
  if (s->column[TIME] < 0 || times[index] > times[index - 1])
    return true;
  char what[100];
  snprintf(what, sizeof what, "time %.9g after %.9g; expected increasing times", times[index], times[index - 1]);
  complain(s, line, s->column[TIME] + 1, what);
  return false;
}

static int read_lines(sheet *s, const km_arm *arm, char *text, km_pose *poses, double *times) {
  int count = 0, line = 1;
  if (strncmp(text, "\xEF\xBB\xBF", 3) == 0)
    text += 3;
  for (char *next; text && *text; text = next, ++line) {
    char *fields[MOST_COLUMNS];
    double value[MOST_COLUMNS];
    next = strchr(text, '\n');
    if (next)
      *next++ = '\0';
    if (text[strspn(text, " \t\r")] == '\0')
      continue;
    int found = cut(text, fields);
    if (s->columns == 0) {
      s->columns = found;
      bool header = found <= MOST_COLUMNS && !is_number(fields[0], &value[0]);
      if (header && !read_header(s, fields, found))
        return 0;
      if (!header && (found == 6 || found == 7))
        guess_columns(s, found);
      if (!whole(s)) {
        complain(s, line, 0, "expected x,y,z and a quaternion w,x,y,z (7 columns) or a rotation vector (6 columns)");
        return 0;
      }
      if (header)
        continue;
    }
    if (found != s->columns) {
      char what[80];
      snprintf(what, sizeof what, "found %d columns; expected %d", found, s->columns);
      complain(s, line, 0, what);
      return 0;
    }
    for (int i = 0; i < found; ++i)
      if (!is_number(fields[i], &value[i]) || !(fabs(value[i]) <= 1e60)) {
        char what[100];
        snprintf(what, sizeof what, "found \"%.40s\"; expected a number", fields[i]);
        complain(s, line, i + 1, what);
        return 0;
      }
    if (!read_row(s, arm, line, value, &poses[count]))
      return 0;
    times[count] = s->column[TIME] >= 0 ? value[s->column[TIME]] : 0.0;
    if (!goes_on(s, line, poses, times, count))
      return 0;
    ++count;
  }
  return count;
}

int km_poses_read(km_reader *reader, const km_arm *arm, const char *file, const km_place *place, km_arena *arena,
                  km_pose **poses, double **times) {
  sheet s = {.reader = reader, .place = place, .file = file};
  km_text text = {0};
  km_error error;
  int count = 0;
  for (int m = 0; m < MEANINGS; ++m)
    s.column[m] = -1;
  if (km_file_read(file, &text, &error)) {
    km_reader_error(reader, place, "%s", error.text);
    reader->unreadable = true;
  } else if (text.size && strlen(text.data) < text.size) {
    km_reader_error(reader, place, "%s holds a NUL byte; expected text", file);
  } else if (text.size) {
    size_t lines = (size_t)count_lines(text.data);
    *poses = KM_ARENA_NEW(arena, km_pose, lines);
    *times = KM_ARENA_NEW(arena, double, lines);
    size_t errors = km_messages_errors(reader->messages);
    count = arena->failed ? 0 : read_lines(&s, arm, text.data, *poses, *times);
    if (count < 2 && km_messages_errors(reader->messages) == errors)
      km_reader_error(reader, place, "%s holds %d poses; expected at least 2", file, count);
    count = count < 2 ? 0 : count;
    if (s.column[TIME] < 0)
      *times = NULL;
  } else {
    km_reader_error(reader, place, "%s is empty; expected poses", file);
  }
  km_text_free(&text);
  return count;
}
