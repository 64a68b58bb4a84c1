/* All poses that hold an effector, as arcs of closed curves. */
#include "arm/ik/ik_branches.h"

#include "arm/arm_arguments.h"

static void add_row(const km_loop_curve *c, km_selfmotion *out, int arc, double u, const int *shift, double *q) {
  for (int k = 0; k < c->arm->n; ++k)
    q[k] += 2.0 * M_PI * shift[k];
  km_arm_bring_within(c->arm, q);
  out->row_arc[out->row_count] = arc;
  out->row_u[out->row_count] = u;
  for (int k = 0; k < c->arm->n; ++k)
    out->row_q[out->row_count * c->arm->n + k] = km_arm_shown(c->arm, k, q[k]);
  out->row_count++;
}

/* The first and last round that an arc has poses of. */
static int round_of(const km_loop_curve *c, double u) {
  return c->closed ? (int)floor(u / c->length) : 0;
}

/* End, points between, end. */
static void add_arc(const km_loop_curve *c, km_selfmotion *out, int arc, const int *shift) {
  const int n = c->arm->n;
  double from = out->arcs[arc].from, to = out->arcs[arc].to, q[KM_ARM_MOST];
  if (km_loop_curve_at(c, from, q))
    add_row(c, out, arc, from, shift, q);
  for (int round = round_of(c, from); round <= round_of(c, to); ++round)
    for (int i = 0; i < c->count; ++i) {
      double u = c->u[i] + round * c->length;
      if (u <= from + 1e-9 || u >= to - 1e-9)
        continue;
      for (int k = 0; k < n; ++k)
        q[k] = c->q[i * n + k] + round * km_loop_curve_turn(c, k);
      add_row(c, out, arc, u, shift, q);
    }
  if (km_loop_curve_at(c, to, q))
    add_row(c, out, arc, to, shift, q);
}

static bool add_rows(const km_loop_curve *c, const int *shift, km_selfmotion *out) {
  size_t most = 2;
  for (int arc = 0; arc < out->arc_count; ++arc)
    most += (size_t)(round_of(c, out->arcs[arc].to) - round_of(c, out->arcs[arc].from) + 1) * (size_t)c->count + 2;
  out->row_arc = KM_NEW(int, most);
  out->row_u = KM_NEW(double, most);
  out->row_q = KM_NEW(double, most *(size_t)c->arm->n);
  if (!out->row_arc || !out->row_u || !out->row_q)
    return false;
  for (int arc = 0; arc < out->arc_count; ++arc)
    add_arc(c, out, arc, shift + arc * c->arm->n);
  return true;
}

km_status km_selfmotion_export(const km_loop_curve *c, km_selfmotion *out, km_error *error) {
  const int n = c->arm->n;
  out->count = c->count;
  out->columns = n;
  out->closed = c->closed;
  out->turns_on = km_loop_curve_runs_on(c);
  out->length = c->length;
  out->u = KM_NEW(double, (size_t)c->count);
  out->q = KM_NEW(double, (size_t)(c->count * n));
  km_lifts lifts;
  bool whole = km_loop_curve_lifts(c, &lifts) && out->u && out->q;
  out->arcs = lifts.arcs;
  out->turn = lifts.turn;
  out->arc_count = whole ? lifts.count : 0;
  whole = whole && add_rows(c, lifts.shift, out);
  lifts.arcs = NULL;
  lifts.turn = NULL;
  km_lifts_free(&lifts);
  if (!whole)
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  out->whole = c->closed && !out->turns_on && out->arc_count > 0;
  for (int i = 0; i < out->arc_count; ++i)
    out->whole = out->whole && out->arcs[i].column[0] < 0 && out->arcs[i].column[1] < 0;
  for (int i = 0; i < c->count; ++i) {
    out->u[i] = c->u[i];
    for (int k = 0; k < n; ++k)
      out->q[i * n + k] = km_arm_shown(c->arm, k, c->q[i * n + k]);
    km_arm_update(c->arm, c->space, c->q + i * n);
    out->error = fmax(out->error, km_arm_error(c->arm, c->space, &c->target, NULL, NULL, NULL));
  }
  out->evaluations = c->space->evaluations;
  return KM_OK;
}

/* One direction of a surface of poses, up to its first limit: an arc of its own. */
static bool add_direction(const km_loop_curve *c, km_selfmotion *out, int direction, km_error *error) {
  km_selfmotion one = {0};
  bool whole = km_selfmotion_export(c, &one, error) == KM_OK;
  int most = out->row_count + (whole ? one.row_count : 0);
  size_t n = (size_t)c->arm->n;
  int *arc = km_resize(out->row_arc, (size_t)most + 1, sizeof *arc);
  out->row_arc = arc ? arc : out->row_arc;
  double *u = km_resize(out->row_u, (size_t)most + 1, sizeof *u);
  out->row_u = u ? u : out->row_u;
  double *q = km_resize(out->row_q, ((size_t)most + 1) * n, sizeof *q);
  out->row_q = q ? q : out->row_q;
  whole = whole && arc && u && q;
  bool starts = whole && one.arc_count > 0 && one.arcs[0].from <= 0.0;
  for (int i = 0; starts && i < one.row_count && one.row_arc[i] == 0; ++i, ++out->row_count) {
    arc[out->row_count] = direction;
    u[out->row_count] = one.row_u[i];
    for (size_t k = 0; k < n; ++k)
      q[(size_t)out->row_count * n + k] = one.row_q[(size_t)i * n + k];
  }
  out->arcs[direction] = starts ? one.arcs[0] : (km_arc_span){0.0, 0.0, {-1, -1}};
  out->length = fmax(out->length, out->arcs[direction].to);
  out->error = fmax(out->error, one.error);
  km_selfmotion_free(&one);
  return whole;
}

static km_status stopped(km_error *error) {
  return km_fail(error, KM_CANCELLED, "following the self-motion was cancelled");
}

/* A circle of directions in the first pose's two pose-control columns. */
static km_status follow_circle(const km_arm *a, km_arm_space *space, const double *start, km_progress progress,
                               void *context, km_selfmotion *out, km_error *error) {
  static const double none[KM_ARM_ROWS] = {0};
  double path[KM_ARM_MOST + 1], self[KM_ARM_MOST * KM_ARM_MOST], sense[KM_ARM_MOST];
  km_pose target = space->pose;
  km_control_factor(a, space, none, NULL);
  km_control_columns(a, space, NULL, path, self);
  out->columns = a->n;
  out->arcs = KM_NEW(km_arc_span, KM_SELFMOTION_DIRECTIONS);
  out->arc_count = out->arcs ? KM_SELFMOTION_DIRECTIONS : 0;
  bool whole = out->arcs != NULL, cancelled = false;
  for (int d = 0; d < KM_SELFMOTION_DIRECTIONS && whole; ++d) {
    double around = 2.0 * M_PI * d / KM_SELFMOTION_DIRECTIONS;
    for (int k = 0; k < a->n; ++k)
      sense[k] = cos(around) * self[k] + sin(around) * self[a->n + k];
    km_loop_curve curve = {
        .arm = a, .space = space, .target = target, .sense = sense, .progress = progress, .context = context};
    whole = km_loop_curve_follow(&curve, start, M_PI) && add_direction(&curve, out, d, error);
    cancelled = curve.cancelled;
    km_loop_curve_free(&curve);
  }
  if (cancelled)
    return stopped(error);
  return whole ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a self-motion");
}

km_status km_selfmotion_follow(const km_arm *a, const double *q, km_progress progress, void *context,
                               km_selfmotion *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_selfmotion){0};
  km_status fits = km_check_given(a && q, "arm or pose", error);
  if (!fits)
    fits = km_check_arm_values(a, q, error);
  if (fits)
    return fits;
  km_arm_space space;
  double start[KM_ARM_MOST];
  if (a->freedom != 1 && a->freedom != 2)
    return km_fail(error, KM_USAGE, "the arm has %d spare freedoms for its task; expected 1 or 2", a->freedom);
  if (!km_arm_space_create(a, &space))
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  for (int k = 0; k < a->n; ++k)
    start[k] = km_arm_read(a, k, q[k]);
  km_arm_update(a, &space, start);
  km_status status;
  if (a->freedom == 2) {
    status = follow_circle(a, &space, start, progress, context, out, error);
  } else {
    km_loop_curve curve = {.arm = a, .space = &space, .target = space.pose, .progress = progress, .context = context};
    status = km_loop_curve_follow(&curve, start, 200.0) ? km_selfmotion_export(&curve, out, error)
             : curve.cancelled                          ? stopped(error)
                                                        : km_fail(error, KM_MEMORY, "out of memory for a curve");
    km_loop_curve_free(&curve);
  }
  km_arm_space_free(&space);
  return status;
}

void km_selfmotion_free(km_selfmotion *m) {
  if (!m)
    return;
  km_free(m->u);
  km_free(m->q);
  km_free(m->arcs);
  km_free(m->turn);
  km_free(m->row_arc);
  km_free(m->row_u);
  km_free(m->row_q);
  *m = (km_selfmotion){0};
}
