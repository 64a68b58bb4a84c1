/* The path of a study: its segments as a plan, in the units in which they are written. */
#include "exchange/json/study/study_reader.h"

#include "model/path_study/path_plan.h"

#include <string.h>

/* A segment that is being read. */
typedef struct segment_reader {
  km_study_reader *s;
  const km_value *from;
  const km_place *place;
  bool may_jump; /* the path's first, without a start: a spline may begin where it likes */
  km_path_segment *out;
} segment_reader;

static bool given(const segment_reader *r, const char *key) {
  return km_value_get(r->from, key) != NULL;
}

static bool missing(segment_reader *r, const char *key, const char *what) {
  if (given(r, key))
    return false;
  km_reader_error(&r->s->reader, r->place, "\"%s\" is missing; expected %s", key, what);
  return true;
}

static void read_vector(const km_value *from, const char *key, double out[3]) {
  km_vec3 v = km_reader_vector(from, key);
  km_vec3_write(v, out);
}

/* True if a rotation is stated. */
static bool read_rotation(km_study_reader *s, const km_value *from, const char *key, const km_place *place,
                          double out[9]) {
  if (!km_value_get(from, key))
    return false;
  km_rotation R = km_reader_rotation(&s->reader, from, key, place);
  km_rotation_rows(&R, out);
  return true;
}

static void read_line(segment_reader *r) {
  r->out->in_place = !given(r, "to");
  if (!given(r, "to") && !given(r, "R_to"))
    km_reader_error(&r->s->reader, r->place, "expected \"to\" or \"R_to\": where the line leads");
}

static void read_arc(segment_reader *r) {
  const char *type = km_reader_string(r->from, "type");
  bool circle = strcmp(type, "circle") == 0;
  missing(r, "center", "a point of the axis");
  missing(r, "axis", "the direction of the axis");
  if (!circle)
    missing(r, "angle", "how far to go round");
  if (strcmp(type, "helix") == 0)
    missing(r, "pitch", "the travel along the axis of a turn");
  r->out->full_turn = circle && !given(r, "angle");
  const km_value *turn = km_value_get(r->from, "turn");
  r->out->turns_along = turn && turn->number != 0.0;
  if (r->out->turns_along && r->out->turns)
    km_reader_error(&r->s->reader, r->place, "both \"turn\" and \"R_to\"; expected one of them");
}

static void read_weave(segment_reader *r) {
  missing(r, "to", "where the weave leads");
  missing(r, "amplitude", "how far it swings to either side");
  missing(r, "waves", "how many swings there and back");
  missing(r, "sideways", "the direction of the swings");
}

/* Points without a rotation keep that of the point before; the first ones that with which the path comes. */
static void read_points(segment_reader *r, const km_value *list, const km_place *place) {
  km_path_segment *out = r->out;
  km_place item = {place, NULL, 0};
  km_frame_pose *points = KM_ARENA_NEW(r->s->arena, km_frame_pose, list->count + 1);
  double *times = KM_ARENA_NEW(r->s->arena, double, list->count + 1);
  if (!points || !times)
    return;
  int timed = 0, count = 0;
  bool turned = false;
  for (const km_value *v = list->first; v; v = v->next, ++item.index, ++count) {
    read_vector(v, "T", points[count].p);
    if (turned)
      memcpy(points[count].R, points[count - 1].R, sizeof points[count].R);
    turned = read_rotation(r->s, v, "R", &item, points[count].R) || turned;
    out->unturned += !turned;
    timed += km_value_get(v, "time") != NULL;
    times[count] = km_reader_number(v, "time", 0.0);
  }
  if (timed && timed < count)
    km_reader_error(&r->s->reader, place, "%d of %d points have a \"time\"; expected all or none", timed, count);
  out->points = points;
  out->point_count = count;
  out->times = timed ? times : NULL;
  out->own_start = count > 0 && r->may_jump && !(timed && times[0] > 0.0);
}

static void read_spline(segment_reader *r) {
  km_place points = {r->place, "points", 0};
  if (!missing(r, "points", "the poses that the spline goes through"))
    read_points(r, km_value_get(r->from, "points"), &points);
}

static void read_steps(segment_reader *r) {
  double steps = km_reader_number(r->from, "steps", r->out->steps);
  km_place at = {r->place, "steps", 0};
  if (steps >= 1.0 && steps <= KM_PATH_STEPS && steps == floor(steps))
    r->out->steps = (int)steps;
  else
    km_reader_error(&r->s->reader, &at, "found %s; expected a whole number from 1 to %d", KM_SHOWN(steps),
                    KM_PATH_STEPS);
}

static const struct {
  const char *word;
  km_path_shape shape;
  void (*read)(segment_reader *r);
} kinds[] = {{"line", KM_PATH_LINE, read_line},    {"arc", KM_PATH_ARC, read_arc},
             {"circle", KM_PATH_ARC, read_arc},    {"helix", KM_PATH_ARC, read_arc},
             {"weave", KM_PATH_WEAVE, read_weave}, {"spline", KM_PATH_SPLINE, read_spline}};

/* Optional keys of all kinds, and required keys of each kind. */
static void read_members(segment_reader *r, int kind) {
  km_path_segment *out = r->out;
  *out = km_path_segment_default(kinds[kind].shape);
  read_steps(r);
  read_vector(r->from, "to", out->to);
  read_vector(r->from, "center", out->center);
  read_vector(r->from, "axis", out->axis);
  read_vector(r->from, "sideways", out->sideways);
  out->turns = read_rotation(r->s, r->from, "R_to", r->place, out->R);
  out->angle = km_reader_number(r->from, "angle", 0.0);
  out->pitch = km_reader_number(r->from, "pitch", 0.0);
  out->amplitude = km_reader_number(r->from, "amplitude", 0.0);
  out->waves = km_reader_number(r->from, "waves", 1.0);
  kinds[kind].read(r);
}

static void read_segment(segment_reader *r) {
  const char *type = km_reader_string(r->from, "type");
  km_place at = {r->place, "type", 0};
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k)
    if (strcmp(type, kinds[k].word) == 0) {
      read_members(r, (int)k);
      return;
    }
  km_reader_error(&r->s->reader, &at,
                  "\"%.40s\" is not a kind of segment; expected line, arc, circle, helix, weave or spline", type);
}

/* Checks the numbers of a complete plan. */
static void check_plan(km_study_reader *s, const km_study_path *path) {
  km_path_fault fault;
  km_error error;
  char where[KM_PATH_FAULT_TEXT];
  if (km_path_plan_check(&path->plan, &fault, &error))
    km_messages_add(s->reader.messages, KM_ERROR, "%s.%s: %s", path->place.text, km_path_fault_text(&fault, where),
                    error.text);
}

static void read_segments(km_study_reader *s, const km_value *list, const km_place *place, bool may_jump,
                          km_study_path *out) {
  size_t errors = km_messages_errors(s->reader.messages);
  km_place at = {place, "segments", 0}, item = {&at, NULL, 0};
  km_path_segment *segments = KM_ARENA_NEW(s->arena, km_path_segment, list->count + 1);
  if (!segments)
    return;
  for (const km_value *v = list->first; v; v = v->next, ++item.index) {
    segment_reader r = {s, v, &item, may_jump && item.index == 0, &segments[item.index]};
    read_segment(&r);
  }
  out->plan.segments = segments;
  out->plan.segment_count = (int)list->count;
  if (km_messages_errors(s->reader.messages) == errors)
    check_plan(s, out);
}

static void read_start(km_study_reader *s, const km_value *start, const km_place *place, km_study_path *out) {
  km_place at = {place, "start", 0};
  out->start_p = km_value_get(start, "T") != NULL;
  read_vector(start, "T", out->plan.start.p);
  out->start_R = read_rotation(s, start, "R", &at, out->plan.start.R);
}

/* 0 if the path doesn't say, or what it says is wrong. */
static double read_speed(km_study_reader *s, const km_value *value, const km_place *place, const char *key) {
  if (!km_value_get(value, key))
    return 0.0;
  double speed = km_reader_number(value, key, 0.0);
  km_reader_positive(&s->reader, place, key, speed);
  return speed > 0.0 ? speed : 0.0;
}

static void read_csv(km_study_reader *s, const km_value *value, km_study_path *out) {
  const char *name = km_reader_string(value, "csv"), *folder = name[0] == '/' ? "" : s->folder;
  km_text file = {0};
  km_text_format(&file, "%s%s%s", folder, folder[0] ? "/" : "", name);
  const char *kept = km_text_move_to_arena(&file, s->arena);
  if (kept)
    km_study_poses_of(s, kept, out);
}

void km_study_path_of(km_study_reader *s, const km_value *value, km_study_path *out) {
  km_place place = {NULL, out->place.text, 0};
  const km_value *start = km_value_get(value, "start"), *segments = km_value_get(value, "segments");
  bool csv = km_value_get(value, "csv") != NULL;
  if ((segments != NULL) == csv)
    km_reader_error(&s->reader, &place, "expected either \"segments\" or \"csv\"");
  out->plan.speed = read_speed(s, value, &place, "speed");
  out->plan.turn_speed = read_speed(s, value, &place, "turn_speed");
  if (start)
    read_start(s, start, &place, out);
  if (segments && !csv)
    read_segments(s, segments, &place, !start, out);
  else if (csv && !segments)
    read_csv(s, value, out);
}
