/* Samples of a path: metric, travel, turn and time of every interval, and the unit twist at every sample
 * (docs/theory.md 12.2).
 *
 *   ds = sqrt(|dp/L|² + dθ²), by Gauss-Legendre panels;   time = max(travel/speed, turn/turn_speed) */
#include "arm/path/path.h"

#include <stdlib.h>

/* Lengths over an interval of u, or rates by u: metric σ, travel of the origin, counted rotation. */
typedef struct path_lengths {
  double s, travel, turn;
} path_lengths;

/* Metric, travel and turn of a twist, as the task counts them. */
static path_lengths counted_lengths(const km_arm *arm, const km_pose *pose, km_twist rate) {
  double rows[KM_ARM_ROWS], travel = 0.0, turn = 0.0;
  km_arm_all_task_rows(arm, &pose->R, rate, rows);
  for (int r = 0; r < 3; ++r)
    travel += rows[r] * rows[r];
  for (int r = 3; r < arm->task_rows; ++r)
    turn += rows[r] * rows[r];
  return (path_lengths){sqrt(travel + turn), sqrt(travel), sqrt(turn)};
}

static path_lengths rate_at(const km_path *path, const km_segment *segment, double u) {
  km_twist rate;
  km_pose pose = km_segment_pose(segment, u, &rate);
  return counted_lengths(path->arm, &pose, rate);
}

/* Integrates from u0 to u1 by panels of the five-point Gauss-Legendre rule. */
static path_lengths sum_panels(const km_path *path, const km_segment *segment, double u0, double u1, int panels) {
  static const double at[5] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
  static const double weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                   0.2369268850561891};
  double h = (u1 - u0) / (2 * panels);
  path_lengths sum = {0.0, 0.0, 0.0};
  for (int p = 0; p < panels; ++p)
    for (int k = 0; k < 5; ++k) {
      path_lengths rate = rate_at(path, segment, u0 + h * (2 * p + 1 + at[k]));
      sum.s += h * weight[k] * rate.s;
      sum.travel += h * weight[k] * rate.travel;
      sum.turn += h * weight[k] * rate.turn;
    }
  return sum;
}

/* Lengths from u0 to u1; for splines and weaves, the panels are doubled until the sums change by less than 1e-10. */
static path_lengths measure_lengths(const km_path *path, const km_segment *segment, double u0, double u1) {
  enum { PANELS = 4, MAX_PANELS = 256 };
  path_lengths sum = sum_panels(path, segment, u0, u1, PANELS), coarse;
  int panels = PANELS;
  bool correction_count = segment->kind == KM_SEGMENT_SPLINE || segment->kind == KM_SEGMENT_WEAVE;
  do {
    coarse = sum;
    panels *= 2;
    sum = correction_count ? sum_panels(path, segment, u0, u1, panels) : coarse;
  } while (panels < MAX_PANELS &&
           fabs(sum.travel - coarse.travel) + fabs(sum.turn - coarse.turn) + fabs(sum.s - coarse.s) > 1e-10 * sum.s);
  return sum;
}

/* Rotation speed in rad/s; 1 if the path states none (rotations in place). */
static double turn_speed(const km_path *path) {
  return path->turn_speed > 0.0 ? path->turn_speed : 1.0;
}

/* Determines if travel, rotation or stated times set the time of an interval: the slower one. */
static km_pace pace_of(const km_path *path, const km_segment *segment, path_lengths increment) {
  if (segment->seconds > 0.0)
    return KM_PACE_TIMES;
  if (increment.travel <= 1e-9 * increment.s)
    return KM_PACE_TURN;
  bool limits = path->turn_speed > 0.0 && increment.turn / path->turn_speed > increment.travel / path->speed;
  return limits ? KM_PACE_TURN : KM_PACE_TRAVEL;
}

/* Time in seconds of an increment at a pace; du is its part of the segment. */
static double seconds_of(const km_path *path, const km_segment *segment, km_pace pace, path_lengths increment,
                         double du) {
  if (pace == KM_PACE_TIMES)
    return segment->seconds * du;
  return pace == KM_PACE_TURN ? increment.turn / turn_speed(path) : increment.travel / path->speed;
}

/* Path point at u in an interval of length `increment` and time `seconds`. */
static km_path_point point_of(const km_path *path, const km_segment *segment, double u, km_pace pace,
                              path_lengths increment, double seconds) {
  km_path_point point = {.s = 0.0};
  km_twist rate;
  point.pose = km_segment_pose(segment, u, &rate);
  path_lengths here = counted_lengths(path->arm, &point.pose, rate);
  double dt = seconds_of(path, segment, pace, here, 1.0), mean = increment.s / seconds;
  /* The origin is at rest at a cusp while the effector rotates; the mean speed of the interval is used there. */
  point.speed = here.s <= 10.0 * mean * dt ? here.s / dt : mean;
  if (here.s == 0.0)
    point.speed = 0.0;
  if (here.s < 1e-9 * segment->length) { /* the direction is taken a small step further inside */
    km_segment_pose(segment, u < 0.5 ? u + 1e-6 : u - 1e-6, &rate);
    here = counted_lengths(path->arm, &point.pose, rate);
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

/* Path point at a fraction of an interval; splines and weaves are integrated, other shapes are linear in u. */
km_path_point km_path_at(const km_path *path, int i, double fraction) {
  const km_segment *segment = segment_at(path, i);
  const km_path_point *a = &path->points[i], *b = &path->points[i + 1];
  if (fraction <= 0.0)
    return *a;
  double u0 = u_at(segment, i - segment->first), u1 = u_at(segment, i + 1 - segment->first);
  double u = u0 + fraction * (u1 - u0);
  path_lengths all = {b->s - a->s, b->travel - a->travel, b->turn - a->turn};
  path_lengths part = {all.s * fraction, all.travel * fraction, all.turn * fraction};
  if (segment->kind == KM_SEGMENT_SPLINE || segment->kind == KM_SEGMENT_WEAVE)
    part = measure_lengths(path, segment, u0, u);
  km_path_point point = point_of(path, segment, u, path->pace[i], all, b->t - a->t);
  point.s = a->s + part.s;
  point.travel = a->travel + part.travel;
  point.turn = a->turn + part.turn;
  point.t = a->t + seconds_of(path, segment, path->pace[i], part, u - u0);
  return point;
}

/* Computes the samples of one segment; false if it doesn't move. A sample has the speed of the interval that begins
 * there. */
static bool sample_segment(km_path *path, int index) {
  km_segment *segment = &path->segments[index];
  km_path_point last = path->points[segment->first];
  segment->length = measure_lengths(path, segment, 0.0, 1.0).s;
  if (!(segment->length > 1e-9))
    return false;
  for (int k = 0; k < segment->steps; ++k) {
    double u = u_at(segment, k), end = u_at(segment, k + 1);
    path_lengths increment = measure_lengths(path, segment, u, end);
    if (!(increment.s > 1e-12 * segment->length))
      return false;
    km_pace pace = pace_of(path, segment, increment);
    double seconds = seconds_of(path, segment, pace, increment, end - u);
    for (int side = 0; side < 2; ++side) {
      int i = segment->first + k + side;
      km_path_point *point = &path->points[i];
      *point = point_of(path, segment, side ? end : u, pace, increment, seconds);
      point->s = last.s + side * increment.s;
      point->travel = last.travel + side * increment.travel;
      point->turn = last.turn + side * increment.turn;
      point->t = last.t + side * seconds;
      path->segment_of[i] = index;
      path->pace[i] = pace;
    }
    last = path->points[segment->first + k + 1];
  }
  return true;
}

/* Numbers the samples of all segments and computes them. */
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
    if (!sample_segment(path, *which))
      return km_fail(error, KM_USAGE, "the effector doesn't move on it; expected a way to go");
  return KM_OK;
}

double km_pose_distance(const km_pose *a, const km_pose *b) {
  km_rotation back = km_rotation_inverse(&a->R), difference = km_rotation_product(&b->R, &back);
  km_vec3 turn = km_quaternion_log(km_rotation_quaternion(&difference)), increment = km_vec3_sub(b->p, a->p);
  return sqrt(km_vec3_dot(increment, increment) + km_vec3_dot(turn, turn));
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
