/* Paths from definitions: each segment begins at the end of the previous one. */
#include "arm/arm_arguments.h"
#include "arm/path/path.h"
#include "base/text.h"

#include <string.h>

/* Path under construction; `at` is the end pose of its last segment. */
typedef struct path_builder {
  km_path *path;
  km_pose at;
  km_path_fault *fault; /* part of the plan that is being built */
} path_builder;

static km_vec3 position_of(const path_builder *b, const double p[3]) {
  km_pose pose = {km_rotation_identity(), km_vec3_from_array(p)};
  return km_arm_from_model(b->path->arm, &pose).p;
}

/* Rotation vector from the present orientation to the segment's R, about a fixed axis. */
static km_vec3 rotation_to(const path_builder *b, const km_path_segment *g) {
  if (!g->turns)
    return (km_vec3){0, 0, 0};
  km_frame_pose end = {.p = {0, 0, 0}};
  memcpy(end.R, g->R, sizeof end.R);
  km_rotation to = km_arm_pose_of(b->path->arm, &end).R, back = km_rotation_inverse(&b->at.R);
  km_rotation difference = km_rotation_product(&to, &back);
  return km_quaternion_log(km_rotation_quaternion(&difference));
}

static km_vec3 direction_of(const double v[3]) {
  km_vec3 axis = km_vec3_from_array(v);
  return km_vec3_scale(1.0 / km_vec3_norm(axis), axis);
}

/* Helix segment: axis, angle, rise and rotation of the effector. */
static km_status make_helix(path_builder *b, const km_path_segment *g, km_segment *out, km_error *error) {
  out->kind = KM_SEGMENT_HELIX;
  out->centre = position_of(b, g->center);
  out->axis = direction_of(g->axis);
  out->angle = g->full_turn ? 2.0 * M_PI : g->angle;
  out->rise = g->pitch / b->path->arm->length * out->angle / (2.0 * M_PI);
  out->turn = g->turns_along ? km_vec3_scale(out->angle, out->axis) : rotation_to(b, g);
  b->fault->key = "angle";
  return fabs(out->angle) <= 2000.0 * M_PI ? KM_OK : km_fail(error, KM_USAGE, "found more than 1000 turns");
}

static void make_line(const path_builder *b, const km_path_segment *g, km_segment *out) {
  out->kind = KM_SEGMENT_LINE;
  if (!g->in_place)
    out->travel = km_vec3_sub(position_of(b, g->to), b->at.p);
  out->turn = rotation_to(b, g);
}

static void make_weave(const path_builder *b, const km_path_segment *g, km_segment *out) {
  out->kind = KM_SEGMENT_WEAVE;
  out->travel = km_vec3_sub(position_of(b, g->to), b->at.p);
  out->turn = rotation_to(b, g);
  out->waves = g->waves;
  out->sideways = km_vec3_scale(g->amplitude / b->path->arm->length, direction_of(g->sideways));
}

/* Poses of a spline, preceded by the end of the previous segment; the spline begins there unless its first point is
 * that pose. */
typedef struct knots {
  km_pose *poses;      /* [given + 1] poses */
  const double *times; /* [given] times, or NULL */
  int given, first;    /* first: index of the first pose used, 0 or 1 */
} knots;

/* Checks and collects the poses of a spline, preceded by the end of the path so far. */
static km_status gather_points(path_builder *b, const km_path_segment *g, knots *out, km_error *error) {
  km_status status = km_check_list(g->points, g->point_count, "points of a spline", error);
  *out = (knots){.given = g->point_count, .times = g->times};
  for (int k = g->unturned > 0 ? g->unturned : 0; k < g->point_count && !status; ++k)
    status = km_check_pose(&g->points[b->fault->item = k], error);
  if (status)
    return status;
  out->poses = KM_ARENA_NEW(&b->path->arena, km_pose, (size_t)g->point_count + 1);
  if (!out->poses)
    return km_fail(error, KM_MEMORY, "out of memory for a spline of %d points", g->point_count);
  out->poses[0] = b->at;
  for (int k = 0; k < g->point_count; ++k) {
    km_pose *pose = &out->poses[k + 1];
    *pose = km_arm_pose_of(b->path->arm, &g->points[k]);
    if (k < g->unturned)
      pose->R = out->poses[k].R;
  }
  b->fault->item = -1;
  out->first = g->own_start || (g->point_count > 0 && km_pose_distance(&out->poses[0], &out->poses[1]) <= 1e-6);
  int least = out->first ? 2 : 1;
  return g->point_count >= least
             ? KM_OK
             : km_fail(error, KM_USAGE, "found %d points; expected at least %d", g->point_count, least);
}

/* Time of pose `index`, from the start of the segment. */
static double time_at(const knots *k, int index) {
  return index > 0 ? k->times[index - 1] : 0.0;
}

/* Sets the knots 0 … 1 by the times, else by chord lengths. */
static km_status set_knots(path_builder *b, const knots *k, km_segment *out, km_error *error) {
  double second = b->path->arm->mechanism->model->units.time->si;
  out->knots = k->given + 1 - k->first;
  out->knot = KM_ARENA_NEW(&b->path->arena, double, (size_t)out->knots);
  if (!out->knot)
    return km_fail(error, KM_MEMORY, "out of memory for a spline of %d points", out->knots);
  for (int i = 1; i < out->knots; ++i) {
    int to = k->first + i;
    double increment = km_pose_distance(&k->poses[to - 1], &k->poses[to]);
    b->fault->item = to - 1;
    if (!(increment > KM_SAME_POSE))
      return km_fail(error, KM_USAGE, "the same pose as the one before; expected a way to go");
    double from_time = k->times ? time_at(k, to - 1) : 0.0, to_time = k->times ? time_at(k, to) : increment;
    if (!(to_time > from_time && isfinite(to_time)))
      return km_fail(error, KM_USAGE, "time %s after %s; expected increasing times", KM_SHOWN(to_time),
                     KM_SHOWN(from_time));
    out->knot[i] = out->knot[i - 1] + (to_time - from_time);
  }
  double last = out->knot[out->knots - 1];
  out->seconds = k->times ? last * second : 0.0;
  for (int i = 1; i < out->knots; ++i)
    out->knot[i] /= last;
  return KM_OK;
}

/* Spline segment through poses. */
static km_status make_spline(path_builder *b, const km_path_segment *g, km_segment *out, km_error *error) {
  knots k;
  b->fault->key = "points";
  out->kind = KM_SEGMENT_SPLINE;
  km_status status = gather_points(b, g, &k, error);
  if (!status)
    status = set_knots(b, &k, out, error);
  out->at_knots = g->at_points;
  if (g->at_points)
    out->steps = out->knots - 1;
  return status ? status : km_segment_fit(out, k.poses + k.first, &b->path->arena, error);
}

/* Builds one segment by its shape. */
static km_status make_segment(path_builder *b, const km_path_segment *g, km_segment *out, km_error *error) {
  km_frame_pose end = {.p = {g->to[0], g->to[1], g->to[2]}};
  memcpy(end.R, g->turns ? g->R : (const double[]){1, 0, 0, 0, 1, 0, 0, 0, 1}, sizeof end.R);
  *out = (km_segment){.steps = g->steps, .start = b->at};
  km_status status = km_check_pose(&end, error);
  if (status)
    return status;
  switch (g->shape) {
  case KM_PATH_LINE:
    make_line(b, g, out);
    return KM_OK;
  case KM_PATH_ARC:
    return make_helix(b, g, out, error);
  case KM_PATH_WEAVE:
    make_weave(b, g, out);
    return KM_OK;
  case KM_PATH_SPLINE:
    return make_spline(b, g, out, error);
  default:
    return km_fail(error, KM_USAGE, "%d is no shape of a segment", (int)g->shape);
  }
}

/* Builds all segments, each from the end of the previous one, and samples the path. */
static km_status make_segments(path_builder *b, const km_path_plan *plan, km_error *error) {
  km_path *path = b->path;
  path->segments = KM_ARENA_NEW(&path->arena, km_segment, (size_t)plan->segment_count);
  if (!path->segments)
    return km_fail(error, KM_MEMORY, "out of memory for a path");
  for (int i = 0; i < plan->segment_count; ++i) {
    km_twist rate;
    *b->fault = (km_path_fault){i, NULL, -1};
    km_status status = make_segment(b, &plan->segments[i], &path->segments[path->segment_count++], error);
    if (status)
      return status;
    b->at = km_segment_pose(&path->segments[i], 1.0, &rate);
  }
  int which = -1;
  km_status status = km_path_finish(path, &which, error);
  *b->fault = (km_path_fault){which, NULL, -1};
  return status;
}

km_status km_path_build(const km_arm *a, const km_path_plan *plan, const km_pose *start, km_path **out,
                        km_path_fault *fault, km_error *error) {
  path_builder b = {.path = KM_NEW(km_path, 1), .at = *start, .fault = fault};
  if (!b.path)
    return km_fail(error, KM_MEMORY, "out of memory for a path");
  double second = a->mechanism->model->units.time->si;
  b.path->arm = a;
  b.path->speed = plan->speed > 0.0 ? plan->speed * (1.0 / a->length) / second : 1.0;
  b.path->turn_speed = plan->turn_speed / second;
  km_status status = make_segments(&b, plan, error);
  if (status)
    km_path_free(b.path);
  else
    *out = b.path;
  return status;
}

static km_status check_plan(const km_arm *a, const km_path_plan *plan, km_error *error) {
  km_status status = km_check_given(a && plan, "arm or plan of a path", error);
  if (!status)
    status = km_check_pose(&plan->start, error);
  if (!status)
    status = km_check_list(plan->segments, plan->segment_count, "segments", error);
  return status;
}

km_status km_path_create(const km_arm *a, const km_path_plan *plan, km_path **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = check_plan(a, plan, error);
  if (status)
    return status;
  km_path_fault fault = KM_PATH_NO_FAULT;
  km_error found;
  char where[KM_PATH_FAULT_TEXT];
  km_pose start = km_arm_pose_of(a, &plan->start);
  status = km_path_plan_check(plan, &fault, &found);
  if (!status)
    status = km_path_build(a, plan, &start, out, &fault, &found);
  return status ? km_fail(error, status, "%s: %s", km_path_fault_text(&fault, where), found.text) : KM_OK;
}
