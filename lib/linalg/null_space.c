/* Orthonormal null and row spaces from a partition, and mobility numbers (docs/theory.md 3.4).
 *
 *   Z = orth(D [−B; I]),   R = orth([I B] D⁻¹)   by modified Gram-Schmidt, twice;    m_j = Σ_k Z_jk² */
#include "base/number/vectors.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/factor_private.h"

#include <math.h>
#include <string.h>

static void scale(double *z, int count, double factor) {
  for (int i = 0; i < count; ++i)
    z[i] *= factor;
}

/* Modified Gram-Schmidt, twice: with a forced driver near its dead point N is ill-conditioned, and one pass loses as
 * much orthogonality. The first vector has length 1; vectors before `first` are orthonormal. */
static void orthonormalise(double *Z, int columns, int first, int count) {
  size_t n = (size_t)columns;
  for (int k = first > 1 ? first : 1; k < count; ++k) {
    double *z = Z + (size_t)k * n;
    for (int pass = 0; pass < 2; ++pass) {
      for (int o = 0; o < k; ++o) {
        const double *y = Z + (size_t)o * n;
        double overlap = count > KM_MANY_VECTORS ? km_pair_dot(y, z, columns) : km_dot(y, z, columns);
        if (overlap == 0.0)
          continue;
        for (size_t i = 0; i < n; ++i)
          z[i] -= overlap * y[i];
      }
    }
    scale(z, columns, 1.0 / sqrt(km_dot(z, z, columns)));
  }
}

/* Writes D times null vector k; returns its squared length. */
static double write_null_vector(const km_factor *p, int k, double *z) {
  const int rank = p->rank, *const column = p->column;
  const double *b = km_factor_b(p, k), *const weight = p->weight;
  for (int c = rank; c < p->columns; ++c)
    z[column[c]] = 0.0;
  double weight_of_independent = weight[column[rank + k]], sum = weight_of_independent * weight_of_independent;
  z[column[rank + k]] = weight_of_independent;
  for (int i = 0; i < rank; ++i) {
    double value = -b[i] * weight[column[i]];
    z[column[i]] = value;
    sum += value * value;
  }
  return sum;
}

/* Null vectors first … count-1, orthonormalised against those before them. */
void km_factor_extend_null_space(const km_factor *p, int first, int count, double *Z) {
  for (int k = first; k < count; ++k) {
    double square = write_null_vector(p, k, Z + (size_t)k * (size_t)p->columns);
    if (k == 0)
      scale(Z, p->columns, 1.0 / sqrt(square));
  }
  orthonormalise(Z, p->columns, first, count);
}

/* Memory of a basis of `count` vectors. NULL when out of memory; then the factor has failed. */
static double *reserve_basis(km_factor *p, int count) {
  size_t size = (size_t)count * (size_t)p->columns + 1;
  bool is_ok = size <= p->Z_capacity || km_arena_grow(p->arena, (void **)&p->Z, &p->Z_capacity, size, sizeof *p->Z);
  p->failed = p->failed || !is_ok;
  return is_ok ? p->Z : NULL;
}

double *km_factor_null_space(km_factor *p, int count) {
  int known = p->Z_version == p->version ? p->Z_count : 0;
  if (known >= count && p->Z)
    return p->Z;
  double *Z = reserve_basis(p, count);
  if (Z)
    km_factor_extend_null_space(p, known, count, Z);
  p->Z_count = Z ? count : 0;
  p->Z_version = p->version;
  return Z;
}

int km_factor_known_null_vectors(const km_factor *p) {
  return p->Z_count;
}

void km_factor_set_null_vector(km_factor *p, const double *z, size_t stride) {
  double *Z = reserve_basis(p, 1);
  for (int k = 0; Z && k < p->columns; ++k)
    Z[k] = z[(size_t)k * stride];
  p->Z_count = Z != NULL;
  p->Z_version = p->version;
  p->is_cached = false; /* the vector need not be that of the matrix factored last */
}

/* Writes the rows of [I B] D⁻¹, a basis of the row space; returns the squared length of the first one. */
static double write_row_vectors(const km_factor *p, int count, double *R) {
  const int rank = p->rank, *const column = p->column;
  const double *const weight = p->weight;
  size_t n = (size_t)p->columns;
  double square = 0.0;
  memset(R, 0, (size_t)rank * n * sizeof *R);
  for (int i = 0; i < rank; ++i)
    R[(size_t)i * n + (size_t)column[i]] = 1.0 / weight[column[i]];
  for (int k = 0; k < count; ++k) {
    const double *b = km_factor_b(p, k);
    int c = column[rank + k];
    for (int i = 0; i < rank; ++i)
      R[(size_t)i * n + (size_t)c] = b[i] / weight[c];
  }
  for (int k = -1; k < count && rank > 0; ++k) {
    double entry = R[column[k < 0 ? 0 : rank + k]];
    square += entry * entry;
  }
  return square;
}

/* Orthonormal row space: Gram-Schmidt on [I B] D⁻¹. */
void km_factor_write_row_space(const km_factor *p, int count, double *R) {
  double square = write_row_vectors(p, count, R);
  if (p->rank > 0)
    scale(R, p->columns, 1.0 / sqrt(square));
  orthonormalise(R, p->columns, 0, p->rank);
}

double *km_factor_row_space(km_factor *p, int count) {
  double *R = reserve_basis(p, p->rank);
  p->Z_count = 0;
  if (R)
    km_factor_write_row_space(p, count, R);
  return R;
}

/* m_j = Σ_k Z_jk². */
void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers) {
  for (int j = 0; j < columns; ++j)
    numbers[j] = freedom > 0 ? Z[j] * Z[j] : 0.0;
  for (int k = 1; k < freedom; ++k) {
    const double *z = Z + (size_t)k * (size_t)columns;
    for (int j = 0; j < columns; ++j)
      numbers[j] += z[j] * z[j];
  }
}
