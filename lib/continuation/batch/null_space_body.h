/* Null vectors and minimum-norm steps in a batch (theory 3.4, 3.5); part of step_body.h. Per lane the operations are
 * those of linalg and loop_closing.c. */

/* sum += (D a)·(D b) */
static inline void add_product(const km_batch *l, const km_batch_number *a, const km_batch_number *b, vector *sum,
                               int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector weight = GET(l->weight[k]);
      sum[r] += weight * GET(a[k]) * weight * GET(b[k]);
    }
}

/* Computes D times the null vector of the k-th independent column, and the square of its length. */
static inline void compute_null_vector(const km_batch *l, int k, km_batch_number *z, vector *square, int first,
                                       int count) {
  const km_recorded_elimination *elimination = &l->elimination;
  const km_batch_number *B = l->B + (size_t)k * (size_t)elimination->rank;
  const int column_k = elimination->column[elimination->rank + k];
  for (int c = elimination->rank; l->extra_freedoms > 0 && c < elimination->column_count; ++c)
    EACH(r)
  PUT(z[elimination->column[c]], all(0.0));
  EACH(r) {
    vector weight = GET(l->weight[column_k]);
    square[r] = weight * weight;
    PUT(z[column_k], weight);
  }
  for (int i = 0; i < elimination->rank; ++i) {
    int column = elimination->column[i];
    EACH(r) {
      vector value = -GET(B[i]) * GET(l->weight[column]);
      PUT(z[column], value);
      square[r] += value * value;
    }
  }
}

static inline void compute_dot(const km_batch *l, const km_batch_number *a, const km_batch_number *b, vector *dot,
                               int first, int count) {
  EACH(r)
  dot[r] = all(0.0);
  for (int j = 0; j < l->sub->columns; ++j)
    EACH(r)
  dot[r] += GET(a[j]) * GET(b[j]);
}

/* Subtracts from z its projection on the unit vector y (Gram-Schmidt). */
static inline void subtract_projection(const km_batch *l, const km_batch_number *y, km_batch_number *z, int first,
                                       int count) {
  vector dot[REGISTERS];
  compute_dot(l, y, z, dot, first, count);
  for (int j = 0; j < l->sub->columns; ++j)
    EACH(r) {
      vector value = GET(z[j]);
      PUT(z[j], pick(equal(dot[r], all(0.0)), value, value - dot[r] * GET(y[j])));
    }
}

/* Computes vectors from … to-1 of the orthonormal null space Z by Gram-Schmidt, done twice; earlier ones are known. */
static NOT_INLINED void compute_null_vectors(km_batch *l, int from, int to, int first, int count) {
  const size_t columns = (size_t)l->sub->columns;
  for (int k = from; k < to; ++k) {
    km_batch_number *z = l->Z + (size_t)k * columns;
    vector square[REGISTERS], factor[REGISTERS];
    compute_null_vector(l, k, z, square, first, count);
    for (int pass = 0; pass < 2; ++pass)
      for (int o = 0; o < k; ++o)
        subtract_projection(l, l->Z + (size_t)o * columns, z, first, count);
    if (k > 0)
      compute_dot(l, z, z, square, first, count);
    EACH(r)
    factor[r] = 1.0 / root(square[r]);
    for (int j = 0; j < l->sub->columns; ++j)
      EACH(r)
    PUT(z[j], GET(z[j]) * factor[r]);
  }
}

/* Subtracts from x its projection on the null vectors with the driver at rest, in the metric D: the minimum-norm
 * step. `part`: work [columns]. */
static NOT_INLINED void minimum_norm_step(const km_batch *l, km_batch_number *x, km_batch_number *part, int first,
                                          int count) {
  const int columns = l->sub->columns;
  for (int j = 0; j < columns; ++j)
    EACH(r)
  PUT(part[j], all(0.0));
  for (int k = 0; k < l->extra_freedoms; ++k) {
    const km_batch_number *y = l->Z + (size_t)k * (size_t)columns;
    vector dot[REGISTERS];
    EACH(r)
    dot[r] = all(0.0);
    for (int j = 0; j < columns; ++j)
      EACH(r)
    dot[r] += GET(y[j]) * GET(l->weight[j]) * GET(x[j]);
    for (int j = 0; j < columns; ++j)
      EACH(r)
    PUT(part[j], GET(part[j]) + dot[r] * GET(y[j]));
  }
  for (int j = 0; j < columns; ++j)
    EACH(r)
  PUT(x[j], GET(x[j]) - GET(part[j]) / GET(l->weight[j]));
}

/* Computes next_t, the tangent with t_driver = 1 and |D t| minimal. */
static INLINED void compute_next_tangent(km_batch *l, int first, int count) {
  const km_recorded_elimination *elimination = &l->elimination;
  const km_batch_number *B = l->B + (size_t)l->extra_freedoms * (size_t)elimination->rank;
  for (int i = 0; i < elimination->rank; ++i) {
    km_batch_number *to = &l->next_t[elimination->column[i]];
    EACH(r)
    PUT(*to, -GET(B[i]));
  }
  for (int c = elimination->rank; c < elimination->rank + l->extra_freedoms; ++c)
    EACH(r)
  PUT(l->next_t[elimination->column[c]], all(0.0));
  EACH(r)
  PUT(l->next_t[l->column], all(1.0));
  if (l->extra_freedoms > 0)
    minimum_norm_step(l, l->next_t, l->x, first, count);
}

/* Writes the mobility numbers m_j = Σ_k Z_jk² and the unit direction D t where `took` is set; several freedoms. */
static NOT_INLINED void write_numbers_of_several_freedoms(km_batch *l, const mask *took, int first, int count) {
  const int columns = l->sub->columns;
  const km_lane_row *row = l->row;
  vector sum[REGISTERS], factor[REGISTERS];
  compute_null_vectors(l, l->extra_freedoms, l->extra_freedoms + 1, first, count);
  EACH(r)
  sum[r] = all(0.0);
  add_product(l, l->t, l->t, sum, first, count);
  EACH(r)
  factor[r] = 1.0 / root(sum[r]);
  for (int j = 0; j < columns; ++j)
    EACH(r) {
      vector first_entry = GET(l->Z[j]), number = first_entry * first_entry;
      for (int k = 1; k <= l->extra_freedoms; ++k) {
        vector z = GET(l->Z[(size_t)k * (size_t)columns + (size_t)j]);
        number += z * z;
      }
      PUT(row->mobility_number[j], pick(took[r], number, GET(row->mobility_number[j])));
      PUT(row->z[j], pick(took[r], GET(l->weight[j]) * GET(l->t[j]) * factor[r], GET(row->z[j])));
    }
}
