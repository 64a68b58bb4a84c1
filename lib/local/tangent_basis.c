/* Bases of a part of the tangents. */
#include "local/tangent_cone.h"

#include <string.h>

bool km_orthonormalise(const double *basis, int count, int size, double *v) {
  double left = 0.0;
  for (int i = 0; i < count; ++i) {
    double along = 0.0;
    for (int k = 0; k < size; ++k)
      along += basis[i * size + k] * v[k];
    for (int k = 0; k < size; ++k)
      v[k] -= along * basis[i * size + k];
  }
  for (int k = 0; k < size; ++k)
    left += v[k] * v[k];
  for (int k = 0; k < size; ++k)
    v[k] /= sqrt(left);
  return left > 1e-6; /* of unit vectors: one of them is spanned by the others, the rest are well apart */
}

bool km_tangents_append_orthonormal(double *V, int count, int k, const double *a) {
  double *v = V + (size_t)count * (size_t)k;
  memcpy(v, a, (size_t)k * sizeof *v);
  return km_orthonormalise(V, count, k, v) &&
         km_orthonormalise(V, count, k, v); /* once more takes what rounding has left */
}

bool km_tangents_complete_basis(double *V, int count, int k) {
  double *unit = KM_NEW(double, (size_t)k + 1);
  for (int i = 0; i < k && count < k && unit; ++i) {
    memset(unit, 0, (size_t)k * sizeof *unit);
    unit[i] = 1.0;
    count += km_tangents_append_orthonormal(V, count, k, unit);
  }
  km_free(unit);
  return count == k;
}

bool km_tangents_remove(km_tangents *f, double *V, int count) {
  km_second_order *conditions = &f->conditions;
  int k = conditions->freedom, n = f->sub->columns;
  if (count == 0)
    return true;
  double *rest = KM_ARENA_NEW(f->arena, double, (size_t)(k - count) * (size_t)n + 1);
  bool whole = rest && km_tangents_complete_basis(V, count, k);
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
