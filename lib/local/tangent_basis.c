/* Orthonormal bases of subspaces of the tangents, by Gram-Schmidt. */
#include "local/tangent_cone.h"

#include <string.h>

/* One Gram-Schmidt step: v minus its projection onto the basis, normalised. */
bool km_orthonormalise(const double *basis, int count, int size, double *v) {
  double square = 0.0;
  for (int i = 0; i < count; ++i) {
    double dot = 0.0;
    for (int k = 0; k < size; ++k)
      dot += basis[i * size + k] * v[k];
    for (int k = 0; k < size; ++k)
      v[k] -= dot * basis[i * size + k];
  }
  for (int k = 0; k < size; ++k)
    square += v[k] * v[k];
  for (int k = 0; k < size; ++k)
    v[k] /= sqrt(square);
  return square > 1e-6; /* squared length that remains of a unit vector: spanned vectors leave rounding, others far
                         * more */
}

/* Gram-Schmidt, twice. */
bool km_tangents_append_orthonormal(double *V, int count, int k, const double *a) {
  double *v = V + (size_t)count * (size_t)k;
  memcpy(v, a, (size_t)k * sizeof *v);
  return km_orthonormalise(V, count, k, v) &&
         km_orthonormalise(V, count, k, v); /* the second pass removes the rounding of the first */
}

/* Completes orthonormal rows by orthonormalised unit vectors. */
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

/* Replaces the basis Z by the orthogonal complement of removed tangents. */
bool km_tangents_remove(km_tangents *f, double *V, int count) {
  km_second_order *conditions = &f->conditions;
  int k = conditions->freedom, n = f->sub->columns;
  if (count == 0)
    return true;
  double *remaining = KM_ARENA_NEW(f->arena, double, (size_t)(k - count) * (size_t)n + 1);
  bool is_ok = remaining && km_tangents_complete_basis(V, count, k);
  for (int i = count; i < k && is_ok; ++i)
    km_second_order_combine(conditions, V + i * k, remaining + (size_t)(i - count) * (size_t)n);
  if (!is_ok)
    return false;
  conditions->Z = remaining;
  conditions->freedom = k - count;
  for (int i = 0; i < k - count; ++i)
    f->length[i] = -1.0;
  return true;
}
