/* Orthonormal bases of null spaces and of subspaces of the tangents. */
#include "local/local_private.h"

#include "linalg/factor.h"

#include <string.h>

int km_dense_null_space(const double *A, int rows, int columns, double tolerance, km_arena *arena, double **N) {
  km_arena scratch = {0};
  km_factor *p = km_factor_create(rows, columns, NULL, &scratch);
  int dimension = -1;
  if (p) {
    km_factor_compute(p, A, rows, columns, &(km_factor_options){.tolerance = tolerance});
    dimension = km_factor_freedom(p);
    *N = KM_ARENA_NEW(arena, double, (size_t)dimension *(size_t)columns + 1);
    const double *Z = *N ? km_factor_null_space(p, dimension) : NULL;
    if (Z)
      memcpy(*N, Z, (size_t)dimension * (size_t)columns * sizeof *Z);
    dimension = Z ? dimension : -1;
  }
  km_arena_free(&scratch);
  return dimension;
}

/* One Gram-Schmidt step: v minus its projection onto the basis, normalised. */
double km_orthonormalise(const double *basis, int count, int size, double *v) {
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
  return sqrt(square);
}

/* Gram-Schmidt, twice: the second pass removes the rounding of the first. */
bool km_append_orthonormal(double *V, int count, int size, const double *a) {
  double *v = V + (size_t)count * (size_t)size;
  memcpy(v, a, (size_t)size * sizeof *v);
  return km_orthonormalise(V, count, size, v) > KM_INDEPENDENT && km_orthonormalise(V, count, size, v) > KM_INDEPENDENT;
}

/* Completes orthonormal rows by orthonormalised unit vectors. */
bool km_complete_basis(double *V, int count, int size) {
  double *unit = KM_NEW(double, (size_t)size + 1);
  for (int i = 0; i < size && count < size && unit; ++i) {
    memset(unit, 0, (size_t)size * sizeof *unit);
    unit[i] = 1.0;
    count += km_append_orthonormal(V, count, size, unit);
  }
  km_free(unit);
  return count == size;
}
