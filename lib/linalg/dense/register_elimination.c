/* Gauss-Jordan elimination with complete pivoting for up to 12 rows and 64 columns, in registers.
 *
 * For pivot row r and column c of step i, with p = 1/J_rc, every other row k subtracts J_kc p times row r; in a column
 * that is dependent already `reduced` keeps these multiples, in an independent one what is left of the column, from
 * which B = J_pd⁻¹ J_pi follows by the pivots' reciprocals. A refactor replays the steps on new values.
 * The largest entry is found by integer keys: the bits of its magnitude above the number of its row and column, so
 * that entries equal to 2^-42 go by place, or those that agree in the mantissa's first three bits. */
#include "linalg/dense/register_elimination.h"
#include "linalg/dense/simd_pair.h"

#include <math.h>

/* Every function below takes the stride as a constant and is inlined, once for each stride: what is kept for each
 * pair of rows then stays in registers. gcc -O2 leaves such loops rolled up, hence the macro: statements for each
 * pair i of a column. */
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

typedef struct search {
  km_pair open[PAIRS]; /* key mask of rows that hold no pivot yet, 0 of the others */
  km_pair best[PAIRS]; /* the largest key so far, without its row */
} search;

INLINE void note(search *s, km_bits slot, int i, km_pair x) {
  s->best[i] = km_pair_larger(km_pair_or(km_pair_and(x, s->open[i]), (km_pair)slot), s->best[i]);
}

INLINE int64_t take_best(search *s, const int stride) {
  km_pair best = {0.0, 0.0};
  EACH_PAIR(best = km_pair_larger(km_pair_or(s->best[i], km_row_bits(2 * i)), best); s->best[i] = (km_pair){0.0, 0.0};);
  return km_key_bits(best);
}

/* Pair i of a column of the matrix; beyond an odd number of rows 0. */
INLINE km_pair read(const double *column, int rows, int i, const int stride) {
  if (2 * i + 2 == stride && rows < stride)
    return (km_pair){column[2 * i], 0.0};
  return km_pair_load(column + 2 * i);
}

INLINE int64_t load(const km_partition *p, const double *matrix, search *s, int candidates, double *largest,
                    const int stride) {
  const int64_t key = p->ties_by_position ? KM_NEAR_KEY : KM_KEY;
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
    EACH_PAIR(to[i] = x[i] = read(from, rows, i, stride);
              scale[i] = km_pair_larger(km_pair_and(x[i], magnitude), scale[i]););
    if (k < candidates)
      EACH_PAIR(note(s, slot, i, x[i]););
  }
  EACH_PAIR(scale[0] = km_pair_larger(scale[i], scale[0]););
  *largest = scale[0][0] > scale[0][1] ? scale[0][0] : scale[0][1];
  return take_best(s, stride);
}

/* Only the columns from … columns-1, when those before are used up. */
INLINE int64_t look(const km_partition *p, search *s, int from, const int stride) {
  km_bits slot = km_slot_bits(from);
  for (int k = from; k < p->columns; ++k, slot -= KM_NEXT_SLOT) {
    const km_pair *x = (const km_pair *)(p->reduced + (ptrdiff_t)p->column[k] * stride);
    EACH_PAIR(note(s, slot, i, x[i]););
  }
  return take_best(s, stride);
}

/* Subtracts the pivot row from the others; the multiples take the pivot column's place. */
INLINE void multiples(const km_partition *p, int step, int row, km_pair *l, km_pair *others, const int stride) {
  double *column = p->reduced + (ptrdiff_t)p->column[step] * stride;
  double inverse = 1.0 / column[row], r = row;
  p->inverse[step] = inverse;
  p->row[step] = row;
  EACH_PAIR(others[i] = (km_pair)((km_pair){2 * i, 2 * i + 1} != (km_pair){r, r});
            l[i] = km_pair_and(((km_pair *)column)[i] * (km_pair){inverse, inverse}, others[i]);
            ((km_pair *)column)[i] = l[i];);
}

/* A step of elimination, and the search for the next one among columns step+1 … candidates-1. */
INLINE int64_t eliminate(const km_partition *p, search *s, int step, int row, int candidates, const int stride) {
  km_pair l[PAIRS];
  km_pair others[PAIRS];
  multiples(p, step, row, l, others, stride);
  EACH_PAIR(s->open[i] = km_pair_and(s->open[i], others[i]););
  const int columns = p->columns, *const order = p->column;
  double *const reduced = p->reduced;
  km_bits slot = km_slot_bits(step + 1);
  int k = step + 1;
  for (; k < candidates; ++k, slot -= KM_NEXT_SLOT) {
    double *column = reduced + (ptrdiff_t)order[k] * stride, u = column[row];
    EACH_PAIR(km_pair x = ((km_pair *)column)[i] - l[i] * (km_pair){u, u}; ((km_pair *)column)[i] = x;
              note(s, slot, i, x););
  }
  for (; k < columns; ++k) {
    double *column = reduced + (ptrdiff_t)order[k] * stride, u = column[row];
    EACH_PAIR(((km_pair *)column)[i] -= l[i] * (km_pair){u, u};);
  }
  return take_best(s, stride);
}

INLINE double size_at(const km_partition *p, int place, const int stride) {
  return fabs(p->reduced[(ptrdiff_t)p->column[km_place_slot(place)] * stride + km_place_row(place)]);
}

/* The place that the key names. Mostly it is that of the last search: a predicted branch hides the time that finding the
 * maximum takes. The result is the same either way. */
INLINE int take_place(const km_partition *p, int step, int64_t key) {
  int found = km_key_place(key), last = p->pivot_guess[step], place = last;
  __asm__("" : "+r"(place)); /* that place is `last` is nothing to reason from: the branch must stay */
  if (__builtin_expect(found != last, 0))
    p->pivot_guess[step] = place = found;
  return place;
}

INLINE void factor(km_partition *p, const double *matrix, int candidates, double tolerance, const int stride) {
  search s;
  int64_t key = load(p, matrix, &s, candidates, &p->scale, stride);
  double threshold = tolerance * p->scale;
  int most = p->rows < p->columns ? p->rows : p->columns, step = 0;
  for (; step < most; ++step) {
    int place = 0;
    double size = 0.0;
    if (km_key_is_valid(key)) {
      place = take_place(p, step, key);
      size = size_at(p, place, stride);
    }
    if (!(size > threshold) && candidates < p->columns && !p->forced_never_pivot) {
      key = look(p, &s, candidates, stride);
      place = km_key_place(key);
      size = km_key_is_valid(key) ? size_at(p, place, stride) : 0.0;
      candidates = p->columns;
      p->forced_dependent = size > threshold;
    }
    if (!(size > threshold)) {
      p->first_dropped = size > 0.0 ? size : 0.0;
      break;
    }
    int slot = km_place_slot(place), column = p->column[slot];
    p->column[slot] = p->column[step];
    p->column[step] = column;
    key = eliminate(p, &s, step, km_place_row(place), candidates, stride);
    p->first_pivot = step == 0 ? size : p->first_pivot;
    p->last_pivot = size;
    p->smallest_pivot = size < p->smallest_pivot ? size : p->smallest_pivot;
  }
  p->rank = step;
}

INLINE bool refactor(const km_partition *in, const double *matrix, const int stride) {
  const km_partition own = *in, *const p = &own; /* in registers: nothing that is stored below can change it */
  km_pair poison = {0.0, 0.0};                   /* x − x: 0, or not a number */
  for (int k = 0; k < p->columns; ++k) {
    km_pair *to = (km_pair *)(p->reduced + (ptrdiff_t)k * stride);
    EACH_PAIR(km_pair x = read(matrix + (ptrdiff_t)k * p->rows, p->rows, i, stride); to[i] = x; poison += x - x;);
  }
  for (int step = 0; step < p->rank; ++step) {
    km_pair l[PAIRS];
    km_pair others[PAIRS];
    int row = p->row[step];
    multiples(p, step, row, l, others, stride);
    for (int k = step + 1; k < p->columns; ++k) {
      double *column = p->reduced + (ptrdiff_t)p->column[k] * stride, u = column[row];
      EACH_PAIR(((km_pair *)column)[i] -= l[i] * (km_pair){u, u};);
    }
  }
  return poison[0] + poison[1] == 0.0;
}

void km_register_factor(km_partition *p, const double *matrix, int candidates, double tolerance) {
  switch (p->stride) {
  case 2:
    factor(p, matrix, candidates, tolerance, 2);
    break;
  case 4:
    factor(p, matrix, candidates, tolerance, 4);
    break;
  case 6:
    factor(p, matrix, candidates, tolerance, 6);
    break;
  case 8:
    factor(p, matrix, candidates, tolerance, 8);
    break;
  case 10:
    factor(p, matrix, candidates, tolerance, 10);
    break;
  default:
    factor(p, matrix, candidates, tolerance, 12);
    break;
  }
}

bool km_register_refactor(const km_partition *p, const double *matrix) {
  switch (p->stride) {
  case 2:
    return refactor(p, matrix, 2);
  case 4:
    return refactor(p, matrix, 4);
  case 6:
    return refactor(p, matrix, 6);
  case 8:
    return refactor(p, matrix, 8);
  case 10:
    return refactor(p, matrix, 10);
  default:
    return refactor(p, matrix, 12);
  }
}
