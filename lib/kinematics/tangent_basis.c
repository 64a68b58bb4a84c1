/* Bases of a part of the tangents. */
#include "kinematics/tangents.h"

#include <string.h>

bool km_tangents_add(double *V, int count, int k, const double *a) {
  static const double least = 1e-3;
  double *v = V + (size_t)count * (size_t)k, square = 0.0;
  memcpy(v, a, (size_t)k * sizeof *v);
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < count; ++i) {
      double dot = 0.0;
      for (int r = 0; r < k; ++r)
        dot += V[i * k + r] * v[r];
      for (int r = 0; r < k; ++r)
        v[r] -= dot * V[i * k + r];
    }
  for (int r = 0; r < k; ++r)
    square += v[r] * v[r];
  if (!(square > least * least))
    return false;
  km_tangents_normalise(v, k);
  return true;
}

bool km_tangents_complete(double *V, int count, int k) {
  double *unit = KM_NEW(double, (size_t)k + 1);
  for (int i = 0; i < k && count < k && unit; ++i) {
    memset(unit, 0, (size_t)k * sizeof *unit);
    unit[i] = 1.0;
    count += km_tangents_add(V, count, k, unit);
  }
  km_free(unit);
  return count == k;
}

bool km_tangents_take_out(km_tangents *f, double *V, int count) {
  km_second_order *conditions = &f->conditions;
  int k = conditions->freedom, n = f->sub->columns;
  if (count == 0)
    return true;
  double *rest = KM_ARENA_NEW(f->arena, double, (size_t)(k - count) * (size_t)n + 1);
  bool whole = rest && km_tangents_complete(V, count, k);
  for (int i = count; i < k && whole; ++i)
    km_second_order_combine(conditions, V + i * k, rest + (size_t)(i - count) * (size_t)n);
  if (!whole)
    return false;
  conditions->Z = rest;
  conditions->freedom = k - count;
  for (int i = 0; i < k - count; ++i)
    f->length[i] = -1.0;
  return true;
}
