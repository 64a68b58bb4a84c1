/* Random matrices of a known rank with their partition, and the laws that every partition keeps: LAPACK's singular
 * value decomposition judges rank and null space. */
#ifndef KM_TESTS_MATRICES_H
#define KM_TESTS_MATRICES_H

#include "linalg/sparse/sparse_lu.h"
#include "support/support.h"

enum { MOST = 80, SMALL = 14 };

/* The matrix at hand. */
typedef struct problem {
  km_arena arena;
  km_factor *p, *q;
  km_factor_options options; /* options of factor() */
  int rows, columns, rank;
  double J[MOST * MOST], D[MOST]; /* D: column weights */
  double Z[MOST * MOST], numbers[MOST], svd_numbers[MOST];
  int svd_rank;
  bool forced[MOST];
} problem;
extern problem f;
extern bool sparse; /* factored by the sparse engine */

double any(void); /* -1 … 1 */
int index_below(int count);
int least(int a, int b);
double largest_entry(void);

/* A random rows × columns matrix of the given rank, some of its entries 0. */
void fill(int rows, int columns, int rank);
/* J (I + E) for a random E of that size: the rank stays. */
void perturb(double size);
void run_svd(void);
/* Space for both partitions, of matrices in which every entry may be something else than 0. */
void reserve(void);
void reserve_one(km_factor **p, int rows, int columns);
/* The matrix as the partition's engine takes it: whole, or the values of its pattern. */
const double *stored(const km_factor *p);
void factor(km_factor *p);

/* Rank, order, B, pivots, directions, null space, row space, solution; after run_svd. */
void check_all(km_factor *p, double tolerance);
void check_pivots(km_factor *p);
void check_directions(km_factor *p);
void check_null(km_factor *p, double tolerance);
void check_solution(km_factor *p);
void check_permutation(const int *list, int count);
/* First and last pivot are those of complete pivoting, in which no entry grows by more than a factor of 2 a step; the
 * sparse engine's are its largest and its smallest. */
void check_evidence(km_factor *p);

#endif
