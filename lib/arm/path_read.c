/* The path of a study. */
#include "arm/study.h"

#include <string.h>

typedef struct builder {
  km_reader *reader;
  km_path *path;
  km_pose at;       /* where the path has come to */
  bool start_given; /* else the first spline may begin where it likes */
  const char *folder;
} builder;

enum { MOST_STEPS = 1000000 };

static km_vec3 place_of(const builder *b, const km_value *object, const char *key) {
  km_pose pose = {km_rotation_identity(), km_reader_vector(object, key)};
  return km_arm_from_model(b->path->arm, &pose).p;
}

static bool missing(builder *b, const km_value *g, const km_place *place, const char *key, const char *what) {
  if (km_value_get(g, key))
    return false;
  km_reader_error(b->reader, place, "\"%s\" is missing; expected %s", key, what);
  return true;
}

/* Where the segment's turn ends, as a rotation vector about a fixed axis. */
static km_vec3 turn_to(builder *b, const km_value *g, const km_place *place) {
  if (!km_value_get(g, "R_to"))
    return (km_vec3){0, 0, 0};
  km_rotation to = km_reader_rotation(b->reader, g, "R_to", place), back = km_rotation_inverse(&b->at.R);
  km_rotation difference = km_rotation_product(&to, &back);
  return km_quaternion_log(km_rotation_quaternion(&difference));
}

static void read_line(builder *b, const km_value *g, const km_place *place, km_segment *out) {
  out->kind = KM_SEGMENT_LINE;
  if (!km_value_get(g, "to") && !km_value_get(g, "R_to"))
    km_reader_error(b->reader, place, "expected \"to\" or \"R_to\": where the line leads");
  if (km_value_get(g, "to"))
    out->travel = km_vec3_sub(place_of(b, g, "to"), b->at.p);
  out->turn = turn_to(b, g, place);
}

static bool read_axis(builder *b, const km_value *g, const char *key, const km_place *place, km_vec3 *out) {
  km_place at = {place, key, 0};
  *out = km_reader_vector(g, key);
  double length = km_vec3_norm(*out);
  if (!(length > 0.0)) {
    km_reader_error(b->reader, &at, "found a vector of length 0; expected a direction");
    return false;
  }
  *out = km_vec3_scale(1.0 / length, *out);
  return true;
}

/* Arcs, circles and helices. */
static void read_helix(builder *b, const km_value *g, const km_place *place, const char *type, km_segment *out) {
  const km_arm *a = b->path->arm;
  bool circle = strcmp(type, "circle") == 0, helix = strcmp(type, "helix") == 0;
  out->kind = KM_SEGMENT_HELIX;
  bool faulty = missing(b, g, place, "center", "a point of the axis");
  faulty = missing(b, g, place, "axis", "the direction of the axis") || faulty;
  faulty = (!circle && missing(b, g, place, "angle", "how far to go round")) || faulty;
  faulty = (helix && missing(b, g, place, "pitch", "the travel along the axis of a turn")) || faulty;
  if (faulty || !read_axis(b, g, "axis", place, &out->axis))
    return;
  out->centre = place_of(b, g, "center");
  double unit = a->mechanism->model->units.angle->si;
  out->angle = circle ? 2.0 * M_PI : km_reader_number(g, "angle", 0.0) * unit;
  if (circle && km_value_get(g, "angle"))
    out->angle = km_reader_number(g, "angle", 0.0) * unit;
  out->rise = km_reader_number(g, "pitch", 0.0) / a->length * out->angle / (2.0 * M_PI);
  const km_value *turn = km_value_get(g, "turn");
  bool turns = turn && turn->number != 0.0;
  if (turns && km_value_get(g, "R_to"))
    km_reader_error(b->reader, place, "both \"turn\" and \"R_to\"; expected one of them");
  out->turn = turns ? km_vec3_scale(out->angle, out->axis) : turn_to(b, g, place);
  km_place at = {place, "angle", 0};
  if (!(fabs(out->angle) <= 2000.0 * M_PI))
    km_reader_error(b->reader, &at, "found more than 1000 turns");
}

static void read_weave(builder *b, const km_value *g, const km_place *place, km_segment *out) {
  km_vec3 sideways = {0, 0, 0};
  out->kind = KM_SEGMENT_WEAVE;
  bool faulty = missing(b, g, place, "to", "where the weave leads");
  faulty = missing(b, g, place, "amplitude", "how far it swings to either side") || faulty;
  faulty = missing(b, g, place, "waves", "how many swings there and back") || faulty;
  faulty = missing(b, g, place, "sideways", "the direction of the swings") || faulty;
  if (faulty || !read_axis(b, g, "sideways", place, &sideways))
    return;
  out->travel = km_vec3_sub(place_of(b, g, "to"), b->at.p);
  out->turn = turn_to(b, g, place);
  out->waves = km_reader_number(g, "waves", 1.0);
  out->sideways = km_vec3_scale(km_reader_number(g, "amplitude", 0.0) / b->path->arm->length, sideways);
  km_place at = {place, "waves", 0};
  if (!(out->waves > 0.0 && out->waves <= 1e4))
    km_reader_error(b->reader, &at, "found %s; expected a number above 0 up to 10000", KM_SHOWN(out->waves));
}

/* Knots by the times, or by the length of the chords; from 0 to 1. */
static bool set_knots(builder *b, km_segment *out, const km_pose *poses, const double *times, const km_place *points,
                      size_t first) {
  const km_model *model = b->path->arm->mechanism->model;
  km_place at = {points, NULL, 0};
  out->knot = KM_ARENA_NEW(&b->path->arena, double, (size_t)out->knots);
  for (int k = 1; out->knot && k < out->knots; ++k) {
    double way = km_poses_apart(&poses[k - 1], &poses[k]);
    at.index = (size_t)k - first;
    if (!(way > KM_SAME_POSE)) {
      km_reader_error(b->reader, &at, "the same pose as the one before; expected a way to go");
      return false;
    }
    if (times && !(times[k] > times[k - 1])) {
      km_reader_error(b->reader, &at, "time %s after %s; expected increasing times", KM_SHOWN(times[k]),
                      KM_SHOWN(times[k - 1]));
      return false;
    }
    out->knot[k] = out->knot[k - 1] + (times ? times[k] - times[k - 1] : way);
  }
  double last = out->knot ? out->knot[out->knots - 1] : 1.0;
  out->seconds = times ? last * model->units.time->si : 0.0;
  for (int k = 1; out->knot && k < out->knots; ++k)
    out->knot[k] /= last;
  return out->knot != NULL;
}

/* `first` knots stand before the list's first item. */
static void fit(builder *b, km_segment *out, const km_pose *poses, const double *times, const km_place *place,
                size_t first) {
  km_error error;
  if (!set_knots(b, out, poses, times, place, first))
    return;
  if (km_segment_fit(out, poses, &b->path->arena, &error))
    km_reader_error(b->reader, place, "%s", error.text);
}

/* Poses and times of a spline's points. The path's place comes first, unless the first point is that. */
static void read_spline(builder *b, const km_value *g, const km_place *place, bool first_segment, km_segment *out) {
  const km_value *list = km_value_get(g, "points");
  km_place points = {place, "points", 0}, item = {&points, NULL, 0};
  out->kind = KM_SEGMENT_SPLINE;
  if (missing(b, g, place, "points", "the poses that the spline goes through"))
    return;
  km_pose *poses = KM_ARENA_NEW(&b->path->arena, km_pose, list->count + 1);
  double *times = KM_ARENA_NEW(&b->path->arena, double, list->count + 1);
  if (!poses || !times)
    return;
  size_t timed = 0, count = 0;
  poses[0] = b->at;
  for (const km_value *v = list->first; v; v = v->next, ++item.index) {
    km_pose *pose = &poses[++count];
    pose->p = place_of(b, v, "T");
    pose->R = km_value_get(v, "R") ? km_reader_rotation(b->reader, v, "R", &item) : poses[count - 1].R;
    timed += km_value_get(v, "time") != NULL;
    times[count] = km_reader_number(v, "time", 0.0);
  }
  if (timed && timed < count) {
    km_reader_error(b->reader, &points, "%zu of %zu points have a \"time\"; expected all or none", timed, count);
    return;
  }
  bool there = count > 0 && km_poses_apart(&poses[0], &poses[1]) <= 1e-6;
  bool own_start = there || (count > 0 && first_segment && !b->start_given && !(timed && times[1] > 0.0));
  if (count < (own_start ? 2u : 1u)) {
    km_reader_error(b->reader, &points, "found %zu points; expected at least %d", count, own_start ? 2 : 1);
    return;
  }
  out->knots = (int)count + !own_start;
  fit(b, out, poses + own_start, timed ? times + own_start : NULL, &points, !own_start);
  if (own_start && !there)
    b->at = poses[1];
}

static int read_steps(builder *b, const km_value *g, const km_place *place) {
  double steps = km_reader_number(g, "steps", 100.0);
  km_place at = {place, "steps", 0};
  if (steps >= 1.0 && steps <= MOST_STEPS && steps == floor(steps))
    return (int)steps;
  km_reader_error(b->reader, &at, "found %s; expected a whole number from 1 to %d", KM_SHOWN(steps), MOST_STEPS);
  return 1;
}

static void read_segment(builder *b, const km_value *g, const km_place *place, bool first, km_segment *out) {
  const char *type = km_reader_string(g, "type");
  km_place at = {place, "type", 0};
  *out = (km_segment){.steps = read_steps(b, g, place)};
  if (strcmp(type, "line") == 0)
    read_line(b, g, place, out);
  else if (strcmp(type, "arc") == 0 || strcmp(type, "circle") == 0 || strcmp(type, "helix") == 0)
    read_helix(b, g, place, type, out);
  else if (strcmp(type, "weave") == 0)
    read_weave(b, g, place, out);
  else if (strcmp(type, "spline") == 0)
    read_spline(b, g, place, first, out);
  else
    km_reader_error(b->reader, &at,
                    "\"%.40s\" is not a kind of segment; expected line, arc, circle, helix, weave or spline", type);
  out->start = out->kind == KM_SEGMENT_SPLINE ? out->start : b->at;
}

/* Each segment begins where the one before ends; what is wrong with one spares the rest. */
static void read_segments(builder *b, const km_value *list, const km_place *place) {
  km_path *path = b->path;
  km_place at = {place, "segments", 0}, item = {&at, NULL, 0};
  path->segments = KM_ARENA_NEW(&path->arena, km_segment, list->count);
  if (list->count == 0)
    km_reader_error(b->reader, &at, "found none; expected at least one segment");
  double steps = 0.0;
  for (const km_value *v = list->first; v && path->segments; v = v->next, ++item.index) {
    size_t errors = km_messages_errors(b->reader->messages);
    km_segment *segment = &path->segments[path->segment_count++];
    read_segment(b, v, &item, item.index == 0, segment);
    if (km_messages_errors(b->reader->messages) > errors)
      return;
    km_twist rate;
    b->at = km_segment_pose(segment, 1.0, &rate);
    steps += segment->steps;
  }
  if (steps > MOST_STEPS)
    km_reader_error(b->reader, &at, "found %s steps in all; expected at most %d", KM_SHOWN(steps), MOST_STEPS);
}

static void read_csv(builder *b, const km_value *path, const km_place *place) {
  km_path *out = b->path;
  km_place at = {place, "csv", 0};
  km_pose *poses;
  double *times;
  km_text file = {0};
  const char *name = km_reader_string(path, "csv");
  km_text_format(&file, "%s%s%s", name[0] == '/' ? "" : b->folder, name[0] == '/' || !b->folder[0] ? "" : "/", name);
  int count = file.failed ? 0 : km_poses_read(b->reader, out->arm, file.data, &at, &out->arena, &poses, &times);
  km_text_free(&file);
  out->segments = KM_ARENA_NEW(&out->arena, km_segment, 1);
  if (!count || !out->segments)
    return;
  out->segment_count = 1;
  out->segments[0] = (km_segment){.kind = KM_SEGMENT_SPLINE, .steps = count - 1, .knots = count, .at_knots = true};
  fit(b, &out->segments[0], poses, times, &at, 0);
}

static km_pose read_start(builder *b, const km_value *start, const km_place *place) {
  km_place at = {place, "start", 0};
  km_pose pose = b->at;
  if (km_value_get(start, "T"))
    pose.p = place_of(b, start, "T");
  if (km_value_get(start, "R"))
    pose.R = km_reader_rotation(b->reader, start, "R", &at);
  return pose;
}

/* A speed in the model's units, over `unit` a second; `otherwise` if the path doesn't say. */
static double read_speed(builder *b, const km_value *value, const km_place *place, const char *key, double unit,
                         double otherwise) {
  if (!km_value_get(value, key))
    return otherwise;
  double speed = km_reader_number(value, key, 1.0);
  km_reader_positive(b->reader, place, key, speed);
  return speed * unit / b->path->arm->mechanism->model->units.time->si;
}

km_path *km_path_read(km_reader *reader, const km_arm *arm, const km_value *value, const km_place *place,
                      const km_pose *here, const char *folder) {
  size_t errors = km_messages_errors(reader->messages);
  builder b = {.reader = reader, .path = KM_NEW(km_path, 1), .at = *here, .folder = folder};
  if (!b.path)
    return NULL;
  b.path->arm = arm;
  const km_value *start = km_value_get(value, "start"), *segments = km_value_get(value, "segments");
  if ((segments != NULL) == (km_value_get(value, "csv") != NULL))
    km_reader_error(reader, place, "expected either \"segments\" or \"csv\"");
  b.path->speed = read_speed(&b, value, place, "speed", 1.0 / arm->length, 1.0);
  b.path->turn_speed = read_speed(&b, value, place, "turn_speed", arm->mechanism->model->units.angle->si, 0.0);
  b.start_given = start != NULL;
  if (start)
    b.at = read_start(&b, start, place);
  if (segments && km_messages_errors(reader->messages) == errors)
    read_segments(&b, segments, place);
  else if (km_messages_errors(reader->messages) == errors)
    read_csv(&b, value, place);
  km_error error;
  int which = 0;
  if (km_messages_errors(reader->messages) == errors && km_path_finish(b.path, &which, &error)) {
    km_place list = {place, segments ? "segments" : "csv", 0}, item = {&list, NULL, (size_t)which};
    km_reader_error(reader, segments ? &item : &list, "%s", error.text);
  }
  if (km_messages_errors(reader->messages) == errors && !b.path->arena.failed)
    return b.path;
  km_path_free(b.path);
  return NULL;
}
