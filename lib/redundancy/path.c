#include "redundancy/path.h"

#include <stdlib.h>

/* What the task counts of a rate: its length dσ. */
static double counted(const km_arm *arm, const km_pose *pose, km_twist rate) {
  double rows[KM_ARM_ROWS], sum = 0.0;
  km_arm_task_rows(arm, &pose->R, rate, rows);
  for (int r = 0; r < arm->rows; ++r)
    sum += rows[r] * rows[r];
  return sqrt(sum);
}

static double speed_at(const km_path *path, const km_segment *segment, double u) {
  km_twist rate;
  km_pose pose = km_segment_pose(segment, u, &rate);
  return counted(path->arm, &pose, rate);
}

/* σ from u0 to u1: four panels of Gauss and Legendre's rule of five points. */
static double length_between(const km_path *path, const km_segment *segment, double u0, double u1) {
  static const double at[5] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
  static const double weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                   0.2369268850561891};
  enum { PANELS = 4 };
  double h = (u1 - u0) / (2 * PANELS), sum = 0.0;
  for (int p = 0; p < PANELS; ++p)
    for (int k = 0; k < 5; ++k)
      sum += weight[k] * speed_at(path, segment, u0 + h * (2 * p + 1 + at[k]));
  return h * sum;
}

static km_path_point point_of(const km_path *path, const km_segment *segment, double u, double length) {
  km_path_point point;
  km_twist rate;
  point.pose = km_segment_pose(segment, u, &rate);
  double speed = counted(path->arm, &point.pose, rate);
  point.speed = segment->seconds > 0.0 ? speed / segment->seconds : path->speed;
  if (speed < 1e-9 * length) { /* a cusp: its direction is that a little further inside */
    km_segment_pose(segment, u < 0.5 ? u + 1e-6 : u - 1e-6, &rate);
    speed = counted(path->arm, &point.pose, rate);
  }
  double scale = speed > 0.0 ? 1.0 / speed : 0.0;
  point.twist = (km_twist){km_vec3_scale(scale, rate.v), km_vec3_scale(scale, rate.w)};
  point.s = point.t = 0.0;
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
  double all = b->s - a->s, u = u0 + fraction * (u1 - u0);
  km_path_point point = point_of(path, segment, u, all / (u1 - u0));
  double part = all * fraction;
  if (segment->kind == KM_SEGMENT_SPLINE || segment->kind == KM_SEGMENT_WEAVE)
    part = length_between(path, segment, u0, u);
  point.s = a->s + part;
  point.t = segment->seconds > 0.0 ? a->t + (b->t - a->t) * fraction : a->t + part / path->speed;
  return point;
}

/* Samples of one segment; false if it doesn't move. */
static bool sample(km_path *path, int index) {
  km_segment *segment = &path->segments[index];
  km_path_point last = path->points[segment->first];
  double length = length_between(path, segment, 0.0, 1.0);
  if (!(length > 1e-9))
    return false;
  for (int k = 0; k <= segment->steps; ++k) {
    double u = u_at(segment, k), s = last.s, t = last.t;
    if (k > 0) {
      double part = length_between(path, segment, u_at(segment, k - 1), u);
      if (!(part > 1e-12 * length))
        return false;
      s += part;
      t += segment->seconds > 0.0 ? segment->seconds * (u - u_at(segment, k - 1)) : part / path->speed;
    }
    int i = segment->first + k;
    path->points[i] = last = point_of(path, segment, u, length);
    path->points[i].s = last.s = s;
    path->points[i].t = last.t = t;
    path->segment_of[i] = index;
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
  if (path->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a path of %d steps", steps);
  for (*which = 0; *which < path->segment_count; ++*which)
    if (!sample(path, *which))
      return km_fail(error, KM_USAGE, "the effector doesn't move on it; expected a way to go");
  return KM_OK;
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
  return path->samples;
}

double km_path_length(const km_path *path, int i) {
  return path->points[i].s * path->arm->length;
}

double km_path_time(const km_path *path, int i) {
  return path->points[i].t;
}

void km_path_pose(const km_path *path, int i, km_effector_pose *out) {
  km_pose pose = km_arm_to_model(path->arm, &path->points[i].pose);
  for (int k = 0; k < 3; ++k) {
    out->R[k] = pose.R.axis[k].x;
    out->R[3 + k] = pose.R.axis[k].y;
    out->R[6 + k] = pose.R.axis[k].z;
  }
  out->p[0] = pose.p.x;
  out->p[1] = pose.p.y;
  out->p[2] = pose.p.z;
}
