#include "partition/small.h"
#include "partition/pair.h"

#include <math.h>

/* Every function below takes the stride as a constant and is inlined, once for each stride: the loops over a
 * column's pairs are then unrolled, and what is kept for each row stays in registers. */
#define INLINE  static inline __attribute__((always_inline))
#define EACH(i) _Pragma("GCC unroll 6") for (int i = 0; i < stride / 2; ++i)
enum { PAIRS = KM_SMALL_ROWS / 2 };

typedef struct search {
  km_bits open[PAIRS];  /* key mask of rows that hold no pivot yet, 0 of the others */
  km_bits place[PAIRS]; /* of slot 0 */
  km_pair best[PAIRS];
} search;

INLINE void note(search *s, int slot, int i, km_pair x) {
  s->best[i] = km_pair_larger(km_pair_key(x, s->open[i], s->place[i] - km_place_slot(slot)), s->best[i]);
}

INLINE int64_t take_best(search *s, const int stride) {
  km_pair best = s->best[0];
  EACH(i) {
    best = km_pair_larger(s->best[i], best);
    s->best[i] = (km_pair){0.0, 0.0};
  }
  return km_key_bits(best);
}

/* Pair i of a column of the matrix; beyond an odd number of rows 0. */
INLINE km_pair read(const double *column, int rows, int i, const int stride) {
  if (2 * i + 2 == stride && rows < stride)
    return (km_pair){column[2 * i], 0.0};
  return km_pair_load(column + 2 * i);
}

INLINE int64_t load(km_partition *p, const double *matrix, search *s, int candidates, const int stride) {
  km_pair scale = {0.0, 0.0};
  EACH(i) {
    s->open[i] = (km_bits){KM_KEY, 2 * i + 1 < p->rows ? KM_KEY : 0};
    s->place[i] = km_place(2 * i);
    s->best[i] = (km_pair){0.0, 0.0};
  }
  const int rows = p->rows, columns = p->columns, *const column = p->column;
  double *const reduced = p->reduced;
  for (int k = 0; k < columns; ++k) {
    const double *from = matrix + (size_t)(column[k] * rows);
    km_pair *to = (km_pair *)(reduced + (size_t)(column[k] * stride));
    EACH(i) {
      km_pair x = read(from, rows, i, stride);
      to[i] = x;
      scale = km_pair_larger(km_pair_masked(x, (km_bits){KM_MAGNITUDE, KM_MAGNITUDE}), scale);
      if (k < candidates)
        note(s, k, i, x);
    }
  }
  p->scale = scale[0] > scale[1] ? scale[0] : scale[1];
  return take_best(s, stride);
}

/* Only the columns from … columns-1, when those before are used up. */
INLINE int64_t look(const km_partition *p, search *s, int from, const int stride) {
  for (int k = from; k < p->columns; ++k) {
    const km_pair *x = (const km_pair *)(p->reduced + (size_t)(p->column[k] * stride));
    EACH(i) note(s, k, i, x[i]);
  }
  return take_best(s, stride);
}

/* Subtracts the pivot row from the others; the multiples take the pivot column's place. */
INLINE void multiples(km_partition *p, int step, int row, km_pair *l, km_bits *others, const int stride) {
  double *column = p->reduced + (size_t)(p->column[step] * stride);
  double inverse = 1.0 / column[row], r = row;
  p->inverse[step] = inverse;
  p->row[step] = row;
  EACH(i) {
    others[i] = (km_bits)((km_pair){2 * i, 2 * i + 1} != (km_pair){r, r});
    l[i] = km_pair_masked(((km_pair *)column)[i] * (km_pair){inverse, inverse}, others[i]);
    ((km_pair *)column)[i] = l[i];
  }
}

/* A step of elimination, and the search for the next one among columns step+1 … candidates-1. */
INLINE int64_t eliminate(km_partition *p, search *s, int step, int row, int candidates, const int stride) {
  km_pair l[PAIRS];
  km_bits others[PAIRS];
  multiples(p, step, row, l, others, stride);
  EACH(i) s->open[i] &= others[i];
  const int columns = p->columns, *const order = p->column;
  double *const reduced = p->reduced;
  int k = step + 1;
  for (; k < candidates; ++k) {
    double *column = reduced + (size_t)(order[k] * stride), u = column[row];
    EACH(i) {
      km_pair x = ((km_pair *)column)[i] - l[i] * (km_pair){u, u};
      ((km_pair *)column)[i] = x;
      note(s, k, i, x);
    }
  }
  for (; k < columns; ++k) {
    double *column = reduced + (size_t)(order[k] * stride), u = column[row];
    EACH(i)((km_pair *)column)[i] -= l[i] * (km_pair){u, u};
  }
  return take_best(s, stride);
}

INLINE double size_of(const km_partition *p, int64_t key, const int stride) {
  return km_key_valid(key) ? fabs(p->reduced[p->column[km_key_slot(key)] * stride + km_key_row(key)]) : 0.0;
}

INLINE void factor(km_partition *p, const double *matrix, int candidates, double tolerance, const int stride) {
  search s;
  int64_t key = load(p, matrix, &s, candidates, stride);
  double threshold = tolerance * p->scale;
  int most = p->rows < p->columns ? p->rows : p->columns, step = 0;
  for (; step < most; ++step) {
    double size = size_of(p, key, stride);
    if (!(size > threshold) && candidates < p->columns) {
      key = look(p, &s, candidates, stride);
      size = size_of(p, key, stride);
      candidates = p->columns;
      p->forced_dependent = size > threshold;
    }
    if (!(size > threshold)) {
      p->first_dropped = size > 0.0 ? size : 0.0;
      break;
    }
    int slot = km_key_slot(key), column = p->column[slot];
    p->column[slot] = p->column[step];
    p->column[step] = column;
    key = eliminate(p, &s, step, km_key_row(key), candidates, stride);
    p->first_pivot = step == 0 ? size : p->first_pivot;
    p->last_pivot = size;
  }
  p->rank = step;
}

INLINE bool refactor(km_partition *p, const double *matrix, const int stride) {
  km_pair poison = {0.0, 0.0}; /* x − x: 0, or not a number */
  for (int k = 0; k < p->columns; ++k) {
    km_pair *to = (km_pair *)(p->reduced + (size_t)(k * stride));
    EACH(i) {
      km_pair x = read(matrix + (size_t)(k * p->rows), p->rows, i, stride);
      to[i] = x;
      poison += x - x;
    }
  }
  for (int step = 0; step < p->rank; ++step) {
    km_pair l[PAIRS];
    km_bits others[PAIRS];
    int row = p->row[step];
    multiples(p, step, row, l, others, stride);
    for (int k = step + 1; k < p->columns; ++k) {
      double *column = p->reduced + (size_t)(p->column[k] * stride), u = column[row];
      EACH(i)((km_pair *)column)[i] -= l[i] * (km_pair){u, u};
    }
  }
  return poison[0] + poison[1] == 0.0;
}

void km_small_factor(km_partition *p, const double *matrix, int candidates, double tolerance) {
  switch (p->stride) {
  case 2: factor(p, matrix, candidates, tolerance, 2); break;
  case 4: factor(p, matrix, candidates, tolerance, 4); break;
  case 6: factor(p, matrix, candidates, tolerance, 6); break;
  case 8: factor(p, matrix, candidates, tolerance, 8); break;
  case 10: factor(p, matrix, candidates, tolerance, 10); break;
  default: factor(p, matrix, candidates, tolerance, 12); break;
  }
}

bool km_small_refactor(km_partition *p, const double *matrix) {
  switch (p->stride) {
  case 2: return refactor(p, matrix, 2);
  case 4: return refactor(p, matrix, 4);
  case 6: return refactor(p, matrix, 6);
  case 8: return refactor(p, matrix, 8);
  case 10: return refactor(p, matrix, 10);
  default: return refactor(p, matrix, 12);
  }
}
