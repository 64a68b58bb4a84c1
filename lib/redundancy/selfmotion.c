#include "redundancy/branches.h"

/* Hinges with limits come within them by full turns; the others stay continuous. */
static void bring_within(const km_arm *a, double *q) {
  double all[KM_ARM_MOST];
  for (int k = 0; k < a->n; ++k)
    all[k] = q[k];
  km_arm_unwind(a, all);
  for (int k = 0; k < a->n; ++k)
    if (a->high[k] - a->low[k] < 2.0 * M_PI)
      q[k] = all[k];
}

static void add_row(const km_loop_curve *c, km_selfmotion *out, int arc, double u, double *q) {
  bring_within(c->arm, q);
  out->row_arc[out->row_count] = arc;
  out->row_u[out->row_count] = u;
  for (int k = 0; k < c->arm->n; ++k)
    out->row_q[out->row_count * c->arm->n + k] = km_arm_shown(c->arm, k, q[k]);
  out->row_count++;
}

/* The pose at u, which on a closed curve may be below 0. */
static bool pose_at(const km_loop_curve *c, double u, double *q) {
  u += c->closed && u < 0.0 ? c->length : 0.0;
  int i = 0;
  while (i + 1 < c->count && c->u[i + 1] <= u)
    ++i;
  double span = i == c->count - 1 ? c->length - c->u[i] : c->u[i + 1] - c->u[i];
  return km_loop_curve_between(c, i, span > 0.0 ? fmin(fmax((u - c->u[i]) / span, 0.0), 1.0) : 0.0, q, NULL);
}

/* End, points between, end. */
static void add_arc(const km_loop_curve *c, km_selfmotion *out, int arc) {
  const int n = c->arm->n;
  double from = out->arcs[arc].from, to = out->arcs[arc].to, q[KM_ARM_MOST];
  if (pose_at(c, from, q))
    add_row(c, out, arc, from, q);
  for (int turn = -1; turn <= 0; ++turn)
    for (int i = 0; i < c->count; ++i) {
      double u = c->u[i] + turn * c->length;
      if ((turn && !c->closed) || u <= from + 1e-9 || u >= to - 1e-9)
        continue;
      for (int k = 0; k < n; ++k)
        q[k] = c->q[i * n + k];
      add_row(c, out, arc, u, q);
    }
  if (pose_at(c, to, q))
    add_row(c, out, arc, to, q);
}

static bool add_rows(const km_loop_curve *c, km_selfmotion *out) {
  size_t most = 2 * (size_t)c->count + 2 * (size_t)out->arc_count + 2;
  out->row_arc = KM_NEW(int, most);
  out->row_u = KM_NEW(double, most);
  out->row_q = KM_NEW(double, most *(size_t)c->arm->n);
  if (!out->row_arc || !out->row_u || !out->row_q)
    return false;
  for (int arc = 0; arc < out->arc_count; ++arc)
    add_arc(c, out, arc);
  return true;
}

km_status km_selfmotion_export(const km_loop_curve *c, km_selfmotion *out, km_error *error) {
  const int n = c->arm->n;
  out->count = c->count;
  out->columns = n;
  out->closed = c->closed;
  out->length = c->length;
  out->u = KM_NEW(double, (size_t)c->count);
  out->q = KM_NEW(double, (size_t)(c->count * n));
  out->arcs = km_loop_curve_arcs(c, &out->arc_count);
  if (!out->u || !out->q || !out->arcs)
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  if (!add_rows(c, out))
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  out->whole = c->closed && out->arc_count == 1 && out->arcs[0].column[0] < 0 && out->arcs[0].column[1] < 0;
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

km_status km_selfmotion_follow(const km_arm *a, const double *q, km_selfmotion *out, km_error *error) {
  km_arm_space space;
  double start[KM_ARM_MOST];
  *out = (km_selfmotion){0};
  if (a->freedom != 1)
    return km_fail(error, KM_USAGE, "the arm has %d spare freedoms for its task; expected 1: a curve of poses",
                   a->freedom);
  if (!km_arm_space_create(a, &space))
    return km_fail(error, KM_MEMORY, "out of memory for a self-motion");
  for (int k = 0; k < a->n; ++k)
    start[k] = km_arm_read(a, k, q[k]);
  km_arm_update(a, &space, start);
  km_loop_curve curve = {.arm = a, .space = &space, .target = space.pose};
  km_status status = km_loop_curve_follow(&curve, start, 1e3) ? km_selfmotion_export(&curve, out, error)
                                                              : km_fail(error, KM_MEMORY, "out of memory for a curve");
  km_loop_curve_free(&curve);
  km_arm_space_free(&space);
  return status;
}

void km_selfmotion_free(km_selfmotion *m) {
  km_free(m->u);
  km_free(m->q);
  km_free(m->arcs);
  km_free(m->row_arc);
  km_free(m->row_u);
  km_free(m->row_q);
  *m = (km_selfmotion){0};
}
