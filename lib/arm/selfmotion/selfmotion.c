/* Self-motions as public records: one curve with its arcs within the limits; with two spare freedoms, a circle of
 * directions (docs/theory.md 12.8). */
#include "arm/ik/ik_branches.h"

#include "arm/arm_arguments.h"

/* Appends a row of an arc, shifted by full turns. */
static void add_row(const km_selfmotion_curve *c, km_selfmotion *out, int arc, double u, const int *shift, double *q) {
  for (int k = 0; k < c->arm->n; ++k)
    q[k] += 2.0 * M_PI * shift[k];
  km_arm_unwind_narrow(c->arm, q);
  out->row_arc[out->row_count] = arc;
  out->row_u[out->row_count] = u;
  for (int k = 0; k < c->arm->n; ++k)
    out->row_q[out->row_count * c->arm->n + k] = km_arm_to_units(c->arm, k, q[k]);
  out->row_count++;
}

/* Round of the closed curve that contains u. */
static int round_of(const km_selfmotion_curve *c, double u) {
  return c->closed ? (int)floor(u / c->length) : 0;
}

/* Rows of an arc: its end, the points between, the other end. */
static void add_arc(const km_selfmotion_curve *c, km_selfmotion *out, int arc, const int *shift) {
  const int n = c->arm->n;
  double from = out->arcs[arc].from, to = out->arcs[arc].to, q[KM_ARM_MAX_JOINTS];
  if (km_selfmotion_curve_at(c, from, q))
    add_row(c, out, arc, from, shift, q);
  for (int round = round_of(c, from); round <= round_of(c, to); ++round)
    for (int i = 0; i < c->count; ++i) {
      double u = c->u[i] + round * c->length;
      if (u <= from + 1e-9 || u >= to - 1e-9)
        continue;
      for (int k = 0; k < n; ++k)
        q[k] = c->q[i * n + k] + round * km_selfmotion_curve_turn(c, k);
      add_row(c, out, arc, u, shift, q);
    }
  if (km_selfmotion_curve_at(c, to, q))
    add_row(c, out, arc, to, shift, q);
}

/* Writes the rows of all arcs. */
static bool add_rows(const km_selfmotion_curve *c, const int *shift, km_selfmotion *out) {
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

/* Public record: points, lifted arcs, rows and the largest pose error. */
km_status km_selfmotion_export(const km_selfmotion_curve *c, km_selfmotion *out, km_error *error) {
  const int n = c->arm->n;
  out->count = c->count;
  out->columns = n;
  out->closed = c->closed;
  out->continues_by_turns = km_selfmotion_curve_continues(c);
  out->length = c->length;
  out->u = KM_NEW(double, (size_t)c->count);
  out->q = KM_NEW(double, (size_t)(c->count * n));
  km_lifted_arcs lifts;
  bool is_ok = km_selfmotion_curve_find_lifted_arcs(c, &lifts) && out->u && out->q;
  out->arcs = lifts.arcs;
  out->turn = lifts.turn;
  out->arc_count = is_ok ? lifts.count : 0;
  is_ok = is_ok && add_rows(c, lifts.shift, out);
  lifts.arcs = NULL;
  lifts.turn = NULL;
  km_lifted_arcs_free(&lifts);
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  out->is_within_limits = c->closed && !out->continues_by_turns && out->arc_count > 0;
  for (int i = 0; i < out->arc_count; ++i)
    out->is_within_limits = out->is_within_limits && out->arcs[i].column[0] < 0 && out->arcs[i].column[1] < 0;
  for (int i = 0; i < c->count; ++i) {
    out->u[i] = c->u[i];
    for (int k = 0; k < n; ++k)
      out->q[i * n + k] = km_arm_to_units(c->arm, k, c->q[i * n + k]);
    km_arm_update(c->arm, c->space, c->q + i * n);
    out->error = fmax(out->error, km_arm_error(c->arm, c->space, &c->target, NULL, NULL, NULL));
  }
  out->evaluations = c->space->evaluations;
  return KM_OK;
}

/* Adds one direction of a two-parameter self-motion, up to its first limit, as an arc. */
static bool add_direction(const km_selfmotion_curve *c, km_selfmotion *out, int direction, km_error *error) {
  km_selfmotion one = {0};
  bool is_ok = km_selfmotion_export(c, &one, error) == KM_OK;
  int most = out->row_count + (is_ok ? one.row_count : 0);
  size_t n = (size_t)c->arm->n;
  int *arc = km_resize(out->row_arc, (size_t)most + 1, sizeof *arc);
  out->row_arc = arc ? arc : out->row_arc;
  double *u = km_resize(out->row_u, (size_t)most + 1, sizeof *u);
  out->row_u = u ? u : out->row_u;
  double *q = km_resize(out->row_q, ((size_t)most + 1) * n, sizeof *q);
  out->row_q = q ? q : out->row_q;
  is_ok = is_ok && arc && u && q;
  bool starts = is_ok && one.arc_count > 0 && one.arcs[0].from <= 0.0;
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
  return is_ok;
}

static km_status fail_cancelled(km_error *error) {
  return km_fail(error, KM_CANCELLED, "following the self-motion was cancelled");
}

/* Follows a circle of directions, spanned by the two pose-control columns at the start. */
static km_status follow_circle(const km_arm *a, km_arm_space *space, const double *start, km_progress progress,
                               void *context, km_selfmotion *out, km_error *error) {
  static const double none[KM_ARM_ROWS] = {0};
  double path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS], sense[KM_ARM_MAX_JOINTS];
  km_pose target = space->pose;
  km_control_factor(a, space, none, NULL);
  km_control_columns(a, space, NULL, path, self);
  out->columns = a->n;
  out->arcs = KM_NEW(km_arc_span, KM_SELFMOTION_DIRECTIONS);
  out->arc_count = out->arcs ? KM_SELFMOTION_DIRECTIONS : 0;
  bool is_ok = out->arcs != NULL, cancelled = false;
  for (int d = 0; d < KM_SELFMOTION_DIRECTIONS && is_ok; ++d) {
    double around = 2.0 * M_PI * d / KM_SELFMOTION_DIRECTIONS;
    for (int k = 0; k < a->n; ++k)
      sense[k] = cos(around) * self[k] + sin(around) * self[a->n + k];
    km_selfmotion_curve curve = {
        .arm = a, .space = space, .target = target, .sense = sense, .progress = progress, .context = context};
    is_ok = km_selfmotion_curve_follow(&curve, start, M_PI) && add_direction(&curve, out, d, error);
    cancelled = curve.cancelled;
    km_selfmotion_curve_free(&curve);
  }
  if (cancelled)
    return fail_cancelled(error);
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a self-motion");
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
  double start[KM_ARM_MAX_JOINTS];
  if (a->freedom != 1 && a->freedom != 2)
    return km_fail(error, KM_USAGE, "the arm has %d spare freedoms for its task; expected 1 or 2", a->freedom);
  if (!km_arm_space_create(a, &space))
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  for (int k = 0; k < a->n; ++k)
    start[k] = km_arm_from_units(a, k, q[k]);
  km_arm_update(a, &space, start);
  km_status status;
  if (a->freedom == 2) {
    status = follow_circle(a, &space, start, progress, context, out, error);
  } else {
    km_selfmotion_curve curve = {
        .arm = a, .space = &space, .target = space.pose, .progress = progress, .context = context};
    status = km_selfmotion_curve_follow(&curve, start, 200.0) ? km_selfmotion_export(&curve, out, error)
             : curve.cancelled                                ? fail_cancelled(error)
                                                              : km_fail(error, KM_MEMORY, "out of memory for a curve");
    km_selfmotion_curve_free(&curve);
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
