/* Weights of variable-step Adams-Bashforth for a type T, a double or a vector of doubles; included once for each type.
 * The includer defines T and FN(name) (theory 4.7).
 *
 *   x_k = (s_k − s) / h   nodes, the present configuration first;   Σ_k w_k x_k^j = moment_j, j = 0 … nodes - 1
 *   moments  1 / (j + 1): integral over the step;   0, 1, 0 …: slope;   0, 0, 2, 0 …: curvature */

/* Weights of the tangents at the nodes, 0 behind the last one: error_weight is the difference to one tangent less,
 * slope and curvature are those of the derivatives at the present configuration, for ball joints. */
typedef struct FN(multistep) {
  T weight[KM_PATH_NODES], error_weight[KM_PATH_NODES], slope[KM_PATH_NODES], curvature[KM_PATH_NODES];
} FN(multistep);

/* Solves the dual Vandermonde system in place (Å. Björck and V. Pereyra, 1970). */
static inline void FN(solve_vandermonde)(const T *x, int count, T *moment) {
  for (int k = 0; k < count - 1; ++k)
    for (int i = count - 1; i > k; --i)
      moment[i] -= x[k] * moment[i - 1];
  for (int k = count - 2; k >= 0; --k) {
    for (int i = k + 1; i < count; ++i)
      moment[i] /= x[i] - x[i - k - 1];
    for (int i = k; i < count - 1; ++i)
      moment[i] -= moment[i + 1];
  }
}

static inline FN(multistep) FN(multistep_weights)(const T *x, int nodes, bool has_balls) {
  const T zero = {0};
  FN(multistep) w;
  T less[KM_PATH_NODES];
  for (int i = 0; i < KM_PATH_NODES; ++i) {
    w.weight[i] = zero + (i < nodes ? 1.0 / (i + 1) : 0.0);
    less[i] = zero + (i < nodes - 1 ? 1.0 / (i + 1) : 0.0);
    w.slope[i] = zero + (i == 1 ? 1.0 : 0.0);
    w.curvature[i] = zero + (i == 2 ? 2.0 : 0.0);
  }
  FN(solve_vandermonde)(x, nodes, w.weight);
  FN(solve_vandermonde)(x, nodes - 1, less);
  for (int i = 0; i < KM_PATH_NODES; ++i)
    w.error_weight[i] = w.weight[i] - less[i];
  if (has_balls) {
    FN(solve_vandermonde)(x, nodes, w.slope);
    FN(solve_vandermonde)(x, nodes, w.curvature);
  }
  return w;
}
