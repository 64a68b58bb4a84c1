/* Gauss-Jordan elimination with complete pivoting for up to 12 rows and 64 columns, in registers (docs/theory.md 3.1).
 *
 *   step with pivot (r, c):  l = J_:c / J_rc, l_r = 0;   J_:k <- J_:k − l J_rk  for all later columns k
 *
 * `reduced` keeps the multipliers l in dependent columns and the reduced entries in independent ones, from which B
 * follows by the reciprocal pivots. The search runs with the update: the maximum of integer keys, the bits of a
 * magnitude above its row and column number. So entries that are equal to 2⁻⁴², or agree in three bits of the mantissa,
 * go by position. */
#include "linalg/dense/register_elimination.h"
#include "linalg/dense/simd_pair.h"

#include <math.h>

/* Every function below has the stride as a constant and is inlined once for each stride, so that the data of each pair
 * of rows stay in registers. gcc -O2 does not unroll such loops; the macro repeats the statements for each pair i of a
 * column. */
#define INLINE static inline __attribute__((always_inline))
#define PAIR(number, ...)                                                                                              \
  if (2 * number < stride) {                                                                                           \
    enum { i = number };                                                                                               \
    __VA_ARGS__                                                                                                        \
  }
#define EACH_PAIR(...)                                                                                                 \
  do {                                                                                                                 \
    PAIR(0, __VA_ARGS__)                                                                                               \
    PAIR(1, __VA_ARGS__)                                                                                               \
    PAIR(2, __VA_ARGS__)                                                                                               \
    PAIR(3, __VA_ARGS__)                                                                                               \
    PAIR(4, __VA_ARGS__)                                                                                               \
    PAIR(5, __VA_ARGS__)                                                                                               \
  } while (0)
enum { PAIRS = KM_SMALL_ROWS / 2 };

typedef struct key_search {
  km_pair open[PAIRS]; /* key mask of rows without a pivot, 0 of the others */
  km_pair best[PAIRS]; /* largest key so far, without its row bits */
} key_search;

/* Updates the largest key by pair i of a column. */
INLINE void update_best_key(key_search *s, km_bits slot, int i, km_pair x) {
  s->best[i] = km_pair_larger(km_pair_or(km_pair_and(x, s->open[i]), (km_pair)slot), s->best[i]);
}

/* Largest key over all rows; resets the search. */
INLINE int64_t find_best_key(key_search *s, const int stride) {
  km_pair best = {0.0, 0.0};
  EACH_PAIR(best = km_pair_larger(km_pair_or(s->best[i], km_row_bits(2 * i)), best); s->best[i] = (km_pair){0.0, 0.0};);
  return km_key_bits(best);
}

/* Pair i of a column of the matrix; 0 beyond an odd number of rows. */
INLINE km_pair read_pair(const double *column, int rows, int i, const int stride) {
  if (2 * i + 2 == stride && rows < stride)
    return (km_pair){column[2 * i], 0.0};
  return km_pair_load(column + 2 * i);
}

/* Copies the matrix to `reduced`; finds its largest magnitude and the first pivot. */
INLINE int64_t load_and_search(const km_factor *p, const double *matrix, key_search *s, int candidates, double *largest,
                               const int stride) {
  const int64_t key = p->options.ties_by_position ? KM_NEAR_KEY : KM_KEY;
  const km_pair magnitude = (km_pair)(km_bits){KM_MAGNITUDE, KM_MAGNITUDE};
  km_pair scale[PAIRS];
  EACH_PAIR(scale[i] = (km_pair){0.0, 0.0}; s->open[i] = (km_pair)(km_bits){key, 2 * i + 1 < p->rows ? key : 0};
            s->best[i] = (km_pair){0.0, 0.0};);
  const int rows = p->rows, columns = p->columns, *const column = p->column;
  double *const reduced = p->reduced;
  km_bits slot = km_slot_bits(0);
  for (int k = 0; k < columns; ++k, slot -= KM_NEXT_SLOT) {
    const double *from = matrix + (ptrdiff_t)column[k] * rows;
    km_pair *to = (km_pair *)(reduced + (ptrdiff_t)column[k] * stride);
    km_pair x[PAIRS];
    EACH_PAIR(to[i] = x[i] = read_pair(from, rows, i, stride);
              scale[i] = km_pair_larger(km_pair_and(x[i], magnitude), scale[i]););
    if (k < candidates)
      EACH_PAIR(update_best_key(s, slot, i, x[i]););
  }
  EACH_PAIR(scale[0] = km_pair_larger(scale[i], scale[0]););
  *largest = scale[0][0] > scale[0][1] ? scale[0][0] : scale[0][1];
  return find_best_key(s, stride);
}

/* Searches the columns from … columns-1 after all earlier ones are used. */
INLINE int64_t search_columns(const km_factor *p, key_search *s, int from, const int stride) {
  km_bits slot = km_slot_bits(from);
  for (int k = from; k < p->columns; ++k, slot -= KM_NEXT_SLOT) {
    const km_pair *x = (const km_pair *)(p->reduced + (ptrdiff_t)p->column[k] * stride);
    EACH_PAIR(update_best_key(s, slot, i, x[i]););
  }
  return find_best_key(s, stride);
}

/* Multipliers l of a step, which replace the pivot column. */
INLINE void compute_multipliers(const km_factor *p, int step, int row, km_pair *l, km_pair *not_pivot_row,
                                const int stride) {
  double *column = p->reduced + (ptrdiff_t)p->column[step] * stride;
  double inverse = 1.0 / column[row], r = row;
  p->inverse[step] = inverse;
  p->row[step] = row;
  EACH_PAIR(not_pivot_row[i] = (km_pair)((km_pair){2 * i, 2 * i + 1} != (km_pair){r, r});
            l[i] = km_pair_and(((km_pair *)column)[i] * (km_pair){inverse, inverse}, not_pivot_row[i]);
            ((km_pair *)column)[i] = l[i];);
}

/* Elimination step, and search for the next pivot among columns step+1 … candidates-1. */
INLINE int64_t eliminate_and_search(const km_factor *p, key_search *s, int step, int row, int candidates,
                                    const int stride) {
  km_pair l[PAIRS];
  km_pair not_pivot_row[PAIRS];
  compute_multipliers(p, step, row, l, not_pivot_row, stride);
  EACH_PAIR(s->open[i] = km_pair_and(s->open[i], not_pivot_row[i]););
  const int columns = p->columns, *const order = p->column;
  double *const reduced = p->reduced;
  km_bits slot = km_slot_bits(step + 1);
  int k = step + 1;
  for (; k < candidates; ++k, slot -= KM_NEXT_SLOT) {
    double *column = reduced + (ptrdiff_t)order[k] * stride, u = column[row];
    EACH_PAIR(km_pair x = ((km_pair *)column)[i] - l[i] * (km_pair){u, u}; ((km_pair *)column)[i] = x;
              update_best_key(s, slot, i, x););
  }
  for (; k < columns; ++k) {
    double *column = reduced + (ptrdiff_t)order[k] * stride, u = column[row];
    EACH_PAIR(((km_pair *)column)[i] -= l[i] * (km_pair){u, u};);
  }
  return find_best_key(s, stride);
}

INLINE double magnitude_at(const km_factor *p, int position, const int stride) {
  return fabs(p->reduced[(ptrdiff_t)p->column[km_place_slot(position)] * stride + km_place_row(position)]);
}

/* Position of the key. It mostly equals that of the last search: a predicted branch hides the latency of the maximum.
 * The result does not depend on the guess. */
INLINE int decode_position(const km_factor *p, int step, int64_t key) {
  int found = km_key_place(key), last = p->pivot_guess[step], position = last;
  __asm__("" : "+r"(position)); /* hides from the compiler that position equals `last`, so that the branch stays */
  if (__builtin_expect(found != last, 0))
    p->pivot_guess[step] = position = found;
  return position;
}

/* Elimination with complete pivoting; forced columns after `candidates` are tried last. */
INLINE void factor_with_stride(km_factor *p, const double *matrix, int candidates, double tolerance, const int stride) {
  key_search s;
  int64_t key = load_and_search(p, matrix, &s, candidates, &p->scale, stride);
  double threshold = tolerance * p->scale;
  int max_rank = p->rows < p->columns ? p->rows : p->columns, step = 0;
  for (; step < max_rank; ++step) {
    int position = 0;
    double size = 0.0;
    if (km_key_is_valid(key)) {
      position = decode_position(p, step, key);
      size = magnitude_at(p, position, stride);
    }
    if (!(size > threshold) && candidates < p->columns && !p->options.forced_never_pivot) {
      key = search_columns(p, &s, candidates, stride);
      position = km_key_place(key);
      size = km_key_is_valid(key) ? magnitude_at(p, position, stride) : 0.0;
      candidates = p->columns;
      p->forced_dependent = size > threshold;
    }
    if (!(size > threshold)) {
      p->first_dropped = size > 0.0 ? size : 0.0;
      break;
    }
    int slot = km_place_slot(position), column = p->column[slot];
    p->column[slot] = p->column[step];
    p->column[step] = column;
    key = eliminate_and_search(p, &s, step, km_place_row(position), candidates, stride);
    p->first_pivot = step == 0 ? size : p->first_pivot;
    p->last_pivot = size;
    p->smallest_pivot = size < p->smallest_pivot ? size : p->smallest_pivot;
  }
  p->rank = step;
}

/* Elimination with known pivots. False if a value is not finite. */
INLINE bool refactor_with_stride(const km_factor *in, const double *matrix, const int stride) {
  const km_factor own = *in, *const p = &own; /* a copy in registers, which stores below cannot change */
  km_pair not_finite = {0.0, 0.0};            /* sum of x − x: 0, or NaN */
  for (int k = 0; k < p->columns; ++k) {
    km_pair *to = (km_pair *)(p->reduced + (ptrdiff_t)k * stride);
    EACH_PAIR(km_pair x = read_pair(matrix + (ptrdiff_t)k * p->rows, p->rows, i, stride); to[i] = x;
              not_finite += x - x;);
  }
  for (int step = 0; step < p->rank; ++step) {
    km_pair l[PAIRS];
    km_pair not_pivot_row[PAIRS];
    int row = p->row[step];
    compute_multipliers(p, step, row, l, not_pivot_row, stride);
    for (int k = step + 1; k < p->columns; ++k) {
      double *column = p->reduced + (ptrdiff_t)p->column[k] * stride, u = column[row];
      EACH_PAIR(((km_pair *)column)[i] -= l[i] * (km_pair){u, u};);
    }
  }
  return not_finite[0] + not_finite[1] == 0.0;
}

void km_register_factor(km_factor *p, const double *matrix, int candidates, double tolerance) {
  switch (p->stride) {
  case 2:
    factor_with_stride(p, matrix, candidates, tolerance, 2);
    break;
  case 4:
    factor_with_stride(p, matrix, candidates, tolerance, 4);
    break;
  case 6:
    factor_with_stride(p, matrix, candidates, tolerance, 6);
    break;
  case 8:
    factor_with_stride(p, matrix, candidates, tolerance, 8);
    break;
  case 10:
    factor_with_stride(p, matrix, candidates, tolerance, 10);
    break;
  default:
    factor_with_stride(p, matrix, candidates, tolerance, 12);
    break;
  }
}

/* Gauss-Jordan elimination with known pivots, by the instance for the stride. False if a value is not finite. */
bool km_register_refactor(const km_factor *p, const double *matrix) {
  switch (p->stride) {
  case 2:
    return refactor_with_stride(p, matrix, 2);
  case 4:
    return refactor_with_stride(p, matrix, 4);
  case 6:
    return refactor_with_stride(p, matrix, 6);
  case 8:
    return refactor_with_stride(p, matrix, 8);
  case 10:
    return refactor_with_stride(p, matrix, 10);
  default:
    return refactor_with_stride(p, matrix, 12);
  }
}
