/* Paths from definitions: each segment begins where the one before ends. */
#include "arm/check.h"
#include "arm/path.h"

#include <string.h>

/* A path that is being made: where it has come to. */
typedef struct maker {
  km_path *path;
  km_pose at;
} maker;

km_path_segment km_path_segment_default(km_path_shape shape) {
  return (km_path_segment){.shape = shape, .steps = 100, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .waves = 1.0};
}

km_path_plan km_path_plan_default(void) {
  return (km_path_plan){.start = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}};
}

static km_vec3 place_of(const maker *b, const double p[3]) {
  km_pose pose = {km_rotation_identity(), km_vec3_make(p)};
  return km_arm_from_model(b->path->arm, &pose).p;
}

/* The turn from where the path is to the segment's R, as a rotation vector about a fixed axis. */
static km_vec3 turn_to(const maker *b, const km_path_segment *g) {
  if (!g->turns)
    return (km_vec3){0, 0, 0};
  km_frame_pose end = {.p = {0, 0, 0}};
  memcpy(end.R, g->R, sizeof end.R);
  km_rotation to = km_arm_pose_of(b->path->arm, &end).R, back = km_rotation_inverse(&b->at.R);
  km_rotation difference = km_rotation_product(&to, &back);
  return km_quaternion_log(km_rotation_quaternion(&difference));
}

static km_status direction_of(const double v[3], const char *what, km_vec3 *out, km_error *error) {
  km_vec3 axis = km_vec3_make(v);
  double length = km_vec3_norm(axis);
  if (!(length > 0.0 && isfinite(length)))
    return km_fail(error, KM_USAGE, "the %s is a vector of length %g; expected a direction", what, length);
  *out = km_vec3_scale(1.0 / length, axis);
  return KM_OK;
}

static km_status make_helix(const maker *b, const km_path_segment *g, km_segment *out, km_error *error) {
  out->kind = KM_SEGMENT_HELIX;
  if (!(fabs(g->angle) <= 2000.0 * M_PI))
    return km_fail(error, KM_USAGE, "an arc of %g rad; expected at most 1000 turns", g->angle);
  out->centre = place_of(b, g->center);
  out->angle = g->angle;
  out->rise = g->pitch / b->path->arm->length * g->angle / (2.0 * M_PI);
  km_status status = direction_of(g->axis, "axis of an arc", &out->axis, error);
  out->turn = g->turns_along ? km_vec3_scale(g->angle, out->axis) : turn_to(b, g);
  return status;
}

static km_status make_weave(const maker *b, const km_path_segment *g, km_segment *out, km_error *error) {
  out->kind = KM_SEGMENT_WEAVE;
  if (!(g->waves > 0.0 && g->waves <= 1e4))
    return km_fail(error, KM_USAGE, "%g waves; expected a number above 0 up to 10000", g->waves);
  km_vec3 sideways;
  km_status status = direction_of(g->sideways, "direction of the swings", &sideways, error);
  if (status)
    return status;
  out->travel = km_vec3_sub(place_of(b, g->to), b->at.p);
  out->turn = turn_to(b, g);
  out->waves = g->waves;
  out->sideways = km_vec3_scale(g->amplitude / b->path->arm->length, sideways);
  return KM_OK;
}

/* Through the poses from where the path stands, with knots by the length of the chords. */
static km_status make_spline(maker *b, const km_path_segment *g, km_segment *out, km_error *error) {
  km_path *path = b->path;
  out->kind = KM_SEGMENT_SPLINE;
  km_status status = g->pose_count < 1 ? km_fail(error, KM_USAGE, "a spline through no pose")
                                       : km_check_list(g->poses, g->pose_count, "poses of a spline", error);
  for (int k = 0; k < g->pose_count && !status; ++k)
    status = km_check_pose(&g->poses[k], error);
  if (status)
    return status;
  out->knots = g->pose_count + 1;
  km_pose *poses = KM_ARENA_NEW(&path->arena, km_pose, (size_t)out->knots);
  out->knot = KM_ARENA_NEW(&path->arena, double, (size_t)out->knots);
  if (!poses || !out->knot)
    return km_fail(error, KM_MEMORY, "out of memory for a spline of %d points", out->knots);
  poses[0] = b->at;
  for (int k = 1; k < out->knots; ++k) {
    poses[k] = km_arm_pose_of(path->arm, &g->poses[k - 1]);
    double way = km_poses_apart(&poses[k - 1], &poses[k]);
    if (!(way > KM_SAME_POSE))
      return km_fail(error, KM_USAGE, "pose %d of a spline is the one before; expected a way to go", k - 1);
    out->knot[k] = out->knot[k - 1] + way;
  }
  double last = out->knot[out->knots - 1];
  for (int k = 1; k < out->knots; ++k)
    out->knot[k] /= last;
  return km_segment_fit(out, poses, &path->arena, error);
}

static km_status make_segment(maker *b, const km_path_segment *g, km_segment *out, km_error *error) {
  km_frame_pose end = {.p = {g->to[0], g->to[1], g->to[2]}};
  memcpy(end.R, g->R, sizeof end.R);
  *out = (km_segment){.steps = g->steps, .start = b->at};
  km_status status = g->turns || g->shape == KM_PATH_LINE ? km_check_pose(&end, error) : KM_OK;
  if (status)
    return status;
  switch (g->shape) {
  case KM_PATH_LINE:
    out->kind = KM_SEGMENT_LINE;
    out->travel = km_vec3_sub(place_of(b, g->to), b->at.p);
    out->turn = turn_to(b, g);
    return KM_OK;
  case KM_PATH_ARC:
    return make_helix(b, g, out, error);
  case KM_PATH_WEAVE:
    return make_weave(b, g, out, error);
  case KM_PATH_SPLINE:
    return make_spline(b, g, out, error);
  default:
    return km_fail(error, KM_USAGE, "%d is no shape of a segment", (int)g->shape);
  }
}

static km_status make_segments(maker *b, const km_path_plan *plan, km_error *error) {
  enum { MOST_STEPS = 1000000 };
  km_path *path = b->path;
  int steps = 0;
  km_status status = KM_OK;
  path->segments = KM_ARENA_NEW(&path->arena, km_segment, (size_t)plan->segment_count);
  if (!path->segments)
    return km_fail(error, KM_MEMORY, "out of memory for a path");
  for (int i = 0; i < plan->segment_count && !status; ++i) {
    const km_path_segment *g = &plan->segments[i];
    km_twist rate;
    if (g->steps < 1 || g->steps > MOST_STEPS - steps)
      return km_fail(error, KM_USAGE, "segment %d has %d steps; expected 1 or more, and at most %d in all", i, g->steps,
                     MOST_STEPS);
    steps += g->steps;
    status = make_segment(b, g, &path->segments[path->segment_count++], error);
    if (!status)
      b->at = km_segment_pose(&path->segments[i], 1.0, &rate);
  }
  int which;
  return status ? status : km_path_finish(path, &which, error);
}

static km_status check(const km_arm *a, const km_path_plan *plan, km_error *error) {
  km_status status = km_check_given(a && plan, "arm or plan of a path", error);
  if (!status)
    status = km_check_pose(&plan->start, error);
  if (!status && plan->segment_count < 1)
    status = km_fail(error, KM_USAGE, "a path of %d segments; expected at least one", plan->segment_count);
  if (!status)
    status = km_check_list(plan->segments, plan->segment_count, "segments", error);
  if (!status && !(plan->speed >= 0.0 && plan->turn_speed >= 0.0 && isfinite(plan->speed + plan->turn_speed)))
    status = km_fail(error, KM_USAGE, "speeds of %g and %g; expected 0 or more", plan->speed, plan->turn_speed);
  return status;
}

km_status km_path_create(const km_arm *a, const km_path_plan *plan, km_path **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = check(a, plan, error);
  if (status)
    return status;
  maker b = {.path = KM_NEW(km_path, 1), .at = km_arm_pose_of(a, &plan->start)};
  if (!b.path)
    return km_fail(error, KM_MEMORY, "out of memory for a path");
  double second = a->mechanism->model->units.time->si;
  b.path->arm = a;
  b.path->speed = plan->speed > 0.0 ? plan->speed / a->length / second : 1.0;
  b.path->turn_speed = plan->turn_speed / second;
  status = make_segments(&b, plan, error);
  if (status)
    km_path_free(b.path);
  else
    *out = b.path;
  return status;
}
