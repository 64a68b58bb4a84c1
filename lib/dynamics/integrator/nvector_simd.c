/* Vector operations of CVODE's steps in SIMD lanes; CVODE's serial ones process one component at a time. */
#include "dynamics/simulation.h"

#include <nvector/nvector_serial.h>

typedef double lane4 __attribute__((vector_size(32), aligned(16), may_alias));

_Static_assert(sizeof(lane4) == KM_VECTOR_LANES * sizeof(double),
               "a lane holds as many components as lengths are multiples of");

static inline lane4 *lanes_of(N_Vector v) {
  return (lane4 *)NV_DATA_S(v);
}

static inline sunindextype count_of(N_Vector v) {
  return NV_LENGTH_S(v) / KM_VECTOR_LANES;
}

/* z = a x + b y. */
static void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z) {
  const lane4 *from = lanes_of(x), *other = lanes_of(y);
  lane4 *to = lanes_of(z);
  sunindextype count = count_of(x);
  if (a == 1.0 && b == 1.0)
    for (sunindextype i = 0; i < count; ++i)
      to[i] = from[i] + other[i];
  else
    for (sunindextype i = 0; i < count; ++i)
      to[i] = a * from[i] + b * other[i];
}

static void scale(realtype a, N_Vector x, N_Vector z) {
  const lane4 *from = lanes_of(x);
  lane4 *to = lanes_of(z);
  for (sunindextype i = 0; i < count_of(x); ++i)
    to[i] = a * from[i];
}

static void set_all(realtype a, N_Vector z) {
  lane4 *to = lanes_of(z), value = {a, a, a, a};
  for (sunindextype i = 0; i < count_of(z); ++i)
    to[i] = value;
}

/* Weighted root mean square √(Σ (x w)²/n). */
static realtype weighted_norm(N_Vector x, N_Vector w) {
  const lane4 *value = lanes_of(x), *weight = lanes_of(w);
  lane4 sum = {0.0, 0.0, 0.0, 0.0};
  for (sunindextype i = 0; i < count_of(x); ++i) {
    lane4 part = value[i] * weight[i];
    sum += part * part;
  }
  return sqrt(((sum[0] + sum[1]) + (sum[2] + sum[3])) / (double)NV_LENGTH_S(x));
}

static int scale_add_multi(int count, realtype *a, N_Vector x, N_Vector *y, N_Vector *z) {
  for (int k = 0; k < count; ++k)
    linear_sum(a[k], x, 1.0, y[k], z[k]);
  return 0;
}

static int scale_array(int count, realtype *a, N_Vector *x, N_Vector *z) {
  for (int k = 0; k < count; ++k)
    scale(a[k], x[k], z[k]);
  return 0;
}

/* z = Σ a_k x_k. */
static int combine(int count, realtype *a, N_Vector *x, N_Vector z) {
  lane4 *to = lanes_of(z);
  for (sunindextype i = 0; i < count_of(z); ++i) {
    lane4 sum = a[0] * lanes_of(x[0])[i];
    for (int k = 1; k < count; ++k)
      sum += a[k] * lanes_of(x[k])[i];
    to[i] = sum;
  }
  return 0;
}

void km_vector_use_lanes(void *vector) {
  N_Vector v = (N_Vector)vector;
  v->ops->nvlinearsum = linear_sum;
  v->ops->nvscale = scale;
  v->ops->nvconst = set_all;
  v->ops->nvwrmsnorm = weighted_norm;
  v->ops->nvscaleaddmulti = scale_add_multi;
  v->ops->nvscalevectorarray = scale_array;
  v->ops->nvlinearcombination = combine;
}
