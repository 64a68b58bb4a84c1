/* Maps of self-motions along a path: the curve of every station, cut open into an interval of arc length. */
#include "arm/selfmotion/selfmotion_map.h"

#include "arm/tracking/joint_effort.h"

#include <string.h>

/* Map under construction. */
typedef struct map_builder {
  km_motion_map *out;
  const km_path *path;
  const km_objective *objective;
  km_arm free_arm; /* the arm without limits and rates */
  km_arm_space space;
  km_tracker_space tracker_space;
  km_path_node here, next;
} map_builder;

static double signed_arc_length(const km_selfmotion_curve *c, double u) {
  return c->closed && u > 0.5 * c->length ? u - c->length : u;
}

/* Copies the points in the order of u; on a closed curve the second half comes first, with negative u. */
static void copy_points(map_builder *m, const km_selfmotion_curve *c, const km_path_point *point, km_station *s) {
  const int n = m->out->arm->n;
  int first = 0;
  while (first < c->count && c->closed && c->u[first] <= 0.5 * c->length)
    ++first;
  first = c->closed ? first % c->count : 0;
  for (int i = 0; i < c->count; ++i) {
    int from = (first + i) % c->count;
    double xi[KM_ARM_ROWS], columns[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS] = {0},
                                                                                     values[KM_OBJECTIVES];
    double *q = s->q + i * n;
    s->u[i] = signed_arc_length(c, c->u[from]);
    memcpy(q, c->q + from * n, (size_t)n * sizeof *q);
    for (int k = 0; k < n && s->u[i] < c->u[from]; ++k)
      q[k] -= km_selfmotion_curve_turn(c, k);
    km_arm_unwind_narrow(m->out->arm, q);
    km_arm_update(m->out->arm, &m->space, q);
    km_arm_task_rows(m->out->arm, &m->space.pose.R, point->twist, xi);
    km_control_factor(m->out->arm, &m->space, xi, NULL);
    km_control_columns(m->out->arm, &m->space, NULL, columns, self);
    km_objective_values(m->out->arm, &m->space, q, columns, point->speed, m->objective, values);
    s->value[i] = km_objective_sum(m->objective, values);
    if (km_objective_needs_forces(m->objective)) {
      km_joint_effort effort;
      km_joint_effort_at_rest(m->out->arm, q, columns, point->speed, &effort);
      s->value[i] += km_joint_effort_sum(m->objective, &effort);
    }
  }
  s->count = c->count;
}

/* Copies the arcs, cut at the ends of the interval of u. */
static void copy_arcs(const km_selfmotion_curve *c, const km_arc_span *arcs, int count, km_station *s) {
  int turns = c->closed && !km_selfmotion_curve_continues(c) ? 1 : 0;
  for (int i = 0; i < count; ++i)
    for (int turn = -turns; turn <= turns; ++turn) {
      double from = fmax(arcs[i].from + turn * c->length, s->low), to = fmin(arcs[i].to + turn * c->length, s->high);
      if (to > from)
        s->arcs[s->arc_count++] = (km_arc_span){from, to, {arcs[i].column[0], arcs[i].column[1]}};
    }
}

/* Follows the self-motion of the reference at a sample and adds it as a station. */
static bool add_station(map_builder *m, int sample) {
  km_motion_map *out = m->out;
  const km_path_point *point = &m->path->points[sample];
  km_selfmotion_curve curve = {.arm = out->arm, .space = &m->space, .target = point->pose, .sense = m->here.self};
  if (!km_selfmotion_curve_follow(&curve, m->here.q, 40.0)) {
    km_selfmotion_curve_free(&curve);
    return false;
  }
  int arc_count;
  km_arc_span *arcs = km_selfmotion_curve_arcs(&curve, &arc_count);
  km_station *s = &out->stations[out->count++];
  size_t count = (size_t)curve.count;
  *s = (km_station){.sample = sample, .s = point->s * out->arm->length, .closed = curve.closed};
  s->low = curve.closed ? -0.5 * curve.length : curve.u[0];
  s->high = curve.closed ? 0.5 * curve.length : curve.u[curve.count - 1];
  s->u = KM_ARENA_NEW(&out->arena, double, count);
  s->value = KM_ARENA_NEW(&out->arena, double, count);
  s->q = KM_ARENA_NEW(&out->arena, double, count *(size_t)out->arm->n);
  s->arcs = KM_ARENA_NEW(&out->arena, km_arc_span, 3 * (size_t)(arc_count > 0 ? arc_count : 0) + 1);
  bool is_ok = arcs && !out->arena.failed;
  if (is_ok) {
    copy_points(m, &curve, point, s);
    copy_arcs(&curve, arcs, arc_count, s);
  }
  km_free(arcs);
  km_selfmotion_curve_free(&curve);
  return is_ok;
}

/* Carries the reference along the path by the path-control column and adds stations at equal strides. */
static bool trace_reference(map_builder *m, const double *start, int stations) {
  static const km_step_choice greedy_choice = {0};
  const km_tracker w = {&m->free_arm, m->path, NULL};
  int samples = m->path->samples, stride = (samples - 1 + stations - 1) / stations, i = 0;
  km_tracker_compute_node(&w, &m->tracker_space, 0, start, &greedy_choice, &m->here);
  for (stride = stride < 1 ? 1 : stride;; ++i) {
    if ((i % stride == 0 || i == samples - 1) && !add_station(m, i))
      return false;
    if (i == samples - 1 || km_tracker_step(&w, &m->tracker_space, i, 1.0, &m->here, &greedy_choice, &m->next).stop)
      break;
    km_path_node_copy(&m->free_arm, &m->here, &m->next);
  }
  m->out->reached = m->path->points[i].s / m->path->points[samples - 1].s;
  return true;
}

/* Allocates the map and an arm without limits and rates. */
static bool prepare(map_builder *m, km_arena *arena, const km_arm *arm, int stations) {
  size_t n = (size_t)arm->n;
  m->free_arm = *arm;
  m->free_arm.low = KM_ARENA_NEW(arena, double, n);
  m->free_arm.high = KM_ARENA_NEW(arena, double, n);
  m->free_arm.rate = KM_ARENA_NEW(arena, double, n);
  m->out->stations = KM_ARENA_NEW(arena, km_station, (size_t)stations + 3);
  if (arena->failed || !km_path_node_create(arm, arena, &m->here) || !km_path_node_create(arm, arena, &m->next))
    return false;
  for (size_t k = 0; k < n; ++k) {
    m->free_arm.low[k] = -(double)INFINITY;
    m->free_arm.high[k] = m->free_arm.rate[k] = (double)INFINITY;
  }
  return km_arm_space_create(arm, &m->space) && km_tracker_space_create(arm, &m->tracker_space);
}

km_status km_motion_map_create(const km_arm *arm, const km_path *path, const double *start,
                               const km_objective *objective, int stations, km_motion_map *out, km_error *error) {
  *out = (km_motion_map){.arm = arm};
  if (arm->freedom != 1)
    return km_fail(error, KM_USAGE, "the arm has %d spare freedoms for its task; a map needs 1", arm->freedom);
  map_builder m = {.out = out, .path = path, .objective = objective};
  double q[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < arm->n; ++k)
    q[k] = km_arm_from_units(arm, k, start[k]);
  bool is_ok = prepare(&m, &out->arena, arm, stations) && trace_reference(&m, q, stations);
  km_arm_space_free(&m.space);
  km_tracker_space_free(&m.tracker_space);
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a map");
}

void km_motion_map_free(km_motion_map *map) {
  km_arena_free(&map->arena);
}

double km_station_find(const km_motion_map *map, const km_station *s, const double *q) {
  const int n = map->arm->n;
  double best = (double)INFINITY;
  int nearest = -1;
  for (int i = 0; i < s->count; ++i) {
    double distance = 0.0;
    for (int k = 0; k < n; ++k) {
      double difference = km_arm_difference(map->arm, k, s->q[i * n + k], q[k]);
      distance += difference * difference;
    }
    if (distance < best) {
      best = distance;
      nearest = i;
    }
  }
  if (nearest < 0 || best >= 0.1 * 0.1)
    return (double)NAN;
  int other = nearest + 1 < s->count ? nearest + 1 : nearest - 1; /* projection on the chord to a neighbouring point */
  double along = 0.0, chord = 0.0;
  for (int k = 0; other >= 0 && k < n; ++k) {
    double side = km_arm_difference(map->arm, k, s->q[nearest * n + k], s->q[other * n + k]);
    along += side * km_arm_difference(map->arm, k, s->q[nearest * n + k], q[k]);
    chord += side * side;
  }
  return s->u[nearest] + (chord > 0.0 ? along / chord * (s->u[other] - s->u[nearest]) : 0.0);
}
