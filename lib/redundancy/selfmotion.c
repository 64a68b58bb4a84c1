#include "redundancy/branches.h"

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
  m->u = m->q = NULL;
  m->arcs = NULL;
}
