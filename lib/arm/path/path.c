/* Samples and arc lengths of a path. */
#include "arm/path/path.h"

#include <stdlib.h>

/* Lengths over a stretch of u, or rates: dσ, and what it is made of. */
typedef struct stretch {
  double s, travel, turn;
} stretch;

/* What the task counts of a rate. */
static stretch counted(const km_arm *arm, const km_pose *pose, km_twist rate) {
  double rows[KM_ARM_ROWS], travel = 0.0, turn = 0.0;
  km_arm_all_task_rows(arm, &pose->R, rate, rows);
  for (int r = 0; r < 3; ++r)
    travel += rows[r] * rows[r];
  for (int r = 3; r < arm->task_rows; ++r)
    turn += rows[r] * rows[r];
  return (stretch){sqrt(travel + turn), sqrt(travel), sqrt(turn)};
}

static stretch rate_at(const km_path *path, const km_segment *segment, double u) {
  km_twist rate;
  km_pose pose = km_segment_pose(segment, u, &rate);
  return counted(path->arm, &pose, rate);
}

/* From u0 to u1, by panels of Gauss and Legendre's rule of five points. */
static stretch sum_panels(const km_path *path, const km_segment *segment, double u0, double u1, int panels) {
  static const double at[5] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
  static const double weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                   0.2369268850561891};
  double h = (u1 - u0) / (2 * panels);
  stretch sum = {0.0, 0.0, 0.0};
  for (int p = 0; p < panels; ++p)
    for (int k = 0; k < 5; ++k) {
      stretch rate = rate_at(path, segment, u0 + h * (2 * p + 1 + at[k]));
      sum.s += h * weight[k] * rate.s;
      sum.travel += h * weight[k] * rate.travel;
      sum.turn += h * weight[k] * rate.turn;
    }
  return sum;
}

/* Twice as many panels until they change nothing: splines bend sharply, and have knots between samples. */
static stretch measure(const km_path *path, const km_segment *segment, double u0, double u1) {
  enum { PANELS = 4, MOST_PANELS = 256 };
  stretch sum = sum_panels(path, segment, u0, u1, PANELS), coarse;
  int panels = PANELS;
  bool bends = segment->kind == KM_SEGMENT_SPLINE || segment->kind == KM_SEGMENT_WEAVE;
  do {
    coarse = sum;
    panels *= 2;
    sum = bends ? sum_panels(path, segment, u0, u1, panels) : coarse;
  } while (panels < MOST_PANELS &&
           fabs(sum.travel - coarse.travel) + fabs(sum.turn - coarse.turn) + fabs(sum.s - coarse.s) > 1e-10 * sum.s);
  return sum;
}

/* Radians a second; without the path's own, where the origin stands still, one. */
static double turn_speed(const km_path *path) {
  return path->turn_speed > 0.0 ? path->turn_speed : 1.0;
}

/* The slower of travel and turn sets the time of an interval. */
static km_pace pace_of(const km_path *path, const km_segment *segment, stretch way) {
  if (segment->seconds > 0.0)
    return KM_PACE_TIMES;
  if (way.travel <= 1e-9 * way.s)
    return KM_PACE_TURN;
  bool limits = path->turn_speed > 0.0 && way.turn / path->turn_speed > way.travel / path->speed;
  return limits ? KM_PACE_TURN : KM_PACE_TRAVEL;
}

/* Seconds that a stretch takes at a pace; du is its part of the segment. */
static double seconds_of(const km_path *path, const km_segment *segment, km_pace pace, stretch way, double du) {
  if (pace == KM_PACE_TIMES)
    return segment->seconds * du;
  return pace == KM_PACE_TURN ? way.turn / turn_speed(path) : way.travel / path->speed;
}

/* The point at u within an interval of that pace, which is `way` long and takes `seconds`. */
static km_path_point point_of(const km_path *path, const km_segment *segment, double u, km_pace pace, stretch way,
                              double seconds) {
  km_path_point point = {.s = 0.0};
  km_twist rate;
  point.pose = km_segment_pose(segment, u, &rate);
  stretch here = counted(path->arm, &point.pose, rate);
  double dt = seconds_of(path, segment, pace, here, 1.0), mean = way.s / seconds;
  /* At a cusp the origin stands for an instant while the effector turns: there the interval's mean counts. */
  point.speed = here.s <= 10.0 * mean * dt ? here.s / dt : mean;
  if (here.s == 0.0)
    point.speed = 0.0;
  if (here.s < 1e-9 * segment->length) { /* its direction is that a little further inside */
    km_segment_pose(segment, u < 0.5 ? u + 1e-6 : u - 1e-6, &rate);
    here = counted(path->arm, &point.pose, rate);
  }
  double scale = here.s > 0.0 ? 1.0 / here.s : 0.0;
  point.twist = (km_twist){km_vec3_scale(scale, rate.v), km_vec3_scale(scale, rate.w)};
  return point;
}

static double u_at(const km_segment *segment, int k) {
  return segment->at_knots ? segment->knot[k] : (double)k / segment->steps;
}

static const km_segment *segment_at(const km_path *path, int i) {
  return &path->segments[path->segment_of[i]];
}

km_path_point km_path_at(const km_path *path, int i, double fraction) {
  const km_segment *segment = segment_at(path, i);
  const km_path_point *a = &path->points[i], *b = &path->points[i + 1];
  if (fraction <= 0.0)
    return *a;
  double u0 = u_at(segment, i - segment->first), u1 = u_at(segment, i + 1 - segment->first);
  double u = u0 + fraction * (u1 - u0);
  stretch all = {b->s - a->s, b->travel - a->travel, b->turn - a->turn};
  stretch part = {all.s * fraction, all.travel * fraction, all.turn * fraction};
  if (segment->kind == KM_SEGMENT_SPLINE || segment->kind == KM_SEGMENT_WEAVE)
    part = measure(path, segment, u0, u);
  km_path_point point = point_of(path, segment, u, path->pace[i], all, b->t - a->t);
  point.s = a->s + part.s;
  point.travel = a->travel + part.travel;
  point.turn = a->turn + part.turn;
  point.t = a->t + seconds_of(path, segment, path->pace[i], part, u - u0);
  return point;
}

/* Samples of one segment; false if it doesn't move. A sample's speed is that of the interval which it begins. */
static bool sample(km_path *path, int index) {
  km_segment *segment = &path->segments[index];
  km_path_point last = path->points[segment->first];
  segment->length = measure(path, segment, 0.0, 1.0).s;
  if (!(segment->length > 1e-9))
    return false;
  for (int k = 0; k < segment->steps; ++k) {
    double u = u_at(segment, k), end = u_at(segment, k + 1);
    stretch way = measure(path, segment, u, end);
    if (!(way.s > 1e-12 * segment->length))
      return false;
    km_pace pace = pace_of(path, segment, way);
    double seconds = seconds_of(path, segment, pace, way, end - u);
    for (int side = 0; side < 2; ++side) {
      int i = segment->first + k + side;
      km_path_point *point = &path->points[i];
      *point = point_of(path, segment, side ? end : u, pace, way, seconds);
      point->s = last.s + side * way.s;
      point->travel = last.travel + side * way.travel;
      point->turn = last.turn + side * way.turn;
      point->t = last.t + side * seconds;
      path->segment_of[i] = index;
      path->pace[i] = pace;
    }
    last = path->points[segment->first + k + 1];
  }
  return true;
}

km_status km_path_finish(km_path *path, int *which, km_error *error) {
  int steps = 0;
  for (int i = 0; i < path->segment_count; ++i) {
    path->segments[i].first = steps;
    steps += path->segments[i].steps;
  }
  path->samples = steps + 1;
  path->points = KM_ARENA_NEW(&path->arena, km_path_point, (size_t)path->samples);
  path->segment_of = KM_ARENA_NEW(&path->arena, int, (size_t)path->samples);
  path->pace = KM_ARENA_NEW(&path->arena, km_pace, (size_t)path->samples);
  if (path->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a path of %d steps", steps);
  for (*which = 0; *which < path->segment_count; ++*which)
    if (!sample(path, *which))
      return km_fail(error, KM_USAGE, "the effector doesn't move on it; expected a way to go");
  return KM_OK;
}

double km_poses_apart(const km_pose *a, const km_pose *b) {
  km_rotation back = km_rotation_inverse(&a->R), difference = km_rotation_product(&b->R, &back);
  km_vec3 turn = km_quaternion_log(km_rotation_quaternion(&difference)), way = km_vec3_sub(b->p, a->p);
  return sqrt(km_vec3_dot(way, way) + km_vec3_dot(turn, turn));
}

void km_path_free(km_path *path) {
  if (!path)
    return;
  for (int i = 0; i < path->segment_count && path->segments; ++i)
    for (int k = 0; k < 3; ++k)
      if (path->segments[i].spline[k])
        gsl_spline_free(path->segments[i].spline[k]);
  km_arena_free(&path->arena);
  km_free(path);
}

int km_path_samples(const km_path *path) {
  if (!path)
    return 0;
  return path->samples;
}

double km_path_length(const km_path *path, int i) {
  if (!path || i < 0 || i >= path->samples)
    return nan("");
  return path->points[i].s * path->arm->length;
}

double km_path_travel(const km_path *path, int i) {
  if (!path || i < 0 || i >= path->samples)
    return nan("");
  return path->points[i].travel * path->arm->length;
}

double km_path_turn(const km_path *path, int i) {
  if (!path || i < 0 || i >= path->samples)
    return nan("");
  return path->points[i].turn;
}

double km_path_time(const km_path *path, int i) {
  if (!path || i < 0 || i >= path->samples)
    return nan("");
  return path->points[i].t;
}

void km_path_pose(const km_path *path, int i, km_frame_pose *out) {
  if (!out)
    return;
  if (!path || i < 0 || i >= path->samples) {
    for (int k = 0; k < 12; ++k)
      *(k < 9 ? &out->R[k] : &out->p[k - 9]) = nan("");
    return;
  }
  km_pose pose = km_arm_to_model(path->arm, &path->points[i].pose);
  km_pose_write(&pose, out);
}
