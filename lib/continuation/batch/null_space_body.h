/* Null vectors and least steps of several drives in vectors: a part of lanes_body.h. What is computed for a lane is what
 * linalg/null_space.c and closure.c compute for one drive. */

/* sum += (D a)·(D b) */
static inline void add_product(const km_batch *l, const km_batch_number *a, const km_batch_number *b, vector *sum,
                               int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector weight = GET(l->weight[k]);
      sum[r] += weight * GET(a[k]) * weight * GET(b[k]);
    }
}

/* diag(weight) times the null vector of independent column k; and the square of its length. null_vector of partition/null.c. */
static inline void set_null_vector(const km_batch *l, int k, km_batch_number *z, vector *square, int first, int count) {
  const km_recorded_elimination *replay = &l->replay;
  const km_batch_number *B = l->B + (size_t)k * (size_t)replay->rank;
  const int own = replay->column[replay->rank + k];
  for (int c = replay->rank; l->beside > 0 && c < replay->column_count; ++c)
    EACH(r)
  PUT(z[replay->column[c]], all(0.0));
  EACH(r) {
    vector weight = GET(l->weight[own]);
    square[r] = weight * weight;
    PUT(z[own], weight);
  }
  for (int i = 0; i < replay->rank; ++i) {
    int column = replay->column[i];
    EACH(r) {
      vector value = -GET(B[i]) * GET(l->weight[column]);
      PUT(z[column], value);
      square[r] += value * value;
    }
  }
}

static inline void find_dot(const km_batch *l, const km_batch_number *a, const km_batch_number *b, vector *dot,
                            int first, int count) {
  EACH(r)
  dot[r] = all(0.0);
  for (int j = 0; j < l->sub->columns; ++j)
    EACH(r)
  dot[r] += GET(a[j]) * GET(b[j]);
}

/* z loses its part along the unit vector y. */
static inline void subtract_part(const km_batch *l, const km_batch_number *y, km_batch_number *z, int first,
                                 int count) {
  vector dot[TOGETHER];
  find_dot(l, y, z, dot, first, count);
  for (int j = 0; j < l->sub->columns; ++j)
    EACH(r) {
      vector value = GET(z[j]);
      PUT(z[j], pick(equal(dot[r], all(0.0)), value, value - dot[r] * GET(y[j])));
    }
}

/* Vectors from … to-1 of the orthonormal null space; those before are known. km_partition_extend_null_space. */
static APART void find_null_vectors(km_batch *l, int from, int to, int first, int count) {
  const size_t columns = (size_t)l->sub->columns;
  for (int k = from; k < to; ++k) {
    km_batch_number *z = l->Z + (size_t)k * columns;
    vector square[TOGETHER], factor[TOGETHER];
    set_null_vector(l, k, z, square, first, count);
    for (int pass = 0; pass < 2; ++pass)
      for (int o = 0; o < k; ++o)
        subtract_part(l, l->Z + (size_t)o * columns, z, first, count);
    if (k > 0)
      find_dot(l, z, z, square, first, count);
    EACH(r)
    factor[r] = 1.0 / root(square[r]);
    for (int j = 0; j < l->sub->columns; ++j)
      EACH(r)
    PUT(z[j], GET(z[j]) * factor[r]);
  }
}

/* km_minimum_norm_step, by the vectors that leave the driver alone. `part`: room for [columns]. */
static APART void least_step(const km_batch *l, km_batch_number *x, km_batch_number *part, int first, int count) {
  const int columns = l->sub->columns;
  for (int j = 0; j < columns; ++j)
    EACH(r)
  PUT(part[j], all(0.0));
  for (int k = 0; k < l->beside; ++k) {
    const km_batch_number *y = l->Z + (size_t)k * (size_t)columns;
    vector dot[TOGETHER];
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

/* km_minimum_norm_rates. */
static WITHIN void set_next_tangent(km_batch *l, int first, int count) {
  const km_recorded_elimination *replay = &l->replay;
  const km_batch_number *B = l->B + (size_t)l->beside * (size_t)replay->rank;
  for (int i = 0; i < replay->rank; ++i) {
    km_batch_number *to = &l->next_t[replay->column[i]];
    EACH(r)
    PUT(*to, -GET(B[i]));
  }
  for (int c = replay->rank; c < replay->rank + l->beside; ++c)
    EACH(r)
  PUT(l->next_t[replay->column[c]], all(0.0));
  EACH(r)
  PUT(l->next_t[l->column], all(1.0));
  if (l->beside > 0)
    least_step(l, l->next_t, l->x, first, count);
}

/* Mobility numbers where `took` is set, and the direction of the driver's motion. */
static APART void set_numbers_of_several(km_batch *l, const mask *took, int first, int count) {
  const int columns = l->sub->columns;
  const km_lane_row *row = l->row;
  vector sum[TOGETHER], factor[TOGETHER];
  find_null_vectors(l, l->beside, l->beside + 1, first, count);
  EACH(r)
  sum[r] = all(0.0);
  add_product(l, l->t, l->t, sum, first, count);
  EACH(r)
  factor[r] = 1.0 / root(sum[r]);
  for (int j = 0; j < columns; ++j)
    EACH(r) {
      vector first_one = GET(l->Z[j]), number = first_one * first_one;
      for (int k = 1; k <= l->beside; ++k) {
        vector z = GET(l->Z[(size_t)k * (size_t)columns + (size_t)j]);
        number += z * z;
      }
      PUT(row->numbers[j], pick(took[r], number, GET(row->numbers[j])));
      PUT(row->z[j], pick(took[r], GET(l->weight[j]) * GET(l->t[j]) * factor[r], GET(row->z[j])));
    }
}
