/* Data of a factorisation. Private to linalg/. */
#ifndef KM_LINALG_FACTOR_PRIVATE_H
#define KM_LINALG_FACTOR_PRIVATE_H

#include "linalg/factor.h"

#include <math.h>

typedef struct km_sparse km_sparse;

struct km_factor {
  int rows, columns; /* shape of the matrix, */
  int rank;
  int *row;          /* [rows] row[0 … rank-1] are the primary constraints, in pivot order */
  int *column;       /* [columns] first the dependent coordinates in pivot order, then the independent ones */
  int stride;        /* leading dimension of `reduced`: rows, rounded up to even */
  km_sparse *sparse; /* sparse factor; NULL: dense, by `reduced` and `pivot_guess` */
  double *reduced;   /* [columns × stride] rows and columns in the matrix's order. Dependent column i: the multiples of
                      * row[i] that step i subtracted from the others, 0 for itself. Independent: B before `inverse` */
  double *inverse;   /* [rank] reciprocals of the pivots */
  double *B;         /* [freedom × rank, leading dimension `rank`], of the dense engine */
  int *pivot_guess;  /* [rank] position of each pivot at the last search: guess for the next search */
  double *work;      /* [stride] */
  double scale, first_pivot, last_pivot, first_dropped, smallest_pivot, max_b,
      max_b_at_search;       /* as in km_factor_evidence */
  int sign;                  /* product of the signs of the pivots */
  unsigned search_count;     /* number of searches for pivots */
  unsigned version;          /* number of changes */
  bool forced_dependent;     /* a forced column had to be a pivot */
  bool failed;               /* out of memory: the rank is meaningless, the freedom counts as 0 */
  const double *weight;      /* [columns] D, borrowed */
  km_factor_options options; /* options of the last search; of `forced` only whether there are any is valid */
  int locked_count;          /* locked columns at the last search */

  int most_rows, most_columns; /* largest shape */

  /* Matrix of the last search and its arguments, while is_cached. */
  double *cached_matrix;
  bool *cached_forced, *cached_locked; /* [columns] */
  bool is_cached;

  /* Basis of the null space or the row space. It grows with the freedom. */
  km_arena *arena;
  double *Z, *projection /* [columns] */;
  size_t Z_capacity;
  int Z_count;        /* vectors in Z; 0 while Z holds row-space vectors */
  unsigned Z_version; /* `version` from which Z was formed */
};

/* Allocates the arrays of all back ends. NULL when out of memory. */
km_factor *km_factor_allocate(int rows, int columns, int entries, const double *weight, km_arena *arena);

/* Largest reciprocal of a pivot. */
static inline double km_factor_largest_inverse(const km_factor *p) {
  double largest = 0.0;
  for (int i = 0; i < p->rank; ++i) {
    double size = fabs(p->inverse[i]);
    largest = size > largest ? size : largest;
  }
  return largest;
}
/* Computes the vectors first … count-1 of Z, which contains those before them. */
void km_factor_extend_null_space(const km_factor *factor, int first, int count, double *Z);
/* Writes R[rank × columns] over the dependent and the first `count` independent columns. */
void km_factor_write_row_space(const km_factor *factor, int count, double *R);

/* Sparse minimum-norm solutions by row equations. False without SuiteSparse or memory. */
bool km_sparse_minimum_norm(const km_factor *factor, const double *matrix, int count, const double *rhs, double *x);
bool km_sparse_remove_null_space(const km_factor *factor, const double *matrix, int count, double *x, double *work);

static inline bool km_factor_is_locked(const km_factor *p, int c) {
  return p->options.locked && p->options.locked[c];
}

#endif
